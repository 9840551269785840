//! Pages: one HTML file with all of its styles and drawings, and tables of numbers (CSV) beside it.

mod chart;
pub mod html;

pub use html::Html;

use crate::digits::significant;
use crate::plot;
use std::fmt::Write;
use std::path::Path;
use undula::output::{Provenance, Status, write_atomic};
use undula::study::{Cell, PictureEntry, Report, RunRow, Shown, Table, Verdict, Weighed};

/// What a page is about.
pub struct Heading<'a> {
    /// Title.
    pub title: &'a str,
    /// Paragraphs.
    pub about: &'a [&'a str],
    /// Command that makes the page.
    pub command: &'a str,
}

/// Writes `index.html` and the tables of `reports` into `directory`.
///
/// # Errors
/// Files that cannot be written.
pub fn write(directory: &Path, heading: &Heading<'_>, reports: &[Report]) -> anyhow::Result<()> {
    let mut page = Html::new(heading.title);
    page.heading(1, None, heading.title);
    heading.about.iter().for_each(|text| page.paragraph(text));
    provenance(&mut page, heading, reports);
    if reports.len() > 1 {
        contents(&mut page, reports);
    }
    for report in reports {
        study(&mut page, directory, report)?;
    }
    let text = page.finish();
    write_atomic(directory.join("index.html"), |file| std::io::Write::write_all(file, text.as_bytes()))?;
    let json = serde_json::to_string_pretty(&reports.iter().map(results).collect::<Vec<_>>())?;
    write_atomic(directory.join("results.json"), |file| std::io::Write::write_all(file, json.as_bytes()))?;
    Ok(())
}

/// How many statements have each verdict.
pub fn count(reports: &[Report], verdict: Verdict) -> usize {
    reports.iter().flat_map(|report| &report.statements).filter(|s| s.verdict == verdict).count()
}

fn provenance(page: &mut Html, heading: &Heading<'_>, reports: &[Report]) {
    let now = Provenance::now(option_env!("UNDULA_COMMIT").map(String::from));
    let seconds: f64 = reports.iter().flat_map(|report| &report.runs).map(|run| run.seconds).sum();
    let mut rows = vec![
        vec!["command".to_string(), heading.command.to_string()],
        vec!["program".into(), format!("undula {} {}", now.version, now.commit.unwrap_or_default())],
        vec!["written".into(), now.date],
        vec!["processor".into(), now.processor.unwrap_or_else(|| "unknown".into())],
        vec!["time of all runs".into(), duration(seconds)],
    ];
    let statements: usize = reports.iter().map(|report| report.statements.len()).sum();
    if statements > 0 {
        let lost: usize = reports.iter().map(|report| report.lost.len()).sum();
        let n = |verdict| count(reports, verdict);
        let text = format!(
            "{statements}: {} reproduced, {} not reproduced, {} undecided; {lost} not comparable",
            n(Verdict::Reproduced),
            n(Verdict::NotReproduced),
            n(Verdict::Undecided)
        );
        rows.push(vec!["statements".into(), text]);
    }
    page.table(&[], &rows, "facts");
}

fn contents(page: &mut Html, reports: &[Report]) {
    let head = ["study", "section", "statements", "reproduced", "not", "undecided", "not comparable", "time"];
    let rows: Vec<Vec<String>> = reports
        .iter()
        .map(|report| {
            let n = |verdict| count(std::slice::from_ref(report), verdict).to_string();
            vec![
                html::link(&format!("#{}", report.name), &report.title),
                html::escape(&report.section),
                report.statements.len().to_string(),
                n(Verdict::Reproduced),
                n(Verdict::NotReproduced),
                n(Verdict::Undecided),
                report.lost.len().to_string(),
                duration(report.runs.iter().map(|run| run.seconds).sum()),
            ]
        })
        .collect();
    page.raw_table(&head, &rows, "numbers");
}

