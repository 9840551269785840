//! Normals at nodes of boundaries, straight and curved ones.

use super::FsiSpace;
use crate::element::{Quadrature, Shape, lagrange};
use crate::math::{Tensor, Vector};
use crate::mesh::Facet;
use std::collections::BTreeMap;

/// Facets whose normals at a node differ by more than this angle meet in a corner there, cos 40°; else they are parts of
/// one curved boundary.
const CORNER: f64 = 0.766;

/// Directions agree with an axis up to this.
const STRAIGHT: f64 = 1e-9;

/// The normals at every node of the facets, orthonormal to each other: one where they are parts of one smooth boundary,
/// several in corners and edges.
///
/// The normal of a smooth boundary at node a is that of ∫ φ_a n ds: with n_a·v_a = 0 at all its nodes nothing flows
/// through the boundary as a whole, curved or not. On tetrahedra it is the mean of the normals at the node itself.
/// Directions of axes are exact.
pub fn normals<'a, const D: usize>(
    space: &FsiSpace<D>,
    facets: impl Iterator<Item = &'a Facet>,
) -> BTreeMap<u32, Vec<Vector<f64, D>>> {
    let mut found: BTreeMap<u32, Vec<Vector<f64, D>>> = BTreeMap::new();
    for facet in facets {
        for (node, normal) in of_facet(space, facet) {
            let here = found.entry(node).or_default();
            let size = |n: Vector<f64, D>| n.dot(n).sqrt();
            match here.iter_mut().find(|n| n.dot(normal) >= CORNER * size(**n) * size(normal)) {
                Some(sum) => *sum += normal,
                None => here.push(normal),
            }
        }
    }
    found.values_mut().for_each(orthonormal);
    found
}

/// ∫ φ_a n ds of the nodes a of a facet \[m^(D−1)\], with the weight 2π r in (r, z) off the axis. On a tetrahedron it is
/// n(x_a) ∫ |φ_a| ds: φ_a of corners has no integral with degree 2, and triangles need not be symmetric about a node,
/// so that the mean over them may be wrong by O(h).
fn of_facet<const D: usize>(space: &FsiSpace<D>, facet: &Facet) -> Vec<(u32, Vector<f64, D>)> {
    let mesh = &space.mesh;
    let (cell, local) = (facet.cell as usize, facet.local as usize);
    let rule = Quadrature::facet(mesh.shape, local, space.nodes.degree + D * mesh.degree);
    let table = space.nodes.table(mesh.shape, &rule);
    let reference = mesh.shape.facet_normal(local);
    let place = |q: usize| mesh.map(cell, std::array::from_fn(|d| rule.points[q][d]));
    // The axis has no area, but a normal.
    let measure = |q: usize| space.coordinates.measure(&place(q));
    let on_axis = (0..rule.points.len()).all(|q| measure(q) == 0.0);
    let density = |xi: [f64; D]| {
        let cofactor = Tensor(mesh.map_gradient(cell, xi)).cofactor();
        cofactor * Vector(std::array::from_fn(|d| reference[d]))
    };
    let area = |q: usize| {
        let weight = if on_axis { 1.0 } else { measure(q) } * rule.weights[q];
        density(std::array::from_fn(|d| rule.points[q][d])) * weight
    };
    let areas: Vec<Vector<f64, D>> = (0..rule.points.len()).map(area).collect();
    let degree = space.nodes.degree;
    let of_node = mesh.shape == Shape::Tetrahedron;
    let normal = |(a, node): (usize, u32)| {
        let value = |q: usize| table.value(q)[a];
        // Bubbles of facets are no nodes.
        if of_node && a < mesh.shape.n_nodes(degree) {
            let at = lagrange::node(mesh.shape, degree, a);
            let size = (0..rule.points.len()).map(|q| rule.weights[q] * value(q).abs()).sum::<f64>();
            return (node, density(std::array::from_fn(|d| at[d])) * size);
        }
        (node, areas.iter().enumerate().fold(Vector::zero(), |sum, (q, n)| sum + *n * value(q)))
    };
    space.facet_functions(facet).into_iter().map(normal).collect()
}

/// Makes the directions orthonormal, and axes exact; what depends on those before is left out.
fn orthonormal<const D: usize>(normals: &mut Vec<Vector<f64, D>>) {
    let mut basis: Vec<Vector<f64, D>> = vec![];
    for &normal in normals.iter() {
        let unit = normal * (1.0 / normal.dot(normal).sqrt());
        let rest = basis.iter().fold(unit, |rest, n| rest - *n * n.dot(unit));
        let size = rest.dot(rest).sqrt();
        if size > STRAIGHT.sqrt() {
            basis.push(straightened(rest * (1.0 / size)));
        }
    }
    *normals = basis;
}

fn straightened<const D: usize>(n: Vector<f64, D>) -> Vector<f64, D> {
    let axis = (0..D).find(|&d| (0..D).all(|other| other == d || n.0[other].abs() <= STRAIGHT));
    axis.map_or(n, |axis| Vector(std::array::from_fn(|d| if d == axis { n.0[d].signum() } else { 0.0 })))
}

/// The axis of a direction, if it is one.
pub fn axis<const D: usize>(n: &Vector<f64, D>) -> Option<usize> {
    (0..D).find(|&d| n.0[d].abs() == 1.0)
}
