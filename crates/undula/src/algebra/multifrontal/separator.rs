//! Vertex separators: a cut across the coordinates, improved by moves of Fiduccia and Mattheyses.

use super::graph::Graph;
use std::collections::BinaryHeap;

/// Largest part of the weight on one side.
const MAX_SIDE: f64 = 0.6;

/// Moves without gain after which a pass ends.
const PATIENCE: usize = 120;

/// Passes over a separator at most.
const PASSES: usize = 6;

/// Mark of a vertex in the separator; 0 and 1 are the sides.
pub(super) const MIDDLE: u8 = 2;

/// Side of each vertex: 0, 1 or [`MIDDLE`], with no edge between 0 and 1.
pub(super) fn separate(graph: &Graph) -> Vec<u8> {
    let total: u64 = graph.weight.iter().map(|&w| u64::from(w)).sum();
    let mut cuts: Vec<Cut> = directions(graph).into_iter().map(|d| Cut::across(graph, d)).collect();
    cuts.sort_by(|a, b| a.cost(total).total_cmp(&b.cost(total)));
    cuts.truncate(3);
    for cut in &mut cuts {
        for _ in 0..PASSES {
            if !cut.improve(graph, total) {
                break;
            }
        }
    }
    cuts.into_iter().min_by(|a, b| a.cost(total).total_cmp(&b.cost(total))).map_or_else(Vec::new, |c| c.side)
}

/// Coordinate axes, their diagonals in the plane, and the axis of largest inertia.
fn directions(graph: &Graph) -> Vec<[f64; 3]> {
    let n = graph.n() as f64;
    let mean = [0, 1, 2].map(|i| graph.at.iter().map(|x| x[i]).sum::<f64>() / n);
    let mut covariance = [[0.0; 3]; 3];
    for x in &graph.at {
        for i in 0..3 {
            for j in 0..3 {
                covariance[i][j] += (x[i] - mean[i]) * (x[j] - mean[j]);
            }
        }
    }
    // Power iteration; a few steps do for a direction to try.
    let mut axis = [1.0, 0.7, 0.4];
    for _ in 0..20 {
        let next = covariance.map(|row| row[0] * axis[0] + row[1] * axis[1] + row[2] * axis[2]);
        let size = next.iter().map(|v| v * v).sum::<f64>().sqrt();
        if size > 0.0 {
            axis = next.map(|v| v / size);
        }
    }
    let mut all = vec![axis, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.7, 0.7, 0.0], [0.7, -0.7, 0.0]];
    if covariance[2][2] > 0.0 {
        all.push([0.0, 0.0, 1.0]);
    }
    all
}

/// Two sides, what separates them, and their weights.
struct Cut {
    side: Vec<u8>,
    weight: [u64; 3],
}

