//! A body: whatever lies on the conveyor.
//!
//! A new subject implements [`BodyKind`] and [`Slice`] in `procedural`: surface, matter, hull, bounds and instances. A
//! body whose hull is its surface says so in [`BodyKind::is_its_hull`], one that hides parts of itself or throws light
//! onto itself in [`BodyKind::relief`]. In the crate `recipe`, `subject.rs` has its `Subject` and `Plan`, `keys/mod.rs`
//! its groups of parameters, `constraints/object.rs` its rules. The pipeline makes it in `body` and has its numbers in
//! `effective.rs`. What its labels can show stands in `output_schema/src/subject.rs`, its truth maps in
//! `dataset/src/record.rs`.

use std::any::Any;
use std::fmt::Debug;
use std::ops::Deref;
use std::sync::Arc;

use glam::{Vec2, Vec3};

use crate::{Instance, Matter, Mesh, Surface};

/// Places that are worked out together, as vector code.
pub const BLOCK: usize = 16;

/// Anything that can lie under the laser: what its kind makes of it; clones share it.
#[derive(Debug, Clone)]
pub struct Body(Arc<dyn BodyKind>);

impl Body {
    /// A body of some kind.
    pub fn new(kind: impl BodyKind) -> Self {
        Self(Arc::new(kind))
    }

    /// What it is made as, where that is a `T`.
    pub fn get<T: BodyKind>(&self) -> Option<&T> {
        (&*self.0 as &dyn Any).downcast_ref()
    }
}

impl Deref for Body {
    type Target = dyn BodyKind;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

/// How a body's upper surface hides parts of itself and throws light onto itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Relief {
    /// Not at all, or rays through its hull tell it.
    Smooth,
    /// Walls of openings hide and shade what lies behind them; they are rough and mirror nothing.
    Openings,
    /// Film over rooms hides, and mirrors the line.
    Film {
        /// Least reduced scattering times thickness of the film, anywhere [1].
        clearest: f32,
    },
}

/// One kind of body: boards, packs, pieces, parts, targets.
pub trait BodyKind: Any + Debug + Send + Sync {
    /// The cut at scan position `y` [mm].
    fn slice(&self, y: f32) -> Box<dyn Slice + '_>;

    /// A closed coarse hull, within 0.2 mm of the surface, for shadows; of solid pieces the surface itself [mm].
    fn hull(&self) -> Mesh;

    /// Lowest and highest corner of a box around the body [mm].
    fn bounds(&self) -> (Vec3, Vec3);

    /// Whether a line at its end along the motion falls beside it with a part of its width; targets stand for a plane
    /// without ends.
    fn has_ends(&self) -> bool {
        true
    }

    /// The things on it that labels number, ordered by number from 1 without gaps: defects, pockets, teeth, parts.
    fn instances(&self) -> &[Instance] {
        &[]
    }

    /// Whether its hull is its surface: rays through it then tell exactly what is where, overhangs included.
    fn is_its_hull(&self) -> bool {
        false
    }

    /// How its surface hides parts of itself.
    fn relief(&self) -> Relief {
        Relief::Smooth
    }
}

/// A body cut at one position of the scan; holds what is common to all points of the cut.
pub trait Slice: Debug + Sync {
    /// Upper surface above `x` [mm]; `None` beside the body.
    fn surface(&self, x: f32) -> Option<Surface>;

    /// Medium and truth at (x, z) of the cut, inside the body [mm].
    fn matter(&self, x: f32, z: f32) -> Matter;

    /// Upper surfaces above some `x` [mm]; `None` beside the body.
    fn surfaces(&self, x: &[f32; BLOCK]) -> [Option<Surface>; BLOCK] {
        x.map(|x| self.surface(x))
    }

    /// Medium and truth at some places (x, z) of the cut, inside the body [mm]; `put` takes the number of each that is
    /// one, and its matter.
    fn matters(&self, places: &[Option<Vec2>; BLOCK], put: &mut dyn FnMut(usize, Matter)) {
        for (n, place) in places.iter().enumerate().filter_map(|(n, place)| Some((n, (*place)?))) {
            put(n, self.matter(place.x, place.y));
        }
    }
}
