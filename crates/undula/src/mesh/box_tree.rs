//! A tree of boxes, to find among many things those near a point.

use super::geometry::bounds;
use crate::element::Shape;

/// Leaves hold at most this many boxes.
const LEAF: usize = 4;

/// A box with axis-parallel sides: lower and upper corner.
pub(crate) type Bounds<const D: usize> = ([f64; D], [f64; D]);

/// Boxes numbered in the order given, halved again and again along the longest side.
#[derive(Clone, Debug)]
pub(crate) struct BoxTree<const D: usize> {
    boxes: Vec<Bounds<D>>,
    order: Vec<u32>,
    branches: Vec<Branch<D>>,
}

#[derive(Clone, Debug)]
struct Branch<const D: usize> {
    bounds: Bounds<D>,
    /// Range of `order`.
    range: (usize, usize),
    /// Two further branches, or none.
    halves: Option<(usize, usize)>,
}

impl<const D: usize> BoxTree<D> {
    pub(crate) fn new(boxes: Vec<Bounds<D>>) -> Self {
        let order = (0..boxes.len() as u32).collect();
        let mut tree = BoxTree { boxes, order, branches: vec![] };
        tree.grow(0, tree.boxes.len());
        tree
    }

    fn grow(&mut self, start: usize, end: usize) -> usize {
        let inside = self.order[start..end].iter().map(|&i| self.boxes[i as usize]);
        let (lower, upper) = bounds(inside.flat_map(|(lower, upper)| [lower, upper]));
        let number = self.branches.len();
        self.branches.push(Branch { bounds: (lower, upper), range: (start, end), halves: None });
        if end - start > LEAF {
            let longest = |&a: &usize, &b: &usize| (upper[a] - lower[a]).total_cmp(&(upper[b] - lower[b]));
            let axis = (0..D).max_by(longest).unwrap_or(0);
            let boxes = &self.boxes;
            let twice_centre = |&i: &u32| boxes[i as usize].0[axis] + boxes[i as usize].1[axis];
            let middle = (start + end) / 2;
            self.order[start..end].sort_by(|a, b| twice_centre(a).total_cmp(&twice_centre(b)));
            let halves = (self.grow(start, middle), self.grow(middle, end));
            self.branches[number].halves = Some(halves);
        }
        number
    }

    /// Calls `visit` with every box that comes within `reach` of `x`.
    pub(crate) fn near(&self, x: [f64; D], reach: f64, mut visit: impl FnMut(usize)) {
        self.search(x, reach, |i, _| {
            visit(i);
            reach
        });
    }

    /// The smallest value of `distance(i)` over all boxes `i`, given that it is never below the distance
    /// of `x` to the box; infinite without boxes.
    pub(crate) fn nearest(&self, x: [f64; D], distance: impl Fn(usize) -> f64) -> f64 {
        let mut best = f64::INFINITY;
        self.search(x, f64::INFINITY, |i, _| {
            best = best.min(distance(i));
            best
        });
        best
    }

    /// Visits boxes within a reach that `visit` returns anew each time, nearer halves first.
    fn search(&self, x: [f64; D], mut reach: f64, mut visit: impl FnMut(usize, f64) -> f64) {
        let mut stack = vec![(0, 0.0)];
        while let Some((branch, away)) = stack.pop() {
            let Branch { range, halves, .. } = &self.branches[branch];
            if away > reach {
                continue;
            }
            if let Some((one, two)) = *halves {
                let gap = |half: usize| outside(x, &self.branches[half].bounds);
                let (near, far) = if gap(one) <= gap(two) { (one, two) } else { (two, one) };
                stack.extend([(far, gap(far)), (near, gap(near))]);
            } else {
                for &i in &self.order[range.0..range.1] {
                    let away = outside(x, &self.boxes[i as usize]);
                    if away <= reach {
                        reach = visit(i as usize, away);
                    }
                }
            }
        }
    }
}

/// Distance of `x` to a box, 0 inside.
fn outside<const D: usize>(x: [f64; D], (lower, upper): &Bounds<D>) -> f64 {
    let gap = |d: usize| (lower[d] - x[d]).max(x[d] - upper[d]).max(0.0);
    (0..D).map(|d| gap(d).powi(2)).sum::<f64>().sqrt()
}

/// The factor by which the image of the Lagrange map of degree 1 or 2 leaves the box of its nodes at most (Lebesgue
/// constant): 5/4 per variable for degree 2, 5/3 on a triangle, 2 on a tetrahedron.
pub(crate) fn spread(shape: Shape, degree: usize) -> f64 {
    match (shape, degree) {
        (_, 1) => 1.0,
        (Shape::Triangle, _) => 5.0 / 3.0,
        (Shape::Tetrahedron, _) => 2.0,
        _ => 1.25_f64.powi(shape.dim() as i32),
    }
}

/// A box around the image of a Lagrange map with these nodes, which leaves the box of its nodes by at most `factor`.
pub(crate) fn image_bounds<const D: usize>(nodes: impl Iterator<Item = [f64; D]>, factor: f64) -> Bounds<D> {
    let (mut lower, mut upper) = bounds(nodes);
    for d in 0..D {
        let (middle, half) = (0.5 * (lower[d] + upper[d]), 0.5 * (upper[d] - lower[d]));
        (lower[d], upper[d]) = (middle - factor * half, middle + factor * half);
    }
    (lower, upper)
}
