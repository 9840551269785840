//! Approximate minimum degree (Amestoy, Davis and Duff 1996) for weighted vertices in two stages.
//!
//! The quotient graph: an eliminated vertex becomes an element, whose boundary are those that it has made
//! neighbours; elements within another one's boundary are absorbed by it.

use super::super::graph::Graph;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Order of elimination: of the vertices that are left, next is the one with the least weight of neighbours,
/// estimated from above; those marked as late come after all others.
pub(super) fn minimum_degree(graph: &Graph, late: &[bool]) -> Vec<u32> {
    let mut quotient = Quotient::new(graph, late);
    while let Some(Reverse((_, degree, v))) = quotient.offers.pop() {
        if quotient.weight[v as usize] > 0 && quotient.degree[v as usize] == degree {
            quotient.eliminate(v as usize);
        }
    }
    quotient.order
}

struct Quotient<'a> {
    late: &'a [bool],
    /// Weight of each vertex and those joined to it; 0 once it is eliminated or joined to another.
    weight: Vec<u32>,
    /// Neighbours of each vertex that share no element with it.
    neighbours: Vec<Vec<u32>>,
    /// Elements of each vertex.
    elements: Vec<Vec<u32>>,
    /// Vertices around each element; none if it has been absorbed.
    boundary: Vec<Vec<u32>>,
    /// Weight of the boundary.
    size: Vec<u32>,
    /// Bound of the weight of the neighbours of each vertex.
    degree: Vec<u32>,
    /// Vertices that are eliminated with each.
    joined: Vec<Vec<u32>>,
    /// Last element in whose boundary each vertex was.
    seen: Vec<u32>,
    /// Weight of the boundary of each element outside the newest one, and which that was.
    outside: Vec<(u32, u32)>,
    /// Weight not yet eliminated.
    left: u32,
    offers: BinaryHeap<Reverse<(bool, u32, u32)>>,
    order: Vec<u32>,
}

impl<'a> Quotient<'a> {
    fn new(graph: &Graph, late: &'a [bool]) -> Self {
        let n = graph.n();
        let neighbours: Vec<Vec<u32>> = (0..n).map(|v| graph.neighbours(v).to_vec()).collect();
        let weight_of = |list: &Vec<u32>| list.iter().map(|&w| graph.weight[w as usize]).sum();
        let degree: Vec<u32> = neighbours.iter().map(weight_of).collect();
        Self {
            late,
            weight: graph.weight.clone(),
            neighbours,
            elements: vec![vec![]; n],
            boundary: vec![vec![]; n],
            size: vec![0; n],
            offers: (0..n).map(|v| Reverse((late[v], degree[v], v as u32))).collect(),
            degree,
            joined: vec![vec![]; n],
            seen: vec![u32::MAX; n],
            outside: vec![(u32::MAX, 0); n],
            left: graph.weight.iter().sum(),
            order: Vec::with_capacity(n),
        }
    }

    fn eliminate(&mut self, p: usize) {
        let mut boundary = self.find_boundary(p);
        self.take(p);
        self.measure_outside(p, &boundary);
        let mut size: u32 = boundary.iter().map(|&v| self.weight[v as usize]).sum();
        let mut alike = Vec::with_capacity(boundary.len());
        for &v in &boundary {
            let v = v as usize;
            self.update(v, p, size);
            if self.elements[v].len() == 1 && self.neighbours[v].is_empty() && self.late[v] == self.late[p] {
                // Its neighbours are those of p: it adds nothing if it goes now.
                size -= self.weight[v];
                self.take(v);
            } else {
                alike.push((self.signature(v), v as u32));
            }
        }
        self.join(alike);
        boundary.retain(|&v| self.weight[v as usize] > 0);
        for &v in &boundary {
            self.offers.push(Reverse((self.late[v as usize], self.degree[v as usize], v)));
        }
        self.boundary[p] = boundary;
        self.size[p] = size;
    }

