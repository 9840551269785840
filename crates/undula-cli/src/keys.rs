//! `undula keys`: the keys of a case with units, default values and the names of their values.

use crate::args::{KeysArgs, bad_input, print};
use crate::schema;
use std::process::ExitCode;
use undula::case::keys::{Found, nearest, search};

/// Columns of the output in characters, as long as the texts in the other columns leave room.
const WIDTH: usize = 120;
/// Columns that the meaning has at least.
const LEAST: usize = 30;

/// Prints the keys that match, aligned or as Markdown.
///
/// # Errors
/// Standard output cannot be written.
pub fn run(args: &KeysArgs) -> anyhow::Result<ExitCode> {
    if args.schema {
        return print(&format!("{:#}\n", schema::schema()));
    }
    let pattern = args.pattern.as_deref().unwrap_or("");
    let found = search(pattern);
    if found.is_empty() {
        let hint = nearest(pattern);
        let rest = if hint.is_empty() { ";" } else { "" };
        let all = "`undula keys` lists all keys";
        return bad_input(format_args!("no key, table or value matches `{pattern}`{hint}{rest} {all}"));
    }
    print(&if args.markdown { markdown(&found) } else { aligned(&found) })
}

/// A line per key, and one per value below it; meanings that do not fit go on in the next line.
pub fn aligned(found: &[Found]) -> String {
    let title = ["key", "unit", "default"];
    let keys = found.iter().map(|found| [found.key.key, found.key.unit, found.key.default]);
    let widths = keys.clone().fold(title.map(str::len), |widths: [usize; 3], cells| {
        std::array::from_fn(|i| widths[i].max(cells[i].chars().count()))
    });
    let [key, unit, default] = widths;
    let begin = key + unit + default + 6;
    let mut text = format!("{:key$}  {:unit$}  {:default$}  meaning\n", title[0], title[1], title[2]);
    for (found, cells) in found.iter().zip(keys) {
        let head = format!("{:key$}  {:unit$}  {:default$}  ", cells[0], cells[1], cells[2]);
        wrap(&mut text, &head, found.key.about, begin);
        for (name, about) in &found.choices {
            wrap(&mut text, &format!("  = {name:0$}  ", begin.saturating_sub(6)), about, begin);
        }
    }
    text
}

/// `head` and the words of `about`, from column `begin` on.
fn wrap(text: &mut String, head: &str, about: &str, begin: usize) {
    let end = WIDTH.max(begin + LEAST);
    let mut line = head.to_string();
    let mut is_empty = true;
    for word in about.split(' ') {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > end {
            *text += &format!("{}\n", line.trim_end());
            (line, is_empty) = (" ".repeat(begin), true);
        }
        if !is_empty {
            line.push(' ');
        }
        line += word;
        is_empty = false;
    }
    *text += &format!("{}\n", line.trim_end());
}

/// A table of Markdown for each table of a case.
fn markdown(found: &[Found]) -> String {
    let mut text = String::from(
        "# Keys of a case\n\nThis page is the output of `undula keys --markdown`. `NAME` stands for a name that the case \
         chooses. A row that begins\nwith `=` is a value of the key above it. A number may have a unit, as in `\"1 mm\"` or `\"120 mmHg\"`; an expression \
         may\ntake values from a table, as in `table(\"inflow.csv\", t)`: see [methods/data.md](methods/data.md).\n",
    );
    let mut table = None;
    for Found { key, choices } in found {
        if table != Some(key.table()) {
            table = Some(key.table());
            let title = if key.table().is_empty() { "The case".into() } else { format!("[{}]", key.table()) };
            text +=
                &format!("\n## {title}\n\n| key | unit | default | meaning |\n| --- | --- | --- | --- |\n");
        }
        let name = key.key.rsplit('.').next().unwrap_or(key.key);
        text += &format!("| `{name}` | {} | {} | {} |\n", key.unit, key.default, escaped(key.about));
        for (name, about) in choices {
            text += &format!("| = `{name}` | | | {} |\n", escaped(about));
        }
    }
    text
}

/// Text in which Markdown sees no markup.
fn escaped(text: &str) -> String {
    text.chars().fold(String::new(), |text, c| match c {
        '|' | '*' | '[' | ']' | '<' | '>' | '_' => format!("{text}\\{c}"),
        c => format!("{text}{c}"),
    })
}
