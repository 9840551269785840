//! What a solve has done, and what all have done together.

/// Work done so far.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Newton iterations.
    pub newton_steps: usize,
    /// Jacobians assembled.
    pub jacobians: usize,
    /// Factorisations.
    pub factorizations: usize,
    /// Iterations of the linear solver: residuals to which factors were applied.
    pub linear_iterations: usize,
    /// Steps that were begun anew with the whole Jacobian and a direct solver.
    pub fallbacks: usize,
}

/// How a solve went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NewtonReport {
    /// Iterations.
    pub steps: usize,
    /// Jacobians assembled in them.
    pub jacobians: usize,
    /// Iterations of the linear solver.
    pub linear_iterations: usize,
    /// Scaled residual at the start and after each iteration.
    pub norms: Vec<f64>,
}

/// Seconds spent by phase.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Seconds {
    /// Residuals and Jacobians.
    pub assembly: f64,
    /// Factorisations.
    pub factorization: f64,
    /// Triangular solves.
    pub solve: f64,
}
