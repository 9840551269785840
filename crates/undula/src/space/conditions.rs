//! Dirichlet data.

use super::FsiSpace;
use std::sync::Arc;

/// A velocity given as a function of position and time \[m/s\].
pub type VelocityData<const D: usize> = Arc<dyn Fn(&[f64; D], f64) -> [f64; D] + Send + Sync>;

/// What holds on a named boundary, as far as the spaces are concerned.
#[derive(Clone)]
pub enum BoundaryCondition<const D: usize> {
    /// v given, u = 0.
    Velocity(VelocityData<D>),
    /// v = 0, u = 0.
    Fixed,
    /// v free, u = 0: outflow on a boundary that does not move.
    Outflow {
        /// Apply the correction that makes the condition do-nothing instead of traction-free.
        do_nothing: bool,
    },
    /// v and u free: surface of the solid without traction.
    Free,
}

/// Constrained unknowns and the data they take.
#[derive(Clone)]
pub struct Constraints<const D: usize> {
    /// Velocity nodes that are given.
    pub v: Vec<bool>,
    /// Deformation nodes that are given (always 0), bubbles among them.
    pub u: Vec<bool>,
    /// Nodes with velocity data, and which.
    pub data: Vec<(u32, VelocityData<D>)>,
}

impl<const D: usize> Constraints<D> {
    /// From one condition per boundary of the mesh, in its order. Where several meet, a fixed wall rules.
    pub fn new(space: &FsiSpace<D>, conditions: &[BoundaryCondition<D>]) -> Constraints<D> {
        let n = space.nodes.len();
        let mut fixed = vec![false; n];
        let mut c = Constraints { v: vec![false; n], u: vec![false; n], data: vec![] };
        let mut given: Vec<Option<VelocityData<D>>> = vec![None; n];
        for facet in &space.mesh.facets {
            for node in space.facet_nodes(facet) {
                let node = node as usize;
                match &conditions[facet.boundary as usize] {
                    BoundaryCondition::Velocity(data) => {
                        (c.v[node], c.u[node]) = (true, true);
                        given[node] = Some(data.clone());
                    }
                    BoundaryCondition::Fixed => {
                        (c.v[node], c.u[node], fixed[node]) = (true, true, true);
                    }
                    BoundaryCondition::Outflow { .. } => c.u[node] = true,
                    BoundaryCondition::Free => {}
                }
            }
        }
        // Bubbles are of the velocity alone.
        c.u[space.nodes.n_lagrange..].fill(true);
        for node in 0..n {
            if let (false, Some(data)) = (fixed[node], given[node].take()) {
                c.data.push((node as u32, data));
            }
        }
        c
    }

    /// Write the data of time `t` into `v` and zero into the other given entries of v and u.
    pub fn apply(&self, space: &FsiSpace<D>, t: f64, v: &mut [f64], u: &mut [f64]) {
        for (node, &is) in self.v.iter().enumerate() {
            if is {
                v[node * D..(node + 1) * D].fill(0.0);
            }
        }
        for (node, &is) in self.u.iter().enumerate() {
            if is && !u.is_empty() {
                u[node * D..(node + 1) * D].fill(0.0);
            }
        }
        for (node, data) in &self.data {
            let node = *node as usize;
            v[node * D..(node + 1) * D].copy_from_slice(&data(&space.nodes.points[node], t));
        }
    }
}
