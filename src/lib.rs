//! Sheetlight: from a recipe to a labelled dataset of simulated laser-triangulation scans.
//!
//! This crate ties the others together: the command line, the making of datasets, previews. In flow order:
//!
//! - `recipe`: YAML -> `Recipe`, `Recipe::draw(seed, index)` -> `Scene`
//! - `procedural`: plain numbers -> `Body`: surface, medium and truth at a point
//! - `scanner`: `Body` -> `Specimen` -> `Band` -> `Frame`, what the light does; `Frame` + `Calibration` -> Range,
//!   Reflectance, Scatter
//! - `transport`: light inside matter, by the kernel that makes datasets
//! - `pipeline`: `Scene` -> `Record`, the spine
//! - `dataset`, `output_schema`: `Record` -> files -> rows; files -> findings
//! - `tools`: what is done with a dataset: check, export, compare, report
//! - `rig`: the rig of a recipe in the words of data sheets
//! - `evidence`: the models that the kernel is held to, studies, and the gap to real scans, behind one door
//! - `base`, `optical_bench`, `numerics`, `yaml`, `drawing`: what several of them stand on
//! - [`generate`]: a recipe and a number of samples -> a dataset folder
//! - [`preview`]: one sample -> a picture for a person
//! - [`tune`]: a page on which the keys of a recipe are turned
//! - [`cli`]: the command line
//! - [`api`]: what is promised to other programs
//!
//! Units: mm, mm^-1, rad, s, electrons, DN. Axes: x along the laser line, y along the scan, z up.

pub mod api;
pub mod cli;
pub mod generate;
pub mod preview;
pub mod tune;
