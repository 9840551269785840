//! What a run writes: fields, checkpoints, the window of its statistics.

use crate::case::choices::{OUTPUT_CELLS, OUTPUT_MESH};
use crate::case::error::suggestion;
use crate::case::read::{ANY, NOT_NEGATIVE, POSITIVE, Section};
use crate::case::schema::{FunctionalSpec, OutputSpec, TimeSpec};
use crate::functional::nodal::{DEFAULT_FIELDS, FIELDS};
use crate::time::schedule::RESOLUTION;

/// Minutes of computation that a run may lose when it is killed.
pub(super) const CHECKPOINT_MINUTES: f64 = 10.0;

/// `names` are all functionals of the file, `present` those that are evaluated.
pub(super) fn output(
    mut s: Section<'_, '_>,
    names: &[String],
    present: &[(String, FunctionalSpec)],
    time: Option<&TimeSpec>,
) -> OutputSpec {
    let fields_every = s.integer("fields-every", 0, 0..=usize::MAX);
    let fields_interval = s.optional_number("fields-interval", POSITIVE);
    let least = RESOLUTION * time.map_or(0.0, |time| time.start.abs().max(time.end.abs()));
    if fields_interval.is_some_and(|interval| interval < least) {
        // Steps end at each multiple of it.
        let least = crate::case::literal::number(least);
        let message = format!("below the rounding of the times of the run: expected at least {least} s");
        s.wrong("fields-interval", message);
    }
    let fields_times = s.numbers("fields-times", ANY).unwrap_or_default();
    let fields = s.choices("fields", &FIELDS).unwrap_or_else(|| DEFAULT_FIELDS.to_vec());
    let window = s.pair("window", ANY);
    if window.is_some_and(|[start, end]| end <= start) {
        s.wrong("window", "expected two times, the first and the last [s]");
    }
    note_outside(&s, &fields_times, window, time);
    let deformed = s.choice("mesh", &OUTPUT_MESH, &[]).unwrap_or(true);
    let curved = s.choice("cells", &OUTPUT_CELLS, &[]).unwrap_or(false);
    let checkpoint_every = s.integer("checkpoint-every", 0, 0..=usize::MAX);
    let checkpoint_minutes = s.number("checkpoint-minutes", CHECKPOINT_MINUTES, NOT_NEGATIVE);
    let (report, leading) = (s.boolean("report", true), s.string("leading"));
    if let Some(name) = &leading
        && !names.contains(name)
    {
        let hint = suggestion(name, names.iter().map(String::as_str));
        s.wrong("leading", format!("expected the name of a functional{hint}"));
    }
    s.finish();
    let leading = leading.filter(|name| present.iter().any(|(n, _)| n == name));
    OutputSpec {
        fields_every,
        fields_interval,
        fields_times,
        fields,
        window,
        deformed,
        curved,
        checkpoint_every,
        checkpoint_minutes,
        report,
        leading,
    }
}

/// Times of output that the run does not come to.
fn note_outside(s: &Section<'_, '_>, times: &[f64], window: Option<[f64; 2]>, time: Option<&TimeSpec>) {
    let Some(time) = time else { return };
    let outside = |t: &f64| *t < time.start || *t > time.end;
    let (start, end) = (time.start, time.end);
    if let Some(t) = times.iter().find(|t| outside(t)) {
        let note = format!("output.fields-times: the run from {start} to {end} s does not come to {t} s");
        s.note(note);
    }
    if window.is_some_and(|window| window.iter().any(outside)) {
        let note = format!("output.window: the run from {start} to {end} s does not fill it");
        s.note(note);
    }
}
