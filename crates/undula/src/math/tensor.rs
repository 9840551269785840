//! Vectors and second-order tensors of a fixed space dimension `D`.
//!
//! Reading rule: parameters (`f64`) stand left of a tensor, field scalars (`T`) right of it:
//! `rho * (grad_v * v) * J`.

use super::Scalar;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// `a[i]`, shape `(D)`.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Vector<T, const D: usize>(pub [T; D]);

/// `A[i][j]`, shape `(D, D)`; a gradient is `∂v_i/∂x_j`.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Tensor<T, const D: usize>(pub [[T; D]; D]);

impl<T: Scalar, const D: usize> Vector<T, D> {
    /// The zero vector.
    #[inline(always)]
    pub fn zero() -> Self {
        Vector([T::zero(); D])
    }

    /// `f` of each component.
    #[inline(always)]
    pub fn map<U: Scalar>(self, f: impl Fn(T) -> U) -> Vector<U, D> {
        let mut r = Vector::zero();
        for i in 0..D {
            r.0[i] = f(self.0[i]);
        }
        r
    }

    /// `a · b`.
    #[inline(always)]
    pub fn dot(self, other: Self) -> T {
        let mut s = self.0[0] * other.0[0];
        for i in 1..D {
            s += self.0[i] * other.0[i];
        }
        s
    }
}

impl<T: Scalar, const D: usize> Tensor<T, D> {
    /// The zero tensor.
    #[inline(always)]
    pub fn zero() -> Self {
        Tensor([[T::zero(); D]; D])
    }

    /// `I`.
    #[inline(always)]
    pub fn identity() -> Self {
        let mut r = Self::zero();
        for i in 0..D {
            r.0[i][i] = T::one();
        }
        r
    }

    /// `f` of each component.
    #[inline(always)]
    pub fn map<U: Scalar>(self, f: impl Fn(T) -> U) -> Tensor<U, D> {
        let mut r = Tensor::zero();
        for i in 0..D {
            for j in 0..D {
                r.0[i][j] = f(self.0[i][j]);
            }
        }
        r
    }

    /// `Aᵀ`.
    #[inline(always)]
    pub fn t(self) -> Self {
        let mut r = self;
        for i in 0..D {
            for j in 0..D {
                r.0[i][j] = self.0[j][i];
            }
        }
        r
    }

    /// `tr A`.
    #[inline(always)]
    pub fn trace(self) -> T {
        let mut s = self.0[0][0];
        for i in 1..D {
            s += self.0[i][i];
        }
        s
    }

    /// `A : B = Σ A_ij B_ij`.
    #[inline(always)]
    pub fn ddot(self, other: Self) -> T {
        let mut s = T::zero();
        for i in 0..D {
            for j in 0..D {
                s += self.0[i][j] * other.0[i][j];
            }
        }
        s
    }

    /// `det A`, for `D` = 1, 2, 3.
    #[inline(always)]
    pub fn det(self) -> T {
        let a = &self.0;
        match D {
            1 => a[0][0],
            2 => a[0][0] * a[1][1] - a[0][1] * a[1][0],
            _ => {
                a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1])
                    - a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0])
                    + a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0])
            }
        }
    }

    /// `cof A = det(A) A⁻ᵀ`, for `D` = 1, 2, 3.
    #[inline(always)]
    pub fn cofactor(self) -> Self {
        let a = &self.0;
        let mut c = Self::zero();
        match D {
            1 => c.0[0][0] = T::one(),
            2 => {
                c.0[0][0] = a[1][1];
                c.0[0][1] = -a[1][0];
                c.0[1][0] = -a[0][1];
                c.0[1][1] = a[0][0];
            }
            _ => {
                for i in 0..D {
                    for j in 0..D {
                        let (i1, i2, j1, j2) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
                        c.0[i][j] = a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1];
                    }
                }
            }
        }
        c
    }
}

macro_rules! linear_operators {
    ($type:ident) => {
        impl<T: Scalar, const D: usize> Add for $type<T, D> {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                let mut r = self;
                r += other;
                r
            }
        }
        impl<T: Scalar, const D: usize> Sub for $type<T, D> {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                let mut r = self;
                r -= other;
                r
            }
        }
        impl<T: Scalar, const D: usize> Neg for $type<T, D> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                self.map(|a| -a)
            }
        }
        impl<T: Scalar, const D: usize> Mul<T> for $type<T, D> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, s: T) -> Self {
                self.map(|a| a * s)
            }
        }
        impl<T: Scalar, const D: usize> Mul<$type<T, D>> for f64 {
            type Output = $type<T, D>;
            #[inline(always)]
            fn mul(self, a: $type<T, D>) -> $type<T, D> {
                a.map(|x| x * self)
            }
        }
    };
}
linear_operators!(Vector);
linear_operators!(Tensor);

impl<T: Scalar, const D: usize> AddAssign for Vector<T, D> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        for i in 0..D {
            self.0[i] += other.0[i];
        }
    }
}

impl<T: Scalar, const D: usize> SubAssign for Vector<T, D> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        for i in 0..D {
            self.0[i] -= other.0[i];
        }
    }
}

impl<T: Scalar, const D: usize> AddAssign for Tensor<T, D> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        for i in 0..D {
            for j in 0..D {
                self.0[i][j] += other.0[i][j];
            }
        }
    }
}

impl<T: Scalar, const D: usize> SubAssign for Tensor<T, D> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        for i in 0..D {
            for j in 0..D {
                self.0[i][j] -= other.0[i][j];
            }
        }
    }
}

impl<T: Scalar, const D: usize> Mul for Tensor<T, D> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let mut r = self;
        for i in 0..D {
            for j in 0..D {
                let mut s = self.0[i][0] * other.0[0][j];
                for k in 1..D {
                    s += self.0[i][k] * other.0[k][j];
                }
                r.0[i][j] = s;
            }
        }
        r
    }
}

impl<T: Scalar, const D: usize> Mul<Vector<T, D>> for Tensor<T, D> {
    type Output = Vector<T, D>;
    #[inline(always)]
    fn mul(self, other: Vector<T, D>) -> Vector<T, D> {
        let mut r = other;
        for i in 0..D {
            let mut s = self.0[i][0] * other.0[0];
            for k in 1..D {
                s += self.0[i][k] * other.0[k];
            }
            r.0[i] = s;
        }
        r
    }
}
