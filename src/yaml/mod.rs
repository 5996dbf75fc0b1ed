//! Files in YAML, read strictly: a tree in which every value knows its place, a walk that takes keys and values from it,
//! and faults, each with line, key and remedy. Nothing here knows what a file means.

pub mod fault;
pub(crate) mod node;
pub(crate) mod text;
pub(crate) mod walk;
