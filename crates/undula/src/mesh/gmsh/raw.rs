//! What a `.msh` file contains, and which groups its elements are in.

use super::source::{At, Source};
use crate::math::{rounded, shortest};
use crate::mesh::MeshError;
use std::collections::HashMap;

/// What a file contains that a mesh is made of.
pub(super) struct Raw {
    pub version: Version,
    /// Names of the physical groups by dimension and tag, in the order of the file.
    pub names: Vec<(usize, i64, String)>,
    /// The nodes.
    pub nodes: Vec<Node>,
    /// Lines, triangles, quadrilaterals, tetrahedra and hexahedra.
    pub elements: Vec<Element>,
    /// Entities of version 4 by dimension and tag, and those of partitions.
    pub entities: [HashMap<(usize, i64), Entity>; 2],
    /// Cells of a VTU file, points among them.
    pub n_cells: usize,
}

/// A node.
pub(super) struct Node {
    /// Where it stands.
    pub at: At,
    /// Its tag.
    pub tag: u64,
    /// Its coordinates.
    pub x: [f64; 3],
}

/// A line or a cell.
pub(super) struct Element {
    /// Where it stands.
    pub at: At,
    /// Dimension: 1, 2 or 3.
    pub dim: usize,
    /// Tag of the physical group of version 2, of the entity of version 4; 0 for none.
    owner: i64,
    /// Tags of the nodes in the order of Gmsh.
    pub nodes: Vec<u64>,
}

impl Element {
    /// Whether an element of version 2 is in no physical group.
    pub fn is_in_no_group(&self) -> bool {
        self.owner == 0
    }
}

/// The two versions of the format, and files of VTK, whose names are as those of version 2.
#[derive(Copy, Clone, PartialEq)]
pub(super) enum Version {
    V2,
    V4,
    Vtu,
}

/// A piece of the geometry.
pub(super) struct Entity {
    /// Its physical groups.
    pub groups: Vec<i64>,
    /// Of a part: dimension and tag of the piece that was divided.
    pub parent: Option<(usize, i64)>,
}

impl Raw {
    /// Nothing of a VTU file yet.
    pub fn of_cells() -> Self {
        let entities = [HashMap::new(), HashMap::new()];
        Raw { version: Version::Vtu, names: vec![], nodes: vec![], elements: vec![], entities, n_cells: 0 }
    }

    /// Where the middle of these nodes is, as the end of a message; nothing if they are not there.
    pub fn place_of(&self, nodes: &[u64]) -> String {
        let at = |tag: &u64| self.nodes.iter().find(|node| node.tag == *tag).map(|node| node.x);
        let points: Option<Vec<[f64; 3]>> = nodes.iter().map(at).collect();
        let Some(points) = points.filter(|points| !points.is_empty()) else { return String::new() };
        let mean = |d: usize| points.iter().map(|x| x[d]).sum::<f64>() / points.len() as f64;
        let size = self.nodes.iter().flat_map(|node| node.x).fold(0.0, |size: f64, x| size.max(x.abs()));
        let digits = |d: usize| shortest(rounded(mean(d), size, 6));
        format!(" (at {}, {}, {})", digits(0), digits(1), digits(2))
    }

    /// Adds an element; points are left out.
    pub fn add(&mut self, at: At, dim: usize, owner: i64, nodes: Vec<u64>) {
        if dim > 0 {
            self.elements.push(Element { at, dim, owner, nodes });
        }
    }

    /// Tag of the physical group of `element`, 0 for none. A part is in the groups of what was divided.
    ///
    /// # Errors
    /// An entity in several groups.
    pub fn group(&self, element: &Element, source: &Source) -> Result<i64, MeshError> {
        if self.version != Version::V4 {
            return Ok(element.owner);
        }
        match self.groups(element.dim, element.owner) {
            [] => Ok(0),
            [group] => Ok(*group),
            several => {
                let what = ["point", "curve", "surface", "volume"][element.dim];
                let names: Vec<_> = several.iter().map(|&tag| self.name(element.dim, tag)).collect();
                let reason = format!(
                    "{what} {} is in physical groups {}; it can be in one only",
                    element.owner,
                    names.join(" and ")
                );
                Err(super::source::error(source.path, element.at, reason))
            }
        }
    }

    /// Physical groups of an entity. Entities of partitions have other tags than those that were divided.
    fn groups(&self, dim: usize, tag: i64) -> &[i64] {
        let [wholes, parts] = &self.entities;
        let part = parts.get(&(dim, tag));
        let parent = part.filter(|part| part.groups.is_empty()).and_then(|part| part.parent);
        let whole = || wholes.get(&parent.filter(|(d, _)| *d == dim)?);
        let found = if part.is_some() { whole().or(part) } else { wholes.get(&(dim, tag)) };
        found.map_or(&[], |entity| &entity.groups)
    }

    /// The name of a physical group in quotes, else its tag.
    pub fn name(&self, dim: usize, tag: i64) -> String {
        let named = self.names.iter().find(|(d, t, _)| (*d, *t) == (dim, tag));
        named.map_or_else(|| tag.to_string(), |(_, _, name)| format!("`{name}`"))
    }
}
