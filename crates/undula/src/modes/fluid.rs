//! The mass of a fluid that moves along with the solid.

use super::Setting;
use super::body::{Body, NONE};
use crate::algebra::{Csr, Kind, LinearSolver, MultifrontalLu, Options, Pattern, SolverError, Unknown, dot};
use crate::mesh::Side;
use crate::sampling::facet_points;
use crate::sampling::for_each_point;
use crate::space::{FsiSpace, Region, State};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// M_a = Cᵀ L⁻¹ C.
pub(super) struct AddedMass {
    /// Entries of C: pressure, unknown of the body, value \[m\].
    coupling: Vec<(u32, u32, f64)>,
    /// Factors of L.
    potential: MultifrontalLu,
    /// g of every part of the fluid without outlet, where it is not 0.
    fluxes: Vec<Vec<f64>>,
    b: Vec<f64>,
    p: Vec<f64>,
}

/// A flux g·φ through the surface of a part of the fluid that must be 0, scaled to g·K⁻¹ g = 1 and K⁻¹-orthogonal to
/// the others.
pub(super) struct Volume {
    g: Vec<f64>,
    /// K⁻¹ g.
    z: Vec<f64>,
}

impl Volume {
    /// Takes off x what changes the volume: x ← x − K⁻¹ g (g·x).
    pub(super) fn keep(&self, x: &mut [f64]) {
        let flux = dot(&self.g, x);
        x.iter_mut().zip(&self.z).for_each(|(x, z)| *x -= flux * z);
    }
}

/// Pressures of the fluid, of the degree of the velocity: nodes of its cells, apart in each connected part.
struct Pressures {
    /// `n_cells × per_cell`; [`NONE`] in the solid and where p = 0.
    of_cell: Vec<u32>,
    per_cell: usize,
    /// Node of each pressure.
    nodes: Vec<u32>,
    /// The connected part in which each cell is.
    parts: Vec<u32>,
    /// Parts of the fluid without outlet.
    closed: Vec<u32>,
}

impl Pressures {
    fn new(setting: &Setting<'_>, inner: &[[Side; 2]]) -> Pressures {
        let FsiSpace { mesh, nodes, regions, .. } = setting.space;
        let per_cell = mesh.shape.n_nodes(nodes.degree);
        let parts = mesh.components_by(inner);
        // Whether p is given at a node of a part.
        let mut given: HashMap<(u32, u32), bool> = HashMap::new();
        let mut is_open: BTreeMap<u32, bool> = BTreeMap::new();
        let fluid = |cell: usize| regions[cell] == Region::Fluid;
        for facet in
            mesh.facets.iter().filter(|f| fluid(f.cell as usize) && setting.open[f.boundary as usize])
        {
            let part = parts[facet.cell as usize];
            is_open.insert(part, true);
            setting.space.facet_nodes(facet).into_iter().for_each(|node| {
                given.insert((part, node), true);
            });
        }
        for cell in (0..mesh.n_cells()).filter(|&cell| fluid(cell)) {
            // The first pressure of a part without outlet is 0: its constant has no effect on motions without flux.
            if let std::collections::btree_map::Entry::Vacant(part) = is_open.entry(parts[cell]) {
                part.insert(false);
                given.insert((parts[cell], nodes.cell(cell)[0]), true);
            }
        }
        let mut number: HashMap<(u32, u32), u32> = HashMap::new();
        let (mut of_cell, mut places) = (vec![NONE; mesh.n_cells() * per_cell], vec![]);
        for cell in (0..mesh.n_cells()).filter(|&cell| fluid(cell)) {
            for (a, &node) in nodes.cell(cell)[..per_cell].iter().enumerate() {
                let key = (parts[cell], node);
                if given.contains_key(&key) {
                    continue;
                }
                of_cell[cell * per_cell + a] = *number.entry(key).or_insert_with(|| {
                    places.push(node);
                    places.len() as u32 - 1
                });
            }
        }
        let closed = is_open.into_iter().filter(|(_, open)| !open).map(|(part, _)| part).collect();
        Pressures { of_cell, per_cell, nodes: places, parts, closed }
    }

    fn cell(&self, cell: usize) -> &[u32] {
        &self.of_cell[cell * self.per_cell..(cell + 1) * self.per_cell]
    }

    /// L for the density `rho`.
    fn potential(&self, setting: &Setting<'_>, rho: f64) -> Csr {
        let mut rows: Vec<Vec<u32>> = vec![vec![]; self.nodes.len()];
        for dofs in self.of_cell.chunks_exact(self.per_cell) {
            let dofs: Vec<u32> = dofs.iter().copied().filter(|&dof| dof != NONE).collect();
            dofs.iter().for_each(|&row| rows[row as usize].extend(&dofs));
        }
        let mut matrix = Csr::zeros(&Arc::new(Pattern::from_rows(&rows)));
        let space = setting.space;
        let rest = State::zero(space.n_v(), space.n_u(), space.n_p());
        for_each_point(space, &rest, setting.quadrature, |point| {
            let dofs = self.cell(point.cell);
            for (a, &row) in dofs.iter().enumerate().filter(|(_, row)| **row != NONE) {
                for (b, &column) in dofs.iter().enumerate().filter(|(_, column)| **column != NONE) {
                    let ([ax, ay], [bx, by]) = (point.grad[a], point.grad[b]);
                    if let Some(at) = matrix.pattern.find(row as usize, column as usize) {
                        matrix.values[at] += point.weight / rho * (ax * bx + ay * by);
                    }
                }
            }
        });
        matrix
    }

