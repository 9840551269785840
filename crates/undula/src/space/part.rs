//! The part of a space that one process has, where several share it: its own cells, and a layer of those of others around
//! them, so that the rows of its own unknowns are complete.
//!
//! A node belongs to the lowest process that has a cell at it, a discontinuous pressure to that of its cell. Unknowns of
//! others are copies. What the equations of a row are, and what is given, is that of the whole space.

use super::{Constraints, FsiSpace, Nodes, PressureKind, PressureSpace, State};
use crate::mesh::Hierarchy;
use crate::parallel::{Crew, Fault, Halo, Reduce, Shared};
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// What a part knows of the whole space.
pub struct Part<const D: usize> {
    crew: Crew,
    /// The owner of each cell, and its number in the whole mesh.
    cells: Vec<Shared>,
    /// The same of nodes and of pressures; their numbers are those in the whole space.
    nodes: Vec<Shared>,
    pressures: Vec<Shared>,
    /// Nodes and pressures of the whole space, and its cells.
    all: [usize; 2],
    all_cells: usize,
    /// Bytes of the process before there was a mesh.
    memory_before: u64,
    /// What is given at the nodes.
    pub(crate) constraints: Constraints<D>,
    whole: Mutex<Option<Arc<FsiSpace<D>>>>,
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

/// Work of a cell of the solid, where that of one of the fluid is 1: it has no pressure, and its deformation follows.
const SOLID: f64 = 0.6;

/// What is left of a list of which some things stay.
struct Kept {
    /// Old numbers of those that stay, ascending.
    old: Vec<u32>,
    /// New numbers by the old ones; `u32::MAX`: it does not stay.
    new: Vec<u32>,
}

impl Kept {
    /// Those of `n` things that `uses` name.
    fn of(n: usize, uses: impl Iterator<Item = u32>) -> Kept {
        let mut new = vec![u32::MAX; n];
        uses.filter(|&old| old != u32::MAX).for_each(|old| new[old as usize] = 0);
        let old: Vec<u32> = (0..n as u32).filter(|&old| new[old as usize] == 0).collect();
        old.iter().zip(0..).for_each(|(&old, number)| new[old as usize] = number);
        Kept { old, new }
    }

    /// `list` of those that stay.
    fn list<T: Copy>(&self, list: &[T]) -> Vec<T> {
        self.old.iter().map(|&old| list[old as usize]).collect()
    }

    /// New numbers of a list of old ones, in which `u32::MAX` stays.
    fn numbers(&self, list: impl Iterator<Item = u32>) -> Vec<u32> {
        list.map(|old| if old == u32::MAX { old } else { self.new[old as usize] }).collect()
    }

    /// The entries of those that stay, by their new numbers.
    fn entries<T: Clone>(&self, list: &[(u32, T)]) -> Vec<(u32, T)> {
        let stays = |(old, value): &(u32, T)| Some((self.new[*old as usize], value.clone()));
        list.iter().filter_map(stays).filter(|(new, _)| *new != u32::MAX).collect()
    }
}

/// The least owner of the cells at each of `n` things, `of` being those at a cell.
fn least_owner<'a>(n: usize, owner: &[u32], of: impl Fn(usize) -> &'a [u32]) -> Vec<u32> {
    let mut least = vec![u32::MAX; n];
    for (cell, &rank) in owner.iter().enumerate() {
        of(cell).iter().for_each(|&at| least[at as usize] = least[at as usize].min(rank));
    }
    least
}

/// Those that stay as all know them.
fn shared(kept: &Kept, owner: &[u32]) -> Vec<Shared> {
    kept.old.iter().map(|&old| Shared { owner: owner[old as usize], id: u64::from(old) }).collect()
}

impl<const D: usize> Constraints<D> {
    /// Those at the nodes that stay.
    fn part(&self, nodes: &Kept) -> Constraints<D> {
        let Constraints { v, u, p: _, data, motion, moves, mirrors, directions, load, still, follows } = self;
        let mut held = vec![];
        for at in directions.iter().filter(|at| nodes.new[at.node as usize] != u32::MAX) {
            held.push(super::Directions { node: nodes.new[at.node as usize], ..at.clone() });
        }
        Constraints {
            v: nodes.list(v),
            u: nodes.list(u),
            p: vec![],
            data: nodes.entries(data),
            motion: nodes.entries(motion),
            moves: *moves,
            mirrors: nodes.entries(mirrors),
            directions: held,
            load: *load,
            still: *still,
            follows: *follows,
        }
    }
}

