//! A system of PETSc with what belongs to it here: the places of its entries, and the scales of its fields.

use super::access::Access;
use super::calls::Indices;
use super::counted::Counted;
use super::error::Trouble;
use super::fields::{FieldScales, Layout, failure};
use super::system::{Place, Rows, System};
use crate::algebra::{Csr, Kind, Pattern, Sizes, SolverError, Unknown};
use crate::parallel::{Halo, Reduce};
use std::sync::Arc;

/// How many times the residual may be what an iteration is asked for: it may measure it in another norm.
const SLACK: f64 = 10.0;

#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) system: System,
    rows: Layout,
    pub(super) counted: Counted,
    pub(super) scales: FieldScales,
    /// Whether it solves without an iteration.
    pub(super) is_direct: bool,
    /// Relative reduction of the residual that an iteration is asked for.
    pub(super) tolerance: f64,
}

/// The fields of a system, with the names that they have for `fieldsplit`.
const FIELDS: [(&str, Kind); 3] = [("v", Kind::Velocity), ("u", Kind::Deformation), ("p", Kind::Pressure)];

/// The unknowns of each field that there is, those among `rows` by their numbers in PETSc. A process may have none of a
/// field that others have: all make the same calls.
fn blocks(
    unknowns: &[Unknown],
    rows: &[u32],
    (bits, number): (usize, &dyn Fn(usize) -> usize),
    counted: &Counted,
) -> Option<Vec<(&'static str, Indices)>> {
    let mut there =
        FIELDS.map(|(_, kind)| f64::from(u8::from(unknowns.iter().any(|unknown| unknown.kind == kind))));
    counted.reduce(Reduce::Max, &mut there);
    let of = |kind: Kind| {
        let own = rows.iter().map(|&row| row as usize).filter(|&row| unknowns[row].kind == kind);
        Indices::new(bits, own.map(number))
    };
    let there = FIELDS.into_iter().zip(there).filter(|(_, there)| *there > 0.0);
    there.map(|((name, kind), _)| Some((name, of(kind)?))).collect()
}

impl Prepared {
    /// For matrices of `pattern`, by `options`. Where processes share the unknowns, `halo` says how; else each has all of
    /// them, and hands its share of the rows over.
    pub(super) fn new(
        access: &Access,
        options: &str,
        pattern: &Pattern,
        unknowns: &[Unknown],
        halo: Option<Arc<Halo>>,
    ) -> Result<Prepared, Trouble> {
        let bits = access.engine.index_bits;
        let counted = Counted::new(pattern.n, halo.clone());
        let own = match &halo {
            Some(halo) => halo.own().to_vec(),
            None => access.share.of(pattern.n).map(|row| row as u32).collect(),
        };
        let number = |i: usize| halo.as_ref().map_or(i, |halo| halo.number(i));
        let (rows, columns) = Layout::new(pattern, own, number);
        let columns = Indices::new(bits, columns.into_iter());
        let starts = Indices::new(bits, rows.starts().iter().copied());
        let blocks = blocks(unknowns, rows.rows(), (bits, &number), &counted);
        let fit = columns.is_some() && starts.is_some() && blocks.is_some();
        let (Some(columns), Some(starts), Some(blocks), false) = (columns, starts, blocks, counted.any(!fit))
        else {
            let entries = pattern.nnz();
            let message = format!("{entries} entries are too many for its integers of {bits} bits");
            return Err(Trouble::plain(message));
        };
        let place =
            Place { rows: rows.rows().to_vec(), n: halo.as_ref().map_or(pattern.n, |h| h.total()), halo };
        let system = System::new(access, place, &Rows { starts, columns }, options)?;
        let (scales, tolerance) = (FieldScales::default(), 0.0);
        let mut prepared = Prepared { system, rows, counted, scales, is_direct: false, tolerance };
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
        self.scales.update(a, unknowns, sizes, &self.counted)
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
