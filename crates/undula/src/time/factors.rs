//! What all linear systems of a step share: how their solvers are made, and how factors serve a step with another k.

use crate::algebra::LinearSolver;
use crate::physics::StepRule;
use crate::space::PsiOwner;
use crate::system::Assembler;

/// Makes linear solvers of the kind that the case asks for.
pub type MakeSolver = Box<dyn Fn(Purpose) -> Box<dyn LinearSolver> + Send>;

/// What a linear solver is for.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Solutions as exact as can be.
    Exact,
    /// Corrections in an iteration that sees its own residual.
    Correction,
    /// The same where the matrix is symmetric and should be positive definite.
    Definite,
}

/// Nodes of the solid whose deformation is not given.
pub(super) fn relation<const D: usize>(assembler: &Assembler<D>) -> impl Iterator<Item = usize> + '_ {
    let (space, given) = (&assembler.space, &assembler.constraints.u);
    let free = |&node: &usize| space.owner[node] == PsiOwner::Relation && given[node] == [false; D];
    (0..if space.deforms { space.nodes.len() } else { 0 }).filter(free)
}

/// How many times the matrix of a step by `rule` is that of one by `of`, where this is all that differs: in k⁻¹M + θA
/// with equal kθ, as in the parts of fractional-step θ. `None`: once, or more differs.
pub(super) fn ratio(of: &StepRule, rule: &StepRule) -> Option<f64> {
    let coupling = |rule: &StepRule| rule.theta / rule.per_k;
    let equal = (coupling(of) - coupling(rule)).abs() <= 1e-9 * coupling(rule);
    (equal && of.per_k != rule.per_k).then_some(rule.per_k / of.per_k)
}

/// Scale the rows that have k⁻¹M + θA: momentum and velocity-deformation relation.
pub(super) fn scale_rows<const D: usize>(assembler: &Assembler<D>, factor: f64, r: &mut [f64]) {
    let space = &assembler.space;
    let (v, rest) = r.split_at_mut(space.n_v());
    v.iter_mut().for_each(|r| *r *= factor);
    for node in relation(assembler) {
        rest[node * D..(node + 1) * D].iter_mut().for_each(|r| *r *= factor);
    }
}

/// The pressure is not multiplied by θ: its correction makes up for the scaled rows.
pub(super) fn scale_pressure<const D: usize>(assembler: &Assembler<D>, factor: f64, delta: &mut [f64]) {
    let space = &assembler.space;
    delta[space.n_v() + space.n_u()..].iter_mut().for_each(|p| *p *= factor);
}
