//! The laws of outlets whose pressure depends on their flow.

use crate::case::error::CaseError;
use crate::case::expression::Expression;
use crate::case::{Case, Condition};
use crate::math::{rounded, shortest};
use crate::operators::outlet::Law;

/// The law of an outlet, `None` for another condition.
pub(super) fn law(condition: &Condition) -> Option<Law> {
    let at = |e: &Expression, t: f64| e.eval(&[0.0; 3], t);
    Some(match condition.clone() {
        Condition::Resistance { resistance, pressure } => {
            Law::Resistance(Box::new(move |t| [at(&resistance, t), at(&pressure, t)]))
        }
        Condition::Windkessel { proximal, capacitance, distal, pressure, initial: _ } => {
            let all = [proximal, capacitance, distal, pressure];
            Law::Windkessel(Box::new(move |t| std::array::from_fn(|i| at(&all[i], t))))
        }
        Condition::Flux { flow, .. } => Law::Flow(Box::new(move |t| [at(&flow, t)])),
        _ => return None,
    })
}

#[doc(hidden)]
impl Case {
    /// The mistake of a resistance or capacitance that becomes negative, or of a distal resistance that is not above 0.
    pub(super) fn negative_in_circuit(
        &self,
        condition: &Condition,
        (name, key): (&str, &str),
        data: &Expression,
        times: &[f64],
    ) -> Option<CaseError> {
        let least = match key {
            _ if !condition.is_lumped() => return None,
            "distal" => f64::MIN_POSITIVE,
            "resistance" | "proximal" | "capacitance" => 0.0,
            _ => return None,
        };
        let &t = times.iter().find(|&&t| data.eval(&[0.0; 3], t) < least)?;
        let value = data.eval(&[0.0; 3], t);
        let expected = if least > 0.0 { "above 0" } else { "of 0 or above" };
        let message = format!(
            "expected a value {expected} at all times; it is {} at t = {} s",
            shortest(rounded(value, value, 4)),
            shortest(t)
        );
        let key = format!("boundary.{name}.{key}");
        Some(CaseError {
            place: self.place_of(&key),
            key,
            value: Some(format!("{:?}", data.source())),
            message,
        })
    }
}
