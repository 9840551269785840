//! Statistics of signals whose mean, amplitude and frequency are known.

use std::f64::consts::TAU;
use undula::functional::statistics::{
    Extremum, Series, Statistics, leading_window, maximum, minimum, ranking, spectrum, statistics, summarize,
};

/// 36.6 samples per period of 5.46 Hz.
const F: f64 = 5.46;
const STEP: f64 = 0.005;

fn sampled(n: usize, signal: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
    (1..=n).map(|i| STEP * i as f64).map(|t| (t, signal(t))).unzip()
}

/// Mean, amplitude and frequency are those given to a relative accuracy.
fn assert_statistics(found: Statistics, [mean, amplitude, frequency]: [f64; 3], accuracy: f64) {
    let error = |found: Option<f64>, x: f64, size: f64| (found.unwrap_or(f64::NAN) - x).abs() / size;
    let errors = [
        error(found.mean, mean, amplitude),
        error(found.amplitude, amplitude, amplitude),
        error(found.frequency, frequency, frequency),
    ];
    assert!(errors.iter().all(|e| *e < accuracy), "{found:?}: errors {errors:?}");
}

#[test]
fn a_sine_to_1e_4_whatever_its_phase() {
    for phase in (0..50).map(|i| 0.13 * f64::from(i)) {
        let (t, v) = sampled(1000, |t| 1.48e-3 + 34.38e-3 * (TAU * F * t + phase).sin());
        let window = leading_window(&t, &v).unwrap();
        assert!((window.period() * F - 1.0).abs() < 1e-4);
        assert!(t[999] - window.end < 1.01 / F && window.end <= t[999]);
        assert_statistics(statistics(&t, &v, Some(window)), [1.48e-3, 34.38e-3, F], 1e-4);
    }
}

#[test]
fn drag_has_twice_the_frequency_and_lift_its_own_wiggles() {
    for phase in (0..20).map(|i| 0.31 * f64::from(i)) {
        let (t, uy) = sampled(2000, |t| 1.48e-3 + 34.38e-3 * (TAU * F * t + phase).sin());
        let window = leading_window(&t, &uy);
        let at = |t: f64| TAU * F * t + phase;
        let (_, drag) = sampled(2000, |t| 457.3 + 22.66 * (2.0 * at(t)).cos() + 1.0 * at(t).cos());
        let found = statistics(&t, &drag, window);
        assert!((found.frequency.unwrap() / (2.0 * F) - 1.0).abs() < 1e-4, "{found:?}");
        assert!(
            (found.mean.unwrap() - 457.8).abs() < 0.02 && (found.amplitude.unwrap() - 23.165).abs() < 0.02,
            "{found:?}"
        );
        // Several crossings of the mean and several bumps per period.
        let (_, lift) = sampled(2000, |t| 2.2 + 100.0 * at(t).sin() + 90.0 * (3.0 * at(t) + 1.0).sin());
        let found = statistics(&t, &lift, window);
        assert!((found.frequency.unwrap() / F - 1.0).abs() < 1e-4, "{found:?}");
    }
}

#[test]
fn a_leading_signal_with_strong_harmonics() {
    for phase in (0..20).map(|i| 0.31 * f64::from(i)) {
        let at = |t: f64| TAU * 2.0 * t + phase;
        let (t, v) =
            sampled(2000, |t| at(t).sin() + 0.9 * (3.0 * at(t) + 1.0).sin() + 0.4 * (2.0 * at(t)).cos());
        let window = leading_window(&t, &v).unwrap();
        assert!((window.period() * 2.0 - 1.0).abs() < 1e-4, "{window:?}");
    }
}

#[test]
fn small_subharmonics_do_not_double_the_period() {
    let (t, v) = sampled(2000, |t| (TAU * F * t).sin() + 0.04 * (0.5 * TAU * F * t).sin());
    let window = leading_window(&t, &v).unwrap();
    assert!((window.period() * F - 1.0).abs() < 0.02, "{window:?}");
    assert!((statistics(&t, &v, Some(window)).frequency.unwrap() / F - 1.0).abs() < 0.02);
}

#[test]
fn drift_does_not_disturb_the_period() {
    let (t, v) = sampled(1200, |t| 0.2 * t + (TAU * F * t).sin());
    let window = leading_window(&t, &v).unwrap();
    assert!((window.period() * F - 1.0).abs() < 1e-4, "{}", window.period() * F);
    // The mean is that of the last period, wherever the drift has brought it.
    let found = statistics(&t, &v, Some(window));
    assert!((found.mean.unwrap() - 0.2 * 0.5 * (window.start + window.end)).abs() < 0.02);
    assert!((found.amplitude.unwrap() - 1.0).abs() < 0.02);
}