fn study(page: &mut Html, directory: &Path, report: &Report) -> anyhow::Result<()> {
    let section = if report.section.is_empty() { String::new() } else { format!(" ({})", report.section) };
    page.heading(2, Some(&report.name), &format!("{}{section}", report.title));
    if report.quick {
        page.paragraph(
            "A quick study: coarser or shorter runs than those of the full study, as the table of runs says.",
        );
    }
    report.about.iter().for_each(|text| page.paragraph(text));
    let folder = directory.join(&report.name);
    std::fs::create_dir_all(&folder)?;
    if !report.statements.is_empty() {
        page.heading(3, None, "Statements");
        statements(page, &report.statements);
    }
    if !report.lost.is_empty() {
        page.heading(3, None, "Not comparable");
        let rows: Vec<Vec<String>> = report
            .lost
            .iter()
            .map(|lost| vec![lost.text.clone(), lost.section.clone(), lost.because.clone()])
            .collect();
        page.table(&["what", "where", "why"], &rows, "texts");
    }
    for (n, table) in report.tables.iter().enumerate() {
        page.heading(3, None, &table.title);
        page.raw_table(&table.head.iter().map(String::as_str).collect::<Vec<_>>(), &cells(table), "numbers");
        if !table.note.is_empty() {
            page.paragraph(&table.note);
        }
        csv(page, &folder, &report.name, &format!("table-{}", n + 1), &table_csv(table))?;
    }
    for (n, figure) in report.figures.iter().enumerate() {
        page.heading(3, None, &figure.entry.title);
        if figure.curves.is_empty() {
            page.paragraph("No run of this figure has results.");
            continue;
        }
        page.figure(&chart::draw(figure, &format!("{}-{n}", report.name)), &figure.entry.title);
        if !figure.entry.note.is_empty() {
            page.paragraph(&figure.entry.note);
        }
        csv(page, &folder, &report.name, &format!("figure-{}", n + 1), &chart::csv(figure))?;
    }
    pictures(page, &folder, report)?;
    page.heading(3, None, "Runs");
    runs(page, report);
    if let Some(numbers) = numbers_csv(report) {
        csv(page, &folder, &report.name, "numbers", &numbers)?;
    }
    csv(page, &folder, &report.name, "runs", &runs_csv(report))
}

/// Pictures of fields, within the page and as files beside it.
fn pictures(page: &mut Html, folder: &Path, report: &Report) -> anyhow::Result<()> {
    for (n, picture) in report.pictures.iter().enumerate() {
        page.heading(3, None, &picture.entry.title);
        let PictureEntry { time, field, .. } = &picture.entry;
        let image = match &picture.directory {
            Some(directory) => plot::picture_at(directory, time.as_ref().and_then(Cell::number), field)?,
            None => None,
        };
        let Some(image) = image else {
            page.paragraph("The run of this picture has no fields.");
            continue;
        };
        let png = image.halved().png()?;
        write_atomic(folder.join(format!("picture-{}.png", n + 1)), |out| {
            std::io::Write::write_all(out, &png)
        })?;
        page.picture(&png, &picture.entry.title);
    }
    Ok(())
}

fn csv(page: &mut Html, folder: &Path, study: &str, name: &str, text: &str) -> anyhow::Result<()> {
    let file = format!("{name}.csv");
    write_atomic(folder.join(&file), |out| std::io::Write::write_all(out, text.as_bytes()))?;
    page.raw(&format!("<p class=\"data\">{}</p>", html::link(&format!("{study}/{file}"), &file)));
    Ok(())
}

fn statements(page: &mut Html, statements: &[Weighed]) {
    let head = ["", "statement", "where", "published", "computed"];
    let rows: Vec<Vec<String>> = statements
        .iter()
        .map(|weighed| {
            let Weighed { statement, number, verdict, missing } = weighed;
            let unit = if statement.unit.is_empty() { String::new() } else { format!(" {}", statement.unit) };
            let mut text = html::escape(&statement.text);
            if *verdict == Verdict::NotReproduced && !statement.because.is_empty() {
                let _ = write!(text, "<br><small>{}</small>", html::escape(&statement.because));
            }
            if !missing.is_empty() {
                let _ = write!(text, "<br><small>missing: {}</small>", html::escape(&missing.join(", ")));
            }
            let _ = write!(text, "<details><summary>condition</summary>{}", html::code(&statement.holds));
            if !statement.number.is_empty() {
                let _ = write!(text, "<br>it = {}", html::code(&statement.number));
            }
            text += "</details>";
            let shown = |x: Option<f64>| x.map_or(String::new(), |x| format!("{}{unit}", significant(x, 4)));
            let class = match verdict {
                Verdict::Reproduced => "yes",
                Verdict::NotReproduced => "no",
                Verdict::Undecided => "open",
            };
            let published = shown(statement.published());
            vec![
                format!("<span class=\"{class}\">{verdict}</span>"),
                text,
                html::escape(&statement.section),
                format!("<span class=\"published\">{published}</span>"),
                shown(*number),
            ]
        })
        .collect();
    page.raw_table(&head, &rows, "texts verdicts");
}

fn cells(table: &Table) -> Vec<Vec<String>> {
    let cell = |cell: &Shown| match cell {
        Shown::Text(text) => html::escape(text),
        Shown::Published(x) => format!("<span class=\"published\">{}</span>", html::escape(&x.to_string())),
        Shown::Computed(Some(x)) => significant(*x, 4),
        Shown::Exact(x) => significant(*x, 7),
        Shown::Computed(None) => "–".into(),
    };
    table.rows.iter().map(|row| row.iter().map(cell).collect()).collect()
}

fn table_csv(table: &Table) -> String {
    let mut text = line(table.head.iter().cloned());
    for row in &table.rows {
        text += &line(row.iter().map(|cell| match cell {
            Shown::Text(text) => text.clone(),
            Shown::Published(x) | Shown::Exact(x) | Shown::Computed(Some(x)) => x.to_string(),
            Shown::Computed(None) => String::new(),
        }));
    }
    text
}

