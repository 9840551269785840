//! The graph that is dissected: one weighted vertex per mesh node.

use super::super::{Kind, Pattern, Unknown};

/// Undirected graph; a vertex stands for all unknowns of a mesh node.
#[derive(Debug, Default)]
pub(super) struct Graph {
    /// Vertex `v` has its neighbours at `ptr[v]..ptr[v + 1]` of `adj`.
    pub ptr: Vec<usize>,
    /// Neighbours, increasing, without the vertex itself.
    pub adj: Vec<u32>,
    /// Number of unknowns.
    pub weight: Vec<u32>,
    /// Position, m.
    pub at: Vec<[f64; 3]>,
}

impl Graph {
    /// Number of vertices.
    pub fn n(&self) -> usize {
        self.weight.len()
    }

    /// Neighbours of a vertex.
    pub fn neighbours(&self, v: usize) -> &[u32] {
        &self.adj[self.ptr[v]..self.ptr[v + 1]]
    }

    /// The graph of the pattern with the unknowns lumped to vertices.
    fn of(pattern: &Pattern, members: &Members, unknowns: &[Unknown]) -> Self {
        let n = members.n();
        let mut edges = vec![Vec::new(); n];
        let mut seen = vec![usize::MAX; n];
        for v in 0..n {
            seen[v] = v;
            for &i in members.of(v) {
                for &j in &pattern.col[pattern.row(i as usize)] {
                    let w = members.vertex[j as usize] as usize;
                    if seen[w] != v {
                        seen[w] = v;
                        edges[v].push(w as u32);
                        edges[w].push(v as u32);
                    }
                }
            }
        }
        let mut graph = Self { ptr: vec![0], ..Self::default() };
        for (v, list) in edges.iter_mut().enumerate() {
            list.sort_unstable();
            list.dedup();
            graph.adj.extend_from_slice(list);
            graph.ptr.push(graph.adj.len());
            graph.weight.push(members.of(v).len() as u32);
            graph.at.push(unknowns[members.of(v)[0] as usize].at);
        }
        graph
    }
}

/// Which unknowns belong to which vertex.
#[derive(Debug, Default)]
pub(super) struct Members {
    /// Vertex of each unknown.
    pub vertex: Vec<u32>,
    ptr: Vec<usize>,
    list: Vec<u32>,
}

impl Members {
    fn n(&self) -> usize {
        self.ptr.len() - 1
    }

    /// Unknowns of a vertex: first those with a diagonal, pressures last.
    pub fn of(&self, v: usize) -> &[u32] {
        &self.list[self.ptr[v]..self.ptr[v + 1]]
    }

    /// Groups unknowns by vertex.
    fn new(vertex: Vec<u32>, n: usize, unknowns: &[Unknown]) -> Self {
        let mut ptr = vec![0; n + 1];
        for &v in &vertex {
            ptr[v as usize + 1] += 1;
        }
        for v in 0..n {
            ptr[v + 1] += ptr[v];
        }
        let mut list: Vec<u32> = (0..vertex.len() as u32).collect();
        list.sort_by_key(|&i| (vertex[i as usize], unknowns[i as usize].kind == Kind::Pressure, i));
        Self { vertex, ptr, list }
    }
}

/// Lumps unknowns by mesh node. Nodes with nothing but pressures (the cells of a discontinuous
/// pressure) have no pivots of their own: they join the neighbour with the fewest neighbours, in
/// Q2 the middle node of their cell.
pub(super) fn lump(pattern: &Pattern, unknowns: &[Unknown]) -> (Graph, Members) {
    let mut nodes: Vec<u32> = unknowns.iter().map(|u| u.node).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let vertex = unknowns.iter().map(|u| nodes.partition_point(|&k| k < u.node) as u32).collect();
    let members = Members::new(vertex, nodes.len(), unknowns);
    let graph = Graph::of(pattern, &members, unknowns);
    let only_pressure = |v: usize| members.of(v).iter().all(|&i| unknowns[i as usize].kind == Kind::Pressure);
    let degree = |v: usize| graph.ptr[v + 1] - graph.ptr[v];
    let host = |v: usize| {
        let others = graph.neighbours(v).iter().map(|&w| w as usize).filter(|&w| !only_pressure(w));
        others.min_by_key(|&w| (degree(w), w)).filter(|_| only_pressure(v))
    };
    let hosts: Vec<Option<usize>> = (0..graph.n()).map(host).collect();
    if hosts.iter().all(Option::is_none) {
        return (graph, members);
    }
    let mut number = vec![0; graph.n()];
    let mut n = 0;
    for v in 0..graph.n() {
        if hosts[v].is_none() {
            number[v] = n;
            n += 1;
        }
    }
    let vertex = members.vertex.iter().map(|&v| number[hosts[v as usize].unwrap_or(v as usize)]).collect();
    let members = Members::new(vertex, n as usize, unknowns);
    (Graph::of(pattern, &members, unknowns), members)
}
