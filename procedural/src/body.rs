//! A body: whatever lies on the conveyor.
//!
//! A new subject is a variant of [`Body`] and [`Slice`] with surface, matter, hull, bounds and instances. A body whose
//! hull is its surface says so in [`Body::is_its_hull`]. One that hides itself or throws light onto itself says so in
//! `surface_grids` of `scanner/src/specimen.rs`. In the crate `recipe`, `subject.rs` has its `Subject` and `Plan`,
//! `keys/mod.rs` its groups of parameters, `constraints/object.rs` its rules. The pipeline makes it in `body` and has
//! its numbers in `effective.rs`. What its labels can show stands in `output_schema/src/subject.rs`, its truth maps in
//! `dataset/src/record.rs`.

use glam::{Vec2, Vec3};

use crate::Mesh;
use crate::blister::{Pack, PackSlice};
use crate::flat::{Flat, FlatSlice};
use crate::noise::BLOCK;
use crate::solid::part::PartSlice;
use crate::solid::sawtooth::SawtoothSlice;
use crate::solid::{Part, Sawtooth};
use crate::strips::{Strips, StripsSlice};
use crate::truth::{Instance, Matter, Surface};
use crate::wood::{Plank, PlankSlice};

/// Everything that can lie under the laser.
#[derive(Debug, Clone)]
pub enum Body {
    /// A sawn board.
    Plank(Box<Plank>),
    /// A blister pack.
    Pack(Box<Pack>),
    /// A saw-tooth for calibration.
    Sawtooth(Box<Sawtooth>),
    /// A part from a file of triangles.
    Part(Box<Part>),
    /// A flat target of one medium, for calibration and tests.
    Flat(Flat),
    /// A flat target of several media with borders and cracks, for tests.
    Strips(Strips),
}

/// A body cut at one position of the scan; holds what is common to all points of the cut.
#[derive(Debug)]
pub enum Slice<'a> {
    /// Through a board.
    Plank(PlankSlice<'a>),
    /// Through a blister pack.
    Pack(PackSlice<'a>),
    /// Through a saw-tooth.
    Sawtooth(SawtoothSlice<'a>),
    /// Through a part from a file.
    Part(PartSlice<'a>),
    /// Through a flat target.
    Flat(FlatSlice<'a>),
    /// Through a target of strips.
    Strips(StripsSlice<'a>),
}

impl Body {
    /// The cut at scan position `y` [mm].
    pub fn slice(&self, y: f32) -> Slice<'_> {
        match self {
            Self::Plank(plank) => Slice::Plank(plank.slice(y)),
            Self::Pack(pack) => Slice::Pack(pack.slice(y)),
            Self::Sawtooth(body) => Slice::Sawtooth(body.slice(y)),
            Self::Part(part) => Slice::Part(part.slice(y)),
            Self::Flat(flat) => Slice::Flat(flat.slice(y)),
            Self::Strips(strips) => Slice::Strips(strips.slice(y)),
        }
    }

    /// A closed coarse hull, within 0.2 mm of the surface, for shadows; of solid pieces the surface itself [mm].
    pub fn hull(&self) -> Mesh {
        match self {
            Self::Plank(plank) => plank.hull(),
            Self::Pack(pack) => pack.hull(),
            Self::Sawtooth(body) => body.hull(),
            Self::Part(part) => part.hull(),
            Self::Flat(flat) => flat.hull(),
            Self::Strips(strips) => strips.hull(),
        }
    }

    /// Lowest and highest corner of a box around the body [mm].
    pub fn bounds(&self) -> (Vec3, Vec3) {
        match self {
            Self::Plank(plank) => plank.bounds(),
            Self::Pack(pack) => pack.bounds(),
            Self::Sawtooth(body) => body.bounds(),
            Self::Part(part) => part.bounds(),
            Self::Flat(flat) => flat.bounds(),
            Self::Strips(strips) => strips.bounds(),
        }
    }

    /// The things on it that labels number, ordered by number from 1 without gaps: defects, pockets, teeth, parts.
    pub fn instances(&self) -> &[Instance] {
        match self {
            Self::Plank(plank) => plank.instances(),
            Self::Pack(pack) => pack.instances(),
            Self::Sawtooth(body) => body.instances(),
            Self::Part(part) => part.instances(),
            Self::Flat(_) | Self::Strips(_) => &[],
        }
    }
}

impl Body {
    /// Whether its hull is its surface: rays through it then tell exactly what is where, overhangs included.
    pub fn is_its_hull(&self) -> bool {
        matches!(self, Self::Sawtooth(_) | Self::Part(_))
    }
}

impl Slice<'_> {
    /// Upper surface above `x` [mm]; `None` beside the body.
    pub fn surface(&self, x: f32) -> Option<Surface> {
        match self {
            Self::Plank(slice) => slice.surface(x),
            Self::Pack(slice) => slice.surface(x),
            Self::Sawtooth(slice) => slice.surface(x),
            Self::Part(slice) => slice.surface(x),
            Self::Flat(slice) => slice.surface(x),
            Self::Strips(slice) => slice.surface(x),
        }
    }

    /// Upper surfaces above some `x` [mm]; `None` beside the body.
    pub fn surfaces(&self, x: &[f32; BLOCK]) -> [Option<Surface>; BLOCK] {
        match self {
            Self::Plank(slice) => slice.surfaces(x),
            slice => x.map(|x| slice.surface(x)),
        }
    }

    /// Medium and truth at some places (x, z) of the cut, inside the body [mm]; `put` takes the number of each that is
    /// one, and its matter.
    pub fn matters(&self, places: &[Option<Vec2>; BLOCK], mut put: impl FnMut(usize, Matter)) {
        if let Self::Plank(slice) = self {
            return slice.matters(places, put);
        }
        for (n, place) in places.iter().enumerate().filter_map(|(n, place)| Some((n, (*place)?))) {
            put(n, self.matter(place.x, place.y));
        }
    }

    /// Medium and truth at (x, z) of the cut, inside the body [mm].
    pub fn matter(&self, x: f32, z: f32) -> Matter {
        match self {
            Self::Plank(slice) => slice.matter(x, z),
            Self::Pack(slice) => slice.matter(x),
            Self::Sawtooth(slice) => slice.matter(x),
            Self::Part(slice) => slice.matter(),
            Self::Flat(slice) => slice.matter(),
            Self::Strips(slice) => slice.matter(x),
        }
    }
}
