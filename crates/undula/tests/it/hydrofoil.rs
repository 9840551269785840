//! The case `examples/hydrofoil.toml`: a stiff foil on springs at its axis.

use crate::common::sets;
use std::f64::consts::{PI, TAU};
use std::path::Path;
use undula::case::Case;
use undula::modes::of_case;
use undula::sampling::{facet_points, for_each_point};
use undula::simulation::Simulation;
use undula::space::{FsiSpace, Region, State};

const STIFFNESS: f64 = 3000.0;
/// Gauss points per direction of the case.
const POINTS: usize = 3;

fn foil(more: &[&str]) -> Case {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/hydrofoil.toml");
    let case = Case::load(path.to_str().unwrap(), &sets(more)).unwrap();
    assert_eq!(case.space.quadrature, POINTS);
    case
}

/// ∮ over the rim of the hole of f(x, u), u of a state.
fn around_hub(space: &FsiSpace<2>, u: &[f64], f: impl Fn([f64; 2], [f64; 2]) -> f64) -> f64 {
    let mut sum = 0.0;
    for facet in space.boundary_facets("hub") {
        let nodes = space.nodes.cell(facet.cell as usize);
        for point in facet_points(space, &facet, POINTS) {
            let at = |i: usize| -> f64 {
                nodes.iter().zip(&point.value).map(|(&a, phi)| phi * u[2 * a as usize + i]).sum()
            };
            sum += point.weight * f(point.x, [at(0), at(1)]);
        }
    }
    sum
}

/// The forces and the moment of the fluid are those of the springs; the springs of a rim that turns like a rigid one
/// have the moment k 2 π r³ sin θ.
#[test]
#[ignore = "long"]
fn a_foil_in_a_stream_is_in_equilibrium_with_its_springs() {
    let mut simulation = Simulation::new(foil(&["mesh.refine=0", "newton.tolerance=1e-11"]), 1).unwrap();
    let row = simulation.step().unwrap();
    let (space, u) = (&simulation.stepper.assembler.space, &simulation.stepper.new.u);
    let spring = |f: &dyn Fn([f64; 2], [f64; 2]) -> f64| STIFFNESS * around_hub(space, u, f);
    let turning = spring(&|x, u| x[0] * u[1] - x[1] * u[0]);
    for (name, held) in [("drag", spring(&|_, u| u[0])), ("lift", spring(&|_, u| u[1])), ("moment", turning)]
    {
        println!("{name}: {} of the fluid, {held} of the springs", row[name]);
        assert!((row[name] / held - 1.0).abs() < 1e-6, "{name}: {} {held}", row[name]);
    }
    // From nose to tail, before and after.
    let at = |name: &str| {
        let end = simulation.fields().at(if name == "nose" { NOSE } else { TAIL }).unwrap();
        end.displacement
    };
    let (nose, tail) = (at("nose"), at("tail"));
    let chord = [TAIL[0] - NOSE[0], TAIL[1] - NOSE[1]];
    let moved = [chord[0] + tail[0] - nose[0], chord[1] + tail[1] - nose[1]];
    let sine =
        (chord[0] * moved[1] - chord[1] * moved[0]) / (chord[0].hypot(chord[1]) * moved[0].hypot(moved[1]));
    let rigid = STIFFNESS * TAU * 0.03f64.powi(3) * sine;
    println!("turned by {:.4} degrees, springs of a rigid rim {rigid}", sine.asin().to_degrees());
    assert!((turning / rigid - 1.0).abs() < 0.01, "{turning} {rigid}");
    // Converged: see validation/examples.md.
    assert!((sine.asin().to_degrees() / CONVERGED - 1.0).abs() < 0.025);
}

const NOSE: [f64; 2] = [-0.3486681443, 0.03050451];
const TAIL: [f64; 2] = [0.6475265538, -0.0566512328];
/// How far the foil turns \[degrees\], nose up.
const CONVERGED: f64 = -2.747;

/// m, the first moments and the moment of inertia of the foil about the axis, per length.
fn inertia(space: &FsiSpace<2>) -> [f64; 4] {
    let rest = State::zero(space.n_v(), space.n_u(), space.n_p());
    let mut sums = [0.0; 4];
    for_each_point(space, &rest, POINTS, |point| {
        if point.region == Region::Solid {
            let [x, y] = point.x;
            for (sum, f) in sums.iter_mut().zip([1.0, x, y, x * x + y * y]) {
                *sum += 10.0 * point.weight * f;
            }
        }
    });
    sums
}