#[test]
fn a_growing_oscillation_after_a_ramp() {
    let (t, v) = sampled(1400, |t| {
        let ramp = if t < 2.0 { 0.5 - 0.5 * (TAU / 4.0 * t).cos() } else { 1.0 };
        let size = 1.0 / (1.0 + (-(t - 4.0) * 3.0).exp());
        5.0 * ramp + size * (TAU * F * t).sin()
    });
    let window = leading_window(&t, &v).unwrap();
    assert_statistics(statistics(&t, &v, Some(window)), [5.0, 1.0, F], 2e-3);
}

#[test]
fn time_steps_may_vary() {
    let t: Vec<f64> = (0..1500).map(|i| STEP * (f64::from(i) + 0.6 * (0.37 * f64::from(i)).sin())).collect();
    let v: Vec<f64> = t.iter().map(|t| 3.0 + 2.0 * (TAU * F * t).cos()).collect();
    let window = leading_window(&t, &v);
    assert_statistics(statistics(&t, &v, window), [3.0, 2.0, F], 3e-4);
    // A long first part with coarse steps.
    let t: Vec<f64> =
        (0..40).map(|i| 0.1 * f64::from(i)).chain((0..800).map(|i| 4.0 + STEP * f64::from(i))).collect();
    let v: Vec<f64> = t.iter().map(|t| 3.0 + 2.0 * (TAU * F * t).cos()).collect();
    assert_statistics(statistics(&t, &v, leading_window(&t, &v)), [3.0, 2.0, F], 1e-4);
}

#[test]
fn few_periods_are_enough() {
    for n in [80, 100, 150] {
        let (t, v) = sampled(n, |t| (TAU * F * t + 0.4).sin());
        let window = leading_window(&t, &v);
        assert_statistics(statistics(&t, &v, window), [0.0, 1.0, F], 1e-3);
    }
}

/// What a run gives that has not settled, or whose steps alternate.
#[test]
fn ramps_zigzags_and_rings_that_die_have_no_period() {
    let zigzag = |t: f64| if (t / STEP).round() as i64 % 2 == 0 { 1.0 } else { -1.0 };
    let signals: [(&str, &dyn Fn(f64) -> f64); 11] = [
        ("ramp", &|t| 46.5 + t),
        ("smooth start", &|t| 1.0 - (TAU / 20.0 * t).cos()),
        ("zigzag", &|t| zigzag(t)),
        ("zigzag on a ramp", &|t| t + 0.1 * zigzag(t)),
        ("zigzag that dies", &|t| 3.0 + zigzag(t) * (-t).exp()),
        ("decay", &|t| (-0.2 * t).exp() * (TAU * 2.0 * t).sin()),
        ("slow decay", &|t| 1.0 + (-0.05 * t).exp() * (TAU * 2.0 * t).sin()),
        ("growth", &|t| (0.2 * t).exp() * (TAU * 2.0 * t).sin()),
        ("oscillation on a ramp", &|t| t + 0.3 * (TAU * 2.0 * t).sin()),
        ("frequency that rises", &|t| (TAU * 0.3 * t * t).sin()),
        ("one swing and a half", &|t| (TAU * 0.3 * t).sin()),
    ];
    for (name, signal) in signals {
        let (t, v) = sampled(1000, signal);
        assert_eq!(leading_window(&t, &v), None, "{name}");
        // Nor do they take one from a signal that has.
        let (_, other) = sampled(1000, |t| (TAU * 2.0 * t).sin());
        let series = [("uy_A", &other), ("x", &v)].map(|(name, v)| Series { name, times: &t, values: v });
        let (window, found) = summarize(&series, None);
        assert!((window.unwrap().period() - 0.5).abs() < 1e-4);
        assert_eq!((found[1].mean, found[1].amplitude, found[1].frequency), (None, None, None), "{name}");
        assert!(found[0].amplitude.is_some());
    }
}

#[test]
fn one_rule_says_which_signal_leads() {
    let names = ["drag", "c_L", "tip", "uy_A", "Lift"];
    assert_eq!(ranking(&names, None), [3, 1, 4, 0, 2]);
    assert_eq!(ranking(&names, Some("tip")), [2]);
    assert_eq!(ranking(&names, Some("other")), [0; 0]);
    let (t, swing) = sampled(1000, |t| (TAU * 2.0 * t).sin());
    let (_, ramp) = sampled(1000, |t| t);
    let series = [("uy_A", &ramp), ("tip", &swing)].map(|(name, v)| Series { name, times: &t, values: v });
    // The first that is periodic, unless one is named.
    assert!(summarize(&series, None).0.is_some());
    assert_eq!(summarize(&series, Some("uy_A")).0, None);
}

