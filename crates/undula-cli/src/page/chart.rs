//! Figures of studies.

use super::line;
use crate::plot::colors::{GREY, INK, LINES, Rgb};
use crate::plot::figure::{Anchor, Figure, Panel};
use undula::study::{Curve, Figure as Content};

const WIDTH: f64 = 880.0;
const HEIGHT: f64 = 330.0;
/// Half the side of a mark.
const MARK: f64 = 3.0;

/// The figure as SVG; `id` is a name that no other drawing of the page has.
pub fn draw(content: &Content, id: &str) -> String {
    let entry = &content.entry;
    let place = |x: f64| if entry.logarithmic { x.log10() } else { x };
    let placed: Vec<(Vec<f64>, Vec<f64>)> = content
        .curves
        .iter()
        .map(|curve| {
            (curve.x.iter().map(|&x| place(x)).collect(), curve.y.iter().map(|&y| place(y)).collect())
        })
        .collect();
    let x = range(placed.iter().flat_map(|(x, _)| x), entry.from.map(place), entry.to.map(place), 0.0);
    let inside = placed
        .iter()
        .flat_map(|(xs, ys)| xs.iter().zip(ys).filter(|(at, _)| (x.0..=x.1).contains(*at)).map(|(_, y)| y));
    let y = range(inside, entry.low.map(place), entry.high.map(place), 0.05);
    let legend = 22.0 * content.curves.len().div_ceil(3) as f64;
    let top = 34.0 + legend;
    let mut panel =
        Panel { left: 0.0, top, width: WIDTH, height: HEIGHT, x, y, logarithmic: entry.logarithmic };
    panel.left = panel.margin() + 8.0;
    panel.width -= panel.left + 16.0;
    let mut figure = Figure::named(WIDTH, top + HEIGHT + 50.0, id);
    panel.grid(&mut figure);
    for (n, (curve, (x, y))) in content.curves.iter().zip(&placed).enumerate() {
        let ink = ink(n, curve);
        if curve.marked {
            marks(&mut figure, &panel, x, y, ink);
        } else {
            panel.graph(&mut figure, x, y, ink, 1.4);
        }
        let (column, row) = (n % 3, n / 3);
        let at = (panel.left + column as f64 * panel.width / 3.0, 16.0 + 22.0 * row as f64);
        figure.fill([at.0, at.1 - 7.0, 18.0, 4.0], ink);
        figure.text((at.0 + 24.0, at.1), &curve.name, 13, Anchor::Start, INK);
    }
    let label = (!entry.x.is_empty()).then_some(entry.x.as_str()).or(Some(""));
    panel.axes(&mut figure, label, &entry.y);
    figure.svg()
}

/// Behind the last colour they begin anew, darker in each round.
fn ink(n: usize, curve: &Curve) -> Rgb {
    if curve.published {
        return GREY;
    }
    let share = 0.55_f64.powi((n / LINES.len()) as i32);
    LINES[n % LINES.len()].map(|part| (f64::from(part) * share).round() as u8)
}

fn marks(figure: &mut Figure, panel: &Panel, x: &[f64], y: &[f64], ink: Rgb) {
    let points: Vec<(f64, f64)> = x.iter().zip(y).map(|(&x, &y)| panel.at(x, y)).collect();
    figure.clipped(panel, |figure| {
        figure.curve(points.clone(), ink, 1.0);
        for (x, y) in points {
            figure.fill([x - MARK, y - MARK, 2.0 * MARK, 2.0 * MARK], ink);
        }
    });
}

/// From the least to the greatest, with some air, where the ends are not given.
fn range<'a>(
    values: impl Iterator<Item = &'a f64>,
    low: Option<f64>,
    high: Option<f64>,
    air: f64,
) -> (f64, f64) {
    let finite = values.copied().filter(|x| x.is_finite());
    let (least, greatest) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    let (least, greatest) = if least <= greatest { (least, greatest) } else { (0.0, 1.0) };
    let size = if greatest > least { greatest - least } else { greatest.abs().max(1e-3) };
    let wider = if greatest > least { air * size } else { 0.5 * size };
    let (a, b) = (low.unwrap_or(least - wider), high.unwrap_or(greatest + wider));
    if b > a { (a, b) } else { (a, a + size) }
}

/// Points of all curves.
pub fn csv(content: &Content) -> String {
    let mut text = line(["curve".to_string(), content.entry.x.clone(), content.entry.y.clone()].into_iter());
    for curve in &content.curves {
        for (x, y) in curve.x.iter().zip(&curve.y) {
            text += &line([curve.name.clone(), x.to_string(), y.to_string()].into_iter());
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_of_twelve_curves_look_alike() {
        let curve = Curve { name: String::new(), marked: false, published: false, x: vec![], y: vec![] };
        let inks: Vec<Rgb> = (0..12).map(|n| ink(n, &curve)).collect();
        for (n, one) in inks.iter().enumerate() {
            for other in &inks[..n] {
                let apart: i32 = one.iter().zip(other).map(|(a, b)| i32::from(a.abs_diff(*b))).sum();
                assert!(apart > 40, "{one:?} {other:?}");
            }
        }
    }
}
