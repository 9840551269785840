//! How well posed the discrete problem is: inf-sup constants (5.24), (5.25) and condition numbers (5.35).
//!
//! The chapter has two warnings: that the constant of the moved domain may be much smaller than that of the reference
//! domain, and that the coupled matrix may be so badly conditioned that direct solvers fail. Both are numbers here.

pub mod condition;
pub mod inf_sup;
mod lanczos;

pub use condition::{Condition, condition};
pub use inf_sup::{InfSup, inf_sup};

use crate::algebra::{Csr, SolverError};
use crate::physics::{Kinematics, StepRule};
use crate::simulation::Simulation;
use crate::space::{FsiSpace, PsiOwner, State};
use crate::system::StepView;
use crate::tangent::Tangent;
use crate::time::Stepper;

/// Both constants, and the smallest J of the deformation.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Constants {
    /// On the reference domain, (5.25).
    pub reference: InfSup,
    /// On the moved domain, (5.24).
    pub moved: InfSup,
    /// Smallest J of the fluid at the quadrature points.
    pub min_j: f64,
}

/// Condition numbers of the coupled matrix and of its diagonal blocks, those that there are.
pub type Conditions = Vec<(&'static str, Condition)>;

/// The constants of `simulation` with its present deformation, or with [`sample_deformation`]; `None` without fluid.
///
/// # Errors
/// If a matrix cannot be factorised.
pub fn constants<const D: usize>(
    simulation: &Simulation<D>,
    present: bool,
) -> Result<Option<Constants>, SolverError> {
    let assembler = &simulation.stepper.assembler;
    let (space, quadrature) = (&*assembler.space, simulation.case.space.quadrature);
    if assembler.physics.fluid.is_none() {
        return Ok(None);
    }
    // The constants are those of the flow, whatever pressure the solid has.
    let (mesh, regions, seams) = (space.mesh.clone(), space.regions.clone(), space.seams.clone());
    let (degree, kind) = (space.nodes.degree, space.pressure.kind);
    let space = match space.nodes.n_lagrange < space.nodes.len() {
        true => FsiSpace::with_bubbles(mesh, regions, degree, kind),
        false => FsiSpace::new(mesh, regions, degree, kind),
    };
    let space = &space.joined(seams);
    let u = if present { simulation.stepper.new.u.clone() } else { sample_deformation(space) };
    Ok(Some(Constants {
        reference: inf_sup(space, &assembler.constraints, &[], quadrature)?,
        moved: inf_sup(space, &assembler.constraints, &u, quadrature)?,
        min_j: min_j(space, &u, quadrature),
    }))
}

/// A smooth deformation that leaves the smallest box around the domain where it is:
/// u = 0.15 l sin(π s) sin(π t) (0.6, 0.8) with s, t in \[0, 1\] along its sides, of which l is the shortest.
pub fn sample_deformation<const D: usize>(space: &FsiSpace<D>) -> Vec<f64> {
    let points = &space.nodes.points;
    let end = |d: usize, f: fn(f64, f64) -> f64, start: f64| points.iter().map(|x| x[d]).fold(start, f);
    let lower: [f64; D] = std::array::from_fn(|d| end(d, f64::min, f64::INFINITY));
    let length: [f64; D] = std::array::from_fn(|d| end(d, f64::max, f64::NEG_INFINITY) - lower[d]);
    let size = 0.15 * length.into_iter().fold(f64::INFINITY, f64::min);
    let bump = |x: &[f64; D]| -> f64 {
        (0..D).map(|d| (std::f64::consts::PI * (x[d] - lower[d]) / length[d]).sin()).product()
    };
    // Bubbles are of the velocity alone.
    let height = |(node, x): (usize, &[f64; D])| if node < space.nodes.n_lagrange { bump(x) } else { 0.0 };
    let moved = |h: f64| (0..D).map(move |d| size * h * [0.6, 0.8, 0.0][d]);
    points.iter().enumerate().map(height).flat_map(moved).collect()
}

fn min_j<const D: usize>(space: &FsiSpace<D>, u: &[f64], quadrature: usize) -> f64 {
    let mut state = State::zero(space.n_v(), space.n_v(), space.n_p());
    state.u[..u.len()].copy_from_slice(u);
    let mut min = f64::INFINITY;
    crate::sampling::for_each_point(space, &state, quadrature, |point| {
        if !point.pressure.is_empty() {
            min = min.min(Kinematics::of(&point.fields.grad_u).J);
        }
    });
    min
}

/// The whole Jacobian (5.35) of the next step at the present state, or of the stationary problem.
///
/// # Errors
/// If memory is short, or the problem too large.
pub(super) fn whole_jacobian<const D: usize>(simulation: &mut Simulation<D>) -> Result<Csr, SolverError> {
    let now = simulation.stepper.time;
    let rule = match (&simulation.case.time, simulation.case.theta()) {
        (Some(time), Some(theta)) => StepRule::theta(time.step.eval(&[0.0; 3], now), theta),
        _ => StepRule::STATIONARY,
    };
    let Stepper { assembler, new, .. } = &mut simulation.stepper;
    let mut matrix = Csr::zeros(&assembler.try_pattern()?);
    assembler.jacobian(&StepView { rule, new, old: new }, Tangent::Automatic, &mut matrix);
    Ok(matrix)
}

/// Condition numbers of the whole Jacobian (5.35) of the next step at the present state, or of the stationary problem.
///
/// # Errors
/// If memory is short, or the problem too large.
pub fn conditions<const D: usize>(simulation: &mut Simulation<D>) -> Result<Conditions, SolverError> {
    let matrix = whole_jacobian(simulation)?;
    let assembler = &simulation.stepper.assembler;
    let space = &*assembler.space;
    let (unknowns, blocks) = (assembler.unknowns(), blocks(space, &assembler.constraints));
    let mut list = vec![];
    for (name, keep) in blocks {
        if !keep.is_empty() {
            list.push((name, condition(&matrix, &unknowns, &keep)?));
        }
    }
    Ok(list)
}

/// Unknowns of the blocks by name.
fn blocks<const D: usize>(
    space: &FsiSpace<D>,
    constraints: &crate::space::Constraints<D>,
) -> Vec<(&'static str, Vec<u32>)> {
    let (n_v, n_u) = (space.n_v(), space.n_u());
    let of_fluid = |node: usize| space.owner[node] == PsiOwner::Extension;
    let places = |first: usize, given: &dyn Fn(usize, usize) -> bool, fluid: bool| -> Vec<u32> {
        let nodes = (0..space.nodes.len()).filter(|&node| of_fluid(node) == fluid);
        let all = nodes.flat_map(|node| (0..D).map(move |i| (node, i)));
        all.filter(|&(node, i)| !given(node, i)).map(|(node, i)| (first + node * D + i) as u32).collect()
    };
    let v = [true, false].map(|fluid| places(0, &|node, i| constraints.v[node][i], fluid));
    let there = space.deforms;
    let u = [true, false].map(|fluid| places(n_v, &|node, i| !there || constraints.u[node][i], fluid));
    let p: Vec<u32> = (n_v + n_u..space.n_field_unknowns()).map(|p| p as u32).collect();
    let join = |parts: &[&Vec<u32>]| -> Vec<u32> {
        let mut all: Vec<u32> = parts.iter().flat_map(|part| part.iter().copied()).collect();
        all.sort_unstable();
        all
    };
    let flow = if p.is_empty() { vec![] } else { join(&[&v[0], &p]) };
    vec![
        ("coupled matrix (5.35)", join(&[&v[0], &v[1], &u[0], &u[1], &p])),
        ("flow: div and NS, p and v", flow),
        ("momentum of the flow: NS, v", v[0].clone()),
        ("extension: ALE, u", u[0].clone()),
        ("solid with interface: ES and uv, v and u", join(&[&v[1], &u[1]])),
    ]
}
