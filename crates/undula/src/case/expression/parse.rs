//! From text to tree: a tokenizer and a Pratt parser.

use super::functions::{FUNCTIONS, TABLE, apply, named};
use super::program::{Call, Program};
use super::rows::Files;
use super::table::Interpolation;
use super::tree::{Binary, Tree, Unary};
use super::{ExpressionError, Names, error};
use crate::case::error::did_you_mean;
use crate::case::literal::{number, number_length};
use crate::case::unit;
use std::sync::Arc;

/// Longest source, so that the depth of the tree is bounded.
const MAX_SOURCE: usize = 4096;
/// Deepest nesting of parentheses, signs and powers.
const MAX_DEPTH: usize = 64;

#[derive(Copy, Clone, Debug, PartialEq)]
enum Token<'a> {
    Number(f64),
    Name(&'a str),
    /// In quotes.
    Text(&'a str),
    Operator(&'static str),
    End,
}

const OPERATORS: &[&str] = &["<=", ">=", "<", ">", "+", "-", "*", "/", "^", "(", ")", ","];

/// What an expression is.
pub(super) struct Parsed {
    pub tree: Tree,
    /// The tables in it.
    pub calls: Vec<Call>,
    /// The source with numbers in place of those with a unit.
    pub written: String,
}

/// The tree of `source`; `names` are known besides those of every expression.
pub(super) fn parse(
    source: &str,
    names: Option<&dyn Names>,
    files: Files<'_>,
) -> Result<Parsed, ExpressionError> {
    if source.len() > MAX_SOURCE {
        return error(MAX_SOURCE, format!("longer than {MAX_SOURCE} bytes"));
    }
    let source = source.trim_end();
    let blanks = source.len() - source.trim_start().len();
    let (calls, written) = Default::default();
    let mut parser = Parser {
        source,
        names,
        files,
        position: blanks,
        token: Token::End,
        start: 0,
        depth: 0,
        calls,
        written,
        copied: blanks,
    };
    parser.advance()?;
    if parser.token == Token::End {
        return error(0, "empty expression".into());
    }
    let tree = parser.expression(0)?;
    match parser.token {
        Token::End => {
            parser.copy(parser.source.len());
            Ok(Parsed { tree, calls: parser.calls, written: parser.written })
        }
        Token::Operator(")") => error(parser.start, "`)` without `(`".into()),
        Token::Operator(",") => error(parser.start, "`,` outside of a function's arguments".into()),
        _ => error(parser.start, format!("expected an operator before `{}`", parser.shown())),
    }
}

struct Parser<'a> {
    source: &'a str,
    names: Option<&'a dyn Names>,
    files: Files<'a>,
    /// Byte after the current token.
    position: usize,
    token: Token<'a>,
    /// Byte where the current token starts.
    start: usize,
    depth: usize,
    calls: Vec<Call>,
    /// The source up to byte `copied`, with SI numbers.
    written: String,
    copied: usize,
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
            self.token = Token::Number(self.number(rest)?);
        } else if first == '"' || first == '\'' {
            let Some((text, _)) = rest[1..].split_once(first) else {
                return error(self.start, format!("`{first}` without a second one"));
            };
            self.position += text.len() + 2;
            self.token = Token::Text(text);
        } else if first.is_ascii_alphabetic() || first == '_' {
            let dots = self.names.is_some();
            let inner = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_' || (dots && *b == b'.');
            let length = rest.bytes().take_while(inner).count();
            let (name, behind) = (&rest[..length], rest[length..].trim_start());
            // `min(` and `h` are no units where they are functions and names of results.
            let is_unit = !dots && !behind.starts_with('(') && unit::is_unit(name);
            if matches!(self.token, Token::Number(_)) && is_unit {
                let message = "; a unit in a formula stands in brackets, as in `80 [mmHg]`";
                return error(self.start, format!("expected an operator before `{name}`{message}"));
            }
            self.position += length;
            self.token = Token::Name(name);
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

    /// The number at the start of `rest`, in SI units if a unit stands in brackets behind it.
    fn number(&mut self, rest: &str) -> Result<f64, ExpressionError> {
        let length = number_length(rest.as_bytes());
        let Ok(value) = rest[..length].parse::<f64>() else {
            return error(self.start, format!("`{}` is not a number", &rest[..length]));
        };
        self.position += length;
        let behind = rest[length..].trim_start();
        let Some(inner) = behind.strip_prefix('[') else { return Ok(value) };
        let bracket = self.start + rest.len() - behind.len();
        let Some((unit, _)) = inner.split_once(']') else {
            return error(bracket, "`[` without `]`".into());
        };
        let value = match unit::in_si(&rest[..length], unit.trim()) {
            Ok((value, _)) => value,
            Err(message) => return error(bracket + 1, message),
        };
        self.position = bracket + unit.len() + 2;
        self.copy(self.start);
        self.written += &number(value);
        self.copied = self.position;
        Ok(value)
    }

    /// Writes the source up to byte `end`.
    fn copy(&mut self, end: usize) {
        self.written += &self.source[self.copied..end];
        self.copied = end;
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
            Token::Text(_) => error(start, "a text stands only in `table(\"file.csv\", t)`".into()),
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
                    let argument = Program::compile(&self.expression(0)?, vec![])?;
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
        if name == TABLE && self.names.is_none() {
            return self.table();
        }
        let Some((_, function)) = FUNCTIONS.iter().find(|(n, _)| *n == name) else {
            let hint = did_you_mean(name, FUNCTIONS.iter().map(|(n, _)| *n).chain([TABLE]));
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

    /// `table("file.csv", argument)` or `table("file.csv", argument, "words")`; the current token is its `(`.
    fn table(&mut self) -> Result<Tree, ExpressionError> {
        const FORM: &str = "as in `table(\"file.csv\", t)` or `table(\"file.csv\", t, \"cubic periodic\")`";
        self.advance()?;
        let (Token::Text(file), at) = (self.token, self.start) else {
            return error(self.start, format!("expected the name of a file in quotes, {FORM}"));
        };
        self.copy(self.start);
        let begin = self.written.len();
        self.copy(self.position);
        let name = begin..self.written.len();
        self.advance()?;
        if self.token != Token::Operator(",") {
            return error(self.start, format!("expected `,` and the argument, {FORM}"));
        }
        let from = self.position;
        self.advance()?;
        let argument = self.expression(0)?;
        let text = self.source[from..self.start].trim().to_string();
        let mut how = Interpolation::default();
        if self.token == Token::Operator(",") {
            self.advance()?;
            let Token::Text(words) = self.token else {
                return error(self.start, format!("expected words in quotes, {FORM}"));
            };
            how = Interpolation::of(words).or_else(|message| error(self.start, message))?;
            self.advance()?;
        }
        self.expect(")", "to close `table(`")?;
        let table = self.files.table(file, how).or_else(|message| error(at, message))?;
        self.calls.push(Call { table: Arc::new(table), name, argument: text });
        Ok(Tree::Table(self.calls.len() - 1, Box::new(argument)))
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
