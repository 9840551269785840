//! Stabilisation of equal-order pairs and of transport, mapped to the reference domain, section 5.3.3.
//!
//! All terms are taken at U_θ = (1 − θ) U⁻ + θ U, where the pressure of the step lives, so that they are of
//! second order in time and have no explicit part. Their parameters come from the old step and are frozen:
//! Newton's method stays exact.

use super::kinematics::Kinematics;
use super::{Fields, Fluid, StepRule};
use crate::choice::{Choice, choice};
use crate::math::{Scalar, Tensor, Vector};

/// Terms in the divergence equation, which equal-order pairs need for (5.24).
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum PressureTerm {
    /// None.
    None,
    /// (α J F⁻¹F⁻ᵀ ∇p, ∇ξ), (5.28): Brezzi and Pitkäranta 1984.
    BrezziPitkaranta,
    /// (α J F⁻¹F⁻ᵀ ∇(p − πp), ∇(ξ − πξ)): Becker and Braack 2001.
    LocalProjection,
    /// (α R, F⁻ᵀ∇ξ) with the strong residual R of the momentum equation: Hughes, Franca and Balestra 1986.
    Pspg,
}

/// Their names in a case.
pub static PRESSURE_TERMS: [Choice<PressureTerm>; 4] = [
    choice("off", PressureTerm::None, "no term"),
    choice("brezzi-pitkaranta", PressureTerm::BrezziPitkaranta, "gradient of the pressure (5.28)"),
    choice(
        "lps",
        PressureTerm::LocalProjection,
        "local projection: gradient of what a projection removes from the pressure",
    ),
    choice("pspg", PressureTerm::Pspg, "residual of the momentum equation, tested with the gradient of ξ"),
];

/// Terms in the momentum equation against oscillations by transport with w = v − ∂_t u.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum TransportTerm {
    /// None.
    None,
    /// (ρ J δ ∇(v − πv) F⁻¹w, ∇(φ − πφ) F⁻¹w): Becker and Braack 2004.
    LocalProjection,
    /// (δ R, ∇φ F⁻¹w): Brooks and Hughes 1982.
    Supg,
}

/// Their names in a case.
pub static TRANSPORT_TERMS: [Choice<TransportTerm>; 3] = [
    choice("off", TransportTerm::None, "no term"),
    choice("lps", TransportTerm::LocalProjection, "local projection of the derivative along the flow"),
    choice(
        "supg",
        TransportTerm::Supg,
        "residual of the momentum equation, tested along the flow (streamline upwind)",
    ),
];

/// Where π projects to.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Projection {
    /// The next lower degree, cell by cell.
    Cell,
    /// The same degree on the coarser mesh, patch by patch.
    Patch,
}

/// Their names in a case.
pub static PROJECTIONS: [Choice<Projection>; 2] = [
    choice("cell", Projection::Cell, "to the next lower degree on each cell"),
    choice("patch", Projection::Patch, "to the same degree on the mesh before the last refinement"),
];

/// How the terms are carried from the moved domain to the reference domain, Remark 5.13.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Mapping {
    /// Not at all: the terms of a domain that does not move, F = I and J = 1 but for ∂_t u in w. For small
    /// deformations.
    None,
    /// Not at all, with parameters of the present size h = J^(1/D) ĥ, (5.32). For isotropic deformations.
    Size,
    /// With F, J and h = J^(1/D) ĥ: the terms of the moved domain.
    Full,
}

/// Their names in a case.
pub static MAPPINGS: [Choice<Mapping>; 3] = [
    choice("none", Mapping::None, "F = I and J = 1 in the terms, sizes of the reference cells"),
    choice(
        "size",
        Mapping::Size,
        "F = I and J = 1 in the terms, sizes of the moved cells, h = J^(1/d) ĥ (5.32)",
    ),
    choice("full", Mapping::Full, "terms and sizes of the moved cells"),
];

/// What is added to the equations of the fluid, and how much of it.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Stabilization {
    /// In the divergence equation.
    pub pressure: PressureTerm,
    /// In the momentum equation.
    pub transport: TransportTerm,
    /// α_0.
    pub alpha: f64,
    /// δ_0.
    pub delta: f64,
    /// π of local projections.
    pub projection: Projection,
    /// Separate the axes of each cell, Remark 5.13.
    pub directional: bool,
    /// How the terms are carried to the reference domain.
    pub map: Mapping,
}

impl Stabilization {
    /// No term at all.
    pub const NONE: Stabilization = Stabilization {
        pressure: PressureTerm::None,
        transport: TransportTerm::None,
        alpha: 0.1,
        delta: 0.1,
        projection: Projection::Cell,
        directional: false,
        map: Mapping::Full,
    };

    /// Whether there is any term.
    pub fn acts(&self) -> bool {
        self.pressure != PressureTerm::None || self.transport != TransportTerm::None
    }

    /// Whether the strong residual is needed, and with it second derivatives.
    pub fn has_residual(&self) -> bool {
        self.pressure == PressureTerm::Pspg || self.transport == TransportTerm::Supg
    }

