//! Small geometries and other units.

use super::{Place, close, last, place, undula};

/// Units of length, mass and time in m, kg and s.
type Units = [f64; 3];

const SI: Units = [1.0, 1.0, 1.0];
const UNITS: [(&str, Units); 5] = [
    ("si", SI),
    ("mm-g-s", [1e-3, 1e-3, 1.0]),
    ("mm-t-s", [1e-3, 1e3, 1.0]),
    ("cm-g-s", [1e-2, 1e-3, 1.0]),
    ("um-ug-ms", [1e-6, 1e-9, 1e-3]),
];

/// A problem is as many times as large, with the same Reynolds number, speeds and moduli.
const SIZES: [f64; 3] = [1e-3, 1.0, 1e3];

/// A flap on the floor of a channel, 2 m x 0.4 m times `size`, given in `units`.
fn channel(size: f64, [l, m, t]: Units, time: &str) -> String {
    let x = |x: f64| format!("{:?}", x * size / l);
    let (speed, pressure) = (t / l, l * t * t / m);
    let [density, viscosity, young] = [1000.0 * l.powi(3) / m, 1e-3 * size * t / (l * l), 3e4 * pressure];
    let (height, peak, second) = (0.4 * size / l, 0.3 * speed, size / t);
    format!(
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [{}, {}]\ncells = [40, 8]\n\
         [mesh.region]\nsolid = \"min(min(x-{}, {}-x), {}-y)\"\n\
         [fluid]\ndensity = {density:?}\nkinematic-viscosity = {viscosity:?}\n\
         [solid]\ndensity = {density:?}\nyoung = {young:?}\npoisson = 0.4\n\
         [boundary.left]\ncondition = \"velocity\"\n\
         velocity = [\"{peak:?}*4*y*({height:?}-y)/{height:?}^2*ramp(t,{:?})\", 0]\n\
         [boundary.right]\ncondition = \"do-nothing\"\n[boundary.top]\ncondition = \"no-slip\"\n\
         [boundary.bottom]\ncondition = \"no-slip\"\n{}\n\
         [functional.ux]\nkind = \"displacement\"\npoint = [{}, {}]\ncomponent = \"x\"\n\
         [functional.drag]\nkind = \"force\"\non = [\"interface\"]\ncomponent = \"x\"\n",
        x(2.0),
        x(0.4),
        x(0.5),
        x(0.55),
        x(0.2),
        0.1 * second,
        time.replace("END", &format!("{:?}", 0.2 * second)).replace("STEP", &format!("{:?}", 0.02 * second)),
        x(0.5),
        x(0.2),
    )
}

const MOVING: &str = "[time]\nstep = STEP\nend = END\n";
const AT_REST: &str = "[time]\nscheme = \"stationary\"\nend = END\n";

/// u_x of the tip over the size, drag over the size in N/m², and the smallest J.
fn run(place: &Place, name: &str, size: f64, units: Units, (time, sets): (&str, &[&str])) -> [f64; 3] {
    let [l, m, t] = units;
    place.write(&format!("{name}.toml"), &channel(size, units, time));
    let sets = [sets, &["output.fields-every=0"]].concat();
    undula(place, &format!("run {name}.toml -o {name} --force --threads 1 --quiet"), &sets).expect(0, &[]);
    let min_j = column(place, name, "min_J").pop().unwrap();
    [last(place, name, "ux") * l / size, last(place, name, "drag") * m / (t * t) / size, min_j]
}

/// Asserts that the problem with `sets` gives the same in all `units`, to the relative accuracy `within`.
#[track_caller]
fn agree(name: &str, how: (&str, &[&str]), units: &[(f64, Units)], within: f64) {
    let place = place(name, &[]);
    let right = run(&place, "right", 1.0, SI, how);
    assert!(right[0] > 1e-4, "nothing moves: {right:?}");
    for &(size, units) in units {
        let found = run(&place, "other", size, units, how);
        found.iter().zip(right).for_each(|(&found, right)| close(found, right, within));
    }
}

fn all() -> Vec<(f64, Units)> {
    let sizes = SIZES.iter().map(|&size| (size, SI));
    UNITS.iter().skip(1).map(|&(_, units)| (1.0, units)).chain(sizes).collect()
}

/// A column of `history.csv`.
fn column(place: &Place, run: &str, name: &str) -> Vec<f64> {
    let history = place.read(&format!("{run}/history.csv"));
    let mut rows = history.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let at = rows.next().unwrap().iter().position(|&word| word == name).unwrap();
    rows.map(|row| row[at].parse().unwrap()).collect()
}

#[test]
#[ignore = "long"]
fn defaults_give_the_same_in_all_units_and_sizes() {
    agree("units", (MOVING, &[]), &all(), 1e-6);
}

