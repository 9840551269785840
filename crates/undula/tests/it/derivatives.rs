//! The derivative of every form: dual numbers = by hand (1e-12) = differences, at random states.
#![allow(non_snake_case)]

use undula::math::{Scalar, Tensor, Vector};
use undula::physics::form::Block;
use undula::physics::rule::{GALERKIN, MIDPOINT, SECANT};
use undula::physics::{
    Artery, Backflow, CarreauYasuda, Damping, Extension, Fabric, FacetForm, Fields, Fluid, Material, Muscle,
    Outflow, Place, Pressure, Reference, Solid, StepRule, Tested, WeakForm,
};
use undula::tangent::{ByHand, Difference, Stencil, Tangent, automatic, automatic_facet, facet, fixed_point};

/// Deterministic random numbers in (−½, ½) (xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    fn vector<const D: usize>(&mut self) -> Vector<f64, D> {
        let mut v = Vector::zero();
        v.0.iter_mut().for_each(|x| *x = self.next());
        v
    }

    fn fields<const D: usize>(&mut self, scale: f64) -> Fields<f64, D> {
        let mut f = Fields::zero();
        for n in 0..Fields::<f64, D>::COMPONENTS {
            *f.component(n) = scale * self.next();
        }
        f
    }

    fn place<const D: usize>(&mut self) -> Place<f64, D> {
        let (force, stiffness) = (10.0 * self.vector(), 1.5 + self.next());
        let fibre: Vector<f64, D> = self.vector();
        let fibre = fibre * (1.0 / fibre.dot(fibre).sqrt());
        let fabric = Fabric { fibre, unloading: self.fields::<D>(0.4).grad_u, ..Fabric::plain() };
        Place { force, stiffness, fabric, ..Place::plain() }
    }

    /// The same with a body force that changes with the position; that of the solid does not.
    fn place_of<F: WeakForm<D>, const D: usize>(&mut self, form: &F) -> Place<f64, D> {
        let mut place = self.place();
        if form.couplings().psi_v == Block::Zero {
            place.force_slope = 10.0 * self.fields::<D>(1.0).grad_u;
        }
        place
    }
}

fn rules() -> Vec<StepRule> {
    vec![
        StepRule::theta(0.005, 1.0),
        StepRule::theta(0.005, 0.51),
        StepRule { inertia: MIDPOINT, ..StepRule::theta(0.005, 0.51) },
        StepRule { inertia: GALERKIN, ..StepRule::theta(0.005, 0.51) },
        StepRule::galerkin(0.005),
        StepRule::STATIONARY,
    ]
}

/// θ = 1 is fully implicit with every domain-motion term; for θ = ½ the Galerkin form has the weights of the book.
#[test]
fn domain_motion_terms_are_those_of_the_book() {
    let mut random = Random(3);
    for _ in 0..50 {
        let (new, old, place) = (random.fields::<2>(0.6), random.fields::<2>(0.6), random.place());
        let with = |theta: f64, inertia| {
            residual(&FLUID, &StepRule { inertia, ..StepRule::theta(0.1, theta) }, &place, &new, &old)
        };
        for inertia in [MIDPOINT, GALERKIN] {
            assert!(gap(&with(1.0, SECANT), &with(1.0, inertia)) < 1e-13);
        }
        let [secant, midpoint, galerkin] = [SECANT, MIDPOINT, GALERKIN].map(|inertia| with(0.5, inertia).phi);
        let mean = secant * (1.0 / 3.0) + midpoint * (2.0 / 3.0) - galerkin;
        assert!(mean.dot(mean).sqrt() < 1e-12 * galerkin.dot(galerkin).sqrt());
        assert!((secant - midpoint).dot(secant - midpoint) > 0.0);
    }
    let weights: Vec<f64> = StepRule { inertia: GALERKIN, ..StepRule::theta(0.1, 0.5) }
        .inertia_points::<2>()
        .map(|(weight, _)| weight)
        .collect();
    for (found, book) in weights.iter().zip([1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0]) {
        assert!((found - book).abs() < 1e-15);
    }
}

