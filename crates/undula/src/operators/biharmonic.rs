//! The biharmonic extension, section 5.3.5.4, in its mixed form with w = −Δu:
//! ```text
//!     (∇w, ∇ψ¹) + (∇u, ∇ψ²) − (w, ψ²) = ⟨n·∇u_s, ψ²⟩_I,   ψ¹ = 0 on I and the outer boundary,
//! ```
//! n outward of F. Clamped (u = 0, ∂_n u = 0 on the outer boundary) ψ² and w are free there; hinged (u = 0, w = 0)
//! they vanish. On a boundary with `Slip`, which mirrors the domain, the normal components of u and w vanish and the
//! others are free. With (w, ψ²) by the nodal rule the unknown w is eliminated node by node, and what is left is one
//! constant sparse operator on u,
//! ```text
//!     A = Kᵀ M⁻¹ (K − B),   K_ij = (∇φ_j, ∇χ_i)_F,   M_ii = (1, χ_i)_F,   B_ij = ⟨n·∇φ_j, χ_i⟩_I by the cells of S,
//! ```
//! which couples a node to the cells around its neighbours. φ is the basis of u, χ that of w and ψ²: the same, but on
//! quadratic triangles, where the integrals at the vertices vanish, with the cubic bubble (Cohen, Joly, Roberts and
//! Tordjman 2001): the nodes of u and the centre have the weights 1/20, 2/15 and 9/20 of the area. Quadratic polynomials
//! are reproduced on parallelograms and straight triangles, affine ones on all cells.

