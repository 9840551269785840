//! Why a step failed, and where.

use super::system::StepSystem;
use crate::algebra::{Kind, SolverError, Unknown};
use crate::math::{rounded, shortest};
use crate::nonlinear::{Newton, NewtonError};
use crate::space::{FsiSpace, PressureKind, PsiOwner, Region};
use crate::system::Worst;
use std::fmt;

/// A place of the reference domain.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    /// Coordinates \[m\].
    pub at: Vec<f64>,
    /// What is there, for people: `cell 12 at (0.41, 0.2) m`.
    pub text: String,
}

/// An equation of the discrete problem.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Equation {
    /// Momentum of the fluid.
    FluidMomentum,
    /// Momentum of the solid, interface included.
    SolidMomentum,
    /// Divergence.
    Divergence,
    /// Extension of the deformation into the fluid.
    Extension,
    /// Velocity-deformation relation of the solid.
    Relation,
    /// Equation of a scalar unknown.
    Scalar,
}

impl fmt::Display for Equation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Equation::FluidMomentum => "the momentum of the fluid",
            Equation::SolidMomentum => "the momentum of the solid",
            Equation::Divergence => "the divergence",
            Equation::Scalar => "the equation of a scalar unknown",
            Equation::Extension => "the extension",
            Equation::Relation => "the velocity-deformation relation",
        })
    }
}

/// Data of a case that are not finite.
#[derive(Clone, Debug, PartialEq)]
pub struct DataFault {
    /// Which.
    pub kind: DataKind,
    /// Where \[m\].
    pub at: Vec<f64>,
    /// When \[s\].
    pub time: f64,
    /// Their value there and then.
    pub value: Vec<f64>,
}

/// What can be given.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum DataKind {
    /// The velocity at a node of the boundary \[m/s\].
    Velocity {
        /// The node.
        node: u32,
    },
    /// The body force of a region \[m/s²\].
    Force {
        /// The kind of its body.
        body: Region,
        /// Number of the material.
        material: u16,
    },
    /// Data of the condition on a boundary.
    Condition {
        /// Its number in the mesh.
        boundary: u16,
    },
    /// Some, on another of the processes that share the space, which says more.
    Elsewhere,
}

/// How an iteration ended without a solution.
pub(super) struct Ended {
    pub reason: NewtonError,
    pub worst: Worst,
    pub cause: Box<Cause>,
}

/// Why a step failed.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// J ≤ 0: the domain map folds.
    Folding {
        /// In which body.
        region: Region,
        /// The smallest J.
        min_j: f64,
        /// Its cell.
        spot: Spot,
    },
    /// The nonlinear iteration does not converge, and nothing folds.
    Divergence {
        /// The equation of the largest residual.
        equation: Equation,
        /// The largest residual, scaled to the unit of a velocity \[m/s\].
        residual: f64,
        /// Its place.
        spot: Spot,
    },
    /// A linear iteration is too slow.
    Slow {
        /// Factor of the residual per iteration.
        rate: f64,
        /// Iterations done, all in all.
        done: usize,
        /// Iterations that would be left at this rate.
        left: f64,
        /// Iterations allowed.
        allowed: usize,
    },
    /// The matrix is singular.
    Singular {
        /// The field that is not determined.
        field: Kind,
        /// Where.
        spot: Spot,
    },
    /// A number is not finite, though all data are.
    NotFinite {
        /// The equation whose residual it is.
        equation: Equation,
        /// Its place.
        spot: Spot,
    },
    /// Data are not finite.
    Data(DataFault),
    /// The linear solver fails in another way.
    Solver(SolverError),
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Cause::Folding { region, min_j, spot } => {
                let body = if *region == Region::Solid { "the solid" } else { "the mesh of the fluid" };
                let min_j = shortest(rounded(*min_j, *min_j, 3));
                write!(f, "{body} folds, smallest J = {min_j} in {}", spot.text)
            }
            Cause::Divergence { equation, residual, spot } => write!(
                f,
                "the nonlinear iteration does not converge, its largest residual is that of {equation}, \
                 {residual:.2e} m/s (scaled) at {}",
                spot.text
            ),
            Cause::Slow { rate, done, left, allowed } if left.is_finite() => write!(
                f,
                "the nonlinear iteration converges too slowly, by the factor {rate:.3} per iteration: after {done} \
                 iterations about {left} more would be needed, and {allowed} are allowed"
            ),
            Cause::Slow { rate, done, .. } => write!(
                f,
                "the nonlinear iteration does not converge: after {done} iterations, those for parts of the load among \
                 them, its residual changes by the factor {rate:.3} in each"
            ),
            Cause::Singular { field, spot } => {
                write!(f, "the matrix is singular, nothing determines the {} of {}", name(*field), spot.text)
            }
            Cause::NotFinite { equation, spot } => {
                write!(f, "a value is not finite in {equation} at {}", spot.text)
            }
            Cause::Data(DataFault { kind, at, time, value }) => {
                let data = match kind {
                    DataKind::Velocity { .. } => "the velocity of the boundary",
                    DataKind::Force { .. } => "the body force",
                    DataKind::Condition { .. } => "the data of a boundary condition",
                    DataKind::Elsewhere => "a datum of another process",
                };
                write!(f, "{data} is not finite: {value:?} at {at:?} m, t = {time} s")
            }
            Cause::Solver(error) => error.fmt(f),
        }
    }
}

