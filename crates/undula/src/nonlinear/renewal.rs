//! When the Jacobian is renewed: one object per rule, made for a solve.
//!
//! | rule | of `newton.rate-max` | factors are of |
//! | --- | --- | --- |
//! | [`Given`] | γ_nt of (5.20) | the Jacobian |
//! | [`Priced`] | none: kept as long as that costs less than a new one | the Jacobian |
//! | [`Gmres`] | γ_nt, or none | an older Jacobian: they precondition |

use super::report::NewtonReport;

/// Rate at which a new Jacobian of the condensed system converges in developed motion.
const FRESH_RATE: f64 = 0.03;

/// γ_nt of matrices that need no new factors, where none is given.
const MATRIX_RATE: f64 = 0.5;

/// What is made at the iterate before its correction.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Make {
    /// Nothing: all is kept.
    Nothing,
    /// The matrix, preconditioned by the factors at hand.
    Matrix,
    /// The matrix and its factors.
    Factors,
}

/// How a kept Jacobian has done since it was made.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Age {
    /// Solves with it.
    pub solves: u32,
    /// Iterations in them: of the linear solver where the factors may be older than the Jacobian, else of Newton's
    /// method.
    pub iterations: u32,
    /// Iterations in the last one.
    pub last: u32,
}

impl Age {
    /// Whether the last solve has cost more than the mean one, renewal included: then replacing pays.
    fn is_due(&self, price: f64) -> bool {
        self.solves > 0 && f64::from(self.last) * f64::from(self.solves) > price + f64::from(self.iterations)
    }

    fn add(&mut self, work: usize) {
        let work = work as u32;
        self.solves += 1;
        self.last = work;
        self.iterations += work;
    }
}

/// What is known of the factors at hand, from one solve to the next.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Kept {
    /// They exist, and no rule has refused them.
    pub(super) usable: bool,
    pub(super) age: Age,
    /// Mean rate of the iterations after the first, with the Jacobian of an earlier step, over the rate of the first,
    /// as last seen; in single precision, for checkpoints.
    pub(super) worsening: f32,
}

impl Default for Kept {
    /// No factors, and nothing learnt.
    fn default() -> Kept {
        Kept { usable: false, age: Age::default(), worsening: 1.0 }
    }
}

impl Kept {
    /// Learn from an iteration of this `rate`, whose residual `report` has not yet.
    pub(super) fn learn(&mut self, report: &NewtonReport, rate: f64) {
        if let ([start, first, ..], 0) = (&report.norms[..], report.jacobians) {
            let last = rate * report.norms[report.norms.len() - 1];
            let mean = (last / first).powf(1.0 / (report.norms.len() - 1) as f64);
            self.worsening = ((mean * start / first) as f32).max(1.0);
        }
    }

    /// The rate of iterations to come, after one of `rate`. The first one with the Jacobian of an earlier step
    /// does better than those that follow: by how much in the mean, the last steps tell.
    fn expected(&self, report: &NewtonReport, rate: f64) -> f64 {
        let is_first = report.jacobians == 0 && report.norms.len() == 1;
        if is_first { rate * f64::from(self.worsening) } else { rate }
    }
}

/// An iteration that was successful.
pub(super) struct Iteration<'a> {
    /// The solve before it.
    pub(super) report: &'a NewtonReport,
    /// ‖r_n‖/‖r_{n−1}‖.
    pub(super) rate: f64,
    /// Logarithm of the residual that is wanted over the one that is reached.
    pub(super) left: f64,
    /// What a renewal costs, in iterations.
    pub(super) price: f64,
}

/// A rule that says when to renew.
pub(super) trait Renewal {
    /// What the next correction needs; `linear` iterations of the linear solver are done in this solve.
    fn due(&mut self, kept: &Kept, _linear: usize, _price: f64) -> Make {
        if kept.usable { Make::Nothing } else { Make::Factors }
    }

