//! Given flows with the profile of a flow that is fully developed.

use crate::common::{channel_between, sets, wrong};
use std::f64::consts::TAU;
use undula::case::{Case, MeshSource, OwnMesh};
use undula::simulation::Simulation;

const WALL: &str = "condition = \"no-slip\"";

/// A channel of 4 m × 1 m with ν = 0.1 into which a flow comes at `left`.
fn channel(cells: [usize; 2], left: &str, more: &[&str]) -> Case {
    let left = format!("condition = \"flux\"\n{left}");
    let flows = "[functional.in]\nkind = \"flux\"\non = [\"left\"]\n[functional.out]\nkind = \"flux\"\non = [\"right\"]\n";
    channel_between(cells, [&left, "condition = \"do-nothing\""], flows, more)
}

/// The velocity at the nodes with x = 0 at the first time of the data.
fn inlet(case: Case) -> Vec<([f64; 2], [f64; 2])> {
    let simulation = Simulation::new(case, 1).unwrap();
    let (space, mut state) = (&simulation.stepper.assembler.space, simulation.stepper.new.clone());
    let constraints = &simulation.stepper.assembler.constraints;
    constraints.apply(space, simulation.case.at_time, &mut state.v, &mut state.u);
    let at_left = |node: &u32| {
        let node = *node as usize;
        (space.nodes.points[node], [state.v[2 * node], state.v[2 * node + 1]])
    };
    space.boundary_nodes("left").iter().map(at_left).collect()
}

/// v = 6 Q y (1 − y): exact from degree 2 on, and Poiseuille's flow behind it.
#[test]
fn a_parabola_is_exact() {
    let pairs: [&[&str]; 5] = [
        &[],
        &["space.velocity=Q3", "space.pressure=P2dc", "newton.linearization=newton"],
        &["space.velocity=Q4", "space.pressure=Q3"],
        &["space.velocity=P2", "space.pressure=P1"],
        &["space.velocity=P2-bubble", "space.pressure=P1dc"],
    ];
    for pair in pairs {
        let case = || channel([3, 3], "flow-rate = \"-0.7\"\nprofile = \"parabolic\"", pair);
        for ([_, y], v) in inlet(case()) {
            let gap = (v[0] - 4.2 * y * (1.0 - y)).abs().max(v[1].abs());
            assert!(gap < 1e-12, "{pair:?}: {v:?} at {y}, {gap:e}");
        }
        let mut simulation = Simulation::new(case(), 1).unwrap();
        let row = simulation.step().unwrap();
        assert!((row["in"] + 0.7).abs() < 1e-12 && (row["out"] - 0.7).abs() < 1e-10, "{pair:?}");
        for (x, v) in simulation.fields().coordinates().iter().zip(simulation.fields().velocity()) {
            assert!(
                (v[0] - 4.2 * x[1] * (1.0 - x[1])).abs() < 1e-9 && v[1].abs() < 1e-9,
                "{pair:?} at {x:?}"
            );
        }
    }
    // The sides of linear elements bring the flow, too.
    let linear = ["space.velocity=Q1", "space.pressure=Q1", "mesh.refine=1"];
    let mut simulation =
        Simulation::new(channel([2, 3], "flow-rate = -0.7\nprofile = \"parabolic\"", &linear), 1).unwrap();
    let row = simulation.step().unwrap();
    assert!((row["in"] + 0.7).abs() < 1e-12, "{}", row["in"]);
}

/// The upper half of a channel has half of its profile: no rim at a plane of symmetry.
#[test]
fn a_plane_of_symmetry_is_no_rim() {
    let left = "flow-rate = -0.7\nprofile = \"parabolic\"";
    for ([_, y], v) in inlet(channel([3, 3], left, &["boundary.bottom.condition=symmetry"])) {
        assert!((v[0] - 1.05 * (1.0 - y * y)).abs() < 1e-12, "{v:?} at {y}");
    }
    let case = channel([3, 3], left, &["boundary.bottom.condition=slip", "boundary.top.condition=slip"]);
    let message = Simulation::new(case, 1).err().map_or(String::new(), |e| e.to_string());
    assert!(message.contains("boundary.left.profile") && message.contains("no wall meets"), "{message}");
}

