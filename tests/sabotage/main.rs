//! Damage of every kind to datasets that the program made: each is reported as that fault, and a clean dataset has none.

#[path = "../gen_support/mod.rs"]
mod gen_support;

#[path = "../validate_support/damage.rs"]
mod damage;

mod bodies;
mod clean;
mod content;
mod copies;
mod documents;
mod files;
mod flips;
mod place;
mod review;