/// A line of a table, with quotes where they are needed.
pub fn line(cells: impl Iterator<Item = String>) -> String {
    let quoted = |cell: String| match cell.contains([',', '"', '\n']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell,
    };
    cells.map(quoted).collect::<Vec<_>>().join(",") + "\n"
}

fn settings(run: &RunRow) -> String {
    run.settings.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join("\n")
}

fn status(run: &RunRow) -> String {
    match run.status {
        None => "not run".into(),
        Some(Status::Breakdown) => "breakdown".into(),
        Some(status) => status.to_string(),
    }
}

/// `mean ± amplitude [frequency]` of what is periodic, else the last value.
fn value([last, mean, amplitude, frequency]: [Option<f64>; 4]) -> String {
    match (mean, amplitude) {
        (Some(mean), Some(amplitude)) => {
            let frequency = frequency.map_or(String::new(), |f| format!(" [{} Hz]", significant(f, 4)));
            format!("{} ± {}{frequency}", significant(mean, 5), significant(amplitude, 5))
        }
        _ => last.map_or("–".into(), |last| significant(last, 6)),
    }
}

fn runs(page: &mut Html, report: &Report) {
    let mut head: Vec<String> =
        ["run", "case", "settings", "unknowns", "end", "t [s]", "seconds"].map(String::from).into();
    for (n, name) in report.functionals.iter().enumerate() {
        let unit = report.runs.iter().find_map(|run| run.units.get(n).filter(|unit| !unit.is_empty()));
        head.push(unit.map_or_else(|| name.clone(), |unit| format!("{name} [{unit}]")));
    }
    let rows: Vec<Vec<String>> = report
        .runs
        .iter()
        .map(|run| {
            let mut row = vec![
                html::escape(&run.name),
                html::escape(&run.case),
                html::escape(&settings(run)).replace('\n', "<br>"),
                if run.unknowns > 0 { run.unknowns.to_string() } else { String::new() },
                status(run),
                match run.time {
                    Some(t) => significant(t, 5),
                    None if run.unknowns > 0 => "stationary".into(),
                    None => String::new(),
                },
                significant(run.seconds, 3),
            ];
            row.extend(run.values.iter().map(|v| html::escape(&value(*v))));
            row
        })
        .collect();
    page.raw_table(&head.iter().map(String::as_str).collect::<Vec<_>>(), &rows, "numbers runs");
}

/// Numbers that were computed besides or instead of histories.
fn numbers_csv(report: &Report) -> Option<String> {
    let mut text = line(["run", "number", "value"].map(String::from).into_iter());
    let numbers = report.runs.iter().flat_map(|run| run.numbers.iter().map(move |(name, x)| (run, name, x)));
    for (run, name, x) in numbers {
        text += &line([run.name.clone(), name.clone(), x.to_string()].into_iter());
    }
    (text.lines().count() > 1).then_some(text)
}

fn runs_csv(report: &Report) -> String {
    let mut head: Vec<String> =
        ["run", "case", "settings", "unknowns", "status", "time", "seconds", "commit"]
            .map(String::from)
            .into();
    for name in &report.functionals {
        head.extend(["last", "mean", "amplitude", "frequency"].map(|quantity| format!("{name}.{quantity}")));
    }
    let mut text = line(head.into_iter());
    for run in &report.runs {
        let number = |x: Option<f64>| x.map_or(String::new(), |x| x.to_string());
        let mut row = vec![
            run.name.clone(),
            run.case.clone(),
            settings(run).replace('\n', "; "),
            run.unknowns.to_string(),
            status(run),
            number(run.time),
            run.seconds.to_string(),
            run.commit.clone().unwrap_or_default(),
        ];
        row.extend(run.values.iter().flatten().map(|x| number(*x)));
        text += &line(row.into_iter());
    }
    text
}

/// A report for programs.
fn results(report: &Report) -> serde_json::Value {
    let statements: Vec<serde_json::Value> = report
        .statements
        .iter()
        .map(|Weighed { statement, number, verdict, missing }| {
            serde_json::json!({
                "text": statement.text, "section": statement.section, "number": number, "unit": statement.unit,
                "published": statement.published(), "expression": statement.number, "holds": statement.holds,
                "verdict": verdict.to_string(), "because": statement.because, "missing": missing,
            })
        })
        .collect();
    serde_json::json!({
        "study": report.name, "title": report.title, "section": report.section, "quick": report.quick,
        "statements": statements,
        "seconds": report.runs.iter().map(|run| run.seconds).sum::<f64>(),
    })
}

/// Minutes where seconds are many.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{} s", significant(s, 3)),
        s if s < 7200.0 => format!("{} min", significant(s / 60.0, 3)),
        s => format!("{} h", significant(s / 3600.0, 3)),
    }
}