/// A rigid body on springs, det(K − ω² M) = 0 of surge, heave and pitch, and the same foil, much stiffer.
#[test]
fn the_modes_of_a_foil_in_vacuum_are_those_of_a_rigid_one() {
    let case = foil(&["mesh.refine=0", "solid.young=1e9"]);
    let (space, modes) = of_case(&case, 3, 1).unwrap();
    let [m, sx, sy, i] = inertia(&space);
    let zero = vec![0.0; space.n_v()];
    let rim = |f: &dyn Fn([f64; 2]) -> f64| STIFFNESS * around_hub(&space, &zero, |x, _| f(x));
    let (heave, pitch) = (rim(&|_| 1.0), rim(&|x| x[0] * x[0] + x[1] * x[1]));
    println!("springs {heave:.3} N/m², {pitch:.5} N; mass {m:.5} kg/m, inertia {i:.5} kg m");
    assert!((heave / (STIFFNESS * TAU * 0.03) - 1.0).abs() < 1e-3);
    let det = |frequency: f64| {
        let square = (TAU * frequency).powi(2);
        // (a, b, c; the last row and column of K − ω² M): u = (U − θ y, V + θ x).
        let (a, b, c, d) = (heave - square * m, square * sy, -square * sx, pitch - square * i);
        a * (a * d - b * b - c * c)
    };
    for mode in &modes.vacuum {
        let f = mode.frequency;
        println!("{f:.6} Hz");
        assert!(det(f * (1.0 - 1e-5)) * det(f * (1.0 + 1e-5)) < 0.0, "{f}");
    }
    // With the fluid all of them are lower, and converged to a part in a thousand: see validation/examples.md.
    let fluid = modes.with_fluid.unwrap();
    assert!(fluid.iter().zip(&modes.vacuum).all(|(wet, dry)| wet.frequency < dry.frequency));
    assert!((fluid[0].frequency / PITCH_IN_WATER - 1.0).abs() < 5e-3, "{}", fluid[0].frequency);
}

/// Of the stiff foil with the added mass of the fluid \[Hz\].
const PITCH_IN_WATER: f64 = 0.3776;

/// An oscillation in vacuum has the frequency of the mode, (2/k) tan(ω k/2) = ω₀ by the scheme.
#[test]
fn a_foil_in_vacuum_swings_with_the_frequency_of_its_mode() {
    let more = ["mesh.refine=0", "fluid=none"];
    let (_, modes) = of_case(&foil(&more), 1, 1).unwrap();
    let (k, omega) = (0.05, TAU * modes.vacuum[0].frequency);
    let swing =
        ["time.step=0.05", "time.end=5", "time.scheme=cg1", "initial.velocity=[\"-0.001*y\",\"0.001*x\"]"];
    let mut simulation = Simulation::new(foil(&[&more[..], &swing].concat()), 1).unwrap();
    let (mut zeros, mut before) = (vec![], 0.0);
    while !simulation.finished() {
        let row = simulation.step().unwrap();
        let now = row["uy_tail"];
        if before < 0.0 && now >= 0.0 {
            zeros.push(row.time - k * now / (now - before));
        }
        before = now;
    }
    let frequency = (zeros.len() - 1) as f64 / (zeros[zeros.len() - 1] - zeros[0]);
    let expected = 2.0 / k * (omega * k / 2.0).atan() / TAU;
    println!("{frequency:.6} Hz, {expected:.6} Hz by the mode and the step");
    assert!((frequency / expected - 1.0).abs() < 1e-4, "{frequency} {expected}");
}

/// Bars on springs: κ tan(κ L) = k/(λ + 2 μ) with ω = κ √((λ + 2 μ)/ρ); along them `normal` is the same as `all`.
#[test]
fn the_modes_of_a_bar_on_a_spring_are_those_of_the_closed_form() {
    let text = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [2, 0.5]
cells = [16, 1]
region = { solid = "1" }
[solid]
density = 3
mu = 3
lambda = 4
[boundary.left]
condition = "spring"
stiffness = 5
damping = 1
[boundary.right]
condition = "traction-free"
[boundary.top]
condition = "symmetry"
[boundary.bottom]
condition = "symmetry"
"#;
    for direction in ["all", "normal"] {
        let set = format!("boundary.left.direction={direction}");
        let case = Case::from_toml(text, "bar.toml", &sets(&[&set])).unwrap();
        let (_, modes) = of_case(&case, 2, 1).unwrap();
        for (n, mode) in modes.vacuum.iter().enumerate() {
            let (mut low, mut high) = (n as f64 * PI / 2.0, (n as f64 + 0.5) * PI / 2.0);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                if middle * (2.0 * middle).tan() < 0.5 { low = middle } else { high = middle }
            }
            let exact = low * (10.0f64 / 3.0).sqrt() / TAU;
            assert!((mode.frequency / exact - 1.0).abs() < 1e-5, "{n}: {} {exact}", mode.frequency);
        }
        assert_eq!(undula::modes::unused_loads(&case), ["boundary.left.damping"]);
    }
}