    fn unknowns(&self, space: &FsiSpace<2>) -> Vec<Unknown> {
        let unknown = |(n, &node): (usize, &u32)| {
            let [x, y] = space.nodes.points[node as usize];
            // Nodes at which two parts meet have a pressure in each.
            Unknown { node: n as u32, kind: Kind::Deformation, at: [x, y, 0.0] }
        };
        self.nodes.iter().enumerate().map(unknown).collect()
    }
}

impl AddedMass {
    /// Of a fluid with the density `rho` \[kg/m³\] around `body`.
    ///
    /// # Errors
    /// If L cannot be factorised.
    pub(super) fn new(setting: &Setting<'_>, body: &Body, rho: f64) -> Result<AddedMass, SolverError> {
        let space = setting.space;
        let inner = space.inner_facets();
        let pressures = Pressures::new(setting, &inner);
        let matrix = pressures.potential(setting, rho);
        let mut potential = MultifrontalLu::definite(Options::default());
        potential.analyse(&matrix.pattern, &pressures.unknowns(space))?;
        potential.factor(&matrix)?;
        let mut coupling = vec![];
        let mut fluxes: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
        for side in inner.into_iter().filter_map(|sides| fluid_side(space, sides)) {
            let cell = side.cell as usize;
            let local = space.mesh.shape.facet_nodes(space.nodes.degree, side.local as usize);
            let part = pressures.parts[cell];
            for point in facet_points(space, &side.named(0), setting.quadrature) {
                for &a in &local {
                    let place = 2 * space.nodes.cell(cell)[a] as usize;
                    for i in (0..2).filter(|&i| body.number[place + i] != NONE) {
                        let unknown = body.number[place + i];
                        let flux = point.weight * point.value[a] * point.normal.0[i];
                        if pressures.closed.contains(&part) {
                            let g = fluxes.entry(part).or_insert_with(|| vec![0.0; body.places.len()]);
                            g[unknown as usize] += flux;
                        }
                        let pressure = |&b: &usize| (pressures.cell(cell)[b], unknown, flux * point.value[b]);
                        coupling.extend(local.iter().map(pressure).filter(|entry| entry.0 != NONE));
                    }
                }
            }
        }
        let n = pressures.nodes.len();
        let (b, p) = (vec![0.0; n], vec![0.0; n]);
        Ok(AddedMass { coupling, potential, fluxes: fluxes.into_values().collect(), b, p })
    }

    /// Number of pressures.
    pub(super) fn n_p(&self) -> usize {
        self.p.len()
    }

    /// y ← y + M_a x.
    pub(super) fn add(&mut self, x: &[f64], y: &mut [f64]) {
        self.b.fill(0.0);
        self.coupling.iter().for_each(|&(q, a, value)| self.b[q as usize] += value * x[a as usize]);
        self.potential.apply(&self.b, &mut self.p);
        self.coupling.iter().for_each(|&(q, a, value)| y[a as usize] += value * self.p[q as usize]);
    }

    /// The volumes that stay; `solve(g, z)` sets z = K⁻¹ g.
    pub(super) fn volumes(&self, mut solve: impl FnMut(&[f64], &mut [f64])) -> Vec<Volume> {
        let mut volumes: Vec<Volume> = vec![];
        for flux in &self.fluxes {
            let (mut g, mut z) = (flux.clone(), vec![0.0; flux.len()]);
            solve(&g, &mut z);
            let before = dot(&g, &z);
            for Volume { g: other, z: other_z } in &volumes {
                let part = dot(&g, other_z);
                g.iter_mut().zip(other).for_each(|(g, other)| *g -= part * other);
                z.iter_mut().zip(other_z).for_each(|(z, other)| *z -= part * other);
            }
            let size = dot(&g, &z);
            // Held surfaces, and parts whose volume is kept because others keep theirs.
            if size > 1e-10 * before {
                let scale = 1.0 / size.sqrt();
                g.iter_mut().chain(&mut z).for_each(|x| *x *= scale);
                volumes.push(Volume { g, z });
            }
        }
        volumes
    }
}

/// The side of the fluid of a facet between fluid and solid.
fn fluid_side(space: &FsiSpace<2>, [one, two]: [Side; 2]) -> Option<Side> {
    match [one, two].map(|side| space.regions[side.cell as usize]) {
        [Region::Fluid, Region::Solid] => Some(one),
        [Region::Solid, Region::Fluid] => Some(two),
        _ => None,
    }
}
