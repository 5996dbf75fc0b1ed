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

/// Why diffusion has no answer; layers count from 0 at the top.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DiffusionError {
    /// A gap, or matter that hardly scatters.
    #[error(
        "layer {layer} does not scatter: light crosses it in straight lines, which diffusion cannot say; use the path \
         model"
    )]
    Clear {
        /// Its number.
        layer: usize,
    },
    /// Cylinders with nothing between them.
    #[error(
        "layer {layer} has cylinders without background: light runs along them without end; give it a sigma_i above \
            0, or \
         use the path model"
    )]
    Guided {
        /// Its number.
        layer: usize,
    },
    /// Metal at the bottom.
    #[error("the stack lies on foil, which diffusion knows nothing of; use the path model")]
    Foil,
    /// A coat on a layer.
    #[error("layer {layer} has a coat, which diffusion knows nothing of; use the path model")]
    Coat {
        /// Its number.
        layer: usize,
    },
    /// A stack of nothing.
    #[error("the stack has no layer; give it one")]
    Empty,
    /// Light that does not go down.
    #[error("light at {degrees} degrees does not meet the surface; ask for less than 90 degrees")]
    Grazing {
        /// Angle of incidence [deg].
        degrees: f64,
    },
}

#[cfg(test)]
mod tests;
