//! When steps end. Steps are counted from the start, not subtracted from what is left: a run that is extended takes
//! the steps of one that was long from the beginning, with the same bits.

/// A rest of this part of a step is none.
const NOTHING: f64 = 1e-9;

/// A last step may be longer than the others by this part, rather than leave a small one.
pub const STRETCH: f64 = 1e-3;

/// Smallest step as a part of the time: below it the difference of two times has fewer than four digits.
pub const RESOLUTION: f64 = 1e-12;

/// The times that steps land on.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Schedule {
    /// First time \[s\].
    pub start: f64,
    /// Last time \[s\].
    pub end: f64,
    /// Steps land on start + n · interval, too \[s\].
    pub interval: Option<f64>,
}

/// A step to come.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Next {
    /// Its length k \[s\].
    pub length: f64,
    /// Where it ends \[s\]; t⁻ + k as a decimal number.
    pub time: f64,
    /// Whether it has another length than asked for, to land on the end: a run to a later end does not take it.
    pub cut: bool,
}

impl Schedule {
    /// The step of length `k` \[s\] from `now` \[s\] on. With `counted` all steps have this length, and the n-th ends
    /// at start + n k.
    pub fn next(&self, now: f64, k: f64, counted: bool) -> Next {
        let (anchor, slack) = (self.last_landing(now), slack(now, k));
        let steps = ((now - anchor) / k).round();
        let on_grid = counted && (now - (anchor + steps * k)).abs() <= slack;
        let time = if on_grid { decimal(anchor, (steps + 1.0) * k) } else { decimal(now, k) };
        let target = self.target(now);
        if target - now >= (1.0 + STRETCH) * k || (target - time).abs() <= slack {
            return Next { length: k, time, cut: false };
        }
        Next { length: target - now, time: target, cut: self.is_end(target) }
    }

    /// The time after `now` that a step must not pass \[s\].
    pub fn target(&self, now: f64) -> f64 {
        self.landing(now, 1.0).map_or(self.end, |landing| landing.min(self.end))
    }

    /// Whether `target` is a landing for being the end alone.
    pub fn is_end(&self, target: f64) -> bool {
        let Some(interval) = self.interval else { return target == self.end };
        let number = (target - self.start) / interval;
        target == self.end && (number - number.round()).abs() > NOTHING
    }

    /// Whether nothing is left to do at `now`, where a step has the length `k` \[s\].
    pub fn is_over(&self, now: f64, k: f64) -> bool {
        now >= self.end - slack(now, k)
    }

    /// Where steps are counted from at `now` \[s\].
    fn last_landing(&self, now: f64) -> f64 {
        self.landing(now, 0.0).unwrap_or(self.start)
    }

    /// The landing `ahead` intervals after the last one.
    fn landing(&self, now: f64, ahead: f64) -> Option<f64> {
        let interval = self.interval?;
        let done = ((now - self.start) / interval + NOTHING).floor();
        Some(decimal(self.start, (done + ahead) * interval))
    }
}

/// Times that differ by no more are one \[s\].
fn slack(now: f64, k: f64) -> f64 {
    let k = if k.is_finite() { k.max(0.0) } else { 0.0 };
    NOTHING * k + 4.0 * f64::EPSILON * now.abs()
}

/// `a` + `b` as a decimal number: 0.3, not 0.30000000000000004. It has 15 digits, counted from the largest of the
/// three numbers.
pub fn decimal(a: f64, b: f64) -> f64 {
    let sum = a + b;
    let size = a.abs().max(b.abs()).max(sum.abs());
    if size == 0.0 || !size.is_finite() {
        return sum;
    }
    let digits = 14 - size.log10().floor() as i32;
    match digits {
        ..0 => sum,
        // 10^22 is the last power of ten that is a number without rounding.
        0..=22 => {
            let power = 10f64.powi(digits);
            (sum * power).round() / power
        }
        _ => format!("{sum:.*}", digits as usize).parse().unwrap_or(sum),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All steps of a run, `(length, time, cut)`.
    fn steps(schedule: Schedule, mut now: f64, k: f64) -> Vec<(f64, f64, bool)> {
        let mut found = vec![];
        while !schedule.is_over(now, k) {
            let Next { length, time, cut } = schedule.next(now, k, true);
            assert!(time > now, "{time} after {now}");
            found.push((length, time, cut));
            now = time;
        }
        found
    }

    #[test]
    fn a_short_run_is_the_beginning_of_a_long_one() {
        for (start, k, n, unit) in
            [(0.0, 0.005, 60, 1.0), (-1.3, 0.1, 40, 1.0), (2.0, 1.0 / 3.0, 50, 1.0), (0.0, 0.007, 99, 1e-9)]
        {
            let (start, k) = (start * unit, k * unit);
            let long = steps(Schedule { start, end: start + f64::from(n) * k, interval: None }, start, k);
            assert_eq!(long.len(), n as usize);
            assert!(long.iter().all(|(length, _, cut)| *length == k && !cut), "{k}: {long:?}");
            for m in 1..n {
                let end = start + f64::from(m) * k;
                let short = Schedule { start, end, interval: None };
                assert_eq!(steps(short, start, k), long[..m as usize], "{k}, {m} steps");
            }
        }
    }

    #[test]
    fn times_are_decimal_numbers() {
        let times = steps(Schedule { start: 0.0, end: 1.0, interval: None }, 0.0, 0.1);
        let text: Vec<String> = times.iter().map(|(_, t, _)| t.to_string()).collect();
        assert_eq!(text.join(" "), "0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 0.9 1");
        let times = steps(Schedule { start: 0.0, end: 4e-13, interval: None }, 0.0, 1e-13);
        let text: Vec<String> = times.iter().map(|(_, t, _)| format!("{t:e}")).collect();
        assert_eq!(text.join(" "), "1e-13 2e-13 3e-13 4e-13");
        assert_eq!(decimal(1e30, 1e25).to_string(), (1e30f64 + 1e25).to_string());
        assert_eq!((decimal(0.0, 0.0), decimal(0.1, -0.1), decimal(0.1, 0.2)), (0.0, 0.0, 0.3));
    }

    #[test]
    fn the_last_step_is_cut_where_the_end_is_no_multiple() {
        let times = steps(Schedule { start: 0.0, end: 0.023, interval: None }, 0.0, 0.01);
        assert_eq!(times.len(), 3);
        assert!(times[2].2 && times[2].1 == 0.023 && (times[2].0 - 0.003).abs() < 1e-15, "{times:?}");
        // A rest of half a per mille is not worth its own.
        let times = steps(Schedule { start: 0.0, end: 0.020_005, interval: None }, 0.0, 0.01);
        assert!(times.len() == 2 && times[1].2 && times[1].1 == 0.020_005, "{times:?}");
    }

    #[test]
    fn steps_land_on_output_times() {
        let schedule = Schedule { start: 0.0, end: 0.1, interval: Some(0.025) };
        let times = steps(schedule, 0.0, 0.01);
        let text: Vec<String> = times.iter().map(|(_, t, _)| t.to_string()).collect();
        assert_eq!(text.join(" "), "0.01 0.02 0.025 0.035 0.045 0.05 0.06 0.07 0.075 0.085 0.095 0.1");
        assert!(times.iter().all(|(_, _, cut)| !cut), "a later end has the same landings");
        assert!(steps(Schedule { end: 0.09, ..schedule }, 0.0, 0.01).last().unwrap().2);
    }
}
