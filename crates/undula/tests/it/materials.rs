//! Constitutive laws at a point: energies, closed forms, objectivity, Hooke's law at rest.
#![allow(non_snake_case)]

use undula::math::{Dual, Scalar, Tensor, Vector};
use undula::physics::kinematics::{cofactor, volume_change};
use undula::physics::{Artery, Deformation, IsochoricNeoHookean, Material, Muscle, StoredEnergy};

/// Deterministic random numbers in (−½, ½) (xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    fn tensor<const D: usize>(&mut self, size: f64) -> Tensor<f64, D> {
        let mut a = Tensor::zero();
        a.0.iter_mut().flatten().for_each(|x| *x = size * self.next());
        a
    }
}

const MU: f64 = 3.0;
const LAMBDA: f64 = 5.0;
const C1: f64 = 1.1;
const C2: f64 = 0.4;

const LINEAR: Material = Material::Linear { mu: MU, lambda: LAMBDA };
const VENANT: Material = Material::StVenantKirchhoff { mu: MU, lambda: LAMBDA };
const NEO: Material = Material::NeoHookean { mu: MU, lambda: LAMBDA };
const ISOCHORIC: Material =
    Material::Isochoric(IsochoricNeoHookean { mu: MU, bulk: LAMBDA + 2.0 / 3.0 * MU });
const MOONEY: Material = Material::MooneyRivlin { c1: C1, c2: C2, lambda: LAMBDA };

fn nearly() -> Material {
    Material::incompressible(C1, C2, LAMBDA)
}

fn incompressible(c2: f64) -> Material {
    Material::incompressible(C1, c2, f64::INFINITY)
}

/// Those with a stress by hand.
fn by_hand() -> [Material; 7] {
    [LINEAR, VENANT, NEO, MOONEY, nearly(), incompressible(C2), incompressible(0.0)]
}

const TERMS: [[f64; 2]; 3] = [[1.2, 1.3], [0.3, 5.0], [-0.4, -2.0]];

/// Compressible, nearly and fully incompressible.
fn ogdens() -> [Material; 3] {
    let own = |lambda| Material::ogden(&TERMS, lambda, true);
    [Material::ogden(&TERMS, LAMBDA, false), own(LAMBDA), own(f64::INFINITY)]
}

fn all() -> Vec<Material> {
    [&by_hand()[..], &ogdens(), &with_fibres(), &[ISOCHORIC]].concat()
}

const ARTERY: Artery = Artery {
    mu: MU,
    lambda: LAMBDA,
    compliance: None,
    k1: 2.0,
    k2: 0.8,
    dispersion: 0.1,
    angles: [0.9, -0.3],
    direction: [1.0, 0.0],
};
const MUSCLE: Muscle =
    Muscle { stiffness: 2.0, exponents: [1.5, 0.7, 1.1], compliance: 0.0, direction: [0.6, 0.8] };

fn with_fibres() -> [Material; 4] {
    let own = Artery { lambda: 0.0, compliance: Some(1.0 / LAMBDA), ..ARTERY };
    let nearly = Muscle { compliance: 0.1, ..MUSCLE };
    [Material::Artery(ARTERY), Material::Artery(own), Material::Muscle(MUSCLE), Material::Muscle(nearly)]
}

/// P with the pressure that a nearly incompressible law has by itself, p = −κ' (J − 1).
fn piola<T: Scalar, const D: usize>(material: &Material, grad_u: &Tensor<T, D>) -> Tensor<T, D> {
    let P = material.piola(grad_u, grad_u);
    match material.compliance() {
        Some(c) if c > 0.0 => P + cofactor(grad_u) * (volume_change(grad_u, grad_u) * (1.0 / c)),
        _ => P,
    }
}

/// Cauchy stress P Fᵀ / J.
fn cauchy<const D: usize>(material: &Material, F: Tensor<f64, D>) -> Tensor<f64, D> {
    let grad_u = F - Tensor::identity();
    piola(material, &grad_u) * F.t() * (1.0 / F.det())
}

