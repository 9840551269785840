//! A solution on the spaces of another mesh.

use super::fields::{Fields, PointFields};
use crate::element::lagrange::n_bubbles;
use crate::element::{Quadrature, Shape, lagrange};
use crate::math::Tensor;
use crate::mesh::{Locator, MeshError};
use crate::space::{FsiSpace, PressureKind, PsiOwner, Region, State};

/// A point may lie outside of a cell by this part of its size and still take its values from the side of the cell:
/// curved boundaries of two meshes differ by less.
const OUTSIDE: f64 = 0.1;
/// The same for points that are taken to be inside, which are looked for first.
const CLOSE: f64 = 1e-6;
/// How far a point is drawn into a cell, relative to the cell, where the old pressure has several values at it.
const DRAWN_IN: f64 = 1e-6;

/// The old solution, asked for by body.
struct Source<'a, const D: usize> {
    space: &'a FsiSpace<D>,
    fields: Fields<'a, D>,
    locator: Locator<'a, D>,
}

impl<const D: usize> Source<'_, D> {
    /// The solution at `x` \[m\] in the cells of `body`.
    fn at(&self, x: [f64; D], body: Region) -> Result<PointFields<D>, MeshError> {
        let find = |tolerance| self.locator.find_where(x, tolerance, |cell| self.space.regions[cell] == body);
        // Far away from a point there are many small cells.
        let found = find(CLOSE).or_else(|_| find(OUTSIDE))?;
        Ok(self.fields.value(&found))
    }
}

/// The solution `state` on `from` as a solution on `to`, by the positions on the reference domain.
///
/// Nodes of the solid, those of the interface among them, take v and u from cells of the solid, the others from cells
/// of the fluid. A continuous pressure takes the values at its nodes, means over the cells around it where the old
/// one is discontinuous; a discontinuous pressure is projected cell by cell, (p, ξ)_K = (p_old, ξ)_K. A field that
/// `from` does not have is 0.
///
/// # Errors
/// [`MeshError::Outside`] for a node further from all cells of its body than a tenth of the size of a cell.
pub fn transfer<const D: usize>(
    from: &FsiSpace<D>,
    state: &State,
    to: &FsiSpace<D>,
) -> Result<State, MeshError> {
    let source = Source { space: from, fields: Fields::new(from, state), locator: Locator::new(&from.mesh) };
    let mut new = State::zero(to.n_v(), to.n_u(), to.n_p());
    nodes(&source, to, &mut new)?;
    bubbles(&source, to, &mut new)?;
    match to.pressure.kind {
        PressureKind::Continuous(_) => continuous(&source, to, &mut new.p)?,
        PressureKind::Pdc(_) => discontinuous(&source, to, &mut new.p)?,
    }
    Ok(new)
}

/// v and u at the nodes.
fn nodes<const D: usize>(source: &Source<'_, D>, to: &FsiSpace<D>, new: &mut State) -> Result<(), MeshError> {
    let mut in_fluid = vec![false; to.nodes.len()];
    for cell in (0..to.mesh.n_cells()).filter(|&cell| to.regions[cell] == Region::Fluid) {
        to.nodes.cell(cell).iter().for_each(|&node| in_fluid[node as usize] = true);
    }
    for node in 0..to.nodes.n_lagrange {
        let x = to.nodes.points[node];
        let found = match to.owner[node] {
            PsiOwner::Extension => source.at(x, Region::Fluid),
            // At the interface of a body that is new the flow is known.
            PsiOwner::Relation if in_fluid[node] => {
                source.at(x, Region::Solid).or_else(|_| source.at(x, Region::Fluid))
            }
            PsiOwner::Relation => source.at(x, Region::Solid),
        }?;
        new.v[D * node..D * (node + 1)].copy_from_slice(&found.velocity);
        if to.deforms {
            new.u[D * node..D * (node + 1)].copy_from_slice(&found.displacement);
        }
    }
    Ok(())
}

