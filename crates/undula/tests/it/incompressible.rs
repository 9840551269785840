//! Incompressible solids in the whole program: orders in space and time, closed forms, the condensed system.
#![allow(non_snake_case)]

use crate::manufactured::*;
use std::sync::Arc;
use undula::case::Case;
use undula::math::{Tensor, Vector};
use undula::mesh::Mesh;
use undula::physics::{Material, Solid};
use undula::sampling::facet_points;
use undula::simulation::Simulation;
use undula::space::PressureKind::{self, Continuous};
use undula::space::{BoundaryCondition, Region};
use undula::system::{End, Physics};
use undula::time::Scheme;
use undula::verification::manufactured::{Exact, InTime, Manufactured, Number, Values, cos, number, sin};
use undula::verification::unit_square::in_the_spaces;

fn rubber(lambda: f64) -> Solid {
    Solid::elastic(2.1, Material::incompressible(1.1, 0.4, lambda))
}

fn body(lambda: f64) -> Physics {
    Physics::new(None, Some(rubber(lambda)))
}

fn coupled(lambda: f64) -> Physics {
    Physics::new(Some(AUXETIC), Some(rubber(lambda)))
}

/// Not polynomial; the right-hand side of the constraint is J − 1 of these fields. Where `jump` is not 0 the
/// pressure is another one in the lower half.
fn smooth(jump: f64) -> Exact {
    Arc::new(move |[x, y]: [Number; 2], t| {
        let (w, a) = (bubble([x, y]), number(1.0) + sin(t) * 0.3);
        let p = sin(x * 3.0 + t) * cos(y * 2.0) + x;
        let of_solid = if y.re < 0.5 { cos(x * 2.0) * jump + p * 2.0 } else { p };
        Values {
            v: [sin(x * 2.0 + y * 1.5 + t), cos(x - y * 2.0 + t * 0.5)],
            u: [w * a * (number(0.035) + y * 0.025), w * a * (x * 0.045 - number(0.05))],
            p: if jump == 0.0 { p } else { of_solid },
        }
    })
}

/// What is solved and how.
struct InSpace {
    name: &'static str,
    physics: Physics,
    pressure: PressureKind,
    cells: Cells,
    jump: f64,
    /// 0 is stationary, else so many of θ = 0.51 without error in time.
    steps: usize,
    levels: [usize; 2],
}

impl InSpace {
    fn problem(&self, n: usize) -> Manufactured {
        let mesh = square(n, self.cells, Body::Half);
        problem(&mesh, self.physics, self.pressure, smooth(self.jump), InTime::Difference, 5)
    }

    fn errors(&self, n: usize) -> [f64; 3] {
        let problem = self.problem(n);
        let mut stepper = problem.stepper(Scheme::Theta { theta: 0.51 }, 0.0, false, &options());
        // Rounding of the finest level.
        stepper.newton.settings.floor = Some(1e-9);
        if self.steps == 0 {
            stepper.stationary().unwrap();
        }
        for _ in 0..self.steps {
            stepper.step(0.25).unwrap();
        }
        let e = problem.errors(&stepper.new, stepper.time, stepper.force_time(), 5);
        [e.v, e.u, e.p]
    }

    /// Orders of at least 2.8 in v and u and 1.85 in p, p_s included.
    fn check(self) {
        let errors = self.levels.map(|n| self.errors(n));
        let orders: [f64; 3] = std::array::from_fn(|i| (errors[0][i] / errors[1][i]).log2());
        println!("{}: {errors:?} orders {orders:.3?}", self.name);
        assert!(orders[0] > 2.8 && orders[1] > 2.8 && orders[2] > 1.85, "{} {orders:?}", self.name);
    }
}

const EXACTLY: f64 = f64::INFINITY;
const P1DC: PressureKind = PressureKind::Pdc(1);

