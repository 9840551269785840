//! What flows through the boundaries of the fluid: does it come out again?
//!
//! At every step the net flow ∫ v · J F⁻ᵀ n ds over all boundaries of the fluid, interface included, is that of an
//! incompressible fluid: zero, to the tolerance of Newton's method. The volume of the fluid changes in a step by
//! what its boundaries sweep: the interface moves with v, to the order of the time scheme, the others with ∂_t u.

use crate::math::{Tensor, Vector};
use crate::parallel::{Crew, Reduce};
use crate::physics::kinematics::cofactor;
use crate::sampling::facet_points;
use crate::space::{FluidBoundary, FsiSpace, State};
use serde::{Deserialize, Serialize};

/// Flows below this part of the largest velocity times the size of the boundary are rounding. A fluid at rest under
/// its weight moves by the rounding of its pressure, so √(|p|/ρ) counts as a velocity.
const NOTHING: f64 = 1e-10;

/// Largest flows of a run so far, per unit depth \[m²/s\].
#[derive(Copy, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Largest {
    /// |∫ v · n|.
    pub net: f64,
    /// ½ ∫ |v · n|.
    pub through: f64,
    /// The largest coefficient of v, or √(|p|/ρ), times the size of the boundary.
    pub speed: f64,
    /// |(|F(t)| − |F(t⁻)|)/k − mean of ∫ v · n over the interface − mean of ∫ ∂_t u · n over the other boundaries|;
    /// `None` before the first step.
    pub swept: Option<f64>,
}

/// The flow through the boundaries of the fluid, watched from step to step.
pub struct Balance<const D: usize> {
    /// Largest flows so far.
    pub largest: Largest,
    faces: Vec<Face<D>>,
    /// Size of the boundary on the reference domain.
    size: f64,
    density: f64,
    deforms: bool,
    time: f64,
    last: Flow,
    /// Displacement at `time`; empty where nothing deforms.
    u: Vec<f64>,
    /// The processes that share the space.
    crew: Option<Crew>,
}

/// A facet with its quadrature points.
struct Face<const D: usize> {
    nodes: Vec<u32>,
    points: Vec<Point<D>>,
    at_solid: bool,
}

/// A quadrature point; only basis functions of nodes on the facet count there.
struct Point<const D: usize> {
    weight: f64,
    /// Distance to the axis \[m\], if there is one.
    radius: Option<f64>,
    /// From some point of the boundary.
    x: Vector<f64, D>,
    normal: Vector<f64, D>,
    value: Vec<f64>,
    /// Gradients along the facet: cof F n needs no others.
    grad: Vec<[f64; D]>,
}

/// Integrals over the boundary at one time.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
struct Flow {
    net: f64,
    through: f64,
    /// ∫ v · n over the interface.
    interface: f64,
    /// |F|.
    volume: f64,
}

impl<const D: usize> Balance<D> {
    /// For a run of a fluid of `density` \[kg/m³\] that starts from `state` at `time` \[s\].
    pub fn new(space: &FsiSpace<D>, density: f64, state: &State, time: f64) -> Balance<D> {
        let faces = faces(space);
        let size = space.sum(faces.iter().flat_map(|face| &face.points).map(|point| point.weight).sum());
        let crew = space.part.as_ref().map(|part| part.crew().clone());
        let (largest, last, deforms) = (Largest::default(), Flow::default(), space.deforms);
        let u = if deforms { state.u.clone() } else { vec![] };
        let mut balance = Balance { largest, faces, size, density, deforms, time, last, u, crew };
        balance.last = balance.flow(state);
        balance
    }

    /// Go on from `state` at `time` \[s\].
    pub fn restart(&mut self, state: &State, time: f64) {
        (self.last, self.time) = (self.flow(state), time);
        let kept = self.u.len();
        self.u.copy_from_slice(&state.u[..kept]);
    }

