//! Reference elements as data: after set-up an element is a table of numbers.

pub mod fluctuation;
pub mod hessian;
pub mod lagrange;
pub mod quadrature;
pub mod shape;
pub mod table;

pub use fluctuation::{Fine, Fluctuation};
pub use quadrature::Quadrature;
pub use shape::Shape;
pub use table::{BasisTable, LineTable};
