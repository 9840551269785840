//! Eigenfrequencies in vacuum and with the added mass of the fluid.

use crate::common::builtin;
use std::f64::consts::PI;
use undula::Error;
use undula::case::Case;
use undula::mesh::generate::rectangle;
use undula::modes::{Mode, Modes, Setting, of_case};
use undula::physics::{Material, Solid};
use undula::sampling::for_each_point;
use undula::space::{FsiSpace, PressureKind, Region, State};

/// A cantilever of length 1 and height 1/50.
const CANTILEVER: &str = r#"
[mesh]
generator = "box"
lower = [0, 0]
upper = [1, 0.02]
cells = [100, 2]
region = { solid = "1" }
[solid]
density = 1000
young = 1e6
poisson = 0.3
[boundary]
left.condition = "clamped"
right.condition = "traction-free"
bottom.condition = "traction-free"
top.condition = "traction-free"
"#;

fn cantilever(law: &str) -> (FsiSpace<2>, Modes) {
    let case = Case::from_toml(CANTILEVER, "cantilever.toml", &[format!("solid.law={law}")]).unwrap();
    of_case(&case, 4, 1).unwrap()
}

/// f_n = (β_n l)²/(2π l²) √(E' h²/(12 ρ)) in plane strain, E' = E/(1 − ν²). Shear and the inertia of rotation
/// (Timoshenko) take off a part of about ½ (β_n h)²/12 (1 + E'/(κ μ)), κ = 5/6: 0.03 %, 0.16 % and 0.46 % of the
/// first three. The clamped end, which does not contract, adds some of h/l.
#[test]
fn a_slender_cantilever_has_the_frequencies_of_a_beam() {
    let (h, young, poisson, density) = (0.02_f64, 1e6_f64, 0.3_f64, 1000.0_f64);
    let plane = young / (1.0 - poisson * poisson);
    let (space, modes) = cantilever("st-venant-kirchhoff");
    assert!(modes.with_fluid.is_none());
    for (mode, beta) in modes.vacuum.iter().zip([1.875104_f64, 4.694091, 7.854757]) {
        let beam = beta * beta / (2.0 * PI) * (plane * h * h / (12.0 * density)).sqrt();
        let shear =
            0.5 * (beta * h).powi(2) / 12.0 * (1.0 + plane / (5.0 / 6.0 * young / (2.0 * (1.0 + poisson))));
        let deviation = mode.frequency / beam - 1.0;
        println!(
            "{:.6} Hz, beam {beam:.6} Hz: {deviation:.2e}, shear explains {:.2e}",
            mode.frequency, -shear
        );
        assert!((deviation + shear).abs() < 2e-3, "{deviation} {shear}");
    }
    let gap = largest_gap(&products(&space, 1000.0, &modes.vacuum, |_| 0.0));
    println!("largest deviation from M-orthogonality {gap:.1e}");
    assert!(gap < 1e-9, "{gap}");
}

/// All laws have Hooke's law as their derivative at rest.
#[test]
fn frequencies_are_those_of_the_law_at_rest() {
    let linear = cantilever("linear").1;
    for law in ["st-venant-kirchhoff", "neo-hookean", "mooney-rivlin"] {
        for (mode, other) in cantilever(law).1.vacuum.iter().zip(&linear.vacuum) {
            assert!((mode.frequency / other.frequency - 1.0).abs() < 1e-9, "{law}");
        }
    }
}

/// φ_iᵀ M φ_j + `more` of both.
fn products(
    space: &FsiSpace<2>,
    density: f64,
    modes: &[Mode],
    more: impl Fn([&Mode; 2]) -> f64,
) -> Vec<Vec<f64>> {
    let product = |a: &Mode, b: &Mode| {
        let mut state = State::zero(space.n_v(), space.n_v(), space.n_p());
        (state.v, state.u) = (a.shape.clone(), b.shape.clone());
        let mut sum = more([a, b]);
        for_each_point(space, &state, 4, |point| {
            if point.region == Region::Solid {
                sum += density * point.weight * point.fields.v.dot(point.fields.u);
            }
        });
        sum
    };
    modes.iter().map(|a| modes.iter().map(|b| product(a, b)).collect()).collect()
}

/// φ_iᵀ K φ_j/(ω_i ω_j), which is φ_iᵀ (M + M_a) φ_j.
fn works(space: &FsiSpace<2>, modes: &[Mode]) -> Vec<Vec<f64>> {
    let work = |a: &Mode, b: &Mode| {
        let mut state = State::zero(space.n_v(), space.n_v(), space.n_p());
        (state.v, state.u) = (a.shape.clone(), b.shape.clone());
        let mut sum = 0.0;
        for_each_point(space, &state, 4, |point| {
            if point.region == Region::Solid {
                sum += point.weight * HOOKE.stress(&point.fields.grad_v).ddot(point.fields.grad_u);
            }
        });
        sum / (4.0 * PI * PI * a.frequency * b.frequency)
    };
    modes.iter().map(|a| modes.iter().map(|b| work(a, b)).collect()).collect()
}

