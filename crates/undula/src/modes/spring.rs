//! The stiffness of springs on the boundary of the solid.

use crate::case::{Case, Condition};
use crate::sampling::facet_points;
use crate::space::FsiSpace;

/// Entries of K of all springs of `case`: k_ab = ⟨k φ_b, φ_a⟩, or ⟨k n·φ_b, n·φ_a⟩, as the places 2 a + i and 2 b + j,
/// and the value \[Pa\]. k is taken at the start of the case.
pub(super) fn entries(case: &Case, space: &FsiSpace<2>) -> Vec<(u32, u32, f64)> {
    let start = case.time.as_ref().map_or(0.0, |time| time.start);
    let mut entries = vec![];
    for (name, condition) in &case.boundary {
        let Condition::Spring { stiffness, normal, .. } = condition else { continue };
        for facet in space.boundary_facets(name) {
            let nodes = space.nodes.cell(facet.cell as usize);
            for point in facet_points(space, &facet, case.space.quadrature) {
                let k = point.weight * stiffness.eval(&[point.x[0], point.x[1], 0.0], start);
                let n = point.normal.0;
                for (&a, phi) in nodes.iter().zip(&point.value).filter(|(_, phi)| **phi != 0.0) {
                    for (&b, other) in nodes.iter().zip(&point.value).filter(|(_, phi)| **phi != 0.0) {
                        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                            let part = if *normal { n[i] * n[j] } else { f64::from(u8::from(i == j)) };
                            if part != 0.0 {
                                entries.push((2 * a + i as u32, 2 * b + j as u32, k * phi * other * part));
                            }
                        }
                    }
                }
            }
        }
    }
    entries
}
