//! The order in which VTK has the nodes of a cell.

use super::CellKind;

/// Lexicographic numbers of the nodes of a cell in the order of VTK: vertices, edges, interior.
///
/// Vertices go round; edges of quadrilaterals are bottom, right, top, left, each in the direction of its coordinate. This is
/// the order of `VTK_QUAD`, `VTK_BIQUADRATIC_QUAD` and `VTK_LAGRANGE_QUADRILATERAL` alike. Edges of triangles
/// go round, too.
pub fn vtk_order(kind: CellKind, degree: usize) -> Vec<usize> {
    let k = degree;
    if kind == CellKind::Hexahedron {
        return hexahedron_order(k);
    }
    if kind == CellKind::Tetrahedron {
        return tetrahedron_order(k);
    }
    if kind == CellKind::Triangle {
        let mut lattice = vec![(0, 0), (k, 0), (0, k)];
        lattice.extend((1..k).map(|i| (i, 0)));
        lattice.extend((1..k).map(|j| (k - j, j)));
        lattice.extend((1..k).map(|j| (0, k - j)));
        // Inside there is one point at most.
        lattice.extend((1..k.saturating_sub(1)).map(|i| (i, 1)));
        return lattice.into_iter().map(|(i, j)| i + (0..j).map(|row| k + 1 - row).sum::<usize>()).collect();
    }
    let mut lattice = vec![(0, 0), (k, 0), (k, k), (0, k)];
    lattice.extend((1..k).map(|i| (i, 0)));
    lattice.extend((1..k).map(|j| (k, j)));
    lattice.extend((1..k).map(|i| (i, k)));
    lattice.extend((1..k).map(|j| (0, j)));
    lattice.extend((1..k).flat_map(|j| (1..k).map(move |i| (i, j))));
    lattice.into_iter().map(|(i, j)| i + (k + 1) * j).collect()
}

/// The same for hexahedra: vertices and edges of the bottom and of the top, upright edges, faces x-, x+, y-, y+, z-, z+,
/// interior.
///
/// This is the order of `VTK_HEXAHEDRON`, `VTK_TRIQUADRATIC_HEXAHEDRON` and, in files of version 2.1, of
/// `VTK_LAGRANGE_HEXAHEDRON`; in older files the last two upright edges of the latter change places.
fn hexahedron_order(k: usize) -> Vec<usize> {
    let round = [(0, 0), (k, 0), (k, k), (0, k)];
    let between = || 1..k;
    let inside = || between().flat_map(move |b| between().map(move |a| (a, b)));
    let mut lattice: Vec<[usize; 3]> = Vec::with_capacity((k + 1).pow(3));
    for z in [0, k] {
        lattice.extend(round.map(|(x, y)| [x, y, z]));
    }
    for z in [0, k] {
        lattice.extend(between().map(|x| [x, 0, z]));
        lattice.extend(between().map(|y| [k, y, z]));
        lattice.extend(between().map(|x| [x, k, z]));
        lattice.extend(between().map(|y| [0, y, z]));
    }
    for (x, y) in round {
        lattice.extend(between().map(|z| [x, y, z]));
    }
    for x in [0, k] {
        lattice.extend(inside().map(|(y, z)| [x, y, z]));
    }
    for y in [0, k] {
        lattice.extend(inside().map(|(x, z)| [x, y, z]));
    }
    for z in [0, k] {
        lattice.extend(inside().map(|(x, y)| [x, y, z]));
    }
    lattice.extend(between().flat_map(|z| inside().map(move |(x, y)| [x, y, z])));
    lattice.into_iter().map(|[x, y, z]| x + (k + 1) * (y + (k + 1) * z)).collect()
}

/// The same for tetrahedra, up to degree 3: vertices, edges round the bottom and those to the top, faces opposite to the
/// vertices 2, 0, 1 and 3.
fn tetrahedron_order(k: usize) -> Vec<usize> {
    let weights = |at: &[(usize, usize)]| {
        let mut shares = [0; 4];
        at.iter().for_each(|&(vertex, weight)| shares[vertex] = weight);
        [shares[1], shares[2], shares[3]]
    };
    let mut lattice: Vec<[usize; 3]> = (0..4).map(|v| weights(&[(v, k)])).collect();
    for (from, to) in [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)] {
        lattice.extend((1..k).map(|i| weights(&[(from, k - i), (to, i)])));
    }
    if k == 3 {
        lattice
            .extend([[0, 1, 3], [1, 2, 3], [0, 2, 3], [0, 1, 2]].map(|face| weights(&face.map(|v| (v, 1)))));
    }
    let row = |n: usize| (n + 1) * (n + 2) / 2;
    let number = |[i, j, l]: [usize; 3]| {
        (0..l).map(|l| row(k - l)).sum::<usize>() + (0..j).map(|j| k - l + 1 - j).sum::<usize>() + i
    };
    lattice.into_iter().map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figures of the VTK file format: vertices round the cell, then edges, then the interior.
    #[test]
    fn nodes_are_in_the_order_of_vtk() {
        let quadrilateral = |k| vtk_order(CellKind::Quadrilateral, k);
        assert_eq!(quadrilateral(1), [0, 1, 3, 2]);
        assert_eq!(quadrilateral(2), [0, 2, 8, 6, 1, 5, 7, 3, 4]);
        assert_eq!(quadrilateral(3), [0, 3, 15, 12, 1, 2, 7, 11, 13, 14, 4, 8, 5, 6, 9, 10]);
        let triangle = |k| vtk_order(CellKind::Triangle, k);
        assert_eq!(triangle(1), [0, 1, 2]);
        assert_eq!(triangle(2), [0, 2, 5, 1, 4, 3]);
        assert_eq!(triangle(3), [0, 3, 9, 1, 2, 6, 8, 7, 4, 5]);
        let tetrahedron = |k| vtk_order(CellKind::Tetrahedron, k);
        assert_eq!(tetrahedron(1), [0, 1, 2, 3]);
        assert_eq!(tetrahedron(2), [0, 2, 5, 9, 1, 4, 3, 6, 7, 8]);
        let edges = [1, 2, 6, 8, 7, 4, 10, 16, 12, 17, 15, 18];
        assert_eq!(tetrahedron(3), [&[0, 3, 9, 19][..], &edges, &[11, 14, 13, 5]].concat());
        let hexahedron = |k| vtk_order(CellKind::Hexahedron, k);
        assert_eq!(hexahedron(1), [0, 1, 3, 2, 4, 5, 7, 6]);
        let [corners, bottom, top] =
            [[0, 2, 8, 6, 18, 20, 26, 24].as_slice(), &[1, 5, 7, 3], &[19, 23, 25, 21]];
        let [upright, faces] = [[9, 11, 17, 15].as_slice(), &[12, 14, 10, 16, 4, 22, 13]];
        assert_eq!(hexahedron(2), [corners, bottom, top, upright, faces].concat());
        let third = hexahedron(3);
        assert_eq!(third[..12], [0, 3, 15, 12, 48, 51, 63, 60, 1, 2, 7, 11]);
        assert_eq!(third[24..32], [16, 32, 19, 35, 31, 47, 28, 44]);
        assert_eq!(third[32..40], [20, 24, 36, 40, 23, 27, 39, 43]);
        assert_eq!(third[56..], [21, 22, 25, 26, 37, 38, 41, 42]);
        let every: std::collections::BTreeSet<usize> = hexahedron(4).into_iter().collect();
        assert!(every.into_iter().eq(0..125));
    }
}
