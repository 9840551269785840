//! Triangles from quadrilaterals.

use super::geometry::distance;
use super::{Mesh, Side};
use crate::element::Shape;
use std::collections::HashMap;

/// A place in a quadrilateral, in quarters of it.
type Place = [usize; 2];

/// Its two triangles on either side of the diagonal from vertex 0 to 3.
const RISING: [[Place; 3]; 2] = [[[0, 0], [4, 0], [4, 4]], [[0, 0], [4, 4], [0, 4]]];
/// The same with the diagonal from vertex 1 to 2.
const FALLING: [[Place; 3]; 2] = [[[0, 0], [4, 0], [0, 4]], [[4, 0], [4, 4], [0, 4]]];
/// The four triangles between both diagonals.
const CROSS: [[Place; 3]; 4] =
    [[[0, 0], [4, 0], [2, 2]], [[4, 0], [4, 4], [2, 2]], [[4, 4], [0, 4], [2, 2]], [[0, 4], [0, 0], [2, 2]]];

impl Mesh<2> {
    /// The same domain in triangles, two from each quadrilateral.
    ///
    /// The diagonal ends in the corner of the boundary if the cell has one: a triangle with two edges on the boundary,
    /// on which a given velocity leaves nothing free, would have a pressure that nothing determines. A cell with
    /// corners on both diagonals is split in four; elsewhere the diagonal is the shorter one. Edges of quadrilaterals
    /// keep their nodes, and diagonals are bent as much as the cell is: at the circle with it, not at all between
    /// straight sides, where triangles are affine. Names are kept. Triangles are returned as they are.
    pub fn triangulated(&self) -> Self {
        if self.shape == Shape::Triangle {
            return self.clone();
        }
        let mut mesh = Mesh {
            shape: Shape::Triangle,
            cell_nodes: vec![],
            cell_region: vec![],
            facets: vec![],
            parts: vec![],
            ..self.clone()
        };
        // The name of each side, and its further ones.
        let mut named: Vec<[Vec<u16>; 4]> = vec![Default::default(); self.n_cells()];
        for facet in self.facets.iter().chain(&self.parts) {
            named[facet.cell as usize][facet.local as usize].push(facet.boundary);
        }
        for (cell, named) in named.iter().enumerate() {
            let mut new = HashMap::new();
            for corners in self.parts(cell, named) {
                mesh.add_triangle(self, cell, *corners, named, &mut new);
            }
        }
        mesh
    }

