//! From tree to program: constants folded, flattened for a stack machine of fixed size.

use super::ExpressionError;
use super::derivative::Slope;
use super::table::Table;
use super::tree::{Binary, Tree, Unary, Variable};
use std::ops::Range;
use std::sync::Arc;

/// Numbers the stack machine holds.
const STACK: usize = 32;

/// `then` unless the condition is 0; NaN if the condition is.
#[inline]
fn select(condition: f64, then: f64, otherwise: f64) -> f64 {
    match condition {
        _ if condition.is_nan() => condition,
        0.0 => otherwise,
        _ => then,
    }
}

/// One instruction of the stack machine.
#[derive(Copy, Clone, Debug, PartialEq)]
enum Instruction {
    Push(f64),
    Load(Variable),
    Unary(Unary),
    Binary(Binary),
    /// a², which parabolas are made of.
    Square,
    /// Pops else, then, condition.
    Select,
    /// The table number i.
    Table(usize),
}

/// A table in an expression.
#[derive(Clone, Debug)]
pub(super) struct Call {
    pub table: Arc<Table>,
    /// Bytes of the source with the name of the file and its quotes.
    pub name: Range<usize>,
    /// The text of the argument.
    pub argument: String,
}

/// Whether they have the same values.
impl PartialEq for Call {
    fn eq(&self, other: &Self) -> bool {
        self.table == other.table
    }
}

/// Instructions in postfix order; at most [`STACK`] numbers are alive at once.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Program {
    code: Vec<Instruction>,
    pub(super) calls: Vec<Call>,
}

impl Program {
    /// No instructions, which leave 0.
    pub(super) const EMPTY: Program = Program { code: Vec::new(), calls: Vec::new() };

    pub(super) fn constant(value: f64) -> Self {
        Self { code: vec![Instruction::Push(value)], calls: vec![] }
    }

    /// The program of `tree` with the tables `calls`.
    pub(super) fn compile(tree: &Tree, calls: Vec<Call>) -> Result<Self, ExpressionError> {
        let mut code = Vec::new();
        let depth = emit(tree, &calls, &mut code);
        if depth > STACK {
            return Err(ExpressionError {
                position: 0,
                message: format!("needs more than {STACK} numbers at once"),
            });
        }
        Ok(Self { code, calls })
    }

    pub(super) fn as_constant(&self) -> Option<f64> {
        match *self.code {
            [Instruction::Push(value)] => Some(value),
            _ => None,
        }
    }

    pub(super) fn depends_on_time(&self) -> bool {
        self.code.contains(&Instruction::Load(Variable::T))
    }

    pub(super) fn depends_on_space(&self) -> bool {
        [Variable::X, Variable::Y, Variable::Z].iter().any(|v| self.code.contains(&Instruction::Load(*v)))
    }

    pub(super) fn depends_across(&self) -> bool {
        [Variable::X, Variable::Y].iter().any(|v| self.code.contains(&Instruction::Load(*v)))
    }

    pub(super) fn depends_on_depth(&self) -> bool {
        self.code.contains(&Instruction::Load(Variable::Z))
    }

    /// The value at the point `x` and time `t`.
    #[inline]
    pub(super) fn run(&self, x: &[f64; 3], t: f64) -> f64 {
        self.run_noting(x, t, |_, _| {})
    }

    /// The first table whose range is left at the point `x` and time `t`, with the argument there.
    pub(super) fn gap(&self, x: &[f64; 3], t: f64) -> Option<(&Call, f64)> {
        let mut found = None;
        self.run_noting(x, t, |call, argument| {
            if found.is_none() && call.table.value(argument).is_nan() {
                found = Some((call, argument));
            }
        });
        found
    }

    /// The value; `note` is told of every table and its argument.
    #[inline]
    fn run_noting<'p>(&'p self, x: &[f64; 3], t: f64, mut note: impl FnMut(&'p Call, f64)) -> f64 {
        if let [Instruction::Push(value)] = *self.code {
            return value;
        }
        let mut stack = [0.0; STACK];
        // Numbers alive; `compile` keeps it within 1..=STACK after every instruction.
        let mut n = 0;
        for instruction in &self.code {
            match *instruction {
                Instruction::Push(value) => {
                    stack[n] = value;
                    n += 1;
                }
                Instruction::Load(variable) => {
                    stack[n] = match variable {
                        Variable::X => x[0],
                        Variable::Y => x[1],
                        Variable::Z => x[2],
                        Variable::T => t,
                    };
                    n += 1;
                }
                Instruction::Unary(f) => stack[n - 1] = f.apply(stack[n - 1]),
                Instruction::Square => stack[n - 1] *= stack[n - 1],
                Instruction::Binary(f) => {
                    n -= 1;
                    stack[n - 1] = f.apply(stack[n - 1], stack[n]);
                }
                Instruction::Select => {
                    n -= 2;
                    stack[n - 1] = select(stack[n - 1], stack[n], stack[n + 1]);
                }
                Instruction::Table(i) => {
                    note(&self.calls[i], stack[n - 1]);
                    stack[n - 1] = self.calls[i].table.value(stack[n - 1]);
                }
            }
        }
        stack[0]
    }