    /// Whether there is a local projection.
    pub fn projects(&self) -> bool {
        self.pressure == PressureTerm::LocalProjection || self.transport == TransportTerm::LocalProjection
    }
}

/// What the terms see at a point: fields with more derivatives than the equations need.
#[derive(Copy, Clone, Debug)]
pub struct FineFields<T, const D: usize> {
    /// v, ∇v, u, ∇u; p is not used.
    pub at: Fields<T, D>,
    /// ∇p \[Pa/m\].
    pub grad_p: Vector<T, D>,
    /// ∇(p − πp) \[Pa/m\].
    pub fine_p: Vector<T, D>,
    /// ∇(v − πv) \[1/s\].
    pub fine_v: Tensor<T, D>,
    /// Second derivatives of each component of v \[1/(m s)\].
    pub hess_v: [Tensor<T, D>; D],
    /// Second derivatives of each component of u \[1/m\].
    pub hess_u: [Tensor<T, D>; D],
}

impl<T: Scalar, const D: usize> FineFields<T, D> {
    /// All zero.
    #[inline(always)]
    pub fn zero() -> Self {
        FineFields {
            at: Fields::zero(),
            grad_p: Vector::zero(),
            fine_p: Vector::zero(),
            fine_v: Tensor::zero(),
            hess_v: [Tensor::zero(); D],
            hess_u: [Tensor::zero(); D],
        }
    }

    /// `f` of each component of `self` and `other`.
    #[inline(always)]
    pub fn zip<O: Scalar, U: Scalar>(
        &self,
        other: &FineFields<O, D>,
        f: impl Fn(T, O) -> U + Copy,
    ) -> FineFields<U, D> {
        let mut r = FineFields::zero();
        let vector = |a: Vector<T, D>, b: Vector<O, D>, r: &mut Vector<U, D>| {
            for i in 0..D {
                r.0[i] = f(a.0[i], b.0[i]);
            }
        };
        let tensor = |a: Tensor<T, D>, b: Tensor<O, D>, r: &mut Tensor<U, D>| {
            for i in 0..D {
                for j in 0..D {
                    r.0[i][j] = f(a.0[i][j], b.0[i][j]);
                }
            }
        };
        vector(self.at.v, other.at.v, &mut r.at.v);
        vector(self.at.u, other.at.u, &mut r.at.u);
        vector(self.grad_p, other.grad_p, &mut r.grad_p);
        vector(self.fine_p, other.fine_p, &mut r.fine_p);
        tensor(self.at.grad_v, other.at.grad_v, &mut r.at.grad_v);
        tensor(self.at.grad_u, other.at.grad_u, &mut r.at.grad_u);
        tensor(self.fine_v, other.fine_v, &mut r.fine_v);
        for i in 0..D {
            tensor(self.hess_v[i], other.hess_v[i], &mut r.hess_v[i]);
            tensor(self.hess_u[i], other.hess_u[i], &mut r.hess_u[i]);
        }
        r
    }
}

/// What stands before the gradients of the test functions: (phi, ∇φ) + (xi, ∇ξ), or those of φ − πφ and ξ − πξ
/// for local projections.
#[derive(Copy, Clone, Debug)]
pub struct FineTested<T, const D: usize> {
    /// Before ∇φ \[N/m²\].
    pub phi: Tensor<T, D>,
    /// Before ∇ξ \[m/s\].
    pub xi: Vector<T, D>,
}

/// Frozen parameters of a cell, and the body force.
#[derive(Copy, Clone, Debug)]
pub struct Parameters<S, const D: usize> {
    /// α \[m³ s/kg\].
    pub alpha: S,
    /// δ \[s\].
    pub delta: S,
    /// Σ α_i ĥ_i ĥ_iᵀ with the axes ĥ_i of the cell \[m⁵ s/kg\], with [`Mapping::Size`] J^(2/D) times that; zero unless
    /// directional.
    pub axes: Tensor<S, D>,
    /// Body force per mass at t⁻ + θ k \[m/s²\].
    pub force: Vector<S, D>,
}

/// The old state of a cell, from which its parameters follow.
#[derive(Copy, Clone, Debug)]
pub struct CellState {
    /// ĥ = |K̂|^(1/D) \[m\].
    pub size: f64,
    /// Mean of J; 1 if sizes are those of the reference cells.
    pub j: f64,
    /// ‖v‖_{L∞(K)} \[m/s\].
    pub speed: f64,
}

impl Stabilization {
    /// α = (α_0/ρ) (6 ν/h² + ‖v‖/h)⁻¹ with the present size h = J^(1/D) ĥ.
    ///
    /// Errata: (5.28) prints the inverse of the bracket and no density; its ALE form has J^(2/D) and J^(1/D) for
    /// J^(−2/D) and J^(−1/D), and an L² norm. Test `parameters_are_those_of_the_moved_cell`.
    pub fn alpha<const D: usize>(&self, fluid: &Fluid, cell: &CellState) -> f64 {
        let h = cell.size * cell.j.max(0.0).powf(1.0 / D as f64);
        self.alpha / fluid.rho / (6.0 * fluid.nu / (h * h) + cell.speed / h)
    }

