//! The number that factors are made of: double or single precision.

use faer::traits::RealField;
use pulp::Simd;
use std::fmt::Debug;

/// `f64` or `f32`, alone and in vectors.
pub trait Real: RealField + Copy + Default + Debug + Send + Sync + 'static {
    /// Name of the solver with such factors.
    const NAME: &'static str;
    /// Relative error of one rounding.
    const ROUNDOFF: f64;
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Entries of the factors below this are zero, for matrices whose entries are about one; then no
    /// product of two is subnormal, which processors are slow at: six times for the matrix of an
    /// implicit step in single precision, whose inverse decays. Zero where nothing gets that small.
    const TINY: f64;
    /// Several numbers in one register.
    type Vector<S: Simd>: Copy;

    /// Rounds.
    fn of(x: f64) -> Self;
    /// The same number in double precision.
    fn double(self) -> f64;
    /// |x|.
    fn size(self) -> Self;
    /// Whether it is neither infinite nor not a number.
    fn finite(self) -> bool;

    /// Numbers in a vector.
    fn lanes<S: Simd>() -> usize;
    /// Whole vectors and the rest.
    fn vectors<S: Simd>(x: &[Self]) -> (&[Self::Vector<S>], &[Self]);
    /// Whole vectors and the rest.
    fn vectors_mut<S: Simd>(x: &mut [Self]) -> (&mut [Self::Vector<S>], &mut [Self]);
    /// One number in all lanes.
    fn splat<S: Simd>(simd: S, x: Self) -> Self::Vector<S>;
    /// a b + c.
    fn mul_add<S: Simd>(
        simd: S,
        a: Self::Vector<S>,
        b: Self::Vector<S>,
        c: Self::Vector<S>,
    ) -> Self::Vector<S>;
    /// a − b.
    fn subtract<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// The larger of |a| and b.
    fn larger<S: Simd>(simd: S, a: Self::Vector<S>, b: Self::Vector<S>) -> Self::Vector<S>;
    /// Less than a vector, zeros behind.
    fn load<S: Simd>(simd: S, x: &[Self]) -> Self::Vector<S>;
    /// The first lanes.
    fn store<S: Simd>(simd: S, x: &mut [Self], value: Self::Vector<S>);
    /// Sum of the lanes.
    fn sum<S: Simd>(simd: S, a: Self::Vector<S>) -> Self;
    /// Largest of the lanes.
    fn max<S: Simd>(simd: S, a: Self::Vector<S>) -> Self;
}

macro_rules! real {
    ($T:ident, $name:literal, $tiny:expr, $Vector:ident, $lanes:ident, $vectors:ident, $vectors_mut:ident, $splat:ident,
     $mul_add:ident, $sub:ident, $abs:ident, $larger:ident, $load:ident, $store:ident, $sum:ident, $max:ident) => {
        impl Real for $T {
            const NAME: &'static str = $name;
            const ROUNDOFF: f64 = 0.5 * $T::EPSILON as f64;
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const TINY: f64 = $tiny;
            type Vector<S: Simd> = S::$Vector;

            #[inline(always)]
            fn of(x: f64) -> Self {
                x as $T
            }
            #[inline(always)]
            fn double(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn size(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn finite(self) -> bool {
                self.is_finite()
            }

            #[inline(always)]
            fn lanes<S: Simd>() -> usize {
                S::$lanes
            }
            #[inline(always)]
            fn vectors<S: Simd>(x: &[Self]) -> (&[S::$Vector], &[Self]) {
                S::$vectors(x)
            }
            #[inline(always)]
            fn vectors_mut<S: Simd>(x: &mut [Self]) -> (&mut [S::$Vector], &mut [Self]) {
                S::$vectors_mut(x)
            }
            #[inline(always)]
            fn splat<S: Simd>(simd: S, x: Self) -> S::$Vector {
                simd.$splat(x)
            }
            #[inline(always)]
            fn mul_add<S: Simd>(simd: S, a: S::$Vector, b: S::$Vector, c: S::$Vector) -> S::$Vector {
                simd.$mul_add(a, b, c)
            }
            #[inline(always)]
            fn subtract<S: Simd>(simd: S, a: S::$Vector, b: S::$Vector) -> S::$Vector {
                simd.$sub(a, b)
            }
            #[inline(always)]
            fn larger<S: Simd>(simd: S, a: S::$Vector, b: S::$Vector) -> S::$Vector {
                simd.$larger(simd.$abs(a), b)
            }
            #[inline(always)]
            fn load<S: Simd>(simd: S, x: &[Self]) -> S::$Vector {
                simd.$load(x)
            }
            #[inline(always)]
            fn store<S: Simd>(simd: S, x: &mut [Self], value: S::$Vector) {
                simd.$store(x, value);
            }
            #[inline(always)]
            fn sum<S: Simd>(simd: S, a: S::$Vector) -> Self {
                simd.$sum(a)
            }
            #[inline(always)]
            fn max<S: Simd>(simd: S, a: S::$Vector) -> Self {
                simd.$max(a)
            }
        }
    };
}

real!(
    f64,
    "multifrontal",
    0.0,
    f64s,
    F64_LANES,
    as_simd_f64s,
    as_mut_simd_f64s,
    splat_f64s,
    mul_add_f64s,
    sub_f64s,
    abs_f64s,
    max_f64s,
    partial_load_f64s,
    partial_store_f64s,
    reduce_sum_f64s,
    reduce_max_f64s
);
real!(
    f32,
    "multifrontal-single",
    // 2⁻⁶⁰
    8.673617379884035e-19,
    f32s,
    F32_LANES,
    as_simd_f32s,
    as_mut_simd_f32s,
    splat_f32s,
    mul_add_f32s,
    sub_f32s,
    abs_f32s,
    max_f32s,
    partial_load_f32s,
    partial_store_f32s,
    reduce_sum_f32s,
    reduce_max_f32s
);
