//! Values at material points.

use super::{Functional, Snapshot};
use crate::element::lagrange;
use crate::mesh::{Locator, MeshError};

use crate::space::{FsiSpace, Region};

/// One component of the deformation of a material point \[m\].
pub struct Displacement {
    nodes: Vec<u32>,
    basis: Vec<f64>,
    component: usize,
}

impl Displacement {
    /// At the reference position `x` \[m\].
    ///
    /// # Errors
    /// If `x` lies outside of the mesh.
    pub fn new<const D: usize>(
        space: &FsiSpace<D>,
        x: [f64; D],
        component: usize,
    ) -> Result<Self, MeshError> {
        let found = Locator::new(&space.mesh).find(x)?;
        let (basis, _) = lagrange::basis(space.mesh.shape, space.nodes.degree, &found.xi);
        Ok(Displacement { nodes: space.nodes.cell(found.cell).to_vec(), basis, component })
    }
}

impl<const D: usize> Functional<D> for Displacement {
    fn unit(&self) -> &'static str {
        "m"
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        if at.new.u.is_empty() {
            return 0.0;
        }
        let value = |node: u32| at.new.u[node as usize * D + self.component];
        self.nodes.iter().zip(&self.basis).map(|(&node, b)| b * value(node)).sum()
    }
}

/// p(a) − p(b) \[Pa\] at material points.
///
/// Where a discontinuous pressure has several values, at a node, their mean is taken.
pub struct PressureDifference {
    /// (unknown, weight).
    terms: Vec<(u32, f64)>,
}

impl PressureDifference {
    /// At reference positions \[m\].
    ///
    /// # Errors
    /// If a point lies outside of the fluid.
    pub fn new<const D: usize>(space: &FsiSpace<D>, a: [f64; D], b: [f64; D]) -> Result<Self, MeshError> {
        let mut terms = vec![];
        for (x, sign) in [(a, 1.0), (b, -1.0)] {
            let cells = cells_at(space, x)?;
            let share = sign / cells.len() as f64;
            for (cell, xi) in cells {
                let at = space.mesh.map(cell, xi);
                let basis = space.pressure.basis(&space.mesh, cell, &xi, &at);
                terms.extend(space.pressure.cell(cell).iter().zip(basis).map(|(&dof, b)| (dof, share * b)));
            }
        }
        Ok(PressureDifference { terms })
    }
}

/// The fluid cells that contain `x`, with its reference coordinates there.
fn cells_at<const D: usize>(space: &FsiSpace<D>, x: [f64; D]) -> Result<Vec<(usize, [f64; D])>, MeshError> {
    let locator = Locator::new(&space.mesh);
    let first = locator.find(x)?;
    let near = |node: u32| {
        let at = space.nodes.points[node as usize];
        (0..D).all(|d| (at[d] - x[d]).abs() < 1e-9)
    };
    let Some(&node) = space.nodes.cell(first.cell).iter().find(|&&n| near(n)) else {
        return Ok(vec![(first.cell, first.xi)]);
    };
    let mut cells = vec![];
    for cell in (0..space.mesh.n_cells()).filter(|&c| space.regions[c] == Region::Fluid) {
        if let Some(a) = space.nodes.cell(cell).iter().position(|&n| n == node) {
            let xi = lagrange::node(space.mesh.shape, space.nodes.degree, a);
            cells.push((cell, std::array::from_fn(|d| xi[d])));
        }
    }
    if cells.is_empty() { Ok(vec![(first.cell, first.xi)]) } else { Ok(cells) }
}

impl<const D: usize> Functional<D> for PressureDifference {
    fn unit(&self) -> &'static str {
        "Pa"
    }

    fn at_force_time(&self) -> bool {
        true
    }

    fn evaluate(&self, at: &Snapshot<'_, D>) -> f64 {
        self.terms.iter().map(|&(dof, w)| w * at.new.p[dof as usize]).sum()
    }
}
