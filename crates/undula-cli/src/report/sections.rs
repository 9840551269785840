//! The words and tables of the page of a run.

use super::Content;
use super::fields::Scene;
use crate::compare::Published;
use crate::digits::significant;
use crate::page::{Html, duration, html};
use serde_json::Value;
use undula::output::{Status, Summary};
use undula::results::compare::Row;
use undula::setup::overview::Inflow;

/// What the page is called.
pub fn title(content: &Content) -> String {
    let case = content.results.case.as_ref();
    // A run that goes on has an empty summary.
    let name = &content.results.summary.case;
    let name = case.filter(|_| name.is_empty()).map_or(name, |case| &case.name);
    match content.results.case.as_ref().map(|case| case.title.as_str()).filter(|title| !title.is_empty()) {
        Some(title) => format!("{name}: {title}"),
        None => name.clone(),
    }
}

/// Title, state and size of the run.
pub fn head(page: &mut Html, content: &Content, title: &str) {
    let summary = &content.results.summary;
    let class = match summary.status {
        Status::Completed => "yes",
        Status::Breakdown | Status::Failed => "no",
        _ => "open",
    };
    page.heading(1, None, title);
    let badge = format!("<span class=\"{class}\">{}</span>", summary.status);
    let unknowns = &summary.unknowns;
    let mut rows = vec![vec!["run".to_string(), format!("{badge} {}", html::escape(&took(summary)))]];
    let mut fact = |name: &str, text: String| rows.push(vec![name.into(), html::escape(&text)]);
    if let Some((case, overview)) = &content.overview {
        let [lower, upper] = &overview.extents;
        let names = if overview.around_axis { ["r", "z", ""] } else { ["x", "y", "z"] };
        let sides: Vec<String> = names
            .iter()
            .zip(lower.iter().zip(upper))
            .map(|(name, (a, b))| format!("{name} from {} to {} m", significant(*a, 4), significant(*b, 4)))
            .collect();
        let [smallest, largest] = overview.sizes.map(|size| significant(size, 3));
        fact("domain", sides.join(", "));
        fact("mesh", format!("{} cells, sizes from {smallest} to {largest} m", grouped(overview.cells)));
        fact("elements", format!("{}/{}", case.space.velocity.name(), case.space.pressure.name()));
        if let Some(Inflow { reynolds, mean, scale: (scale, what), cfl, name, .. }) = &overview.inflow {
            let [mean, scale] = [mean, scale].map(|x| significant(*x, 4));
            let number = significant(*reynolds, 4);
            fact(
                "Reynolds number",
                format!("{number}, with the mean velocity {mean} m/s at {name} and {scale} m, {what}"),
            );
            if let Some([_, largest]) = cfl {
                fact("CFL number", format!("up to {}", significant(*largest, 3)));
            }
        }
    } else {
        fact("mesh", format!("{} cells", grouped(summary.cells)));
    }
    fact(
        "unknowns",
        format!(
            "{}: velocity {}, displacement {}, pressure {}",
            grouped(unknowns.total),
            grouped(unknowns.velocity),
            grouped(unknowns.deformation),
            grouped(unknowns.pressure)
        ),
    );
    if let Some(time) = content.results.history.column("time").filter(|time| time.len() > 1) {
        let last = significant(time[time.len() - 1], 6);
        // The summary of a run that goes on is that of its last checkpoint.
        let steps = content.results.history.column("step").and_then(|steps| steps.last().copied());
        fact("time", format!("up to t = {last} s in {} steps", grouped(steps.unwrap_or(0.0) as usize)));
    }
    if let Some(start) = &summary.start {
        fact("start", start.clone());
    }
    page.raw_table(&[], &rows, "facts");
}

/// How the run ended, and after what time.
fn took(summary: &Summary) -> String {
    match summary.wall_seconds {
        seconds if seconds > 0.0 => format!("after {}", duration(seconds)),
        _ => String::new(),
    }
}

/// A number with thin spaces between groups of three digits.
fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|group| std::str::from_utf8(group).ok()).collect();
    groups.join("\u{202f}")
}

/// What went wrong, and what should be known.
pub fn warnings(page: &mut Html, content: &Content) {
    let summary = &content.results.summary;
    let mut found: Vec<String> = vec![];
    if let Some(breakdown) = &summary.breakdown {
        let at = significant(breakdown.time, 6);
        let remedy = if breakdown.remedy.is_empty() { "" } else { "\n" };
        found.push(format!("breakdown at t = {at} s: {}{remedy}{}", breakdown.reason, breakdown.remedy));
    }
    if let Some(part) = summary.mass_balance.filter(|&part| part > Summary::BALANCED) {
        found.push(format!(
            "The flow through the boundaries of the fluid does not balance: at some step {part:.1e} of the largest flow \
             is gained or lost."
        ));
    }
    if summary.direct_fallbacks > 0 {
        let n = summary.direct_fallbacks;
        let steps = if n == 1 { "step was" } else { "steps were" };
        found.push(format!("{n} {steps} begun anew with the whole Jacobian and a direct solver."));
    }
    if let Some((case, overview)) = &content.overview {
        found.extend(case.notes().iter().cloned());
        found.extend(overview.warnings.iter().chain(&overview.notes).cloned());
    }
    if let Published::Departs(why) = &content.published {
        found.push(why.clone());
    }
    if found.is_empty() {
        return;
    }
    let items: String = found.iter().map(|text| format!("<li>{}</li>", html::escape(text.trim()))).collect();
    page.raw(&format!(
        "<div class=\"warnings\"><h2 id=\"warnings\">Warnings and notes</h2><ul>{items}</ul></div>"
    ));
}