fn largest<const D: usize>(a: Tensor<f64, D>) -> f64 {
    a.0.iter().flatten().fold(0.0, |m, x| m.max(x.abs()))
}

fn assert_near<const D: usize>(a: Tensor<f64, D>, b: Tensor<f64, D>, what: &str) {
    assert!(largest(a - b) < 1e-12 * (1.0 + largest(b)), "{what}: {a:?} is not {b:?}");
}

/// P = ∂W/∂F by dual numbers at random F, not symmetric, in both dimensions.
#[test]
fn stress_is_the_derivative_of_the_energy() {
    fn run<const D: usize>() {
        let mut random = Random(11);
        for material in by_hand() {
            for _ in 0..100 {
                let grad_u = random.tensor::<D>(0.6);
                let mut slope = Tensor::<f64, D>::zero();
                for i in 0..D {
                    for j in 0..D {
                        let mut at = grad_u.map(|x| Dual { re: x, eps: 0.0 });
                        at.0[i][j].eps = 1.0;
                        slope.0[i][j] = material.energy(&at).eps;
                    }
                }
                assert_near(piola(&material, &grad_u), slope, &format!("{material:?} in {D}D"));
            }
        }
    }
    run::<2>();
    run::<3>();
}

/// The built-in energies as laws of another program: what follows from them is what is written by hand.
#[test]
fn laws_by_their_energy_are_those_by_hand() {
    fn run<const D: usize>() {
        let mut random = Random(17);
        for material in by_hand() {
            let own = Material::own(material);
            for _ in 0..100 {
                let (grad_u, grad_w) = (random.tensor::<D>(0.6), random.tensor::<D>(1.0));
                let what = format!("{material:?} in {D}D");
                let expected = piola(&material, &grad_u);
                assert_near(own.stress(&grad_u), expected, &what);
                let at = seeded(&grad_u, &grad_w);
                let slope = piola(&material, &at).map(|x| x.eps);
                assert_near(own.tangent(&grad_u, &grad_w), slope, &what);
                // By dual numbers, as the Jacobian has it; the state before does not matter.
                let lagged = own.piola(&at, &at.map(Scalar::frozen));
                assert_near(lagged.map(|x| x.re), expected, &what);
                assert_near(lagged.map(|x| x.eps), slope, &what);
                let energy = own.energy(&at);
                assert!((energy.re - material.energy(&grad_u)).abs() < 1e-13, "{what}");
                assert!((energy.eps - expected.ddot(grad_w)).abs() < 1e-12, "{what}");
            }
        }
    }
    run::<2>();
    run::<3>();
}

/// ∇u + ε ∇w.
fn seeded<const D: usize>(grad_u: &Tensor<f64, D>, grad_w: &Tensor<f64, D>) -> Tensor<Dual<f64>, D> {
    let mut at = grad_u.map(|x| Dual { re: x, eps: 0.0 });
    at.0.as_flattened_mut().iter_mut().zip(grad_w.0.as_flattened()).for_each(|(x, w)| x.eps = *w);
    at
}

