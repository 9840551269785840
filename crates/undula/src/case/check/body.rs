//! The tables `[mesh]`, `[space]`, `[fluid]`, `[solid]` and `[motion]`.

use super::material::{self, Moduli, POISSON};
use crate::case::choices::BODY_FORCE_AT;
use crate::case::element::{PRESSURES, Stability, VELOCITIES};
use crate::case::expression::Expression;
use crate::case::literal::number;
use crate::case::read::{NOT_NEGATIVE, POSITIVE, Section};
use crate::case::schema::{
    FluidSpec, MeshSource, MeshSpec, MotionModel, MotionSpec, PressureElement, SolidLaw, SolidSpec,
    SpaceSpec, VelocityElement,
};
use crate::case::synonyms::meant;
use crate::mesh::gmsh;
use crate::physics::Reference;
use crate::physics::extension::{MOTIONS, OUTER, STIFFENING};
use crate::physics::solid_law::LAWS;
use crate::space::WALLS;

/// What names of regions and boundaries must be: those of a Gmsh file may have spaces and dots.
pub(super) const NAME: &str = "expected a name that is not empty, in one line";

pub(super) fn names_something(name: &str) -> bool {
    !name.trim().is_empty() && !name.chars().any(char::is_control)
}

/// The velocity unless one is asked for: Q2, on the triangles or tetrahedra of a file P2.
fn default_velocity(mesh: Option<&MeshSpec>, pressure: Option<PressureElement>) -> VelocityElement {
    let triangles = match mesh.map(|mesh| &mesh.source) {
        Some(MeshSource::File(path)) => match gmsh::shape(path) {
            Ok(shape) => shape.is_simplex(),
            // What is wrong with the file is told when the mesh is made, and should be the only thing that is told.
            Err(_) => matches!(pressure, Some(PressureElement::P(_))),
        },
        Some(MeshSource::Own(mesh)) => mesh.0.shape.is_simplex(),
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
    match velocity.stability_in(s.checker.vectors.get().len(), pressure) {
        Stability::Refused(reason) => s.wrong("pressure", reason),
        Stability::Stable | Stability::Equal => {}
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
        s.note(note);
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
        let other = if velocity.is_simplicial() { "P2" } else { "Q2" };
        let message = format!(
            "the mixed form does not converge with elements of degree 1; take `{other}` or higher as space.velocity"
        );
        s.wrong("model", message);
    }
    if model == MotionModel::Biharmonic && velocity.is_simplicial() && s.checker.vectors.get().len() == 3 {
        let message = "on tetrahedra it is not yet available: the integrals of their basis are not all positive; \
                       expected another model, or hexahedra (`Q2` as space.velocity)";
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
        s.note(note);
    }
    s.finish();
    spec
}
