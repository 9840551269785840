//! From text to tree: a tokenizer and a Pratt parser.

use super::program::Program;
use super::tree::{Binary, Tree, Unary, Variable};
use super::{ExpressionError, Names};
use crate::case::error::did_you_mean;

/// Longest source, so that the depth of the tree is bounded.
const MAX_SOURCE: usize = 4096;
/// Deepest nesting of parentheses, signs and powers.
const MAX_DEPTH: usize = 64;

/// Functions by name with the number of arguments they take.
const FUNCTIONS: &[(&str, Function)] = &[
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

/// Names that stand for a number.
const NAMES: &[(&str, Tree)] = &[
    ("x", Tree::Variable(Variable::X)),
    ("y", Tree::Variable(Variable::Y)),
    ("z", Tree::Variable(Variable::Z)),
    ("t", Tree::Variable(Variable::T)),
    ("pi", Tree::Constant(std::f64::consts::PI)),
];

#[derive(Copy, Clone)]
enum Function {
    One(Unary),
    Two(Binary),
    /// Two or more, combined from the left.
    Many(Binary),
    If,
    Clamp,
}

#[derive(Copy, Clone, Debug, PartialEq)]
enum Token<'a> {
    Number(f64),
    Name(&'a str),
    Operator(&'static str),
    End,
}

const OPERATORS: &[&str] = &["<=", ">=", "<", ">", "+", "-", "*", "/", "^", "(", ")", ","];

/// The tree of `source`; `names` are known besides those of every expression.
pub(super) fn parse(source: &str, names: Option<&dyn Names>) -> Result<Tree, ExpressionError> {
    if source.len() > MAX_SOURCE {
        return error(MAX_SOURCE, format!("longer than {MAX_SOURCE} bytes"));
    }
    let mut parser = Parser { source, names, position: 0, token: Token::End, start: 0, depth: 0 };
    parser.advance()?;
    if parser.token == Token::End {
        return error(0, "empty expression".into());
    }
    let tree = parser.expression(0)?;
    match parser.token {
        Token::End => Ok(tree),
        Token::Operator(")") => error(parser.start, "`)` without `(`".into()),
        Token::Operator(",") => error(parser.start, "`,` outside of a function's arguments".into()),
        _ => error(parser.start, format!("expected an operator before `{}`", parser.shown())),
    }
}

fn error<T>(position: usize, message: String) -> Result<T, ExpressionError> {
    Err(ExpressionError { position, message })
}

struct Parser<'a> {
    source: &'a str,
    names: Option<&'a dyn Names>,
    /// Byte after the current token.
    position: usize,
    token: Token<'a>,
    /// Byte where the current token starts.
    start: usize,
    depth: usize,
}

impl<'a> Parser<'a> {
    /// The current token as written.
    fn shown(&self) -> &'a str {
        self.source[self.start..self.position].trim()
    }

    /// Reads the next token.
    fn advance(&mut self) -> Result<(), ExpressionError> {
        let bytes = self.source.as_bytes();
        while self.position < bytes.len() && bytes[self.position].is_ascii_whitespace() {
            self.position += 1;
        }
        self.start = self.position;
        let rest = &self.source[self.position..];
        let Some(first) = rest.chars().next() else {
            self.token = Token::End;
            return Ok(());
        };
        if first.is_ascii_digit() || first == '.' {
            let length = number_length(rest.as_bytes());
            let Ok(value) = rest[..length].parse::<f64>() else {
                return error(self.start, format!("`{}` is not a number", &rest[..length]));
            };
            self.position += length;
            self.token = Token::Number(value);
        } else if first.is_ascii_alphabetic() || first == '_' {
            let dots = self.names.is_some();
            let inner = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_' || (dots && *b == b'.');
            let length = rest.bytes().take_while(inner).count();
            self.position += length;
            self.token = Token::Name(&rest[..length]);
        } else if rest.starts_with("**") {
            return error(self.start, "unknown operator `**`; did you mean `^`?".into());
        } else if let Some(operator) = OPERATORS.iter().find(|o| rest.starts_with(**o)) {
            self.position += operator.len();
            self.token = Token::Operator(operator);
        } else {
            return error(self.start, format!("unexpected character `{first}`"));
        }
        Ok(())
    }

    fn expect(&mut self, operator: &'static str, after: &str) -> Result<(), ExpressionError> {
        if self.token == Token::Operator(operator) {
            self.advance()
        } else {
            error(self.start, format!("expected `{operator}` {after}"))
        }
    }

    /// An expression of operators that bind more strongly than `floor`.
    fn expression(&mut self, floor: u8) -> Result<Tree, ExpressionError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return error(self.start, format!("nested more than {MAX_DEPTH} deep"));
        }
        let mut left = self.operand()?;
        while let Some((operator, power)) = self.infix() {
            if power <= floor {
                break;
            }
            if power == COMPARISON && matches!(&left, Tree::Binary(b, ..) if b.is_comparison()) {
                return error(self.start, "comparisons cannot be chained".into());
            }
            self.advance()?;
            // `^` groups from the right, the others from the left.
            let right = self.expression(if operator == Binary::Pow { power - 1 } else { power })?;
            left = Tree::Binary(operator, Box::new(left), Box::new(right));
        }
        self.depth -= 1;
        Ok(left)
    }

    /// A number, a name, a call, a sign or a parenthesis.
    fn operand(&mut self) -> Result<Tree, ExpressionError> {
        let (token, start) = (self.token, self.start);
        match token {
            Token::Number(value) => {
                self.advance()?;
                Ok(Tree::Constant(value))
            }
            Token::Name(name) => {
                self.advance()?;
                if self.token == Token::Operator("(") {
                    self.call(name, start)
                } else {
                    self.named(name, start)
                }
            }
            Token::Operator("(") => {
                self.advance()?;
                let inner = self.expression(0)?;
                self.expect(")", "to close the parenthesis")?;
                // A parenthesised comparison may be compared again, so it is not left bare.
                Ok(match inner {
                    Tree::Binary(b, ..) if b.is_comparison() => Tree::Unary(Unary::Plus, Box::new(inner)),
                    other => other,
                })
            }
            Token::Operator(sign @ ("-" | "+")) => {
                self.advance()?;
                let inner = Box::new(self.expression(SIGN)?);
                Ok(Tree::Unary(if sign == "-" { Unary::Neg } else { Unary::Plus }, inner))
            }
            Token::Operator(other) => {
                error(start, format!("expected a number, a name or `(` before `{other}`"))
            }
            Token::End => error(start, "ends where a number, a name or `(` is expected".into()),
        }
    }

    /// The operator at the current token; with names of their own, expressions have `and` and `or`.
    fn infix(&self) -> Option<(Binary, u8)> {
        match self.token {
            Token::Operator(symbol) => infix(symbol),
            // Of 0 and 1.
            Token::Name("and") if self.names.is_some() => Some((Binary::Min, AND)),
            Token::Name("or") if self.names.is_some() => Some((Binary::Max, OR)),
            _ => None,
        }
    }

    fn named(&self, name: &str, start: usize) -> Result<Tree, ExpressionError> {
        match self.names.and_then(|names| names.value(name)) {
            Some(Ok(value)) => Ok(Tree::Constant(value)),
            Some(Err(message)) => error(start, message),
            None => named(name, start),
        }
    }

    /// The arguments of a function of [`Names`]: names, then numbers.
    fn call_of_names(
        &mut self,
        names: &dyn Names,
        name: &str,
        start: usize,
    ) -> Result<Tree, ExpressionError> {
        let (mut of, mut numbers) = (vec![], vec![]);
        loop {
            self.advance()?;
            match self.token {
                Token::Name(signal) if numbers.is_empty() && names.is_signal(signal) => {
                    of.push(signal);
                    self.advance()?;
                }
                Token::Operator(")") => break,
                _ => {
                    let at = self.start;
                    let argument = Program::compile(&self.expression(0)?)?;
                    let Some(number) = argument.as_constant() else {
                        return error(at, "expected a number".into());
                    };
                    numbers.push(number);
                }
            }
            if self.token != Token::Operator(",") {
                break;
            }
        }
        self.expect(")", &format!("to close `{name}(`"))?;
        match names.call(name, &of, &numbers) {
            Ok(value) => Ok(Tree::Constant(value)),
            Err(message) => error(start, message),
        }
    }

    /// The arguments of the function `name`; the current token is its `(`.
    fn call(&mut self, name: &str, start: usize) -> Result<Tree, ExpressionError> {
        if let Some(names) = self.names.filter(|names| names.has_function(name)) {
            return self.call_of_names(names, name, start);
        }
        let Some((_, function)) = FUNCTIONS.iter().find(|(n, _)| *n == name) else {
            let hint = did_you_mean(name, FUNCTIONS.iter().map(|(n, _)| *n));
            return error(start, format!("unknown function `{name}`{hint}"));
        };
        self.advance()?;
        let mut arguments = Vec::new();
        if self.token != Token::Operator(")") {
            arguments.push(self.expression(0)?);
            while self.token == Token::Operator(",") {
                self.advance()?;
                arguments.push(self.expression(0)?);
            }
        }
        self.expect(")", &format!("to close `{name}(`"))?;
        apply(*function, name, arguments, start)
    }
}

