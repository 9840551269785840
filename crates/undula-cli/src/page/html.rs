//! HTML: text is escaped, what is called `raw` is not.

use base64::prelude::{BASE64_STANDARD, Engine};
use std::fmt::Write;

const STYLE: &str = include_str!("style.css");

/// A page in the making.
pub struct Html {
    text: String,
}

/// `text` for a place between tags or within quotes.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A link.
pub fn link(to: &str, text: &str) -> String {
    format!("<a href=\"{}\">{}</a>", escape(to), escape(text))
}

/// An expression.
pub fn code(text: &str) -> String {
    format!("<code>{}</code>", escape(text))
}

impl Html {
    /// A page without content.
    pub fn new(title: &str) -> Self {
        Self::styled(title, "")
    }

    /// The same with more styles.
    pub fn styled(title: &str, style: &str) -> Self {
        let title = escape(title);
        let text = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>\n{STYLE}{style}</style>\n</head>\n<body>\n<main>\n"
        );
        Html { text }
    }

    /// The whole page.
    pub fn finish(self) -> String {
        self.text + "</main>\n</body>\n</html>\n"
    }

    /// HTML as it is.
    pub fn raw(&mut self, html: &str) {
        self.text += html;
        self.text.push('\n');
    }

    /// A heading; links lead to its `id`.
    pub fn heading(&mut self, level: u8, id: Option<&str>, text: &str) {
        let id = id.map_or(String::new(), |id| format!(" id=\"{}\"", escape(id)));
        let _ = writeln!(self.text, "<h{level}{id}>{}</h{level}>", escape(text));
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.text, "<p>{}</p>", escape(text));
    }

    /// A table of texts.
    pub fn table(&mut self, head: &[&str], rows: &[Vec<String>], class: &str) {
        let rows: Vec<Vec<String>> =
            rows.iter().map(|row| row.iter().map(|cell| escape(cell)).collect()).collect();
        self.raw_table(head, &rows, class);
    }

    /// A table of HTML.
    pub fn raw_table(&mut self, head: &[&str], rows: &[Vec<String>], class: &str) {
        let _ = writeln!(self.text, "<div class=\"wide\"><table class=\"{class}\">");
        if !head.is_empty() {
            let cells: String = head.iter().map(|cell| format!("<th>{}</th>", escape(cell))).collect();
            let _ = writeln!(self.text, "<thead><tr>{cells}</tr></thead>");
        }
        self.text += "<tbody>\n";
        for row in rows {
            let cells: String = row.iter().map(|cell| format!("<td>{cell}</td>")).collect();
            let _ = writeln!(self.text, "<tr>{cells}</tr>");
        }
        self.text += "</tbody></table></div>\n";
    }

    /// Data for the scripts of the page.
    pub fn data(&mut self, id: &str, value: &serde_json::Value) {
        // Nothing within the data may end their element.
        let text = value.to_string().replace('<', "\\u003c");
        let _ =
            writeln!(self.text, "<script type=\"application/json\" id=\"{}\">{text}</script>", escape(id));
    }

    /// A script.
    pub fn script(&mut self, parts: &[&str]) {
        let _ = writeln!(self.text, "<script>\n{}</script>", parts.concat());
    }

    /// A drawing.
    pub fn figure(&mut self, svg: &str, alt: &str) {
        let _ = writeln!(self.text, "<figure role=\"img\" aria-label=\"{}\">{svg}</figure>", escape(alt));
    }

    /// A picture, as a part of the page.
    pub fn picture(&mut self, png: &[u8], alt: &str) {
        let (data, alt) = (BASE64_STANDARD.encode(png), escape(alt));
        let _ =
            writeln!(self.text, "<figure><img src=\"data:image/png;base64,{data}\" alt=\"{alt}\"></figure>");
    }
}
