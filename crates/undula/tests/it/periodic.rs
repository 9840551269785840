//! Boundaries that are one: the domain repeats.

use crate::common::{SCHEMES, sets, wrong};
use std::f64::consts::PI;
use undula::Fields;
use undula::case::{Case, MeshSource, OwnMesh};
use undula::modes::of_case;
use undula::output::{Checkpoint, Status};
use undula::run::{Flow, Observer, RunOptions, run as run_in, snapshot};
use undula::simulation::Row;
use undula::simulation::Simulation;
use undula::verification::jacobians;
use undula::verification::stability::constants;

/// A box without walls, ν = 0.05, that begins with the velocity `v`.
fn torus(cells: [usize; 2], v: [&str; 2], more: &[&str]) -> Case {
    let text = format!(
        r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [1, 1]
cells = {cells:?}
[fluid]
density = 1
kinematic-viscosity = 0.05
[boundary.left]
condition = "periodic"
with = "right"
[boundary.bottom]
condition = "periodic"
with = "top"
[initial]
velocity = {v:?}
[time]
scheme = "crank-nicolson"
step = 0.01
end = 0.03
[newton]
tolerance = 1e-12
[linear]
precision = "double"
"#
    );
    Case::from_toml(&text, "torus.toml", &sets(more)).unwrap()
}

/// Taylor and Green's vortices, k = 2π.
const VORTICES: [&str; 2] = ["-cos(2*pi*x)*sin(2*pi*y)", "sin(2*pi*x)*cos(2*pi*y)"];
const K: f64 = 2.0 * PI;
const NU: f64 = 0.05;

fn run(case: Case) -> Simulation {
    let mut simulation = Simulation::new(case, 1).unwrap();
    simulation.step().unwrap();
    while !simulation.finished() {
        simulation.step().unwrap();
    }
    simulation
}

/// L2 errors of v at the end and of p at `t_p`.
fn errors(simulation: &Simulation, t_p: f64) -> [f64; 2] {
    let decay = (-2.0 * NU * K * K * simulation.time()).exp();
    let level = (-4.0 * NU * K * K * t_p).exp();
    let fields: Fields<'_> = simulation.fields();
    let v = fields.integrate(|at| {
        let [x, y] = at.x.map(|x| K * x);
        let exact = [-x.cos() * y.sin() * decay, x.sin() * y.cos() * decay];
        (0..2).map(|i| (at.velocity[i] - exact[i]).powi(2)).sum()
    });
    let p = fields.integrate(|at| {
        let [x, y] = at.x.map(|x| 2.0 * K * x);
        (at.pressure + 0.25 * level * (x.cos() + y.cos())).powi(2)
    });
    [v.sqrt(), p.sqrt()]
}

/// v and p of the vortices converge with the orders of the elements.
#[test]
fn vortices_decay_with_the_orders_of_the_elements() {
    for (velocity, pressure, orders, cells) in [
        ("Q2", "P1dc", [3.0, 2.0], [8, 16]),
        ("Q2", "Q1", [3.0, 2.0], [8, 16]),
        ("Q3", "P2dc", [4.0, 3.0], [4, 8]),
        ("Q4", "Q3", [5.0, 4.0], [6, 12]),
        ("P2", "P1", [3.0, 2.0], [8, 16]),
        ("P3", "P2", [4.0, 3.0], [4, 8]),
        ("P2-bubble", "P1dc", [3.0, 2.0], [16, 32]),
    ] {
        let pair = [format!("space.velocity={velocity}"), format!("space.pressure={pressure}")];
        let more = [&pair[0], &pair[1], "time.step=0.0005", "time.end=0.001"];
        let of = |n: usize| errors(&run(torus([n; 2], VORTICES, &more)), 0.00075);
        let [coarse, fine] = cells.map(of);
        for i in 0..2 {
            let order = (coarse[i] / fine[i]).log2();
            assert!(order > orders[i] - 0.3, "{velocity} {pressure}: {coarse:?}, {fine:?}, order {order}");
        }
        assert!(fine[0] < 2e-3 && fine[1] < 1e-2, "{velocity} {pressure}: {fine:?}");
    }
}

