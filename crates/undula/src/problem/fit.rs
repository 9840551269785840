//! Whether a case fits its mesh: what names the mesh has, and what holds there.

use super::case::{Case, Condition, FunctionalSpec};
use super::error::{CaseError, CaseErrors, Place, suggestion};
use crate::mesh::Mesh;

/// Name of the boundary between fluid and solid.
pub const INTERFACE: &str = "interface";

/// The names of a complete mesh, before any region is left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshNames {
    /// Regions.
    pub regions: Vec<String>,
    /// Boundaries with the regions whose cells they touch.
    pub boundaries: Vec<(String, Vec<String>)>,
}

impl MeshNames {
    /// The names of `mesh`.
    pub fn of<const D: usize>(mesh: &Mesh<D>) -> Self {
        let mut boundaries: Vec<(String, Vec<String>)> =
            mesh.boundaries.iter().map(|name| (name.clone(), Vec::new())).collect();
        for facet in &mesh.facets {
            let region =
                mesh.cell_region.get(facet.cell as usize).and_then(|r| mesh.regions.get(usize::from(*r)));
            let boundary = boundaries.get_mut(usize::from(facet.boundary));
            if let (Some(region), Some((_, touched))) = (region, boundary)
                && !touched.contains(region)
            {
                touched.push(region.clone());
            }
        }
        Self { regions: mesh.regions.clone(), boundaries }
    }
}

impl Case {
    /// Compares the names in the case with those of the complete mesh.
    ///
    /// Regions without `[fluid]` or `[solid]` are left out together with their boundaries, which may be
    /// listed in the case nevertheless.
    ///
    /// # Errors
    /// Regions and boundaries that the mesh does not have, boundaries without a condition, conditions
    /// that do not suit their region, and bodies that nothing holds.
    pub fn check_mesh(&self, names: &MeshNames) -> Result<(), CaseErrors> {
        let mut fit = Fit { case: self, names, errors: Vec::new() };
        fit.regions();
        // With a region missing, all that follows would be noise.
        if fit.errors.is_empty() {
            fit.boundaries();
            fit.functionals();
            fit.held();
        }
        if fit.errors.is_empty() { Ok(()) } else { Err(CaseErrors(fit.errors)) }
    }

    /// Regions of the mesh that are computed on: those of `[fluid]` and `[solid]`.
    pub fn regions(&self) -> Vec<&str> {
        let fluid = self.fluid.as_ref().map(|f| f.region.as_str());
        let solid = self.solid.as_ref().map(|s| s.region.as_str());
        fluid.into_iter().chain(solid).collect()
    }

    /// Place of the dotted `key`, or of the longest part of it that was given.
    pub fn place_of(&self, key: &str) -> Place {
        let mut part = key;
        loop {
            if let Some(place) = self.record.places.get(part) {
                return place.clone();
            }
            match part.rsplit_once('.') {
                Some((shorter, _)) => part = shorter,
                None => return Place::File { name: self.record.file_name.clone(), line: 1, column: 1 },
            }
        }
    }
}

struct Fit<'a> {
    case: &'a Case,
    names: &'a MeshNames,
    errors: Vec<CaseError>,
}

