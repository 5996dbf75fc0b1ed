//! Elementary functions for loops over columns, nodes and weights of integrals, laws of numbers and exact tests of
//! them.

pub mod chance;
pub mod lanes;
pub mod quadrature;
