//! What names a mesh has, and which parts they belong to.

use crate::mesh::{Facet, Facets, Mesh, Side};
use std::collections::{HashMap, HashSet};

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
    /// Boundaries with facets between cells of two regions, and these regions.
    pub between: Vec<(String, [String; 2])>,
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
        let region = |side: &Side| mesh.regions[usize::from(mesh.cell_region[side.cell as usize])].clone();
        let beyond: HashMap<Side, Side> = inner.iter().flat_map(|&[a, b]| [(a, b), (b, a)]).collect();
        let mut between = vec![];
        for facet in &mesh.facets {
            if let Some(other) = beyond.get(&facet.side()) {
                let name = mesh.boundaries[usize::from(facet.boundary)].clone();
                push_new(&mut between, (name, [region(&facet.side()), region(other)]));
            }
        }
        Self {
            between,
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

    /// Whether all facets of `name` lie between two different regions of those `kept`.
    pub(super) fn is_between(&self, name: &str, kept: &[&str]) -> bool {
        let mut here = self.between.iter().filter(|(n, _)| n == name).peekable();
        let of_kept = |[one, two]: &[String; 2]| {
            one != two && [one, two].iter().all(|region| kept.contains(&region.as_str()))
        };
        here.peek().is_some() && self.is_inside(name, kept) && here.all(|(_, regions)| of_kept(regions))
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
