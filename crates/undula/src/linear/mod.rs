//! Corrections of Newton's method: with the whole Jacobian (`full.rs`), or condensed to (v, p) (`condensed.rs`); both
//! by factors of the matrix, or by GMRES with older ones (`krylov.rs`).

mod border;
mod condensed;
mod correction;
mod extension;
mod factors;
mod full;
mod krylov;
mod lift;
mod price;
mod projection;
mod relation;
mod scales;

pub use factors::{MakeSolver, Purpose};
pub use krylov::KrylovSettings;
pub use projection::Closed;
pub use scales::{BlockNorms, Scales};

use crate::algebra::{LinearSolver, Sizes, SolverError, Spent};
use crate::multigrid;
use crate::nonlinear::Seconds;
use crate::physics::StepRule;
use crate::space::State;
use crate::system::{Assembler, Matrix, StepView};
use crate::tangent::{Linearization, Tangent};
use border::Bordered;
use condensed::Condensed;
use correction::{At, Correction};
use full::{Full, by_parts};
use lift::Lift;
use std::time::Instant;

/// Steps with the whole Jacobian after one that another linearisation could not do.
const DETOUR: u32 = 10;

/// Of what a checkpoint keeps: multigrid has failed.
const HAS_LEFT: u32 = 1 << 31;

/// The whole matrix and the condensed one, each made when first needed.
pub struct Linear<const D: usize> {
    /// The one in use.
    pub active: Linearization,
    /// The one that was asked for.
    chosen: Linearization,
    /// Steps to go with the whole Jacobian after that has failed.
    pub detour: u32,
    make: MakeSolver,
    /// Typical sizes of the unknowns in a step, for the factorisations to come.
    pub sizes: Sizes,
    /// GMRES, if factors may be older than the matrix.
    krylov: Option<KrylovSettings>,
    /// Multigrid for the condensed system.
    multigrid: Option<multigrid::Settings>,
    /// Whether multigrid was asked for, and has failed.
    has_left: bool,
    /// Whether there is memory for the factors of the whole matrix, and of the condensed one.
    fits: [bool; 2],
    /// With the whole matrix and with the condensed one.
    made: [Option<Box<dyn Correction<D>>>; 2],
    /// Far couplings and scalar unknowns of the one in use.
    bordered: Bordered,
    /// For displacements that are given, with the whole matrix.
    lift: Lift<D>,
}

impl<const D: usize> Linear<D> {
    /// Nothing is prepared yet.
    pub fn new(chosen: Linearization, make: MakeSolver) -> Linear<D> {
        let (sizes, made) = (Sizes::default(), [None, None]);
        Linear {
            active: chosen,
            chosen,
            detour: 0,
            make,
            sizes,
            krylov: None,
            multigrid: None,
            has_left: false,
            fits: [true; 2],
            made,
            bordered: Bordered::default(),
            lift: Lift::new(),
        }
    }

    /// With GMRES: factors are kept longer than matrices.
    #[must_use]
    pub fn with_krylov(mut self, settings: Option<KrylovSettings>) -> Linear<D> {
        self.krylov = settings;
        self
    }

    /// With multigrid in place of the factors of the condensed system; GMRES is then asked for, too. `fits` says whether
    /// the factors of the whole matrix and of the condensed one may take over where it fails.
    #[must_use]
    pub fn with_multigrid(mut self, settings: Option<multigrid::Settings>, fits: [bool; 2]) -> Linear<D> {
        (self.multigrid, self.fits) = (settings, if settings.is_some() { fits } else { [true; 2] });
        self
    }

    /// Whether factors may be older than the matrix.
    pub fn is_iterative(&self) -> bool {
        self.krylov.is_some()
    }

    /// Whether multigrid is in use.
    pub const fn is_multigrid(&self) -> bool {
        self.multigrid.is_some()
    }

    /// Whether the direct solver has taken over.
    pub const fn has_left_multigrid(&self) -> bool {
        self.has_left
    }

    /// Let the direct solver take over for the rest of the run where multigrid has failed; `false` if it is not in use, or
    /// if there is no memory for factors.
    pub fn leave_multigrid(&mut self) -> bool {
        let of_whole = self.made[0].as_mut().is_some_and(|made| !made.factored().is_exact());
        let condensed = self.active == Linearization::Condensed;
        (condensed || of_whole) && self.fits[usize::from(condensed)] && self.leave()
    }

    fn leave(&mut self) -> bool {
        let is_left = self.multigrid.take().is_some();
        if is_left {
            self.has_left = true;
            self.krylov = None;
            self.made = [None, None];
        }
        is_left
    }

    /// Unknowns of the largest system that is factorised as a whole.
    pub fn largest_factor(&self) -> usize {
        self.solvers().map(LinearSolver::largest_factor).max().unwrap_or(0)
    }