impl<const D: usize> FsiSpace<D> {
    /// The part of this process in a space that `crew` shares, with what is given at the nodes of the whole space; `None` if
    /// there are too few cells for so many processes.
    ///
    /// # Panics
    /// If the space has seams, or is itself a part.
    pub fn parted(
        self: &Arc<Self>,
        crew: &Crew,
        constraints: &Constraints<D>,
        rim: Rim,
    ) -> Option<FsiSpace<D>> {
        assert!(self.seams.is_empty() && self.part.is_none(), "a space with seams is not shared");
        let work = |cell: usize| if self.regions[cell] == super::Region::Solid { SOLID } else { 1.0 };
        let owner = self.mesh.partition(&self.hierarchy, crew.size(), work)?;
        let of_nodes = least_owner(self.nodes.len(), &owner, |cell| self.nodes.cell(cell));
        let cells = self.around(&owner, crew.rank() as u32, rim);
        let (n, nodes_of) = (self.nodes.per_cell, |&cell: &u32| cell as usize * self.nodes.per_cell);
        let of_cells = || {
            let ranges = cells.iter().map(nodes_of).map(move |at| at..at + n);
            ranges.flat_map(|range| &self.nodes.cell_nodes[range]).copied()
        };
        let nodes = Kept::of(self.nodes.len(), of_cells());
        let (pressure, pressures) = self.pressure_part(&cells);
        let of_pressures = least_owner(self.n_p(), &owner, |cell| self.pressure.cell(cell));
        let part = Part {
            crew: crew.clone(),
            cells: cells
                .iter()
                .map(|&cell| Shared { owner: owner[cell as usize], id: u64::from(cell) })
                .collect(),
            nodes: shared(&nodes, &of_nodes),
            pressures: shared(&pressures, &of_pressures),
            all: [self.nodes.len(), self.n_p()],
            all_cells: self.mesh.n_cells(),
            memory_before: rim.memory_before,
            constraints: constraints.part(&nodes),
            whole: Mutex::new(Some(Arc::clone(self))),
        };
        let of_list = |list: &[u16]| cells.iter().map(|&cell| list[cell as usize]).collect();
        let nearest = match pressure.kind {
            PressureKind::Pdc(_) => vec![],
            PressureKind::Continuous(_) => nodes.numbers(pressures.list(&self.pressure_nodes).into_iter()),
        };
        Some(FsiSpace {
            mesh: self.mesh.part(&cells),
            coordinates: self.coordinates,
            hierarchy: Hierarchy::default(),
            regions: cells.iter().map(|&cell| self.regions[cell as usize]).collect(),
            material: of_list(&self.material),
            nodes: Nodes {
                degree: self.nodes.degree,
                points: nodes.list(&self.nodes.points),
                cell_nodes: nodes.numbers(of_cells()),
                per_cell: n,
                n_lagrange: nodes.old.partition_point(|&old| (old as usize) < self.nodes.n_lagrange),
            },
            pressure,
            owner: nodes.list(&self.owner),
            deforms: self.deforms,
            walls: self.walls,
            seams: vec![],
            places: None,
            fabrics: self.fabrics.clone(),
            pressure_nodes: nearest,
            part: Some(Arc::new(part)),
        })
    }

    /// The cells of `rank`, and those around them, ascending: all that share a node with one of them for each layer, and
    /// with families those that have the same parent.
    fn around(&self, owner: &[u32], rank: u32, rim: Rim) -> Vec<u32> {
        let mut cells: Vec<u32> =
            (0..owner.len() as u32).filter(|&cell| owner[cell as usize] == rank).collect();
        for _ in 0..rim.layers {
            let mut near = vec![false; self.nodes.len()];
            let nodes = cells.iter().flat_map(|&cell| self.nodes.cell(cell as usize));
            nodes.for_each(|&node| near[node as usize] = true);
            let touches =
                |cell: &u32| self.nodes.cell(*cell as usize).iter().any(|&node| near[node as usize]);
            cells = (0..owner.len() as u32).filter(touches).collect();
        }
        let level = self.hierarchy.coarser().len();
        if level == 0 || !rim.families {
            return cells;
        }
        let parent = |cell: u32| self.hierarchy.child(level - 1, cell as usize).parent;
        let mut parents: Vec<usize> = cells.into_iter().map(parent).collect();
        parents.dedup();
        parents
            .iter()
            .flat_map(|&parent| self.hierarchy.children(level - 1, parent))
            .map(|c| c as u32)
            .collect()
    }

    /// The pressures of `cells`.
    fn pressure_part(&self, cells: &[u32]) -> (PressureSpace<D>, Kept) {
        let PressureSpace { kind, n, per_cell, cell_dofs, frames, points } = &self.pressure;
        let of_cells = || {
            let ranges = cells.iter().map(|&cell| cell as usize * per_cell..(cell as usize + 1) * per_cell);
            ranges.flat_map(|range| &cell_dofs[range]).copied()
        };
        let kept = Kept::of(*n, of_cells());
        let space = PressureSpace {
            kind: *kind,
            n: kept.old.len(),
            per_cell: *per_cell,
            cell_dofs: kept.numbers(of_cells()),
            frames: match kind {
                PressureKind::Pdc(_) => cells.iter().map(|&cell| frames[cell as usize]).collect(),
                PressureKind::Continuous(_) => vec![],
            },
            points: kept.list(points),
        };
        (space, kept)
    }
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
        let shared: Vec<Shared> = places.map(|place| self.shared(part, place as usize, [n_v, n_u])).collect();
        Some(Halo::new(&part.crew, &shared))
    }

    fn shared(&self, part: &Part<D>, place: usize, [n_v, n_u]: [usize; 2]) -> Shared {
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
