//! The tables `[time]`, `[newton]` and `[linear]`.

use crate::algebra::petsc::USUAL_OPTIONS;
use crate::algebra::{ENGINES, Engine, GmresSettings, PRECISIONS, SOLVERS};
use crate::case::choices::STARTS;
use crate::case::error::quoted;
use crate::case::expression::Expression;
use crate::case::read::{ANY, NOT_NEGATIVE, POSITIVE, Range, Section};
use crate::case::schema::{
    AdaptiveSettings, DomainMotion, GMRES, KRYLOV, LinearSolverKind, LinearSpec, Linearization, MeshSpec,
    NewtonSpec, Precision, Scheme, SolidSpec, Tangent, TimeSpec, WITH_MULTIGRID,
};
use crate::choice;
use crate::tangent::{DIFFERENCES, Difference, EPSILON, LINEARIZATIONS, TANGENTS};
use crate::time::NewtonSettings;
use crate::time::schedule::RESOLUTION;
use crate::time::scheme::{DOMAIN_MOTIONS, SCHEMES};

const THETA: Range = Range { holds: |x| (0.5..=1.0).contains(&x), text: "a number from 0.5 to 1" };
const RATE: Range = Range { holds: |x| (0.0..1.0).contains(&x), text: "a number from 0 to below 1" };
const REDUCTION: Range = Range { holds: |x| x > 0.0 && x < 1.0, text: "a number above 0 and below 1" };
const PERTURBATION: Range =
    Range { holds: |x| (1e-14..=1e-1).contains(&x), text: "a number from 1e-14 to 0.1" };
/// θ − ½ of shifted Crank-Nicolson, and steps from damping to damping of Rannacher's scheme, where the case does not say.
const DAMPING: f64 = 0.005;
const DAMPED_EVERY: f64 = 200.0;

/// The schedule, `None` if stationary, and the end time if one is given.
pub(super) fn time(mut s: Section<'_, '_>) -> (Option<TimeSpec>, Option<f64>) {
    if !s.is_present() {
        return (None, None);
    }
    let scheme = s.choice("scheme", &SCHEMES, &[]);
    let step = s.expression("step");
    let start = s.number("start", 0.0, ANY);
    let end = s.optional_number("end", ANY);
    let theta = s.optional_number("theta", THETA);
    let first = first_step(step.as_ref(), start);
    let shift = s.number("shift", DAMPING / first, NOT_NEGATIVE);
    let max_halvings = s.integer("max-halvings", 5, 0..=20) as u32;
    let steps = s.integer("rannacher-steps", 2, 1..=1000) as u32;
    let interval = s.number("rannacher-interval", DAMPED_EVERY * first, POSITIVE);
    let domain_motion = s.choice("domain-motion", &DOMAIN_MOTIONS, &[]);
    let largest = start.abs().max(end.unwrap_or(start).abs());
    let adaptive = adaptive(s.section("adaptive"), step.as_ref(), RESOLUTION * largest);
    if adaptive.is_some() && step.as_ref().is_some_and(|step| !step.is_constant()) {
        s.wrong("step", "expected a number, the first step: [time.adaptive] chooses the others");
    }
    let shifted = Scheme::ShiftedCrankNicolson { shift };
    // After a mistake any scheme will do that asks for nothing more.
    let scheme = scheme.unwrap_or(Some(if s.has("scheme") { Scheme::BackwardEuler } else { shifted }));
    let Some(scheme) = scheme else {
        if s.has("step") {
            let note = "time.step has no effect: time.scheme is `stationary`";
            s.note(note);
        }
        s.finish();
        return (None, end);
    };
    let scheme = match scheme {
        Scheme::Theta { theta: default } => Scheme::Theta { theta: theta.unwrap_or(default) },
        Scheme::ShiftedCrankNicolson { .. } => shifted,
        Scheme::Rannacher { .. } => Scheme::Rannacher { steps, interval },
        other => other,
    };
    check_schedule(&s, scheme, step.as_ref(), (start, end));
    check_domain_motion(&s, scheme, domain_motion);
    check_rannacher(&s, scheme, step.as_ref(), start);
    note_other_schemes(&s, scheme);
    if matches!(scheme, Scheme::Theta { .. }) && !s.has("theta") {
        s.missing("theta", "the weight of the new time, from 0.5 to 1");
    }
    s.finish();
    let (step, end_or_start) = (step.unwrap_or_default(), end.unwrap_or(start));
    let domain_motion = domain_motion.unwrap_or_default();
    (Some(TimeSpec { scheme, step, start, end: end_or_start, max_halvings, domain_motion, adaptive }), end)
}

