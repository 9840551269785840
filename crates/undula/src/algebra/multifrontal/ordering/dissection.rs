//! Nested dissection.

use super::super::graph::Graph;
use super::cut::MIDDLE;
use super::separator::separate;

/// Cuts the graph into two parts, these again, and so on while they have more than `smallest` vertices.
/// Returns for every vertex the size, in vertices, of the part that it separates, 0 if it separates none.
pub(super) fn dissect(graph: &Graph, smallest: usize) -> Vec<usize> {
    let mut separated = vec![0; graph.n()];
    for (v, size) in separators(graph, smallest) {
        separated[v as usize] = size;
    }
    separated
}

/// Vertices of separators and the sizes of the parts they separate.
fn separators(graph: &Graph, smallest: usize) -> Vec<(u32, usize)> {
    if graph.n() <= smallest {
        return vec![];
    }
    let side = separate(graph);
    let middle = side.iter().enumerate().filter(|(_, s)| **s == MIDDLE);
    let mut all: Vec<(u32, usize)> = middle.map(|(v, _)| (v as u32, graph.n())).collect();
    if all.len() == graph.n() {
        // Everybody is everybody's neighbour.
        return all;
    }
    let inside = |s: u8| {
        let (part, numbers) = part(graph, &side, s);
        let whole = |(v, size): (u32, usize)| (numbers[v as usize], size);
        separators(&part, smallest).into_iter().map(whole).collect::<Vec<_>>()
    };
    let (below, above) = rayon::join(|| inside(0), || inside(1));
    all.extend(below);
    all.extend(above);
    all
}

/// The graph of one side, and the numbers of its vertices in the whole one.
fn part(graph: &Graph, side: &[u8], s: u8) -> (Graph, Vec<u32>) {
    let numbers: Vec<u32> = (0..graph.n() as u32).filter(|&v| side[v as usize] == s).collect();
    (graph.restricted_to(&numbers, |v, out| out.extend_from_slice(graph.neighbours(v as usize))), numbers)
}
