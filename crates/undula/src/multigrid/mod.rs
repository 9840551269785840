//! Geometric multigrid for the system of (v, p), on the meshes that a mesh was refined from.

mod clusters;
mod envelope;
mod levels;
mod lists;
mod matrix;
mod smoother;
mod transfer;
mod weights;

pub use levels::{System, Tier, tiers};

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
    /// Smoothing steps before and after the correction by the coarser level.
    pub sweeps: usize,
    /// Corrections by the coarser level in a cycle: 1 is a V-cycle, 2 a W-cycle.
    pub corrections: usize,
}

impl Default for Settings {
    /// One sweep over blocks that have several cells does more than two over single cells.
    fn default() -> Settings {
        Settings { sweeps: 1, corrections: 1 }
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
    r: Vec<f32>,
}

impl Level {
    /// Sweeps over all blocks, `back` to front or not.
    fn smooth(&mut self, sweeps: usize, back: bool) {
        (0..sweeps).for_each(|_| self.smoother.sweep(&self.matrix, &self.b, &mut self.x, back));
    }
}

/// A multigrid cycle as the factors of a matrix.
pub struct Multigrid {
    settings: Settings,
    /// What levels will be made of.
    tiers: Vec<Tier>,
    /// The finest first.
    levels: Vec<Level>,
    coarsest: Box<dyn LinearSolver>,
    /// Right-hand side and solution of the coarsest level.
    coarse: [Vec<f64>; 2],
}

impl Multigrid {
    /// From the `tiers` of the levels above the coarsest one, which `coarsest` solves.
    pub fn new(settings: Settings, tiers: Vec<Tier>, coarsest: Box<dyn LinearSolver>) -> Multigrid {
        Multigrid { settings, tiers, levels: vec![], coarsest, coarse: Default::default() }
    }

    /// The correction of level `l` for its right-hand side `b`, into its `x`.
    fn cycle(&mut self, l: usize) {
        let Settings { sweeps, corrections } = self.settings;
        if l == self.levels.len() {
            let [b, x] = &mut self.coarse;
            self.coarsest.apply(b, x);
            return;
        }
        let level = &mut self.levels[l];
        level.x.fill(0.0);
        level.smooth(sweeps, false);
        for _ in 0..corrections {
            self.correct(l);
        }
        self.levels[l].smooth(sweeps, true);
    }

    /// Correct level `l` by the next coarser one.
    fn correct(&mut self, l: usize) {
        let (finer, coarser) = self.levels.split_at_mut(l + 1);
        let level = &mut finer[l];
        level.matrix.residual(&level.b, &level.x, &mut level.r);
        if let Some(next) = coarser.first_mut() {
            level.transfer.restrict(&level.r, &mut next.b);
            self.cycle(l + 1);
            let (finer, coarser) = self.levels.split_at_mut(l + 1);
            finer[l].transfer.prolong(&coarser[0].x, &mut finer[l].x);
            return;
        }
        let mut coarse = vec![0.0; self.coarse[0].len()];
        level.transfer.restrict(&level.r, &mut coarse);
        self.coarse[0].iter_mut().zip(&coarse).for_each(|(to, from)| *to = f64::from(*from));
        self.cycle(l + 1);
        coarse.iter_mut().zip(&self.coarse[1]).for_each(|(to, from)| *to = *from as f32);
        let level = &mut self.levels[l];
        level.transfer.prolong(&coarse, &mut level.x);
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
                r: vec![0.0; n],
            });
            (pattern, last) = (coarser, unknowns);
        }
        self.coarse = [vec![0.0; pattern.n], vec![0.0; pattern.n]];
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
        let sweeps = 2 * self.settings.sweeps;
        let read = |level: &Level| (2 * sweeps + 1) * level.matrix.bytes() + sweeps * level.smoother.bytes();
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
