//! The parts of a step, each called alone.

use super::median;
use crate::algebra::{Cost, Csr, LinearSolver, MultifrontalLu, Options, Sizes, SolverError, Unknown};
use crate::error::Error;
use crate::physics::StepRule;
use crate::simulation::Simulation;
use crate::space::State;
use crate::system::{Assembler, CondensedSystem, StepView};
use crate::tangent::Tangent;
use crate::time::Stepper;
use crate::verification::jacobians::differences::{Differences, deviation};
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::Instant;

/// Calls of each kernel, at least.
const CALLS: usize = 11;

/// Calls go on until they have taken this long together \[s\], or have been [`MANY`].
const ENOUGH: f64 = 0.1;
const MANY: usize = 201;

/// Unknowns up to which the whole Jacobian is assembled.
const LARGEST_JACOBIAN: usize = 300_000;

/// Bytes up to which factors are made.
const LARGEST_FACTORS: f64 = 2.0 * 1024.0 * 1024.0 * 1024.0;

/// Why they are not.
const LARGE_FACTORS: &str = "the factors would take more than 2 GiB";

/// A Jacobian by differences that takes longer \[s\] is left out.
const LONGEST_DIFFERENCES: f64 = 4.0;

/// Median of some calls.
#[derive(Copy, Clone, Debug, PartialEq, Serialize)]
pub struct Timing {
    /// Seconds per call.
    pub seconds: f64,
    /// Calls.
    pub calls: usize,
    /// Floating point operations of a call, as predicted from the pattern.
    pub flops: Option<f64>,
    /// Bytes of the factors written or read by a call, as predicted from the pattern.
    pub bytes: Option<f64>,
}

/// Kernels by name; those left out are `None`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Kernels {
    /// The residual of a step.
    pub residual: Option<Timing>,
    /// The explicit part of a step.
    pub explicit: Option<Timing>,
    /// The condensed matrix by dual numbers, unknowns inside of cells eliminated.
    pub condensed_dual: Option<Timing>,
    /// The same by hand.
    pub condensed_by_hand: Option<Timing>,
    /// Forward elimination of the unknowns inside of cells.
    pub eliminate_inner: Option<Timing>,
    /// Their back substitution.
    pub recover_inner: Option<Timing>,
    /// The whole Jacobian by dual numbers.
    pub jacobian_dual: Option<Timing>,
    /// The same by hand, Theorem 5.2.
    pub jacobian_by_hand: Option<Timing>,
    /// The same by central differences.
    pub jacobian_differences: Option<Timing>,
    /// Ordering and symbolic factorisation of the condensed matrix.
    pub analyse: Option<Timing>,
    /// Its multifrontal factorisation in single precision.
    pub factor_single: Option<Timing>,
    /// The same in double precision.
    pub factor_double: Option<Timing>,
    /// Both substitutions with factors in single precision.
    pub apply_single: Option<Timing>,
    /// The same in double precision.
    pub apply_double: Option<Timing>,
    /// Factorisation of the extension in single precision, once per run.
    pub factor_extension: Option<Timing>,
    /// Both substitutions with its factors.
    pub apply_extension: Option<Timing>,
    /// Pivots of the condensed matrix in single precision that were refused in their own front.
    pub delayed: Option<usize>,
    /// Bytes that its factors hold.
    pub held: Option<usize>,
    /// Residuals that a Jacobian by differences takes.
    pub difference_residuals: Option<usize>,
    /// Largest deviation of the differences from dual numbers, relative to the largest entry of the row.
    pub difference_deviation: Option<f64>,
    /// Why a kernel is left out.
    pub left_out: BTreeMap<&'static str, String>,
}

