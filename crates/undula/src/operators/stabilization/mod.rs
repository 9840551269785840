//! Stabilisation of the fluid, added to residual and matrices by loops of its own.
//!
//! A local projection on patches couples the unknowns of the cells of a patch, so that the loop goes over
//! patches; without projection, or with one on cells, a patch is one cell. Pairs that need no stabilisation have
//! no such loop.

mod apply;
mod differences;
mod parameters;
mod patches;
pub mod tables;
mod tasks;

use super::{End, Entries, ForceAt, How, Matrix, Operator, Options, StepView};
use crate::algebra::{Sink, SolverError};
use crate::loops::chunks::{Copies, Writes, for_each};
use crate::loops::scatter::PerThread;
use crate::loops::slots::{Numbering, Pair, Slots, scalars, vectors};
use crate::loops::test_functions::{Test, Trial};
use crate::loops::width::Width;
use crate::math::{Lanes, Vector};
use crate::physics::{Fluid, Mapping, PressureTerm, Stabilization, TransportTerm};
use crate::space::{FsiSpace, Region};
use crate::tangent::Linearization;
use apply::ApplyTask;
use differences::DifferenceTask;
use patches::axes;
pub use patches::patches;
use tables::Tables;
use tasks::{MatrixTask, ResidualTask, Scratch};

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

/// The same test function by test function.
fn pairs(couplings: &[Coupling]) -> Vec<Pair> {
    let of = |c: &Coupling| {
        let tests = [(c.phi, Test::Phi(0)), (c.xi, Test::Xi)];
        tests.into_iter().filter(|(holds, _)| *holds).map(|(_, test)| Pair::full(test, c.trial)).collect()
    };
    couplings.iter().flat_map::<Vec<Pair>, _>(of).collect()
}

/// Where the entries of one matrix go.
#[derive(Default)]
struct Target<const D: usize, const L: usize> {
    couplings: Vec<Coupling>,
    slots: Slots<D, L>,
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
    targets: [Target<D, L>; 2],
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
        options: &Options,
    ) -> Result<Stabilizer<D, L>, SolverError> {
        let tables = Tables::new(space, how, options.quadrature);
        let (n, m) = (tables.velocity.n, tables.pressure.n);
        let (n_v, first_pressure) = (space.n_v() as u32, (space.n_v() + space.n_u()) as u32);
        let mut write_phi: Vec<[u32; L]> =
            tables.velocity.dofs.iter().map(|l| l.map(|node| node * D as u32)).collect();
        let mut write_xi: Vec<[u32; L]> =
            tables.pressure.dofs.iter().map(|l| l.map(|dof| first_pressure + dof)).collect();
        let mut writes = [(&mut write_phi, n, D), (&mut write_xi, m, 1)].map(|(list, per_batch, width)| {
            Writes::runs(list.as_flattened_mut(), &tables.chunks, per_batch * L, width)
        });
        let row_copies = Copies::new(space.n_field_unknowns(), tables.chunks.len(), &mut writes)?;
        drop(writes);
        let all = couplings(how, space.deforms);
        let flow = all.iter().copied().filter(|c| !matches!(c.trial, Trial::U(_))).collect();
        let columns = 2 * n * D + m;
        let scratch = PerThread::new(options.threads, || Scratch::new(n, m, columns));
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
            threads: options.threads,
        })
    }

    /// Rows and columns of a batch in the numbers that `number` gives to places in `[v, u, p]`.
    fn numbering(&self, batch: usize, number: &[u32]) -> Numbering<D, L> {
        let (n, m, active) = (self.tables.velocity.n, self.tables.pressure.n, self.tables.active[batch]);
        let nodes = &self.tables.velocity.dofs[batch * n..(batch + 1) * n];
        let pressures = &self.tables.pressure.dofs[batch * m..(batch + 1) * m];
        let vector = |first: u32| {
            let places = nodes.iter().map(|lanes| lanes.map(|node| first + node * D as u32));
            vectors(places, active, number)
        };
        let scalar =
            || scalars(pressures.iter().map(|l| l.map(|dof| self.first_pressure + dof)), active, number);
        let u = if self.deforms { vector(self.n_v) } else { vec![] };
        Numbering { rows: [vector(0), vec![], scalar()], columns: [vector(0), u, scalar()] }
    }

    fn for_each_batch(&self, work: impl Fn(usize) + Sync) {
        for_each(&self.tables.chunks, self.threads, &|chunk| chunk.clone().for_each(&work));
    }
}

