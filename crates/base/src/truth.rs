//! The truth at a point and about whole things: surfaces, matter, instances and their numbers.

use crate::{Class, Film, Medium};

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
    /// What that covers, where it is a film; `None` for matter without end.
    pub film: Option<Film>,
    /// What it is.
    pub class: Class,
    /// Which one it is: 0 for none, else the number of an [`Instance`].
    pub instance: u16,
}

/// Where a knot lies on the face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KnotPlace {
    /// Away from the arrises.
    Face,
    /// In the outer quarter of the width.
    Edge,
    /// Cut by the arris.
    Arris,
}

/// What a knot is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KnotNames {
    /// Where it lies.
    pub place: KnotPlace,
    /// Whether it is cut lengthwise.
    pub is_spike: bool,
    /// Whether it is small.
    pub is_pin: bool,
    /// Whether it is one of a cluster.
    pub is_clustered: bool,
    /// Whether its wood has cracked.
    pub is_cracked: bool,
}

impl KnotNames {
    /// The names with spaces between them: the place, then what else holds.
    pub fn text(&self) -> String {
        let place = match self.place {
            KnotPlace::Face => "face",
            KnotPlace::Edge => "edge",
            KnotPlace::Arris => "arris",
        };
        let others = [
            (self.is_spike, "spike"),
            (self.is_pin, "pin"),
            (self.is_clustered, "cluster"),
            (self.is_cracked, "crack"),
        ];
        let others = others.into_iter().filter_map(|(holds, name)| holds.then_some(name));
        std::iter::once(place).chain(others).collect::<Vec<_>>().join(" ")
    }
}

/// The numbers behind one defect or pocket, whether or not any of it is visible. NaN where a number has no meaning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// Number in instance images, from 1.
    pub id: u16,
    /// Class of its own pixels.
    pub class: Class,
    /// What the whole of it counts as: the worst defect of a pocket, else its own class.
    pub state: Class,
    /// Number of the instance that it lies in; 0 for none. Boxes and areas of that one hold it too.
    pub within: u16,
    /// Centre at the upper surface, along the laser line [mm].
    pub x_mm: f64,
    /// Centre at the upper surface, along the scan [mm].
    pub y_mm: f64,
    /// Diameter across its axis at the upper surface, or largest extent [mm].
    pub diameter_mm: f64,
    /// Angle between its axis and the upper surface [deg].
    pub dive_deg: f64,
    /// Distance from the pith at which the branch died [mm].
    pub death_radius_mm: f64,
    /// Severity of decay or of a defect, 0 to 1 [1].
    pub severity: f64,
    /// Greatest depth below the face, of openings [mm].
    pub depth_mm: f64,
    /// What graders call it, where it is a knot.
    pub knot: Option<KnotNames>,
}

impl Instance {
    /// A thing that has a place, a largest extent [mm] and, where that means something, a severity.
    pub fn new(id: u16, class: Class, [x_mm, y_mm]: [f64; 2], diameter_mm: f64, severity: f64) -> Self {
        Self {
            id,
            class,
            state: class,
            within: 0,
            x_mm,
            y_mm,
            diameter_mm,
            dive_deg: f64::NAN,
            death_radius_mm: f64::NAN,
            severity,
            depth_mm: f64::NAN,
            knot: None,
        }
    }
}
