//! The solution at one time.

/// Coefficients of v, u and p.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Velocity, `[node][component]` \[m/s\].
    pub v: Vec<f64>,
    /// Deformation, `[node][component]` \[m\]; empty in a pure flow.
    pub u: Vec<f64>,
    /// Pressure \[Pa\]; it belongs to the time t⁻ + θ k of the step that made it.
    pub p: Vec<f64>,
}

impl State {
    /// Zero, with the given numbers of unknowns.
    pub fn zero(n_v: usize, n_u: usize, n_p: usize) -> State {
        State { v: vec![0.0; n_v], u: vec![0.0; n_u], p: vec![0.0; n_p] }
    }

    /// Copy from `other` without allocating.
    pub fn copy_from(&mut self, other: &State) {
        self.v.copy_from_slice(&other.v);
        self.u.copy_from_slice(&other.u);
        self.p.copy_from_slice(&other.p);
    }

    /// `self += a · x`, x in the order v, u, p.
    pub fn add_scaled(&mut self, a: f64, x: &[f64]) {
        let (nv, nu) = (self.v.len(), self.u.len());
        let parts = [(&mut self.v, &x[..nv]), (&mut self.u, &x[nv..nv + nu]), (&mut self.p, &x[nv + nu..])];
        for (part, x) in parts {
            for (y, x) in part.iter_mut().zip(x) {
                *y += a * x;
            }
        }
    }

    /// `self = b + s (b − a)`: linear extrapolation by the factor `s` past `b`, Remark 5.1.
    pub fn extrapolate(&mut self, a: &State, b: &State, s: f64) {
        let parts = [(&mut self.v, &a.v, &b.v), (&mut self.u, &a.u, &b.u), (&mut self.p, &a.p, &b.p)];
        for (y, a, b) in parts {
            for ((y, a), b) in y.iter_mut().zip(a).zip(b) {
                *y = b + s * (b - a);
            }
        }
    }
}