    /// Writes a vertex and those joined to it into the order.
    fn take(&mut self, v: usize) {
        self.left -= self.weight[v];
        self.weight[v] = 0;
        self.order.push(v as u32);
        let mut next = self.order.len() - 1;
        while let Some(&v) = self.order.get(next) {
            self.order.append(&mut self.joined[v as usize]);
            next += 1;
        }
    }

    /// Everybody around the new element p, which absorbs the elements of p.
    fn find_boundary(&mut self, p: usize) -> Vec<u32> {
        let mut boundary = Vec::new();
        self.seen[p] = p as u32;
        let absorbed: Vec<u32> = std::mem::take(&mut self.elements[p]);
        let neighbours = std::mem::take(&mut self.neighbours[p]);
        let elements = absorbed.into_iter().map(|e| std::mem::take(&mut self.boundary[e as usize]));
        for list in std::iter::once(neighbours).chain(elements) {
            for v in list {
                if self.weight[v as usize] > 0 && self.seen[v as usize] != p as u32 {
                    self.seen[v as usize] = p as u32;
                    boundary.push(v);
                }
            }
        }
        boundary
    }

    /// For each element that touches the boundary of p: the weight of its own outside of it.
    fn measure_outside(&mut self, p: usize, boundary: &[u32]) {
        for &v in boundary {
            for &e in &self.elements[v as usize] {
                let e = e as usize;
                if self.boundary[e].is_empty() {
                    continue;
                }
                if self.outside[e].0 != p as u32 {
                    self.outside[e] = (p as u32, self.size[e]);
                }
                self.outside[e].1 -= self.weight[v as usize];
            }
        }
    }

    /// Neighbours, elements and degree of a vertex in the boundary of p.
    fn update(&mut self, v: usize, p: usize, size: u32) {
        let Self { boundary, outside, seen, weight, .. } = self;
        let elements = &mut self.elements[v];
        elements.retain(|&e| !boundary[e as usize].is_empty() && outside[e as usize].1 > 0);
        let beyond: u32 = elements.iter().map(|&e| outside[e as usize].1).sum();
        elements.push(p as u32);
        let neighbours = &mut self.neighbours[v];
        neighbours.retain(|&w| weight[w as usize] > 0 && seen[w as usize] != p as u32);
        let direct: u32 = neighbours.iter().map(|&w| weight[w as usize]).sum();
        let inside = size - weight[v];
        self.degree[v] = (self.degree[v] + inside).min(direct + inside + beyond).min(self.left - weight[v]);
    }

    /// Equal for vertices with equal neighbours and elements.
    fn signature(&self, v: usize) -> u64 {
        let all = self.elements[v].iter().chain(&self.neighbours[v]);
        all.fold(0, |sum: u64, &i| sum.wrapping_add((u64::from(i) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15)))
    }

    /// Joins vertices that have the same neighbours and elements, and the same stage.
    fn join(&mut self, mut alike: Vec<(u64, u32)>) {
        alike.sort_unstable();
        for same in alike.chunk_by(|a, b| a.0 == b.0) {
            for (i, &(_, v)) in same.iter().enumerate() {
                for &(_, w) in &same[i + 1..] {
                    let (v, w) = (v as usize, w as usize);
                    if self.weight[v] > 0 && self.weight[w] > 0 && self.are_alike(v, w) {
                        self.degree[v] -= self.weight[w].min(self.degree[v]);
                        self.weight[v] += std::mem::take(&mut self.weight[w]);
                        self.joined[v].push(w as u32);
                        (self.elements[w], self.neighbours[w]) = (vec![], vec![]);
                    }
                }
            }
        }
    }

    fn are_alike(&self, v: usize, w: usize) -> bool {
        let sorted = |list: &[u32]| {
            let mut list = list.to_vec();
            list.sort_unstable();
            list
        };
        let equal = |a: &[u32], b: &[u32]| a.len() == b.len() && sorted(a) == sorted(b);
        self.late[v] == self.late[w]
            && equal(&self.elements[v], &self.elements[w])
            && equal(&self.neighbours[v], &self.neighbours[w])
    }
}
