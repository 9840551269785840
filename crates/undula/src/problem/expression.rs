//! Expressions of x, y, t in a case file.

/// A compiled expression. Placeholder.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    source: String,
}
