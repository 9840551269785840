//! Directions n in which v or u vanishes at a node, in residuals and matrices.
//!
//! With P = I − Σ n nᵀ at such nodes a residual is P r and a matrix P A P + s Σ n nᵀ, s being of the size of its entries:
//! n·δ = 0 for every correction δ, and all vectors keep the components of the axes.

use crate::algebra::{Csr, Pattern, Value};
use crate::loops::scatter::DROP;
use crate::math::Vector;
use crate::space::{Constraints, Directions, FsiSpace};

/// The blocks of a matrix that directions change.
#[derive(Clone, Debug, Default)]
pub struct DirectedBlocks<const D: usize> {
    blocks: Vec<Block<D>>,
}

/// One field at one node.
#[derive(Clone, Debug)]
struct Block<const D: usize> {
    normals: Vec<Vector<f64, D>>,
    /// Row of each component.
    rows: [u32; D],
    /// Places of the entries of the rows, which have the same columns.
    row_entries: Vec<[u32; D]>,
    /// Places of the entries of the columns in all rows.
    column_entries: Vec<[u32; D]>,
    /// Places of the block on the diagonal.
    diagonal: [[u32; D]; D],
}

/// Call `visit` with each field that has directions: its first place in `[v, u, p]` and the node.
fn fields<'a, const D: usize>(
    space: &FsiSpace<D>,
    constraints: &'a Constraints<D>,
    mut visit: impl FnMut(usize, &'a Directions<D>),
) {
    for at in &constraints.directions {
        let node = at.node as usize * D;
        if at.v {
            visit(node, at);
        }
        if at.u && space.deforms {
            visit(space.n_v() + node, at);
        }
    }
}

/// P x at all nodes with directions of a vector `[v, u, p]`.
pub(super) fn project<const D: usize>(space: &FsiSpace<D>, constraints: &Constraints<D>, x: &mut [f64]) {
    fields(space, constraints, |first, at| at.project(&mut x[first..first + D]));
}

impl<const D: usize> DirectedBlocks<D> {
    /// For a matrix in whose rows the unknowns of `[v, u, p]` have the numbers `number`. Its lists of columns get the
    /// entries that projection fills.
    pub(super) fn new(
        space: &FsiSpace<D>,
        constraints: &Constraints<D>,
        number: &[u32],
        lists: &mut [Vec<u32>],
    ) -> DirectedBlocks<D> {
        let mut blocks = vec![];
        fields(space, constraints, |first, at| {
            let rows: [u32; D] = std::array::from_fn(|i| number[first + i]);
            if !rows.contains(&DROP) {
                let (row_entries, column_entries, diagonal) = (vec![], vec![], [[0; D]; D]);
                let normals = at.normals.clone();
                blocks.push(Block { normals, rows, row_entries, column_entries, diagonal });
            }
        });
        if !blocks.is_empty() {
            fill(&blocks, lists);
        }
        DirectedBlocks { blocks }
    }

    /// Remember the places in the finished `pattern`.
    pub(super) fn place(&mut self, pattern: &Pattern) {
        if self.blocks.is_empty() {
            return;
        }
        let mut block_of = vec![DROP; pattern.n];
        for (n, block) in self.blocks.iter().enumerate() {
            block_of[block.rows[0] as usize] = n as u32;
        }
        let at = |row: usize, column: u32| pattern.find(row, column as usize).map_or(DROP, |at| at as u32);
        for block in &mut self.blocks {
            let Block { rows, row_entries, diagonal, .. } = block;
            let columns = pattern.columns(rows[0] as usize).iter().copied();
            *row_entries = columns.map(|column| rows.map(|row| at(row as usize, column))).collect();
            *diagonal = rows.map(|row| rows.map(|column| at(row as usize, column)));
        }
        for row in 0..pattern.n {
            for entry in pattern.row(row) {
                let block = block_of[pattern.column(row, entry) as usize];
                if let Some(block) = self.blocks.get_mut(block as usize) {
                    block.column_entries.push(block.rows.map(|column| at(row, column)));
                }
            }
        }
    }

    /// A ← P A P + s Σ n nᵀ.
    pub(super) fn constrain<T: Value>(&self, matrix: &mut Csr<T>) {
        for Block { normals, row_entries, column_entries, diagonal, .. } in &self.blocks {
            let values = &mut matrix.values;
            for entries in row_entries.iter().chain(column_entries) {
                for n in normals {
                    let along: f64 = (0..D).map(|i| n.0[i] * values[entries[i] as usize].double()).sum();
                    for i in 0..D {
                        let value = &mut values[entries[i] as usize];
                        *value = T::of(value.double() - along * n.0[i]);
                    }
                }
            }
            let size = (0..D).map(|i| values[diagonal[i][i] as usize].double().abs()).fold(0.0, f64::max);
            let size = if size > 0.0 { size } else { 1.0 };
            for n in normals {
                for (i, row) in diagonal.iter().enumerate() {
                    for (j, &at) in row.iter().enumerate() {
                        let value = &mut values[at as usize];
                        *value = T::of(value.double() + size * n.0[i] * n.0[j]);
                    }
                }
            }
        }
    }
}

/// Complete the columns of all rows to whole blocks, and the rows of a block to the same columns.
fn fill<const D: usize>(blocks: &[Block<D>], lists: &mut [Vec<u32>]) {
    let mut block_of = vec![DROP; lists.len()];
    for (n, block) in blocks.iter().enumerate() {
        block.rows.iter().for_each(|&row| block_of[row as usize] = n as u32);
    }
    for list in lists.iter_mut() {
        let seen: Vec<u32> =
            list.iter().map(|&column| block_of[column as usize]).filter(|&block| block != DROP).collect();
        list.extend(seen.into_iter().flat_map(|block| blocks[block as usize].rows));
    }
    for block in blocks {
        let mut all: Vec<u32> = block.rows.iter().flat_map(|&row| lists[row as usize].clone()).collect();
        all.extend(block.rows);
        all.sort_unstable();
        all.dedup();
        block.rows.iter().for_each(|&row| lists[row as usize].clone_from(&all));
    }
}