/// Keys that belong to another scheme.
fn note_other_schemes(s: &Section<'_, '_>, scheme: Scheme) {
    let (theta, shifted) =
        (matches!(scheme, Scheme::Theta { .. }), matches!(scheme, Scheme::ShiftedCrankNicolson { .. }));
    let rannacher = matches!(scheme, Scheme::Rannacher { .. });
    let used = [
        ("theta", theta),
        ("shift", shifted),
        ("rannacher-steps", rannacher),
        ("rannacher-interval", rannacher),
    ];
    for (key, _) in used.into_iter().filter(|(key, used)| !used && s.has(key)) {
        let note = format!("time.{key} has no effect: the scheme is another one");
        s.note(note);
    }
}

/// The first step \[s\], from which times are taken that the case does not give.
fn first_step(step: Option<&Expression>, start: f64) -> f64 {
    let step = step.filter(|step| !step.depends_on_space()).map(|step| step.eval(&[0.0; 3], start));
    step.filter(|k| k.is_finite() && *k > 0.0).unwrap_or(1.0)
}

/// Step-size control, where its table is there; steps below `least` \[s\] cannot be told from none.
fn adaptive(mut s: Section<'_, '_>, step: Option<&Expression>, least: f64) -> Option<AdaptiveSettings> {
    if !s.is_present() {
        return None;
    }
    let first = step.and_then(Expression::constant_value).filter(|k| *k > 0.0).unwrap_or(1.0);
    let settings = AdaptiveSettings {
        tolerance: s.number("tolerance", 1e-3, REDUCTION),
        min_step: s.number("min-step", (1e-3 * first).max(least), POSITIVE),
        max_step: s.number("max-step", 10.0 * first, POSITIVE),
        safety: s.number("safety", 0.9, REDUCTION),
    };
    if s.has("min-step") && settings.min_step < least {
        let text = crate::case::literal::number(least);
        s.wrong(
            "min-step",
            format!("below the rounding of the times of the run: expected at least {text} s"),
        );
    }
    if step.is_some_and(Expression::is_constant) {
        if s.has("min-step") && settings.min_step > first {
            s.wrong("min-step", format!("expected at most time.step, {first} s"));
        }
        if s.has("max-step") && settings.max_step < first {
            s.wrong("max-step", format!("expected at least time.step, {first} s"));
        }
    }
    s.finish();
    Some(settings)
}

/// Some schemes say themselves where the factors of ∂_t are taken.
fn check_domain_motion(s: &Section<'_, '_>, scheme: Scheme, motion: Option<DomainMotion>) {
    let Some(motion) = motion else { return };
    match scheme {
        Scheme::Bdf2 | Scheme::Esdirk3 | Scheme::Esdirk4 => {
            let name = scheme.name();
            let text = format!(
                "`{name}` takes all terms at the new time, elsewhere it would lose its order: leave the key out"
            );
            s.wrong("domain-motion", text);
        }
        Scheme::Galerkin if motion != DomainMotion::Galerkin => s.wrong(
            "domain-motion",
            "`cg1` integrates all terms over the step: expected `galerkin`, or leave the key out",
        ),
        _ => {}
    }
}

/// Whether steps of Crank-Nicolson are left.
fn check_rannacher(s: &Section<'_, '_>, scheme: Scheme, step: Option<&Expression>, start: f64) {
    let Scheme::Rannacher { steps, interval } = scheme else { return };
    let Some(step) = step.filter(|step| !step.depends_on_space()) else { return };
    let damped = f64::from(steps) * step.eval(&[0.0; 3], start);
    if damped >= interval * (1.0 - 1e-9) {
        let key = if s.has("rannacher-interval") { "rannacher-interval" } else { "scheme" };
        s.wrong(
            key,
            format!("{steps} steps of backward Euler take {damped} s of every {interval} s: none is left"),
        );
    }
}

