//! All Jacobians of a case beside each other at one state: what a person who changes the physics needs.
//!
//! ```no_run
//! use undula::{case::Case, simulation::Simulation, verification::jacobians};
//! let mut simulation = Simulation::new(Case::load("fsi3", &[])?, 1)?;
//! let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 1 })?;
//! assert!(report.agrees(), "{report}");
//! # Ok::<(), undula::error::Error>(())
//! ```

mod blocks;
pub mod differences;
mod state;
mod table;

pub use blocks::{Block, Entry, Equation, Field, Unknown};

use self::differences::Differences;
use crate::algebra::{Csr, SolverError};
use crate::choice::Choice;
use crate::physics::StepRule;
use crate::simulation::Simulation;
use crate::space::State;
use crate::system::{Assembler, StepView};
use crate::tangent::{Difference, LINEARIZATIONS, Linearization, Stencil, Tangent};
use blocks::Blocks;
use state::Setting;

/// The state at which Jacobians are compared.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum At {
    /// A random one on the way from the start of the case: velocities of 1 m/s, deformations of a tenth of the
    /// distance of nodes, the boundary data of the first step.
    Random {
        /// Of the random numbers.
        seed: u64,
    },
    /// That of the simulation, as [`crate::run::restore_latest`] leaves it.
    Present,
}

/// One matrix beside the automatic Jacobian.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Which one.
    pub name: String,
    /// Deviation up to which they count as equal.
    pub tolerance: f64,
    /// Where they differ most.
    pub worst: Option<Entry>,
    /// Largest deviation of each block that is not empty.
    pub blocks: Vec<(Block, f64)>,
}

impl Comparison {
    /// Whether all entries agree.
    pub fn agrees(&self) -> bool {
        self.blocks.iter().all(|(_, deviation)| *deviation <= self.tolerance)
    }
}

/// What a linearisation leaves out of the Jacobian, by block.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Which linearisation.
    pub name: String,
    /// Largest deviation of each block that is not empty, relative as in [`Comparison`].
    pub blocks: Vec<(Block, f64)>,
}

/// The Jacobians of a case at one state.
#[derive(Clone, Debug, PartialEq)]
pub struct JacobianReport {
    /// Name of the case.
    pub case: String,
    /// The state, in words.
    pub state: String,
    /// The step in which it is.
    pub rule: StepRule,
    /// Smallest J at the quadrature points.
    pub min_j: f64,
    /// Unknowns, given ones counted.
    pub unknowns: usize,
    /// Against the automatic Jacobian.
    pub comparisons: Vec<Comparison>,
    /// What the other linearisations leave out.
    pub left_out: Vec<LeftOut>,
}

impl JacobianReport {
    /// Whether all Jacobians agree within their tolerances.
    pub fn agrees(&self) -> bool {
        self.comparisons.iter().all(Comparison::agrees)
    }
}

/// Perturbation of differences of the whole residual, relative to the velocity, the distance of nodes and the
/// pressure; on one side and on both.
const ONE_SIDED: f64 = 1e-6;
const CENTRAL: f64 = 1e-5;

/// Two exact ways differ by rounding.
const EXACT: f64 = 1e-10;
/// One-sided differences have errors of their perturbation, central ones of its square and of rounding.
const ONE_SIDED_TOLERANCE: f64 = 1e-4;
const CENTRAL_TOLERANCE: f64 = 1e-6;

/// Compute all Jacobians of `simulation` at one state, and what other linearisations leave out of them. The state
/// of the simulation is as before.
///
/// # Errors
/// If the matrix has too many entries to be numbered.
pub fn compare<const D: usize>(
    simulation: &mut Simulation<D>,
    at: At,
) -> Result<JacobianReport, SolverError> {
    simulation.install(|simulation| {
        let setting = Setting::new(simulation, at);
        let case = simulation.case.name.clone();
        let assembler = &mut simulation.stepper.assembler;
        let min_j = setting.min_j(assembler);
        let unknowns = assembler.space.n_field_unknowns();
        let (comparisons, left_out) = matrices(assembler, &setting)?;
        let Setting { text: state, rule, .. } = setting;
        Ok(JacobianReport { case, state, rule, min_j, unknowns, comparisons, left_out })
    })
}

