//! Tetrahedra as hexahedra for pictures.

use super::cell::factor;
use std::path::Path;
use undula::output::{CellKind, Field, FieldSnapshot, OutputError, read_snapshot};

/// The fields of a file for pictures, whose cells are triangles, quadrilaterals or hexahedra.
///
/// # Errors
/// If the file cannot be read.
pub fn read_fields(path: impl AsRef<Path>) -> Result<FieldSnapshot, OutputError> {
    Ok(as_hexahedra(read_snapshot(path)?.0))
}

/// The same fields on hexahedra, tetrahedra being the images of cubes under ξ = s, η = t (1 − s), ζ = r (1 − s)(1 − t), on
/// which a polynomial keeps its degree in each coordinate. Two sides of such a hexahedron have no area. Other cells are
/// returned as they are.
pub fn as_hexahedra(snapshot: FieldSnapshot) -> FieldSnapshot {
    if snapshot.kind != CellKind::Tetrahedron {
        return snapshot;
    }
    let (k, n) = (snapshot.degree, snapshot.points_per_cell());
    let weights = weights(k);
    let values = |field: &Field| -> Vec<f64> {
        let c = field.components;
        let sum = |cell: &[u32], weights: &[f64], i: usize| {
            cell.iter().zip(weights).map(|(&p, w)| w * field.values[c * p as usize + i]).sum::<f64>()
        };
        let cells = snapshot.cells.chunks_exact(n);
        let points = cells.flat_map(|cell| weights.iter().map(move |weights| (cell, weights)));
        points.flat_map(|(cell, weights)| (0..c).map(move |i| sum(cell, weights, i))).collect()
    };
    let places = Field::new("", 3, snapshot.points.iter().flatten().copied().collect());
    let points: Vec<[f64; 3]> = values(&places).chunks_exact(3).map(|x| [x[0], x[1], x[2]]).collect();
    let point_data = snapshot.point_data.iter();
    let point_data = point_data.map(|field| Field::new(field.name.clone(), field.components, values(field)));
    FieldSnapshot {
        kind: CellKind::Hexahedron,
        degree: k,
        cells: (0..points.len() as u32).collect(),
        point_data: point_data.collect(),
        points,
        cell_data: snapshot.cell_data,
    }
}

/// The basis of degree `k` of a tetrahedron at the nodes of the cube.
fn weights(k: usize) -> Vec<Vec<f64>> {
    let layer = |l: usize| (0..=k - l).flat_map(move |j| (0..=k - l - j).map(move |i| [i, j, l]));
    let nodes: Vec<[usize; 3]> = (0..=k).flat_map(layer).collect();
    let row = |point: usize| {
        let [s, t, r] =
            [point % (k + 1), point / (k + 1) % (k + 1), point / (k + 1).pow(2)].map(|i| i as f64 / k as f64);
        let xi = [s, t * (1.0 - s), r * (1.0 - s) * (1.0 - t)];
        let rest = 1.0 - xi.iter().sum::<f64>();
        let weight = |&[i, j, l]: &[usize; 3]| {
            let factors = [(i, xi[0]), (j, xi[1]), (l, xi[2]), (k - i - j - l, rest)];
            factors.map(|(m, s)| factor(k, m, s)).iter().product()
        };
        nodes.iter().map(weight).collect()
    };
    (0..(k + 1).pow(3)).map(row).collect()
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// The unit cube in six tetrahedra of degree `k`, with a field of that degree.
    pub fn cube(k: usize) -> FieldSnapshot {
        let mut mesh = FieldSnapshot { kind: CellKind::Tetrahedron, degree: k, ..FieldSnapshot::default() };
        for [a, b, _] in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let mut corners = [[0.0; 3]; 4];
            (1..4).for_each(|v| corners[v][a] = 1.0);
            (2..4).for_each(|v| corners[v][b] = 1.0);
            corners[3] = [1.0; 3];
            if (b + 3 - a) % 3 == 2 {
                corners.swap(1, 2);
            }
            for l in 0..=k {
                for (j, i) in (0..=k - l).flat_map(|j| (0..=k - l - j).map(move |i| (j, i))) {
                    let shares = [k - i - j - l, i, j, l].map(|w| w as f64 / k as f64);
                    mesh.cells.push(mesh.points.len() as u32);
                    let at = |d: usize| (0..4).map(|v| shares[v] * corners[v][d]).sum::<f64>();
                    mesh.points.push([0, 1, 2].map(at));
                }
            }
        }
        let f = |x: &[f64; 3]| (x[0] + 2.0 * x[1] - x[2]).powi(k as i32);
        mesh.point_data = vec![Field::new("pressure", 1, mesh.points.iter().map(f).collect())];
        mesh
    }

    #[test]
    fn fields_of_tetrahedra_are_kept() {
        for k in 1..=3 {
            let cubes = as_hexahedra(cube(k));
            assert_eq!((cubes.n_cells(), cubes.points.len()), (6, 6 * (k + 1).pow(3)));
            let values = &cubes.at_points("pressure").unwrap().values;
            for (x, value) in cubes.points.iter().zip(values) {
                let exact = (x[0] + 2.0 * x[1] - x[2]).powi(k as i32);
                assert!((value - exact).abs() < 1e-12, "{k} {x:?}: {value} {exact}");
            }
        }
    }
}
