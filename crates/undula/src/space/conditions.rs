//! What is given at nodes: Dirichlet data, displacements, directions that a boundary does not let pass.

use super::{BoundaryCondition, FsiSpace, MotionData, PsiOwner, VelocityData, Walls, normals};
use crate::math::Vector;
use crate::mesh::Facet;
use std::sync::Arc;

/// Constrained unknowns and the data they take.
#[derive(Clone)]
pub struct Constraints<const D: usize> {
    /// Components of the velocity that are given.
    pub v: Vec<[bool; D]>,
    /// Components of the deformation that are given, those of bubbles among them: 0 but for [`Constraints::motion`].
    pub u: Vec<[bool; D]>,
    /// Pressure unknowns that are given; empty if none is, see [`super::ClosedPressure`].
    pub p: Vec<bool>,
    /// Nodes with velocity data, and which.
    pub data: Vec<(u32, VelocityData<D>)>,
    /// Nodes with a given displacement, and which.
    pub motion: Vec<(u32, MotionData<D>)>,
    /// Whether there are such nodes, here or on another of the processes that share the space.
    pub moves: bool,
    /// Nodes of `Slip` with the axes that are normal there: the extension is mirrored.
    pub mirrors: Vec<(u32, [bool; D])>,
    /// Nodes at which v or u vanishes in directions that are no axes.
    pub directions: Vec<Directions<D>>,
    /// Factor of the data, for loads that are raised in parts.
    pub load: f64,
    /// Whether boundaries with a given displacement are at rest: v is 0 there, as in an equilibrium.
    pub still: bool,
    /// Whether velocity data depend on the deformation: they are taken at x + u, and nodes with data slide.
    pub follows: bool,
}

/// Directions in which v or u vanishes at a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Directions<const D: usize> {
    /// The node.
    pub node: u32,
    /// Whether n·v = 0 there.
    pub v: bool,
    /// Whether n·u = 0 there.
    pub u: bool,
    /// The directions n, orthonormal.
    pub normals: Vec<Vector<f64, D>>,
}

impl<const D: usize> Directions<D> {
    /// x − Σ n n·x.
    pub fn project(&self, x: &mut [f64]) {
        for n in &self.normals {
            let along: f64 = (0..D).map(|i| n.0[i] * x[i]).sum();
            (0..D).for_each(|i| x[i] -= along * n.0[i]);
        }
    }
}

/// What the facets at a node say of it.
#[derive(Clone, Default)]
struct Seen<const D: usize> {
    fixed: bool,
    velocity: Option<VelocityData<D>>,
    /// Given displacements; the first that gives a component rules.
    motion: Vec<MotionData<D>>,
    /// An outlet of the fluid that does not move.
    outlet: bool,
}

impl<const D: usize> Constraints<D> {
    /// From one condition per boundary of the mesh, in its order. Where several meet, a displacement rules, then a fixed
    /// wall, then a velocity, then `Slip`.
    pub fn new(space: &FsiSpace<D>, conditions: &[BoundaryCondition<D>]) -> Constraints<D> {
        let n = space.nodes.len();
        let (v, u) = (vec![[false; D]; n], vec![[false; D]; n]);
        let (data, motion, mirrors, directions) = (vec![], vec![], vec![], vec![]);
        let (load, still, follows) = (1.0, false, false);
        let (p, moves) = (vec![], false);
        let mut c = Constraints { v, u, p, data, motion, moves, mirrors, directions, load, still, follows };
        let mut seen = seen(space, conditions);
        for (node, seen) in seen.iter().enumerate() {
            let free = !seen.motion.is_empty() && !seen.fixed;
            if (seen.fixed || seen.velocity.is_some()) && !free {
                (c.v[node], c.u[node]) = ([true; D], [true; D]);
            }
            if seen.outlet && !free {
                c.u[node] = [true; D];
            }
        }
        space.interface_bubbles().into_iter().for_each(|node| c.v[node as usize] = [true; D]);
        // Bubbles are of the velocity alone.
        c.u[space.nodes.n_lagrange..].fill([true; D]);
        let slips = |facet: &Facet| matches!(conditions[facet.boundary as usize], BoundaryCondition::Slip);
        if space.walls == Walls::Sliding {
            c.slide(space, slips);
        }
        for (node, normals) in normals::normals(space, space.mesh.facets.iter().filter(|facet| slips(facet)))
        {
            c.mirrors.push((node, std::array::from_fn(|d| normals.iter().any(|n| n.0[d].abs() == 1.0))));
            c.hold(node as usize, normals, [true, true]);
        }
        for (node, seen) in seen.iter_mut().enumerate() {
            if node >= space.nodes.n_lagrange {
                // Data are interpolated by the nodes, beside which bubbles stand.
                c.without_bubble(space, node, seen);
            } else if !seen.motion.is_empty() {
                c.moved(space, node, std::mem::take(&mut seen.motion));
            } else if let (false, Some(data)) = (seen.fixed, seen.velocity.take()) {
                c.follows |= space.deforms && c.u[node] != [true; D];
                c.data.push((node as u32, data));
            }
        }
        c.directions.retain(|at| at.v || at.u);
        c.moves = !c.motion.is_empty();
        c
    }

