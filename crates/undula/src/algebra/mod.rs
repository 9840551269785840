//! Sparse matrices and linear solvers; nothing here knows finite elements.