/// The decay e^{−2νk²t} with the order of every scheme.
#[test]
fn vortices_decay_with_the_orders_of_the_schemes() {
    let exact = -(-2.0 * NU * K * K * 0.2f64).exp();
    for scheme in SCHEMES {
        let amplitude = |steps: u32| {
            let step = format!("time.step={}", 0.2 / f64::from(steps));
            let more = [scheme, &step, "time.end=0.2", "space.velocity=Q4", "space.pressure=P3dc"];
            run(torus([3, 3], VORTICES, &more)).fields().at([0.0, 0.25]).unwrap().velocity[0]
        };
        let [coarse, middle, fine] = [10, 20, 40].map(amplitude);
        let order = ((coarse - middle) / (middle - fine)).abs().log2();
        let expected = if scheme.contains("euler") { 1.0 } else { 2.0 };
        // With θ = ½ + k the error changes its sign near these steps. Those of higher order are near rounding.
        let crosses = scheme.contains("shifted");
        let higher = scheme.contains("esdirk") && ((middle - fine).abs() < 1e-8 || order > 2.7);
        assert!(
            crosses || higher || (order - expected).abs() < 0.25,
            "{scheme}: {coarse}, {middle}, {fine}, order {order}"
        );
        assert!(
            (fine - exact).abs() < if expected == 1.0 { 0.01 } else { 1e-3 },
            "{scheme}: {fine} for {exact}"
        );
    }
}

/// The case on triangles, all of one shape: the squares of the box of `cells` and `size` cut along one diagonal.
fn on_triangles(mut case: Case, [nx, ny]: [u32; 2], size: [f64; 2], solid: bool) -> Case {
    let at =
        |i: u32, j: u32| [size[0] * f64::from(i) / f64::from(nx), size[1] * f64::from(j) / f64::from(ny)];
    let nodes = (0..=ny).flat_map(|j| (0..=nx).map(move |i| at(i, j))).collect();
    let square = |i: u32, j: u32| {
        let n = |i: u32, j: u32| i + (nx + 1) * j;
        [[n(i, j), n(i + 1, j), n(i + 1, j + 1)], [n(i, j), n(i + 1, j + 1), n(i, j + 1)]]
    };
    let cells: Vec<[u32; 3]> = (0..ny).flat_map(|j| (0..nx).flat_map(move |i| square(i, j))).collect();
    let region = |x: [f64; 2]| if solid && (x[1] - 0.75).abs() > 0.5 { "solid" } else { "fluid" };
    let side = |x: [f64; 2]| match x {
        [0.0, _] => "left",
        [x, _] if x == size[0] => "right",
        [_, 0.0] => "bottom",
        _ => "top",
    };
    let mesh = undula::Mesh::from_cells(nodes, &cells, region, side).unwrap();
    case.mesh.region.clear();
    case.mesh.source = MeshSource::Own(OwnMesh(mesh.into()));
    case
}

/// A flow that goes through the seams does not know where they are.
#[test]
fn a_shifted_flow_has_the_same_values() {
    let flow = |s: f64, t: f64| {
        let (x, y) = (format!("2*pi*(x - {s})"), format!("2*pi*(y - {t})"));
        [
            format!("1 - cos({x})*sin({y}) + 0.3*sin({y})*cos(2*{y})"),
            format!("0.5 + sin({x})*cos({y}) - 0.2*cos({x})"),
        ]
    };
    let stabilised = ["space.velocity=Q1", "space.pressure=Q1", "mesh.refine=1"];
    let residual = ["stabilization.pressure=pspg", "stabilization.transport=supg"];
    let settings: [&[&str]; 9] = [
        &[],
        &["space.pressure=Q1", "newton.linearization=newton"],
        &["space.velocity=Q3", "space.pressure=P2dc", "newton.linearization=newton", "linear.solver=faer"],
        &["space.velocity=Q4", "space.pressure=Q3"],
        &["space.velocity=P2", "space.pressure=P1"],
        &["space.velocity=P2-bubble", "space.pressure=P1dc", "newton.linearization=newton"],
        &stabilised,
        &[stabilised[0], stabilised[1], residual[0], residual[1]],
        &["linear.krylov=gmres", "time.scheme=bdf2"],
    ];
    for more in settings {
        let [here, there] = [[0.0, 0.0], [0.5, 0.5]].map(|[s, t]| {
            let v = flow(s, t);
            let case = torus([4, 4], [&v[0], &v[1]], more);
            let triangles = more.first().is_some_and(|element| element.starts_with("space.velocity=P"));
            run(if triangles { on_triangles(case, [4, 4], [1.0, 1.0], false) } else { case })
        });
        let (one, two) = (here.fields(), there.fields());
        let mut worst = 0.0f64;
        for (i, x) in (0..64).map(|i| (i, [f64::from(i % 8), f64::from(i / 8)].map(|x| (x + 0.37) / 8.0))) {
            let a = one.at(x).unwrap();
            let b = two.at(x.map(|x| (x + 0.5).fract())).unwrap();
            let gap = (a.pressure - b.pressure).abs();
            worst = (0..2).fold(worst.max(gap), |worst, i| worst.max((a.velocity[i] - b.velocity[i]).abs()));
            assert!(i > 0 || a.pressure.abs() > 1e-3, "{}", a.pressure);
        }
        assert!(worst < 1e-10, "{more:?}: {worst:e}");
    }
}

