//! What decay looks like inside: mottled, cracked into cubes, bleached in pockets, crossed by zone lines.
//!
//! Models: severity varies with noise that is elongated along the grain. Brown rot shrinks into cubes: strands along
//! the grain of unlike width, each broken across at places of its own. The cracks between them wander, are dark, and
//! open where decay is far developed. White pocket rot leaves bleached spindles around jittered points; their volume is
//! their share as long as they do not meet. Zone lines are the zeros of a noise of wide cells, as wide as asked by its
//! slope. Sources: forms and sizes after Schmidt (2006), *Wood and Tree Fungi*; what each absorbs is an estimate.
//! Limits: cracks have no depth; all of it lies still in the log as the front does, so that boards of one log continue
//! it.

use base::Stream;
use glam::Vec3;

use super::parameters::Rot;
use crate::noise::{Noise, smoothstep};

/// Cells of the mottle across and along the grain [mm].
const MOTTLE_MM: [f32; 2] = [2.5, 12.0];
/// Length of a cube along the grain over its size across [1], how far cracks lie from even places and how far they
/// wander, root mean square, over that size [1].
const CUBE_LENGTH: f32 = 1.5;
const CRACK_JITTER: f32 = 0.7;
const CRACK_WANDER: f32 = 0.06;
/// Half the width of a crack over the size of its cube, at most [1], what it absorbs over decayed wood [1], and the
/// severities between which wood cracks [1].
const CRACK_HALF: f32 = 0.07;
const CRACK_ABSORPTION: f32 = 6.0;
const CRACKED: [f32; 2] = [0.25, 0.6];
/// Cells of white pockets across and along the grain, each with one of them [mm], the share of their size over which
/// they fade [1], and what they absorb over clear wood [1].
const POCKET_MM: [f32; 2] = [2.2, 10.0];
const POCKET_FADE: f32 = 0.2;
const POCKET_ABSORPTION: f32 = 0.7;
/// Cells of zone lines across and along the grain [mm], and what they absorb over decayed wood [1].
const ZONE_MM: [f32; 2] = [14.0, 45.0];
const ZONE_ABSORPTION: f32 = 5.0;

/// The inside of decay.
#[derive(Debug, Clone)]
pub(super) struct DecayTexture {
    mottle: f32,
    cube: f32,
    /// Half the size of white pockets over that of their cells [1].
    pocket: f32,
    /// Half the width of zone lines [mm].
    zone: f32,
    noises: [Noise; 5],
}

/// What the inside is like at a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inside {
    /// Severity, 0 and more [1].
    pub severity: f32,
    /// Factor on absorption [1].
    pub absorption: f32,
}

impl DecayTexture {
    /// The texture that a recipe asks for.
    pub fn new(stream: Stream, asked: &Rot) -> Self {
        Self {
            mottle: asked.mottle as f32,
            cube: asked.cube_mm as f32,
            pocket: libm::cbrt(asked.white_pocket_share * 0.75 / std::f64::consts::PI) as f32,
            zone: 0.5 * asked.zone_line_mm as f32,
            noises: ["mottle", "cube", "crack", "pocket", "zone"].map(|name| Noise::new(stream.child(name))),
        }
    }

    /// At a point of the log, across, along and across the grain [mm], where a share of the front has `passed` and
    /// decay has `severity` on the mean.
    pub fn at(&self, log: Vec3, passed: f32, severity: f32) -> Inside {
        if passed == 0.0 {
            return Inside { severity, absorption: 1.0 };
        }
        let [mottle, cube, crack, pocket, zone] = self.noises;
        let cells = |[across, along]: [f32; 2]| log / Vec3::new(across, along, across);
        let mut severity = severity * (1.0 + self.mottle * mottle.fractal(cells(MOTTLE_MM))).max(0.0);
        let mut absorption = 1.0;
        if self.cube > 0.0 {
            let p = cells([self.cube, CUBE_LENGTH * self.cube]);
            let wander = [p, p + Vec3::splat(50.0)].map(|p| CRACK_WANDER * crack.fractal(p));
            let open = CRACK_HALF * (0.5 + 0.5 * crack.space(0.7 * p)).clamp(0.1, 1.0);
            let crack = 1.0 - smoothstep(0.6 * open, 1.2 * open, cracks(cube, p.x + wander[0], p.y + wander[1]));
            let developed = smoothstep(CRACKED[0], CRACKED[1], severity * passed);
            absorption += (CRACK_ABSORPTION - 1.0) * crack * developed;
        }
        if self.zone > 0.0 {
            let (value, slope) = zone.space_slope(cells(ZONE_MM));
            let per_mm = (slope / Vec3::new(ZONE_MM[0], ZONE_MM[1], ZONE_MM[0])).length();
            let line = 1.0 - smoothstep(0.7 * self.zone, 1.3 * self.zone, value.abs() / (per_mm + 1.0e-6));
            absorption += (ZONE_ABSORPTION - 1.0) * line * passed;
        }
        if self.pocket > 0.0 {
            let distance = pocket.nearest(cells(POCKET_MM));
            let rim = [1.0 - POCKET_FADE, 1.0 + POCKET_FADE].map(|share| share * self.pocket);
            let bleached = (1.0 - smoothstep(rim[0], rim[1], distance)) * passed;
            severity *= 1.0 - bleached;
            absorption *= 1.0 + bleached * (POCKET_ABSORPTION - 1.0);
        }
        Inside { severity, absorption }
    }
}