fn matrices<const D: usize>(
    assembler: &mut Assembler<D>,
    setting: &Setting,
) -> Result<(Vec<Comparison>, Vec<LeftOut>), SolverError> {
    let view = setting.view();
    let pattern = assembler.try_pattern()?;
    let (mut exact, mut other) = (Csr::zeros(&pattern), Csr::zeros(&pattern));
    assembler.jacobian(&view, Tangent::Automatic, &mut exact);
    let blocks = Blocks::new(&assembler.space, &exact, assembler.is_given());
    let mut comparisons = vec![];
    let by = |stencil, epsilon| Tangent::Difference(Difference::new(stencil, epsilon));
    for (name, tolerance, tangent) in [
        ("analytic", EXACT, Tangent::Analytic),
        ("finite-difference, one-sided", ONE_SIDED_TOLERANCE, by(Stencil::OneSided, ONE_SIDED)),
        ("finite-difference, central", CENTRAL_TOLERANCE, by(Stencil::Central, CENTRAL)),
    ] {
        assembler.jacobian(&view, tangent, &mut other);
        comparisons.push(blocks.compare(name, tolerance, &exact, &other, None));
    }
    let noise = noise(&exact, &setting.new, &setting.old);
    assembler.jacobian(&view, by(Stencil::Nodal, ONE_SIDED), &mut other);
    let (name, steps) = ("finite-difference, nodal", setting.steps(ONE_SIDED));
    comparisons.push(blocks.compare(name, ONE_SIDED_TOLERANCE, &exact, &other, Some((&noise, &steps))));
    let mut differences = Differences::new(assembler);
    for (name, tolerance, central, h) in [
        ("whole residual, one-sided", ONE_SIDED_TOLERANCE, false, ONE_SIDED),
        ("whole residual, central", CENTRAL_TOLERANCE, true, CENTRAL),
    ] {
        let mut new = setting.new.clone();
        let steps = setting.steps(h);
        differences.jacobian(
            assembler,
            setting.rule,
            (&mut new, &setting.old),
            (&steps, central),
            &mut other,
        );
        comparisons.push(blocks.compare(name, tolerance, &exact, &other, Some((&noise, &steps))));
    }
    let mut left_out = vec![];
    for &Choice { name, value: kind, .. } in &LINEARIZATIONS {
        if kind == Linearization::Newton {
            continue;
        }
        if kind != Linearization::Condensed || (setting.rule.per_k > 0.0 || !assembler.space.deforms) {
            assembler.matrix(&view, kind, Tangent::Automatic, &mut other);
            let blocks = blocks.compare(name, 1.0, &exact, &other, None).blocks;
            let blocks = blocks.into_iter().filter(|(_, deviation)| *deviation > EXACT).collect();
            left_out.push(LeftOut { name: name.into(), blocks });
        }
    }
    Ok((comparisons, left_out))
}

/// Roundings that a residual is made of, a few per term.
const ROUNDINGS: f64 = 16.0 * f64::EPSILON;

/// What rounding leaves of each row of the residual: ε Σ_j |a_ij| (|x_j| + |x⁻_j|).
fn noise(matrix: &Csr, new: &State, old: &State) -> Vec<f64> {
    let all = |s: &State| [&s.v[..], &s.u, &s.p].concat();
    let sizes: Vec<f64> = all(new).iter().zip(all(old)).map(|(a, b)| a.abs() + b.abs()).collect();
    let row = |i: usize| {
        let terms = matrix
            .pattern
            .row(i)
            .map(|at| matrix.values[at].abs() * sizes[matrix.pattern.column(i, at) as usize]);
        ROUNDINGS * terms.sum::<f64>()
    };
    (0..matrix.pattern.n).map(row).collect()
}

impl Setting {
    fn view(&self) -> StepView<'_> {
        StepView { rule: self.rule, new: &self.new, old: &self.old }
    }
}
