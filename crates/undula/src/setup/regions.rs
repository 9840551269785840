//! The regions of a mesh: which are computed on, which are left out, and how the sides of these are called.

use super::functions::padded;
use super::names::MeshNames;
use crate::case::error::{CaseError, did_you_mean, quoted, suggestion};
use crate::case::{Case, MeshSource};
use crate::error::Error;
use crate::mesh::{INTERFACE, Mesh, MeshError};
use std::collections::BTreeMap;

/// Regions of the tables `[fluid]` and `[solid]` by default.
const FLUID: &str = "fluid";
const SOLID: &str = "solid";

/// The key that the mesh comes from.
pub(super) fn mesh_key(case: &Case) -> &'static str {
    if matches!(case.mesh.source, MeshSource::File(_)) { "mesh.file" } else { "mesh" }
}

#[doc(hidden)]
impl Case {
    /// Regions of the mesh that are computed on: those of `[fluid]` and `[solid]`.
    pub fn regions(&self) -> Vec<&str> {
        [self.fluid_regions(), self.solid_regions()].concat()
    }

    /// The regions that an absent table leaves out together with their interface, `solid` without `[solid]` and `fluid`
    /// without `[fluid]`, unless something else is said about it.
    pub(super) fn absent_regions(&self) -> Vec<&str> {
        if !self.mesh.absent.is_empty() {
            return self.mesh.absent.iter().map(String::as_str).collect();
        }
        let absent = match (self.fluids.is_empty(), self.solids.is_empty()) {
            (false, true) => SOLID,
            (true, false) => FLUID,
            _ => return vec![],
        };
        let free =
            !self.regions().contains(&absent) && !self.mesh.leave_out.iter().any(|name| name == absent);
        if free { vec![absent] } else { vec![] }
    }

    /// What is wrong with the use of the `regions` of a mesh: each is that of a table, or left out.
    pub(super) fn check_regions(&self, regions: &[String]) -> Vec<CaseError> {
        let mut errors = vec![];
        let mut error = |key: &str, message: String| {
            errors.push(CaseError { place: self.place_of(key), key: key.into(), value: None, message });
        };
        let unknown = |name: &str| {
            let known = suggestion(name, regions.iter().map(String::as_str));
            format!("the mesh has no region `{name}`{known}")
        };
        let tables = self.tables_of_bodies();
        for (table, filled) in &tables {
            for region in filled.iter().filter(|region| !regions.contains(region)) {
                error(&format!("{table}.region"), unknown(region));
            }
        }
        for name in &self.mesh.leave_out {
            let table = tables.iter().find(|(_, filled)| filled.contains(name));
            match table {
                Some((table, _)) => {
                    error(
                        "mesh.leave-out",
                        format!("region `{name}` is that of [{table}]; it cannot be left out"),
                    );
                }
                None if !regions.contains(name) => error("mesh.leave-out", unknown(name)),
                None => {}
            }
        }
        let used = |name: &&String| self.regions().contains(&name.as_str());
        let known = |name: &&String| {
            used(name) || self.mesh.leave_out.contains(name) || self.absent_regions().contains(&name.as_str())
        };
        // One that a table has misspelt is told there.
        let meant = |name: &&String| {
            let filled = tables.iter().flat_map(|(_, filled)| filled.iter());
            filled
                .filter(|other| !regions.contains(other))
                .any(|o| !did_you_mean(o, [name.as_str()]).is_empty())
        };
        let left: Vec<&String> = regions.iter().filter(|name| !known(name) && !meant(name)).collect();
        if let [first, ..] = left[..] {
            let given = crate::case::key::join("mesh.region", first);
            let key = if self.mesh.region.contains_key(first) { &given } else { mesh_key(self) };
            error(key, self.unused(&left));
        }
        errors
    }

    /// How regions that no table uses are told.
    fn unused(&self, regions: &[&String]) -> String {
        let names = quoted(regions.iter().map(|name| name.as_str()));
        let (subject, them) = match regions {
            [_] => (format!("region {names} of the mesh is"), "it"),
            _ => (format!("regions {names} of the mesh are"), "them"),
        };
        let out: Vec<String> = self
            .mesh
            .leave_out
            .iter()
            .chain(regions.iter().copied())
            .map(|name| format!("\"{name}\""))
            .collect();
        let tables = match (self.fluids.is_empty(), self.solids.is_empty()) {
            (false, false) => "name one as fluid.region or solid.region".into(),
            (false, true) => format!("add [solid] with region = \"{}\"", regions[0]),
            _ => format!("add [fluid] with region = \"{}\"", regions[0]),
        };
        format!(
            "{subject} used by no table: leave {them} out with mesh.leave-out = [{}], which makes walls of the sides, \
             or {tables}",
            out.join(", ")
        )
    }

