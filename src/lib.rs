//! Sheetlight: from a recipe to a labelled dataset of simulated laser-triangulation scans.
//!
//! In flow order:
//!
//! - [`yaml`]: files in YAML, and what is wrong with them
//! - [`asset`]: files that a recipe names
//! - [`chance`]: the law of a number, and exact tests of it
//! - [`mesh`]: OBJ, STL, PLY -> triangles
//! - [`recipe`]: YAML -> `Recipe`, `Recipe::draw(seed, index)` -> `Scene`
//! - [`specimen`]: `procedural::Body` -> `Specimen`, ready for rays
//! - [`transport`]: light inside matter
//! - [`medium`]: YAML -> plane layers and a question to the models of transport
//! - [`study`]: models of transport side by side, in tables and pictures
//! - [`optics`]: `Specimen` -> `Band` -> `Frame`, what the light does
//! - [`frame`]: the wall between what is there and what is measured
//! - [`extract`]: `Frame` + `Calibration` -> Range, Reflectance, Scatter
//! - [`labels`]: hits and truth -> classes, instances, objects
//! - [`effective`]: a scene -> numbers that follow from its draws
//! - [`pipeline`]: `Scene` -> `Record`, the spine
//! - [`record`]: everything about one sample that leaves the simulator
//! - [`dataset`]: `Record` -> files of a dataset, and back
//! - [`generate`]: a recipe and a number of samples -> a dataset folder
//! - [`validate`]: files -> faults
//! - [`preview`]: one sample -> a picture for a person
//! - [`icon`]: scans as files of the real camera
//! - [`compare`]: simulated and real scans side by side
//! - [`check`]: what a trained model makes of a dataset
//! - [`export`]: a dataset in the layouts of other programs
//! - [`report`]: a dataset -> one HTML page for people
//! - [`drawing`]: words, scales and colours of pictures
//! - [`settings`]: what a recipe fixes for all samples
//! - [`parameters`]: the numbers of the bench: scan, laser, camera, exposure, noise, speckle
//! - [`lens`]: image distance, Scheimpflug's condition, distortion
//! - [`split`]: training, validation, test
//! - [`lanes`]: elementary functions for loops over columns
//! - `quadrature`: nodes and weights of integrals
//! - [`cli`]: the command line
//!
//! Units: mm, mm^-1, rad, s, electrons, DN. Axes: x along the laser line, y along the scan, z up.

pub mod asset;
pub mod chance;
pub mod check;
pub mod cli;
pub mod compare;
pub mod dataset;
pub mod drawing;
pub mod effective;
pub mod export;
pub mod extract;
pub mod frame;
pub mod generate;
pub mod icon;
pub mod labels;
pub mod lanes;
pub mod lens;
pub mod medium;
pub mod mesh;
pub mod optics;
pub mod parameters;
pub mod pipeline;
pub mod preview;
mod quadrature;
pub mod recipe;
pub mod record;
pub mod report;
pub mod settings;
pub mod specimen;
pub mod split;
pub mod study;
pub mod transport;
pub mod validate;
pub mod yaml;
