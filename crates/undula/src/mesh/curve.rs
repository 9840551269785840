//! Curves that boundaries follow exactly, however often the mesh is refined.

/// A curve and the boundaries that lie on it.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve<const D: usize> {
    /// `|x − centre| = radius`: a circle, or a sphere in space.
    Sphere {
        /// Boundaries all of whose facets lie on the curve.
        boundaries: Vec<String>,
        /// Its centre \[m\].
        centre: [f64; D],
        /// Its radius \[m\].
        radius: f64,
    },
}

impl<const D: usize> Curve<D> {
    /// Boundaries all of whose facets lie on the curve.
    pub fn boundaries(&self) -> &[String] {
        let Curve::Sphere { boundaries, .. } = self;
        boundaries
    }

    /// The point of the curve nearest to `x`; `x` itself where there are many.
    pub fn project(&self, x: [f64; D]) -> [f64; D] {
        let Curve::Sphere { centre, radius, .. } = self;
        let away: [f64; D] = std::array::from_fn(|d| x[d] - centre[d]);
        let length = away.iter().map(|a| a * a).sum::<f64>().sqrt();
        if length == 0.0 { x } else { std::array::from_fn(|d| centre[d] + away[d] * (radius / length)) }
    }
}
