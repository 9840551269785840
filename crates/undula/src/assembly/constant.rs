//! Rows of the extension that are the same at all states: they are assembled once.

use super::scatter::DROP;
use crate::space::{Constraints, FsiSpace, PsiOwner};

/// A row of a sparse matrix over the nodes, ascending.
pub(super) type Row = Vec<(u32, f64)>;

/// Rows of a constant operator on u.
#[derive(Clone, Debug, Default)]
pub struct ConstantRows {
    /// Row in `[v, u, p]` and the end of its entries.
    rows: Vec<(u32, u32)>,
    /// Entries: column in `[v, u, p]`, value.
    entries: Vec<(u32, f64)>,
    /// Where the entries go in the Jacobian.
    slots: Vec<u32>,
    n_v: usize,
}

impl ConstantRows {
    /// None yet, behind `n_v` unknowns of v.
    pub fn new(n_v: usize) -> ConstantRows {
        ConstantRows { n_v, ..ConstantRows::default() }
    }

    /// Add a row with its entries, by places in `[v, u, p]`.
    pub fn push(&mut self, row: u32, entries: impl Iterator<Item = (u32, f64)>) {
        self.entries.extend(entries);
        self.rows.push((row, self.entries.len() as u32));
    }

    /// Each row with its entries.
    fn lines(&self) -> impl Iterator<Item = (u32, &[(u32, f64)])> {
        let mut start = 0;
        self.rows.iter().map(move |&(row, end)| {
            let entries = &self.entries[start..end as usize];
            start = end as usize;
            (row, entries)
        })
    }

    /// Call `visit(row, column, value)` for all entries, by places in `[v, u, p]`.
    pub fn visit(&self, visit: &mut dyn FnMut(u32, u32, f64)) {
        for (row, entries) in self.lines() {
            entries.iter().for_each(|&(column, value)| visit(row, column, value));
        }
    }

    /// Add A u to the ψ rows of `out`.
    pub fn residual(&self, u: &[f64], out: &mut [f64]) {
        for (row, entries) in self.lines() {
            out[row as usize] +=
                entries.iter().map(|&(column, value)| value * u[column as usize - self.n_v]).sum::<f64>();
        }
    }

    /// Remember where the entries go; `find` gives [`DROP`] for those of given unknowns.
    pub fn set_slots(&mut self, find: impl Fn(u32, u32) -> u32) {
        let mut slots = Vec::with_capacity(self.entries.len());
        self.visit(&mut |row, column, _| slots.push(find(row, column)));
        self.slots = slots;
    }

    /// Add the entries to those of the Jacobian.
    pub fn jacobian(&self, out: &mut [f64]) {
        for (&slot, &(_, value)) in self.slots.iter().zip(&self.entries).filter(|(slot, _)| **slot != DROP) {
            out[slot as usize] += value;
        }
    }

    /// Add ∂_s² u = 0 along the outlets that move ([`PsiOwner::Outlet`]): differences of neighbours over their distance,
    /// times the largest `stiffness` there, so that the residual has the unit of the others.
    pub fn push_outlets<const D: usize>(
        &mut self,
        space: &FsiSpace<D>,
        constraints: &Constraints<D>,
        stiffness: &dyn Fn(&[f64; D]) -> f64,
    ) {
        let mut rows: Vec<Row> = vec![vec![]; space.nodes.len()];
        let (mut largest, mut length, mut pairs) = (0.0f64, 0.0, 0.0);
        let outlet = |node: u32| space.owner[node as usize] == PsiOwner::Outlet;
        for facet in &space.mesh.facets {
            let nodes = space.facet_nodes(facet);
            for pair in nodes.windows(2).filter(|pair| pair.iter().any(|&node| outlet(node))) {
                let [a, b] = [pair[0], pair[1]];
                let [x, y] = [a, b].map(|node| space.nodes.points[node as usize]);
                let distance = (0..D).map(|d| (x[d] - y[d]).powi(2)).sum::<f64>().sqrt();
                largest = largest.max(stiffness(&x)).max(stiffness(&y));
                (length, pairs) = (length + distance, pairs + 1.0);
                for (node, other) in [(a, b), (b, a)] {
                    rows[node as usize].extend([(node, 1.0 / distance), (other, -1.0 / distance)]);
                }
            }
        }
        let scale = largest * length / pairs;
        for (node, row) in rows.iter_mut().enumerate().filter(|(node, _)| outlet(*node as u32)) {
            merge(row);
            for i in (0..D).filter(|&i| !constraints.u[node][i]) {
                let place = |node: u32| (self.n_v + node as usize * D + i) as u32;
                let entries: Row = row.iter().map(|&(a, value)| (place(a), scale * value)).collect();
                self.push(place(node as u32), entries.into_iter());
            }
        }
    }
}

/// Sort by column and add up what belongs to one.
pub(super) fn merge(row: &mut Row) {
    row.sort_by_key(|&(column, _)| column);
    row.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
}
