//! One region of the mesh: its batches, its equations, and the loops over them.

use super::body_force::BodyForce;
use super::fabric::fabric;
use super::interior::Interior;
use super::nodal::Nodal;
use crate::algebra::SolverError;
use crate::loops::batch::{Batches, Corners};
use crate::loops::chunks::{Copies, Writes, for_each, for_each_piece};
use crate::loops::scatter::{DROP, PerThread};
use crate::loops::slots::{Numbering, Slots, scalars, vectors};
use crate::loops::tensor::TensorScratch;
use crate::loops::test_functions::{Piece, Tangents, pieces};
use crate::loops::width::Width;
use crate::math::{Lanes, Scalar, Vector};
use crate::physics::{Fabric, Fields};
use crate::space::{FsiSpace, PsiOwner, Region};
use crate::tangent::StepForm;

/// Coefficients of the direction in the cells of a batch.
#[derive(Default)]
pub(super) struct Direction<const D: usize, const L: usize> {
    pub(super) v: Vec<Vector<Lanes<L>, D>>,
    pub(super) u: Vec<Vector<Lanes<L>, D>>,
    pub(super) p: Vec<Lanes<L>>,
}

/// Work space of one thread.
pub(super) struct Scratch<const D: usize, const L: usize> {
    pub(super) v: Vec<Vector<Lanes<L>, D>>,
    pub(super) u: Vec<Vector<Lanes<L>, D>>,
    pub(super) v_old: Vec<Vector<Lanes<L>, D>>,
    pub(super) u_old: Vec<Vector<Lanes<L>, D>>,
    pub(super) p: Vec<Lanes<L>>,
    pub(super) phi: Vec<Vector<Lanes<L>, D>>,
    pub(super) psi: Vec<Vector<Lanes<L>, D>>,
    pub(super) xi: Vec<Lanes<L>>,
    pub(super) tangent: Vec<Lanes<L>>,
    pub(super) piece: Vec<Lanes<L>>,
    /// (v, p) matrix of the cells, and a vector of its size.
    pub(super) matrix: Vec<Lanes<L>>,
    pub(super) outer: Vec<Lanes<L>>,
    pub(super) tensor: TensorScratch<D, L>,
    pub(super) nodal: Nodal<D, L>,
    /// Of a product without a matrix.
    pub(super) direction: Direction<D, L>,
}

impl<const D: usize, const L: usize> Scratch<D, L> {
    /// For the cells of a region.
    fn new(batches: &Batches<D, L>) -> Scratch<D, L> {
        let (n, m, q) = (batches.n_basis, batches.n_pressure, batches.n_points);
        let components = Fields::<f64, D>::COMPONENTS;
        let vectors = || vec![Vector::zero(); n];
        let scalars = || vec![Lanes::zero(); m];
        Scratch {
            v: vectors(),
            u: vectors(),
            v_old: vectors(),
            u_old: vectors(),
            p: scalars(),
            phi: vectors(),
            psi: vectors(),
            xi: scalars(),
            tangent: vec![Lanes::zero(); q * components * components],
            piece: vec![Lanes::zero(); n * n.max(m)],
            matrix: vec![Lanes::zero(); (n * D + m).pow(2)],
            outer: vec![Lanes::zero(); n * D + m],
            tensor: TensorScratch::new(batches.tensor.as_ref()),
            nodal: Nodal::default(),
            direction: Direction::default(),
        }
    }
}

/// A region with its equations `F`, `L` cells at a time.
pub struct Kernel<F, const D: usize, const L: usize> {
    pub(super) form: F,
    pub(super) region: Region,
    pub(super) material: u16,
    /// Whether a state is admissible only where J is positive in this region.
    pub(super) guards: bool,
    pub(super) body_force: BodyForce<D, L>,
    /// What a solid has at the points, `[batch][point]`; empty: plain.
    pub(super) fabric: Vec<Fabric<Lanes<L>, D>>,
    /// Cells and geometry.
    pub batches: Batches<D, L>,
    pub(super) pieces: Vec<Piece>,
    /// Where they go in the whole matrix.
    pub(super) slots: Slots<D, L>,
    /// Where the element vectors go in `[v, u, p]`, or copies of it.
    pub(super) write_phi: Vec<[u32; L]>,
    pub(super) write_psi: Vec<[u32; L]>,
    pub(super) write_xi: Vec<[u32; L]>,
    pub(super) row_copies: Copies,
    pub(super) rows_phi: Vec<[u32; L]>,
    pub(super) rows_psi: Vec<[u32; L]>,
    pub(super) rows_xi: Vec<[u32; L]>,
    pub(super) deforms: bool,
    /// Places of the first deformation and the first pressure in `[v, u, p]`.
    pub(super) first_deformation: u32,
    pub(super) first_pressure: u32,
    /// Pieces of the (v, p) matrix of condensed Newton.
    pub(super) condensed: Vec<Piece>,
    /// Its inner unknowns.
    pub(super) interior: Option<Interior<D, L>>,
    pub(super) scratch: PerThread<Scratch<D, L>>,
    /// Smallest J met by the last residual, per cell: `[batch][lane]`.
    pub(super) min_j: Vec<f64>,
    /// Geometry at the nodes, once asked for.
    pub(super) corners: Option<Corners<D, L>>,
    /// Batches with watched nodes.
    watched: Vec<bool>,
    /// Leave out all others.
    pub(super) only_watched: bool,
    threads: usize,
}

