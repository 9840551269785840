//! One history as a function of time: its extrema, its period, and whether it repeats itself.

/// A signal varies by less than this, relative to its size: steady.
pub(super) const STEADY: f64 = 1e-6;

/// How many leading periods the frequency of another signal is determined from.
pub(super) const PERIODS: f64 = 6.0;

/// Samples of a period at least: below, extrema are guesses, and a zigzag from step to step has two.
pub const SAMPLES: usize = 8;

/// How many periods the last one is compared with at most.
pub const PAST: usize = 3;

/// The last full period of the leading signal.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Window {
    /// Upward crossing of the mean at its start \[s\].
    pub start: f64,
    /// Upward crossing of the mean at its end \[s\].
    pub end: f64,
}

impl Window {
    /// T \[s\].
    pub fn period(&self) -> f64 {
        self.end - self.start
    }
}

/// A largest or smallest value and when it occurs.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Extremum {
    /// \[s\]
    pub time: f64,
    /// In the unit of the signal.
    pub value: f64,
}

/// Finite samples at strictly increasing times.
pub(super) struct Signal {
    pub(super) t: Vec<f64>,
    pub(super) v: Vec<f64>,
}

impl Signal {
    pub(super) fn new(times: &[f64], values: &[f64]) -> Self {
        let mut signal = Signal { t: Vec::new(), v: Vec::new() };
        for (&t, &v) in times.iter().zip(values) {
            if t.is_finite() && v.is_finite() && signal.t.last().is_none_or(|&last| last < t) {
                signal.t.push(t);
                signal.v.push(v);
            }
        }
        signal
    }

    /// First and last time, if there are two.
    pub(super) fn range(&self) -> Option<(f64, f64)> {
        (self.t.len() >= 2).then(|| (self.t[0], self.t[self.t.len() - 1]))
    }

    /// The parabola's vertex at sample `n`, or the sample if it is at the end or no local extremum.
    pub(super) fn peak(&self, n: usize) -> Extremum {
        let sample = Extremum { time: self.t[n], value: self.v[n] };
        if n == 0 || n + 1 == self.v.len() {
            return sample;
        }
        let [t0, t1, t2] = [self.t[n - 1], self.t[n], self.t[n + 1]];
        let [v0, v1, v2] = [self.v[n - 1], self.v[n], self.v[n + 1]];
        let (left, right) = ((v1 - v0) / (t1 - t0), (v2 - v1) / (t2 - t1));
        if left * right >= 0.0 {
            return sample;
        }
        let curvature = (right - left) / (t2 - t0);
        let time = (0.5 * (t0 + t1) - 0.5 * left / curvature).clamp(t0, t2);
        Extremum { time, value: v0 + (time - t0) * (left + curvature * (time - t1)) }
    }

    /// Largest and smallest value in the window and one step around it, where the other half of an extremum
    /// at its very ends may be.
    pub(super) fn extrema(&self, window: Window) -> Option<(f64, f64)> {
        let first = self.t.partition_point(|&t| t < window.start).saturating_sub(1);
        let end = (self.t.partition_point(|&t| t <= window.end) + 1).min(self.t.len());
        let peaks: Vec<f64> = (first..end).map(|n| self.peak(n).value).collect();
        let max = peaks.iter().copied().reduce(f64::max)?;
        Some((max, peaks.iter().copied().reduce(f64::min)?))
    }

    /// How many samples the window has.
    pub(super) fn samples(&self, window: Window) -> usize {
        self.t.partition_point(|&t| t <= window.end) - self.t.partition_point(|&t| t <= window.start)
    }