/// An inclined section: v is along its normal, and the flow is the given one; triangles and quadrilaterals.
#[test]
fn an_inclined_section_brings_its_flow() {
    for pair in [["space.velocity=Q2", "space.pressure=P1dc"], ["space.velocity=P2", "space.pressure=P1"]] {
        let mut case = channel([3, 4], "flow-rate = -0.7\nprofile = \"parabolic\"", &pair);
        let mut mesh = case.build_mesh().unwrap();
        let (s, c) = 0.4f64.sin_cos();
        mesh.nodes.iter_mut().for_each(|x| *x = [c * x[0] - s * x[1], s * x[0] + c * x[1]]);
        case.mesh.source = MeshSource::Own(OwnMesh(mesh.into()));
        for (x, v) in inlet(case.clone()) {
            let y = c * x[1] - s * x[0];
            let speed = 4.2 * y * (1.0 - y);
            let gap = (v[0] - c * speed).abs().max((v[1] - s * speed).abs());
            assert!(gap < 1e-12, "{pair:?}: {v:?} at {x:?}");
        }
        let row = Simulation::new(case, 1).unwrap().step().unwrap();
        assert!((row["in"] + 0.7).abs() < 1e-12, "{}", row["in"]);
    }
}

type Complex = [f64; 2];

fn times(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn over(a: Complex, b: Complex) -> Complex {
    let size = b[0] * b[0] + b[1] * b[1];
    times(a, [b[0] / size, -b[1] / size])
}

fn cosh([a, b]: Complex) -> Complex {
    [a.cosh() * b.cos(), a.sinh() * b.sin()]
}

fn sinh([a, b]: Complex) -> Complex {
    [a.sinh() * b.cos(), a.cosh() * b.sin()]
}

/// (1 − cosh(λ (y − ½))/cosh(λ/2))/(1 − (2/λ) tanh(λ/2)), λ = √(iω/ν).
fn womersley(y: f64, omega: f64, nu: f64) -> Complex {
    let half = 0.5 * (0.5 * omega / nu).sqrt();
    let (middle, at) = ([half, half], [half * (2.0 * y - 1.0); 2]);
    let part = over(cosh(at), cosh(middle));
    let mean = over(over(sinh(middle), cosh(middle)), middle);
    over([1.0 - part[0], -part[1]], [1.0 - mean[0], -mean[1]])
}

const FLOW: &str = "profile = \"womersley\"\nfourier = [[-0.5, 0], [-0.3, 0.2], [0, 0.1]]\nperiod = 0.8";

/// The velocity of that flow at y and t; ν = 0.1.
fn exact(y: f64, t: f64) -> f64 {
    let mut v = 3.0 * y * (1.0 - y);
    for (n, [a, b]) in [(1.0, [-0.3, 0.2]), (2.0, [0.0, 0.1])] {
        let omega = n * TAU / 0.8;
        let turned = times(times([a, -b], womersley(y, omega, 0.1)), [(omega * t).cos(), (omega * t).sin()]);
        v -= turned[0];
    }
    v
}

/// The profiles of Womersley with the order of the elements, at several times; the flow is the given one.
#[test]
fn womersley_s_profile_is_that_of_cosh() {
    for (velocity, pressure, k) in
        [("Q2", "P1dc", 2.0), ("Q3", "P2dc", 3.0), ("Q4", "Q3", 4.0), ("P2", "P1", 2.0)]
    {
        let pair = [format!("space.velocity={velocity}"), format!("space.pressure={pressure}")];
        // Root mean square over nodes and times.
        let error = |n: usize| {
            let (mut sum, mut count) = (0.0, 0.0);
            for t in [0.1, 0.37, 0.61] {
                let time =
                    [format!("time.start={t}"), "time.step=0.1".into(), format!("time.end={}", t + 0.1)];
                let more: Vec<&str> = pair.iter().chain(&time).map(String::as_str).collect();
                let mut case = channel([2, n], FLOW, &more);
                case.at_time = t;
                for ([_, y], v) in inlet(case) {
                    sum += (v[0] - exact(y, t)).powi(2);
                    count += 1.0;
                }
            }
            f64::sqrt(sum / count)
        };
        let [coarse, fine] = [16, 32].map(error);
        let order = (coarse / fine).log2();
        assert!(order > k + 0.75, "{velocity}: {coarse:e}, {fine:e}, order {order}");
        assert!(fine < 1e-4, "{velocity}: {fine:e}");
    }
}

/// A periodic flow that is developed where it comes in stays so: half way and at the end the profile is the same, to the
/// order of the scheme.
#[test]
fn a_developed_flow_stays_developed() {
    let error = |scheme: &str, steps: u32| {
        let scheme = format!("time.scheme={scheme}");
        let step = format!("time.step={}", 0.8 / f64::from(steps));
        // The start is forgotten with e^{−π² ν t}.
        let more = [&scheme, &step, "time.end=3.2", "fluid.kinematic-viscosity=0.5", "mesh.upper=[2, 1]"];
        let mut simulation = Simulation::new(channel([2, 6], FLOW, &more), 1).unwrap();
        while !simulation.finished() {
            let row = simulation.step().unwrap();
            assert!((row["in"] + row["out"]).abs() < 1e-8, "{} {}", row["in"], row["out"]);
        }
        let fields = simulation.fields();
        let at = |x: f64, y: f64| fields.at([x, y]).unwrap().velocity;
        let gap = |y: f64| {
            let [inlet, middle] = [0.0, 1.0].map(|x| at(x, y));
            (inlet[0] - middle[0]).abs().max(middle[1].abs())
        };
        (0..9).map(|i| gap(f64::from(i) / 8.0)).fold(0.0, f64::max)
    };
    for (scheme, order) in [("bdf2", 2.0), ("backward-euler", 1.0), ("fractional-step-theta", 2.0)] {
        let (coarse, fine) = (error(scheme, 64), error(scheme, 128));
        let found = (coarse / fine).log2();
        assert!(found > order - 0.3, "{scheme}: {coarse:e}, {fine:e}, order {found}");
        assert!(fine < if order == 1.0 { 2e-3 } else { 1e-4 }, "{scheme}: {fine:e}");
    }
}

/// Without frequencies the profile is the parabola.
#[test]
fn a_mean_is_a_parabola() {
    let time = ["time.step=0.1", "time.end=0.1"];
    let mean = "profile = \"womersley\"\nfourier = [[-0.7, 0]]\nperiod = 2";
    for ([_, y], v) in inlet(channel([2, 3], mean, &time)) {
        assert!((v[0] - 4.2 * y * (1.0 - y)).abs() < 1e-12, "{v:?} at {y}");
    }
}

/// A case with a profile is written as it was read.
#[test]
fn profiles_are_written() {
    let time = ["time.step=0.1", "time.end=0.1"];
    for left in [FLOW, "flow-rate = \"-t\"\nprofile = \"parabolic\"", "flow-rate = -1"] {
        let case = channel([2, 3], left, &time);
        let text = case.to_toml();
        let again = Case::from_toml(&text, "again.toml", &[]).unwrap();
        assert_eq!(again.to_toml(), text);
        assert_eq!(again.boundary, case.boundary);
        assert!(
            again.record.notes.iter().all(|note| !note.contains("no effect")),
            "{:?}",
            again.record.notes
        );
    }
}

#[test]
fn wrong_profiles_are_refused() {
    let text = |left: &str| {
        format!(
            "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [1,1]\ncells = [2,2]\n[fluid]\ndensity = 1\n\
             kinematic-viscosity = 1\n[boundary.top]\n{WALL}\n[boundary.bottom]\n{WALL}\n[boundary.right]\n\
             condition = \"do-nothing\"\n[time]\nstep = 0.1\nend = 0.1\n[boundary.left]\ncondition = \"flux\"\n{left}"
        )
    };
    for (left, key, told) in [
        ("profile = \"parabolic\"", "flow-rate", "missing"),
        ("profile = \"womersley\"\nperiod = 1", "fourier", "missing"),
        ("profile = \"womersley\"\nfourier = [[1, 0]]", "period", "missing"),
        ("profile = \"womersley\"\nfourier = [[1, 0]]\nperiod = 0", "period", "expected a number above 0"),
        ("profile = \"womersley\"\nfourier = [[1, 2]]\nperiod = 1", "fourier", "expected [a_0, 0]"),
        ("profile = \"womersley\"\nfourier = [1, 2]\nperiod = 1", "fourier", "expected an array of pairs"),
        ("profile = \"womersley\"\nfourier = []\nperiod = 1", "fourier", "expected an array of pairs"),
        ("profile = \"parabolic\"\nflow-rate = \"y\"", "flow-rate", "expected a function of t"),
        ("profile = \"plug\"\nflow-rate = 1", "profile", "`parabolic`"),
    ] {
        let message = wrong(&text(left), &[]);
        assert!(
            message.contains(&format!("boundary.left.{key}")) && message.contains(told),
            "{left}: {message}"
        );
    }
    let womersley = "profile = \"womersley\"\nfourier = [[-1, 0], [0, 1]]\nperiod = 1\n";
    let message = wrong(&text(womersley), &["time=none"]);
    assert!(message.contains("depends on t, but the case is stationary"), "{message}");
    let note = |left: &str| Case::from_toml(&text(left), "own.toml", &[]).unwrap().record.notes.join("\n");
    assert!(note(&format!("{womersley}flow-rate = 1")).contains("boundary.left.flow-rate has no effect"));
    assert!(note("flow-rate = -1\nperiod = 2").contains("boundary.left.period has no effect"));
    let refused = |more: &[&str]| {
        let case = Case::from_toml(&text(womersley), "own.toml", &sets(more)).unwrap();
        Simulation::new(case, 1).err().map_or(String::new(), |e| e.to_string())
    };
    assert_eq!(refused(&[]), "");
    let thin = "law = \"carreau-yasuda\"\nviscosity-zero = 1\nviscosity-infinity = 0.1\ntime-constant = 1\npower-index = 0.5";
    let thin = text(womersley).replace("kinematic-viscosity = 1", thin);
    let case = Case::from_toml(&thin, "own.toml", &[]).unwrap();
    let message = Simulation::new(case, 1).err().map_or(String::new(), |e| e.to_string());
    assert!(message.contains("boundary.left.profile") && message.contains("constant viscosity"), "{message}");
}

/// Elastic walls that begin at an inlet with a profile: they are held there, and the flow is the given one at all times.
#[test]
fn elastic_walls_begin_at_a_profile() {
    for more in [&[][..], &["newton.linearization=newton", "time.scheme=bdf2"], &["motion.model=biharmonic"]]
    {
        let text = "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [2,1.5]\ncells = [4,6]\n\
                    region = { solid = \"abs(y - 0.75) - 0.5\" }\n[fluid]\ndensity = 1\nkinematic-viscosity = 0.1\n\
                    [solid]\ndensity = 2\nmu = 8\nlambda = 16\n[boundary.left]\ncondition = \"do-nothing\"\n\
                    [boundary.right]\ncondition = \"flux\"\nprofile = \"womersley\"\nperiod = 0.8\n\
                    fourier = [[-0.5, 0], [0.5, 0]]\n[boundary.top]\ncondition = \"traction-free\"\n\
                    [boundary.bottom]\ncondition = \"traction-free\"\n[time]\nstep = 0.05\nend = 0.4\n\
                    [functional.in]\nkind = \"flux\"\non = [\"right\"]\n[newton]\ntolerance = 1e-10\n";
        let case = Case::from_toml(text, "walls.toml", &sets(more)).unwrap();
        let mut simulation = Simulation::new(case, 1).unwrap();
        while !simulation.finished() {
            let row = simulation.step().unwrap();
            let flow = -0.5 + 0.5 * (TAU * row.time / 0.8).cos();
            assert!((row["in"] - flow).abs() < 1e-10, "{more:?}: {} for {flow}", row["in"]);
        }
        let fields = simulation.fields();
        let u = |x: [f64; 2]| fields.at(x).unwrap().displacement;
        assert!(u([2.0, 0.1]) == [0.0; 2] && u([2.0, 0.8]) == [0.0; 2]);
        assert!(u([1.0, 1.25])[1] > 1e-4, "{more:?}: {:?}", u([1.0, 1.25]));
    }
}
