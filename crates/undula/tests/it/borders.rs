//! Terms with a scalar unknown, or with a far coupling of rank one: an outlet with a resistance, and one with a given flow.

use crate::common::{self, SCHEMES};
use std::path::Path;
use undula::case::Case;
use undula::operators::border::Borders;
use undula::operators::{DataTime, Matrix, NotFinite, Operator, StepView};
use undula::run::{Flow, Observer, RunOptions, restore_latest, run_simulation};
use undula::sampling::facet_points;
use undula::simulation::{Memory, Row, Simulation};
use undula::space::Region;
use undula::system::Assembler;

/// ∫ φ_a n over the boundary `name`: places in `[v, u, p]` with values.
fn flow(assembler: &Assembler<2>, name: &str) -> Vec<(u32, f64)> {
    let space = &assembler.space;
    let boundary = space.mesh.boundary(name).unwrap();
    let mut sums = std::collections::BTreeMap::new();
    for facet in space.mesh.facets.iter().filter(|facet| facet.boundary == boundary) {
        let nodes = space.nodes.cell(facet.cell as usize);
        for point in facet_points(space, facet, 3) {
            for (value, &node) in point.value.iter().zip(nodes) {
                for i in 0..2 {
                    *sums.entry(2 * node + i).or_insert(0.0) +=
                        point.weight * value * point.normal.0[i as usize];
                }
            }
        }
    }
    sums.into_iter().filter(|(_, value)| *value != 0.0).collect()
}

fn product(flow: &[(u32, f64)], x: &[f64]) -> f64 {
    flow.iter().map(|&(place, value)| value * x[place as usize]).sum()
}

/// The pressure of an outlet is `resistance` times its flow, or what makes the flow `given`.
enum Outlet {
    Resistance { resistance: f64, flow: Vec<(u32, f64)> },
    Given { flow: Vec<(u32, f64)>, given: f64, scalar: usize, row: usize },
}

impl Operator<2> for Outlet {
    fn body(&self) -> Region {
        Region::Fluid
    }

    fn set_data(&mut self, _: &DataTime) -> Result<(), NotFinite<2>> {
        Ok(())
    }

    fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64 {
        let (flow, pressure) = match self {
            Outlet::Resistance { resistance, flow } => (&*flow, *resistance * product(flow, &step.new.v)),
            Outlet::Given { flow, given, scalar, row } => {
                out[*row] += product(flow, &step.new.v) - *given;
                (&*flow, step.new.s[*scalar])
            }
        };
        flow.iter().for_each(|&(place, value)| out[place as usize] += pressure * value);
        f64::INFINITY
    }

    fn scalars(&self) -> usize {
        usize::from(matches!(self, Outlet::Given { .. }))
    }

    fn number_scalars(&mut self, first: usize, first_row: usize) {
        if let Outlet::Given { scalar, row, .. } = self {
            (*scalar, *row) = (first, first_row);
        }
    }

    fn borders(&mut self, _: Matrix, _: &StepView<'_>, borders: &mut Borders) {
        match self {
            Outlet::Resistance { resistance, flow } => {
                let border = borders.coupling();
                border.column.extend(flow.iter().map(|&(place, value)| (place, *resistance * value)));
                border.row.extend_from_slice(flow);
            }
            Outlet::Given { flow, scalar, .. } => {
                let border = borders.scalar(*scalar, 0.0);
                border.column.extend_from_slice(flow);
                border.row.extend_from_slice(flow);
            }
        }
    }
}

/// Poiseuille's flow through a channel of 4 m × 1 m with ρ = 1, μ = 0.1 and the pressure `p` at the inlet:
/// p − p_out = 12 μ L Q / H³ = 4.8 Q. The tractions hold the shear stress of the flow Q.
fn channel(p: f64, q: f64, more: &[&str]) -> Case {
    let energy = r#"
[functional.energy]
kind = "energy"
term = "fluid-kinetic"
"#;
    let shear = |sign: &str| format!("{sign}0.6*(1-2*y)*{q}");
    let (inlet, outlet) = ([p.to_string(), shear("-")], ["0".into(), shear("")]);
    common::channel([32, 4], inlet, outlet, energy, more)
}

