//! Mean, amplitude and frequency of histories, as benchmark tables state them.
//!
//! All signals of a periodic flow share the period of one *leading signal*, see [`ranking`]. Mean (max + min)/2 and
//! amplitude (max − min)/2 of every signal are taken over the last full period of the leading one. Extrema are
//! those of a parabola through three samples, since sampled ones err by percents at usual step sizes. Time steps
//! need not be equal; samples that are not finite are left out.
//!
//! A signal is *periodic* if its last period, of at least [`SAMPLES`] samples, is like up to [`PAST`] periods before
//! it, of which one must be there: the amplitudes agree to 6 %; the means, to 10 % of the amplitude; and the two
//! periods differ by 20 % of the oscillation at most, as they do where their lengths differ by 3 %. The latter two
//! may grow by 5 % for each further period. A ramp, a zigzag from step to step, an oscillation that grows or decays
//! have no mean, no amplitude and no frequency. `summary.json`, `undula compare` and the pictures all take their
//! numbers from [`summarize`].

pub use super::signal::{Extremum, PAST, SAMPLES, Window};
use super::signal::{PERIODS, STEADY, Signal};

/// A history in four numbers, in the unit of the signal except the frequency.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Statistics {
    /// The last value; NaN if there is none.
    pub last: f64,
    /// (max + min)/2 over the window; `None` where steady or not periodic.
    pub mean: Option<f64>,
    /// (max − min)/2 over the window; `None` where steady or not periodic.
    pub amplitude: Option<f64>,
    /// 1/T of the signal itself \[Hz\]; `None` where steady or not periodic.
    pub frequency: Option<f64>,
}

/// A history with its name.
#[derive(Copy, Clone, Debug)]
pub struct Series<'a> {
    /// Name, such as `uy_A`.
    pub name: &'a str,
    /// Times \[s\].
    pub times: &'a [f64],
    /// A value for every time.
    pub values: &'a [f64],
}

/// A discrete Fourier spectrum.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Spectrum {
    /// From 0 in equal steps up to half the sampling frequency \[Hz\].
    pub frequencies: Vec<f64>,
    /// Amplitude of the oscillation at each frequency, in the unit of the signal; the mean is taken out.
    pub amplitudes: Vec<f64>,
}

/// The last full period of the leading signal; `None` if it is steady or not periodic.
///
/// The period is first guessed as the lag of best self-similarity of the final part of the history, which
/// harmonics and small subharmonics do not mislead, then measured between two upward crossings of the mean.
pub fn leading_window(times: &[f64], values: &[f64]) -> Option<Window> {
    let signal = Signal::new(times, values);
    let (start, end) = signal.range()?;
    // A long transient may need a look at a shorter end, a short history one at all of it.
    [2.0, 4.0, 8.0, 1.0].into_iter().find_map(|part| {
        let guess = signal.period(end - (end - start) / part)?;
        let guess = signal.period(start.max(end - PERIODS * guess)).unwrap_or(guess);
        signal.last_period(guess).filter(|&w| signal.samples(w) >= SAMPLES && signal.repeats(w.period()))
    })
}

/// The order in which signals are asked for a period: `leading` alone if it is given, else vertical deflections
/// (`uy…`), then lifts (`…lift…`, `c_L…`), then all others, each in the order given.
pub fn ranking(names: &[&str], leading: Option<&str>) -> Vec<usize> {
    if let Some(leading) = leading {
        return names.iter().position(|name| *name == leading).into_iter().collect();
    }
    let mut ranked: Vec<usize> = (0..names.len()).collect();
    ranked.sort_by_key(|&n| match names[n].to_lowercase() {
        name if name.starts_with("uy") => 0,
        name if name.contains("lift") || name.starts_with("c_l") => 1,
        _ => 2,
    });
    ranked
}

