//! The velocity-deformation relation u − u⁻ = k (θ v + (1 − θ) v⁻) at the nodes of the solid.

use crate::physics::StepRule;
use crate::space::{PsiOwner, State};
use crate::system::Assembler;

/// Places in u of the solid that are not given.
pub(super) fn places<const D: usize>(assembler: &Assembler<D>) -> impl Iterator<Item = usize> + '_ {
    let (space, given) = (&assembler.space, &assembler.constraints.u);
    let nodes = (0..if space.deforms { space.nodes.len() } else { 0 })
        .filter(|&node| space.owner[node] == PsiOwner::Relation);
    let free = move |node: usize| (0..D).filter(move |&i| !given[node][i]).map(move |i| node * D + i);
    nodes.flat_map(free)
}

/// Make `new` satisfy it; `tell` gets what is subtracted from each entry of u.
pub(super) fn impose<const D: usize>(
    assembler: &Assembler<D>,
    rule: StepRule,
    new: &mut State,
    old: &State,
    mut tell: impl FnMut(usize, f64),
) {
    let k = 1.0 / rule.per_k;
    for at in places(assembler) {
        let u = old.u[at] + k * (rule.theta * new.v[at] + (1.0 - rule.theta) * old.v[at]);
        tell(at, new.u[at] - u);
        new.u[at] = u;
    }
}