fn check_schedule(
    s: &Section<'_, '_>,
    scheme: Scheme,
    step: Option<&Expression>,
    (start, end): (f64, Option<f64>),
) {
    for (key, meaning) in [
        ("step", "the time step [s]; for a stationary case set time.scheme = \"stationary\""),
        ("end", "the last time [s]; for a stationary case set time.scheme = \"stationary\""),
    ] {
        if !s.has(key) {
            s.missing(key, meaning);
        }
    }
    if end.is_some_and(|end| end <= start) {
        s.wrong("end", format!("expected a time after the start, {start} s"));
    }
    let Some(step) = step else { return };
    if step.depends_on_space() {
        return s.wrong("step", "expected a number or an expression of t alone");
    }
    let (smallest, at) = smallest_step(step, start, end.unwrap_or(start));
    if smallest > 0.0 && smallest < RESOLUTION * at.abs() {
        let least = crate::case::literal::number(RESOLUTION * at.abs());
        let message = format!(
            "below the rounding of t = {at} s: t + step would be t, or have few of its digits; expected at least {least} s"
        );
        return s.wrong("step", message);
    }
    // A varying step is looked at where it is most likely to go wrong.
    let last = end.filter(|end| *end > start).unwrap_or(start);
    let times = (0..=100).map(|i| start + (last - start) * f64::from(i) / 100.0);
    let Some((t, k)) =
        times.map(|t| (t, step.eval(&[0.0; 3], t))).find(|(_, k)| !(k.is_finite() && *k > 0.0))
    else {
        if let Scheme::ShiftedCrankNicolson { shift } = scheme {
            let theta = 0.5 + shift * step.eval(&[0.0; 3], start);
            let message =
                format!("theta = 1/2 + shift * step = {theta} is above 1; reduce `step` or `shift`");
            if theta > 1.0 {
                s.wrong("step", message);
            }
        }
        return;
    };
    if step.is_constant() {
        s.wrong("step", "expected a number above 0");
    } else {
        let gap = step.gap(&[0.0; 3], t);
        s.wrong("step", format!("expected a value above 0 at all times, it is {k} at t = {t}{gap}"));
    }
}

/// The step that is smallest beside the time at which it is taken, and that time \[s\].
fn smallest_step(step: &Expression, start: f64, end: f64) -> (f64, f64) {
    if let Some(k) = step.constant_value() {
        return (k, if start.abs() > end.abs() { start } else { end });
    }
    let times = (0..=100).map(|i| start + (end - start) * f64::from(i) / 100.0);
    let steps = times.filter(|t| *t != 0.0).map(|t| (step.eval(&[0.0; 3], t), t));
    steps.min_by(|(a, s), (b, t)| (a / s.abs()).total_cmp(&(b / t.abs()))).unwrap_or((1.0, 0.0))
}

/// How derivatives are computed: `jacobian`, `difference`, `epsilon`.
fn jacobian(s: &mut Section<'_, '_>, linearization: Linearization) -> Tangent {
    let tangent = s.choice("jacobian", &TANGENTS, &[]).unwrap_or(Tangent::Automatic);
    let stencil = s.choice("difference", &DIFFERENCES, &[]);
    let epsilon = s.number("epsilon", EPSILON, PERTURBATION);
    if tangent == Tangent::Analytic && linearization == Linearization::FixedPoint {
        let message = "Theorem 5.2 is the Jacobian of Newton's method, not the matrix of a fixed-point \
                       iteration; expected `automatic` or `finite-difference`";
        s.wrong("jacobian", message);
    }
    if let Tangent::Difference(default) = tangent {
        return Tangent::Difference(Difference::new(stencil.unwrap_or(default.stencil), epsilon));
    }
    for key in ["difference", "epsilon"].into_iter().filter(|key| s.has(key)) {
        let note = format!("newton.{key} has no effect: newton.jacobian is not `finite-difference`");
        s.note(note);
    }
    tangent
}

/// `condensed`: whether the condensed system is the better default, in time or without a solid.
pub(super) fn newton(mut s: Section<'_, '_>, condensed: bool) -> NewtonSpec {
    let linearization = s.choice("linearization", &LINEARIZATIONS, &[]);
    let default = if condensed { Linearization::Condensed } else { Linearization::Newton };
    let mut linearization = linearization.unwrap_or(default);
    if linearization == Linearization::Condensed && !condensed {
        let note = "newton.linearization has no effect: a stationary deformation takes the full Jacobian";
        s.note(note);
        linearization = Linearization::Newton;
    }
    let jacobian = jacobian(&mut s, linearization);
    let defaults = NewtonSpec::default().settings;
    let is_newton = linearization != Linearization::Condensed;
    // From rest to a stationary state at rates of 0.6 to 0.8: no smaller steps help there.
    let is_slow = !condensed && matches!(linearization, Linearization::Reduced | Linearization::FixedPoint);
    let max_steps = if is_slow { 200 } else { defaults.max_steps };
    let rate_max = s.optional_number("rate-max", RATE);
    let spec = NewtonSpec {
        linearization,
        jacobian,
        extrapolate: s.choice("start", &STARTS, &[]).unwrap_or(true),
        settings: NewtonSettings {
            tolerance: s.number("tolerance", defaults.tolerance, REDUCTION),
            floor: s.optional_number("floor", NOT_NEGATIVE),
            rate_max: rate_max.or(is_newton.then_some(0.2)),
            secants: s.integer("secants", defaults.secants, 0..=50),
            max_steps: s.integer("max-steps", max_steps, 1..=1000),
            line_search: s.integer("line-search", defaults.line_search, 0..=30),
        },
    };
    s.finish();
    spec
}

