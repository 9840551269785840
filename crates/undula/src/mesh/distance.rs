//! Distance to named facets, such as that to the interface by which extensions are stiffened.

use super::box_tree::{BoxTree, image_bounds};
use super::geometry::{distance, lagrange, lagrange_slope};
use super::{Mesh, MeshError};
use crate::element::{Shape, lagrange as nodal};

/// Samples along a curved edge from which its nearest point is sought; half as many per direction of a surface.
const SAMPLES: usize = 8;
/// Steps of that search by Newton's method.
const STEPS: usize = 30;
/// At most so often a step on a surface is halved.
const HALVINGS: i32 = 20;

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
    /// curved ones unless `x` is at their centre of curvature or far beyond it; infinite if there are none.
    pub fn distance(&self, x: [f64; D]) -> f64 {
        self.tree.nearest(x, |i| self.facets[i].distance(x))
    }
}

/// The Lagrange map of one facet. That of a triangle is taken as one of a square, whose side s = 1 is a vertex, see
/// [`collapsed`].
#[derive(Clone, Debug)]
pub(crate) struct FacetMap<const D: usize> {
    degree: usize,
    nodes: Vec<[f64; D]>,
    /// Whether it is a flat triangle.
    flat: bool,
}

impl<const D: usize> FacetMap<D> {
    pub(crate) fn new(mesh: &Mesh<D>, cell: usize, local: usize) -> Self {
        let nodes: Vec<_> =
            mesh.facet_nodes(cell, local).into_iter().map(|n| mesh.nodes[n as usize]).collect();
        let triangular = mesh.shape == Shape::Tetrahedron;
        let flat = triangular && mesh.degree == 1;
        let nodes = if triangular && !flat { collapsed(mesh.degree, &nodes) } else { nodes };
        FacetMap { degree: mesh.degree, nodes, flat }
    }

    pub(crate) fn bounds(&self) -> ([f64; D], [f64; D]) {
        let factor = if self.degree == 1 { 1.0 } else { 1.25_f64.powi(D as i32 - 1) };
        image_bounds(self.nodes.iter().copied(), factor)
    }

    /// Distance from `x` to the facet.
    pub(crate) fn distance(&self, x: [f64; D]) -> f64 {
        if self.flat {
            return to_triangle([self.nodes[0], self.nodes[1], self.nodes[2]], x);
        }
        let n = match (self.degree, D) {
            (1, 2) => 1,
            (_, 2) => SAMPLES,
            _ => SAMPLES / 2,
        };
        let mut best = ([0.5; D], f64::INFINITY);
        for i in 0..(n + 1).pow(D as u32 - 1) {
            let at = std::array::from_fn(|d| (i / (n + 1).pow(d as u32) % (n + 1)) as f64 / n as f64);
            let away = distance(self.map(at), x);
            if away < best.1 {
                best = (at, away);
            }
        }
        let (mut at, mut nearest) = best;
        for _ in 0..STEPS {
            let before = at;
            let step = self.newton_step(at, x);
            let moved = |share: f64| std::array::from_fn(|d| (before[d] - share * step[d]).clamp(0.0, 1.0));
            at = moved(1.0);
            let mut away = distance(self.map(at), x);
            // On a surface a full step may lead away; one along the descent that is short enough does not.
            for halvings in 1..if D > 2 { HALVINGS } else { 0 } {
                if away <= nearest {
                    break;
                }
                at = moved(0.5_f64.powi(halvings));
                away = distance(self.map(at), x);
            }
            nearest = f64::min(nearest, away);
            if distance(at, before) < 1e-14 {
                break;
            }
        }
        nearest
    }