/// The player.
pub fn fields(page: &mut Html, fields: &Scene, in_time: bool) {
    page.heading(2, Some("fields"), "Fields");
    match fields {
        Scene::None => page.paragraph("The run has written no fields."),
        Scene::TooLarge(why) => page.paragraph(why),
        Scene::Shown(scene, left) => {
            page.raw("<div id=\"player\"><noscript>The fields are drawn by a script.</noscript></div>");
            left.iter().for_each(|left| page.paragraph(left));
            if in_time && scene["written"] == 1 {
                page.raw(
                    "<p class=\"data\">The run has written one moment; <code>output.fields-interval</code> gives more, \
                     which can be played.</p>",
                );
            }
        }
    }
}

/// Histories, spectra and phase portraits.
pub fn histories(page: &mut Html, histories: Option<&(Value, Option<String>)>) {
    let Some((value, left)) = histories else { return };
    page.heading(2, Some("histories"), "Histories");
    page.raw(
        "<p class=\"data\">Drag to zoom, double-click for all; keys: + − ← → 0. Dashed: published range.</p>\
         <div id=\"history-charts\" class=\"charts\"></div>",
    );
    left.iter().for_each(|left| page.paragraph(left));
    let signals = value["signals"].as_array().map_or(&[][..], Vec::as_slice);
    if signals.iter().any(|signal| !signal["spectrum"].is_null()) {
        page.heading(2, Some("periodic"), "Spectra and phase portraits");
        page.raw(
            "<p class=\"data\">Of what is periodic at the end. The spectrum is that of the last 20 periods, the portrait \
             that of the last 5.</p><div id=\"periodic-charts\"></div>",
        );
    }
}

/// The numbers of all functionals.
pub fn numbers(page: &mut Html, content: &Content) {
    let computed = content.results.computed();
    if computed.is_empty() {
        return;
    }
    page.heading(2, Some("numbers"), "Numbers");
    let shown = |x: Option<f64>| x.map_or("–".to_string(), |x| significant(x, 7));
    let rows: Vec<Vec<String>> = computed
        .iter()
        .map(|(name, found)| {
            let n = &found.numbers;
            let mut row = vec![name.clone(), found.unit.clone()];
            row.extend([n.value, n.mean, n.amplitude, n.frequency, n.min, n.max].map(shown));
            row
        })
        .collect();
    let head = ["functional", "unit", "last", "mean", "amplitude", "frequency [Hz]", "min", "max"];
    page.table(&head, &rows, "numbers");
}

/// Published values beside computed ones.
pub fn published(page: &mut Html, content: &Content) {
    let Published::Table(comparison) = &content.published else { return };
    page.heading(2, Some("published"), "Published values");
    let head = ["functional", "", "unit", "computed", "published", "deviation", "uncertainty", "source"];
    let (first, others): (Vec<&Row>, Vec<&Row>) = comparison.rows.iter().partition(|row| row.primary);
    page.raw_table(&head, &first.into_iter().map(beside).collect::<Vec<_>>(), "numbers sources");
    if !others.is_empty() {
        page.raw(&format!("<details><summary>{} values of other sources</summary>", others.len()));
        page.raw_table(&head, &others.into_iter().map(beside).collect::<Vec<_>>(), "numbers sources");
        page.raw("</details>");
    }
    if comparison.rows.iter().any(|row| row.quantity == "mean") {
        page.paragraph("Deviations of a mean are relative to the amplitude where that is larger.");
    }
    for departure in &comparison.left_out {
        page.paragraph(&format!("Not what was published: {departure}"));
    }
}

fn beside(row: &Row) -> Vec<String> {
    let percent = |x: f64| format!("{:+.2} %", 100.0 * x).replace('-', "\u{2212}");
    let within = row.deviation.zip(row.uncertainty).map(|(d, u)| d.abs() <= u);
    let class = match within {
        Some(true) => "good",
        Some(false) => "bad",
        None => "plain",
    };
    let deviation = row.deviation.map_or("–".into(), percent);
    vec![
        html::escape(&row.functional),
        row.quantity.into(),
        html::escape(&row.unit),
        row.computed.map_or("–".into(), |x| significant(x, 6)),
        format!("<span class=\"published\">{}</span>", significant(row.published, 8)),
        format!("<span class=\"{class}\">{deviation}</span>"),
        row.uncertainty.map_or(String::new(), |x| format!("{} %", significant(100.0 * x, 2))),
        format!("<span class=\"published\">{}</span>", html::escape(&row.source)),
    ]
}

