//! Walls of the fluid that move, in problems that people bring: an oscillating cylinder, a peristaltic pump.

use crate::common::builtin;
use std::f64::consts::{PI, TAU};
use std::ops::{Add, Mul, Sub};
use undula::simulation::Simulation;

/// A complex number.
#[derive(Clone, Copy, Debug)]
struct C(f64, f64);

impl Add for C {
    type Output = C;
    fn add(self, other: C) -> C {
        C(self.0 + other.0, self.1 + other.1)
    }
}

impl Sub for C {
    type Output = C;
    fn sub(self, other: C) -> C {
        C(self.0 - other.0, self.1 - other.1)
    }
}

impl Mul for C {
    type Output = C;
    fn mul(self, other: C) -> C {
        C(self.0 * other.0 - self.1 * other.1, self.0 * other.1 + self.1 * other.0)
    }
}

impl C {
    fn real(x: f64) -> C {
        C(x, 0.0)
    }

    fn size(self) -> f64 {
        self.0.hypot(self.1)
    }

    fn inverse(self) -> C {
        let square = self.0 * self.0 + self.1 * self.1;
        C(self.0 / square, -self.1 / square)
    }

    fn ln(self) -> C {
        C(self.size().ln(), self.1.atan2(self.0))
    }
}

/// I₀, I₁, K₀, K₁ at z by their power series.
fn bessel(z: C) -> [C; 4] {
    let (half, quarter) = (z * C::real(0.5), z * z * C::real(0.25));
    let euler = 0.577_215_664_901_532_9;
    let mut term = C::real(1.0);
    let [mut i0, mut i1, mut k0, mut k1] = [C::real(0.0); 4];
    let mut harmonic = 0.0;
    for k in 0..80 {
        let n = f64::from(k);
        if k > 0 {
            term = term * quarter * C::real(1.0 / (n * n));
            harmonic += 1.0 / n;
        }
        i0 = i0 + term;
        i1 = i1 + term * C::real(1.0 / (n + 1.0));
        k0 = k0 + term * C::real(harmonic);
        // ψ(k + 1) + ψ(k + 2).
        let psi = 2.0 * (harmonic - euler) + 1.0 / (n + 1.0);
        k1 = k1 + term * C::real(psi / (n + 1.0));
    }
    i1 = i1 * half;
    let log = half.ln();
    let k0 = k0 - (log + C::real(euler)) * i0;
    let k1 = z.inverse() + log * i1 - half * C::real(0.5) * k1;
    [i0, i1, k0, k1]
}

/// C_a − i C_d of small oscillations of a cylinder of radius `r` in a concentric one at rest of radius `outer`: with the
/// speed U e^{iωt} the force per length is −ρ π r² iω U e^{iωt} (C_a − i C_d).
///
/// The linearised flow has the stream function f(r) sin φ, f = A r + B/r + C I₁(λ r) + D K₁(λ r), λ² = iω/ν, with
/// f = r, f' = 1 at the inner and f = f' = 0 at the outer cylinder. The pressure is that of its harmonic part,
/// −ρ iω (A r − B/r) cos φ, the friction ρ iω (f − A r − B/r) at the wall; C_a − i C_d = 2 B/r² − 1.
fn closed_form(r: f64, outer: f64, viscosity: f64, omega: f64) -> C {
    let size = (omega / viscosity).sqrt();
    let lambda = C(size * 0.5f64.sqrt(), size * 0.5f64.sqrt());
    let rows = |r: f64| {
        let [i0, i1, k0, k1] = bessel(lambda * C::real(r));
        let over = C::real(1.0 / r);
        let value = [C::real(r), over, i1, k1];
        let slope = [
            C::real(1.0),
            C::real(-1.0 / (r * r)),
            lambda * i0 - i1 * over,
            C::real(0.0) - lambda * k0 - k1 * over,
        ];
        [value, slope]
    };
    let [[a, b], [c, d]] = [rows(r), rows(outer)];
    let mut matrix = [a, b, c, d];
    let mut right = [C::real(r), C::real(1.0), C::real(0.0), C::real(0.0)];
    // Gauss elimination.
    for i in 0..4 {
        let pivot = (i..4).max_by(|&a, &b| matrix[a][i].size().total_cmp(&matrix[b][i].size())).unwrap();
        matrix.swap(i, pivot);
        right.swap(i, pivot);
        let inverse = matrix[i][i].inverse();
        for j in (0..4).filter(|&j| j != i) {
            let factor = matrix[j][i] * inverse;
            for column in 0..4 {
                matrix[j][column] = matrix[j][column] - factor * matrix[i][column];
            }
            right[j] = right[j] - factor * right[i];
        }
    }
    right[1] * matrix[1][1].inverse() * C::real(2.0 / (r * r)) - C::real(1.0)
}

/// Coefficients of added mass and damping of the case `cylinder`, from the last period.
fn coefficients(more: &[&str]) -> [f64; 2] {
    let case = builtin("cylinder", more);
    let theta = case.theta().unwrap();
    let mut simulation = Simulation::new(case, 1).unwrap();
    let mut before = 0.0;
    let mut list = vec![];
    while !simulation.finished() {
        let row = simulation.step().unwrap();
        list.push((before + theta * (row.time - before), row["force"]));
        before = row.time;
    }
    // The discrete Fourier transform is exact: the steps divide the period.
    let steps = list.iter().filter(|row| row.0 > before - 1.0).count();
    let last = &list[list.len() - steps..];
    let part = |f: fn(f64) -> f64| {
        2.0 / steps as f64 * last.iter().map(|(t, force)| force * f(TAU * t)).sum::<f64>()
    };
    // u = a sin(ω t), so that F = π ρ r² a ω² (C_a sin(ω t) − C_d cos(ω t)).
    let scale = PI * 0.01 * TAU * TAU;
    [part(f64::sin) / scale, -part(f64::cos) / scale]
}