    /// δ = δ_0 (6 ν/h² + ‖v‖/h + 1/k)⁻¹; that ‖v‖ and not ‖w‖ enters makes δ a function of the old state alone.
    pub fn delta<const D: usize>(&self, fluid: &Fluid, per_k: f64, cell: &CellState) -> f64 {
        let h = cell.size * cell.j.max(0.0).powf(1.0 / D as f64);
        self.delta / (6.0 * fluid.nu / (h * h) + cell.speed / h + per_k)
    }

    /// α_i = (α_0/ρ) (6 ν + ‖v‖ h_i)⁻¹ for an axis of present length h_i: what stands before (h_i · ∇p)² where
    /// isotropic cells have α = α_i h².
    pub fn axis_alpha(&self, fluid: &Fluid, speed: f64, length: f64) -> f64 {
        self.alpha / fluid.rho / (6.0 * fluid.nu + speed * length)
    }

    /// All terms at a point.
    #[inline(always)]
    pub fn terms<T: Scalar, const D: usize>(
        &self,
        fluid: &Fluid,
        rule: &StepRule,
        with: &Parameters<T::Value, D>,
        new: &FineFields<T, D>,
        old: &FineFields<T::Value, D>,
    ) -> FineTested<T, D> {
        let theta = rule.theta;
        let mut at = new.zip(old, |a, b| a * theta + T::lift(b) * (1.0 - theta));
        if self.map != Mapping::Full {
            (at.at.grad_u, at.hess_u) = (Tensor::zero(), [Tensor::zero(); D]);
        }
        let dv_dt = (new.at.v - old.at.v.map(T::lift)) * T::constant(rule.per_k);
        let du_dt = (new.at.u - old.at.u.map(T::lift)) * T::constant(rule.per_k);
        let kinematics = Kinematics::of(&at.at.grad_u);
        let Kinematics { F, F_inv, J } = kinematics;
        let w = F_inv * (at.at.v - du_dt);
        let residual = if self.has_residual() {
            let force = with.force.map(T::lift);
            let rate = dv_dt + at.at.grad_v * w - force;
            (fluid.rho * rate - friction(fluid, &at, &kinematics)) * J + F_inv.t() * new.grad_p * J
        } else {
            Vector::zero()
        };
        let mut r = FineTested { phi: Tensor::zero(), xi: Vector::zero() };
        if self.pressure != PressureTerm::None {
            let flux = match self.pressure {
                PressureTerm::Pspg => residual,
                PressureTerm::LocalProjection => F_inv.t() * new.fine_p * J,
                _ => F_inv.t() * new.grad_p * J,
            };
            r.xi = if self.directional {
                // With the axes F ĥ_i of the moved cell: F ĥ_i · F⁻ᵀ∇ξ = ĥ_i · ∇ξ.
                with.axes.map(T::lift) * (F.t() * flux)
            } else {
                F_inv * flux * T::lift(with.alpha)
            };
        }
        let delta = T::lift(with.delta);
        match self.transport {
            TransportTerm::None => {}
            TransportTerm::LocalProjection => {
                r.phi = outer(fluid.rho * (at.fine_v * w) * (J * delta), w);
            }
            TransportTerm::Supg => r.phi = outer(residual * delta, w),
        }
        r
    }
}

/// div σ of the moved domain: ρν Σ_k ∂_{x_k} (G_ik + G_ki) with G = ∇v F⁻¹.
#[inline(always)]
fn friction<T: Scalar, const D: usize>(
    fluid: &Fluid,
    at: &FineFields<T, D>,
    kinematics: &Kinematics<T, D>,
) -> Vector<T, D> {
    let F_inv = kinematics.F_inv;
    let G = at.at.grad_v * F_inv;
    let mut sum = Vector::zero();
    for m in 0..D {
        // ∂G/∂X_m = (∂∇v/∂X_m − G ∂F/∂X_m) F⁻¹.
        let (mut dv, mut dF) = (Tensor::zero(), Tensor::zero());
        for i in 0..D {
            for j in 0..D {
                dv.0[i][j] = at.hess_v[i].0[j][m];
                dF.0[i][j] = at.hess_u[i].0[j][m];
            }
        }
        let dG = (dv - G * dF) * F_inv;
        for i in 0..D {
            for k in 0..D {
                sum.0[i] += (dG.0[i][k] + dG.0[k][i]) * F_inv.0[m][k];
            }
        }
    }
    fluid.rho * fluid.nu * sum
}

/// a bᵀ.
#[inline(always)]
fn outer<T: Scalar, const D: usize>(a: Vector<T, D>, b: Vector<T, D>) -> Tensor<T, D> {
    let mut r = Tensor::zero();
    for i in 0..D {
        for j in 0..D {
            r.0[i][j] = a.0[i] * b.0[j];
        }
    }
    r
}
