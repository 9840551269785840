//! How runs begin: with fields, and in equilibrium.

use crate::common::{SCHEMES, builtin, sets, wrong};
use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use undula::case::Case;
use undula::output::Status;
use undula::physics::StepRule;
use undula::run::{Flow, Observer, RunOptions, run};
use undula::simulation::{Row, Simulation};
use undula::space::{PsiOwner, State};
use undula::system::StepView;

/// A unit square of `cells` × `cells` cells with the tables `more`.
fn square(cells: u32, more: &str, overrides: &[&str]) -> Case {
    let text = format!(
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [1, 1]\ncells = [{cells}, {cells}]\n\
         [newton]\ntolerance = 1e-11\n{more}"
    );
    Case::from_toml(&text, "square.toml", &sets(overrides)).unwrap_or_else(|e| panic!("{e}"))
}

/// Runs to the end without a word.
struct Quiet;

impl Observer for Quiet {
    fn after_step(&mut self, _: &Simulation, _: &Row) -> Flow {
        Flow::Continue
    }
}

fn begin(case: &Case) -> Simulation {
    Simulation::new(case.clone(), 1).unwrap_or_else(|e| panic!("{e}"))
}

fn finish(simulation: &mut Simulation) {
    while !simulation.finished() {
        simulation.step().unwrap_or_else(|e| panic!("{e}"));
    }
}

/// Why `case` cannot begin.
fn refused(case: &Case) -> String {
    Simulation::new(case.clone(), 1).err().map_or("it can".into(), |error| error.to_string())
}

/// Rows (J F⁻¹ : ∇vᵀ, ξ) of the fluid.
fn divergence(simulation: &mut Simulation, state: &State) -> f64 {
    let assembler = &mut simulation.stepper.assembler;
    let mut r = vec![0.0; assembler.n_unknowns()];
    let view = StepView { rule: StepRule::STATIONARY, new: state, old: state };
    assembler.residual(&view, &mut r);
    let first = state.v.len() + state.u.len();
    r[first..first + state.p.len()].iter().fold(0.0, |most, x| x.abs().max(most))
}

/// Vortices that decay, v = (−cos πx sin πy, sin πx cos πy) exp(−2νπ²t), in a box that gives v on its sides.
fn vortices(scheme: &str, step: f64) -> Case {
    let v = ["-cos(pi*x)*sin(pi*y)*exp(-0.1*pi^2*t)", "sin(pi*x)*cos(pi*y)*exp(-0.1*pi^2*t)"];
    let sides: String = ["left", "right", "top", "bottom"]
        .map(|side| format!("[boundary.{side}]\ncondition = \"velocity\"\nvelocity = {v:?}\n"))
        .concat();
    let more = format!(
        "[space]\nvelocity = \"Q4\"\n[fluid]\ndensity = 2\nkinematic-viscosity = 0.05\n{sides}\
         [initial]\nvelocity = {v:?}\n[time]\nstep = {step}\nend = 0.8\n"
    );
    square(5, &more, &[scheme])
}

/// Largest error of v at the nodes at the end, and of p at the time of the forces of the first step.
fn errors_of_vortices(scheme: &str, step: f64) -> [f64; 2] {
    let mut simulation = begin(&vortices(scheme, step));
    simulation.step().unwrap();
    let t = simulation.stepper.force_time();
    let p =
        |x: f64, y: f64| -0.5 * ((2.0 * PI * x).cos() + (2.0 * PI * y).cos()) * (-0.2 * PI * PI * t).exp();
    let mut gap = 0.0f64;
    for [x, y] in [[0.2, 0.3], [0.4, 0.1], [0.5, 0.5], [0.8, 0.7]] {
        gap = gap.max((simulation.fields().at([x, y]).unwrap().pressure - p(x, y)).abs());
    }
    finish(&mut simulation);
    let decay = (-0.08 * PI * PI).exp();
    let fields = simulation.fields();
    let exact = |[x, y]: [f64; 2]| {
        [-(PI * x).cos() * (PI * y).sin() * decay, (PI * x).sin() * (PI * y).cos() * decay]
    };
    let error = fields.coordinates().iter().zip(fields.velocity()).fold(0.0f64, |most, (x, v)| {
        let exact = exact(*x);
        most.max((v[0] - exact[0]).abs()).max((v[1] - exact[1]).abs())
    });
    [error, gap]
}

