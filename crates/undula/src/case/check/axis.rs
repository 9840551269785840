//! What a case around an axis, or with periodic boundaries, cannot have.

use crate::case::conditions::Condition;
use crate::case::functionals::FunctionalSpec;
use crate::case::read::Section;
use crate::case::schema::Case;
use crate::physics::{MotionModel, PressureTerm, TransportTerm};

/// Refuses moments where a point of the fluid has several places.
fn refuse_moments(root: &mut Section<'_, '_>, case: &Case) {
    if !case.boundary.values().any(|condition| matches!(condition, Condition::Periodic(_))) {
        return;
    }
    for (name, functional) in &case.functional {
        if matches!(functional, FunctionalSpec::Moment { .. }) {
            let message = "a moment depends on which of the places of a periodic point is meant; expected no periodic boundary";
            root.section("functional").section(name).wrong("kind", message.to_string());
        }
    }
}

/// Refuses what is written for the plane alone.
pub(super) fn refuse(root: &mut Section<'_, '_>, case: &Case) {
    refuse_moments(root, case);
    if !case.mesh.coordinates.is_axisymmetric() {
        return;
    }
    let only = "is not available with mesh.coordinates = \"axisymmetric\"";
    if case.motion.model == MotionModel::Biharmonic && !case.fluids.is_empty() {
        root.section("motion").wrong("model", format!("{only}; expected `pseudo-elastic` or another model"));
    }
    if case.solids.iter().any(|solid| solid.fibres.is_some()) {
        let note = "fibres lie in the section (r, z): directions around the axis are not yet available";
        root.note(note);
    }
    let how = &case.stabilization;
    let pair = "take a stable pair such as Q2 with P1dc, or P2 with P1";
    if how.pressure != PressureTerm::None {
        root.section("stabilization").wrong("pressure", format!("{only}: {pair}"));
    }
    if how.transport != TransportTerm::None {
        root.section("stabilization").wrong("transport", format!("{only}; expected `off`"));
    }
    for (name, functional) in &case.functional {
        if matches!(functional, FunctionalSpec::Force { coefficient: Some(_), .. }) {
            let message = "is per length, and a body of revolution has an area; expected the force alone";
            root.section("functional").section(name).wrong("coefficient", message.to_string());
        }
        if matches!(functional, FunctionalSpec::Rotation { .. } | FunctionalSpec::Moment { .. }) {
            root.section("functional")
                .section(name)
                .wrong("kind", "nothing turns around the axis".to_string());
        }
    }
}
