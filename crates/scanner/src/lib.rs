//! The instrument: a body under laser and camera, the light it sends back, the frames, and how lines are read from
//! them.

pub mod extract;
pub mod frame;
pub mod optics;
pub mod specimen;
