//! Which term against flow that comes in holds on a boundary.

use super::conditions::Condition;
use super::schema::Case;
use crate::space::Against;

impl Condition {
    /// The term that holds unless a case gives another: a given pressure makes an inlet, through which flow comes straight in.
    pub(super) fn against(&self) -> Against {
        match self {
            Condition::Pressure { .. } => Against::Tangential,
            _ => Against::None,
        }
    }
}

impl Case {
    /// The term against flow that comes in through the boundary `name`, as far as it is one of the fluid.
    pub fn against(&self, name: &str) -> Against {
        let of_condition = || self.boundary.get(name).map_or(Against::None, Condition::against);
        self.backflow.get(name).copied().unwrap_or_else(of_condition)
    }
}
