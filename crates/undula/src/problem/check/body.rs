//! The tables `[mesh]`, `[space]`, `[fluid]`, `[solid]` and `[motion]`.

use super::{is_name, resolve};
use crate::problem::case::{
    FluidSpec, MeshSource, MeshSpec, MotionModel, MotionSpec, SolidLaw, SolidSpec, SpaceSpec, VelocityElement,
};
use crate::problem::element::{PRESSURES, Stability, VELOCITIES};
use crate::problem::expression::Expression;
use crate::problem::read::{ANY, NOT_NEGATIVE, POSITIVE, Range, Section};
use std::collections::BTreeMap;

const POISSON: Range = Range { holds: |x| x > -1.0 && x < 0.5, text: "a number above -1 and below 0.5" };

#[derive(Copy, Clone, PartialEq)]
enum Generator {
    TurekHron,
    SchaeferTurek,
    Box,
}

pub(super) fn mesh(mut s: Section<'_, '_>, root: &Section<'_, '_>) -> Option<MeshSpec> {
    let generators = [
        ("turek-hron", Generator::TurekHron),
        ("schaefer-turek", Generator::SchaeferTurek),
        ("box", Generator::Box),
    ];
    let generator = s.choice("generator", &generators, &["rotor"]);
    let file = s.string("file");
    let refine = s.integer("refine", 0, 0..=10) as u32;
    let grading = s.integer("grading", 0, 0..=30) as u32;
    let (lower, upper, cells) = (s.pair("lower", ANY), s.pair("upper", ANY), s.counts("cells"));
    let region = regions(s.section("region"));
    if !s.is_present() {
        root.missing("mesh", "add [mesh] with generator = \"turek-hron\" or file = \"own.msh\"");
    } else if s.has("generator") && s.has("file") {
        s.wrong("file", "give either `generator` or `file`");
    } else if !s.has("generator") && !s.has("file") {
        s.missing("generator", "give `generator` (`turek-hron`, `schaefer-turek`, `box`) or `file`");
    }
    let is_box = generator == Some(Generator::Box);
    for key in ["lower", "upper", "cells", "region"] {
        if s.has(key) && !is_box && (generator.is_some() || file.is_some()) {
            s.wrong(key, "only for generator = \"box\"");
        } else if is_box && !s.has(key) && key != "region" {
            s.missing(key, "a box needs `lower` and `upper` corner [m] and `cells` per direction");
        }
    }
    if let (Some(a), Some(b)) = (lower, upper)
        && (a[0] >= b[0] || a[1] >= b[1])
    {
        s.wrong("upper", format!("expected a corner right of and above `lower` = [{}, {}]", a[0], a[1]));
    }
    let source = match (generator, file) {
        (Some(Generator::TurekHron), _) => MeshSource::TurekHron,
        (Some(Generator::SchaeferTurek), _) => MeshSource::SchaeferTurek,
        (Some(Generator::Box), _) => MeshSource::Box { lower: lower?, upper: upper?, cells: cells? },
        (None, Some(file)) => MeshSource::File(resolve(&s, "file", &file)),
        // A mistake was told; what follows is checked nevertheless.
        (None, None) => MeshSource::TurekHron,
    };
    s.finish();
    Some(MeshSpec { source, refine, grading, region })
}

fn regions(mut s: Section<'_, '_>) -> BTreeMap<String, Expression> {
    let mut regions = BTreeMap::new();
    for key in s.keys() {
        if let Some(expression) = s.expression(&key) {
            if expression.depends_on_time() {
                s.wrong(&key, "a region cannot depend on t");
            }
            if !is_name(&key) {
                s.wrong(&key, "expected a region name of letters, digits, `-` and `_`");
            }
            regions.insert(key, expression);
        }
    }
    regions
}

pub(super) fn space(mut s: Section<'_, '_>) -> SpaceSpec {
    let velocity = s.choice("velocity", &VELOCITIES, &[]);
    let pressure = s.choice("pressure", &PRESSURES, &[]);
    let velocity = velocity.unwrap_or(VelocityElement::Q(2));
    let quadrature = s.integer("quadrature", velocity.quadrature(), 2..=8);
    s.finish();
    SpaceSpec { velocity, pressure: pressure.unwrap_or(velocity.pressure()), quadrature }
}

