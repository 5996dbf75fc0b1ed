//! What a cut knot shows: its pith and heart, compression wood, years, fibres, cracks, its bark, and the stained wood
//! around it.
//!
//! Models: factors on the absorption of the knot's wood. The branch's pith lies off the middle of its outline, by e
//! half widths; its years are circles between both, so that a place p of the unit disc belongs to the circle s with
//! |p - (1 - s) e| = s. A knot as a whole is darker or lighter than others. Its heart is dark, and fades from the pith
//! outwards, where the youngest years are nearly as light as the stem. Conifers form compression wood on the lower side
//! of a branch, darker in proportion to the depth under the axis. Years differ; resin and early decay lie in patches;
//! fibres vary like the stem's, in lanes along the axis. Some knots crack as they dry, from the pith to one side, to
//! both or to three. A crack takes up light: it is a wedge of strong absorption. The bark of a dead knot is 1 + k cos
//! thick about the outline, and where that is negative the stem had closed around the branch without it. Resin and
//! tannins stain the stem's wood beyond the outline, most on one side.
//!
//! Sources: compression wood on the lower side of conifer branches is textbook knowledge (Timell 1986). The spread of
//! knots, the strength of hearts, how many crack and how bark leaves the outline were adjusted to photographs of sawn
//! spruce and pine (Kodytek et al. 2021, docs/theory/wood.md); all else here is an engineering estimate. Limits: cracks
//! have no depth in Range; their walls don't guide light; resin changes absorption alone.

use base::{Stream, normal};
use glam::{Vec2, Vec3};
use rand::RngExt;

use super::parameters::Knots;
use crate::noise::{Noise, smoothstep};

/// Radius of a branch's pith [mm], and the absorption in its middle over that of the wood [1].
const PITH: [f32; 2] = [0.9, 2.5];
/// Farthest that a pith lies from the middle [half widths].
const PITH_LIMIT: f32 = 0.7;
/// Where hearts end at the least and at the most [half widths from the pith].
const HEART_END: [f32; 2] = [0.9, 1.6];
/// Part of the heart's logarithm that is left at half a radius, where the knot's wood has its own absorption [1].
const HEART_HALF: f32 = 0.65;
/// Largest absorption at the lower edge over that on the axis, less one [1].
const COMPRESSION: f32 = 1.0;
/// Mean width of a run of like years [mm], and the spread of their absorption [1].
const YEARS: [f32; 2] = [0.7, 0.2];
/// Cell of patches [mm], and the spread of their absorption [1].
const PATCHES: [f32; 2] = [1.8, 0.25];
/// Cells of the fibres across and along the branch [mm], and the spread of their absorption [1].
const FIBRES: [f32; 3] = [0.3, 5.0, 0.15];
/// Most cracks from a pith.
const CHECKS: usize = 3;
/// Shares of cracked knots with one, two and three cracks: two lie opposite each other [1].
const CHECK_COUNTS: [f32; 2] = [0.35, 0.85];
/// Width of a crack at its widest over the half width of the knot [1], and the most it may be [mm].
const CHECK_WIDTH: [f32; 2] = [0.06, 0.5];
/// Where a crack may end, in half widths from the pith [1].
const CHECK_END: [f32; 2] = [0.5, 1.0];
/// Absorption in a crack over that of the knot's wood [1].
const CHECK_ABSORPTION: f32 = 16.0;
/// Wander of a crack over its distance from the pith [1], and its cell [mm].
const CHECK_WANDER: [f32; 2] = [0.05, 2.5];
/// Cells of the bark's roughness around a knot over two radians, and its spread over the mean thickness [1].
const BARK_ROUGH: [f32; 2] = [2.0, 0.4];
/// How far stained wood reaches beyond the outline, least and most [half widths].
const STAIN_REACH: [f32; 2] = [0.2, 0.8];

/// A crack from the pith outwards.
#[derive(Debug, Clone, Copy)]
struct Check {
    direction: Vec2,
    /// Where it ends [half widths]; 0 is no crack.
    end: f32,
    /// Its width at the pith over the half width [1]; it closes towards its end.
    width: f32,
}