use super::{Entries, How, Matrix, Operator, StepView};
use crate::algebra::{Sink, SolverError};
use crate::element::Shape;
use crate::loops::scatter::DROP;
use crate::math::Vector;
use crate::mesh::{INTERFACE, Side};
use crate::sampling::{facet_points, for_each_point};
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
        let (mut source, mass) = forms(space, n);
        let mut tested: Vec<Row> = vec![vec![]; space.nodes.len()];
        for (w, row) in source.iter().enumerate() {
            row.iter().for_each(|&(node, k)| tested[node as usize].push((w as u32, k)));
        }
        subtract_traces(space, n, &mut source);
        for (row, mass) in source.iter_mut().zip(&mass).filter(|(_, mass)| **mass > 0.0) {
            merge(row);
            row.iter_mut().for_each(|(_, value)| *value /= mass);
        }
        let mut mirrored = vec![[false; D]; space.nodes.len()];
        constraints.mirrors.iter().for_each(|&(node, axes)| mirrored[node as usize] = axes);
        let n_v = space.n_v();
        let mut operator = Biharmonic { n_v, ..Biharmonic::default() };
        for node in (0..space.nodes.len()).filter(|&node| space.owner[node] == PsiOwner::Extension) {
            for i in (0..D).filter(|&i| !constraints.u[node][i]) {
                let mut row = Row::new();
                for &(w, k) in &tested[node] {
                    // There is no node of u in the centre.
                    let given = constraints.u.get(w as usize).is_some_and(|u| u[i]);
                    let odd = mirrored.get(w as usize).is_some_and(|axes| axes[i]);
                    if !(odd || hinged && given) {
                        row.extend(source[w as usize].iter().map(|&(a, value)| (a, k * value)));
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
    fn visit(&self, visit: &mut dyn FnMut(u32, u32, f64)) {
        for (row, entries) in self.lines() {
            entries.iter().for_each(|&(column, value)| visit(row, column, value));
        }
    }
}

impl<const D: usize> Operator<D> for Biharmonic {
    fn body(&self) -> Region {
        Region::Fluid
    }

    /// A u in the ψ rows.
    fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64 {
        for (row, entries) in self.lines() {
            let product = |&(column, value): &(u32, f64)| value * step.new.u[column as usize - self.n_v];
            out[row as usize] += entries.iter().map(product).sum::<f64>();
        }
        f64::INFINITY
    }

    fn entries(&self, matrix: Matrix, number: &[u32], visit: &mut dyn FnMut(u32, u32)) {
        self.visit(&mut |row, column, _| {
            let (row, column) = (number[row as usize], number[column as usize]);
            if matrix == Matrix::Whole && row != DROP && column != DROP {
                visit(row, column);
            }
        });
    }

    fn place(&mut self, matrix: Matrix, number: &[u32], entries: &Entries<'_>) -> Result<(), SolverError> {
        if matrix == Matrix::Whole {
            let mut slots = Vec::with_capacity(self.entries.len());
            self.visit(&mut |row, column, _| {
                let (row, column) = (number[row as usize], number[column as usize]);
                let there = row != DROP && column != DROP;
                slots.push(if there { (entries.find)(row, column) } else { DROP });
            });
            self.slots = slots;
        }
        Ok(())
    }

    fn linearise(&mut self, matrix: Matrix, _step: &StepView<'_>, _how: How, mut out: Sink<'_>) {
        let entries = self.slots.iter().zip(&self.entries).filter(|(slot, _)| **slot != DROP);
        for (&slot, &(_, value)) in entries.filter(|_| matrix == Matrix::Whole) {
            out.add(slot as usize, value);
        }
    }

    fn apply(&mut self, matrix: Matrix, _step: &StepView<'_>, x: &[f64], y: &mut [f64]) {
        for (row, entries) in self.lines().filter(|_| matrix == Matrix::Whole) {
            let product = |&(column, value): &(u32, f64)| value * x[column as usize];
            y[row as usize] += entries.iter().map(product).sum::<f64>();
        }
    }

    fn extension(&self, _step: &StepView<'_>, visit: &mut dyn FnMut(u32, u32, f64)) -> bool {
        self.visit(visit);
        true
    }
}

/// Vertices of a quadratic triangle, each with the nodes on the two edges there.
const VERTICES: [(usize, [usize; 2]); 3] = [(0, [1, 3]), (2, [1, 4]), (5, [3, 4])];

/// From the basis of a quadratic triangle to χ: the cubic bubble b that is 1 in the centre, behind φ_a − φ_a(centre) b.
fn enrich<const D: usize>(value: &mut Vec<f64>, grad: &mut Vec<Vector<f64, D>>) {
    let lambda = VERTICES.map(|(v, [a, b])| value[v] + 0.5 * (value[a] + value[b]));
    let slopes = VERTICES.map(|(v, [a, b])| grad[v] + 0.5 * (grad[a] + grad[b]));
    let bubble = 27.0 * lambda.iter().product::<f64>();
    let slope = (0..3).fold(Vector::zero(), |sum, i| {
        let others = lambda[(i + 1) % 3] * lambda[(i + 2) % 3];
        sum + slopes[i] * (27.0 * others)
    });
    for a in 0..value.len() {
        let at_centre = if VERTICES.iter().any(|(v, _)| *v == a) { -1.0 / 9.0 } else { 4.0 / 9.0 };
        value[a] -= at_centre * bubble;
        grad[a] -= slope * at_centre;
    }
    value.push(bubble);
    grad.push(slope);
}

/// What the cells add to K and M, `[cell][function of w]`.
struct Blocks {
    n_u: usize,
    n_w: usize,
    /// (∇φ_j, ∇χ_i), `[cell][i][j]`.
    stiffness: Vec<f64>,
    /// (1, χ_i).
    integral: Vec<f64>,
    /// (χ_i, χ_i).
    square: Vec<f64>,
}

impl Blocks {
    fn new<const D: usize>(space: &FsiSpace<D>, n: usize) -> Blocks {
        let (shape, degree, n_cells) = (space.mesh.shape, space.nodes.degree, space.mesh.n_cells());
        let enriched = shape == Shape::Triangle && degree == 2;
        let n_u = shape.n_nodes(degree);
        let n_w = n_u + usize::from(enriched);
        let mut stiffness = vec![0.0; n_cells * n_w * n_u];
        let (mut integral, mut square) = (vec![0.0; n_cells * n_w], vec![0.0; n_cells * n_w]);
        let zero = State::zero(space.n_v(), space.n_u(), space.n_p());
        for_each_point(space, &zero, n, |point| {
            // Bubbles of the velocity are no functions of u.
            let mut value = point.value[..n_u].to_vec();
            let mut grad: Vec<_> = point.grad[..n_u].iter().map(|g| Vector(*g)).collect();
            if enriched {
                enrich(&mut value, &mut grad);
            }
            for (a, (value, grad)) in value.iter().zip(&grad).enumerate() {
                let at = point.cell * n_w + a;
                integral[at] += point.weight * value;
                square[at] += point.weight * value * value;
                for (entry, other) in stiffness[at * n_u..].iter_mut().zip(&point.grad[..n_u]) {
                    *entry += point.weight * grad.dot(Vector(*other));
                }
            }
        });
        Blocks { n_u, n_w, stiffness, integral, square }
    }

    /// The nodal rule of a cell, its integrals; where one is not positive, as it may be in a cell that is bent too much,
    /// the diagonal of its mass matrix scaled to the same volume.
    fn mass(&self, cell: usize) -> Vec<f64> {
        let here = cell * self.n_w..(cell + 1) * self.n_w;
        let (integral, square) = (&self.integral[here.clone()], &self.square[here]);
        let volume: f64 = integral.iter().sum();
        let scale = volume / square.iter().sum::<f64>();
        let positive = integral.iter().all(|&x| x > 1e-6 * volume);
        if positive { integral.to_vec() } else { square.iter().map(|x| scale * x).collect() }
    }
}

/// K, by rows of w, and M on the fluid: the nodes of u, and behind them the centres of the cells.
fn forms<const D: usize>(space: &FsiSpace<D>, n: usize) -> (Vec<Row>, Vec<f64>) {
    let blocks = Blocks::new(space, n);
    let (n_u, n_w, n_nodes) = (blocks.n_u, blocks.n_w, space.nodes.len());
    let mut stiffness: Vec<Row> = vec![vec![]; n_nodes + space.mesh.n_cells()];
    let mut mass = vec![0.0; stiffness.len()];
    for cell in (0..space.mesh.n_cells()).filter(|&c| space.regions[c] == Region::Fluid) {
        let nodes = &space.nodes.cell(cell)[..n_u];
        for (a, of_cell) in blocks.mass(cell).into_iter().enumerate() {
            let row = nodes.get(a).map_or(n_nodes + cell, |&node| node as usize);
            let entries = &blocks.stiffness[(cell * n_w + a) * n_u..][..n_u];
            stiffness[row].extend(nodes.iter().copied().zip(entries.iter().copied()));
            mass[row] += of_cell;
        }
    }
    stiffness.iter_mut().for_each(merge);
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
