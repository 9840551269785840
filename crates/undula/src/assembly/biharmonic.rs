//! The biharmonic extension, section 5.3.5.4, in its mixed form with w = −Δu:
//! ```text
//!     (∇w, ∇ψ¹) + (∇u, ∇ψ²) − (w, ψ²) = ⟨n·∇u_s, ψ²⟩_I,   ψ¹ = 0 on I and the outer boundary,
//! ```
//! n outward of F. Clamped (u = 0, ∂_n u = 0 on the outer boundary) ψ² and w are free there; hinged (u = 0, w = 0)
//! they vanish. With (w, ψ²) by the nodal rule the unknown w is eliminated node by node, and what is left is one
//! constant sparse operator on u,
//! ```text
//!     A = K M⁻¹ (K − B),   K_ij = (∇φ_j, ∇φ_i)_F,   M_ii = (1, φ_i)_F,   B_ij = ⟨n·∇φ_j, φ_i⟩_I by the cells of S,
//! ```
//! which couples a node to the cells around its neighbours. Quadratic polynomials are reproduced on cells that are
//! parallelograms, affine ones on all.

use super::facets::facet_points;
use super::points::for_each_point;
use super::scatter::DROP;
use crate::math::Vector;
use crate::mesh::{INTERFACE, Side};
use crate::space::{Constraints, FsiSpace, PsiOwner, Region, State};

/// A row of a sparse matrix over the nodes, ascending.
type Row = Vec<(u32, f64)>;

/// The operator A on the free unknowns of the fluid.
#[derive(Clone, Debug, Default)]
pub struct Biharmonic {
    /// Row in `[v, u, p]` and the end of its entries.
    rows: Vec<(u32, u32)>,
    /// Entries: column in `[v, u, p]`, value.
    entries: Vec<(u32, f64)>,
    /// Where the entries go in the Jacobian.
    slots: Vec<u32>,
    n_v: usize,
}

impl Biharmonic {
    /// On the fluid of `space`, `n` Gauss points per direction.
    pub fn new<const D: usize>(
        space: &FsiSpace<D>,
        constraints: &Constraints<D>,
        hinged: bool,
        n: usize,
    ) -> Biharmonic {
        let (stiffness, mass) = forms(space, n);
        let mut source = stiffness.clone();
        subtract_traces(space, n, &mut source);
        for (row, mass) in source.iter_mut().zip(&mass).filter(|(_, mass)| **mass > 0.0) {
            merge(row);
            row.iter_mut().for_each(|(_, value)| *value /= mass);
        }
        let n_v = space.n_v();
        let mut operator = Biharmonic { n_v, ..Biharmonic::default() };
        for node in (0..space.nodes.len()).filter(|&node| space.owner[node] == PsiOwner::Extension) {
            for i in (0..D).filter(|&i| !constraints.u[node][i]) {
                let mut row = Row::new();
                for &(j, k) in &stiffness[node] {
                    if !(hinged && constraints.u[j as usize][i]) {
                        row.extend(source[j as usize].iter().map(|&(a, value)| (a, k * value)));
                    }
                }
                merge(&mut row);
                let place = |node: u32| (n_v + node as usize * D + i) as u32;
                operator.entries.extend(row.into_iter().map(|(a, value)| (place(a), value)));
                operator.rows.push((place(node as u32), operator.entries.len() as u32));
            }
        }
        operator
    }

    /// Each row with its entries.
    fn lines(&self) -> impl Iterator<Item = (u32, &[(u32, f64)])> {
        let mut start = 0;
        self.rows.iter().map(move |&(row, end)| {
            let entries = &self.entries[start..end as usize];
            start = end as usize;
            (row, entries)
        })
    }

    /// Call `visit(row, column, value)` for all entries, by places in `[v, u, p]`.
    pub fn visit(&self, visit: &mut dyn FnMut(u32, u32, f64)) {
        for (row, entries) in self.lines() {
            entries.iter().for_each(|&(column, value)| visit(row, column, value));
        }
    }

    /// Add A u to the ψ rows of `out`.
    pub fn residual(&self, u: &[f64], out: &mut [f64]) {
        for (row, entries) in self.lines() {
            out[row as usize] +=
                entries.iter().map(|&(column, value)| value * u[column as usize - self.n_v]).sum::<f64>();
        }
    }

