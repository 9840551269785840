//! The error function.

use std::f64::consts::PI;

/// erf(x) = 2/√π ∫₀ˣ exp(−s²) ds, to rounding: by its series exp(−x²) Σ 2ⁿ x²ⁿ⁺¹/(1·3·…·(2n+1)), whose terms have
/// one sign.
///
/// ```
/// use undula::math::erf;
/// assert!((erf(0.5) - 0.5204998778130465).abs() < 1e-15);
/// assert!((erf(-2.0) + 0.9953222650189527).abs() < 1e-15);
/// assert_eq!((erf(0.0), erf(7.0)), (0.0, 1.0));
/// ```
pub fn erf(x: f64) -> f64 {
    // 1 − erf(6) = 2e-17.
    if x.abs() > 6.0 {
        return x.signum();
    }
    let (mut term, mut sum, mut odd) = (x, x, 1.0);
    while term.abs() > 1e-17 * sum.abs() {
        odd += 2.0;
        term *= 2.0 * x * x / odd;
        sum += term;
    }
    2.0 / PI.sqrt() * (-x * x).exp() * sum
}