/// Refuse pairs of velocity and pressure for which the flow has no unique solution.
pub(super) fn refuse_pair(s: &Section<'_, '_>, space: &SpaceSpec) {
    let SpaceSpec { velocity, pressure, .. } = *space;
    let (key, pair) = match s.has("pressure") {
        true => ("pressure", format!("with the velocity {}", velocity.name())),
        false => ("velocity", format!("with the pressure {}", pressure.name())),
    };
    match velocity.stability(pressure) {
        Stability::Stable => {}
        Stability::Equal => s.wrong(
            key,
            format!(
                "{pair} a pair of equal order, which needs stabilisation (inf-sup condition (5.24)); \
                 velocities of degree 2 and above with their default pressure do not"
            ),
        ),
        Stability::Refused(reason) => s.wrong("pressure", reason),
    }
}

fn region(s: &mut Section<'_, '_>, default: &str) -> String {
    let region = s.string("region").unwrap_or_else(|| default.into());
    if !is_name(&region) {
        s.wrong("region", "expected a region name of letters, digits, `-` and `_`");
    }
    region
}

pub(super) fn fluid(mut s: Section<'_, '_>) -> Option<FluidSpec> {
    if !s.is_present() {
        return None;
    }
    let spec = FluidSpec {
        region: region(&mut s, "fluid"),
        density: s.required_number("density", POSITIVE, "the density [kg/m³]"),
        kinematic_viscosity: s.required_number(
            "kinematic-viscosity",
            POSITIVE,
            "the kinematic viscosity [m²/s]",
        ),
        body_force: s.expressions("body-force").unwrap_or_default(),
    };
    s.finish();
    Some(spec)
}

pub(super) fn solid(mut s: Section<'_, '_>) -> Option<SolidSpec> {
    if !s.is_present() {
        return None;
    }
    let laws = [("st-venant-kirchhoff", SolidLaw::StVenantKirchhoff)];
    let later = ["neo-hookean", "mooney-rivlin", "linear", "incompressible-neo-hookean"];
    let region = region(&mut s, "solid");
    let law = s.choice("law", &laws, &later).unwrap_or(SolidLaw::StVenantKirchhoff);
    let density = s.required_number("density", POSITIVE, "the density [kg/m³]");
    let (mu, lambda) = moduli(&mut s);
    let body_force = s.expressions("body-force").unwrap_or_default();
    s.finish();
    Some(SolidSpec { region, law, density, mu, lambda, body_force })
}

/// μ and λ \[Pa\], given as such or as Young's modulus and Poisson ratio.
fn moduli(s: &mut Section<'_, '_>) -> (f64, f64) {
    let mu = s.optional_number("mu", POSITIVE);
    let lambda = s.optional_number("lambda", ANY);
    let young = s.optional_number("young", POSITIVE);
    let poisson = s.optional_number("poisson", POISSON);
    let lame = s.has("mu") || s.has("lambda");
    let engineering = s.has("young") || s.has("poisson");
    for key in ["young", "poisson"] {
        if lame && s.has(key) {
            s.wrong(key, "give either `mu` and `lambda` or `young` and `poisson`");
        } else if engineering && !lame && !s.has(key) {
            s.missing(key, "`young` [Pa] and `poisson` belong together");
        }
    }
    for key in ["mu", "lambda"] {
        if !engineering && !s.has(key) {
            s.missing(key, "the moduli `mu` and `lambda` [Pa], or `young` [Pa] and `poisson`");
        } else if engineering && lame && !s.has(key) {
            s.missing(key, "`mu` and `lambda` [Pa] belong together");
        }
    }
    if let (Some(young), Some(poisson)) = (young, poisson) {
        let mu = young / (2.0 * (1.0 + poisson));
        return (mu, young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)));
    }
    if let (Some(mu), Some(lambda)) = (mu, lambda)
        && 3.0 * lambda + 2.0 * mu <= 0.0
    {
        s.wrong("lambda", format!("expected a number above -2/3 mu = {} Pa", -2.0 / 3.0 * mu));
    }
    (mu.unwrap_or(1.0), lambda.unwrap_or(1.0))
}

pub(super) fn motion(mut s: Section<'_, '_>) -> MotionSpec {
    let models = [("harmonic", MotionModel::Harmonic), ("pseudo-elastic", MotionModel::PseudoElastic)];
    let later = ["stiffened-harmonic", "jacobian-stiffened", "biharmonic"];
    let spec = MotionSpec {
        model: s.choice("model", &models, &later).unwrap_or(MotionModel::PseudoElastic),
        poisson: s.number("poisson", 0.0, POISSON),
        offset: s.number("offset", 0.01, POSITIVE),
        exponent: s.number("exponent", 2.0, NOT_NEGATIVE),
    };
    s.choice("walls", &[("fixed", ())], &["sliding"]);
    s.finish();
    spec
}
