//! Runge-Kutta methods as tables.

/// A singly diagonally implicit method that ends with its last stage: the solution of a step is that of this stage,
/// and so is its derivative, which the next step begins with.
///
/// Stage i solves the equations at t⁻ + cᵢ k for w = h + γ k ẇ with h = w⁻ + k Σ aᵢⱼ ẇⱼ, j < i. Stage 0 is explicit: it
/// stands for the derivative at t⁻.
#[derive(Debug, PartialEq)]
pub struct Tableau {
    /// γ, the diagonal.
    pub gamma: f64,
    /// cᵢ.
    pub c: &'static [f64],
    /// aᵢⱼ, j < i, row by row; the first row is empty. A method that does not take the derivative at t⁻ has 0 for j = 0.
    pub a: &'static [&'static [f64]],
    /// bⱼ − b̂ⱼ of an embedded method of the order below; none if it has none.
    pub error: &'static [f64],
}

/// √2.
const R: f64 = std::f64::consts::SQRT_2;

/// ESDIRK3(2)5L\[2\]SA of Kennedy and Carpenter (2016): order 3, L-stable, stages of order 2, γ = 9/40.
pub static ESDIRK3: Tableau = Tableau {
    gamma: 9.0 / 40.0,
    c: &[0.0, 9.0 / 20.0, 9.0 * (2.0 + R) / 40.0, 0.6, 1.0],
    a: &[
        &[],
        &[9.0 / 40.0],
        &[9.0 * (1.0 + R) / 80.0, 9.0 * (1.0 + R) / 80.0],
        &[
            (22.0 + 15.0 * R) / (80.0 * (1.0 + R)),
            (22.0 + 15.0 * R) / (80.0 * (1.0 + R)),
            -7.0 / (40.0 * (1.0 + R)),
        ],
        &[B3[0], B3[0], B3[1], B3[2]],
    ],
    error: &[
        B3[0] - 4_555_948_517_383.0 / 24_713_416_420_891.0,
        B3[0] - 4_555_948_517_383.0 / 24_713_416_420_891.0,
        B3[1] + 7_107_561_914_881.0 / 25_547_637_784_726.0,
        B3[2] - 30_698_249.0 / 44_052_120.0,
        9.0 / 40.0 - 49_563.0 / 233_080.0,
    ],
};

/// b₀ = b₁, b₂ and b₃ of [`ESDIRK3`].
const B3: [f64; 3] = [
    (2398.0 + 1205.0 * R) / (2835.0 * (4.0 + 3.0 * R)),
    -2374.0 * (1.0 + 2.0 * R) / (2835.0 * (5.0 + 3.0 * R)),
    5827.0 / 7560.0,
];

/// ESDIRK4(3)6L\[2\]SA of Kennedy and Carpenter (2003): order 4, L-stable, stages of order 2, γ = 1/4.
pub static ESDIRK4: Tableau = Tableau {
    gamma: 0.25,
    c: &[0.0, 0.5, 0.332, 0.62, 0.85, 1.0],
    a: &[
        &[],
        &[0.25],
        &[8611.0 / 62_500.0, -1743.0 / 31_250.0],
        &[5_012_029.0 / 34_652_500.0, -654_441.0 / 2_922_500.0, 174_375.0 / 388_108.0],
        &[
            15_267_082_809.0 / 155_376_265_600.0,
            -71_443_401.0 / 120_774_400.0,
            730_878_875.0 / 902_184_768.0,
            2_285_395.0 / 8_070_912.0,
        ],
        &[82_889.0 / 524_892.0, 0.0, 15_625.0 / 83_664.0, 69_875.0 / 102_672.0, -2260.0 / 8211.0],
    ],
    error: &[
        82_889.0 / 524_892.0 - 4_586_570_599.0 / 29_645_900_160.0,
        0.0,
        15_625.0 / 83_664.0 - 178_811_875.0 / 945_068_544.0,
        69_875.0 / 102_672.0 - 814_220_225.0 / 1_159_782_912.0,
        -2260.0 / 8211.0 + 3_700_637.0 / 11_593_932.0,
        0.25 - 61_727.0 / 225_920.0,
    ],
};

/// The method of order 4 of Hairer and Wanner (1996, table IV.6.5), L-stable, γ = 1/4. Its first stage is implicit: it
/// takes the first step, for which no derivative is known.
pub static START: Tableau = Tableau {
    gamma: 0.25,
    c: &[0.0, 0.25, 0.75, 0.55, 0.5, 1.0],
    a: &[
        &[],
        &[0.0],
        &[0.0, 0.5],
        &[0.0, 17.0 / 50.0, -0.04],
        &[0.0, 371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0],
        &[0.0, 25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0],
    ],
    error: &[],
};

/// Stages of the longest method, the explicit one included.
pub const MOST: usize = 6;

#[cfg(test)]
mod tests {
    use super::*;

    /// A and b of `method` as full arrays, b being the last row.
    fn full(method: &Tableau) -> [[f64; MOST]; MOST] {
        let mut a = [[0.0; MOST]; MOST];
        for (i, row) in method.a.iter().enumerate() {
            a[i][..row.len()].copy_from_slice(row);
            a[i][i] = if i > 0 { method.gamma } else { 0.0 };
        }
        a
    }

