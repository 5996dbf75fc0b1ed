//! Coats on the upper face: dirt and burns.
//!
//! Models: a thin layer that takes a share of the light each time it passes and has no thickness in Range. A spot of
//! dirt is an ellipse with a wandering outline and clouds inside; a burn is a band across the board that is darkest in
//! its middle and streaky along the fibre, where single knives touched more. Sources: transmittance of dirt as in
//! docs/theory/wood.md, the rest are engineering estimates. Limits: coats scatter nothing themselves; they have no
//! gloss of their own.

use base::{Class, Instance, Stream, lognormal};
use glam::Vec2;
use rand::RngExt;

use super::Wood;
use super::board_face::BoardFace;
use crate::noise::{Noise, smoothstep};

/// Spread of the logarithm of sizes [1].
const LOG_SD: f64 = 0.5;
/// Wander of the outline over its size, root mean square [1].
const OUTLINE: f32 = 0.2;
/// Unevenness of dirt, and of burns across the board [1], and the cell of either [mm].
const CLOUDS: [f32; 2] = [0.25, 0.35];
const CLOUD_MM: f32 = 1.5;
/// From this share on a place has the label [1].
const LABELLED: f32 = 0.5;

/// A coat at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coated {
    /// Light that it lets through, each way [1].
    pub through: f32,
    /// Its class and instance, where the coat is dark enough for the label.
    pub label: Option<(Class, u16)>,
}

#[derive(Debug, Clone, Copy)]
struct Coat {
    class: Class,
    id: u16,
    centre: Vec2,
    half: Vec2,
    through: f32,
    outline: Noise,
}

/// All coats of a board.
#[derive(Debug, Clone)]
pub(super) struct Coats(Vec<Coat>);

impl Coats {
    /// The coats that the numbers ask for; their instances are added to `instances`.
    pub fn grow(stream: Stream, wood: &Wood, instances: &mut Vec<Instance>) -> Self {
        let (asked, face) = (&wood.marks, BoardFace::of(wood));
        let mut all = Vec::new();
        for (class, name, count, size, through) in [
            (Class::Dirt, "dirt", asked.dirt_count, asked.dirt_mm, asked.dirt_coat),
            (Class::Burn, "burn", asked.burn_count, asked.burn_mm, asked.burn_coat),
        ] {
            for index in 0..count.round() as u64 {
                let own = stream.child(name).index(index);
                let mut rng = own.rng();
                let spot = face.spot([rng.random(), rng.random()]);
                let long = 1.0 + rng.random::<f32>();
                let size = lognormal(&mut rng, size, LOG_SD) as f32;
                let (centre, half) = match class {
                    // Across the whole board.
                    Class::Burn => (Vec2::new(face.middle.x, spot.y), Vec2::new(f32::INFINITY, 0.5 * size)),
                    _ => (spot, 0.5 * size * Vec2::new(1.0, long)),
                };
                let id = all.len() as u16 + instances.len() as u16 + 1;
                all.push(Coat {
                    class,
                    id,
                    centre,
                    half,
                    through: through as f32,
                    outline: Noise::new(own.child("outline")),
                });
            }
        }
        instances.extend(all.iter().map(|coat| {
            let extent = if coat.class == Class::Burn { 2.0 * face.half.x } else { 2.0 * coat.half.y };
            let at = [f64::from(coat.centre.x), f64::from(coat.centre.y)];
            Instance::new(coat.id, coat.class, at, f64::from(extent), 1.0 - f64::from(coat.through))
        }));
        Self(all)
    }

    /// The coats at a spot of the face; `None` where there is none.
    #[inline]
    pub fn at(&self, spot: Vec2) -> Option<Coated> {
        let mut coated: Option<Coated> = None;
        for coat in &self.0 {
            let q = (spot - coat.centre) / coat.half;
            if q.length_squared() > 4.0 {
                continue;
            }
            let clouds = coat.outline.plane(spot / CLOUD_MM).0;
            let share = match coat.class {
                Class::Burn => {
                    (1.0 - smoothstep(0.2, 1.0, q.y.abs())) * (1.0 + CLOUDS[1] * coat.outline.line(spot.x / CLOUD_MM).0)
                }
                _ => {
                    let edge = 1.0 + OUTLINE * coat.outline.plane(2.0 * q).0;
                    (1.0 - smoothstep(edge - 0.2, edge + 0.2, q.length())) * (1.0 + CLOUDS[0] * clouds)
                }
            };
            if share <= 0.0 {
                continue;
            }
            let through = 1.0 - (1.0 - coat.through) * share.min(1.0);
            let label = (share >= LABELLED).then_some((coat.class, coat.id));
            let before = coated.unwrap_or(Coated { through: 1.0, label: None });
            coated = Some(Coated { through: before.through * through, label: label.or(before.label) });
        }
        coated
    }
}