    /// Judge the Jacobian by an iteration with it.
    fn observe(&mut self, kept: &mut Kept, iteration: &Iteration<'_>);

    /// An update raised the residual, and not everything was `made` for it: what is old is to blame.
    fn blame(&mut self, kept: &mut Kept, _made: Make) {
        kept.usable = false;
    }

    /// The solve is done.
    fn end(&self, kept: &mut Kept, report: &NewtonReport);
}

/// The rule for a γ_nt, if one is given, and for factors that may be older than the matrix if `iterative`.
pub(super) fn rule(rate_max: Option<f64>, iterative: bool, kept: &mut Kept, price: f64) -> Box<dyn Renewal> {
    match rate_max {
        _ if iterative => Box::new(Gmres::new(rate_max.unwrap_or(MATRIX_RATE), kept, price)),
        Some(rate_max) => Box::new(Given { rate_max }),
        None => Box::new(Priced { is_last: kept.usable && kept.age.is_due(price) }),
    }
}

/// (5.20): the Jacobian is kept while ‖r_n‖/‖r_{n−1}‖ ≤ γ_nt.
struct Given {
    rate_max: f64,
}

impl Renewal for Given {
    fn observe(&mut self, kept: &mut Kept, iteration: &Iteration<'_>) {
        kept.usable = iteration.rate <= self.rate_max;
    }

    fn end(&self, _: &mut Kept, _: &NewtonReport) {}
}

/// The Jacobian is kept as long as the iterations to come cost less than a new one and those that it needs.
struct Priced {
    /// The Jacobian at the start has cost too much: one iteration with it, and no more.
    is_last: bool,
}

impl Renewal for Priced {
    fn observe(&mut self, kept: &mut Kept, &Iteration { report, rate, left, price }: &Iteration<'_>) {
        let expected = kept.expected(report, rate);
        let renewed = price + left / FRESH_RATE.ln();
        let refused = self.is_last && report.norms.len() == 1;
        kept.usable = !refused && expected < 1.0 && left / expected.ln() < renewed;
    }

    fn end(&self, kept: &mut Kept, report: &NewtonReport) {
        kept.age.add(report.steps);
    }
}

/// GMRES: a matrix is of its step alone, and kept in it while ‖r_n‖/‖r_{n−1}‖ ≤ γ_nt. Its factors are renewed when the
/// iterations of the linear solver since have cost as much.
struct Gmres {
    rate_max: f64,
    /// The matrix is of this step, and good enough.
    matrix: bool,
    /// Iterations of the linear solver in this solve, up to the last factorisation.
    before: usize,
}

impl Gmres {
    fn new(rate_max: f64, kept: &mut Kept, price: f64) -> Gmres {
        if kept.usable && kept.age.is_due(price) {
            kept.usable = false;
        }
        Gmres { rate_max, matrix: false, before: 0 }
    }
}

impl Renewal for Gmres {
    fn due(&mut self, kept: &Kept, linear: usize, price: f64) -> Make {
        if kept.usable && self.matrix {
            return Make::Nothing;
        }
        self.matrix = true;
        if kept.usable && (linear - self.before) as f64 <= price {
            return Make::Matrix;
        }
        self.before = linear;
        Make::Factors
    }

    fn observe(&mut self, _: &mut Kept, iteration: &Iteration<'_>) {
        self.matrix = iteration.rate <= self.rate_max;
    }

    fn blame(&mut self, kept: &mut Kept, made: Make) {
        if made == Make::Matrix { kept.usable = false } else { self.matrix = false }
    }

