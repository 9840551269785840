//! Quadrature points of facets, and fields there.

use crate::element::Quadrature;
use crate::math::{Tensor, Vector};
use crate::mesh::{Facet, Mesh};
use crate::physics::{Fabric, Fields};
use crate::space::{Coordinates, FsiSpace, Nodes, State};

/// One quadrature point on a facet.
#[derive(Clone, Debug)]
pub struct FacetPoint<const D: usize> {
    /// Reference coordinates in the cell.
    pub xi: [f64; D],
    /// Position \[m\].
    pub x: [f64; D],
    /// Distance to the axis \[m\], if there is one.
    pub radius: Option<f64>,
    /// Outer unit normal of the cell.
    pub normal: Vector<f64, D>,
    /// Quadrature weight times surface element \[m^(D−1)\], that of the body of revolution in (r, z) \[m²\].
    pub weight: f64,
    /// The same of the facet itself, whatever the coordinates mean \[m^(D−1)\].
    pub length: f64,
    /// Basis of v and u, `[basis]`.
    pub value: Vec<f64>,
    /// Its gradient with respect to x, `[basis][d]`.
    pub grad: Vec<[f64; D]>,
}

impl<const D: usize> FacetPoint<D> {
    /// (r + u_r)/r around an axis, 1 on it and in the plane.
    pub fn stretch(&self, u: &Vector<f64, D>) -> f64 {
        self.radius.filter(|r| *r > 0.0).map_or(1.0, |r| 1.0 + u.0[0] / r)
    }
}

/// Quadrature points of `facet` with `n` Gauss points per direction.
pub fn facet_points<const D: usize>(space: &FsiSpace<D>, facet: &Facet, n: usize) -> Vec<FacetPoint<D>> {
    let rule = Quadrature::facet(space.mesh.shape, facet.local as usize, n);
    facet_points_of(space, facet, &rule)
}

/// The points of `rule`, which lie on `facet`.
pub fn facet_points_of<const D: usize>(
    space: &FsiSpace<D>,
    facet: &Facet,
    rule: &Quadrature,
) -> Vec<FacetPoint<D>> {
    facet_points_on((&space.mesh, space.coordinates), &space.nodes, facet, rule)
}

/// The same for the basis of `nodes` on `mesh`, whose coordinates mean `coordinates`.
pub fn facet_points_on<const D: usize>(
    (mesh, coordinates): (&Mesh<D>, Coordinates),
    nodes: &Nodes<D>,
    facet: &Facet,
    rule: &Quadrature,
) -> Vec<FacetPoint<D>> {
    let (cell, local) = (facet.cell as usize, facet.local as usize);
    let table = nodes.table(mesh.shape, rule);
    let mut points = vec![];
    for (q, xi) in rule.points.iter().enumerate() {
        let xi: [f64; D] = std::array::from_fn(|d| xi[d]);
        let x = mesh.map(cell, xi);
        let jacobian = Tensor(mesh.map_gradient(cell, xi));
        let cofactor = jacobian.cofactor();
        let inverse_t = cofactor * (1.0 / jacobian.det());
        // Nanson: n dS = cof(DX) N dS for the reference normal N of the facet.
        let normal = mesh.shape.facet_normal(local);
        let area = cofactor * Vector(std::array::from_fn(|d| normal[d]));
        let size = area.dot(area).sqrt();
        let grad = |a: usize| {
            let reference = Vector(std::array::from_fn(|d| table.grad(q)[a * D + d]));
            (inverse_t * reference).0
        };
        points.push(FacetPoint {
            xi,
            x,
            radius: coordinates.radius(&x),
            normal: area * (1.0 / size),
            length: rule.weights[q] * size,
            weight: rule.weights[q] * size * coordinates.measure(&x),
            value: table.value(q).to_vec(),
            grad: (0..table.n_basis).map(grad).collect(),
        });
    }
    points
}

/// Fields v and u of `state` at a point of a cell with the given nodes; p stays zero.
pub fn fields_at<const D: usize>(
    nodes: &[u32],
    value: &[f64],
    grad: &[[f64; D]],
    state: &State,
) -> Fields<f64, D> {
    let mut f = Fields::zero();
    for (a, &node) in nodes.iter().enumerate() {
        let at = node as usize * D;
        for i in 0..D {
            let v = state.v[at + i];
            let u = if state.u.is_empty() { 0.0 } else { state.u[at + i] };
            f.v.0[i] += value[a] * v;
            f.u.0[i] += value[a] * u;
            for d in 0..D {
                f.grad_v.0[i][d] += grad[a][d] * v;
                f.grad_u.0[i][d] += grad[a][d] * u;
            }
        }
    }
    f
}

/// What a solid has at the place `x` \[m\] of a cell, with the values and the gradients of the basis there.
pub fn fabric_at<const D: usize>(
    space: &FsiSpace<D>,
    cell: usize,
    x: &[f64; D],
    basis: (&[f64], &[[f64; D]]),
) -> Fabric<f64, D> {
    let (fibre, unloading, hoop) = space.fabric_at(cell, x, basis);
    Fabric { fibre, unloading, hoop }
}
