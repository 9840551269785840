//! The Jacobian by differences of residuals, as many columns at a time as meet in no row.

use crate::algebra::{Csr, Pattern};
use crate::physics::StepRule;
use crate::space::State;
use crate::system::{Assembler, Borders, Matrix, StepView};

/// Columns of a pattern in groups, and what is needed to difference them.
pub struct Differences {
    /// Columns that are differenced together; those of given unknowns are in none.
    groups: Vec<Vec<u32>>,
    columns: Columns,
    /// Places of the ones of given rows.
    given: Vec<usize>,
    plus: Vec<f64>,
    minus: Vec<f64>,
    direction: Vec<f64>,
}

/// The entries of a pattern by columns.
struct Columns {
    start: Vec<usize>,
    /// Row and place among the values.
    entries: Vec<(u32, u32)>,
}

impl Columns {
    fn new(pattern: &Pattern) -> Columns {
        let mut start = vec![0; pattern.n + 1];
        pattern.all_columns().for_each(|col| start[col as usize + 1] += 1);
        for col in 0..pattern.n {
            start[col + 1] += start[col];
        }
        let (mut next, mut entries) = (start.clone(), vec![(0, 0); pattern.nnz()]);
        for row in 0..pattern.n {
            for place in pattern.row(row) {
                let at = &mut next[pattern.column(row, place) as usize];
                entries[*at] = (row as u32, place as u32);
                *at += 1;
            }
        }
        Columns { start, entries }
    }

    fn of(&self, col: usize) -> &[(u32, u32)] {
        &self.entries[self.start[col]..self.start[col + 1]]
    }
}

impl Differences {
    /// For the Jacobian of `assembler`.
    pub fn new<const D: usize>(assembler: &mut Assembler<D>) -> Differences {
        let pattern = assembler.pattern();
        let columns = Columns::new(&pattern);
        let is_given = assembler.is_given();
        let given: Vec<usize> =
            (0..pattern.n).filter(|&i| is_given[i]).filter_map(|i| pattern.find(i, i)).collect();
        let groups = colour(&pattern, &columns, |col| !is_given[col]);
        let zeros = || vec![0.0; assembler.n_unknowns()];
        Differences { groups, columns, given, plus: zeros(), minus: zeros(), direction: zeros() }
    }

    /// Residuals that a Jacobian by central differences takes.
    pub fn residuals(&self) -> usize {
        2 * self.groups.len()
    }

    /// Differences at `new`, whose unknowns are moved by the entries of `h`, forth and with `central` back.
    pub fn jacobian<const D: usize>(
        &mut self,
        assembler: &mut Assembler<D>,
        rule: StepRule,
        (new, old): (&mut State, &State),
        (h, central): (&[f64], bool),
        out: &mut Csr,
    ) {
        out.values.fill(0.0);
        self.given.iter().for_each(|&place| out.values[place] = 1.0);
        let back = if central { -1.0 } else { 0.0 };
        // Couplings that are in no matrix are taken out of the differences.
        let mut borders = Borders::default();
        assembler.borders(Matrix::Whole, &StepView { rule, new, old }, &mut borders);
        for group in &self.groups {
            self.direction.fill(0.0);
            group.iter().for_each(|&col| self.direction[col as usize] = h[col as usize]);
            for (move_by, r) in [(1.0, &mut self.plus), (back - 1.0, &mut self.minus)] {
                new.add_scaled(move_by, &self.direction);
                r.fill(0.0);
                assembler.residual(&StepView { rule, new, old }, r);
            }
            new.add_scaled(-back, &self.direction);
            for border in borders.iter().filter(|border| border.scalar.is_none()) {
                border.add_column(-(1.0 - back) * border.product(&self.direction), &mut self.plus);
            }
            for &col in group {
                let scale = 1.0 / ((1.0 - back) * h[col as usize]);
                for &(row, place) in self.columns.of(col as usize) {
                    let (row, place) = (row as usize, place as usize);
                    out.values[place] = scale * (self.plus[row] - self.minus[row]);
                }
            }
        }
        assembler.constrain(out);
    }
}

/// The columns where `wanted` holds, each in the first group with none of which it shares a row.
fn colour(pattern: &Pattern, columns: &Columns, wanted: impl Fn(usize) -> bool) -> Vec<Vec<u32>> {
    const NONE: u32 = u32::MAX;
    let (mut of, mut groups) = (vec![NONE; pattern.n], Vec::<Vec<u32>>::new());
    // The column that met each group last.
    let mut met = vec![];
    for col in (0..pattern.n).filter(|&col| wanted(col)) {
        for &(row, _) in columns.of(col) {
            for place in pattern.row(row as usize) {
                if let Some(met) = met.get_mut(of[pattern.column(row as usize, place) as usize] as usize) {
                    *met = col;
                }
            }
        }
        let group = met.iter().position(|&last| last != col).unwrap_or(groups.len());
        if group == groups.len() {
            groups.push(vec![]);
            met.push(usize::MAX);
        }
        groups[group].push(col as u32);
        of[col] = group as u32;
    }
    groups
}

/// Largest difference of two matrices of one pattern, relative to the largest entry of the row of `a`.
pub fn deviation(a: &Csr, b: &Csr) -> f64 {
    let pattern = &a.pattern;
    let of_row = |row: usize| {
        let places = || pattern.row(row);
        let size = places().map(|i| a.values[i].abs()).fold(f64::MIN_POSITIVE, f64::max);
        places().map(|i| (a.values[i] - b.values[i]).abs()).fold(0.0, f64::max) / size
    };
    (0..pattern.n).map(of_row).fold(0.0, f64::max)
}
