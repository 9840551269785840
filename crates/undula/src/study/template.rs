//! Entries of a study that stand for several: `each` with `{1}`, `{2}`, … in their texts.

use super::file::{Cell, CurveEntry, PictureEntry, Statement, Study, TableEntry};

/// `text` with `{1}` and those after it replaced by `values`.
fn filled(text: &str, values: &[Cell]) -> Result<String, String> {
    let mut text = text.to_string();
    for (n, value) in values.iter().enumerate() {
        let value = match value {
            Cell::Number(x) => x.to_string(),
            Cell::Text(word) => word.clone(),
        };
        text = text.replace(&format!("{{{}}}", n + 1), &value);
    }
    let left = (1..=9).map(|n| format!("{{{n}}}")).find(|mark| text.contains(mark.as_str()));
    match left {
        Some(mark) => Err(format!("`{text}`: each: expected a value for {mark}")),
        None => Ok(text),
    }
}

fn filled_cell(cell: &Cell, values: &[Cell]) -> Result<Cell, String> {
    let Cell::Text(text) = cell else { return Ok(cell.clone()) };
    match values.iter().enumerate().find(|(n, _)| *text == format!("{{{}}}", n + 1)) {
        Some((_, value)) => Ok(value.clone()),
        None => filled(text, values).map(Cell::Text),
    }
}

impl Study {
    /// Makes the rows, curves, points, pictures and statements that stand for `each` of several values.
    pub(super) fn expand(&mut self) -> Result<(), String> {
        for table in &mut self.table {
            table.expand()?;
        }
        for figure in &mut self.figure {
            let mut curves = vec![];
            for curve in &figure.curves {
                curves.extend(curve.expanded()?);
            }
            figure.curves = curves;
        }
        self.picture = expanded(&self.picture, |picture| &picture.each, PictureEntry::filled)?;
        self.statement = expanded(&self.statement, |statement| &statement.each, Statement::filled)?;
        let a_number = |what: &str, title: &str, cell: &Option<Cell>| match cell {
            Some(Cell::Text(text)) => Err(format!("{what} {title:?}: {text:?}: expected a number")),
            _ => Ok(()),
        };
        for picture in &self.picture {
            a_number("time of the picture", &picture.title, &picture.time)?;
        }
        for statement in &self.statement {
            a_number("published of the statement", &statement.text, &statement.published)?;
        }
        Ok(())
    }
}

impl TableEntry {
    /// Makes the rows that stand for `each` of several values.
    fn expand(&mut self) -> Result<(), String> {
        if self.each.is_empty() != self.row.is_empty() {
            return Err(format!("table {:?}: expected both `each` and `row`, or none of them", self.title));
        }
        for values in std::mem::take(&mut self.each) {
            self.rows.push(self.row.iter().map(|cell| filled_cell(cell, &values)).collect::<Result<_, _>>()?);
        }
        Ok(())
    }
}

impl PictureEntry {
    /// The picture for `values`.
    fn filled(&self, values: &[Cell]) -> Result<PictureEntry, String> {
        let [title, run, field] = [&self.title, &self.run, &self.field].map(|text| filled(text, values));
        let time = self.time.as_ref().map(|cell| filled_cell(cell, values)).transpose()?;
        Ok(PictureEntry { title: title?, run: run?, field: field?, time, each: vec![] })
    }
}

impl Statement {
    /// The statement for `values`.
    fn filled(&self, values: &[Cell]) -> Result<Statement, String> {
        let published = self.published.as_ref().map(|cell| filled_cell(cell, values)).transpose()?;
        let [text, section, number] =
            [&self.text, &self.section, &self.number].map(|text| filled(text, values));
        let [unit, holds, because] =
            [&self.unit, &self.holds, &self.because].map(|text| filled(text, values));
        Ok(Statement {
            text: text?,
            section: section?,
            number: number?,
            unit: unit?,
            published,
            holds: holds?,
            because: because?,
            each: vec![],
        })
    }
}

/// Entries with those that stand for several written out.
fn expanded<T: Clone>(
    entries: &[T],
    each: impl Fn(&T) -> &Vec<Vec<Cell>>,
    fill: impl Fn(&T, &[Cell]) -> Result<T, String>,
) -> Result<Vec<T>, String> {
    let mut all = vec![];
    for entry in entries {
        match &each(entry)[..] {
            [] => all.push(entry.clone()),
            values => {
                for values in values {
                    all.push(fill(entry, values)?);
                }
            }
        }
    }
    Ok(all)
}

impl CurveEntry {
    /// Itself, with its points, or the curves that it stands for.
    fn expanded(&self) -> Result<Vec<CurveEntry>, String> {
        if let [x, y] = &self.point[..] {
            if self.each.is_empty() {
                return Err(format!("curve {:?}: point: expected `each` with its values", self.name));
            }
            let mut curve = CurveEntry { each: vec![], point: vec![], ..self.clone() };
            for values in &self.each {
                curve.points.push([filled_cell(x, values)?, filled_cell(y, values)?]);
            }
            return Ok(vec![curve]);
        }
        if !self.point.is_empty() {
            return Err(format!("curve {:?}: point: expected two coordinates", self.name));
        }
        expanded(
            std::slice::from_ref(self),
            |curve| &curve.each,
            |curve, values| {
                let [name, of, factor] =
                    [&curve.name, &curve.of, &curve.factor].map(|text| filled(text, values));
                Ok(CurveEntry { name: name?, of: of?, factor: factor?, each: vec![], ..curve.clone() })
            },
        )
    }
}
