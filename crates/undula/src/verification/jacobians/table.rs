//! The report as text.

use super::{Block, Comparison, JacobianReport};
use crate::math::{rounded, shortest};
use std::fmt::{self, Display, Formatter};

impl Display for JacobianReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let step = match self.rule.per_k {
            per_k if per_k > 0.0 => {
                let k = shortest(rounded(1.0 / per_k, 1.0 / per_k, 5));
                format!("k = {k} s, theta = {:.4}", self.rule.theta)
            }
            _ => "stationary".into(),
        };
        writeln!(f, "{}: Jacobians at {} ({step}, min J {:.3}),", self.case, self.state, self.min_j)?;
        writeln!(
            f,
            "{} unknowns; deviations relative to the largest entry of a row in its block\n",
            self.unknowns
        )?;
        writeln!(f, "{:30} {:>9} {:>9}", "against automatic", "worst", "allowed")?;
        for comparison in &self.comparisons {
            write_comparison(f, comparison)?;
        }
        let columns: Vec<_> = self.comparisons.iter().map(|c| (short(&c.name), &c.blocks[..])).collect();
        write_blocks(f, "worst by block", &columns)?;
        let columns: Vec<_> = self.left_out.iter().map(|l| (l.name.clone(), &l.blocks[..])).collect();
        write_blocks(f, "left out", &columns)?;
        let verdict = if self.agrees() { "all Jacobians agree" } else { "the Jacobians do NOT agree" };
        writeln!(f, "\n{verdict}")
    }
}

fn write_comparison(f: &mut Formatter<'_>, comparison: &Comparison) -> fmt::Result {
    let Comparison { name, tolerance, worst, .. } = comparison;
    let Some(worst) = worst else { return writeln!(f, "{name:30} no entries") };
    let mark = if comparison.agrees() { "" } else { "  TOO MUCH" };
    writeln!(f, "{name:30} {:9.1e} {tolerance:9.0e}{mark}", worst.deviation)?;
    let (equation, field) = worst.block;
    writeln!(f, "    {equation} x {field}: row of {}, column of {}", worst.row, worst.column)?;
    writeln!(f, "    {:.9e}, automatic {:.9e}", worst.found, worst.expected)
}

/// `whole residual, central` as the head of a column.
fn short(name: &str) -> String {
    let name = name.replace("finite-difference, nodal", "nodal");
    name.replace("finite-difference", "points").replace("whole residual", "residual").replace(", ", " ")
}

/// A line per block, a column per matrix; blocks that are not there are left empty.
fn write_blocks(f: &mut Formatter<'_>, title: &str, columns: &[(String, &[(Block, f64)])]) -> fmt::Result {
    let mut blocks: Vec<Block> =
        columns.iter().flat_map(|(_, list)| list.iter().map(|(block, _)| *block)).collect();
    blocks.sort_unstable();
    blocks.dedup();
    write!(f, "\n{title:14}")?;
    for (name, _) in columns {
        write!(f, " {name:>18}")?;
    }
    writeln!(f)?;
    for block in blocks {
        write!(f, "{:14}", format!("{} x {}", block.0, block.1))?;
        for (_, list) in columns {
            match list.iter().find(|(other, _)| *other == block) {
                Some((_, deviation)) => write!(f, " {deviation:18.1e}")?,
                None => write!(f, " {:>18}", "")?,
            }
        }
        writeln!(f)?;
    }
    Ok(())
}
