//! Far couplings and scalar unknowns, which no matrix contains.
//!
//! ```text
//!     [ A   a ] [ δ ]   [ r  ]
//!     [ bᵀ  c ] [ δλ] = [ r_λ]
//! ```
//! A border with a scalar unknown λ has its equation g(U, λ) = 0: a = ∂R/∂λ, b = ∂g/∂U, c = ∂g/∂λ. A coupling of rank one,
//! A + a bᵀ, is a border whose unknown λ = bᵀδ is nobody's: c = −1, r_λ = 0. Neither fills the pattern of A.

/// One border.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Border {
    /// Its scalar unknown, numbered over all terms; `None`: a coupling of rank one.
    pub scalar: Option<usize>,
    /// a: places in `[v, u, p]` with values.
    pub column: Vec<(u32, f64)>,
    /// b: the same.
    pub row: Vec<(u32, f64)>,
    /// c.
    pub corner: f64,
}

impl Border {
    /// bᵀ x.
    pub fn product(&self, x: &[f64]) -> f64 {
        self.row.iter().map(|&(place, b)| b * x[place as usize]).sum()
    }

    /// y ← y + f a.
    pub fn add_column(&self, f: f64, y: &mut [f64]) {
        self.column.iter().for_each(|&(place, a)| y[place as usize] += f * a);
    }
}

/// The borders of a system, whose memory is used again.
#[derive(Clone, Debug, Default)]
pub struct Borders {
    list: Vec<Border>,
    used: usize,
}

impl Borders {
    /// Forget all.
    pub fn clear(&mut self) {
        self.used = 0;
    }

    /// An empty border with the equation of the unknown `scalar` and its derivative `corner`.
    pub fn scalar(&mut self, scalar: usize, corner: f64) -> &mut Border {
        self.next(Some(scalar), corner)
    }

    /// An empty coupling of rank one.
    pub fn coupling(&mut self) -> &mut Border {
        self.next(None, -1.0)
    }

    fn next(&mut self, scalar: Option<usize>, corner: f64) -> &mut Border {
        if self.used == self.list.len() {
            self.list.push(Border::default());
        }
        self.used += 1;
        let border = &mut self.list[self.used - 1];
        border.column.clear();
        border.row.clear();
        (border.scalar, border.corner) = (scalar, corner);
        border
    }

    /// All of them.
    pub fn iter(&self) -> std::slice::Iter<'_, Border> {
        self.list[..self.used].iter()
    }

    /// Their number.
    pub fn len(&self) -> usize {
        self.used
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.used == 0
    }
}