/// The first step included, which begins with the projected field.
#[test]
fn vortices_decay_with_second_order() {
    for scheme in SCHEMES.into_iter().filter(|scheme| !scheme.ends_with("backward-euler")) {
        let [coarse, fine] = [0.2, 0.1].map(|step| errors_of_vortices(scheme, step));
        let order = (coarse[0] / fine[0]).log2();
        println!(
            "{scheme}: errors of v {:.3e} {:.3e}, order {order:.2}; of p in the first step {:.2e} {:.2e}",
            coarse[0], fine[0], coarse[1], fine[1]
        );
        // The error in space is 9e-7.
        assert!(order > 1.8 || fine[0] < 1e-6, "{scheme}: {order}");
        // In space that of p is 5e-4.
        let small = fine[1] < 0.6 * coarse[1] || coarse[1] < 1e-3;
        assert!(fine[1] < 0.03 && small, "{scheme}: {coarse:?}, {fine:?}");
    }
}

const CHANNEL: &str = "[fluid]\ndensity = 3\nkinematic-viscosity = 0.1\n\
    [boundary.left]\ncondition = \"velocity\"\nvelocity = [\"4*y*(1-y)\", 0]\n\
    [boundary.right]\ncondition = \"do-nothing\"\n[boundary.top]\ncondition = \"no-slip\"\n\
    [boundary.bottom]\ncondition = \"no-slip\"\n[time]\nstep = 0.1\nend = 0.3\n";

/// A velocity without divergence stays; any other one becomes the nearest without, so that nothing of it is left to a
/// second projection, and what was taken off is orthogonal to all that is free of divergence.
#[test]
fn initial_velocities_are_made_free_of_divergence() {
    for elements in [&[][..], &["space.pressure=Q1"], &["space.velocity=P2-bubble"], &["space.velocity=Q3"]] {
        let of = |v: &str| {
            let mut simulation =
                begin(&square(4, &format!("{CHANNEL}[initial]\nvelocity = {v}\n"), elements));
            let state = simulation.stepper.new.clone();
            let left = divergence(&mut simulation, &state);
            assert!(left < 1e-13, "{elements:?}: {left:e}");
            (simulation, state)
        };
        let (mut simulation, parabola) = of("[\"4*y*(1-y)\", 0]");
        for (x, v) in simulation.fields().coordinates().iter().zip(simulation.fields().velocity()) {
            assert!(
                (v[0] - 4.0 * x[1] * (1.0 - x[1])).abs().max(v[1].abs()) < 1e-12,
                "{elements:?}: {v:?} at {x:?}"
            );
        }
        simulation.step().unwrap();
        for (x, v) in simulation.fields().coordinates().iter().zip(simulation.fields().velocity()) {
            assert!(
                (v[0] - 4.0 * x[1] * (1.0 - x[1])).abs().max(v[1].abs()) < 1e-9,
                "{elements:?}: {v:?} at {x:?}"
            );
        }
        // v₀ − v is orthogonal to the differences of fields without divergence and with the same data.
        let (mut simulation, v) = of("[\"4*y*(1-y)*(1+x)\", \"x*y*(1-y)\"]");
        let (_, other) = of("[\"4*y*(1-y)*(1-2*x^2)\", \"sin(x)*y*(1-y)\"]");
        let mut given = State { p: vec![0.0; v.p.len()], ..v.clone() };
        for (v, [x, y]) in given.v.chunks_exact_mut(2).zip(simulation.fields().coordinates()) {
            v.copy_from_slice(&[4.0 * y * (1.0 - y) * (1.0 + x), x * y * (1.0 - y)]);
        }
        let assembler = &mut simulation.stepper.assembler;
        // Bubbles have no place of their own.
        if assembler.space.nodes.n_lagrange == given.v.len() / 2 {
            let mut taken = vec![0.0; assembler.n_unknowns()];
            let rule = StepRule { per_k: 1.0, theta: 0.0, ..StepRule::STATIONARY };
            assembler.residual(&StepView { rule, new: &v, old: &given }, &mut taken);
            let product = |a: &State| {
                taken.iter().zip(a.v.iter().zip(&parabola.v)).map(|(m, (a, b))| m * (a - b)).sum::<f64>()
            };
            let size = taken[..v.v.len()].iter().map(|x| x.abs()).sum::<f64>();
            let parts = [product(&v), product(&other)];
            println!("{elements:?}: {parts:?} of {size:.2e}");
            assert!(size > 0.1 && parts.iter().all(|part| part.abs() < 1e-13), "{elements:?}: {parts:?}");
        }
    }
}

