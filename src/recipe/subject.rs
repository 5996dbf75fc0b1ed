//! What the objects of a recipe are, and the numbers that one draw gives such an object.

use procedural::Parameter;
use procedural::blister::{Blister, Card, Defects, Foil, Pocket, Tablet, Web};
use procedural::wood::{Board, Knots, Log, Media, Rot, Wood};

/// What the objects are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subject {
    /// Sawn boards of softwood.
    Wood,
    /// Blister packs, film up.
    Blister,
}

impl Subject {
    /// Every subject in the order of [`Self::NAMES`].
    pub const ALL: [Self; 2] = [Self::Wood, Self::Blister];
    /// Names in recipes and files.
    pub const NAMES: [&str; 2] = ["wood", "blister"];

    /// Name in recipes and files.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

/// The numbers that one object is made from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Plan {
    /// Of a board and the log that it was cut from.
    Wood(Wood),
    /// Of a blister pack.
    Blister(Blister),
}

impl Plan {
    /// Fills every number of `subject` from `value`, asked once for each declaration in order.
    pub fn from_values(subject: Subject, value: &mut dyn FnMut(&'static Parameter) -> f64) -> Self {
        match subject {
            Subject::Wood => Self::Wood(Wood {
                board: Board::from_values(value),
                log: Log::from_values(value),
                knots: Knots::from_values(value),
                rot: Rot::from_values(value),
                media: Media::from_values(value),
            }),
            Subject::Blister => Self::Blister(Blister {
                card: Card::from_values(value),
                pocket: Pocket::from_values(value),
                tablet: Tablet::from_values(value),
                web: Web::from_values(value),
                foil: Foil::from_values(value),
                defects: Defects::from_values(value),
            }),
        }
    }

    /// What the object is.
    pub fn subject(&self) -> Subject {
        match self {
            Self::Wood(_) => Subject::Wood,
            Self::Blister(_) => Subject::Blister,
        }
    }

    /// Every number with its declaration, in their order.
    pub fn values(&self) -> Vec<(&'static Parameter, f64)> {
        let groups = match self {
            Self::Wood(Wood { board, log, knots, rot, media }) => {
                vec![board.values(), log.values(), knots.values(), rot.values(), media.values()]
            }
            Self::Blister(Blister { card, pocket, tablet, web, foil, defects }) => {
                vec![card.values(), pocket.values(), tablet.values(), web.values(), foil.values(), defects.values()]
            }
        };
        groups.concat()
    }

    /// The numbers of a board; `None` for anything else.
    pub fn wood(&self) -> Option<&Wood> {
        match self {
            Self::Wood(wood) => Some(wood),
            Self::Blister(_) => None,
        }
    }

    /// The numbers of a blister pack; `None` for anything else.
    pub fn blister(&self) -> Option<&Blister> {
        match self {
            Self::Blister(blister) => Some(blister),
            Self::Wood(_) => None,
        }
    }
}
