//! Fields at all quadrature points, one by one in `f64`: for functionals, errors and sources.

use super::facets::{fabric_at, fields_at};
use crate::element::Quadrature;
use crate::math::Tensor;
use crate::physics::{Fabric, Fields};
use crate::space::{FsiSpace, Region, State};

/// One quadrature point.
pub struct PointValues<'a, const D: usize> {
    /// Cell.
    pub cell: usize,
    /// Its region.
    pub region: Region,
    /// Position \[m\].
    pub x: [f64; D],
    /// Quadrature weight times |det ∂x/∂ξ| \[m^D\], times 2π r in (r, z) \[m³\].
    pub weight: f64,
    /// The fields there.
    pub fields: Fields<f64, D>,
    /// What a solid has there.
    pub fabric: Fabric<f64, D>,
    /// Basis of v and u, `[basis]`.
    pub value: &'a [f64],
    /// Its gradient with respect to x.
    pub grad: &'a [[f64; D]],
    /// Basis of p; empty in the solid.
    pub pressure: &'a [f64],
}

/// Call `visit` at every point of the rule of number `n`, see [`Quadrature::cell`]. In cells without a bubble the basis
/// may be one longer than the list of nodes.
pub fn for_each_point<const D: usize>(
    space: &FsiSpace<D>,
    state: &State,
    n: usize,
    visit: impl FnMut(&PointValues<'_, D>),
) {
    for_each_point_of(space, state, &Quadrature::cell(space.mesh.shape, n), |_| true, visit);
}

/// Call `visit` at the points of `rule` in every cell that is `wanted`.
pub fn for_each_point_of<const D: usize>(
    space: &FsiSpace<D>,
    state: &State,
    rule: &Quadrature,
    wanted: impl Fn(usize) -> bool,
    mut visit: impl FnMut(&PointValues<'_, D>),
) {
    let mesh = &space.mesh;
    let table = space.nodes.table(mesh.shape, rule);
    let mut grad = vec![[0.0; D]; table.n_basis];
    for cell in (0..mesh.n_cells()).filter(|&cell| wanted(cell)) {
        for (q, xi) in rule.points.iter().enumerate() {
            let xi: [f64; D] = std::array::from_fn(|d| xi[d]);
            let x = mesh.map(cell, xi);
            let jacobian = Tensor(mesh.map_gradient(cell, xi));
            let det = jacobian.det();
            let inverse_t = jacobian.cofactor() * (1.0 / det);
            for (a, grad) in grad.iter_mut().enumerate() {
                let reference = crate::math::Vector(std::array::from_fn(|d| table.grad(q)[a * D + d]));
                *grad = (inverse_t * reference).0;
            }
            let mut fields = fields_at(space.nodes.cell(cell), table.value(q), &grad, state);
            let dofs = space.pressure.cell(cell);
            let pressure = if dofs.is_empty() { vec![] } else { space.pressure.basis(mesh, cell, &xi, &x) };
            fields.p = dofs.iter().zip(&pressure).map(|(&dof, b)| b * state.p[dof as usize]).sum();
            visit(&PointValues {
                cell,
                region: space.regions[cell],
                x,
                weight: rule.weights[q] * det * space.coordinates.measure(&x),
                fields,
                fabric: fabric_at(space, cell, &x, (table.value(q), &grad)),
                value: table.value(q),
                grad: &grad,
                pressure: &pressure,
            });
        }
    }
}