/// v at the centres of bubbles, those of faces first: its coefficient is what the functions before leave, over the bubble
/// there.
fn bubbles<const D: usize>(
    source: &Source<'_, D>,
    to: &FsiSpace<D>,
    new: &mut State,
) -> Result<(), MeshError> {
    let mesh = &to.mesh;
    let points = centres_of_bubbles(mesh.shape);
    let weights = vec![1.0; points.len()];
    let table = to.nodes.table(mesh.shape, &Quadrature { points: points.clone(), weights });
    let first = mesh.shape.n_nodes(to.nodes.degree);
    for cell in (0..mesh.n_cells()).filter(|&cell| to.nodes.has_bubble(cell)) {
        for (q, xi) in points.iter().enumerate() {
            let found = source.at(mesh.map(cell, std::array::from_fn(|d| xi[d])), to.regions[cell])?;
            let (others, behind) = to.nodes.cell(cell).split_at(first + q);
            for i in 0..D {
                let before = others.iter().zip(table.value(q));
                let before: f64 = before.map(|(&node, b)| b * new.v[D * node as usize + i]).sum();
                new.v[D * behind[0] as usize + i] = (found.velocity[i] - before) / table.value(q)[first + q];
            }
        }
    }
    Ok(())
}

/// Where the bubbles of a simplex are 1, in their order.
fn centres_of_bubbles(shape: Shape) -> Vec<[f64; 3]> {
    let third = |face: usize| std::array::from_fn(|d| if d + 1 == face { 0.0 } else { 1.0 / 3.0 });
    let faces = (0..n_bubbles(shape).saturating_sub(1)).map(third);
    faces.chain((n_bubbles(shape) > 0).then(|| shape.centre())).collect()
}

fn continuous<const D: usize>(
    source: &Source<'_, D>,
    to: &FsiSpace<D>,
    p: &mut [f64],
) -> Result<(), MeshError> {
    let one_valued = matches!(source.space.pressure.kind, PressureKind::Continuous(_));
    let mut count = vec![0.0; p.len()];
    for cell in 0..to.mesh.n_cells() {
        let centre = to.mesh.map(cell, to.mesh.reference_centre());
        for (a, &dof) in to.pressure.cell(cell).iter().enumerate() {
            let dof = dof as usize;
            if one_valued && count[dof] > 0.0 {
                continue;
            }
            let xi = lagrange::node(to.mesh.shape, to.pressure.kind.degree(), a);
            let x = to.mesh.map(cell, std::array::from_fn(|d| xi[d]));
            let part = if one_valued { 0.0 } else { DRAWN_IN };
            let inside = std::array::from_fn(|d| x[d] + part * (centre[d] - x[d]));
            p[dof] += source.at(inside, to.regions[cell])?.pressure;
            count[dof] += 1.0;
        }
    }
    p.iter_mut().zip(count).for_each(|(p, n)| *p /= f64::max(n, 1.0));
    Ok(())
}

fn discontinuous<const D: usize>(
    source: &Source<'_, D>,
    to: &FsiSpace<D>,
    p: &mut [f64],
) -> Result<(), MeshError> {
    let rule = Quadrature::cell(to.mesh.shape, to.pressure.kind.degree() + 2);
    for cell in 0..to.mesh.n_cells() {
        let dofs = to.pressure.cell(cell);
        let n = dofs.len();
        let (mut mass, mut moments) = (vec![vec![0.0; n]; n], vec![0.0; n]);
        for (xi, weight) in rule.points.iter().zip(&rule.weights).filter(|_| n > 0) {
            let xi = std::array::from_fn(|d| xi[d]);
            let x = to.mesh.map(cell, xi);
            let weight = weight * Tensor(to.mesh.map_gradient(cell, xi)).det();
            let basis = to.pressure.basis(&to.mesh, cell, &xi, &x);
            let value = source.at(x, to.regions[cell])?.pressure;
            for (i, a) in basis.iter().enumerate() {
                moments[i] += weight * a * value;
                mass[i].iter_mut().zip(&basis).for_each(|(entry, b)| *entry += weight * a * b);
            }
        }
        for (&dof, value) in dofs.iter().zip(solve(mass, moments)) {
            p[dof as usize] = value;
        }
    }
    Ok(())
}

/// The solution of `a x = b` for a small symmetric positive definite matrix, by elimination.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let (above, below) = a.split_at_mut(k + 1);
        for (i, row) in below.iter_mut().enumerate() {
            let factor = row[k] / above[k][k];
            row.iter_mut().zip(&above[k]).for_each(|(x, pivot)| *x -= factor * pivot);
            b[k + 1 + i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}