    /// Whether the last `period` is like those before it, as far as there are any.
    pub(super) fn repeats(&self, period: f64) -> bool {
        let Some((first, end)) = self.range() else { return false };
        let window = |n: usize| Window { start: end - (n + 1) as f64 * period, end: end - n as f64 * period };
        let middle = |w: Window| self.extrema(w).map(|(max, min)| (0.5 * (max + min), 0.5 * (max - min)));
        let Some((mean, amplitude)) = middle(window(0)) else { return false };
        let alike = |n: usize| {
            let Some((m, a)) = middle(window(n)) else { return false };
            let more = 0.05 * (n - 1) as f64;
            (a - amplitude).abs() <= 0.06 * amplitude
                && (m - mean).abs() <= (0.1 + more) * amplitude
                && self.difference(window(0), n) <= 0.2 + more
        };
        let mut past = (1..=PAST).take_while(|&n| first <= window(n).start).peekable();
        past.peek().is_some() && past.all(alike)
    }

    /// Size of x(t) − x(t − n T) over the window, T its length, relative to that of x; both without their means.
    fn difference(&self, window: Window, n: usize) -> f64 {
        let samples = self.samples(window).clamp(64, 4096);
        let step = window.period() / samples as f64;
        let from = |n: usize| window.start - n as f64 * window.period() + 0.5 * step;
        let (now, before) = (self.resample(from(0), step, samples), self.resample(from(n), step, samples));
        let change: Vec<f64> = now.iter().zip(&before).map(|(a, b)| a - b).collect();
        let size = |x: &[f64]| {
            let mean = x.iter().sum::<f64>() / x.len() as f64;
            x.iter().map(|x| (x - mean).powi(2)).sum::<f64>().sqrt()
        };
        size(&change) / size(&now).max(f64::MIN_POSITIVE)
    }

    /// Value at `t` by the cubic through the four samples around it.
    pub(super) fn at(&self, t: f64) -> f64 {
        let n = self.t.len();
        let right = self.t.partition_point(|&s| s < t);
        let first = right.saturating_sub(2).min(n.saturating_sub(4));
        let range = first..(first + 4).min(n);
        let weight = |i: usize| -> f64 {
            range.clone().filter(|&j| j != i).map(|j| (t - self.t[j]) / (self.t[i] - self.t[j])).product()
        };
        range.clone().map(|i| self.v[i] * weight(i)).sum()
    }

    /// Values at `start + i step`, i < n.
    pub(super) fn resample(&self, start: f64, step: f64, n: usize) -> Vec<f64> {
        (0..n).map(|i| self.at(start + step * i as f64)).collect()
    }

    /// Mean in time over `start..end`.
    fn mean(&self, start: f64, end: f64) -> f64 {
        let inside = (self.t.partition_point(|&t| t < end) - self.t.partition_point(|&t| t < start)).max(8);
        let step = (end - start) / (2 * inside) as f64;
        self.resample(start + 0.5 * step, step, 2 * inside).iter().sum::<f64>() / (2 * inside) as f64
    }

    /// Lag of best self-similarity of the signal from time `from` on; `None` if it is steady or not similar.
    ///
    /// Of the peaks of 2 Σ x(t) x(t+τ) / Σ (x(t)² + x(t+τ)²) the first is taken that comes within 10 % of the
    /// highest: later ones are multiples of the period, lower ones its harmonics.
    pub(super) fn period(&self, from: f64) -> Option<f64> {
        let (_, end) = self.range()?;
        let n_samples = self.t.len() - self.t.partition_point(|&t| t < from);
        if n_samples < 8 {
            return None;
        }
        let n = n_samples.clamp(256, 4096);
        let step = (end - from) / (n - 1) as f64;
        let x = without_trend(self.resample(from, step, n))?;
        let similarity: Vec<f64> = (0..2 * n / 3).map(|lag| similarity(&x, lag)).collect();
        let peaks = peaks(&similarity);
        let highest = peaks.iter().map(|&lag| similarity[lag]).reduce(f64::max)?;
        let lag = peaks.into_iter().find(|&lag| similarity[lag] >= 0.9 * highest && similarity[lag] > 0.5)?;
        let lags: Vec<f64> = (lag - 1..=lag + 1).map(|l| step * l as f64).collect();
        Some(Signal { t: lags, v: similarity[lag - 1..=lag + 1].to_vec() }.peak(1).time)
    }

