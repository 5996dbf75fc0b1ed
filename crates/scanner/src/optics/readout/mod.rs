//! Readout: from electrons to digital numbers.
//!
//! Takes the electrons of windows ([`crate::optics::window::Window`]); gives frames. [`Digitiser`] goes through
//! speckle, the pixels' own response, slopes, blooming and noise by a [`SignalChain`]; [`ThesisScripts`] stand in its
//! place where a recipe asks for them.

mod blooming;
mod digitise;
mod fixed_pattern;
mod postprocess;
mod signal_chain;

pub(crate) use self::digitise::{Digitiser, TileExposure};
pub use self::postprocess::FrameLight;
pub(crate) use self::postprocess::ThesisScripts;
pub(crate) use self::signal_chain::SignalChain;
