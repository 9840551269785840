//! How a case is computed and what is written: steps in time, nonlinear and linear solver, output.

use crate::algebra::{LinearSolverKind, Precision};
use crate::case::expression::Expression;
use crate::choice::{Choice, choice};
use crate::functional::nodal::NodalField;
use crate::tangent::{Linearization, Tangent};
use crate::time::{AdaptiveSettings, DomainMotion, Scheme};

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
    /// γ_nt: a Jacobian is kept while the residual shrinks at least by this factor per iteration. `None`:
    /// as long as that costs less than a new one.
    pub rate_max: Option<f64>,
    /// Pairs of differences that improve the corrections of a kept Jacobian.
    pub secants: usize,
    /// Reduction of the scaled residual relative to the old solution.
    pub tolerance: f64,
    /// Absolute floor of the scaled residual \[m/s\]; `None`: what rounding leaves of a solution of that size.
    pub floor: Option<f64>,
    /// Iterations per step before it counts as failed.
    pub max_steps: usize,
    /// Start from the linear extrapolation of the last two solutions instead of the last.
    pub extrapolate: bool,
    /// Halvings of the update before a step counts as failed.
    pub line_search: usize,
}

impl Default for NewtonSpec {
    fn default() -> Self {
        NewtonSpec {
            linearization: Linearization::Condensed,
            jacobian: Tangent::Automatic,
            rate_max: None,
            secants: 0,
            tolerance: 1e-8,
            floor: None,
            max_steps: 30,
            extrapolate: true,
            line_search: 5,
        }
    }
}

/// Linear solver.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearSpec {
    /// Which one.
    pub solver: LinearSolverKind,
    /// Steps of iterative refinement at most.
    pub refinement: usize,
    /// Precision of the factors that only make corrections.
    pub precision: Precision,
    /// GMRES with the factors of an older matrix, `None`: corrections from factors alone.
    pub krylov: Option<KrylovSpec>,
}

impl Default for LinearSpec {
    fn default() -> Self {
        LinearSpec {
            solver: LinearSolverKind::Multifrontal,
            refinement: 2,
            precision: Precision::Single,
            krylov: None,
        }
    }
}

/// GMRES, preconditioned by kept factors.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct KrylovSpec {
    /// Residual of the linear system relative to its right-hand side.
    pub tolerance: f64,
    /// Iterations at most, before the factors are renewed.
    pub size: usize,
}

impl KrylovSpec {
    /// What holds unless a case gives other numbers.
    pub const DEFAULT: KrylovSpec = KrylovSpec { tolerance: 0.03, size: 20 };
}

/// Their names in a case.
pub static KRYLOV: [Choice<Option<KrylovSpec>>; 2] = [
    choice("none", None, "corrections from the factors alone"),
    choice("gmres", Some(KrylovSpec::DEFAULT), "GMRES, preconditioned by the factors of an older matrix"),
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
    /// Signal whose period fixes the window of the statistics; `None`: the first `uy_*`, else `lift`.
    pub leading: Option<String>,
}
