//! Which cells make a patch, and the axes of a cell.

use crate::element::{Fine, Fluctuation, Quadrature, Shape};
use crate::space::{FsiSpace, Region};

/// The cells of the fluid by patches: children of a refined cell, in the order of refinement.
///
/// `None` if the mesh does not consist of such cells, and on tetrahedra, whose children are not alike.
pub fn patches<const D: usize>(space: &FsiSpace<D>) -> Option<Vec<Vec<usize>>> {
    if space.mesh.shape == Shape::Tetrahedron {
        return None;
    }
    let rule = Quadrature::cell(space.mesh.shape, 1);
    let nodal = Fine { shape: space.mesh.shape, degree: space.nodes.degree, bubble: false };
    let numbers = Fluctuation::on_patch(nodal, &rule);
    let cells = fluid_cells(space);
    let list: Vec<Vec<usize>> = cells.chunks(1 << D).map(<[usize]>::to_vec).collect();
    let fits = |patch: &Vec<usize>| {
        let mut nodes = vec![u32::MAX; numbers.n_basis];
        let same = |(&cell, places): (&usize, &Vec<usize>)| {
            space.nodes.cell(cell).iter().zip(places).all(|(&node, &place)| {
                let known = std::mem::replace(&mut nodes[place], node);
                known == u32::MAX || known == node
            })
        };
        patch.len() == 1 << D && patch.iter().zip(&numbers.children).all(same)
    };
    list.iter().all(fits).then_some(list)
}

/// The cells of the fluid.
pub(super) fn fluid_cells<const D: usize>(space: &FsiSpace<D>) -> Vec<usize> {
    (0..space.mesh.n_cells()).filter(|&c| space.regions[c] == Region::Fluid).collect()
}

/// Axes of the reference cell with their weights: on a regular cell of size ĥ = |K|^(1/D) they are as long as that, and
/// Σ weight (axis · ∇)² = ĥ² |∇|².
///
/// Those of a simplex are its edges, so that no vertex is preferred; an edge of a regular triangle of area 1 is 2/3^¼
/// long, one of a regular tetrahedron of volume 1 (6 √2)^⅓.
pub(super) fn axes(shape: Shape) -> Vec<([f64; 3], f64)> {
    if shape == Shape::Triangle {
        let s = 0.5 * 3.0f64.powf(0.25);
        return [[s, 0.0, 0.0], [0.0, s, 0.0], [-s, s, 0.0]].map(|axis| (axis, 2.0 / 3.0)).to_vec();
    }
    if shape == Shape::Tetrahedron {
        let s = 1.0 / (6.0 * 2f64.sqrt()).cbrt();
        let from_first = [[s, 0.0, 0.0], [0.0, s, 0.0], [0.0, 0.0, s]];
        let others = [[-s, s, 0.0], [-s, 0.0, s], [0.0, -s, s]];
        return from_first.into_iter().chain(others).map(|axis| (axis, 0.5)).collect();
    }
    let unit = |d: usize| (std::array::from_fn(|e| if d == e { 1.0 } else { 0.0 }), 1.0);
    (0..shape.dim()).map(unit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∂x/∂ξ of a regular cell of size 1.
    fn regular(shape: Shape) -> [[f64; 3]; 3] {
        let mut map = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        if shape == Shape::Triangle {
            let edge = 2.0 / 3.0f64.powf(0.25);
            (map[0], map[1]) = ([edge, 0.5 * edge, 0.0], [0.0, 0.75f64.sqrt() * edge, 0.0]);
        }
        if shape == Shape::Tetrahedron {
            let a = (6.0 * 2f64.sqrt()).cbrt();
            let (height, foot) = ((2.0 / 3f64).sqrt() * a, 0.5 * a / 3f64.sqrt());
            map = [[a, 0.5 * a, 0.5 * a], [0.0, 0.75f64.sqrt() * a, foot], [0.0, 0.0, height]];
        }
        map
    }

    #[test]
    fn axes_of_regular_cells_prefer_no_direction() {
        for shape in [Shape::Triangle, Shape::Quadrilateral, Shape::Tetrahedron, Shape::Hexahedron] {
            let (map, dim) = (regular(shape), shape.dim());
            let mut sum = [[0.0; 3]; 3];
            for (axis, weight) in axes(shape) {
                let h = map.map(|row| (0..dim).map(|d| row[d] * axis[d]).sum::<f64>());
                assert!((h[..dim].iter().map(|h| h * h).sum::<f64>() - 1.0).abs() < 1e-14, "{shape:?}");
                (0..3).for_each(|i| (0..3).for_each(|j| sum[i][j] += weight * h[i] * h[j]));
            }
            for i in 0..dim {
                for j in 0..dim {
                    let expected = if i == j { 1.0 } else { 0.0 };
                    assert!((sum[i][j] - expected).abs() < 1e-14, "{shape:?} {sum:?}");
                }
            }
        }
    }
}
