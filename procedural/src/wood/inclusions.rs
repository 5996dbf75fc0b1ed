//! Inclusions: resin pockets, resin streaks and bark pockets.
//!
//! Models: a lens of two caps, or an ellipsoid for a streak, in the log's own coordinates, growth time t outwards, arc
//! about the pith around, l along: its longest axis runs along the grain and its shortest outwards, so it lies in a
//! growth layer and bends with it. A resin pocket lies on the boundary of a ring, where one is near; a bark pocket is
//! narrower; both are sharp. A streak is wood soaked with resin that fades outwards over half of its size. Each is cut
//! by the upper face: its middle lies within 0.1 of its own thickness of it. Sources: resin pockets as lenses within a
//! growth ring (Temnerud 1998); sizes are engineering estimates. Limits: pockets are full of resin, none has run out;
//! bark pockets carry no callus; rings do not bend around any of them.

use base::{Class, Instance, Stream, lognormal};
use rand::RngExt;

use super::Wood;
use super::board_face::BoardFace;
use super::growth::wrap;
use super::pith::{LogPoint, Trunk};
use super::rings::Rings;
use crate::noise::{Noise, smoothstep};

/// Spread of the logarithm of each size [1].
const LOG_SD: f64 = 0.3;
/// Distance of a resin pocket's middle from the boundary of the ring that it lies on, over half its thickness [1].
const TORN: f32 = 0.3;
/// Farthest that the middle lies from the face over half the size outwards [1]; outlines wander by less than the rest.
const ASIDE: f32 = 0.2;
/// Share of a streak's size over which it fades [1].
const STREAK_FADE: f32 = 0.5;
/// Width of a bark pocket over that of a resin pocket [1].
const BARK_WIDTH: f32 = 0.3;
/// Wander of a pocket's outline over its size, root mean square [1], and cells of it along a size [1].
const OUTLINE: [f32; 2] = [0.12, 1.3];

/// What an inclusion is full of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Filling {
    /// Resin.
    Resin,
    /// Bark.
    Bark,
}

/// An inclusion at a place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Included {
    /// What it is full of.
    pub filling: Filling,
    /// How much of it is there, 0 to 1 [1].
    pub share: f32,
    /// Its class.
    pub class: Class,
    /// Its instance.
    pub id: u16,
}

#[derive(Debug, Clone, Copy)]
struct Inclusion {
    class: Class,
    id: u16,
    /// Growth time, azimuth [rad] and place along the log of its middle [mm].
    t: f32,
    azimuth: f32,
    along: f32,
    /// Half its size outwards, around and along [mm].
    half: [f32; 3],
    outline: Noise,
}

/// All inclusions of a board.
#[derive(Debug, Clone)]
pub(super) struct Inclusions(Vec<Inclusion>);

impl Inclusions {
    /// The inclusions that the numbers ask for; their instances are added to `instances`.
    pub fn grow(stream: Stream, wood: &Wood, trunk: &Trunk, rings: &Rings, instances: &mut Vec<Instance>) -> Self {
        let (asked, face) = (&wood.inclusions, BoardFace::of(wood));
        let mut all = Vec::new();
        for (class, name, count, length) in [
            (Class::ResinPocket, "resin_pocket", asked.resin_pocket_count, asked.length_mm),
            (Class::ResinStreak, "resin_streak", asked.resin_streak_count, asked.streak_length_mm),
            (Class::BarkPocket, "bark_pocket", asked.bark_pocket_count, asked.length_mm),
        ] {
            for index in 0..count.round() as u64 {
                let own = stream.child(name).index(index);
                let mut rng = own.rng();
                let spot = face.spot([rng.random(), rng.random()]);
                let place = trunk.place(spot.x, spot.y, face.height);
                let ring = trunk.layer(&place);
                let aside = ASIDE * (2.0 * rng.random::<f32>() - 1.0);
                let mut about = |median: f64| lognormal(&mut rng, 0.5 * median, LOG_SD);
                let mut half = [asked.thickness_mm, asked.width_mm, length].map(|size| about(size) as f32);
                half[1] *= if class == Class::BarkPocket { BARK_WIDTH } else { 1.0 };
                let t = ring + aside * half[0];
                // Where the wood tore lies the boundary of a ring, if one is so near that the face still cuts the
                // pocket.
                let torn = rings.boundary(ring) + TORN * half[0];
                let t = if class == Class::ResinPocket && (torn - ring).abs() < 0.5 * half[0] { torn } else { t };
                let id = instances.len() as u16 + 1;
                let at = [f64::from(spot.x), f64::from(spot.y)];
                instances.push(Instance::new(id, class, at, 2.0 * f64::from(half[2].max(half[1])), f64::NAN));
                let (azimuth, along) = (place.phi, place.l);
                all.push(Inclusion { class, id, t, azimuth, along, half, outline: Noise::new(own.child("outline")) });
            }
        }
        Self(all)
    }

    /// The inclusion that takes most of a place that grew when the trunk had the radius `t` [mm].
    #[inline]
    pub fn at(&self, place: &LogPoint, t: f32) -> Option<Included> {
        let mut most: Option<Included> = None;
        for one in &self.0 {
            let share = one.share(place, t);
            if share > most.map_or(0.0, |other| other.share) {
                let filling = if one.class == Class::BarkPocket { Filling::Bark } else { Filling::Resin };
                most = Some(Included { filling, share, class: one.class, id: one.id });
            }
        }
        most
    }
}

impl Inclusion {
    #[inline]
    fn share(&self, place: &LogPoint, t: f32) -> f32 {
        let along = (place.l - self.along) / self.half[2];
        let outwards = (t - self.t) / self.half[0];
        if along.abs() > 1.5 || outwards.abs() > 1.5 {
            return 0.0;
        }
        let around = place.r * wrap(place.phi - self.azimuth) / self.half[1];
        let flat = along * along + around * around;
        let distance = match self.class {
            Class::ResinStreak => (flat + outwards * outwards).sqrt(),
            // Two caps that meet in a sharp rim.
            _ => flat + outwards.abs(),
        };
        if distance > 1.5 {
            return 0.0;
        }
        let place = glam::Vec3::new(around, along, outwards) * OUTLINE[1];
        let edge = 1.0 + OUTLINE[0] * self.outline.space(place);
        if self.class == Class::ResinStreak {
            return 1.0 - smoothstep(edge - STREAK_FADE, edge, distance);
        }
        // As sharp as a few cells of the thinnest way through it.
        let fade = (0.06 / self.half[0]).min(0.3);
        1.0 - smoothstep(edge - fade, edge + fade, distance)
    }
}
