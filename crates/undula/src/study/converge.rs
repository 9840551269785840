//! Observed orders and extrapolated values of a case under refinement.
//!
//! With three results f₁, f₂, f₃ on meshes or steps of which each is half the one before, the observed order is
//! p = log₂((f₁ − f₂)/(f₂ − f₃)), the value extrapolated after Richardson f₃ + (f₃ − f₂)/(2ᵖ − 1), and its uncertainty
//! 1.25 |f₃ − f₂|/(2ᵖ − 1), the grid convergence index of P. J. Roache, *Perspective: a method for uniform reporting of
//! grid refinement studies*, J. Fluids Eng. 116 (1994). Where the results do not approach each other with an order
//! between ½ and twice the formal one, there is no extrapolated value: the uncertainty is three times the largest
//! difference of the last two pairs.

use super::engine::Computed;
use super::file::{Axis, RunEntry, Study};
use crate::case::Case;
use crate::case::expression::Expression;

/// Refinements of the mesh or of the step.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Direction {
    /// `mesh.refine` goes up.
    Mesh,
    /// `time.step` is halved.
    Step,
}

/// Three results with what follows from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Converged {
    /// Functional.
    pub functional: String,
    /// `value`, `mean`, `amplitude` or `frequency`.
    pub quantity: &'static str,
    /// Unit.
    pub unit: String,
    /// What is refined.
    pub direction: Direction,
    /// On the coarsest, the next, the finest.
    pub results: [f64; 3],
    /// Observed order; `None` where the results do not approach each other.
    pub order: Option<f64>,
    /// Extrapolated value; `None` where there is no order to trust.
    pub extrapolated: Option<f64>,
    /// How far the finest result, or the extrapolated one, may be off.
    pub uncertainty: f64,
}

/// Orders outside of this range are not those of a method.
const ORDERS: (f64, f64) = (0.5, 8.0);

impl Converged {
    /// From three results, each with half the mesh size or step of the one before.
    pub fn new(
        functional: &str,
        quantity: &'static str,
        unit: &str,
        direction: Direction,
        results: [f64; 3],
    ) -> Self {
        let [first, second, third] = results;
        let (coarse, fine) = (first - second, second - third);
        // Differences of rounding have no order.
        let rounding = 1e-12 * third.abs();
        let ratio = coarse / fine;
        let order = (fine.abs() > rounding && ratio > 0.0).then(|| ratio.log2());
        let trusted = order.filter(|p| (ORDERS.0..=ORDERS.1).contains(p));
        let (extrapolated, uncertainty) = match trusted {
            Some(p) => (Some(third - fine / (p.exp2() - 1.0)), 1.25 * fine.abs() / (p.exp2() - 1.0)),
            None if fine.abs() <= rounding && coarse.abs() <= rounding => (Some(third), rounding),
            None => (None, 3.0 * coarse.abs().max(fine.abs())),
        };
        let (functional, unit) = (functional.to_string(), unit.to_string());
        Converged { functional, quantity, unit, direction, results, order, extrapolated, uncertainty }
    }
}

/// The study that computes `case` (a built-in case or a file) on `levels` meshes, and with as many steps where it has
/// any; `settings` are assignments `key=value` that made it of the case.
pub fn study(case: &Case, of: &str, settings: &[String], levels: usize) -> Study {
    let refine = i64::from(case.mesh.refine);
    let mesh: Vec<toml::Value> = (0..levels).map(|n| toml::Value::Integer(refine + n as i64)).collect();
    let axis = |key: &str, values| Axis { key: key.into(), values, quick: None };
    let run = |name: &str, over| RunEntry { name: name.into(), over: vec![over], ..RunEntry::default() };
    let mut runs = vec![run("mesh", axis("mesh.refine", mesh))];
    if let Some(time) = &case.time {
        let steps = (1..levels).map(|n| part(&time.step, (1u64 << n) as f64)).collect();
        runs.push(run("step", axis("time.step", steps)));
    }
    Study {
        name: format!("{}-converge", case.name),
        title: format!("{}: convergence", case.name),
        case: of.into(),
        assignments: settings.to_vec(),
        run: runs,
        ..Study::default()
    }
}

/// A step divided by `n`.
fn part(step: &Expression, n: f64) -> toml::Value {
    match step.constant_value() {
        Some(value) => toml::Value::Float(value / n),
        None => toml::Value::String(format!("({})/{n}", step.source())),
    }
}

/// Orders and values of all functionals that all runs of [`study`] have.
pub fn converged(computed: &[Computed]) -> Vec<Converged> {
    let named =
        |start: &str| computed.iter().filter(|run| run.job.name.starts_with(start)).collect::<Vec<_>>();
    let mesh = named("mesh_");
    // The steps begin with the run on the first mesh.
    let mut step = named("step_");
    if !step.is_empty() {
        step.insert(0, mesh[0]);
    }
    let mut found = vec![];
    for (direction, runs) in [(Direction::Mesh, mesh), (Direction::Step, step)] {
        for last in runs.windows(3).last().into_iter() {
            found.extend(of(direction, last));
        }
    }
    found
}

fn of(direction: Direction, runs: &[&Computed]) -> Vec<Converged> {
    // What a run had computed when it broke down is no result of a mesh or step.
    let completed = runs.iter().filter(|run| run.is_completed());
    let all: Vec<_> =
        completed.filter_map(|run| run.results.as_ref()).map(|results| results.computed()).collect();
    let [first, second, third] = &all[..] else { return vec![] };
    let mut found = vec![];
    for (name, finest) in third {
        let (Some(a), Some(b)) = (first.get(name), second.get(name)) else { continue };
        let numbers = a.numbers.named().into_iter().zip(b.numbers.named()).zip(finest.numbers.named());
        // A periodic signal has no last value that would converge.
        let periodic = finest.numbers.mean.is_some();
        for (((quantity, a), (_, b)), (_, c)) in numbers {
            let wanted = match quantity {
                "mean" | "amplitude" | "frequency" => periodic,
                "value" => !periodic,
                _ => false,
            };
            if let (true, Some(a), Some(b), Some(c)) = (wanted, a, b, c) {
                let unit = if quantity == "frequency" { "Hz" } else { &finest.unit };
                found.push(Converged::new(name, quantity, unit, direction, [a, b, c]));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(f: impl Fn(f64) -> f64) -> Converged {
        Converged::new("f", "value", "", Direction::Mesh, [f(1.0), f(0.5), f(0.25)])
    }

    #[test]
    fn a_power_of_the_mesh_size_is_found_and_extrapolated() {
        for p in [1.0, 2.0, 3.5] {
            let found = of(|h: f64| 7.0 - 0.3 * h.powf(p));
            assert!((found.order.unwrap() - p).abs() < 1e-9, "{found:?}");
            assert!((found.extrapolated.unwrap() - 7.0).abs() < 1e-9, "{found:?}");
            let error = 0.3 * 0.25_f64.powf(p);
            assert!((found.uncertainty / (1.25 * error) - 1.0).abs() < 1e-6, "{found:?}");
        }
    }

    #[test]
    fn results_that_wander_have_no_extrapolated_value() {
        let found = Converged::new("f", "value", "", Direction::Step, [1.0, 1.2, 1.1]);
        assert_eq!((found.order, found.extrapolated), (None, None));
        assert!((found.uncertainty - 0.6).abs() < 1e-12);
        let settled = Converged::new("f", "value", "", Direction::Step, [1.0, 1.0, 1.0]);
        assert_eq!(settled.extrapolated, Some(1.0));
    }
}
