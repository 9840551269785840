//! The tables of functionals.

use super::{Lines, names, numbers};
use crate::case::choices::METHODS;
use crate::case::functionals::{FUNCTIONALS, FunctionalSpec, Site};
use crate::functional::body_energy::PARTS;
use crate::functional::energy::ENERGIES;
use crate::functional::quantity::{self, COMPONENTS, TAKES};

impl Site {
    pub(super) fn write(&self, out: &mut Lines) {
        match self {
            Site::Point { point, region } => {
                out.key("point", numbers(point));
                if let Some(region) = region {
                    out.word("region", region);
                }
            }
            Site::Boundaries(on, take) => {
                out.key("on", names(on));
                out.choice("take", &TAKES, take);
            }
            Site::Region(region, take) => {
                out.word("region", region);
                out.choice("take", &TAKES, take);
            }
        }
    }
}

/// The component around an axis, in space.
fn write_axis(out: &mut Lines, axis: Option<usize>) {
    if let Some(axis) = axis {
        out.choice("component", &COMPONENTS, &quantity::Component::Along(axis));
    }
}

impl FunctionalSpec {
    /// The lines of its table.
    pub(super) fn write(&self, out: &mut Lines) {
        out.variant("kind", &FUNCTIONALS, self);
        match self {
            FunctionalSpec::Force { on, component, surface_integral, coefficient } => {
                out.key("on", names(on));
                out.choice("component", &COMPONENTS, &quantity::Component::Along(*component));
                out.choice("method", &METHODS, surface_integral);
                if let Some(scales) = coefficient {
                    out.key("coefficient", numbers(scales));
                }
            }
            FunctionalSpec::Moment { on, about, axis } => {
                out.key("on", names(on));
                out.key("point", numbers(about));
                write_axis(out, *axis);
            }
            FunctionalSpec::Displacement { point, component } => {
                out.key("point", numbers(point));
                out.choice("component", &COMPONENTS, &quantity::Component::Along(*component));
            }
            FunctionalSpec::PressureDifference { a, b } => {
                out.key("a", numbers(a));
                out.key("b", numbers(b));
            }
            FunctionalSpec::Energy(integral) => out.choice("term", &ENERGIES, integral),
            FunctionalSpec::Rotation { axis } => write_axis(out, *axis),
            FunctionalSpec::Flux { on } | FunctionalSpec::Power { on } => out.key("on", names(on)),
            FunctionalSpec::Pressure(at) => at.write(out),
            FunctionalSpec::Velocity { component, at } | FunctionalSpec::Stress { component, at } => {
                out.choice("component", &COMPONENTS, component);
                at.write(out);
            }
            FunctionalSpec::WallShearStress { component, on, take } => {
                out.key("on", names(on));
                out.choice("component", &COMPONENTS, component);
                out.choice("take", &TAKES, take);
            }
            FunctionalSpec::Balance { region, part } => {
                out.choice("part", &PARTS, part);
                out.word("region", region);
            }
            FunctionalSpec::Volume { region } => out.word("region", region),
        }
    }
}