/// The drag leads and has half the period of the lift.
#[test]
fn a_signal_of_several_windows_is_looked_at_over_its_own_period() {
    let at = |t: f64| TAU * 2.0 * t + 0.4;
    let (t, lift) = sampled(1000, |t| 1.0 + 5.0 * at(t).sin() + 2.0 * (2.0 * at(t)).sin());
    let (_, drag) = sampled(1000, |t| 9.0 + (2.0 * at(t)).cos());
    let (_, found) = {
        let series =
            [("drag", &drag), ("lift", &lift)].map(|(name, v)| Series { name, times: &t, values: v });
        summarize(&series, Some("drag"))
    };
    assert_statistics(found[0], [9.0, 1.0, 4.0], 1e-3);
    let (max, min) = (maximum(&t, &lift).unwrap().value, minimum(&t, &lift).unwrap().value);
    assert_statistics(found[1], [0.5 * (max + min), 0.5 * (max - min), 2.0], 2e-3);
}

#[test]
fn steady_signals_have_no_period() {
    let (t, oscillating) = sampled(1000, |t| (TAU * F * t).sin());
    let window = leading_window(&t, &oscillating);
    let signals: [&dyn Fn(f64) -> f64; 8] = [
        &|_| 14.29,
        &|_| 0.0,
        &|t| 14.29 + 1e-7 * (TAU * F * t).sin(),
        &|t| 1.0 - (-3.0 * t).exp(),
        &|t| (0.3 * t).exp(),
        &|t| 0.3 * t + 2.0,
        &|t| (t / 2.0).min(1.0),
        &|t| f64::sqrt(t),
    ];
    for (n, signal) in signals.iter().enumerate() {
        let (t, v) = sampled(1000, signal);
        assert_eq!(leading_window(&t, &v), None, "signal {n}");
        let alone = statistics(&t, &v, None);
        assert_eq!(alone, Statistics { last: v[999], mean: None, amplitude: None, frequency: None });
    }
    let (t, v) = sampled(1000, signals[2]);
    assert_eq!(statistics(&t, &v, window).amplitude, None);
    for v in [vec![], vec![1.0], vec![f64::NAN; 4]] {
        assert_eq!(leading_window(&t[..v.len()], &v), None);
        assert_eq!(maximum(&[0.0; 4][..v.len()], &v).is_some(), v.len() == 1);
        let _ = (statistics(&t[..v.len()], &v, window), spectrum(&t[..v.len()], &v));
    }
    assert!(statistics(&[], &[], window).last.is_nan());
}

#[test]
fn extrema_lie_between_samples() {
    let (t, v) = sampled(1600, |t| 2.95 * (-(t - 3.936).powi(2)).exp());
    let peak = maximum(&t, &v).unwrap();
    assert!((peak.time - 3.936).abs() < 1e-5 && (peak.value - 2.95).abs() < 1e-8, "{peak:?}");
    let v: Vec<f64> = v.iter().map(|v| -v).collect();
    assert_eq!(minimum(&t, &v).unwrap(), Extremum { time: peak.time, value: -peak.value });
    assert_eq!(maximum(&[0.0, 1.0, 2.0], &[1.0, 2.0, 4.0]), Some(Extremum { time: 2.0, value: 4.0 }));
    let uneven = maximum(&[0.0, 1.0, 4.0], &[-2.25, -0.25, -6.25]).unwrap();
    assert!((uneven.time - 1.5).abs() < 1e-14 && uneven.value.abs() < 1e-14, "{uneven:?}");
}

#[test]
fn the_spectrum_has_the_lines_of_the_signal() {
    // 5 s, so that 4 and 11 Hz are on the grid.
    let (t, v) = sampled(1001, |t| 7.0 + 3.0 * (TAU * 4.0 * t).sin() + 0.5 * (TAU * 11.0 * t + 1.0).cos());
    let found = spectrum(&t, &v);
    let line =
        |f: f64| found.amplitudes[found.frequencies.iter().position(|x| (x - f).abs() < 1e-9).unwrap()];
    assert!(
        (line(4.0) - 3.0).abs() < 1e-3 && (line(11.0) - 0.5).abs() < 1e-3,
        "{} {}",
        line(4.0),
        line(11.0)
    );
    assert!(line(0.0) < 1e-3 && line(7.0) < 1e-4);
    assert_eq!(found.frequencies.len(), found.amplitudes.len());
}
