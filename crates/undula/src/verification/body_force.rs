//! The body force with which the momentum equation of a flow holds at exact fields: methods that add the residual see it.
#![allow(non_snake_case)]

use super::manufactured::{Exact, Manufactured, sample};
use crate::math::Tensor;
use crate::physics::{Fluid, Kinematics};
use crate::sampling::for_each_point;
use crate::space::{Region, State};
use crate::system::{Dim, End, Kernels};
use crate::time::Stepper;
use crate::time::stepper::Source;

/// J σ F⁻ᵀ of the exact solution.
fn stress<const D: usize>(fluid: &Fluid, exact: &Exact<D>, x: [f64; D], t: f64) -> Tensor<f64, D> {
    let at = sample(exact, x, t).fields;
    let Kinematics { F_inv, J, .. } = Kinematics::of(&at.grad_u);
    let G = at.grad_v * F_inv;
    let sigma = fluid.rho * fluid.nu * (G + G.t()) - Tensor::identity() * at.p;
    sigma * F_inv.t() * J
}

/// The force per mass with which the stationary momentum equation of a Newtonian fluid holds at a point \[m/s²\],
/// (v·∇)v − div σ/ρ in the moved domain; the divergence by differences of fourth order.
pub fn force<const D: usize>(fluid: &Fluid, exact: &Exact<D>, x: [f64; D], t: f64) -> [f64; D] {
    let at = sample(exact, x, t).fields;
    let Kinematics { F_inv, J, .. } = Kinematics::of(&at.grad_u);
    let rate = at.grad_v * (F_inv * at.v);
    let h = 1e-4;
    std::array::from_fn(|i| {
        let divergence: f64 = (0..D)
            .map(|j| {
                let moved = |s: f64| {
                    let mut x = x;
                    x[j] += s;
                    stress(fluid, exact, x, t).0[i][j]
                };
                (8.0 * (moved(h) - moved(-h)) - (moved(2.0 * h) - moved(-2.0 * h))) / (12.0 * h)
            })
            .sum();
        rate.0[i] - divergence / (fluid.rho * J)
    })
}

/// Gives the stationary flow of `problem`, if there is one, its right-hand side as a body force, and takes it off the
/// source: −A(U)(φ) + (ρ J f, φ).
pub fn give_force<const D: usize>(problem: &Manufactured<D>, stepper: &mut Stepper<D>)
where
    Dim<D>: Kernels<D>,
{
    let Some(fluid) = problem.physics.fluid else { return };
    let exact = &problem.exact;
    stepper.assembler.set_force(Region::Fluid, End::New, Some(&|x| force(&fluid, exact, *x, 0.0)));
    stepper.source = Some(without_force(problem.clone(), fluid));
}

/// The source of `problem` less its body force.
fn without_force<const D: usize>(problem: Manufactured<D>, fluid: Fluid) -> Source
where
    Dim<D>: Kernels<D>,
{
    let mut source = problem.source();
    Box::new(move |t_old, t, theta, out| {
        source(t_old, t, theta, out);
        let space = &*problem.space;
        let zero = State::zero(space.n_v(), space.n_u(), space.n_p());
        for_each_point(space, &zero, problem.quadrature, |point| {
            if point.region != Region::Fluid {
                return;
            }
            let f = force(&fluid, &problem.exact, point.x, t);
            let J = Kinematics::of(&sample(&problem.exact, point.x, t).fields.grad_u).J;
            for (&node, value) in space.nodes.cell(point.cell).iter().zip(point.value) {
                for i in 0..D {
                    out[D * node as usize + i] += fluid.rho * J * f[i] * value * point.weight;
                }
            }
        });
    })
}
