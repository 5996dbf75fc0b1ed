//! The truth at a point and about whole things: classes, instances and their numbers.
//!
//! A new class comes last in [`Class`] and says on which side of [`Class::is_of_wood`] it stands. The order is that of
//! `PIXEL_CLASSES` in output_schema, which a test holds. What a subject gets later is a run of its own in
//! `output_schema/src/subject.rs`, with the minor version since when labels show it. The colour of a class stands in
//! `drawing/src/classes.rs`, its kind and whether it is good in `tools/src/export/classes.rs`. A class in the middle
//! would change what stored labels mean. That takes a new major of `SCHEMA_VERSION`, and `OLDEST_MINOR` 0 there and in
//! `sheetlight_schema.py`.

use crate::{Film, Medium};

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
    /// Film that is sealed to the foil, or the foil's edge.
    Flange = 5,
    /// A pocket as it should be, its tablet included.
    Pocket = 6,
    /// A pocket without its tablet.
    Missing = 7,
    /// Where the rest of a broken tablet is missing.
    Broken = 8,
    /// Where the edge of a tablet is missing.
    Chipped = 9,
    /// A gap through a tablet.
    Cracked = 10,
    /// Where a tablet has lost its cap.
    Capped = 11,
    /// A pocket with another product.
    ForeignTablet = 12,
    /// A pocket whose tablet has the wrong colour, or a damaged coat.
    WrongCoat = 13,
    /// A pocket with two tablets.
    Double = 14,
    /// A foreign particle.
    Particle = 15,
    /// A foreign fibre.
    Fibre = 16,
    /// Powder or debris.
    Powder = 17,
    /// A pocket that was not formed to its full depth.
    Shallow = 18,
    /// A dent in a pocket.
    Collapsed = 19,
    /// A hole in the film.
    Punctured = 20,
    /// A hole in the foil.
    Pinhole = 21,
    /// A channel through the seal.
    Channel = 22,
    /// A wrinkle of the foil.
    Wrinkle = 23,
    /// Film that has come off the foil.
    Delamination = 24,
    /// A tablet caught between film and foil beside the pockets.
    TabletOnFlange = 25,
    /// A tooth of a saw-tooth.
    Tooth = 26,
    /// A part from a file.
    Object = 27,
    /// A hole that a dead knot has left.
    KnotHole = 28,
    /// Wood that decay has discoloured and not yet softened.
    IncipientDecay = 29,
    /// The pith and its own tissue.
    Pith = 30,
    /// Compression wood of the stem.
    CompressionWood = 31,
    /// Sapwood with blue stain.
    BlueStain = 32,
    /// A pocket of resin between two rings.
    ResinPocket = 33,
    /// Wood soaked with resin.
    ResinStreak = 34,
    /// Bark that the tree enclosed.
    BarkPocket = 35,
    /// An open radial crack.
    Check = 36,
    /// An open crack along a ring.
    Shake = 37,
    /// An open crack that runs in from an end.
    Split = 38,
    /// A hole that an insect made, its frass included.
    InsectHole = 39,
    /// The log's own surface, with or without bark.
    Wane = 40,
    /// Dirt on the surface.
    Dirt = 41,
    /// A dent of a feed roller.
    RollerMark = 42,
    /// A place that the planer missed.
    PlanerSkip = 43,
    /// A burn from the planer's knives.
    Burn = 44,
    /// A dead knot that has dried out of its hole: a gap around it, its face sunk and tilted.
    LooseKnot = 45,
}

impl Class {
    /// Every class in the order of its value.
    pub const ALL: [Self; 46] = [
        Self::Background,
        Self::Clear,
        Self::SoundKnot,
        Self::DeadKnot,
        Self::Rot,
        Self::Flange,
        Self::Pocket,
        Self::Missing,
        Self::Broken,
        Self::Chipped,
        Self::Cracked,
        Self::Capped,
        Self::ForeignTablet,
        Self::WrongCoat,
        Self::Double,
        Self::Particle,
        Self::Fibre,
        Self::Powder,
        Self::Shallow,
        Self::Collapsed,
        Self::Punctured,
        Self::Pinhole,
        Self::Channel,
        Self::Wrinkle,
        Self::Delamination,
        Self::TabletOnFlange,
        Self::Tooth,
        Self::Object,
        Self::KnotHole,
        Self::IncipientDecay,
        Self::Pith,
        Self::CompressionWood,
        Self::BlueStain,
        Self::ResinPocket,
        Self::ResinStreak,
        Self::BarkPocket,
        Self::Check,
        Self::Shake,
        Self::Split,
        Self::InsectHole,
        Self::Wane,
        Self::Dirt,
        Self::RollerMark,
        Self::PlanerSkip,
        Self::Burn,
        Self::LooseKnot,
    ];