    /// The last two upward crossings of the mean that are one period apart, given the period to 20 %.
    pub(super) fn last_period(&self, guess: f64) -> Option<Window> {
        let (start, end) = self.range()?;
        let mut window = None;
        let mut period = guess;
        for _ in 0..4 {
            if end - period < start {
                return None;
            }
            // A slow drift goes with the mean.
            let mean = self.mean(end - period, end);
            let before =
                if end - 2.0 * period < start { mean } else { self.mean(end - 2.0 * period, end - period) };
            let level = |t: f64| mean + (mean - before) / period * (t - end + 0.5 * period);
            let crossings = self.upward_crossings(end - 2.5 * period, level);
            let last = *crossings.last()?;
            let off = |t: f64| (last - t - period).abs();
            let first = crossings.into_iter().min_by(|&a, &b| off(a).total_cmp(&off(b)))?;
            if off(first) > 0.2 * period {
                return None;
            }
            window = Some(Window { start: first, end: last });
            period = last - first;
        }
        window
    }

    /// Times from `from` on at which the signal rises through `level`.
    fn upward_crossings(&self, from: f64, level: impl Fn(f64) -> f64) -> Vec<f64> {
        let above = |n: usize| self.v[n] >= level(self.t[n]);
        let first = self.t.partition_point(|&t| t < from).max(1);
        let rising = (first..self.t.len()).filter(|&n| !above(n - 1) && above(n));
        let crossing = |n: usize| {
            let (mut low, mut high) = (self.t[n - 1], self.t[n]);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                *(if self.at(middle) < level(middle) { &mut low } else { &mut high }) = middle;
            }
            high
        };
        rising.map(crossing).collect()
    }

    /// 1/T of the final part, snapped to multiples and parts of the leading frequency.
    pub(super) fn frequency(&self, leading: f64) -> Option<f64> {
        let (start, end) = self.range()?;
        let period = self.period(start.max(end - PERIODS * leading))?;
        let near = |ratio: f64| (ratio - ratio.round()).abs() < 0.03 * ratio.round();
        let (multiple, part) = (leading / period, period / leading);
        Some(match () {
            () if near(multiple) => multiple.round() / leading,
            () if near(part) => 1.0 / (part.round() * leading),
            () => 1.0 / period,
        })
    }
}

/// `x` minus the straight line closest to it; `None` if nothing is left.
fn without_trend(x: Vec<f64>) -> Option<Vec<f64>> {
    let n = x.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = x.iter().sum::<f64>() / n;
    let moment: f64 = x.iter().enumerate().map(|(i, x)| (i as f64 - middle) * x).sum();
    let slope = moment * 12.0 / (n * (n * n - 1.0));
    let size = x.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
    let rest: Vec<f64> =
        x.into_iter().enumerate().map(|(i, x)| x - mean - slope * (i as f64 - middle)).collect();
    let left = rest.iter().fold(0.0_f64, |left, x| left.max(x.abs()));
    (left > 0.5 * STEADY * size).then_some(rest)
}

/// 1 if `x` repeats itself after `lag` samples, 0 if there is no relation, −1 if it changes sign.
fn similarity(x: &[f64], lag: usize) -> f64 {
    let (early, late) = (&x[..x.len() - lag], &x[lag..]);
    let product: f64 = early.iter().zip(late).map(|(a, b)| a * b).sum();
    let squares: f64 = early.iter().zip(late).map(|(a, b)| a * a + b * b).sum();
    if squares > 0.0 { 2.0 * product / squares } else { 0.0 }
}

/// The highest interior position of every stretch of positive numbers but the first.
fn peaks(similarity: &[f64]) -> Vec<usize> {
    let mut found = Vec::new();
    let mut n = similarity.iter().position(|&s| s <= 0.0).unwrap_or(similarity.len());
    while let Some(begin) = (n..similarity.len()).find(|&i| similarity[i] > 0.0) {
        n = (begin..similarity.len()).find(|&i| similarity[i] <= 0.0).unwrap_or(similarity.len());
        let best = (begin..n).max_by(|&a, &b| similarity[a].total_cmp(&similarity[b]));
        found.extend(best.filter(|&i| i > 0 && i + 1 < similarity.len()));
    }
    found
}
