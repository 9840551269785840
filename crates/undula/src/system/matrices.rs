//! The matrices of the linear systems: of all unknowns, and of v and p alone.

use super::directions::{self, DirectedBlocks};
use super::{Assembler, granted};
use crate::algebra::{Csr, Pattern, SolverError, Unknown, Value, add_column};
use crate::loops::scatter::DROP;
use crate::operators::{Blocks, Entries, How, Matrix, StepView};
use crate::space::{PressureKind, Region};
use crate::tangent::{Difference, Linearization, Sizes, Tangent};
use std::sync::Arc;

/// Median ratio of the sides of cells above which the unknowns inside are left to the factors. Measured with one layer of
/// cfd3, `mesh.refine=1`: with ratios of 22, 44 and 83 they cost 5 %, 31 % and 151 % more operations than with 12, and 1 to
/// 2 % where nothing is eliminated.
const LONG: f64 = 20.0;

/// The sparsity of the Jacobian and the places of the diagonal entries of given rows.
#[derive(Debug)]
pub(super) struct Whole {
    pattern: Arc<Pattern>,
    diagonals: Vec<u32>,
}

/// The (v, p) system of condensed Newton: given unknowns and those inside of cells are left out.
#[derive(Debug)]
pub struct CondensedSystem {
    /// Sparsity of its matrix.
    pub pattern: Arc<Pattern>,
    /// Place in `[v, u, p]` of each of its unknowns.
    pub places: Vec<u32>,
    /// What the linear solver may know of them.
    pub unknowns: Vec<Unknown>,
}

impl<const D: usize> Assembler<D> {
    /// Sparsity of the Jacobian, all unknowns in the order v, u, p; found when first asked for.
    ///
    /// # Panics
    /// Where [`Assembler::try_pattern`] fails.
    pub fn pattern(&mut self) -> Arc<Pattern> {
        granted(self.try_pattern())
    }

    /// [`Assembler::pattern`] of a problem that may be too large.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if it has too many entries to be numbered.
    pub fn try_pattern(&mut self) -> Result<Arc<Pattern>, SolverError> {
        if let Some(whole) = &self.whole {
            return Ok(Arc::clone(&whole.pattern));
        }
        let mut number: Vec<u32> = (0..self.space.n_field_unknowns() as u32).collect();
        self.given.iter().for_each(|&row| number[row as usize] = DROP);
        let pattern = self.place(Matrix::Whole, &number, number.len(), &self.given.clone())?;
        let find =
            |row: u32| pattern.find(row as usize, row as usize).expect("given rows have a diagonal entry");
        let diagonals = self.given.iter().map(|&row| find(row) as u32).collect();
        self.whole = Some(Whole { pattern: Arc::clone(&pattern), diagonals });
        Ok(pattern)
    }

    /// The pattern of a matrix of `n` rows, where every operator remembers its entries; the rows `alone` have a diagonal
    /// entry.
    fn place(
        &mut self,
        matrix: Matrix,
        number: &[u32],
        n: usize,
        alone: &[u32],
    ) -> Result<Arc<Pattern>, SolverError> {
        let mut rows: Vec<Vec<u32>> = vec![vec![]; n];
        alone.iter().for_each(|&row| rows[row as usize].push(row));
        for operator in self.operators() {
            operator.entries(matrix, number, &mut |row, column| add_column(&mut rows[row as usize], column));
        }
        let mut directions = DirectedBlocks::new(&self.space, &self.constraints, number, &mut rows);
        let pattern = Arc::new(Pattern::from_rows(&rows));
        drop(rows);
        directions.place(&pattern);
        self.directions[matrix as usize] = directions;
        let find =
            |row: u32, column: u32| pattern.find(row as usize, column as usize).map_or(DROP, |at| at as u32);
        let entries = Entries { n: pattern.nnz(), find: &find };
        self.operators_mut().try_for_each(|operator| operator.place(matrix, number, &entries))?;
        Ok(pattern)
    }

    /// The Jacobian of [`Assembler::residual`] with respect to the new state, on [`Assembler::pattern`].
    pub fn jacobian(&mut self, step: &StepView<'_>, tangent: Tangent, out: &mut Csr) {
        self.matrix(step, Linearization::Newton, tangent, out);
    }

