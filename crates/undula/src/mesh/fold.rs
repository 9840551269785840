//! Whether the map of a cell folds anywhere: det DX is bounded on the whole cell, not looked at in some points.
//!
//! det DX is a polynomial. Its Bernstein coefficients on a box bound it from both sides, those at the corners are its
//! values there. A box on which they do not decide is halved until they do (Johnen, Remacle, Geuzaine, "Geometrical
//! validity of curvilinear finite elements", J. Comput. Phys. 233, 2013).

use super::geometry::{determinant, distance};
use super::{Least, Mesh, MeshError};
use crate::element::Shape;

/// A cell is straight if its nodes are where the multilinear map of its vertices has them, but for this part of
/// its diameter.
const STRAIGHT: f64 = 1e-12;

/// Boxes looked at in one cell. Where so many do not decide, det DX is 0 somewhere but for rounding.
const BOXES: usize = 4000;

impl<const D: usize> Mesh<D> {
    /// Refuses cells whose map is folded or numbered clockwise, be it in one point of the cell only.
    ///
    /// # Errors
    /// [`MeshError::Inverted`] with all of these cells and the smallest det DX.
    pub fn check_orientation(&self) -> Result<(), MeshError> {
        let polynomial = Determinant::new(self);
        let mut cells = self.quality().inverted;
        let weights: Vec<Vec<f64>> = (0..self.shape.n_nodes(self.degree)).map(|n| self.weights(n)).collect();
        let curved = |&cell: &usize| match D {
            2 => self.degree > 1 && !self.is_straight(cell, &weights),
            // Hexahedra may be folded between their vertices, be their edges straight.
            _ => !self.is_nearly_affine(cell),
        };
        cells.extend(
            (0..self.n_cells()).filter(curved).filter(|&c| polynomial.sign(self, c) != Sign::Positive),
        );
        cells.sort_unstable();
        cells.dedup();
        let least = cells.iter().map(|&cell| polynomial.least(self, cell));
        match least.min_by(|a, b| a.relative.total_cmp(&b.relative)) {
            None => Ok(()),
            Some(least) => Err(MeshError::Inverted(self.list_cells(&cells), least)),
        }
    }

    /// Weights of the vertices in the multilinear map at node `local`.
    fn weights(&self, local: usize) -> Vec<f64> {
        let weights = self.shape.vertex_weights(self.degree, local);
        let sum: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        weights.iter().map(|&w| f64::from(w) / sum).collect()
    }

    /// Whether the map of `cell` is that of its vertices alone, whose det DX has its extrema there in the plane.
    fn is_straight(&self, cell: usize, weights: &[Vec<f64>]) -> bool {
        let vertices: Vec<_> = self.cell_vertices(cell).iter().map(|&v| self.nodes[v as usize]).collect();
        let within = STRAIGHT * vertices.iter().fold(0.0, |size: f64, &v| size.max(distance(v, vertices[0])));
        self.cell(cell).iter().zip(weights).all(|(&node, weights)| {
            let mut x = [0.0; D];
            for (weight, vertex) in weights.iter().zip(&vertices) {
                (0..D).for_each(|d| x[d] += weight * vertex[d]);
            }
            distance(x, self.nodes[node as usize]) <= within
        })
    }
}

/// Sign of det DX on a cell.
#[derive(Copy, Clone, PartialEq)]
enum Sign {
    Positive,
    /// 0 or below somewhere.
    Not,
}

/// A box in the unit cube with the Bernstein coefficients of det DX there, the first coordinate running fastest.
struct Piece<const D: usize> {
    lower: [f64; D],
    upper: [f64; D],
    coefficients: Vec<f64>,
    /// The direction in which it is halved next.
    axis: usize,
}

/// A bound from below.
fn lowest<const D: usize>(piece: &Piece<D>) -> f64 {
    piece.coefficients.iter().copied().fold(f64::INFINITY, f64::min)
}

