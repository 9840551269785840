//! A matrix in PETSc, and its solver made from a string of options. All calls are made while `Access` is held.
#![allow(unsafe_code)]

use super::access::Access;
use super::calls::{Indices, call};
use super::error::Trouble;
use crate::parallel::Halo;
use crate::parallel::library::{Object, text_of};
use std::ffi::CString;
use std::ptr::{null, null_mut};
use std::slice;
use std::sync::Arc;

/// Matrix, solver and two vectors, with a database of options of their own.
#[derive(Debug)]
pub(super) struct System {
    place: Place,
    entries: usize,
    options: Object,
    matrix: Object,
    solver: Object,
    right: Object,
    left: Object,
    /// Whether there are several processes.
    several: bool,
    /// Where each of several processes has all unknowns.
    shared: Option<Shared>,
}

/// The rows of a system that this process hands over.
#[derive(Debug)]
pub(super) struct Place {
    /// Which of ours.
    pub(super) rows: Vec<u32>,
    /// How many all processes have.
    pub(super) n: usize,
    /// Where processes share the unknowns.
    pub(super) halo: Option<Arc<Halo>>,
}

/// What brings the parts of several processes together.
#[derive(Debug)]
struct Shared {
    /// Brings a vector to all processes.
    scatter: Object,
    /// The whole of it.
    whole: Object,
    n: usize,
}

/// How a solve went, as PETSc sees it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Outcome {
    /// Positive where PETSc calls it converged.
    pub(super) reason: i32,
    pub(super) iterations: i64,
    /// Why the preconditioner failed; 0: it did not.
    pub(super) failure: i32,
}

/// Rows of a matrix with the columns of each, all columns sorted, and an entry on every diagonal.
pub(super) struct Rows {
    pub(super) starts: Indices,
    pub(super) columns: Indices,
}

impl System {
    /// With the options of a string; the values of the matrix are zero. `place` are the rows of this process.
    ///
    /// # Errors
    /// What PETSc refuses. What was made until then stays in memory.
    pub(super) fn new(access: &Access, place: Place, rows: &Rows, options: &str) -> Result<System, Trouble> {
        let (petsc, world) = (&access.engine.petsc, access.world);
        let entries = rows.columns.len();
        let [mut database, mut matrix, mut solver, mut right, mut left] = [Object::NONE; 5];
        call!(petsc, PetscOptionsCreate(&raw mut database))?;
        let text = CString::new(options).unwrap_or_default();
        call!(petsc, PetscOptionsInsertString(database, text.as_ptr()))?;
        let [local, size] = [place.rows.len() as i64, place.n as i64];
        call!(petsc, MatCreate(world, &raw mut matrix))?;
        call!(petsc, MatSetSizes(matrix, local, local, size, size))?;
        // Sequential on one process, else distributed by rows: of the two calls one has no effect.
        call!(petsc, MatSetType(matrix, c"aij".as_ptr()))?;
        let (starts, columns) = (rows.starts.at(), rows.columns.at());
        call!(petsc, MatSeqAIJSetPreallocationCSR(matrix, starts, columns, null()))?;
        call!(petsc, MatMPIAIJSetPreallocationCSR(matrix, starts, columns, null()))?;
        call!(petsc, MatCreateVecs(matrix, &raw mut right, &raw mut left))?;
        call!(petsc, KSPCreate(world, &raw mut solver))?;
        let several = access.share.size > 1;
        let shared = match place.halo {
            None if several => Some(Shared::new(access, right, place.n)?),
            _ => None,
        };
        Ok(System { place, entries, options: database, matrix, solver, right, left, several, shared })
    }

    /// Does something with the options of this system in force, and no others.
    fn with_options<T>(
        &self,
        access: &Access,
        act: impl FnOnce() -> Result<T, Trouble>,
    ) -> Result<T, Trouble> {
        let petsc = &access.engine.petsc;
        call!(petsc, PetscOptionsPush(self.options))?;
        let result = act();
        call!(petsc, PetscOptionsPop())?;
        result
    }

    /// Makes the solver what the options say; blocks of unknowns have names for `fieldsplit`.
    pub(super) fn configure(&self, access: &Access, blocks: &[(&str, Indices)]) -> Result<(), Trouble> {
        const COPY: i32 = 0;
        let petsc = &access.engine.petsc;
        self.with_options(access, || {
            call!(petsc, KSPSetOperators(self.solver, self.matrix, self.matrix))?;
            call!(petsc, KSPSetFromOptions(self.solver))?;
            let preconditioner = self.preconditioner(access)?;
            for (name, indices) in blocks {
                let mut set = Object::NONE;
                let (name, length) = (CString::new(*name).unwrap_or_default(), indices.len() as i64);
                call!(petsc, ISCreateGeneral(access.world, length, indices.at(), COPY, &raw mut set))?;
                // Without effect on other preconditioners.
                call!(petsc, PCFieldSplitSetIS(preconditioner, name.as_ptr(), set))?;
                call!(petsc, ISDestroy(&raw mut set))?;
            }
            Ok(())
        })
    }

