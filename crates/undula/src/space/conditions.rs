//! Dirichlet data.

use super::{BoundaryCondition, FsiSpace, PsiOwner, VelocityData, Walls};

/// Constrained unknowns and the data they take.
#[derive(Clone)]
pub struct Constraints<const D: usize> {
    /// Velocity nodes that are given.
    pub v: Vec<bool>,
    /// Components of the deformation that are given (always 0), those of bubbles among them.
    pub u: Vec<[bool; D]>,
    /// Pressure unknowns that are given; empty if none is, see [`super::ClosedPressure`].
    pub p: Vec<bool>,
    /// Nodes with velocity data, and which.
    pub data: Vec<(u32, VelocityData<D>)>,
    /// Factor of the velocity data, for loads that are raised in parts.
    pub load: f64,
    /// Whether velocity data depend on the deformation: they are taken at x + u, and nodes with data slide.
    pub follows: bool,
}

impl<const D: usize> Constraints<D> {
    /// From one condition per boundary of the mesh, in its order. Where several meet, a fixed wall rules.
    pub fn new(space: &FsiSpace<D>, conditions: &[BoundaryCondition<D>]) -> Constraints<D> {
        let n = space.nodes.len();
        let mut fixed = vec![false; n];
        let (v, u) = (vec![false; n], vec![[false; D]; n]);
        let mut c = Constraints { v, u, p: vec![], data: vec![], load: 1.0, follows: false };
        let mut given: Vec<Option<VelocityData<D>>> = vec![None; n];
        let moves = super::ends::moving(space, conditions);
        for facet in &space.mesh.facets {
            for node in space.facet_nodes(facet) {
                let node = node as usize;
                match &conditions[facet.boundary as usize] {
                    BoundaryCondition::Velocity(data) => {
                        (c.v[node], c.u[node]) = (true, [true; D]);
                        given[node] = Some(data.clone());
                    }
                    BoundaryCondition::Fixed => {
                        (c.v[node], c.u[node], fixed[node]) = (true, [true; D], true);
                    }
                    // Nodes of the solid are free, as both u and v.
                    BoundaryCondition::Outflow { .. }
                        if space.owner[node] == PsiOwner::Extension && !moves[facet.boundary as usize] =>
                    {
                        c.u[node] = [true; D];
                    }
                    BoundaryCondition::Outflow { .. } | BoundaryCondition::Free => {}
                }
            }
        }
        // Bubbles are of the velocity alone.
        c.u[space.nodes.n_lagrange..].fill([true; D]);
        if space.walls == Walls::Sliding {
            for (node, axis) in super::sliding::normals(space).into_iter().enumerate() {
                if let Some(axis) = axis.filter(|_| c.u[node] == [true; D]) {
                    c.u[node] = std::array::from_fn(|d| d == axis);
                }
            }
        }
        for node in 0..n {
            if let (false, Some(data)) = (fixed[node], given[node].take()) {
                c.follows |= space.deforms && c.u[node] != [true; D];
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
        if !u.is_empty() {
            for (u, given) in u.chunks_exact_mut(D).zip(&self.u) {
                (0..D).filter(|&i| given[i]).for_each(|i| u[i] = 0.0);
            }
        }
        self.apply_data(space, t, v, u);
    }

    /// Write the velocity data of time `t` at the places x + u into `v`.
    pub fn apply_data(&self, space: &FsiSpace<D>, t: f64, v: &mut [f64], u: &[f64]) {
        for (node, data) in &self.data {
            let node = *node as usize;
            let mut x = space.nodes.points[node];
            // Where nothing slides u is 0 here.
            if self.follows {
                (0..D).for_each(|i| x[i] += u[node * D + i]);
            }
            let value = data(&x, t);
            (0..D).for_each(|i| v[node * D + i] = self.load * value[i]);
        }
    }
}
