//! Light inside matter: where light that enters a body comes out again, and towards whom.
//!
//! Four models answer the same question, from the slowest and truest to the fastest:
//!
//! - [`path`]: Monte Carlo of the transport equation, the judge
//! - [`diffusion`]: a tensor of diffusion, in layers or on voxels
//! - [`kernel`]: Gaussians over path length, what datasets are rendered with
//! - [`thesis`]: light that spreads in a picture, the method of the thesis, kept to compare with
//!
//! [`stack`] is the matter that they are asked about in the plain case, [`answer`] what they say, [`model`] asks
//! whichever is wanted. docs/physics.md has
//! the equations, their sources and where each model fails.

pub mod answer;
pub mod diffusion;
pub mod fresnel;
pub mod kernel;
pub mod line;
pub mod model;
pub mod path;
pub mod phase;
pub mod stack;
pub mod thesis;