/// The last full period of the first periodic signal in the order of [`ranking`].
pub fn common_window(series: &[Series<'_>], leading: Option<&str>) -> Option<Window> {
    let names: Vec<&str> = series.iter().map(|s| s.name).collect();
    let ranked = ranking(&names, leading);
    ranked.into_iter().find_map(|n| leading_window(series[n].times, series[n].values))
}

/// Statistics of all signals over the last period of the leading one, and that period.
pub fn summarize(series: &[Series<'_>], leading: Option<&str>) -> (Option<Window>, Vec<Statistics>) {
    let window = common_window(series, leading);
    (window, series.iter().map(|s| statistics(s.times, s.values, window)).collect())
}

/// Statistics of one signal over the window of the leading signal.
///
/// The frequency is that of the signal itself: the drag on a body that moves up and down has twice the
/// frequency of its lift. It is a multiple (or part) of the leading one wherever the two agree to 3 %; a signal
/// with a period of several windows is looked at over that period.
pub fn statistics(times: &[f64], values: &[f64], window: Option<Window>) -> Statistics {
    let signal = Signal::new(times, values);
    let last = signal.v.last().copied().unwrap_or(f64::NAN);
    let steady = Statistics { last, mean: None, amplitude: None, frequency: None };
    let Some(window) = window else { return steady };
    let frequency = signal.frequency(window.period());
    // A zigzag from step to step may fit into the window.
    if frequency.is_some_and(|f| (signal.samples(window) as f64) < 3.0 * f * window.period()) {
        return steady;
    }
    let periods = frequency.map_or(1.0, |f| (1.0 / (f * window.period())).round().max(1.0));
    let own = Window { start: window.end - periods * window.period(), end: window.end };
    let Some((max, min)) = signal.extrema(own).filter(|_| signal.repeats(own.period())) else {
        return steady;
    };
    if max - min <= STEADY * max.abs().max(min.abs()) {
        return steady;
    }
    Statistics { last, mean: Some(0.5 * (max + min)), amplitude: Some(0.5 * (max - min)), frequency }
}

/// The value at time `t` \[s\], by the cubic through the four samples around it; that of the sample if there is one.
/// `None` outside of the times of the history.
pub fn value_at(times: &[f64], values: &[f64], t: f64) -> Option<f64> {
    let signal = Signal::new(times, values);
    let n = signal.t.partition_point(|&s| s < t);
    match signal.t.get(n) {
        Some(&found) if found == t => Some(signal.v[n]),
        Some(_) if n > 0 => Some(signal.at(t)),
        _ => None,
    }
}

/// The largest value of the whole history, by a parabola; `None` without samples.
pub fn maximum(times: &[f64], values: &[f64]) -> Option<Extremum> {
    let signal = Signal::new(times, values);
    let n = (0..signal.v.len()).max_by(|&a, &b| signal.v[a].total_cmp(&signal.v[b]))?;
    Some(signal.peak(n))
}

/// The smallest value of the whole history, by a parabola; `None` without samples.
pub fn minimum(times: &[f64], values: &[f64]) -> Option<Extremum> {
    let signal = Signal::new(times, values);
    let n = (0..signal.v.len()).min_by(|&a, &b| signal.v[a].total_cmp(&signal.v[b]))?;
    Some(signal.peak(n))
}

/// Amplitude spectrum of a history, which is resampled at a power of two of equal steps and weighted by a
/// Hann window; empty for less than four samples.
///
/// A line between two frequencies of the grid is up to 15 % low; the grid has the step 1/(length in time).
pub fn spectrum(times: &[f64], values: &[f64]) -> Spectrum {
    let signal = Signal::new(times, values);
    let Some((start, end)) = signal.range().filter(|_| signal.v.len() >= 4) else {
        return Spectrum::default();
    };
    let n = signal.v.len().next_power_of_two().min(1 << 20);
    let step = (end - start) / n as f64;
    let mut re = signal.resample(start, step, n);
    let mean = re.iter().sum::<f64>() / n as f64;
    for (i, x) in re.iter_mut().enumerate() {
        // Sums to n/2.
        *x = (*x - mean) * (std::f64::consts::PI * i as f64 / n as f64).sin().powi(2);
    }
    let mut im = vec![0.0; n];
    fourier(&mut re, &mut im);
    let frequencies = (0..=n / 2).map(|i| i as f64 / (end - start)).collect();
    let amplitudes = (0..=n / 2).map(|i| 4.0 / n as f64 * re[i].hypot(im[i])).collect();
    Spectrum { frequencies, amplitudes }
}

/// Fast Fourier transform in place; the length is a power of two.
fn fourier(re: &mut [f64], im: &mut [f64]) {
    let n = re.len();
    let bits = n.trailing_zeros();
    for i in 0..n {
        let j = i.reverse_bits() >> (usize::BITS - bits);
        if i < j {
            re.swap(i, j);
            im.swap(i, j);
        }
    }
    let mut half = 1;
    while half < n {
        for k in 0..half {
            let (sin, cos) = (-std::f64::consts::PI * k as f64 / half as f64).sin_cos();
            for i in (k..n).step_by(2 * half) {
                let j = i + half;
                let (x, y) = (cos * re[j] - sin * im[j], sin * re[j] + cos * im[j]);
                (re[j], im[j]) = (re[i] - x, im[i] - y);
                (re[i], im[i]) = (re[i] + x, im[i] + y);
            }
        }
        half *= 2;
    }
}