impl Kernels {
    /// Names and timings, in the order of a step.
    pub fn named(&self) -> [(&'static str, Option<Timing>); 16] {
        [
            ("residual", self.residual),
            ("explicit", self.explicit),
            ("condensed_dual", self.condensed_dual),
            ("condensed_by_hand", self.condensed_by_hand),
            ("eliminate_inner", self.eliminate_inner),
            ("recover_inner", self.recover_inner),
            ("jacobian_dual", self.jacobian_dual),
            ("jacobian_by_hand", self.jacobian_by_hand),
            ("jacobian_differences", self.jacobian_differences),
            ("analyse", self.analyse),
            ("factor_single", self.factor_single),
            ("factor_double", self.factor_double),
            ("apply_single", self.apply_single),
            ("apply_double", self.apply_double),
            ("factor_extension", self.factor_extension),
            ("apply_extension", self.apply_extension),
        ]
    }

    fn leave_out(&mut self, names: &[&'static str], reason: &str) {
        self.left_out.extend(names.iter().map(|name| (*name, reason.to_string())));
    }
}

/// Where kernels are called: a step of some length from the present state.
struct Setting<'a, const D: usize> {
    assembler: &'a mut Assembler<D>,
    rule: StepRule,
    new: &'a State,
    old: &'a State,
    sizes: Sizes,
}

/// Measure all kernels for a step of length `k` \[s\], within the pool of the simulation.
///
/// # Errors
/// If a matrix cannot be factorised.
pub fn measure<const D: usize>(simulation: &mut Simulation<D>, k: f64) -> Result<Kernels, Error> {
    let Stepper { assembler, settings, new, old, .. } = &mut simulation.stepper;
    let rule = settings.scheme.rule(k);
    let mut at = Setting { assembler, rule, new, old, sizes: settings.scales.sizes::<D>(rule.per_k) };
    let size = settings.scales.size;
    let mut kernels = Kernels::default();
    residuals(&mut at, &mut kernels);
    condensed(&mut at, &mut kernels)?;
    extension(&mut at, &mut kernels)?;
    jacobians(&mut at, size, &mut kernels);
    Ok(kernels)
}

impl<const D: usize> Setting<'_, D> {
    fn view(&self) -> StepView<'_> {
        StepView { rule: self.rule, new: self.new, old: self.old }
    }

    fn n(&self) -> usize {
        self.assembler.n_unknowns()
    }

    fn condensed_matrix(&mut self, tangent: Tangent, out: &mut Csr) {
        let view = StepView { rule: self.rule, new: self.new, old: self.old };
        self.assembler.condensed_matrix(&view, tangent, out);
    }

    fn jacobian(&mut self, tangent: Tangent, out: &mut Csr) {
        let view = StepView { rule: self.rule, new: self.new, old: self.old };
        self.assembler.jacobian(&view, tangent, out);
    }

    /// The residual on top of what is in `r`.
    fn residual(&mut self, r: &mut [f64]) {
        let view = StepView { rule: self.rule, new: self.new, old: self.old };
        self.assembler.residual(&view, r);
    }
}

fn residuals<const D: usize>(at: &mut Setting<'_, D>, kernels: &mut Kernels) {
    let mut explicit = vec![0.0; at.n()];
    let view = StepView { rule: at.rule, new: at.new, old: at.old };
    kernels.explicit = Some(timing(|| at.assembler.explicit(&view, &mut explicit)));
    let mut r = vec![0.0; at.n()];
    kernels.residual = Some(timing_after(&mut r, |r| r.copy_from_slice(&explicit), |r| at.residual(r)));
}

fn condensed<const D: usize>(at: &mut Setting<'_, D>, kernels: &mut Kernels) -> Result<(), SolverError> {
    let system = at.assembler.try_condensed()?;
    let mut matrix = Csr::zeros(&system.pattern);
    kernels.condensed_by_hand = Some(timing(|| at.condensed_matrix(Tangent::Analytic, &mut matrix)));
    kernels.condensed_dual = Some(timing(|| at.condensed_matrix(Tangent::Automatic, &mut matrix)));
    let mut r = vec![0.0; at.n()];
    at.residual(&mut r);
    let mut b = r.clone();
    let assembler = &mut *at.assembler;
    let eliminated = timing_after(&mut b, |b| b.copy_from_slice(&r), |b| assembler.eliminate_inner(b));
    kernels.eliminate_inner = Some(eliminated);
    kernels.recover_inner = Some(timing(|| assembler.recover_inner(&mut b)));
    factorisations(&system, &matrix, at.sizes, kernels)
}

fn factorisations(
    system: &CondensedSystem,
    matrix: &Csr,
    sizes: Sizes,
    kernels: &mut Kernels,
) -> Result<(), SolverError> {
    let [mut single, mut double] =
        [MultifrontalLu::single, MultifrontalLu::multifrontal].map(|solver| solver(Options::unprobed()));
    single.set_sizes(sizes);
    double.set_sizes(sizes);
    let (found, cost) = factors(single, matrix, &system.unknowns, size_of::<f32>())?;
    [kernels.analyse, kernels.factor_single, kernels.apply_single] = found;
    (kernels.delayed, kernels.held) = (cost.map(|cost| cost.delayed), cost.and_then(|cost| cost.bytes));
    let (found, _) = factors(double, matrix, &system.unknowns, size_of::<f64>())?;
    [_, kernels.factor_double, kernels.apply_double] = found;
    if kernels.factor_single.is_none() {
        kernels.leave_out(&["factor_single", "apply_single"], LARGE_FACTORS);
    }
    if kernels.factor_double.is_none() {
        kernels.leave_out(&["factor_double", "apply_double"], LARGE_FACTORS);
    }
    Ok(())
}

fn extension<const D: usize>(at: &mut Setting<'_, D>, kernels: &mut Kernels) -> Result<(), SolverError> {
    let names = ["factor_extension", "apply_extension"];
    let Some(system) = at.assembler.extension(&at.view()) else {
        kernels.leave_out(&names, "there is no extension");
        return Ok(());
    };
    let all = at.assembler.unknowns();
    let unknowns: Vec<Unknown> = system.places.iter().map(|&place| all[place as usize]).collect();
    let solver = MultifrontalLu::single_definite(Options::unprobed());
    [_, kernels.factor_extension, kernels.apply_extension] =
        factors(solver, &system.matrix, &unknowns, size_of::<f32>())?.0;
    if kernels.factor_extension.is_none() {
        kernels.leave_out(&names, LARGE_FACTORS);
    }
    Ok(())
}

