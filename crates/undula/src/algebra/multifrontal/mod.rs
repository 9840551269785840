//! Multifrontal LU, made for unknowns on mesh nodes.
//!
//! The order of elimination of the mesh nodes gives a tree of dense fronts; each adds the contributions of
//! its children, eliminates its own unknowns, and leaves a contribution to its parent (Duff and Reid
//! 1983). Pivots are chosen among the rows of the front and must not be small against the rest of
//! their column; where there is none, as for pressures before the velocities they push, the unknown is
//! delayed to the parent.

mod buffer;
mod definite;
mod dense;
mod factors;
mod front;
mod graph;
mod kernels;
mod large;
mod numeric;
mod ordering;
mod prefetch;
mod real;
mod sizes;
mod solve;
mod symbolic;
mod tree;

use super::direct::Failure;
use super::scaling::inverse;
use super::{Backend, Cost, Csr, Direct, Options, Pattern, Scaling, SolverError, Unknown, norm_inf};
use factors::Factors;
use front::Front;
use numeric::{Numeric, Part, Pool};
use pulp::Arch;
use real::Real;
use solve::{Parent, Solve};
use std::sync::Arc;
use symbolic::{Symbolic, entries};

/// Multifrontal LU of our own; subtrees run in parallel.
pub type MultifrontalLu = Direct<MultifrontalBackend>;

impl MultifrontalLu {
    /// Factors in double precision.
    pub fn multifrontal(options: Options) -> Self {
        Self::new(MultifrontalBackend::of::<f64>(false), options)
    }

    /// Factors in single precision, half as large: for iterations that see their own residual, or with
    /// refinement.
    pub fn single(options: Options) -> Self {
        Self::new(MultifrontalBackend::of::<f32>(false), options)
    }

    /// For symmetric positive definite matrices: `L D Lᵀ` without exchanges, of which L alone is stored.
    pub fn definite(options: Options) -> Self {
        Self::new(MultifrontalBackend::of::<f64>(true), options)
    }

    /// The same in single precision.
    pub fn single_definite(options: Options) -> Self {
        Self::new(MultifrontalBackend::of::<f32>(true), options)
    }
}

/// Backend of [`MultifrontalLu`]. Its precision is no type parameter: whoever uses it would compile it once more.
#[derive(Debug)]
pub struct MultifrontalBackend(Box<dyn Backend>);

impl MultifrontalBackend {
    fn of<T: Real>(definite: bool) -> Self {
        let symbolic = Symbolic { definite, ..Symbolic::default() };
        Self(Box::new(Multifrontal::<T> { symbolic, ..Multifrontal::default() }))
    }
}

impl Backend for MultifrontalBackend {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn analyse(&mut self, pattern: &Arc<Pattern>, unknowns: &[Unknown]) -> Result<(), SolverError> {
        self.0.analyse(pattern, unknowns)
    }

    fn factor(&mut self, a: &Csr, scaling: &Scaling) -> Result<Cost, Failure> {
        self.0.factor(a, scaling)
    }

    fn solve(&mut self, y: &mut [f64]) {
        self.0.solve(y);
    }

    fn predicted(&self) -> Option<Cost> {
        self.0.predicted()
    }

    fn settle(&mut self) {
        self.0.settle();
    }

    fn is_definite(&self) -> bool {
        self.0.is_definite()
    }

    fn roundoff(&self) -> f64 {
        self.0.roundoff()
    }
}

/// Factors and substitutes in the precision of `T`.
#[derive(Debug)]
struct Multifrontal<T> {
    symbolic: Symbolic,
    fronts: Vec<Front<T>>,
    factors: Factors<T>,
    pool: Pool<T>,
    arch: Arch,
    permuted: Vec<T>,
}

impl<T: Real> Default for Multifrontal<T> {
    fn default() -> Self {
        Self {
            symbolic: Symbolic::default(),
            fronts: Vec::new(),
            factors: Factors::default(),
            pool: Pool::new(),
            arch: Arch::new(),
            permuted: Vec::new(),
        }
    }
}

