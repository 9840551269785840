//! Geometric multigrid for the system of (v, p), on the meshes that a mesh was refined from.

mod clusters;
mod envelope;
mod levels;
mod lists;
mod matrix;
mod number;
mod numbers;
mod smoother;
mod transfer;
mod triangular;
mod weights;

pub use levels::{System, Tier, tiers};
pub use triangular::{Part, Triangular};

use crate::algebra::{
    Cost, Csr, FactorReport, LinearSolver, Pattern, Sizes, SolveReport, SolverError, Spent, Unknown,
};
use matrix::Matrix;
use number::Number;
use smoother::Smoother;
use std::sync::Arc;
use std::time::Instant;
use transfer::Transfer;

/// Operations of P ᵀ A P for a byte of A.
const GALERKIN: f64 = 8.0;

/// How a cycle is done.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Settings {
    /// Smoothing steps after the correction by the coarser level.
    pub sweeps: usize,
    /// Cycles in double precision.
    pub double: bool,
}

impl Default for Settings {
    /// One sweep over blocks that have several cells does more than two over single cells. None goes before the
    /// correction: with it GMRES needs as many iterations, of twice the cost.
    fn default() -> Settings {
        Settings { sweeps: 1, double: false }
    }
}

/// A level above the coarsest one.
struct Level<T> {
    matrix: Matrix<T>,
    smoother: Smoother<T>,
    transfer: Transfer,
    /// Pattern of the next coarser level.
    coarser: Arc<Pattern>,
    x: Vec<T>,
    b: Vec<T>,
}

/// A multigrid cycle as the factors of a matrix.
struct Multigrid<T> {
    settings: Settings,
    /// What levels will be made of.
    tiers: Vec<Tier>,
    /// The finest first.
    levels: Vec<Level<T>>,
    coarsest: Box<dyn LinearSolver>,
    coarse: Coarse<T>,
    /// The coarsest level, transfers, smoothing.
    spent: [Spent; 3],
}

/// Nothing yet.
fn no_time() -> [Spent; 3] {
    ["coarsest level", "transfer", "smoother"].map(|part| Spent { part, seconds: 0.0, bytes: 0.0 })
}

impl Spent {
    /// Since `start`, which begins anew.
    fn add(&mut self, start: &mut Instant, bytes: usize) {
        let now = Instant::now();
        self.seconds += (now - *start).as_secs_f64();
        self.bytes += bytes as f64;
        *start = now;
    }
}

/// Vectors of the coarsest level.
#[derive(Default)]
struct Coarse<T> {
    /// Right-hand side, then solution.
    own: Vec<T>,
    double: [Vec<f64>; 2],
    /// Bytes that a solution reads.
    bytes: usize,
}

/// A multigrid cycle from the `tiers` of the levels above the coarsest one, which `coarsest` solves.
pub fn multigrid(
    settings: Settings,
    tiers: Vec<Tier>,
    coarsest: Box<dyn LinearSolver>,
) -> Box<dyn LinearSolver> {
    if settings.double {
        Box::new(Multigrid::<f64>::new(settings, tiers, coarsest))
    } else {
        Box::new(Multigrid::<f32>::new(settings, tiers, coarsest))
    }
}

impl<T: Number> Multigrid<T> {
    fn new(settings: Settings, tiers: Vec<Tier>, coarsest: Box<dyn LinearSolver>) -> Multigrid<T> {
        Multigrid { settings, tiers, levels: vec![], coarsest, coarse: Coarse::default(), spent: no_time() }
    }

    /// The solution of level `l` for its right-hand side `b`, about, into its `x`: that of the next coarser level, then
    /// sweeps.
    fn cycle(&mut self, l: usize) {
        let mut start = Instant::now();
        let (finer, coarser) = self.levels.split_at_mut(l + 1);
        let Level { transfer, b, x, .. } = &mut finer[l];
        let bytes = transfer.bytes();
        x.fill(T::default());
        if let Some(next) = coarser.first_mut() {
            transfer.restrict(b, &mut next.b);
            self.spent[1].add(&mut start, bytes);
            self.cycle(l + 1);
            start = Instant::now();
            let (finer, coarser) = self.levels.split_at_mut(l + 1);
            finer[l].transfer.prolong(&coarser[0].x, &mut finer[l].x);
        } else {
            let Coarse { own, double: [right, solution], bytes: read } = &mut self.coarse;
            transfer.restrict(b, own);
            self.spent[1].add(&mut start, bytes);
            right.iter_mut().zip(&*own).for_each(|(to, from)| *to = from.double());
            self.coarsest.apply(right, solution);
            own.iter_mut().zip(&*solution).for_each(|(to, from)| *to = T::of(*from));
            self.spent[0].add(&mut start, *read);
            transfer.prolong(own, x);
        }
        self.spent[1].add(&mut start, bytes);
        let Level { matrix, smoother, b, x, .. } = &mut self.levels[l];
        (0..self.settings.sweeps).for_each(|_| smoother.sweep(matrix, b, x));
        let bytes = self.levels[l].bytes();
        self.spent[2].add(&mut start, self.settings.sweeps * bytes);
    }
}

impl<T: Number> Level<T> {
    /// What a sweep reads: rows on the rims of blocks belong to several of them.
    fn bytes(&self) -> usize {
        2 * self.matrix.bytes() + self.smoother.bytes()
    }
}

impl<T: Number> LinearSolver for Multigrid<T> {
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
                matrix: Matrix::zeros(&pattern),
                smoother: Smoother::new(blocks, &pattern),
                transfer,
                coarser: Arc::clone(&coarser),
                x: vec![T::default(); n],
                b: vec![T::default(); n],
            });
            (pattern, last) = (coarser, unknowns);
        }
        let n = pattern.n;
        self.coarsest.analyse(&pattern, &last)?;
        let bytes = self.coarsest.predicted().and_then(|cost| cost.read).unwrap_or(0);
        self.coarse = Coarse { own: vec![T::default(); n], double: [vec![0.0; n], vec![0.0; n]], bytes };
        Ok(())
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
        self.levels[0].b.iter_mut().zip(b).for_each(|(to, from)| *to = T::of(from / size));
        self.cycle(0);
        x.iter_mut().zip(&self.levels[0].x).for_each(|(to, from)| *to = from.double() * size);
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn predicted(&self) -> Option<Cost> {
        let read: usize = self.levels.iter().map(|level| self.settings.sweeps * level.bytes()).sum();
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

    fn largest_factor(&self) -> usize {
        let blocks = self.levels.iter().map(|level| level.smoother.largest());
        blocks.fold(self.coarsest.largest_factor(), usize::max)
    }

    fn spent(&self) -> Vec<Spent> {
        self.spent.to_vec()
    }

    fn set_sizes(&mut self, sizes: Sizes) {
        self.coarsest.set_sizes(sizes);
    }
}
