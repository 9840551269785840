//! Sparse LU of the faer library.

use super::direct::Failure;
use super::{Backend, Cost, Csr, Direct, Options, Pattern, Scaling, SolverError, Unknown};
use ::faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use ::faer::sparse::linalg::LuError;
use ::faer::sparse::linalg::lu::{LuRef, NumericLu, SymbolicLu, factorize_symbolic_lu};
use ::faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMatRef};
use ::faer::{Conj, MatMut, Par};
use std::sync::Arc;

/// Supernodal LU of faer with COLAMD ordering and partial pivoting, always sequential.
pub type FaerLu = Direct<FaerBackend>;

impl FaerLu {
    /// A solver that knows no matrix yet.
    pub fn faer(options: Options) -> Self {
        Self::new(FaerBackend::default(), options)
    }
}

/// Backend of [`FaerLu`]. The rows of A are taken for the columns of Aᵀ, so nothing is transposed:
/// Aᵀ is factored and the transposed system solved.
#[derive(Default)]
pub struct FaerBackend {
    row_ptr: Vec<usize>,
    col: Vec<usize>,
    values: Vec<f64>,
    symbolic: Option<SymbolicLu<usize>>,
    numeric: NumericLu<usize, f64>,
    memory: Option<MemBuffer>,
}

impl std::fmt::Debug for FaerBackend {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("FaerBackend").field("nnz", &self.col.len()).finish_non_exhaustive()
    }
}

impl Backend for FaerBackend {
    fn name(&self) -> &'static str {
        "faer"
    }

    fn analyse(&mut self, pattern: &Arc<Pattern>, _: &[Unknown]) -> Result<(), SolverError> {
        let n = pattern.n;
        self.row_ptr.clone_from(&pattern.row_ptr);
        self.col = pattern.all_columns().map(|j| j as usize).collect();
        self.numeric = NumericLu::new();
        let transposed = SymbolicSparseColMatRef::new_checked(n, n, &self.row_ptr, None, &self.col);
        let memory = |e: FaerError| SolverError::Memory(e.to_string());
        let symbolic = factorize_symbolic_lu(transposed, Default::default()).map_err(memory)?;
        let request = StackReq::or(
            symbolic.factorize_numeric_lu_scratch::<f64>(Par::Seq, Default::default()),
            symbolic.solve_transpose_in_place_scratch::<f64>(1, Par::Seq),
        );
        self.memory = Some(MemBuffer::try_new(request).map_err(|e| memory(e.into()))?);
        self.symbolic = Some(symbolic);
        Ok(())
    }

    fn factor(&mut self, a: &Csr, scaling: &Scaling) -> Result<Cost, Failure> {
        let Self { row_ptr, col, values, symbolic: Some(symbolic), numeric, memory: Some(memory) } = self
        else {
            return Err(Failure::Memory("factor before analyse".into()));
        };
        values.clear();
        for i in 0..a.pattern.n {
            let (at, r) = (a.pattern.row(i), scaling.row[i]);
            let scaled = a.values[at.clone()].iter().zip(&col[at]).map(|(v, &j)| v * r * scaling.col[j]);
            values.extend(scaled);
        }
        let n = a.pattern.n;
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, row_ptr, None, col);
        let transposed = SparseColMatRef::new(pattern, values);
        let stack = MemStack::new(memory);
        match symbolic.factorize_numeric_lu(numeric, transposed, Par::Seq, stack, Default::default()) {
            Ok(_) => Ok(Cost::default()),
            // The columns of the factored matrix are the rows of A.
            Err(LuError::SymbolicSingular { index }) => {
                let (row_of, _) = symbolic.col_perm().arrays();
                Err(Failure::ZeroPivot(row_of.get(index).copied().unwrap_or(0)))
            }
            Err(LuError::Generic(e)) => Err(Failure::Memory(e.to_string())),
        }
    }

    fn solve(&mut self, y: &mut [f64]) {
        if let (Some(symbolic), Some(memory)) = (&self.symbolic, &mut self.memory) {
            let n = y.len();
            LuRef::new_unchecked(symbolic, &self.numeric).solve_transpose_in_place_with_conj(
                Conj::No,
                MatMut::from_column_major_slice_mut(y, n, 1),
                Par::Seq,
                MemStack::new(memory),
            );
        }
    }
}