/// The derivative at rest is 2 μ ε + λ tr(ε) I for every law, μ = 2 (c₁ + c₂); with J = 1 for ε without trace.
#[test]
fn at_rest_every_law_is_that_of_hooke() {
    fn run<const D: usize>() {
        let mut random = Random(5);
        for material in by_hand().into_iter().chain(ogdens()) {
            let mu = match material {
                Material::Linear { mu, .. }
                | Material::StVenantKirchhoff { mu, .. }
                | Material::NeoHookean { mu, .. } => mu,
                Material::MooneyRivlin { c1, c2, .. } | Material::Incompressible { c1, c2, .. } => {
                    2.0 * (c1 + c2)
                }
                Material::Ogden(law) => law.shear_modulus(),
                _ => unreachable!("of other constants"),
            };
            let rest = Tensor::<f64, D>::zero();
            assert_eq!(largest(piola(&material, &rest)), 0.0, "{material:?}");
            assert_eq!(material.energy(&rest), 0.0, "{material:?}");
            for _ in 0..20 {
                let mut w = random.tensor::<D>(1.0);
                if material.compliance() == Some(0.0) {
                    w = w - Tensor::identity() * (w.trace() / D as f64);
                }
                let strain = 0.5 * (w + w.t());
                let expected = 2.0 * mu * strain + Tensor::identity() * (LAMBDA * w.trace());
                let at = w.map(|x| Dual { re: 0.0, eps: x });
                let slope = piola(&material, &at).map(|x| x.eps);
                assert_near(slope, expected, &format!("{material:?}"));
                // Of the energy: positive unless the body only turns.
                let twice = slope.ddot(w);
                assert!(twice > 0.0, "{material:?} {w:?}");
            }
        }
    }
    run::<2>();
    run::<3>();
}

/// W(Q F) = W(F) and P(Q F) = Q P(F) for rotations Q; the linear law is the one of which this is not true.
#[test]
fn a_rotation_turns_the_stress_and_nothing_else() {
    let mut random = Random(3);
    for material in all() {
        for _ in 0..50 {
            let (a, b) = (3.0 * random.next(), 3.0 * random.next());
            let about_z = Tensor([[a.cos(), -a.sin(), 0.0], [a.sin(), a.cos(), 0.0], [0.0, 0.0, 1.0]]);
            let about_x = Tensor([[1.0, 0.0, 0.0], [0.0, b.cos(), -b.sin()], [0.0, b.sin(), b.cos()]]);
            let (Q, I) = (about_z * about_x, Tensor::identity());
            let F = I + random.tensor(0.6);
            let (turned, straight) = (Q * F - I, F - I);
            let gap = piola(&material, &turned) - Q * piola(&material, &straight);
            let energy = material.energy(&turned) - material.energy(&straight);
            if material == LINEAR {
                assert!(largest(gap) > 1e-3);
            } else {
                assert!(largest(gap) < 1e-12 && energy.abs() < 1e-12, "{material:?} {gap:?} {energy}");
            }
        }
    }
}

/// Plane strain is the three-dimensional law with F₃₃ = 1.
#[test]
fn two_dimensions_are_plane_strain() {
    let mut random = Random(9);
    for material in all() {
        for _ in 0..50 {
            let plane = random.tensor::<2>(0.6);
            let mut full = Tensor::<f64, 3>::zero();
            for i in 0..2 {
                for j in 0..2 {
                    full.0[i][j] = plane.0[i][j];
                }
            }
            let P = piola(&material, &full);
            let block = Tensor([[P.0[0][0], P.0[0][1]], [P.0[1][0], P.0[1][1]]]);
            assert_near(piola(&material, &plane), block, &format!("{material:?}"));
            assert!((material.energy(&plane) - material.energy(&full)).abs() < 1e-12);
        }
    }
}

fn diagonal(a: f64, b: f64, c: f64) -> Tensor<f64, 3> {
    Tensor([[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]])
}

/// F = diag(a, b, b): P₁₁ of each compressible law, written out.
#[test]
fn uniaxial_stretch() {
    for (a, b) in [(1.7, 0.8), (0.6, 1.1), (1.01, 1.0)] {
        let (F, J) = (diagonal(a, b, b), a * b * b);
        let axial = |material: &Material| piola(material, &(F - Tensor::identity())).0[0][0];
        let trace = a * a + 2.0 * b * b - 3.0;
        let venant = a * (MU * (a * a - 1.0) + 0.5 * LAMBDA * trace);
        let neo = MU * (a - 1.0 / a) + LAMBDA * (J - 1.0) * J / a;
        // ∂I₂/∂a = 2 a (b² + b²) for the stretches a, b, b.
        let mooney = 2.0 * C1 * a
            + 4.0 * C2 * a * b * b
            + (-2.0 * (C1 + 2.0 * C2) + (LAMBDA - 4.0 * C2) * (J - 1.0) * J) / a;
        let linear = 2.0 * MU * (a - 1.0) + LAMBDA * (a + 2.0 * b - 3.0);
        for (material, expected) in [(VENANT, venant), (NEO, neo), (MOONEY, mooney), (LINEAR, linear)] {
            assert!((axial(&material) - expected).abs() < 1e-12 * (1.0 + expected.abs()), "{material:?}");
        }
    }
}