/// A channel between walls of 2 m × 1 m that repeats along x, driven by a force of 0.8 N/m³; ν = 0.1.
fn channel(cells: [usize; 2], more: &[&str]) -> Case {
    let text = format!(
        r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [2, 1]
cells = {cells:?}
[fluid]
density = 1
kinematic-viscosity = 0.1
body-force = [0.8, 0]
[boundary.right]
condition = "periodic"
with = "left"
[boundary.top]
condition = "no-slip"
[boundary.bottom]
condition = "no-slip"
[functional.in]
kind = "flux"
on = ["left"]
[functional.out]
kind = "flux"
on = ["right"]
[functional.drag]
kind = "force"
component = "x"
on = ["top", "bottom"]
[functional.below]
kind = "force"
component = "x"
on = ["bottom"]
[functional.below_surface]
kind = "force"
component = "x"
on = ["bottom"]
method = "surface-integral"
[functional.end]
kind = "force"
component = "x"
on = ["left"]
[functional.p]
kind = "pressure"
point = [2, 0.5]
[newton]
tolerance = 1e-13
"#
    );
    Case::from_toml(&text, "channel.toml", &sets(more)).unwrap()
}

/// v = 4 y (1 − y), Q = 2/3, and the walls carry the whole force; also on one cell between the ends.
#[test]
fn a_force_drives_poiseuille_flow() {
    let pairs: [&[&str]; 6] = [
        &[],
        &["space.pressure=Q1"],
        &["space.velocity=Q3", "space.pressure=Q2"],
        &["space.velocity=Q4", "space.pressure=P3dc"],
        &["space.velocity=P2", "space.pressure=P1"],
        &["space.velocity=P2-bubble", "space.pressure=P1dc"],
    ];
    let ways: [&[&str]; 3] = [&[], &["newton.linearization=newton"], &["linear.solver=faer"]];
    for (pair, (cells, way)) in pairs
        .iter()
        .flat_map(|pair| [[1, 2], [2, 2], [4, 3]].into_iter().zip(ways).map(move |ways| (pair, ways)))
    {
        let more = [*pair, way].concat();
        let mut simulation = Simulation::new(channel(cells, &more), 1).unwrap();
        let row = simulation.step().unwrap();
        let (told, fields) = (format!("{cells:?} {more:?}"), simulation.fields());
        for (x, v) in fields.coordinates().iter().zip(fields.velocity()) {
            let gap = (v[0] - 4.0 * x[1] * (1.0 - x[1])).abs().max(v[1].abs());
            assert!(gap < 1e-10, "{told}: {v:?} at {x:?}");
        }
        assert!(
            fields.coordinates().iter().any(|x| x[0] == 0.0)
                && fields.coordinates().iter().any(|x| x[0] == 2.0)
        );
        let expected =
            [("in", -2.0 / 3.0), ("out", 2.0 / 3.0), ("drag", 1.6), ("below", 0.8), ("below_surface", 0.8)];
        for (name, value) in expected.into_iter().chain([("end", 0.0), ("p", 0.0)]) {
            assert!((row[name] - value).abs() < 1e-9, "{told}: {name} = {} for {value}", row[name]);
        }
    }
}

/// A channel with elastic walls over `periods` of 1 m, driven by a force that repeats.
fn compliant(periods: usize, more: &[&str]) -> Case {
    let text = format!(
        r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [{periods}, 1.5]
cells = [{}, 6]
region = {{ solid = "abs(y - 0.75) - 0.5" }}
[fluid]
density = 1
kinematic-viscosity = 0.1
body-force = ["2*t*(1 + sin(2*pi*x))", "t*cos(2*pi*(x - 0.1))"]
[solid]
density = 2
mu = 2
lambda = 4
[boundary.left]
condition = "periodic"
with = "right"
[boundary.top]
condition = "clamped"
[boundary.bottom]
condition = "clamped"
[motion]
offset = 0.1
[time]
scheme = "shifted-crank-nicolson"
step = 0.1
end = 0.4
[newton]
tolerance = 1e-12
[linear]
precision = "double"
"#,
        4 * periods
    );
    Case::from_toml(&text, "compliant.toml", &sets(more)).unwrap()
}

