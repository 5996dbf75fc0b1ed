//! How wood runs around one knot that a face shows: what [`super::growth`] does at every point of a log, for those who
//! see the face alone.
//!
//! Models: the flow of `grain_flow` and the bulge of `bulge` around a living branch that stands upright on the face, in
//! units of its half width. A leaning branch is the same after its outline has been stretched to a circle. Sources:
//! those of the two files. Limits: no death of the branch, no taper, no spiral; growth layers parallel to the face.

use glam::{Vec2, Vec3};

use super::bulge::{ASPECT, Bulge, BulgePlace, REACH, SHORTEN, height};
use super::grain_flow::{RankineOval, SLOWEST};
use super::growth::not_below;

/// What a knot does to the wood around it.
#[derive(Debug, Clone)]
pub struct KnotSurroundings {
    bulge: Bulge,
    oval: RankineOval,
}

/// What it does at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnotSurrounding {
    /// What the knot adds to a uniform stream of speed 1: along and across it [1].
    pub stream: Vec2,
    /// Slope of the growth layers, away from the pith positive: along and across the stream [1].
    pub slope: Vec2,
    /// How much the order of fibres is disturbed, 0 far from the knot and 1 at and in it [1].
    pub disturbed: f32,
}

impl KnotSurroundings {
    /// Beyond this many half widths across the fibre, and [`Self::LONGER`] times as many along it, nothing is disturbed
    /// [1].
    pub const REACH: f32 = REACH;
    /// How much longer the disturbance is along the fibre [1].
    pub const LONGER: f32 = ASPECT;

    /// Around knots whose source and sink lie `flow_ratio` half widths from the middle.
    pub fn new(flow_ratio: f32) -> Self {
        Self { bulge: Bulge::new(), oval: RankineOval::new(flow_ratio) }
    }

    /// At `p` from the middle of the knot, along and across the fibre [half width]; `None` where nothing is disturbed.
    pub fn at(&self, p: Vec2) -> Option<KnotSurrounding> {
        let squares = p * p;
        let place = BulgePlace::of(p.length(), (squares.y + squares.x * SHORTEN).sqrt());
        if place.x >= REACH {
            return None;
        }
        let merge = self.bulge.at(place.x);
        let (h, _) = height(1.0, 0.0, -1.0);
        let steep = h * merge.slope_over_x;
        let [whole, shortened] = place.steepness;
        Some(KnotSurrounding {
            stream: merge.weight * self.oval.disturb(p).velocity,
            slope: steep * Vec2::new((whole + shortened * SHORTEN) * p.x, (whole + shortened) * p.y),
            disturbed: self.bulge.disorder(&merge),
        })
    }

    /// The fibre where disturbances add up to `stream` and slopes of the growth layers to `slope`, both along and
    /// across the undisturbed fibre: along, across, and away from the pith [1].
    pub fn fibre(stream: Vec2, slope: Vec2) -> Vec3 {
        let free = Vec3::new(not_below(1.0 + stream.x, SLOWEST), stream.y, 0.0);
        let normal = (-slope).extend(1.0);
        (free - normal * (free.dot(normal) / normal.length_squared())).normalize_or(Vec3::X)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wood::{Plank, Wood};
    use base::{BodyKind, Class, Stream};

    /// Purpose: a board grown around one upright knot has the fibres that are told here.
    #[test]
    fn it_is_what_boards_have() {
        let mut wood = Wood::from_values(&mut |p| p.default);
        let log = &mut wood.log;
        (log.pith_tilt_deg, log.pith_wander_mm, log.spiral_deg, log.spiral_slope_deg_per_mm) = (0.0, 0.0, 0.0, 0.0);
        (log.pith_offset_mm, log.pith_depth_mm) = (0.0, 300.0);
        (wood.knots.sound_count, wood.knots.slope_deg, wood.knots.slope_sd_deg) = (1.0, 0.0, 0.0);
        (wood.knots.bulge_log_sd, wood.knots.lean_sd_deg) = (0.0, 0.0);
        (wood.board.cup_mm, wood.board.twist_deg) = (0.0, 0.0);
        let around = KnotSurroundings::new(wood.knots.flow_ratio as f32);
        let (mut checked, mut sum, mut worst) = (0, 0.0, 0.0_f32);
        for seed in 0..4 {
            let plank = Plank::grow(Stream::root(seed), &wood);
            let knot = &plank.instances()[0];
            let middle = Vec2::new(knot.x_mm as f32, knot.y_mm as f32);
            let half = 0.5 * knot.diameter_mm as f32;
            for i in 0..400 {
                let p = Vec2::from_angle(0.7 * i as f32) * (1.3 + 0.006 * i as f32);
                let place = middle + half * Vec2::new(p.y, p.x);
                let slice = plank.slice(place.y);
                let Some(surface) = slice.surface(place.x) else { continue };
                let matter = slice.matter(place.x, surface.z);
                let Some(told) = around.at(p) else { continue };
                if matter.class != Class::Clear {
                    continue;
                }
                let told = KnotSurroundings::fibre(told.stream, told.slope);
                let fibre = matter.medium.fibre * matter.medium.fibre.y.signum();
                let apart = fibre.angle_between(Vec3::new(told.y, told.x, told.z));
                worst = worst.max(apart);
                sum += apart;
                // Layers wave by half a percent over 40 mm and are curved about the pith (their normal leans by 50/300
                // at the edges, of which a bulge makes a twentieth), and the branch widens outwards by a third: each
                // about a degree.
                assert!(apart < 0.07, "seed {seed}, {p}: {fibre}, {told}, {apart}");
                checked += 1;
            }
        }
        let mean = sum / checked as f32;
        println!("fibres of {checked} places around knots: {mean} rad apart in the mean, {worst} at worst");
        assert!(checked > 1000 && mean < 0.03, "{checked}: {mean}");
    }
}
