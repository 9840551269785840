//! What the table of a functional means, by its kind.

use crate::case::choices::METHODS;
use crate::case::error::quoted;
use crate::case::functionals::{FunctionalSpec, Site};
use crate::case::read::{POSITIVE, Section, Vectors};
use crate::choice::{self, Choice};
use crate::functional::body_energy::PARTS;
use crate::functional::energy::ENERGIES;
use crate::functional::quantity::{Component, TAKES, Take};

impl FunctionalSpec {
    /// The functional of this kind that the table `s` means.
    pub(super) fn read(self, s: &mut Section<'_, '_>) -> FunctionalSpec {
        match self {
            FunctionalSpec::Force { .. } => force(s),
            FunctionalSpec::Moment { .. } => FunctionalSpec::Moment {
                on: boundaries(s),
                about: required_point(s, "point"),
                axis: turning(s),
            },
            FunctionalSpec::Displacement { .. } => {
                FunctionalSpec::Displacement { point: required_point(s, "point"), component: axis(s) }
            }
            FunctionalSpec::PressureDifference { .. } => {
                FunctionalSpec::PressureDifference { a: required_point(s, "a"), b: required_point(s, "b") }
            }
            FunctionalSpec::Energy(default) => {
                let term = s.choice("term", &ENERGIES, &[]);
                s.require_choice("term", &ENERGIES);
                FunctionalSpec::Energy(term.unwrap_or(default))
            }
            FunctionalSpec::Rotation { .. } => FunctionalSpec::Rotation { axis: turning(s) },
            FunctionalSpec::Flux { .. } => FunctionalSpec::Flux { on: boundaries(s) },
            FunctionalSpec::Power { .. } => FunctionalSpec::Power { on: boundaries(s) },
            FunctionalSpec::Pressure(_) => FunctionalSpec::Pressure(site(s, true)),
            FunctionalSpec::Velocity { .. } => FunctionalSpec::Velocity {
                component: component(s, Component::of_velocity(dim(s))),
                at: site(s, true),
            },
            FunctionalSpec::Stress { .. } => FunctionalSpec::Stress {
                component: component(s, Component::of_stress(dim(s))),
                at: site(s, false),
            },
            FunctionalSpec::WallShearStress { .. } => FunctionalSpec::WallShearStress {
                component: component(s, Component::of_shear(dim(s))),
                on: boundaries(s),
                take: take(s),
            },
            FunctionalSpec::Balance { part, .. } => {
                let found = s.choice("part", &PARTS, &[]);
                s.require_choice("part", &PARTS);
                if !s.has("region") {
                    s.missing("region", "a region of the fluid or of the solid, such as \"solid\"");
                }
                let region = s.string("region").unwrap_or_default();
                FunctionalSpec::Balance { region, part: found.unwrap_or(part) }
            }
            FunctionalSpec::Volume { .. } => {
                if !s.has("region") {
                    s.missing("region", "the region of the fluid or of the solid, such as \"fluid\"");
                }
                FunctionalSpec::Volume { region: s.string("region").unwrap_or_default() }
            }
        }
    }
}

/// Where a field is looked at: `point`, `on` or `region`, with `take` for the last two.
fn site(s: &mut Section<'_, '_>, on_boundaries: bool) -> Site {
    let (on, region) = (s.strings("on"), s.string("region"));
    if !on_boundaries && s.has("on") {
        let message = "a stress is taken at a point or in a region; of boundaries there are `force`, \
                       `wall-shear-stress` and `pressure`";
        s.wrong("on", message);
    }
    if s.has("point") {
        for key in ["on", "take"] {
            if s.has(key) {
                s.wrong(key, "a point has one value: leave it out, or `point`");
            }
        }
        s.item("take");
        return Site::Point { point: required_point(s, "point"), region };
    }
    s.item("point");
    match (on, region) {
        (Some(on), None) => Site::Boundaries(on, take(s)),
        (None, Some(region)) => Site::Region(region, take(s)),
        (Some(on), Some(_)) => {
            s.wrong("region", "expected either `on` or `region`");
            Site::Boundaries(on, take(s))
        }
        (None, None) => {
            let known = if on_boundaries { "`point`, `on` or `region`" } else { "`point` or `region`" };
            if !["on", "region"].iter().any(|key| s.has(key)) {
                s.missing(if on_boundaries { "on" } else { "region" }, known);
            }
            Site::Boundaries(vec![], take(s))
        }
    }
}

fn take(s: &mut Section<'_, '_>) -> Take {
    let take = s.choice("take", &TAKES, &[]);
    s.require_choice("take", &TAKES);
    take.unwrap_or(Take::Mean)
}

fn boundaries(s: &mut Section<'_, '_>) -> Vec<String> {
    let on = s.strings("on");
    if !s.has("on") {
        s.missing("on", "the boundaries, such as on = [\"cylinder\", \"interface\"]");
    }
    on.unwrap_or_default()
}

fn force(s: &mut Section<'_, '_>) -> FunctionalSpec {
    let on = boundaries(s);
    let method = s.choice("method", &METHODS, &[]);
    FunctionalSpec::Force {
        on,
        component: axis(s),
        surface_integral: method.unwrap_or(false),
        coefficient: s.pair("coefficient", POSITIVE),
    }
}

/// The number of a direction.
fn axis(s: &mut Section<'_, '_>) -> usize {
    match component(s, Component::of_vector(dim(s))) {
        Component::Along(axis) => axis,
        _ => 0,
    }
}

/// In space the axis of a rotation, on an extruded plane z unless it is given; `None` in the plane.
fn turning(s: &mut Section<'_, '_>) -> Option<usize> {
    match s.checker.vectors.get() {
        Vectors::Plane => None,
        Vectors::Extruded { .. } if !s.has("component") => Some(2),
        _ => Some(axis(s)),
    }
}

/// Dimension of the mesh.
fn dim(s: &Section<'_, '_>) -> usize {
    s.checker.vectors.get().len()
}

fn component(s: &mut Section<'_, '_>, available: Vec<Choice<Component>>) -> Component {
    let component = s.choice("component", &available, &[]);
    if !s.has("component") {
        let meaning = match &available[..] {
            [one, two] => format!("\"{}\" or \"{}\"", one.name, two.name),
            _ => format!("one of {}", quoted(choice::names(&available))),
        };
        s.missing("component", &meaning);
    }
    component.unwrap_or(available[0].value)
}

fn required_point(s: &mut Section<'_, '_>, key: &str) -> Vec<f64> {
    let point = s.point(key);
    if !s.has(key) {
        s.missing(key, "a point of the reference domain [m], such as [0.6, 0.2]");
    }
    point.unwrap_or_default()
}
