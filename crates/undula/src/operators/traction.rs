//! A given force per area on a boundary, a dead load.
//!
//! J σ F⁻ᵀ N = g(X, t) on the reference boundary Γ with the outward normal N. The residual has
//! ```text
//!     −θ ⟨g(t), φ⟩_Γ − (1 − θ) ⟨g(t⁻), φ⟩_Γ;
//! ```
//! schemes that integrate over the step take g of its middle. Nothing of it depends on the solution.

use super::{DataTime, End, NotFinite, Operator, StepView};
use crate::math::Vector;
use crate::mesh::Side;
use crate::sampling::{FacetPoint, facet_points};
use crate::space::{FsiSpace, Region};

/// g(X, t) \[N/m²\] at a reference position \[m\] and a time \[s\].
pub type Load<const D: usize> = Box<dyn Fn(&[f64; D], f64) -> [f64; D] + Send + Sync>;

/// The load on the facets of one body at one boundary.
pub struct Traction<const D: usize> {
    body: Region,
    boundary: u16,
    load: Load<D>,
    facets: Vec<(Side, Vec<u32>, Vec<FacetPoint<D>>)>,
    /// g at the points of all facets, at the old and the new time.
    values: [Vec<Vector<f64, D>>; 2],
}

impl<const D: usize> Traction<D> {
    /// On the facets of `body` at `boundary`, `n` Gauss points per direction; zero until data are set.
    pub fn new(space: &FsiSpace<D>, body: Region, boundary: u16, load: Load<D>, n: usize) -> Traction<D> {
        let here = space
            .mesh
            .facets
            .iter()
            .filter(|facet| facet.boundary == boundary && space.regions[facet.cell as usize] == body);
        let facets: Vec<_> = here
            .map(|facet| {
                let nodes = space.nodes.cell(facet.cell as usize).to_vec();
                (facet.side(), nodes, facet_points(space, facet, n))
            })
            .collect();
        let zero = vec![Vector::zero(); facets.iter().map(|(.., points)| points.len()).sum()];
        Traction { body, boundary, load, facets, values: [zero.clone(), zero] }
    }

    /// Call `visit` with the nodes of each facet, each point and −g there, weighted.
    fn visit(
        &self,
        end: End,
        weight: f64,
        mut visit: impl FnMut(Side, &[u32], &FacetPoint<D>, Vector<f64, D>),
    ) {
        let mut rest = &self.values[end as usize][..];
        for (side, nodes, points) in &self.facets {
            let (values, behind) = rest.split_at(points.len());
            rest = behind;
            for (point, g) in points.iter().zip(values) {
                visit(*side, nodes, point, *g * (-weight * point.weight));
            }
        }
    }

    fn add(&self, end: End, weight: f64, out: &mut [f64]) {
        self.visit(end, weight, |_, nodes, point, t| {
            for (value, &node) in point.value.iter().zip(nodes) {
                for i in 0..D {
                    out[node as usize * D + i] += value * t.0[i];
                }
            }
        });
    }
}

/// The weight of the new end: θ, or 1 where the step is integrated.
fn weight(step: &StepView<'_>) -> f64 {
    // The sum is the same in all dimensions.
    step.rule.transport_points::<2>().map(|(weight, _)| weight).sum()
}

impl<const D: usize> Operator<D> for Traction<D> {
    fn body(&self) -> Region {
        self.body
    }

    fn set_data(&mut self, at: &DataTime) -> Result<(), NotFinite<D>> {
        let points = self.facets.iter().flat_map(|(.., points)| points);
        for (value, point) in self.values[at.end as usize].iter_mut().zip(points) {
            let g = (self.load)(&point.x, at.time);
            if !g.iter().all(|g| g.is_finite()) {
                return Err(NotFinite { boundary: self.boundary, at: point.x, value: g });
            }
            *value = Vector(g) * at.load;
        }
        Ok(())
    }

    fn explicit(&mut self, step: &StepView<'_>, out: &mut [f64]) {
        self.add(End::Old, 1.0 - step.rule.theta, out);
    }

    fn residual(&mut self, step: &StepView<'_>, out: &mut [f64]) -> f64 {
        self.add(End::New, weight(step), out);
        f64::INFINITY
    }

    fn force_through(&self, step: &StepView<'_>, sides: &[Side]) -> Vector<f64, D> {
        let mut sum = Vector::zero();
        let mut add = |side: Side, _: &[u32], _: &FacetPoint<D>, t: Vector<f64, D>| {
            if sides.contains(&side) {
                sum += t;
            }
        };
        self.visit(End::New, weight(step), &mut add);
        if step.rule.has_explicit() {
            self.visit(End::Old, 1.0 - step.rule.theta, &mut add);
        }
        sum
    }
}