impl<T: Real> Multifrontal<T> {
    /// What the last factorisation has cost.
    fn cost(&self) -> Cost {
        let sizes = || self.fronts.iter().map(|f| (f.e, f.k + f.r - f.e, f.delayed()));
        Cost {
            fill: Some(sizes().map(|(k, r, _)| entries(k, r, self.symbolic.definite)).sum()),
            flops: Some(sizes().map(|(k, r, _)| tree::flops(k, r)).sum()),
            delayed: sizes().map(|(_, _, delayed)| delayed).sum(),
            bytes: Some(self.bytes()),
            read: None,
        }
    }

    /// Memory of factors and vectors. That of contributions depends on how many threads had some at a
    /// time, which no result may.
    fn bytes(&self) -> usize {
        let of = |f: &Front<T>| f.spill.capacity() + f.work.capacity() + f.spare.capacity();
        let factors = self.factors.lower.capacity() + self.factors.upper.capacity();
        size_of::<T>() * (factors + self.fronts.iter().map(of).sum::<usize>())
    }
}

impl<T: Real> Backend for Multifrontal<T> {
    fn name(&self) -> &'static str {
        T::NAME
    }

    fn analyse(&mut self, pattern: &Arc<Pattern>, unknowns: &[Unknown]) -> Result<(), SolverError> {
        self.symbolic = Symbolic::new(pattern, unknowns, self.symbolic.definite)?;
        self.fronts.clear();
        self.fronts.resize_with(self.symbolic.fronts.len(), Front::default);
        let (lower, upper) = self.symbolic.stored;
        self.factors = Factors::new(lower, upper, self.symbolic.definite);
        self.pool = Pool::new();
        self.permuted = vec![T::ZERO; pattern.n];
        Ok(())
    }

    fn factor(&mut self, a: &Csr, scaling: &Scaling) -> Result<Cost, Failure> {
        let Self { symbolic, fronts, factors: Factors { lower, upper, .. }, pool, arch, .. } = self;
        let numeric = Numeric { symbolic, a, scaling, pool, arch: *arch };
        let ((n_lower, n_upper), fronts) = (symbolic.stored, &mut fronts[..]);
        let (lower, upper) = (&mut lower[..n_lower], &mut upper[..n_upper]);
        numeric.subtrees(&symbolic.roots, Part { fronts, lower, upper });
        if symbolic.definite
            && let Some(f) = fronts.iter().position(|front| !front.is_definite)
        {
            return Err(Failure::NotDefinite(symbolic.old[symbolic.fronts[f].first] as usize));
        }
        for &root in &symbolic.roots {
            let (front, shape) = (&self.fronts[root as usize], &symbolic.fronts[root as usize]);
            if front.delayed() > 0 {
                let place = front.col_from[front.e..].iter().find(|&&c| (c as usize) < shape.k);
                let new = shape.first + place.map_or(0, |&c| c as usize);
                return Err(Failure::ZeroPivot(symbolic.old[new] as usize));
            }
        }
        Ok(self.cost())
    }

    fn solve(&mut self, y: &mut [f64]) {
        let Self { symbolic, fronts, factors, arch, permuted, .. } = self;
        // Powers of two round nothing, and no right-hand side is too small or too large for factors in
        // single precision.
        let scale = inverse(norm_inf(y).max(f64::MIN_POSITIVE));
        for (p, &old) in permuted.iter_mut().zip(&symbolic.old) {
            *p = T::of(y[old as usize] * scale);
        }
        let solve = Solve { symbolic, factors, arch: *arch };
        solve.forward(&symbolic.roots, fronts, permuted);
        solve.backward(&symbolic.roots, fronts, permuted, Parent { known: &[], k: 0, shift: 0 });
        for (p, &old) in permuted.iter().zip(&symbolic.old) {
            y[old as usize] = p.double() / scale;
        }
    }

    fn is_definite(&self) -> bool {
        self.symbolic.definite
    }

    fn settle(&mut self) {
        self.pool = Pool::new();
        for shape in &mut self.symbolic.fronts {
            (shape.left, shape.right) = (vec![], vec![]);
        }
    }

    fn predicted(&self) -> Option<Cost> {
        let Symbolic { fill, flops, .. } = self.symbolic;
        let bytes = size_of::<T>() * fill;
        let passes = if self.symbolic.definite { 2 } else { 1 };
        Some(Cost {
            fill: Some(fill),
            flops: Some(flops),
            delayed: 0,
            bytes: Some(bytes),
            read: Some(passes * bytes),
        })
    }

    fn roundoff(&self) -> f64 {
        T::ROUNDOFF
    }
}
