//! Entries of a Jacobian by equation and field.

use super::Comparison;
use crate::algebra::Csr;
use crate::math::{rounded, shortest};
use crate::space::{FsiSpace, PsiOwner, Region};
use std::fmt;

/// A row of blocks: which equation is tested, (5.35).
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Equation {
    /// Momentum of the fluid, off the interface.
    NavierStokes,
    /// Momentum of both at nodes of the interface.
    Interface,
    /// Momentum of the solid, off the interface.
    Elasticity,
    /// Divergence.
    Divergence,
    /// Extension.
    Ale,
    /// Velocity-deformation relation.
    Relation,
}

/// A column of blocks.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Field {
    /// Velocity.
    V,
    /// Deformation.
    U,
    /// Pressure.
    P,
}

/// One block of the Jacobian.
pub type Block = (Equation, Field);

impl fmt::Display for Equation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Equation::NavierStokes => "NS",
            Equation::Interface => "NS+ES",
            Equation::Elasticity => "ES",
            Equation::Divergence => "div",
            Equation::Ale => "ALE",
            Equation::Relation => "uv",
        })
    }
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Field::V => "v",
            Field::U => "u",
            Field::P => "p",
        })
    }
}

/// An unknown with its place.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Unknown {
    /// Number among all unknowns, v, u, p.
    pub index: usize,
    /// Its field.
    pub field: Field,
    /// 0: x, 1: y, 2: z; 0 for a pressure.
    pub component: usize,
    /// Where its node is, or the cell of a pressure \[m\]; in the plane without the last.
    pub position: [f64; 3],
    /// Number of coordinates.
    pub dim: usize,
}

impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let component = match self.field {
            Field::P => "",
            _ => ["_x", "_y", "_z"][self.component],
        };
        let position = &self.position[..self.dim];
        let size = position.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
        let shown: Vec<String> = position.iter().map(|x| shortest(rounded(*x, size, 6))).collect();
        write!(f, "{}{component} at ({})", self.field, shown.join(", "))
    }
}

/// An entry in which two matrices differ.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its block.
    pub block: Block,
    /// The unknown whose test function makes the row.
    pub row: Unknown,
    /// The unknown that moves.
    pub column: Unknown,
    /// By automatic differentiation.
    pub expected: f64,
    /// In the other matrix.
    pub found: f64,
    /// Their difference, relative to the largest entry of the row in the block.
    pub deviation: f64,
}

/// Rows much smaller than their block count as this part of it.
const SMALL: f64 = 1e-6;

/// Every row and column with its equation and field, and the size of every row in each field.
pub(super) struct Blocks {
    unknowns: Vec<Unknown>,
    equations: Vec<Equation>,
    given: Vec<bool>,
    sizes: Vec<[f64; 3]>,
}

impl Blocks {
    /// Of the Jacobian `exact`; with which unknowns are given.
    pub(super) fn new<const D: usize>(space: &FsiSpace<D>, exact: &Csr, given: Vec<bool>) -> Blocks {
        let unknowns = unknowns(space);
        let equations = equations(space);
        let mut sizes = vec![[0.0f64; 3]; unknowns.len()];
        let mut largest = [[0.0f64; 3]; 6];
        for (row, sizes) in sizes.iter_mut().enumerate().filter(|(row, _)| !given[*row]) {
            for at in exact.pattern.row(row) {
                let field = unknowns[exact.pattern.column(row, at) as usize].field as usize;
                sizes[field] = sizes[field].max(exact.values[at].abs());
                let block = &mut largest[equations[row] as usize][field];
                *block = block.max(exact.values[at].abs());
            }
        }
        for (sizes, equation) in sizes.iter_mut().zip(&equations) {
            for (size, block) in sizes.iter_mut().zip(largest[*equation as usize]) {
                *size = size.max(SMALL * block);
            }
        }
        Blocks { unknowns, equations, given, sizes }
    }

    /// `other` beside `exact`. With `noise`, what rounding explains of a row of the residual, and the perturbation
    /// of each column, that much is forgiven.
    pub(super) fn compare(
        &self,
        name: &str,
        tolerance: f64,
        exact: &Csr,
        other: &Csr,
        noise: Option<(&[f64], &[f64])>,
    ) -> Comparison {
        let mut worst: Option<Entry> = None;
        let mut blocks: Vec<(Block, f64)> = vec![];
        for row in (0..self.unknowns.len()).filter(|&row| !self.given[row]) {
            for at in exact.pattern.row(row) {
                let column = exact.pattern.column(row, at) as usize;
                let field = self.unknowns[column].field;
                let (a, b) = (exact.values[at], other.values[at]);
                let forgiven = noise.map_or(0.0, |(rows, steps)| rows[row] / steps[column]);
                let gap = ((a - b).abs() - forgiven).max(0.0);
                let size = self.sizes[row][field as usize];
                // A block of zeros has no size: any difference from it is one.
                let deviation = if gap == 0.0 { 0.0 } else { gap / size };
                let deviation = if deviation.is_nan() { f64::INFINITY } else { deviation };
                let block = (self.equations[row], field);
                match blocks.iter_mut().find(|(other, _)| *other == block) {
                    Some((_, largest)) => *largest = largest.max(deviation),
                    None => blocks.push((block, deviation)),
                }
                if worst.is_none_or(|worst| deviation > worst.deviation) {
                    let (row, column) = (self.unknowns[row], self.unknowns[column]);
                    worst = Some(Entry { block, row, column, expected: a, found: b, deviation });
                }
            }
        }
        blocks.sort_by_key(|(block, _)| *block);
        Comparison { name: name.into(), tolerance, worst, blocks }
    }
}

fn padded<const D: usize>(x: &[f64; D]) -> [f64; 3] {
    std::array::from_fn(|d| if d < D { x[d] } else { 0.0 })
}

fn unknowns<const D: usize>(space: &FsiSpace<D>) -> Vec<Unknown> {
    let mut list = vec![];
    for (field, n) in [(Field::V, space.n_v()), (Field::U, space.n_u())] {
        for i in 0..n {
            let position = padded(&space.nodes.points[i / D]);
            list.push(Unknown { index: list.len(), field, component: i % D, position, dim: D });
        }
    }
    for position in &space.pressure.points {
        list.push(Unknown {
            index: list.len(),
            field: Field::P,
            component: 0,
            position: padded(position),
            dim: D,
        });
    }
    list
}

fn equations<const D: usize>(space: &FsiSpace<D>) -> Vec<Equation> {
    let mut in_fluid = vec![false; space.nodes.len()];
    for cell in (0..space.mesh.n_cells()).filter(|&cell| space.regions[cell] == Region::Fluid) {
        space.nodes.cell(cell).iter().for_each(|&node| in_fluid[node as usize] = true);
    }
    let momentum = |node: usize| match (in_fluid[node], space.owner[node] == PsiOwner::Relation) {
        (true, true) => Equation::Interface,
        (_, false) => Equation::NavierStokes,
        (false, true) => Equation::Elasticity,
    };
    let psi = |node: usize| match space.owner[node] {
        PsiOwner::Extension => Equation::Ale,
        PsiOwner::Relation => Equation::Relation,
    };
    let mut list: Vec<Equation> = (0..space.n_v()).map(|i| momentum(i / D)).collect();
    list.extend((0..space.n_u()).map(|i| psi(i / D)));
    list.resize(space.n_field_unknowns(), Equation::Divergence);
    list
}