/// The largest deviation from the unit matrix.
fn largest_gap(products: &[Vec<f64>]) -> f64 {
    let gap = |i: usize, j: usize| (products[i][j] - if i == j { 1.0 } else { 0.0 }).abs();
    let all = (0..products.len()).flat_map(|i| (0..products.len()).map(move |j| (i, j)));
    all.map(|(i, j)| gap(i, j)).fold(0.0, f64::max)
}

const YOUNG: f64 = 2.0;
const DENSITY: f64 = 3.0;
const FLUID: f64 = 1.5;
const HOOKE: Material = Material::Linear { mu: 0.5 * YOUNG, lambda: 0.0 };
/// Length of the solid, depth of the fluid, height of both.
const LENGTH: f64 = 1.0;
const DEPTH: f64 = 0.7;
const HEIGHT: f64 = 2.0;

/// Solid in x < LENGTH, fluid of DEPTH beside it, ν = 0, the solid held at x = 0 and everywhere across; 10 `cells`
/// per unit of length and 8 `cells` across. With `mirrored` a second solid closes the fluid in; else p = 0 at the end.
fn block(cells: usize, mirrored: bool) -> (FsiSpace<2>, Modes) {
    let end = LENGTH + DEPTH + if mirrored { LENGTH } else { 0.0 };
    let solid = |x: f64| !(LENGTH..=LENGTH + DEPTH).contains(&x);
    let counts = [(10.0 * end).round() as usize * cells, 8 * cells];
    let mut mesh = rectangle([0.0; 2], [end, HEIGHT], counts, 0).unwrap();
    mesh.regions.push("solid".into());
    let centres: Vec<f64> = (0..mesh.n_cells()).map(|cell| mesh.centre(cell)[0]).collect();
    mesh.cell_region = centres.iter().map(|&x| u16::from(solid(x))).collect();
    let regions = centres.iter().map(|&x| if solid(x) { Region::Solid } else { Region::Fluid }).collect();
    let space = FsiSpace::new(mesh, regions, 2, PressureKind::Pdc(1));
    let held = |x: &[f64; 2]| [x[0] == 0.0 || (mirrored && x[0] > end - 1e-12), true];
    let setting = Setting {
        space: &space,
        solids: vec![Solid::elastic(DENSITY, HOOKE)],
        fluid_density: Some(FLUID),
        held: space.nodes.points.iter().map(held).collect(),
        springs: vec![],
        open: space.mesh.boundaries.iter().map(|name| name == "right" && !mirrored).collect(),
        quadrature: 3,
    };
    let modes = setting.modes(4).unwrap();
    (space, modes)
}

/// The zero of `f`, which is positive at `low` and negative at `high`.
fn zero(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if f(middle) > 0.0 { low = middle } else { high = middle }
    }
    low
}

/// Frequencies of u_x = sin(k x) cos(w y), w = n π/H: ρ_s ω² = E k² + μ w², and at the interface
/// E k cos(k l) = ρ_f ω² t sin(k l), where the pressure is ρ_f ω² t times the displacement. Where the fluid is so heavy
/// that it asks for it, k is imaginary: ρ_s ω² = μ w² − E κ², E κ cosh(κ l) = ρ_f ω² t sinh(κ l).
fn exact(n: f64, t: f64, branch: f64) -> f64 {
    let wave = n * PI / HEIGHT;
    let square = |kk: f64| (YOUNG * kk + 0.5 * YOUNG * wave * wave) / DENSITY;
    let kk = if branch == 0.0 && YOUNG < FLUID * square(0.0) * t * LENGTH {
        let balance =
            |k: f64| FLUID * square(-k * k) * t * (k * LENGTH).sinh() - YOUNG * k * (k * LENGTH).cosh();
        -zero(balance, 1e-6, wave * 0.5_f64.sqrt()).powi(2)
    } else {
        let sign = (-1.0_f64).powf(branch);
        let balance =
            |k: f64| sign * (YOUNG * k * (k * LENGTH).cos() - FLUID * square(k * k) * t * (k * LENGTH).sin());
        zero(balance, (branch + 1e-9) * PI / LENGTH, (branch + 0.5) * PI / LENGTH).powi(2)
    };
    square(kk).sqrt() / (2.0 * PI)
}

/// All of these, ascending, for a fluid with the depths `t` of n = 0 and of each w.
fn spectrum(plane: f64, depths: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let mut all: Vec<f64> = [0.0, 1.0].map(|branch| exact(0.0, plane, branch)).to_vec();
    for n in (1..5).map(f64::from) {
        for t in depths(n * PI / HEIGHT) {
            all.extend([0.0, 1.0].map(|branch| exact(n, t, branch)));
        }
    }
    all.sort_by(f64::total_cmp);
    all
}

