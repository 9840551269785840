//! The engine of the linear systems, if it is not our own: whether it is there and takes the options of the case.

use crate::algebra::petsc::{self, USUAL_OPTIONS, mistake_in_options};
use crate::algebra::{Engine, Kind};
use crate::case::{Case, Linearization};
use crate::error::Error;

const ENGINE: &str = "linear.engine";
const OPTIONS: &str = "linear.petsc.options";

impl Case {
    /// The options of PETSc, if it solves.
    pub(super) fn petsc_options(&self) -> Option<&str> {
        (self.linear.engine == Engine::Petsc).then_some(&*self.linear.petsc)
    }

    /// Fields of the systems of Newton's method.
    fn fields(&self) -> Vec<Kind> {
        let is_whole = self.newton.linearization != Linearization::Condensed;
        let has_pressure = !self.fluids.is_empty() || self.solids.iter().any(|s| s.law.is_incompressible());
        let fields = [
            (Kind::Velocity, true),
            (Kind::Deformation, is_whole && (!self.solids.is_empty() || self.has_displacements())),
            (Kind::Pressure, has_pressure),
        ];
        fields.into_iter().filter(|(_, is_there)| *is_there).map(|(kind, _)| kind).collect()
    }

    /// What the engine is; it starts, and tries the options.
    ///
    /// # Errors
    /// If it is not there, or if something is wrong with the options.
    pub(super) fn check_engine(&self) -> Result<Option<String>, Error> {
        let Some(options) = self.petsc_options() else { return Ok(None) };
        match mistake_in_options(options, &self.fields()) {
            Err(missing) => Err(self.refuse(ENGINE, missing.to_string())),
            Ok(Some(mistake)) if options == USUAL_OPTIONS => {
                Err(self.refuse(ENGINE, format!("the usual options, `{options}`: {mistake}")))
            }
            Ok(Some(mistake)) => Err(self.refuse(OPTIONS, mistake)),
            Ok(None) => {
                let title = petsc::engine().map(petsc::Engine::title).unwrap_or_default();
                Ok(Some(format!("{ENGINE}: {title} solves, by `{options}`")))
            }
        }
    }

    /// The same without an error where there is none: a case is checked on other machines than those that run it.
    pub(super) fn note_on_engine(&self) -> Result<Option<String>, Error> {
        if petsc::have_parted() {
            return Ok(None);
        }
        match self.petsc_options().map(|_| petsc::engine()) {
            Some(Err(missing)) => Ok(Some(format!("{ENGINE}: a run is not possible here: {missing}"))),
            Some(Ok(_)) | None => self.check_engine(),
        }
    }
}
