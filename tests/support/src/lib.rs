//! What the tests of several themes and the benches share, compiled once.

pub mod bench;
pub mod pages;
pub mod program;
pub mod records;