    /// Look at the solution `state` of a step that ends at `time` \[s\].
    pub fn observe(&mut self, state: &State, time: f64) {
        let (flow, k) = (self.flow(state), time - self.time);
        let largest_of = |values: &[f64]| values.iter().fold(0.0, |max: f64, x| max.max(x.abs()));
        let mut speed = [largest_of(&state.v).max((largest_of(&state.p) / self.density).sqrt())];
        self.reduce(Reduce::Max, &mut speed);
        let [speed] = speed;
        let gap = (self.deforms && k > 0.0).then(|| {
            let mean = 0.5 * (flow.interface + self.last.interface) + self.swept_elsewhere(state) / k;
            ((flow.volume - self.last.volume) / k - mean).abs()
        });
        let largest = &mut self.largest;
        largest.net = largest.net.max(flow.net.abs());
        largest.through = largest.through.max(flow.through);
        largest.speed = largest.speed.max(speed * self.size);
        largest.swept = gap.map(|gap| largest.swept.unwrap_or(0.0).max(gap)).or(largest.swept);
        (self.last, self.time) = (flow, time);
        let kept = self.u.len();
        self.u.copy_from_slice(&state.u[..kept]);
    }

    /// Largest net flow relative to the largest flow; `None` where nothing crosses the boundaries.
    pub fn mass(&self) -> Option<f64> {
        let Largest { net, through, speed, .. } = self.largest;
        (through > NOTHING * speed).then(|| net / through)
    }

    /// Largest gap between the change of the volume and the flow at the interface, relative to the largest flow;
    /// `None` where nothing moves.
    pub fn swept(&self) -> Option<f64> {
        self.mass().and(self.largest.swept).map(|gap| gap / self.largest.through)
    }

    /// Volume \[m²\] that the boundaries other than the interface have swept since `time`: ∫ (u − u⁻) · n, with the mean
    /// of the normals J F⁻ᵀ n of both times, which is exact in the plane.
    fn swept_elsewhere(&self, state: &State) -> f64 {
        let mut swept = 0.0;
        for Face { nodes, points, .. } in self.faces.iter().filter(|face| !face.at_solid) {
            for Point { weight, radius, normal, value, grad, .. } in points {
                let (mut moved, mut grads) = (Vector::zero(), [Tensor::zero(); 2]);
                let mut outward = [0.0; 2];
                for ((&node, value), grad) in nodes.iter().zip(value).zip(grad) {
                    for i in 0..D {
                        let entry = node as usize * D + i;
                        let both = [self.u[entry], state.u[entry]];
                        moved.0[i] += value * (both[1] - both[0]);
                        if i == 0 {
                            (0..2).for_each(|end| outward[end] += value * both[end]);
                        }
                        for (sum, u) in grads.iter_mut().zip(both) {
                            (0..D).for_each(|d| sum.0[i][d] += grad[d] * u);
                        }
                    }
                }
                let at = |tau: f64| {
                    let grad = grads[0] * (1.0 - tau) + grads[1] * tau;
                    let u_r = (1.0 - tau) * outward[0] + tau * outward[1];
                    cofactor(&grad) * *normal * stretch(*radius, u_r)
                };
                let mean = match radius {
                    None => (at(0.0) + at(1.0)) * 0.5,
                    // Quadratic in τ.
                    Some(_) => (at(0.0) + at(0.5) * 4.0 + at(1.0)) * (1.0 / 6.0),
                };
                swept += weight * moved.dot(mean);
            }
        }
        let mut swept = [swept];
        self.reduce(Reduce::Sum, &mut swept);
        swept[0]
    }

    /// Numbers of all processes that share the space.
    fn reduce(&self, how: Reduce, values: &mut [f64]) {
        if let Some(crew) = &self.crew {
            crew.reduce(how, values);
        }
    }

