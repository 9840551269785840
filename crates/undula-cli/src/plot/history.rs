//! Functionals over time, and paths of points.

use super::colors::{GREY, GRID, INK, LINES};
use super::figure::{Anchor, Figure, Panel, labelled, readable};
use std::path::{Path, PathBuf};
use undula::functional::statistics::{Statistics, Window, summarize};
use undula::results::computed::{Results, Signal as Computed};

/// Periods in the zoom.
const PERIODS: f64 = 5.0;

/// Band behind the curve that the zoom shows.
const BAND: [u8; 3] = [242, 242, 246];

/// One functional, in readable units.
struct Signal {
    name: String,
    unit: String,
    times: Vec<f64>,
    values: Vec<f64>,
    /// `None` for the smallest J.
    statistics: Option<Statistics>,
}

/// Writes `history.{svg,png}` and `path_POINT.{svg,png}`; nothing for stationary runs.
pub fn plot(results: &Results, into: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let Some(times) = results.history.column("time").filter(|t| t.len() > 1 && t[0] < t[t.len() - 1]) else {
        return Ok(Vec::new());
    };
    let (signals, window) = signals(results, &times);
    let case = &results.summary.case;
    let mut written = stacked(&signals, &times, window, case)?.save(&into.join("history"))?;
    for x in &signals {
        let Some(point) = x.name.strip_prefix("ux_") else { continue };
        let Some(y) = signals.iter().find(|y| y.name == format!("uy_{point}")) else { continue };
        let stem = into.join(format!("path_{}", point.replace(|c: char| !c.is_alphanumeric(), "_")));
        written.extend(path(x, y, window, point, case).save(&stem)?);
    }
    Ok(written)
}

/// All functionals with their statistics, then the smallest J; and the period of the statistics.
fn signals(results: &Results, times: &[f64]) -> (Vec<Signal>, Option<Window>) {
    let mut computed = results.signals();
    for Computed { values, unit, .. } in &mut computed {
        let size = values.iter().filter(|v| v.is_finite()).fold(0.0_f64, |size, v| size.max(v.abs()));
        let (factor, shown) = readable(size, unit);
        values.iter_mut().for_each(|v| *v *= factor);
        *unit = shown;
    }
    let series: Vec<_> = computed.iter().map(Computed::series).collect();
    let (window, found) = summarize(&series, results.leading());
    let with = |(Computed { name, unit, times, values }, found): (Computed, Statistics)| Signal {
        name,
        unit,
        times,
        values,
        statistics: Some(found),
    };
    let mut signals: Vec<Signal> = computed.into_iter().zip(found).map(with).collect();
    signals.extend(results.history.column("min_J").map(|values| Signal {
        name: "min_J".into(),
        unit: String::new(),
        times: times.to_vec(),
        values,
        statistics: None,
    }));
    (signals, window)
}

/// All functionals over the run, and over the last periods.
fn stacked(signals: &[Signal], times: &[f64], window: Option<Window>, case: &str) -> anyhow::Result<Figure> {
    const HEIGHT: f64 = 104.0;
    const PITCH: f64 = 146.0;
    const TOP: f64 = 60.0;
    let (first, last) = (times[0].min(0.0).max(times[0] - times[1].abs()), times[times.len() - 1]);
    let zoom = window.map(|w| ((last - PERIODS * w.period()).max(first), last)).filter(|z| z.0 > first);
    let ranges: Vec<(f64, f64)> = std::iter::once((first, last)).chain(zoom).collect();
    let widths: &[f64] = if ranges.len() == 2 { &[500.0, 340.0] } else { &[880.0] };
    let panels: Vec<Vec<Panel>> = ranges
        .iter()
        .zip(widths)
        .map(|(&x, &width)| {
            let panel = |(n, s): (usize, &Signal)| {
                let top = TOP + PITCH * n as f64;
                Panel { left: 0.0, top, width, height: HEIGHT, x, y: span(s, x), logarithmic: false }
            };
            signals.iter().enumerate().map(panel).collect()
        })
        .collect();
    let margins: Vec<f64> =
        panels.iter().map(|column| column.iter().map(Panel::margin).fold(0.0, f64::max)).collect();
    let width = margins.iter().zip(widths).map(|(m, w)| 12.0 + m + w).sum::<f64>() + 16.0;
    let mut figure = Figure::new(width, TOP + PITCH * signals.len() as f64 + 18.0);
    let mut left = 12.0;
    for (c, column) in panels.into_iter().enumerate() {
        left += margins[c];
        for (n, (mut panel, s)) in column.into_iter().zip(signals).enumerate() {
            panel.left = left;
            if let (0, Some(zoom)) = (c, zoom) {
                let from = panel.at(zoom.0, panel.y.1);
                figure.fill([from.0, from.1, left + panel.width - from.0, HEIGHT], BAND);
            }
            panel.grid(&mut figure);
            panel.graph(
                &mut figure,
                &s.times,
                &s.values,
                LINES[n % LINES.len()],
                if c == 0 { 1.2 } else { 1.6 },
            );
            let last = n + 1 == signals.len();
            let label = labelled(&s.name.replace("min_J", "min J"), &s.unit);
            panel.axes(&mut figure, last.then_some("t [s]"), if c == 0 { &label } else { "" });
            if c + 1 == ranges.len() {
                let at = (left + panel.width, panel.top - 9.0);
                figure.text(at, &in_words(s), 12, Anchor::End, GREY);
            }
        }
        left += widths[c] + 12.0;
    }
    figure.text((12.0 + margins[0], 24.0), case, 16, Anchor::Start, INK);
    Ok(figure)
}

