//! What the tests of several themes and the benches share, compiled once. Features say what writes datasets or renders.

pub mod disk;
pub mod pages;
pub mod program;
#[cfg(feature = "records")]
pub mod records;
#[cfg(feature = "target")]
pub mod target;
