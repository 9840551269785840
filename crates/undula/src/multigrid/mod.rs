//! Geometric multigrid for the system of (v, p), on the meshes that a mesh was refined from.

mod blocks;
mod clusters;
mod envelope;
mod gathered;
mod levels;
mod lists;
mod matrix;
mod number;
mod numbers;
mod parted;
mod shared;
mod smoother;
mod transfer;
mod triangular;
mod weights;

pub use levels::System;
pub use parted::Tiers;
pub use triangular::{Part, Triangular};

use crate::algebra::{
    Cost, Csr, FactorReport, LinearSolver, Pattern, Sizes, SolveReport, SolverError, Spent, Unknown, Value,
};
use crate::parallel::{Fault, Halo, Reduce};
use gathered::Gathered;
use levels::Tier;
use lists::Lists;
use matrix::Matrix;
use number::Number;
use parted::Parted;
use shared::{Coarser, Finer, Share};
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
    /// The finest matrix in single precision, for GMRES, too.
    pub single: bool,
}

impl Default for Settings {
    /// One sweep over blocks that have several cells does more than two over single cells. None goes before the
    /// correction: with it GMRES needs as many iterations, of twice the cost.
    fn default() -> Settings {
        Settings { sweeps: 1, double: false, single: false }
    }
}

/// A level above the coarsest one.
struct Level<T: Number> {
    pattern: Arc<Pattern>,
    matrix: Matrix<T>,
    smoother: Smoother<T>,
    transfer: Transfer,
    /// Pattern of the next coarser level.
    coarser: Arc<Pattern>,
    x: Vec<T>,
    b: Vec<T>,
    /// Where processes share it.
    share: Option<Share<T>>,
}

/// A multigrid cycle as the factors of a matrix.
struct Multigrid<T: Number> {
    settings: Settings,
    /// What levels will be made of.
    tiers: Tiers,
    /// The finest unknowns, where processes share them.
    halo: Option<Arc<Halo>>,
    /// The finest first.
    levels: Vec<Level<T>>,
    coarsest: Box<dyn LinearSolver>,
    coarse: Coarse<T>,
    /// The coarsest level of several processes.
    gathered: Option<Gathered>,
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

fn told(fault: Fault) -> SolverError {
    SolverError::Engine(fault.to_string())
}

/// Vectors of the coarsest level.
#[derive(Default)]
struct Coarse<T> {
    /// Right-hand side, then solution.
    own: Vec<T>,
    /// What is summed over several processes.
    parts: Vec<f64>,
    double: [Vec<f64>; 2],
    /// Bytes that a solution reads.
    bytes: usize,
}

/// A multigrid cycle from the `tiers` of the levels above the coarsest one, which `coarsest` solves.
pub fn multigrid(settings: Settings, tiers: Tiers, coarsest: Box<dyn LinearSolver>) -> Box<dyn LinearSolver> {
    if settings.double {
        Box::new(Multigrid::<f64>::new(settings, tiers, coarsest))
    } else {
        Box::new(Multigrid::<f32>::new(settings, tiers, coarsest))
    }
}

impl<T: Number> Multigrid<T> {
    fn new(settings: Settings, tiers: Tiers, coarsest: Box<dyn LinearSolver>) -> Multigrid<T> {
        let (halo, gathered, coarse) = (None, None, Coarse::default());
        Multigrid { settings, tiers, halo, levels: vec![], coarsest, coarse, gathered, spent: no_time() }
    }

    /// Levels of a process alone; returns the pattern and the unknowns of the coarsest one.
    fn take_whole(
        &mut self,
        tiers: Vec<Tier>,
        pattern: &Arc<Pattern>,
    ) -> (Arc<Pattern>, Option<Vec<Unknown>>) {
        let (mut pattern, mut last) = (Arc::clone(pattern), None);
        for Tier { blocks, rows, unknowns, .. } in tiers {
            let transfer = Transfer::new(rows, unknowns.len());
            let coarser = Arc::new(transfer.pattern(&pattern));
            self.levels.push(Level::new(&pattern, blocks, transfer, &coarser));
            (pattern, last) = (coarser, Some(unknowns));
        }
        (pattern, last)
    }

