//! Corrections by the whole Jacobian, or what the chosen linearisation leaves of it.

use super::correction::{At, Correction};
use super::factors::{Factored, Fill, MakeSolver, Purpose, scale_pressure, scale_rows, share};
use super::krylov::KrylovSettings;
use super::price::Work;
use super::relation;
use crate::algebra::{LinearSolver, SolverError};
use crate::multigrid::{self, Part, System, Tiers, Triangular};
use crate::physics::StepRule;
use crate::space::{FsiSpace, PsiOwner};
use crate::system::{Assembler, StepView};

/// The matrix of [v, u, p].
pub(super) struct Full {
    factored: Factored,
    /// A right-hand side that had to be scaled.
    work: Vec<f64>,
}

impl Full {
    pub(super) fn new<const D: usize>(
        assembler: &mut Assembler<D>,
        mut solver: Box<dyn LinearSolver>,
        krylov: Option<KrylovSettings>,
    ) -> Result<Full, SolverError> {
        let pattern = assembler.try_pattern()?;
        let halo = share(&assembler.space, 0..pattern.n as u32, &mut *solver)?;
        let factored = Factored::new(&pattern, &assembler.unknowns(), solver, krylov, halo)?;
        Ok(Full { factored, work: vec![] })
    }

    /// By GMRES, with factors of an older matrix.
    fn iterate<const D: usize>(
        &mut self,
        assembler: &Assembler<D>,
        rule: &StepRule,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError> {
        let ratio = self.factored.ratio(rule).unwrap_or(1.0);
        let before = |r: &mut [f64]| {
            if ratio != 1.0 {
                scale_rows(assembler, 1.0 / ratio, r);
            }
        };
        let after = |z: &mut [f64]| scale_pressure(assembler, ratio, z);
        self.factored.iterate((before, after), r, delta)
    }
}

/// Multigrid for a stationary deformation of bodies without pressure: the flow on the domain as it is, the solid, the
/// extension, each with levels of its own.
pub(super) fn by_parts<const D: usize>(
    assembler: &mut Assembler<D>,
    make: &MakeSolver,
    settings: multigrid::Settings,
) -> Result<Box<dyn LinearSolver>, SolverError> {
    let (n_v, n_u) = (assembler.space.n_v(), assembler.space.n_u());
    let mut given = assembler.is_given();
    let nodal: Vec<u32> = relation::places(assembler).map(|at| at as u32).collect();
    let space = &assembler.space;
    let moves: Vec<u32> = nodal.iter().map(|at| at + n_v as u32).collect();
    let free = |first: usize, owner: PsiOwner| {
        let nodes = (0..space.nodes.len()).filter(move |&node| space.owner[node] == owner);
        nodes.flat_map(move |node| (first + node * D..first + (node + 1) * D).map(|place| place as u32))
    };
    let is_free = |place: &u32| !given[*place as usize];
    let pressures = (n_v + n_u..space.n_field_unknowns()).map(|place| place as u32);
    let flow: Vec<u32> = free(0, PsiOwner::Extension).chain(pressures).filter(is_free).collect();
    let extension: Vec<u32> = free(n_v, PsiOwner::Extension).filter(is_free).collect();
    // The velocity of the solid is no unknown of the flow.
    free(0, PsiOwner::Relation).for_each(|place| given[place as usize] = true);
    let solver = |system: System<'_>, settings| {
        let is_there = match system {
            System::Flow { places, .. } | System::Extension(places) => !places.is_empty(),
        };
        let tiers = if is_there { Tiers::new(space, system)? } else { Tiers::Whole(vec![]) };
        Ok::<_, SolverError>(Some(multigrid::multigrid(settings, tiers, make(Purpose::Coarsest))))
    };
    let of_flow = solver(System::Flow { given: &given, places: &flow }, settings)?;
    // A thin body bends by forces that are rounding of the single ones.
    let of_solid = solver(System::Extension(&moves), multigrid::Settings { double: true, ..settings })?;
    let of_extension = if assembler.is_biharmonic() {
        Some(make(Purpose::Exact))
    } else {
        solver(System::Extension(&extension), settings)?
    };
    Ok(Box::new(Triangular::new(vec![
        Part { rows: moves.clone(), columns: nodal.clone(), solver: None },
        Part { rows: flow.clone(), columns: flow, solver: of_flow },
        Part { rows: nodal, columns: moves, solver: of_solid },
        Part { rows: extension.clone(), columns: extension, solver: of_extension },
    ])))
}

impl<const D: usize> Correction<D> for Full {
    fn factored(&mut self) -> &mut Factored {
        &mut self.factored
    }

    fn assemble(&mut self, At { assembler, view, linearization, tangent }: &mut At<'_, D>) {
        self.factored.fill(|matrix| {
            if let Fill::Double(matrix) = matrix {
                assembler.matrix(view, *linearization, *tangent, matrix);
            }
        });
    }

    fn precondition(&mut self, space: &FsiSpace<D>, per_k: f64) {
        self.factored.precondition(|scales, weights| scales.weights(space, per_k, weights));
    }

    fn correct(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        _settled: bool,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError> {
        if self.factored.are_old() {
            return self.iterate(assembler, &view.rule, r, delta);
        }
        let Some(ratio) = self.factored.ratio(&view.rule) else { return self.factored.solve(r, delta) };
        self.work.clear();
        self.work.extend_from_slice(r);
        scale_rows(assembler, 1.0 / ratio, &mut self.work);
        let applied = self.factored.solve(&self.work, delta)?;
        scale_pressure(assembler, ratio, delta);
        Ok(applied)
    }

    fn solvers(&self) -> Vec<&dyn LinearSolver> {
        vec![self.factored.solver()]
    }

    fn work(&self) -> Work {
        self.factored.work(self.factored.rows(), None)
    }
}
