//! The best of several vertex separators: cuts across coordinates and distances in the graph itself, and
//! the same in coarse graphs, improved on the way back (Hendrickson and Rothberg 1998).

use super::super::graph::Graph;
use super::coarsening::Coarse;
use super::cut::Cut;

/// Number of sequences of coarse graphs.
const SEQUENCES: u32 = 2;

/// Graphs of more vertices are made coarser.
const COARSEST: usize = 50;

/// Side of each vertex: 0, 1 or [`MIDDLE`](super::cut::MIDDLE), with no edge between 0 and 1.
pub(super) fn separate(graph: &Graph) -> Vec<u8> {
    let through_levels = (0..SEQUENCES).filter_map(|sequence| cut_by_levels(graph, sequence));
    through_levels.fold(cut(graph), better).side
}

fn better(a: Cut, b: Cut) -> Cut {
    if b.cost() < a.cost() { b } else { a }
}

/// The best cut across the graph, improved.
fn cut(graph: &Graph) -> Cut {
    let [first, others @ ..] = keys(graph).map(|keys| Cut::at_median(graph, &keys));
    let mut best = others.into_iter().fold(first, better);
    best.improve(graph);
    best
}

/// The best cut of a coarse graph, improved in each graph on the way back to the finest.
fn cut_by_levels(graph: &Graph, sequence: u32) -> Option<Cut> {
    let mut levels: Vec<Coarse> = Vec::new();
    loop {
        let (finer, edges) = levels.last().map_or((graph, None), |c| (&c.graph, Some(&c.edges[..])));
        if finer.n() <= COARSEST {
            break;
        }
        let coarse = Coarse::of(finer, edges, graph.total() / COARSEST as u64, sequence);
        if 20 * coarse.graph.n() > 19 * finer.n() {
            break;
        }
        levels.push(coarse);
    }
    let mut cut = cut(&levels.last()?.graph);
    for (i, level) in levels.iter().enumerate().rev() {
        let fine = if i == 0 { graph } else { &levels[i - 1].graph };
        cut = Cut::of(fine, level.parent.iter().map(|&c| cut.side[c as usize]).collect());
        cut.improve(fine);
    }
    Some(cut)
}

/// Numbers for each vertex that can be cut at their median: coordinates along axes, diagonals in the plane
/// and the axis of largest inertia, distances in edges from two ends of the graph, and their difference.
fn keys(graph: &Graph) -> [Vec<f64>; 9] {
    let along = |d: [f64; 3]| graph.at.iter().map(|x| d[0] * x[0] + d[1] * x[1] + d[2] * x[2]).collect();
    let one = distances(graph, farthest(&distances(graph, 0)));
    let other = distances(graph, farthest(&one));
    let difference = one.iter().zip(&other).map(|(a, b)| a - b).collect();
    [
        along(longest_axis(graph)),
        along([1.0, 0.0, 0.0]),
        along([0.0, 1.0, 0.0]),
        along([0.0, 0.0, 1.0]),
        along([0.7, 0.7, 0.0]),
        along([0.7, -0.7, 0.0]),
        difference,
        one,
        other,
    ]
}

/// Axis of largest inertia.
fn longest_axis(graph: &Graph) -> [f64; 3] {
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
    axis
}

/// Distance of each vertex from one of them, in edges; that of the farthest where there is no way.
fn distances(graph: &Graph, from: usize) -> Vec<f64> {
    let mut distance = vec![f64::INFINITY; graph.n()];
    let mut reached = Vec::with_capacity(graph.n());
    distance[from] = 0.0;
    reached.push(from);
    let (mut next, mut most) = (0, 0.0);
    while let Some(&v) = reached.get(next) {
        next += 1;
        most = distance[v];
        for &w in graph.neighbours(v) {
            if distance[w as usize] == f64::INFINITY {
                distance[w as usize] = most + 1.0;
                reached.push(w as usize);
            }
        }
    }
    distance.iter_mut().for_each(|d| *d = d.min(most));
    distance
}

/// The first of the vertices that are farthest.
fn farthest(distances: &[f64]) -> usize {
    let at = (0..distances.len()).max_by(|&a, &b| distances[a].total_cmp(&distances[b]).then(b.cmp(&a)));
    at.unwrap_or(0)
}