    /// The matrix of an iteration on [`Assembler::pattern`], in which derivatives that are left out are 0; that
    /// of `Condensed` is the reduced one here, before u is eliminated.
    pub fn matrix(
        &mut self,
        step: &StepView<'_>,
        linearization: Linearization,
        tangent: Tangent,
        out: &mut Csr,
    ) {
        let linearization = match linearization {
            Linearization::Condensed => Linearization::Reduced,
            other => other,
        };
        let how = How { linearization, tangent: sized(tangent, step) };
        self.pattern();
        out.values.fill(0.0);
        let mut sink = f64::sink(&mut out.values);
        for operator in self.operators_mut() {
            operator.linearise(Matrix::Whole, step, how, sink.again());
        }
        for &diagonal in self.whole.iter().flat_map(|whole| &whole.diagonals) {
            out.values[diagonal as usize] = 1.0;
        }
        self.constrain(out);
    }

    /// Let a matrix on [`Assembler::pattern`] hold the directions that boundaries do not let pass.
    pub fn constrain(&self, out: &mut Csr) {
        self.directions[Matrix::Whole as usize].constrain(out);
    }

    /// y ← A x with the Jacobian A of [`Assembler::residual`], without a matrix: `x` and `y` are `[v, u, p, s]`, and rows of
    /// given unknowns read y = x; y has nothing in the directions that boundaries do not let pass. `work` is overwritten.
    pub fn apply(&mut self, step: &StepView<'_>, x: &[f64], y: &mut [f64], work: &mut Vec<f64>) {
        self.product(Matrix::Whole, step, x, y, work);
    }

    /// The same with the matrix of (v, p) before unknowns inside of cells are eliminated: u = kθ v in the solid, and the
    /// domain of the fluid does not move. Rows of free u are 0. Equations of scalar unknowns take u of `x`.
    pub fn apply_condensed(&mut self, step: &StepView<'_>, x: &[f64], y: &mut [f64], work: &mut Vec<f64>) {
        self.product(Matrix::Condensed, step, x, y, work);
    }

    fn product(
        &mut self,
        matrix: Matrix,
        step: &StepView<'_>,
        x: &[f64],
        y: &mut [f64],
        work: &mut Vec<f64>,
    ) {
        work.clear();
        work.extend_from_slice(x);
        self.zero_given(work);
        y.fill(0.0);
        for operator in self.operators_mut() {
            operator.apply(matrix, step, work, y);
        }
        let mut borders = std::mem::take(&mut self.borders);
        self.borders(matrix, step, &mut borders);
        let first = self.space.n_field_unknowns();
        for border in borders.iter() {
            let product = border.product(work);
            match border.scalar {
                Some(scalar) => {
                    border.add_column(work[first + scalar], y);
                    y[first + scalar] = product + border.corner * work[first + scalar];
                }
                None => border.add_column(product, y),
            }
        }
        self.borders = borders;
        directions::project(&self.space, &self.constraints, y);
        self.given.iter().for_each(|&row| y[row as usize] = x[row as usize]);
    }

    /// The (v, p) system of condensed Newton, found when first asked for.
    ///
    /// # Panics
    /// Where [`Assembler::try_condensed`] fails.
    pub fn condensed(&mut self) -> Arc<CondensedSystem> {
        granted(self.try_condensed())
    }

    /// Eliminate unknowns inside of cells from the condensed matrix even where most cells are long.
    ///
    /// The slope of p along a cell of length L and width h, once eliminated, makes velocities stiff by (L/h)². Factors then
    /// find no pivots in their own fronts; multigrid relaxes what is left.
    pub fn eliminate_in_long_cells(&mut self, yes: bool) {
        if self.eliminates_in_long != yes {
            self.eliminates_in_long = yes;
            self.condensed = None;
        }
    }

