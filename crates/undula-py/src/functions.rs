//! Functions of Python as functions of one argument in expressions of a case.

use pyo3::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};
use undula::OwnFunction;

/// Values that are remembered: a function is asked at all nodes of a boundary for the same few times.
const REMEMBERED: usize = 16;

/// What was raised first by a function of a case.
pub type Raised = Arc<Mutex<Option<PyErr>>>;

/// The function `f` of one number; `slope` is its derivative, by default a central difference.
///
/// An exception is put into `raised`, and the value is NaN, which ends the run.
pub fn own(f: Py<PyAny>, slope: Option<Py<PyAny>>, raised: &Raised) -> OwnFunction {
    let value = remembering(f, raised.clone());
    let value = Arc::new(value);
    let of = value.clone();
    match slope {
        Some(slope) => {
            let slope = remembering(slope, raised.clone());
            OwnFunction::new(move |a| of(a), slope)
        }
        None => OwnFunction::new(
            move |a| of(a),
            move |a: f64| {
                let h = 1e-6 * a.abs().max(1.0);
                (value(a + h) - value(a - h)) / (2.0 * h)
            },
        ),
    }
}

/// A call of `f` that remembers its last values.
fn remembering(f: Py<PyAny>, raised: Raised) -> impl Fn(f64) -> f64 + Send + Sync + 'static {
    let known: Mutex<Vec<(u64, f64)>> = Mutex::default();
    move |argument: f64| {
        let bits = argument.to_bits();
        let found = {
            let known = known.lock().unwrap_or_else(PoisonError::into_inner);
            known.iter().find(|(other, _)| *other == bits).map(|(_, value)| *value)
        };
        // The lock is not held meanwhile: who waits for it may hold the interpreter.
        let ask = || {
            let asked =
                Python::attach(|py| f.bind(py).call1((argument,)).and_then(|value| value.extract::<f64>()));
            asked.unwrap_or_else(|error| {
                let mut raised = raised.lock().unwrap_or_else(PoisonError::into_inner);
                raised.get_or_insert(error);
                f64::NAN
            })
        };
        found.unwrap_or_else(|| {
            let value = ask();
            let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
            if known.len() == REMEMBERED {
                known.remove(0);
            }
            known.push((bits, value));
            value
        })
    }
}
