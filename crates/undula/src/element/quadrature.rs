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
pub fn gauss_jacobi(n: usize) -> (Vec<f64>, Vec<f64>) {
    gauss_jacobi_of(1, n)
}

/// The same for the weight (1 − y)².
pub fn gauss_jacobi_2(n: usize) -> (Vec<f64>, Vec<f64>) {
    gauss_jacobi_of(2, n)
}

/// The same for the weight (1 − y)^α.
///
/// Its points are the zeros of the Jacobi polynomial P^{(α,0)} in 2 y − 1, found between those of the rule with one
/// point less; the weights make it exact.
fn gauss_jacobi_of(alpha: i32, n: usize) -> (Vec<f64>, Vec<f64>) {
    // Recurrence of P^{(α,β)} with β = 0 (Abramowitz and Stegun 22.7.1).
    let a = f64::from(alpha);
    let polynomial = |n: usize, y: f64| {
        let x = 2.0 * y - 1.0;
        let (mut p0, mut p1) = (1.0, 0.5 * ((a + 2.0) * x + a));
        if n == 0 {
            return p0;
        }
        for k in 1..n {
            let k = k as f64;
            let first = 2.0 * (k + 1.0) * (k + a + 1.0) * (2.0 * k + a);
            let second = (2.0 * k + a + 1.0) * ((2.0 * k + a + 2.0) * (2.0 * k + a) * x + a * a);
            let third = 2.0 * (k + a) * k * (2.0 * k + a + 2.0);
            (p0, p1) = (p1, (second * p1 - third * p0) / first);
        }
        p1
    };
    let mut points: Vec<f64> = vec![];
    for m in 1..=n {
        let ends = [&[0.0][..], &points, &[1.0]].concat();
        points = ends.windows(2).map(|w| bisect(|y| polynomial(m, y), w[0], w[1])).collect();
    }
    let weight = |i: usize| {
        // ∫ l_i (1 − y)^α dy by a Gauss-Legendre rule, l_i of degree n − 1.
        let (x, w) = gauss(n + 1);
        let l = |y: f64| {
            let others = (0..n).filter(|&j| j != i).map(|j| (y - points[j]) / (points[i] - points[j]));
            others.product::<f64>()
        };
        x.iter().zip(&w).map(|(x, w)| w * (1.0 - x).powi(alpha) * l(*x)).sum()
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
    /// fastest; on simplices one that is exact to the same degree `2 n − 1`, with positive weights and points inside.
    pub fn cell(shape: Shape, n: usize) -> Quadrature {
        match shape {
            Shape::Triangle => return triangle(n),
            Shape::Tetrahedron => return tetrahedron(n),
            _ => {}
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

    /// Gauss rule with `n` points per direction on facet `facet` of the cell, in cell coordinates; on the triangular
    /// facets of tetrahedra the rule of number `n` of triangles.
    pub fn facet(shape: Shape, facet: usize, n: usize) -> Quadrature {
        if shape == Shape::Tetrahedron {
            return facet_of_tetrahedron(facet, n);
        }
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

/// The rule of a triangle on a facet of a tetrahedron: its vertices in lexicographic order are those of the triangle.
fn facet_of_tetrahedron(facet: usize, n: usize) -> Quadrature {
    let rule = triangle(n);
    let vertices: Vec<usize> = (0..4).filter(|v| *v != facet).collect();
    let place = |at: &[f64; 3]| {
        let mut barycentric = [0.0; 4];
        let shares = [1.0 - at[0] - at[1], at[0], at[1]];
        vertices.iter().zip(shares).for_each(|(&v, share)| barycentric[v] = share);
        [barycentric[1], barycentric[2], barycentric[3]]
    };
    let weights = rule.weights.iter().map(|w| 2.0 * w).collect();
    Quadrature { points: rule.points.iter().map(place).collect(), weights }
}

/// A rule on the tetrahedron that is exact to degree `2 n − 1`.
///
/// `n = 1, 3, 4` are symmetric: the midpoint; 14 points (Walkington 2000; Grundmann and Möller 1978 have others); 35
/// points (Witherden and Vincent, Comput. Math. Appl. 69, 2015). The others collapse the cube onto the tetrahedron,
/// ξ = x (1 − y)(1 − z), η = y (1 − z), ζ = z, with Gauss points for the weights 1, 1 − y and (1 − z)²: `n³` points.
fn tetrahedron(n: usize) -> Quadrature {
    let mut rule = Quadrature { points: vec![], weights: vec![] };
    match n {
        0 | 1 => orbit(&mut rule, [0.25; 4], 1.0 / 6.0),
        3 => {
            orbit_of_four(&mut rule, 0.092_735_250_310_891_22, 0.012_248_840_519_393_658);
            orbit_of_four(&mut rule, 0.310_885_919_263_300_6, 0.018_781_320_953_002_642);
            let a = 0.454_496_295_874_350_35;
            orbit(&mut rule, [a, a, 0.5 - a, 0.5 - a], 0.007_091_003_462_846_911);
        }
        4 => {
            orbit(&mut rule, [0.25; 4], 0.015_914_214_910_688_475);
            orbit_of_four(&mut rule, 0.315_701_149_778_202_8, 0.007_054_930_201_661_172);
            let a = 0.050_489_822_598_396_37;
            orbit(&mut rule, [a, a, 0.5 - a, 0.5 - a], 0.005_316_154_638_809_596);
            let (a, b) = (0.188_833_831_026_001_05, 0.047_160_700_360_997_88);
            orbit(&mut rule, [a, a, b, 1.0 - 2.0 * a - b], 0.006_201_188_454_722_437);
            let (a, b) = (0.021_265_472_541_483_245, 0.810_830_241_098_548_6);
            orbit(&mut rule, [a, a, b, 1.0 - 2.0 * a - b], 0.001_351_795_138_317_223_6);
        }
        _ => return collapsed(n),
    }
    rule
}

/// Adds all different permutations of barycentric coordinates, in lexicographic order.
fn orbit(rule: &mut Quadrature, at: [f64; 4], weight: f64) {
    let mut points: Vec<[f64; 4]> = vec![];
    for i in 0..4 {
        for j in (0..4).filter(|&j| j != i) {
            for k in (0..4).filter(|&k| k != i && k != j) {
                points.push([at[i], at[j], at[k], at[6 - i - j - k]]);
            }
        }
    }
    points.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    points.dedup();
    rule.weights.extend(vec![weight; points.len()]);
    rule.points.extend(points.iter().map(|p| [p[1], p[2], p[3]]));
}

/// Those of (a, a, a, 1 − 3 a).
fn orbit_of_four(rule: &mut Quadrature, a: f64, weight: f64) {
    orbit(rule, [a, a, a, 1.0 - 3.0 * a], weight);
}

/// The collapsed rule of the tetrahedron.
fn collapsed(n: usize) -> Quadrature {
    let ((x, w_x), (y, w_y), (z, w_z)) = (gauss(n), gauss_jacobi(n), gauss_jacobi_2(n));
    let mut rule = Quadrature { points: vec![], weights: vec![] };
    for (z, w_z) in z.iter().zip(&w_z) {
        for (y, w_y) in y.iter().zip(&w_y) {
            rule.points.extend(x.iter().map(|x| [x * (1.0 - y) * (1.0 - z), y * (1.0 - z), *z]));
            rule.weights.extend(w_x.iter().map(|w_x| w_x * w_y * w_z));
        }
    }
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
            let (z, w_z) = gauss_jacobi_2(n);
            for degree in 0..2 * n {
                let d = degree as f64;
                let sum: f64 = x.iter().zip(&w).map(|(x, w)| w * x.powi(degree as i32)).sum();
                assert!((sum - 1.0 / (d + 1.0)).abs() < 1e-14, "n {n} degree {degree}: {sum}");
                let sum: f64 = y.iter().zip(&w_y).map(|(y, w)| w * y.powi(degree as i32)).sum();
                let exact = 1.0 / ((d + 1.0) * (d + 2.0));
                assert!((sum - exact).abs() < 1e-14, "Jacobi, n {n} degree {degree}: {sum}");
                let sum: f64 = z.iter().zip(&w_z).map(|(z, w)| w * z.powi(degree as i32)).sum();
                let exact = 2.0 / ((d + 1.0) * (d + 2.0) * (d + 3.0));
                assert!((sum - exact).abs() < 1e-14, "Jacobi, n {n} degree {degree}: {sum}");
            }
        }
    }

    #[test]
    fn tetrahedron_rules_are_exact_to_degree_2n_minus_1() {
        let shape = Shape::Tetrahedron;
        for n in 1..=8usize {
            let rule = Quadrature::cell(shape, n);
            let expected = [1, 8, 14, 35].get(n - 1).copied().unwrap_or(n.pow(3));
            assert_eq!(rule.points.len(), expected);
            assert!(rule.weights.iter().all(|w| *w > 0.0));
            assert!(rule.points.iter().all(|x| x.iter().all(|x| *x > 0.0) && x.iter().sum::<f64>() < 1.0));
            let top = 2 * n as i32;
            for (i, j) in (0..top).flat_map(|i| (0..top - i).map(move |j| (i, j))) {
                for k in 0..top - i - j {
                    let value = |x: &[f64; 3]| x[0].powi(i) * x[1].powi(j) * x[2].powi(k);
                    let sum: f64 = rule.points.iter().zip(&rule.weights).map(|(x, w)| w * value(x)).sum();
                    // i! j! k! / (i + j + k + 3)!
                    let part =
                        |m: i32, n: i32| (1..=n).map(|l| f64::from(l) / f64::from(m + l)).product::<f64>();
                    let last = (1..=3).map(|l| f64::from(i + j + k + l)).product::<f64>();
                    let exact = part(i, j) * part(i + j, k) / last;
                    assert!((sum - exact).abs() < 1e-15, "n {n}, {i} {j} {k}: {sum} instead of {exact}");
                }
            }
        }
    }

    /// ∫ over a facet of degree 2 n − 1 polynomials of the barycentric coordinates.
    #[test]
    fn rules_of_triangular_facets_lie_on_them() {
        let shape = Shape::Tetrahedron;
        for facet in 0..4 {
            let rule = Quadrature::facet(shape, facet, 3);
            assert!((rule.weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            for vertex in 0..4 {
                let at = |x: &[f64; 3]| if vertex == 0 { 1.0 - x.iter().sum::<f64>() } else { x[vertex - 1] };
                let sum: f64 = rule.points.iter().zip(&rule.weights).map(|(x, w)| w * at(x).powi(4)).sum();
                // 2 · 4!/6!
                let exact = if vertex == facet { 0.0 } else { 2.0 / 30.0 };
                assert!((sum - exact).abs() < 1e-14, "{facet} {vertex}: {sum}");
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