    fn flow(&self, state: &State) -> Flow {
        let mut flow = Flow::default();
        for Face { nodes, points, at_solid } in &self.faces {
            for Point { weight, radius, x, normal, value, grad } in points {
                let (mut v, mut at, mut grad_u) = (Vector::zero(), *x, Tensor::zero());
                for ((&node, value), grad) in nodes.iter().zip(value).zip(grad) {
                    for i in 0..D {
                        let entry = node as usize * D + i;
                        v.0[i] += value * state.v[entry];
                        if self.deforms {
                            at.0[i] += value * state.u[entry];
                            (0..D).for_each(|d| grad_u.0[i][d] += grad[d] * state.u[entry]);
                        }
                    }
                }
                let n = cofactor(&grad_u) * *normal * stretch(*radius, at.0[0] - x.0[0]);
                let through = weight * v.dot(n);
                flow.net += through;
                flow.through += 0.5 * through.abs();
                flow.interface += if *at_solid { through } else { 0.0 };
                // The divergence of x is D in the plane; around the axis that of z e_z is 1.
                flow.volume +=
                    weight * if radius.is_some() { at.0[1] * n.0[1] } else { at.dot(n) / D as f64 };
            }
        }
        let mut sums = [flow.net, flow.through, flow.interface, flow.volume];
        self.reduce(Reduce::Sum, &mut sums);
        let [net, through, interface, volume] = sums;
        Flow { net, through, interface, volume }
    }
}

/// (r + u_r)/r around an axis, 1 in the plane.
fn stretch(radius: Option<f64>, u_r: f64) -> f64 {
    radius.map_or(1.0, |r| 1.0 + u_r / r)
}

/// The facets of the boundary of the fluid.
fn faces<const D: usize>(space: &FsiSpace<D>) -> Vec<Face<D>> {
    let degree = space.nodes.degree.max(space.mesh.degree);
    let mut origin = space.part.as_ref().map(|_| first_corner(space));
    let mut faces = vec![];
    let boundary = FluidBoundary::new(space);
    for facet in boundary.facets.iter().filter(|facet| space.owns_cell(facet.side.cell as usize)) {
        let (on_cell, nodes): (Vec<usize>, Vec<u32>) =
            space.facet_functions(&facet.facet()).into_iter().unzip();
        let of = |p: crate::sampling::FacetPoint<D>| {
            let from = *origin.get_or_insert(p.x);
            let along = |a: &usize| {
                let grad = Vector(p.grad[*a]);
                (grad - p.normal * grad.dot(p.normal)).0
            };
            Point {
                weight: p.weight,
                radius: p.radius.filter(|r| *r > 0.0),
                x: Vector(p.x) - Vector(from),
                normal: p.normal,
                value: on_cell.iter().map(|&a| p.value[a]).collect(),
                grad: on_cell.iter().map(along).collect(),
            }
        };
        let points = facet_points(space, &facet.facet(), degree + space.coordinates.dimension(D) - 2)
            .into_iter()
            .map(of)
            .collect();
        faces.push(Face { nodes, points, at_solid: facet.at_solid });
    }
    faces
}

