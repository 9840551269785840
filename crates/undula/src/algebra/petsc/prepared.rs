//! A system of PETSc with what belongs to it here: the places of its entries, and the scales of its fields.

use super::access::Access;
use super::calls::Indices;
use super::error::Trouble;
use super::fields::{FieldScales, Layout, failure};
use super::system::{Rows, System};
use crate::algebra::{Csr, Kind, Pattern, Sizes, SolverError, Unknown};
use std::ops::Range;

/// How many times the residual may be what an iteration is asked for: it may measure it in another norm.
const SLACK: f64 = 10.0;

#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) system: System,
    rows: Layout,
    pub(super) scales: FieldScales,
    /// Whether it solves without an iteration.
    pub(super) is_direct: bool,
    /// Relative reduction of the residual that an iteration is asked for.
    pub(super) tolerance: f64,
}

/// The unknowns of each field that there is, those among `rows`, with the name that it has for `fieldsplit`. A process
/// may have none of a field that others have: all make the same calls.
fn blocks(unknowns: &[Unknown], rows: Range<usize>, bits: usize) -> Option<Vec<(&'static str, Indices)>> {
    let of = |kind: Kind| Indices::new(bits, rows.clone().filter(|&i| unknowns[i].kind == kind));
    let named = [("v", Kind::Velocity), ("u", Kind::Deformation), ("p", Kind::Pressure)];
    let there = named.into_iter().filter(|(_, kind)| unknowns.iter().any(|unknown| unknown.kind == *kind));
    there.map(|(name, kind)| Some((name, of(kind)?))).collect()
}

impl Prepared {
    /// For matrices of `pattern`, by `options`.
    pub(super) fn new(
        access: &Access,
        options: &str,
        pattern: &Pattern,
        unknowns: &[Unknown],
    ) -> Result<Prepared, Trouble> {
        let bits = access.engine.index_bits;
        let too_large = || {
            let entries = pattern.nnz();
            Trouble::plain(format!("{entries} entries are too many for its integers of {bits} bits"))
        };
        let rows = Layout::new(pattern, access.share.of(pattern.n));
        let starts = Indices::new(bits, rows.starts().iter().copied()).ok_or_else(too_large)?;
        let columns = Indices::new(bits, rows.columns(pattern)).ok_or_else(too_large)?;
        let blocks = blocks(unknowns, rows.rows(), bits).ok_or_else(too_large)?;
        let place = (rows.rows(), pattern.n);
        let system = System::new(access, place, &Rows { starts, columns }, options)?;
        let (scales, tolerance) = (FieldScales::default(), 0.0);
        let mut prepared = Prepared { system, rows, scales, is_direct: false, tolerance };
        match prepared.configure(access, &blocks) {
            Ok(()) => Ok(prepared),
            Err(trouble) => {
                prepared.system.destroy(access);
                Err(trouble)
            }
        }
    }

    fn configure(&mut self, access: &Access, blocks: &[(&str, Indices)]) -> Result<(), Trouble> {
        self.system.configure(access, blocks)?;
        self.is_direct = self.system.types(access)?[0] == "preonly";
        self.tolerance = self.system.tolerance(access)?;
        Ok(())
    }

    /// Largest reduction of the residual that counts as converged; zero where nothing iterates.
    pub(super) fn allowed(&self) -> f64 {
        if self.is_direct { 0.0 } else { SLACK * self.tolerance }
    }

    /// Finds the scales of `a`.
    pub(super) fn scale(&mut self, a: &Csr, unknowns: &[Unknown], sizes: Sizes) -> Result<(), SolverError> {
        self.scales.update(a, unknowns, sizes)
    }

    /// Hands the entries of `a` over, scaled, and makes the preconditioner; why that failed, if it has.
    pub(super) fn set(
        &self,
        access: &Access,
        a: &Csr,
        unknowns: &[Unknown],
    ) -> Result<Option<&'static str>, Trouble> {
        let factor = |row: usize, column: usize| self.scales.of(unknowns, row, column);
        self.system.set_values(access, |values| self.rows.write(a, factor, values))?;
        self.system.set_up(access)?;
        self.system.failure(access).map(failure)
    }
}