    /// The same of several processes.
    fn take_parts(
        &mut self,
        Parted { crew, tiers, numbers, owners }: Parted,
        pattern: &Arc<Pattern>,
    ) -> Result<(Arc<Pattern>, Option<Vec<Unknown>>), Fault> {
        let mut halo = self.halo.clone().ok_or(Fault::Missing("its unknowns are not shared".into()))?;
        let (mut pattern, mut last, mut numbers, mut owners) = (Arc::clone(pattern), vec![], numbers, owners);
        let own_blocks = |tier: &Tier| -> Vec<Vec<u32>> {
            let blocks = tier.blocks.iter().zip(&tier.ranks);
            blocks
                .filter(|(_, rank)| **rank as usize == crew.rank())
                .map(|(block, _)| block.to_vec())
                .collect()
        };
        let mut tiers = tiers.into_iter().peekable();
        while let Some(tier) = tiers.next() {
            let wanted: Vec<u32> = tiers.peek().map(own_blocks).into_iter().flatten().flatten().collect();
            let mut places = vec![0; owners.len()];
            numbers.iter().zip(0_u32..).for_each(|(&number, place)| places[number as usize] = place);
            let place = |number: &u32| places[*number as usize];
            let mut blocks = Lists::default();
            own_blocks(&tier).iter().for_each(|block| blocks.push(block.iter().map(place)));
            let finer = Finer { halo: &halo, pattern: &pattern, numbers: &numbers, owners: &owners };
            let Coarser { transfer, pattern: coarser, rows, halo: next, numbers: coarse, owners: ranks } =
                finer.coarser(&tier, wanted)?;
            let share = Share::new(halo, &blocks, rows, pattern.n);
            let level = Level::new(&pattern, blocks, transfer, &coarser);
            self.levels.push(Level { share: Some(share), ..level });
            (halo, pattern, numbers, owners, last) = (next, coarser, coarse, ranks, tier.unknowns);
        }
        let gathered = Gathered::new(halo, &pattern, numbers, last.len())?;
        self.coarse.parts = vec![0.0; pattern.n];
        self.coarse.own = vec![T::default(); pattern.n];
        let pattern = Arc::clone(&gathered.matrix.pattern);
        self.gathered = Some(gathered);
        Ok((pattern, Some(last)))
    }

    /// Factorise the levels from `first` on, the first one of which has the matrix `a`.
    fn factor_coarser(&mut self, a: &Csr, first: usize) -> Result<FactorReport, SolverError> {
        let mut last: Option<Csr> = None;
        for level in self.levels.iter_mut().skip(first) {
            let matrix = last.as_ref().unwrap_or(a);
            level.matrix.take(matrix);
            level.smoother.factor(matrix);
            last = Some(level.galerkin(matrix).map_err(told)?);
        }
        let matrix = last.as_ref().unwrap_or(a);
        let Some(gathered) = &mut self.gathered else { return self.coarsest.factor(matrix) };
        gathered.take(matrix).map_err(told)?;
        self.coarsest.factor(&gathered.matrix)
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
            next.share.iter_mut().for_each(|share| share.update(&mut next.b, true));
            self.spent[1].add(&mut start, bytes);
            self.cycle(l + 1);
            start = Instant::now();
            let (finer, coarser) = self.levels.split_at_mut(l + 1);
            finer[l].transfer.prolong(&coarser[0].x, &mut finer[l].x);
        } else {
            let Coarse { own, parts, double: [right, solution], bytes: read } = &mut self.coarse;
            transfer.restrict(b, own);
            self.spent[1].add(&mut start, bytes);
            if let Some(gathered) = &self.gathered {
                parts.iter_mut().zip(&*own).for_each(|(to, from)| *to = from.double());
                gathered.sum(parts, right);
                self.coarsest.apply(right, solution);
                own.iter_mut().zip(gathered.part(solution)).for_each(|(to, from)| *to = T::of(from));
            } else {
                right.iter_mut().zip(&*own).for_each(|(to, from)| *to = from.double());
                self.coarsest.apply(right, solution);
                own.iter_mut().zip(&*solution).for_each(|(to, from)| *to = T::of(*from));
            }
            self.spent[0].add(&mut start, *read);
            transfer.prolong(own, x);
        }
        self.spent[1].add(&mut start, bytes);
        (0..self.settings.sweeps).for_each(|_| self.levels[l].sweep());
        let bytes = self.levels[l].bytes();
        self.spent[2].add(&mut start, self.settings.sweeps * bytes);
    }
}

impl<T: Number> Level<T> {
    /// Of a process alone.
    fn new(
        pattern: &Arc<Pattern>,
        blocks: Lists<u32>,
        transfer: Transfer,
        coarser: &Arc<Pattern>,
    ) -> Level<T> {
        Level {
            pattern: Arc::clone(pattern),
            matrix: Matrix::none(),
            smoother: Smoother::new(blocks, pattern),
            transfer,
            coarser: Arc::clone(coarser),
            x: vec![T::default(); pattern.n],
            b: vec![T::default(); pattern.n],
            share: None,
        }
    }

