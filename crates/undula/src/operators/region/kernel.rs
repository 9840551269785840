//! One region of the mesh: its batches, its equations, and the loops over them.

use super::current_force::CurrentForce;
use super::interior::Interior;
use super::nodal::Nodal;
use crate::algebra::SolverError;
use crate::loops::batch::{Batches, Corners};
use crate::loops::chunks::{Copies, Writes, for_each, for_each_piece};
use crate::loops::scatter::{DROP, PerThread};
use crate::loops::slots::Slots;
use crate::loops::tensor::TensorScratch;
use crate::loops::test_functions::{Piece, Tangents, Test, Trial, pieces};
use crate::loops::width::Width;
use crate::math::{Lanes, Scalar, Tensor, Vector};
use crate::physics::Fields;
use crate::space::{FsiSpace, PsiOwner, Region};
use crate::tangent::ByHand;

/// Body force per mass at the quadrature points of a region \[m/s²\]; empty: none.
pub type ForceField<const D: usize, const L: usize> = Vec<Vector<Lanes<L>, D>>;

/// Its gradient \[1/s²\]; empty: none.
pub type SlopeField<const D: usize, const L: usize> = Vec<Tensor<Lanes<L>, D>>;

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
    /// Whether a state is admissible only where J is positive in this region.
    pub(super) guards: bool,
    /// The body force, where it is taken at the current position.
    pub(super) current_force: Option<CurrentForce<D>>,
    /// Cells and geometry.
    pub batches: Batches<D, L>,
    /// Body force at the new time.
    pub force: ForceField<D, L>,
    /// Its gradient where it is taken at the current position; else empty.
    pub force_slope: SlopeField<D, L>,
    /// Body force at the old time.
    pub force_old: ForceField<D, L>,
    pub(super) pieces: Vec<Piece>,
    /// Where the entries of each piece go in the whole matrix, `[batch][piece][row basis][column basis]`.
    pub(super) slots: Slots<L>,
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

impl<F: ByHand<D>, const D: usize, const L: usize> Kernel<F, D, L>
where
    Lanes<L>: Width,
{
    /// Prepare the loops of `region` for `threads` threads.
    ///
    /// # Errors
    /// If there are too many unknowns to be numbered.
    pub fn new(
        form: F,
        space: &FsiSpace<D>,
        region: Region,
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
            |(list, per_batch, width)| Writes {
                indices: list.as_flattened_mut(),
                per_batch: per_batch * L,
                width,
            },
        );
        let row_copies = Copies::new(space.n_unknowns(), &batches.chunks, &mut writes)?;
        Ok(Kernel {
            min_j: vec![f64::INFINITY; batches.len() * L],
            pieces: pieces(&form.couplings(), D, space.deforms),
            form,
            region,
            guards,
            current_force: None,
            batches,
            force: vec![],
            force_slope: vec![],
            force_old: vec![],
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

    /// Call `visit(lane, row, column)` for every entry of the element matrices, in the numbers that `number` gives to
    /// places in `[v, u, p]`, [`DROP`]ped ones included.
    pub(super) fn whole_entries(&self, number: &[u32], visit: &mut dyn FnMut(usize, u32, u32)) {
        let (n, m) = (self.batches.n_basis, self.batches.n_pressure);
        let of = |first: u32, i: usize| if first == DROP { DROP } else { number[first as usize + i] };
        let n_v = self.first_deformation;
        for batch in 0..self.batches.len() {
            for piece in &self.pieces {
                let rows = if piece.test == Test::Xi { m } else { n };
                let columns = if piece.trial == Trial::P { m } else { n };
                for (a, b) in (0..rows).flat_map(|a| (0..columns).map(move |b| (a, b))) {
                    for l in 0..L {
                        let row = match piece.test {
                            Test::Phi(i) => of(self.rows_phi[batch * n + a][l], i),
                            Test::Psi(i) => of(self.rows_psi[batch * n + a][l], i),
                            Test::Xi => of(self.rows_xi[batch * m + a][l], 0),
                        };
                        let column = match piece.trial {
                            Trial::V(j) => of(self.rows_phi[batch * n + b][l], j),
                            Trial::U(j) => of(n_v + self.rows_phi[batch * n + b][l], j),
                            Trial::P => of(self.rows_xi[batch * m + b][l], 0),
                        };
                        let there = l < self.batches.active[batch] && row != DROP && column != DROP;
                        let (row, column) = if there { (row, column) } else { (DROP, DROP) };
                        visit(l, row, column);
                    }
                }
            }
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