/// Analysis, factorisation and substitution of `matrix`, entries of the factors having `size` bytes; and what the
/// factorisation has cost.
fn factors(
    mut solver: MultifrontalLu,
    matrix: &Csr,
    unknowns: &[Unknown],
    size: usize,
) -> Result<([Option<Timing>; 3], Option<Cost>), SolverError> {
    let begun = Instant::now();
    solver.analyse(&matrix.pattern, unknowns)?;
    let seconds = begun.elapsed().as_secs_f64();
    let analyse = Some(Timing { seconds, calls: 1, flops: None, bytes: None });
    let cost = solver.predicted().unwrap_or_default();
    let bytes = cost.bytes.map(|bytes| bytes as f64);
    let read = cost.read.map(|read| read as f64);
    if bytes.is_some_and(|bytes| bytes > LARGEST_FACTORS) {
        return Ok(([analyse, None, None], None));
    }
    // An error of the first call is told, later ones would be the same.
    let found = solver.factor(matrix)?.cost;
    let factor = timing(|| drop(solver.factor(matrix)));
    let mut b = vec![0.0; unknowns.len()];
    matrix.mul(&vec![1.0; b.len()], &mut b);
    let mut x = vec![0.0; b.len()];
    let apply = timing(|| solver.apply(&b, &mut x));
    let factor = Timing { flops: cost.flops, bytes, ..factor };
    let apply = Timing { flops: read.map(|read| 2.0 * read / size as f64), bytes: read, ..apply };
    Ok(([analyse, Some(factor), Some(apply)], Some(found)))
}

fn jacobians<const D: usize>(at: &mut Setting<'_, D>, size: f64, kernels: &mut Kernels) {
    if at.n() > LARGEST_JACOBIAN {
        let names = ["jacobian_dual", "jacobian_by_hand", "jacobian_differences"];
        return kernels.leave_out(&names, "the whole Jacobian would take more than 2 GiB");
    }
    let mut dual = Csr::zeros(&at.assembler.pattern());
    kernels.jacobian_by_hand = Some(timing(|| at.jacobian(Tangent::Analytic, &mut dual)));
    kernels.jacobian_dual = Some(timing(|| at.jacobian(Tangent::Automatic, &mut dual)));
    let mut differences = Differences::new(at.assembler);
    let residuals = differences.residuals();
    kernels.difference_residuals = Some(residuals);
    let expected = kernels.residual.map_or(0.0, |t| t.seconds * residuals as f64);
    if expected > LONGEST_DIFFERENCES {
        let reason = format!("{residuals} residuals would take {expected:.0} s");
        return kernels.leave_out(&["jacobian_differences"], &reason);
    }
    let mut new = at.new.clone();
    let h = moves(&new, size, at.rule.per_k);
    let steps: Vec<f64> = [(h[0], new.v.len()), (h[1], new.u.len()), (h[2], new.p.len())]
        .into_iter()
        .flat_map(|(h, n)| std::iter::repeat_n(h, n))
        .collect();
    let mut matrix = Csr::zeros(&dual.pattern);
    let call =
        || differences.jacobian(at.assembler, at.rule, (&mut new, at.old), (&steps, true), &mut matrix);
    let calls = (LONGEST_DIFFERENCES / expected) as usize;
    kernels.jacobian_differences = Some(repeated(calls.clamp(1, CALLS), call));
    kernels.difference_deviation = Some(deviation(&dual, &matrix));
}

/// By how much v, u and p are moved for differences: the residual is quadratic in v, linear in p, and u
/// must not fold a cell.
fn moves(state: &State, size: f64, per_k: f64) -> [f64; 3] {
    let largest = |x: &[f64]| x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    // At rest any pressure will do, and a velocity that moves a node by a part of its cell.
    let p = Some(largest(&state.p)).filter(|&p| p > 0.0);
    [1e-3 * largest(&state.v).max(1e-3 * size * per_k), 1e-5 * size, p.unwrap_or(1.0)]
}

fn seconds(work: impl FnOnce()) -> f64 {
    let begun = Instant::now();
    work();
    begun.elapsed().as_secs_f64()
}

fn timing(mut work: impl FnMut()) -> Timing {
    timing_after(&mut (), |()| {}, |()| work())
}

/// Calls of `work`, each after `prepare`, which does not count; nor does the first call.
fn timing_after<S>(on: &mut S, prepare: impl Fn(&mut S), mut work: impl FnMut(&mut S)) -> Timing {
    prepare(on);
    work(on);
    let mut all = vec![];
    while all.len() < CALLS || (all.len() < MANY && all.iter().sum::<f64>() < ENOUGH) {
        prepare(on);
        all.push(seconds(|| work(on)));
    }
    Timing { seconds: median(&all), calls: all.len(), flops: None, bytes: None }
}

/// Exactly `calls` calls of something slow.
fn repeated(calls: usize, mut work: impl FnMut()) -> Timing {
    let all: Vec<f64> = (0..calls).map(|_| seconds(&mut work)).collect();
    Timing { seconds: median(&all), calls, flops: None, bytes: None }
}
