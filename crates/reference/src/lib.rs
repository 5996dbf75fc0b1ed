//! The models that judge: Monte Carlo of the transport equation, diffusion on voxels, the method of the thesis.

pub mod diffusion;
pub mod model;
pub mod path;
pub mod thesis;
