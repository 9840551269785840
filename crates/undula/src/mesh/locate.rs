//! Which cell a point of the reference domain lies in.

use super::box_tree::{BoxTree, image_bounds, spread};
use super::geometry::distance;
use super::{Mesh, MeshError};

/// A point may lie outside of a cell by this part of its size and still belong to it; curved boundaries
/// of a coarse mesh leave the true curve by less.
const TOLERANCE: f64 = 1e-3;
/// Newton steps for the inverse of a cell's map.
const STEPS: usize = 30;

/// A point in a cell.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Located<const D: usize> {
    /// The cell.
    pub cell: usize,
    /// Coordinates in the reference cell.
    pub xi: [f64; D],
}

/// A mesh ready to be asked for points.
#[derive(Clone, Debug)]
pub struct Locator<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    tree: BoxTree<D>,
    /// The largest diameter of a cell \[m\].
    largest: f64,
}

impl<'a, const D: usize> Locator<'a, D> {
    /// Prepares the search in `mesh`.
    pub fn new(mesh: &'a Mesh<D>) -> Self {
        let nodes = |cell: usize| mesh.cell(cell).iter().map(|&n| mesh.nodes[n as usize]);
        let factor = spread(mesh.shape, mesh.degree);
        let boxes = (0..mesh.n_cells()).map(|cell| image_bounds(nodes(cell), factor)).collect();
        let largest = (0..mesh.n_cells()).map(|cell| mesh.cell_diameter(cell)).fold(0.0, f64::max);
        Locator { mesh, tree: BoxTree::new(boxes), largest }
    }

    /// The cell that contains `x` \[m\], and where in it; the lowest of several.
    ///
    /// # Errors
    /// [`MeshError::Outside`] if `x` is further from every cell than a thousandth of its size.
    pub fn find(&self, x: [f64; D]) -> Result<Located<D>, MeshError> {
        self.find_where(x, TOLERANCE, |_| true)
    }

    /// As [`Locator::find`], among the cells of region `region` only.
    ///
    /// # Errors
    /// [`MeshError::Outside`], and [`MeshError::UnknownName`] for an unknown region.
    pub fn find_in(&self, region: &str, x: [f64; D]) -> Result<Located<D>, MeshError> {
        let number = self.mesh.require_region(region)?;
        self.find_where(x, TOLERANCE, |cell| self.mesh.cell_region[cell] == number)
    }

    /// As [`Locator::find`], among the cells that are `wanted`; of points outside of all, up to `tolerance` of the size
    /// of a cell, the place on the side of the nearest cell.
    ///
    /// # Errors
    /// [`MeshError::Outside`].
    pub fn find_where(
        &self,
        x: [f64; D],
        tolerance: f64,
        wanted: impl Fn(usize) -> bool,
    ) -> Result<Located<D>, MeshError> {
        let mut candidates = vec![];
        // Cells whose box is further away need not be tried.
        self.tree.near(x, tolerance * self.largest, |cell| candidates.push(cell));
        candidates.retain(|&cell| wanted(cell));
        candidates.sort_unstable();
        let mut best: Option<(f64, Located<D>)> = None;
        for cell in candidates {
            if let Some(xi) = self.mesh.inverse_map(cell, x) {
                let outside = self.mesh.shape.outside(&xi);
                // Points on a facet of two cells must not depend on rounding.
                let outside = if outside < 1e-9 { 0.0 } else { outside };
                if outside <= tolerance && best.is_none_or(|(least, _)| outside < least) {
                    best = Some((outside, Located { cell, xi: self.mesh.shape.clamp(xi) }));
                }
            }
        }
        best.map(|(_, located)| located).ok_or_else(|| {
            let nearest = self.mesh.nearest_node(x).map(|(n, _)| self.mesh.nodes[n as usize].to_vec());
            MeshError::Outside { point: x.to_vec(), nearest: nearest.unwrap_or_default() }
        })
    }
}

impl<const D: usize> Mesh<D> {
    /// The geometry node nearest to `x` and its distance \[m\]; none in an empty mesh.
    pub fn nearest_node(&self, x: [f64; D]) -> Option<(u32, f64)> {
        let distances = self.nodes.iter().enumerate().map(|(n, &at)| (n as u32, distance(at, x)));
        distances.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Reference coordinates of `x` in `cell` by Newton's method, also somewhat outside of the cell; none
    /// if it does not converge.
    pub fn inverse_map(&self, cell: usize, x: [f64; D]) -> Option<[f64; D]> {
        let mut xi = self.reference_centre();
        for _ in 0..STEPS {
            let at = self.map(cell, xi);
            let residual = std::array::from_fn(|d| x[d] - at[d]);
            let step = solve(self.map_gradient(cell, xi), residual)?;
            for d in 0..D {
                xi[d] = (xi[d] + step[d]).clamp(-1.0, 2.0);
            }
            if step.iter().all(|s| s.abs() < 1e-13) {
                break;
            }
        }
        let error = distance(self.map(cell, xi), x);
        (error <= 1e-10 * self.cell_diameter(cell)).then_some(xi)
    }
}

/// Solves `a y = b` by elimination with pivoting; none if `a` is singular.
fn solve<const D: usize>(mut a: [[f64; D]; D], mut b: [f64; D]) -> Option<[f64; D]> {
    for k in 0..D {
        let pivot = (k..D).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()))?;
        if a[pivot][k] == 0.0 {
            return None;
        }
        a.swap(pivot, k);
        b.swap(pivot, k);
        for i in k + 1..D {
            let factor = a[i][k] / a[k][k];
            for j in k..D {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..D).rev() {
        for j in k + 1..D {
            b[k] -= a[k][j] * b[j];
        }
        b[k] /= a[k][k];
    }
    Some(b)
}
