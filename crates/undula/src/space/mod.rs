//! Discrete spaces of velocity, deformation and pressure: X_h = V_h × W_h × L_h of (5.26).

pub mod boundary;
pub mod conditions;
pub mod coordinates;
pub mod dofs;
pub mod enclosed;
pub mod ends;
pub mod fabric;
pub mod fluid_boundary;
pub mod normals;
pub mod part;
mod parting;
pub mod pressure;
pub mod seams;
mod sliding;
pub mod state;

pub use boundary::{Against, BACKFLOW, BoundaryCondition, MotionData, VelocityData, WALLS, Walls};
pub use conditions::{Constraints, Directions};
pub use coordinates::{COORDINATES, Coordinates};
pub use dofs::Nodes;
pub use enclosed::{ClosedPressure, Enclosed, enclosed};
pub use fabric::{Fabrics, FibreField};
pub use fluid_boundary::{FluidBoundary, FluidFacet};
pub use part::{Part, Rim};
pub use pressure::{PressureKind, PressureSpace};
pub use seams::Places;
pub use state::State;

use crate::element::{Quadrature, Shape};
use crate::math::Tensor;
use crate::mesh::{Facet, Hierarchy, Mesh, Seam, Side};
use std::sync::Arc;

/// Which equations hold in a cell.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Region {
    /// Navier-Stokes and the extension.
    Fluid,
    /// Elastodynamics.
    Solid,
}

/// Which equation owns the ψ row of a node, (5.26).
///
/// Interface rows of the extension do not exist: the test functions ψ_f vanish there. They are dropped,
/// never scaled away by a penalty.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum PsiOwner {
    /// The extension: the node lies in the fluid, off the interface.
    Extension,
    /// The velocity-deformation relation: the node lies in the closure of the solid.
    Relation,
}

/// Velocity and deformation on all of Ω, pressure in the fluid and in an incompressible solid.
#[derive(Clone, Debug)]
pub struct FsiSpace<const D: usize> {
    /// The mesh, restricted to the regions that take part.
    pub mesh: Mesh<D>,
    /// What its coordinates mean.
    pub coordinates: Coordinates,
    /// The coarser meshes that `mesh` was refined from, restricted as it; empty where they are not known.
    pub hierarchy: Hierarchy<D>,
    /// Equations of every cell.
    pub regions: Vec<Region>,
    /// Number of the material of every cell among those of its equations: 0 where there is one fluid and one solid.
    pub material: Vec<u16>,
    /// Nodes of velocity and deformation.
    pub nodes: Nodes<D>,
    /// Pressure unknowns.
    pub pressure: PressureSpace<D>,
    /// Owner of the ψ rows of every node.
    pub owner: Vec<PsiOwner>,
    /// Whether the deformation is unknown: not in a pure flow.
    pub deforms: bool,
    /// What the deformation does on the outer boundary of the fluid.
    pub walls: Walls,
    /// Facets of the outer boundary that are one, see [`FsiSpace::joined`].
    pub seams: Vec<Seam<D>>,
    places: Option<Places<D>>,
    /// What solids have at their points from the start.
    pub fabrics: Fabrics<D>,
    /// Nearest velocity node of the cell for every continuous pressure unknown.
    pressure_nodes: Vec<u32>,
    /// What is known of the whole where this is the part of one of several processes.
    pub part: Option<Arc<Part<D>>>,
}

impl<const D: usize> FsiSpace<D> {
    /// Spaces of degree `degree` for v and u on `mesh`, whose cells obey `regions`.
    pub fn new(mesh: Mesh<D>, regions: Vec<Region>, degree: usize, pressure: PressureKind) -> FsiSpace<D> {
        FsiSpace::with_pressure_in(mesh, regions, degree, pressure, &[Region::Fluid])
    }

    /// The same with a pressure in each of `bodies`: one space, discontinuous from region to region, of which
    /// p_f and p_s are the restrictions (section 5.3.2).
    pub fn with_pressure_in(
        mesh: Mesh<D>,
        regions: Vec<Region>,
        degree: usize,
        pressure: PressureKind,
        bodies: &[Region],
    ) -> FsiSpace<D> {
        let nodes = Nodes::new(&mesh, degree);
        Self::with_nodes(mesh, regions, nodes, pressure, bodies)
    }