    fn preconditioner(&self, access: &Access) -> Result<Object, Trouble> {
        let mut preconditioner = Object::NONE;
        call!(access.engine.petsc, KSPGetPC(self.solver, &raw mut preconditioner))?;
        Ok(preconditioner)
    }

    /// New values of the matrix, which `write` sets in the order of its entries.
    pub(super) fn set_values(&self, access: &Access, write: impl FnOnce(&mut [f64])) -> Result<(), Trouble> {
        let (petsc, mut values) = (&access.engine.petsc, null_mut());
        if self.several {
            // Given back before factors are made: they would stand beside them for nothing.
            let mut values = vec![0.0; self.entries];
            write(&mut values);
            return call!(petsc, MatUpdateMPIAIJWithArray(self.matrix, values.as_ptr()));
        }
        call!(petsc, MatSeqAIJGetArray(self.matrix, &raw mut values))?;
        // SAFETY: the values of the matrix, as many as it has entries, until they are given back.
        write(unsafe { slice::from_raw_parts_mut(values, self.entries) });
        call!(petsc, MatSeqAIJRestoreArray(self.matrix, &raw mut values))
    }

    /// Factors, hierarchies, and what else the options ask for.
    pub(super) fn set_up(&self, access: &Access) -> Result<(), Trouble> {
        let petsc = &access.engine.petsc;
        self.with_options(access, || {
            // Tells that the values are new.
            call!(petsc, KSPSetOperators(self.solver, self.matrix, self.matrix))?;
            call!(petsc, KSPSetUp(self.solver))?;
            call!(petsc, KSPSetUpOnBlocks(self.solver))
        })
    }

    /// Applies the preconditioner once, to ones: solvers within it are made then.
    pub(super) fn precondition(&self, access: &Access) -> Result<(), Trouble> {
        let petsc = &access.engine.petsc;
        let preconditioner = self.preconditioner(access)?;
        self.in_vector(access, self.left, |values| values.fill(1.0))?;
        self.with_options(access, || call!(petsc, PCApply(preconditioner, self.left, self.right)))
    }

    /// x ← A⁻¹ b, as well as the options ask for: on all processes the same, or its own unknowns and copies of others.
    pub(super) fn solve(&self, access: &Access, b: &[f64], x: &mut [f64]) -> Result<Outcome, Trouble> {
        debug_assert_eq!(b.len(), x.len(), "vectors do not fit the matrix");
        let petsc = &access.engine.petsc;
        let own = || self.place.rows.iter().map(|&row| row as usize);
        self.in_vector(access, self.left, |values| {
            values.iter_mut().zip(own()).for_each(|(v, i)| *v = b[i])
        })?;
        self.with_options(access, || call!(petsc, KSPSolve(self.solver, self.left, self.right)))?;
        match &self.shared {
            None => {
                self.in_vector(access, self.right, |values| {
                    values.iter().zip(own()).for_each(|(v, i)| x[i] = *v)
                })?;
                self.place.halo.iter().for_each(|halo| halo.update(x));
            }
            Some(shared) => shared.gather(access, self.right, x)?,
        }
        self.outcome(access)
    }

    /// What has become of the last solve.
    fn outcome(&self, access: &Access) -> Result<Outcome, Trouble> {
        let (petsc, mut outcome) = (&access.engine.petsc, Outcome { reason: 0, iterations: 0, failure: 0 });
        call!(petsc, KSPGetConvergedReason(self.solver, &raw mut outcome.reason))?;
        call!(petsc, KSPGetIterationNumber(self.solver, &raw mut outcome.iterations))?;
        outcome.failure = self.failure(access)?;
        Ok(outcome)
    }

    /// Why the preconditioner failed; 0: it did not.
    pub(super) fn failure(&self, access: &Access) -> Result<i32, Trouble> {
        let mut failure = 0;
        call!(access.engine.petsc, PCGetFailedReason(self.preconditioner(access)?, &raw mut failure))?;
        Ok(failure)
    }

    fn in_vector(
        &self,
        access: &Access,
        vector: Object,
        act: impl FnOnce(&mut [f64]),
    ) -> Result<(), Trouble> {
        in_vector(access, vector, self.place.rows.len(), act)
    }