impl<F: StepForm<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    /// Prepare the loops of a region and its material for `threads` threads.
    ///
    /// # Errors
    /// If there are too many unknowns to be numbered.
    pub fn new(
        form: F,
        space: &FsiSpace<D>,
        (region, material): (Region, u16),
        guards: bool,
        batches: Batches<D, L>,
        threads: usize,
    ) -> Result<Kernel<F, D, L>, SolverError> {
        let (n, m) = (batches.n_basis, batches.n_pressure);
        let scratch = PerThread::new(threads, || Scratch::new(&batches));
        let (n_v, n_u) = (space.n_v() as u32, space.n_u() as u32);
        let owner = if region == Region::Solid { PsiOwner::Relation } else { PsiOwner::Extension };
        let psi_row = |node: u32| {
            if space.deforms && space.owner[node as usize] == owner { n_v + node * D as u32 } else { DROP }
        };
        let rows_phi: Vec<[u32; L]> = batches.nodes.iter().map(|l| l.map(|node| node * D as u32)).collect();
        let rows_psi: Vec<[u32; L]> = batches.nodes.iter().map(|l| l.map(psi_row)).collect();
        let rows_xi: Vec<[u32; L]> = batches.pressure.iter().map(|l| l.map(|p| n_v + n_u + p)).collect();
        let (mut write_phi, mut write_psi, mut write_xi) =
            (rows_phi.clone(), rows_psi.clone(), rows_xi.clone());
        let mut writes = [(&mut write_phi, n, D), (&mut write_psi, n, D), (&mut write_xi, m, 1)].map(
            |(list, per_batch, width)| {
                Writes::runs(list.as_flattened_mut(), &batches.chunks, per_batch * L, width)
            },
        );
        let row_copies = Copies::new(space.n_field_unknowns(), batches.chunks.len(), &mut writes)?;
        drop(writes);
        Ok(Kernel {
            min_j: vec![f64::INFINITY; batches.len() * L],
            pieces: pieces(&form.blocks(), D, space.deforms),
            form,
            region,
            material,
            guards,
            body_force: BodyForce::none(),
            fabric: fabric(space, (region, material), &batches),
            batches,
            slots: Slots::default(),
            write_phi,
            write_psi,
            write_xi,
            row_copies,
            rows_phi,
            rows_psi,
            rows_xi,
            deforms: space.deforms,
            first_deformation: n_v,
            first_pressure: n_v + n_u,
            condensed: vec![],
            interior: None,
            scratch,
            corners: None,
            watched: vec![],
            only_watched: false,
            threads,
        })
    }

    /// Rows and columns of a batch in the numbers that `number` gives to places in `[v, u, p]`.
    pub(super) fn numbering(&self, batch: usize, number: &[u32]) -> Numbering<D, L> {
        let (n, m) = (self.batches.n_basis, self.batches.n_pressure);
        let (nodes, active) = (batch * n..(batch + 1) * n, self.batches.active[batch]);
        let vectors = |list: &[[u32; L]]| vectors(list.iter().copied(), active, number);
        let phi = &self.rows_phi[nodes.clone()];
        let u: Vec<[u32; L]> = phi.iter().map(|lanes| lanes.map(|at| self.first_deformation + at)).collect();
        let xi = || scalars(self.rows_xi[batch * m..(batch + 1) * m].iter().copied(), active, number);
        Numbering {
            rows: [vectors(phi), vectors(&self.rows_psi[nodes]), xi()],
            columns: [vectors(phi), if self.deforms { vectors(&u) } else { vec![] }, xi()],
        }
    }

    /// Note which batches have one of the watched `nodes`.
    pub(super) fn watch_batches(&mut self, nodes: &[bool]) {
        let n = self.batches.n_basis;
        let has = |lanes: &[u32; L]| lanes.iter().any(|&node| nodes[node as usize]);
        self.watched = self.batches.nodes.chunks_exact(n).map(|batch| batch.iter().any(has)).collect();
    }

    /// Run `work` on every batch, the batches of a chunk in their order on one thread.
    pub(super) fn for_each_batch(&self, work: impl Fn(usize) + Sync) {
        for_each(&self.batches.chunks, self.threads, &|chunk| {
            for batch in chunk.clone() {
                if !self.only_watched || self.watched[batch] {
                    work(batch);
                }
            }
        });
    }

    /// The same with the piece of `size` entries of `array` that belongs to each batch.
    pub(super) fn for_each_batch_of<T: Send>(
        &self,
        array: &mut [T],
        size: usize,
        work: impl Fn(usize, &mut [T]) + Sync,
    ) {
        for_each_piece(&self.batches.chunks, array, size, self.threads > 1, &work);
    }

    /// Smallest J of the last residual with its cell, and all cells where J is not positive.
    pub(super) fn worst_cells(&self) -> Option<(f64, Vec<u32>)> {
        let cell = |i: usize| self.batches.cells[i / L][i % L];
        let (worst, j) = self.min_j.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        let mut cells = vec![cell(worst)];
        let real = |i: &usize| i % L < self.batches.active[i / L];
        cells.extend(
            (0..self.min_j.len()).filter(real).filter(|&i| i != worst && self.min_j[i] <= 0.0).map(cell),
        );
        Some((*j, cells))
    }

    /// The tangents of a batch, ready to be contracted, or its element matrix.
    pub(super) fn tangents<'a>(
        &'a self,
        batch: usize,
        tangent: &'a [Lanes<L>],
        nodal: Option<&'a [Lanes<L>]>,
    ) -> Tangents<'a, D, L> {
        let b = &self.batches;
        let points = b.n_points * b.n_pressure;
        Tangents {
            tangent,
            basis: &b.basis,
            pressure: &b.pressure_basis[batch * points..(batch + 1) * points],
            n_basis: b.n_basis,
            n_pressure: b.n_pressure,
            n_points: b.n_points,
            tensor: b.tensor.as_ref(),
            nodal,
        }
    }
}
