//! The part of a space that one process has, where several share it: its own cells, and a layer of those of others around
//! them, so that the rows of its own unknowns are complete.
//!
//! A node belongs to the lowest process that has a cell at it, a discontinuous pressure to that of its cell. Unknowns of
//! others are copies. What the equations of a row are, and what is given, is that of the whole space.

use super::{Constraints, FsiSpace, State};
use crate::parallel::{Crew, Fault, Halo, Reduce, Shared};
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// What a part knows of the whole space.
pub struct Part<const D: usize> {
    pub(super) crew: Crew,
    /// The owner of each cell, and its number in the whole mesh.
    pub(super) cells: Vec<Shared>,
    /// The same of nodes and of pressures; their numbers are those in the whole space.
    pub(super) nodes: Vec<Shared>,
    pub(super) pressures: Vec<Shared>,
    /// Nodes and pressures of the whole space, and its cells.
    pub(super) all: [usize; 2],
    pub(super) all_cells: usize,
    /// Bytes of the process before there was a mesh.
    pub(super) memory_before: u64,
    /// What is given at the nodes.
    pub(crate) constraints: Constraints<D>,
    pub(super) whole: Mutex<Option<Arc<FsiSpace<D>>>>,
}

impl<const D: usize> fmt::Debug for Part<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Part").field("crew", &self.crew).field("all", &self.all).finish_non_exhaustive()
    }
}

/// What a part needs of others, and what is told of its process.
#[derive(Copy, Clone, Debug)]
pub struct Rim {
    /// Layers of cells around the own ones: those that an equation couples to.
    pub layers: usize,
    /// Whether the children of a refined cell are all there, or none.
    pub families: bool,
    /// Bytes of the process before there was a mesh.
    pub memory_before: u64,
}

impl<const D: usize> Part<D> {
    /// The processes that share the space.
    pub fn crew(&self) -> &Crew {
        &self.crew
    }

    /// Nodes and pressures of the whole space.
    pub fn all(&self) -> [usize; 2] {
        self.all
    }

    /// Bytes of the process before there was a mesh.
    pub fn memory_before(&self) -> u64 {
        self.memory_before
    }

    /// Cells of the whole space.
    pub fn all_cells(&self) -> usize {
        self.all_cells
    }

