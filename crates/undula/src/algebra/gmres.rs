//! GMRES with a preconditioner on the right, for factors that are no longer those of the matrix.

use super::vector::add_scaled as add;
use super::{LinearOperator, SolverError};
use crate::algebra;
use crate::parallel::{Halo, Reduce};
use std::sync::Arc;

/// Share of an image that must be new against those before for its direction to be of use.
const INDEPENDENT: f64 = 1e-10;

/// When an iteration ends.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct GmresSettings {
    /// ‖W (b − A x)‖₂/‖W b‖₂ that is small enough.
    pub tolerance: f64,
    /// Iterations of a system at most, and directions that are kept.
    pub size: usize,
}

/// The generalised minimal residual method, in the form that keeps directions (GCR: Eisenstat, Elman and Schultz,
/// SIAM J. Numer. Anal. 20, 1983; Saad and Schultz, SIAM J. Sci. Stat. Comput. 7, 1986). Its memory is taken once.
///
/// With the preconditioner P ≈ A⁻¹, the diagonal matrix W of weights and the residual r_k = b − A x_k,
/// ```text
///     p_k = P r_k − Σ_(j<k) (q_j, W A P r_k) p_j,   q_k = W A p_k,   both divided by ‖q_k‖₂,
///     x_(k+1) = x_k + (q_k, W r_k) p_k,
/// ```
/// x_k has the least ‖W (b − A x)‖₂ in the span of the p_j. An iteration is one application of P, one product with A,
/// and three passes over the vectors for every direction before. For another right-hand side and the same
/// matrix the span is that of all directions so far: systems of one Newton iteration after the other are alike
/// (Parks, de Sturler et al., SIAM J. Sci. Comput. 28, 2006).
#[derive(Clone, Debug)]
pub struct Gmres {
    /// When it ends.
    pub settings: GmresSettings,
    /// p_j with q_j, newest last.
    pairs: Vec<Pair>,
    /// Memory of others.
    spare: Vec<Pair>,
    /// W r.
    residual: Vec<f64>,
    work: Vec<f64>,
    /// Where processes share the unknowns: products are those of all.
    halo: Option<Arc<Halo>>,
}

#[derive(Clone, Debug, Default)]
struct Pair {
    direction: Vec<f64>,
    image: Vec<f64>,
}

/// How a system was solved.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct GmresReport {
    /// Iterations.
    pub iterations: usize,
    /// ‖W (b − A x)‖₂/‖W b‖₂.
    pub reduction: f64,
}

impl Gmres {
    /// No directions yet.
    pub fn new(settings: GmresSettings) -> Gmres {
        let room = || Vec::with_capacity(settings.size);
        Gmres { settings, pairs: room(), spare: room(), residual: vec![], work: vec![], halo: None }
    }

    /// For a system that processes share. Its operator and preconditioner see own rows and copies of the others; what is in
    /// rows of copies does not count.
    #[must_use]
    pub fn shared(mut self, halo: Option<Arc<Halo>>) -> Gmres {
        self.halo = halo;
        self
    }

    /// (a, b) of all processes.
    fn dot(&self, a: &[f64], b: &[f64]) -> f64 {
        match &self.halo {
            None => algebra::dot(a, b),
            Some(halo) => {
                let own = halo.own().iter().map(|&at| a[at as usize] * b[at as usize]).sum();
                halo.crew().one(Reduce::Sum, own)
            }
        }
    }

    /// The step of least residual along a direction.
    fn project(&mut self, pair: usize, x: &mut [f64]) {
        let length = self.dot(&self.pairs[pair].image, &self.residual);
        let Pair { direction, image } = &self.pairs[pair];
        add(-length, image, &mut self.residual);
        add(length, direction, x);
    }

    /// Forget all directions, as for another matrix or other weights.
    pub fn clear(&mut self) {
        self.spare.append(&mut self.pairs);
    }