/// The lower corner of the box around what all processes have, which is one point for all of them.
fn first_corner<const D: usize>(space: &FsiSpace<D>) -> [f64; D] {
    let least = |d: usize| space.mesh.nodes.iter().map(|x| x[d]).fold(f64::INFINITY, f64::min);
    let mut corner = std::array::from_fn(least);
    space.reduce(Reduce::Min, &mut corner);
    corner
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::rectangle;
    use crate::space::{PressureKind, Region};

    /// A square of 2 × 1 whose right half is solid.
    fn space() -> FsiSpace<2> {
        let mut mesh = rectangle([3.0, 5.0], [5.0, 6.0], [4, 2], 0).unwrap();
        mesh.assign_region("solid", |x| x[0] - 4.0).unwrap();
        mesh.mark_interface("fluid", "solid").unwrap();
        let regions =
            mesh.cell_region.iter().map(|&r| if r == 0 { Region::Fluid } else { Region::Solid }).collect();
        FsiSpace::new(mesh, regions, 2, PressureKind::Pdc(1))
    }

    /// At every node `v(x)` and `u(x)`.
    fn state(
        space: &FsiSpace<2>,
        v: impl Fn([f64; 2]) -> [f64; 2],
        u: impl Fn([f64; 2]) -> [f64; 2],
    ) -> State {
        let of = |f: &dyn Fn([f64; 2]) -> [f64; 2]| space.nodes.points.iter().flat_map(|&x| f(x)).collect();
        State { v: of(&v), u: of(&u), p: vec![0.0; space.n_p()], s: vec![] }
    }

    #[test]
    fn what_comes_in_and_does_not_go_out_is_told() {
        let space = space();
        let still = state(&space, |_| [0.0; 2], |_| [0.0; 2]);
        let mut balance = Balance::new(&space, 1e3, &still, 0.0);
        assert!((balance.last.volume - 1.0).abs() < 1e-14, "{:?}", balance.last);
        balance.observe(&still, 0.1);
        assert_eq!((balance.mass(), balance.swept()), (None, None));
        // Rounding under a pressure of 1e4 Pa.
        let mut rounding = state(&space, |x| [1e-13 * (x[1] - 5.3), 1e-13], |_| [0.0; 2]);
        rounding.p.fill(1e4);
        let mut resting = Balance::new(&space, 1e3, &still, 0.0);
        resting.observe(&rounding, 0.1);
        assert_eq!(resting.mass(), None);
        // Along all walls but the left one, where 0.3 come in.
        balance.observe(&state(&space, |x| [0.3 * (4.0 - x[0]), 0.0], |_| [0.0; 2]), 0.2);
        assert!((balance.mass().unwrap() - 2.0).abs() < 1e-13, "0.3 lost of ½ 0.3 through");
        // A flow that goes through is larger; it moves the interface, which does not sweep anything.
        balance.observe(&state(&space, |_| [2.0, 0.0], |_| [0.0; 2]), 0.3);
        assert!((balance.mass().unwrap() - 0.15).abs() < 1e-13);
        assert!((balance.swept().unwrap() - 0.5).abs() < 1e-13);
    }

    #[test]
    fn the_interface_sweeps_what_the_flow_fills() {
        let space = space();
        let moved = |t: f64| {
            let bump = move |x: [f64; 2]| [t * (x[0] - 3.0) * (x[1] - 5.0), 0.0];
            state(&space, |x| bump(x).map(|u| u / t.max(1e-300)), bump)
        };
        let still = state(&space, |_| [0.0; 2], |_| [0.0; 2]);
        let mut balance = Balance::new(&space, 1e3, &still, 0.0);
        balance.observe(&moved(0.1), 0.1);
        assert!((balance.last.volume - 1.05).abs() < 1e-14, "{:?}", balance.last);
        assert!((balance.last.interface - 0.5).abs() < 1e-14);
        balance.largest = Largest::default();
        balance.observe(&moved(0.2), 0.2);
        assert!(balance.swept().unwrap() < 1e-13, "v is ∂_t u: {:?}", balance.swept());
        // An outlet that moves sweeps as much as the volume changes, whatever flows through it.
        let lifted = |t: f64| state(&space, |_| [0.0, 1.0], |x| [0.0, t * (x[1] - 5.0) * (x[0] - 2.0)]);
        let mut outlet = Balance::new(&space, 1e3, &lifted(0.0), 0.0);
        outlet.observe(&lifted(0.1), 0.1);
        assert!((outlet.last.volume - 1.15).abs() < 1e-14 && outlet.mass().is_some(), "{:?}", outlet.last);
        assert!(outlet.swept().unwrap() < 1e-13, "{:?}", outlet.swept());
        // A run that is resumed goes on from the same numbers.
        let (largest, last) = (balance.largest, balance.last);
        let mut resumed = Balance::new(&space, 1e3, &still, 0.0);
        resumed.restart(&moved(0.2), 0.2);
        resumed.largest = largest;
        assert_eq!(resumed.last, last);
    }
}