const FLUID: Fluid =
    Fluid { rho: 1000.0, nu: 1e-3, thinning: None, extension: Extension::PseudoElastic { poisson: -0.2 } };
const FLUID_HARMONIC: Fluid = Fluid { rho: 1.0, nu: 0.3, thinning: None, extension: Extension::Harmonic };
const FLUID_LAGGED: Fluid =
    Fluid { extension: Extension::JacobianStiffened { poisson: 0.1, lagged: true }, ..FLUID_HARMONIC };
const FLUID_STIFFENED: Fluid =
    Fluid { extension: Extension::JacobianStiffened { poisson: 0.1, lagged: false }, ..FLUID_HARMONIC };
const THINNING: CarreauYasuda = CarreauYasuda { ratio: 0.1, time: 3.0, index: 0.4, transition: 1.3 };
const FLUID_THINNING: Fluid = Fluid { thinning: Some(THINNING), ..FLUID_HARMONIC };
const SOLID: Solid = Solid::elastic(1e3, Material::StVenantKirchhoff { mu: 2e6, lambda: 8e6 });

fn damped(material: Material) -> Solid {
    Solid { damping: Damping { mass: 30.0, shear: 2e5, volume: 3e5 }, ..Solid::elastic(1e3, material) }
}

fn materials() -> [Material; 11] {
    let (mu, lambda) = (2e6, 8e6);
    let matrix = Artery::matrix(mu, lambda, None);
    [
        SOLID.material,
        Material::Linear { mu, lambda },
        Material::NeoHookean { mu, lambda },
        Material::MooneyRivlin { c1: 0.7e6, c2: 0.3e6, lambda },
        Material::incompressible(1e6, 0.0, f64::INFINITY),
        Material::incompressible(0.7e6, 0.3e6, f64::INFINITY),
        Material::incompressible(0.7e6, 0.3e6, lambda),
        Material::ogden(&[[1e6, 1.5], [-0.2e6, -2.0]], lambda, false),
        Material::ogden(&[[1e6, 1.5], [-0.2e6, -2.0]], f64::INFINITY, true),
        Material::Artery(Artery { k1: 1e6, k2: 0.5, dispersion: 0.1, angles: [0.3, 1.2], ..matrix }),
        Material::Muscle(Muscle {
            stiffness: 1e6,
            exponents: [1.5, 0.7, 1.1],
            compliance: 0.0,
            direction: [0.6, 0.8],
        }),
    ]
}

/// Largest deviation of two results relative to the largest entry of the first.
fn gap<const D: usize>(a: &Tested<f64, D>, b: &Tested<f64, D>) -> f64 {
    let (a, b) = (a.to_vec(), b.to_vec());
    let size = a.iter().fold(1e-300, |m: f64, x| m.max(x.abs()));
    a.iter().zip(&b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max) / size
}

fn residual<F: WeakForm<D>, const D: usize>(
    form: &F,
    rule: &StepRule,
    place: &Place<f64, D>,
    new: &Fields<f64, D>,
    old: &Fields<f64, D>,
) -> Tested<f64, D> {
    let mut r = Tested::zero();
    rule.residual(form, place, new, new, old, &mut r);
    r
}

/// `place` where the position has moved by `by` and with it the body force.
fn displaced<const D: usize>(place: &Place<f64, D>, by: Vector<f64, D>) -> Place<f64, D> {
    Place { force: place.force + place.force_slope * by, ..*place }
}

