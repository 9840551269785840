//! States at which Jacobians are compared.

use super::At;
use crate::physics::StepRule;
use crate::simulation::Simulation;
use crate::space::{FsiSpace, State};
use crate::system::{Assembler, StepView};
use crate::tangent::Sizes;

/// A step between two states.
pub(super) struct Setting {
    pub(super) text: String,
    pub(super) rule: StepRule,
    pub(super) new: State,
    pub(super) old: State,
    /// Smallest distance of each node to another of a cell \[m\].
    spacing: Vec<f64>,
}

/// Deformation relative to the distance of nodes.
const DEFORMATION: f64 = 0.1;
/// J at all points, at least; smaller deformations are taken until then.
const SMALLEST_J: f64 = 0.3;

impl Setting {
    pub(super) fn new<const D: usize>(simulation: &mut Simulation<D>, at: At) -> Setting {
        let spacing = spacing(&simulation.stepper.assembler.space);
        match at {
            At::Present => {
                let text = format!("the state at t = {} s", simulation.stepper.time);
                let (rule, new, old, _) = simulation.stepper.last_step();
                Setting { text, rule, new: new.clone(), old: old.clone(), spacing }
            }
            At::Random { seed } => random(simulation, seed, spacing),
        }
    }

    pub(super) fn min_j<const D: usize>(&self, assembler: &mut Assembler<D>) -> f64 {
        let mut r = vec![0.0; assembler.n_unknowns()];
        assembler.residual(&StepView { rule: self.rule, new: &self.new, old: &self.old }, &mut r)
    }

    /// Perturbations of all unknowns, relative by `h`.
    pub(super) fn steps(&self, h: f64) -> Vec<f64> {
        let sizes = Sizes::of([&self.new.v, &self.new.u, &self.new.p]);
        let components = self.new.u.len() / self.spacing.len().max(1);
        let of_nodes = self.spacing.iter().flat_map(|&s| std::iter::repeat_n(h * s, components));
        let mut steps = vec![h * sizes.v; self.new.v.len()];
        steps.extend(of_nodes);
        steps.resize(steps.len() + self.new.p.len(), h * sizes.p);
        steps
    }
}

fn random<const D: usize>(simulation: &mut Simulation<D>, seed: u64, spacing: Vec<f64>) -> Setting {
    let time = simulation.case.time.as_ref();
    let k = time.map(|time| time.step.eval(&[0.0; 3], time.start));
    let stepper = &mut simulation.stepper;
    let rule = k.map_or(StepRule::STATIONARY, |k| stepper.settings.scheme.rule(k));
    let density = stepper.assembler.physics.fluid.map_or(1.0, |fluid| fluid.rho);
    let t = stepper.time + k.unwrap_or(0.0);
    let mut random = Random(seed.wrapping_mul(2).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let text = format!("a random state, seed {seed}");
    let mut new = state(&stepper.assembler, &spacing, density, &mut random);
    let mut old = state(&stepper.assembler, &spacing, density, &mut random);
    for (state, t) in [(&mut new, t), (&mut old, stepper.time)] {
        stepper.assembler.constraints.apply(&stepper.assembler.space, t, &mut state.v, &mut state.u);
    }
    let mut setting = Setting { text, rule, new, old, spacing };
    // Cells of high degree fold more easily.
    for _ in 0..20 {
        if setting.min_j(&mut stepper.assembler) >= SMALLEST_J {
            break;
        }
        [&mut setting.new.u, &mut setting.old.u].into_iter().flatten().for_each(|u| *u *= 0.5);
    }
    setting
}

fn state<const D: usize>(
    assembler: &Assembler<D>,
    spacing: &[f64],
    density: f64,
    random: &mut Random,
) -> State {
    let (space, s) = (&assembler.space, assembler.zero().s);
    let v = (0..space.n_v()).map(|_| 2.0 * random.next()).collect();
    let u = (0..space.n_u()).map(|i| 2.0 * DEFORMATION * spacing[i / D] * random.next()).collect();
    let p = (0..space.n_p()).map(|_| 2.0 * density * random.next()).collect();
    State { v, u, p, s }
}

/// Smallest distance of each node to another node of a cell.
fn spacing<const D: usize>(space: &FsiSpace<D>) -> Vec<f64> {
    let mut spacing = vec![f64::INFINITY; space.nodes.len()];
    for cell in 0..space.mesh.n_cells() {
        let nodes = space.nodes.cell(cell);
        for &a in nodes {
            for &b in nodes.iter().filter(|&&b| b != a) {
                let [p, q] = [a, b].map(|node| space.nodes.points[node as usize]);
                let distance = (0..D).fold(0.0, |length: f64, d| length.hypot(p[d] - q[d]));
                spacing[a as usize] = spacing[a as usize].min(distance);
            }
        }
    }
    spacing
}

/// Deterministic random numbers in (−½, ½) (xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }
}