/// One period and two have the same solution: every motion of the mesh, linearisation, and some elements.
#[test]
fn one_period_is_as_two() {
    let settings: [&[&str]; 9] = [
        &["motion.model=pseudo-elastic"],
        &["motion.model=harmonic", "newton.linearization=newton"],
        &["motion.model=biharmonic"],
        &["motion.model=biharmonic", "space.velocity=P2", "space.pressure=P1"],
        &["motion.model=jacobian-stiffened", "newton.linearization=newton"],
        &["newton.linearization=fixed-point", "space.pressure=Q1", "time.scheme=bdf2"],
        &["space.velocity=Q3", "space.pressure=P2dc"],
        &["space.velocity=P2", "space.pressure=P1", "linear.solver=faer", "newton.linearization=newton"],
        &[
            "solid.law=incompressible-neo-hookean",
            "boundary.top.condition=traction-free",
            "space.pressure=Q1",
            "time.scheme=fractional-step-theta",
        ],
    ];
    for more in settings {
        let [one, two] = [1, 2].map(|periods| {
            let case = compliant(periods, more);
            let triangles = more.contains(&"space.velocity=P2");
            let size = [periods as f64, 1.5];
            run(if triangles { on_triangles(case, [4 * periods as u32, 6], size, true) } else { case })
        });
        let (short, long) = (one.fields(), two.fields());
        let (mut worst, mut size) = (0.0f64, 0.0f64);
        for i in 0..96 {
            let x = [f64::from(i % 8) / 4.0 + 0.03, (f64::from(i / 8) + 0.37) / 8.0];
            let (a, b) = (short.at([x[0].fract(), x[1]]).unwrap(), long.at(x).unwrap());
            size = size.max(b.displacement[0].abs());
            worst = worst.max((a.pressure - b.pressure).abs());
            for i in 0..2 {
                worst = worst.max((a.velocity[i] - b.velocity[i]).abs());
                worst = worst.max((a.displacement[i] - b.displacement[i]).abs());
            }
        }
        assert!(size > 3e-3, "{more:?}: {size}");
        assert!(worst < 1e-9, "{more:?}: {worst:e}");
    }
}

/// All Jacobians: whole and condensed, at random states.
#[test]
fn jacobians_hold_seams() {
    let pair = ["space.velocity=P2", "space.pressure=P1"];
    for case in [
        compliant(1, &["mesh.cells=[3,6]"]),
        compliant(1, &pair),
        torus([3, 3], VORTICES, &["space.pressure=Q1"]),
        channel([1, 2], &[]),
    ] {
        let mut simulation = Simulation::new(case, 1).unwrap();
        let report = jacobians::compare(&mut simulation, jacobians::At::Random { seed: 3 }).unwrap();
        assert!(report.agrees(), "{report}");
    }
}

/// The number of threads changes no bit.
#[test]
fn threads_change_no_bit_at_seams() {
    let state = |threads: usize| {
        let mut simulation =
            Simulation::new(compliant(2, &["mesh.refine=1", "time.end=0.2"]), threads).unwrap();
        while !simulation.finished() {
            simulation.step().unwrap();
        }
        simulation.stepper.new
    };
    assert!(state(1) == state(2));
}

/// A layer of the solid, sheared at its top: u_x = τ y/μ, without any other motion.
#[test]
fn a_layer_is_sheared() {
    let body = "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [1,1]\ncells = [2,2]\nregion = { solid = \"1\" }\n\
                [solid]\ndensity = 1\nmu = 3\nlambda = 4\nlaw = \"linear\"\n[boundary.left]\ncondition = \"periodic\"\n\
                with = \"right\"\n[boundary.top]\ncondition = \"traction\"\ntraction = [0.3, 0.6]\n\
                [boundary.bottom]\ncondition = \"clamped\"\n[newton]\ntolerance = 1e-13\n";
    let case = |more: &[&str]| Case::from_toml(body, "layer.toml", &sets(more));
    let simulation = run(case(&[]).unwrap());
    let fields = simulation.fields();
    for (x, u) in fields.coordinates().iter().zip(fields.displacement()) {
        let gap = (u[0] - 0.1 * x[1]).abs().max((u[1] - 0.06 * x[1]).abs());
        assert!(gap < 1e-11, "{u:?} at {x:?}");
    }
    // What repeats does not turn, but it moves.
    let message = Simulation::new(case(&["boundary.bottom.condition=symmetry"]).unwrap(), 1).err();
    let message = message.map(|e| e.to_string()).unwrap_or_default();
    assert!(message.contains("against moving along (1, 0)"), "{message}");
    let message = Simulation::new(case(&["boundary.bottom.condition=traction-free"]).unwrap(), 1).err();
    assert!(message.is_some_and(|e| e.to_string().contains("nothing holds the solid")));
}

