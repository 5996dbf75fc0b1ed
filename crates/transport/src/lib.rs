//! Light transport inside matter: where light that enters a body leaves it again, and in which directions.
//!
//! Three models answer the same question about plane layers and are asked by name ([`model`]), from the slowest and
//! truest to the fastest:
//!
//! - [`path`]: Monte Carlo of the transport equation, the reference
//! - [`diffusion`]: a tensor of diffusion, in layers or on voxels
//! - [`kernel`]: Gaussians over path length, what datasets are rendered with
//!
//! A fourth, [`thesis`], is light that spreads in a picture, the method of the thesis, kept to compare with. It knows no
//! layers and answers lines of light on a body and points in a plane alone.
//!
//! [`stack`] is the matter in plane layers and [`answer`] what is said of it; [`line`] is a line of light on a body.
//! docs/physics.md has the equations, their sources and where each model fails.
//!
//! Production needs [`stack`], [`answer`], [`phase`], [`fresnel`], [`line`] and [`kernel`], which use neither [`path`],
//! [`diffusion`], [`thesis`] nor [`model`]; those may use them. Tables of the kernel are laid out by the kernel and measured
//! by [`path::measure`].

pub mod answer;
pub mod fresnel;
pub mod kernel;
pub mod line;
pub mod phase;
pub mod stack;
