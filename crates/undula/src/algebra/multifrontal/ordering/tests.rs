use super::super::graph::{Graph, Role};
use super::super::tree::{Group, Price, flops, grow};
use super::cut::MIDDLE;
use super::degree::minimum_degree;
use super::dissection::dissect;
use super::pressures::with_pressures;
use super::separator::separate;
use super::{core, fronts};
use std::collections::BTreeSet;

const PRICE: Price = Price { front: 100.0, entry: 2.0 };

fn graph(n: usize, edges: impl IntoIterator<Item = (usize, usize)>) -> Graph {
    let mut around = vec![BTreeSet::new(); n];
    for (v, w) in edges.into_iter().filter(|(v, w)| v != w) {
        around[v].insert(w as u32);
        around[w].insert(v as u32);
    }
    let mut graph = Graph { ptr: vec![0], weight: vec![2; n], at: vec![[0.0; 3]; n], ..Graph::default() };
    graph.role = vec![Role::Free; n];
    for list in around {
        graph.adj.extend(list);
        graph.ptr.push(graph.adj.len());
    }
    graph
}

/// Vertices of n × m squares, neighbours if they are of one square.
fn grid(n: usize, m: usize) -> Graph {
    let steps = [(0, 1), (1, 0), (1, 1), (1, -1)];
    let inside = move |i: usize, j: usize| {
        let to = steps.map(|(a, b)| (i + a, j.wrapping_add_signed(b)));
        to.into_iter()
            .filter(move |&(k, l)| k <= n && l <= m)
            .map(move |(k, l)| (i * (m + 1) + j, k * (m + 1) + l))
    };
    let all = (0..=n).flat_map(|i| (0..=m).map(move |j| (i, j)));
    let mut graph = graph((n + 1) * (m + 1), all.flat_map(|(i, j)| inside(i, j)));
    for (v, at) in graph.at.iter_mut().enumerate() {
        *at = [(v / (m + 1)) as f64, (v % (m + 1)) as f64, 0.0];
    }
    graph
}

/// Parents by chance.
fn tree(n: usize) -> Graph {
    graph(n, (1..n).map(|v| (v, (v * 7919 + 13) % 104_729 % v)))
}

/// Nodes of n × m cells of degree two, those inside of the cells left out, and a pressure for every cell.
fn flow(n: usize, m: usize) -> Graph {
    let width = 2 * m + 1;
    let number = |i: usize, j: usize| i * width + j;
    let n_nodes = (2 * n + 1) * width;
    let mut edges = Vec::new();
    for cell in 0..n * m {
        let (i, j) = (2 * (cell / m), 2 * (cell % m));
        let nodes = (0..9).filter(|k| *k != 4).map(|k| number(i + k / 3, j + k % 3));
        let all: Vec<usize> = nodes.chain([n_nodes + cell]).collect();
        edges.extend(all.iter().flat_map(|&v| all.iter().map(move |&w| (v, w))));
    }
    let mut graph = graph(n_nodes + n * m, edges);
    graph.role[n_nodes..].fill(Role::Mean);
    graph.weight[n_nodes..].fill(1);
    for (v, at) in graph.at.iter_mut().enumerate().take(n_nodes) {
        *at = [(v / width) as f64, (v % width) as f64, 0.0];
    }
    graph
}

fn assert_permutation(order: &[u32], n: usize) {
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    assert!(sorted.into_iter().eq(0..n as u32));
}

/// Edges that elimination in this order adds.
fn fill(graph: &Graph, order: &[u32]) -> usize {
    let mut around: Vec<BTreeSet<u32>> =
        (0..graph.n()).map(|v| graph.neighbours(v).iter().copied().collect()).collect();
    let mut added = 0;
    for &v in order {
        let left = std::mem::take(&mut around[v as usize]);
        for &w in &left {
            around[w as usize].remove(&v);
            for &x in left.iter().filter(|&&x| x != w) {
                added += usize::from(around[w as usize].insert(x));
            }
        }
    }
    added / 2
}

#[test]
fn every_graph_is_ordered() {
    let cliques = (0..300).flat_map(|v| (0..300).map(move |w| (v, w)));
    let apart = (0..1000).map(|v| (v, (v + 3) % 999));
    let chance = (0..2000).map(|v| (v % 700, v * v % 691));
    let graphs = [
        graph(0, []),
        graph(1, []),
        graph(500, []),
        graph(300, cliques),
        graph(1000, apart),
        graph(700, chance),
        tree(900),
        grid(40, 23),
        flow(20, 13),
    ];
    for graph in graphs {
        let order: Vec<u32> = fronts(&graph, PRICE).into_iter().flat_map(|front| front.vertices).collect();
        assert_permutation(&order, graph.n());
    }
}

#[test]
fn minimum_degree_of_trees_has_no_fill() {
    let tree = tree(500);
    let order = minimum_degree(&tree, &[false; 500]);
    assert_permutation(&order, 500);
    assert_eq!(fill(&tree, &order), 0);
}

