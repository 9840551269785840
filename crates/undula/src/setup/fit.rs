//! Whether a case fits its mesh: what holds at its names.

use super::names::MeshNames;
use crate::case::conditions::CONDITIONS;
use crate::case::error::{CaseError, CaseErrors, Place, quoted, suggestion};
use crate::case::key;
use crate::case::{Case, Condition, FunctionalSpec};
use crate::mesh::INTERFACE;
use crate::space::{Against, Region};

#[doc(hidden)]
impl Case {
    /// Compares the names in the case with those of the complete mesh.
    ///
    /// Regions that are left out are so together with their boundaries, which may be listed in the case nevertheless.
    ///
    /// # Errors
    /// Regions and boundaries that the mesh does not have, regions that no table uses, boundaries without a condition,
    /// conditions that do not suit their region, and bodies that nothing holds.
    pub fn check_mesh(&self, names: &MeshNames) -> Result<(), CaseErrors> {
        let mut fit = Fit { case: self, names, errors: Vec::new() };
        fit.regions();
        // With a region missing, all that follows would be noise.
        if fit.errors.is_empty() {
            fit.boundaries();
            fit.functionals();
            fit.held();
            fit.fluids();
        }
        if fit.errors.is_empty() { Ok(()) } else { Err(CaseErrors(fit.errors)) }
    }

