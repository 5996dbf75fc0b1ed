//! From numbers to matter: solid bodies as geometry, optical medium and truth.
//!
//! Nothing here knows a laser, a camera, a file format or a recipe. A body answers three questions: where its upper
//! surface is, what medium and which truth stand at a point, and which coarse hull casts its shadow.
//!
//! Units: mm, mm^-1, rad. Axes: x along the laser line, y along the scan, z up; z = 0 is the conveyor.

pub mod blister;
pub mod flat;
pub mod noise;
pub mod solid;
pub mod strips;
pub mod wood;
