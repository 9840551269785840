//! Coarse graphs: pairs of neighbours become one vertex.

use super::super::graph::{Graph, Role};

/// A graph in which pairs of neighbours of a finer one are joined.
pub(super) struct Coarse {
    /// The coarse graph.
    pub graph: Graph,
    /// Number of edges of the finest graph in each of its edges.
    pub edges: Vec<u32>,
    /// Vertex of the coarse graph for each of the finer one.
    pub parent: Vec<u32>,
}

impl Coarse {
    /// Joins every vertex, in an order that depends on the seed, to the free neighbour with most edges
    /// between them and the least weight, if together they do not weigh more than allowed. `edges`: number
    /// of edges of the finest graph in each edge, none if this is the finest.
    pub fn of(fine: &Graph, edges: Option<&[u32]>, heaviest: u64, seed: u32) -> Self {
        let n = fine.n();
        let count = |at: usize| edges.map_or(1, |edges| edges[at]);
        let mut mate = vec![u32::MAX; n];
        let mut order: Vec<u32> = (0..n as u32).collect();
        order.sort_by_key(|&v| (scattered(v, seed), v));
        for v in order {
            let v = v as usize;
            if mate[v] != u32::MAX {
                continue;
            }
            let fits = |w: usize| u64::from(fine.weight[v]) + u64::from(fine.weight[w]) <= heaviest;
            let free = (fine.ptr[v]..fine.ptr[v + 1])
                .filter(|&at| mate[fine.adj[at] as usize] == u32::MAX && fits(fine.adj[at] as usize));
            let lightness = |at: usize| std::cmp::Reverse(fine.weight[fine.adj[at] as usize]);
            let best = free.max_by_key(|&at| (count(at), lightness(at), std::cmp::Reverse(at)));
            let w = best.map_or(v, |at| fine.adj[at] as usize);
            mate[v] = w as u32;
            mate[w] = v as u32;
        }
        let mut parent = vec![u32::MAX; n];
        let mut pairs = Vec::with_capacity(n / 2);
        for v in 0..n {
            if parent[v] == u32::MAX {
                parent[v] = pairs.len() as u32;
                parent[mate[v] as usize] = pairs.len() as u32;
                pairs.push((v, mate[v] as usize));
            }
        }
        Self::join(fine, count, &pairs, parent)
    }

    fn join(fine: &Graph, count: impl Fn(usize) -> u32, pairs: &[(usize, usize)], parent: Vec<u32>) -> Self {
        let mut graph = Graph { ptr: vec![0], role: vec![Role::Free; pairs.len()], ..Graph::default() };
        let mut edges = Vec::new();
        let mut place = vec![usize::MAX; pairs.len()];
        for (k, &(v, w)) in pairs.iter().enumerate() {
            let start = graph.adj.len();
            let pair = [v, w];
            let pair = if v == w { &pair[..1] } else { &pair };
            for at in pair.iter().flat_map(|&v| fine.ptr[v]..fine.ptr[v + 1]) {
                let to = parent[fine.adj[at] as usize];
                if to as usize == k {
                    continue;
                }
                let place = &mut place[to as usize];
                if *place == usize::MAX {
                    *place = graph.adj.len();
                    graph.adj.push(to);
                    edges.push(0);
                }
                edges[*place] += count(at);
            }
            graph.adj[start..].iter().for_each(|&to| place[to as usize] = usize::MAX);
            graph.ptr.push(graph.adj.len());
            let weight: u32 = pair.iter().map(|&v| fine.weight[v]).sum();
            let share = |v: usize| f64::from(fine.weight[v]) / f64::from(weight.max(1));
            graph.at.push([0, 1, 2].map(|i| pair.iter().map(|&v| share(v) * fine.at[v][i]).sum()));
            graph.weight.push(weight);
        }
        Self { graph, edges, parent }
    }
}

/// A number that looks like chance (the last steps of MurmurHash3).
fn scattered(v: u32, seed: u32) -> u32 {
    let mut x = v ^ seed.wrapping_mul(0x9E37_79B9);
    x = (x ^ (x >> 16)).wrapping_mul(0x85EB_CA6B);
    x = (x ^ (x >> 13)).wrapping_mul(0xC2B2_AE35);
    x ^ (x >> 16)
}
