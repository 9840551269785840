//! Bases of the stabilisation at the quadrature points of cells or patches, fixed for the run.

use super::patches::{fluid_cells, patches};
use crate::element::hessian::{hessians, mapped};
use crate::element::lagrange::bubble_hessians;
use crate::element::{BasisTable, Fine, Fluctuation, Quadrature};
use crate::loops::chunks::chunks;
use crate::math::{Lanes, Scalar, Tensor, Vector};
use crate::physics::{PressureTerm, Projection, Stabilization, TransportTerm};
use crate::space::{FsiSpace, PressureKind};
use std::ops::Range;

/// Basis functions of one field on cells or patches, derivatives with respect to x.
#[derive(Default)]
pub struct Basis<const D: usize, const L: usize> {
    /// Functions of a patch.
    pub n: usize,
    /// Unknowns (pressure) or nodes (velocity), `[batch][function]`.
    pub dofs: Vec<[u32; L]>,
    /// Values, `[point][function]`; velocity only.
    pub value: Vec<f64>,
    /// Gradients, `[batch][point][function]`.
    pub grad: Vec<Vector<Lanes<L>, D>>,
    /// Gradients of φ − πφ, where that is projected; else empty.
    pub fine: Vec<Vector<Lanes<L>, D>>,
    /// Second derivatives, where they are needed; else empty.
    pub hess: Vec<Tensor<Lanes<L>, D>>,
}

impl<const D: usize, const L: usize> Basis<D, L> {
    /// The functions at point `index` = batch · points + point in a table.
    #[inline(always)]
    pub fn at<'a, T>(&self, table: &'a [T], index: usize) -> &'a [T] {
        &table[index * self.n..(index + 1) * self.n]
    }

    /// What test functions are differentiated in: φ − πφ where that is projected.
    #[inline(always)]
    pub fn tested(&self, index: usize) -> &[Vector<Lanes<L>, D>] {
        self.at(if self.fine.is_empty() { &self.grad } else { &self.fine }, index)
    }
}

/// Cells or patches of the fluid in batches.
pub struct Tables<const D: usize, const L: usize> {
    /// How many lanes of a batch are real.
    pub active: Vec<usize>,
    /// Batches that belong to one thread's work.
    pub chunks: Vec<Range<usize>>,
    /// Velocity and deformation.
    pub velocity: Basis<D, L>,
    /// Pressure.
    pub pressure: Basis<D, L>,
    /// Cells of a patch.
    pub n_children: usize,
    /// Points of a cell.
    pub n_points: usize,
    /// Quadrature weight times |det ∂x/∂ξ| \[m^D\], `[batch][child][point]`; zero in padded lanes.
    pub weight: Vec<Lanes<L>>,
    /// ĥ of the cells \[m\], `[batch][child]`.
    pub size: Vec<Lanes<L>>,
    /// ∂x/∂ξ \[m\], `[batch][child][point]`; directional only.
    pub jacobian: Vec<Tensor<Lanes<L>, D>>,
    /// Position of the points \[m\]; where the force is needed.
    pub positions: Vec<Vector<Lanes<L>, D>>,
}

/// Reference tables from which those of the cells are made.
struct Reference {
    rule: Quadrature,
    velocity: Fluctuation,
    pressure: Fluctuation,
    /// Values of v, plain gradients of v and p: `[point][basis]`.
    plain: [BasisTable; 2],
    hessians: Vec<Vec<[[f64; 3]; 3]>>,
    patched: bool,
}

impl Reference {
    fn new<const D: usize>(space: &FsiSpace<D>, how: &Stabilization, quadrature: usize) -> Reference {
        let (shape, k) = (space.mesh.shape, space.nodes.degree);
        let rule = Quadrature::cell(shape, quadrature);
        let patched = how.projects() && how.projection == Projection::Patch;
        // A discontinuous pressure has no nodes; it is never projected.
        let of_pressure = match space.pressure.kind {
            PressureKind::Continuous(k) => k,
            _ => 1,
        };
        let fluctuation = |degree: usize, bubble: bool| {
            let of = Fine { shape, degree, bubble };
            if patched { Fluctuation::on_patch(of, &rule) } else { Fluctuation::on_cell(of, &rule) }
        };
        let bubble = space.nodes.n_lagrange < space.nodes.len();
        let second = |xi: &[f64; 3]| {
            let mut list = hessians(shape, k, xi);
            if bubble {
                list.extend(bubble_hessians(shape, xi));
            }
            list
        };
        let needed = if how.has_residual() { &rule.points[..] } else { &[] };
        Reference {
            velocity: fluctuation(k, bubble),
            pressure: fluctuation(of_pressure, false),
            plain: [space.nodes.table(shape, &rule), BasisTable::lagrange(shape, of_pressure, &rule)],
            hessians: needed.iter().map(second).collect(),
            rule,
            patched,
        }
    }
}

/// One point of one cell.
struct At<'a, const D: usize> {
    cell: usize,
    child: usize,
    q: usize,
    x: [f64; D],
    inverse: Tensor<f64, D>,
    reference: &'a Reference,
}

