//! The bench: what a recipe fixes for all samples, and the parameters of laser, camera, exposure and movement.

pub mod lens;
pub mod parameters;
pub mod settings;
pub mod split;