    /// The triangles of `cell`, some of whose facets have names.
    fn parts(&self, cell: usize, named: &[Vec<u16>; 4]) -> &'static [[Place; 3]] {
        let is_corner = |v: usize| !named[v & 1].is_empty() && !named[2 + (v >> 1)].is_empty();
        let at = self.cell_vertices(cell).into_iter().map(|n| self.nodes[n as usize]).collect::<Vec<_>>();
        match (is_corner(0) || is_corner(3), is_corner(1) || is_corner(2)) {
            (true, true) => &CROSS,
            (true, false) => &RISING,
            (false, true) => &FALLING,
            // Equal but for rounding counts as equal.
            (false, false) if distance(at[0], at[3]) <= (1.0 + 1e-9) * distance(at[1], at[2]) => &RISING,
            (false, false) => &FALLING,
        }
    }

    /// Adds the triangle between three places of quadrilateral `cell` of `of`; `new` are nodes inside of it.
    fn add_triangle(
        &mut self,
        of: &Mesh<2>,
        cell: usize,
        corners: [Place; 3],
        named: &[Vec<u16>; 4],
        new: &mut HashMap<Place, u32>,
    ) {
        let (degree, number) = (of.degree, self.n_cells() as u32);
        for node in 0..Shape::Triangle.n_nodes(degree) {
            let weights = Shape::Triangle.vertex_weights(degree, node);
            let place = [0, 1].map(|d| {
                weights.iter().zip(corners).map(|(w, corner)| *w as usize * corner[d]).sum::<usize>() / degree
            });
            let there = place.iter().all(|p| p * degree % 4 == 0);
            let [i, j] = place.map(|p| p * degree / 4);
            let number = if there {
                of.cell(cell)[of.shape.number(degree, [i, j, 0])]
            } else {
                *new.entry(place).or_insert_with(|| {
                    self.nodes.push(of.map(cell, place.map(|p| p as f64 / 4.0)));
                    self.nodes.len() as u32 - 1
                })
            };
            let inside = place.iter().all(|p| (1..4).contains(p));
            if inside && weights.iter().all(|w| (*w as usize) < degree) {
                // In the middle of a diagonal, or of half of one.
                let ends = corners.map(|corner| of.map(cell, corner.map(|p| p as f64 / 4.0)));
                let bend = if place == [2, 2] { 1.0 } else { 0.25 };
                let (middle, mean) = (of.map(cell, [0.5; 2]), of.centre(cell));
                self.nodes[number as usize] = [0, 1].map(|d| {
                    let along: f64 = weights.iter().zip(ends).map(|(w, x)| f64::from(*w) * x[d]).sum();
                    along / degree as f64 + bend * (middle[d] - mean[d])
                });
            }
            self.cell_nodes.push(number);
        }
        self.cell_region.push(of.cell_region[cell]);
        for (side, names) in named.iter().enumerate() {
            let on_side = |local: &usize| {
                let mut ends = (0..3).filter(|v| v != local);
                ends.all(|v| corners[v][side / 2] == 4 * (side % 2))
            };
            if let (Some((first, further)), Some(local)) = (names.split_first(), (0..3).find(on_side)) {
                let side = Side { cell: number, local: local as u8 };
                self.facets.push(side.named(*first));
                self.parts.extend(further.iter().map(|&boundary| side.named(boundary)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::{cylinder, rectangle, schaefer_turek, turek_hron};

    /// Whether no triangle has two named facets.
    fn corners_are_cut(mesh: &Mesh<2>) -> bool {
        let mut cells: Vec<u32> = mesh.facets.iter().map(|f| f.cell).collect();
        cells.sort_unstable();
        cells.windows(2).all(|w| w[0] != w[1])
    }

    #[test]
    fn benchmark_meshes_become_sound_triangles() {
        for (quads, grading) in [(turek_hron(0, 0), 0), (turek_hron(0, 2), 2), (schaefer_turek(0), 0)] {
            let mesh = quads.triangulated();
            mesh.check().unwrap();
            mesh.check_curves(&[cylinder()]).unwrap();
            assert!(corners_are_cut(&mesh));
            let worst = mesh.quality().min_scaled_jacobian();
            println!("{} triangles, grading {grading}: worst {worst:.3}", mesh.n_cells());
            // Long cells at the outflow: ten times as long as wide.
            assert!(worst > 0.06, "worst {worst}");
            let areas = [&quads, &mesh].map(|m| m.quality().total_volume());
            assert!((areas[0] - areas[1]).abs() < 1e-5, "the circle bends the same edges: {areas:?}");
            for name in &quads.boundaries {
                let count = |m: &Mesh<2>| {
                    m.facets.iter().filter(|f| &m.boundaries[f.boundary as usize] == name).count()
                };
                assert_eq!(count(&mesh), count(&quads), "{name}");
            }
        }
        turek_hron(0, 0).triangulated().check_matching("fluid", "solid", &[cylinder()]).unwrap();
    }

    #[test]
    fn triangles_are_refined_conformingly_on_the_circle() {
        let mesh = turek_hron(0, 1).triangulated();
        let finer = mesh.refine(&[cylinder()]);
        let finest = finer.refine(&[cylinder()]);
        finer.check_matching("fluid", "solid", &[cylinder()]).unwrap();
        finest.check_matching("fluid", "solid", &[cylinder()]).unwrap();
        assert_eq!(finest.n_cells(), 16 * mesh.n_cells());
        assert!(corners_are_cut(&finest));
        // Areas of the domain converge with order 4: quadratic arcs of the circle.
        let exact = 2.5 * 0.41 - std::f64::consts::PI * 0.05f64.powi(2);
        let beam = |m: &Mesh<2>| {
            let solid = m.region("solid");
            let q = m.quality();
            (0..m.n_cells()).filter(|&c| Some(m.cell_region[c]) == solid).map(|c| q.volume[c]).sum::<f64>()
        };
        let errors = [&mesh, &finer, &finest].map(|m| (m.quality().total_volume() - exact).abs());
        assert!(errors[0] / errors[1] > 12.0 && errors[1] / errors[2] > 12.0, "{errors:?}");
        assert!((beam(&finest) - beam(&finer)).abs() < 1e-9);
        let points = |m: &Mesh<2>| m.quality().min_scaled_jacobian();
        assert!(points(&finest) > 0.9 * points(&mesh), "{} {}", points(&finest), points(&mesh));
    }

    #[test]
    fn corners_on_both_diagonals_take_four_triangles() {
        let strip = rectangle([0.0; 2], [3.0, 1.0], [3, 1], 0).unwrap().triangulated();
        strip.check().unwrap();
        assert_eq!(strip.n_cells(), 10);
        assert!(corners_are_cut(&strip));
        let square = rectangle([0.0; 2], [1.0; 2], [2, 2], 0).unwrap().triangulated();
        assert_eq!((square.n_cells(), corners_are_cut(&square)), (8, true));
    }

    #[test]
    fn points_are_found_in_triangles() {
        let mesh = turek_hron(0, 0).triangulated();
        let locator = crate::mesh::Locator::new(&mesh);
        for x in [[0.6, 0.2], [0.15, 0.2], [1.234, 0.321], [0.2, 0.26], [0.255, 0.2]] {
            let found = locator.find(x).unwrap();
            assert!(distance(mesh.map(found.cell, found.xi), x) < 1e-10, "{x:?}");
            assert_eq!(mesh.shape.outside(&found.xi), 0.0);
        }
        assert!(locator.find([0.2, 0.2]).is_err(), "inside of the cylinder");
    }
}
