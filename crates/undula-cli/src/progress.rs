//! What a run tells while it goes on.

use crate::args::{Log, say};
use crate::digits::fixed;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Seconds between two lines where there is no terminal.
const PERIOD: Duration = Duration::from_secs(10);

/// Resolution of the bar.
const LENGTH: u64 = 10_000;

/// A step that has been done.
#[derive(Copy, Clone, Debug)]
pub struct StepInfo<'a> {
    /// Number of the step.
    pub step: u64,
    /// Time reached \[s\].
    pub time: f64,
    /// Newton iterations of this step.
    pub newton_steps: usize,
    /// Jacobians assembled in this step.
    pub jacobians: usize,
    /// Name, value and unit of the leading functional, in SI units.
    pub leading: Option<(&'a str, f64, &'a str)>,
    /// Smallest det F of this step.
    pub min_j: f64,
}

/// One line that shows how far a run is: a bar on a terminal, else a line every ten seconds.
#[derive(Debug)]
pub struct Progress {
    end_time: Option<f64>,
    mode: Mode,
    begun: Instant,
    /// Time, step and clock of the first update; a resumed run does not begin at zero.
    first: Option<(f64, u64, Instant)>,
    /// When the last line was printed.
    printed: Option<Instant>,
}

#[derive(Debug)]
enum Mode {
    Quiet,
    /// Messages alone: steps are told by others.
    Messages,
    Lines,
    Bar(ProgressBar),
}

impl Progress {
    /// For a run until `end_time` \[s\], or a stationary one.
    pub fn new(end_time: Option<f64>, quiet: bool, log: Log) -> Self {
        let mode = match quiet {
            _ if log == Log::Json => Mode::Messages,
            true => Mode::Quiet,
            false if std::io::stderr().is_terminal() => Mode::Bar(bar(end_time)),
            false => Mode::Lines,
        };
        Progress { end_time, mode, begun: Instant::now(), first: None, printed: None }
    }

    /// Shows a step.
    pub fn update(&mut self, info: &StepInfo) {
        let now = Instant::now();
        let first = *self.first.get_or_insert((info.time, info.step, now));
        let line = match self.end_time {
            Some(end) => self.in_time(info, end, first, now),
            None => describe(info),
        };
        match &self.mode {
            Mode::Quiet | Mode::Messages => {}
            Mode::Bar(bar) => {
                let share = self.end_time.map_or(0.0, |end| info.time / end);
                bar.set_position((share.clamp(0.0, 1.0) * LENGTH as f64) as u64);
                bar.set_message(line);
            }
            Mode::Lines if self.printed.is_none_or(|printed| now - printed >= PERIOD) => {
                self.printed = Some(now);
                say(&line);
            }
            Mode::Lines => {}
        }
    }

    /// Prints a line of its own, above the bar.
    pub fn message(&self, text: &str) {
        match &self.mode {
            Mode::Quiet => {}
            Mode::Bar(bar) => bar.println(text),
            Mode::Lines | Mode::Messages => say(text),
        }
    }

    /// Ends the display without a word.
    pub fn clear(self) {
        if let Mode::Bar(bar) = self.mode {
            bar.finish_and_clear();
        }
    }

    /// Ends the display with a last line, such as `completed`, and what is to be told `behind` its time.
    pub fn finish(self, text: &str, behind: &str) {
        let line = format!("{text} after {}{behind}", duration(self.begun.elapsed().as_secs_f64()));
        match self.mode {
            Mode::Quiet | Mode::Messages => {}
            Mode::Bar(bar) => {
                bar.finish_and_clear();
                say(&line);
            }
            Mode::Lines => say(&line),
        }
    }

    /// Time, rate and what remains.
    fn in_time(&self, info: &StepInfo, end: f64, first: (f64, u64, Instant), now: Instant) -> String {
        let seconds = (now - first.2).as_secs_f64();
        let mut line = format!("t = {}/{end} s", fixed(info.time, end, 3));
        if info.step > first.1 && seconds > 0.0 {
            let rate = (info.step - first.1) as f64 / seconds;
            let left = (end - info.time) / (info.time - first.0) * seconds;
            let rate =
                if rate < 1.0 { format!("{:.1} s/step", 1.0 / rate) } else { format!("{rate:.1} steps/s") };
            line += &format!(", {rate}, {} left", duration(left));
        }
        format!("{line}, {}", describe(info))
    }
}

fn bar(end_time: Option<f64>) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(LENGTH), ProgressDrawTarget::stderr_with_hz(10));
    let template =
        if end_time.is_some() { "{bar:24} {percent:>3}% {wide_msg}" } else { "{spinner} {wide_msg}" };
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style.progress_chars("━╸─"));
    bar
}

/// Functional, Newton's method and mesh in one line.
fn describe(info: &StepInfo) -> String {
    let leading = info.leading.map_or(String::new(), |(name, value, unit)| {
        let (value, unit) = if unit == "m" { (1e3 * value, "mm") } else { (value, unit) };
        format!("{name} = {} {unit}", fixed(value, value, 4)).trim_end().to_string() + ", "
    });
    let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    let newton =
        format!("{}, {}", count(info.newton_steps, "Newton step"), count(info.jacobians, "Jacobian"));
    let mesh = if info.min_j.is_finite() { format!(", min J {:.3}", info.min_j) } else { String::new() };
    format!("{leading}{newton}{mesh}")
}

/// `1:02:03`, `2:03` or `3.1 s`.
fn duration(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, _) => format!("{seconds:.1} s"),
        (0, minutes, seconds) => format!("{minutes}:{seconds:02} min"),
        (hours, minutes, seconds) => format!("{hours}:{minutes:02}:{seconds:02} h"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(step: u64, time: f64) -> StepInfo<'static> {
        StepInfo {
            step,
            time,
            newton_steps: 3,
            jacobians: 1,
            leading: Some(("uy_A", 0.03456, "m")),
            min_j: 0.7612,
        }
    }

    #[test]
    fn a_line_says_where_the_run_is() {
        let progress = Progress::new(Some(10.0), true, Log::Text);
        let begun = Instant::now();
        let line = progress.in_time(&info(30, 3.0), 10.0, (1.0, 10, begun), begun + Duration::from_secs(4));
        assert_eq!(
            line,
            "t = 3.000/10 s, 5.0 steps/s, 14.0 s left, uy_A = 34.5600 mm, 3 Newton steps, 1 Jacobian, min J 0.761"
        );
        let line = progress.in_time(&info(11, 1.1), 10.0, (1.0, 10, begun), begun + Duration::from_secs(90));
        assert!(line.contains("90.0 s/step") && line.contains("2:13:30 h left"), "{line}");
        assert!(!progress.in_time(&info(10, 1.0), 10.0, (1.0, 10, begun), begun).contains("left"));
    }

    #[test]
    fn nothing_is_divided_by_zero() {
        let mut progress = Progress::new(Some(0.0), true, Log::Text);
        [0.0, 0.0, f64::NAN].into_iter().for_each(|time| progress.update(&info(1, time)));
        progress.message("halved");
        progress.finish("interrupted", "");
        let stationary = StepInfo { leading: None, min_j: f64::NAN, newton_steps: 1, ..info(0, 0.0) };
        assert_eq!(describe(&stationary), "1 Newton step, 1 Jacobian");
    }
}
