//! Elementary functions for loops over columns, nodes and weights of integrals, laws of numbers.

pub mod chance;
pub mod lanes;
pub mod quadrature;