    /// What the parts of cycles have cost, those of the extension behind those of the flow.
    pub fn spent(&self) -> Vec<Spent> {
        self.solvers().flat_map(LinearSolver::spent).collect()
    }

    fn solvers(&self) -> impl Iterator<Item = &dyn LinearSolver> {
        self.made.iter().flatten().flat_map(|made| made.solvers())
    }

    /// Take the whole Jacobian for some steps; `false` if it is in use already, or if there is no memory for its factors.
    pub fn fall_back(&mut self) -> bool {
        if self.active == Linearization::Newton || !self.fits[0] {
            return false;
        }
        (self.active, self.detour) = (Linearization::Newton, DETOUR);
        true
    }

    /// What a checkpoint keeps: the steps to go with the whole Jacobian, and whether multigrid has failed.
    pub fn save(&self) -> u32 {
        // The rest is asked for by the case, follows from it, or is made anew.
        let Linear {
            active: _,
            chosen: _,
            detour,
            make: _,
            sizes: _,
            krylov: _,
            multigrid: _,
            has_left,
            fits: _,
            made: _,
            bordered: _,
            lift: _,
        } = *self;
        detour | if has_left { HAS_LEFT } else { 0 }
    }

    /// As it was when a run was left; nothing if that is to go on with the whole Jacobian anyway.
    pub fn restore(&mut self, saved: u32) {
        let detour = saved & !HAS_LEFT;
        if saved != detour {
            self.leave();
        }
        if detour > 0 && self.active != Linearization::Newton {
            (self.active, self.detour) = (Linearization::Newton, detour);
        }
    }

    /// A step is done; `true` if the linearisation that was asked for takes over again.
    pub fn count_step(&mut self) -> bool {
        if self.detour == 0 {
            return false;
        }
        self.detour -= 1;
        if self.detour == 0 {
            self.active = self.chosen;
        }
        self.detour == 0
    }

    /// Where corrections of the active linearisation are.
    fn slot(&self) -> usize {
        usize::from(self.active == Linearization::Condensed)
    }

    /// Those of the active linearisation, if they are made.
    fn at_hand(&mut self) -> Result<&mut dyn Correction<D>, SolverError> {
        match &mut self.made[self.slot()] {
            Some(made) => Ok(&mut **made),
            None => Err(SolverError::NotFactored),
        }
    }

    /// Corrections of the active linearisation, without a matrix.
    fn make(
        &self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
    ) -> Result<Box<dyn Correction<D>>, SolverError> {
        Ok(match self.active {
            Linearization::Condensed => {
                let iterative = (self.krylov, self.multigrid);
                Box::new(Condensed::new(assembler, view, &self.make, iterative)?)
            }
            Linearization::Newton | Linearization::Reduced | Linearization::FixedPoint => {
                let at_rest = view.rule.per_k == 0.0;
                let alone = assembler.space.part.is_none();
                let solver = match self.multigrid.filter(|_| at_rest && alone) {
                    Some(settings) => by_parts(assembler, &self.make, settings)?,
                    None => (self.make)(Purpose::Whole),
                };
                Box::new(Full::new(assembler, solver, self.krylov)?)
            }
        })
    }

    /// Assemble and factorise at the iterate of `view`. Returns how many times factors were applied, for borders.
    ///
    /// # Errors
    /// If the matrix is singular, or memory is short.
    pub fn renew(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        tangent: Tangent,
        seconds: &mut Seconds,
    ) -> Result<usize, SolverError> {
        let start = Instant::now();
        let (slot, sizes, linearization) = (self.slot(), self.sizes, self.active);
        match &mut self.made[slot] {
            Some(made) => made.renew_extension(assembler, view)?,
            None => self.made[slot] = Some(self.make(assembler, view)?),
        }
        let made = self.at_hand()?;
        made.assemble(&mut At { assembler, view, linearization, tangent });
        let assembled = Instant::now();
        seconds.assembly += (assembled - start).as_secs_f64();
        let factored = made.factored().factor(view.rule, sizes);
        seconds.factorization += assembled.elapsed().as_secs_f64();
        factored?;
        if !made.factored().is_exact() {
            made.precondition(&assembler.space, view.rule.per_k);
        }
        self.take_borders(assembler, view, seconds)
    }

