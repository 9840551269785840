//! Elimination tree of the ordered vertices, and fronts grown from it.

use super::graph::Graph;

/// No parent.
pub(super) const NONE: u32 = u32::MAX;

/// Vertices eliminated together, and where their contribution goes.
#[derive(Debug, Default)]
pub(super) struct Group {
    /// Vertices, in the order of elimination.
    pub vertices: Vec<u32>,
    /// Groups that contribute to this one.
    pub children: Vec<u32>,
    /// Number of unknowns eliminated.
    pub k: usize,
    /// Number of unknowns they leave behind, coupled.
    pub r: usize,
}

/// Time of a front as a multiple of that of a multiplication with addition: what is done per front,
/// per entry of the front (assembly, memory) and per operation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Price {
    pub front: f64,
    pub entry: f64,
}

impl Price {
    /// Time of a front with `k` pivots and `r` rows behind.
    pub fn of(self, k: usize, r: usize) -> f64 {
        let m = (k + r) as f64;
        self.front + self.entry * m * m + 0.5 * flops(k, r)
    }
}

/// Floating point operations of a front with `k` pivots and `r` rows below.
pub(super) fn flops(k: usize, r: usize) -> f64 {
    let (k, r) = (k as f64, r as f64);
    2.0 / 3.0 * k * k * k + 2.0 * k * k * r + 2.0 * k * r * r
}

/// Fronts of the ordered graph, children before parents: starting with a front for every vertex,
/// children are merged into their parent where that saves time at the given price.
pub(super) fn grow(graph: &Graph, order: &[u32], price: Price) -> Vec<Group> {
    let n = order.len();
    let mut place = vec![0; n];
    for (i, &v) in order.iter().enumerate() {
        place[v as usize] = i as u32;
    }
    let parent = elimination_tree(graph, order, &place);
    let below = weights_below(graph, order, &place, &parent);
    let mut groups: Vec<Group> = order
        .iter()
        .zip(&below)
        .map(|(&v, &r)| Group {
            vertices: vec![v],
            children: vec![],
            k: graph.weight[v as usize] as usize,
            r,
        })
        .collect();
    for i in 0..n {
        merge_children(&mut groups, i, price);
        if parent[i] != NONE {
            groups[parent[i] as usize].children.push(i as u32);
        }
    }
    for group in &mut groups {
        group.vertices.sort_unstable_by_key(|&v| place[v as usize]);
    }
    postorder(groups)
}

/// Parent of each place in the order (Liu, with path compression).
fn elimination_tree(graph: &Graph, order: &[u32], place: &[u32]) -> Vec<u32> {
    let mut parent = vec![NONE; order.len()];
    let mut ancestor = vec![NONE; order.len()];
    for (j, &v) in order.iter().enumerate() {
        for &w in graph.neighbours(v as usize) {
            let mut i = place[w as usize] as usize;
            while i < j {
                let next = std::mem::replace(&mut ancestor[i], j as u32);
                if next == NONE {
                    parent[i] = j as u32;
                    break;
                }
                if next as usize == j {
                    break;
                }
                i = next as usize;
            }
        }
    }
    parent
}

/// Weight of the factor's rows below each place.
fn weights_below(graph: &Graph, order: &[u32], place: &[u32], parent: &[u32]) -> Vec<usize> {
    let mut below = vec![0; order.len()];
    let mut seen = vec![usize::MAX; order.len()];
    for (j, &v) in order.iter().enumerate() {
        seen[j] = j;
        for &w in graph.neighbours(v as usize) {
            let mut i = place[w as usize] as usize;
            while i < j && seen[i] != j {
                seen[i] = j;
                below[i] += graph.weight[v as usize] as usize;
                i = parent[i] as usize;
            }
        }
    }
    below
}

/// Merges into group `i` those of its children for which it pays, and then their children in turn.
fn merge_children(groups: &mut [Group], i: usize, price: Price) {
    loop {
        let (k, r) = (groups[i].k, groups[i].r);
        let saving = |c: usize| {
            let child = &groups[c];
            price.of(child.k, child.r) + price.of(k, r) - price.of(child.k + k, r)
        };
        let best = (0..groups[i].children.len())
            .map(|at| (saving(groups[i].children[at] as usize), at))
            .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((saved, at)) = best.filter(|b| b.0 > 0.0) else { return };
        debug_assert!(saved > 0.0);
        let child = groups[i].children.remove(at) as usize;
        let Group { vertices, children, k, .. } = std::mem::take(&mut groups[child]);
        groups[i].vertices.extend(vertices);
        groups[i].children.extend(children);
        groups[i].k += k;
    }
}

/// The groups that are left, children before parents and each subtree in one piece; among children,
/// those that need the most memory beyond what they leave come first.
fn postorder(mut groups: Vec<Group>) -> Vec<Group> {
    let n = groups.len();
    // Peak of the contributions waiting while a subtree is worked on.
    let mut peak = vec![0_usize; n];
    let mut is_child = vec![false; n];
    for i in 0..n {
        let mut children = std::mem::take(&mut groups[i].children);
        let left = |c: u32| groups[c as usize].r.pow(2);
        children.sort_by_key(|&c| (std::cmp::Reverse(peak[c as usize] - left(c)), c));
        let (mut waiting, mut most) = (0, 0);
        for &c in &children {
            is_child[c as usize] = true;
            most = most.max(waiting + peak[c as usize]);
            waiting += left(c);
        }
        peak[i] = most.max(waiting + (groups[i].k + groups[i].r).pow(2));
        groups[i].children = children;
    }
    let roots = (0..n).filter(|&i| groups[i].k > 0 && !is_child[i]);
    let mut stack: Vec<(usize, bool)> = roots.map(|i| (i, false)).collect();
    stack.reverse();
    let (mut out, mut number) = (Vec::new(), vec![0; n]);
    while let Some((i, children_done)) = stack.pop() {
        if children_done {
            number[i] = out.len() as u32;
            let mut group = std::mem::take(&mut groups[i]);
            for c in &mut group.children {
                *c = number[*c as usize];
            }
            out.push(group);
        } else {
            stack.push((i, true));
            stack.extend(groups[i].children.iter().rev().map(|&c| (c as usize, false)));
        }
    }
    out
}