/// A tube under pressure, fluid below and solid above, without anything that moves along it.
const TUBE: &str = "[fluid]\ndensity = 1e3\nkinematic-viscosity = 1e-3\n[mesh.region]\nsolid = \"y - 0.75\"\n\
    [solid]\ndensity = 1e3\nlaw = \"neo-hookean\"\nmu = 1e5\nlambda = 4e5\n\
    [boundary.bottom]\ncondition = \"symmetry\"\n[boundary.right]\ncondition = \"symmetry\"\n\
    [boundary.top]\ncondition = \"symmetry\"\n[boundary.left]\ncondition = \"pressure\"\n";

/// A block that is clamped at its left side.
const BLOCK: &str = "[mesh.region]\nsolid = \"1\"\n[solid]\ndensity = 1e3\nlaw = \"neo-hookean\"\nmu = 1e5\nlambda = 4e5\n\
    [boundary.left]\ncondition = \"clamped\"\n[boundary.top]\ncondition = \"traction-free\"\n\
    [boundary.bottom]\ncondition = \"traction-free\"\n[boundary.right]\n";

const STATIC: &str = "[initial]\nstatic = true\n[time]\nstart = 0.5\nend = 1\nstep = 0.1\n";

fn most(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most, x| most.max(x.abs()))
}

