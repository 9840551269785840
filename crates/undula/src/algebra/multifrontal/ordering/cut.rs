//! Vertex separators and moves that make them better (Fiduccia and Mattheyses 1982).

use super::super::graph::Graph;
use std::collections::BinaryHeap;

/// Largest part of the weight on one side.
const MAX_SIDE: f64 = 0.7;

/// Moves without gain after which a pass ends.
const PATIENCE: usize = 50;

/// Passes over a separator at most.
const PASSES: usize = 6;

/// Mark of a vertex in the separator; 0 and 1 are the sides.
pub(super) const MIDDLE: u8 = 2;

/// Two sides, what separates them, and their weights.
pub(super) struct Cut {
    /// Side of each vertex: 0, 1 or [`MIDDLE`], with no edge between 0 and 1.
    pub side: Vec<u8>,
    weight: [u64; 3],
    total: u64,
}

impl Cut {
    /// Cuts at the weighted median of a number for each vertex; the separator is the lighter boundary.
    pub fn at_median(graph: &Graph, keys: &[f64]) -> Self {
        let n = graph.n();
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| keys[a].total_cmp(&keys[b]).then(a.cmp(&b)));
        let total = graph.total();
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
        Self::of(graph, side)
    }

    /// The cut with these sides.
    pub fn of(graph: &Graph, side: Vec<u8>) -> Self {
        let mut weight = [0; 3];
        for (&s, &w) in side.iter().zip(&graph.weight) {
            weight[s as usize] += u64::from(w);
        }
        Self { side, weight, total: graph.total() }
    }

    /// Small is good: the separator's weight, and a little for sides of different weight.
    pub fn cost(&self) -> f64 {
        let [a, b, middle] = self.weight.map(|w| w as f64);
        let total = self.total.max(1) as f64;
        let skew = (a - b).abs() / total;
        let out_of_balance = (a.max(b) / total - MAX_SIDE).max(0.0);
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

    /// Moves vertices as long as the separator gets better.
    pub fn improve(&mut self, graph: &Graph) {
        for _ in 0..PASSES {
            if !self.improve_once(graph) {
                break;
            }
        }
    }

    /// One pass: moves vertices out of the separator, best first and uphill too, and goes back to
    /// the best separator seen. Returns whether it is better than before.
    fn improve_once(&mut self, graph: &Graph) -> bool {
        let start = self.cost();
        let (mut best, mut best_len, mut waited) = (start, 0, 0);
        let mut pass = Pass::new(graph.n());
        for v in (0..graph.n()).filter(|&v| self.side[v] == MIDDLE) {
            pass.offer(v, [0, 1].map(|to| self.gain(graph, v, to)));
        }
        while let Some((gain, v, to)) = pass.offers.pop() {
            let now = pass.gain[v][to as usize];
            if self.side[v] != MIDDLE || pass.moved[v] || now > gain {
                // Better ones have been offered when they became better.
                continue;
            }
            if now < gain {
                pass.offers.push((now, v, to));
                continue;
            }
            let weight = self.weight[to as usize] + u64::from(graph.weight[v]);
            if weight as f64 > MAX_SIDE * self.total as f64 && weight > self.weight[1 - to as usize] {
                continue;
            }
            self.move_out(graph, &mut pass, v, to);
            let cost = self.cost();
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

    /// Moves a vertex of the separator to a side; its neighbours on the other side take its place.
    fn move_out(&mut self, graph: &Graph, pass: &mut Pass, v: usize, to: u8) {
        pass.moved[v] = true;
        pass.log.push((v, MIDDLE));
        self.shift(graph, v, to);
        for x in self.middle_around(graph, v) {
            pass.gain[x][1 - to as usize] -= i64::from(graph.weight[v]);
        }
        for &w in graph.neighbours(v) {
            let w = w as usize;
            if self.side[w] != 1 - to {
                continue;
            }
            pass.log.push((w, 1 - to));
            self.shift(graph, w, MIDDLE);
            for x in self.middle_around(graph, w) {
                pass.gain[x][to as usize] += i64::from(graph.weight[w]);
                pass.changed.push(x);
            }
            pass.offer(w, [0, 1].map(|to| self.gain(graph, w, to)));
        }
        pass.changed.sort_unstable();
        pass.changed.dedup();
        for &x in pass.changed.iter().filter(|&&x| !pass.moved[x]) {
            pass.offers.push((pass.gain[x][to as usize], x, to));
        }
        pass.changed.clear();
    }

    /// Neighbours in the separator.
    fn middle_around(&self, graph: &Graph, v: usize) -> impl Iterator<Item = usize> {
        let around = graph.neighbours(v).iter().map(|&x| x as usize);
        around.filter(|&x| self.side[x] == MIDDLE)
    }
}

/// State of a pass over a separator.
struct Pass {
    /// Vertices that have had their turn.
    moved: Vec<bool>,
    /// Separator weight lost by moving a vertex of the separator to either side.
    gain: Vec<[i64; 2]>,
    /// Moves to choose from: gain, vertex, side.
    offers: BinaryHeap<(i64, usize, u8)>,
    /// Vertices shifted, and the side they were on.
    log: Vec<(usize, u8)>,
    /// Vertices whose gain has grown by the last move.
    changed: Vec<usize>,
}

impl Pass {
    fn new(n: usize) -> Self {
        let (moved, gain) = (vec![false; n], vec![[0; 2]; n]);
        Self { moved, gain, offers: BinaryHeap::new(), log: vec![], changed: vec![] }
    }

    /// Offers to move a vertex, with the gain of either side.
    fn offer(&mut self, v: usize, gain: [i64; 2]) {
        self.gain[v] = gain;
        self.offers.extend([(gain[0], v, 0), (gain[1], v, 1)]);
    }
}
