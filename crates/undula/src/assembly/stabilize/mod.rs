//! Stabilisation of the fluid, added to residual and matrices by loops of its own.
//!
//! A local projection on patches couples the unknowns of the cells of a patch, so that the loop goes over
//! patches; without projection, or with one on cells, a patch is one cell. Pairs that need no stabilisation have
//! no such loop.

mod patches;
pub mod tables;
mod tasks;

use super::chunks::{Copies, Writes, for_each};
use super::kernel::StepView;
use super::scatter::{DROP, PerThread};
use super::simd::Width;
use super::test_functions::Trial;
use crate::algebra::SolverError;
use crate::math::{Lanes, Vector};
use crate::physics::{Fluid, Mapping, PressureTerm, Stabilization, TransportTerm};
use crate::space::FsiSpace;
use crate::tangent::Tangent;
use patches::axes;
pub use patches::patches;
use tables::Tables;
use tasks::{DifferenceTask, MatrixTask, ResidualTask, Scratch};

/// Which columns a matrix has.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Columns {
    /// v, u, p.
    All,
    /// v and p: the condensed system.
    Flow,
}

/// A field of unknowns, and whether momentum and divergence rows depend on it.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub struct Coupling {
    /// The field; components are numbered apart.
    pub trial: Trial,
    /// Momentum.
    pub phi: bool,
    /// Divergence.
    pub xi: bool,
}

/// Which unknowns the rows of the stabilisation depend on.
pub fn couplings(how: &Stabilization, deforms: bool) -> Vec<Coupling> {
    let (momentum, divergence) = (how.transport != TransportTerm::None, how.pressure != PressureTerm::None);
    let mut list = vec![Coupling {
        trial: Trial::V(0),
        phi: momentum,
        // Frozen parameters leave the pressure alone in the terms that are not residuals.
        xi: how.pressure == PressureTerm::Pspg,
    }];
    if deforms {
        // Without the map u is in ∂_t u alone.
        let xi = divergence && (how.map == Mapping::Full || how.pressure == PressureTerm::Pspg);
        list.push(Coupling { trial: Trial::U(0), phi: momentum, xi });
    }
    list.push(Coupling { trial: Trial::P, phi: how.transport == TransportTerm::Supg, xi: divergence });
    list.retain(|c| c.phi || c.xi);
    list
}

/// Where the entries of one matrix go.
#[derive(Default)]
struct Target<const L: usize> {
    couplings: Vec<Coupling>,
    slots: Vec<[u32; L]>,
    copies: Copies,
}

/// The stabilisation on all cells of the fluid, `L` patches at a time.
pub struct Stabilizer<const D: usize, const L: usize> {
    how: Stabilization,
    fluid: Fluid,
    tables: Tables<D, L>,
    /// Axes of the reference cell with their weights.
    axes: Vec<([f64; 3], f64)>,
    /// Body force at the new and at the old time \[m/s²\]; empty: none.
    pub force: [Vec<Vector<Lanes<L>, D>>; 2],
    write_phi: Vec<[u32; L]>,
    write_xi: Vec<[u32; L]>,
    row_copies: Copies,
    targets: [Target<L>; 2],
    scratch: PerThread<Scratch<D, L>>,
    deforms: bool,
    n_v: u32,
    first_pressure: u32,
    threads: usize,
}