/// What cannot be one is refused with the key, the place and what would be right.
#[test]
fn boundaries_that_are_not_one_are_refused() {
    let text = |more: &str| {
        format!(
            "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [1,1]\ncells = [2,2]\n[fluid]\ndensity = 1\n\
             kinematic-viscosity = 1\n[boundary.top]\ncondition = \"no-slip\"\n[boundary.bottom]\n\
             condition = \"no-slip\"\n[boundary.left]\ncondition = \"periodic\"\n{more}"
        )
    };
    let with = |other: &str| text(&format!("with = \"{other}\"\n"));
    let right = "[boundary.right]\ncondition = ";
    for (text, told) in [
        (text(""), "boundary.left.with"),
        (with("left"), "expected the name of another outer boundary"),
        (with("interface"), "expected the name of another outer boundary"),
        (with("top"), "`top` has condition = `no-slip`: expected `periodic` with `left`"),
        (with("right") + right + "\"do-nothing\"", "`right` has condition = `do-nothing`"),
        (
            with("right") + right + "\"periodic\"\nwith = \"x\"",
            "`right` is one with `x`: expected two boundaries",
        ),
        (text("with = 3"), "expected a string"),
    ] {
        let message = wrong(&text, &[]);
        assert!(message.contains("boundary.left.with") && message.contains(told), "{told}: {message}");
    }
    let refused = |text: &str, more: &[&str]| {
        let case = Case::from_toml(text, "box.toml", &sets(more)).unwrap();
        Simulation::new(case, 1).err().map_or(String::new(), |e| e.to_string())
    };
    let absent = refused(&(with("rigth") + right + "\"no-slip\""), &[]);
    assert!(
        absent.contains("boundary.left.with") && absent.contains("the mesh has no boundary `rigth`"),
        "{absent}"
    );
    // A box that two sides of different directions bound.
    let corner = with("top").replace("[boundary.top]\ncondition", "[boundary.right]\ncondition");
    let message = refused(&corner, &[]);
    assert!(
        message.contains("boundary.left.with") && message.contains("`top` is no translation of `left`"),
        "{message}"
    );
    // Fluid on one side, solid on the other.
    let solid = "[solid]\ndensity = 1\nmu = 1\nlambda = 1\n[time]\nstep = 0.1\nend = 0.1\n";
    let message = refused(&(with("right") + solid), &["mesh.region={ solid = \"x - 0.5\" }"]);
    assert!(message.contains("bound different bodies at (0, "), "{message}");
    // Nothing holds the flow, which is stationary.
    let slip = with("right").replace("no-slip", "slip");
    let message = refused(&slip, &[]);
    assert!(message.contains("nothing holds the fluid between its periodic boundaries"), "{message}");
    assert_eq!(refused(&slip, &["time.step=0.1", "time.end=0.1"]), "");
    // Data that do not repeat.
    let lid = ["boundary.top.condition=velocity", "boundary.top.velocity=[\"x\", 0]"];
    let message = refused(&with("right"), &lid);
    assert!(
        message.contains("boundary.top.velocity") && message.contains("expected data that repeat"),
        "{message}"
    );
    assert_eq!(refused(&with("right"), &[lid[0], "boundary.top.velocity=[\"sin(2*pi*x)^2\", 0]"]), "");
    let start = ["time.step=0.1", "time.end=0.1", "initial.velocity=[\"x*y*(1-y)\", 0]"];
    let message = refused(&with("right"), &start);
    assert!(
        message.contains("initial.velocity") && message.contains("expected data that repeat"),
        "{message}"
    );
}

/// Facets are matched by their nodes: a mesh whose sides have others is refused with the place.
#[test]
fn meshes_match_facet_by_facet() {
    let mesh = |moved: f64| {
        let nodes = (0..3).flat_map(|j| [0.0, 0.5, 1.0].map(|x| [x, f64::from(j) / 2.0]));
        let mut nodes: Vec<[f64; 2]> = nodes.collect();
        nodes[5][1] += moved;
        let cell = |i: u32, j: u32| [i + 3 * j, i + 1 + 3 * j, i + 4 + 3 * j, i + 3 + 3 * j];
        let cells: Vec<[u32; 4]> = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| cell(i, j)).to_vec();
        let side = |x: [f64; 2]| match x {
            [0.0, _] => "left",
            [1.0, _] => "right",
            _ => "walls",
        };
        undula::Mesh::from_cells(nodes, &cells, |_| "fluid", side).unwrap()
    };
    let start = |moved: f64| {
        let case = undula::CaseBuilder::new("box")
            .mesh(mesh(moved))
            .set("fluid.density", 1.0)
            .set("fluid.kinematic-viscosity", 1.0)
            .set("boundary.left.condition", "periodic")
            .set("boundary.left.with", "right")
            .set("boundary.walls.condition", "no-slip")
            .build()
            .unwrap();
        Simulation::new(case, 1).err().map_or(String::new(), |e| e.to_string())
    };
    assert_eq!(start(0.0), "");
    assert_eq!(start(1e-8), "");
    let message = start(1e-3);
    for part in [
        "boundary.left.with",
        "the facet at (0, 0.25) m has no partner at (1, 0.25) m on `right`",
        "same nodes",
    ] {
        assert!(message.contains(part), "{message}");
    }
}

/// Stops after some step.
struct Stop(u64);

