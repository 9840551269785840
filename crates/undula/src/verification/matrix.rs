//! What the coupled matrix (5.35) is like: entries of its blocks, symmetry, diagonal, and what plain LU makes of it.

use super::stability::whole_jacobian;
use crate::algebra::{Backend, Csr, FaerBackend, Scaling, SolverError};
use crate::simulation::Simulation;
use crate::space::{FsiSpace, PsiOwner, Region};

/// Rows of blocks of (5.35), by test functions; the columns q, z_f, w_f, z_i, w_i, z_s, w_s stand in the same order.
pub const ROWS: [&str; 7] = ["xi", "phi_f", "psi_f", "phi_i", "psi_i", "phi_s", "psi_s"];

/// Columns of blocks of (5.35): p, then v and u in the fluid, on the interface, in the solid.
pub const COLUMNS: [&str; 7] = ["q", "z_f", "w_f", "z_i", "w_i", "z_s", "w_s"];

/// The coupled matrix without rows and columns of given values.
#[derive(Clone, Debug, PartialEq)]
pub struct Portrait {
    /// Entries that are not zero, by row and column of [`ROWS`] and [`COLUMNS`].
    pub entries: [[usize; 7]; 7],
    /// Unknowns of each column of blocks.
    pub unknowns: [usize; 7],
    /// ‖A − Aᵀ‖/‖A‖ in the Frobenius norm, after its rows and columns have been brought to one size.
    pub asymmetry: f64,
    /// Rows whose diagonal entry is zero, so that A is not definite.
    pub zero_diagonal: usize,
    /// Part of the rows with |a_ii| ≥ Σ |a_ij|, j ≠ i.
    pub dominant: f64,
    /// max |x − 1| of the solution by sparse LU with partial pivoting and without scaling or refinement, where
    /// all x are 1; infinite where LU fails.
    pub plain_lu_error: f64,
}

/// The matrix of the next step of `simulation` at its present state, or of the stationary problem.
///
/// # Errors
/// If memory is short, or the problem too large.
pub fn portrait<const D: usize>(simulation: &mut Simulation<D>) -> Result<Portrait, SolverError> {
    let matrix = whole_jacobian(simulation)?;
    let assembler = &simulation.stepper.assembler;
    let given = assembler.is_given();
    let groups = groups(&assembler.space);
    let (mut entries, mut unknowns) = ([[0; 7]; 7], [0; 7]);
    let (mut zero_diagonal, mut dominant, mut rows) = (0, 0, 0usize);
    for row in (0..matrix.pattern.n).filter(|&row| !given[row]) {
        unknowns[groups[row]] += 1;
        rows += 1;
        let (mut diagonal, mut others) = (0.0, 0.0);
        for at in matrix.pattern.row(row) {
            let (col, value) = (matrix.pattern.column(row, at) as usize, matrix.values[at]);
            if value == 0.0 || given[col] {
                continue;
            }
            entries[groups[row]][groups[col]] += 1;
            if col == row {
                diagonal = value.abs();
            } else {
                others += value.abs();
            }
        }
        zero_diagonal += usize::from(diagonal == 0.0);
        dominant += usize::from(diagonal > 0.0 && diagonal >= others);
    }
    let mut scaling = Scaling::default();
    scaling.update(&matrix, &assembler.unknowns())?;
    Ok(Portrait {
        entries,
        unknowns,
        asymmetry: asymmetry(&matrix, &scaling, &given),
        zero_diagonal,
        dominant: dominant as f64 / rows.max(1) as f64,
        plain_lu_error: plain_lu_error(&matrix)?,
    })
}

/// Number of the block of every unknown, and of the row with the same number.
fn groups<const D: usize>(space: &FsiSpace<D>) -> Vec<usize> {
    let mut in_fluid = vec![false; space.nodes.len()];
    for cell in (0..space.mesh.n_cells()).filter(|&cell| space.regions[cell] == Region::Fluid) {
        space.nodes.cell(cell).iter().for_each(|&node| in_fluid[node as usize] = true);
    }
    let place = |node: usize| match (in_fluid[node], space.owner[node] == PsiOwner::Relation) {
        (_, false) => 1,
        (true, true) => 3,
        (false, true) => 5,
    };
    let mut list: Vec<usize> = (0..space.n_v()).map(|i| place(i / D)).collect();
    list.extend((0..space.n_u()).map(|i| place(i / D) + 1));
    list.resize(space.n_field_unknowns(), 0);
    list
}

fn asymmetry(a: &Csr, scaling: &Scaling, given: &[bool]) -> f64 {
    let (mut gaps, mut squares) = (0.0, 0.0);
    let scaled = |row: usize, col: usize, value: f64| value * scaling.row[row] * scaling.col[col];
    for row in (0..a.pattern.n).filter(|&row| !given[row]) {
        for at in a.pattern.row(row) {
            let col = a.pattern.column(row, at) as usize;
            if given[col] {
                continue;
            }
            let value = scaled(row, col, a.values[at]);
            let across = a.pattern.find(col, row).map_or(0.0, |at| scaled(col, row, a.values[at]));
            gaps += (value - across).powi(2);
            squares += value.powi(2);
        }
    }
    (gaps / squares).sqrt()
}

fn plain_lu_error(a: &Csr) -> Result<f64, SolverError> {
    let n = a.pattern.n;
    let mut backend = FaerBackend::default();
    backend.analyse(&a.pattern, &[])?;
    let (ones, mut x) = (vec![1.0; n], vec![0.0; n]);
    let mut plain = Scaling::default();
    (plain.row, plain.col) = (ones.clone(), ones.clone());
    if backend.factor(a, &plain).is_err() {
        return Ok(f64::INFINITY);
    }
    a.mul(&ones, &mut x);
    backend.solve(&mut x);
    let error = x.iter().fold(0.0f64, |error, x| error.max((x - 1.0).abs()));
    Ok(if x.iter().all(|x| x.is_finite()) { error } else { f64::INFINITY })
}