/// det DX on the cells of a mesh as polynomials on the unit cube. A triangle is the image of the square under
/// (s, t) ↦ (s, t (1 − s)), on which a polynomial keeps its degree in s and t; so is a tetrahedron of the cube under
/// (s, t, u) ↦ (s, t (1 − s), u (1 − s)(1 − t)).
struct Determinant<const D: usize> {
    /// Degree in each coordinate.
    degree: usize,
    /// What the nodes add to DX at the points of the lattice of this degree.
    weights: Vec<Vec<[f64; D]>>,
    /// From values at i/degree to Bernstein coefficients, `(degree + 1)²` by rows.
    coefficients: Vec<f64>,
}

impl<const D: usize> Determinant<D> {
    fn new(mesh: &Mesh<D>) -> Self {
        let degree = match mesh.shape {
            Shape::Triangle | Shape::Tetrahedron => D * (mesh.degree - 1),
            _ => D * mesh.degree - 1,
        };
        let n = degree + 1;
        let at = |i: usize, d: u32| (i / n.pow(d) % n) as f64 / degree.max(1) as f64;
        let xi = |i: usize| Self::xi(mesh.shape, std::array::from_fn(|d| at(i, d as u32)));
        let weights = (0..n.pow(D as u32)).map(|i| mesh.gradient_weights(xi(i))).collect();
        Determinant { degree, weights, coefficients: bernstein(degree) }
    }

    fn xi(shape: Shape, s: [f64; D]) -> [f64; D] {
        let mut xi = s;
        if shape.is_simplex() {
            for d in 1..D {
                xi[d] *= s[..d].iter().map(|s| 1.0 - s).product::<f64>();
            }
        }
        xi
    }

    /// The whole of `cell`.
    fn whole(&self, mesh: &Mesh<D>, cell: usize) -> Piece<D> {
        let n = self.degree + 1;
        let weights = self.weights.iter();
        let mut values: Vec<f64> =
            weights.map(|weights| determinant(mesh.gradient_by(cell, weights))).collect();
        for d in 0..D {
            lines(n, D, d, |line| {
                let old: Vec<f64> = line.clone().map(|i| values[i]).collect();
                for (row, i) in self.coefficients.chunks(n).zip(line) {
                    values[i] = row.iter().zip(&old).map(|(a, b)| a * b).sum();
                }
            });
        }
        Piece { lower: [0.0; D], upper: [1.0; D], coefficients: values, axis: 0 }
    }

    fn sign(&self, mesh: &Mesh<D>, cell: usize) -> Sign {
        let mut boxes = vec![self.whole(mesh, cell)];
        for _ in 0..BOXES {
            let Some(piece) = boxes.pop() else { return Sign::Positive };
            if self.corners(&piece).any(|(value, _)| value <= 0.0) {
                return Sign::Not;
            }
            if lowest(&piece) <= 0.0 {
                boxes.extend(self.halves(piece));
            }
        }
        Sign::Not
    }

    /// The smallest value in `cell`, to a thousandth of itself.
    fn least(&self, mesh: &Mesh<D>, cell: usize) -> Least {
        let whole = self.whole(mesh, cell);
        let size = whole.coefficients.iter().fold(0.0, |size: f64, c| size.max(c.abs()));
        let (mut least, mut at) = (f64::INFINITY, [0.0; D]);
        let mut boxes = vec![whole];
        for _ in 0..BOXES {
            let Some(piece) = boxes.pop() else { break };
            for (value, s) in self.corners(&piece) {
                if value < least {
                    (least, at) = (value, s);
                }
            }
            let within = (1e-3 * least.abs()).max(1e-9 * size);
            if lowest(&piece) < least - within {
                let [one, two] = self.halves(piece);
                // The more promising half comes first.
                boxes.extend(if lowest(&one) < lowest(&two) { [two, one] } else { [one, two] });
            }
        }
        let relative = if size > 0.0 { least / size } else { 0.0 };
        Least { cell, det: least, relative, at: mesh.map(cell, Self::xi(mesh.shape, at)).to_vec() }
    }

    /// Values at the corners of a box, and where these are.
    fn corners<'a>(&'a self, piece: &'a Piece<D>) -> impl Iterator<Item = (f64, [f64; D])> + 'a {
        (0..1_usize << D).map(move |corner| {
            let upper = |d: usize| corner >> d & 1 == 1;
            let stride = |d: usize| (self.degree + 1).pow(d as u32) * self.degree;
            let index: usize = (0..D).filter(|&d| upper(d)).map(stride).sum();
            let s = std::array::from_fn(|d| if upper(d) { piece.upper[d] } else { piece.lower[d] });
            (piece.coefficients[index], s)
        })
    }