    /// The same with partial derivatives with respect to x, y, z.
    pub(super) fn run_with_slope(&self, x: &[f64; 3], t: f64) -> Slope {
        let [a, b, c] = std::array::from_fn(|d| Slope::coordinate(x[d], d));
        self.run_seeded([a, b, c, Slope::constant(t)])
    }

    /// The same with the derivative with respect to t in place of the first.
    pub(super) fn run_with_rate(&self, x: &[f64; 3], t: f64) -> Slope {
        let [a, b, c] = x.map(Slope::constant);
        self.run_seeded([a, b, c, Slope::coordinate(t, 0)])
    }

    /// The value with the derivatives that x, y, z, t bring along.
    fn run_seeded(&self, [x, y, z, t]: [Slope; 4]) -> Slope {
        let mut stack = [Slope::constant(0.0); STACK];
        let mut n = 0;
        for instruction in &self.code {
            match *instruction {
                Instruction::Push(value) => {
                    stack[n] = Slope::constant(value);
                    n += 1;
                }
                Instruction::Load(variable) => {
                    stack[n] = match variable {
                        Variable::X => x,
                        Variable::Y => y,
                        Variable::Z => z,
                        Variable::T => t,
                    };
                    n += 1;
                }
                Instruction::Unary(f) => stack[n - 1] = Slope::unary(f, stack[n - 1]),
                Instruction::Square => {
                    stack[n - 1] = Slope::binary(Binary::Mul, stack[n - 1], stack[n - 1]);
                }
                Instruction::Binary(f) => {
                    n -= 1;
                    stack[n - 1] = Slope::binary(f, stack[n - 1], stack[n]);
                }
                Instruction::Select => {
                    n -= 2;
                    stack[n - 1] = match stack[n - 1].value {
                        condition if condition.is_nan() => Slope::constant(condition),
                        0.0 => stack[n + 1],
                        _ => stack[n],
                    };
                }
                Instruction::Table(i) => {
                    let (table, at) = (&self.calls[i].table, stack[n - 1]);
                    stack[n - 1] = Slope::of(table.value(at.value), table.slope(at.value), at);
                }
            }
        }
        stack[0]
    }
}

/// Appends the instructions of `tree`; returns how many numbers they need at once.
fn emit(tree: &Tree, calls: &[Call], code: &mut Vec<Instruction>) -> usize {
    let start = code.len();
    match tree {
        Tree::Constant(value) => {
            code.push(Instruction::Push(*value));
            1
        }
        Tree::Variable(variable) => {
            code.push(Instruction::Load(*variable));
            1
        }
        Tree::Unary(f, a) => {
            let depth = emit(a, calls, code);
            if let [Instruction::Push(value)] = code[start..] {
                code[start] = Instruction::Push(f.apply(value));
            } else if *f != Unary::Plus {
                code.push(Instruction::Unary(*f));
            }
            depth
        }
        Tree::Table(i, a) => emit_table(*i, a, calls, code),
        Tree::Binary(f, a, b) => {
            let first = emit(a, calls, code);
            let middle = code.len();
            let second = emit(b, calls, code);
            let (left, right) = (&code[start..middle], &code[middle..]);
            if let ([Instruction::Push(a)], [Instruction::Push(b)]) = (left, right) {
                let value = f.apply(*a, *b);
                code.truncate(start);
                code.push(Instruction::Push(value));
            } else if *f == Binary::Pow && *right == [Instruction::Push(2.0)] {
                code.truncate(middle);
                code.push(Instruction::Square);
            } else {
                code.push(Instruction::Binary(*f));
            }
            first.max(1 + second)
        }
        Tree::If(condition, a, b) => {
            let first = emit(condition, calls, code);
            // The other branch of a constant condition is never looked at: nested ones would take 2^depth times.
            if let [Instruction::Push(value)] = code[start..] {
                code.truncate(start);
                if value.is_nan() {
                    code.push(Instruction::Push(value));
                    return 1;
                }
                return emit(if value != 0.0 { a } else { b }, calls, code);
            }
            let second = emit(a, calls, code);
            let third = emit(b, calls, code);
            code.push(Instruction::Select);
            first.max(1 + second).max(2 + third)
        }
    }
}

/// The same of the table number `i` at the argument `a`.
fn emit_table(i: usize, a: &Tree, calls: &[Call], code: &mut Vec<Instruction>) -> usize {
    let start = code.len();
    let depth = emit(a, calls, code);
    // Beyond the ends there is no value: that is told where it is needed.
    match code[start..] {
        [Instruction::Push(argument)] if !calls[i].table.value(argument).is_nan() => {
            code[start] = Instruction::Push(calls[i].table.value(argument));
        }
        _ => code.push(Instruction::Table(i)),
    }
    depth
}
