//! What one step gave.

use std::ops::Index;
use std::sync::Arc;

/// What one step gave. A functional is found by its name.
///
/// ```
/// # use undula::{CaseBuilder, Simulation};
/// let case = CaseBuilder::load("csm1")?.set("mesh.refine", 0).build()?;
/// let row = Simulation::new(case, 1)?.step()?;
/// assert_eq!(row["uy_A"], row.values[1]);
/// assert_eq!(row.get("drag"), None);
/// assert_eq!(row.names(), ["ux_A", "uy_A"]);
/// # Ok::<(), undula::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Number of the step, from 1; 0 for a stationary solution.
    pub step: u64,
    /// Time \[s\].
    pub time: f64,
    /// Time t⁻ + θ k to which pressure and forces belong \[s\].
    pub force_time: f64,
    /// Functionals in the order of [`Row::names`].
    pub values: Vec<f64>,
    /// Smallest J at the quadrature points.
    pub min_j: f64,
    /// Newton iterations.
    pub newton_steps: usize,
    /// Jacobians assembled.
    pub jacobians: usize,
    /// How often factors, or a cycle of multigrid, were applied.
    pub linear_iterations: usize,
    pub(crate) names: Arc<[String]>,
}

impl Row {
    /// Names of the functionals.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The functional `name`, `None` if there is none of that name.
    pub fn get(&self, name: &str) -> Option<f64> {
        let at = self.names.iter().position(|n| n == name)?;
        self.values.get(at).copied()
    }
}

/// The functional of that name.
///
/// # Panics
/// If there is none.
impl Index<&str> for Row {
    type Output = f64;

    fn index(&self, name: &str) -> &f64 {
        match self.names.iter().position(|n| n == name) {
            Some(at) => &self.values[at],
            None => panic!("no functional `{name}`; there are {}", self.names.join(", ")),
        }
    }
}
