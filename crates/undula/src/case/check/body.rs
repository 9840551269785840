//! The tables `[mesh]`, `[space]`, `[fluid]`, `[solid]` and `[motion]`.

use super::material::{self, Moduli, POISSON};
use super::resolve;
use crate::case::choices::BODY_FORCE_AT;
use crate::case::element::{PRESSURES, Stability, VELOCITIES};
use crate::case::error::quoted;
use crate::case::expression::Expression;
use crate::case::literal::{number, numbers};
use crate::case::read::{NOT_NEGATIVE, POSITIVE, Section, Vectors};
use crate::case::schema::{
    Extrude, FluidSpec, GENERATORS, MeshSource, MeshSpec, MotionModel, MotionSpec, PressureElement, SolidLaw,
    SolidSpec, SpaceSpec, VelocityElement,
};
use crate::case::synonyms::meant;
use crate::choice;
use crate::element::Shape;
use crate::mesh::gmsh;
use crate::physics::Reference;
use crate::physics::extension::{MOTIONS, OUTER, STIFFENING};
use crate::physics::solid_law::LAWS;
use crate::space::{COORDINATES, WALLS};
use std::collections::BTreeMap;
use std::path::Path;

pub(super) fn mesh(mut s: Section<'_, '_>, root: &Section<'_, '_>) -> Option<MeshSpec> {
    let generator = s.choice("generator", &GENERATORS, &[]);
    let file = s.string("file");
    let scale = s.number("scale", 1.0, POSITIVE);
    let coordinates = s.choice("coordinates", &COORDINATES, &[]).unwrap_or_default();
    root.checker.coordinates.set(coordinates);
    let refine = s.integer("refine", 0, 0..=10) as u32;
    let grading = s.integer("grading", 0, 0..=30) as u32;
    let extrude = extrude(s.section("extrude"));
    let in_space = matches!(generator, Some(MeshSource::Box { .. })) && s.length("lower") == Some(3);
    let generated = if in_space { Vectors::Space } else { Vectors::Plane };
    root.checker.vectors.set(generated);
    let (lower, upper, cells) = (s.point("lower"), s.point("upper"), s.counts("cells"));
    root.checker.vectors.set(match (&extrude, &file) {
        (Some(extrude), _) => Vectors::Extruded { middle: 0.5 * extrude.depth },
        (None, Some(file)) => of_file(&resolve(&s, "file", file)),
        (None, None) => generated,
    });
    let radii = s.pair("radii", POSITIVE);
    let region = regions(s.section("region"));
    let leave_out = s.names("leave-out", "[\"rock\"]", 0).unwrap_or_default();
    let own = root.checker.mesh;
    if own.is_some() {
        refuse_source(&s);
    } else if !s.is_present() {
        root.missing("mesh", "add [mesh] with generator = \"turek-hron\" or file = \"own.msh\"");
    } else if s.has("generator") && s.has("file") {
        s.wrong("file", "give either `generator` or `file`");
    } else if !s.has("generator") && !s.has("file") && !s.means("file") {
        let generators = quoted(choice::names(&GENERATORS));
        s.missing("generator", &format!("give `generator` ({generators}) or `file`"));
    }
    sizes_belong(&s, generator.as_ref(), file.is_some());
    if s.has("scale") && file.is_none() {
        s.wrong("scale", "only for `file`: the generators make meshes in metres");
    }
    if let (Some(a), Some(b)) = (&lower, &upper)
        && a.iter().zip(b).any(|(a, b)| a >= b)
    {
        let place = if in_space { "right of, above and behind" } else { "right of and above" };
        s.wrong("upper", format!("expected a corner {place} `lower` = {}", numbers(a)));
    }
    if in_space && extrude.is_some() {
        s.wrong("extrude", "only for meshes of the plane: this box is one of space");
    }
    if let Some(MeshSource::Annulus { .. }) = generator {
        check_ring(&s, radii, cells.as_deref());
    }
    let source = match (generator, file) {
        (Some(MeshSource::Annulus { .. }), _) => MeshSource::Annulus { radii: radii?, cells: <[usize; 2]>::try_from(cells?).ok()? },
        (Some(MeshSource::Box { .. }), _) => MeshSource::Box { lower: lower?, upper: upper?, cells: cells? },
        (Some(generator), _) => generator,
        (None, Some(file)) => MeshSource::File(resolve(&s, "file", &file)),
        // A mistake was told; what follows is checked nevertheless.
        (None, None) => MeshSource::TurekHron,
    };
    let source = own.map_or(source, |mesh| MeshSource::Own(mesh.clone()));
    s.finish();
    let dimension = root.checker.vectors.get().len();
    Some(MeshSpec { source, dimension, scale, extrude, coordinates, refine, grading, region, leave_out, absent: vec![] })
}

