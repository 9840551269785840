//! `undula engines`: what solves linear systems here beside the program itself, and what is missing.

use crate::args::print;
use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use undula::algebra::petsc::{self, Engine, INSTALL, MpiKind, Names};

/// Tells the library which libraries the environment names.
pub fn name_libraries() {
    let of = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    let directory =
        of("PETSC_DIR").map(|path| PathBuf::from(path).join(of("PETSC_ARCH").unwrap_or_default()));
    petsc::name_libraries(Names { petsc: of("UNDULA_PETSC"), directory, mpi: of("UNDULA_MPI") });
}

/// Prints them. Nothing is started.
pub fn run() -> anyhow::Result<ExitCode> {
    let mut text =
        "own       multifrontal LU and multigrid, part of the program: linear.solver\n".to_string();
    match petsc::engine() {
        Ok(engine) => describe(&mut text, engine)?,
        Err(missing) => {
            writeln!(text, "petsc     {missing}")?;
            match petsc::mpi_alone() {
                Some((name, version)) => writeln!(text, "          MPI: {version} ({name})")?,
                None => writeln!(text, "          MPI: none was found")?,
            }
            writeln!(text, "          Debian 12: {INSTALL}")?;
            writeln!(
                text,
                "          others: UNDULA_PETSC=/path/to/libpetsc.so, or PETSC_DIR and PETSC_ARCH"
            )?;
        }
    }
    print(&text)
}

fn describe(text: &mut String, engine: &Engine) -> std::fmt::Result {
    let version = engine.version.map(|n| n.to_string()).join(".");
    let path = mapped(&["libpetsc"]).unwrap_or_else(|| engine.library.clone());
    writeln!(text, "petsc     PETSc {version} ({path}): linear.engine = \"petsc\"")?;
    writeln!(text, "          real numbers of 64 bits, integers of {} bits", engine.index_bits)?;
    match engine.mpi {
        MpiKind::Without => writeln!(text, "          MPI: none, PETSc was built without")?,
        MpiKind::OpenMpi | MpiKind::Mpich => {
            let path = mapped(&["libmpi.", "libmpich"]).map_or(String::new(), |path| format!(" ({path})"));
            writeln!(text, "          MPI: {}{path}", engine.mpi_version)?;
        }
    }
    let of = |there: bool| -> Vec<&str> {
        engine.packages.iter().filter(|(_, is)| *is == there).map(|(name, _)| *name).collect()
    };
    let (inside, missing) = (of(true), of(false));
    let list = |names: &[&str]| if names.is_empty() { "none".to_string() } else { names.join(", ") };
    writeln!(text, "          packages inside: {}; missing: {}", list(&inside), list(&missing))?;
    match mapped(&["libopenblas", "openblas", "libmkl", "libblis"]) {
        Some(path) => writeln!(text, "          BLAS: {path}"),
        None => match mapped(&["libblas"]) {
            Some(path) => writeln!(
                text,
                "          BLAS: {path}, the reference one, with which MUMPS is many times slower: install libopenblas0-serial"
            ),
            None => writeln!(text, "          BLAS: unknown"),
        },
    }
}

/// Path of a library that is loaded, the first that has one of these words in its path, where the system tells (Linux).
fn mapped(words: &[&str]) -> Option<String> {
    let maps = std::fs::read_to_string("/proc/self/maps").ok()?;
    let paths = || maps.lines().filter_map(|line| line.find('/').map(|at| line[at..].trim()));
    words
        .iter()
        .find_map(|word| paths().find(|path| path.contains(word) && path.contains(".so")))
        .map(String::from)
}