    /// Puts cells into the regions of `mesh.region`; returns what should be known about that.
    pub(super) fn assign_regions<const D: usize>(&self, mesh: &mut Mesh<D>) -> Result<Vec<String>, Error> {
        let (mut before, mut notes) = (BTreeMap::new(), vec![]);
        for (name, inside) in &self.mesh.region {
            let gap = std::cell::RefCell::new(String::new());
            let value = |x: [f64; D]| {
                let value = inside.eval(&padded(&x), 0.0);
                if value.is_nan() && gap.borrow().is_empty() {
                    gap.replace(inside.gap(&padded(&x), 0.0));
                }
                value
            };
            let key = crate::case::key::join("mesh.region", name);
            let cells = mesh
                .assign_region(name, value)
                .map_err(|e| self.refuse(&key, format!("{e}{}", gap.borrow())))?;
            let shared: Vec<&str> =
                cells.iter().filter_map(|cell| before.insert(*cell, name.as_str())).collect();
            if let Some(other) = shared.first() {
                let note = format!(
                    "mesh.region: {} cells are in regions `{other}` and `{name}`; they belong to `{name}`, the later \
                     one of the alphabet",
                    shared.len()
                );
                notes.push(note);
            }
        }
        // Regions without cells go.
        if (0..mesh.regions.len() as u16).any(|region| !mesh.cell_region.contains(&region)) {
            mesh.drop_cells(|_| true);
        }
        Ok(notes)
    }

    /// Names the interface and the sides of regions that are left out; returns what should be known about that.
    pub(super) fn mark_sides<const D: usize>(&self, mesh: &mut Mesh<D>) -> Result<Vec<String>, Error> {
        let mut notes = vec![];
        notes.extend(self.mark_interface(mesh)?);
        for region in &self.mesh.leave_out {
            mesh.mark_sides(region, &self.regions()).map_err(|e| self.blame("mesh.leave-out", e))?;
        }
        let left_out = self.absent_regions().into_iter().filter(|region| mesh.region(region).is_some());
        notes.extend(left_out.map(|region| match self.fluids.is_empty() {
            false => format!(
                "region `{region}` of the mesh is left out, as there is no [solid]: its sides, `{INTERFACE}`, are \
                 no-slip walls"
            ),
            true => format!(
                "region `{region}` of the mesh is left out, as there is no [fluid]: its sides, `{INTERFACE}`, are free \
                 of traction"
            ),
        }));
        Ok(notes)
    }

    /// What should be known of an outer boundary that the mesh of one body calls `interface`.
    pub(super) fn outer_interface(&self, names: &MeshNames) -> Option<String> {
        let holds = match (self.fluids.is_empty(), self.solids.is_empty()) {
            (false, false) => return None,
            (false, true) => "a no-slip wall",
            _ => "free of traction",
        };
        let outer = !names.is_inside(INTERFACE, &self.regions());
        outer.then(|| {
            format!(
                "boundary `{INTERFACE}` of the mesh is taken for the side of a body that is not there: it is {holds}"
            )
        })
    }

    /// Names the sides between fluids and solids, or those of the region that an absent table leaves out; returns what
    /// should be known about that.
    fn mark_interface<const D: usize>(&self, mesh: &mut Mesh<D>) -> Result<Option<String>, Error> {
        let absent = self.absent_regions();
        let [firsts, seconds] = [self.fluid_regions(), self.solid_regions()].map(|regions| {
            let regions = if regions.is_empty() { absent.clone() } else { regions };
            regions.into_iter().filter(|region| mesh.region(region).is_some()).collect::<Vec<_>>()
        });
        let (mut found, mut apart) = (false, None);
        for (first, second) in
            firsts.iter().flat_map(|first| seconds.iter().map(move |second| (first, second)))
        {
            match mesh.mark_interface(first, second) {
                Ok(_) => found = true,
                Err(error @ MeshError::NoInterface { .. }) => apart = Some(error),
                Err(error) => return Err(self.blame(mesh_key(self), error)),
            }
        }
        match apart.filter(|_| !found && absent.is_empty()) {
            None => Ok(None),
            Some(_) if self.is_between(mesh, &firsts, &seconds) => {
                Ok(Some("fluid and solid touch nowhere: regions that are left out lie between them".into()))
            }
            // What keeps the regions apart says more than that they are.
            Some(error) => Err(self.blame(mesh_key(self), mesh.check().err().unwrap_or(error))),
        }
    }

    /// Whether a region that is left out touches regions of both.
    fn is_between<const D: usize>(&self, mesh: &Mesh<D>, firsts: &[&str], seconds: &[&str]) -> bool {
        let touch = |a: &str, b: &str| mesh.sides_between(a, b).is_ok_and(|sides| !sides.is_empty());
        let any = |a: &str, regions: &[&str]| regions.iter().any(|b| touch(a, b));
        self.mesh.leave_out.iter().any(|out| any(out, firsts) && any(out, seconds))
    }

    /// Name, number of cells and area \[m²\] of each region of the complete `mesh` that is left out.
    pub(super) fn left_out_of<const D: usize>(&self, mesh: &Mesh<D>) -> Vec<(String, usize, f64)> {
        let volume = mesh.quality().volume;
        let size = |(number, name): (u16, &String)| {
            let here = || mesh.cell_region.iter().zip(&volume).filter(move |(region, _)| **region == number);
            (name.clone(), here().count(), here().map(|(_, volume)| volume).sum())
        };
        let used = |name: &str| self.regions().contains(&name);
        (0..).zip(&mesh.regions).filter(|(_, name)| !used(name)).map(size).collect()
    }
}