    /// Remember where the entries go; `find` gives [`DROP`] for those of given unknowns.
    pub fn set_slots(&mut self, find: impl Fn(u32, u32) -> u32) {
        let mut slots = Vec::with_capacity(self.entries.len());
        self.visit(&mut |row, column, _| slots.push(find(row, column)));
        self.slots = slots;
    }

    /// Add the entries to those of the Jacobian.
    pub fn jacobian(&self, out: &mut [f64]) {
        for (&slot, &(_, value)) in self.slots.iter().zip(&self.entries).filter(|(slot, _)| **slot != DROP) {
            out[slot as usize] += value;
        }
    }
}

/// K and M on the fluid.
///
/// M has the integrals of the basis, the nodal rule of the element; where one is not positive, as at the vertices
/// of quadratic triangles, the diagonal of the mass matrix scaled to the same volume.
fn forms<const D: usize>(space: &FsiSpace<D>, n: usize) -> (Vec<Row>, Vec<f64>) {
    let (n_nodes, per_cell) = (space.nodes.len(), space.nodes.per_cell);
    let mut blocks = vec![0.0; space.mesh.n_cells() * per_cell * per_cell];
    let mut integral = vec![0.0; space.mesh.n_cells() * per_cell];
    let mut square = integral.clone();
    let zero = State::zero(space.n_v(), space.n_u(), space.n_p());
    for_each_point(space, &zero, n, |point| {
        for a in 0..per_cell {
            let at = point.cell * per_cell + a;
            integral[at] += point.weight * point.value[a];
            square[at] += point.weight * point.value[a] * point.value[a];
            let grad = Vector(point.grad[a]) * point.weight;
            for (entry, other) in blocks[at * per_cell..].iter_mut().zip(point.grad) {
                *entry += grad.dot(Vector(*other));
            }
        }
    });
    let fluid = |c: &usize| space.regions[*c] == Region::Fluid;
    let mut stiffness: Vec<Row> = vec![vec![]; n_nodes];
    for cell in (0..space.mesh.n_cells()).filter(fluid) {
        let nodes = space.nodes.cell(cell);
        for (a, &row) in nodes.iter().enumerate() {
            let entries = &blocks[(cell * per_cell + a) * per_cell..][..per_cell];
            stiffness[row as usize].extend(nodes.iter().copied().zip(entries.iter().copied()));
        }
    }
    stiffness.iter_mut().for_each(merge);
    let mut mass = vec![0.0; n_nodes];
    for cell in (0..space.mesh.n_cells()).filter(fluid) {
        let here = cell * per_cell..(cell + 1) * per_cell;
        let (integral, square) = (&integral[here.clone()], &square[here]);
        let volume: f64 = integral.iter().sum();
        let scale = volume / square.iter().sum::<f64>();
        let positive = integral.iter().all(|&x| x > 1e-6 * volume);
        for (a, &node) in space.nodes.cell(cell).iter().enumerate() {
            mass[node as usize] += if positive { integral[a] } else { scale * square[a] };
        }
    }
    (stiffness, mass)
}

/// `rows ← rows − B`.
fn subtract_traces<const D: usize>(space: &FsiSpace<D>, n: usize, rows: &mut [Row]) {
    let beyond = space.mesh.neighbours();
    let interface = space.mesh.boundary(INTERFACE);
    for facet in space.mesh.facets.iter().filter(|f| Some(f.boundary) == interface) {
        let solid = |side: &Side| space.regions[side.cell as usize] == Region::Solid;
        let here = facet.side();
        let Some(side) = [Some(here), beyond.get(&here).copied()].into_iter().flatten().find(solid) else {
            continue;
        };
        let nodes = space.nodes.cell(side.cell as usize);
        for point in facet_points(space, &side.named(facet.boundary), n) {
            // The normal of the solid points into the fluid: B has the sign of −n.
            let slope = point.grad.iter().map(|g| point.weight * Vector(*g).dot(point.normal));
            let slope: Vec<f64> = slope.collect();
            for (value, &row) in point.value.iter().zip(nodes).filter(|(value, _)| value.abs() > 1e-13) {
                rows[row as usize].extend(nodes.iter().zip(&slope).map(|(&a, slope)| (a, value * slope)));
            }
        }
    }
}

/// Sort by column and add up what belongs to one.
fn merge(row: &mut Row) {
    row.sort_by_key(|&(column, _)| column);
    row.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
}