fn gap(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

/// How much u and v change in a run, relative to the largest of both.
fn drift(case: &Case) -> f64 {
    let mut simulation = begin(case);
    assert!(case.notes().iter().all(|note| !note.contains("initial.static")));
    assert!(simulation.case.notes().iter().any(|note| note.contains("initial.static")));
    let start = simulation.stepper.new.clone();
    finish(&mut simulation);
    let now = &simulation.stepper.new;
    let [u, v] = [gap(&now.u, &start.u), gap(&now.v, &start.v)];
    let size = most(&start.u).max(most(&start.v));
    println!(
        "u {:.3e} m, its change {u:.1e} m, v {:.3e} m/s, its change {v:.1e} m/s",
        most(&start.u),
        most(&start.v)
    );
    assert!(most(&start.u) > 1e-6);
    u.max(v) / size
}

/// A beam that gravity has bent, a tube under pressure and a block that is held deformed stay as they are.
#[test]
fn what_is_in_equilibrium_stays() {
    let gravity = "condition = \"traction-free\"\n";
    for scheme in SCHEMES {
        let beam = square(4, &format!("{BLOCK}{gravity}{STATIC}"), &[scheme, "solid.body-force=[0,-10]"]);
        let tube = square(4, &format!("{TUBE}pressure = 2e4\n{STATIC}"), &[scheme]);
        let drawn =
            format!("{BLOCK}condition = \"displacement\"\ndisplacement = [\"0.2\", \"-0.1\"]\n{STATIC}");
        for case in [beam, tube, square(4, &drawn, &[scheme])] {
            let gone = drift(&case);
            assert!(gone < 1e-9, "{scheme}: {gone:e}");
        }
    }
}

const SHORT: [&str; 5] =
    ["mesh.refine=0", "initial.static=true", "time.step=0.01", "time.end=0.05", "newton.tolerance=1e-12"];

#[test]
fn a_bent_beam_in_water_stays() {
    let water = ["solid.body-force=[0,-2]", "boundary.inflow.velocity=[0,0]"];
    let gone = drift(&builtin("fsi3", &[&SHORT[..], &water].concat()));
    assert!(gone < 1e-9, "{gone:e}");
}

#[test]
fn a_stationary_flow_past_a_beam_stays() {
    let gone = drift(&builtin("fsi1", &[&SHORT[..], &["time.scheme=crank-nicolson"]].concat()));
    assert!(gone < 1e-9, "{gone:e}");
}

/// The start is the stationary solution, whatever the number of threads.
#[test]
fn a_static_start_is_the_stationary_solution() {
    let of = |more: &str, threads: usize| {
        let case = square(4, &format!("{TUBE}pressure = \"4e4*t\"\n{more}"), &[]);
        Simulation::new(case, threads).unwrap_or_else(|e| panic!("{e}"))
    };
    let mut alone = of("[time]\nscheme = \"stationary\"\nend = 0.5\n", 1);
    alone.step().unwrap();
    let starts = [1, 2].map(|threads| of(STATIC, threads).stepper.new.clone());
    assert!(starts[0] == starts[1]);
    let (start, alone) = (&starts[0], &alone.stepper.new);
    assert!(
        gap(&start.u, &alone.u) < 1e-10 && gap(&start.p, &alone.p) < 1e-5,
        "{:e}",
        gap(&start.p, &alone.p)
    );
    assert!(start.p.iter().all(|p| p.abs() < 2.1e4) && most(&start.u) > 1e-2);
}

/// The load is raised in parts where the whole of it takes too many iterations, to the same solution.
fn raised(more: &str, load: &str) {
    let solve = |max: usize| {
        let steps = format!("newton.max-steps={max}");
        let mut simulation = begin(&square(4, more, &["newton.tolerance=1e-9", &steps, load]));
        let row = simulation.step();
        row.map(|_| (simulation.report.residuals_of_parts().count(), simulation.stepper.new.clone()))
    };
    let (_, whole) = solve(50).unwrap();
    let all: Vec<_> = (2..9).rev().filter_map(|max| solve(max).ok()).collect();
    let parts: Vec<usize> = all.iter().map(|(parts, _)| *parts).collect();
    let (_, state) = all.iter().find(|(parts, _)| *parts > 1).unwrap_or_else(|| panic!("{parts:?}"));
    let ([v, u], [sv, su]) =
        ([gap(&state.v, &whole.v), gap(&state.u, &whole.u)], [most(&whole.v), most(&whole.u)]);
    println!("{parts:?} parts, u {su:.2e} v {sv:.2e}, differences {u:.1e} {v:.1e}");
    assert!(u <= 1e-7 * su && v <= 1e-7 * sv.max(su), "{u:e} {v:e}");
}

#[test]
fn tractions_are_raised_in_parts() {
    raised(&format!("{BLOCK}condition = \"traction\"\ntraction = [1.5e5, 5e4]\n"), "newton.line-search=5");
}

#[test]
fn pressures_are_raised_in_parts() {
    raised(&format!("{BLOCK}condition = \"pressure\"\npressure = -1e5\n"), "newton.line-search=5");
}

#[test]
fn displacements_are_raised_in_parts() {
    let more = format!("{BLOCK}condition = \"displacement\"\ndisplacement = [0.3, 0.2]\n");
    raised(&more, "newton.line-search=5");
}

#[test]
fn body_forces_are_raised_in_parts() {
    raised(&format!("{BLOCK}condition = \"traction-free\"\n"), "solid.body-force=[0,-40]");
}

#[test]
fn velocities_are_raised_in_parts() {
    let walls =
        ["left", "right", "bottom"].map(|side| format!("[boundary.{side}]\ncondition = \"no-slip\"\n"));
    let lid = "[fluid]\ndensity = 1\nkinematic-viscosity = 5e-3\n[boundary.top]\ncondition = \"velocity\"\n\
        velocity = [\"16*x^2*(1-x)^2\", 0]\n";
    raised(&format!("{lid}{}", walls.concat()), "newton.line-search=5");
}

/// A wall that is far from where the mesh has it takes the mesh along.
#[test]
fn a_stationary_wall_takes_the_mesh_along() {
    let sides =
        ["top", "bottom", "right"].map(|side| format!("[boundary.{side}]\ncondition = \"slip\"\n")).concat();
    let more = format!(
        "[fluid]\ndensity = 1\nkinematic-viscosity = 0.1\nbody-force = [1, 0]\n[boundary.left]\ncondition = \"displacement\"\n\
         displacement = [0.4, 0]\n{sides}"
    );
    let mut simulation = begin(&square(8, &more, &["motion.model=harmonic"]));
    simulation.step().unwrap();
    assert_eq!(simulation.report.residuals_of_parts().count(), 1);
}

/// A standing wave u = A sin πx cos(ωt + φ) between planes of symmetry: ω = π √((λ + 2μ)/ρ) = 2π.
fn wave(phase: f64, start: f64, end: f64, overrides: &[&str]) -> Case {
    let sides = ["left", "right", "top", "bottom"];
    let sides = sides.map(|side| format!("[boundary.{side}]\ncondition = \"symmetry\"\n")).concat();
    let more = format!(
        "[space]\nvelocity = \"Q4\"\n[mesh.region]\nsolid = \"1\"\n\
         [solid]\ndensity = 1\nlaw = \"linear\"\nmu = 1\nlambda = 2\n{sides}\
         [initial]\ndisplacement = [\"0.1*sin(pi*x)*cos(2*pi*t + {phase})\", 0]\n\
         velocity = [\"-0.2*pi*sin(pi*x)*sin(2*pi*t + {phase})\", 0]\n\
         [time]\nstart = {start}\nend = {end}\nstep = 0.05\n"
    );
    square(3, &more, overrides)
}

/// u in the middle, beside A cos(ωt + φ).
fn gap_of_wave(simulation: &Simulation, phase: f64) -> f64 {
    let u = simulation.fields().at([0.5, 0.5]).unwrap().displacement[0];
    (u - 0.1 * (2.0 * PI * simulation.time() + phase).cos()).abs()
}

#[test]
fn an_oscillation_begins_in_phase() {
    for scheme in SCHEMES.into_iter().filter(|scheme| !scheme.ends_with("backward-euler")) {
        for (phase, start) in [(0.7, 0.0), (0.7, 0.3)] {
            let gaps = ["time.step=0.04", "time.step=0.02"].map(|step| {
                let mut simulation =
                    begin(&wave(phase, start, start + 0.8, &[scheme, step, "time.shift=0.1"]));
                assert!(gap_of_wave(&simulation, phase) < 1e-5);
                finish(&mut simulation);
                gap_of_wave(&simulation, phase)
            });
            let order = (gaps[0] / gaps[1]).log2();
            println!("{scheme}, from {start}: {gaps:.3?}, order {order:.2}");
            assert!(gaps[1] < 0.01 && order > 1.6, "{scheme}: {gaps:?}");
        }
    }
}

/// Runs of the wave on files: stopped and resumed with the bits of one run, and taken on by another run in phase.
#[test]
fn an_oscillation_goes_on_in_phase() {
    let place = |name: &str| Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("initial-{name}"));
    let compute = |name: &str, case: Case, threads: usize, resume: bool| {
        let options = RunOptions { directory: place(name), threads, force: true, resume, commit: None };
        let summary = run(case, &options, &mut Quiet).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(summary.status, Status::Completed);
        summary
    };
    let history = |name: &str| fs::read_to_string(place(name).join("history.csv")).unwrap();
    let point =
        ["functional.u.kind=displacement", "functional.u.point=[0.5,0.5]", "functional.u.component=x"];
    let of = |end: f64, more: &[&str]| wave(0.7, 0.0, end, &[&point[..], &["time.step=0.01"], more].concat());
    let summary = compute("whole", of(0.8, &[]), 1, false);
    assert_eq!(summary.start.as_deref(), Some("initial.velocity, initial.displacement"));
    compute("parts", of(0.4, &[]), 2, false);
    compute("parts", of(0.8, &[]), 1, true);
    assert_eq!(history("parts"), history("whole"));
    compute("first", of(0.4, &[]), 1, false);
    let from = format!("initial.from={}", place("first").display());
    let mut text = of(0.8, &[]).to_toml();
    let begins = text.find("[initial]").unwrap();
    let ends = begins + text[begins..].find("\n\n").unwrap();
    text.replace_range(begins..ends, "");
    let next = Case::from_toml(&text.replace("start = 0.0", ""), "next.toml", &sets(&[&from])).unwrap();
    compute("second", next, 1, false);
    let last = |name: &str| -> f64 {
        history(name).lines().last().unwrap().split(',').nth(3).unwrap().parse().unwrap()
    };
    let exact = 0.1 * (1.6 * PI + 0.7).cos();
    println!("{} and {} for {exact}", last("whole"), last("second"));
    assert!((last("second") - last("whole")).abs() < 1e-9 && (last("second") - exact).abs() < 2e-3);
    // Another field is another run.
    let other = wave(0.8, 0.0, 1.0, &[&point[..], &["time.step=0.01"]].concat());
    let options =
        RunOptions { directory: place("parts"), threads: 1, force: true, resume: true, commit: None };
    let error = run(other, &options, &mut Quiet).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(error.contains("initial."), "{error}");
}