impl Observer for Stop {
    fn after_step(&mut self, _: &Simulation, row: &Row) -> Flow {
        if row.step == self.0 { Flow::Stop } else { Flow::Continue }
    }
}

/// A run that was stopped goes on with the same bits; steps of adaptive size, a window of means.
#[test]
fn a_run_with_seams_is_resumed() {
    let result = |name: &str, parts: bool| {
        let directory = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("periodic-{name}"));
        let _ = std::fs::remove_dir_all(&directory);
        let more = ["time.adaptive.tolerance=1e-2", "output.window=[0.1, 0.4]", "output.fields-every=1"];
        let options = |resume: bool| RunOptions {
            directory: directory.clone(),
            threads: 1,
            force: true,
            resume,
            commit: None,
        };
        if parts {
            assert_eq!(
                run_in(compliant(1, &more), &options(false), &mut Stop(2)).unwrap().status,
                Status::Interrupted
            );
        }
        assert_eq!(
            run_in(compliant(1, &more), &options(parts), &mut Stop(0)).unwrap().status,
            Status::Completed
        );
        let latest = Checkpoint::load_latest(directory.join("checkpoints")).unwrap().unwrap();
        (std::fs::read(directory.join("mean.vtu")).unwrap(), latest.checkpoint.arrays)
    };
    let (whole, parts) = (result("whole", false), result("parts", true));
    assert!(whole.0 == parts.0, "means");
    assert!(whole.1 == parts.1, "last states");
}

/// Files have the points of both sides, each with its own place, and every cell where it is.
#[test]
fn files_have_both_sides() {
    let simulation = run(compliant(1, &[]));
    let space = &simulation.stepper.assembler.space;
    for deformed in [false, true] {
        let fields = snapshot(space, &simulation.stepper.new, deformed).linear();
        let mut area = 0.0;
        for cell in fields.cells.chunks_exact(4) {
            let [a, b, c, d] = [0, 1, 3, 2].map(|i| fields.points[cell[i] as usize]);
            let (p, q) = ([c[0] - a[0], c[1] - a[1]], [d[0] - b[0], d[1] - b[1]]);
            let own = 0.5 * (p[0] * q[1] - p[1] * q[0]);
            assert!(own > 0.3 / 96.0 && own < 3.0 / 96.0, "{own}");
            area += own;
        }
        // What leaves on one side comes in on the other.
        assert!((area - 1.5).abs() < 1e-12, "{area}");
        for field in &fields.point_data {
            assert_eq!(field.values.len(), fields.points.len() * field.components, "{}", field.name);
        }
    }
}

/// Modes of a layer between a clamped and a free side, f = (2n − 1)/4 √(c/ρ) with c = μ and λ + 2μ; and beside a fluid
/// those of one period are among those of two.
#[test]
fn modes_repeat() {
    let text = "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [0.25,1]\ncells = [1,8]\n\
                region = { solid = \"1\" }\n[solid]\ndensity = 1\nmu = 3\nlambda = 4\n[boundary.left]\n\
                condition = \"periodic\"\nwith = \"right\"\n[boundary.top]\ncondition = \"traction-free\"\n\
                [boundary.bottom]\ncondition = \"clamped\"\n";
    let layer = Case::from_toml(text, "layer.toml", &[]).unwrap();
    let found = of_case(&layer, 3, 1).unwrap().1.vacuum;
    let exact = [3.0f64.sqrt() / 4.0, 10.0f64.sqrt() / 4.0, 0.75 * 3.0f64.sqrt()];
    for (mode, exact) in found.iter().zip(exact) {
        assert!((mode.frequency / exact - 1.0).abs() < 1e-4, "{} for {exact}", mode.frequency);
    }
    let of = |periods: usize, count: usize| of_case(&compliant(periods, &[]), count, 1).unwrap().1;
    let (one, two) = (of(1, 3), of(2, 8));
    let lists = [(one.vacuum, two.vacuum), (one.with_fluid.unwrap(), two.with_fluid.unwrap())];
    for (short, long) in lists {
        for mode in &short {
            let gap =
                long.iter().map(|other| (other.frequency / mode.frequency - 1.0).abs()).fold(1.0, f64::min);
            assert!(gap < 1e-8, "{} Hz: {gap:e}", mode.frequency);
        }
    }
}

/// Inf-sup constants of the whole torus, of a channel, and beside elastic walls.
#[test]
fn inf_sup_constants_know_seams() {
    for case in [torus([4, 4], VORTICES, &[]), channel([4, 4], &[]), compliant(1, &[])] {
        let simulation = Simulation::new(case, 1).unwrap();
        let found = constants(&simulation, false).unwrap().unwrap();
        assert!(found.reference.closed && found.moved.closed);
        assert!(
            found.reference.constant > 0.3 && found.reference.constant < 1.0,
            "{}",
            found.reference.constant
        );
        assert!(found.moved.constant > 0.15 && found.moved.constant < 1.0, "{}", found.moved.constant);
    }
}