    /// Place of the dotted `key`, or of the longest part of it that was given.
    pub fn place_of(&self, key: &str) -> Place {
        let mut part = key;
        loop {
            if let Some(place) = self.record.places.get(part) {
                return place.clone();
            }
            match key::parent(part) {
                Some(shorter) => part = shorter,
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
        self.errors.extend(self.case.check_regions(&self.names.regions));
    }

    fn absent_boundary(&self, name: &str) -> String {
        absent("boundary", name, self.names.boundaries.iter().map(|(n, _)| n.as_str()))
    }

    /// Whether a boundary touches the region of the fluid, of the solid.
    fn touches(&self, regions: &[String]) -> (bool, bool) {
        let has = |filled: Vec<&str>| regions.iter().any(|region| filled.contains(&region.as_str()));
        (has(self.case.fluid_regions()), has(self.case.solid_regions()))
    }

    fn absent_boundaries(&mut self) {
        for name in self.case.boundary.keys() {
            if !self.names.boundaries.iter().any(|(n, _)| n == name) {
                let message = self.absent_boundary(name);
                let key = key::join("boundary", name);
                let key = match self.case.boundary.get(name) {
                    Some(Condition::Periodic(with)) if !self.case.record.places.contains_key(&key) => {
                        self.case.partner_key(with, name)
                    }
                    _ => key,
                };
                self.error(&key, message);
            }
        }
    }

    fn boundaries(&mut self) {
        self.absent_boundaries();
        for (name, regions) in &self.names.boundaries {
            let (fluid, solid) = self.touches(regions);
            if name == INTERFACE {
                continue;
            }
            let key = key::join("boundary", name);
            let condition = self.case.boundary.get(name);
            // A part may be seen from a region that is left out.
            if condition.is_some() && self.is_part(name) {
                self.error(&key, self.part_of_interface(name));
                continue;
            }
            if !(fluid || solid) {
                continue;
            }
            match condition {
                // Parts of the interface, and sides of regions that are left out.
                None if self.names.is_inside(name, &self.case.regions()) => {}
                None => {
                    let suits = |condition: &Condition| condition.suits(fluid, solid);
                    let allowed = CONDITIONS.iter().filter(|row| suits(&row.value)).map(|row| row.name);
                    let allowed = quoted(allowed);
                    let message = format!(
                        "boundary `{name}` of the mesh has no condition: add [boundary.{}] with condition = one of {allowed}",
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
                Some(condition) if !condition.suits(fluid, solid) => {
                    let names =
                        CONDITIONS.iter().filter(|row| row.value.suits(fluid, solid)).map(|row| row.name);
                    let here = match (fluid, solid) {
                        (true, true) => "fluid and solid are here, and it is for one of them",
                        (true, false) => "only the fluid is here",
                        _ => "only the solid is here",
                    };
                    let message = format!("{here}; use one of {}", quoted(names));
                    self.error(&format!("{key}.condition"), message);
                }
                Some(_) => {}
            }
            let given = self.case.backflow.get(name).is_some_and(|against| *against != Against::None);
            if given && !self.case.fluids.is_empty() && !fluid {
                let message = "it is for an outlet of the fluid, and only the solid is here; remove it";
                self.error(&format!("{key}.backflow"), message.into());
            }
        }
    }

    /// Whether `name` lies on no facet of the bodies but those of the interface.
    fn is_part(&self, name: &str) -> bool {
        let kept = self.case.regions();
        let mut bodies = self.names.components.iter().filter(|c| kept.contains(&c.region.as_str()));
        self.names.parts.iter().any(|part| part == name)
            && bodies.all(|c| !c.boundaries.iter().any(|n| n == name))
    }

    /// Why nothing can be imposed on the part `name` of the interface.
    fn part_of_interface(&self, name: &str) -> String {
        match self.case.absent_regions().first() {
            None => format!(
                "nothing can be imposed on the interface between fluid and solid, of which `{name}` is a part; remove \
                 this table"
            ),
            Some(region) => format!(
                "`{name}` is a part of the interface with region `{region}`, which is left out as there is no such \
                 table; with mesh.leave-out = [\"{region}\"] its sides can have conditions of their own"
            ),
        }
    }

    fn functionals(&mut self) {
        for (name, functional) in &self.case.functional {
            let key = format!("functional.{name}.region");
            if let Some(region) = functional.region().filter(|r| !self.names.regions.iter().any(|n| n == r)) {
                let message = absent("region", region, self.names.regions.iter().map(String::as_str));
                self.error(&key, message);
            }
            let key = format!("functional.{name}.on");
            for boundary in functional.on() {
                match self.names.boundaries.iter().find(|(n, _)| n == boundary) {
                    None => {
                        let message = self.absent_boundary(boundary);
                        self.error(&key, message);
                    }
                    Some((_, regions)) if boundary != INTERFACE && !self.touches(regions).0 => {
                        self.error(&key, format!("the fluid does not touch the boundary `{boundary}`"));
                    }
                    Some(_) if free(self.case, functional, boundary) => {
                        let message = format!(
                            "the velocity on the boundary `{boundary}` is free; power is that on walls, inlets and the \
                             interface"
                        );
                        self.error(&key, message);
                    }
                    Some(_) => {}
                }
            }
        }
    }

    /// Fluids of different density or viscosity that touch each other: their interface would move with the flow.
    fn fluids(&mut self) {
        let case = self.case;
        let fluid_in = |number: usize| {
            let (body, material) = case.body_in(&self.names.components[number].region)?;
            (body == Region::Fluid).then(|| &case.fluids[usize::from(material)])
        };
        let mut errors = vec![];
        for (number, part) in self.names.components.iter().enumerate() {
            for &other in part.touches.iter().filter(|&&other| other > number) {
                let (Some(one), Some(two)) = (fluid_in(number), fluid_in(other)) else { continue };
                let message = format!(
                    "[{}] touches [{}] of another density or viscosity, and their interface would move with the flow, which \
                     is not available: expected equal values, or a solid between them",
                    two.table(),
                    one.table()
                );
                if !one.flows_like(two) && errors.iter().all(|(_, told)| *told != message) {
                    errors.push((two.table(), message));
                }
            }
        }
        errors.into_iter().for_each(|(key, message)| self.error(&key, message));
    }

    /// A stationary solid needs a hold, a fluid on its own a way out.
    fn held(&mut self) {
        for (key, message) in super::bodies::check(self.case, self.names) {
            self.error(&key, message);
        }
    }
}

/// Whether `functional` is a power and the velocity on `boundary` not given.
fn free(case: &Case, functional: &FunctionalSpec, boundary: &str) -> bool {
    let free = |condition: &Condition| condition.is_natural() || condition.is_periodic();
    let free = case.boundary.get(boundary).is_some_and(free);
    free && matches!(functional, FunctionalSpec::Power { .. })
}

/// `name` as a key of TOML, in quotes where it needs them.
fn toml_key(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if !name.is_empty() && name.chars().all(bare) { name.into() } else { format!("{name:?}") }
}

fn absent<'a>(kind: &str, name: &str, all: impl Iterator<Item = &'a str> + Clone) -> String {
    format!("the mesh has no {kind} `{name}`{}", suggestion(name, all))
}
