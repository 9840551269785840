//! A space in parts, one for each of several processes.

use super::part::{Part, Rim};
use super::{Constraints, Directions, FsiSpace, Nodes, PressureKind, PressureSpace, Region};
use crate::mesh::Hierarchy;
use crate::parallel::{Crew, Shared};
use std::sync::{Arc, Mutex};

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
            held.push(Directions { node: nodes.new[at.node as usize], ..at.clone() });
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
        let owner = self.ranks_of_cells(crew.size())?;
        let of_nodes = least_owner(self.nodes.len(), &owner, |cell| self.nodes.cell(cell));
        let cells = self.around(&owner, crew.rank() as u32, rim);
        let nodes = Kept::of(self.nodes.len(), self.nodes_at(&cells));
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
            nodes: self.nodes_part(&nodes, &cells),
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

    /// The process of each cell, of `n`; `None` if there are too few cells.
    pub fn ranks_of_cells(&self, n: usize) -> Option<Vec<u32>> {
        let work = |cell: usize| if self.regions[cell] == Region::Solid { SOLID } else { 1.0 };
        self.mesh.partition(&self.hierarchy, n, work)
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

    /// Nodes of `cells`, one after the other.
    fn nodes_at<'a>(&'a self, cells: &'a [u32]) -> impl Iterator<Item = u32> + 'a {
        let n = self.nodes.per_cell;
        let ranges = cells.iter().map(move |&cell| cell as usize * n..(cell as usize + 1) * n);
        ranges.flat_map(|range| &self.nodes.cell_nodes[range]).copied()
    }

    /// The nodes of `cells`, those that are `kept`.
    fn nodes_part(&self, kept: &Kept, cells: &[u32]) -> Nodes<D> {
        Nodes {
            degree: self.nodes.degree,
            points: kept.list(&self.nodes.points),
            cell_nodes: kept.numbers(self.nodes_at(cells)),
            per_cell: self.nodes.per_cell,
            n_lagrange: kept.old.partition_point(|&old| (old as usize) < self.nodes.n_lagrange),
        }
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
