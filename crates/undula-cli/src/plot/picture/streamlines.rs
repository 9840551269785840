//! Streamlines of the velocity of the fluid in a picture.

use super::raster::{NOWHERE, Raster, SAMPLES};
use super::{Panel, SCALE};
use undula::output::FieldSnapshot;

/// Distance between beginnings; lines end at half of it from others \[pixels\].
const BETWEEN: f64 = 16.0;
/// Steps in each direction at most; each is a pixel long.
const STEPS: usize = 2000;
/// Lines that are shorter are left out \[pixels\].
const SHORTEST: usize = 30;

/// The velocity at the pixels of a picture.
struct Flow<'a> {
    along: [Raster; 2],
    solid: &'a [bool],
}

impl Flow<'_> {
    /// Direction of the velocity at a point of the panel, in pixels, y downwards; `None` outside of the fluid and
    /// where nothing flows.
    fn direction(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let fine = (SCALE * SAMPLES) as f64;
        let raster = &self.along[0];
        let (i, j) = ((x * fine).floor(), (y * fine).floor());
        if i < 0.0 || j < 0.0 || i >= raster.width as f64 || j >= raster.height as f64 {
            return None;
        }
        let at = j as usize * raster.width + i as usize;
        let cell = raster.samples[at].cell;
        if cell == NOWHERE || self.solid[cell as usize] {
            return None;
        }
        let [u, v] = [0, 1].map(|d| f64::from(self.along[d].samples[at].value));
        let size = u.hypot(v);
        (size > 0.0).then(|| [u / size, -v / size])
    }

    /// Points of a line from `start`, forwards or backwards, up to lines that `taken` has.
    fn line(&self, start: [f64; 2], sign: f64, taken: &Taken) -> Vec<[f64; 2]> {
        let mut line = vec![];
        let mut at = start;
        let go =
            |from: [f64; 2], along: [f64; 2], by: f64| [from[0] + by * along[0], from[1] + by * along[1]];
        while line.len() < STEPS {
            // The midpoint rule.
            let Some(first) = self.direction(at) else { break };
            let Some(middle) = self.direction(go(at, first, 0.5 * sign)) else { break };
            at = go(at, middle, sign);
            if taken.has(at) {
                break;
            }
            line.push(at);
        }
        line
    }
}

/// Side of a square of a panel \[pixels\].
const SQUARE: f64 = 0.5 * BETWEEN;

/// Squares of a panel that lines pass.
struct Taken {
    columns: usize,
    squares: Vec<bool>,
}

impl Taken {
    fn square(&self, [x, y]: [f64; 2]) -> usize {
        let column = ((x / SQUARE).max(0.0) as usize).min(self.columns - 1);
        let row = (y / SQUARE).max(0.0) as usize;
        (row * self.columns + column).min(self.squares.len() - 1)
    }

    fn has(&self, at: [f64; 2]) -> bool {
        self.squares[self.square(at)]
    }

    /// Whether a line passes near a point, too.
    fn has_near(&self, [x, y]: [f64; 2]) -> bool {
        let steps = [-SQUARE, 0.0, SQUARE];
        steps.iter().any(|dx| steps.iter().any(|dy| self.has([x + dx, y + dy])))
    }
}

/// Lines in the coordinates of the figure, from beginnings on a grid that no earlier line has passed.
pub(super) fn trace(snapshot: &FieldSnapshot, solid: &[bool], panel: &Panel) -> Vec<Vec<(f64, f64)>> {
    let Some(velocity) = snapshot.at_points("velocity") else { return vec![] };
    let component = |d: usize| -> Vec<f64> {
        velocity.values.chunks_exact(velocity.components).map(|v| v.get(d).copied().unwrap_or(0.0)).collect()
    };
    let flow = Flow { along: [0, 1].map(|d| Raster::new(snapshot, &component(d), panel, SAMPLES)), solid };
    let count =
        |size: f64| [panel.width, panel.height].map(|length| (length / size).ceil().max(1.0) as usize);
    let ([columns, rows], squares) = (count(BETWEEN), count(SQUARE));
    let mut taken = Taken { columns: squares[0], squares: vec![false; squares[0] * squares[1]] };
    let mut lines = vec![];
    for row in 0..rows {
        for column in 0..columns {
            let start = [column, row].map(|n| (n as f64 + 0.5) * BETWEEN);
            if taken.has_near(start) || flow.direction(start).is_none() {
                continue;
            }
            let mut line = flow.line(start, -1.0, &taken);
            line.reverse();
            line.push(start);
            line.extend(flow.line(start, 1.0, &taken));
            if line.len() < SHORTEST {
                continue;
            }
            for point in &line {
                let square = taken.square(*point);
                taken.squares[square] = true;
            }
            lines.push(line.into_iter().map(|[x, y]| (panel.left + x, panel.top + y)).collect());
        }
    }
    lines
}
