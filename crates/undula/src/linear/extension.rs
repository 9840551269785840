//! The extension of an update of the solid into the fluid.

use super::factors::{MakeSolver, Purpose, share};
use crate::algebra::{Cost, Csr, Gmres, GmresSettings, LinearOperator, LinearSolver, SolverError};
use crate::multigrid::{self, System, Tiers};
use crate::system::extension::ExtensionSystem;
use crate::system::{Assembler, StepView};
use std::sync::Arc;

/// Difference of two entries of the extension, relative to their diagonals, that is rounding.
const SYMMETRIC: f64 = 1e-10;

/// Iterations with multigrid.
const GMRES: GmresSettings = GmresSettings { tolerance: 1e-2, size: 20 };

/// The system of the extension and its factors, which live as long as its operator.
pub(super) struct Extension<const D: usize> {
    system: ExtensionSystem<D>,
    solver: Box<dyn LinearSolver>,
    /// The matrix in single precision, where the solver has it, too, and nothing changes: that of the system is gone.
    single: Option<Arc<Csr<f32>>>,
    /// Where the solver is not exact: its iteration, with the weights of the rows.
    gmres: Option<(Gmres, Vec<f64>)>,
    b: Vec<f64>,
    x: Vec<f64>,
}

impl<const D: usize> Extension<D> {
    /// Factorised for the iterate of `view`; `None` where nothing is extended.
    pub(super) fn new(
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        make: &MakeSolver,
        multigrid: Option<multigrid::Settings>,
    ) -> Result<Option<Extension<D>>, SolverError> {
        let Some(mut system) = assembler.extension(view) else { return Ok(None) };
        let purpose = if assembler.is_biharmonic() {
            // Of fourth order: single precision is not enough for the condition of its matrix.
            Purpose::Exact
        } else if assembler.extension_is_constant()
            && !assembler.space.any(!system.matrix.is_symmetric(SYMMETRIC))
        {
            Purpose::Definite
        } else {
            Purpose::Correction
        };
        let all = assembler.unknowns();
        let unknowns: Vec<_> = system.places.iter().map(|&place| all[place as usize]).collect();
        let biharmonic = assembler.is_biharmonic();
        let multigrid = multigrid.filter(|_| !biharmonic);
        let multigrid =
            multigrid.map(|settings| multigrid::Settings { single: !settings.double, ..settings });
        let is_constant = assembler.extension_is_constant();
        let factor = |purpose| {
            let mut solver: Box<dyn LinearSolver> = match multigrid {
                Some(settings) => {
                    let tiers = Tiers::new(&assembler.space, System::Extension(&system.places))?;
                    // On several processes each solves the coarsest level alone.
                    let alone = assembler.space.part.is_none();
                    let purpose = if alone { purpose } else { Purpose::Coarsest };
                    multigrid::multigrid(settings, tiers, make(purpose))
                }
                None => make(purpose),
            };
            let halo = share(&assembler.space, system.places.iter().copied(), &mut *solver)?;
            let single = is_constant && solver.takes_single();
            solver.analyse(&system.matrix.pattern, &unknowns)?;
            let single = single.then(|| Arc::new(system.matrix.single()));
            match &single {
                Some(matrix) => solver.factor_single(matrix)?,
                None => solver.factor(&system.matrix)?,
            };
            Ok((solver, single, halo))
        };
        let (mut solver, single, halo) = match factor(purpose) {
            // By rounding, in single precision: the operator is nearly singular.
            Err(SolverError::NotDefinite { .. }) => factor(Purpose::Correction)?,
            result => result?,
        };
        // An iteration needs the matrix itself.
        if is_constant && (solver.is_exact() || single.is_some()) {
            system.settle();
            solver.settle();
        }
        let n = system.places.len();
        let gmres = (!solver.is_exact()).then(|| (Gmres::new(GMRES).shared(halo), vec![1.0; n]));
        Ok(Some(Extension { system, solver, single, gmres, b: vec![0.0; n], x: vec![0.0; n] }))
    }

    /// What applies its factors.
    pub(super) fn solver(&self) -> &dyn LinearSolver {
        &*self.solver
    }

    /// What its factors cost.
    pub(super) fn predicted(&self) -> Option<Cost> {
        self.solver.predicted()
    }

    /// Where the operator is not constant, it changes with the Jacobian.
    pub(super) fn renew(&mut self, assembler: &Assembler<D>, view: &StepView<'_>) -> Result<(), SolverError> {
        if assembler.renew_extension(view, &mut self.system) {
            self.solver.factor(&self.system.matrix)?;
            self.gmres.iter_mut().for_each(|(gmres, _)| gmres.clear());
        }
        Ok(())
    }

    /// Forget what solutions before have taught.
    pub(super) fn forget(&mut self) {
        self.gmres.iter_mut().for_each(|(gmres, _)| gmres.clear());
    }

    /// Extend the update `delta` of the interface; with `r`, the residual of the extension becomes zero, too.
    pub(super) fn solve(&mut self, r: Option<&[f64]>, delta: &[f64]) {
        self.system.right_hand_side(r, delta, &mut self.b);
        let Extension { system, solver, single, gmres, b, x } = self;
        let Some((gmres, weights)) = gmres else { return solver.apply(b, x) };
        // The best there is will do: the residual of the next iterate tells what it lacks.
        let a: &dyn LinearOperator = match single {
            Some(matrix) => &**matrix,
            None => &system.matrix,
        };
        let _ = gmres.solve(a, weights, |r, z| solver.apply(r, z), b, x);
    }

    /// The solution: places in `[v, u, p]` and values.
    pub(super) fn values(&self) -> impl Iterator<Item = (usize, f64)> {
        self.system.places.iter().map(|&place| place as usize).zip(self.x.iter().copied())
    }
}
