//! What a projection to a smaller space leaves of a basis: φ − πφ of local projection stabilisation.

use super::{Quadrature, Shape, lagrange};

/// Reference gradients of φ_a − πφ_a, `[child][point][a][ξ_d]`, and where the nodes of the children are.
#[derive(Clone, Debug)]
pub struct Fluctuation {
    /// Gradients with respect to the ξ of the child.
    pub grad: Vec<f64>,
    /// Functions: those of a cell, or of all cells of a patch.
    pub n_basis: usize,
    /// Number of each function of each child, `[child][function]`.
    pub children: Vec<Vec<usize>>,
}

/// The basis that is projected: that of the nodes of degree `degree`, and behind it perhaps the bubbles of a simplex.
#[derive(Copy, Clone, Debug)]
pub struct Fine {
    /// Shape of the cells.
    pub shape: Shape,
    /// Degree.
    pub degree: usize,
    /// Whether there are bubbles.
    pub bubble: bool,
}

impl Fine {
    fn n_basis(self) -> usize {
        self.shape.n_nodes(self.degree) + if self.bubble { lagrange::n_bubbles(self.shape) } else { 0 }
    }

    /// Values and gradients at `xi`.
    fn basis(self, xi: &[f64; 3]) -> (Vec<f64>, Vec<[f64; 3]>) {
        let (mut value, mut grad) = lagrange::basis(self.shape, self.degree, xi);
        if self.bubble {
            for (bubble, slope) in lagrange::bubbles(self.shape, xi) {
                value.push(bubble);
                grad.push(slope);
            }
        }
        (value, grad)
    }
}

/// Functions of a child by their numbers in the patch, and the image of the reference cell: ξ ↦ `corner` + `scale` ξ.
struct Child {
    functions: Vec<usize>,
    corner: [f64; 3],
    scale: f64,
}

impl Child {
    fn place(&self, xi: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|d| self.corner[d] + self.scale * xi[d])
    }
}

impl Fluctuation {
    /// π is the L² projection on one cell from degree k, that of `of`, to k − 1.
    pub fn on_cell(of: Fine, rule: &Quadrature) -> Fluctuation {
        let child = Child { functions: (0..of.n_basis()).collect(), corner: [0.0; 3], scale: 1.0 };
        Self::new(of, of.degree - 1, rule, vec![child])
    }

    /// π is the L² projection to the same degree k on the coarser mesh; the children of a patch are those of a refined
    /// cell in the order of [`Shape::in_parent`]. Functions are numbered like the nodes of degree 2 k, bubbles behind.
    ///
    /// # Panics
    /// On tetrahedra, whose children are not alike.
    pub fn on_patch(of: Fine, rule: &Quadrature) -> Fluctuation {
        let (shape, k) = (of.shape, of.degree);
        assert!(shape != Shape::Tetrahedron, "children of one shape");
        let child = |child: usize| {
            let node = |a: usize| shape.number(2 * k, shape.in_parent(k, child, shape.lattice(k, a)));
            let bubble = of.bubble.then(|| shape.n_nodes(2 * k) + child);
            Child {
                functions: (0..shape.n_nodes(k)).map(node).chain(bubble).collect(),
                corner: std::array::from_fn(|d| 0.5 * (child >> d & 1) as f64),
                scale: if shape.is_turned(child) { -0.5 } else { 0.5 },
            }
        };
        Self::new(of, k, rule, (0..1 << shape.dim()).map(child).collect())
    }

    /// π is the L² projection to degree `coarse` on the cell that `children` make up.
    fn new(of: Fine, coarse: usize, rule: &Quadrature, children: Vec<Child>) -> Fluctuation {
        let shape = of.shape;
        let (dim, n_coarse) = (shape.dim(), shape.n_nodes(coarse));
        let n_basis = 1 + children.iter().flat_map(|c| &c.functions).max().copied().unwrap_or(0);
        // Products are integrated exactly, whatever `rule` is.
        let exact = Quadrature::cell(shape, of.degree + 1 + usize::from(of.bubble));
        let (mut mass, mut mixed) = (vec![0.0; n_coarse * n_coarse], vec![0.0; n_coarse * n_basis]);
        for child in &children {
            for (xi, weight) in exact.points.iter().zip(&exact.weights) {
                let value = of.basis(xi).0;
                let tested = lagrange::basis(shape, coarse, &child.place(xi)).0;
                for i in 0..n_coarse {
                    for j in 0..n_coarse {
                        mass[i * n_coarse + j] += weight * tested[i] * tested[j];
                    }
                    for (value, &a) in value.iter().zip(&child.functions) {
                        mixed[i * n_basis + a] += weight * tested[i] * value;
                    }
                }
            }
        }
        let projected = solve(mass, mixed, n_coarse, n_basis);
        let mut grad = vec![];
        for child in &children {
            for xi in &rule.points {
                let first = grad.len();
                let slope = lagrange::basis(shape, coarse, &child.place(xi)).1;
                for a in 0..n_basis {
                    let sum = |d: usize| {
                        (0..n_coarse).map(|i| projected[i * n_basis + a] * slope[i][d]).sum::<f64>()
                    };
                    grad.extend((0..dim).map(|d| -child.scale * sum(d)));
                }
                for (slope, &a) in of.basis(xi).1.iter().zip(&child.functions) {
                    (0..dim).for_each(|d| grad[first + a * dim + d] += slope[d]);
                }
            }
        }
        Fluctuation { grad, n_basis, children: children.into_iter().map(|c| c.functions).collect() }
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
        for shape in [Shape::Triangle, Shape::Quadrilateral, Shape::Tetrahedron, Shape::Hexahedron] {
            for (degree, bubble) in [(1, false), (2, false), (3, false), (2, true)] {
                if !bubble || shape.is_simplex() {
                    nothing_is_left_of(Fine { shape, degree, bubble });
                }
            }
        }
    }

    fn nothing_is_left_of(of: Fine) {
        let (shape, k) = (of.shape, of.degree);
        let rule = Quadrature::cell(shape, 2);
        let power = |x: f64, n: usize| x.powi(n as i32);
        // The other exponent of a monomial of degree n.
        let other = |n: usize| if shape.is_simplex() { 0 } else { n };
        let cell = Fluctuation::on_cell(of, &rule);
        let on_cell = |a: usize| lagrange::node(shape, k, a);
        let small = |a: usize| power(on_cell(a)[0], other(k - 1)) * power(on_cell(a)[1], k - 1) + 3.0;
        // Bubbles stand beside the nodal basis.
        let in_cell = |f: &dyn Fn(usize) -> f64| {
            left(&cell, shape.dim(), |a| if a < shape.n_nodes(k) { f(a) } else { 0.0 })
        };
        assert!(in_cell(&small) < 1e-12, "{of:?}");
        assert!(in_cell(&|a| power(on_cell(a)[1], k)) > 0.1);
        if shape == Shape::Tetrahedron {
            return;
        }
        let patch = Fluctuation::on_patch(of, &rule);
        let on_patch = |a: usize| shape.lattice(2 * k, a).map(|i| i as f64 / (2 * k) as f64);
        let small = |a: usize| power(on_patch(a)[0], other(k)) * power(on_patch(a)[1], k) - 2.0;
        let in_patch = |f: &dyn Fn(usize) -> f64| {
            left(&patch, shape.dim(), |a| if a < shape.n_nodes(2 * k) { f(a) } else { 0.0 })
        };
        assert!(in_patch(&small) < 1e-11, "{of:?}");
        assert!(in_patch(&|a| power(on_patch(a)[1], k + 1)) > 0.01);
    }
}