fn check<F: ByHand<D>, const D: usize>(form: &F) {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    for rule in rules() {
        for _ in 0..200 {
            let (new, old) = (random.fields::<D>(0.6), random.fields::<D>(0.6));
            let mut place = random.place_of(form);
            if !rule.quadrature.is_empty() {
                // One force for all times within the step: a case refuses that at the current position.
                place.force_slope = Tensor::zero();
            }
            let W = random.fields::<D>(1.0);
            let dual = automatic(form, &rule, &place, &new, &old, &W);
            let hand = form.by_hand(&rule, &place, &new, &old, &W);
            assert!(gap(&dual, &hand) < 1e-12, "by hand {:e} with {rule:?}", gap(&dual, &hand));
            let moved = |eps: f64| {
                let (mut at, mut w) = (new, W);
                for n in 0..Fields::<f64, D>::COMPONENTS {
                    *at.component(n) += eps * *w.component(n);
                }
                residual(form, &rule, &displaced(&place, at.u - new.u), &at, &old)
            };
            let difference = |b: Tested<f64, D>, a: Tested<f64, D>, h: f64| {
                let (mut d, b) = (a, b);
                d.phi = (b.phi - a.phi) * (1.0 / h);
                d.grad_phi = (b.grad_phi - a.grad_phi) * (1.0 / h);
                d.psi = (b.psi - a.psi) * (1.0 / h);
                d.grad_psi = (b.grad_psi - a.grad_psi) * (1.0 / h);
                d.xi = (b.xi - a.xi) / h;
                d
            };
            let one_sided = difference(moved(1e-7), moved(0.0), 1e-7);
            assert!(gap(&dual, &one_sided) < 1e-5, "one-sided {:e}", gap(&dual, &one_sided));
            let central = difference(moved(1e-5), moved(-1e-5), 2e-5);
            assert!(gap(&dual, &central) < 1e-7, "central {:e} with {rule:?}", gap(&dual, &central));
        }
    }
}

/// A'(U)(W) by dual numbers is Theorem 5.2 and is the limit of differences, for all time rules, with
/// body force, in 2D and 3D.
#[test]
fn fluid_jacobian_is_theorem_5_2() {
    check::<_, 2>(&FLUID);
    check::<_, 3>(&FLUID);
    check::<_, 2>(&FLUID_HARMONIC);
    check::<_, 3>(&FLUID_HARMONIC);
    for fluid in [FLUID_LAGGED, FLUID_STIFFENED, FLUID_THINNING] {
        check::<_, 2>(&fluid);
        check::<_, 3>(&fluid);
    }
}

/// The same for the solid with every law, Lemma 5.5, with a loaded reference domain, too.
#[test]
#[ignore = "long"]
fn solid_jacobian_is_lemma_5_5() {
    for material in materials() {
        for solid in [Solid::elastic(1e3, material), damped(material)] {
            for reference in [Reference::Free, Reference::Loaded, Reference::Sought] {
                let solid = Solid { reference, ..solid };
                check::<_, 2>(&solid);
                check::<_, 3>(&solid);
            }
        }
    }
}

/// Differences at the point: the error falls with ε, with its square on both sides.
#[test]
fn differences_are_of_first_and_second_order() {
    fn run<F: ByHand<D>, const D: usize>(form: &F) {
        let mut random = Random(31);
        let rule = StepRule::theta(0.005, 0.51);
        for _ in 0..20 {
            let (new, old, place) = (random.fields::<D>(0.6), random.fields::<D>(0.6), random.place_of(form));
            let W = random.fields::<D>(1.0);
            let exact = automatic(form, &rule, &place, &new, &old, &W);
            let base = residual(form, &rule, &place, &new, &old);
            let error = |stencil, h: f64| {
                let by = Difference::new(stencil, h);
                let d = by.derivative(false, form, &rule, &place, (&new, &old), &base, (&W, h));
                gap(&exact, &d)
            };
            for (stencil, h, order) in [(Stencil::OneSided, 1e-4, 1), (Stencil::Central, 1e-2, 2)] {
                let (coarse, fine) = (error(stencil, h), error(stencil, h / 10.0));
                let found = (coarse / fine).log10();
                assert!(
                    fine < 1e-3 && (found - f64::from(order)).abs() < 0.2,
                    "{stencil:?}: {coarse:e} {fine:e}"
                );
            }
        }
    }
    run::<_, 2>(&FLUID);
    run::<_, 3>(&FLUID);
    run::<_, 2>(&SOLID);
    run::<_, 3>(&SOLID);
}