/// Walls that slide: the seam is no boundary, so that nodes of a straight wall slide at its end, too.
#[test]
fn walls_slide_beside_seams() {
    let text = |periods: usize| {
        format!(
            "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [{periods},1]\ncells = [{},4]\n\
             region = {{ solid = \"min(0.25 - y, 0.25 - abs(x - floor(x) - 0.5))\" }}\n[fluid]\ndensity = 1\n\
             kinematic-viscosity = 0.1\nbody-force = [\"4*t\", 0]\n[solid]\ndensity = 1\nmu = 2\nlambda = 3\n\
             [boundary.left]\ncondition = \"periodic\"\nwith = \"right\"\n[boundary.top]\ncondition = \"slip\"\n\
             [boundary.bottom]\ncondition = \"no-slip\"\n[motion]\nwalls = \"sliding\"\noffset = 0.1\n[time]\n\
             step = 0.1\nend = 0.3\n[newton]\ntolerance = 1e-12\n[linear]\nprecision = \"double\"\n",
            4 * periods
        )
    };
    let [one, two] = [1, 2].map(|n| run(Case::from_toml(&text(n), "slide.toml", &[]).unwrap()));
    let (short, long) = (one.fields(), two.fields());
    let mut moved = 0.0f64;
    for i in 0..40 {
        let x = [f64::from(i % 8) / 4.0 + 0.01, f64::from(i / 8) / 4.0];
        let (a, b) = (short.at([x[0].fract(), x[1]]).unwrap(), long.at(x).unwrap());
        let gap = (0..2).map(|i| (a.displacement[i] - b.displacement[i]).abs()).fold(0.0, f64::max);
        assert!(gap < 1e-9, "{gap:e} at {x:?}");
        moved = moved.max(short.at([0.0, 1.0]).unwrap().displacement[0].abs());
    }
    assert!(moved > 1e-5, "{moved}");
}

/// An elastic block in a flow without walls, in the middle or across all four corners.
fn block(corner: bool, more: &[&str]) -> Case {
    let s = if corner { 0.5 } else { 0.0 };
    let text = format!(
        r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [1, 1]
cells = [8, 8]
region = {{ solid = "0.25 - max(abs(x + {s} - floor(x + {s}) - 0.5), abs(y + {s} - floor(y + {s}) - 0.5))" }}
[fluid]
density = 1
kinematic-viscosity = 0.1
body-force = ["4*sin(2*pi*(y + {s})) + 1", "3*cos(2*pi*(x + {s} - 0.1))"]
[solid]
density = 2
mu = 2
lambda = 4
[boundary.left]
condition = "periodic"
with = "right"
[boundary.top]
condition = "periodic"
with = "bottom"
[motion]
offset = 0.1
[time]
step = 0.05
end = 0.2
[newton]
tolerance = 1e-12
[linear]
precision = "double"
"#
    );
    Case::from_toml(&text, "block.toml", &sets(more)).unwrap()
}

/// A body does not know where the seams are, be it cut by them or not.
#[test]
fn a_body_across_the_seams_is_one() {
    let settings: [&[&str]; 4] = [
        &["mesh.cells=[4,4]"],
        &["mesh.cells=[4,4]", "motion.model=biharmonic", "newton.linearization=newton", "time.scheme=bdf2"],
        &["mesh.cells=[4,4]", "motion.model=jacobian-stiffened", "space.velocity=Q3", "space.pressure=Q2"],
        &["space.velocity=Q1", "space.pressure=Q1", "motion.model=stiffened-harmonic"],
    ];
    for more in settings {
        let [middle, corner] = [false, true].map(|corner| run(block(corner, more)));
        let (one, two) = (middle.fields(), corner.fields());
        let (mut worst, mut size) = (0.0f64, [f64::MAX, 0.0f64]);
        for i in 0..64 {
            let x = [f64::from(i % 8), f64::from(i / 8)].map(|x| (x + 0.37) / 8.0);
            let (a, b) = (one.at(x).unwrap(), two.at(x.map(|x| (x + 0.5).fract())).unwrap());
            assert_eq!(a.is_solid, b.is_solid);
            size = [size[0].min(a.displacement[0]), size[1].max(a.displacement[0])];
            worst = worst.max((a.pressure - b.pressure).abs());
            for i in 0..2 {
                worst = worst.max((a.velocity[i] - b.velocity[i]).abs());
                worst = worst.max((a.displacement[i] - b.displacement[i]).abs());
            }
        }
        assert!(size[1] > 5e-3 && size[1] - size[0] > 1e-3, "{more:?}: {size:?}");
        assert!(worst < 1e-9, "{more:?}: {worst:e}");
    }
}