#[test]
fn late_vertices_come_last() {
    let grid = grid(12, 9);
    let late: Vec<bool> = (0..grid.n()).map(|v| v % 7 == 0).collect();
    let order = minimum_degree(&grid, &late);
    assert_permutation(&order, grid.n());
    assert!(order.is_sorted_by_key(|&v| late[v as usize]));
}

#[test]
fn separators_separate() {
    for (graph, most) in [(grid(40, 40), 41), (grid(120, 11), 12), (flow(15, 15), 61), (tree(400), 3)] {
        let side = separate(&graph);
        let total = |s: u8| (0..graph.n()).filter(|&v| side[v] == s).count();
        for v in (0..graph.n()).filter(|&v| side[v] != MIDDLE) {
            assert!(
                graph
                    .neighbours(v)
                    .iter()
                    .all(|&w| side[w as usize] == side[v] || side[w as usize] == MIDDLE)
            );
        }
        assert!(total(MIDDLE) <= most, "{} of {}", total(MIDDLE), graph.n());
        assert!(total(0).max(total(1)) <= graph.n() * 3 / 4);
    }
}

/// Parts of a grid, halved again and again, and the lines between them.
#[test]
fn dissection_ends_with_small_parts() {
    let grid = grid(63, 63);
    let size = dissect(&grid, 300);
    let separators = size.iter().filter(|&&s| s > 0).count();
    assert_eq!(size.iter().filter(|&&s| s == grid.n()).count(), 64);
    assert!((300..450).contains(&separators), "{separators}");
    let inside: Vec<usize> = (0..grid.n()).filter(|&v| size[v] == 0).collect();
    let mut part = vec![0; grid.n()];
    for &v in &inside {
        let (mut reached, mut next) = (vec![v], 0);
        while let Some(&v) = reached.get(next) {
            next += 1;
            if std::mem::replace(&mut part[v], 1) == 0 {
                reached.extend(grid.neighbours(v).iter().map(|&w| w as usize).filter(|&w| size[w] == 0));
            }
        }
        assert!(reached.iter().collect::<BTreeSet<_>>().len() <= 300);
    }
}

/// Of the pressures on cells that eliminated velocities connect, all but one are eliminated.
#[test]
fn one_pressure_of_a_patch_is_left() {
    let graph = flow(9, 7);
    let free: Vec<u32> = (0..graph.n() as u32).filter(|&v| graph.role[v as usize] == Role::Free).collect();
    let scattered: Vec<u32> = (0..free.len()).map(|k| free[k * 101 % free.len()]).collect();
    let order = with_pressures(&graph, &scattered);
    assert_permutation(&order, graph.n());
    let is_cell = |v: u32| graph.role[v as usize] == Role::Mean;
    let cells =
        |v: u32| graph.neighbours(v as usize).iter().copied().filter(|&w| is_cell(w)).collect::<Vec<_>>();
    for end in (1..order.len()).filter(|&end| !is_cell(order[end])) {
        let (gone, left) = order.split_at(end);
        let mut patch: Vec<usize> = (0..graph.n()).collect();
        for pair in gone.iter().map(|&v| cells(v)).filter(|c| c.len() == 2) {
            let [from, to] = [0, 1].map(|k| patch[pair[k] as usize]);
            patch.iter_mut().filter(|p| **p == from).for_each(|p| *p = to);
        }
        let of = |v: &u32| is_cell(*v).then(|| patch[*v as usize]);
        let patches: BTreeSet<usize> = order.iter().filter_map(of).collect();
        let waiting: Vec<usize> = left.iter().filter_map(of).collect();
        assert_eq!(waiting.len(), patches.len());
        assert_eq!(waiting.into_iter().collect::<BTreeSet<_>>(), patches);
    }
}

/// Operations and entries of factors of a square of Q1 and of a channel of Q2 cells, against minimum degree alone.
#[test]
fn separators_make_fronts_small() {
    for (graph, most) in [(grid(150, 150), [0.62, 0.86]), (flow(120, 30), [0.82, 0.97])] {
        let cost = |groups: Vec<Group>| {
            let operations: f64 = groups.iter().map(|g| flops(g.k, g.r)).sum();
            [operations, groups.iter().map(|g| (g.k * (g.k + 2 * g.r)) as f64).sum()]
        };
        let free: Vec<u32> =
            (0..graph.n() as u32).filter(|&v| graph.role[v as usize] == Role::Free).collect();
        let (core, _) = core(&graph);
        let alone: Vec<u32> =
            minimum_degree(&core, &vec![false; core.n()]).into_iter().map(|v| free[v as usize]).collect();
        let alone = grow(&graph, &with_pressures(&graph, &alone), PRICE);
        let (ours, alone) = (cost(fronts(&graph, PRICE)), cost(alone));
        assert!(ours[0] < most[0] * alone[0], "{} of {}", ours[0], alone[0]);
        assert!(ours[1] < most[1] * alone[1], "{} of {}", ours[1], alone[1]);
    }
}