    /// The whole space, until [`Part::forget`].
    pub fn whole(&self) -> Option<Arc<FsiSpace<D>>> {
        self.whole.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The whole space is needed no longer.
    pub fn forget(&self) {
        *self.whole.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Own nodes with their numbers in the whole space, ascending.
    pub fn own_nodes(&self) -> impl Iterator<Item = (u32, usize)> {
        own(&self.nodes, self.crew.rank())
    }

    /// The same of pressures.
    pub fn own_pressures(&self) -> impl Iterator<Item = (u32, usize)> {
        own(&self.pressures, self.crew.rank())
    }

    /// The number in the whole mesh of a cell here.
    pub fn cell(&self, here: usize) -> usize {
        self.cells[here].id as usize
    }

    /// The number here of a cell of the whole mesh, if it is an own one.
    pub fn own_cell(&self, whole: usize) -> Option<usize> {
        let at = self.cells.binary_search_by_key(&(whole as u64), |shared| shared.id).ok()?;
        (self.cells[at].owner as usize == self.crew.rank()).then_some(at)
    }

    /// The number here of a pressure of the whole space, if it is an own one.
    pub fn own_pressure(&self, whole: u32) -> Option<u32> {
        let at = self.pressures.binary_search_by_key(&u64::from(whole), |shared| shared.id).ok()?;
        (self.pressures[at].owner as usize == self.crew.rank()).then_some(at as u32)
    }
}

fn own(list: &[Shared], rank: usize) -> impl Iterator<Item = (u32, usize)> {
    let all = (0..).zip(list).filter(move |(_, shared)| shared.owner as usize == rank);
    all.map(|(here, shared)| (here, shared.id as usize))
}

/// What a process has of a space that may be shared. Without others all is its own.
impl<const D: usize> FsiSpace<D> {
    /// Does something with the whole space, as long as it is known.
    pub fn with_whole<T>(&self, act: impl FnOnce(&FsiSpace<D>) -> T) -> T {
        match self.part.as_ref().and_then(|part| part.whole()) {
            Some(whole) => act(&whole),
            None => act(self),
        }
    }

    /// The number here of a cell of the whole space, if this process counts it.
    pub fn own_cell(&self, whole: usize) -> Option<usize> {
        self.part.as_ref().map_or(Some(whole), |part| part.own_cell(whole))
    }

    /// The number here of a pressure of the whole space, if it is here, as a copy or not.
    pub fn pressure_here(&self, whole: u32) -> Option<u32> {
        let Some(part) = &self.part else { return Some(whole) };
        part.pressures.binary_search_by_key(&u64::from(whole), |shared| shared.id).ok().map(|at| at as u32)
    }

    /// The number here of a pressure of the whole space, if this process counts it.
    pub fn own_pressure(&self, whole: u32) -> Option<u32> {
        self.part.as_ref().map_or(Some(whole), |part| part.own_pressure(whole))
    }

    /// Whether this process counts a cell in sums.
    pub fn owns_cell(&self, cell: usize) -> bool {
        self.part.as_ref().is_none_or(|part| part.cells[cell].owner as usize == part.crew.rank())
    }

    /// Whether this process counts a node.
    pub fn owns_node(&self, node: usize) -> bool {
        self.part.as_ref().is_none_or(|part| part.nodes[node].owner as usize == part.crew.rank())
    }

    /// Whether this process counts a pressure unknown.
    pub fn owns_pressure(&self, dof: usize) -> bool {
        self.part.as_ref().is_none_or(|part| part.pressures[dof].owner as usize == part.crew.rank())
    }

    /// A number of all processes.
    pub fn over_all(&self, how: Reduce, value: f64) -> f64 {
        self.part.as_ref().map_or(value, |part| part.crew.one(how, value))
    }

    /// Whether it holds on one of them.
    pub fn any(&self, holds: bool) -> bool {
        self.over_all(Reduce::Max, f64::from(u8::from(holds))) > 0.0
    }

    /// Σ over all processes.
    pub fn sum(&self, value: f64) -> f64 {
        self.over_all(Reduce::Sum, value)
    }

    /// Numbers of all processes.
    pub fn reduce(&self, how: Reduce, values: &mut [f64]) {
        if let Some(part) = &self.part {
            part.crew.reduce(how, values);
        }
    }

    /// `r` \[v, u, p\] with 0 in the rows of other processes.
    pub fn own_rows(&self, r: &[f64]) -> Vec<f64> {
        let mut own = r.to_vec();
        let (nodal, p) = own[..self.n_field_unknowns()].split_at_mut(self.n_v() + self.n_u());
        for (node, of_node) in nodal.chunks_exact_mut(D).enumerate() {
            if !self.owns_node(node % self.nodes.len()) {
                of_node.fill(0.0);
            }
        }
        p.iter_mut().enumerate().filter(|(dof, _)| !self.owns_pressure(*dof)).for_each(|(_, p)| *p = 0.0);
        own
    }

    /// The part of this process in a state of the whole space.
    pub fn part_of(&self, state: State) -> State {
        let Some(part) = &self.part else { return state };
        let State { v, u, p, s } = &state;
        State {
            v: self.nodal_part(v),
            u: self.nodal_part(u),
            p: part.pressures.iter().map(|shared| p[shared.id as usize]).collect(),
            s: s.clone(),
        }
    }

    /// The same of a list of D numbers for each node, which may be empty.
    pub fn nodal_part(&self, values: &[f64]) -> Vec<f64> {
        let Some(part) = self.part.as_ref().filter(|_| !values.is_empty()) else { return values.to_vec() };
        let of_node = |shared: &Shared| &values[shared.id as usize * D..][..D];
        part.nodes.iter().flat_map(of_node).copied().collect()
    }

    /// Numbers of the unknowns of v, u and p, given ones counted, of the whole space.
    pub fn n_all(&self) -> [usize; 3] {
        let [nodes, pressures] = self.part.as_ref().map_or([self.nodes.len(), self.n_p()], |part| part.all);
        [nodes * D, if self.deforms { nodes * D } else { 0 }, pressures]
    }

    /// The unknowns at `places` in \[v, u, p\] as a system that processes share; `None` where they do not.
    ///
    /// # Errors
    /// If MPI fails, or if the processes do not have the same unknowns.
    pub fn halo(&self, places: impl Iterator<Item = u32>) -> Option<Result<Halo, Fault>> {
        let part = self.part.as_ref()?;
        let [n_v, n_u, _] = self.n_all();
        let named = places.map(|place| self.named(part, place as usize, [n_v, n_u]));
        Some(Halo::new(&part.crew, &named.collect::<Vec<_>>()))
    }

    /// The process that the unknown at a place in \[v, u, p\] belongs to, and its place in the whole; `None` without others.
    pub fn shared(&self, place: u32) -> Option<Shared> {
        let part = self.part.as_ref()?;
        let [n_v, n_u, _] = self.n_all();
        Some(self.named(part, place as usize, [n_v, n_u]))
    }

    fn named(&self, part: &Part<D>, place: usize, [n_v, n_u]: [usize; 2]) -> Shared {
        let of_node = |entry: usize, first: usize| {
            let Shared { owner, id } = part.nodes[entry / D];
            Shared { owner, id: first as u64 + id * D as u64 + (entry % D) as u64 }
        };
        match place {
            v if v < self.n_v() => of_node(v, 0),
            u if u < self.n_v() + self.n_u() => of_node(u - self.n_v(), n_v),
            p => {
                let Shared { owner, id } = part.pressures[p - self.n_v() - self.n_u()];
                Shared { owner, id: (n_v + n_u) as u64 + id }
            }
        }
    }
}