    /// Whether it is a defect: neither what surfaces show where all is well nor a pocket, tooth or part that is as it
    /// should be.
    pub fn is_defect(self) -> bool {
        !matches!(self, Self::Background | Self::Clear | Self::Flange | Self::Pocket | Self::Tooth | Self::Object)
    }

    /// Whether it is matter of an object as it should be, neither a defect nor the background.
    pub fn is_sound(self) -> bool {
        self != Self::Background && !self.is_defect()
    }

    /// Whether pixels of boards can have it.
    pub fn is_of_wood(self) -> bool {
        // Every class is named, so that a new one has to be put on its side.
        match self {
            Self::Clear
            | Self::SoundKnot
            | Self::DeadKnot
            | Self::Rot
            | Self::KnotHole
            | Self::IncipientDecay
            | Self::Pith
            | Self::CompressionWood
            | Self::BlueStain
            | Self::ResinPocket
            | Self::ResinStreak
            | Self::BarkPocket
            | Self::Check
            | Self::Shake
            | Self::Split
            | Self::InsectHole
            | Self::Wane
            | Self::Dirt
            | Self::RollerMark
            | Self::PlanerSkip
            | Self::Burn
            | Self::LooseKnot => true,
            Self::Background
            | Self::Flange
            | Self::Pocket
            | Self::Missing
            | Self::Broken
            | Self::Chipped
            | Self::Cracked
            | Self::Capped
            | Self::ForeignTablet
            | Self::WrongCoat
            | Self::Double
            | Self::Particle
            | Self::Fibre
            | Self::Powder
            | Self::Shallow
            | Self::Collapsed
            | Self::Punctured
            | Self::Pinhole
            | Self::Channel
            | Self::Wrinkle
            | Self::Delamination
            | Self::TabletOnFlange
            | Self::Tooth
            | Self::Object => false,
        }
    }

    /// Name in files: lower case, underscores.
    pub fn name(self) -> &'static str {
        match self {
            Self::Background => "background",
            Self::Clear => "clear",
            Self::SoundKnot => "sound_knot",
            Self::DeadKnot => "dead_knot",
            Self::Rot => "rot",
            Self::Flange => "flange",
            Self::Pocket => "pocket",
            Self::Missing => "missing",
            Self::Broken => "broken",
            Self::Chipped => "chipped",
            Self::Cracked => "cracked",
            Self::Capped => "capped",
            Self::ForeignTablet => "foreign_tablet",
            Self::WrongCoat => "wrong_coat",
            Self::Double => "double",
            Self::Particle => "particle",
            Self::Fibre => "fibre",
            Self::Powder => "powder",
            Self::Shallow => "shallow",
            Self::Collapsed => "collapsed",
            Self::Punctured => "punctured",
            Self::Pinhole => "pinhole",
            Self::Channel => "channel",
            Self::Wrinkle => "wrinkle",
            Self::Delamination => "delamination",
            Self::TabletOnFlange => "tablet_on_flange",
            Self::Tooth => "tooth",
            Self::Object => "object",
            Self::KnotHole => "knot_hole",
            Self::IncipientDecay => "incipient_decay",
            Self::Pith => "pith",
            Self::CompressionWood => "compression_wood",
            Self::BlueStain => "blue_stain",
            Self::ResinPocket => "resin_pocket",
            Self::ResinStreak => "resin_streak",
            Self::BarkPocket => "bark_pocket",
            Self::Check => "check",
            Self::Shake => "shake",
            Self::Split => "split",
            Self::InsectHole => "insect_hole",
            Self::Wane => "wane",
            Self::Dirt => "dirt",
            Self::RollerMark => "roller_mark",
            Self::PlanerSkip => "planer_skip",
            Self::Burn => "burn",
            Self::LooseKnot => "loose_knot",
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
}

impl KnotNames {
    /// The names with spaces between them: the place, then what else holds.
    pub fn text(&self) -> String {
        let place = match self.place {
            KnotPlace::Face => "face",
            KnotPlace::Edge => "edge",
            KnotPlace::Arris => "arris",
        };
        let others = [(self.is_spike, "spike"), (self.is_pin, "pin"), (self.is_clustered, "cluster")];
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
    /// A defect of wood that has a place, a largest extent [mm] and, where that means something, a severity.
    pub fn defect(id: u16, class: Class, [x_mm, y_mm]: [f64; 2], diameter_mm: f64, severity: f64) -> Self {
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
