//! Whether several processes share the spaces of a case, or each has all of them.

use crate::case::{Case, Initial};
use crate::parallel::Crew;
use crate::space::{BoundaryCondition, Constraints, FsiSpace, Rim};
use std::sync::Arc;

/// What a run has on one of several processes.
pub(super) struct Shared<const D: usize> {
    pub(super) space: Arc<FsiSpace<D>>,
    /// What should be known of it.
    pub(super) note: Option<String>,
}

impl Case {
    /// The part of this process of `whole`, where the processes of `crew` can share it; with the bytes of memory that this
    /// one had before there was a mesh.
    pub(super) fn share<const D: usize>(
        &self,
        whole: Arc<FsiSpace<D>>,
        conditions: &[BoundaryCondition<D>],
        crew: Option<(&Crew, u64)>,
    ) -> Shared<D> {
        let Some((crew, before)) = crew.filter(|(crew, _)| crew.size() > 1) else {
            return Shared { space: whole, note: None };
        };
        let n = crew.size();
        let alone = |why: &str| format!("each of the {n} processes has the whole problem: {why}");
        if let Some(why) = self.is_not_shared(&whole) {
            return Shared { space: whole, note: Some(alone(why)) };
        }
        let constraints = Constraints::new(&whole, conditions);
        let rim = Rim {
            // Its terms on facets couple the nodes of both cells.
            layers: if self.factorises_extension() { 2 } else { 1 },
            families: self.needs_patches(),
            memory_before: before,
        };
        match whole.parted(crew, &constraints, rim) {
            Some(part) => {
                let note = format!("{n} processes share the mesh of {} cells", whole.mesh.n_cells());
                Shared { space: Arc::new(part), note: Some(note) }
            }
            None => Shared { space: whole, note: Some(alone("it has too few cells")) },
        }
    }

    /// Why processes cannot share it, if they cannot.
    fn is_not_shared<const D: usize>(&self, whole: &FsiSpace<D>) -> Option<&'static str> {
        let begins = match &self.initial {
            None => false,
            Some(Initial::From(_) | Initial::Fields { .. } | Initial::Static) => true,
        };
        let reasons = [
            (!whole.seams.is_empty(), "it has periodic boundaries"),
            (self.is_prestressed(), "`solid.prestress`"),
            (begins, "`[initial]`"),
            (self.newton.settings.secants > 0, "`newton.secants`"),
            (self.output.window.is_some(), "`output.window`"),
        ];
        reasons.into_iter().find(|(is_there, _)| *is_there).map(|(_, why)| why)
    }
}
