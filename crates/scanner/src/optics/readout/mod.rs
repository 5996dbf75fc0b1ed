//! Readout: from electrons to digital numbers.
//!
//! Takes the electrons of windows ([`crate::optics::window::Window`]); gives frames. [`Digitiser`] goes through
//! speckle, the pixels' own response, slopes, blooming and noise by a [`SignalChain`]; [`ThesisScripts`] stand in its
//! place where a recipe asks for them.
//!
//! An effect is off by default, or as small as on a real rig, and free when off. Its number stands in [`SignalChain`],
//! and [`Digitiser`] applies it. An effect that `is_plain` does not know does nothing. Where a pixel tells of others,
//! `rows_are_alone` must know it, and where a pixel reads more than its own light, `greatest_level`: otherwise rows are
//! left out in which it would show. What differs from pixel to pixel or by columns stands in `fixed_pattern.rs`. Rows
//! outside windows are made in `full_frame.rs`.

mod blooming;
mod digitise;
mod fixed_pattern;
mod postprocess;
mod signal_chain;

pub(crate) use self::digitise::{Digitiser, TileExposure};
pub use self::postprocess::FrameLight;
pub(crate) use self::postprocess::ThesisScripts;
pub(crate) use self::signal_chain::SignalChain;