const OR: u8 = 1;
const AND: u8 = 2;
const COMPARISON: u8 = 3;
const SIGN: u8 = 6;

/// The operator and its binding power.
fn infix(symbol: &str) -> Option<(Binary, u8)> {
    Some(match symbol {
        "<" => (Binary::Less, COMPARISON),
        "<=" => (Binary::LessEqual, COMPARISON),
        ">" => (Binary::Greater, COMPARISON),
        ">=" => (Binary::GreaterEqual, COMPARISON),
        "+" => (Binary::Add, 4),
        "-" => (Binary::Sub, 4),
        "*" => (Binary::Mul, 5),
        "/" => (Binary::Div, 5),
        "^" => (Binary::Pow, 7),
        _ => return None,
    })
}

/// Bytes of the number literal at the start of `bytes`.
fn number_length(bytes: &[u8]) -> usize {
    let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let mut length = digits(0);
    if bytes.get(length) == Some(&b'.') {
        length += 1;
        length += digits(length);
    }
    if matches!(bytes.get(length), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
        if bytes.get(length + 1 + sign).is_some_and(u8::is_ascii_digit) {
            length += 1 + sign;
            length += digits(length);
        }
    }
    length
}

fn named(name: &str, start: usize) -> Result<Tree, ExpressionError> {
    if let Some((_, tree)) = NAMES.iter().find(|(n, _)| *n == name) {
        return Ok(tree.clone());
    }
    if FUNCTIONS.iter().any(|(n, _)| *n == name) {
        return error(start, format!("expected `(` after the function `{name}`"));
    }
    let hint = did_you_mean(name, NAMES.iter().map(|(n, _)| *n));
    let hint = if hint.is_empty() { "; there are `x`, `y`, `z`, `t` and `pi`".into() } else { hint };
    error(start, format!("unknown name `{name}`{hint}"))
}

fn apply(
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