/// How many components vectors have on the mesh in a file; as in the plane if it cannot be read, which is told later.
fn of_file(path: &Path) -> Vectors {
    match gmsh::dimension(path) {
        Ok(3) => Vectors::Space,
        _ => Vectors::Plane,
    }
}

/// How a plane mesh becomes one of space.
fn extrude(mut s: Section<'_, '_>) -> Option<Extrude> {
    if !s.is_present() {
        return None;
    }
    for (key, about) in [("depth", "the extent along z [m], such as 0.1"), ("layers", "the number of layers, such as 1")] {
        if !s.has(key) {
            s.missing(key, about);
        }
    }
    let (depth, layers) = (s.number("depth", 1.0, POSITIVE), s.integer("layers", 1, 1..=100_000));
    s.finish();
    Some(Extrude { depth, layers: layers as usize })
}

/// Refuses sizes of another generator, and misses those of this one.
fn sizes_belong(s: &Section<'_, '_>, generator: Option<&MeshSource>, file: bool) {
    let is_box = matches!(generator, Some(MeshSource::Box { .. }));
    let is_ring = matches!(generator, Some(MeshSource::Annulus { .. }));
    for (key, of_box, of_ring) in [
        ("lower", true, false),
        ("upper", true, false),
        ("radii", false, true),
        ("cells", true, true),
        ("region", true, true),
    ] {
        let is_used = (is_box && of_box) || (is_ring && of_ring);
        if s.has(key) && !is_used && (generator.is_some() || file) {
            let generators = match (of_box, of_ring) {
                (true, true) => "\"box\" or \"annulus\"",
                (true, false) => "\"box\"",
                _ => "\"annulus\"",
            };
            s.wrong(key, format!("only for generator = {generators}"));
        } else if is_box && is_used && !s.has(key) && key != "region" {
            s.missing(key, "a box needs `lower` and `upper` corner [m] and `cells` per direction");
        } else if is_ring && is_used && !s.has(key) && key != "region" {
            s.missing(
                key,
                "an annulus needs `radii` [m], as [1, 2], and `cells` round and across, as [16, 4]",
            );
        }
    }
}

/// Refuses a ring that has no thickness, or that has no vertices on the axes.
fn check_ring(s: &Section<'_, '_>, radii: Option<[f64; 2]>, cells: Option<&[usize]>) {
    if radii.is_some_and(|[inner, outer]| inner >= outer) {
        s.wrong("radii", "expected the radius of the inner circle, then the larger one of the outer circle");
    }
    if cells.is_some_and(|cells| !cells[0].is_multiple_of(4)) {
        s.wrong("cells", "expected a multiple of 4 round, as [16, 4]");
    }
}

/// Keys that say where the mesh comes from, if the program gives it.
fn refuse_source(s: &Section<'_, '_>) {
    for key in ["generator", "file", "grading", "lower", "upper", "radii", "cells", "region"] {
        if s.has(key) {
            s.wrong(key, "the program gives the mesh");
        }
    }
}

/// What names of regions and boundaries must be: those of a Gmsh file may have spaces and dots.
pub(super) const NAME: &str = "expected a name that is not empty, in one line";

