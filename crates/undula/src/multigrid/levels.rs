//! Unknowns of the levels, and how those of a finer one follow from those of a coarser one.
//!
//! A node of a coarser mesh is a node of the finer one: it keeps its number. Coarser unknowns are those at the nodes of
//! the coarser cells that are not given, and all pressures of these cells; only on the finest level some are eliminated.

use super::blocks::{by_rank, of_groups};
use super::clusters::{groups, side_by_side};
use super::lists::Lists;
use super::numbers::{Cells, NONE, Numbers, without_idle};
use super::weights::{ZERO, in_child, pressure_weights, weights};
use crate::algebra::{Kind, Unknown};

use crate::mesh::{Mesh, Split};
use crate::space::{FsiSpace, PressureKind, PressureSpace};

/// Groups of coarser cells that are joined to a block at most, by dimension less one. In space factors of large blocks are
/// what costs most: no more are joined there than side by side are about as long in all directions.
const JOINED: [usize; 3] = [64, 64, 8];

/// A level above the coarsest one.
#[derive(Clone, Debug)]
pub struct Tier {
    /// Its unknowns in each block of the smoother.
    pub blocks: Lists<u32>,
    /// The process of each block, where several share them.
    pub ranks: Vec<u32>,
    /// Each of its unknowns from those of the coarser level.
    pub rows: Lists<(u32, f32)>,
    /// The unknowns of the coarser level.
    pub unknowns: Vec<Unknown>,
}

/// A system whose unknowns are some of `[v, u, p]`.
#[derive(Copy, Clone, Debug)]
pub enum System<'a> {
    /// Of v and p, where some unknowns are given, and others are eliminated.
    Flow {
        /// Those of `[v, u, p]` that are given.
        given: &'a [bool],
        /// The places of the unknowns of the system.
        places: &'a [u32],
    },
    /// Of u, with unknowns at these places.
    Extension(&'a [u32]),
}

/// From the finest level down. `ranks` are the processes of the cells, where several share them: they have no block in
/// common.
pub fn tiers<const D: usize>(space: &FsiSpace<D>, system: System<'_>, ranks: &[u32]) -> Vec<Tier> {
    let (n_v, n_u) = (space.n_v(), space.n_u());
    let (kind, places) = match system {
        System::Flow { places, .. } => (Kind::Velocity, places),
        System::Extension(places) => (Kind::Deformation, places),
    };
    let mut of_places = vec![NONE; space.n_field_unknowns()];
    places.iter().zip(0..).for_each(|(&place, number)| of_places[place as usize] = number);
    let (nodal, given): (_, Vec<bool>) = match system {
        System::Flow { given, .. } => (&of_places[..n_v], given[..n_v].to_vec()),
        System::Extension(_) => {
            let of_u = &of_places[n_v..n_v + n_u];
            (of_u, of_u.iter().map(|&number| number == NONE).collect())
        }
    };
    let mut numbers = Numbers { v: nodal.to_vec(), p: of_places[n_v + n_u..].to_vec(), n: places.len() };
    let n_cells = space.mesh.n_cells();
    let mut cells = Cells {
        nodes: (0..n_cells).map(|cell| space.nodes.cell(cell).to_vec()).collect(),
        pressures: (0..n_cells).map(|cell| space.pressure.cell(cell).to_vec()).collect(),
    };
    let mut finer = (space.mesh.clone(), space.pressure.clone());
    let mut ranks = ranks.to_vec();
    let mut list = vec![];
    for (number, mesh) in space.hierarchy.coarser().iter().enumerate().rev() {
        let split = space.hierarchy.split(number);
        let coarser = coarser_pressure(space, (mesh, split), &finer.1, kind);
        let (finer_level, coarser_level) = ((&finer.0, &finer.1), (mesh, &coarser));
        let (finer_ranks, given) = (&ranks[..], &given[..]);
        let level = Coarsening {
            space,
            kind,
            split,
            given,
            ranks: finer_ranks,
            finer: finer_level,
            coarser: coarser_level,
        };
        let (tier, next_numbers, next_cells) = level.tier(&numbers, &cells);
        ranks = ranks.into_iter().step_by(split.children(D)).collect();
        list.push(tier);
        (numbers, cells) = (next_numbers, next_cells);
        finer = (mesh.clone(), coarser);
    }
    list
}

