//! Factors of units, whose products with decimal numbers are rounded once.

/// A factor as a fraction of whole numbers with powers of 10 and π, so that nothing is rounded before the end.
#[derive(Clone, Debug, Default)]
pub(super) struct Factor {
    pub numerators: Vec<u64>,
    pub denominators: Vec<u64>,
    /// Power of 10.
    pub ten: i32,
    /// Power of π.
    pub pi: i32,
}

impl Factor {
    /// Multiplies with `other`.
    pub fn times(&mut self, other: Factor) {
        self.numerators.extend(other.numerators);
        self.denominators.extend(other.denominators);
        self.ten += other.ten;
        self.pi += other.pi;
    }

    /// 1 divided by this.
    pub fn inverted(self) -> Factor {
        Factor { numerators: self.denominators, denominators: self.numerators, ten: -self.ten, pi: -self.pi }
    }

    /// The number nearest to this times the decimal `digits`.
    pub fn of(&self, digits: &str) -> Result<f64, String> {
        let (mantissa, exponent) = digits.split_once(['e', 'E']).unwrap_or((digits, "0"));
        let (whole, part) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let mut ten = exponent.parse::<i64>().map_err(|_| format!("`{digits}` has too large an exponent"))?;
        ten += i64::from(self.ten) - part.len() as i64;
        let mut decimal: Vec<u8> = whole.bytes().chain(part.bytes()).map(|byte| byte - b'0').collect();
        for factor in &self.numerators {
            multiply(&mut decimal, *factor);
        }
        let divisor = self.denominators.iter().try_fold(1u64, |product, n| product.checked_mul(*n));
        let divisor = divisor.ok_or("the powers of the units are too large")?;
        if divisor > 1 {
            ten -= divide(&mut decimal, divisor);
        }
        let text: String = decimal.iter().map(|digit| char::from(b'0' + digit)).collect();
        let value: f64 =
            format!("{text}e{ten}").parse().map_err(|_| format!("`{digits}` is not a number"))?;
        Ok(if self.pi == 0 { value } else { value * std::f64::consts::PI.powi(self.pi) })
    }
}

/// `decimal`, digits with the largest first, times `factor`.
fn multiply(decimal: &mut Vec<u8>, factor: u64) {
    let mut carry = 0u128;
    for digit in decimal.iter_mut().rev() {
        carry += u128::from(*digit) * u128::from(factor);
        *digit = (carry % 10) as u8;
        carry /= 10;
    }
    while carry > 0 {
        decimal.insert(0, (carry % 10) as u8);
        carry /= 10;
    }
}

/// `decimal` divided by `divisor` with so many more digits that rounding the result is rounding the exact one: returns
/// how many.
fn divide(decimal: &mut Vec<u8>, divisor: u64) -> i64 {
    const MORE: usize = 45;
    decimal.resize(decimal.len() + MORE, 0);
    let mut rest = 0u128;
    for digit in decimal.iter_mut() {
        rest = rest * 10 + u128::from(*digit);
        *digit = (rest / u128::from(divisor)) as u8;
        rest %= u128::from(divisor);
    }
    // Whether anything is left says on which side of a tie the value lies.
    decimal.push(u8::from(rest > 0));
    MORE as i64 + 1
}