#[test]
fn body_alone_has_full_order_in_space() {
    let physics = body(EXACTLY);
    let common = |name, pressure, steps| InSpace {
        name,
        physics,
        pressure,
        cells: Cells::Curved,
        jump: 0.0,
        steps,
        levels: [8, 16],
    };
    common("body, P1dc", P1DC, 0).check();
    common("body, Q1", Continuous(1), 0).check();
    common("body, P1DC, 2 steps", P1DC, 2).check();
}

/// The pressure of the solid is its own: p jumps at the interface, with continuous pressures, too.
#[test]
fn coupled_with_a_jump_of_pressure_has_full_order_in_space() {
    for (name, pressure) in [("coupled, P1dc", P1DC), ("coupled, Q1", Continuous(1))] {
        let physics = coupled(EXACTLY);
        let (cells, levels) = (Cells::Square, [8, 16]);
        InSpace { name, physics, pressure, cells, jump: 3.0, steps: 0, levels }.check();
    }
    let (name, physics, cells) = ("coupled, curved, 2 steps", coupled(EXACTLY), Cells::Curved);
    InSpace { name, physics, pressure: P1DC, cells, jump: 0.0, steps: 2, levels: [8, 16] }.check();
}

#[test]
fn nearly_incompressible_body_has_full_order_in_space() {
    let (name, physics, cells) = ("nearly incompressible", body(1e3), Cells::Curved);
    InSpace { name, physics, pressure: P1DC, cells, jump: 0.0, steps: 0, levels: [8, 16] }.check();
}

/// Largest errors of v, u and p at t⁻ + θ k from 0 to 1.2 s; p from the third step on, because exact values are
/// not those from which the scheme would have come.
fn in_time(problem: &Manufactured, scheme: Scheme, steps: usize) -> [f64; 3] {
    let mut stepper = problem.stepper(scheme, 0.0, false, &options());
    let mut worst = [0.0f64; 3];
    for step in 0..steps {
        stepper.step(1.2 / steps as f64).unwrap();
        let e = problem.errors(&stepper.new, stepper.time, stepper.force_time(), QUADRATURE);
        let p = if step < 2 { 0.0 } else { e.p };
        for (worst, e) in worst.iter_mut().zip([e.v, e.u, p]) {
            *worst = worst.max(e);
        }
    }
    worst
}

fn check_time(name: &str, physics: Physics, scheme: Scheme, order: f64, tolerance: f64) {
    let mesh = square(4, Cells::Square, Body::Half);
    let problem = problem(&mesh, physics, P1DC, in_the_spaces(), InTime::Derivative, QUADRATURE);
    let e = [64, 128].map(|steps| in_time(&problem, scheme, steps));
    let orders: [f64; 3] = std::array::from_fn(|i| (e[0][i] / e[1][i]).log2());
    println!("{name}: {e:?} orders {orders:.3?}");
    for found in orders {
        assert!((found - order).abs() < tolerance, "{name}: {orders:?}");
    }
}

/// J = 1 at the new time and one pressure per step on the weighted geometry keep second order, in v, u, p_f and
/// p_s at t⁻ + θ k.
#[test]
fn second_order_in_time() {
    let shifted = Scheme::ShiftedCrankNicolson { shift: 1.0 };
    check_time("Crank-Nicolson", coupled(EXACTLY), Scheme::CrankNicolson, 2.0, 0.15);
    check_time("shifted", coupled(EXACTLY), shifted, 2.0, 0.15);
    check_time("nearly, Crank-Nicolson", coupled(1e2), Scheme::CrankNicolson, 2.0, 0.15);
}

#[test]
fn backward_euler_is_first_order() {
    check_time("backward Euler", body(EXACTLY), Scheme::BackwardEuler, 1.0, 0.15);
}

