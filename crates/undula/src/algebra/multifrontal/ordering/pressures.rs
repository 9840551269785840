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
    let mut placement = Placement::new(graph);
    for &v in order {
        placement.put(v);
        placement.put_details(v);
        placement.join_patches(v);
    }
    // One pressure of each fluid domain, and whatever has no velocities.
    for p in 0..graph.n() as u32 {
        if graph.role[p as usize] != Role::Free && !placement.done[p as usize] {
            placement.put(p);
        }
    }
    placement.order
}

struct Placement<'a> {
    graph: &'a Graph,
    /// Number of cells that each vertex is coupled to.
    n_cells: Vec<usize>,
    /// Disjoint sets of cells: every cell leads to another of its patch, the one whose pressure is left to itself.
    leads_to: Vec<u32>,
    done: Vec<bool>,
    order: Vec<u32>,
}

impl<'a> Placement<'a> {
    fn new(graph: &'a Graph) -> Self {
        let n = graph.n();
        let (order, done) = (Vec::with_capacity(n), vec![false; n]);
        let mut new = Self { graph, n_cells: vec![], leads_to: (0..n as u32).collect(), done, order };
        new.n_cells = (0..n as u32).map(|v| new.around(v, Role::Mean).count()).collect();
        new
    }

    fn put(&mut self, v: u32) {
        self.done[v as usize] = true;
        self.order.push(v);
    }

    fn around(&self, v: u32, role: Role) -> impl Iterator<Item = u32> + use<'a> {
        let graph = self.graph;
        graph.neighbours(v as usize).iter().copied().filter(move |&w| graph.role[w as usize] == role)
    }

    /// Puts details behind v, if v is inside of their cell (or as far inside as any).
    fn put_details(&mut self, v: u32) {
        for p in self.around(v, Role::Detail) {
            let innermost = self.around(p, Role::Free).map(|v| self.n_cells[v as usize]).min();
            if !self.done[p as usize] && Some(self.n_cells[v as usize]) == innermost {
                self.put(p);
            }
        }
    }

    /// Joins the patches on both sides of v and puts the pressures that are too many behind it.
    fn join_patches(&mut self, v: u32) {
        let mut cells = self.around(v, Role::Mean);
        let Some(mut stays) = cells.next().filter(|_| self.is_between(v)).map(|p| self.patch(p)) else {
            return;
        };
        // A velocity in D dimensions has D pivots to give.
        let mut pivots = self.graph.weight[v as usize];
        for p in cells {
            let other = self.patch(p);
            if other == stays || pivots == 0 {
                continue;
            }
            let goes = stays.max(other);
            stays = stays.min(other);
            self.leads_to[goes as usize] = stays;
            self.put(goes);
            pivots -= 1;
        }
    }

    /// Whether v couples as few cells, if more than one, as any velocity of one of them: two, on faces, where
    /// there are such velocities.
    fn is_between(&self, v: u32) -> bool {
        let count = |v: u32| self.n_cells[v as usize];
        let least = |p: u32| self.around(p, Role::Free).map(count).filter(|&n| n > 1).min().unwrap_or(0);
        count(v) > 1 && self.around(v, Role::Mean).any(|p| count(v) <= least(p))
    }

    /// The cell of the patch of p whose pressure is left.
    fn patch(&mut self, mut p: u32) -> u32 {
        while self.leads_to[p as usize] != p {
            let next = self.leads_to[p as usize];
            self.leads_to[p as usize] = self.leads_to[next as usize];
            p = next;
        }
        p
    }
}