    /// Newton step for the minimum of `|X(s) − x|² / 2` over the coordinates that are free: those that are not at an
    /// end which the function falls towards. Where its second derivatives are not clearly positive they are those of a
    /// flat facet.
    fn newton_step(&self, s: [f64; D], x: [f64; D]) -> [f64; D] {
        let basis = s.map(|s| lagrange(self.degree, s));
        let slope = s.map(|s| lagrange_slope(self.degree, s));
        let bend = if self.degree == 1 { [0.0; 3] } else { [4.0, -8.0, 4.0] };
        // Derivative in each of the coordinates `along`.
        let derivative = |along: [usize; 2]| {
            self.combine(|d, i| match along.iter().filter(|&&axis| axis == d).count() {
                0 => basis[d][i],
                1 => slope[d][i],
                _ => bend[i],
            })
        };
        let at = self.map(s);
        let dot = |a: [f64; D], b: [f64; D]| (0..D).fold(0.0, |sum, d| sum + a[d] * b[d]);
        let away: [f64; D] = std::array::from_fn(|d| at[d] - x[d]);
        let tangent: [[f64; D]; D] = std::array::from_fn(|axis| derivative([axis, D]));
        let first = tangent.map(|tangent| dot(tangent, away));
        // Second derivative of a flat facet, and what its curvature adds.
        let second = |a: usize, b: usize| (dot(tangent[a], tangent[b]), dot(derivative([a, b]), away));
        let ends = |a: &usize| (s[*a] <= 0.0 && first[*a] > 0.0) || (s[*a] >= 1.0 && first[*a] < 0.0);
        let free: Vec<usize> = (0..D - 1).filter(|a| !ends(a)).collect();
        let mut step = [0.0; D];
        if let [a, b] = free[..] {
            let [aa, ab, bb] = [second(a, a), second(a, b), second(b, b)];
            let det = |bent: f64| {
                let [aa, ab, bb] = [aa, ab, bb].map(|(flat, more)| flat + bent * more);
                (aa * bb - ab * ab, [aa, ab, bb])
            };
            let ((flat, _), (curved, _)) = (det(0.0), det(1.0));
            let bent = if aa.0 + aa.1 > 0.1 * aa.0 && curved > 0.01 * flat { 1.0 } else { 0.0 };
            let (det, [aa, ab, bb]) = det(bent);
            if det > 1e-12 * aa * bb {
                step[a] = (bb * first[a] - ab * first[b]) / det;
                step[b] = (aa * first[b] - ab * first[a]) / det;
                return step;
            }
        }
        for &a in &free {
            let (flat, more) = second(a, a);
            let second = if flat + more > 0.1 * flat { flat + more } else { flat };
            step[a] = if second > 0.0 { first[a] / second } else { 0.0 };
        }
        step
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

/// The nodes of the map of a square onto a triangle of degree `degree` with these nodes, (s, t) ↦ (s, t (1 − s)): a
/// polynomial keeps its degree in s and t.
fn collapsed<const D: usize>(degree: usize, nodes: &[[f64; D]]) -> Vec<[f64; D]> {
    let side = degree + 1;
    let place = |i: usize| {
        let [s, t] = [i % side, i / side].map(|i| i as f64 / degree as f64);
        let basis = nodal::basis(Shape::Triangle, degree, &[s, t * (1.0 - s), 0.0]).0;
        std::array::from_fn(|d| basis.iter().zip(nodes).map(|(weight, x)| weight * x[d]).sum())
    };
    (0..side * side).map(place).collect()
}

/// Distance of `x` to a flat triangle: to its plane if the foot lies inside, else to the nearest of its edges.
fn to_triangle<const D: usize>([a, b, c]: [[f64; D]; 3], x: [f64; D]) -> f64 {
    let minus = |p: [f64; D], q: [f64; D]| -> [f64; D] { std::array::from_fn(|d| p[d] - q[d]) };
    let dot = |p: [f64; D], q: [f64; D]| (0..D).map(|d| p[d] * q[d]).sum::<f64>();
    let to_edge = |p: [f64; D], q: [f64; D]| {
        let (along, away) = (minus(q, p), minus(x, p));
        let s = (dot(along, away) / dot(along, along)).clamp(0.0, 1.0);
        distance(std::array::from_fn(|d| p[d] + s * along[d]), x)
    };
    let (e, f, away) = (minus(b, a), minus(c, a), minus(x, a));
    let [ee, ef, ff, ea, fa] = [dot(e, e), dot(e, f), dot(f, f), dot(e, away), dot(f, away)];
    let det = ee * ff - ef * ef;
    let [s, t] = [(ff * ea - ef * fa) / det, (ee * fa - ef * ea) / det];
    if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
        return distance(std::array::from_fn(|d| a[d] + s * e[d] + t * f[d]), x);
    }
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}