impl<const D: usize, const L: usize> Stabilizer<D, L>
where
    Lanes<L>: Width,
{
    /// Prepare the loops.
    ///
    /// # Errors
    /// If there are too many unknowns to be numbered.
    pub fn new(
        how: &Stabilization,
        fluid: Fluid,
        space: &FsiSpace<D>,
        quadrature: usize,
        threads: usize,
    ) -> Result<Stabilizer<D, L>, SolverError> {
        let tables = Tables::new(space, how, quadrature);
        let (n, m) = (tables.velocity.n, tables.pressure.n);
        let (n_v, first_pressure) = (space.n_v() as u32, (space.n_v() + space.n_u()) as u32);
        let mut write_phi: Vec<[u32; L]> =
            tables.velocity.dofs.iter().map(|l| l.map(|node| node * D as u32)).collect();
        let mut write_xi: Vec<[u32; L]> =
            tables.pressure.dofs.iter().map(|l| l.map(|dof| first_pressure + dof)).collect();
        let mut writes = [(&mut write_phi, n, D), (&mut write_xi, m, 1)].map(|(list, per_batch, width)| {
            Writes { indices: list.as_flattened_mut(), per_batch: per_batch * L, width }
        });
        let row_copies = Copies::new(space.n_unknowns(), &tables.chunks, &mut writes)?;
        let all = couplings(how, space.deforms);
        let flow = all.iter().copied().filter(|c| !matches!(c.trial, Trial::U(_))).collect();
        let columns = 2 * n * D + m;
        let scratch = PerThread::new(threads, || Scratch::new(n, m, columns));
        Ok(Stabilizer {
            how: *how,
            fluid,
            axes: axes(space.mesh.shape),
            tables,
            force: [vec![], vec![]],
            write_phi,
            write_xi,
            row_copies,
            targets: [all, flow].map(|couplings| Target { couplings, ..Target::default() }),
            scratch,
            deforms: space.deforms,
            n_v,
            first_pressure,
            threads,
        })
    }

    /// Set the body force at the new (0) or the old (1) time.
    pub fn set_force(&mut self, end: usize, force: Option<super::ForceAt<'_, D>>) {
        let Self { tables, force: field, .. } = self;
        field[end].clear();
        let Some(force) = force else { return };
        for position in &tables.positions {
            let mut values = Vector([Lanes::splat(0.0); D]);
            for l in 0..L {
                let f = force(&std::array::from_fn(|d| position.0[d].0[l]));
                (0..D).for_each(|d| values.0[d].0[l] = f[d]);
            }
            field[end].push(values);
        }
    }

    /// Call `visit(lane, row, column)` for every entry in the numbers that `number` gives to places in
    /// `[v, u, p]`, [`DROP`]ped ones included.
    pub fn entries(&self, columns: Columns, number: &[u32], mut visit: impl FnMut(usize, u32, u32)) {
        let (n, m) = (self.tables.velocity.n, self.tables.pressure.n);
        for batch in 0..self.tables.n_batches() {
            let active = self.tables.active[batch];
            let nodes = &self.tables.velocity.dofs[batch * n..(batch + 1) * n];
            let pressures = &self.tables.pressure.dofs[batch * m..(batch + 1) * m];
            let vectors = |first: u32| {
                nodes.iter().flat_map(move |lanes| {
                    (0..D as u32).map(move |i| lanes.map(|node| first + node * D as u32 + i))
                })
            };
            let scalars = || pressures.iter().map(|lanes| lanes.map(|dof| self.first_pressure + dof));
            for coupling in &self.targets[columns as usize].couplings {
                let places: Vec<[u32; L]> = match coupling.trial {
                    Trial::V(_) => vectors(0).collect(),
                    Trial::U(_) => vectors(self.n_v).collect(),
                    Trial::P => scalars().collect(),
                };
                for column in places {
                    let phi = vectors(0).filter(|_| coupling.phi);
                    for row in phi.chain(scalars().filter(|_| coupling.xi)) {
                        for l in 0..L {
                            let (row, column) = (number[row[l] as usize], number[column[l] as usize]);
                            let there = l < active && row != DROP && column != DROP;
                            visit(l, if there { row } else { DROP }, if there { column } else { DROP });
                        }
                    }
                }
            }
        }
    }

    /// Remember where every entry goes.
    ///
    /// # Errors
    /// If they are too many to be numbered.
    pub fn set_slots(
        &mut self,
        columns: Columns,
        number: &[u32],
        n_entries: usize,
        find: impl Fn(u32, u32) -> u32,
    ) -> Result<(), SolverError> {
        let mut slots: Vec<[u32; L]> = vec![];
        self.entries(columns, number, |l, row, column| {
            if l == 0 {
                slots.push([DROP; L]);
            }
            if let (Some(last), true) = (slots.last_mut(), row != DROP) {
                last[l] = find(row, column);
            }
        });
        let per_batch = slots.len() / self.tables.n_batches().max(1) * L;
        let mut writes = [Writes { indices: slots.as_flattened_mut(), per_batch, width: 1 }];
        let copies = Copies::new(n_entries, &self.tables.chunks, &mut writes)?;
        let target = &mut self.targets[columns as usize];
        (target.slots, target.copies) = (slots, copies);
        Ok(())
    }

    fn for_each_batch(&self, work: impl Fn(usize) + Sync) {
        for_each(&self.tables.chunks, self.threads, &|chunk| chunk.clone().for_each(&work));
    }

    /// Add all terms of the step to `out`.
    pub fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) {
        let mut copies = std::mem::take(&mut self.row_copies);
        let shared = copies.share(out);
        self.for_each_batch(|batch| {
            self.scratch.with(|scratch| {
                Lanes::<L>::dispatch(ResidualTask { of: self, step, batch, scratch, out: &shared });
            });
        });
        copies.gather(out);
        self.row_copies = copies;
    }

    /// Add the derivatives with respect to the new state to the entries `out` of a matrix: by dual numbers, but by
    /// differences in nodal values where the whole matrix is made of them.
    pub fn matrix(&mut self, columns: Columns, step: &StepView<'_>, tangent: Tangent, out: &mut [f64]) {
        let mut copies = std::mem::take(&mut self.targets[columns as usize].copies);
        let shared = copies.share(out);
        let target = &self.targets[columns as usize];
        let per_batch = target.slots.len() / self.tables.n_batches().max(1);
        self.for_each_batch(|batch| {
            self.scratch.with(|scratch| {
                let slots = &target.slots[batch * per_batch..(batch + 1) * per_batch];
                let couplings = &target.couplings;
                let out = &shared;
                let task = MatrixTask { of: self, step, couplings, slots, batch, scratch, out };
                match tangent.nodal() {
                    Some(by) => Lanes::<L>::dispatch(DifferenceTask { by, task }),
                    None => Lanes::<L>::dispatch(task),
                }
            });
        });
        copies.gather(out);
        self.targets[columns as usize].copies = copies;
    }
}