    /// Those of [`FsiSpace::new`] with the bubbles of every simplex of the fluid for the velocity, see
    /// [`bubbles`](crate::element::lagrange::bubbles): P^{2,bubble} for degree 2.
    ///
    /// Bubbles stand beside the nodal basis; those of cells vanish on facets. Their coefficients of the deformation are given
    /// as 0, and in the solid there are none, so that the velocity-deformation relation stays an identity of nodes.
    pub fn with_bubbles(
        mesh: Mesh<D>,
        regions: Vec<Region>,
        degree: usize,
        pressure: PressureKind,
    ) -> FsiSpace<D> {
        let nodes = Nodes::new(&mesh, degree).with_bubbles(&mesh, |c| regions[c] == Region::Fluid);
        Self::with_nodes(mesh, regions, nodes, pressure, &[Region::Fluid])
    }

    fn with_nodes(
        mesh: Mesh<D>,
        regions: Vec<Region>,
        nodes: Nodes<D>,
        pressure: PressureKind,
        bodies: &[Region],
    ) -> FsiSpace<D> {
        let of = |body: Region| {
            PressureSpace::new(&mesh, pressure, |c| regions[c] == body && bodies.contains(&body))
        };
        let pressure = of(Region::Fluid).joined(of(Region::Solid));
        let mut owner = vec![PsiOwner::Extension; nodes.len()];
        for c in (0..mesh.n_cells()).filter(|&c| regions[c] == Region::Solid) {
            for &node in nodes.cell(c) {
                owner[node as usize] = PsiOwner::Relation;
            }
        }
        let deforms = regions.contains(&Region::Solid);
        let pressure_nodes = match pressure.kind {
            PressureKind::Pdc(_) => vec![],
            PressureKind::Continuous(k) => pressure_nodes(&mesh, &nodes, &pressure, k),
        };
        let (walls, hierarchy) = (Walls::Fixed, Hierarchy::default());
        let material = vec![0; regions.len()];
        FsiSpace {
            mesh,
            coordinates: Coordinates::Cartesian,
            hierarchy,
            regions,
            material,
            nodes,
            pressure,
            owner,
            deforms,
            walls,
            seams: vec![],
            places: None,
            fabrics: Fabrics::default(),
            pressure_nodes,
            part: None,
        }
    }

    /// The same with the `material` of every cell, and a pressure in the fluid and in the solids `with_pressure`. Pressures
    /// are discontinuous from solid to solid, as at the fluid.
    #[must_use]
    pub fn with_materials(mut self, material: Vec<u16>, with_pressure: &[u16]) -> FsiSpace<D> {
        let kind = self.pressure.kind;
        let of = |here: &dyn Fn(usize) -> bool| PressureSpace::new(&self.mesh, kind, here);
        let mut pressure = of(&|c| self.regions[c] == Region::Fluid);
        for solid in with_pressure {
            pressure = pressure.joined(of(&|c| self.regions[c] == Region::Solid && material[c] == *solid));
        }
        if let PressureKind::Continuous(k) = kind {
            self.pressure_nodes = pressure_nodes(&self.mesh, &self.nodes, &pressure, k);
        }
        (self.material, self.pressure) = (material, pressure);
        self
    }

    /// Number of the connected part of every cell, bodies of one kind that touch each other in facets being one; `inner`
    /// are the facets between cells.
    pub fn components_by(&self, inner: &[[Side; 2]]) -> Vec<u32> {
        self.mesh.components_where(inner, |one, two| self.regions[one] == self.regions[two])
    }

    /// Number of velocity unknowns, given ones counted.
    pub fn n_v(&self) -> usize {
        self.nodes.len() * D
    }

    /// Number of deformation unknowns, given ones counted.
    pub fn n_u(&self) -> usize {
        if self.deforms { self.nodes.len() * D } else { 0 }
    }

    /// Number of pressure unknowns.
    pub fn n_p(&self) -> usize {
        self.pressure.n
    }

    /// Number of unknowns of the fields v, u and p, given ones counted; terms may have scalar ones besides.
    pub fn n_field_unknowns(&self) -> usize {
        self.n_v() + self.n_u() + self.n_p()
    }

    /// The velocity node at the place of a continuous pressure unknown.
    pub fn pressure_node(&self, dof: usize) -> u32 {
        self.pressure_nodes[dof]
    }

