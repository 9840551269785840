//! The bodies of a case: fluids and solids, one table each.

use super::Case;
use super::expression::Expression;
use super::key;
use super::schema::{FluidSpec, SolidSpec};
use crate::space::Region;

/// A body force with what it acts on.
pub(crate) struct Load<'a> {
    /// The kind of the body.
    pub body: Region,
    /// Number of the body among those of its kind.
    pub material: u16,
    /// Dotted key.
    pub key: String,
    /// Force per mass \[m/s²\].
    pub force: &'a [Expression],
}

fn table(kind: &str, name: Option<&String>) -> String {
    name.map_or_else(|| kind.into(), |name| key::join(kind, name))
}

impl FluidSpec {
    /// Its table, `fluid` or `fluid.NAME`.
    pub fn table(&self) -> String {
        table("fluid", self.name.as_ref())
    }

    /// Whether another fluid is the same but for its regions and its body force.
    pub(crate) fn flows_like(&self, other: &FluidSpec) -> bool {
        self.density == other.density && self.kinematic_viscosity == other.kinematic_viscosity
    }
}

impl SolidSpec {
    /// Its table, `solid` or `solid.NAME`.
    pub fn table(&self) -> String {
        table("solid", self.name.as_ref())
    }

    /// λ + 2 μ \[Pa\], or Young's modulus 3 μ where the volume is kept.
    pub(crate) fn stiffness(&self) -> f64 {
        if self.lambda.is_finite() { self.lambda + 2.0 * self.mu } else { 3.0 * self.mu }
    }

    /// Whether its volume cannot change.
    pub(crate) fn keeps_volume(&self) -> bool {
        self.law.is_incompressible() && self.lambda.is_infinite()
    }
}

impl Case {
    /// Regions of the mesh that fluids fill.
    pub(crate) fn fluid_regions(&self) -> Vec<&str> {
        self.fluids.iter().flat_map(|fluid| &fluid.regions).map(String::as_str).collect()
    }

    /// Regions of the mesh that solids fill.
    pub(crate) fn solid_regions(&self) -> Vec<&str> {
        self.solids.iter().flat_map(|solid| &solid.regions).map(String::as_str).collect()
    }

    /// The kind of the body that fills `region` of the mesh, and its number among those of its kind; `None` if none does.
    pub(crate) fn body_in(&self, region: &str) -> Option<(Region, u16)> {
        let fills = |regions: &[String]| regions.iter().any(|other| other == region);
        let fluid = self.fluids.iter().position(|fluid| fills(&fluid.regions));
        let solid = self.solids.iter().position(|solid| fills(&solid.regions));
        match (fluid, solid) {
            (Some(number), _) => Some((Region::Fluid, number as u16)),
            (None, Some(number)) => Some((Region::Solid, number as u16)),
            (None, None) => None,
        }
    }

    /// Tables of the bodies with their regions, fluids first.
    pub(crate) fn tables_of_bodies(&self) -> Vec<(String, &[String])> {
        let fluids = self.fluids.iter().map(|fluid| (fluid.table(), &fluid.regions[..]));
        fluids.chain(self.solids.iter().map(|solid| (solid.table(), &solid.regions[..]))).collect()
    }

    /// The body forces, those of fluids first.
    pub(crate) fn loads(&self) -> Vec<Load<'_>> {
        let load = |body, material, table: String, force| Load {
            body,
            material,
            key: format!("{table}.body-force"),
            force,
        };
        let fluids = (0..).zip(&self.fluids).map(|(n, f)| load(Region::Fluid, n, f.table(), &f.body_force));
        let solids = (0..).zip(&self.solids).map(|(n, s)| load(Region::Solid, n, s.table(), &s.body_force));
        fluids.chain(solids).collect()
    }
}