    /// n·u = 0 in place of u = 0 where the mesh may slide.
    fn slide(&mut self, space: &FsiSpace<D>, slips: impl Fn(&Facet) -> bool) {
        for (node, normal) in super::sliding::sliding(space, slips).into_iter().enumerate() {
            if let Some(normal) = normal.filter(|_| self.u[node] == [true; D]) {
                self.u[node] = [false; D];
                self.hold(node, vec![normal], [false, true]);
            }
        }
    }

    /// Lets v or u vanish in the directions `normals` at a node, where they are not given already.
    fn hold(&mut self, node: usize, normals: Vec<Vector<f64, D>>, [v, u]: [bool; 2]) {
        let axes: Option<Vec<usize>> = match normals.len() {
            n if n == D => Some((0..D).collect()),
            _ => normals.iter().map(normals::axis).collect(),
        };
        let free = |given: &[bool; D]| given.contains(&false);
        let (v, u) = (v && free(&self.v[node]), u && free(&self.u[node]));
        match axes {
            Some(axes) => {
                for d in axes {
                    self.v[node][d] |= v;
                    self.u[node][d] |= u;
                }
            }
            None => self.directions.push(Directions { node: node as u32, v, u, normals }),
        }
    }

    /// Gives the coefficient of a bubble as 0 where the velocity of its facet is given.
    fn without_bubble(&mut self, space: &FsiSpace<D>, node: usize, seen: &Seen<D>) {
        for motion in &seen.motion {
            let given = motion(&space.nodes.points[node], 0.0);
            (0..D).for_each(|i| self.v[node][i] |= given[i].is_some());
        }
    }

    /// Gives the displacement of a node. Components that are free in it stay what walls and `Slip` make of them.
    fn moved(&mut self, space: &FsiSpace<D>, node: usize, mut motions: Vec<MotionData<D>>) {
        let motion: MotionData<D> = match motions.len() {
            1 => motions.remove(0),
            _ => Arc::new(move |x, t| {
                let all: Vec<_> = motions.iter().map(|motion| motion(x, t)).collect();
                std::array::from_fn(|i| all.iter().find_map(|given| given[i]))
            }),
        };
        let given = motion(&space.nodes.points[node], 0.0).map(|component| component.is_some());
        for i in (0..D).filter(|&i| given[i]) {
            (self.v[node][i], self.u[node][i]) = (true, true);
        }
        if given == [true; D] {
            self.directions.retain(|at| at.node as usize != node);
        }
        self.motion.push((node as u32, motion));
    }

    /// Whether all components of v are given at a node.
    pub fn is_given(&self, node: usize) -> bool {
        self.v[node] == [true; D]
    }

    /// The places in `u` whose values follow given displacements, with what stands there; none if nothing deforms.
    pub fn displacements(&self, u: &[f64]) -> Vec<(usize, f64)> {
        let nodes = self.motion.iter().filter(|_| !u.is_empty());
        let places = nodes.flat_map(|(node, _)| (0..D).map(move |i| *node as usize * D + i));
        places.map(|at| (at, u[at])).collect()
    }

    /// Write the data of time `t` into `v` and `u`, and zero into the other given entries.
    pub fn apply(&self, space: &FsiSpace<D>, t: f64, v: &mut [f64], u: &mut [f64]) {
        let zero = |x: &mut [f64], given: &[[bool; D]]| {
            for (x, given) in x.chunks_exact_mut(D).zip(given) {
                (0..D).filter(|&i| given[i]).for_each(|i| x[i] = 0.0);
            }
        };
        zero(v, &self.v);
        zero(u, &self.u);
        for at in &self.directions {
            let node = at.node as usize * D..(at.node as usize + 1) * D;
            if at.v {
                at.project(&mut v[node.clone()]);
            }
            if at.u && !u.is_empty() {
                at.project(&mut u[node]);
            }
        }
        for (node, motion) in &self.motion {
            let node = *node as usize;
            let given = motion(&space.nodes.points[node], t);
            for (i, [displacement, rate]) in (0..D).filter_map(|i| Some((i, given[i]?))) {
                v[node * D + i] = if self.still { 0.0 } else { self.load * rate };
                if let Some(u) = u.get_mut(node * D + i) {
                    *u = self.load * displacement;
                }
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

fn seen<const D: usize>(space: &FsiSpace<D>, conditions: &[BoundaryCondition<D>]) -> Vec<Seen<D>> {
    let mut seen = vec![Seen::default(); space.nodes.len()];
    let moves = super::ends::moving(space, conditions);
    for facet in &space.mesh.facets {
        for (_, node) in space.facet_functions(facet) {
            let (seen, owner) = (&mut seen[node as usize], space.owner[node as usize]);
            match &conditions[facet.boundary as usize] {
                BoundaryCondition::Velocity(data) => seen.velocity = Some(data.clone()),
                BoundaryCondition::Fixed => seen.fixed = true,
                BoundaryCondition::Displacement(motion) => seen.motion.push(motion.clone()),
                // Nodes of the solid are free, as both u and v.
                BoundaryCondition::Outflow { .. } => {
                    seen.outlet |= owner == PsiOwner::Extension && !moves[facet.boundary as usize];
                }
                BoundaryCondition::Slip | BoundaryCondition::Free => {}
            }
        }
    }
    seen
}