    /// Solves A x = b from x = 0 with the operator `a`; `weights` are positive, `precondition(r, z)` sets z ← P r, and may spoil `r`.
    ///
    /// # Errors
    /// [`SolverError::NotConverged`] if the tolerance is not reached, x being the best there is, or if a number is not
    /// finite.
    ///
    /// # Panics
    /// If the vectors do not fit the operator.
    pub fn solve(
        &mut self,
        a: &dyn LinearOperator,
        weights: &[f64],
        mut precondition: impl FnMut(&mut [f64], &mut [f64]),
        b: &[f64],
        x: &mut [f64],
    ) -> Result<GmresReport, SolverError> {
        let n = a.size();
        assert_eq!((weights.len(), b.len(), x.len()), (n, n, n), "vectors do not fit the operator");
        x.fill(0.0);
        self.residual.clear();
        self.residual.extend(b.iter().zip(weights).map(|(b, w)| b * w));
        let norm = self.dot(&self.residual, &self.residual).sqrt();
        if norm == 0.0 {
            return Ok(GmresReport { iterations: 0, reduction: 0.0 });
        }
        (0..self.pairs.len()).for_each(|pair| self.project(pair, x));
        let (mut iterations, GmresSettings { tolerance, size }) = (0, self.settings);
        loop {
            let reduction = self.dot(&self.residual, &self.residual).sqrt() / norm;
            if reduction <= tolerance {
                return Ok(GmresReport { iterations, reduction });
            }
            if iterations == size || !self.extend(a, weights, &mut precondition) {
                return Err(SolverError::NotConverged { iterations, reduction, allowed: tolerance });
            }
            iterations += 1;
            self.project(self.pairs.len() - 1, x);
        }
    }