/// The simulation with a term at its outlet.
fn with(case: Case, make: impl Fn(Vec<(u32, f64)>) -> Outlet) -> Simulation {
    let mut simulation = Simulation::new(case, 1).unwrap();
    let flow = flow(&simulation.stepper.assembler, "right");
    simulation.add_term(Box::new(make(flow)));
    simulation
}

fn run(simulation: &mut Simulation) -> f64 {
    simulation.step().unwrap();
    while !simulation.finished() {
        simulation.step().unwrap();
    }
    simulation.fields().integrate(|at| at.velocity[0]) / 4.0
}

const STEPS: [&str; 2] = ["time.step=0.2", "time.end=40"];

/// p = (4.8 + R) Q, with every linearisation and with GMRES; the matrix has no entry more.
#[test]
#[ignore = "long"]
fn a_resistance_is_a_coupling_of_rank_one() {
    let (p, resistance) = (3.2, 2.0);
    let q = p / (4.8 + resistance);
    let resist = |flow| Outlet::Resistance { resistance, flow };
    let mut stationary = with(channel(p, q, &[]), resist);
    let entries = stationary.stepper.assembler.pattern().nnz();
    assert!((run(&mut stationary) / q - 1.0).abs() < 1e-9);
    assert_eq!(entries, Simulation::new(channel(p, q, &[]), 1).unwrap().stepper.assembler.pattern().nnz());
    // Newton's method converges with the square as it does without: the digits double from step to step.
    let mut exact = with(channel(p, q, &["newton.rate-max=0"]), resist);
    run(&mut exact);
    let norms = &exact.stepper.newton.counters;
    let mut plain = Simulation::new(channel(p, q, &["newton.rate-max=0"]), 1).unwrap();
    run(&mut plain);
    let steps = plain.stepper.newton.counters.newton_steps;
    assert!(norms.newton_steps <= steps, "{norms:?}, {steps} without");
    let linear = [&["newton.linearization=newton"][..], &["linear.krylov=gmres"]];
    let others = linear.map(|linear| ("time.scheme=bdf2", linear));
    for (scheme, linear) in SCHEMES.map(|scheme| (scheme, &[][..])).into_iter().chain(others) {
        let case = channel(p, q, &[&[scheme][..], &STEPS, linear].concat());
        let found = run(&mut with(case, resist));
        assert!((found / q - 1.0).abs() < 1e-6, "{scheme} {linear:?}: {found} for {q}");
    }
}

/// Where the flow Q is given, the pressure of the outlet is p − 4.8 Q.
#[test]
fn a_given_flow_has_a_scalar_unknown() {
    let (p, q) = (3.2, 0.4);
    let give = |flow| Outlet::Given { flow, given: q, scalar: 0, row: 0 };
    let mut stationary = with(channel(p, q, &[]), give);
    assert!((run(&mut stationary) / q - 1.0).abs() < 1e-9);
    let found = stationary.stepper.new.s[0];
    assert!((found - (p - 4.8 * q)).abs() < 1e-9, "{found}");
    for linear in
        [&["newton.linearization=newton"][..], &["newton.linearization=condensed"], &["linear.krylov=gmres"]]
    {
        let case = channel(p, q, &[&["time.scheme=bdf2"][..], &STEPS, linear].concat());
        let mut simulation = with(case, give);
        assert!((run(&mut simulation) / q - 1.0).abs() < 1e-8, "{linear:?}");
        let found = simulation.stepper.new.s[0];
        assert!((found - (p - 4.8 * q)).abs() < 1e-6, "{linear:?}: {found}");
    }
}

/// Two borders at a time: with a resistance at the inlet as well, p − R Q is what drives the flow.
#[test]
fn borders_are_solved_together() {
    let (p, q, resistance) = (3.2, 0.4, 1.5);
    for more in [&[][..], &["time.scheme=bdf2", "time.step=0.2", "time.end=20"]] {
        let mut simulation =
            with(channel(p, q, more), |flow| Outlet::Given { flow, given: q, scalar: 0, row: 0 });
        let inlet = flow(&simulation.stepper.assembler, "left");
        simulation.add_term(Box::new(Outlet::Resistance { resistance, flow: inlet }));
        assert!((run(&mut simulation) / q - 1.0).abs() < 1e-8, "{more:?}");
        let found = simulation.stepper.new.s[0];
        assert!((found - (p - resistance * q - 4.8 * q)).abs() < 1e-6, "{more:?}: {found}");
    }
}

