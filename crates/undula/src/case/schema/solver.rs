//! How a case is computed and what is written: steps in time, nonlinear and linear solver, output.

use crate::algebra::petsc::USUAL_OPTIONS;
use crate::algebra::{Engine, GmresSettings, LinearSolverKind, Precision};
use crate::case::expression::Expression;
use crate::choice::{Choice, choice};
use crate::functional::nodal::NodalField;
use crate::tangent::{Linearization, Tangent};
use crate::time::{AdaptiveSettings, DomainMotion, NewtonSettings, Scheme};

/// Time interval and scheme.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeSpec {
    /// One-step scheme.
    pub scheme: Scheme,
    /// Step k \[s\], an expression of t (its value at the start of the step counts).
    pub step: Expression,
    /// First time \[s\].
    pub start: f64,
    /// Last time \[s\]; the last step is shortened to land on it.
    pub end: f64,
    /// How often a failed step is halved before the run ends as a breakdown.
    pub max_halvings: u32,
    /// Where in the step the factors of ∂_t in the fluid are taken; `bdf2` and `cg1` have their own.
    pub domain_motion: DomainMotion,
    /// Control of the step by its local error; `step` is then the first.
    pub adaptive: Option<AdaptiveSettings>,
}

/// Nonlinear solver.
#[derive(Clone, Debug, PartialEq)]
pub struct NewtonSpec {
    /// Which derivatives the matrix holds.
    pub linearization: Linearization,
    /// How they are computed.
    pub jacobian: Tangent,
    /// Start from the linear extrapolation of the last two solutions instead of the last.
    pub extrapolate: bool,
    /// When an iteration stops, and when it renews the Jacobian.
    pub settings: NewtonSettings,
}

impl Default for NewtonSpec {
    fn default() -> Self {
        NewtonSpec {
            linearization: Linearization::Condensed,
            jacobian: Tangent::Automatic,
            extrapolate: true,
            settings: NewtonSettings {
                tolerance: 1e-8,
                floor: None,
                rate_max: None,
                secants: 0,
                max_steps: 30,
                line_search: 5,
            },
        }
    }
}

/// Linear solver.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearSpec {
    /// Who solves the systems of Newton's method.
    pub engine: Engine,
    /// Options of PETSc, where that is the engine.
    pub petsc: String,
    /// Which one of our own; with another engine that of the extension.
    pub solver: LinearSolverKind,
    /// Steps of iterative refinement at most.
    pub refinement: usize,
    /// Precision of the factors that only make corrections.
    pub precision: Precision,
    /// GMRES with the factors of an older matrix, `None`: corrections from factors alone.
    pub krylov: Option<GmresSettings>,
}

impl Default for LinearSpec {
    fn default() -> Self {
        LinearSpec {
            engine: Engine::Own,
            petsc: USUAL_OPTIONS.into(),
            solver: LinearSolverKind::Multifrontal,
            refinement: 2,
            precision: Precision::Single,
            krylov: None,
        }
    }
}

/// GMRES unless a case gives other numbers.
pub const GMRES: GmresSettings = GmresSettings { tolerance: 0.03, size: 20 };

/// The same with multigrid: after these iterations a step takes the direct solver.
pub const WITH_MULTIGRID: GmresSettings = GmresSettings { tolerance: 0.03, size: 60 };

/// Its name in a case, and that of none.
pub static KRYLOV: [Choice<Option<GmresSettings>>; 2] = [
    choice("none", None, "corrections from the factors alone"),
    choice("gmres", Some(GMRES), "GMRES, preconditioned by the factors of an older matrix"),
];

/// What is written.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputSpec {
    /// Write fields every this many steps (0: only at the end).
    pub fields_every: usize,
    /// Write fields every this many seconds after the start, too; steps end there. `None`: not so.
    pub fields_interval: Option<f64>,
    /// Write fields at the ends of steps nearest to these times \[s\], too.
    pub fields_times: Vec<f64>,
    /// Which fields are written.
    pub fields: Vec<NodalField>,
    /// First and last time \[s\] of the means that are written at the end; `None`: no means.
    pub window: Option<[f64; 2]>,
    /// Write the mesh deformed (default) or on the reference domain.
    pub deformed: bool,
    /// Write cells as curved as they are, not cut into straight ones.
    pub curved: bool,
    /// Write a checkpoint every this many steps (0: not by steps).
    pub checkpoint_every: usize,
    /// Write a checkpoint after this many minutes by the clock on the wall (0: not by time). There is one at the end
    /// of every run in time, whatever ends it.
    pub checkpoint_minutes: f64,
    /// Write a page about the run at its end.
    pub report: bool,
    /// Signal whose period fixes the window of the statistics; `None`: the first `uy_*`, else `lift`.
    pub leading: Option<String>,
}
