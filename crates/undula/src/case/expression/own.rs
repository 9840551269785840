//! Functions of one argument that a program gives.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

type Value = dyn Fn(f64) -> f64 + Send + Sync;

/// A function of one argument with its derivative, for expressions of a case, see [`crate::CaseBuilder::function`].
#[derive(Clone)]
pub struct OwnFunction {
    value: Arc<Value>,
    slope: Arc<Value>,
}

impl OwnFunction {
    /// The function `value` with the derivative `slope`, which prescribed displacements need for the velocity and forces at
    /// moved places for their Jacobian. Both are called from several threads.
    ///
    /// ```
    /// let pulse = undula::OwnFunction::new(|t| t.sin().powi(2), |t| (2.0 * t).sin());
    /// ```
    pub fn new(
        value: impl Fn(f64) -> f64 + Send + Sync + 'static,
        slope: impl Fn(f64) -> f64 + Send + Sync + 'static,
    ) -> OwnFunction {
        OwnFunction { value: Arc::new(value), slope: Arc::new(slope) }
    }

    pub(super) fn value(&self, argument: f64) -> f64 {
        (self.value)(argument)
    }

    pub(super) fn slope(&self, argument: f64) -> f64 {
        (self.slope)(argument)
    }
}

/// Whether they are one object.
impl PartialEq for OwnFunction {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.value, &other.value) && Arc::ptr_eq(&self.slope, &other.slope)
    }
}

impl fmt::Debug for OwnFunction {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("OwnFunction")
    }
}

/// Functions of a program by their names.
#[derive(Clone, Debug, Default)]
pub(crate) struct Functions(pub BTreeMap<String, OwnFunction>);

impl Functions {
    /// None.
    pub(crate) const NONE: &Functions = &Functions(BTreeMap::new());
}