#[test]
#[ignore = "long"]
fn tight_tolerances_give_nine_digits_in_all_units_and_sizes() {
    let sets = ["newton.tolerance=1e-11", "linear.precision=double"];
    agree("digits", (MOVING, &sets), &all(), 1e-9);
}

#[test]
#[ignore = "long"]
fn every_method_gives_the_same_in_other_units() {
    let other = [(SIZES[0], UNITS[2].1)];
    let methods: [&[&str]; 10] = [
        &["newton.linearization=newton"],
        &["time.scheme=rannacher", "newton.jacobian=finite-difference"],
        &["newton.linearization=newton", "linear.krylov=gmres"],
        &["linear.krylov=gmres"],
        &["linear.solver=faer", "newton.jacobian=analytic"],
        &["space.velocity=P2", "motion.model=stiffened-harmonic"],
        &["space.velocity=Q1", "motion.exponent=1.5"],
        &["motion.model=biharmonic", "time.scheme=bdf2"],
        &["motion.model=jacobian-stiffened", "time.scheme=fractional-step-theta"],
        &["solid.law=incompressible-neo-hookean", "solid.poisson=none", "motion.walls=sliding"],
    ];
    for (i, sets) in methods.iter().enumerate() {
        agree(&format!("methods-{i}"), (MOVING, sets), &other, 1e-6);
    }
}

#[test]
#[ignore = "long"]
fn stationary_solutions_are_the_same_in_all_units_and_sizes() {
    agree("stationary", (AT_REST, &[]), &all(), 1e-6);
    let sets = ["newton.tolerance=1e-11", "linear.precision=double"];
    agree("stationary-digits", (AT_REST, &sets), &all(), 1e-9);
}

/// Of the condensed matrix in motion: delayed pivots and bytes of its factors.
#[test]
fn factors_cost_the_same_in_all_units_and_sizes() {
    let place = place("factors", &[]);
    let cost = |size: f64, units: Units| {
        place.write("channel.toml", &channel(size, units, MOVING));
        let said = undula(&place, "bench channel.toml --steps 1 --repeat 1 --threads 1 -o bench.json", &[]);
        said.expect(0, &["delayed pivots"]);
        let kernels = &place.json("bench.json")["kernels"];
        [&kernels["delayed"], &kernels["held"]].map(|number| number.as_f64().unwrap())
    };
    let [delayed, held] = cost(1.0, SI);
    for (size, units) in [(1.0, UNITS[2].1), (SIZES[0], UNITS[4].1)] {
        let [d, h] = cost(size, units);
        assert!(
            (d - delayed).abs() <= 0.05 * delayed.max(20.0),
            "{d} delayed pivots, not {delayed}: {units:?}"
        );
        close(h, held, 0.1);
    }
}

/// On long cells factors find their pivots where they look for them: the slope of p along a cell of length L and width h,
/// once eliminated, would make velocities stiff by (L/h)². Of 6601 unknowns 8000 pivots were refused then.
#[test]
fn long_cells_have_their_pivots() {
    let place = place("long", &[]);
    for depth in [5.0, 50.0] {
        let extrude = format!("mesh.extrude={{depth={depth},layers=1}}");
        let sets = ["mesh.refine=0", "linear.solver=multifrontal", extrude.as_str()];
        undula(&place, "bench cfd3 --steps 1 --repeat 1 --threads 1 -o bench.json", &sets).expect(0, &[]);
        let delayed = place.json("bench.json")["kernels"]["delayed"].as_f64().unwrap();
        assert!(delayed < 600.0, "{delayed} delayed pivots with {depth} m");
    }
}

/// Continuous pressures at walls, where v is given, are eliminated with a velocity beside them; as cells of their own they
/// made factors of five times the memory of the discontinuous ones in one layer.
#[test]
fn continuous_pressures_at_walls_are_no_cells() {
    let place = place("walls", &[]);
    let held = |pressure: &str| {
        let pressure = format!("space.pressure={pressure}");
        let sets =
            ["mesh.refine=0", "mesh.extrude={depth=0.2,layers=1}", "linear.solver=multifrontal", &pressure];
        undula(&place, "bench cfd3 --steps 1 --repeat 1 --threads 1 -o bench.json", &sets).expect(0, &[]);
        place.json("bench.json")["kernels"]["held"].as_f64().unwrap()
    };
    let (continuous, discontinuous) = (held("Q1"), held("P1dc"));
    assert!(continuous < 2.5 * discontinuous, "{continuous} B, {discontinuous} B");
}