impl Cut {
    /// Cuts at the weighted median along a direction; the separator is the lighter boundary.
    fn across(graph: &Graph, direction: [f64; 3]) -> Self {
        let n = graph.n();
        let key = |v: usize| -> f64 { (0..3).map(|i| direction[i] * graph.at[v][i]).sum() };
        let keys: Vec<f64> = (0..n).map(key).collect();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| keys[a].total_cmp(&keys[b]).then(a.cmp(&b)));
        let total: u64 = graph.weight.iter().map(|&w| u64::from(w)).sum();
        let (mut side, mut below) = (vec![1; n], 0);
        for v in order {
            if 2 * below >= total {
                break;
            }
            side[v] = 0;
            below += u64::from(graph.weight[v]);
        }
        let facing = |v: usize| graph.neighbours(v).iter().any(|&w| side[w as usize] != side[v]);
        let boundary: Vec<usize> = (0..n).filter(|&v| facing(v)).collect();
        let weight_of = |s: u8| -> u64 {
            boundary.iter().filter(|&&v| side[v] == s).map(|&v| u64::from(graph.weight[v])).sum()
        };
        let lighter = u8::from(weight_of(1) < weight_of(0));
        for v in boundary {
            if side[v] == lighter {
                side[v] = MIDDLE;
            }
        }
        let mut weight = [0; 3];
        for v in 0..n {
            weight[side[v] as usize] += u64::from(graph.weight[v]);
        }
        Self { side, weight }
    }

    /// Small is good: the separator's weight, and a little for sides of different weight.
    fn cost(&self, total: u64) -> f64 {
        let [a, b, middle] = self.weight.map(|w| w as f64);
        let skew = (a - b).abs() / total.max(1) as f64;
        let out_of_balance = (a.max(b) / total.max(1) as f64 - MAX_SIDE).max(0.0);
        (middle + 0.5) * (1.0 + 0.5 * skew * skew + 100.0 * out_of_balance)
    }

    /// Separator weight lost by moving a vertex out of it to a side.
    fn gain(&self, graph: &Graph, v: usize, to: u8) -> i64 {
        let pulled = graph.neighbours(v).iter().filter(|&&w| self.side[w as usize] == 1 - to);
        i64::from(graph.weight[v]) - pulled.map(|&w| i64::from(graph.weight[w as usize])).sum::<i64>()
    }

    fn shift(&mut self, graph: &Graph, v: usize, to: u8) {
        let w = u64::from(graph.weight[v]);
        self.weight[self.side[v] as usize] -= w;
        self.weight[to as usize] += w;
        self.side[v] = to;
    }

    /// One pass: moves vertices out of the separator, best first and uphill too, and goes back to
    /// the best separator seen. Returns whether it is better than before.
    fn improve(&mut self, graph: &Graph, total: u64) -> bool {
        let start = self.cost(total);
        let (mut best, mut best_len, mut waited) = (start, 0, 0);
        let mut pass = Pass { moved: vec![false; graph.n()], ..Pass::default() };
        for v in (0..graph.n()).filter(|&v| self.side[v] == MIDDLE) {
            self.offer(graph, &mut pass, v, &[0, 1]);
        }
        while let Some((gain, v, to)) = pass.offers.pop() {
            if self.side[v] != MIDDLE || pass.moved[v] {
                continue;
            }
            let now = self.gain(graph, v, to);
            if now != gain {
                // Better ones have been offered when they became better.
                if now < gain {
                    pass.offers.push((now, v, to));
                }
                continue;
            }
            let weight = self.weight[to as usize] + u64::from(graph.weight[v]);
            if weight as f64 > MAX_SIDE * total as f64 && weight > self.weight[1 - to as usize] {
                continue;
            }
            self.move_out(graph, &mut pass, v, to);
            let cost = self.cost(total);
            if cost < best {
                (best, best_len, waited) = (cost, pass.log.len(), 0);
            } else {
                waited += 1;
                if waited > PATIENCE {
                    break;
                }
            }
        }
        for &(v, side) in pass.log[best_len..].iter().rev() {
            self.shift(graph, v, side);
        }
        best < start
    }

    fn offer(&self, graph: &Graph, pass: &mut Pass, v: usize, sides: &[u8]) {
        pass.offers.extend(sides.iter().map(|&to| (self.gain(graph, v, to), v, to)));
    }

    /// Moves a vertex of the separator to a side; its neighbours on the other side take its place.
    fn move_out(&mut self, graph: &Graph, pass: &mut Pass, v: usize, to: u8) {
        pass.moved[v] = true;
        pass.log.push((v, MIDDLE));
        self.shift(graph, v, to);
        for &w in graph.neighbours(v) {
            let w = w as usize;
            if self.side[w] == 1 - to {
                pass.log.push((w, 1 - to));
                self.shift(graph, w, MIDDLE);
                self.offer(graph, pass, w, &[0, 1]);
                for &x in graph.neighbours(w) {
                    if self.side[x as usize] == MIDDLE && !pass.moved[x as usize] {
                        self.offer(graph, pass, x as usize, &[to]);
                    }
                }
            }
        }
    }
}

/// State of a pass over a separator.
#[derive(Default)]
struct Pass {
    /// Vertices that have had their turn.
    moved: Vec<bool>,
    /// Moves to choose from: gain, vertex, side.
    offers: BinaryHeap<(i64, usize, u8)>,
    /// Vertices shifted, and the side they were on.
    log: Vec<(usize, u8)>,
}
