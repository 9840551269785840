//! The discrete inf-sup constants (5.24) and (5.25) as the smallest eigenvalue of a Schur complement.
//!
//! With A of (J ∇v F⁻¹, ∇φ F⁻¹), B of (div(J F⁻¹v), ξ) and M of (J p, ξ) the constant is the root of the smallest
//! eigenvalue of B A⁻¹ Bᵀ q = γ² M q: the supremum over v is reached at A⁻¹ Bᵀ p. The numerator of (5.24) has no
//! further factor, as div(J F⁻¹v) is J times the divergence in the moved domain.
//!
//! Erratum: (5.24) prints ∇v F⁻ᵀ in the norm, which with (∇v)_ij = ∂_j v_i is no gradient of the moved domain; the
//! test `constants_are_those_of_the_moved_mesh` shows it.
#![allow(non_snake_case)]

use super::lanczos::largest;
use crate::algebra::{Csr, Kind, LinearSolver, MultifrontalLu, Options, Pattern, SolverError, Unknown};
use crate::math::Vector;
use crate::physics::Kinematics;
use crate::sampling::{PointValues, for_each_point};
use crate::space::{Constraints, FsiSpace, PressureKind, PsiOwner, Region, State};
use crate::system::homes;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Added to γ²: modes without any velocity get 1/SHIFT as the largest eigenvalue of the inverse.
const SHIFT: f64 = 1e-10;

/// An inf-sup constant.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct InfSup {
    /// γ_h; 0 to about 1e-5 if a pressure does no work on any velocity.
    pub constant: f64,
    /// Whether constant pressures do no work, as in a connected part of the fluid that is closed in: they are left out.
    pub closed: bool,
}

/// Numbers of the velocities that take part: in the fluid, neither given nor on the interface.
fn free_velocities<const D: usize>(space: &FsiSpace<D>, constraints: &Constraints<D>) -> Vec<u32> {
    let directed: Vec<u32> = constraints.directions.iter().map(|at| at.node).collect();
    let mut number = vec![u32::MAX; space.nodes.len()];
    let (drifting, mut n) = (drifting(space, constraints), 0);
    for cell in (0..space.mesh.n_cells()).filter(|&c| space.regions[c] == Region::Fluid) {
        for &node in space.nodes.cell(cell) {
            let node = node as usize;
            // Where a boundary lets the flow along it pass, all of it is left out.
            let slips = constraints.v[node].contains(&true) || directed.contains(&(node as u32));
            let given = slips || drifting.contains(&node) || space.owner[node] == PsiOwner::Relation;
            if number[node] == u32::MAX && !given {
                number[node] = n;
                n += 1;
            }
        }
    }
    number
}

/// A node of each connected part of the fluid that nothing holds, as it may be between seams: a constant velocity changes
/// neither ∇v nor ∇·v, so that it may vanish there.
fn drifting<const D: usize>(space: &FsiSpace<D>, constraints: &Constraints<D>) -> Vec<usize> {
    if space.seams.is_empty() {
        return vec![];
    }
    let part = space.components_by(&space.inner_facets());
    let mut parts: BTreeMap<u32, (usize, bool)> = BTreeMap::new();
    for cell in (0..space.mesh.n_cells()).filter(|&c| space.regions[c] == Region::Fluid) {
        let nodes = space.nodes.cell(cell);
        let held = |&node: &u32| {
            let at = node as usize;
            constraints.v[at].contains(&true) || space.owner[at] == PsiOwner::Relation
        };
        let (_, is_held) = parts.entry(part[cell]).or_insert((nodes[0] as usize, false));
        *is_held |= nodes.iter().any(held);
    }
    parts.into_values().filter(|(_, held)| !held).map(|(node, _)| node).collect()
}

/// The saddle point matrix \[A Bᵀ; B −SHIFT M\] and M.
struct System {
    matrix: Csr,
    mass: Csr,
    unknowns: Vec<Unknown>,
    n_v: usize,
}