    /// Whether most cells of a region that have slopes of p of their own are long: the median of the ratios of their sides is
    /// above [`LONG`].
    fn is_long(&self, body: Region) -> bool {
        let mesh = &self.space.mesh;
        let pressure = &self.space.pressure;
        if mesh.shape.is_simplex() || !matches!(pressure.kind, PressureKind::Pdc(_)) {
            return false;
        }
        let has_slopes = |cell: usize| self.space.regions[cell] == body && pressure.cell(cell).len() > 1;
        let cells = (0..mesh.n_cells()).filter(|&cell| has_slopes(cell) && self.space.owns_cell(cell));
        let mut ratios: Vec<f64> = cells
            .map(|cell| mesh.sizes(cell))
            .map(|sizes| {
                sizes.into_iter().fold(0.0, f64::max) / sizes.into_iter().fold(f64::INFINITY, f64::min)
            })
            .collect();
        if let Some(part) = &self.space.part {
            ratios = part.crew().lists(&ratios).unwrap_or_default().concat();
        }
        ratios.sort_unstable_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).is_some_and(|median| *median > LONG)
    }

    /// [`Assembler::condensed`] of a problem that may be too large.
    ///
    /// # Errors
    /// [`SolverError::TooLarge`] if it has too many entries to be numbered.
    pub fn try_condensed(&mut self) -> Result<Arc<CondensedSystem>, SolverError> {
        if let Some(system) = &self.condensed {
            return Ok(Arc::clone(system));
        }
        self.blocks = Blocks::of(&self.terms);
        let n = self.space.n_field_unknowns();
        let mut number = vec![0; n];
        number[self.space.n_v()..self.space.n_v() + self.space.n_u()].fill(DROP);
        self.given.iter().for_each(|&place| number[place as usize] = DROP);
        let keeps: Vec<bool> =
            self.regions.iter().map(|r| !self.eliminates_in_long && self.is_long(r.body())).collect();
        for (region, keeps) in self.regions.iter_mut().zip(keeps) {
            let body = region.body();
            let spans = self.terms.iter().any(|term| term.body() == body && term.spans_cells());
            let eliminate = !spans && !keeps;
            region.prepare_condensed(&self.space, &self.blocks, eliminate);
            region.inner(&mut |place| number[place as usize] = DROP);
        }
        let all = self.unknowns();
        let (mut places, mut unknowns) = (vec![], vec![]);
        for place in 0..n {
            if number[place] != DROP {
                number[place] = places.len() as u32;
                places.push(place as u32);
                unknowns.push(all[place]);
            }
        }
        let pattern = self.place(Matrix::Condensed, &number, places.len(), &[])?;
        let system = Arc::new(CondensedSystem { pattern, places, unknowns });
        self.condensed = Some(Arc::clone(&system));
        Ok(system)
    }

    /// The matrix of [`Assembler::condensed`]; the factors of the inner blocks are kept.
    ///
    /// # Panics
    /// If the system was not asked for before.
    pub fn condensed_matrix<T: Value>(&mut self, step: &StepView<'_>, tangent: Tangent, out: &mut Csr<T>) {
        assert!(self.condensed.is_some(), "the condensed system is asked for first");
        out.values.fill(T::default());
        let mut sink = T::sink(&mut out.values);
        let how = How { linearization: Linearization::Condensed, tangent: sized(tangent, step) };
        self.blocks.fill(&mut self.terms, step, how);
        for region in &mut self.regions {
            region.condense(step, how.tangent, &self.blocks, sink.again());
        }
        for term in &mut self.terms {
            term.linearise(Matrix::Condensed, step, how, sink.again());
        }
        self.directions[Matrix::Condensed as usize].constrain(out);
    }

    /// Forward elimination of the unknowns inside of cells from a right-hand side `[v, u, p]`.
    pub fn eliminate_inner(&mut self, b: &mut [f64]) {
        self.regions.iter_mut().for_each(|region| region.eliminate(b));
    }

    /// The unknowns inside of cells of a solution `[v, u, p]` whose others are known.
    pub fn recover_inner(&self, x: &mut [f64]) {
        self.regions.iter().for_each(|region| region.recover(x));
    }
}

/// The same with the sizes of the fields of the iterate, which differences need.
fn sized(tangent: Tangent, step: &StepView<'_>) -> Tangent {
    match tangent {
        Tangent::Difference(by) => {
            let sizes = Sizes::of([&step.new.v, &step.new.u, &step.new.p]);
            Tangent::Difference(Difference { sizes, ..by })
        }
        other => other,
    }
}
