//! Histories, spectra and paths for the page.

use super::arrays::doubles;
use crate::digits::significant;
use crate::plot::figure::readable;
use serde_json::{Value, json};
use undula::functional::statistics::{Series, Statistics, Window, spectrum, summarize};
use undula::results::compare::Row;
use undula::results::computed::{Results, Signal};

/// Rows of the history on a page.
const ROWS: usize = 10_000;

/// Periods that a spectrum is computed from, where there are so many.
const PERIODS: f64 = 20.0;

/// Frequencies of a spectrum, in multiples of that of its signal.
const MULTIPLES: f64 = 8.0;

/// Solver columns of the history with what they are called.
const COUNTS: [(&str, &str); 4] = [
    ("newton_steps", "Newton iterations"),
    ("linear_iterations", "linear iterations"),
    ("jacobians", "Jacobians"),
    ("min_J", "smallest J"),
];

/// Histories for the page, and in words what is left out; `None` where nothing depends on time.
///
/// # Errors
/// None in practice: packing writes into memory.
pub fn histories(results: &Results, published: &[Row]) -> anyhow::Result<Option<(Value, Option<String>)>> {
    let Some(time) = results.history.column("time").filter(|t| t.len() > 1 && t[0] < t[t.len() - 1]) else {
        return Ok(None);
    };
    let signals = results.signals();
    let series: Vec<Series> = signals.iter().map(Signal::series).collect();
    let (window, statistics) = summarize(&series, results.leading());
    let every = time.len().div_ceil(ROWS);
    let mut values = vec![];
    for (signal, statistics) in signals.iter().zip(&statistics) {
        values.push(history(signal, statistics, window, published, &time, every)?);
    }
    let mut counts = vec![];
    for (column, label) in COUNTS {
        if let Some(values) = results.history.column(column) {
            let values = doubles(&thinned(&values, every))?;
            counts.push(
                json!({ "name": column, "label": label, "unit": "", "values": values, "force": false }),
            );
        }
    }
    let force_time = results.history.column("force_time").unwrap_or_else(|| time.clone());
    let value = json!({
        "time": doubles(&thinned(&time, every))?,
        "force_time": doubles(&thinned(&force_time, every))?,
        "signals": values,
        "counts": counts,
        "window": window.map(|window| [window.start, window.end]),
    });
    let left = (every > 1)
        .then(|| format!("Every {every}th of the {} rows of history.csv is on this page.", time.len()));
    Ok(Some((value, left)))
}

/// Every `every`th value and the last one.
fn thinned(values: &[f64], every: usize) -> Vec<f64> {
    let last = values.len() - 1;
    values.iter().enumerate().filter(|(n, _)| n % every == 0 || *n == last).map(|(_, &x)| x).collect()
}

fn history(
    signal: &Signal,
    statistics: &Statistics,
    window: Option<Window>,
    published: &[Row],
    time: &[f64],
    every: usize,
) -> anyhow::Result<Value> {
    let size = signal.values.iter().filter(|x| x.is_finite()).fold(0.0_f64, |size, x| size.max(x.abs()));
    let (factor, unit) = readable(size, &signal.unit);
    let shown: Vec<f64> = thinned(&signal.values, every).iter().map(|x| factor * x).collect();
    let of = |quantity: &str| {
        let row = published.iter().find(|row| row.functional == signal.name && row.quantity == quantity);
        row.filter(|row| row.primary).map(|row| factor * row.published)
    };
    let lines = match (of("mean"), of("amplitude"), of("value")) {
        (Some(mean), Some(amplitude), _) => vec![mean - amplitude, mean + amplitude],
        (_, _, Some(value)) => vec![value],
        _ => vec![],
    };
    let mut value = json!({
        "name": signal.name, "label": signal.name, "unit": unit, "factor": factor, "values": doubles(&shown)?,
        "about": in_words(statistics, factor, &unit), "published": lines, "force": signal.times != time,
    });
    if let (Some(frequency), Some(window)) = (statistics.frequency, window) {
        value["spectrum"] = lines_of(signal, frequency, window, factor)?;
    }
    Ok(value)
}

/// `mean ± amplitude, frequency` of what is periodic, or the last value.
pub fn in_words(statistics: &Statistics, factor: f64, unit: &str) -> String {
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let text = match (statistics.mean, statistics.amplitude) {
        (Some(mean), Some(amplitude)) => {
            let [mean, amplitude] = [mean, amplitude].map(|x| significant(factor * x, 5));
            let frequency =
                statistics.frequency.map_or(String::new(), |f| format!(", {} Hz", significant(f, 4)));
            format!("{mean} ± {amplitude}{unit}{frequency}")
        }
        _ => format!("last {}{unit}", significant(factor * statistics.last, 6)),
    };
    text.replace('-', "\u{2212}")
}

/// The spectrum of the last periods of a signal, up to some multiples of its frequency.
fn lines_of(signal: &Signal, frequency: f64, window: Window, factor: f64) -> anyhow::Result<Value> {
    let start = window.end - PERIODS * window.period();
    let inside = signal.times.iter().zip(&signal.values).filter(|(t, _)| (start..=window.end).contains(*t));
    let (times, values): (Vec<f64>, Vec<f64>) = inside.map(|(&t, &v)| (t, v)).unzip();
    let found = spectrum(&times, &values);
    let count = found.frequencies.iter().filter(|&&f| f <= MULTIPLES * frequency).count();
    let amplitudes: Vec<f64> = found.amplitudes[..count].iter().map(|a| factor * a).collect();
    Ok(json!({ "frequencies": doubles(&found.frequencies[..count])?, "amplitudes": doubles(&amplitudes)? }))
}
