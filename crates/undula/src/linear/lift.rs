//! The domain follows boundaries whose displacement is given, where no correction takes it along.

use super::extension::Extension;
use super::factors::MakeSolver;
use crate::algebra::{SolverError, norm_inf};
use crate::physics::StepRule;
use crate::space::{PsiOwner, State};
use crate::system::{Assembler, StepView};

/// Parts in which a displacement is extended by an operator that depends on it, corrections of each part at most, and
/// the relative correction after which there is none.
const PARTS: u32 = 10;
const CORRECTIONS: u32 = 40;
const EXTENDED: f64 = 1e-14;

/// The extension of given displacements, made when first asked for.
pub(super) struct Lift<const D: usize> {
    extension: Option<Extension<D>>,
    /// A vector \[v, u, p\].
    work: Vec<f64>,
}

impl<const D: usize> Lift<D> {
    /// Nothing is prepared yet.
    pub(super) fn new() -> Lift<D> {
        Lift { extension: None, work: vec![] }
    }

    /// Take the fluid of `new` along, whose places `moved` in u have become less by so much since `old`.
    ///
    /// What goes wrong here goes wrong again, and is told, where the matrix of the step is made.
    pub(super) fn follow(
        &mut self,
        assembler: &mut Assembler<D>,
        make: &MakeSolver,
        rule: StepRule,
        (new, old): (&mut State, &State),
        moved: &[(usize, f64)],
    ) {
        let view = StepView { rule, new: old, old };
        match &mut self.extension {
            Some(extension) => {
                if extension.renew(assembler, &view).is_err() {
                    return;
                }
            }
            None => self.extension = Extension::new(assembler, &view, make, None).ok().flatten(),
        }
        let Some(extension) = &mut self.extension else { return };
        let n_v = assembler.space.n_v();
        self.work.clear();
        self.work.resize(assembler.space.n_field_unknowns(), 0.0);
        moved.iter().for_each(|&(at, change)| self.work[n_v + at] = change);
        extension.solve(None, &self.work);
        for (place, x) in extension.values() {
            new.u[place - n_v] -= x;
        }
    }

    /// Make u in the fluid of `state`, where it is 0, the extension of u in the solid and of given displacements.
    ///
    /// # Errors
    /// If the matrix of the extension cannot be factorised.
    pub(super) fn extend(
        &mut self,
        assembler: &mut Assembler<D>,
        make: &MakeSolver,
        state: &mut State,
    ) -> Result<(), SolverError> {
        let parts = if assembler.extension_is_constant() { 1 } else { PARTS };
        let target = state.u.clone();
        for part in 1..=parts {
            let Assembler { space, constraints, .. } = &*assembler;
            let (share, growth) =
                (f64::from(part) / f64::from(parts), f64::from(part) / f64::from(part.max(2) - 1));
            for (place, u) in state.u.iter_mut().enumerate() {
                let (node, i) = (place / D, place % D);
                let extended = space.owner[node] == PsiOwner::Extension && !constraints.u[node][i];
                *u = if extended { *u * growth } else { target[place] * share };
            }
            for _ in 0..CORRECTIONS {
                let change = self.correct(assembler, make, state)?;
                if change <= EXTENDED * norm_inf(&state.u) {
                    break;
                }
            }
        }
        Ok(())
    }

    /// One correction of the extension; its largest value.
    fn correct(
        &mut self,
        assembler: &mut Assembler<D>,
        make: &MakeSolver,
        state: &mut State,
    ) -> Result<f64, SolverError> {
        let (n_v, old) = (assembler.space.n_v(), state.clone());
        let view = StepView { rule: StepRule::STATIONARY, new: state, old: &old };
        let mut r = vec![0.0; assembler.n_unknowns()];
        assembler.residual(&view, &mut r);
        match &mut self.extension {
            Some(extension) => extension.renew(assembler, &view)?,
            None => self.extension = Extension::new(assembler, &view, make, None)?,
        }
        let Some(extension) = &mut self.extension else { return Ok(0.0) };
        self.work.clear();
        self.work.resize(assembler.n_unknowns(), 0.0);
        extension.solve(Some(&r), &self.work);
        let mut change = 0.0f64;
        for (place, x) in extension.values() {
            state.u[place - n_v] -= x;
            change = change.max(x.abs());
        }
        Ok(change)
    }
}