/// Walls that move, with a wave that repeats; a wave that does not is refused.
#[test]
fn moving_walls_repeat() {
    let case = |periods: usize, wave: f64| {
        let text = format!(
            "[mesh]\ngenerator = \"box\"\nlower = [0,0]\nupper = [{periods},1]\ncells = [{},3]\n[fluid]\ndensity = 1\n\
             kinematic-viscosity = 0.1\n[boundary.left]\ncondition = \"periodic\"\nwith = \"right\"\n\
             [boundary.bottom]\ncondition = \"no-slip\"\n[boundary.top]\ncondition = \"displacement\"\n\
             displacement = [0, \"0.1*sin(2*pi*({wave}*x - t)) - 0.1*sin(2*pi*{wave}*x)\"]\n[motion]\noffset = 0.1\n\
             [time]\nstep = 0.05\nend = 0.3\n[newton]\ntolerance = 1e-12\n[linear]\nprecision = \"double\"\n",
            4 * periods
        );
        Case::from_toml(&text, "wave.toml", &[]).unwrap()
    };
    let [one, two] = [1, 2].map(|periods| run(case(periods, 1.0)));
    let (short, long) = (one.fields(), two.fields());
    let mut size = 0.0f64;
    for i in 0..40 {
        let x = [f64::from(i % 8) / 4.0 + 0.01, (f64::from(i / 8) + 0.3) / 6.0];
        let (a, b) = (short.at([x[0].fract(), x[1]]).unwrap(), long.at(x).unwrap());
        let gap = |i: usize| {
            (a.velocity[i] - b.velocity[i]).abs().max((a.displacement[i] - b.displacement[i]).abs())
        };
        assert!(gap(0).max(gap(1)) < 1e-9, "{:e} at {x:?}", gap(0).max(gap(1)));
        size = size.max(a.velocity[0].abs());
    }
    assert!(size > 0.05, "{size}");
    let message = Simulation::new(case(1, 0.8), 1).err().map_or(String::new(), |e| e.to_string());
    assert!(
        message.contains("boundary.top.displacement") && message.contains("expected data that repeat"),
        "{message}"
    );
}

/// Ends that are not straight: Poiseuille's flow on triangles whose seam is bent.
#[test]
fn seams_may_be_bent() {
    let mut case =
        on_triangles(channel([4, 3], &["space.velocity=P2", "space.pressure=P1"]), [4, 3], [2.0, 1.0], false);
    let MeshSource::Own(OwnMesh(mesh)) = &case.mesh.source else { panic!() };
    let mut mesh = undula::Mesh::clone(mesh);
    mesh.nodes.iter_mut().for_each(|x| x[0] += 0.8 * x[1] * (1.0 - x[1]) + 0.2 * x[1]);
    case.mesh.source = MeshSource::Own(OwnMesh(mesh.into()));
    case.functional.retain(|(name, _)| name != "p");
    case.mesh.refine = 1;
    let mut simulation = Simulation::new(case, 1).unwrap();
    let row = simulation.step().unwrap();
    for (x, v) in simulation.fields().coordinates().iter().zip(simulation.fields().velocity()) {
        let gap = (v[0] - 4.0 * x[1] * (1.0 - x[1])).abs().max(v[1].abs());
        assert!(gap < 1e-10, "{v:?} at {x:?}");
    }
    assert!((row["out"] - 2.0 / 3.0).abs() < 1e-10 && (row["drag"] - 1.6).abs() < 1e-9);
}

/// A run starts from another one on another mesh, and in equilibrium.
#[test]
fn runs_start_from_others() {
    let directory = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("periodic-former");
    let _ = std::fs::remove_dir_all(&directory);
    let options =
        RunOptions { directory: directory.clone(), threads: 1, force: true, resume: false, commit: None };
    let pair = ["space.velocity=Q4", "space.pressure=Q3"];
    run_in(torus([6, 6], VORTICES, &pair), &options, &mut Stop(0)).unwrap();
    let from = format!("initial.from={}", directory.display());
    for pressure in ["space.pressure=Q1", "space.pressure=P1dc"] {
        let more = ["initial.velocity=none", &from, "time.end=0.05", pressure];
        let error = errors(&Simulation::new(torus([16, 16], VORTICES, &more), 1).unwrap(), 0.025);
        assert!(error[0] < 2e-3 && error[1] < 1.5e-2, "{pressure}: {error:?}");
    }
    let force = ["time.step=0.1", "time.end=0.2", "initial.static=true"];
    let steady = run(channel([2, 2], &force));
    let v = steady.fields().at([1.3, 0.5]).unwrap().velocity;
    assert!((v[0] - 1.0).abs() < 1e-9, "{v:?}");
}