impl Cause {
    /// One word for programs.
    pub fn name(&self) -> &'static str {
        match self {
            Cause::Folding { .. } => "folding",
            Cause::Divergence { .. } => "divergence",
            Cause::Slow { .. } => "slow",
            Cause::Singular { .. } => "singular",
            Cause::NotFinite { .. } => "not-finite",
            Cause::Data(_) => "data",
            Cause::Solver(_) => "solver",
        }
    }

    /// Where it is.
    pub fn spot(&self) -> Option<&Spot> {
        match self {
            Cause::Folding { spot, .. }
            | Cause::Divergence { spot, .. }
            | Cause::Singular { spot, .. }
            | Cause::NotFinite { spot, .. } => Some(spot),
            Cause::Slow { .. } | Cause::Data(_) | Cause::Solver(_) => None,
        }
    }
}

fn name(field: Kind) -> &'static str {
    match field {
        Kind::Velocity => "velocity",
        Kind::Deformation => "deformation",
        Kind::Pressure => "pressure",
    }
}

/// Why `reason` ended the iteration of `system`, which is evaluated once more if need be.
pub(super) fn find<const D: usize>(
    system: &mut StepSystem<'_, D>,
    newton: &mut Newton,
    reason: NewtonError,
) -> Ended {
    let worst = system.assembler.worst();
    // Folding of an iterate ends the iteration in other words, too.
    if worst.min_j <= 0.0
        && let Some(&cell) = worst.cells.first()
    {
        let space = &system.assembler.space;
        let region = space.regions[cell as usize];
        let spot = cell_spot(space, cell as usize);
        let cause = Box::new(Cause::Folding { region, min_j: worst.min_j, spot });
        return Ended { reason, worst, cause };
    }
    let cause = match &reason {
        NewtonError::Linear(error) => of_solver(&system.assembler.space, error),
        NewtonError::Slow { norms, rate, left, allowed } => {
            Cause::Slow { rate: *rate, done: norms.len() - 1, left: *left, allowed: *allowed }
        }
        NewtonError::Stalled { .. } | NewtonError::Inadmissible | NewtonError::Stopped => {
            newton.norm(system);
            of_residual(system, newton.residual())
        }
    };
    Ended { reason, worst, cause: Box::new(cause) }
}

/// From the largest residual of `r`, `[v, u, p]`, or one that is not finite.
fn of_residual<const D: usize>(system: &StepSystem<'_, D>, r: &[f64]) -> Cause {
    let space = &*system.assembler.space;
    let mut weights = vec![0.0; r.len()];
    system.scales.weights(space, system.rule.per_k, &mut weights);
    let mut largest = (0, 0.0);
    for (i, (r, weight)) in r.iter().zip(&weights).enumerate() {
        let size = (r * weight).abs();
        if !size.is_finite() {
            let (equation, spot) = row(space, i);
            return Cause::NotFinite { equation, spot };
        }
        if size > largest.1 {
            largest = (i, size);
        }
    }
    let (equation, spot) = row(space, largest.0);
    Cause::Divergence { equation, residual: largest.1, spot }
}

fn of_solver<const D: usize>(space: &FsiSpace<D>, error: &SolverError) -> Cause {
    match error {
        SolverError::Singular { unknown, .. }
        | SolverError::ZeroRow { unknown, .. }
        | SolverError::ZeroColumn { unknown, .. } => {
            Cause::Singular { field: unknown.kind, spot: unknown_spot(space, unknown) }
        }
        SolverError::NotFinite { unknown, .. } | SolverError::RightHandSide { unknown, .. } => {
            let solid = space.owner.get(unknown.node as usize) == Some(&PsiOwner::Relation);
            let equation = match unknown.kind {
                Kind::Velocity if solid => Equation::SolidMomentum,
                Kind::Velocity => Equation::FluidMomentum,
                Kind::Deformation if solid => Equation::Relation,
                Kind::Deformation => Equation::Extension,
                Kind::Pressure => Equation::Divergence,
            };
            Cause::NotFinite { equation, spot: unknown_spot(space, unknown) }
        }
        other => Cause::Solver(other.clone()),
    }
}

/// The equation and place of row `i` of a residual `[v, u, p, s]`.
fn row<const D: usize>(space: &FsiSpace<D>, i: usize) -> (Equation, Spot) {
    let (n_v, n_u, fields) = (space.n_v(), space.n_u(), space.n_field_unknowns());
    if i >= fields {
        let text = format!("scalar unknown {}", i - fields);
        return (Equation::Scalar, Spot { at: vec![], text });
    }
    if i >= n_v + n_u {
        let spot = spot(space, "", &space.pressure.points[i - n_v - n_u]);
        return (Equation::Divergence, spot);
    }
    let node = i % n_v / D;
    let equation = match (i < n_v, space.owner[node]) {
        (true, PsiOwner::Extension) => Equation::FluidMomentum,
        (true, PsiOwner::Relation) => Equation::SolidMomentum,
        (false, PsiOwner::Extension) => Equation::Extension,
        (false, PsiOwner::Relation) => Equation::Relation,
    };
    (equation, spot(space, &format!("node {node} at "), &space.nodes.points[node]))
}

fn unknown_spot<const D: usize>(space: &FsiSpace<D>, unknown: &Unknown) -> Spot {
    let at = std::array::from_fn(|d| unknown.at[d]);
    // Pressures of cells are numbered behind the nodes.
    let cells = matches!(space.pressure.kind, PressureKind::Pdc(_)) && unknown.kind == Kind::Pressure;
    let place = if cells { "the cell at ".into() } else { format!("node {} at ", unknown.node) };
    spot(space, &place, &at)
}

/// The centre of a cell.
pub(super) fn cell_spot<const D: usize>(space: &FsiSpace<D>, cell: usize) -> Spot {
    spot(space, &format!("cell {cell} at "), &space.mesh.centre(cell))
}

fn spot<const D: usize>(space: &FsiSpace<D>, before: &str, at: &[f64; D]) -> Spot {
    Spot { at: at.to_vec(), text: format!("{before}{}", space.mesh.shown(at)) }
}
