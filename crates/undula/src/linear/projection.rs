//! Velocities of the fluid that are discretely free of divergence.

use super::factors::{MakeSolver, Purpose};
use crate::algebra::{Csr, Pattern, SolverError};
use crate::physics::StepRule;
use crate::space::{ClosedPressure, PsiOwner, Region, State};
use crate::system::{Assembler, StepView};
use crate::tangent::{Linearization, Tangent};
use std::sync::Arc;

/// Marks an unknown that stays.
const STAYS: u32 = u32::MAX;

/// Part of the flow into a closed part of the fluid that is rounding.
const BALANCED: f64 = 1e-9;
/// A part of the fluid whose whole boundary has a given velocity or is the interface.
pub struct Closed {
    /// Its pressure.
    pub pressure: ClosedPressure,
    /// What flows through its boundary, about ½ ∫ |v| ds \[m^D/s\].
    pub through: f64,
}

/// Part of it by which velocities that are interpolated at the nodes may fail to balance.
const INTERPOLATED: f64 = 0.01;

/// Make v in the fluid the nearest velocity in L² that is discretely free of divergence: with p as multiplier
///
/// (ρ J (v − v₀), φ)/k − (p J F⁻ᵀ, ∇φ) = 0, (J F⁻¹ : ∇vᵀ, ξ) = 0,
///
/// J and F those of u. v₀, given velocities and v in the solid, that of the interface included, are those of `state`
/// [m/s] and stay, and so do u and p. The `closed` pressures are zero: one of each part of the fluid whose whole boundary
/// has a given velocity, but for those that the equations know already. `k` \[s\] has no effect without stabilisation.
///
/// Returns whether as much flows into each closed part as out of it; `state` is as before if not. Velocities of the interface
/// change a little where they and those of the boundaries balance up to their interpolation only.
///
/// # Errors
/// If the system cannot be solved.
pub(super) fn project<const D: usize>(
    assembler: &mut Assembler<D>,
    make: &MakeSolver,
    k: f64,
    closed: &[Closed],
    state: &mut State,
) -> Result<bool, SolverError> {
    // With θ = 0 nothing is left of the momentum but mass and pressure.
    let rule = StepRule { per_k: 1.0 / k, theta: 0.0, ..StepRule::STATIONARY };
    let mut old = State { p: vec![0.0; state.p.len()], ..state.clone() };
    let mut whole = Csr::zeros(&assembler.try_pattern()?);
    let mut r = vec![0.0; assembler.n_unknowns()];
    let view = StepView { rule, new: &old, old: &old };
    assembler.residual(&view, &mut r);
    assembler.matrix(&view, Linearization::Newton, Tangent::Automatic, &mut whole);
    if !closed.iter().all(|part| balance(assembler, &whole, &r, part, &mut old.v)) {
        return Ok(false);
    }
    let view = StepView { rule, new: &old, old: &old };
    r.fill(0.0);
    assembler.residual(&view, &mut r);
    // v₀ satisfies the momentum: what outlets add at the old time has no part in it.
    r[..old.v.len()].fill(0.0);
    let fixed: Vec<u32> = closed.iter().map(|part| part.pressure.fixed).collect();
    let (numbers, places) = numbers(assembler, &fixed);
    let matrix = part(&whole, &numbers, &places);
    let all = assembler.unknowns();
    let unknowns: Vec<_> = places.iter().map(|&place| all[place as usize]).collect();
    let mut solver = make(Purpose::Exact);
    solver.analyse(&matrix.pattern, &unknowns)?;
    solver.factor(&matrix)?;
    let b: Vec<f64> = places.iter().map(|&place| r[place as usize]).collect();
    let mut x = vec![0.0; places.len()];
    solver.solve(&matrix, &b, &mut x)?;
    let mut v = old.v.clone();
    for (&place, x) in places.iter().zip(&x) {
        if let Some(v) = v.get_mut(place as usize) {
            *v -= x;
        }
    }
    let new = State { v, ..old };
    r.fill(0.0);
    assembler.residual(&StepView { rule, new: &new, old: &new }, &mut r);
    let first = assembler.space.n_v() + assembler.space.n_u();
    let keeps = closed.iter().all(|Closed { pressure, through }| {
        let row = first + pressure.fixed as usize;
        let terms = whole.pattern.row(row).map(|at| {
            new.v.get(whole.pattern.column(row, at) as usize).map_or(0.0, |v| (whole.values[at] * v).abs())
        });
        r[row].abs() <= BALANCED * (through + terms.sum::<f64>())
    });
    if keeps {
        state.v = new.v;
    }
    Ok(keeps)
}

