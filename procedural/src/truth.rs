//! The truth at a point and about whole things: classes, instances and their numbers.

use crate::Medium;

/// What a point really is; the discriminant is the value in label images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Class {
    /// Conveyor, or nothing.
    Background = 0,
    /// Wood without defect.
    Clear = 1,
    /// A knot that was alive where the saw met it.
    SoundKnot = 2,
    /// A knot that had died, its bark ring included.
    DeadKnot = 3,
    /// Decayed wood.
    Rot = 4,
}

impl Class {
    /// Every class in the order of its value.
    pub const ALL: [Self; 5] = [Self::Background, Self::Clear, Self::SoundKnot, Self::DeadKnot, Self::Rot];

    /// Name in files: lower case, underscores.
    pub fn name(self) -> &'static str {
        match self {
            Self::Background => "background",
            Self::Clear => "clear",
            Self::SoundKnot => "sound_knot",
            Self::DeadKnot => "dead_knot",
            Self::Rot => "rot",
        }
    }
}

/// Upper surface of a body above one (x, y).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Height [mm].
    pub z: f32,
    /// dz/dx [1].
    pub slope_x: f32,
    /// dz/dy [1].
    pub slope_y: f32,
}

/// Medium and truth at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Matter {
    /// What light meets.
    pub medium: Medium,
    /// What it is.
    pub class: Class,
    /// Which one it is: 0 for none, else the number of an [`Instance`].
    pub instance: u16,
}

/// The numbers behind one defect, whether or not any of it is visible. NaN where a number has no meaning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// Number in instance images, from 1.
    pub id: u16,
    /// Its class.
    pub class: Class,
    /// Centre at the upper surface, along the laser line [mm].
    pub x_mm: f64,
    /// Centre at the upper surface, along the scan [mm].
    pub y_mm: f64,
    /// Diameter across its axis at the upper surface [mm].
    pub diameter_mm: f64,
    /// Angle between its axis and the upper surface [deg].
    pub dive_deg: f64,
    /// Distance from the pith at which the branch died [mm].
    pub death_radius_mm: f64,
    /// Severity of decay, 0 to 1 [1].
    pub severity: f64,
}