impl<const D: usize, const L: usize> Tables<D, L> {
    /// On the fluid cells of `space`, `quadrature` Gauss points per direction.
    ///
    /// # Panics
    /// If there are no patches to project on.
    pub fn new(space: &FsiSpace<D>, how: &Stabilization, quadrature: usize) -> Tables<D, L> {
        let reference = Reference::new(space, how, quadrature);
        let list = match reference.patched {
            true => patches(space).expect("patches of a refined mesh"),
            false => fluid_cells(space).into_iter().map(|cell| vec![cell]).collect(),
        };
        let n_pressure = match space.pressure.kind {
            PressureKind::Continuous(_) => reference.pressure.n_basis,
            _ => space.pressure.per_cell,
        };
        let mut tables = Tables {
            active: vec![],
            chunks: chunks(list.len().div_ceil(L)),
            velocity: Basis { n: reference.velocity.n_basis, ..Basis::default() },
            pressure: Basis { n: n_pressure, ..Basis::default() },
            n_children: reference.velocity.children.len(),
            n_points: reference.rule.points.len(),
            weight: vec![],
            size: vec![],
            jacobian: vec![],
            positions: vec![],
        };
        tables.velocity.value = values(&reference);
        for patches in list.chunks(L) {
            tables.push(space, how, patches, &reference);
        }
        tables
    }

    /// Number of batches.
    pub fn n_batches(&self) -> usize {
        self.active.len()
    }

    /// Points of a patch.
    pub fn points(&self) -> usize {
        self.n_children * self.n_points
    }

    fn push(&mut self, space: &FsiSpace<D>, how: &Stabilization, patches: &[Vec<usize>], from: &Reference) {
        let lane = |l: usize| &patches[l.min(patches.len() - 1)];
        let (nodes, pressures) = (&space.nodes, &space.pressure);
        let of_nodes: Vec<_> = (0..L).map(|l| gather(lane(l), &from.velocity, |c| nodes.cell(c))).collect();
        let of_pressure: Vec<_> = (0..L)
            .map(|l| match space.pressure.kind {
                PressureKind::Continuous(_) => gather(lane(l), &from.pressure, |c| pressures.cell(c)),
                _ => pressures.cell(lane(l)[0]).to_vec(),
            })
            .collect();
        self.velocity.dofs.extend((0..self.velocity.n).map(|a| std::array::from_fn(|l| of_nodes[l][a])));
        self.pressure.dofs.extend((0..self.pressure.n).map(|a| std::array::from_fn(|l| of_pressure[l][a])));
        for child in 0..self.n_children {
            let first = self.weight.len();
            for q in 0..self.n_points {
                self.make_room(how);
                for l in 0..L {
                    self.set_point(space, how, from, (lane(l)[child], child, q), (l, l < patches.len()));
                }
            }
            let mut size = Lanes::<L>::zero();
            for l in 0..L {
                // Padded lanes have no weight; their size must not be zero either.
                let volume: f64 = self.weight[first..].iter().map(|w| w.0[l]).sum();
                size.0[l] = if volume > 0.0 { volume.powf(1.0 / D as f64) } else { 1.0 };
            }
            self.size.push(size);
        }
        self.active.push(patches.len());
    }

    /// One more point in all tables.
    fn make_room(&mut self, how: &Stabilization) {
        let more = |table: &mut Vec<Vector<Lanes<L>, D>>, n: usize, there: bool| {
            if there {
                table.resize(table.len() + n, Vector::zero());
            }
        };
        let (n, m) = (self.velocity.n, self.pressure.n);
        more(&mut self.velocity.grad, n, true);
        more(&mut self.velocity.fine, n, how.transport == TransportTerm::LocalProjection);
        more(&mut self.pressure.grad, m, true);
        more(&mut self.pressure.fine, m, how.pressure == PressureTerm::LocalProjection);
        more(&mut self.positions, 1, how.has_residual());
        let hessians = if how.has_residual() { n } else { 0 };
        self.velocity.hess.resize(self.velocity.hess.len() + hessians, Tensor::zero());
        self.jacobian.resize(self.jacobian.len() + usize::from(how.directional), Tensor::zero());
        self.weight.push(Lanes::zero());
    }

