//! What the table of a functional means, by its kind.

use crate::case::choices::{COMPONENTS, METHODS};
use crate::case::functionals::FunctionalSpec;
use crate::case::read::{ANY, POSITIVE, Section};
use crate::functional::energy::ENERGIES;

impl FunctionalSpec {
    /// The functional of this kind that the table `s` means.
    pub(super) fn read(self, s: &mut Section<'_, '_>) -> FunctionalSpec {
        match self {
            FunctionalSpec::Force { .. } => force(s),
            FunctionalSpec::Displacement { .. } => {
                FunctionalSpec::Displacement { point: required_point(s, "point"), component: component(s) }
            }
            FunctionalSpec::PressureDifference { .. } => {
                FunctionalSpec::PressureDifference { a: required_point(s, "a"), b: required_point(s, "b") }
            }
            FunctionalSpec::Energy(default) => {
                let term = s.choice("term", &ENERGIES, &[]);
                s.require_choice("term", &ENERGIES);
                FunctionalSpec::Energy(term.unwrap_or(default))
            }
            FunctionalSpec::Rotation => FunctionalSpec::Rotation,
        }
    }
}

fn force(s: &mut Section<'_, '_>) -> FunctionalSpec {
    let on = s.strings("on");
    if !s.has("on") {
        s.missing("on", "the boundaries, such as on = [\"cylinder\", \"interface\"]");
    }
    let method = s.choice("method", &METHODS, &[]);
    FunctionalSpec::Force {
        on: on.unwrap_or_default(),
        component: component(s),
        surface_integral: method.unwrap_or(false),
        coefficient: s.pair("coefficient", POSITIVE),
    }
}

fn component(s: &mut Section<'_, '_>) -> usize {
    let component = s.choice("component", &COMPONENTS, &[]);
    if !s.has("component") {
        s.missing("component", "\"x\" or \"y\"");
    }
    component.unwrap_or(0)
}

fn required_point(s: &mut Section<'_, '_>, key: &str) -> [f64; 2] {
    let point = s.pair(key, ANY);
    if !s.has(key) {
        s.missing(key, "a point of the reference domain [m], such as [0.6, 0.2]");
    }
    point.unwrap_or_default()
}