/// The inside of one knot and its rim.
#[derive(Debug, Clone, Copy)]
pub(super) struct KnotInside {
    /// Logarithm of its absorption over that of the kind of knot [1].
    tone: f32,
    /// Its pith, from the middle of the outline: around and along [half widths].
    pith: Vec2,
    /// Logarithm of the absorption at the pith over that at the outline [1], and where it is fallen [half widths].
    heart: [f32; 2],
    compression: f32,
    years: Noise,
    patches: Noise,
    fibres: Noise,
    checks: [Check; CHECKS],
    /// Towards where bark is thickest, by its relative amplitude [1].
    bark: Vec2,
    /// Towards where the stem is stained most, its absorption there less one, and how far [half widths].
    stain: (Vec2, f32, f32),
}

impl KnotInside {
    /// The draws of one knot's own stream.
    pub fn grow(stream: Stream, knots: &Knots) -> Self {
        let mut rng = stream.child("tone").rng();
        let tone = (knots.tone_log_sd * normal(&mut rng)) as f32;
        // Each of two normal parts has the mean length over sqrt(pi / 2).
        let mut part = || normal(&mut rng) as f32;
        let off = knots.pith_shift as f32 * (2.0 / std::f32::consts::PI).sqrt();
        let pith = (off * Vec2::new(part(), part())).clamp_length_max(PITH_LIMIT);
        let mut share = || rng.random::<f32>();
        let heart = [libm::log(knots.heart_mu_a_ratio) as f32 * (0.5 + share()), between(HEART_END, share())];
        let compression = COMPRESSION * share();
        let bark = knots.bark_uneven as f32 * 2.0 * share() * direction(share());
        let stained = (knots.stain_mu_a_ratio as f32 - 1.0) * 2.0 * share();
        let stain = (direction(share()), stained, between(STAIN_REACH, share()));
        let [years, patches, fibres] = ["years", "patches", "fibres"].map(|name| Noise::new(stream.child(name)));
        let checks = checks(stream, knots);
        Self { tone, pith, heart, compression, years, patches, fibres, checks, bark, stain }
    }

    /// Whether it has cracked.
    pub fn is_cracked(&self) -> bool {
        self.checks[0].end > 0.0
    }

    /// Circle of its years that a place `x` half widths from the middle of the outline belongs to, `offset` from it in
    /// any unit: 0 at the pith, 1 on the outline [1].
    #[inline]
    pub fn circle(&self, offset: Vec2, x: f32) -> f32 {
        let from_pith = x * offset.normalize_or_zero() - self.pith;
        let (ahead, shrunk) = (from_pith.dot(self.pith), 1.0 - self.pith.length_squared());
        (ahead + (ahead * ahead + shrunk * from_pith.length_squared()).sqrt()) / shrunk
    }

    /// Absorption over that of its kind of knot [1]: `offset` from the axis [mm], `x` its length in half widths, on the
    /// `circle` of years, `below` the cosine of its angle from down the stem, `r` the distance from the log's pith
    /// [mm].
    #[inline]
    pub fn absorption(&self, offset: Vec2, x: f32, circle: f32, below: f32, r: f32) -> f32 {
        let half_width = offset.length() / x.max(1.0e-3);
        let from_pith = circle * half_width;
        let [strength, end] = self.heart;
        let heart = strength * (1.0 - smoothstep(0.0, end, circle) - HEART_HALF);
        let years = YEARS[1] * self.years.line(from_pith / YEARS[0]).0;
        let patches = PATCHES[1] * self.patches.plane(offset / PATCHES[0]).0;
        let place = Vec3::new(offset.x / FIBRES[0], offset.y / FIBRES[0], r / FIBRES[1]);
        let fibres = FIBRES[2] * self.fibres.bundles(place);
        let pith = 1.0 + (PITH[1] - 1.0) * (1.0 - smoothstep(0.4 * PITH[0], PITH[0], from_pith));
        let compression = 1.0 + self.compression * (x * below).max(0.0);
        let wood = pith * compression * libm::expf(self.tone + heart + years + patches + fibres);
        wood + (CHECK_ABSORPTION - wood).max(0.0) * self.cracked(offset - half_width * self.pith, half_width)
    }

    /// Thickness of bark in a direction over its mean all around, 0 where there is none [1].
    #[inline]
    pub fn bark(&self, offset: Vec2) -> f32 {
        let towards = offset.normalize_or_zero();
        let rough = BARK_ROUGH[1] * self.patches.plane(BARK_ROUGH[0] * towards).0;
        (1.0 + self.bark.dot(towards) + rough).max(0.0)
    }

    /// Absorption of the stem's wood `x` half widths from the axis over that without a knot [1].
    #[inline]
    pub fn stain(&self, offset: Vec2, x: f32) -> f32 {
        let (towards, strength, reach) = self.stain;
        let left = (1.0 - (x - 1.0).max(0.0) / reach).max(0.0);
        1.0 + strength * left * left * (0.5 + 0.5 * towards.dot(offset.normalize_or_zero()))
    }

