//! What the objects of a recipe are, and the numbers that one draw gives such an object.

use procedural::Parameter;
use procedural::blister::Blister;
use procedural::wood::Wood;

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
            Subject::Wood => Self::Wood(Wood::from_values(value)),
            Subject::Blister => Self::Blister(Blister::from_values(value)),
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
        match self {
            Self::Wood(Wood { board, log, knots, rot, media }) => {
                [board.values(), log.values(), knots.values(), rot.values(), media.values()].concat()
            }
            Self::Blister(blister) => blister.values(),
        }
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
