//! What light meets at the floor of an opening: wood, a gallery's wall, frass, or bark in patches.

use base::Stream;
use glam::Vec2;

use crate::noise::Noise;

/// Wood that every opening leaves above the conveyor [mm].
pub(super) const FLOOR_MM: f32 = 0.3;
/// Light that the dark wall of a gallery lets through, each way; an estimate [1].
pub(super) const GALLERY_COAT: f32 = 0.45;
/// Bounds of value noise in the plane that hold all of it: bark is everywhere or nowhere beyond them [1].
const NORMAL_TO_SHARE: f32 = 2.3;
/// Roughness of bark and of the surface below it [mm], and its cell [mm].
const BARK_ROUGH_MM: [f32; 2] = [0.5, 0.03];
const BARK_CELL_MM: f32 = 3.5;
/// Cell of the patches of bark [mm].
const BARK_PATCH_MM: f32 = 30.0;

/// What light meets in an opening.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Floor {
    /// The wood that is there.
    Wood,
    /// The wall of a gallery, darkened by fungi that beetles bring.
    Gallery,
    /// Frass: chewed wood.
    Frass,
    /// Bark.
    Bark,
}

/// Bark and the bare surface below it, in patches.
#[derive(Debug, Clone)]
pub(super) struct BarkCover {
    /// Share of bark [1].
    share: f32,
    rough: Noise,
    patches: Noise,
}

impl BarkCover {
    /// The cover of a share of the surface [1].
    pub fn new(stream: Stream, share: f64) -> Self {
        let [rough, patches] = ["rough", "patches"].map(|name| Noise::new(stream.child(name)));
        Self { share: share as f32, rough, patches }
    }

    /// How much deeper than smooth the surface lies where it goes down by `down` from its upper border [mm], and what
    /// is there.
    #[inline]
    pub fn at(&self, spot: Vec2, down: f32) -> (f32, Floor) {
        let barked = self.patches.plane(Vec2::new(spot.x, 0.4 * spot.y) / BARK_PATCH_MM).0
            < NORMAL_TO_SHARE * (2.0 * self.share - 1.0);
        let rough = BARK_ROUGH_MM[usize::from(!barked)]
            * self.rough.plane(Vec2::new(spot.x, 0.3 * spot.y) / BARK_CELL_MM).0
            * (down / 2.0).min(1.0);
        (rough, if barked { Floor::Bark } else { Floor::Wood })
    }
}