/// The system of section 5.2.1 by hand, for backward Euler: the flow carried by the last velocity on the last
/// domain, the corrected strain, and u free in the velocity-deformation relation.
#[test]
fn fixed_point_is_section_5_2_1() {
    fn run<const D: usize>() {
        let (mut random, k) = (Random(13), 0.005);
        let rule = StepRule::theta(k, 1.0);
        for _ in 0..100 {
            let (new, old, place) = (random.fields::<D>(0.6), random.fields::<D>(0.6), random.place());
            let W = random.fields::<D>(1.0);
            let F = Tensor::identity() + new.grad_u;
            let (J, F_inv) = (F.det(), F.cofactor().t() * (1.0 / F.det()));
            let transport = new.v - (new.u - old.u) * (1.0 / k);
            let (rho, mu) = (FLUID.rho, FLUID.rho * FLUID.nu);
            let sigma = mu * (W.grad_v * F_inv + (W.grad_v * F_inv).t()) - Tensor::identity() * W.p;
            let flow = Tested {
                phi: (W.v * (1.0 / k) + W.grad_v * (F_inv * transport)) * (rho * J),
                grad_phi: sigma * F_inv.t() * J,
                xi: J * F_inv.ddot(W.grad_v.t()),
                grad_psi: FLUID.extension.stress(&W.grad_u, place.stiffness),
                ..Tested::zero()
            };
            let found = fixed_point(&FLUID, &rule, &place, &new, &old, &W);
            assert!(gap(&flow, &found) < 1e-12, "{:e}", gap(&flow, &found));

            let E = 0.5 * (W.grad_u + W.grad_u.t() + new.grad_u.t() * W.grad_u);
            let Material::StVenantKirchhoff { mu, lambda } = SOLID.material else { unreachable!() };
            let body = Tested {
                phi: W.v * (SOLID.rho / k),
                grad_phi: F * (2.0 * mu * E + Tensor::identity() * (lambda * E.trace())),
                psi: W.u * (1.0 / k) - W.v,
                ..Tested::zero()
            };
            let found = fixed_point(&SOLID, &rule, &place, &new, &old, &W);
            assert!(gap(&body, &found) < 1e-12, "{:e}", gap(&body, &found));
        }
    }
    run::<2>();
    run::<3>();
}

/// With what it keeps held fast the equation is linear: differences of it are exact whatever their size, and at
/// the last iterate it is the equation itself.
#[test]
fn fixed_point_equations_are_linear() {
    fn run<F: ByHand<D>, const D: usize>(form: &F) {
        let mut random = Random(17);
        for rule in rules() {
            let (new, old, place) = (random.fields::<D>(0.6), random.fields::<D>(0.6), random.place_of(form));
            let W = random.fields::<D>(1.0);
            let base = residual(form, &rule, &place, &new, &old);
            let dual = fixed_point(form, &rule, &place, &new, &old, &W);
            for h in [1.0, 0.1] {
                let by = Difference::new(Stencil::OneSided, h);
                let d = by.derivative(true, form, &rule, &place, (&new, &old), &base, (&W, h));
                assert!(gap(&dual, &d) < 1e-11, "{:e} with {rule:?}", gap(&dual, &d));
            }
        }
    }
    run::<_, 2>(&FLUID);
    run::<_, 3>(&FLUID_HARMONIC);
    run::<_, 2>(&FLUID_THINNING);
    run::<_, 2>(&SOLID);
    run::<_, 3>(&SOLID);
}

/// The do-nothing correction is linearised in v and in u.
#[test]
fn outflow_jacobian() {
    fn run<const D: usize>(thinning: Option<CarreauYasuda>) {
        let mut random = Random(77);
        let form = Outflow { viscosity: 1.3, thinning };
        for _ in 0..200 {
            let (at, W, n) = (random.fields::<D>(0.6), random.fields::<D>(1.0), random.vector());
            let dual = automatic_facet(&form, 0.51, &at, &n, &W);
            let hand = undula::physics::theorem_5_2::outflow(&form, 0.51, &at, &n, &W);
            let moved = |eps: f64| {
                let (mut a, mut w) = (at, W);
                for c in 0..Fields::<f64, D>::COMPONENTS {
                    *a.component(c) += eps * *w.component(c);
                }
                form.traction(&a, &a, &n, 0.51)
            };
            let difference = (moved(1e-6) - moved(-1e-6)) * 5e5;
            let size = dual.dot(dual).sqrt();
            let (e, f) = (dual - hand, dual - difference);
            assert!(e.dot(e).sqrt() < 1e-12 * size);
            assert!(f.dot(f).sqrt() < 1e-7 * size);
        }
    }
    for thinning in [None, Some(THINNING)] {
        run::<2>(thinning);
        run::<3>(thinning);
    }
}

