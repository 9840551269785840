//! Numbers of signals over a stretch of time, for expressions of a study.

use crate::functional::statistics::{leading_window, maximum, minimum, spectrum, statistics, value_at};
use crate::results::computed::Signal;

/// A function of signals and numbers.
pub(super) struct Measure {
    name: &'static str,
    /// How many signals it takes, which come first.
    pub signals: usize,
    /// How many numbers follow.
    pub numbers: usize,
    /// Its arguments in words.
    pub usage: &'static str,
    /// Its value; `None` where there is none.
    pub compute: fn(&[&Signal], &[f64]) -> Option<f64>,
}

const fn measure(
    name: &'static str,
    signals: usize,
    numbers: usize,
    usage: &'static str,
    compute: fn(&[&Signal], &[f64]) -> Option<f64>,
) -> Measure {
    Measure { name, signals, numbers, usage, compute }
}

const OVER: &str = "a signal, the first and the last time";
const LINE: &str = "a signal, the first and the last time, the lowest and the highest frequency";

static MEASURES: [Measure; 15] = [
    measure("at", 1, 1, "a signal and a time", |s, n| value_at(&s[0].times, &s[0].values, n[0])),
    measure("highest", 1, 2, OVER, |s, n| extremes(s[0], n).map(|(_, high)| high)),
    measure("lowest", 1, 2, OVER, |s, n| extremes(s[0], n).map(|(low, _)| low)),
    measure("middle", 1, 2, OVER, |s, n| extremes(s[0], n).map(|(low, high)| 0.5 * (high + low))),
    measure("amplitude", 1, 2, OVER, |s, n| extremes(s[0], n).map(|(low, high)| 0.5 * (high - low))),
    measure("average", 1, 2, OVER, |s, n| average(&over(s[0], n))),
    measure("total", 1, 2, OVER, |s, n| Some(steps(s[0], n).map(|(_, value)| value).sum())),
    measure("frequency", 1, 2, OVER, |s, n| frequency(&over(s[0], n))),
    measure("line", 1, 4, LINE, |s, n| line(s[0], n).map(|(_, amplitude)| amplitude)),
    measure("line_frequency", 1, 4, LINE, |s, n| line(s[0], n).map(|(frequency, _)| frequency)),
    measure("zigzag", 1, 2, OVER, |s, n| zigzags(s[0], n).map(|(_, size)| size).reduce(f64::max)),
    measure("onset", 1, 3, "a signal, a level, the first and the last time", |s, n| {
        Some(zigzags(s[0], &n[1..]).find(|(_, size)| *size > n[0]).map_or(n[2], |(time, _)| time))
    }),
    measure("distance", 2, 2, "two signals, the first and the last time", distance),
    measure("prominence", 1, 4, LINE, prominence),
    measure("order", 0, 2, "the errors on a mesh, or with a step, and on one of half the size", |_, n| {
        Some((n[0] / n[1]).log2())
    }),
];

/// The function of this name.
pub(super) fn of(name: &str) -> Option<&'static Measure> {
    MEASURES.iter().find(|measure| measure.name == name)
}

/// Samples from the time `n[0]` to `n[1]`, those of the step that reaches past `n[1]` by rounding included.
fn steps<'a>(signal: &'a Signal, n: &[f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
    let (start, end) = (n[0], n[1]);
    let margin = 1e-9 * end.abs().max(start.abs());
    let samples = signal.times.iter().copied().zip(signal.values.iter().copied());
    samples.filter(move |(t, _)| (start - margin..=end + margin).contains(t))
}

fn over(signal: &Signal, n: &[f64]) -> Signal {
    let (times, values) = steps(signal, n).unzip();
    Signal { name: signal.name.clone(), unit: signal.unit.clone(), times, values }
}

/// Lowest and highest value, by parabolas; of counts the samples themselves.
fn extremes(signal: &Signal, n: &[f64]) -> Option<(f64, f64)> {
    let part = over(signal, n);
    if part.values.iter().all(|value| value.fract() == 0.0) {
        let samples = || part.values.iter().copied();
        return samples().reduce(f64::min).zip(samples().reduce(f64::max));
    }
    Some((minimum(&part.times, &part.values)?.value, maximum(&part.times, &part.values)?.value))
}

/// Integral by the trapezoidal rule over the length.
fn average(signal: &Signal) -> Option<f64> {
    let (first, last) = signal.span()?;
    let pairs = signal.times.windows(2).zip(signal.values.windows(2));
    let integral: f64 = pairs.map(|(t, v)| 0.5 * (t[1] - t[0]) * (v[0] + v[1])).sum();
    Some(integral / (last - first))
}

fn frequency(signal: &Signal) -> Option<f64> {
    let window = leading_window(&signal.times, &signal.values)?;
    statistics(&signal.times, &signal.values, Some(window)).frequency
}