/// Stokes 1851; Chen, Wambsganss and Jendrzejczyk 1976.
#[test]
fn an_oscillating_cylinder_has_the_added_mass_and_damping_of_the_closed_form() {
    let exact = closed_form(1.0, 2.0, 0.5, TAU);
    // By another program.
    assert!((exact - C(2.546_187_603_804, -3.523_230_323_772)).size() < 1e-10, "{exact:?}");
    let published = undula::results::reference::References::builtin("cylinder").unwrap();
    let amplitude = published.results["force"][0].numbers.amplitude.unwrap();
    assert!((PI * 0.01 * TAU * TAU * exact.size() - amplitude).abs() < 1e-5, "{amplitude}");
    let [mass, damping] = coefficients(&[]);
    let errors = [mass / exact.0 - 1.0, damping / -exact.1 - 1.0];
    println!("{mass:.6}, {damping:.6}: {errors:?}");
    assert!(errors[0].abs() < 1e-3 && errors[1].abs() < 3e-3, "{errors:?}");
}

/// Fourth order in h, as forces by the residual have with Q2, and second order in k. What a sudden start leaves depends
/// on the mesh.
#[test]
fn the_force_on_an_oscillating_cylinder_converges() {
    let order = |[a, b, c]: [[f64; 2]; 3]| [0, 1].map(|i| ((a[i] - b[i]) / (b[i] - c[i])).log2());
    let steps = ["0.04", "0.02", "0.01"].map(|step| format!("time.step={step}"));
    let in_time = order(steps.map(|step| coefficients(&["mesh.cells=[16,3]", &step])));
    let start = "boundary.inner.displacement=[\"0.01*ramp(t,1)*sin(2*pi*t)\",\"0\"]";
    let meshes = ["mesh.cells=[16,3]", "mesh.cells=[32,6]", "mesh.cells=[64,12]"];
    let in_space = order(meshes.map(|cells| coefficients(&[cells, start, "time.step=0.05", "time.end=2"])));
    println!("orders in time {in_time:.2?}, in space {in_space:.2?}");
    assert!(in_time.iter().all(|order| (order - 2.0).abs() < 0.2), "{in_time:?}");
    assert!(in_space.iter().all(|order| (order - 4.0).abs() < 0.35), "{in_space:?}");
}

/// Mean flow of a half of the pump over its second period of `steps` steps, with one wave of the length `wave` and the
/// rise in pressure of the half of what stops it, if asked for.
fn pumped(wave: u32, steps: u32, rise: bool) -> f64 {
    let half = f64::from(wave) / 2.0;
    // At Q = 0: Δp = 3 μ c λ/a² (3 φ²/2) (1 − φ²)^(−5/2).
    let phi: f64 = 0.5;
    let stop = 3.0 * 100.0 * f64::from(wave) * 1.5 * phi * phi * (1.0 - phi * phi).powf(-2.5);
    let pressure = if rise { 0.5 * stop } else { 0.0 };
    let case = builtin(
        "pump",
        &[
            &format!("mesh.upper=[{wave},1]"),
            "mesh.cells=[16,4]",
            &format!("boundary.top.displacement=[\"0\",\"0.5*ramp(t,{half})*sin(2*pi*(x-t)/{wave})\"]"),
            "boundary.right.condition=pressure",
            &format!("boundary.right.pressure={pressure}*ramp(t,{half})"),
            &format!("time.step={}", f64::from(wave) / f64::from(steps)),
            &format!("time.end={}", 2 * wave),
        ],
    );
    let mut simulation = Simulation::new(case, 1).unwrap();
    let mut flows = vec![];
    while !simulation.finished() {
        flows.push(simulation.step().unwrap()["flow"]);
    }
    assert_eq!(flows.len(), 2 * steps as usize);
    flows[steps as usize..].iter().sum::<f64>() / f64::from(steps)
}

/// Shapiro, Jaffrin and Weinberg 1969: Q = 3 φ² a c/(2 + φ²) for long waves, to (a/λ)². With the wave as the observer,
/// p' = −3 μ (q + c h)/h³ and h = a + b sin, so that q = −c a (1 − φ²)/(1 + φ²/2) without a rise, and Q = q + c a; Q
/// falls with the rise along a straight line.
#[test]
fn a_travelling_wave_pumps_as_lubrication_theory_says() {
    let converged = |wave: u32| (4.0 * pumped(wave, 40, false) - pumped(wave, 20, false)) / 3.0;
    let theory = 1.0 / 3.0;
    let [short, long] = [10, 20].map(|wave| converged(wave) / theory - 1.0);
    println!("deviations {short:.2e}, {long:.2e}");
    assert!(long.abs() < 5e-3, "{long}");
    let order = (short / long).log2();
    assert!((order - 2.0).abs() < 0.2, "{short} {long}: order {order}");
    let half = pumped(20, 40, true);
    println!("at half of the pressure that stops it: {half:.6}");
    assert!((half / theory - 0.5).abs() < 0.01, "{half}");
}
