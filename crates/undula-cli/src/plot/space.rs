//! Cells of three dimensions: their places, and which of them meet at a face.

use super::cube::face_corners;
use std::collections::HashMap;
use undula::output::FieldSnapshot;

/// A place, rounded. Points meet by place, since discontinuous fields have points of their own in every cell.
pub type Place = [i64; 3];

/// Ranges of the three coordinates; infinite if there are no points.
pub fn extents(snapshot: &FieldSnapshot) -> [(f64, f64); 3] {
    let empty = [(f64::INFINITY, f64::NEG_INFINITY); 3];
    snapshot.points.iter().fold(empty, |ranges, point| {
        std::array::from_fn(|d| (ranges[d].0.min(point[d]), ranges[d].1.max(point[d])))
    })
}

/// The largest of the three extents.
pub fn size(snapshot: &FieldSnapshot) -> f64 {
    extents(snapshot).iter().map(|(low, high)| high - low).fold(0.0, f64::max)
}

/// Rounds places.
#[derive(Copy, Clone)]
pub struct Places {
    unit: f64,
}

impl Places {
    /// Places in `snapshot`.
    pub fn new(snapshot: &FieldSnapshot) -> Self {
        Places { unit: 1e-8 * size(snapshot) }
    }

    /// A point.
    pub fn of(self, x: [f64; 3]) -> Place {
        x.map(|c| (c / self.unit).round() as i64)
    }

    /// The middle of the different corners of a face; none if it has no area.
    fn face(self, corners: [[f64; 3]; 4]) -> Option<Place> {
        let is_new = |n: &usize| (0..*n).all(|before| self.of(corners[before]) != self.of(corners[*n]));
        let different: Vec<[f64; 3]> = (0..4).filter(is_new).map(|n| corners[n]).collect();
        let mean = |d: usize| different.iter().map(|x| x[d]).sum::<f64>() / different.len() as f64;
        (different.len() > 2).then(|| self.of(std::array::from_fn(mean)))
    }
}

/// A face of one or two cells.
#[derive(Copy, Clone)]
pub struct Face {
    /// The first of the cells.
    pub cell: usize,
    /// Its number in that cell.
    pub facet: usize,
    /// The other cell.
    pub other: Option<usize>,
}

/// The faces of some cells, in the order in which the first of their cells is met; those without area are left out.
pub fn faces(snapshot: &FieldSnapshot, cells: impl Iterator<Item = usize>) -> Vec<Face> {
    let (n, places) = (snapshot.points_per_cell(), Places::new(snapshot));
    let corners: [[usize; 4]; 6] = std::array::from_fn(|facet| face_corners(snapshot.degree, facet));
    let mut numbers: HashMap<Place, usize> = HashMap::new();
    let mut faces: Vec<Face> = Vec::new();
    for cell in cells {
        let nodes = &snapshot.cells[cell * n..(cell + 1) * n];
        for (facet, corners) in corners.iter().enumerate() {
            let corners = corners.map(|corner| snapshot.points[nodes[corner] as usize]);
            let Some(at) = places.face(corners) else { continue };
            match numbers.get(&at) {
                Some(&number) => faces[number].other = Some(cell),
                None => {
                    numbers.insert(at, faces.len());
                    faces.push(Face { cell, facet, other: None });
                }
            }
        }
    }
    faces
}
