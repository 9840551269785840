//! Facets of two boundaries of which one is a translation of the other.

use super::geometry::{bounds, distance};
use super::{Facet, Mesh, Side};
use crate::element::lagrange;
use crate::math::{Tensor, Vector};
use std::collections::HashSet;

/// Two facets that are one: the second is the first, moved by `shift`.
#[derive(Clone, Debug, PartialEq)]
pub struct Seam<const D: usize> {
    /// The facets, each seen from its cell.
    pub sides: [Side; 2],
    /// The translation \[m\].
    pub shift: [f64; D],
}

/// Points are one if their distance is below this part of the size of the smallest facet.
const CLOSE: f64 = 1e-6;

/// The geometry nodes of a facet, and its centre.
struct Place<const D: usize> {
    side: Side,
    nodes: Vec<[f64; D]>,
    centre: [f64; D],
}

impl<const D: usize> Mesh<D> {
    /// The facets of the boundary `names[0]`, each with the facet of `names[1]` that is its translation; all in the order
    /// of the mesh.
    ///
    /// # Errors
    /// In words, if a facet lies between cells, if the boundaries are not of one shape, if their facets do not match, or if
    /// both have the domain on one side.
    pub fn seams(&self, names: [&str; 2]) -> Result<Vec<Seam<D>>, String> {
        let facets = names.map(|name| self.facets_on(&[name]));
        let outer: HashSet<Side> = self.facets_of_cells().outer.into_iter().collect();
        for (facets, name) in facets.iter().zip(names) {
            if let Some(inner) = facets.iter().find(|facet| !outer.contains(&facet.side())) {
                let at = self.shown(&self.place(inner).centre);
                return Err(format!("`{name}` lies between cells at {at}: expected an outer boundary"));
            }
        }
        let [one, two] = facets.map(|facets| facets.iter().map(|f| self.place(f)).collect::<Vec<_>>());
        if let Some((name, _)) = names.iter().zip([&one, &two]).find(|(_, list)| list.is_empty()) {
            return Err(format!(
                "`{name}` has no facet on the bodies of the case: expected two outer boundaries"
            ));
        }
        let size =
            |place: &Place<D>| place.nodes.iter().map(|x| distance(*x, place.centre)).fold(0.0, f64::max);
        let close = CLOSE * one.iter().chain(&two).map(size).fold(f64::INFINITY, f64::min);
        let ends = [&one, &two].map(|list| bounds(list.iter().flat_map(|place| place.nodes.iter().copied())));
        let shift = minus(ends[1].0, ends[0].0);
        if distance(plus(ends[0].1, shift), ends[1].1) > close {
            let extent =
                ends.map(|(lower, upper)| format!("{} to {}", self.shown(&lower), self.shown(&upper)));
            return Err(format!(
                "`{}` is no translation of `{}`: they extend over {} and {}; expected two boundaries of one shape and \
                 direction (rotations are not yet available)",
                names[1], names[0], extent[0], extent[1]
            ));
        }
        self.pairs(names, [&one, &two], shift, close)
    }

    /// Each place of the first list with that of the second one which is it, moved by `shift`.
    fn pairs(
        &self,
        names: [&str; 2],
        [one, two]: [&[Place<D>]; 2],
        shift: [f64; D],
        close: f64,
    ) -> Result<Vec<Seam<D>>, String> {
        let unmatched = |place: &Place<D>, there: [f64; D], other: &str| {
            let [at, there] = [place.centre, there].map(|x| self.shown(&x));
            format!(
                "the facet at {at} has no partner at {there} on `{other}`: expected boundaries with matching facets, the \
                 same nodes on both"
            )
        };
        let (mut seams, mut taken) = (vec![], HashSet::new());
        // Sorted along the longest side, those near a place stand together.
        let (lower, upper) = bounds(two.iter().map(|place| place.centre));
        let along =
            (0..D).max_by(|&a, &b| (upper[a] - lower[a]).total_cmp(&(upper[b] - lower[b]))).unwrap_or(0);
        let mut order: Vec<&Place<D>> = two.iter().collect();
        order.sort_by(|a, b| a.centre[along].total_cmp(&b.centre[along]));
        for place in one {
            let there = plus(place.centre, shift);
            let first = order.partition_point(|other| other.centre[along] < there[along] - close);
            let near = order[first..].iter().take_while(|other| other.centre[along] <= there[along] + close);
            let is_there = |x: &[f64; D], other: &Place<D>| {
                other.nodes.iter().any(|y| distance(plus(*x, shift), *y) <= close)
            };
            let same = |other: &&&Place<D>| place.nodes.iter().all(|x| is_there(x, other));
            let Some(other) = near.into_iter().find(same) else {
                return Err(unmatched(place, there, names[1]));
            };
            if self.normal(place.side).dot(self.normal(other.side)) >= 0.0 {
                return Err(format!(
                    "the domain lies on one side of `{}` and `{}` at {}: expected two ends of the domain",
                    names[0],
                    names[1],
                    self.shown(&place.centre)
                ));
            }
            taken.insert(other.side);
            seams.push(Seam { sides: [place.side, other.side], shift });
        }
        match two.iter().find(|place| !taken.contains(&place.side)) {
            Some(place) => Err(unmatched(place, minus(place.centre, shift), names[0])),
            None => Ok(seams),
        }
    }

    fn place(&self, facet: &Facet) -> Place<D> {
        let nodes = self.facet_nodes(facet.cell as usize, facet.local as usize);
        let nodes: Vec<[f64; D]> = nodes.into_iter().map(|node| self.nodes[node as usize]).collect();
        let sum = nodes.iter().fold([0.0; D], |sum, x| plus(sum, *x));
        Place { side: facet.side(), centre: sum.map(|x| x / nodes.len() as f64), nodes }
    }

    /// The outer normal in the middle of a facet, of any length.
    fn normal(&self, side: Side) -> Vector<f64, D> {
        let (cell, local) = (side.cell as usize, side.local as usize);
        let on_facet = self.shape.facet_nodes(self.degree, local);
        let n = on_facet.len() as f64;
        let at = on_facet.iter().map(|&a| lagrange::node(self.shape, self.degree, a));
        let xi = at.fold([0.0; D], |sum, xi| std::array::from_fn(|d| sum[d] + xi[d] / n));
        let reference = self.shape.facet_normal(local);
        Tensor(self.map_gradient(cell, xi)).cofactor() * Vector(std::array::from_fn(|d| reference[d]))
    }
}

impl<const D: usize> Seam<D> {
    /// The nodes of a Lagrange basis of degree `k` on the facet: their numbers in the cells of both sides.
    pub fn twins(&self, mesh: &Mesh<D>, k: usize) -> Vec<[usize; 2]> {
        let at = |side: Side| {
            let on_facet = mesh.shape.facet_nodes(k, side.local as usize).into_iter();
            let place = |a: usize| {
                let xi = lagrange::node(mesh.shape, k, a);
                (a, mesh.map(side.cell as usize, std::array::from_fn(|d| xi[d])))
            };
            on_facet.map(place).collect::<Vec<_>>()
        };
        let [one, two] = self.sides.map(at);
        let nearest = |(a, x): (usize, [f64; D])| {
            let from = |y: &[f64; D]| distance(plus(x, self.shift), *y);
            let twin = two.iter().min_by(|y, z| from(&y.1).total_cmp(&from(&z.1)));
            twin.map(|(b, _)| [a, *b])
        };
        one.into_iter().filter_map(nearest).collect()
    }
}

fn plus<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|d| a[d] + b[d])
}

fn minus<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|d| a[d] - b[d])
}