pub(super) fn names_something(name: &str) -> bool {
    !name.trim().is_empty() && !name.chars().any(char::is_control)
}

fn regions(mut s: Section<'_, '_>) -> BTreeMap<String, Expression> {
    let mut regions = BTreeMap::new();
    for key in s.keys() {
        if let Some(expression) = s.expression(&key) {
            if expression.depends_on_time() {
                s.wrong(&key, "a region cannot depend on t");
            }
            if !names_something(&key) {
                s.wrong(&key, NAME);
            }
            regions.insert(key, expression);
        }
    }
    regions
}

/// The velocity unless one is asked for: Q2, on the triangles of a file P2.
fn default_velocity(mesh: Option<&MeshSpec>, pressure: Option<PressureElement>) -> VelocityElement {
    let triangles = match mesh.map(|mesh| &mesh.source) {
        Some(MeshSource::File(path)) => match gmsh::shape(path) {
            Ok(shape) => shape == Shape::Triangle,
            // What is wrong with the file is told when the mesh is made, and should be the only thing that is told.
            Err(_) => matches!(pressure, Some(PressureElement::P(_))),
        },
        Some(MeshSource::Own(mesh)) => mesh.0.shape == Shape::Triangle,
        _ => false,
    };
    if triangles { VelocityElement::P(2) } else { VelocityElement::Q(2) }
}

pub(super) fn space(mut s: Section<'_, '_>, mesh: Option<&MeshSpec>) -> SpaceSpec {
    let velocity = s.choice("velocity", &VELOCITIES, &[]);
    let pressure = s.choice("pressure", &PRESSURES, &[]);
    let velocity = velocity.unwrap_or_else(|| default_velocity(mesh, pressure));
    let quadrature = s.integer("quadrature", velocity.quadrature(), 2..=8);
    s.finish();
    SpaceSpec { velocity, pressure: pressure.unwrap_or(velocity.pressure()), quadrature }
}

/// Refuse pairs of velocity and pressure for which the flow has no unique solution.
pub(super) fn refuse_pair(s: &Section<'_, '_>, space: &SpaceSpec) {
    let SpaceSpec { velocity, pressure, .. } = *space;
    // What pairs of equal order need is checked with `[stabilization]`.
    if let Stability::Refused(reason) = velocity.stability(pressure) {
        s.wrong("pressure", reason);
    }
}

/// A fluid in `regions`.
pub(super) fn fluid(mut s: Section<'_, '_>, name: Option<String>, regions: Vec<String>) -> FluidSpec {
    let density = s.required_number("density", POSITIVE, "the density [kg/m³]");
    let (kinematic_viscosity, thinning) = material::viscosity(&mut s, density);
    let spec = FluidSpec {
        name,
        regions,
        density,
        kinematic_viscosity,
        thinning,
        body_force: s.expressions_or_zero("body-force"),
        force_at_current: s.choice("body-force-at", &BODY_FORCE_AT, &[]).unwrap_or(false),
    };
    if spec.thinning.is_none() {
        explain_viscosity(&mut s);
    }
    if spec.force_at_current && !spec.body_force.iter().any(Expression::depends_on_space) {
        let table = &s.path;
        let note = format!("{table}.body-force-at has no effect: {table}.body-force is the same everywhere");
        s.checker.notes.borrow_mut().push(note);
    }
    s.finish();
    spec
}

/// ν = μ/ρ for those who know μ.
fn explain_viscosity(s: &mut Section<'_, '_>) {
    let density = s.look_at_number("density").filter(|rho| *rho > 0.0);
    for key in s.keys() {
        if meant("fluid", &key) != Some("kinematic-viscosity") || key.to_lowercase().starts_with("nu") {
            continue;
        }
        let value = s.look_at_number(&key).zip(density).map(|(mu, rho)| format!(" = {}", number(mu / rho)));
        let nu = format!("kinematic-viscosity{} [m²/s], which is mu/density", value.unwrap_or_default());
        let message = if s.has("kinematic-viscosity") {
            "`kinematic-viscosity` is given; remove this".into()
        } else if matches!(&*key.to_lowercase(), "viscosity" | "kinematic") {
            format!(
                "`kinematic-viscosity` [m²/s] is needed; if this is the dynamic viscosity mu [Pa s], write {nu}"
            )
        } else {
            format!("the kinematic viscosity is needed: write {nu}")
        };
        s.explain(&key, message);
    }
}

