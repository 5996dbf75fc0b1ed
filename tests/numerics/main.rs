//! Numbers that have to be the same everywhere.

mod chance;
mod portable_floats;
