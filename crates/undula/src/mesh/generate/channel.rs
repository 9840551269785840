//! What the two channels with a cylinder share: a ring of blocks around the cylinder, the cells between
//! ring, inflow and walls, and the rows of blocks behind the ring.

use super::blocks::{Blocks, Path, Point, even};
use super::{CENTRE, HEIGHT, RADIUS};
use crate::mesh::INTERFACE;

/// One block of the ring, between its points `i` and `i + 1` counter-clockwise.
pub(super) struct Sector {
    /// Course of its outer side.
    pub path: Path,
    /// Division of its inner side.
    pub inner: Vec<f64>,
    /// Division of its outer side.
    pub outer: Vec<f64>,
    /// Region.
    pub region: u16,
    /// Boundary on the circle.
    pub boundary: &'static str,
}

impl Sector {
    /// A fluid block with `n` equal cells on both sides.
    pub(super) fn fluid(n: usize, path: Path) -> Self {
        Sector { path, inner: even(n), outer: even(n), region: 0, boundary: "cylinder" }
    }
}

impl Blocks {
    /// The point on the cylinder in direction `degrees`.
    pub(super) fn on_cylinder(&mut self, degrees: f64) -> Point {
        let (sin, cos) = degrees.to_radians().sin_cos();
        self.point(CENTRE[0] + RADIUS * cos, CENTRE[1] + RADIUS * sin)
    }

    /// The blocks between the points `inner` on the cylinder and `outer` around them.
    pub(super) fn ring(&mut self, inner: &[Point], outer: &[Point], radial: &[f64], sectors: &[Sector]) {
        for (&a, &b) in inner.iter().zip(outer) {
            self.edge(a, b, Path::Line, radial);
        }
        for (i, sector) in sectors.iter().enumerate() {
            let before = &sectors[(i + sectors.len() - 1) % sectors.len()];
            if sector.region != before.region {
                self.name(inner[i], outer[i], INTERFACE);
            }
        }
        for (i, sector) in sectors.iter().enumerate() {
            let j = (i + 1) % sectors.len();
            self.edge(inner[i], inner[j], Path::Arc(CENTRE), &sector.inner);
            self.edge(outer[i], outer[j], sector.path, &sector.outer);
            self.name(inner[i], inner[j], sector.boundary);
            self.block(sector.region, [inner[j], inner[i], outer[i], outer[j]]);
        }
    }

    /// The cells between the ring with corners `[se, ne, nw, sw]`, the inflow and the walls up to the
    /// points `below` and `above`; `along` cells over and under the ring, `across` cells in front of it. The inflow is at
    /// `x = start`, with cells divided as `before` up to the ring.
    pub(super) fn before_ring(
        &mut self,
        ring: [Point; 4],
        [below, above]: [Point; 2],
        [along, across]: [usize; 2],
        (start, before): (f64, &[f64]),
    ) {
        let [se, ne, nw, sw] = ring;
        let [front_low, front_high] = [self.x(sw)[0] - 0.02, self.x(nw)[0] - 0.02];
        let bottom = [self.point(start, 0.0), self.point(front_low, 0.0)];
        let top = [self.point(start, HEIGHT), self.point(front_high, HEIGHT)];
        let inflow = [self.point(start, 0.07), self.point(start, HEIGHT - 0.074)];
        let (along, across, one) = (&even(along)[..], &even(across)[..], &even(1)[..]);
        for (a, b, breaks, name) in [
            (bottom[0], bottom[1], before, "walls"),
            (top[0], top[1], before, "walls"),
            (bottom[1], below, along, "walls"),
            (top[1], above, along, "walls"),
            (bottom[0], inflow[0], one, "inflow"),
            (inflow[0], inflow[1], across, "inflow"),
            (inflow[1], top[0], one, "inflow"),
        ] {
            self.edge(a, b, Path::Line, breaks);
            self.name(a, b, name);
        }
        for (a, b, breaks) in [
            (inflow[0], sw, before),
            (inflow[1], nw, before),
            (bottom[1], sw, one),
            (nw, top[1], one),
            (below, se, one),
            (ne, above, one),
        ] {
            self.edge(a, b, Path::Line, breaks);
        }
        for corners in [
            [bottom[0], bottom[1], sw, inflow[0]],
            [inflow[0], sw, nw, inflow[1]],
            [inflow[1], nw, top[1], top[0]],
            [bottom[1], below, se, sw],
            [nw, ne, above, top[1]],
        ] {
            self.block(0, corners);
        }
    }
}

/// Blocks in rows and columns behind the ring.
pub(super) struct Rows<'a> {
    /// Points by column and, from the lower to the upper wall, by row; the edges of the first column are
    /// there already.
    pub columns: &'a [Vec<Point>],
    /// Division of the horizontal edge behind `(column, row)`.
    pub along: &'a dyn Fn(usize, usize) -> Vec<f64>,
    /// Division of the vertical edge above `(column, row)`.
    pub across: &'a dyn Fn(usize, usize) -> Vec<f64>,
    /// Region of the block behind and above `(column, row)`.
    pub region: &'a dyn Fn(usize, usize) -> u16,
}

impl Rows<'_> {
    /// Adds the edges, with the names of walls, outflow and interface, and the blocks.
    pub(super) fn add(&self, blocks: &mut Blocks) {
        let (n, m) = (self.columns.len() - 1, self.columns[0].len() - 1);
        for column in 0..n {
            for row in 0..=m {
                let (a, b) = (self.columns[column][row], self.columns[column + 1][row]);
                blocks.edge(a, b, Path::Line, &(self.along)(column, row));
                if row == 0 || row == m {
                    blocks.name(a, b, "walls");
                } else if (self.region)(column, row) != (self.region)(column, row - 1) {
                    blocks.name(a, b, INTERFACE);
                }
            }
        }
        for column in 1..=n {
            for row in 0..m {
                let (a, b) = (self.columns[column][row], self.columns[column][row + 1]);
                blocks.edge(a, b, Path::Line, &(self.across)(column, row));
                if column == n {
                    blocks.name(a, b, "outflow");
                } else if (self.region)(column, row) != (self.region)(column - 1, row) {
                    blocks.name(a, b, INTERFACE);
                }
            }
        }
        for column in 0..n {
            for row in 0..m {
                let (left, right) = (&self.columns[column], &self.columns[column + 1]);
                let corners = [left[row], right[row], right[row + 1], left[row + 1]];
                blocks.block((self.region)(column, row), corners);
            }
        }
    }
}
