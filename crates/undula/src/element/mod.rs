//! Reference elements as data: after set-up an element is a table of numbers.

pub mod shape;

pub use shape::Shape;