    /// One more direction, from the residual; `false` if there is nothing new in it.
    fn extend(
        &mut self,
        a: &dyn LinearOperator,
        weights: &[f64],
        precondition: &mut impl FnMut(&mut [f64], &mut [f64]),
    ) -> bool {
        if self.pairs.len() == self.settings.size {
            self.spare.push(self.pairs.remove(0));
        }
        let mut pair = self.spare.pop().unwrap_or_default();
        let Pair { direction, image } = &mut pair;
        direction.resize(weights.len(), 0.0);
        image.resize(weights.len(), 0.0);
        self.work.clear();
        self.work.extend(self.residual.iter().zip(weights).map(|(r, w)| r / w));
        precondition(&mut self.work, direction);
        a.apply(direction, image);
        image.iter_mut().zip(weights).for_each(|(q, w)| *q *= w);
        let size = self.dot(image, image).sqrt();
        // Modified Gram and Schmidt: few vectors, and no more digits than the tolerance.
        for before in &self.pairs {
            let known = self.dot(&before.image, image);
            add(-known, &before.image, image);
            add(-known, &before.direction, direction);
        }
        let rest = self.dot(image, image).sqrt();
        let is_new = rest.is_finite() && rest > INDEPENDENT * size;
        if is_new {
            direction.iter_mut().chain(image).for_each(|x| *x /= rest);
            self.pairs.push(pair);
        } else {
            self.spare.push(pair);
        }
        is_new
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::{Csr, Kind, LinearSolver, MultifrontalLu, Options, Pattern, Unknown};
    use std::sync::Arc;

    const N: usize = 12;

    fn of(tolerance: f64) -> Gmres {
        Gmres::new(GmresSettings { tolerance, size: N })
    }

    /// Not symmetric, with rows of sizes from 1 to 1e8; `change` is added to some entries.
    fn matrix(change: f64) -> Csr {
        let rows: Vec<Vec<u32>> = (0..N).map(|_| (0..N as u32).collect()).collect();
        let mut a = Csr::zeros(&Arc::new(Pattern::from_rows(&rows)));
        for i in 0..N {
            for j in 0..N {
                let value = if i == j { 4.0 } else { ((3 * i + 5 * j * j) as f64).sin() };
                let value = value + if (i + j) % 5 == 1 { change } else { 0.0 };
                a.values[N * i + j] = row_size(i) * value;
            }
        }
        a
    }

    fn row_size(i: usize) -> f64 {
        10f64.powi(8 * (i % 2) as i32)
    }

    fn weights() -> Vec<f64> {
        (0..N).map(|i| 1.0 / row_size(i)).collect()
    }

    /// Right-hand side and solution.
    fn system(a: &Csr) -> (Vec<f64>, Vec<f64>) {
        let solution: Vec<f64> = (0..N).map(|i| 1.0 / (1.0 + i as f64)).collect();
        let mut b = vec![0.0; N];
        a.mul(&solution, &mut b);
        (b, solution)
    }

    fn factors(a: &Csr) -> impl FnMut(&mut [f64], &mut [f64]) + use<> {
        let unknowns: Vec<_> =
            (0..N).map(|i| Unknown { node: i as u32, kind: Kind::Velocity, at: [0.0; 3] }).collect();
        let mut solver = MultifrontalLu::multifrontal(Options::unprobed());
        solver.analyse(&a.pattern, &unknowns).unwrap();
        solver.factor(a).unwrap();
        move |r, z| solver.apply(r, z)
    }

    /// ‖W (b − A x)‖/‖W b‖ computed anew.
    fn reduction(a: &Csr, b: &[f64], x: &[f64]) -> f64 {
        let mut r = vec![0.0; N];
        a.residual(b, x, &mut r);
        let norm = |r: &[f64]| r.iter().zip(weights()).map(|(r, w)| (r * w).powi(2)).sum::<f64>().sqrt();
        norm(&r) / norm(b)
    }

    #[test]
    fn it_ends_at_the_tolerance_and_not_before() {
        let a = matrix(0.1);
        let (b, _) = system(&a);
        let mut precondition = factors(&matrix(0.0));
        let mut last = 0;
        for tolerance in [1e-1, 1e-2, 1e-4, 1e-8, 1e-13] {
            let (mut gmres, mut x) = (of(tolerance), vec![f64::NAN; N]);
            let report = gmres.solve(&a, &weights(), &mut precondition, &b, &mut x).unwrap();
            let found = reduction(&a, &b, &x);
            assert!(found <= tolerance * (1.0 + 1e-3) + 1e-15, "{tolerance}: {found}");
            assert!((found - report.reduction).abs() <= 1e-3 * found + 1e-14, "{report:?}: {found}");
            assert!(report.iterations >= last.max(1), "{report:?}");
            last = report.iterations;
            if report.iterations > 1 {
                gmres.settings.size = report.iterations - 1;
                gmres.clear();
                let error = gmres.solve(&a, &weights(), &mut precondition, &b, &mut x).unwrap_err();
                let SolverError::NotConverged { reduction: best, .. } = error else { panic!("{error}") };
                assert!(best > tolerance && (reduction(&a, &b, &x) / best - 1.0).abs() < 1e-3, "{error}");
            }
        }
        assert!(last > 3, "too easy");
    }

    /// Directions of one right-hand side serve the next.
    #[test]
    fn directions_are_used_again() {
        let a = matrix(0.1);
        let (b, _) = system(&a);
        let start = matrix(0.0);
        let (mut gmres, mut x) = (of(1e-10), vec![0.0; N]);
        let mut precondition = factors(&start);
        let first = gmres.solve(&a, &weights(), &mut precondition, &b, &mut x).unwrap().iterations;
        let half: Vec<f64> = b.iter().map(|b| 0.5 * b).collect();
        let report = gmres.solve(&a, &weights(), &mut precondition, &half, &mut x).unwrap();
        assert!(first > 1 && report.iterations == 0 && reduction(&a, &half, &x) < 2e-10, "{report:?}");
        let near: Vec<f64> = b.iter().enumerate().map(|(i, b)| b * (1.0 + 1e-4 * (i as f64).sin())).collect();
        let again = gmres.solve(&a, &weights(), &mut precondition, &near, &mut x).unwrap().iterations;
        gmres.clear();
        let anew = gmres.solve(&a, &weights(), &mut precondition, &near, &mut x).unwrap().iterations;
        assert!(again < anew && anew == first, "{again} {anew} {first}");
        assert!(reduction(&a, &near, &x) < 2e-10);
    }

    /// The Krylov space of n unknowns is exhausted after n iterations, whatever the preconditioner.
    #[test]
    fn n_iterations_are_exact() {
        let a = matrix(0.0);
        let (b, solution) = system(&a);
        let (mut gmres, mut x) = (of(1e-13), vec![0.0; N]);
        let by_rows = |r: &mut [f64], z: &mut [f64]| {
            z.iter_mut().zip(r).zip(weights()).for_each(|((z, r), w)| *z = w * *r);
        };
        let report = gmres.solve(&a, &weights(), by_rows, &b, &mut x).unwrap();
        assert_eq!(report.iterations, N);
        for (x, s) in x.iter().zip(&solution) {
            assert!((x - s).abs() < 1e-12, "{x} {s}");
        }
    }

    /// −x″ + c (x, 1) 1 without a matrix: differences of neighbours and a product of full rows.
    struct Stencil(f64);

    impl LinearOperator for Stencil {
        fn size(&self) -> usize {
            N
        }

        fn apply(&self, x: &[f64], y: &mut [f64]) {
            let at = |i: usize| x.get(i).copied().unwrap_or(0.0);
            let mean = self.0 * x.iter().sum::<f64>();
            for (i, y) in y.iter_mut().enumerate() {
                *y = 2.0 * at(i) - at(i.wrapping_sub(1)) - at(i + 1) + mean;
            }
        }
    }

    #[test]
    fn an_operator_need_not_be_a_matrix() {
        let (a, one) = (Stencil(0.1), [1.0; N]);
        let solution: Vec<f64> = (0..N).map(|i| (1.0 + i as f64).sqrt()).collect();
        let (mut b, mut x) = (vec![0.0; N], vec![0.0; N]);
        a.apply(&solution, &mut b);
        let mut gmres = of(1e-12);
        let report = gmres.solve(&a, &one, |r, z| z.copy_from_slice(r), &b, &mut x).unwrap();
        assert!(report.iterations > 1, "{report:?}");
        for (x, s) in x.iter().zip(&solution) {
            assert!((x - s).abs() < 1e-9, "{x} {s}");
        }
    }

    #[test]
    fn exact_factors_need_one_iteration() {
        let a = matrix(0.0);
        let (b, solution) = system(&a);
        let (mut gmres, mut x) = (of(1e-10), vec![0.0; N]);
        assert_eq!(gmres.solve(&a, &weights(), factors(&a), &b, &mut x).unwrap().iterations, 1);
        assert!(x.iter().zip(&solution).all(|(x, s)| (x - s).abs() < 1e-12));
        let report = gmres.solve(&a, &weights(), factors(&a), &[0.0; N], &mut x).unwrap();
        assert_eq!((report.iterations, x), (0, vec![0.0; N]));
    }

    #[test]
    fn numbers_that_are_not_finite_are_an_error() {
        let a = matrix(0.0);
        let (mut b, _) = system(&a);
        let mut x = vec![0.0; N];
        let mut gmres = of(1e-3);
        let spoilt = |_: &mut [f64], z: &mut [f64]| z.fill(f64::NAN);
        assert!(gmres.solve(&a, &weights(), spoilt, &b, &mut x).is_err());
        b[3] = f64::INFINITY;
        assert!(gmres.solve(&a, &weights(), factors(&a), &b, &mut x).is_err());
    }
}