/// A millimetre of water: d_0 was a hundredth of a metre.
#[test]
fn a_small_flap_moves_like_a_large_one() {
    let place = place("flaps", &["small-geometry/metre.toml", "small-geometry/millimetre.toml"]);
    let [large, small] = ["metre", "millimetre"].map(|name| {
        let arguments = format!("run {name}.toml -o {name} --threads 1 --quiet");
        undula(&place, &arguments, &["mesh.cells=[40, 8]", "output.fields-every=0"]).expect(0, &[]);
        let min_j = column(&place, name, "min_J").into_iter().fold(f64::INFINITY, f64::min);
        [last(&place, name, "ux"), last(&place, name, "drag"), min_j]
    });
    close(1e3 * small[0], large[0], 1e-6);
    close(1e3 * small[1], large[1], 1e-6);
    close(small[2], large[2], 1e-6);
}

#[test]
#[ignore = "long"]
fn the_flexible_cavity_reaches_forty_seconds() {
    let place = place("cavity", &["newcomer/cavity.toml", "newcomer/cavity.msh"]);
    let sets = ["time.end=40", "time.step=0.2", "output.fields-every=0"];
    undula(&place, "run cavity.toml -o cavity --threads 1 --quiet", &sets).expect(0, &[]);
    let min_j = column(&place, "cavity", "min_J").into_iter().fold(f64::INFINITY, f64::min);
    assert!(min_j > 0.1, "{min_j}");
}

#[test]
fn refinement_does_not_change_the_extension() {
    let place = place("offset", &[]);
    place.write("channel.toml", &channel(1.0, SI, MOVING));
    let key = |text: &str, key: &str| {
        let line = text.lines().find(|line| line.starts_with(&format!("{key} = ")));
        line.unwrap_or_else(|| panic!("{text}")).to_string()
    };
    for (model, name) in [("pseudo-elastic", "offset"), ("stiffened-harmonic", "scale")] {
        let told = |refine: u32| {
            let sets = [format!("mesh.refine={refine}"), format!("motion.model={model}")];
            let sets = [&*sets[0], &*sets[1]];
            key(&undula(&place, "check channel.toml --toml", &sets).expect(0, &[]).out, name)
        };
        assert_eq!([told(1), told(2)], [told(0), told(0)]);
    }
    undula(&place, "run channel.toml -o run --threads 1 --quiet", &["time.end=0.02"]).expect(0, &[]);
    assert_eq!(key(&place.read("run/case.toml"), "offset"), "offset = 0.01  # m");
    let fsi3 = undula(&place, "check fsi3 --toml", &[]).expect(0, &[]).out;
    assert_eq!(key(&fsi3, "offset"), "offset = 0.01  # m");
}

#[test]
fn places_have_digits_in_small_meshes() {
    let place = place("places", &["small-geometry/millimetre.toml"]);
    let sets = ["mesh.region.solid=min(min(x-0.000501, 0.00055-x), 0.0002-y)"];
    undula(&place, "check millimetre.toml", &sets).expect(2, &["(0.0005125, 1.25e-5)"]);
}

/// Water at rest in a tank with an elastic floor: nothing but rounding is left of the residual after some steps.
#[test]
fn a_tank_stays_at_rest_in_all_units() {
    let place = place("tank", &[]);
    for (name, [l, m, t]) in UNITS {
        let (pressure, density) = (l * t * t / m, 1000.0 * l.powi(3) / m);
        let text = format!(
            "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [{:?}, {:?}]\ncells = [8, 10]\n\
             [mesh.region]\nsolid = \"{:?}-y\"\n\
             [fluid]\ndensity = {density:?}\nkinematic-viscosity = {:?}\nbody-force = [0, {:?}]\n\
             [solid]\ndensity = {:?}\nyoung = {:?}\npoisson = 0.3\n\
             [boundary.left]\ncondition = \"no-slip\"\n[boundary.right]\ncondition = \"no-slip\"\n\
             [boundary.top]\ncondition = \"do-nothing\"\n[boundary.bottom]\ncondition = \"clamped\"\n\
             [time]\nscheme = \"backward-euler\"\nstep = {:?}\nend = {:?}\n\
             [functional.uy]\nkind = \"displacement\"\npoint = [{:?}, {:?}]\ncomponent = \"y\"\n",
            0.8 / l,
            1.0 / l,
            0.1 / l,
            1e-2 * t / (l * l),
            -9.81 * t * t / l,
            2.0 * density,
            1e6 * pressure,
            0.5 / t,
            20.0 / t,
            0.4 / l,
            0.1 / l,
        );
        place.write(&format!("{name}.toml"), &text);
        undula(&place, &format!("run {name}.toml -o {name} --threads 1 --quiet"), &[]).expect(0, &[]);
        close(last(&place, name, "uy") * l, last(&place, "si", "uy"), 1e-6);
        let iterations: f64 = column(&place, name, "newton_steps").iter().rev().take(10).sum();
        let jacobians: f64 = column(&place, name, "jacobians").iter().rev().take(10).sum();
        assert!(
            iterations <= 10.0 && jacobians <= 1.0,
            "{name}: {iterations} iterations, {jacobians} Jacobians"
        );
    }
}