/// The modes with the added mass converge to those in closed form with order 4 = 2 · 2, plane and not plane.
#[test]
fn a_block_that_pushes_a_fluid_has_its_closed_frequencies() {
    // p = 0 at the end: t = d, and cot(z) = ρ_f d/(ρ_s l) z for z = k l, or t = tanh(w d)/w.
    let z = 2.0 * PI * exact(0.0, DEPTH, 0.0) * LENGTH / (YOUNG / DENSITY).sqrt();
    assert!((1.0 / z.tan() - FLUID * DEPTH / (DENSITY * LENGTH) * z).abs() < 1e-12);
    let expected = spectrum(DEPTH, |wave| vec![(wave * DEPTH).tanh() / wave]);
    let errors = [1, 2].map(|cells| {
        let (space, modes) = block(cells, false);
        let found = modes.with_fluid.unwrap();
        if cells == 1 {
            let at_interface = |mode: &Mode| -> f64 {
                let node =
                    space.nodes.points.iter().position(|x| x[1] == 0.0 && (x[0] - LENGTH).abs() < 1e-12);
                mode.shape[2 * node.unwrap()]
            };
            // A plane motion moves the mass ρ_f d H.
            let more = |[a, b]: [&Mode; 2]| FLUID * DEPTH * HEIGHT * at_interface(a) * at_interface(b);
            let gap = largest_gap(&products(&space, DENSITY, &found[..1], more));
            assert!(gap < 1e-6, "{gap}");
            let gap = largest_gap(&works(&space, &found));
            println!("largest deviation from orthogonality with the added mass {gap:.1e}");
            assert!(gap < 1e-6, "{gap}");
        }
        let error = |(mode, exact): (&Mode, &f64)| mode.frequency / exact - 1.0;
        found.iter().zip(&expected).map(error).collect::<Vec<f64>>()
    });
    println!("{expected:.6?}, errors {errors:?}");
    for (coarse, fine) in errors[0].iter().zip(&errors[1]) {
        let order = (coarse / fine).log2();
        assert!(*fine > 0.0 && *fine < 1e-4 && (order - 4.0).abs() < 0.2, "{coarse} {fine}: order {order}");
    }
}

/// A fluid between two blocks keeps its volume: in plane motion both are one piston with half of the fluid each,
/// t = d/2, and motions in which both go inwards are not among the modes. Else t = tanh(w d/2)/w or 1/(w tanh(w d/2)).
#[test]
fn a_fluid_without_outlet_keeps_its_volume() {
    let (space, modes) = block(1, true);
    let found = modes.with_fluid.unwrap();
    let expected = spectrum(0.5 * DEPTH, |wave| {
        let half = (0.5 * wave * DEPTH).tanh();
        vec![half / wave, 1.0 / (half * wave)]
    });
    for (mode, exact) in found.iter().zip(&expected) {
        println!("{:.8} Hz, exact {exact:.8} Hz", mode.frequency);
        assert!((mode.frequency / exact - 1.0).abs() < 3e-4, "{} {exact}", mode.frequency);
    }
    // In vacuum each block moves on its own: all frequencies are there twice.
    for pair in modes.vacuum.chunks_exact(2) {
        assert!((pair[0].frequency / pair[1].frequency - 1.0).abs() < 1e-9);
    }
    for mode in &found {
        let column = |x: f64| -> f64 {
            let on = |n: &usize| (space.nodes.points[*n][0] - x).abs() < 1e-12;
            let mut nodes: Vec<usize> = (0..space.nodes.len()).filter(on).collect();
            nodes.sort_by(|&a, &b| space.nodes.points[a][1].total_cmp(&space.nodes.points[b][1]));
            // Simpson's rule on each cell.
            let value = |n: usize| mode.shape[2 * nodes[n]];
            let cell = |n: usize| value(n) + 4.0 * value(n + 1) + value(n + 2);
            (0..nodes.len() - 2).step_by(2).map(cell).sum()
        };
        let (left, right) = (column(LENGTH), column(LENGTH + DEPTH));
        assert!((left - right).abs() < 1e-8 * (left.abs() + 1.0), "{left} {right}");
    }
}

/// The beam of fsi3: water lowers the first frequency by more than half, in proportion less the higher ones.
#[test]
fn water_lowers_the_frequencies_of_the_benchmark_beam() {
    let (_, modes) = of_case(&builtin("fsi3", &["mesh.refine=0"]), 3, 2).unwrap();
    let fluid = modes.with_fluid.unwrap();
    let ratios: Vec<f64> =
        modes.vacuum.iter().zip(&fluid).map(|(vacuum, fluid)| fluid.frequency / vacuum.frequency).collect();
    assert!(ratios.iter().all(|ratio| *ratio < 1.0) && ratios[0] < 0.5, "{ratios:?}");
}

/// What has no modes is refused as a mistake of the case, with the reason.
#[test]
fn cases_without_modes_are_refused() {
    for (name, sets, word) in [
        ("cfd1", &[][..], "there is no [solid]"),
        ("csm1", &["solid.law=incompressible-neo-hookean"], "not yet available"),
        ("rotor", &[], "nothing holds"),
        ("csm1", &["boundary.clamp.condition=spring"], "nothing holds"),
    ] {
        let Err(Error::Case(errors)) = of_case(&builtin(name, sets), 1, 1) else { panic!("{name}") };
        assert!(errors.to_string().contains(word), "{name}: {errors}");
    }
}