/// In the solid as given, in the fluid extended and free of divergence on the moved domain, with every extension.
fn fields_fit(model: &str) {
    let fields = "pressure = 0\n[initial]\ndisplacement = [\"0.1*(1-x)*y\", \"0.1*x*(1-x)*(1-y)\"]\n\
        velocity = [\"(1-x)*y\", \"0.1*x*y*(1-y)\"]\n[time]\nend = 0.02\nstep = 0.01\n";
    let mut simulation = begin(&square(4, &format!("{TUBE}{fields}"), &[&format!("motion.model={model}")]));
    let state = simulation.stepper.new.clone();
    let space = simulation.stepper.assembler.space.clone();
    for (node, [x, y]) in space.nodes.points.iter().enumerate() {
        let place = 2 * node..2 * node + 2;
        if space.owner[node] == PsiOwner::Relation {
            let (v, u) = (
                [(1.0 - x) * y, 0.1 * x * y * (1.0 - y)],
                [0.1 * (1.0 - x) * y, 0.1 * x * (1.0 - x) * (1.0 - y)],
            );
            assert!(gap(&state.v[place.clone()], &v) < 1e-14 && gap(&state.u[place], &u) < 1e-14, "{model}");
        }
    }
    let assembler = &mut simulation.stepper.assembler;
    let mut r = vec![0.0; assembler.n_unknowns()];
    assembler.residual(&StepView { rule: StepRule::STATIONARY, new: &state, old: &state }, &mut r);
    let (first, n) = (state.v.len(), state.u.len());
    let extension = (0..n).filter(|place| space.owner[place / 2] == PsiOwner::Extension);
    let extension = extension.fold(0.0f64, |most, place| most.max(r[first + place].abs()));
    let left = divergence(&mut simulation, &state);
    println!("{model}: extension {extension:.1e}, divergence {left:.1e}");
    let size = if model == "biharmonic" { 1e-6 } else { 1e-9 };
    assert!(extension < size && left < 1e-12, "{model}: {extension:e}, {left:e}");
    simulation.step().unwrap_or_else(|e| panic!("{model}: {e}"));
}