    /// The two halves of a box, by de Casteljau's algorithm.
    fn halves(&self, piece: Piece<D>) -> [Piece<D>; 2] {
        let (n, axis) = (self.degree + 1, piece.axis);
        let (mut left, mut right) = (piece.coefficients.clone(), piece.coefficients);
        lines(n, D, axis, |line| {
            let mut row: Vec<f64> = line.clone().map(|i| left[i]).collect();
            let at: Vec<usize> = line.collect();
            for k in 0..n {
                (left[at[k]], right[at[n - 1 - k]]) = (row[0], row[n - 1 - k]);
                (0..n - 1 - k).for_each(|i| row[i] = 0.5 * (row[i] + row[i + 1]));
            }
        });
        let middle = 0.5 * (piece.lower[axis] + piece.upper[axis]);
        let (mut below, mut above) = (piece.upper, piece.lower);
        (below[axis], above[axis]) = (middle, middle);
        let axis = (axis + 1) % D;
        [
            Piece { lower: piece.lower, upper: below, coefficients: left, axis },
            Piece { lower: above, upper: piece.upper, coefficients: right, axis },
        ]
    }
}

/// Calls `visit` with the indices of every line in direction `axis` of an array of `n^dim` numbers.
fn lines(
    n: usize,
    dim: usize,
    axis: usize,
    mut visit: impl FnMut(std::iter::StepBy<std::ops::Range<usize>>),
) {
    let stride = n.pow(axis as u32);
    for first in (0..n.pow(dim as u32)).filter(|i| (i / stride).is_multiple_of(n)) {
        visit((first..first + n * stride).step_by(stride));
    }
}

/// Inverse of `B_ij = C(n, j) s_i^j (1 − s_i)^(n − j)` with `s_i = i/n`, by rows.
fn bernstein(n: usize) -> Vec<f64> {
    let binomial = |j: usize| (0..j).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
    let mut rows: Vec<Vec<f64>> = (0..=n)
        .map(|i| {
            let s = i as f64 / n.max(1) as f64;
            let basis = (0..=n).map(|j| binomial(j) * s.powi(j as i32) * (1.0 - s).powi((n - j) as i32));
            basis.chain((0..=n).map(|k| f64::from(u8::from(k == i)))).collect()
        })
        .collect();
    for k in 0..=n {
        let pivot = (k..=n).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs())).unwrap_or(k);
        rows.swap(k, pivot);
        let scale = rows[k][k];
        rows[k].iter_mut().for_each(|x| *x /= scale);
        let row = rows[k].clone();
        for (i, other) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            debug_assert!(i != k);
            let factor = other[k];
            other.iter_mut().zip(&row).for_each(|(x, y)| *x -= factor * y);
        }
    }
    rows.into_iter().flat_map(|row| row[n + 1..].to_vec()).collect()
}

#[cfg(test)]
mod tests {
    use crate::element::Shape;
    use crate::mesh::generate::{rotor, schaefer_turek, turek_hron};
    use crate::mesh::{Mesh, MeshError};

    /// The nodes of one cell in lexicographic order.
    fn one_cell(shape: Shape, nodes: Vec<[f64; 2]>) -> Mesh<2> {
        Mesh {
            shape,
            degree: 2,
            cell_nodes: (0..nodes.len() as u32).collect(),
            nodes,
            cell_region: vec![0],
            regions: vec!["fluid".into()],
            facets: vec![],
            parts: vec![],
            boundaries: vec![],
        }
    }

    /// The square with the first mid node of its lower side moved along the side: x' = 0 where the map turns round.
    fn pushed(by: f64) -> Mesh<2> {
        let at = |i: usize| [0.5 * (i % 3) as f64, 0.5 * (i / 3) as f64];
        let mut nodes: Vec<[f64; 2]> = (0..9).map(at).collect();
        nodes[1][0] += by;
        one_cell(Shape::Quadrilateral, nodes)
    }

