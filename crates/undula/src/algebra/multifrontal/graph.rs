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
    /// When a vertex can be eliminated.
    pub role: Vec<Role>,
}

/// When a vertex can be eliminated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Role {
    /// Any time.
    Free,
    /// A constant pressure on a cell: after velocities of its boundary.
    Mean,
    /// The other pressures of a cell: after velocities inside, if there are any.
    Detail,
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

    /// Weight of all vertices.
    pub fn total(&self) -> u64 {
        self.weight.iter().map(|&w| u64::from(w)).sum()
    }

    /// The graph of some vertices, increasing; neighbours are those that are written for each (in any order,
    /// and with repetitions) and belong to them.
    pub fn restricted_to(&self, vertices: &[u32], neighbours: impl Fn(u32, &mut Vec<u32>)) -> Self {
        let mut number = vec![u32::MAX; self.n()];
        for (k, &v) in vertices.iter().enumerate() {
            number[v as usize] = k as u32;
        }
        let mut sub = Self { ptr: vec![0], ..Self::default() };
        let mut around = Vec::new();
        for &v in vertices {
            around.clear();
            neighbours(v, &mut around);
            around.sort_unstable();
            around.dedup();
            let inside = around.iter().filter(|&&w| w != v).map(|&w| number[w as usize]);
            sub.adj.extend(inside.filter(|&k| k != u32::MAX));
            sub.ptr.push(sub.adj.len());
            sub.weight.push(self.weight[v as usize]);
            sub.at.push(self.at[v as usize]);
            sub.role.push(self.role[v as usize]);
        }
        sub
    }

    /// The graph of the pattern with the unknowns lumped to vertices.
    fn of(pattern: &Pattern, members: &Members, unknowns: &[Unknown], role: Vec<Role>) -> Self {
        let n = members.n();
        let mut edges = vec![Vec::new(); n];
        let mut seen = vec![usize::MAX; n];
        for v in 0..n {
            seen[v] = v;
            for &i in members.of(v) {
                for &j in pattern.columns(i as usize) {
                    let w = members.vertex[j as usize] as usize;
                    if seen[w] != v {
                        seen[w] = v;
                        edges[v].push(w as u32);
                        edges[w].push(v as u32);
                    }
                }
            }
        }
        let mut graph = Self { ptr: vec![0], role, ..Self::default() };
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

/// Lumps unknowns by mesh node. Nodes with nothing but pressures are cells; the first of their pressures is constant
/// and stands alone.
pub(super) fn lump(pattern: &Pattern, unknowns: &[Unknown]) -> (Graph, Members) {
    let n_nodes = unknowns.iter().map(|u| u.node as usize + 1).max().unwrap_or(0);
    let mut is_cell = vec![true; n_nodes];
    for unknown in unknowns.iter().filter(|u| u.kind != Kind::Pressure) {
        is_cell[unknown.node as usize] = false;
    }
    let mut seen = vec![false; n_nodes];
    let key =
        |u: &Unknown| match (is_cell[u.node as usize], std::mem::replace(&mut seen[u.node as usize], true)) {
            (false, _) => (u.node, Role::Free),
            (true, false) => (u.node, Role::Mean),
            (true, true) => (u.node, Role::Detail),
        };
    let keys: Vec<(u32, Role)> = unknowns.iter().map(key).collect();
    let mut vertices = keys.clone();
    vertices.sort_unstable();
    vertices.dedup();
    let vertex = keys.iter().map(|key| vertices.partition_point(|k| k < key) as u32).collect();
    let members = Members::new(vertex, vertices.len(), unknowns);
    let role = vertices.into_iter().map(|(_, role)| role).collect();
    (Graph::of(pattern, &members, unknowns, role), members)
}
