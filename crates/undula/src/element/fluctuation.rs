//! What a projection to a smaller space leaves of a basis: φ − πφ of local projection stabilisation.

use super::{Quadrature, Shape, lagrange};

/// Reference gradients of φ_a − πφ_a, `[child][point][a][ξ_d]`, and where the nodes of the children are.
#[derive(Clone, Debug)]
pub struct Fluctuation {
    /// Gradients with respect to the ξ of the child.
    pub grad: Vec<f64>,
    /// Functions: those of a cell, or of all cells of a patch.
    pub n_basis: usize,
    /// Function of each node of each child, `[child][node]`.
    pub children: Vec<Vec<usize>>,
}

/// A child is the image of the reference cell under ξ ↦ `corner` + `scale` ξ.
struct Place {
    corner: [f64; 3],
    scale: f64,
}

impl Place {
    fn of(&self, xi: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|d| self.corner[d] + self.scale * xi[d])
    }
}

impl Fluctuation {
    /// π is the L² projection on one cell from degree `k` to `k − 1`.
    pub fn on_cell(shape: Shape, k: usize, rule: &Quadrature) -> Fluctuation {
        let nodes = (0..shape.n_nodes(k)).collect();
        Self::new(shape, k, k - 1, rule, vec![nodes], vec![Place { corner: [0.0; 3], scale: 1.0 }])
    }

    /// π is the L² projection to the same degree `k` on the coarser mesh; the children of a patch are those of
    /// a refined cell in the order of [`Shape::in_parent`]. Functions are numbered like the nodes of degree `2 k`.
    pub fn on_patch(shape: Shape, k: usize, rule: &Quadrature) -> Fluctuation {
        let node =
            |child: usize, a: usize| shape.number(2 * k, shape.in_parent(k, child, shape.lattice(k, a)));
        let children = 0..1_usize << shape.dim();
        let nodes = children.clone().map(|c| (0..shape.n_nodes(k)).map(|a| node(c, a)).collect()).collect();
        let place = |child: usize| {
            let scale = if shape.is_turned(child) { -0.5 } else { 0.5 };
            Place { corner: std::array::from_fn(|d| 0.5 * (child >> d & 1) as f64), scale }
        };
        Self::new(shape, k, k, rule, nodes, children.map(place).collect())
    }

    /// Child c is at `places[c]`.
    fn new(
        shape: Shape,
        fine: usize,
        coarse: usize,
        rule: &Quadrature,
        children: Vec<Vec<usize>>,
        places: Vec<Place>,
    ) -> Fluctuation {
        let (dim, n_coarse) = (shape.dim(), shape.n_nodes(coarse));
        let n_basis = 1 + children.iter().flatten().max().copied().unwrap_or(0);
        // Products of degree 2 fine are integrated exactly, whatever `rule` is.
        let exact = Quadrature::cell(shape, fine + 1);
        let (mut mass, mut mixed) = (vec![0.0; n_coarse * n_coarse], vec![0.0; n_coarse * n_basis]);
        for (nodes, place) in children.iter().zip(&places) {
            for (xi, weight) in exact.points.iter().zip(&exact.weights) {
                let value = lagrange::basis(shape, fine, xi).0;
                let tested = lagrange::basis(shape, coarse, &place.of(xi)).0;
                for i in 0..n_coarse {
                    for j in 0..n_coarse {
                        mass[i * n_coarse + j] += weight * tested[i] * tested[j];
                    }
                    for (value, &a) in value.iter().zip(nodes) {
                        mixed[i * n_basis + a] += weight * tested[i] * value;
                    }
                }
            }
        }
        let projected = solve(mass, mixed, n_coarse, n_basis);
        let mut grad = vec![];
        for (nodes, place) in children.iter().zip(&places) {
            for xi in &rule.points {
                let first = grad.len();
                let slope = lagrange::basis(shape, coarse, &place.of(xi)).1;
                for a in 0..n_basis {
                    let sum = |d: usize| {
                        (0..n_coarse).map(|i| projected[i * n_basis + a] * slope[i][d]).sum::<f64>()
                    };
                    grad.extend((0..dim).map(|d| -place.scale * sum(d)));
                }
                for (slope, &a) in lagrange::basis(shape, fine, xi).1.iter().zip(nodes) {
                    (0..dim).for_each(|d| grad[first + a * dim + d] += slope[d]);
                }
            }
        }
        Fluctuation { grad, n_basis, children }
    }
}

/// A⁻¹B of a symmetric positive definite `n` × `n` matrix and `m` columns, by elimination.
fn solve(mut a: Vec<f64>, mut b: Vec<f64>, n: usize, m: usize) -> Vec<f64> {
    for k in 0..n {
        for i in (0..n).filter(|&i| i != k) {
            let factor = a[i * n + k] / a[k * n + k];
            for j in k..n {
                a[i * n + j] -= factor * a[k * n + j];
            }
            for j in 0..m {
                b[i * m + j] -= factor * b[k * m + j];
            }
        }
    }
    for i in 0..n {
        b[i * m..(i + 1) * m].iter_mut().for_each(|x| *x /= a[i * n + i]);
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest gradient of what is left of `f` when it is interpolated at the nodes.
    fn left(fluctuation: &Fluctuation, dim: usize, f: impl Fn(usize) -> f64) -> f64 {
        let n = fluctuation.n_basis;
        let points = fluctuation.grad.chunks_exact(n * dim);
        let at = |g: &[f64], d: usize| (0..n).map(|a| f(a) * g[a * dim + d]).sum::<f64>().abs();
        points.flat_map(|g| (0..dim).map(move |d| at(g, d))).fold(0.0, f64::max)
    }

    #[test]
    fn nothing_is_left_of_the_smaller_space() {
        for shape in [Shape::Triangle, Shape::Quadrilateral, Shape::Hexahedron] {
            for k in 1..4 {
                let rule = Quadrature::cell(shape, k + 1);
                let power = |x: f64, n: usize| x.powi(n as i32);
                // The other exponent of a monomial of degree n.
                let other = |n: usize| if shape == Shape::Triangle { 0 } else { n };
                let cell = Fluctuation::on_cell(shape, k, &rule);
                let on_cell = |a: usize| lagrange::node(shape, k, a);
                let small = |a: usize| power(on_cell(a)[0], other(k - 1)) * power(on_cell(a)[1], k - 1) + 3.0;
                assert!(left(&cell, shape.dim(), small) < 1e-12, "{shape:?} {k}");
                assert!(left(&cell, shape.dim(), |a| power(on_cell(a)[1], k)) > 0.1);
                if shape == Shape::Hexahedron && k > 2 {
                    continue;
                }
                let patch = Fluctuation::on_patch(shape, k, &rule);
                let on_patch = |a: usize| shape.lattice(2 * k, a).map(|i| i as f64 / (2 * k) as f64);
                let small = |a: usize| power(on_patch(a)[0], other(k)) * power(on_patch(a)[1], k) - 2.0;
                assert!(left(&patch, shape.dim(), small) < 1e-11, "{shape:?} {k}");
                assert!(left(&patch, shape.dim(), |a| power(on_patch(a)[1], k + 1)) > 0.01);
            }
        }
    }
}