/// With J = 1 and the lateral stress free: σ = 2 (c₁ + c₂/a)(a² − 1/a) in tension, and
/// σ = 2 (c₁ + c₂ a²)(a² − a⁻⁴) if stretched in two directions (Rivlin 1948).
#[test]
fn incompressible_tension_and_equibiaxial_stretch() {
    for c2 in [0.0, C2] {
        let material = incompressible(c2);
        for a in [0.5, 0.9, 1.3, 2.5] {
            let lateral = 1.0 / f64::sqrt(a);
            let one = cauchy(&material, diagonal(a, lateral, lateral));
            // Whatever the pressure, the difference is the stress with one of them zero.
            let expected = 2.0 * (C1 + c2 / a) * (a * a - 1.0 / a);
            assert!((one.0[0][0] - one.0[1][1] - expected).abs() < 1e-12 * (1.0 + expected.abs()));
            let two = cauchy(&material, diagonal(a, a, 1.0 / (a * a)));
            let expected = 2.0 * (C1 + c2 * a * a) * (a * a - a.powi(-4));
            assert!((two.0[0][0] - two.0[2][2] - expected).abs() < 1e-12 * (1.0 + expected.abs()));
        }
    }
}

/// Simple shear γ: σ₁₂ = μ γ for the laws of rubber, with σ₁₁ − σ₃₃ = 2 c₁ γ² and σ₂₂ − σ₃₃ = −2 c₂ γ²;
/// St. Venant-Kirchhoff: Σ₁₂ = μ γ, Σ₁₁ = ½ λ γ², Σ₂₂ = (μ + ½ λ) γ².
#[test]
fn simple_shear() {
    for gamma in [-0.8, 0.05, 1.5] {
        let F = Tensor([[1.0, gamma, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let square = gamma * gamma;
        for (material, c1, c2) in
            [(NEO, 0.5 * MU, 0.0), (MOONEY, C1, C2), (nearly(), C1, C2), (incompressible(C2), C1, C2)]
        {
            let sigma = cauchy(&material, F).0;
            let found = [sigma[0][1], sigma[0][0] - sigma[2][2], sigma[1][1] - sigma[2][2]];
            let expected = [2.0 * (c1 + c2) * gamma, 2.0 * c1 * square, -2.0 * c2 * square];
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{material:?}: {found} is not {expected}");
            }
        }
        let (half, shear) = (0.5 * LAMBDA * square, MU * gamma);
        let Sigma = Tensor([[half, shear, 0.0], [shear, MU * square + half, 0.0], [0.0, 0.0, half]]);
        assert_near(piola(&VENANT, &(F - Tensor::identity())), F * Sigma, "St. Venant-Kirchhoff");
    }
}

/// In the plane I₁ = I₂ where J = 1: Mooney-Rivlin and neo-Hookean solids differ by a pressure.
#[test]
fn in_the_plane_incompressible_mooney_rivlin_is_neo_hookean() {
    let mut random = Random(21);
    let (mooney, neo) = (incompressible(C2), Material::incompressible(C1 + C2, 0.0, f64::INFINITY));
    for _ in 0..50 {
        let mut F = Tensor::identity() + random.tensor::<2>(0.6);
        F = F * (1.0 / F.det().sqrt());
        let gap = cauchy(&mooney, F) - cauchy(&neo, F);
        assert_near(gap, Tensor::identity() * (0.5 * gap.trace()), "a pressure");
    }
}

/// Neo-Hookean is Mooney-Rivlin with c₂ = 0.
#[test]
fn mooney_rivlin_contains_neo_hookean() {
    let mut random = Random(31);
    let same = Material::MooneyRivlin { c1: 0.5 * MU, c2: 0.0, lambda: LAMBDA };
    for _ in 0..20 {
        let grad_u = random.tensor::<3>(0.6);
        assert_near(piola(&same, &grad_u), piola(&NEO, &grad_u), "neo-Hookean");
    }
}

/// What a fixed-point iteration solves for enters linearly, and where it stands still it is the law.
#[test]
fn the_lagged_stress_is_linear_in_the_new_deformation() {
    let mut random = Random(41);
    for material in by_hand() {
        for _ in 0..20 {
            let (lag, a, b) = (random.tensor::<3>(0.5), random.tensor::<3>(1.0), random.tensor::<3>(1.0));
            let of = |at: Tensor<f64, 3>| material.piola(&at, &lag);
            assert_near(of(a + 2.0 * b), of(a) + 2.0 * of(b), &format!("{material:?}"));
            let J = (Tensor::identity() + lag).det();
            assert!((volume_change(&lag, &lag) - (J - 1.0)).abs() < 1e-14, "J - 1");
        }
    }
}

/// Small strains lose no digits: P/ε is that of Hooke's law at ε = 1e-12, too.
#[test]
fn tiny_strains_are_exact() {
    let w = Tensor([[1.0, 0.5], [-0.25, 0.75]]);
    let hooke = LINEAR.piola(&w, &w);
    for material in [VENANT, NEO] {
        let tiny = 1e-12 * w;
        assert!(largest(1e12 * material.piola(&tiny, &tiny) - hooke) < 1e-10, "{material:?}");
    }
}

/// Rubber resists being pressed to nothing; St. Venant-Kirchhoff gives way.
#[test]
fn only_rubber_resists_collapse() {
    let pressed = |a: f64, material: &Material| {
        let F = Tensor([[a, 0.0], [0.0, 1.0]]);
        piola(material, &(F - Tensor::identity())).0[0][0]
    };
    for material in [NEO, MOONEY] {
        assert!(pressed(1e-3, &material) < 100.0 * pressed(0.3, &material), "{material:?}");
        assert!(material.energy(&Tensor([[-1.5, 0.0], [0.0, 0.0]])).is_nan(), "no meaning at J < 0");
        assert!(material.needs_positive_volume());
    }
    assert!(pressed(1e-3, &VENANT) > pressed(0.5, &VENANT));
}

/// The energy of Ogden in the plane, its principal stretches as roots: without derivative where they are equal.
struct Roots {
    lambda: f64,
}

impl StoredEnergy for Roots {
    fn energy<T: Scalar, const D: usize>(&self, at: &Deformation<T, D>) -> T {
        let (J, half) = (at.J(), (at.I1_minus_3() + T::constant(2.0)) * 0.5);
        let root = (half * half - J * J).sqrt();
        let mut W = at.J_minus_1() * at.J_minus_1() * (0.5 * self.lambda);
        for [mu, alpha] in TERMS {
            let sum = (half + root).powf(0.5 * alpha) + (half - root).powf(0.5 * alpha) - T::constant(2.0);
            W += sum * (mu / alpha) - J.ln() * mu;
        }
        W
    }
}

/// Energy, stress and tangent of Ogden's law are those of the principal stretches as roots, differentiated.
#[test]
fn ogden_is_the_derivative_of_its_energy() {
    let mut random = Random(51);
    for (lambda, law) in [LAMBDA, 0.0].into_iter().zip([0, 2].map(|n| ogdens()[n])) {
        let roots = Material::own(Roots { lambda });
        for _ in 0..200 {
            let (grad_u, grad_w) = (random.tensor::<2>(0.6), random.tensor::<2>(1.0));
            let (P, dP) = (roots.stress(&grad_u), roots.tangent(&grad_u, &grad_w));
            let near = |a: Tensor<f64, 2>, b: Tensor<f64, 2>| largest(a - b) < 1e-9 * (1.0 + largest(b));
            assert!(near(law.stress(&grad_u), P), "{:?} {P:?}", law.stress(&grad_u));
            assert!(near(law.tangent(&grad_u, &grad_w), dP), "{:?} {dP:?}", law.tangent(&grad_u, &grad_w));
            let dual = law.piola(&seeded(&grad_u, &grad_w), &seeded(&grad_u, &grad_w));
            assert!(near(dual.map(|x| x.eps), dP));
            assert!((law.energy(&grad_u) - roots.energy(&grad_u)).abs() < 1e-12);
            let slope = law.energy(&seeded(&grad_u, &grad_w)).eps;
            assert!((slope - P.ddot(grad_w)).abs() < 1e-9);
        }
    }
}

/// One term with α = 2 is neo-Hookean, in space and in the plane, at equal stretches and between them.
#[test]
fn ogden_contains_neo_hookean() {
    fn run<const D: usize>() {
        let (ogden, mut random) = (Material::ogden(&[[MU, 2.0]], LAMBDA, false), Random(61));
        let mut at: Vec<Tensor<f64, D>> = (0..50).map(|_| random.tensor(0.6)).collect();
        // Stretches that are equal, and nearly so.
        at.extend([0.0, 1e-15, 1e-9, 1e-5].map(|gap| {
            let mut grad_u = 0.3 * Tensor::identity();
            grad_u.0[0][0] += gap;
            grad_u.0[0][D - 1] += 0.5 * gap;
            grad_u
        }));
        at.push(Tensor::zero());
        for grad_u in at {
            let grad_w = random.tensor::<D>(1.0);
            assert_near(ogden.stress(&grad_u), NEO.stress(&grad_u), "stress");
            assert_near(ogden.tangent(&grad_u, &grad_w), NEO.tangent(&grad_u, &grad_w), "tangent");
            assert!((ogden.energy(&grad_u) - NEO.energy(&grad_u)).abs() < 1e-12);
        }
    }
    run::<2>();
    run::<3>();
}

/// Closed forms: P₁₁ of F = diag(a, b, b), and tension and equibiaxial stretch with J = 1,
/// σ₁ − σ₂ = Σ μ_p (λ₁^α_p − λ₂^α_p). Small strains lose no digits.
#[test]
fn ogden_in_principal_stretches() {
    let [compressible, _, incompressible] = ogdens();
    let sum =
        |x: f64, y: f64| TERMS.iter().map(|[mu, alpha]| mu * (x.powf(*alpha) - y.powf(*alpha))).sum::<f64>();
    for (a, b) in [(1.7, 0.8), (0.6, 1.1), (1.01, 1.0)] {
        let P = piola(&compressible, &(diagonal(a, b, b) - Tensor::identity()));
        let expected = sum(a, 1.0) / a + LAMBDA * (a * b * b - 1.0) * b * b;
        assert!((P.0[0][0] - expected).abs() < 1e-12 * (1.0 + expected.abs()));
    }
    for a in [0.5, 0.9, 1.3, 2.5] {
        let b = 1.0 / f64::sqrt(a);
        let one = cauchy(&incompressible, diagonal(a, b, b));
        assert!((one.0[0][0] - one.0[1][1] - sum(a, b)).abs() < 1e-12 * (1.0 + sum(a, b).abs()));
        let two = cauchy(&incompressible, diagonal(a, a, 1.0 / (a * a)));
        assert!(
            (two.0[0][0] - two.0[2][2] - sum(a, 1.0 / (a * a))).abs()
                < 1e-12 * (1.0 + sum(a, 1.0 / (a * a)).abs())
        );
    }
    let w = Tensor([[1.0, 0.5], [-0.25, 0.75]]);
    let mu = TERMS.iter().map(|[mu, alpha]| 0.5 * mu * alpha).sum();
    let hooke = Material::Linear { mu, lambda: LAMBDA }.stress(&w);
    assert!(largest(1e12 * compressible.stress(&(1e-12 * w)) - hooke) < 1e-10);
    assert!(compressible.energy(&Tensor([[-1.5, 0.0], [0.0, 0.0]])).is_nan(), "no meaning at J < 0");
}

/// ∂/∂F by central differences.
fn differences<const D: usize>(at: &Tensor<f64, D>, f: impl Fn(&Tensor<f64, D>) -> f64) -> Tensor<f64, D> {
    let (mut slope, h) = (Tensor::zero(), 1e-6);
    for i in 0..D {
        for j in 0..D {
            let moved = |by: f64| {
                let mut at = *at;
                at.0[i][j] += by;
                f(&at)
            };
            slope.0[i][j] = (moved(h) - moved(-h)) / (2.0 * h);
        }
    }
    slope
}

/// Stress and tangent of fibres and of Ogden are differences of the energy and of the stress, in space, too.
#[test]
fn laws_by_number_are_derivatives_of_their_energy() {
    fn run<const D: usize>() {
        let mut random = Random(71);
        for material in ogdens().into_iter().chain(with_fibres()).chain([ISOCHORIC]) {
            for _ in 0..50 {
                let (grad_u, grad_w) = (random.tensor::<D>(0.5), random.tensor::<D>(1.0));
                let P = piola(&material, &grad_u);
                let slope = differences(&grad_u, |at| material.energy(at));
                assert!(largest(slope - P) < 1e-7 * (1.0 + largest(P)), "{material:?}: {slope:?} {P:?}");
                let dP = material.tangent(&grad_u, &grad_w);
                let power = differences(&grad_u, |at| material.stress(at).ddot(grad_w));
                // The tangent is symmetric: it is that of an energy.
                assert!(largest(power - dP) < 1e-6 * (1.0 + largest(dP)), "{material:?}: {power:?} {dP:?}");
            }
        }
    }
    run::<2>();
    run::<3>();
}

/// The pressure of the law with both apart is κ/2 (J − 1/J), whatever the shape, and its stress under a dilatation is no
/// other.
#[test]
fn change_of_volume_and_of_shape_are_apart() {
    let (mut random, bulk) = (Random(91), LAMBDA + 2.0 / 3.0 * MU);
    for _ in 0..50 {
        let grad_u = random.tensor::<3>(0.5);
        let F = Tensor::identity() + grad_u;
        let J = F.det();
        let sigma = 1.0 / J * (ISOCHORIC.stress(&grad_u) * F.t());
        let expected = 0.5 * bulk * (J - 1.0 / J);
        assert!((sigma.trace() / 3.0 - expected).abs() < 1e-12 * (1.0 + expected.abs()), "{J}");
        let dilatation = random.next() * Tensor::<f64, 3>::identity();
        let J = (Tensor::identity() + dilatation).det();
        let expected = 0.5 * bulk * (J * J - 1.0) / (1.0 + dilatation.0[0][0]) * Tensor::identity();
        assert_near(ISOCHORIC.stress(&dilatation), expected, "dilatation");
    }
}

/// Fibres that turn with the reference domain: P_φ(F) = P₀(F R) Rᵀ. Fibres that are pressed bear nothing, and with κ = ⅓
/// they have no direction.
#[test]
fn fibres_have_a_direction_and_bear_tension() {
    let mut random = Random(81);
    let (s, c) = 0.7f64.sin_cos();
    let R = Tensor([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]);
    let turned = [
        Material::Artery(Artery { angles: ARTERY.angles.map(|x| x + 0.7), ..ARTERY }),
        Material::Muscle(Muscle { direction: [0.6 * c - 0.8 * s, 0.6 * s + 0.8 * c], ..MUSCLE }),
    ];
    let matrix = Material::Artery(Artery::matrix(MU, LAMBDA, None));
    for _ in 0..50 {
        let F = Tensor::identity() + random.tensor::<3>(0.5);
        for (turned, plain) in turned.iter().zip([Material::Artery(ARTERY), Material::Muscle(MUSCLE)]) {
            let expected = plain.stress(&(F * R - Tensor::identity())) * R.t();
            assert_near(turned.stress(&(F - Tensor::identity())), expected, &format!("{plain:?}"));
        }
        let grad_u = random.tensor::<2>(0.5);
        assert_near(matrix.stress(&grad_u), NEO.stress(&grad_u), "no fibres");
        let spread = |angle: f64| Artery { dispersion: 1.0 / 3.0, angles: [angle; 2], ..ARTERY };
        let of = |angle: f64| Material::Artery(spread(angle)).stress(&grad_u);
        assert_near(of(0.2), of(1.4), "in all directions");
    }
    let along = Material::Artery(Artery { dispersion: 0.0, angles: [0.0; 2], ..ARTERY });
    let pressed = Tensor([[-0.1, 0.0], [0.0, 0.2]]);
    assert_near(along.stress(&pressed), NEO.stress(&pressed), "pressed");
    let drawn = Tensor([[0.1, 0.0], [0.0, 0.0]]);
    let extra = along.stress(&drawn) - NEO.stress(&drawn);
    let E = 1.1f64 * 1.1 - 1.0;
    // Two families: 2 k₁ E exp(k₂ E²) ∂E/∂a.
    assert!((extra.0[0][0] - 4.0 * 2.0 * E * (0.8 * E * E).exp() * 1.1).abs() < 1e-12, "{extra:?}");
}

/// A direction at the point is that of the law, to the last bit; the energies are those written out.
#[test]
fn the_direction_at_a_point_is_that_of_the_law() {
    let (mut random, f) = (Random(91), [0.28, 0.96]);
    let artery = Artery { direction: f, ..ARTERY };
    let muscle = Muscle { direction: f, ..MUSCLE };
    for _ in 0..50 {
        let (grad_u, grad_w) = (random.tensor::<2>(0.5), random.tensor::<2>(1.0));
        for (here, own) in [
            (Material::Artery(ARTERY), Material::Artery(artery)),
            (Material::Muscle(MUSCLE), Material::Muscle(muscle)),
        ] {
            let fibre = Vector(f);
            assert_eq!(here.piola_at(&fibre, &grad_u, &grad_u), own.piola(&grad_u, &grad_u));
            assert_eq!(here.derivative_at(&fibre, &grad_u, &grad_w), own.tangent(&grad_u, &grad_w));
            assert_eq!(here.energy_at(&fibre, &grad_u), own.energy(&grad_u));
        }
        let F = Tensor::identity() + grad_u;
        let (C, J) = (F.t() * F, F.det());
        let square = |a: [f64; 2], b: [f64; 2]| Vector(a).dot(C * Vector(b));
        let turned = |angle: f64| {
            let (s, c) = angle.sin_cos();
            [c * f[0] - s * f[1], s * f[0] + c * f[1]]
        };
        let first = C.trace() - 2.0;
        let mut W = 0.5 * MU * first - MU * J.ln() + 0.5 * LAMBDA * (J - 1.0).powi(2);
        for angle in ARTERY.angles {
            let a = turned(angle);
            let strain = f64::max(0.1 * first + 0.7 * (square(a, a) - 1.0), 0.0);
            W += 2.0 / 1.6 * ((0.8 * strain * strain).exp() - 1.0);
        }
        assert!((Material::Artery(artery).energy(&grad_u) - W).abs() < 1e-12 * (1.0 + W));
        let t = turned(0.5 * std::f64::consts::PI);
        let (ff, tt, ft) = (0.5 * (square(f, f) - 1.0), 0.5 * (square(t, t) - 1.0), 0.5 * square(f, t));
        let W = (1.5 * ff * ff + 0.7 * tt * tt + 2.2 * ft * ft).exp() - 1.0;
        assert!((Material::Muscle(muscle).energy(&grad_u) - W).abs() < 1e-12 * (1.0 + W));
    }
}