/// Distance to the nearest crack between cubes of unit size, across and along the grain [cube].
fn cracks(places: Noise, across: f32, along: f32) -> f32 {
    // One crack in each cell of a line, at a place of its own.
    let around = |x: f32, place: &dyn Fn(i32) -> f32| {
        let cell = x.floor() as i32;
        let (mut below, mut above) = ((i32::MIN, f32::NEG_INFINITY), f32::INFINITY);
        for i in cell - 1..=cell + 1 {
            let at = i as f32 + 0.5 + CRACK_JITTER * (place(i) - 0.5);
            if at <= x {
                below = (i, at);
            } else {
                above = above.min(at);
            }
        }
        (below.0, (x - below.1).min(above - x))
    };
    let (strand, beside) = around(across, &|i| places.cell(i, 0)[0]);
    let own = places.cell(strand, 1)[1];
    let (_, beyond) = around(along + own, &|j| places.cell(strand, j)[2]);
    beside.min(CUBE_LENGTH * beyond)
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use crate::wood::Wood;

    /// Numbers of `draws` points in the middle of decay of severity 0.5 that is asked for.
    fn inside(seed: u64, draws: usize, ask: impl Fn(&mut Rot)) -> Vec<Inside> {
        let mut rot = Wood::from_values(&mut |p| p.default).rot;
        rot.mottle = 0.0;
        ask(&mut rot);
        let stream = Stream::root(seed).child("texture");
        let texture = DecayTexture::new(stream, &rot);
        let mut rng = stream.child("places").rng();
        let mut place = || 800.0 * rng.random::<f32>() - 400.0;
        (0..draws).map(|_| texture.at(Vec3::new(place(), place(), place()), 1.0, 0.5)).collect()
    }

    fn share(of: &[Inside], is: impl Fn(&Inside) -> bool) -> f64 {
        of.iter().filter(|at| is(at)).count() as f64 / of.len() as f64
    }

    #[test]
    fn without_texture_decay_is_even() {
        assert!(inside(1, 1000, |_| ()).iter().all(|at| (at.severity, at.absorption) == (0.5, 1.0)));
    }

    #[test]
    fn severity_varies_as_asked() {
        for (seed, mottle) in [(1, 0.1), (2, 0.2), (3, 0.3)] {
            let all = inside(seed, 20_000, |rot| rot.mottle = mottle);
            let square = |at: &Inside| (f64::from(at.severity) / 0.5 - 1.0).powi(2);
            let rms = (all.iter().map(square).sum::<f64>() / all.len() as f64).sqrt();
            assert!((rms / mottle - 1.0).abs() < 0.05, "{rms} for {mottle}");
        }
    }

    #[test]
    fn white_pockets_take_their_share() {
        for (seed, asked) in [(1, 0.05), (2, 0.15), (3, 0.3)] {
            let all = inside(seed, 20_000, |rot| rot.white_pocket_share = asked);
            let seen = share(&all, |at| at.severity < 0.25);
            assert!((0.8..1.1).contains(&(seen / asked)), "{seen} for {asked}");
        }
    }

    #[test]
    fn cracks_and_zone_lines_are_dark_and_as_wide_as_asked() {
        let dark = |at: &Inside| at.absorption > 3.0;
        // Cubes of any size look alike: their cracks take the same share.
        let [small, large] = [4.0, 15.0].map(|size| share(&inside(4, 20_000, |rot| rot.cube_mm = size), dark));
        assert!(0.03 < small && (small / large - 1.0).abs() < 0.15, "{small}, {large}");
        let [thin, wide] = [0.4, 1.2].map(|width| share(&inside(5, 60_000, |rot| rot.zone_line_mm = width), dark));
        assert!(0.005 < thin && (2.4..3.6).contains(&(wide / thin)), "{thin}, {wide}");
    }
}
