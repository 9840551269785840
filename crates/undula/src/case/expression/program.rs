//! From tree to program: constants folded, flattened for a stack machine of fixed size.

use super::ExpressionError;
use super::derivative::Slope;

/// Numbers the stack machine holds.
const STACK: usize = 32;

/// A parsed expression.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Tree {
    Constant(f64),
    Variable(Variable),
    Unary(Unary, Box<Tree>),
    Binary(Binary, Box<Tree>, Box<Tree>),
    If(Box<Tree>, Box<Tree>, Box<Tree>),
}

#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Variable {
    X,
    Y,
    Z,
    T,
}

#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Unary {
    Plus,
    Neg,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Ln,
    Log10,
    Sqrt,
    Abs,
    Sign,
    Floor,
    Ceil,
    Step,
}

#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Pow,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Atan2,
    Min,
    Max,
    Hypot,
    Ramp,
}

impl Unary {
    #[inline]
    pub(super) fn apply(self, a: f64) -> f64 {
        match self {
            Unary::Plus => a,
            Unary::Neg => -a,
            Unary::Sin => a.sin(),
            Unary::Cos => a.cos(),
            Unary::Tan => a.tan(),
            Unary::Asin => a.asin(),
            Unary::Acos => a.acos(),
            Unary::Atan => a.atan(),
            Unary::Sinh => a.sinh(),
            Unary::Cosh => a.cosh(),
            Unary::Tanh => a.tanh(),
            Unary::Exp => a.exp(),
            Unary::Ln => a.ln(),
            Unary::Log10 => a.log10(),
            Unary::Sqrt => a.sqrt(),
            Unary::Abs => a.abs(),
            Unary::Sign if a == 0.0 => 0.0,
            Unary::Sign => a.signum(),
            Unary::Floor => a.floor(),
            Unary::Ceil => a.ceil(),
            Unary::Step => of_numbers(a, a, truth(a >= 0.0)),
        }
    }
}

impl Binary {
    pub(super) fn is_comparison(self) -> bool {
        matches!(self, Binary::Less | Binary::LessEqual | Binary::Greater | Binary::GreaterEqual)
    }

    #[inline]
    pub(super) fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Binary::Add => a + b,
            Binary::Sub => a - b,
            Binary::Mul => a * b,
            Binary::Div => a / b,
            Binary::Pow => a.powf(b),
            Binary::Less => of_numbers(a, b, truth(a < b)),
            Binary::LessEqual => of_numbers(a, b, truth(a <= b)),
            Binary::Greater => of_numbers(a, b, truth(a > b)),
            Binary::GreaterEqual => of_numbers(a, b, truth(a >= b)),
            Binary::Atan2 => a.atan2(b),
            Binary::Min => of_numbers(a, b, a.min(b)),
            Binary::Max => of_numbers(a, b, a.max(b)),
            Binary::Hypot => a.hypot(b),
            Binary::Ramp => of_numbers(a, b, ramp(a, b)),
        }
    }
}

/// `value`, but NaN where an argument is: a mistake is not to be hidden by what does not look at it.
#[inline]
fn of_numbers(a: f64, b: f64, value: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { value }
}

fn truth(condition: bool) -> f64 {
    if condition { 1.0 } else { 0.0 }
}

/// `then` unless the condition is 0; NaN if the condition is.
#[inline]
fn select(condition: f64, then: f64, otherwise: f64) -> f64 {
    match condition {
        _ if condition.is_nan() => condition,
        0.0 => otherwise,
        _ => then,
    }
}

/// ½(1 − cos(πt/T)) on \[0, T\], continued by 0 and 1.
fn ramp(t: f64, duration: f64) -> f64 {
    if t < 0.0 {
        0.0
    } else if t < duration {
        0.5 * (1.0 - (std::f64::consts::PI * t / duration).cos())
    } else {
        1.0
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
}

/// Instructions in postfix order; at most [`STACK`] numbers are alive at once.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Program {
    code: Vec<Instruction>,
}

impl Program {
    /// No instructions, which leave 0.
    pub(super) const EMPTY: Program = Program { code: Vec::new() };

    pub(super) fn constant(value: f64) -> Self {
        Self { code: vec![Instruction::Push(value)] }
    }

    pub(super) fn compile(tree: &Tree) -> Result<Self, ExpressionError> {
        let mut code = Vec::new();
        let depth = emit(tree, &mut code);
        if depth > STACK {
            return Err(ExpressionError {
                position: 0,
                message: format!("needs more than {STACK} numbers at once"),
            });
        }
        Ok(Self { code })
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

    #[inline]
    pub(super) fn run(&self, x: &[f64; 3], t: f64) -> f64 {
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
            }
        }
        stack[0]
    }

    /// The same with partial derivatives.
    pub(super) fn run_with_slope(&self, x: &[f64; 3], t: f64) -> Slope {
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
                        Variable::X => Slope::coordinate(x[0], 0),
                        Variable::Y => Slope::coordinate(x[1], 1),
                        Variable::Z => Slope::coordinate(x[2], 2),
                        Variable::T => Slope::constant(t),
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
            }
        }
        stack[0]
    }
}

/// Appends the instructions of `tree`; returns how many numbers they need at once.
fn emit(tree: &Tree, code: &mut Vec<Instruction>) -> usize {
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
            let depth = emit(a, code);
            if let [Instruction::Push(value)] = code[start..] {
                code[start] = Instruction::Push(f.apply(value));
            } else if *f != Unary::Plus {
                code.push(Instruction::Unary(*f));
            }
            depth
        }
        Tree::Binary(f, a, b) => {
            let first = emit(a, code);
            let middle = code.len();
            let second = emit(b, code);
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
            let first = emit(condition, code);
            // The other branch of a constant condition is never looked at: nested ones would take 2^depth times.
            if let [Instruction::Push(value)] = code[start..] {
                code.truncate(start);
                if value.is_nan() {
                    code.push(Instruction::Push(value));
                    return 1;
                }
                return emit(if value != 0.0 { a } else { b }, code);
            }
            let second = emit(a, code);
            let third = emit(b, code);
            code.push(Instruction::Select);
            first.max(1 + second).max(2 + third)
        }
    }
}
