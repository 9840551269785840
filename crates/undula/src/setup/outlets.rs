//! The laws of outlets whose pressure depends on their flow.

use crate::case::Condition;
use crate::case::expression::Expression;
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
        Condition::Flux(flow) => Law::Flow(Box::new(move |t| [at(&flow, t)])),
        _ => return None,
    })
}
