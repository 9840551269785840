//! Partial derivatives of expressions, along with the value.

use super::tree::{Binary, Unary};

/// A value with its partial derivatives with respect to x, y, z.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Slope {
    pub value: f64,
    pub partial: [f64; 3],
}

impl Slope {
    pub fn constant(value: f64) -> Slope {
        Slope { value, partial: [0.0; 3] }
    }

    /// The coordinate number `d`.
    pub fn coordinate(value: f64, d: usize) -> Slope {
        let mut slope = Slope::constant(value);
        slope.partial[d] = 1.0;
        slope
    }

    /// f(a) by the chain rule. Where f jumps or has a kink it is the derivative of one side.
    pub fn unary(f: Unary, a: Slope) -> Slope {
        let (x, value) = (a.value, f.apply(a.value));
        let derivative = match f {
            Unary::Plus => 1.0,
            Unary::Neg => -1.0,
            Unary::Sin => x.cos(),
            Unary::Cos => -x.sin(),
            Unary::Tan => 1.0 + value * value,
            Unary::Asin => 1.0 / (1.0 - x * x).sqrt(),
            Unary::Acos => -1.0 / (1.0 - x * x).sqrt(),
            Unary::Atan => 1.0 / (1.0 + x * x),
            Unary::Sinh => x.cosh(),
            Unary::Cosh => x.sinh(),
            Unary::Tanh => 1.0 - value * value,
            Unary::Exp => value,
            Unary::Ln => 1.0 / x,
            Unary::Log10 => 1.0 / (x * std::f64::consts::LN_10),
            Unary::Sqrt => 0.5 / value,
            Unary::Abs => Unary::Sign.apply(x),
            Unary::Sign | Unary::Floor | Unary::Ceil | Unary::Step => 0.0,
        };
        chain(value, [(derivative, a)])
    }

    /// f(a) by the chain rule, of a function with this value and this derivative at a.
    pub fn of(value: f64, derivative: f64, a: Slope) -> Slope {
        chain(value, [(derivative, a)])
    }

    /// f(a, b) by the chain rule.
    pub fn binary(f: Binary, a: Slope, b: Slope) -> Slope {
        let (x, y, value) = (a.value, b.value, f.apply(a.value, b.value));
        let derivatives = match f {
            Binary::Add => [1.0, 1.0],
            Binary::Sub => [1.0, -1.0],
            Binary::Mul => [y, x],
            Binary::Div => [1.0 / y, -value / y],
            // A constant exponent takes no logarithm of what may be negative.
            Binary::Pow => [y * x.powf(y - 1.0), if b.partial == [0.0; 3] { 0.0 } else { value * x.ln() }],
            Binary::Less | Binary::LessEqual | Binary::Greater | Binary::GreaterEqual => [0.0, 0.0],
            Binary::Atan2 => [y / (x * x + y * y), -x / (x * x + y * y)],
            Binary::Min => choose(x <= y),
            Binary::Max => choose(x >= y),
            Binary::Hypot => [x / value, y / value],
            Binary::Ramp => ramp(x, y),
        };
        chain(value, [(derivatives[0], a), (derivatives[1], b)])
    }
}

fn choose(first: bool) -> [f64; 2] {
    if first { [1.0, 0.0] } else { [0.0, 1.0] }
}

/// Of ½(1 − cos(πt/T)) with respect to t and T.
fn ramp(t: f64, duration: f64) -> [f64; 2] {
    if t < 0.0 || t >= duration {
        return [0.0, 0.0];
    }
    let pi = std::f64::consts::PI;
    let slope = 0.5 * pi / duration * (pi * t / duration).sin();
    [slope, -slope * t / duration]
}

/// What does not move takes no part: 0 times an infinite derivative is 0.
fn chain<const N: usize>(value: f64, parts: [(f64, Slope); N]) -> Slope {
    let partial = std::array::from_fn(|d| {
        parts.iter().filter(|(_, a)| a.partial[d] != 0.0).map(|(df, a)| df * a.partial[d]).sum()
    });
    Slope { value, partial }
}
