//! Numbers that have to be the same everywhere.

mod exact_tests;
mod portable_floats;