/// The matrices that will be solved with are of this linearisation, of the bodies whose deformation is `at_rest` if one is,
/// and of `mesh`.
pub(super) fn linear(
    mut s: Section<'_, '_>,
    (linearization, at_rest): (Linearization, Option<&[SolidSpec]>),
    mesh: Option<&MeshSpec>,
) -> LinearSpec {
    let solver = if s.is_word("solver", "gmres") {
        let message = format!(
            "it is preconditioned by factors: expected one of {}, which make them, and linear.krylov = \"gmres\"",
            quoted(choice::names(&SOLVERS[..2]))
        );
        s.wrong("solver", message);
        None
    } else {
        s.choice("solver", &SOLVERS, &["umfpack", "mumps"])
    };
    let engine = s.choice("engine", &ENGINES, &[]).unwrap_or(Engine::Own);
    let (petsc, is_petsc) = (petsc(&mut s, engine), engine == Engine::Petsc);
    let refinement = s.integer("refinement", 2, 0..=20);
    let precision = s.choice("precision", &PRECISIONS, &[]).unwrap_or(Precision::Single);
    let in_space = mesh.is_some_and(|mesh| mesh.dimension == 3);
    let usual =
        if in_space && !is_petsc { LinearSolverKind::Automatic } else { LinearSolverKind::Multifrontal };
    let mut solver = solver.unwrap_or(usual);
    let is_condensed = linearization == Linearization::Condensed;
    let has_levels = at_rest.map_or(is_condensed, |solids| !solids.iter().any(|s| s.law.is_incompressible()));
    if solver == LinearSolverKind::Multigrid && !has_levels {
        let note = "linear.solver has no effect: the whole Jacobian takes `multifrontal` in time, and at rest with an \
                    incompressible body";
        s.note(note);
        solver = LinearSolverKind::Multifrontal;
    }
    if is_petsc && solver == LinearSolverKind::Multigrid {
        let note = "linear.engine: PETSc solves what multigrid cannot, and takes over where that fails";
        s.note(note);
    }
    let krylov = krylov(&mut s, solver == LinearSolverKind::Multigrid);
    s.finish();
    LinearSpec { engine, petsc, solver, refinement, precision, krylov }
}

/// Options of PETSc: names that begin with `-` and a letter, each with a value or without.
fn petsc(s: &mut Section<'_, '_>, engine: Engine) -> String {
    if engine == Engine::Own && s.has("petsc") {
        let note = "linear.petsc has no effect: linear.engine is `own`";
        s.note(note);
    }
    let mut table = s.section("petsc");
    let options = table.string("options");
    let is_name = |word: &str| {
        word.strip_prefix('-').is_some_and(|name| name.starts_with(|c: char| c.is_ascii_alphabetic()))
    };
    let mut before = None;
    for word in options.iter().flat_map(|options| options.split_whitespace()) {
        if !is_name(word) && !before.is_some_and(is_name) {
            let message = match before {
                None => format!("expected the name of an option, such as `-ksp_type`, not `{word}`"),
                Some(value) => {
                    format!("expected the name of an option behind the value `{value}`, not `{word}`")
                }
            };
            table.wrong("options", message);
            break;
        }
        before = Some(word);
    }
    table.finish();
    options.unwrap_or_else(|| USUAL_OPTIONS.into())
}

/// GMRES on top of the factors, or with `multigrid`.
fn krylov(s: &mut Section<'_, '_>, multigrid: bool) -> Option<GmresSettings> {
    let mut chosen = s.choice("krylov", &KRYLOV, &[]).flatten();
    if multigrid {
        if s.has("krylov") && chosen.is_none() {
            let note = "linear.krylov has no effect: multigrid is a part of GMRES";
            s.note(note);
        }
        chosen = Some(WITH_MULTIGRID);
    }
    let tolerance = s.number("krylov-tolerance", GMRES.tolerance, REDUCTION);
    let size = s.integer("krylov-size", if multigrid { WITH_MULTIGRID.size } else { GMRES.size }, 1..=200);
    for key in ["krylov-tolerance", "krylov-size"].into_iter().filter(|key| s.has(key) && chosen.is_none()) {
        let note = format!("linear.{key} has no effect: linear.krylov is not `gmres`");
        s.note(note);
    }
    chosen.map(|_| GmresSettings { tolerance, size })
}