#[test]
fn initial_fields_of_both_bodies_fit() {
    ["harmonic", "pseudo-elastic"].into_iter().for_each(fields_fit);
}

#[test]
fn initial_displacements_are_extended_by_stiffening_models() {
    fields_fit("jacobian-stiffened");
}

#[test]
fn initial_displacements_are_extended_by_the_biharmonic_model() {
    fields_fit("biharmonic");
}

#[test]
fn starts_that_make_no_sense_are_refused() {
    let block = |more: &str| square(2, &format!("{BLOCK}{more}\n[time]\nend = 1\nstep = 0.1\n"), &[]);
    let drawn = "condition = \"displacement\"\ndisplacement = [\"0.1*cos(t)\", 0]\n[initial]\n";
    let free = "condition = \"traction-free\"\n[initial]\n";
    for (case, words) in [
        (format!("{drawn}velocity = [0, 0]"), ["boundary.right.displacement", "initial.static"]),
        (format!("{drawn}displacement = [\"0.2*x\", 0]"), ["initial.displacement", "`right`"]),
        (format!("{free}displacement = [\"0.2\", 0]"), ["initial.displacement", "`left`"]),
        (format!("{free}displacement = [\"-2*x\", 0]"), ["initial.displacement", "fold"]),
        (format!("{free}velocity = [\"1/(x-1)\", 0]"), ["initial.velocity", "finite"]),
    ] {
        let message = refused(&block(&case));
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
    assert_eq!(refused(&block(&format!("{drawn}displacement = [\"0.1*x\", 0]"))), "it can");
    assert_eq!(refused(&block(&format!("{drawn}static = true"))), "it can");
    let loose =
        BLOCK.replace("clamped", "traction-free") + free + "static = true\n[time]\nend = 1\nstep = 0.1\n";
    assert!(refused(&square(2, &loose, &[])).contains("solid"), "{}", refused(&square(2, &loose, &[])));
    let closed =
        TUBE.replace("\"pressure\"\n", "\"symmetry\"\n") + "[time]\nend = 1\nstep = 0.1\n[initial]\n";
    let of = |v: &str| refused(&square(4, &format!("{closed}velocity = {v}\n"), &[]));
    assert!(of("[0, \"y-1\"]").contains("closed in"), "{}", of("[0, \"y-1\"]"));
    assert_eq!(of("[0, \"(1-y)*cos(2*pi*x)*sin(2*pi*x)\"]"), "it can");
    let channel = |more: &str| {
        format!(
            "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [1,1]\ncells = [1,1]\n{CHANNEL}[initial]\n{more}\n"
        )
    };
    for (more, words) in [
        ("static = true\nvelocity = [0, 0]", "stationary solution is the start"),
        ("static = true\nfrom = \"other\"", "whole state"),
        ("from = \"other\"\ndisplacement = [0, 0]", "whole state"),
        ("static = 1", "true or false"),
        ("velocity = [0]", "two expressions"),
        ("colour = 1", "`static`"),
    ] {
        let message = wrong(&channel(more), &[]);
        assert!(message.contains("initial.") && message.contains(words), "{message}");
    }
    let message = wrong(&channel("velocity = [0, 0]"), &["time=none"]);
    assert!(message.contains("a stationary case has no start"), "{message}");
    let message = refused(&square(2, &format!("{CHANNEL}[initial]\ndisplacement = [0, 0]\n"), &[]));
    assert!(message.contains("no solid"), "{message}");
    // Written and read again.
    for start in ["static = true", "velocity = [\"x\", 0]\ndisplacement = [0, \"x*t\"]"] {
        let case = block(&format!("{free}{start}"));
        assert_eq!(Case::from_toml(&case.to_toml(), "again.toml", &[]).unwrap(), case);
    }
}

/// The pressure of the start of a channel between given velocities is linear, with every scheme and pair of elements.
#[test]
fn the_first_pressure_of_poiseuille_is_linear() {
    let elements: [&[&str]; 4] = [
        &[],
        &["space.velocity=Q3", "space.pressure=P2dc"],
        &["space.velocity=P2", "space.pressure=P1"],
        &["time.scheme=fractional-step-theta"],
    ];
    for more in elements {
        let ends = "condition = \"velocity\"\nvelocity = [\"4*y*(1-y)\", 0]";
        let start = "[initial]\nvelocity = [\"4*y*(1-y)\", 0]\n[time]\nstep = 0.1\nend = 0.2\n";
        let open = "condition = \"pressure\"\npressure = 7";
        let case = crate::common::channel_between([4, 2], [ends, open], start, more);
        let simulation = begin(&case);
        for at in [[0.1, 0.3], [2.0, 0.9], [3.7, 0.5]] {
            let p = simulation.fields().at(at).unwrap().pressure;
            // ρ ν ∂²v/∂y² = −0.8 Pa/m.
            assert!((p - 7.0 - 0.8 * (4.0 - at[0])).abs() < 1e-8, "{more:?}: {p} at {at:?}");
        }
        assert!(simulation.case.notes().iter().all(|note| !note.contains("no pressure")));
    }
}

/// Vortices between walls without friction: v = (sin x cos y, −cos x sin y) on (0, π)², p = ¼ ρ (cos 2x + cos 2y) whatever
/// the viscosity. The error falls with the order of the pressure; a velocity that changes in time asks for ∂_t v.
#[test]
fn the_first_pressure_of_taylor_and_green_has_its_order() {
    let error = |n: usize, elements: &[&str], moving: bool| {
        let pi = std::f64::consts::PI;
        let factor = if moving { "exp(-0.2*t)" } else { "1" };
        let v = format!("[\"sin(x)*cos(y)*{factor}\", \"-cos(x)*sin(y)*{factor}\"]");
        let side = if moving { format!("\"velocity\"\nvelocity = {v}") } else { "\"slip\"".to_string() };
        let sides = ["left", "right", "top", "bottom"]
            .map(|name| format!("[boundary.{name}]\ncondition = {side}\n"))
            .concat();
        let text = format!(
            "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [{pi}, {pi}]\ncells = [{n}, {n}]\n\
             [fluid]\ndensity = 2\nkinematic-viscosity = 0.1\n{sides}[initial]\nvelocity = {v}\n\
             [time]\nscheme = \"crank-nicolson\"\nstep = 0.1\nend = 0.2\n[newton]\ntolerance = 1e-11\n"
        );
        let simulation = begin(&Case::from_toml(&text, "vortex.toml", &sets(elements)).unwrap());
        let exact = |[x, y]: [f64; 2]| 0.5 * ((2.0 * x).cos() + (2.0 * y).cos());
        let fields = simulation.fields();
        let mean = fields.integrate(|at| at.pressure - exact(at.x)) / (pi * pi);
        fields.integrate(|at| (at.pressure - exact(at.x) - mean).powi(2)).sqrt()
    };
    for (elements, moving, order) in [
        (&[][..], false, 1.9),
        (&[], true, 1.9),
        (&["space.velocity=Q3", "space.pressure=P2dc"], false, 2.8),
        (&["space.velocity=P2", "space.pressure=P1"], true, 1.9),
    ] {
        let errors = [error(4, elements, moving), error(8, elements, moving)];
        let found = (errors[0] / errors[1]).log2();
        assert!(found > order && errors[1] < 0.1, "{elements:?}, moving {moving}: {errors:?}, order {found}");
    }
}

/// Poiseuille's flow, which is given in equilibrium with what is behind its outlet, stays as it is given: outlets have no part
/// in making it free of divergence.
#[test]
fn flows_before_outlets_begin_as_they_are_given() {
    let outlets: [&[&str]; 4] = [
        &["boundary.right.condition=resistance", "boundary.right.resistance=2.85"],
        &[
            "boundary.right.condition=resistance",
            "boundary.right.resistance=0",
            "boundary.right.pressure=3.8",
        ],
        &[
            "boundary.right.condition=pressure",
            "boundary.right.pressure=3.8",
            "boundary.right.backflow=directional",
        ],
        &[
            "boundary.right.condition=pressure",
            "boundary.right.pressure=3.8",
            "boundary.left.condition=flux",
            "boundary.left.pressure=none",
            "boundary.left.flow-rate=-1.3333333333333333",
        ],
    ];
    for outlet in outlets {
        let text = "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [4, 1]\ncells = [2, 2]\n[fluid]\ndensity = 2\n\
                    kinematic-viscosity = 0.05\n[boundary.bottom]\ncondition = \"no-slip\"\n[boundary.top]\n\
                    condition = \"no-slip\"\n[boundary.left]\ncondition = \"pressure\"\npressure = 10.2\n[boundary.right]\n\
                    condition = \"do-nothing\"\n[time]\nscheme = \"crank-nicolson\"\nstep = 0.1\nend = 0.2\n[initial]\n\
                    velocity = [\"8*y*(1-y)\", 0]\n[newton]\ntolerance = 1e-11\n";
        // 12 μ Q L/H³ = 6.4 Pa, and 3.8 Pa = 2.85 Pa s/m² · 4/3 m²/s.
        let case = Case::from_toml(text, "channel.toml", &sets(outlet)).unwrap();
        let mut simulation = begin(&case);
        let gap = |simulation: &Simulation| {
            let fields = simulation.fields();
            let both = fields.coordinates().into_iter().zip(fields.velocity());
            both.map(|(x, v)| (v[0] - 8.0 * x[1] * (1.0 - x[1])).abs().max(v[1].abs())).fold(0.0, f64::max)
        };
        assert!(gap(&simulation) < 1e-10, "{outlet:?}: {}", gap(&simulation));
        let p = simulation.fields().at([1.0, 0.3]).unwrap().pressure;
        assert!((p - 8.6).abs() < 1e-4, "{outlet:?}: {p}");
        finish(&mut simulation);
        assert!(gap(&simulation) < 1e-7, "{outlet:?}: {}", gap(&simulation));
    }
}
