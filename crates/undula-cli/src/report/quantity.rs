//! Fields by name: symbol, unit, components, and where they have values.

use serde_json::{Value, json};
use undula::output::{Field, FieldSnapshot};

/// A field as the player shows it.
pub struct Quantity {
    /// Name in the file.
    pub name: String,
    /// Its number among the fields at points.
    pub field: usize,
    /// Components of the field that are shown, with their symbols.
    pub components: Vec<(usize, String)>,
    /// Unit.
    pub unit: &'static str,
    /// Symbol of the size of a vector; empty for others.
    size: String,
    /// In words.
    label: String,
    /// `fluid` or `solid` if it has no values elsewhere, or `all`.
    body: &'static str,
    /// Whether its values have a sign that matters.
    signed: bool,
}

/// Names of the coordinates.
const NAMES: [&str; 3] = ["x", "y", "z"];

/// Symbol, unit and words of a field without its body; symbols of tensors have their components below.
const KNOWN: [(&str, &str, &str, &str, bool); 11] = [
    ("velocity", "v", "m/s", "velocity", true),
    ("deformation", "u", "m", "displacement", true),
    ("pressure", "p", "Pa", "pressure", true),
    ("stress", "σ", "Pa", "Cauchy stress", true),
    ("von-mises", "σ_M", "Pa", "equivalent stress", false),
    ("principal-stress", "σ", "Pa", "principal stress", true),
    ("strain", "E", "", "Green-Lagrange strain", true),
    ("jacobian", "J", "", "J", false),
    ("vorticity", "ω", "1/s", "vorticity", true),
    ("wall-shear-stress", "τ", "Pa", "wall shear stress", true),
    ("", "", "", "", true),
];

impl Quantity {
    /// All that `snapshot` has at its points.
    pub fn all(snapshot: &FieldSnapshot) -> Vec<Quantity> {
        let all_solid = snapshot.in_cells("solid").is_some_and(|field| field.values.iter().all(|&s| s > 0.5));
        let mut found: Vec<Quantity> = snapshot
            .point_data
            .iter()
            .enumerate()
            .map(|(n, field)| Quantity::new(n, field, snapshot.kind.dim()))
            .collect();
        if all_solid {
            // Of a body alone the displacement is seen first.
            found.sort_by_key(|quantity| quantity.name != "deformation");
        }
        found
    }

    fn new(number: usize, field: &Field, dim: usize) -> Quantity {
        let name = field.name.as_str();
        let parts = [("fluid-", "fluid"), ("solid-", "solid")];
        let of = parts.into_iter().find_map(|(start, body)| Some((name.strip_prefix(start)?, body)));
        let (plain, body) = match (of, name) {
            (Some(of), _) => of,
            (None, "pressure") => (name, "fluid"),
            _ => (name, "all"),
        };
        let known = KNOWN.iter().find(|known| known.0 == plain);
        let (symbol, unit, words, signed) = known.map_or((plain, "", plain, true), |k| (k.1, k.2, k.3, k.4));
        // Vectors of the plane are written with a third component, 0.
        let vector = field.components == 3 && plain != "principal-stress" && !plain.contains("strain");
        let components: Vec<(usize, String)> = match field.components {
            1 => vec![(0, symbol.to_string())],
            9 if dim == 2 => tensor(symbol, &[0, 1, 4, 8]),
            9 => tensor(symbol, &[0, 1, 2, 4, 5, 8]),
            _ if vector && !(dim == 2 && plain == "vorticity") => {
                (0..dim).map(|d| (d, format!("{symbol}_{}", NAMES[d]))).collect()
            }
            n => (0..n).map(|c| (c, format!("{symbol}_{}", c + 1))).collect(),
        };
        let label = if body != "all" && of.is_some() { format!("{words}, {body}") } else { words.into() };
        Quantity {
            name: field.name.clone(),
            field: number,
            components,
            unit,
            size: if vector { format!("|{symbol}|") } else { String::new() },
            label,
            body,
            signed,
        }
    }

    /// For the player.
    pub fn to_json(&self) -> Value {
        let symbols: Vec<&String> = self.components.iter().map(|(_, symbol)| symbol).collect();
        json!({
            "name": self.name, "label": self.label, "symbols": symbols, "size": self.size, "body": self.body,
            "signed": self.signed,
        })
    }
}

/// Components of a tensor in rows.
fn tensor(symbol: &str, which: &[usize]) -> Vec<(usize, String)> {
    which.iter().map(|&c| (c, format!("{symbol}_{}{}", NAMES[c / 3], NAMES[c % 3]))).collect()
}
