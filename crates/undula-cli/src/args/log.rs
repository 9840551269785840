//! Lines on standard error: text, or with `--log json` one JSON object each.

use serde_json::{Value, json};
use std::fmt::Display;
use std::io::Write;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// What lines on standard error are.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Log {
    /// Text for people
    #[default]
    Text,
    /// One JSON object a line
    Json,
}

/// Whether they are JSON. The choice is one of the program, not of a run: mistakes in the input come before any run.
static JSON: AtomicBool = AtomicBool::new(false);

/// Whether nothing is printed: of several processes one speaks.
static SILENT: AtomicBool = AtomicBool::new(false);

/// What a line of text begins with, where one of several processes says what the first does not know.
static SPEAKER: OnceLock<String> = OnceLock::new();

/// Words that begin a line of text and are the event of a line of JSON.
const EVENTS: [&str; 4] = ["note", "warning", "breakdown", "error"];

/// Chooses what lines are from here on.
pub fn log_as(log: Log) {
    JSON.store(log == Log::Json, Ordering::Relaxed);
}

/// From here on nothing is printed.
pub fn silence() {
    SILENT.store(true, Ordering::Relaxed);
}

/// From here on this process speaks; lines of text begin with who it is.
pub fn speak_as(speaker: String) {
    let _ = SPEAKER.set(speaker);
    SILENT.store(false, Ordering::Relaxed);
}

/// Prints a line on standard error. Errors of writing are ignored (a reader such as `head` may have closed the pipe): a
/// computation does not depend on its readers.
pub fn say(line: impl Display) {
    tell("message", line);
}

/// [`say`] of a line that is the event `name` unless its first word says another one.
pub fn tell(name: &str, line: impl Display) {
    let line = line.to_string();
    if !JSON.load(Ordering::Relaxed) {
        let speaker = SPEAKER.get().map_or(String::new(), |speaker| format!("{speaker}: "));
        return write(&format!("{speaker}{line}"));
    }
    let said = EVENTS.iter().find_map(|&name| Some((name, line.strip_prefix(name)?.strip_prefix(": ")?)));
    let (name, text) = said.unwrap_or((name, &line));
    event(name, json!({ "text": text }));
}

/// Prints the event `name` with its `values`, an object, as a line of JSON.
pub fn event(name: &str, values: Value) {
    let mut line = json!({ "event": name });
    if let (Some(line), Value::Object(values)) = (line.as_object_mut(), values) {
        line.extend(values);
    }
    write(&line.to_string());
}

fn write(line: &str) {
    if !SILENT.load(Ordering::Relaxed) {
        // At once, lest lines of other processes come between.
        let _ = std::io::stderr().lock().write_all(format!("{line}\n").as_bytes());
    }
}

/// Prints notes on standard error.
pub fn say_notes(notes: &[String]) {
    notes.iter().for_each(|note| say(format_args!("note: {note}")));
}
