//! What matter, light and datasets share: parameters, streams, media, classes, and what a body answers.
//!
//! Nothing here grows wood or forms packs: an edit there builds no instrument and no format of files again.
//!
//! Units: mm, mm^-1, rad. Axes: x along the laser line, y along the scan, z up; z = 0 is the conveyor.

pub mod arctangent;
pub mod body;
pub mod class;
pub mod medium;
pub mod mesh;
pub mod natural;
pub mod normal;
pub mod parameter;
pub mod stream;
pub mod truth;
pub mod words;

pub use arctangent::atan2;
pub use body::{BLOCK, Body, BodyKind, Relief, Slice};
pub use class::{Class, ClassKind};
pub use medium::{Film, Gloss, KERNEL_INDICES, KERNEL_LEAST_SHARE, Medium, TANGLED, WOOD_DISPERSION_DEG};
pub use mesh::Mesh;
pub use natural::Natural;
pub use normal::{lognormal, normal};
pub use parameter::{Condition, Need, Parameter, ParameterGroup, Unmet};
pub use stream::{Stream, mix};
pub use truth::{Instance, KnotNames, KnotPlace, Matter, Surface};
pub use words::Words;
