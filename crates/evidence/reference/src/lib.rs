//! The models that the kernel is held to: Monte Carlo of the transport equation, diffusion on voxels, the method of the
//! thesis.
//!
//! - [`model`]: each of them asked about plane layers; [`medium`] is such a question as YAML, [`media`] are fifteen of
//!   wood
//! - [`line_solver`]: each of them asked about a line on a body, as `transport:` of a recipe names it

mod columns;
pub mod diffusion;
mod line_solver;
pub mod media;
pub mod medium;
pub mod model;
pub mod path;
pub mod phase;
pub mod thesis;

pub use self::line_solver::line_solver;
