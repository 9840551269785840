//! Distance to named facets, such as that to the interface by which extensions are stiffened.

use super::box_tree::{BoxTree, image_bounds};
use super::geometry::{distance, lagrange, lagrange_slope};
use super::{Mesh, MeshError};

/// Samples per direction from which the nearest point of a curved facet is sought.
const SAMPLES: usize = 8;
/// Sweeps of that search; each is Newton's method in one coordinate after the other.
const SWEEPS: usize = 30;

/// The facets of some boundaries, ready to be asked for distances.
#[derive(Clone, Debug)]
pub struct FacetDistance<const D: usize> {
    facets: Vec<FacetMap<D>>,
    tree: BoxTree<D>,
}

impl<const D: usize> FacetDistance<D> {
    /// Collects the facets of `boundaries`.
    ///
    /// # Errors
    /// [`MeshError::UnknownName`] for a boundary that the mesh does not have.
    pub fn new(mesh: &Mesh<D>, boundaries: &[&str]) -> Result<Self, MeshError> {
        boundaries.iter().try_for_each(|b| mesh.require_boundary(b).map(drop))?;
        let named = mesh.facets_on(boundaries).into_iter();
        let facets: Vec<_> = named.map(|f| FacetMap::new(mesh, f.cell as usize, f.local as usize)).collect();
        let tree = BoxTree::new(facets.iter().map(FacetMap::bounds).collect());
        Ok(FacetDistance { facets, tree })
    }

    /// Distance \[m\] from `x` to the nearest of the facets; exact for straight ones, to rounding for
    /// curved ones unless `x` is far beyond their centre of curvature; infinite if there are none.
    pub fn distance(&self, x: [f64; D]) -> f64 {
        self.tree.nearest(x, |i| self.facets[i].distance(x))
    }
}

/// The Lagrange map of one facet.
#[derive(Clone, Debug)]
pub(crate) struct FacetMap<const D: usize> {
    degree: usize,
    nodes: Vec<[f64; D]>,
}

impl<const D: usize> FacetMap<D> {
    pub(crate) fn new(mesh: &Mesh<D>, cell: usize, local: usize) -> Self {
        let nodes = mesh.facet_nodes(cell, local).into_iter().map(|n| mesh.nodes[n as usize]).collect();
        FacetMap { degree: mesh.degree, nodes }
    }

    pub(crate) fn bounds(&self) -> ([f64; D], [f64; D]) {
        let factor = if self.degree == 1 { 1.0 } else { 1.25_f64.powi(D as i32 - 1) };
        image_bounds(self.nodes.iter().copied(), factor)
    }

    /// Distance from `x` to the facet.
    pub(crate) fn distance(&self, x: [f64; D]) -> f64 {
        let n = if self.degree == 1 && D == 2 { 1 } else { SAMPLES };
        let mut best = ([0.5; D], f64::INFINITY);
        for i in 0..(n + 1).pow(D as u32 - 1) {
            let at = std::array::from_fn(|d| (i / (n + 1).pow(d as u32) % (n + 1)) as f64 / n as f64);
            let away = distance(self.map(at), x);
            if away < best.1 {
                best = (at, away);
            }
        }
        let (mut at, mut nearest) = best;
        for _ in 0..SWEEPS {
            let before = at;
            for axis in 0..D - 1 {
                at[axis] = (at[axis] - self.newton_step(at, axis, x)).clamp(0.0, 1.0);
            }
            let away = distance(self.map(at), x);
            nearest = f64::min(nearest, away);
            if distance(at, before) < 1e-14 {
                break;
            }
        }
        nearest
    }

    /// Newton step for the minimum of `|X(s) − x|² / 2` in coordinate `axis`.
    fn newton_step(&self, s: [f64; D], axis: usize, x: [f64; D]) -> f64 {
        let basis = s.map(|s| lagrange(self.degree, s));
        let slope = lagrange_slope(self.degree, s[axis]);
        let bend = if self.degree == 1 { [0.0; 3] } else { [4.0, -8.0, 4.0] };
        let along = |values: [f64; 3]| self.combine(|d, i| if d == axis { values[i] } else { basis[d][i] });
        let (at, tangent, curvature) = (self.map(s), along(slope), along(bend));
        let (mut first, mut straight, mut bent) = (0.0, 0.0, 0.0);
        for d in 0..D {
            first += tangent[d] * (at[d] - x[d]);
            straight += tangent[d] * tangent[d];
            bent += curvature[d] * (at[d] - x[d]);
        }
        let second = if straight + bent > 0.1 * straight { straight + bent } else { straight };
        if second > 0.0 { first / second } else { 0.0 }
    }

    fn map(&self, s: [f64; D]) -> [f64; D] {
        let basis = s.map(|s| lagrange(self.degree, s));
        self.combine(|d, i| basis[d][i])
    }

    /// `Σ_n Π_d factor(d, i_d) x_n` over the nodes `n` at lattice position `i`.
    fn combine(&self, factor: impl Fn(usize, usize) -> f64) -> [f64; D] {
        let side = self.degree + 1;
        let mut sum = [0.0; D];
        for (n, x) in self.nodes.iter().enumerate() {
            let weight: f64 = (0..D - 1).map(|d| factor(d, n / side.pow(d as u32) % side)).product();
            for d in 0..D {
                sum[d] += weight * x[d];
            }
        }
        sum
    }
}