/// The load of a pressure is linearised in ∇u; in a fixed-point iteration it is that of the last iterate.
#[test]
fn pressure_jacobian() {
    fn run<const D: usize>() {
        let mut random = Random(79);
        for follows in [true, false] {
            let form = Pressure { pressure: 1.3, follows };
            for _ in 0..100 {
                let (at, W, n) = (random.fields::<D>(0.6), random.fields::<D>(1.0), random.vector());
                let automatic = facet((Tangent::Automatic, false), &form, 0.51, &at, &n, &W);
                let hand = facet((Tangent::Analytic, false), &form, 0.51, &at, &n, &W);
                let by = Difference::new(Stencil::Central, 1e-5);
                let difference = facet((Tangent::Difference(by), false), &form, 0.51, &at, &n, &W);
                let lagged = facet((Tangent::Automatic, true), &form, 0.51, &at, &n, &W);
                assert_eq!(lagged.dot(lagged), 0.0);
                let size = if follows { automatic.dot(automatic).sqrt() } else { 1.0 };
                assert!(follows || automatic.dot(automatic) == 0.0);
                let (e, f) = (automatic - hand, automatic - difference);
                assert!(e.dot(e).sqrt() < 1e-12 * size);
                assert!(f.dot(f).sqrt() < 1e-7 * size);
            }
        }
    }
    run::<2>();
    run::<3>();
}

/// The directional term is linearised in v, ∂_t u and ∇u; it vanishes where the flow leaves, and takes out as much energy
/// as comes in. Its tangential part acts along the boundary in motion, and takes out the energy of the flow along it.
#[test]
fn backflow_jacobian() {
    fn run<const D: usize>(tangential: bool) {
        let mut random = Random(78);
        let form = Backflow { density: 1.3, tangential };
        let mut into = 0;
        for _ in 0..200 {
            let (at, W, n) = (random.fields::<D>(0.6), random.fields::<D>(1.0), random.vector());
            let area = undula::physics::kinematics::cofactor(&at.grad_u) * n;
            let (flow, normal) = ((at.v - at.u).dot(area), area * (1.0 / area.dot(area).sqrt()));
            let carried = if tangential { at.v - normal * normal.dot(at.v) } else { at.v };
            let term = form.traction(&at, &at, &n, 0.51);
            let energy = term.dot(at.v) - 0.51 * 0.5 * 1.3 * (-flow).max(0.0) * carried.dot(carried);
            assert!(energy.abs() < 1e-12 && (!tangential || term.dot(normal).abs() < 1e-12));
            let dual = automatic_facet(&form, 0.51, &at, &n, &W);
            let hand = undula::physics::theorem_5_2::backflow(&form, 0.51, &at, &n, &W);
            if flow > 0.0 {
                assert_eq!([term.dot(term), dual.dot(dual), hand.dot(hand)], [0.0; 3]);
                continue;
            }
            into += 1;
            let moved = |eps: f64| {
                let (mut a, mut w) = (at, W);
                for c in 0..Fields::<f64, D>::COMPONENTS {
                    *a.component(c) += eps * *w.component(c);
                }
                form.traction(&a, &a, &n, 0.51)
            };
            let difference = (moved(1e-6) - moved(-1e-6)) * 5e5;
            let size = dual.dot(dual).sqrt();
            let (e, f) = (dual - hand, dual - difference);
            assert!(e.dot(e).sqrt() < 1e-12 * size);
            assert!(f.dot(f).sqrt() < 1e-6 * size);
        }
        assert!((50..150).contains(&into), "{into} of 200 flow in");
    }
    for tangential in [false, true] {
        run::<2>(tangential);
        run::<3>(tangential);
    }
}

