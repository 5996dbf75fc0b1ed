//! Sheetlight: from a recipe to a labelled dataset of simulated laser-triangulation scans.
//!
//! In flow order:
//!
//! - [`recipe`]: YAML -> `Recipe`, `Recipe::draw(seed, index)` -> `Scene`
//! - [`specimen`]: `procedural::Body` -> `Specimen`, ready for rays
//! - [`optics`]: `Specimen` -> `Band` -> `Frame`, what the light does
//! - [`frame`]: the wall between what is there and what is measured
//! - [`extract`]: `Frame` + `Calibration` -> Range, Reflectance, Scatter
//! - [`labels`]: hits and truth -> classes, instances, objects
//! - [`pipeline`]: `Scene` -> `Record`, the spine
//! - [`record`]: everything about one sample that leaves the simulator
//! - [`shard`]: `Record` -> files
//! - [`validate`]: files -> faults
//!
//! Units: mm, mm^-1, rad, s, electrons, DN. Axes: x along the laser line, y along the scan, z up.

pub mod settings;
pub mod recipe;
pub mod specimen;
pub mod optics;
pub mod frame;
pub mod extract;
pub mod labels;
pub mod pipeline;
pub mod record;
