//! Pressures of cells, which have no pivots of their own, in the order of elimination.
//!
//! A constant pressure on a patch of cells does no work on velocities inside. So when these have been eliminated,
//! all pressures of the patch but one have pivots, and this one must wait. It does so until a velocity
//! between the patch and another one is eliminated, which leaves one pressure of both: patches grow
//! together along the order of elimination, like trees in Kruskal's algorithm. The front of that velocity has
//! all that these pressures are coupled to, and they add no row to it but themselves.

use super::super::graph::{Graph, Role};

/// Order of elimination of all vertices, given that of the free ones.
pub(super) fn with_pressures(graph: &Graph, order: &[u32]) -> Vec<u32> {
    let cells = |v: u32| {
        graph.neighbours(v as usize).iter().copied().filter(|&p| graph.role[p as usize] == Role::Mean)
    };
    let n_cells: Vec<usize> = (0..graph.n() as u32).map(|v| cells(v).count()).collect();
    let nodes = |p: u32| {
        graph.neighbours(p as usize).iter().copied().filter(|&v| graph.role[v as usize] == Role::Free)
    };
    // Velocities that couple as few cells as any of theirs: on faces where there are such.
    let least = |p: u32| nodes(p).map(|v| n_cells[v as usize]).filter(|&n| n > 1).min().unwrap_or(0);
    let is_between = |v: u32| n_cells[v as usize] > 1 && cells(v).any(|p| n_cells[v as usize] <= least(p));
    // Inner velocities, if there are any.
    let innermost = |p: u32| nodes(p).map(|v| n_cells[v as usize]).min().unwrap_or(0);

    let mut out = Vec::with_capacity(graph.n());
    let mut placed = vec![false; graph.n()];
    let mut patch = Patches { parent: (0..graph.n() as u32).collect() };
    for &v in order {
        out.push(v);
        for &p in graph.neighbours(v as usize) {
            let is_detail = graph.role[p as usize] == Role::Detail && !placed[p as usize];
            if is_detail && n_cells[v as usize] == innermost(p) {
                placed[p as usize] = true;
                out.push(p);
            }
        }
        if !is_between(v) {
            continue;
        }
        let mut first = None;
        let mut pivots = graph.weight[v as usize];
        for p in cells(v) {
            let this = patch.of(p);
            let Some(other) = first.filter(|_| pivots > 0) else {
                first = Some(this);
                continue;
            };
            if this != other {
                let (stays, goes) = (this.min(other), this.max(other));
                patch.parent[goes as usize] = stays;
                placed[goes as usize] = true;
                out.push(goes);
                first = Some(stays);
                pivots -= 1;
            }
        }
    }
    // One of each fluid domain, and whatever has no velocities.
    out.extend(
        (0..graph.n() as u32).filter(|&p| graph.role[p as usize] != Role::Free && !placed[p as usize]),
    );
    out
}

/// Disjoint sets of cells, named by the one whose pressure is left.
struct Patches {
    parent: Vec<u32>,
}

impl Patches {
    fn of(&mut self, mut p: u32) -> u32 {
        while self.parent[p as usize] != p {
            let up = self.parent[p as usize];
            self.parent[p as usize] = self.parent[up as usize];
            p = up;
        }
        p
    }
}
