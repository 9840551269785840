//! The velocity-deformation relation u − u⁻ = k (θ v + (1 − θ) v⁻) at the nodes of the solid.

use crate::physics::StepRule;
use crate::space::{PsiOwner, State};
use crate::system::Assembler;

/// Nodes of the solid whose deformation is not given.
pub(super) fn nodes<const D: usize>(assembler: &Assembler<D>) -> impl Iterator<Item = usize> + '_ {
    let (space, given) = (&assembler.space, &assembler.constraints.u);
    let free = |&node: &usize| space.owner[node] == PsiOwner::Relation && given[node] == [false; D];
    (0..if space.deforms { space.nodes.len() } else { 0 }).filter(free)
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
    for node in nodes(assembler) {
        for at in node * D..(node + 1) * D {
            let u = old.u[at] + k * (rule.theta * new.v[at] + (1.0 - rule.theta) * old.v[at]);
            tell(at, new.u[at] - u);
            new.u[at] = u;
        }
    }
}