    /// Nodes on a facet.
    pub fn facet_nodes(&self, facet: &Facet) -> Vec<u32> {
        let local = self.mesh.shape.facet_nodes(self.nodes.degree, facet.local as usize);
        let cell = self.nodes.cell(facet.cell as usize);
        local.iter().map(|&a| cell[a]).collect()
    }

    /// Functions of the cell of a facet that do not vanish on it: their places in the cell, and their nodes. Those of
    /// [`FsiSpace::facet_nodes`], and the bubble of the facet if there is one.
    pub fn facet_functions(&self, facet: &Facet) -> Vec<(usize, u32)> {
        let (shape, degree) = (self.mesh.shape, self.nodes.degree);
        let (cell, local) = (facet.cell as usize, facet.local as usize);
        let nodal = shape.facet_nodes(degree, local).into_iter().zip(self.facet_nodes(facet));
        let bubble = self.nodes.facet_bubble(shape, cell, local);
        nodal.chain(bubble.map(|node| (shape.n_nodes(degree) + local, node))).collect()
    }

    /// Bubbles of facets between fluid and solid, where the velocity has none: the solid has nodes alone.
    pub fn interface_bubbles(&self) -> Vec<u32> {
        let side = |side: &Side| (side.cell as usize, side.local as usize);
        let of =
            |side: &Side| self.nodes.facet_bubble(self.mesh.shape, side.cell as usize, side.local as usize);
        if self.nodes.n_lagrange == self.nodes.len() || self.mesh.shape != Shape::Tetrahedron {
            return vec![];
        }
        let meet = |[one, two]: &&[Side; 2]| self.regions[side(one).0] != self.regions[side(two).0];
        self.mesh.facets_of_cells().inner.iter().filter(meet).flatten().filter_map(of).collect()
    }

    /// Whether there is a node that may slide, see [`Walls::Sliding`], with one condition per boundary of the mesh.
    pub fn slides(&self, conditions: &[BoundaryCondition<D>]) -> bool {
        let slips = |facet: &Facet| matches!(conditions[facet.boundary as usize], BoundaryCondition::Slip);
        sliding::sliding(self, slips).iter().any(Option::is_some)
    }

    /// All facets of the boundary or part of the interface called `name`.
    pub fn boundary_facets(&self, name: &str) -> Vec<Facet> {
        self.mesh.facets_on(&[name])
    }

    /// All nodes on the boundary called `name`, ascending.
    pub fn boundary_nodes(&self, name: &str) -> Vec<u32> {
        let mut nodes: Vec<u32> =
            self.boundary_facets(name).iter().flat_map(|f| self.facet_nodes(f)).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }
}

impl<const D: usize> FsiSpace<D> {
    /// Mean distance ĥ of nodes \[m\]: the root of the area, in space the third root of the volume, that there is for each.
    pub fn node_distance(&self) -> f64 {
        let rule = Quadrature::cell(self.mesh.shape, 2);
        let mut measure = 0.0;
        for cell in 0..self.mesh.n_cells() {
            for (xi, w) in rule.points.iter().zip(&rule.weights) {
                let xi = std::array::from_fn(|d| xi[d]);
                measure += w * Tensor(self.mesh.map_gradient(cell, xi)).det();
            }
        }
        let each = measure / self.nodes.len() as f64;
        if D == 3 { each.cbrt() } else { each.sqrt() }
    }
}

/// For every continuous pressure unknown of degree `k` the velocity node nearest to it on the lattice.
fn pressure_nodes<const D: usize>(
    mesh: &Mesh<D>,
    nodes: &Nodes<D>,
    pressure: &PressureSpace<D>,
    k: usize,
) -> Vec<u32> {
    let n = nodes.degree;
    let mut list = vec![0; pressure.n];
    for c in 0..mesh.n_cells() {
        for (a, &dof) in pressure.cell(c).iter().enumerate() {
            let mut near = mesh.shape.lattice(k, a).map(|i| (2 * i * n + k) / (2 * k));
            if mesh.shape.is_simplex() {
                near[1] = near[1].min(n - near[0]);
                near[2] = near[2].min(n - near[0] - near[1]);
            }
            list[dof as usize] = nodes.cell(c)[mesh.shape.number(n, near)];
        }
    }
    list
}
