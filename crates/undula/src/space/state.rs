//! The solution at one time.

/// Coefficients of v, u and p, and scalar unknowns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Velocity, `[node][component]` \[m/s\].
    pub v: Vec<f64>,
    /// Deformation, `[node][component]` \[m\]; empty in a pure flow.
    pub u: Vec<f64>,
    /// Pressure \[Pa\]; it belongs to the time t⁻ + θ k of the step that made it.
    pub p: Vec<f64>,
    /// Scalar unknowns of terms; they belong to the time of the pressure.
    pub s: Vec<f64>,
}

impl State {
    /// Zero, with the given numbers of unknowns, none of them scalar.
    pub fn zero(n_v: usize, n_u: usize, n_p: usize) -> State {
        State { v: vec![0.0; n_v], u: vec![0.0; n_u], p: vec![0.0; n_p], s: vec![] }
    }

    /// Copy from `other` without allocating.
    pub fn copy_from(&mut self, other: &State) {
        self.v.copy_from_slice(&other.v);
        self.u.copy_from_slice(&other.u);
        self.p.copy_from_slice(&other.p);
        self.s.copy_from_slice(&other.s);
    }

    /// `self += a · x`, x in the order v, u, p, s.
    pub fn add_scaled(&mut self, a: f64, x: &[f64]) {
        let mut rest = x;
        for part in [&mut self.v, &mut self.u, &mut self.p, &mut self.s] {
            let (x, behind) = rest.split_at(part.len());
            part.iter_mut().zip(x).for_each(|(y, x)| *y += a * x);
            rest = behind;
        }
    }

    /// `self = b + s (b − a)`: linear extrapolation by the factor `s` past `b`, Remark 5.1.
    pub fn extrapolate(&mut self, a: &State, b: &State, s: f64) {
        let parts = [
            (&mut self.v, &a.v, &b.v),
            (&mut self.u, &a.u, &b.u),
            (&mut self.p, &a.p, &b.p),
            (&mut self.s, &a.s, &b.s),
        ];
        for (y, a, b) in parts {
            for ((y, a), b) in y.iter_mut().zip(a).zip(b) {
                *y = b + s * (b - a);
            }
        }
    }
}
