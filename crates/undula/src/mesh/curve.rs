//! Curves and surfaces that boundaries follow exactly, however often the mesh is refined.

/// A curve, or a surface in space, and the boundaries that lie on it.
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
    /// The points at distance `radius` from the line through `point` along `axis`.
    Cylinder {
        /// Boundaries all of whose facets lie on the surface.
        boundaries: Vec<String>,
        /// A point of its axis \[m\].
        point: [f64; D],
        /// Direction of its axis, of any length above 0.
        axis: [f64; D],
        /// Its radius \[m\].
        radius: f64,
    },
}

impl<const D: usize> Curve<D> {
    /// Boundaries all of whose facets lie on the curve.
    pub fn boundaries(&self) -> &[String] {
        match self {
            Curve::Sphere { boundaries, .. } | Curve::Cylinder { boundaries, .. } => boundaries,
        }
    }

    /// The point of the curve nearest to `x`; `x` itself where there are many.
    pub fn project(&self, x: [f64; D]) -> [f64; D] {
        let (centre, radius) = match self {
            Curve::Sphere { centre, radius, .. } => (*centre, radius),
            Curve::Cylinder { point, axis, radius, .. } => {
                let dot = |a: [f64; D], b: &[f64; D]| (0..D).map(|d| a[d] * b[d]).sum::<f64>();
                let along = dot(minus(x, *point), axis) / dot(*axis, axis);
                (std::array::from_fn(|d| point[d] + along * axis[d]), radius)
            }
        };
        let away = minus(x, centre);
        let length = away.iter().map(|a| a * a).sum::<f64>().sqrt();
        if length == 0.0 { x } else { std::array::from_fn(|d| centre[d] + away[d] * (radius / length)) }
    }
}

fn minus<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|d| a[d] - b[d])
}