/// Balances, iterations and where the time went.
pub fn solver(page: &mut Html, content: &Content, in_time: bool) {
    let summary = &content.results.summary;
    page.heading(2, Some("solver"), "Balances, iterations, time");
    let mut rows = vec![];
    let mut fact = |name: &str, text: String| rows.push(vec![name.to_string(), text]);
    if let Some(part) = summary.mass_balance {
        fact(
            "mass",
            format!("largest net flow through the boundaries of the fluid {part:.1e} of the largest flow"),
        );
    }
    if let Some(part) = summary.swept_volume {
        fact(
            "volume",
            format!("change of the fluid's volume and flow at the interface differ by up to {part:.1e}"),
        );
    }
    let energies = content.results.computed();
    let of_energy = |unit: &str| ["J", "J/m", "W", "W/m"].contains(&unit);
    for (name, found) in energies.iter().filter(|(_, found)| of_energy(&found.unit)) {
        if let Some(value) = found.numbers.value {
            fact("energy", format!("{name}: last {} {}", significant(value, 6), found.unit));
        }
    }
    let steps = (summary.steps as f64).max(1.0);
    let each = |n: u64| significant(n as f64 / steps, 3);
    let per_step = |n: u64| match in_time {
        true => format!("{}, {} for each step", grouped(n as usize), each(n)),
        false => grouped(n as usize),
    };
    fact("Newton iterations", per_step(summary.newton_steps));
    if summary.linear_iterations > 0 {
        fact("linear iterations", per_step(summary.linear_iterations));
    }
    fact("Jacobians", per_step(summary.jacobians));
    fact("factorizations", per_step(summary.factorizations));
    if let Some(rejected) = summary.rejected_steps {
        fact("rejected steps", grouped(rejected as usize));
    }
    page.table(&[], &rows, "facts");
    if in_time {
        page.raw("<div id=\"count-charts\" class=\"charts\"></div>");
    }
    time(page, summary, steps);
}

/// Where the time went.
fn time(page: &mut Html, summary: &Summary, steps: f64) {
    let whole = summary.wall_seconds;
    if whole.is_nan() || whole <= 0.0 {
        return;
    }
    let phases = &summary.phases;
    let known = phases.assembly + phases.factorization + phases.solve + phases.output;
    let pieces = steps * summary.unknowns.total as f64;
    let parts = [
        ("assembly", phases.assembly),
        ("factorization", phases.factorization),
        ("solve", phases.solve),
        ("output", phases.output),
        ("everything else", (whole - known).max(0.0)),
        ("whole run", whole),
    ];
    let rows: Vec<Vec<String>> = parts
        .iter()
        .map(|(name, seconds)| {
            let part = 100.0 * seconds / whole;
            vec![
                name.to_string(),
                duration(*seconds),
                significant(part, 3),
                significant(1e6 * seconds / pieces.max(1.0), 3),
                format!("<span class=\"bar\" style=\"width:{part:.1}%\"></span>"),
            ]
        })
        .collect();
    page.raw_table(&["phase", "time", "%", "µs per unknown and step", ""], &rows, "numbers phases");
    let mut rows = vec![];
    if let Some(seconds) = summary.cpu_seconds {
        let each = significant(1e6 * seconds / pieces.max(1.0), 3);
        rows.push(vec![
            "processor time".to_string(),
            format!("{}, {each} µs per unknown and step", duration(seconds)),
        ]);
    }
    if let Some(bytes) = summary.peak_memory_bytes {
        rows.push(vec!["largest memory".into(), format!("{} MB", significant(bytes as f64 / 1e6, 3))]);
    }
    page.table(&[], &rows, "facts");
}

/// Which program, when, where.
pub fn provenance(page: &mut Html, content: &Content) {
    let summary = &content.results.summary;
    let of = &summary.provenance;
    page.heading(2, Some("provenance"), "Provenance");
    let mut rows = vec![];
    let mut fact = |name: &str, text: String| {
        if !text.trim().is_empty() {
            rows.push(vec![name.to_string(), text]);
        }
    };
    fact("program", format!("undula {} {}", of.version, of.commit.clone().unwrap_or_default()));
    fact("date", of.date.clone());
    fact("processor", of.processor.clone().unwrap_or_default());
    fact("threads", summary.threads.to_string());
    fact("case", of.case_hash.clone().unwrap_or_default());
    fact("mesh file", of.mesh_hash.clone().unwrap_or_default());
    fact("directory", content.run.path().display().to_string());
    page.table(&[], &rows, "facts");
}

/// The whole case.
pub fn case(page: &mut Html, content: &Content) {
    page.heading(2, Some("case"), "Case");
    page.raw(&format!(
        "<details open><summary>case.toml, with all defaults</summary><pre>{}</pre></details>",
        html::escape(&content.toml)
    ));
}
