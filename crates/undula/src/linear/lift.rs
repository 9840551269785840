//! The domain follows boundaries whose displacement is given, where no correction takes it along.

use super::extension::Extension;
use super::factors::MakeSolver;
use crate::physics::StepRule;
use crate::space::State;
use crate::system::{Assembler, StepView};

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
            None => self.extension = Extension::new(assembler, &view, make).ok().flatten(),
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
}
