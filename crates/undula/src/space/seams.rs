//! Boundaries that are one: nodes with several places.

use super::{FsiSpace, Nodes, PressureKind, PsiOwner, pressure_nodes};
use crate::mesh::{Seam, Side};
use std::collections::HashSet;

/// The points of the mesh of a space with seams.
#[derive(Clone, Debug)]
pub struct Places<const D: usize> {
    /// Nodes as they were before some of them became one.
    points: Nodes<D>,
    /// The node at each of them.
    of: Vec<u32>,
}

impl<const D: usize> FsiSpace<D> {
    /// The same space on a domain that is closed at the `seams`: nodes and continuous pressures on both sides of each are
    /// one unknown, whose number stands in the cells of both sides. Cells keep their geometry.
    #[must_use]
    pub fn joined(mut self, seams: Vec<Seam<D>>) -> FsiSpace<D> {
        if seams.is_empty() {
            return self;
        }
        let pairs = |k: usize, cell: &dyn Fn(usize) -> Vec<u32>| {
            let mut pairs: Vec<[u32; 2]> = vec![];
            for seam in &seams {
                let [one, two] = seam.sides.map(|side| cell(side.cell as usize));
                let there = !one.is_empty() && !two.is_empty();
                let twins = seam.twins(&self.mesh, k).into_iter().filter(|_| there);
                pairs.extend(twins.map(|[a, b]| [one[a], two[b]]));
            }
            pairs
        };
        let mut twins = pairs(self.nodes.degree, &|c| self.nodes.cell(c).to_vec());
        let bubble =
            |side: Side| self.nodes.facet_bubble(self.mesh.shape, side.cell as usize, side.local as usize);
        let bubbles = seams.iter().filter_map(|seam| Some([bubble(seam.sides[0])?, bubble(seam.sides[1])?]));
        twins.extend(bubbles);
        let of = classes(self.nodes.len(), &twins);
        let pressures = match self.pressure.kind {
            PressureKind::Continuous(k) => {
                classes(self.pressure.n, &pairs(k, &|c| self.pressure.cell(c).to_vec()))
            }
            PressureKind::Pdc(_) => (0..self.pressure.n as u32).collect(),
        };
        let mut nodes = self.nodes.clone();
        renumber(&mut nodes.cell_nodes, &of);
        nodes.points = first_of(&self.nodes.points, &of);
        nodes.n_lagrange = of[..self.nodes.n_lagrange].iter().max().map_or(0, |&last| last as usize + 1);
        let mut owner = vec![PsiOwner::Extension; nodes.len()];
        for (&node, own) in of.iter().zip(&self.owner).filter(|(_, own)| **own == PsiOwner::Relation) {
            owner[node as usize] = *own;
        }
        renumber(&mut self.pressure.cell_dofs, &pressures);
        self.pressure.points = first_of(&self.pressure.points, &pressures);
        self.pressure.n = self.pressure.points.len();
        if let PressureKind::Continuous(k) = self.pressure.kind {
            self.pressure_nodes = pressure_nodes(&self.mesh, &nodes, &self.pressure, k);
        }
        let points = std::mem::replace(&mut self.nodes, nodes);
        (self.owner, self.seams, self.places) = (owner, seams, Some(Places { points, of }));
        self
    }

    /// Facets between two cells, those of seams behind the others.
    pub fn inner_facets(&self) -> Vec<[Side; 2]> {
        let mut inner = self.mesh.facets_of_cells().inner;
        inner.extend(self.seams.iter().map(|seam| seam.sides));
        inner
    }

    /// The sides of the seams.
    pub fn seam_sides(&self) -> HashSet<Side> {
        self.seams.iter().flat_map(|seam| seam.sides).collect()
    }

    /// Points of the mesh: the nodes, each as often as there are places where it lies. Those on a seam lie in two or more.
    pub fn places(&self) -> &Nodes<D> {
        self.places.as_ref().map_or(&self.nodes, |places| &places.points)
    }

    /// The node at the point `place` of [`FsiSpace::places`].
    pub fn node_at(&self, place: usize) -> usize {
        self.places.as_ref().map_or(place, |places| places.of[place] as usize)
    }

    /// Values of the nodes, `n` numbers for each, as values of [`FsiSpace::places`] without bubbles.
    pub fn at_places<T: Copy>(&self, values: &[T], n: usize) -> Vec<T> {
        let all = 0..self.places().n_lagrange;
        all.flat_map(|place| &values[self.node_at(place) * n..][..n]).copied().collect()
    }

    /// Translations \[m\] that bring the domain to its neighbours at the seams, with those of both signs and their sums, 0
    /// among them.
    pub fn shifts(&self) -> Vec<[f64; D]> {
        let mut own: Vec<[f64; D]> = vec![];
        let size = |x: [f64; D]| x.iter().map(|x| x.abs()).fold(0.0, f64::max);
        for seam in &self.seams {
            let is_new = |other: &[f64; D], sign: f64| {
                size(std::array::from_fn(|d| other[d] - sign * seam.shift[d])) > 1e-9 * size(seam.shift)
            };
            if own.iter().all(|other| is_new(other, 1.0) && is_new(other, -1.0)) {
                own.push(seam.shift);
            }
        }
        own.iter().fold(vec![[0.0; D]], |sums, shift| {
            let with = |sum: &[f64; D]| {
                [0.0, 1.0, -1.0].map(|sign| std::array::from_fn(|d| sum[d] + sign * shift[d]))
            };
            sums.iter().flat_map(with).collect()
        })
    }
}

/// Numbers of the classes of 0 … n − 1 that the pairs make, in the order of their first members.
fn classes(n: usize, pairs: &[[u32; 2]]) -> Vec<u32> {
    let mut first: Vec<u32> = (0..n as u32).collect();
    let root = |first: &[u32], mut a: u32| {
        while first[a as usize] != a {
            a = first[a as usize];
        }
        a
    };
    for pair in pairs {
        let [a, b] = pair.map(|a| root(&first, a));
        first[a.max(b) as usize] = a.min(b);
    }
    let (mut number, mut classes) = (vec![0; n], 0);
    for a in 0..n as u32 {
        let root = root(&first, a);
        if root == a {
            number[a as usize] = classes;
            classes += 1;
        } else {
            number[a as usize] = number[root as usize];
        }
    }
    number
}

fn renumber(list: &mut [u32], numbers: &[u32]) {
    list.iter_mut().filter(|a| **a != u32::MAX).for_each(|a| *a = numbers[*a as usize]);
}

/// The value of the first member of each class.
fn first_of<T: Copy>(values: &[T], classes: &[u32]) -> Vec<T> {
    let mut list = vec![];
    for (&value, &class) in values.iter().zip(classes) {
        if class as usize == list.len() {
            list.push(value);
        }
    }
    list
}
