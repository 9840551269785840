//! Order of elimination of the mesh nodes.
//!
//! Nested dissection finds separators; which of them are left to the end, and where dissection stops,
//! is tried: everything is ordered by minimum degree, the chosen separators last (multisection, Ashcraft
//! and Liu 1998), and the order with the cheapest fronts is taken.

mod coarsening;
mod cut;
mod degree;
mod dissection;
mod pressures;
mod separator;
#[cfg(test)]
mod tests;

use super::graph::{Graph, Role};
use super::tree::{Group, Price, grow};
use degree::minimum_degree;
use dissection::dissect;
use pressures::with_pressures;
use rayon::prelude::*;

/// Sizes of parts, in vertices, whose separators are the last to be eliminated; those of smaller parts are
/// ordered with the rest.
const PARTS: [usize; 6] = [200, 400, 800, 1600, 3200, usize::MAX];

/// Fronts of an order of elimination in which they are cheap at this price, children before parents.
pub(super) fn fronts(graph: &Graph, price: Price) -> Vec<Group> {
    let (core, numbers) = core(graph);
    let separated = dissect(&core, PARTS[0]);
    // Thresholds that leave the same separators give the same order.
    let mut choices: Vec<Vec<bool>> =
        PARTS.iter().map(|&size| separated.iter().map(|&part| part > size).collect()).collect();
    choices.dedup();
    let candidate = |late: Vec<bool>| {
        let order = minimum_degree(&core, &late);
        let order: Vec<u32> = order.into_iter().map(|v| numbers[v as usize]).collect();
        let groups = grow(graph, &with_pressures(graph, &order), price);
        (groups.iter().map(|group| price.of(group.k, group.r)).sum::<f64>(), groups)
    };
    let candidates: Vec<(f64, Vec<Group>)> = choices.into_par_iter().map(candidate).collect();
    candidates.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1).unwrap_or_default()
}

/// The graph of the free vertices, in which those of a pressure become neighbours of each other, and the
/// numbers of its vertices in the whole one.
fn core(graph: &Graph) -> (Graph, Vec<u32>) {
    let numbers: Vec<u32> = (0..graph.n() as u32).filter(|&v| graph.role[v as usize] == Role::Free).collect();
    let core = graph.restricted_to(&numbers, |v, around| {
        for &w in graph.neighbours(v as usize) {
            around.push(w);
            if graph.role[w as usize] != Role::Free {
                around.extend_from_slice(graph.neighbours(w as usize));
            }
        }
    });
    (core, numbers)
}
