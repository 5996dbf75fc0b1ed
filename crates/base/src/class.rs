//! Classes of pixels: what a place shows, by the same number in every label image.
//!
//! A class is one declaration here: its value, its name in files, the subject whose labels can show it and the minor
//! version of the schema since when they do, what it is, its colour in pictures. A new one comes last. A class in the
//! middle would change what stored labels mean. That takes a new major of `SCHEMA_VERSION`, and `OLDEST_MINOR` 0 there
//! and in `sheetlight_schema.py`.

use self::ClassKind::{Defect, Ground, Sound};

const WOOD: Option<&str> = Some("wood");
const BLISTER: Option<&str> = Some("blister");
const SAWTOOTH: Option<&str> = Some("sawtooth");
const MESH: Option<&str> = Some("mesh");

/// What pixels of a class show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClassKind {
    /// What surfaces show where all is well, or nothing at all; no object has such pixels.
    Ground,
    /// A thing as it should be, with what it is a kind of in other layouts, where they list it.
    Sound(Option<&'static str>),
    /// A defect, with what it is a kind of in other layouts.
    Defect(&'static str),
}

/// What a class declares.
struct ClassDeclaration {
    name: &'static str,
    subject: Option<&'static str>,
    since: u32,
    kind: ClassKind,
    colour: [u8; 3],
}

/// Declares the classes in the order of their values: value, name, subject, minor version, kind, colour.
macro_rules! classes {
    ($($(#[doc = $doc:literal])+ $Class:ident = $value:literal:
        $name:literal, $subject:expr, $since:literal, $kind:expr, $colour:expr;)+) => {
        /// What a point really is; the discriminant is the value in label images.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        #[repr(u8)]
        pub enum Class {
            $($(#[doc = $doc])+ $Class = $value,)+
        }

        impl Class {
            /// Every class in the order of its value.
            pub const ALL: [Self; [$($value,)+].len()] = [$(Self::$Class,)+];

            const fn declaration(self) -> ClassDeclaration {
                match self {
                    $(Self::$Class => ClassDeclaration {
                        name: $name,
                        subject: $subject,
                        since: $since,
                        kind: $kind,
                        colour: $colour,
                    },)+
                }
            }
        }
    };
}

classes! {
    /// Conveyor, or nothing.
    Background = 0: "background", None, 0, Ground, [40, 44, 52];
    /// Wood without defect.
    Clear = 1: "clear", WOOD, 0, Ground, [222, 196, 150];
    /// A knot that was alive where the saw met it.
    SoundKnot = 2: "sound_knot", WOOD, 0, Defect("knot"), [214, 96, 30];
    /// A knot that had died, its bark ring included.
    DeadKnot = 3: "dead_knot", WOOD, 0, Defect("knot"), [70, 36, 20];
    /// Decayed wood.
    Rot = 4: "rot", WOOD, 0, Defect("decay"), [74, 128, 92];
    /// Film that is sealed to the foil, or the foil's edge.
    Flange = 5: "flange", BLISTER, 0, Ground, [206, 210, 214];
    /// A pocket as it should be, its tablet included.
    Pocket = 6: "pocket", BLISTER, 0, Sound(Some("pocket")), [146, 168, 188];
    /// A pocket without its tablet.
    Missing = 7: "missing", BLISTER, 0, Defect("tablet"), [228, 26, 28];
    /// Where the rest of a broken tablet is missing.
    Broken = 8: "broken", BLISTER, 0, Defect("tablet"), [255, 127, 0];
    /// Where the edge of a tablet is missing.
    Chipped = 9: "chipped", BLISTER, 0, Defect("tablet"), [255, 190, 60];
    /// A gap through a tablet.
    Cracked = 10: "cracked", BLISTER, 0, Defect("tablet"), [150, 80, 30];
    /// Where a tablet has lost its cap.
    Capped = 11: "capped", BLISTER, 0, Defect("tablet"), [250, 235, 90];
    /// A pocket with another product.
    ForeignTablet = 12: "foreign_tablet", BLISTER, 0, Defect("tablet"), [152, 78, 163];
    /// A pocket whose tablet has the wrong colour, or a damaged coat.
    WrongCoat = 13: "wrong_coat", BLISTER, 0, Defect("tablet"), [247, 129, 191];
    /// A pocket with two tablets.
    Double = 14: "double", BLISTER, 0, Defect("tablet"), [88, 50, 150];
    /// A foreign particle.
    Particle = 15: "particle", BLISTER, 0, Defect("foreign_matter"), [0, 0, 0];
    /// A foreign fibre.
    Fibre = 16: "fibre", BLISTER, 0, Defect("foreign_matter"), [0, 90, 40];
    /// Powder or debris.
    Powder = 17: "powder", BLISTER, 0, Defect("foreign_matter"), [255, 250, 205];
    /// A pocket that was not formed to its full depth.
    Shallow = 18: "shallow", BLISTER, 0, Defect("forming"), [0, 114, 178];
    /// A dent in a pocket.
    Collapsed = 19: "collapsed", BLISTER, 0, Defect("forming"), [86, 210, 233];
    /// A hole in the film.
    Punctured = 20: "punctured", BLISTER, 0, Defect("film"), [0, 40, 255];
    /// A hole in the foil.
    Pinhole = 21: "pinhole", BLISTER, 0, Defect("film"), [255, 0, 255];
    /// A channel through the seal.
    Channel = 22: "channel", BLISTER, 0, Defect("seal"), [0, 200, 110];
    /// A wrinkle of the foil.
    Wrinkle = 23: "wrinkle", BLISTER, 0, Defect("seal"), [150, 220, 50];
    /// Film that has come off the foil.
    Delamination = 24: "delamination", BLISTER, 0, Defect("seal"), [0, 128, 128];
    /// A tablet caught between film and foil beside the pockets.
    TabletOnFlange = 25: "tablet_on_flange", BLISTER, 0, Defect("seal"), [130, 0, 60];
    /// A tooth of a saw-tooth.
    Tooth = 26: "tooth", SAWTOOTH, 0, Sound(None), [120, 160, 200];
    /// A part from a file.
    Object = 27: "object", MESH, 0, Sound(None), [200, 170, 90];
    /// A hole that a dead knot has left.
    KnotHole = 28: "knot_hole", WOOD, 5, Defect("knot"), [20, 10, 8];
    /// Wood that decay has discoloured and not yet softened.
    IncipientDecay = 29: "incipient_decay", WOOD, 5, Defect("decay"), [150, 176, 120];
    /// The pith and its own tissue.
    Pith = 30: "pith", WOOD, 5, Defect("structure"), [120, 66, 30];
    /// Compression wood of the stem.
    CompressionWood = 31: "compression_wood", WOOD, 5, Defect("structure"), [190, 110, 90];
    /// Sapwood with blue stain.
    BlueStain = 32: "blue_stain", WOOD, 5, Defect("discolouration"), [96, 116, 176];
    /// A pocket of resin between two rings.
    ResinPocket = 33: "resin_pocket", WOOD, 5, Defect("inclusion"), [255, 196, 0];
    /// Wood soaked with resin.
    ResinStreak = 34: "resin_streak", WOOD, 5, Defect("inclusion"), [240, 220, 110];
    /// Bark that the tree enclosed.
    BarkPocket = 35: "bark_pocket", WOOD, 5, Defect("inclusion"), [96, 40, 90];
    /// An open radial crack.
    Check = 36: "check", WOOD, 5, Defect("crack"), [230, 20, 60];
    /// An open crack along a ring.
    Shake = 37: "shake", WOOD, 5, Defect("crack"), [200, 0, 160];
    /// An open crack that runs in from an end.
    Split = 38: "split", WOOD, 5, Defect("crack"), [255, 90, 120];
    /// A hole that an insect made, its frass included.
    InsectHole = 39: "insect_hole", WOOD, 5, Defect("shape"), [0, 150, 255];
    /// The log's own surface, with or without bark.
    Wane = 40: "wane", WOOD, 5, Defect("shape"), [128, 120, 60];
    /// Dirt on the surface.
    Dirt = 41: "dirt", WOOD, 5, Defect("marking"), [110, 110, 110];
    /// A dent of a feed roller.
    RollerMark = 42: "roller_mark", WOOD, 5, Defect("marking"), [0, 190, 190];
    /// A place that the planer missed.
    PlanerSkip = 43: "planer_skip", WOOD, 5, Defect("marking"), [170, 140, 220];
    /// A burn from the planer's knives.
    Burn = 44: "burn", WOOD, 5, Defect("marking"), [150, 120, 10];
    /// A dead knot that has dried out of its hole: a gap around it, its face sunk and tilted.
    LooseKnot = 45: "loose_knot", WOOD, 5, Defect("knot"), [170, 60, 20];
}

impl Class {
    /// The class of that value in label images.
    pub fn of(value: impl TryInto<usize>) -> Option<Self> {
        Self::ALL.get(value.try_into().ok()?).copied()
    }

    /// The class of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|class| class.name() == name)
    }

    /// The classes that labels of a subject can show in that minor version of the schema, besides the background.
    pub fn of_subject(subject: &str, minor: u32) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |class| {
            let ClassDeclaration { subject: own, since, .. } = class.declaration();
            own == Some(subject) && since <= minor
        })
    }

    /// Name in files: lower case, underscores.
    pub const fn name(self) -> &'static str {
        self.declaration().name
    }

    /// The subject whose labels can show it; `None` for all of them.
    pub const fn subject(self) -> Option<&'static str> {
        self.declaration().subject
    }

    /// Colour in pictures, red, green and blue: calm where all is well, and far from its neighbours where it is not.
    pub const fn colour(self) -> [u8; 3] {
        self.declaration().colour
    }

    /// What its pixels show.
    pub const fn kind(self) -> ClassKind {
        self.declaration().kind
    }

    /// Whether it is a defect.
    pub fn is_defect(self) -> bool {
        matches!(self.kind(), Defect(_))
    }

    /// Whether it is matter of an object as it should be, neither a defect nor the background.
    pub fn is_sound(self) -> bool {
        self != Self::Background && !self.is_defect()
    }
}
