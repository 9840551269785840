//! What a form sees at a point, and what it returns.

use crate::math::{Scalar, Tensor, Vector};

/// `U = {v, u, p}` at a point: values and gradients on the reference domain.
#[derive(Copy, Clone, Debug)]
pub struct Fields<T, const D: usize> {
    /// Velocity \[m/s\].
    pub v: Vector<T, D>,
    /// ∇v, `(∇v)_ij = ∂v_i/∂x_j` \[1/s\].
    pub grad_v: Tensor<T, D>,
    /// Deformation \[m\].
    pub u: Vector<T, D>,
    /// ∇u \[1\].
    pub grad_u: Tensor<T, D>,
    /// Pressure \[Pa\].
    pub p: T,
}

/// What stands before each test function: `(phi, φ) + (grad_phi, ∇φ) + (psi, ψ) + (grad_psi, ∇ψ) + (xi, ξ)`.
#[derive(Copy, Clone, Debug)]
pub struct Tested<T, const D: usize> {
    /// Before φ \[N/m³\].
    pub phi: Vector<T, D>,
    /// Before ∇φ \[N/m²\].
    pub grad_phi: Tensor<T, D>,
    /// Before ψ.
    pub psi: Vector<T, D>,
    /// Before ∇ψ.
    pub grad_psi: Tensor<T, D>,
    /// Before ξ \[1/s\].
    pub xi: T,
}

/// Time derivatives at a point.
#[derive(Copy, Clone, Debug)]
pub struct Dots<T, const D: usize> {
    /// ∂_t v \[m/s²\].
    pub v: Vector<T, D>,
    /// ∂_t u \[m/s\].
    pub u: Vector<T, D>,
    /// ∂_t u of the domain-motion term \[m/s\]: the same, but in a fixed-point iteration that of the last
    /// iterate.
    pub domain: Vector<T, D>,
}

/// What the point knows besides the fields. The reference domain never moves, so most of it is
/// computed once per run.
#[derive(Copy, Clone, Debug)]
pub struct Place<S, const D: usize> {
    /// Body force per mass \[m/s²\].
    pub force: Vector<S, D>,
    /// ∇f, `(∇f)_ij = ∂f_i/∂x_j`, where f is taken at the current position x + u; else 0 \[1/s²\].
    pub force_slope: Tensor<S, D>,
    /// Stiffness E_e(x) of the extension.
    pub stiffness: S,
    /// What a solid has there.
    pub fabric: Fabric<S, D>,
    /// 1/r \[1/m\], r being the distance to the axis of a body of revolution; 0 where there is none.
    pub per_radius: S,
}

/// What a solid has at a place from the start.
#[derive(Copy, Clone, Debug)]
pub struct Fabric<S, const D: usize> {
    /// Direction of the fibres, a unit vector; 0: that of the law.
    pub fibre: Vector<S, D>,
    /// ∇U, where x + U(x) is the position without stress of what is at x; 0 where the reference domain is free of
    /// stress.
    pub unloading: Tensor<S, D>,
    /// U_r/r around an axis, else 0.
    pub hoop: S,
}

impl<S: Scalar, const D: usize> Fabric<S, D> {
    /// No direction, no stress.
    #[inline(always)]
    pub fn plain() -> Self {
        Fabric { fibre: Vector::zero(), unloading: Tensor::zero(), hoop: S::zero() }
    }

    /// `f` of each component.
    #[inline(always)]
    pub fn map<U: Scalar>(&self, f: impl Fn(S) -> U + Copy) -> Fabric<U, D> {
        Fabric { fibre: self.fibre.map(f), unloading: self.unloading.map(f), hoop: f(self.hoop) }
    }
}

impl<S: Scalar, const D: usize> Place<S, D> {
    /// f and its derivative ∇f w, w the direction of the deformation `u`.
    #[inline(always)]
    pub fn force_at<T: Scalar<Value = S>>(&self, u: &Vector<T, D>) -> Vector<T, D> {
        // A loop: std::array::from_fn is not always inlined.
        let mut f = Vector::zero();
        for i in 0..D {
            f.0[i] = T::with_slope(self.force.0[i], &self.force_slope.0[i], &u.0);
        }
        f
    }

