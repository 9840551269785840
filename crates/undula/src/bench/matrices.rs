//! Matrices of a step as files, for measurements of linear solvers alone.

use crate::algebra::{Csr, Kind, Unknown};
use crate::error::Error;
use crate::output::{OutputError, write_atomic};
use crate::simulation::Simulation;
use crate::system::StepView;
use crate::tangent::Tangent;
use std::io::{self, Write};
use std::path::Path;

/// Beyond this the whole Jacobian is left out: it would take several GiB.
const LARGEST_JACOBIAN: usize = 2_000_000;

/// Write `condensed.bin`, `extension.bin` and `newton.bin` into `directory`, in the format that
/// `benches/factor.rs` reads: little endian u64 n, u64 nnz, row_ptr u64\[n + 1\], col u32\[nnz\], values f64\[nnz\],
/// right-hand side A·1 f64\[n\], node u32\[n\], kind u8\[n\] (0 v, 1 u, 2 p), xyz f64\[3 n\].
///
/// # Errors
/// Without time steps, or if a file cannot be written.
pub fn write_matrices<const D: usize>(simulation: &mut Simulation<D>, directory: &Path) -> Result<(), Error> {
    let name = simulation.case.name.clone();
    let time = simulation.case.time.as_ref().ok_or(Error::Stationary(name))?;
    let k = time.step.eval(&[0.0; 3], simulation.stepper.time);
    std::fs::create_dir_all(directory).map_err(OutputError::io("create", directory))?;
    simulation.install(|simulation| {
        let stepper = &mut simulation.stepper;
        let rule = stepper.settings.scheme.rule(k);
        let (assembler, new, old) = (&mut stepper.assembler, &stepper.new, &stepper.old);
        let view = StepView { rule, new, old };
        let system = assembler.try_condensed()?;
        let mut matrix = Csr::zeros(&system.pattern);
        assembler.condensed_matrix(&view, Tangent::Analytic, &mut matrix);
        write(&directory.join("condensed.bin"), &matrix, &system.unknowns)?;
        let all = assembler.unknowns();
        if let Some(extension) = assembler.extension(&view) {
            let unknowns: Vec<Unknown> = extension.places.iter().map(|&at| all[at as usize]).collect();
            write(&directory.join("extension.bin"), &extension.matrix, &unknowns)?;
        }
        if all.len() <= LARGEST_JACOBIAN {
            let mut matrix = Csr::zeros(&assembler.try_pattern()?);
            assembler.jacobian(&view, Tangent::Analytic, &mut matrix);
            write(&directory.join("newton.bin"), &matrix, &all)?;
        }
        Ok(())
    })
}

fn write(path: &Path, matrix: &Csr, unknowns: &[Unknown]) -> Result<(), Error> {
    let mut product = vec![0.0; unknowns.len()];
    matrix.mul(&vec![1.0; unknowns.len()], &mut product);
    write_atomic(path, |file| put(&mut io::BufWriter::new(file), matrix, &product, unknowns))?;
    Ok(())
}

fn put(file: &mut impl Write, matrix: &Csr, b: &[f64], unknowns: &[Unknown]) -> io::Result<()> {
    let pattern = &matrix.pattern;
    let head = [pattern.n, pattern.nnz()];
    for number in head.iter().chain(&pattern.row_ptr) {
        file.write_all(&(*number as u64).to_le_bytes())?;
    }
    for col in pattern.all_columns() {
        file.write_all(&col.to_le_bytes())?;
    }
    for value in matrix.values.iter().chain(b) {
        file.write_all(&value.to_le_bytes())?;
    }
    for unknown in unknowns {
        file.write_all(&unknown.node.to_le_bytes())?;
    }
    for unknown in unknowns {
        let kind = match unknown.kind {
            Kind::Velocity => 0,
            Kind::Deformation => 1,
            Kind::Pressure => 2,
        };
        file.write_all(&[kind])?;
    }
    for x in unknowns.iter().flat_map(|u| u.at) {
        file.write_all(&x.to_le_bytes())?;
    }
    file.flush()
}