/// The pressures on the cells of `mesh` whose children have some.
fn coarser_pressure<const D: usize>(
    space: &FsiSpace<D>,
    (mesh, split): (&Mesh<D>, Split),
    finer: &PressureSpace<D>,
    kind: Kind,
) -> PressureSpace<D> {
    let of = |cell: usize| kind == Kind::Velocity && !finer.cell(cell * split.children(D)).is_empty();
    PressureSpace::new(mesh, space.pressure.kind, of)
}

/// From one level to the next coarser one.
struct Coarsening<'a, const D: usize> {
    space: &'a FsiSpace<D>,
    kind: Kind,
    /// How the coarser cells are split.
    split: Split,
    given: &'a [bool],
    /// Of the finer cells.
    ranks: &'a [u32],
    finer: (&'a Mesh<D>, &'a PressureSpace<D>),
    coarser: (&'a Mesh<D>, &'a PressureSpace<D>),
}

impl<const D: usize> Coarsening<'_, D> {
    fn tier(&self, numbers: &Numbers, cells: &Cells) -> (Tier, Numbers, Cells) {
        let (shape, split) = (self.space.mesh.shape, self.split);
        let n_children = split.children(D);
        let coarse_cells = self.cells(cells);
        let (coarse, unknowns) = self.numbers(&coarse_cells);
        let mut rows: Vec<Vec<(u32, f32)>> = vec![vec![]; numbers.n];
        let degree = self.space.nodes.degree;
        let tables: Vec<Vec<Vec<(usize, f64)>>> =
            (0..n_children).map(|child| weights(shape, split, degree, child)).collect();
        for (cell, nodes) in coarse_cells.nodes.iter().enumerate() {
            for (child, fine) in (cell * n_children..(cell + 1) * n_children).enumerate() {
                for (&node, weights) in cells.nodes[fine].iter().zip(&tables[child]) {
                    for i in 0..D {
                        let row = numbers.v[node as usize * D + i];
                        if row == NONE || !rows[row as usize].is_empty() {
                            continue;
                        }
                        let of = |&(a, weight): &(usize, f64)| {
                            (coarse.v[nodes[a] as usize * D + i], weight as f32)
                        };
                        rows[row as usize]
                            .extend(weights.iter().map(of).filter(|(column, _)| *column != NONE));
                    }
                }
                self.pressures(cell, fine, child, (numbers, &coarse), &mut rows);
            }
        }
        let (coarse, unknowns) = without_idle(coarse, unknowns, &mut rows);
        let mut lists = Lists::default();
        rows.into_iter().for_each(|row| lists.push(row));
        let continuous = matches!(self.finer.1.kind, PressureKind::Continuous(_));
        let (mut groups, mut ranks) = (self.groups(), vec![]);
        if !self.ranks.is_empty() {
            (groups, ranks) = by_rank(groups, self.ranks);
        }
        let (blocks, made) = of_groups::<D>(&groups, numbers, cells, continuous);
        let ranks = made.into_iter().filter_map(|group| ranks.get(group).copied()).collect();
        let tier = Tier { blocks, ranks, rows: lists, unknowns };
        (tier, coarse, coarse_cells)
    }

    /// The finer cells that the smoother takes together.
    fn groups(&self) -> Vec<Vec<u32>> {
        let (axes, n) = (self.split.axes(D), self.split.children(D) as u32);
        if self.kind == Kind::Deformation {
            return groups(self.finer.0, axes, |_| JOINED[D - 1] << (D - 1));
        }
        let most = |cell: u32| match D {
            3 => JOINED[2].min(side_by_side(self.coarser.0, cell)),
            _ => JOINED[D - 1],
        };
        let groups = groups(self.coarser.0, axes, most);
        let children =
            |group: Vec<u32>| group.into_iter().flat_map(|cell| cell * n..(cell + 1) * n).collect();
        groups.into_iter().map(children).collect()
    }

    /// Nodes of the coarser cells, and their pressures.
    fn cells(&self, finer: &Cells) -> Cells {
        let (mesh, pressure) = self.coarser;
        let (shape, degree) = (mesh.shape, self.space.nodes.degree);
        let found: Vec<(usize, usize)> =
            (0..shape.n_nodes(degree)).map(|a| in_child(shape, self.split, degree, a)).collect();
        let nodes = |cell: usize| {
            let children = cell * self.split.children(D);
            found.iter().map(|&(child, a)| finer.nodes[children + child][a]).collect()
        };
        Cells {
            nodes: (0..mesh.n_cells()).map(nodes).collect(),
            pressures: (0..mesh.n_cells()).map(|cell| pressure.cell(cell).to_vec()).collect(),
        }
    }

    /// Numbers of the coarser unknowns, in the order in which cells meet them.
    fn numbers(&self, cells: &Cells) -> (Numbers, Vec<Unknown>) {
        let (_, pressure) = self.coarser;
        let position = |x: &[f64; D]| std::array::from_fn(|d| if d < D { x[d] } else { 0.0 });
        let mut v = vec![NONE; self.space.n_v()];
        let mut p = vec![NONE; pressure.n];
        let mut unknowns: Vec<Unknown> = vec![];
        let behind = self.space.nodes.len() as u32;
        for (nodes, pressures) in cells.nodes.iter().zip(&cells.pressures) {
            for &node in nodes {
                for i in 0..D {
                    let place = node as usize * D + i;
                    if v[place] == NONE && !self.given[place] {
                        v[place] = unknowns.len() as u32;
                        let at = position(&self.space.nodes.points[node as usize]);
                        unknowns.push(Unknown { node, kind: self.kind, at });
                    }
                }
            }
            for &dof in pressures.iter().filter(|&&dof| p[dof as usize] == NONE).collect::<Vec<_>>() {
                p[dof as usize] = unknowns.len() as u32;
                let point = &pressure.points[dof as usize];
                let node = match pressure.kind {
                    PressureKind::Pdc(_) => behind + dof / pressure.per_cell as u32,
                    PressureKind::Continuous(_) => self.home(nodes, point).unwrap_or(behind + dof),
                };
                unknowns.push(Unknown { node, kind: Kind::Pressure, at: position(point) });
            }
        }
        (Numbers { v, p, n: unknowns.len() }, unknowns)
    }

    /// Of the nodes of a cell at which v is not given, the nearest to a pressure: they are eliminated together.
    fn home(&self, nodes: &[u32], point: &[f64; D]) -> Option<u32> {
        let is_free = |node: u32| (0..D).any(|i| !self.given[node as usize * D + i]);
        let far = |node: u32| -> f64 {
            let at = &self.space.nodes.points[node as usize];
            at.iter().zip(point).map(|(a, b)| (a - b) * (a - b)).sum()
        };
        nodes.iter().copied().filter(|&node| is_free(node)).min_by(|&a, &b| far(a).total_cmp(&far(b)))
    }

    /// The rows of the pressures of cell `fine`, which is `child` of `cell`.
    fn pressures(
        &self,
        cell: usize,
        fine: usize,
        child: usize,
        (numbers, coarse): (&Numbers, &Numbers),
        rows: &mut [Vec<(u32, f32)>],
    ) {
        let ((mesh, finer), (coarse_mesh, coarser)) = (self.finer, self.coarser);
        let dofs = finer.cell(fine);
        let needed = dofs.iter().any(|&dof| {
            let row = numbers.p[dof as usize];
            row != NONE && rows[row as usize].is_empty()
        });
        if !needed {
            return;
        }
        let table = pressure_weights((mesh, finer, fine), (coarse_mesh, coarser, cell), (self.split, child));
        for (&dof, weights) in dofs.iter().zip(&table) {
            let row = numbers.p[dof as usize];
            if row == NONE || !rows[row as usize].is_empty() {
                continue;
            }
            let entries = coarser.cell(cell).iter().zip(weights).filter(|(_, weight)| weight.abs() > ZERO);
            let entries = entries.map(|(&dof, &weight)| (coarse.p[dof as usize], weight as f32));
            rows[row as usize].extend(entries.filter(|(column, _)| *column != NONE));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::weights::least_squares;
    use super::*;
    use crate::element::lagrange;
    use crate::mesh::{Hierarchy, generate};
    use crate::space::{FsiSpace, Region};

    /// Fields of the finer space that the coarser one has, too, are prolonged to themselves.
    fn are_kept<const D: usize>(coarse: Mesh<D>, degree: usize, kind: PressureKind) {
        let (mesh, hierarchy) = Hierarchy::refine(coarse, 1, &[]);
        let cells = mesh.n_cells();
        let mut space = FsiSpace::new(mesh, vec![Region::Fluid; cells], degree, kind);
        space.hierarchy = hierarchy;
        let n = space.n_field_unknowns();
        let places: Vec<u32> = (0..n as u32).collect();
        let tiers = tiers(&space, System::Flow { given: &vec![false; n], places: &places }, &[]);
        let [Tier { blocks, rows, unknowns, .. }] = &tiers[..] else { panic!("{} levels", tiers.len()) };
        let power = |degree: usize, x: &[f64]| (0.3 + x[0] - 0.7 * x[D - 1] + 0.2 * x[1]).powi(degree as i32);
        // Coefficients of a velocity, the same in all components, and of a pressure of the pair's degrees.
        let pressure = &space.pressure;
        let first = (&space.hierarchy.coarser()[0], space.hierarchy.split(0));
        let coarser = coarser_pressure(&space, first, pressure, Kind::Velocity);
        let coarse_p = coefficients(&space.hierarchy.coarser()[0], &coarser, power);
        let mut next = coarse_p.iter();
        let coarse: Vec<f64> = unknowns
            .iter()
            .map(|unknown| match unknown.kind {
                Kind::Pressure => *next.next().unwrap(),
                _ => power(degree, &unknown.at),
            })
            .collect();
        let fine_p = coefficients(&space.mesh, pressure, power);
        for (row, entries) in rows.iter().enumerate() {
            let found: f64 = entries.iter().map(|&(at, w)| f64::from(w) * coarse[at as usize]).sum();
            let exact = match row.checked_sub(space.n_v()) {
                None => power(degree, &space.nodes.points[row / D]),
                Some(p) => fine_p[p],
            };
            assert!((found - exact).abs() < 3e-6, "{degree} {kind:?} {row}: {found} {exact}");
        }
        // All unknowns are in a block.
        let mut all = blocks.items().to_vec();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), n);
    }

    /// Coefficients of the polynomial `power` of the degree of the space, cells in their order: continuous ones in the
    /// order in which cells meet them.
    fn coefficients<const D: usize>(
        mesh: &Mesh<D>,
        space: &PressureSpace<D>,
        power: impl Fn(usize, &[f64]) -> f64,
    ) -> Vec<f64> {
        let degree = space.kind.degree();
        if let PressureKind::Continuous(_) = space.kind {
            return space.points.iter().map(|x| power(degree, x)).collect();
        }
        let mut list = vec![];
        for cell in 0..mesh.n_cells() {
            let (mut left, mut right) = (vec![], vec![]);
            for a in 0..mesh.shape.n_nodes(degree.max(1)) {
                let xi = lagrange::node(mesh.shape, degree.max(1), a);
                let x = mesh.map(cell, std::array::from_fn(|d| xi[d]));
                left.push(space.basis(mesh, cell, &xi, &x));
                right.push(vec![power(degree, &x)]);
            }
            list.extend(least_squares(&left, &right).into_iter().flatten());
        }
        list
    }

    #[test]
    fn polynomials_are_prolonged_to_themselves() {
        for (degree, kind) in [
            (1, PressureKind::Pdc(0)),
            (2, PressureKind::Pdc(1)),
            (3, PressureKind::Pdc(2)),
            (2, PressureKind::Continuous(1)),
        ] {
            are_kept(generate::rectangle([0.0; 2], [1.0, 0.7], [3, 2], 0).unwrap(), degree, kind);
            are_kept(generate::hexahedra([0.0; 3], [1.0, 0.7, 0.4], [2, 1, 2], 0).unwrap(), degree, kind);
        }
    }
}