impl Fit<'_> {
    fn error(&mut self, key: &str, message: String) {
        let place = self.case.place_of(key);
        self.errors.push(CaseError { place, key: key.into(), value: None, message });
    }

    fn regions(&mut self) {
        let fluid = self.case.fluid.as_ref().map(|f| ("fluid", &f.region));
        let solid = self.case.solid.as_ref().map(|s| ("solid", &s.region));
        for (body, region) in fluid.into_iter().chain(solid) {
            if !self.names.regions.contains(region) {
                let message = absent("region", region, self.names.regions.iter().map(String::as_str));
                self.error(&format!("{body}.region"), message);
            }
        }
    }

    fn absent_boundary(&self, name: &str) -> String {
        absent("boundary", name, self.names.boundaries.iter().map(|(n, _)| n.as_str()))
    }

    /// Whether a boundary touches the region of the fluid, of the solid.
    fn touches(&self, regions: &[String]) -> (bool, bool) {
        let has = |region: Option<&String>| region.is_some_and(|r| regions.contains(r));
        (has(self.case.fluid.as_ref().map(|f| &f.region)), has(self.case.solid.as_ref().map(|s| &s.region)))
    }

    fn boundaries(&mut self) {
        for name in self.case.boundary.keys() {
            if !self.names.boundaries.iter().any(|(n, _)| n == name) {
                let message = self.absent_boundary(name);
                self.error(&format!("boundary.{name}"), message);
            }
        }
        for (name, regions) in &self.names.boundaries {
            let (fluid, solid) = self.touches(regions);
            if name == INTERFACE || !(fluid || solid) {
                continue;
            }
            let key = format!("boundary.{name}");
            match self.case.boundary.get(name) {
                None => {
                    let allowed = match (fluid, solid) {
                        (_, false) => "`velocity`, `no-slip`, `do-nothing` or `traction-free`",
                        (false, true) => "`clamped` or `traction-free`",
                        (true, true) => "`no-slip` or `traction-free`",
                    };
                    let message = format!(
                        "boundary `{name}` of the mesh has no condition: add [boundary.{}] with condition = {allowed}",
                        toml_key(name)
                    );
                    self.error("boundary", message);
                }
                Some(Condition::Clamped) if !solid => {
                    self.error(
                        &format!("{key}.condition"),
                        "`clamped` is for a solid, and only the fluid is here; use `no-slip`".into(),
                    );
                }
                Some(Condition::Velocity(_) | Condition::DoNothing) if !fluid => {
                    let message = "only the solid is here; use `clamped` or `traction-free`";
                    self.error(&format!("{key}.condition"), message.into());
                }
                Some(_) => {}
            }
        }
    }

    fn functionals(&mut self) {
        for (name, functional) in &self.case.functional {
            let FunctionalSpec::Force { on, .. } = functional else { continue };
            let key = format!("functional.{name}.on");
            for boundary in on {
                match self.names.boundaries.iter().find(|(n, _)| n == boundary) {
                    None => {
                        let message = self.absent_boundary(boundary);
                        self.error(&key, message);
                    }
                    Some((_, regions)) if boundary != INTERFACE && !self.touches(regions).0 => {
                        self.error(&key, format!("the fluid does not touch the boundary `{boundary}`"));
                    }
                    Some(_) => {}
                }
            }
        }
    }

    /// A stationary solid needs a hold, a fluid on its own a way out.
    fn held(&mut self) {
        let with = |test: &dyn Fn(&Condition, (bool, bool)) -> bool| {
            self.names.boundaries.iter().any(|(name, regions)| {
                self.case.boundary.get(name).is_some_and(|condition| test(condition, self.touches(regions)))
            })
        };
        let holds = |c: &Condition, (_, solid): (bool, bool)| {
            solid && !matches!(c, Condition::TractionFree | Condition::DoNothing)
        };
        let lets_out = |c: &Condition, (fluid, _): (bool, bool)| {
            fluid && matches!(c, Condition::TractionFree | Condition::DoNothing)
        };
        let (held, open) = (with(&holds), with(&lets_out));
        let kept =
            self.case.solid.as_ref().is_some_and(|s| s.law.is_incompressible() && s.lambda.is_infinite());
        let yields = |c: &Condition, (_, solid): (bool, bool)| solid && *c == Condition::TractionFree;
        let surface = self.case.fluid.is_none() && self.names.boundaries.iter().any(|(n, _)| n == INTERFACE);
        if kept && !open && !surface && !with(&yields) {
            let message = "its volume cannot change and no boundary gives way, so that pressures are determined up \
                           to a constant only: one boundary needs condition = `traction-free` or `do-nothing`, or \
                           give `bulk`";
            self.error("solid.law", message.into());
        }
        if self.case.solid.is_some() && self.case.time.is_none() && !held {
            let message = "nothing holds the solid, so it has no stationary state: add a boundary with condition = `clamped`";
            self.error("solid", message.into());
        }
        if self.case.fluid.is_some() && self.case.solid.is_none() && !open {
            let message = "the fluid is closed in on all sides, so its pressure is determined up to a constant only: \
                           one boundary needs condition = `do-nothing` or `traction-free`";
            self.error("fluid", message.into());
        }
    }
}

/// `name` as a key of TOML, in quotes where it needs them.
fn toml_key(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if !name.is_empty() && name.chars().all(bare) { name.into() } else { format!("{name:?}") }
}

fn absent<'a>(kind: &str, name: &str, all: impl Iterator<Item = &'a str> + Clone) -> String {
    format!("the mesh has no {kind} `{name}`{}", suggestion(name, all))
}
