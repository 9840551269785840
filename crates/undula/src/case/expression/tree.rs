//! A parsed expression, and the functions in it by their values.

/// A parsed expression.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Tree {
    Constant(f64),
    Variable(Variable),
    Unary(Unary, Box<Tree>),
    Binary(Binary, Box<Tree>, Box<Tree>),
    If(Box<Tree>, Box<Tree>, Box<Tree>),
    /// The table number i of the expression.
    Table(usize, Box<Tree>),
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