    /// The defects of the conditions for a quadrature `b` up to order 4: of order 1, of 2, two of 3 and four of 4.
    fn defects(method: &Tableau, b: &[f64]) -> [f64; 8] {
        let (a, n) = (full(method), method.c.len());
        let c: Vec<f64> = (0..n).map(|i| a[i].iter().sum()).collect();
        let apply = |x: &[f64]| -> Vec<f64> {
            (0..n).map(|i| x.iter().zip(&a[i]).map(|(x, a)| a * x).sum()).collect()
        };
        let power = |e: i32| -> Vec<f64> { c.iter().map(|c| c.powi(e)).collect() };
        let dot = |x: &[f64]| -> f64 { b.iter().zip(x).map(|(b, x)| b * x).sum() };
        let of_rates = apply(&c);
        let mixed: Vec<f64> = of_rates.iter().zip(&c).map(|(x, c)| x * c).collect();
        [
            dot(&power(0)) - 1.0,
            dot(&c) - 0.5,
            dot(&power(2)) - 1.0 / 3.0,
            dot(&of_rates) - 1.0 / 6.0,
            dot(&power(3)) - 0.25,
            dot(&mixed) - 0.125,
            dot(&apply(&power(2))) - 1.0 / 12.0,
            dot(&apply(&of_rates)) - 1.0 / 24.0,
        ]
    }

    /// R(λ): y at the end of a step of length 1 of y′ = λ y from 1.
    fn growth(method: &Tableau, lambda: f64) -> f64 {
        let mut rates = [lambda, 0.0, 0.0, 0.0, 0.0, 0.0];
        let mut y = 1.0;
        for i in 1..method.c.len() {
            let h: f64 = 1.0 + method.a[i].iter().zip(&rates).map(|(a, rate)| a * rate).sum::<f64>();
            y = h / (1.0 - method.gamma * lambda);
            rates[i] = lambda * y;
        }
        y
    }

    const ALL: [(&Tableau, u32); 3] = [(&ESDIRK3, 3), (&ESDIRK4, 4), (&START, 4)];

    #[test]
    fn conditions_hold_up_to_the_order_and_no_further() {
        let largest = |x: &[f64]| x.iter().fold(0.0f64, |sum, x| sum.max(x.abs()));
        for (method, order) in ALL {
            let n = method.c.len();
            let found = defects(method, &full(method)[n - 1][..n]);
            let held = if order == 3 { 4 } else { 8 };
            assert!(largest(&found[..held]) < 1e-14, "{found:?}");
            assert!(held == 8 || largest(&found[4..]) > 1e-4, "{found:?}");
            assert!((method.c[n - 1] - 1.0).abs() < 1e-15, "ends with its last stage");
            let a = full(method);
            for (i, c) in method.c.iter().enumerate() {
                assert!((a[i].iter().sum::<f64>() - c).abs() < 1e-14, "c of stage {i}");
            }
            if method.error.is_empty() {
                continue;
            }
            let embedded: Vec<f64> =
                full(method)[n - 1].iter().zip(method.error).map(|(b, e)| b - e).collect();
            let found = defects(method, &embedded);
            let held = if order == 3 { 2 } else { 4 };
            assert!(largest(&found[..held]) < 1e-13 && largest(&found[held..]) > 1e-4, "{found:?}");
        }
    }

    /// Σⱼ aᵢⱼ cⱼ = cᵢ²/2.
    #[test]
    fn stages_are_of_second_order() {
        for method in [&ESDIRK3, &ESDIRK4] {
            for (a, c) in full(method).iter().zip(method.c) {
                let sum: f64 = a.iter().zip(method.c).map(|(a, c)| a * c).sum();
                assert!((sum - 0.5 * c * c).abs() < 1e-14, "{sum} {c}");
            }
        }
    }

    /// R(∞) = 0.
    #[test]
    fn stiff_components_vanish_in_one_step() {
        for (method, _) in ALL {
            for lambda in [-1e4, -1e6, -1e8] {
                let found = growth(method, lambda) * lambda;
                assert!(found.abs() < 50.0, "R(λ) falls like 1/λ: {found}");
            }
            for exponent in -20..60 {
                let found = growth(method, -(1.3f64.powi(exponent)));
                assert!(found.abs() < 1.0, "{found}");
            }
        }
    }

    /// |R(iy)| ≤ 1: with R(∞) = 0 and poles at 1/γ alone the method is L-stable.
    #[test]
    fn no_vibration_grows() {
        for (method, order) in ALL {
            for exponent in -30..60 {
                let y = 1.3f64.powi(exponent);
                let (re, im) = rotation(method, y);
                let size = re.hypot(im);
                assert!(size < 1.0 + 1e-13, "{size} at {y}");
                if y < 0.2 {
                    let error = (re - y.cos()).hypot(im - y.sin());
                    assert!(error < 0.02 * y.powi(order as i32 + 1) + 1e-15, "{error:e} at {y}");
                }
            }
        }
    }

    /// R(iy): y′ = (−y y₂, y y₁) from (1, 0).
    fn rotation(method: &Tableau, y: f64) -> (f64, f64) {
        let turn = |[a, b]: [f64; 2]| [-y * b, y * a];
        let (mut rates, mut at) = ([turn([1.0, 0.0]); MOST], [1.0, 0.0]);
        for i in 1..method.c.len() {
            let mut h = [1.0, 0.0];
            for (a, rate) in method.a[i].iter().zip(&rates) {
                h = [h[0] + a * rate[0], h[1] + a * rate[1]];
            }
            let s = method.gamma * y;
            let size = 1.0 + s * s;
            at = [(h[0] - s * h[1]) / size, (h[1] + s * h[0]) / size];
            rates[i] = turn(at);
        }
        (at[0], at[1])
    }
}
