//! Quadrature rules on the reference cell and its facets.

use super::Shape;

/// Points in reference coordinates and weights; the weights of a cell rule sum to the volume of the reference cell,
/// those of a facet rule to 1.
#[derive(Clone, Debug)]
pub struct Quadrature {
    /// Points ξ, unused coordinates zero.
    pub points: Vec<[f64; 3]>,
    /// Weights.
    pub weights: Vec<f64>,
}

/// The `n`-point Gauss-Legendre rule on `[0, 1]`, exact to degree `2 n − 1`: (points, weights).
pub fn gauss(n: usize) -> (Vec<f64>, Vec<f64>) {
    let mut points = vec![0.0; n];
    let mut weights = vec![0.0; n];
    for i in 0..n {
        // Newton's method on the Legendre polynomial from the usual asymptotic start.
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..100 {
            let (mut p0, mut p1) = (1.0, x);
            for k in 2..=n {
                let k = k as f64;
                (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
            }
            let (value, before) = if n == 0 { (1.0, 0.0) } else { (p1, p0) };
            slope = n as f64 * (x * value - before) / (x * x - 1.0);
            let dx = value / slope;
            x -= dx;
            if dx.abs() < 1e-16 {
                break;
            }
        }
        points[n - 1 - i] = 0.5 * (1.0 + x);
        weights[n - 1 - i] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
    (points, weights)
}

/// The `n`-point Gauss rule on `[0, 1]` for the weight 1 − y, exact to degree `2 n − 1`: (points, weights).
///
/// Its points are the zeros of the Jacobi polynomial P^{(1,0)} in 2 y − 1, found between those of the rule with one
/// point less; the weights make it exact.
pub fn gauss_jacobi(n: usize) -> (Vec<f64>, Vec<f64>) {
    // (2k+1)(k+1) k... recurrence of P^{(1,0)} (Abramowitz and Stegun 22.7.1 with α = 1, β = 0).
    let polynomial = |n: usize, y: f64| {
        let x = 2.0 * y - 1.0;
        let (mut p0, mut p1) = (1.0, 0.5 * (3.0 * x + 1.0));
        if n == 0 {
            return p0;
        }
        for k in 1..n {
            let k = k as f64;
            let a = 2.0 * (k + 1.0) * (k + 2.0) * (2.0 * k + 1.0);
            let b = (2.0 * k + 2.0) * ((2.0 * k + 3.0) * (2.0 * k + 1.0) * x + 1.0);
            let c = 2.0 * (k + 1.0) * k * (2.0 * k + 3.0);
            (p0, p1) = (p1, (b * p1 - c * p0) / a);
        }
        p1
    };
    let mut points: Vec<f64> = vec![];
    for m in 1..=n {
        let ends = [&[0.0][..], &points, &[1.0]].concat();
        points = ends.windows(2).map(|w| bisect(|y| polynomial(m, y), w[0], w[1])).collect();
    }
    let weight = |i: usize| {
        // ∫ l_i (1 − y) dy by a Gauss-Legendre rule, l_i of degree n − 1.
        let (x, w) = gauss(n + 1);
        let l = |y: f64| {
            let others = (0..n).filter(|&j| j != i).map(|j| (y - points[j]) / (points[i] - points[j]));
            others.product::<f64>()
        };
        x.iter().zip(&w).map(|(x, w)| w * (1.0 - x) * l(*x)).sum()
    };
    let weights = (0..n).map(weight).collect();
    (points, weights)
}

/// The zero of `f` between `a` and `b`, where it has opposite signs.
fn bisect(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let sign = f(a) > 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (a + b);
        if middle == a || middle == b {
            break;
        }
        if (f(middle) > 0.0) == sign { a = middle } else { b = middle }
    }
    0.5 * (a + b)
}

impl Quadrature {
    /// The rule of number `n` on the cell: on tensor-product cells `n` Gauss points per direction, first coordinate
    /// fastest; on triangles one that is exact to the same degree `2 n − 1`, with positive weights and points inside.
    pub fn cell(shape: Shape, n: usize) -> Quadrature {
        if shape == Shape::Triangle {
            return triangle(n);
        }
        let (x, w) = gauss(n);
        let mut rule = Quadrature { points: vec![], weights: vec![] };
        for q in 0..shape.n_nodes(n - 1) {
            let at = shape.lattice(n - 1, q);
            let (mut point, mut weight) = ([0.0; 3], 1.0);
            for d in 0..shape.dim() {
                point[d] = x[at[d]];
                weight *= w[at[d]];
            }
            rule.points.push(point);
            rule.weights.push(weight);
        }
        rule
    }

    /// Gauss rule with `n` points per direction on facet `facet` of the cell, in cell coordinates.
    pub fn facet(shape: Shape, facet: usize, n: usize) -> Quadrature {
        let (x, w) = gauss(n);
        if shape == Shape::Triangle {
            let at = |s: &f64| match facet {
                0 => [1.0 - s, *s, 0.0],
                1 => [0.0, *s, 0.0],
                _ => [*s, 0.0, 0.0],
            };
            return Quadrature { points: x.iter().map(at).collect(), weights: w };
        }
        let (axis, side) = (facet / 2, (facet % 2) as f64);
        let mut rule = Quadrature { points: vec![], weights: vec![] };
        for q in 0..n.pow(shape.dim() as u32 - 1) {
            let (mut point, mut weight, mut rest) = ([0.0; 3], 1.0, q);
            for d in 0..shape.dim() {
                if d == axis {
                    point[d] = side;
                } else {
                    point[d] = x[rest % n];
                    weight *= w[rest % n];
                    rest /= n;
                }
            }
            rule.points.push(point);
            rule.weights.push(weight);
        }
        rule
    }
}

/// A rule on the triangle that is exact to degree `2 n − 1`.
///
/// `n = 1, 2, 3` are symmetric: the midpoint; 6 points, exact to degree 4 even, and 7 points (Radon 1948; both in
/// Dunavant 1985). Above, the square is collapsed onto the triangle, ξ = x (1 − y), η = y, with Gauss-Legendre points
/// in x and Gauss-Jacobi points in y for the weight 1 − y: `n²` points.
fn triangle(n: usize) -> Quadrature {
    let mut rule = Quadrature { points: vec![], weights: vec![] };
    let mut orbit = |a: f64, w: f64| {
        // Barycentric coordinates (1 − 2a, a, a) and their permutations.
        rule.points.extend([[a, a, 0.0], [1.0 - 2.0 * a, a, 0.0], [a, 1.0 - 2.0 * a, 0.0]]);
        rule.weights.extend([0.5 * w; 3]);
    };
    match n {
        0 | 1 => {}
        2 => {
            // Closed form of Dunavant's rule of degree 4.
            let (r, s) = (10f64.sqrt(), (38.0 - 44.0 * 0.4f64.sqrt()).sqrt());
            let t = (213125.0 - 53320.0 * r).sqrt();
            orbit((8.0 - r + s) / 18.0, (620.0 + t) / 3720.0);
            orbit((8.0 - r - s) / 18.0, (620.0 - t) / 3720.0);
            return rule;
        }
        3 => {
            let r = 15f64.sqrt();
            orbit((6.0 - r) / 21.0, (155.0 - r) / 1200.0);
            orbit((6.0 + r) / 21.0, (155.0 + r) / 1200.0);
        }
        _ => {
            let ((x, w_x), (y, w_y)) = (gauss(n), gauss_jacobi(n));
            for (y, w_y) in y.iter().zip(&w_y) {
                rule.points.extend(x.iter().map(|x| [x * (1.0 - y), *y, 0.0]));
                rule.weights.extend(w_x.iter().map(|w_x| w_x * w_y));
            }
            return rule;
        }
    }
    rule.points.push(Shape::Triangle.centre());
    rule.weights.push(0.5 - rule.weights.iter().sum::<f64>());
    rule
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_rules_are_exact_to_degree_2n_minus_1() {
        for n in 1..8 {
            let (x, w) = gauss(n);
            let (y, w_y) = gauss_jacobi(n);
            for degree in 0..2 * n {
                let d = degree as f64;
                let sum: f64 = x.iter().zip(&w).map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!((sum - 1.0 / (d + 1.0)).abs() < 1e-14, "n {n} degree {degree}: {sum}");
                let sum: f64 = y.iter().zip(&w_y).map(|(y, w)| w * y.powi(degree as i32)).sum();
                let exact = 1.0 / ((d + 1.0) * (d + 2.0));
                assert!((sum - exact).abs() < 1e-14, "Jacobi, n {n} degree {degree}: {sum}");
            }
        }
    }

    #[test]
    fn triangle_rules_are_exact_to_degree_2n_minus_1() {
        for n in 1..=8usize {
            let rule = Quadrature::cell(Shape::Triangle, n);
            assert!(rule.weights.iter().all(|w| *w > 0.0));
            assert!(
                rule.points.iter().all(|x| x[0] > 0.0 && x[1] > 0.0 && x[0] + x[1] < 1.0),
                "n {n}: inside"
            );
            for i in 0..2 * n as i32 {
                for j in 0..2 * n as i32 - i {
                    let value = |x: &[f64; 3]| x[0].powi(i) * x[1].powi(j);
                    let sum: f64 = rule.points.iter().zip(&rule.weights).map(|(x, w)| w * value(x)).sum();
                    // i! j! / (i + j + 2)!
                    let exact = (1..=j).map(|m| f64::from(m) / f64::from(i + m)).product::<f64>()
                        / f64::from((i + j + 1) * (i + j + 2));
                    assert!((sum - exact).abs() < 1e-14, "n {n}, x^{i} y^{j}: {sum} instead of {exact}");
                }
            }
        }
    }
}