    fn end(&self, kept: &mut Kept, report: &NewtonReport) {
        kept.age.add(report.linear_iterations);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRICE: f64 = 5.0;

    /// A solve that has made `jacobians` and reached the residuals `norms`.
    fn report(jacobians: usize, norms: &[f64]) -> NewtonReport {
        NewtonReport { jacobians, norms: norms.to_vec(), ..NewtonReport::default() }
    }

    /// Whether `rule` keeps the factors after an iteration of this `rate` that leaves exp(−`left`) to be reduced.
    fn keeps(rule: &mut dyn Renewal, kept: &mut Kept, report: &NewtonReport, rate: f64, left: f64) -> bool {
        kept.usable = true;
        rule.observe(kept, &Iteration { report, rate, left, price: PRICE });
        kept.usable
    }

    /// Factors that have served two solves, the last one much longer than the first.
    fn worn() -> Kept {
        Kept { usable: true, age: Age { solves: 2, iterations: 12, last: 10 }, worsening: 1.0 }
    }

    #[test]
    fn a_given_rate_is_all_that_counts() {
        let mut kept = worn();
        let mut rule = rule(Some(0.2), false, &mut kept, PRICE);
        assert_eq!(rule.due(&kept, 100, PRICE), Make::Nothing);
        for (rate, good) in [(0.2, true), (0.21, false)] {
            assert_eq!(keeps(&mut *rule, &mut kept, &report(0, &[1.0]), rate, -20.0), good, "{rate}");
        }
        assert_eq!(rule.due(&kept, 0, PRICE), Make::Factors);
        rule.end(&mut kept, &report(1, &[1.0]));
        assert_eq!(kept.age, worn().age);
    }

    /// At the rate 0.5 seven iterations are to come for 1e-2, against five and two; three for 1e-1.
    #[test]
    fn the_rule_of_prices_compares_iterations_to_come() {
        let new = || Kept { age: Age::default(), ..worn() };
        let left = |reduction: f64| reduction.ln();
        for (reduction, good) in [(1e-1, true), (1e-2, false)] {
            let mut rule = rule(None, false, &mut new(), PRICE);
            assert_eq!(keeps(&mut *rule, &mut new(), &report(1, &[1.0]), 0.5, left(reduction)), good);
        }
        // What the last steps have lost after their first iteration is expected of this one.
        let mut rule = rule(None, false, &mut new(), PRICE);
        let mut worse = Kept { worsening: 1.8, ..new() };
        assert!(!keeps(&mut *rule, &mut worse, &report(0, &[1.0]), 0.5, left(1e-1)));
        assert!(keeps(&mut *rule, &mut worse, &report(0, &[1.0, 0.5]), 0.5, left(1e-1)));
    }

    #[test]
    fn worn_factors_do_one_more_iteration_by_price_and_none_of_gmres() {
        let mut kept = worn();
        let mut priced = rule(None, false, &mut kept, PRICE);
        assert_eq!(priced.due(&kept, 0, PRICE), Make::Nothing);
        assert!(!keeps(&mut *priced, &mut kept, &report(0, &[1.0]), 0.01, -1.0));
        let mut kept = worn();
        let mut gmres = rule(None, true, &mut kept, PRICE);
        assert_eq!(gmres.due(&kept, 0, PRICE), Make::Factors);
    }

    #[test]
    fn gmres_renews_matrices_until_their_iterations_cost_the_factors() {
        let mut kept = Kept { usable: true, ..Kept::default() };
        let mut rule = rule(None, true, &mut kept, PRICE);
        assert_eq!(rule.due(&kept, 0, PRICE), Make::Matrix);
        assert!(keeps(&mut *rule, &mut kept, &report(1, &[1.0]), 0.4, -5.0));
        assert_eq!(rule.due(&kept, 3, PRICE), Make::Nothing);
        assert!(keeps(&mut *rule, &mut kept, &report(1, &[1.0, 0.4]), 0.6, -5.0));
        assert_eq!(rule.due(&kept, 4, PRICE), Make::Matrix);
        // An old matrix is to blame before its factors.
        rule.blame(&mut kept, Make::Nothing);
        assert_eq!((kept.usable, rule.due(&kept, 6, PRICE)), (true, Make::Factors));
        rule.blame(&mut kept, Make::Matrix);
        assert!(!kept.usable);
    }
}