impl System {
    fn new<const D: usize>(space: &FsiSpace<D>, number: &[u32], state: &State, quadrature: usize) -> System {
        let n_v = D * number.iter().filter(|n| **n != u32::MAX).count();
        let mut rows: Vec<Vec<u32>> = vec![vec![]; n_v + space.n_p()];
        let mut pressures: Vec<Vec<u32>> = vec![vec![]; space.n_p()];
        for cell in (0..space.mesh.n_cells()).filter(|&c| space.regions[c] == Region::Fluid) {
            let nodes = space.nodes.cell(cell).iter().map(|&node| number[node as usize]);
            let nodes: Vec<u32> = nodes.filter(|n| *n != u32::MAX).collect();
            let dofs = space.pressure.cell(cell);
            for &a in &nodes {
                for i in 0..D as u32 {
                    let row = a * D as u32 + i;
                    rows[row as usize].extend(nodes.iter().map(|b| b * D as u32 + i));
                    rows[row as usize].extend(dofs.iter().map(|dof| n_v as u32 + dof));
                    dofs.iter().for_each(|&dof| rows[n_v + dof as usize].push(row));
                }
            }
            for &a in dofs {
                rows[n_v + a as usize].extend(dofs.iter().map(|b| n_v as u32 + b));
                pressures[a as usize].extend(dofs);
            }
        }
        let zeros = |rows: &[Vec<u32>]| Csr::zeros(&Arc::new(Pattern::from_rows(rows)));
        let mut system = System {
            matrix: zeros(&rows),
            mass: zeros(&pressures),
            unknowns: unknowns(space, number, n_v),
            n_v,
        };
        for_each_point(space, state, quadrature, |point| {
            if point.region == Region::Fluid {
                system.add(space, number, point);
            }
        });
        system
    }

    fn add<const D: usize>(&mut self, space: &FsiSpace<D>, number: &[u32], point: &PointValues<'_, D>) {
        let Kinematics { F_inv, J, .. } = Kinematics::of(&point.fields.grad_u);
        let (weight, n_v) = (J * point.weight, self.n_v);
        // Gradients in the moved domain; (div(J F⁻¹v), ξ) = J ∇v F⁻¹ : I.
        let slopes: Vec<_> = point.grad.iter().map(|g| F_inv.t() * Vector(*g)).collect();
        let (nodes, dofs) = (space.nodes.cell(point.cell), space.pressure.cell(point.cell));
        let free = |a: usize| number[nodes[a] as usize];
        for a in (0..nodes.len()).filter(|&a| free(a) != u32::MAX) {
            for i in 0..D {
                let row = free(a) as usize * D + i;
                for b in (0..nodes.len()).filter(|&b| free(b) != u32::MAX) {
                    add(&mut self.matrix, row, free(b) as usize * D + i, weight * slopes[a].dot(slopes[b]));
                }
                for (&dof, basis) in dofs.iter().zip(point.pressure) {
                    let value = weight * basis * slopes[a].0[i];
                    add(&mut self.matrix, row, n_v + dof as usize, value);
                    add(&mut self.matrix, n_v + dof as usize, row, value);
                }
            }
        }
        for (&a, basis) in dofs.iter().zip(point.pressure) {
            for (&b, other) in dofs.iter().zip(point.pressure) {
                let value = weight * basis * other;
                add(&mut self.mass, a as usize, b as usize, value);
                add(&mut self.matrix, n_v + a as usize, n_v + b as usize, -SHIFT * value);
            }
        }
    }

    /// Whether Bᵀ takes `constants` to zero.
    fn is_closed(&self, constants: &[f64]) -> bool {
        let (mut x, mut y) = (vec![0.0; self.matrix.pattern.n], vec![0.0; self.matrix.pattern.n]);
        x[self.n_v..].copy_from_slice(constants);
        self.matrix.mul(&x, &mut y);
        let work = y[..self.n_v].iter().fold(0.0f64, |m, x| m.max(x.abs()));
        x[self.n_v..].iter_mut().enumerate().for_each(|(i, x)| *x *= if i % 2 == 0 { 1.0 } else { -1.0 });
        self.matrix.mul(&x, &mut y);
        work < 1e-9 * y[..self.n_v].iter().fold(0.0f64, |m, x| m.max(x.abs()))
    }
}

fn add(matrix: &mut Csr, row: usize, column: usize, value: f64) {
    if let Some(at) = matrix.pattern.find(row, column) {
        matrix.values[at] += value;
    }
}