    /// No force, unit stiffness.
    pub fn plain() -> Self {
        Place {
            force: Vector::zero(),
            force_slope: Tensor::zero(),
            stiffness: S::one(),
            fabric: Fabric::plain(),
            per_radius: S::zero(),
        }
    }

    /// `f` of each component.
    #[inline(always)]
    pub fn map<U: Scalar>(&self, f: impl Fn(S) -> U + Copy) -> Place<U, D> {
        Place {
            force: self.force.map(f),
            force_slope: self.force_slope.map(f),
            stiffness: f(self.stiffness),
            fabric: self.fabric.map(f),
            per_radius: f(self.per_radius),
        }
    }
}

impl<T: Scalar, const D: usize> Fields<T, D> {
    /// Number of scalar components: v, ∇v, u, ∇u, p.
    pub const COMPONENTS: usize = 2 * (D + D * D) + 1;

    /// All zero.
    #[inline(always)]
    pub fn zero() -> Self {
        Fields {
            v: Vector::zero(),
            grad_v: Tensor::zero(),
            u: Vector::zero(),
            grad_u: Tensor::zero(),
            p: T::zero(),
        }
    }

    /// `f` of each component.
    #[inline(always)]
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U + Copy) -> Fields<U, D> {
        Fields {
            v: self.v.map(f),
            grad_v: self.grad_v.map(f),
            u: self.u.map(f),
            grad_u: self.grad_u.map(f),
            p: f(self.p),
        }
    }

    /// The same values without derivatives: what a fixed-point iteration keeps from before.
    #[inline(always)]
    pub fn frozen(&self) -> Self {
        self.map(T::frozen)
    }

    /// Values that do not depend on the unknowns.
    #[inline(always)]
    pub fn lift(values: &Fields<T::Value, D>) -> Self {
        values.map(T::lift)
    }

    /// `(1 − τ) self + τ other`.
    #[inline(always)]
    pub fn lerp(&self, other: &Self, tau: f64) -> Self {
        let (a, b) = (1.0 - tau, tau);
        Fields {
            v: a * self.v + b * other.v,
            grad_v: a * self.grad_v + b * other.grad_v,
            u: a * self.u + b * other.u,
            grad_u: a * self.grad_u + b * other.grad_u,
            p: self.p * a + other.p * b,
        }
    }

    /// The `n`-th component in the order v, ∇v, u, ∇u, p.
    #[inline(always)]
    pub fn component(&mut self, n: usize) -> &mut T {
        let (d, dd) = (D, D * D);
        if n < d {
            &mut self.v.0[n]
        } else if n < d + dd {
            &mut self.grad_v.0[(n - d) / d][(n - d) % d]
        } else if n < 2 * d + dd {
            &mut self.u.0[n - d - dd]
        } else if n < 2 * (d + dd) {
            let m = n - 2 * d - dd;
            &mut self.grad_u.0[m / d][m % d]
        } else {
            &mut self.p
        }
    }
}

impl<T: Scalar, const D: usize> Tested<T, D> {
    /// All zero.
    #[inline(always)]
    pub fn zero() -> Self {
        Tested {
            phi: Vector::zero(),
            grad_phi: Tensor::zero(),
            psi: Vector::zero(),
            grad_psi: Tensor::zero(),
            xi: T::zero(),
        }
    }

    /// `f` of each component.
    #[inline(always)]
    pub fn map<U: Scalar>(&self, f: impl Fn(T) -> U + Copy) -> Tested<U, D> {
        Tested {
            phi: self.phi.map(f),
            grad_phi: self.grad_phi.map(f),
            psi: self.psi.map(f),
            grad_psi: self.grad_psi.map(f),
            xi: f(self.xi),
        }
    }

    /// All components in the order phi, grad_phi, psi, grad_psi, xi.
    pub fn to_vec(&self) -> Vec<T> {
        let mut list = self.phi.0.to_vec();
        list.extend(self.grad_phi.0.iter().flatten());
        list.extend(self.psi.0);
        list.extend(self.grad_psi.0.iter().flatten());
        list.push(self.xi);
        list
    }
}
