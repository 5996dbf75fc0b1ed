//! Damage of every kind to datasets that the program made: each is reported as that fault, and a clean dataset has
//! none.

mod bodies;
mod clean;
mod clean_sweep;
mod content;
mod copies;
mod documents;
mod files;
mod flips;
mod forgeries;
mod frames;
mod place;
mod review;
mod tags;
mod truth;
mod useless;
