//! Geometric multigrid for the system of (v, p), on the meshes that a mesh was refined from.

mod clusters;
mod envelope;
mod levels;
mod lists;
mod matrix;
mod smoother;
mod transfer;
mod triangular;
mod weights;

pub use levels::{System, Tier, tiers};
pub use triangular::{Part, Triangular};

use crate::algebra::{
    Cost, Csr, FactorReport, LinearSolver, Pattern, Sizes, SolveReport, SolverError, Unknown,
};
use matrix::Single;
use smoother::Smoother;
use std::sync::Arc;
use transfer::Transfer;

/// Operations of P ᵀ A P for a byte of A.
const GALERKIN: f64 = 8.0;

/// How a cycle is done.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Settings {
    /// Smoothing steps after the correction by the coarser level.
    pub sweeps: usize,
}

impl Default for Settings {
    /// One sweep over blocks that have several cells does more than two over single cells. None goes before the
    /// correction: with it GMRES needs as many iterations, of twice the cost.
    fn default() -> Settings {
        Settings { sweeps: 1 }
    }
}

/// A level above the coarsest one.
struct Level {
    matrix: Single,
    smoother: Smoother,
    transfer: Transfer,
    /// Pattern of the next coarser level.
    coarser: Arc<Pattern>,
    x: Vec<f32>,
    b: Vec<f32>,
}

/// A multigrid cycle as the factors of a matrix.
pub struct Multigrid {
    settings: Settings,
    /// What levels will be made of.
    tiers: Vec<Tier>,
    /// The finest first.
    levels: Vec<Level>,
    coarsest: Box<dyn LinearSolver>,
    coarse: Coarse,
}

/// Vectors of the coarsest level.
#[derive(Default)]
struct Coarse {
    /// Right-hand side, then solution.
    single: Vec<f32>,
    double: [Vec<f64>; 2],
}

impl Multigrid {
    /// From the `tiers` of the levels above the coarsest one, which `coarsest` solves.
    pub fn new(settings: Settings, tiers: Vec<Tier>, coarsest: Box<dyn LinearSolver>) -> Multigrid {
        Multigrid { settings, tiers, levels: vec![], coarsest, coarse: Coarse::default() }
    }

    /// The solution of level `l` for its right-hand side `b`, about, into its `x`: that of the next coarser level, then
    /// sweeps.
    fn cycle(&mut self, l: usize) {
        let (finer, coarser) = self.levels.split_at_mut(l + 1);
        let Level { transfer, b, x, .. } = &mut finer[l];
        x.fill(0.0);
        if let Some(next) = coarser.first_mut() {
            transfer.restrict(b, &mut next.b);
            self.cycle(l + 1);
            let (finer, coarser) = self.levels.split_at_mut(l + 1);
            finer[l].transfer.prolong(&coarser[0].x, &mut finer[l].x);
        } else {
            let Coarse { single, double: [right, solution] } = &mut self.coarse;
            transfer.restrict(b, single);
            right.iter_mut().zip(&*single).for_each(|(to, from)| *to = f64::from(*from));
            self.coarsest.apply(right, solution);
            single.iter_mut().zip(&*solution).for_each(|(to, from)| *to = *from as f32);
            transfer.prolong(single, x);
        }
        let Level { matrix, smoother, b, x, .. } = &mut self.levels[l];
        (0..self.settings.sweeps).for_each(|_| smoother.sweep(matrix, b, x));
    }
}

impl LinearSolver for Multigrid {
    fn name(&self) -> &'static str {
        "multigrid"
    }

    fn analyse(&mut self, pattern: &Arc<Pattern>, unknowns: &[Unknown]) -> Result<(), SolverError> {
        let mut pattern = Arc::clone(pattern);
        let mut last = unknowns.to_vec();
        for Tier { blocks, rows, unknowns } in std::mem::take(&mut self.tiers) {
            let transfer = Transfer::new(rows, unknowns.len());
            let n = pattern.n;
            let coarser = Arc::new(transfer.pattern(&pattern));
            self.levels.push(Level {
                matrix: Single::zeros(&pattern),
                smoother: Smoother::new(blocks, &pattern),
                transfer,
                coarser: Arc::clone(&coarser),
                x: vec![0.0; n],
                b: vec![0.0; n],
            });
            (pattern, last) = (coarser, unknowns);
        }
        let n = pattern.n;
        self.coarse = Coarse { single: vec![0.0; n], double: [vec![0.0; n], vec![0.0; n]] };
        self.coarsest.analyse(&pattern, &last)
    }

    fn factor(&mut self, a: &Csr) -> Result<FactorReport, SolverError> {
        let mut last: Option<Csr> = None;
        for level in &mut self.levels {
            let matrix = last.as_ref().unwrap_or(a);
            level.matrix.take(matrix);
            level.smoother.factor(matrix);
            last = Some(level.transfer.galerkin(matrix, &level.coarser));
        }
        self.coarsest.factor(last.as_ref().unwrap_or(a))
    }

    fn solve(&mut self, _a: &Csr, b: &[f64], x: &mut [f64]) -> Result<SolveReport, SolverError> {
        self.apply(b, x);
        Ok(SolveReport { refinements: 0, backward_error: f64::NAN })
    }

    fn apply(&mut self, b: &[f64], x: &mut [f64]) {
        if self.levels.is_empty() {
            return self.coarsest.apply(b, x);
        }
        let size = b.iter().fold(0.0_f64, |size, b| size.max(b.abs()));
        if size == 0.0 {
            return x.fill(0.0);
        }
        self.levels[0].b.iter_mut().zip(b).for_each(|(to, from)| *to = (from / size) as f32);
        self.cycle(0);
        x.iter_mut().zip(&self.levels[0].x).for_each(|(to, from)| *to = f64::from(*from) * size);
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn predicted(&self) -> Option<Cost> {
        let sweeps = self.settings.sweeps;
        // Rows on the rims of blocks belong to several of them.
        let read = |level: &Level| sweeps * (2 * level.matrix.bytes() + level.smoother.bytes());
        let read: usize = self.levels.iter().map(read).sum();
        let flops: f64 = self
            .levels
            .iter()
            .map(|level| level.smoother.flops() + GALERKIN * level.matrix.bytes() as f64)
            .sum();
        let coarse = self.coarsest.predicted().unwrap_or_default();
        Some(Cost {
            read: Some(read + coarse.read.unwrap_or(0)),
            flops: Some(flops + coarse.flops.unwrap_or(0.0)),
            ..coarse
        })
    }

    fn set_sizes(&mut self, sizes: Sizes) {
        self.coarsest.set_sizes(sizes);
    }
}
