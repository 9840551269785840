//! Stiffness and mass of the solid.

use super::{Mode, Setting, frequency};
use crate::algebra::{Csr, Kind, Pattern, Unknown};
use crate::math::{Tensor, Vector};
use crate::physics::Solid;
use crate::sampling::{PointValues, for_each_point};
use crate::space::{FsiSpace, Region, State};
use std::sync::Arc;

/// Marks a component without unknown.
pub(super) const NONE: u32 = u32::MAX;

/// K and M on the free components of the nodes of the solid.
pub(super) struct Body {
    /// Number of the unknown of each place 2 a + i, node a and component i; [`NONE`] where it is held or off the body.
    pub(super) number: Vec<u32>,
    /// Place of each unknown.
    pub(super) places: Vec<u32>,
    /// K \[Pa\].
    pub(super) stiffness: Csr,
    /// M \[kg/m\].
    pub(super) mass: Csr,
    /// What the linear solver may know of the unknowns.
    pub(super) unknowns: Vec<Unknown>,
}

impl Body {
    /// Of the solid cells of the space.
    pub(super) fn new(setting: &Setting<'_>) -> Body {
        let space = setting.space;
        let (number, places) = numbers(setting);
        let pattern = Arc::new(Pattern::from_rows(&rows(space, &number, places.len())));
        let unknown = |&place: &u32| {
            let [x, y] = space.nodes.points[place as usize / 2];
            Unknown { node: place / 2, kind: Kind::Deformation, at: [x, y, 0.0] }
        };
        let unknowns = places.iter().map(unknown).collect();
        let (stiffness, mass) = (Csr::zeros(&pattern), Csr::zeros(&pattern));
        let mut body = Body { number, places, stiffness, mass, unknowns };
        let rest = State::zero(space.n_v(), space.n_u(), space.n_p());
        for_each_point(space, &rest, setting.quadrature, |point| {
            if point.region == Region::Solid {
                let material = usize::from(space.material[point.cell]);
                let solid = &setting.solids[material];
                body.add(setting, solid.rho, &elasticity(solid, &point.fabric.fibre), point);
            }
        });
        for &(row, column, k) in &setting.springs {
            let [row, column] = [row, column].map(|place| body.number[place as usize]);
            let free = row != NONE && column != NONE;
            if let Some(at) =
                free.then(|| body.stiffness.pattern.find(row as usize, column as usize)).flatten()
            {
                body.stiffness.values[at] += k;
            }
        }
        body
    }

    fn add(
        &mut self,
        setting: &Setting<'_>,
        density: f64,
        elasticity: &[[Tensor<f64, 2>; 2]; 2],
        point: &PointValues<'_, 2>,
    ) {
        let nodes = setting.space.nodes.cell(point.cell);
        for (b, &column_node) in nodes.iter().enumerate() {
            for j in 0..2 {
                let column = self.number[2 * column_node as usize + j];
                if column == NONE {
                    continue;
                }
                let [x, y] = point.grad[b];
                let stress = point.weight * (x * elasticity[j][0] + y * elasticity[j][1]);
                let inertia = point.weight * density * point.value[b];
                for (a, &row_node) in nodes.iter().enumerate() {
                    for i in 0..2 {
                        let row = self.number[2 * row_node as usize + i];
                        let at = if row == NONE {
                            None
                        } else {
                            self.mass.pattern.find(row as usize, column as usize)
                        };
                        let Some(at) = at else { continue };
                        let [x, y] = point.grad[a];
                        self.stiffness.values[at] += stress.0[i][0] * x + stress.0[i][1] * y;
                        if i == j {
                            self.mass.values[at] += inertia * point.value[a];
                        }
                    }
                }
            }
        }
    }

    /// The mode of an eigenvalue 1/ω² with its vector.
    pub(super) fn mode(&self, (inverse, vector): &(f64, Vec<f64>)) -> Mode {
        let mut shape = vec![0.0; self.number.len()];
        self.places.iter().zip(vector).for_each(|(&place, x)| shape[place as usize] = *x);
        Mode { frequency: frequency(*inverse), shape }
    }
}

/// Unknowns of the nodes of the solid in their order.
fn numbers(setting: &Setting<'_>) -> (Vec<u32>, Vec<u32>) {
    let space = setting.space;
    let (mut number, mut places) = (vec![NONE; space.n_v()], vec![]);
    for cell in (0..space.mesh.n_cells()).filter(|&cell| space.regions[cell] == Region::Solid) {
        for &node in space.nodes.cell(cell) {
            for i in (0..2).filter(|&i| !setting.held[node as usize][i]) {
                let place = 2 * node as usize + i;
                if number[place] == NONE {
                    number[place] = places.len() as u32;
                    places.push(place as u32);
                }
            }
        }
    }
    (number, places)
}

/// The unknowns that share a cell with each unknown.
fn rows(space: &FsiSpace<2>, number: &[u32], n: usize) -> Vec<Vec<u32>> {
    let mut rows = vec![vec![]; n];
    for cell in (0..space.mesh.n_cells()).filter(|&cell| space.regions[cell] == Region::Solid) {
        let places = space.nodes.cell(cell).iter().flat_map(|node| [2 * node, 2 * node + 1]);
        let unknowns: Vec<u32> =
            places.map(|place| number[place as usize]).filter(|&unknown| unknown != NONE).collect();
        unknowns.iter().for_each(|&row| rows[row as usize].extend(&unknowns));
    }
    rows
}

/// ∂P/∂(∂_d u_j) at rest, `[j][d]`.
fn elasticity(solid: &Solid, fibre: &Vector<f64, 2>) -> [[Tensor<f64, 2>; 2]; 2] {
    let along = |j: usize, d: usize| {
        let mut slope = Tensor::zero();
        slope.0[j][d] = 1.0;
        solid.material.derivative_at(fibre, &Tensor::zero(), &slope)
    };
    [0, 1].map(|j| [0, 1].map(|d| along(j, d)))
}
