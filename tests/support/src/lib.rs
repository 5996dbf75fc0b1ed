//! What the tests of several themes and the benches share, compiled once.

pub mod disk;
pub mod pages;
pub mod program;
pub mod records;
pub mod target;