/// A solid in `regions`.
pub(super) fn solid(mut s: Section<'_, '_>, name: Option<String>, regions: Vec<String>) -> SolidSpec {
    let law = s.choice("law", &LAWS, &[]).unwrap_or(SolidLaw::StVenantKirchhoff);
    let density = s.required_number("density", POSITIVE, "the density [kg/m³]");
    let Moduli { mu, lambda, c2, bulk, ogden, fibres } = material::law_constants(&mut s, law);
    let [viscosity, damping_mass, damping_stiffness] = material::damping(&mut s);
    let body_force = s.expressions_or_zero("body-force");
    let prestressed = s.boolean("prestress", false);
    s.finish();
    SolidSpec {
        name,
        regions,
        law,
        own: None,
        density,
        mu,
        lambda,
        c2,
        ogden,
        fibres,
        bulk,
        viscosity,
        damping_mass,
        damping_stiffness,
        body_force,
        reference: if prestressed { Reference::Loaded } else { Reference::Free },
    }
}

/// The pressure of a solid has no stabilisation.
pub(super) fn refuse_unstable_solid(s: &Section<'_, '_>, solid: &SolidSpec, space: &SpaceSpec) {
    if solid.law.is_incompressible() && space.velocity.stability(space.pressure) != Stability::Stable {
        let (velocity, pressure) = (space.velocity.name(), space.pressure.name());
        let message = format!(
            "{velocity} with {pressure} is not stable, and stabilisation is for the fluid only: take a pair such as \
             Q2 with P1dc or Q1"
        );
        s.wrong("law", message);
    }
}

/// `moves`: whether the case has a last step to take J from.
pub(super) fn motion(mut s: Section<'_, '_>, moves: bool, velocity: VelocityElement) -> MotionSpec {
    let model = s.choice("model", &MOTIONS, &[]).unwrap_or(MotionModel::PseudoElastic);
    if model == MotionModel::Biharmonic && velocity.degree() == 1 {
        let other = if velocity.shape() == Shape::Triangle { "P2" } else { "Q2" };
        let message = format!(
            "the mixed form does not converge with elements of degree 1; take `{other}` or higher as space.velocity"
        );
        s.wrong("model", message);
    }
    let jacobian = s.choice("jacobian", &STIFFENING, &[]);
    if jacobian == Some(true) && !moves {
        s.wrong("jacobian", "a stationary case has no last step to take J from; use `implicit`");
    }
    let walls = s.choice("walls", &WALLS, &[]);
    let outer = s.choice("outer", &OUTER, &[]);
    let spec = MotionSpec {
        model,
        poisson: s.number("poisson", 0.0, POISSON),
        offset: s.optional_number("offset", POSITIVE),
        exponent: s.number("exponent", 2.0, NOT_NEGATIVE),
        scale: s.optional_number("scale", POSITIVE),
        lagged: jacobian.filter(|_| model == MotionModel::JacobianStiffened).unwrap_or(moves),
        hinged: outer.unwrap_or(false),
        walls: walls.unwrap_or_default(),
    };
    let used = [
        ("scale", model == MotionModel::StiffenedHarmonic),
        ("jacobian", model == MotionModel::JacobianStiffened),
        ("outer", model == MotionModel::Biharmonic),
    ];
    for (key, _) in used.into_iter().filter(|(key, used)| !used && s.has(key)) {
        let note = format!("motion.{key} has no effect with this motion.model");
        s.checker.notes.borrow_mut().push(note);
    }
    s.finish();
    spec
}