    /// Assemble at the iterate of `view`, and keep the factors. Returns how many times they were applied, for borders.
    ///
    /// # Errors
    /// If there are none.
    pub fn refresh(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        tangent: Tangent,
        seconds: &mut Seconds,
    ) -> Result<usize, SolverError> {
        let (start, linearization) = (Instant::now(), self.active);
        let made = self.at_hand()?;
        made.assemble(&mut At { assembler: &mut *assembler, view, linearization, tangent });
        let assembled = Instant::now();
        seconds.assembly += (assembled - start).as_secs_f64();
        let (other, sizes) = (made.factored().is_of_other_step(&view.rule), self.sizes);
        let made = self.at_hand()?;
        if other {
            made.factored().factor(view.rule, sizes)?;
            seconds.factorization += assembled.elapsed().as_secs_f64();
        }
        made.precondition(&assembler.space, view.rule.per_k);
        self.take_borders(assembler, view, seconds)
    }

    /// Take far couplings and scalar unknowns at the iterate of `view`.
    fn take_borders(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        seconds: &mut Seconds,
    ) -> Result<usize, SolverError> {
        let start = Instant::now();
        let matrix = match self.active {
            Linearization::Condensed => Matrix::Condensed,
            Linearization::Newton | Linearization::Reduced | Linearization::FixedPoint => Matrix::Whole,
        };
        let slot = self.slot();
        let made = self.made[slot].as_mut().ok_or(SolverError::NotFactored)?;
        let applied = self.bordered.renew(&mut **made, matrix, assembler, view)?;
        seconds.solve += start.elapsed().as_secs_f64();
        Ok(applied)
    }

    /// δ from the residual `r`, both \[v, u, p, s\], by the factors at hand; with `settled` the condensed system takes the
    /// residual of the extension for zero, which is cheaper. Returns how many times factors were applied.
    ///
    /// # Errors
    /// If the solution is inaccurate or there are no factors.
    pub fn correct(
        &mut self,
        assembler: &mut Assembler<D>,
        view: &StepView<'_>,
        settled: bool,
        r: &[f64],
        delta: &mut [f64],
    ) -> Result<usize, SolverError> {
        let slot = self.slot();
        let made = self.made[slot].as_mut().ok_or(SolverError::NotFactored)?;
        let applied = self.bordered.correct(&mut **made, assembler, view, settled, r, delta)?;
        // Factors in single precision leave a rounding there, which no residual shows.
        assembler.project(delta);
        Ok(applied)
    }

    /// What a new Jacobian costs, in iterations, or with GMRES its factors in those.
    pub fn price(&self) -> f64 {
        self.made[self.slot()].as_ref().map_or(price::TYPICAL, |made| made.work().price())
    }

    /// Make u in the fluid of `state`, where it is 0, the extension of u in the solid and of given displacements.
    ///
    /// # Errors
    /// If the matrix of the extension cannot be factorised.
    pub fn extend(&mut self, assembler: &mut Assembler<D>, state: &mut State) -> Result<(), SolverError> {
        self.lift.extend(assembler, &self.make, state)
    }

    /// Make v in the fluid of `state` the nearest velocity in L² that is discretely free of divergence, given values kept;
    /// `closed` are parts of the fluid whose pressure is determined up to a constant, and `k` \[s\] is the
    /// step. Returns whether the given velocities let as much into these parts as out of them; else nothing is changed. What
    /// they differ by is taken from the velocity of the interface if it is as small as errors of an interpolation are.
    ///
    /// # Errors
    /// If the system cannot be solved.
    pub fn project(
        &mut self,
        assembler: &mut Assembler<D>,
        k: f64,
        closed: &[Closed],
        state: &mut State,
    ) -> Result<bool, SolverError> {
        projection::project(assembler, &self.make, k, closed, state)
    }

    /// Make `new` satisfy the velocity-deformation relation at the nodes, where the condensed system takes
    /// it for granted; with `follow` the extension goes along: the fluid then sees at once what a step behind the
    /// solid would cost half an iteration later, and a solid that moves by more than the size of a cell
    /// does not fold its neighbours. `moved` are the places in u that boundary data have changed, and by how much they
    /// have become less.
    pub fn start(
        &mut self,
        assembler: &mut Assembler<D>,
        rule: StepRule,
        new: &mut State,
        old: &State,
        (moved, follow): (&[(usize, f64)], bool),
    ) {
        if self.active != Linearization::Condensed {
            if assembler.is_moved() {
                self.lift.follow(assembler, &self.make, rule, (new, old), moved);
            }
            return;
        }
        let relates = relation::places(assembler).next().is_some();
        if !assembler.is_moved() && !assembler.space.any(relates) {
            return;
        }
        let slot = self.slot();
        if follow && self.made[slot].is_none() {
            // What goes wrong here goes wrong again, and is told, where the matrix is made.
            self.made[slot] = self.make(assembler, &StepView { rule, new, old }).ok();
        }
        match &mut self.made[slot] {
            Some(made) if follow => made.follow(assembler, rule, new, old, moved),
            _ => relation::impose(assembler, rule, new, old, |_, _| {}),
        }
    }
}