/// A square block free on all sides, stretched by dead tractions P n in one step of backward Euler from rest
/// with k = 1 s; a body force takes the place of its inertia. F is the same everywhere, and so is p.
fn block(material: Material, cells: Cells, B: Tensor<f64, 2>, P: Tensor<f64, 2>, p: f64) {
    let mut mesh: Mesh<2> = undula::mesh::generate::rectangle([0.0; 2], [1.0; 2], [4, 4], 0).unwrap();
    mesh.assign_region("solid", |_| 1.0).unwrap();
    bend(&mut mesh, 4, cells);
    let physics = Physics::new(None, Some(Solid::elastic(1.7, material)));
    let space = space(&mesh, &physics, 2, P1DC);
    let conditions = vec![BoundaryCondition::Free; space.mesh.boundaries.len()];
    let nothing = number(0.0);
    let exact: Exact = Arc::new(move |_, _| Values { v: [nothing; 2], u: [nothing; 2], p: nothing });
    let problem = Manufactured {
        space: space.clone(),
        physics,
        conditions,
        exact,
        in_time: InTime::Difference,
        fluid: false,
        quadrature: QUADRATURE,
    };
    let mut rows = vec![0.0; space.n_field_unknowns()];
    for facet in &space.mesh.facets {
        for point in facet_points(&space, facet, 4) {
            let force = P * point.normal * point.weight;
            for (&node, value) in space.nodes.cell(facet.cell as usize).iter().zip(&point.value) {
                for i in 0..2 {
                    rows[2 * node as usize + i] += value * force.0[i];
                }
            }
        }
    }
    let mut stepper = problem.stepper(Scheme::BackwardEuler, 0.0, true, &options());
    stepper.source = Some(Box::new(move |_, _, _, out| {
        out.iter_mut().zip(&rows).for_each(|(out, row)| *out -= row);
    }));
    let force = move |x: &[f64; 2]| (B * Vector(*x)).0;
    stepper.assembler.set_force(Region::Solid, End::New, Some(&force));
    stepper.step(1.0).unwrap();
    for (node, x) in space.nodes.points.iter().enumerate() {
        let expected = (B * Vector(*x)).0;
        for i in 0..2 {
            let found = stepper.new.u[2 * node + i];
            assert!((found - expected[i]).abs() < 1e-9, "{material:?} u at {x:?}: {found} {}", expected[i]);
        }
    }
    for (cell, dofs) in (0..space.mesh.n_cells()).map(|c| (c, space.pressure.cell(c))) {
        for (a, &dof) in dofs.iter().enumerate() {
            let expected = if a == 0 { p } else { 0.0 };
            let found = stepper.new.p[dof as usize];
            assert!((found - expected).abs() < 1e-8, "{material:?} p in cell {cell}: {found} {expected}");
        }
    }
}

