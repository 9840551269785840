//! Functions of a cell as functions of its children.

use crate::element::{Shape, lagrange};
use crate::mesh::{Mesh, Split};
use crate::space::{PressureKind, PressureSpace};

/// Weights that are not zero begin here.
pub const ZERO: f64 = 1e-12;

/// A child and its node at node `a` of a cell.
pub fn in_child(shape: Shape, split: Split, degree: usize, a: usize) -> (usize, usize) {
    let at = shape.lattice(degree, a).map(|i| 2 * i);
    let found = (0..split.children(shape.dim())).find_map(|child| {
        let is_at = |b: &usize| split.in_parent(shape, degree, child, shape.lattice(degree, *b)) == at;
        (0..shape.n_nodes(degree)).find(is_at).map(|b| (child, b))
    });
    found.expect("nodes of a cell are nodes of its children")
}

/// The nodes of a child from those of its cell: (node of the cell, weight) for each.
pub fn weights(shape: Shape, split: Split, degree: usize, child: usize) -> Vec<Vec<(usize, f64)>> {
    let of = |a: usize| {
        let xi = lagrange::node(shape, degree, a);
        let values = lagrange::basis(shape, degree, &split.to_parent(shape, child, xi)).0;
        values.into_iter().enumerate().filter(|(_, weight)| weight.abs() > ZERO).collect()
    };
    (0..shape.n_nodes(degree)).map(of).collect()
}

/// The pressures of a cell from those of the coarser cell that it is `child` of: weights of these for each.
pub fn pressure_weights<const D: usize>(
    (mesh, finer, fine): (&Mesh<D>, &PressureSpace<D>, usize),
    (coarse_mesh, coarser, cell): (&Mesh<D>, &PressureSpace<D>, usize),
    (split, child): (Split, usize),
) -> Vec<Vec<f64>> {
    let shape = mesh.shape;
    let at_parent = |xi: [f64; 3]| {
        let inside: [f64; D] = std::array::from_fn(|d| xi[d]);
        split.to_parent(shape, child, inside)
    };
    if let PressureKind::Continuous(degree) = finer.kind {
        let of = |a: usize| lagrange::basis(shape, degree, &at_parent(lagrange::node(shape, degree, a))).0;
        return (0..finer.per_cell).map(of).collect();
    }
    // The functions of the coarser cell are polynomials in x, as those of its children: they agree in points enough.
    let degree = finer.kind.degree();
    let points: Vec<[f64; 3]> = match degree {
        0 => vec![shape.centre()],
        _ => (0..shape.n_nodes(degree)).map(|a| lagrange::node(shape, degree, a)).collect(),
    };
    let (mut left, mut right) = (vec![], vec![]);
    for xi in points {
        let at: [f64; D] = std::array::from_fn(|d| xi[d]);
        let x = mesh.map(fine, at);
        left.push(finer.basis(mesh, fine, &at, &x));
        right.push(coarser.basis(coarse_mesh, cell, &at_parent(xi), &x));
    }
    least_squares(&left, &right)
}

/// X with the least ‖L X − R‖, by the normal equations.
pub fn least_squares(left: &[Vec<f64>], right: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let (n, m) = (left[0].len(), right[0].len());
    let product = |one: &[Vec<f64>], i: usize, two: &[Vec<f64>], j: usize| -> f64 {
        one.iter().zip(two).map(|(one, two)| one[i] * two[j]).sum()
    };
    let mut a: Vec<Vec<f64>> = (0..n)
        .map(|i| {
            let matrix = (0..n).map(|j| product(left, i, left, j));
            matrix.chain((0..m).map(|j| product(left, i, right, j))).collect()
        })
        .collect();
    for k in 0..n {
        for i in (0..n).filter(|&i| i != k) {
            let factor = a[i][k] / a[k][k];
            let pivot = a[k].clone();
            a[i].iter_mut().zip(&pivot).for_each(|(entry, pivot)| *entry -= factor * pivot);
        }
    }
    (0..n).map(|i| a[i][n..].iter().map(|entry| entry / a[i][i]).collect()).collect()
}
