//! From numbers to matter: solid bodies as geometry, optical medium and truth.
//!
//! Nothing here knows a laser, a camera, a file format or a recipe. A body answers three questions: where its upper
//! surface is, what medium and which truth stand at a point, and which coarse hull casts its shadow.
//!
//! Units: mm, mm^-1, rad. Axes: x along the laser line, y along the scan, z up; z = 0 is the conveyor.

pub mod arctangent;
pub mod blister;
pub mod body;
pub mod flat;
pub mod medium;
pub mod mesh;
pub mod noise;
pub mod normal;
pub mod parameter;
pub mod solid;
pub mod stream;
pub mod strips;
pub mod truth;
pub mod wood;

pub use arctangent::atan2;
pub use body::Body;
pub use medium::{Film, Gloss, KERNEL_INDICES, KERNEL_LEAST_SHARE, Medium, WOOD_DISPERSION_DEG};
pub use mesh::Mesh;
pub(crate) use normal::lognormal;
pub use normal::normal;
pub use parameter::{Condition, Need, Parameter, Unmet};
pub use stream::Stream;
pub use truth::{Class, Instance, Matter, Surface};