    /// Types of the iteration and of the preconditioner, such as `preonly` and `lu`.
    pub(super) fn types(&self, access: &Access) -> Result<[String; 2], Trouble> {
        let (petsc, mut of_solver, mut of_preconditioner) = (&access.engine.petsc, null(), null());
        let preconditioner = self.preconditioner(access)?;
        call!(petsc, KSPGetType(self.solver, &raw mut of_solver))?;
        call!(petsc, PCGetType(preconditioner, &raw mut of_preconditioner))?;
        // SAFETY: null, or names that live as long as the objects.
        Ok([of_solver, of_preconditioner].map(|name| unsafe { text_of(name) }))
    }

    /// Relative reduction of the residual that the solver is asked for.
    pub(super) fn tolerance(&self, access: &Access) -> Result<f64, Trouble> {
        let ([mut relative, mut absolute, mut divergence], mut most) = ([0.0; 3], 0);
        let petsc = &access.engine.petsc;
        call!(
            petsc,
            KSPGetTolerances(
                self.solver,
                &raw mut relative,
                &raw mut absolute,
                &raw mut divergence,
                &raw mut most
            )
        )?;
        Ok(relative)
    }

    /// Options that nothing has asked for so far, without their `-`.
    pub(super) fn unused(&self, access: &Access) -> Result<Vec<String>, Trouble> {
        let (petsc, mut count, mut names, mut values) = (&access.engine.petsc, 0, null_mut(), null_mut());
        let list = (&raw mut count, &raw mut names, &raw mut values);
        call!(petsc, PetscOptionsLeftGet(self.options, list.0, list.1, list.2))?;
        let count_found = usize::try_from(count).unwrap_or(0);
        // SAFETY: an array of so many strings, until it is given back.
        let found = (0..count_found).map(|i| unsafe { text_of(*names.add(i)) }).collect();
        let list = (&raw mut count, &raw mut names, &raw mut values);
        call!(petsc, PetscOptionsLeftRestore(self.options, list.0, list.1, list.2))?;
        Ok(found)
    }

    /// Gives its memory back.
    pub(super) fn destroy(mut self, access: &Access) {
        let petsc = &access.engine.petsc;
        // Nobody is left to be told of what fails here.
        if let Some(shared) = &mut self.shared {
            let _: Result<(), Trouble> = call!(petsc, VecScatterDestroy(&raw mut shared.scatter));
            let _: Result<(), Trouble> = call!(petsc, VecDestroy(&raw mut shared.whole));
        }
        let _: Result<(), Trouble> = call!(petsc, KSPDestroy(&raw mut self.solver));
        let _: Result<(), Trouble> = call!(petsc, VecDestroy(&raw mut self.left));
        let _: Result<(), Trouble> = call!(petsc, VecDestroy(&raw mut self.right));
        let _: Result<(), Trouble> = call!(petsc, MatDestroy(&raw mut self.matrix));
        let _: Result<(), Trouble> = call!(petsc, PetscOptionsDestroy(&raw mut self.options));
    }
}

impl Shared {
    /// For vectors like `vector`, of `n` numbers.
    fn new(access: &Access, vector: Object, n: usize) -> Result<Shared, Trouble> {
        let [mut scatter, mut whole] = [Object::NONE; 2];
        call!(access.engine.petsc, VecScatterCreateToAll(vector, &raw mut scatter, &raw mut whole))?;
        Ok(Shared { scatter, whole, n })
    }

    /// `values` ← all of `vector`, on every process.
    fn gather(&self, access: &Access, vector: Object, values: &mut [f64]) -> Result<(), Trouble> {
        const INSERT: i32 = 1;
        const FORWARD: i32 = 0;
        let petsc = &access.engine.petsc;
        call!(petsc, VecScatterBegin(self.scatter, vector, self.whole, INSERT, FORWARD))?;
        call!(petsc, VecScatterEnd(self.scatter, vector, self.whole, INSERT, FORWARD))?;
        in_vector(access, self.whole, self.n, |whole| values.copy_from_slice(whole))
    }
}

/// Does something with the `n` numbers that this process has of a vector.
fn in_vector(access: &Access, vector: Object, n: usize, act: impl FnOnce(&mut [f64])) -> Result<(), Trouble> {
    let (petsc, mut values) = (&access.engine.petsc, null_mut());
    call!(petsc, VecGetArray(vector, &raw mut values))?;
    // SAFETY: the values of a vector of this length, until they are given back. A vector without any may have no array.
    act(if n == 0 { &mut [] } else { unsafe { slice::from_raw_parts_mut(values, n) } });
    call!(petsc, VecRestoreArray(vector, &raw mut values))
}