/// Uniaxial tension and simple shear of a block under tractions that are written out, every law.
#[test]
fn a_block_takes_the_closed_form() {
    let (mu, lambda, c1, c2, zero) = (3.0, 5.0, 1.1, 0.4, 0.0);
    for cells in [Cells::Square, Cells::Curved] {
        for a in [0.8f64, 1.4] {
            // Lateral stretch b with P₂₂ = 0: one equation, solved by bisection.
            let lateral = |stress: &dyn Fn(f64, f64) -> f64| {
                let (mut low, mut high) = (0.3, 3.0);
                for _ in 0..200 {
                    let middle = 0.5 * (low + high);
                    if stress(middle, a) > 0.0 { high = middle } else { low = middle }
                }
                low
            };
            let neo = move |b: f64, a: f64| mu * (b - 1.0 / b) + lambda * (a * b - 1.0) * a;
            let venant =
                move |b: f64, a: f64| b * (mu * (b * b - 1.0) + 0.5 * lambda * (a * a + b * b - 2.0));
            // I₂ = a² b² + a² + b².
            let mooney = move |b: f64, a: f64| {
                2.0 * c1 * b + 2.0 * c2 * b * (a * a + 1.0) - 2.0 * (c1 + 2.0 * c2) / b
                    + (lambda - 4.0 * c2) * (a * b - 1.0) * a
            };
            type Law<'a> = (Material, &'a dyn Fn(f64, f64) -> f64);
            let laws: [Law<'_>; 3] = [
                (Material::NeoHookean { mu, lambda }, &neo),
                (Material::StVenantKirchhoff { mu, lambda }, &venant),
                (Material::MooneyRivlin { c1, c2, lambda }, &mooney),
            ];
            for (material, stress) in laws {
                let b = lateral(stress);
                let (B, P) =
                    (Tensor([[a - 1.0, zero], [zero, b - 1.0]]), Tensor([[stress(a, b), zero], [zero; 2]]));
                block(material, cells, B, P, 0.0);
            }
            // σ = μ (a² − a⁻²), μ = 2 (c₁ + c₂), in plane strain; p from the free sides:
            // σ₂₂ = 2 c₁ b² + 2 c₂ b² (a² + 1) − 2 (c₁ + 2 c₂) − p = 0.
            let (material, b) = (Material::incompressible(c1, c2, EXACTLY), 1.0 / a);
            let sigma = 2.0 * (c1 + c2) * (a * a - b * b);
            let p = 2.0 * c1 * b * b + 2.0 * c2 * b * b * (a * a + 1.0) - 2.0 * (c1 + 2.0 * c2);
            let (B, P) = (Tensor([[a - 1.0, zero], [zero, b - 1.0]]), Tensor([[sigma * b, zero], [zero; 2]]));
            block(material, cells, B, P, p);
        }
        // Simple shear: σ = μ [[γ², γ], [γ, 0]] with p = 0, P = σ F⁻ᵀ.
        let (material, gamma) = (Material::incompressible(0.5 * mu, 0.0, EXACTLY), 0.6);
        let sigma = mu * Tensor([[gamma * gamma, gamma], [gamma, zero]]);
        let P = sigma * Tensor([[1.0, zero], [-gamma, 1.0]]);
        block(material, cells, Tensor([[zero, gamma], [zero, zero]]), P, 0.0);
        let compressible = Material::NeoHookean { mu, lambda };
        block(compressible, cells, Tensor([[zero, gamma], [zero, zero]]), P, 0.0);
        // Equibiaxial: P = μ (a − 1/a) + λ (a² − 1) a.
        let a: f64 = 1.2;
        let both = mu * (a - 1.0 / a) + lambda * (a * a - 1.0) * a;
        block(
            compressible,
            cells,
            Tensor([[a - 1.0, zero], [zero, a - 1.0]]),
            Tensor([[both, zero], [zero, both]]),
            0.0,
        );
    }
}

/// The energy of a nearly incompressible body is that of its pressure: half of the work of a small load, and hardly another
/// than without compression. J itself has errors of the mesh, times the bulk modulus.
#[test]
fn the_energy_of_a_nearly_incompressible_body_is_the_work_of_its_load() {
    let text = "[mesh]\ngenerator = \"box\"\nlower = [0, 0]\nupper = [2, 1]\ncells = [3, 2]\n[solid]\nregion = \"fluid\"\n\
                density = 1\nlaw = \"incompressible-neo-hookean\"\nmu = 40\n[boundary.left]\ncondition = \"clamped\"\n\
                [boundary.bottom]\ncondition = \"traction-free\"\n[boundary.right]\ncondition = \"traction-free\"\n\
                [boundary.top]\ncondition = \"traction\"\ntraction = [0, 0.02]\n[functional.elastic]\nkind = \"energy\"\n\
                term = \"elastic\"\n";
    let energy = |more: &[String]| {
        let case = Case::from_toml(text, "block.toml", more).unwrap();
        let mut simulation = Simulation::new(case, 1).unwrap();
        simulation.step().unwrap()["elastic"]
    };
    let without = energy(&[]);
    for bulk in [5e3, 5e5] {
        let with = energy(&[format!("solid.bulk={bulk}")]);
        assert!((with / without - 1.0).abs() < 0.03, "{bulk}: {with:e} {without:e}");
    }
}