/// The declared couplings are exactly the blocks of the derivative that are not zero.
#[test]
fn couplings_are_those_of_the_derivative() {
    fn run<F: ByHand<D>, const D: usize>(form: &F) {
        let mut random = Random(5);
        let rule = StepRule::theta(0.01, 0.6);
        // (φ value, φ gradient, ψ value, ψ gradient, ξ) by (v, ∇v, u, ∇u, p).
        let mut touched = [[false; 5]; 5];
        for _ in 0..20 {
            let (new, old, place) = (random.fields::<D>(0.6), random.fields::<D>(0.6), random.place());
            for n in 0..Fields::<f64, D>::COMPONENTS {
                let mut W = Fields::zero();
                *W.component(n) = 1.0;
                let t = automatic(form, &rule, &place, &new, &old, &W);
                let bounds = [D, D + D * D, 2 * D + D * D, 2 * (D + D * D), 2 * (D + D * D) + 1];
                let trial = bounds.iter().position(|&b| n < b).unwrap();
                let any = |x: &[f64]| x.iter().any(|v| *v != 0.0);
                let list = t.to_vec();
                let mut from = 0;
                for (test, &to) in bounds.iter().enumerate() {
                    touched[test][trial] |= any(&list[from..to]);
                    from = to;
                }
            }
        }
        let block = |test: usize, trial: usize| {
            let get = |a: usize, b: usize| touched[test + a][trial + b];
            match (get(0, 0), get(0, 1), get(1, 0), get(1, 1)) {
                (false, false, false, false) => Block::Zero,
                (true, false, false, false) => Block::Mass,
                (false, false, false, true) => Block::Stiffness,
                _ => Block::Full,
            }
        };
        let c = form.couplings();
        assert_eq!(c.phi_v, block(0, 0));
        assert_eq!(c.phi_u, block(0, 2));
        assert_eq!(c.psi_v, block(2, 0));
        assert_eq!(c.psi_u, block(2, 2));
        // Pressure: ∇φ on p and ξ on ∇v, ∇u, p; nothing else.
        let [pressure, xi_v] = [c.pressure, c.xi_v].map(|block| block == Block::Stiffness);
        assert!([c.pressure, c.xi_v].iter().all(|b| matches!(b, Block::Zero | Block::Stiffness)));
        let all = [((1, 4), pressure), ((4, 1), xi_v), ((4, 3), pressure), ((4, 4), c.xi_p)];
        let expected: Vec<(usize, usize)> = all.into_iter().filter(|(_, is)| *is).map(|(at, _)| at).collect();
        for i in 0..5 {
            for j in 0..5 {
                if i == 4 || j == 4 {
                    assert_eq!(touched[i][j], expected.contains(&(i, j)), "block {i}, {j}");
                }
            }
        }
    }
    run::<_, 2>(&FLUID);
    run::<_, 3>(&FLUID);
    run::<_, 2>(&FLUID_STIFFENED);
    run::<_, 2>(&FLUID_THINNING);
    for material in materials() {
        run::<_, 2>(&Solid::elastic(1e3, material));
        run::<_, 2>(&damped(material));
        run::<_, 3>(&Solid::elastic(1e3, material));
    }
}

/// A rigid rotation gives no stress in the solid, and a rigidly rotating flow on a rigidly rotated
/// domain no viscous stress.
#[test]
fn rigid_motion_gives_no_stress() {
    let (s, c) = (0.7f64.sin(), 0.7f64.cos());
    let mut fields = Fields::<f64, 2>::zero();
    fields.grad_u = Tensor([[c - 1.0, -s], [s, c - 1.0]]);
    let stress = SOLID.material.piola(&fields.grad_u, &fields.grad_u);
    assert!(stress.ddot(Tensor([[1.0, 1.0], [1.0, 1.0]])).abs() < 1e-8);
    // v = ω × x at the current position x = F X: ∇v = Ω F.
    fields.grad_v = Tensor([[0.0, -2.0], [2.0, 0.0]]) * (Tensor::identity() + fields.grad_u);
    let mut r = Tested::zero();
    FLUID.transport(&Place::plain(), &fields, &fields, 1.0, &mut r);
    assert!(r.grad_phi.ddot(r.grad_phi).sqrt() < 1e-12);
    let _ = SECANT;
    let _: f64 = Scalar::zero();
}
