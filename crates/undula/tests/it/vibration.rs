//! What schemes do to a vibration: how much of it they damp, and by how much it lags behind.

use crate::common::sets;
use std::f64::consts::PI;
use std::ops::{Add, Div, Mul, Sub};
use undula::case::Case;
use undula::simulation::Simulation;
use undula::time::scheme::{FRACTIONAL, Scheme};
use undula::time::tableau::{MOST, Tableau};

/// A complex number.
#[derive(Copy, Clone, Debug)]
struct C(f64, f64);

impl Add for C {
    type Output = C;
    fn add(self, b: C) -> C {
        C(self.0 + b.0, self.1 + b.1)
    }
}

impl Sub for C {
    type Output = C;
    fn sub(self, b: C) -> C {
        C(self.0 - b.0, self.1 - b.1)
    }
}

impl Mul for C {
    type Output = C;
    fn mul(self, b: C) -> C {
        C(self.0 * b.0 - self.1 * b.1, self.0 * b.1 + self.1 * b.0)
    }
}

impl Div for C {
    type Output = C;
    fn div(self, b: C) -> C {
        let size = b.0 * b.0 + b.1 * b.1;
        self * C(b.0 / size, -b.1 / size)
    }
}

fn real(x: f64) -> C {
    C(x, 0.0)
}

/// A step of y′ = λ y, with z = λ k.
fn theta(y: C, z: C, theta: f64) -> C {
    y * (real(1.0) + real(1.0 - theta) * z) / (real(1.0) - real(theta) * z)
}

/// The same by stages, from k y′; returns y and k y′ at the end.
fn stages(method: &Tableau, y: C, rate: C, z: C) -> (C, C) {
    let (mut rates, mut end) = ([rate; MOST], y);
    for i in 1..method.c.len() {
        let h = method.a[i].iter().zip(&rates).fold(y, |h, (a, rate)| h + real(*a) * *rate);
        end = h / (real(1.0) - real(method.gamma) * z);
        rates[i] = z * end;
    }
    (end, rates[method.c.len() - 1])
}

/// y after `steps` steps of length `k` of y′ = iω y from 1.
fn exact_scheme(scheme: Scheme, omega: f64, k: f64, steps: usize) -> C {
    let (z, mut y, mut older, mut rate) = (C(0.0, omega * k), real(1.0), real(1.0), real(0.0));
    for step in 0..steps {
        let new = match scheme {
            Scheme::BackwardEuler => theta(y, z, 1.0),
            Scheme::CrankNicolson | Scheme::Galerkin => theta(y, z, 0.5),
            Scheme::ShiftedCrankNicolson { shift } => theta(y, z, 0.5 + shift * k),
            Scheme::FractionalStepTheta => {
                FRACTIONAL.iter().fold(y, |y, part| theta(y, real(part.length) * z, part.theta))
            }
            Scheme::Bdf2 if step > 0 => {
                (real(4.0 / 3.0) * y - real(1.0 / 3.0) * older) / (real(1.0) - real(2.0 / 3.0) * z)
            }
            Scheme::Bdf2 => theta(y, z, 0.5),
            Scheme::Esdirk3 | Scheme::Esdirk4 => {
                let (new, last) =
                    stages(scheme.tableau().unwrap(), y, if step == 0 { z * y } else { rate }, z);
                rate = last;
                new
            }
            Scheme::Theta { .. } | Scheme::Rannacher { .. } => unreachable!(),
        };
        (older, y) = (y, new);
    }
    y
}

/// A bar of length 1 between planes of symmetry in its first axial vibration, period 1 s.
fn bar(scheme: &str, k: f64) -> Case {
    let sides = ["left", "right", "top", "bottom"];
    let sides = sides.map(|side| format!("[boundary.{side}]\ncondition = \"symmetry\"\n")).concat();
    let text = format!(
        "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [1, 0.25]\ncells = [4, 1]\nregion = {{ solid = \"1\" }}\n\
         [space]\nvelocity = \"Q4\"\n[solid]\ndensity = 1\nlaw = \"linear\"\nmu = 1\nlambda = 2\n{sides}\
         [initial]\ndisplacement = [\"0.1*sin(pi*x)\", 0]\n[time]\nend = 10\nstep = {k}\nshift = 0.1\n[newton]\ntolerance = 1e-11\n"
    );
    Case::from_toml(&text, "bar.toml", &sets(&[&format!("time.scheme={scheme}")])).unwrap()
}

/// u − i v/ω in the middle, by its first value, after some steps.
fn computed(scheme: &str, k: f64, steps: usize) -> C {
    let mut simulation = Simulation::new(bar(scheme, k), 1).unwrap();
    for _ in 0..steps {
        simulation.step().unwrap();
    }
    let at = simulation.fields().at([0.5, 0.125]).unwrap();
    C(at.displacement[0] / 0.1, -at.velocity[0] / (0.2 * PI))
}

/// Damping (%) and lag (degrees) per period.
fn losses(end: C, periods: f64) -> [f64; 2] {
    let size = end.0.hypot(end.1).powf(1.0 / periods);
    [100.0 * (1.0 - size), -end.1.atan2(end.0).to_degrees() / periods]
}

#[test]
fn vibrations_are_damped_and_delayed_as_the_scheme_does_one_equation() {
    for scheme in [
        Scheme::BackwardEuler,
        Scheme::CrankNicolson,
        Scheme::ShiftedCrankNicolson { shift: 0.1 },
        Scheme::FractionalStepTheta,
        Scheme::Galerkin,
        Scheme::Bdf2,
        Scheme::Esdirk3,
        Scheme::Esdirk4,
    ] {
        let mut line = String::new();
        for (k, steps) in [(0.1, 20), (0.05, 40), (0.025, 40)] {
            let expected = exact_scheme(scheme, 2.0 * PI, k, steps);
            let [damping, lag] = losses(expected, k * steps as f64);
            line += &format!(", k = {k}: {damping:.4} % {lag:.4}°");
            if k == 0.05 {
                let found = computed(scheme.name(), k, steps);
                let gap = (found - expected).0.hypot((found - expected).1);
                // The sine is interpolated at the nodes.
                assert!(gap < 4e-5, "{scheme:?}: {found:?} for {expected:?}");
            }
        }
        println!("{}{line}", scheme.name());
    }
}
