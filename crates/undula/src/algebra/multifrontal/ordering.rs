//! Nested dissection of the mesh nodes.

use super::graph::Graph;
use super::separator::{MIDDLE, separate};

/// Parts of at most this many vertices are ordered by minimum degree.
const LEAF: usize = 60;

/// Order of elimination of the vertices: parts first, what separates them after, recursively.
pub(super) fn nested_dissection(graph: &Graph) -> Vec<u32> {
    let mut order = vec![0; graph.n()];
    let mut local = vec![u32::MAX; graph.n()];
    let mut parts = vec![((0..graph.n() as u32).collect::<Vec<u32>>(), graph.n())];
    // A part of vertices fills the places of the order up to its end.
    while let Some((part, end)) = parts.pop() {
        let place = end - part.len();
        if part.len() <= LEAF {
            order[place..end].copy_from_slice(&minimum_degree(graph, &part, &mut local));
            continue;
        }
        let side = separate(&subgraph(graph, &part, &mut local));
        let of = |s: u8| -> Vec<u32> {
            part.iter().zip(&side).filter(|(_, t)| **t == s).map(|(v, _)| *v).collect()
        };
        let (below, above, middle) = (of(0), of(1), of(MIDDLE));
        if below.is_empty() && above.is_empty() {
            // Everybody is everybody's neighbour.
            order[place..end].copy_from_slice(&middle);
            continue;
        }
        let start = end - middle.len();
        order[start..end].copy_from_slice(&middle);
        let between = start - above.len();
        parts.push((above, start));
        parts.push((below, between));
    }
    order
}

/// The graph between the vertices of a part; `local` is scratch and left as found.
fn subgraph(graph: &Graph, part: &[u32], local: &mut [u32]) -> Graph {
    for (k, &v) in part.iter().enumerate() {
        local[v as usize] = k as u32;
    }
    let mut sub = Graph { ptr: vec![0], ..Graph::default() };
    for &v in part {
        let inside = graph.neighbours(v as usize).iter().map(|&w| local[w as usize]);
        sub.adj.extend(inside.filter(|&k| k != u32::MAX));
        sub.ptr.push(sub.adj.len());
        sub.weight.push(graph.weight[v as usize]);
        sub.at.push(graph.at[v as usize]);
    }
    for &v in part {
        local[v as usize] = u32::MAX;
    }
    sub
}

/// Orders a small part by minimum degree, counting the neighbours outside, which stay.
fn minimum_degree(graph: &Graph, part: &[u32], local: &mut [u32]) -> Vec<u32> {
    let mut all = part.to_vec();
    for (k, &v) in part.iter().enumerate() {
        local[v as usize] = k as u32;
    }
    for &v in part {
        for &w in graph.neighbours(v as usize) {
            if local[w as usize] == u32::MAX {
                local[w as usize] = all.len() as u32;
                all.push(w);
            }
        }
    }
    let words = all.len().div_ceil(64);
    let weight: Vec<u32> = all.iter().map(|&v| graph.weight[v as usize]).collect();
    // Row k: the neighbours of vertex k as bits.
    let mut bits = vec![0_u64; part.len() * words];
    for (k, &v) in part.iter().enumerate() {
        for &w in graph.neighbours(v as usize) {
            let l = local[w as usize] as usize;
            bits[k * words + l / 64] |= 1 << (l % 64);
        }
    }
    for &v in &all {
        local[v as usize] = u32::MAX;
    }
    eliminate(part.len(), words, &weight, &mut bits).into_iter().map(|k| part[k]).collect()
}

/// Minimum degree on bit rows: eliminates the vertex with the lightest neighbourhood and joins its
/// neighbours, until none is left.
fn eliminate(n: usize, words: usize, weight: &[u32], bits: &mut [u64]) -> Vec<usize> {
    let degree = |bits: &[u64]| -> u32 {
        let in_word = |(i, &word): (usize, &u64)| {
            let (mut word, mut sum) = (word, 0);
            while word != 0 {
                sum += weight[64 * i + word.trailing_zeros() as usize];
                word &= word - 1;
            }
            sum
        };
        bits.iter().enumerate().map(in_word).sum()
    };
    let mut degrees: Vec<u32> = bits.chunks(words.max(1)).map(degree).collect();
    let mut left: Vec<usize> = (0..n).collect();
    let mut order = Vec::with_capacity(n);
    while !left.is_empty() {
        let Some(at) = (0..left.len()).min_by_key(|&a| (degrees[left[a]], left[a])) else { break };
        let v = left.swap_remove(at);
        let row = bits[v * words..(v + 1) * words].to_vec();
        for &w in &left {
            if row[w / 64] >> (w % 64) & 1 == 1 {
                let joined = &mut bits[w * words..(w + 1) * words];
                for (a, b) in joined.iter_mut().zip(&row) {
                    *a |= b;
                }
                joined[v / 64] &= !(1 << (v % 64));
                joined[w / 64] &= !(1 << (w % 64));
                degrees[w] = degree(joined);
            }
        }
        order.push(v);
    }
    order
}
