//! Whether a case fits its mesh: what names the mesh has, and what holds there.

use crate::case::error::{CaseError, CaseErrors, Place, suggestion};
use crate::case::key;
use crate::case::{Case, Condition, FunctionalSpec};
use crate::mesh::{Facet, Facets, INTERFACE, Mesh, Side};
use std::collections::HashSet;

/// The names of a complete mesh, before any region is left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshNames {
    /// Regions.
    pub regions: Vec<String>,
    /// Boundaries with the regions whose cells they touch; further names of facets are among them.
    pub boundaries: Vec<(String, Vec<String>)>,
    /// Boundaries that lie on the outer boundary of a region, with these regions.
    pub outer: Vec<(String, Vec<String>)>,
    /// Further names of facets: parts of the interface.
    pub parts: Vec<String>,
    /// Connected parts of the regions.
    pub components: Vec<Component>,
}

/// Cells of one region that hang together by facets.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// The region.
    pub region: String,
    /// Lower corner of the box around it \[m\].
    pub lower: Vec<f64>,
    /// Upper corner of the box around it \[m\].
    pub upper: Vec<f64>,
    /// Boundaries of its facets; `interface` is among those of the body from which it is seen.
    pub boundaries: Vec<String>,
    /// Numbers of the connected parts of other regions that it touches.
    pub touches: Vec<usize>,
}

impl MeshNames {
    /// The names of `mesh`.
    pub fn of<const D: usize>(mesh: &Mesh<D>) -> Self {
        let Facets { inner, .. } = mesh.facets_of_cells();
        let inside: HashSet<Side> = inner.iter().flatten().copied().collect();
        let touched = |facets: &mut dyn Iterator<Item = &Facet>| {
            let mut boundaries: Vec<(String, Vec<String>)> =
                mesh.boundaries.iter().map(|name| (name.clone(), Vec::new())).collect();
            for facet in facets {
                let region = &mesh.regions[usize::from(mesh.cell_region[facet.cell as usize])];
                push_new(&mut boundaries[usize::from(facet.boundary)].1, region.clone());
            }
            boundaries
        };
        let outer = touched(&mut mesh.facets.iter().filter(|f| !inside.contains(&f.side())));
        let mut parts = vec![];
        mesh.parts
            .iter()
            .for_each(|f| push_new(&mut parts, mesh.boundaries[usize::from(f.boundary)].clone()));
        Self {
            regions: mesh.regions.clone(),
            boundaries: touched(&mut mesh.facets.iter().chain(&mesh.parts)),
            outer: outer.into_iter().filter(|(_, regions)| !regions.is_empty()).collect(),
            parts,
            components: components(mesh, &inner),
        }
    }

    /// Whether `name` does not lie on the outer boundary of the regions `kept`.
    pub(super) fn is_inside(&self, name: &str, kept: &[&str]) -> bool {
        let touches = |regions: &[String]| regions.iter().any(|region| kept.contains(&region.as_str()));
        !self.outer.iter().any(|(n, regions)| n == name && touches(regions))
    }
}

/// The connected parts of the regions of `mesh`, whose facets between cells are `inner`.
fn components<const D: usize>(mesh: &Mesh<D>, inner: &[[Side; 2]]) -> Vec<Component> {
    let component = mesh.components_by(inner);
    let mut list: Vec<Component> = vec![];
    for (cell, &number) in component.iter().enumerate() {
        if number as usize == list.len() {
            list.push(Component {
                region: mesh.regions[usize::from(mesh.cell_region[cell])].clone(),
                lower: vec![f64::INFINITY; D],
                upper: vec![f64::NEG_INFINITY; D],
                boundaries: vec![],
                touches: vec![],
            });
        }
        let part = &mut list[number as usize];
        for &node in mesh.cell(cell) {
            for (d, &x) in mesh.nodes[node as usize].iter().enumerate() {
                part.lower[d] = part.lower[d].min(x);
                part.upper[d] = part.upper[d].max(x);
            }
        }
    }
    for facet in &mesh.facets {
        let name = mesh.boundaries[usize::from(facet.boundary)].clone();
        push_new(&mut list[component[facet.cell as usize] as usize].boundaries, name);
    }
    for pair in inner {
        let [one, two] = pair.map(|side| component[side.cell as usize] as usize);
        if one != two {
            push_new(&mut list[one].touches, two);
            push_new(&mut list[two].touches, one);
        }
    }
    list
}

fn push_new<T: PartialEq>(list: &mut Vec<T>, item: T) {
    if !list.contains(&item) {
        list.push(item);
    }
}

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
        let has = |region: Option<&String>| region.is_some_and(|r| regions.contains(r));
        (has(self.case.fluid.as_ref().map(|f| &f.region)), has(self.case.solid.as_ref().map(|s| &s.region)))
    }

    fn boundaries(&mut self) {
        for name in self.case.boundary.keys() {
            if !self.names.boundaries.iter().any(|(n, _)| n == name) {
                let message = self.absent_boundary(name);
                self.error(&key::join("boundary", name), message);
            }
        }
        for (name, regions) in &self.names.boundaries {
            let (fluid, solid) = self.touches(regions);
            if name == INTERFACE || !(fluid || solid) {
                continue;
            }
            let key = key::join("boundary", name);
            let condition = self.case.boundary.get(name);
            if condition.is_some() && self.is_part(name) {
                self.error(&key, self.part_of_interface(name));
                continue;
            }
            match condition {
                // Parts of the interface, and sides of regions that are left out.
                None if self.names.is_inside(name, &self.case.regions()) => {}
                None => {
                    let allowed = match (fluid, solid) {
                        (_, false) => "`velocity`, `no-slip`, `do-nothing` or `traction-free`",
                        (false, true) => "`clamped` or `traction-free`",
                        (true, true) => {
                            "`velocity` (0 on the solid), `no-slip`, `do-nothing` or `traction-free` (the solid is \
                             clamped by the first two and free with the others)"
                        }
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
            if self.case.directional.contains(name) && self.case.fluid.is_some() && !fluid {
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
        match self.case.absent_region() {
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
        for (key, message) in super::bodies::check(self.case, self.names) {
            self.error(key, message);
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