    /// Lane `l` of the last point of all tables.
    fn set_point(
        &mut self,
        space: &FsiSpace<D>,
        how: &Stabilization,
        from: &Reference,
        (cell, child, q): (usize, usize, usize),
        (l, real): (usize, bool),
    ) {
        let xi: [f64; D] = std::array::from_fn(|d| from.rule.points[q][d]);
        let jacobian = Tensor(space.mesh.map_gradient(cell, xi));
        let det = jacobian.det();
        let inverse = jacobian.cofactor().t() * (1.0 / det);
        let x = space.mesh.map(cell, xi);
        let at = At { cell, child, q, x, inverse, reference: from };
        if let Some(weight) = self.weight.last_mut() {
            weight.0[l] = if real { from.rule.weights[q] * det } else { 0.0 };
        }
        if let Some(last) = self.jacobian.last_mut() {
            set_tensor(last, &jacobian, l);
        }
        if let Some(last) = self.positions.last_mut() {
            set_vector(last, Vector(x), l);
        }
        let plain = at.plain(&from.plain[0], &from.velocity);
        put(&mut self.velocity.grad, &plain, l);
        if how.transport == TransportTerm::LocalProjection {
            put(&mut self.velocity.fine, &at.fine(&from.velocity), l);
        }
        put(&mut self.pressure.grad, &at.pressure(space), l);
        if how.pressure == PressureTerm::LocalProjection {
            put(&mut self.pressure.fine, &at.fine(&from.pressure), l);
        }
        if how.has_residual() {
            let first = self.velocity.hess.len() - self.velocity.n;
            let curvature = curvature(space, cell, &xi);
            for (a, &place) in from.velocity.children[child].iter().enumerate() {
                let hess = mapped(plain[place].0, &from.hessians[q][a], &inverse, &curvature);
                set_tensor(&mut self.velocity.hess[first + place], &hess, l);
            }
        }
    }
}

/// Values of the velocity basis, `[child][point][function]`.
fn values(from: &Reference) -> Vec<f64> {
    let mut list = vec![];
    for nodes in &from.velocity.children {
        for q in 0..from.rule.points.len() {
            let first = list.len();
            list.resize(first + from.velocity.n_basis, 0.0);
            for (value, &place) in from.plain[0].value(q).iter().zip(nodes) {
                list[first + place] = *value;
            }
        }
    }
    list
}

impl<const D: usize> At<'_, D> {
    fn to_x(&self, reference: &[f64]) -> Vector<f64, D> {
        self.inverse.t() * Vector(std::array::from_fn(|d| reference[d]))
    }

    /// Gradients of the functions of a patch at a point of one of its cells.
    fn plain(&self, table: &BasisTable, of: &Fluctuation) -> Vec<Vector<f64, D>> {
        let mut list = vec![Vector::zero(); of.n_basis];
        for (reference, &place) in table.grad(self.q).chunks_exact(D).zip(&of.children[self.child]) {
            list[place] = self.to_x(reference);
        }
        list
    }

    /// Gradients of φ − πφ.
    fn fine(&self, of: &Fluctuation) -> Vec<Vector<f64, D>> {
        let (n, point) = (of.n_basis * D, self.child * self.reference.rule.points.len() + self.q);
        of.grad[point * n..(point + 1) * n].chunks_exact(D).map(|g| self.to_x(g)).collect()
    }

    /// Gradients of the pressure basis, which is one in x where it is discontinuous.
    fn pressure(&self, space: &FsiSpace<D>) -> Vec<Vector<f64, D>> {
        match space.pressure.kind {
            PressureKind::Continuous(_) => self.plain(&self.reference.plain[1], &self.reference.pressure),
            PressureKind::Pdc(_) => {
                let slopes = space.pressure.discontinuous_gradients(self.cell, &self.x);
                slopes.into_iter().map(Vector).collect()
            }
        }
    }
}

/// ∂²X_m/∂ξ_a∂ξ_b of the map of a cell \[m\].
fn curvature<const D: usize>(space: &FsiSpace<D>, cell: usize, xi: &[f64; D]) -> [[[f64; D]; D]; D] {
    let mesh = &space.mesh;
    let mut sum = [[[0.0; D]; D]; D];
    for (hess, &node) in hessians(mesh.shape, mesh.degree, xi).iter().zip(mesh.cell(cell)) {
        for (m, sum) in sum.iter_mut().enumerate() {
            for a in 0..D {
                for b in 0..D {
                    sum[a][b] += hess[a][b] * mesh.nodes[node as usize][m];
                }
            }
        }
    }
    sum
}

/// Numbers of the functions of a patch from those of its cells.
fn gather<'a>(patch: &[usize], of: &Fluctuation, numbers: impl Fn(usize) -> &'a [u32]) -> Vec<u32> {
    let mut list = vec![0; of.n_basis];
    for (&cell, places) in patch.iter().zip(&of.children) {
        for (&number, &place) in numbers(cell).iter().zip(places) {
            list[place] = number;
        }
    }
    list
}

/// Write lane `l` of the last entries of a table.
fn put<const D: usize, const L: usize>(
    table: &mut [Vector<Lanes<L>, D>],
    values: &[Vector<f64, D>],
    l: usize,
) {
    let first = table.len() - values.len();
    for (entry, value) in table[first..].iter_mut().zip(values) {
        set_vector(entry, *value, l);
    }
}

fn set_vector<const D: usize, const L: usize>(
    entry: &mut Vector<Lanes<L>, D>,
    value: Vector<f64, D>,
    l: usize,
) {
    for d in 0..D {
        entry.0[d].0[l] = value.0[d];
    }
}

fn set_tensor<const D: usize, const L: usize>(
    entry: &mut Tensor<Lanes<L>, D>,
    value: &Tensor<f64, D>,
    l: usize,
) {
    for i in 0..D {
        for j in 0..D {
            entry.0[i][j].0[l] = value.0[i][j];
        }
    }
}