/// Frequency and amplitude of the highest line between two frequencies.
fn line(signal: &Signal, n: &[f64]) -> Option<(f64, f64)> {
    let part = over(signal, n);
    let spectrum = spectrum(&part.times, &part.values);
    let lines = spectrum.frequencies.into_iter().zip(spectrum.amplitudes);
    lines.filter(|(f, _)| (n[2]..=n[3]).contains(f)).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// The highest peak between two frequencies over the median of the lines there: a line that is higher than those beside
/// it; 1 where there is none.
fn prominence(signals: &[&Signal], n: &[f64]) -> Option<f64> {
    let part = over(signals[0], n);
    let spectrum = spectrum(&part.times, &part.values);
    let a = &spectrum.amplitudes;
    let inside: Vec<usize> =
        (0..a.len()).filter(|&i| (n[2]..=n[3]).contains(&spectrum.frequencies[i])).collect();
    let mut lines: Vec<f64> = inside.iter().map(|&i| a[i]).collect();
    lines.sort_by(f64::total_cmp);
    let median = *lines.get(lines.len() / 2)?;
    let is_peak = |i: &usize| *i > 0 && *i + 1 < a.len() && a[*i] > a[*i - 1] && a[*i] > a[*i + 1];
    let highest = inside.into_iter().filter(is_peak).map(|i| a[i]).reduce(f64::max);
    Some(highest.map_or(1.0, |highest| highest / median))
}

/// Times with the amplitude of an oscillation from step to step.
fn zigzags(signal: &Signal, n: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    let samples: Vec<(f64, f64)> = steps(signal, n).collect();
    let size = |w: &[(f64, f64)]| (w[1].0, 0.25 * (w[2].1 - 2.0 * w[1].1 + w[0].1).abs());
    samples.windows(3).map(size).collect::<Vec<_>>().into_iter()
}

/// Largest difference at the times of the first signal that the second covers.
fn distance(signals: &[&Signal], n: &[f64]) -> Option<f64> {
    let [first, second] = signals else { return None };
    let differences =
        steps(first, n).filter_map(|(t, v)| Some((v - value_at(&second.times, &second.values, t)?).abs()));
    differences.reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal(f: impl Fn(f64) -> f64) -> Signal {
        let times: Vec<f64> = (0..=1000).map(|n| n as f64 * 1e-3).collect();
        let values = times.iter().map(|&t| f(t)).collect();
        Signal { name: "s".into(), unit: String::new(), times, values }
    }

    fn value(name: &str, signals: &[&Signal], numbers: &[f64]) -> f64 {
        (of(name).unwrap().compute)(signals, numbers).unwrap()
    }

    #[test]
    fn numbers_of_known_signals() {
        let pi = std::f64::consts::PI;
        let wave = signal(|t| 3.0 + 2.0 * (2.0 * pi * 10.0 * t).sin() + 0.01 * (2.0 * pi * 120.0 * t).sin());
        let near = |name: &str, numbers: &[f64], right: f64, by: f64| {
            let found = value(name, &[&wave], numbers);
            assert!((found - right).abs() <= by, "{name}: {found}, not {right}");
        };
        near("middle", &[0.0, 1.0], 3.0, 1e-2);
        near("amplitude", &[0.0, 1.0], 2.0, 1e-2);
        near("average", &[0.0, 1.0], 3.0, 1e-12);
        near("frequency", &[0.0, 1.0], 10.0, 1e-2);
        near("line_frequency", &[0.0, 1.0, 50.0, 300.0], 120.0, 1.0);
        near("line", &[0.0, 1.0, 50.0, 300.0], 0.01, 2e-3);
        near("total", &[0.0, 0.0], 3.0, 1e-12);
        near("at", &[0.025], 5.0, 1e-3);
        let counts = signal(|t| if t == 0.5 { 9.0 } else { 2.0 + f64::from(u8::from(t > 0.5)) });
        assert_eq!(value("highest", &[&counts], &[0.0, 1.0]), 9.0);
        assert_eq!(value("order", &[], &[8.0, 2.0]), 2.0);
        // Samples are interpolated to a power of two, which leaves small lines elsewhere.
        let [there, elsewhere] = [[60.0, 180.0], [200.0, 300.0]]
            .map(|[low, high]| value("prominence", &[&wave], &[0.0, 1.0, low, high]));
        assert!(there > 100.0 && elsewhere < 0.1 * there, "{there} {elsewhere}");
        // What falls towards higher frequencies has no peak.
        let slope = self::signal(|t| (-20.0 * (t - 0.5).powi(2)).exp());
        assert!(value("prominence", &[&slope], &[0.0, 1.0, 4.0, 40.0]) < 2.0);
        assert_eq!(value("distance", &[&wave, &wave], &[0.2, 0.8]), 0.0);
    }

    #[test]
    fn a_zigzag_from_step_to_step_is_found_where_it_begins() {
        let sign = |t: f64| if (t * 1e3).round() as i64 % 2 == 0 { 1.0 } else { -1.0 };
        let signal = signal(|t| t * t + if t > 0.5 { 0.1 * sign(t) } else { 0.0 });
        assert!((value("zigzag", &[&signal], &[0.6, 0.9]) - 0.1).abs() < 1e-6);
        assert!((value("onset", &[&signal], &[0.01, 0.0, 1.0]) - 0.5).abs() < 2e-3);
        assert_eq!(value("onset", &[&signal], &[0.01, 0.0, 0.4]), 0.4);
    }
}
