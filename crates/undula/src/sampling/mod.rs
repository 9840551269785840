//! Fields at points of cells and facets, one by one in `f64`: for functionals, errors, sources and terms on the boundary.

pub mod facets;
pub mod points;

pub use facets::{FacetPoint, fabric_at, facet_points, facet_points_of, facet_points_on, fields_at};
pub use points::{PointValues, for_each_point, for_each_point_of};