fn unknowns<const D: usize>(space: &FsiSpace<D>, number: &[u32], n_v: usize) -> Vec<Unknown> {
    let position = |x: &[f64; D]| std::array::from_fn(|d| if d < D { x[d] } else { 0.0 });
    let first = Unknown { node: 0, kind: Kind::Velocity, at: [0.0; 3] };
    let mut list = vec![first; n_v];
    for (node, &n) in number.iter().enumerate().filter(|(_, n)| **n != u32::MAX) {
        let unknown = Unknown { node: node as u32, at: position(&space.nodes.points[node]), ..first };
        list[n as usize * D..(n as usize + 1) * D].fill(unknown);
    }
    let homes = homes(space, |node| number[node as usize] != u32::MAX);
    for (dof, x) in space.pressure.points.iter().enumerate() {
        let node = match space.pressure.kind {
            PressureKind::Continuous(_) => homes[dof],
            _ => (space.nodes.len() + dof / space.pressure.per_cell) as u32,
        };
        list.push(Unknown { node, kind: Kind::Pressure, at: position(x) });
    }
    list
}

/// Coefficients of the pressure that is 1 in one connected part of the fluid and 0 in the others, for each part.
fn constants<const D: usize>(space: &FsiSpace<D>) -> Vec<Vec<f64>> {
    let continuous = matches!(space.pressure.kind, PressureKind::Continuous(_));
    let mut list: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for (cell, part) in space.mesh.components_by(&space.inner_facets()).into_iter().enumerate() {
        let dofs = space.pressure.cell(cell);
        let ones = if continuous { dofs } else { &dofs[..dofs.len().min(1)] };
        for &dof in ones {
            list.entry(part).or_insert_with(|| vec![0.0; space.n_p()])[dof as usize] = 1.0;
        }
    }
    list.into_values().collect()
}

/// The inf-sup constant of velocity and pressure on the fluid with the deformation `u`, `[node][component]`:
/// (5.24), and (5.25) where `u` is zero. Velocities vanish on the interface and where they are given.
///
/// # Errors
/// If the saddle point matrix cannot be factorised.
pub fn inf_sup<const D: usize>(
    space: &FsiSpace<D>,
    constraints: &Constraints<D>,
    u: &[f64],
    quadrature: usize,
) -> Result<InfSup, SolverError> {
    let number = free_velocities(space, constraints);
    let mut state = State::zero(space.n_v(), space.n_v(), space.n_p());
    state.u[..u.len()].copy_from_slice(u);
    let system = System::new(space, &number, &state, quadrature);
    let mut solver = MultifrontalLu::multifrontal(Options::unprobed());
    solver.analyse(&system.matrix.pattern, &system.unknowns)?;
    solver.factor(&system.matrix)?;
    let (n_v, n_p) = (system.n_v, space.n_p());
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let parts = constants(space).into_iter().filter(|constants| system.is_closed(constants));
    let weighted = |constants: Vec<f64>| {
        let mut weighted = vec![0.0; n_p];
        system.mass.mul(&constants, &mut weighted);
        (dot(&constants, &weighted), constants, weighted)
    };
    let closed: Vec<(f64, Vec<f64>, Vec<f64>)> = parts.map(weighted).collect();
    let project = |q: &mut [f64]| {
        for (size, constants, weighted) in &closed {
            let mean = dot(q, weighted) / size;
            q.iter_mut().zip(constants).for_each(|(q, one)| *q -= mean * one);
        }
    };
    // (S + SHIFT M)⁻¹ M: the second row reads −(S + SHIFT M) q = M q_0.
    let (mut b, mut x) = (vec![0.0; n_v + n_p], vec![0.0; n_v + n_p]);
    let apply = |q: &[f64], image: &mut [f64]| {
        system.mass.mul(q, &mut b[n_v..]);
        solver.apply(&b, &mut x);
        image.iter_mut().zip(&x[n_v..]).for_each(|(image, x)| *image = -x);
    };
    let value = largest(n_p, apply, |x, y| system.mass.mul(x, y), project);
    let square = if value > 0.0 { 1.0 / value - SHIFT } else { 0.0 };
    Ok(InfSup { constant: square.max(0.0).sqrt(), closed: !closed.is_empty() })
}
