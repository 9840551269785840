//! How linear solvers are made.

use crate::algebra::petsc::{EXTENSION_OPTIONS, PetscSolver, USUAL_OPTIONS};
use crate::algebra::{self, LinearSolver};
use crate::case::{Case, Precision};
use crate::linear::{MakeSolver, Purpose};

impl Case {
    /// How linear solvers are made; `shared`: of systems that processes share.
    pub(super) fn make_solver(&self, shared: bool) -> MakeSolver {
        let linear = algebra::Options { refinement: self.linear.refinement, ..algebra::Options::default() };
        let (kind, precision) = (self.linear.solver, self.linear.precision);
        let petsc = self.petsc_options().map(String::from);
        Box::new(move |purpose| -> Box<dyn LinearSolver> {
            let (precision, definite, options) = match (purpose, &petsc) {
                (Purpose::Whole | Purpose::Condensed, Some(options)) => {
                    return Box::new(PetscSolver::new(options, linear.refinement));
                }
                (Purpose::Coarsest, _) => (precision, false, algebra::Options::unprobed()),
                (_, Some(options)) if shared => {
                    let definite = purpose == Purpose::Definite;
                    return Box::new(PetscSolver::new(of_extension(options, definite), linear.refinement));
                }
                (Purpose::Exact | Purpose::Whole, _) => (Precision::Double, false, linear),
                (Purpose::Correction | Purpose::Condensed, _) => {
                    (precision, false, algebra::Options::unprobed())
                }
                (Purpose::Definite, _) => (precision, true, algebra::Options::unprobed()),
            };
            kind.make(precision, definite, options)
        })
    }
}

/// Options of the extension where the flow has `options`: factors where that has them, too.
fn of_extension(options: &str, definite: bool) -> &'static str {
    let direct = options.split_whitespace().any(|word| word == "preonly");
    if definite && !direct { EXTENSION_OPTIONS } else { USUAL_OPTIONS }
}