/// Vertical range of a signal within a range of time, with some air.
fn span(signal: &Signal, x: (f64, f64)) -> (f64, f64) {
    let inside =
        signal.times.iter().zip(&signal.values).filter(|(t, v)| (x.0..=x.1).contains(*t) && v.is_finite());
    let mut values: Vec<f64> = inside.map(|(_, &v)| v).collect();
    values.sort_by(f64::total_cmp);
    let Some((&low, &high)) = values.first().zip(values.last()) else { return (0.0, 1.0) };
    // A few spikes, as of an impulsive start, may leave the panel.
    let tail = values.len() / 200;
    let (common_low, common_high) = (values[tail], values[values.len() - 1 - tail]);
    let air = 0.3 * (common_high - common_low);
    let spiky = high - low > 4.0 * (common_high - common_low) && common_high > common_low;
    let (low, high) =
        if spiky { (low.max(common_low - air), high.min(common_high + air)) } else { (low, high) };
    let size = low.abs().max(high.abs());
    let air = (0.06 * (high - low)).max(1e-6 * size).max(f64::MIN_POSITIVE.sqrt());
    if size == 0.0 { (-1.0, 1.0) } else { (low - air, high + air) }
}

/// `mean ± amplitude [frequency]` of what is periodic, or the last value.
fn in_words(signal: &Signal) -> String {
    let Some(s) = signal.statistics else {
        let min = signal.values.iter().copied().fold(f64::INFINITY, f64::min);
        return format!("min {min:.4}").replace('-', "\u{2212}");
    };
    let unit = if signal.unit.is_empty() { String::new() } else { format!(" {}", signal.unit) };
    match (s.mean, s.amplitude) {
        (Some(mean), Some(amplitude)) => {
            // Four digits of the amplitude.
            let digits = (3.0 - amplitude.log10().floor()).clamp(0.0, 9.0) as usize;
            let frequency = s.frequency.map_or(String::new(), |f| format!(", {f:.4} Hz"));
            format!("{mean:.digits$} ± {amplitude:.digits$}{unit}{frequency}").replace('-', "\u{2212}")
        }
        _ => {
            let digits = (4.0 - s.last.abs().max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize;
            format!("{:.digits$}{unit}", s.last).replace('-', "\u{2212}")
        }
    }
}

/// u_y over u_x: all of it in grey, the last periods in colour.
fn path(x: &Signal, y: &Signal, window: Option<Window>, point: &str, case: &str) -> Figure {
    let end = x.times.last().copied().unwrap_or(0.0);
    let late = window.map_or(f64::NEG_INFINITY, |w| end - PERIODS * w.period());
    let first = x.times.partition_point(|&t| t < late);
    let range = (late, f64::INFINITY);
    let mut panel = Panel {
        left: 0.0,
        top: 60.0,
        width: 420.0,
        height: 420.0,
        x: span(x, range),
        y: span(y, range),
        logarithmic: false,
    };
    panel.left = 12.0 + panel.margin();
    let mut figure = Figure::new(panel.left + panel.width + 24.0, panel.top + panel.height + 54.0);
    panel.grid(&mut figure);
    panel.path(&mut figure, &x.values[..first], &y.values[..first], GRID.map(|c| c - 20), 0.8);
    panel.path(&mut figure, &x.values[first..], &y.values[first..], LINES[0], 1.5);
    let label = |name: &str, unit: &str| labelled(&format!("{name}({point})"), unit);
    panel.axes(&mut figure, Some(&label("ux", &x.unit)), &label("uy", &y.unit));
    let title = match window {
        Some(_) if first > 0 => format!("{case}, path of {point} in the last {PERIODS} periods"),
        _ => format!("{case}, path of {point}"),
    };
    figure.text((panel.left, 24.0), &title, 14, Anchor::Start, INK);
    figure
}
