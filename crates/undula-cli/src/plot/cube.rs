//! The reference cube of a picture, cut into small tetrahedra.

use super::cell::lagrange;

/// The points (i, j, k) / n, `0..=n` each, of the reference cube, i fastest.
pub struct Cube {
    n: usize,
    /// For every point the weights of the nodes of a cell, in lexicographic order.
    pub weights: Vec<Vec<f64>>,
}

/// Corners of the six tetrahedra of a little cube, bit d of a corner for its coordinate d. All have the diagonal from 0 to
/// 7, so that those of neighbours meet face to face.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]];

impl Cube {
    /// `n` pieces per direction of a cell of degree `degree`.
    pub fn new(degree: usize, n: usize) -> Self {
        let table: Vec<Vec<f64>> = (0..=n).map(|i| lagrange(degree, i as f64 / n as f64)).collect();
        let nodes = degree + 1;
        let weights = |point: usize| -> Vec<f64> {
            let [i, j, k] = lattice(point, n + 1);
            let weight = |node: usize| {
                let [a, b, c] = lattice(node, nodes);
                table[i][a] * table[j][b] * table[k][c]
            };
            (0..nodes.pow(3)).map(weight).collect()
        };
        Cube { n, weights: (0..(n + 1).pow(3)).map(weights).collect() }
    }

    /// Points of the little cubes, corners in lexicographic order.
    pub fn cubes(&self) -> impl Iterator<Item = [usize; 8]> + use<> {
        let n = self.n;
        (0..n.pow(3)).map(move |cube| {
            let from = lattice(cube, n);
            std::array::from_fn(|corner| number(std::array::from_fn(|d| from[d] + (corner >> d & 1)), n + 1))
        })
    }

    /// Points of the tetrahedra of a little cube.
    pub fn tetrahedra(cube: [usize; 8]) -> [[usize; 4]; 6] {
        TETRAHEDRA.map(|corners| corners.map(|corner| cube[corner]))
    }

    /// Points of the triangles of face `facet`, which are sides of the tetrahedra. Faces are numbered x-, x+, y-, y+, z-, z+.
    pub fn face(&self, facet: usize) -> Vec<[usize; 3]> {
        let n = self.n;
        let [u, v] = across(facet / 2);
        let at = |i: usize, j: usize| {
            let mut at = [facet % 2 * n; 3];
            (at[u], at[v]) = (i, j);
            number(at, n + 1)
        };
        let halves = |(i, j): (usize, usize)| {
            let [low, high] = [at(i, j), at(i + 1, j + 1)];
            [[low, at(i + 1, j), high], [low, high, at(i, j + 1)]]
        };
        (0..n).flat_map(|j| (0..n).map(move |i| (i, j))).flat_map(halves).collect()
    }

    /// Points along the four sides of face `facet`.
    pub fn sides(&self, facet: usize) -> [Vec<usize>; 4] {
        let n = self.n;
        let [u, v] = across(facet / 2);
        [(u, v, 0), (u, v, n), (v, u, 0), (v, u, n)].map(|(along, beside, end)| {
            let at = |i: usize| {
                let mut at = [facet % 2 * n; 3];
                (at[along], at[beside]) = (i, end);
                number(at, n + 1)
            };
            (0..=n).map(at).collect()
        })
    }
}

/// The four corners of face `facet` among the nodes of a cell of degree `degree`, in lexicographic order.
pub fn face_corners(degree: usize, facet: usize) -> [usize; 4] {
    let [u, v] = across(facet / 2);
    std::array::from_fn(|corner| {
        let mut at = [facet % 2 * degree; 3];
        (at[u], at[v]) = ((corner & 1) * degree, (corner >> 1) * degree);
        number(at, degree + 1)
    })
}

/// The two other axes.
pub fn across(axis: usize) -> [usize; 2] {
    [[1, 2], [0, 2], [0, 1]][axis]
}

fn lattice(number: usize, n: usize) -> [usize; 3] {
    [number % n, number / n % n, number / (n * n)]
}

fn number([i, j, k]: [usize; 3], n: usize) -> usize {
    i + n * (j + n * k)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tetrahedra_fill_the_cube_and_faces_are_their_sides() {
        for (degree, n) in [(1, 1), (2, 2), (3, 5)] {
            let cube = Cube::new(degree, n);
            let at = |point: usize| -> [f64; 3] {
                let weights = &cube.weights[point];
                std::array::from_fn(|d| {
                    let of = |node: usize| lattice(node, degree + 1)[d] as f64 / degree as f64;
                    weights.iter().enumerate().map(|(node, w)| w * of(node)).sum()
                })
            };
            for point in 0..cube.weights.len() {
                let right = lattice(point, n + 1).map(|i| i as f64 / n as f64);
                (0..3).for_each(|d| assert!((at(point)[d] - right[d]).abs() < 1e-12));
            }
            let tetrahedra: Vec<[usize; 4]> = cube.cubes().flat_map(Cube::tetrahedra).collect();
            let size = |t: &[usize; 4]| {
                let o = at(t[0]);
                let [a, b, c] =
                    [1, 2, 3].map(|i| -> [f64; 3] { std::array::from_fn(|d| at(t[i])[d] - o[d]) });
                let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
                (cross[0] * c[0] + cross[1] * c[1] + cross[2] * c[2]).abs() / 6.0
            };
            let one = 1.0 / tetrahedra.len() as f64;
            assert!(tetrahedra.iter().all(|t| (size(t) - one).abs() < 1e-12));
            for facet in 0..6 {
                let triangles = cube.face(facet);
                assert_eq!(triangles.len(), 2 * n * n);
                for side in cube.sides(facet) {
                    assert_eq!(side.len(), n + 1);
                    let on_face = |p| triangles.iter().any(|t| t.contains(p));
                    assert!(side.iter().all(on_face));
                }
                for triangle in triangles {
                    assert!(triangle.iter().all(|&p| (at(p)[facet / 2] - (facet % 2) as f64).abs() < 1e-12));
                    let owners = tetrahedra.iter().filter(|t| triangle.iter().all(|p| t.contains(p)));
                    assert_eq!(owners.count(), 1);
                }
                for node in face_corners(degree, facet) {
                    assert_eq!(lattice(node, degree + 1)[facet / 2], facet % 2 * degree);
                }
            }
        }
    }
}