/// Makes the flow through the boundary of a closed part of the fluid 0 by the smallest change of v at the free nodes of the
/// interface; returns whether that is as small as errors of an interpolation are. `r` is the residual of v.
fn balance<const D: usize>(
    assembler: &Assembler<D>,
    whole: &Csr,
    r: &[f64],
    Closed { pressure, through }: &Closed,
    v: &mut [f64],
) -> bool {
    let (space, given) = (&assembler.space, assembler.is_given());
    let rows = || pressure.constant().iter().map(|&dof| space.n_v() + space.n_u() + dof as usize);
    let net: f64 = rows().map(|row| r[row]).sum();
    if net.abs() <= BALANCED * through {
        return true;
    }
    // ∫ φ J F⁻ᵀ n ds of each velocity.
    let mut outflow = vec![0.0; v.len()];
    for row in rows() {
        for (&column, value) in whole.pattern.columns(row).iter().zip(&whole.values[whole.pattern.row(row)]) {
            outflow.get_mut(column as usize).into_iter().for_each(|sum| *sum += value);
        }
    }
    let free = |place: &usize| space.owner[place / D] == PsiOwner::Relation && !given[*place];
    let square: f64 = (0..v.len()).filter(free).map(|place| outflow[place] * outflow[place]).sum();
    if square == 0.0 || net.abs() > INTERPOLATED * through {
        return false;
    }
    (0..v.len()).filter(free).for_each(|place| v[place] -= net * outflow[place] / square);
    true
}

/// The number in the system of each unknown `[v, u, p]`, and the place of each unknown of the system.
fn numbers<const D: usize>(assembler: &Assembler<D>, closed: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let space = &assembler.space;
    let given = assembler.is_given();
    let mut numbers = vec![STAYS; given.len()];
    let free = (0..space.n_v()).filter(|place| space.owner[place / D] == PsiOwner::Extension);
    let first = space.n_v() + space.n_u();
    let cells = (0..space.mesh.n_cells()).filter(|&cell| space.regions[cell] == Region::Fluid);
    let mut places: Vec<u32> = free.map(|place| place as u32).collect();
    for cell in cells {
        let dofs = space.pressure.cell(cell).iter().filter(|dof| !closed.contains(dof));
        places.extend(dofs.map(|dof| first as u32 + dof));
    }
    places.sort_unstable();
    places.dedup();
    places.retain(|&place| !given[place as usize]);
    for (number, &place) in places.iter().enumerate() {
        numbers[place as usize] = number as u32;
    }
    (numbers, places)
}

/// Rows and columns of `whole` that have a number.
fn part(whole: &Csr, numbers: &[u32], places: &[u32]) -> Csr {
    let stored = |place: &u32| {
        let row = *place as usize;
        let entries = whole.pattern.columns(row).iter().zip(&whole.values[whole.pattern.row(row)]);
        entries.map(|(&column, &value)| (numbers[column as usize], value))
    };
    let kept = |place: &u32| stored(place).filter(|(column, _)| *column != STAYS);
    let rows: Vec<Vec<u32>> =
        places.iter().map(|place| kept(place).map(|(column, _)| column).collect()).collect();
    let values = places.iter().flat_map(|place| kept(place).map(|(_, value)| value)).collect();
    Csr { pattern: Arc::new(Pattern::from_rows(&rows)), values }
}
