//! Light inside matter by diffusion: what is left of the transport equation when light has lost its direction.
//!
//! Steady, with a full tensor of diffusion D and the fluence Phi:
//!
//! ```text
//! -div(D grad Phi) + mu_a Phi = S
//! ```
//!
//! - [`tensor`], `generalized`: D, source place and boundary of a medium
//! - [`slab`]: plane layers, in closed form for each wave in the plane; `spread` brings the waves together
//! - [`voxels`], [`solver`], [`line_response`](mod@line_response): a laser line on a body, by finite volumes and
//!   conjugate gradients
//!
//! Valid some mean free paths from the source, where absorption is small against reduced scattering; the file of each
//! part says what it leaves out. Its reference is Monte Carlo.

pub(crate) mod generalized;
pub mod line_response;
mod operator;
pub mod slab;
pub mod solver;
mod spread;
pub mod tensor;
mod transmission_line;
pub mod voxels;

pub use self::line_response::{DiffusionSettings, line_response};
pub use self::slab::solve;

#[cfg(test)]
mod tests;