    /// det DX of the lower side is 1 + 4 by (1 − 2 ξ), least at one end, a node.
    #[test]
    fn a_side_folds_when_its_middle_passes_a_quarter() {
        pushed(0.2499).check_orientation().unwrap();
        pushed(-0.2499).check_orientation().unwrap();
        for by in [0.2501, -0.2501] {
            let Err(MeshError::Inverted(cells, least)) = pushed(by).check_orientation() else {
                panic!("{by}")
            };
            assert_eq!((cells.count, least.cell), (1, 0));
            assert!((least.det + 4e-4).abs() < 1e-12, "{least}");
            assert_eq!(least.at, [if by > 0.0 { 1.0 } else { 0.0 }, 0.0]);
        }
    }

    /// det DX > 0 at all nodes and Gauss points, below 0 between them.
    #[test]
    fn folds_between_nodes_and_gauss_points_are_found() {
        let corners = [
            [-1.321_298, -1.437_636],
            [0.449_551, -0.751_572],
            [0.940_502, -0.764_023],
            [-1.060_962, 0.010_934],
            [-0.274_852, 0.251_950],
            [1.297_568, -0.216_406],
            [-0.804_483, 0.986_063],
            [-0.312_935, 0.729_374],
            [1.102_742, 0.841_732],
        ];
        let mesh = one_cell(Shape::Quadrilateral, corners.to_vec());
        assert!(mesh.quality().inverted.is_empty());
        let Err(MeshError::Inverted(_, least)) = mesh.check_orientation() else { panic!() };
        // 2² times the value on the square of side 2.
        assert!((least.det / 4.0 + 0.0366).abs() < 2e-4, "{least}");
        // The place is in the cell, and no sample is below.
        for i in 0..=200 {
            for j in 0..=200 {
                let det =
                    super::determinant(mesh.map_gradient(0, [f64::from(i) / 200.0, f64::from(j) / 200.0]));
                assert!(det > least.det * 1.002, "{det} {least}");
            }
        }
    }

    /// Random cells of both shapes: the bound says what 10 000 points do, where these are clear.
    #[test]
    fn the_bound_agrees_with_dense_samples() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for shape in [Shape::Triangle, Shape::Quadrilateral] {
            let (mut folded, mut missed) = (0, 0);
            for _ in 0..400 {
                let place = |i: usize| {
                    let at = shape.lattice(2, i);
                    [0.5 * at[0] as f64, 0.5 * at[1] as f64]
                };
                let nodes = (0..shape.n_nodes(2)).map(place);
                let mesh = one_cell(shape, nodes.map(|x| x.map(|x| x + 0.4 * random())).collect());
                let is_in = |i: &(u32, u32)| shape == Shape::Quadrilateral || i.0 + i.1 <= 100;
                let points = (0..=100).flat_map(|i| (0..=100).map(move |j| (i, j))).filter(is_in);
                let dets = points.map(|(i, j)| {
                    super::determinant(mesh.map_gradient(0, [f64::from(i) / 100.0, f64::from(j) / 100.0]))
                });
                let (low, high) = dets.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
                let found = mesh.check_orientation();
                let Err(MeshError::Inverted(_, least)) = found else {
                    assert!(low > 0.0, "{low}");
                    continue;
                };
                folded += 1;
                missed += usize::from(mesh.quality().inverted.is_empty());
                assert!(
                    low < 1e-3 * high && least.det < low + 1e-3 * high && least.det > low - 5e-3 * high,
                    "{low} {high} {least}"
                );
            }
            let is_missed = missed > 0 || shape == Shape::Triangle;
            assert!(folded > 50 && folded < 350 && is_missed, "{shape:?}: {folded}, {missed}");
        }
    }

    #[test]
    fn cells_of_the_built_in_meshes_pass_and_refined_folds_do_not() {
        for mesh in [turek_hron(1, 4), schaefer_turek(1), rotor(1, 2), turek_hron(0, 2).triangulated()] {
            mesh.check_orientation().unwrap();
        }
        let refined = pushed(0.26).refined(2, &[]);
        let Err(MeshError::Inverted(cells, _)) = refined.check_orientation() else { panic!() };
        assert_eq!(cells.count, 1);
    }
}