/// The product without a matrix is the limit of differences of the residual, borders included.
#[test]
fn products_have_borders() {
    let mut simulation = with(channel(3.2, 0.4, &[]), |flow| Outlet::Resistance { resistance: 2.0, flow });
    let flow = flow(&simulation.stepper.assembler, "right");
    simulation.add_term(Box::new(Outlet::Given { flow, given: 0.4, scalar: 0, row: 0 }));
    let mut new = simulation.stepper.new.clone();
    let assembler = &mut simulation.stepper.assembler;
    let n = assembler.n_unknowns();
    let x: Vec<f64> = (0..n).map(|i| (1.0 + i as f64).sin()).collect();
    let mut x_free = x.clone();
    assembler.zero_given(&mut x_free);
    new.add_scaled(0.3, &x_free);
    let rule = undula::physics::StepRule::STATIONARY;
    let mut at = |by: f64| {
        new.add_scaled(by, &x_free);
        let mut r = vec![0.0; n];
        assembler.residual(&StepView { rule, new: &new, old: &new }, &mut r);
        new.add_scaled(-by, &x_free);
        r
    };
    let (plus, minus) = (at(1e-4), at(-1e-4));
    let (mut y, mut work) = (vec![0.0; n], vec![]);
    assembler.apply(&StepView { rule, new: &new, old: &new }, &x_free, &mut y, &mut work);
    let largest = y.iter().fold(0.0, |m: f64, y| m.max(y.abs()));
    for ((y, plus), minus) in y.iter().zip(&plus).zip(&minus) {
        assert!((y - (plus - minus) / 2e-4).abs() < 1e-8 * largest, "{y} for {}", (plus - minus) / 2e-4);
    }
}

/// Each border costs a correction with each Jacobian, and these are counted with those of the iterations.
#[test]
fn corrections_of_borders_are_counted() {
    let more = ["time.scheme=backward-euler", "time.step=0.2", "time.end=2"];
    for borders in 0..3 {
        let mut simulation = Simulation::new(channel(3.2, 0.4, &more), 1).unwrap();
        for (name, resistance) in [("right", 2.0), ("left", 1.5)].into_iter().take(borders) {
            let flow = flow(&simulation.stepper.assembler, name);
            simulation.add_term(Box::new(Outlet::Resistance { resistance, flow }));
        }
        run(&mut simulation);
        let done = &simulation.stepper.newton.counters;
        assert!(done.jacobians > 0 && done.newton_steps > done.jacobians, "{done:?}");
        assert_eq!(
            done.linear_iterations,
            done.newton_steps + borders * done.jacobians,
            "{borders}: {done:?}"
        );
    }
}

/// Leaves a run after some steps.
struct Until(u64);

impl Observer for Until {
    fn after_step(&mut self, _: &Simulation, row: &Row) -> Flow {
        if row.step == self.0 { Flow::Stop } else { Flow::Continue }
    }
}

/// A run with a scalar unknown that is left and resumed has the bits of one that is not, the history among them.
#[test]
fn runs_with_a_scalar_unknown_are_resumed() {
    let more = ["time.scheme=bdf2", "time.step=0.2", "time.end=2"];
    let new = || with(channel(3.2, 0.4, &more), |flow| Outlet::Given { flow, given: 0.4, scalar: 0, row: 0 });
    let part = |name: &str, stop: u64, resume: bool| {
        let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let options =
            RunOptions { directory: directory.clone(), threads: 1, force: true, resume, commit: None };
        run_simulation(new(), &options, &mut Until(stop)).unwrap();
        let mut left = new();
        restore_latest(&mut left, &directory).unwrap();
        (left.save(), std::fs::read(directory.join("history.csv")).unwrap())
    };
    let (straight, history) = part("borders-straight", 0, false);
    let (early, _) = part("borders-parts", 4, false);
    let (resumed, rows) = part("borders-parts", 0, true);
    let solution = |memory: &Memory| (memory.stepper.new.clone(), memory.stepper.old.clone());
    assert!(straight.steps == 10 && early.steps == 4 && resumed.steps == 10);
    assert!(straight.stepper.new.s[0] != early.stepper.new.s[0] && early.stepper.new.s[0] != 0.0);
    assert!(solution(&straight) == solution(&resumed) && history == rows, "other bits");
    assert_eq!(straight.stepper.newton.counters, resumed.stepper.newton.counters);
}