impl<const D: usize, const L: usize> Operator<D> for Stabilizer<D, L>
where
    Lanes<L>: Width,
{
    fn body(&self) -> Region {
        Region::Fluid
    }

    fn set_force(&mut self, end: End, force: Option<ForceAt<'_, D>>) {
        let field = &mut self.force[usize::from(end == End::Old)];
        field.clear();
        let Some(force) = force else { return };
        for position in &self.tables.positions {
            let mut values = Vector([Lanes::splat(0.0); D]);
            for l in 0..L {
                let f = force(&std::array::from_fn(|d| position.0[d].0[l]));
                (0..D).for_each(|d| values.0[d].0[l] = f[d]);
            }
            field.push(values);
        }
    }

    fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64 {
        let mut copies = std::mem::take(&mut self.row_copies);
        let shared = copies.share(out);
        self.for_each_batch(|batch| {
            self.scratch.with(|scratch| {
                Lanes::<L>::dispatch(ResidualTask { of: self, step, batch, scratch, out: &shared });
            });
        });
        copies.gather(out);
        self.row_copies = copies;
        f64::INFINITY
    }

    fn entries(&self, matrix: Matrix, number: &[u32], visit: &mut dyn FnMut(u32, u32)) {
        let pairs = pairs(&self.targets[matrix as usize].couplings);
        for batch in 0..self.tables.n_batches() {
            self.numbering(batch, number).visit(&pairs, visit);
        }
    }

    fn place(&mut self, matrix: Matrix, number: &[u32], entries: &Entries<'_>) -> Result<(), SolverError> {
        let (batches, chunks) = (self.tables.n_batches(), &self.tables.chunks);
        let pairs = pairs(&self.targets[matrix as usize].couplings);
        let numbering = |batch| self.numbering(batch, number);
        let slots = Slots::new(batches, chunks, entries, &pairs, numbering)?;
        self.targets[matrix as usize].slots = slots;
        Ok(())
    }

    /// By dual numbers, but by differences in nodal values where the whole matrix is made of them.
    fn linearise(&mut self, matrix: Matrix, step: &StepView<'_>, how: How, out: Sink<'_>) {
        let mut slots = std::mem::take(&mut self.targets[matrix as usize].slots);
        // Of the reduced Jacobian u is left out, as of the condensed one.
        let left = if how.linearization == Linearization::Reduced { Matrix::Condensed } else { matrix };
        let couplings = &self.targets[left as usize].couplings;
        slots.fill(out, |slots, out| {
            self.for_each_batch(|batch| {
                self.scratch.with(|scratch| {
                    let task = MatrixTask { of: self, step, couplings, slots, batch, scratch, out };
                    match how.tangent.nodal() {
                        Some(by) => Lanes::<L>::dispatch(DifferenceTask { by, task }),
                        None => Lanes::<L>::dispatch(task),
                    }
                });
            });
        });
        self.targets[matrix as usize].slots = slots;
    }

    fn apply(&mut self, matrix: Matrix, step: &StepView<'_>, x: &[f64], y: &mut [f64]) {
        let with_u = self.deforms && matrix == Matrix::Whole;
        let mut copies = std::mem::take(&mut self.row_copies);
        let shared = copies.share(y);
        self.for_each_batch(|batch| {
            self.scratch.with(|scratch| {
                Lanes::<L>::dispatch(ApplyTask { of: self, step, with_u, x, batch, scratch, out: &shared });
            });
        });
        copies.gather(y);
        self.row_copies = copies;
    }

    /// A projection on patches couples the unknowns inside of a cell to those of its neighbours, and constants of the
    /// pressure are felt by all.
    fn spans_cells(&self) -> bool {
        true
    }
}
