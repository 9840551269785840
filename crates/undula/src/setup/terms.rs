//! The terms that conditions on boundaries add to the equations.

use super::functions::{function, padded};
use super::outlets::law;
use crate::case::{Case, Condition};
use crate::operators::outlet::Outlet;
use crate::operators::pressure::pressure;
use crate::operators::spring::spring;
use crate::operators::traction::Traction;
use crate::space::{FsiSpace, Region};
use crate::system::Operator;

impl Case {
    /// The terms that the conditions on boundaries add to the equations.
    pub(super) fn terms<const D: usize>(&self, space: &FsiSpace<D>) -> Vec<Box<dyn Operator<D>>> {
        let mut terms = vec![];
        for (boundary, name) in (0..).zip(&space.mesh.boundaries) {
            for body in [Region::Fluid, Region::Solid] {
                let condition = self.boundary.get(name);
                terms.extend(condition.and_then(|condition| self.term(condition, space, boundary, body)));
                terms.extend(condition.and_then(|condition| self.bed(condition, space, boundary, body)));
            }
        }
        terms
    }

    /// The bed of a condition `spring`, whose pressure is a term of its own.
    fn bed<const D: usize>(
        &self,
        condition: &Condition,
        space: &FsiSpace<D>,
        boundary: u16,
        body: Region,
    ) -> Option<Box<dyn Operator<D>>> {
        let Condition::Spring { stiffness, damping, normal, .. } = condition else { return None };
        let both = [stiffness.clone(), damping.clone()];
        let data = Box::new(move |x: &[f64; D], t: f64| [0, 1].map(|i: usize| both[i].eval(&padded(x), t)));
        let bed = spring(space, boundary, (data, *normal), self.space.quadrature);
        (body == Region::Solid).then(|| Box::new(bed) as Box<dyn Operator<D>>)
    }

    /// The term of a condition on the facets of `body` at a boundary of the mesh.
    fn term<const D: usize>(
        &self,
        condition: &Condition,
        space: &FsiSpace<D>,
        boundary: u16,
        body: Region,
    ) -> Option<Box<dyn Operator<D>>> {
        let n = self.space.quadrature;
        match condition {
            Condition::Traction(g) => Some(Box::new(Traction::new(space, body, boundary, function(g), n))),
            Condition::Pressure { pressure: p, .. } | Condition::Spring { pressure: p, .. }
                if body == Region::Solid || has_correction(condition) =>
            {
                let follows = !matches!(condition, Condition::Pressure { follows: false, .. });
                let p = p.clone();
                let data = Box::new(move |x: &[f64; D], t: f64| p.eval(&padded(x), t));
                Some(Box::new(pressure(space, body, boundary, (data, follows), n)))
            }
            _ if condition.is_lumped() && body == Region::Fluid => {
                let start = match condition {
                    Condition::Windkessel { initial, .. } => initial.eval(&[0.0; 3], 0.0),
                    _ => 0.0,
                };
                Some(Box::new(Outlet::new(space, boundary, law(condition)?, start, n)))
            }
            _ => None,
        }
    }
}

/// Whether the fluid has the do-nothing correction.
pub(super) fn has_correction(condition: &Condition) -> bool {
    matches!(condition, Condition::DoNothing | Condition::Pressure { .. })
}
