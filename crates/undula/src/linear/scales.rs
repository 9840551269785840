//! The units of the equations: residuals of all of them beside each other.

use crate::algebra::{self, Sizes};
use crate::parallel::Reduce;
use crate::space::{FsiSpace, PsiOwner, State};

/// Weights that give the residuals of all equations the unit of a velocity.
///
/// The equations carry different units, so each has its own: momentum k/(ρ ĥ^D), divergence 1/ĥ^(D−1),
/// extension 1/(E_e k ĥ^(D−2)), velocity-deformation relation 1/ĥ^D, with the mean distance ĥ of nodes. A stationary
/// solution takes for k the time in which momentum, or else an elastic wave, gets from node to node. Nothing here
/// is a number of its own: the iteration is the same in every system of units.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Scales {
    /// ρ ĥ^D \[kg\].
    pub mass: f64,
    /// ĥ \[m\].
    pub size: f64,
    /// Largest E_e.
    pub stiffness: f64,
    /// ν of the fluid \[m²/s\], 0 without.
    pub viscosity: f64,
    /// Square of the speed of elastic waves, as if the solid had the density ρ \[m²/s²\]; 0 without solid.
    pub wave: f64,
}

/// A velocity, a deformation and a pressure are rounded to this part of themselves, and some more in sums over cells.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The same for stresses of the solid, which come from a deformation gradient of size 1.
const ROUNDING_OF_STRESS: f64 = 4.0 * f64::EPSILON;

/// Pressures count as much as this share of what would stop a velocity within a step: few columns of a row of
/// momentum are pressures, but they must not decide on the pivots of velocities.
const PRESSURE: f64 = 1e-3;

/// Scaled maximum norms of the equations \[m/s\].
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct BlockNorms {
    /// Momentum.
    pub momentum: f64,
    /// Divergence.
    pub divergence: f64,
    /// Extension.
    pub extension: f64,
    /// Velocity-deformation relation.
    pub relation: f64,
}

impl BlockNorms {
    /// The largest.
    pub fn max(&self) -> f64 {
        self.momentum.max(self.divergence).max(self.extension).max(self.relation)
    }
}

impl Scales {
    /// Those on `space` of a density ρ \[kg/m³\], the viscosity ν of the fluid \[m²/s\], 0 without, the modulus of
    /// elastic waves in the solid \[Pa\], 0 without, and the largest E_e.
    pub fn new<const D: usize>(
        space: &FsiSpace<D>,
        density: f64,
        viscosity: f64,
        modulus: f64,
        stiffness: f64,
    ) -> Scales {
        let size = space.node_distance();
        let mass = (0..D).fold(density, |mass, _| mass * size);
        Scales { mass, size, stiffness, viscosity, wave: modulus / density }
    }

    /// k, or what stands for it in a stationary solution: ĥ²/ν, without a fluid ĥ/c.
    pub fn step(&self, per_k: f64) -> f64 {
        if per_k > 0.0 {
            1.0 / per_k
        } else if self.viscosity > 0.0 {
            self.size * self.size / self.viscosity
        } else {
            self.size / self.wave.sqrt()
        }
    }

    /// Typical sizes of a velocity, a deformation and a pressure beside each other, for a step with 1/k = `per_k`.
    pub fn sizes<const D: usize>(&self, per_k: f64) -> Sizes {
        let k = self.step(per_k);
        let pressure = PRESSURE * self.mass / (self.size.powi(D as i32 - 1) * k);
        Sizes { velocity: 1.0, deformation: k, pressure }
    }

    /// Scaled residual \[m/s\] that rounding leaves of a solution like `state`, in a step with 1/k = `per_k`: nothing
    /// where all is at rest. Displacements of `space` that take away a stress at rest count.
    pub fn rounding<const D: usize>(&self, space: &FsiSpace<D>, state: &State, per_k: f64) -> f64 {
        let (k, h) = (self.step(per_k), self.size);
        let mut sizes =
            [&state.v, &state.u, &state.p, &space.fabrics.unloading].map(|x| algebra::norm_inf(x));
        space.reduce(Reduce::Max, &mut sizes);
        let [v, u, p, unloading] = sizes;
        let u = u.max(unloading);
        let flow =
            v * (1.0 + k * (self.viscosity / h + v) / h) + u / k + p * h.powi(D as i32 - 1) * k / self.mass;
        let stress = if u > 0.0 { self.wave * k / h } else { 0.0 };
        ROUNDING * flow + ROUNDING_OF_STRESS * stress
    }

    /// Factors `[v, u, p]` of the rows that give their residuals this unit, for a step with 1/k = `per_k`.
    pub fn weights<const D: usize>(&self, space: &FsiSpace<D>, per_k: f64, out: &mut [f64]) {
        let k = self.step(per_k);
        let (v, rest) = out.split_at_mut(space.n_v());
        let (u, p) = rest.split_at_mut(space.n_u());
        v.fill(k / self.mass);
        p.fill(1.0 / self.size.powi(D as i32 - 1));
        for (u, owner) in u.chunks_exact_mut(D).zip(&space.owner) {
            u.fill(match owner {
                PsiOwner::Extension => 1.0 / (self.stiffness * k * self.size.powi(D as i32 - 2)),
                PsiOwner::Relation => 1.0 / self.size.powi(D as i32),
            });
        }
    }

    /// Norms of the residual `r` in the order v, u, p for a step with 1/k = `per_k`, over the rows of all processes; `None`
    /// if not finite.
    pub fn norms<const D: usize>(&self, space: &FsiSpace<D>, per_k: f64, r: &[f64]) -> Option<BlockNorms> {
        if space.part.is_none() {
            return self.norms_of(space, per_k, r);
        }
        let here = self.norms_of(space, per_k, &space.own_rows(r));
        let numbers = |n: BlockNorms| [n.momentum, n.divergence, n.extension, n.relation];
        let mut all = here.map_or([f64::NAN; 4], numbers);
        space.reduce(Reduce::Max, &mut all);
        let [momentum, divergence, extension, relation] = all;
        all.iter().all(|norm| norm.is_finite()).then_some(BlockNorms {
            momentum,
            divergence,
            extension,
            relation,
        })
    }

    /// The same of the rows of this process.
    fn norms_of<const D: usize>(&self, space: &FsiSpace<D>, per_k: f64, r: &[f64]) -> Option<BlockNorms> {
        let k = self.step(per_k);
        let (n_v, n_u) = (space.n_v(), space.n_u());
        let mut n = BlockNorms {
            momentum: norm_inf(&r[..n_v])? * k / self.mass,
            divergence: norm_inf(&r[n_v + n_u..])? / self.size.powi(D as i32 - 1),
            ..BlockNorms::default()
        };
        norm_inf(&r[n_v..n_v + n_u])?;
        for (r, owner) in r[n_v..n_v + n_u].chunks_exact(D).zip(&space.owner) {
            let size = r.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            let max = match owner {
                PsiOwner::Extension => &mut n.extension,
                PsiOwner::Relation => &mut n.relation,
            };
            *max = max.max(size);
        }
        n.extension /= self.stiffness * k * self.size.powi(D as i32 - 2);
        n.relation /= self.size.powi(D as i32);
        Some(n)
    }
}

/// Largest absolute value; `None` if one is not finite.
fn norm_inf(r: &[f64]) -> Option<f64> {
    Some(algebra::norm_inf(r)).filter(|norm| norm.is_finite())
}
