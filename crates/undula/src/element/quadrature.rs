//! Gauss rules on the reference cell and its facets.

use super::Shape;

/// Points in reference coordinates and weights; the weights of a cell rule sum to 1.
#[derive(Clone, Debug)]
pub struct Quadrature {
    /// Points ξ in `[0, 1]^D`, unused coordinates zero.
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

impl Quadrature {
    /// Gauss rule with `n` points per direction on the cell, first coordinate fastest.
    pub fn cell(shape: Shape, n: usize) -> Quadrature {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_rules_are_exact_to_degree_2n_minus_1() {
        for n in 1..8 {
            let (x, w) = gauss(n);
            for degree in 0..2 * n {
                let sum: f64 = x.iter().zip(&w).map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!((sum - 1.0 / (degree as f64 + 1.0)).abs() < 1e-14, "n {n} degree {degree}: {sum}");
            }
        }
    }
}