    /// How much of a place, `offset` from the pith [mm], lies in a crack [1].
    #[inline]
    fn cracked(&self, offset: Vec2, half_width: f32) -> f32 {
        let mut most = 0.0_f32;
        for check in &self.checks {
            let ahead = offset.dot(check.direction);
            let share = ahead / (check.end * half_width);
            if !(0.0..1.0).contains(&share) {
                continue;
            }
            let taper = 1.0 - share * share;
            let half = 0.5 * taper * (check.width * half_width).min(CHECK_WIDTH[1]);
            let wander = CHECK_WANDER[0] * ahead * self.years.line(ahead / CHECK_WANDER[1]).0;
            let aside = (check.direction.perp_dot(offset) - wander).abs();
            most = most.max(1.0 - smoothstep(0.5 * half, 1.5 * half + 1.0e-3, aside));
        }
        most
    }
}

/// The cracks of a knot: none in most.
fn checks(stream: Stream, knots: &Knots) -> [Check; CHECKS] {
    let mut rng = stream.child("checks").rng();
    let mut share = || rng.random::<f32>();
    let is_cracked = f64::from(share()) < knots.crack_share;
    let (kind, first) = (share(), share());
    let count = 1 + CHECK_COUNTS.iter().filter(|&&least| kind >= least).count();
    std::array::from_fn(|i| {
        // About evenly around: a crack relieves the wood beside it.
        let turn = first + (i as f32 + 0.3 * (share() - 0.5)) / count as f32;
        let (length, width) = (share(), share());
        Check {
            direction: direction(turn),
            end: if is_cracked && i < count { between(CHECK_END, length) } else { 0.0 },
            width: CHECK_WIDTH[0] * (0.4 + 1.2 * width),
        }
    })
}

/// The direction at a share of a whole turn [1].
fn direction(share: f32) -> Vec2 {
    let (sin, cos) = libm::sincosf(std::f32::consts::TAU * share);
    Vec2::new(cos, sin)
}

