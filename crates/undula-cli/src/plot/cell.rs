//! The plane reference cell of a picture: values between the points of a cell, and its sides.

use undula::output::{CellKind, FieldSnapshot};

/// A reference cell of some degree, its points in lexicographic order.
#[derive(Copy, Clone)]
pub struct Reference {
    kind: CellKind,
    degree: usize,
}

/// A cell cut into small triangles.
pub struct Pieces {
    /// For every corner of the triangles the weights of the points of the cell.
    pub weights: Vec<Vec<f64>>,
    /// Corners of the triangles.
    pub triangles: Vec<[usize; 3]>,
}

impl Reference {
    /// That of the cells of `snapshot`.
    pub fn of(snapshot: &FieldSnapshot) -> Self {
        Reference { kind: snapshot.kind, degree: snapshot.degree }
    }

    /// The points `(i, j)`, `0..=n` in each direction as far as the cell reaches, row by row.
    fn lattice(self, n: usize) -> Vec<(usize, usize)> {
        let end = |j: usize| if self.kind == CellKind::Triangle { n - j } else { n };
        (0..=n).flat_map(|j| (0..=end(j)).map(move |i| (i, j))).collect()
    }

    /// Cut into `n` pieces per direction.
    pub fn pieces(self, n: usize) -> Pieces {
        let table: Vec<Vec<f64>> = (0..=n).map(|i| lagrange(self.degree, i as f64 / n as f64)).collect();
        let weights = |&(i, j): &(usize, usize)| -> Vec<f64> {
            let weight = |&(a, b): &(usize, usize)| match self.kind {
                CellKind::Triangle => {
                    let c = self.degree - a - b;
                    let [x, y] = [i, j].map(|i| i as f64 / n as f64);
                    [(a, x), (b, y), (c, 1.0 - x - y)]
                        .iter()
                        .map(|&(m, s)| factor(self.degree, m, s))
                        .product()
                }
                _ => table[i][a] * table[j][b],
            };
            self.lattice(self.degree).iter().map(weight).collect()
        };
        let points = self.lattice(n);
        let number = |i: usize, j: usize| points.binary_search_by_key(&(j, i), |&(i, j)| (j, i)).ok();
        let mut triangles = vec![];
        for (i, j) in self.lattice(n.saturating_sub(1)) {
            let corner = |a: usize, b: usize| number(i + a, j + b);
            let halves = match self.kind {
                // The second one is missing at the long side.
                CellKind::Triangle => [[(0, 0), (1, 0), (0, 1)], [(1, 0), (1, 1), (0, 1)]],
                _ => [[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]],
            };
            for triangle in halves {
                if let [Some(a), Some(b), Some(c)] = triangle.map(|(a, b)| corner(a, b)) {
                    triangles.push([a, b, c]);
                }
            }
        }
        Pieces { weights: points.iter().map(weights).collect(), triangles }
    }

    /// The points on each side, in order along it.
    pub fn sides(self) -> Vec<Vec<usize>> {
        let k = self.degree;
        let lattice = self.lattice(k);
        let on = |keep: &dyn Fn(usize, usize) -> bool| -> Vec<usize> {
            (0..lattice.len()).filter(|&n| keep(lattice[n].0, lattice[n].1)).collect()
        };
        let mut sides = vec![on(&|_, j| j == 0), on(&|i, _| i == 0)];
        match self.kind {
            CellKind::Triangle => sides.push(on(&|i, j| i + j == k)),
            _ => sides.extend([on(&|i, _| i == k), on(&|_, j| j == k)]),
        }
        sides
    }
}

/// Values of the Lagrange polynomials on equidistant nodes in [0, 1] at `s`.
pub fn lagrange(degree: usize, s: f64) -> Vec<f64> {
    let node = |i: usize| i as f64 / degree as f64;
    let one =
        |i: usize| (0..=degree).filter(|&j| j != i).map(|j| (s - node(j)) / (node(i) - node(j))).product();
    (0..=degree).map(one).collect()
}

/// The factor of a barycentric coordinate in the basis of a simplex: 1 at s = m/degree, 0 at the nodes before.
pub fn factor(degree: usize, m: usize, s: f64) -> f64 {
    (0..m).map(|l| (degree as f64 * s - l as f64) / (l + 1) as f64).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_cover_the_cell_and_interpolate() {
        for (kind, area) in [(CellKind::Quadrilateral, 1.0), (CellKind::Triangle, 0.5)] {
            for degree in 1..4 {
                let cell = Reference { kind, degree };
                let nodes = cell.lattice(degree);
                for n in [1, 2, 5] {
                    let Pieces { weights, triangles } = cell.pieces(n);
                    let at: Vec<[f64; 2]> = weights
                        .iter()
                        .map(|w| {
                            let sum = |d: usize| {
                                let of = |&(i, j): &(usize, usize)| [i, j][d] as f64 / degree as f64;
                                w.iter().zip(&nodes).map(|(w, node)| w * of(node)).sum::<f64>()
                            };
                            [sum(0), sum(1)]
                        })
                        .collect();
                    for (x, (i, j)) in at.iter().zip(cell.lattice(n)) {
                        assert!((x[0] - i as f64 / n as f64).abs() < 1e-12);
                        assert!((x[1] - j as f64 / n as f64).abs() < 1e-12);
                    }
                    let size = |&[a, b, c]: &[usize; 3]| {
                        let [a, b, c] = [at[a], at[b], at[c]];
                        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
                    };
                    let total: f64 = triangles.iter().map(|t| size(t).abs()).sum();
                    assert!(triangles.iter().all(|t| size(t) >= 0.0));
                    assert!((total - area).abs() < 1e-12, "{kind:?} {degree} {n}: {total}");
                }
                assert!(cell.sides().iter().all(|side| side.len() == degree + 1));
            }
        }
    }
}