    fn sweep(&mut self) {
        let Level { matrix, smoother, b, x, share, .. } = self;
        share.iter_mut().for_each(|share| share.begin(x));
        smoother.sweep(matrix, b, x);
        share.iter_mut().for_each(|share| share.join(x));
    }

    /// The matrix of the coarser level.
    fn galerkin<S: Value>(&self, matrix: &Csr<S>) -> Result<Csr, Fault> {
        match &self.share {
            None => Ok(self.transfer.galerkin(matrix, &self.coarser)),
            Some(Share { halo, rows, .. }) => {
                let product = self.transfer.galerkin(matrix, &rows.product);
                rows.complete(halo.crew(), &product, &self.coarser)
            }
        }
    }

    /// What a sweep reads: rows on the rims of blocks belong to several of them.
    fn bytes(&self) -> usize {
        2 * Matrix::<T>::bytes(&self.pattern) + self.smoother.bytes()
    }
}

impl<T: Number> LinearSolver for Multigrid<T> {
    fn name(&self) -> &'static str {
        "multigrid"
    }

    fn analyse(&mut self, pattern: &Arc<Pattern>, unknowns: &[Unknown]) -> Result<(), SolverError> {
        let (pattern, last) = match std::mem::replace(&mut self.tiers, Tiers::Whole(vec![])) {
            Tiers::Whole(tiers) => {
                let made = self.take_whole(tiers, pattern);
                self.coarse.own = vec![T::default(); made.0.n];
                made
            }
            Tiers::Parted(parted) => self.take_parts(parted, pattern).map_err(told)?,
        };
        self.coarsest.analyse(&pattern, last.as_deref().unwrap_or(unknowns))?;
        self.coarse.bytes = self.coarsest.predicted().and_then(|cost| cost.read).unwrap_or(0);
        self.coarse.double = [vec![0.0; pattern.n], vec![0.0; pattern.n]];
        Ok(())
    }

    fn share(&mut self, halo: Arc<Halo>) {
        self.halo = Some(halo);
    }

    fn factor(&mut self, a: &Csr) -> Result<FactorReport, SolverError> {
        let Some(finest) = self.levels.first_mut() else { return self.factor_coarser(a, 0) };
        finest.matrix.take(a);
        finest.smoother.factor(a);
        let coarser = finest.galerkin(a).map_err(told)?;
        self.factor_coarser(&coarser, 1)
    }

    fn takes_single(&self) -> bool {
        let without =
            matches!(&self.tiers, Tiers::Whole(tiers) if tiers.is_empty() && self.levels.is_empty());
        self.settings.single && !self.settings.double && !without
    }

    fn factor_single(&mut self, a: &Arc<Csr<f32>>) -> Result<FactorReport, SolverError> {
        self.hold(Some(a));
        let Some(finest) = self.levels.first_mut() else { return Err(SolverError::NotFactored) };
        finest.smoother.factor(a);
        let coarser = finest.galerkin(a).map_err(told)?;
        self.factor_coarser(&coarser, 1)
    }

    fn hold(&mut self, a: Option<&Arc<Csr<f32>>>) {
        let held = a.and_then(T::held);
        self.levels.first_mut().into_iter().for_each(|finest| finest.matrix.hold(held.clone()));
    }

    fn solve(&mut self, _a: &Csr, b: &[f64], x: &mut [f64]) -> Result<SolveReport, SolverError> {
        self.apply(b, x);
        Ok(SolveReport { refinements: 0, backward_error: f64::NAN })
    }

    fn apply(&mut self, b: &[f64], x: &mut [f64]) {
        if self.levels.is_empty() {
            return self.coarsest.apply(b, x);
        }
        let size = match &self.halo {
            None => b.iter().fold(0.0_f64, |size, b| size.max(b.abs())),
            Some(halo) => {
                let own = halo.own().iter().map(|&at| b[at as usize].abs());
                halo.crew().one(Reduce::Max, own.fold(0.0, f64::max))
            }
        };
        if size == 0.0 {
            return x.fill(0.0);
        }
        let Level { b: right, share, .. } = &mut self.levels[0];
        right.iter_mut().zip(b).for_each(|(to, from)| *to = T::of(from / size));
        share.iter_mut().for_each(|share| share.update(right, false));
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
            .map(|level| level.smoother.flops() + GALERKIN * Matrix::<T>::bytes(&level.pattern) as f64)
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