fn between([from, to]: [f32; 2], share: f32) -> f32 {
    from + (to - from) * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wood::Wood;

    fn asked() -> Knots {
        Wood::from_values(&mut |p| p.default).knots
    }

    /// Logarithms of the absorption at places of the disc of a knot of 5 mm half width, even over the area.
    fn disc(inside: &KnotInside, from: f32, to: f32) -> Vec<f64> {
        let at = (0..400).map(|i| {
            let x = (from * from + (to * to - from * from) * (i as f32 + 0.5) / 400.0).sqrt();
            let unit = Vec2::from_angle(2.399_963 * i as f32);
            let offset = 5.0 * x * unit;
            let value = inside.absorption(offset, x, inside.circle(offset, x), -unit.y, 60.0);
            assert!(value > 0.0 && value.is_finite());
            f64::from(value).ln()
        });
        at.collect()
    }

    fn mean_sd(values: &[f64]) -> (f64, f64) {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt())
    }

    #[test]
    fn knots_vary_and_have_hearts_as_they_are_asked_to() {
        for (tone, heart) in [(0.0, 1.0), (0.7, 1.0), (0.3, 9.0)] {
            let knots = Knots { tone_log_sd: tone, heart_mu_a_ratio: heart, crack_share: 0.0, ..asked() };
            let (mut whole, mut hearts) = (Vec::new(), Vec::new());
            for index in 0..600 {
                let mut inside = KnotInside::grow(Stream::root(4).index(index), &knots);
                inside.pith = Vec2::ZERO;
                inside.compression = 0.0;
                let [rim, heart] = [[0.95, 1.0], [0.2, 0.25]].map(|[a, b]| mean_sd(&disc(&inside, a, b)).0);
                let left = 1.0 - smoothstep(0.0, inside.heart[1], 0.975) - HEART_HALF;
                whole.push(rim - f64::from(inside.heart[0] * left));
                hearts.push(heart - rim);
            }
            let ((_, spread), (gap, _)) = (mean_sd(&whole), mean_sd(&hearts));
            // Years add 0.2 to whole rims; 600 knots give the spread to 3 percent.
            assert!((spread - tone.hypot(0.22)).abs() < 0.06, "asked {tone}: {spread}");
            // From the circle 0.225 to 0.975 a heart that ends at 1 falls by 0.87 of its logarithm, on average by 0.82.
            assert!((gap - 0.82 * heart.ln()).abs() < 0.12, "asked {heart}: {gap}");
        }
    }

    #[test]
    fn years_are_circles_from_the_pith_to_the_outline() {
        for index in 0..50 {
            let inside = KnotInside::grow(Stream::root(7).index(index), &Knots { pith_shift: 0.5, ..asked() });
            assert!(inside.circle(inside.pith, inside.pith.length()) < 1.0e-3);
            for i in 0..40 {
                let unit = Vec2::from_angle(0.157 * i as f32);
                assert!((inside.circle(3.0 * unit, 1.0) - 1.0).abs() < 1.0e-4);
                let s = 0.025 * i as f32;
                let place = (1.0 - s) * inside.pith + s * unit;
                assert!((inside.circle(place, place.length()) - s).abs() < 1.0e-3);
            }
        }
    }

    #[test]
    fn as_many_knots_crack_as_are_asked_and_a_crack_is_a_dark_line() {
        let (mut cracked, mut dark) = (0, [0.0, 0.0]);
        for index in 0..1000 {
            let stream = Stream::root(9).index(index);
            let inside = KnotInside::grow(stream, &Knots { crack_share: 0.3, ..asked() });
            let whole = KnotInside::grow(stream, &Knots { crack_share: 0.0, ..asked() });
            assert!(!whole.is_cracked());
            let darker = disc(&inside, 0.0, 1.0).iter().zip(disc(&whole, 0.0, 1.0)).filter(|(a, b)| *a > b).count();
            cracked += usize::from(inside.is_cracked());
            dark[usize::from(inside.is_cracked())] += darker as f64 / 400.0;
        }
        // Four standard errors of a share of 0.3.
        assert!((cracked as f64 / 1000.0 - 0.3).abs() < 0.058, "{cracked} have cracked");
        let area = dark[1] / cracked as f64;
        assert!(dark[0] == 0.0 && (0.005..0.06).contains(&area), "a crack takes {area} of the area");
    }

    #[test]
    fn bark_keeps_its_mean_until_it_leaves_a_part_of_the_outline() {
        let around = |inside: &KnotInside| {
            let thick: Vec<f32> = (0..360).map(|i| inside.bark(Vec2::from_angle(i as f32 * 0.017_453))).collect();
            (thick.iter().sum::<f32>() / 360.0, thick.iter().filter(|&&bark| bark == 0.0).count())
        };
        for index in 0..40 {
            let stream = Stream::root(11).index(index);
            let (mean, open) = around(&KnotInside::grow(stream, &Knots { bark_uneven: 0.5, ..asked() }));
            // Roughness of 0.4 leaves the mean of some ten cells to 0.13 and a thin side open here and there.
            assert!((mean - 1.0).abs() < 0.5 && open < 120, "{mean}, {open} of 360 open");
        }
        let open = (0..200).filter(|&index| {
            let knots = Knots { bark_uneven: 1.5, ..asked() };
            around(&KnotInside::grow(Stream::root(11).index(index), &knots)).1 > 2
        });
        // Amplitudes are even from 0 to 3: two thirds leave some of the outline, and roughness of others.
        assert!((120..190).contains(&open.count()));
    }

    #[test]
    fn the_lower_side_is_darker_and_the_stem_stained_as_asked() {
        let inside = KnotInside { compression: 0.6, ..KnotInside::grow(Stream::root(1), &asked()) };
        let straight = KnotInside { compression: 0.0, ..inside };
        let at =
            |inside: &KnotInside, below: f32| inside.absorption(Vec2::new(0.0, -4.0 * below), 0.8, 0.8, below, 7.0);
        assert!((at(&inside, 1.0) / at(&straight, 1.0) - 1.48).abs() < 1.0e-3);
        assert_eq!(at(&inside, -1.0), at(&straight, -1.0));
        let stains = (0..400).map(|index| {
            let inside = KnotInside::grow(Stream::root(3).index(index), &Knots { stain_mu_a_ratio: 3.0, ..asked() });
            assert_eq!(inside.stain(Vec2::X, 1.85), 1.0);
            [Vec2::X, -Vec2::X].map(|side| f64::from(inside.stain(side, 1.0))).iter().sum::<f64>() / 2.0
        });
        // Half of the strength on average about the outline: 1 + 2 / 2; 400 draws give it to 0.03.
        assert!((mean_sd(&stains.collect::<Vec<_>>()).0 - 2.0).abs() < 0.12);
    }
}
