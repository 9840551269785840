//! Names and functions of all expressions.

use super::tree::{Binary, Tree, Unary, Variable};
use super::{ExpressionError, error};
use crate::case::error::did_you_mean;

/// Functions by name with the number of arguments they take.
pub(super) const FUNCTIONS: &[(&str, Function)] = &[
    ("sin", Function::One(Unary::Sin)),
    ("cos", Function::One(Unary::Cos)),
    ("tan", Function::One(Unary::Tan)),
    ("asin", Function::One(Unary::Asin)),
    ("acos", Function::One(Unary::Acos)),
    ("atan", Function::One(Unary::Atan)),
    ("sinh", Function::One(Unary::Sinh)),
    ("cosh", Function::One(Unary::Cosh)),
    ("tanh", Function::One(Unary::Tanh)),
    ("exp", Function::One(Unary::Exp)),
    ("ln", Function::One(Unary::Ln)),
    ("log10", Function::One(Unary::Log10)),
    ("sqrt", Function::One(Unary::Sqrt)),
    ("abs", Function::One(Unary::Abs)),
    ("sign", Function::One(Unary::Sign)),
    ("floor", Function::One(Unary::Floor)),
    ("ceil", Function::One(Unary::Ceil)),
    ("step", Function::One(Unary::Step)),
    ("atan2", Function::Two(Binary::Atan2)),
    ("min", Function::Many(Binary::Min)),
    ("max", Function::Many(Binary::Max)),
    ("pow", Function::Two(Binary::Pow)),
    ("hypot", Function::Two(Binary::Hypot)),
    ("ramp", Function::Two(Binary::Ramp)),
    ("if", Function::If),
    ("clamp", Function::Clamp),
];

/// The function of tables of values, whose first argument is a text.
pub(super) const TABLE: &str = "table";

/// Names that stand for a number.
const NAMES: &[(&str, Tree)] = &[
    ("x", Tree::Variable(Variable::X)),
    ("y", Tree::Variable(Variable::Y)),
    ("z", Tree::Variable(Variable::Z)),
    ("t", Tree::Variable(Variable::T)),
    ("pi", Tree::Constant(std::f64::consts::PI)),
];

#[derive(Copy, Clone)]
pub(super) enum Function {
    One(Unary),
    Two(Binary),
    /// Two or more, combined from the left.
    Many(Binary),
    If,
    Clamp,
}

/// Whether `name` is a name or a function of all expressions.
pub(crate) fn is_name(name: &str) -> bool {
    NAMES.iter().any(|(n, _)| *n == name) || name == TABLE || FUNCTIONS.iter().any(|(n, _)| *n == name)
}

/// What the name `name` at byte `start` stands for.
pub(super) fn named(name: &str, start: usize) -> Result<Tree, ExpressionError> {
    if let Some((_, tree)) = NAMES.iter().find(|(n, _)| *n == name) {
        return Ok(tree.clone());
    }
    if name == TABLE || FUNCTIONS.iter().any(|(n, _)| *n == name) {
        return error(start, format!("expected `(` after the function `{name}`"));
    }
    let hint = did_you_mean(name, NAMES.iter().map(|(n, _)| *n));
    let hint = if hint.is_empty() { "; there are `x`, `y`, `z`, `t` and `pi`".into() } else { hint };
    error(start, format!("unknown name `{name}`{hint}"))
}

/// The function with the name `name` at byte `start`, of `arguments`.
pub(super) fn apply(
    function: Function,
    name: &str,
    arguments: Vec<Tree>,
    start: usize,
) -> Result<Tree, ExpressionError> {
    let given = arguments.len();
    let mut arguments = arguments.into_iter();
    let mut next = || arguments.next().map(Box::new);
    let (tree, wanted) = match function {
        Function::One(f) => (next().map(|a| Tree::Unary(f, a)), "1 argument"),
        Function::Two(f) => (next().zip(next()).map(|(a, b)| Tree::Binary(f, a, b)), "2 arguments"),
        Function::Many(f) if given >= 2 => {
            let all = arguments.by_ref().reduce(|a, b| Tree::Binary(f, Box::new(a), Box::new(b)));
            (all, "2 or more arguments")
        }
        Function::Many(_) => (None, "2 or more arguments"),
        Function::If => (
            next().zip(next()).zip(next()).map(|((c, a), b)| Tree::If(c, a, b)),
            "3 arguments (condition, then, else)",
        ),
        Function::Clamp => {
            let tree = next().zip(next()).zip(next()).map(|((a, low), high)| {
                let raised = Tree::Binary(Binary::Max, a, low);
                Tree::Binary(Binary::Min, Box::new(raised), high)
            });
            (tree, "3 arguments (value, low, high)")
        }
    };
    match tree {
        Some(tree) if arguments.next().is_none() => Ok(tree),
        _ => error(start, format!("`{name}` takes {wanted}, not {given}")),
    }
}
