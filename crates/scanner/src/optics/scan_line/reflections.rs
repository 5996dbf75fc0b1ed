//! Reflections, mirror images of the line: laser light that a film's first surface throws back, and that falls on the
//! film elsewhere; and what foil shows of the film's lower side.
//!
//! Foil far below weak film mirrors to the lens what pigment has turned on its way down. That stands where the film's
//! line would as far below foil as it is above: a faint line of its own, in other rows than the film's and than the
//! foil's (`FilmStackSpread::mirrored`). Film that leans sends more or less there, by its angle to the lens' mirror
//! image, walls that the lens does not see too; the part that would meet foil beyond the pocket's end is cut off, and
//! what is left passes the film wherever the lens looks through it. Neglected: that a low wall lights foil far before
//! it, which rough foil shows.
//!
//! Walls: geometrical optics with one bounce: each column's light leaves in the mirror direction with Fresnel's share
//! (a quarter on a wall of 75 degrees), is followed to the next film, and lights it there as the laser lights the line.
//! The lens sees it where that place stands, off the laser plane. The light of neighbouring columns is spread evenly
//! between the places that they hit, so light is kept and caustics come out by themselves. Roughness alpha turns facets
//! by a slope of standard deviation alpha / sqrt(2) (Walter et al. 2007: the GGX law's core) and light by twice that,
//! which widens the image by sqrt(2) alpha times the way. Neglected: the tails of the GGX law, narrower spread across
//! the plane of incidence at a slant, mirror images of tablets and foil and of second bounces. What is lit answers with
//! the light that comes out within 0.32 mm, as the film of the line's own line in that column does.

use base::{Film, Surface};
use glam::Vec3;

use super::film::{entering_share, passes_from};
use super::view::{LineView, LitLine};
use crate::optics::light::Reflection;
use crate::specimen::{Hit, ReflectedHit};
use numerics::lanes::exp;
use transport::kernel::film_stack::{FilmStackSpread, mirrored_depth_mm, mirrored_view};
use transport::kernel::{BASIS, PACK_SPREAD_MM};

/// Square of the slope under which mirrored light rises too steeply to meet the body again: tan(39 deg)^2 [1].
const MIN_SLOPE2: f32 = 0.65;
/// Farthest way of mirrored light [mm].
const MAX_WAY_MM: f32 = 25.0;
/// Places on the sensor of neighbouring columns' light that count as torn apart [px].
const MAX_GAP_PX: f32 = 40.0;
/// Images of one column that are kept apart.
const MAX_IMAGES: usize = 4;
/// Rows within which images are one [px].
const MERGED_PX: f64 = 1.5;
/// Least part of a normal law that is told apart [1].
const LEAST_SHARE: f32 = 1e-3;
/// Deviations of a normal law beyond which nothing lies [1].
const FAR_OFF: f32 = 8.0;
/// Fixed widths that an image is seen with: up to 0.46 mm.
const NARROW_WIDTHS: usize = 5;

/// Where the light of one column lands.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Landing {
    /// On the sensor: column and row [px].
    place: [f32; 2],
    /// Variance along the columns and along the rows [px^2].
    variance: [f32; 2],
    electrons: f32,
}

/// Sums of the images of one column: light, light times row, times row^2 and times variance.
type ImageSums = [f64; 4];

/// Buffers in which images are made.
#[derive(Debug, Default)]
pub(crate) struct ReflectionScratch {
    landings: Vec<Option<Landing>>,
    /// What foil shows of each column's film.
    pub in_foil: Vec<Option<Landing>>,
    slots: Vec<[ImageSums; MAX_IMAGES]>,
}

impl ReflectionScratch {
    /// Foil shows nothing in any of `columns` columns.
    pub fn clear(&mut self, columns: usize) {
        self.in_foil.clear();
        self.in_foil.resize(columns, None);
    }

    /// Fills `reflections` with the mirror images of a line, by rising column.
    pub fn images(&mut self, lit: &LitLine<'_>, reflections: &mut Vec<Reflection>) {
        self.landings.clear();
        self.landings.extend((0..lit.hits.len()).map(|column| lit.landing(column)));
        self.draw(lit.view.faint, reflections);
    }

    /// Spreads the light of all landings over the columns.
    fn draw(&mut self, faint: f32, reflections: &mut Vec<Reflection>) {
        reflections.clear();
        for (landings, in_foil) in [(&self.landings, false), (&self.in_foil, true)] {
            let columns = landings.len();
            self.slots.resize(columns, [[0.0; 4]; MAX_IMAGES]);
            let (mut first, mut last) = (usize::MAX, 0);
            let at = |column: usize| landings.get(column).copied().flatten();
            for column in 0..columns {
                let Some(own) = at(column) else { continue };
                // Half of a column's light lies on either side of its middle.
                for other in [column.wrapping_sub(1), column + 1].map(at) {
                    let other = other.filter(|other| own.joins(other));
                    let end = other.map_or(own.place, |other| [0, 1].map(|i| 0.5 * (own.place[i] + other.place[i])));
                    let touched = deposit(&mut self.slots, &own, end);
                    (first, last) = (first.min(touched.start), last.max(touched.end));
                }
            }
            for column in first.min(last)..last {
                for [electrons, row, row2, variance] in std::mem::take(&mut self.slots[column]) {
                    if electrons <= 0.0 {
                        continue;
                    }
                    let (row, row2) = (row / electrons, row2 / electrons);
                    let variance = (variance / electrons + (row2 - row * row).max(0.0)) as f32;
                    let (row, electrons) = (row as f32, electrons as f32);
                    let reflection = Reflection { column, row, variance, electrons, in_foil };
                    if reflection.peak() > faint {
                        reflections.push(reflection);
                    }
                }
            }
        }
        reflections.sort_by_key(|reflection| reflection.column);
    }
}

/// Spreads half of a landing's light evenly over the columns between its place and `to`; the columns touched.
fn deposit(slots: &mut [[ImageSums; MAX_IMAGES]], own: &Landing, to: [f32; 2]) -> std::ops::Range<usize> {
    let from = own.place;
    let middle = 0.5 * (from[0] + to[0]);
    let step = to[0] - from[0];
    // A box of the variance that way and widening have together.
    let half = 0.5 * (step * step + 12.0 * own.variance[0]).sqrt().max(1e-3);
    let columns = slots.len();
    let start = ((middle - half + 0.5).floor().max(0.0) as usize).min(columns);
    let end = ((middle + half + 1.5).floor().max(0.0) as usize).min(columns).max(start);
    for column in start..end {
        let (low, high) = (column as f32 - 0.5, column as f32 + 0.5);
        let share = (high.min(middle + half) - low.max(middle - half)).max(0.0) / (2.0 * half);
        let along = if step.abs() > 1e-3 { ((column as f32 - from[0]) / step).clamp(0.0, 1.0) } else { 0.5 };
        let row = from[1] + (to[1] - from[1]) * along;
        let electrons = 0.5 * own.electrons * share;
        if electrons > 0.0 {
            add(&mut slots[column], electrons, row, own.variance[1]);
        }
    }
    start..end
}

/// Adds light to the slot that holds its rows, to a free one, or to the nearest.
fn add(slots: &mut [ImageSums; MAX_IMAGES], electrons: f32, row: f32, variance: f32) {
    let (electrons, row, variance) = (f64::from(electrons), f64::from(row), f64::from(variance));
    let off = |slot: &ImageSums| if slot[0] > 0.0 { (slot[1] / slot[0] - row).abs() } else { MERGED_PX };
    let nearest = (0..MAX_IMAGES).min_by(|&a, &b| off(&slots[a]).total_cmp(&off(&slots[b]))).unwrap_or(0);
    let slot = &mut slots[nearest];
    for (sum, value) in slot.iter_mut().zip([1.0, row, row * row, variance]) {
        *sum += electrons * value;
    }
}

/// What foil shows of the film of `hit`, which sends light to the `lens` like `spread`: of the light that is mirrored
/// about its image, what foil in the same pocket mirrors.
pub(crate) fn in_foil(
    hit: &Hit,
    film: &Film,
    spread: &FilmStackSpread,
    (normal, lens): (Vec3, Vec3),
    view: &LineView<'_>,
) -> Option<Landing> {
    let gap = film.gap_mm.filter(|_| spread.mirrored > 0.0 && hit.lit)?;
    let down = mirrored_view(film, lens);
    let depth = mirrored_depth_mm(&hit.matter.medium, film, lens);
    let [slope_x, slope_y] = film.under_slope;
    let at = Vec3::new(hit.x + 2.0 * gap * slope_x, 2.0 * gap * slope_y, hit.surface.z - depth);
    let sight = view.sight(hit.x, &Surface { z: at.z, slope_x, slope_y });
    let electrons = (-down.dot(normal)).max(0.0) * sight.electrons * spread.mirrored;
    if electrons < view.faint {
        return None;
    }
    let beside = gap * down.y / -down.z;
    let [before, behind] = film.room_mm;
    let [share, moved, narrowed] =
        normal_between([-before - beside, behind - beside].map(|end| end / spread.mirrored_mm));
    let sd_mm = spread.mirrored_mm * narrowed.sqrt();
    let moved = moved * spread.mirrored_mm;
    let on_foil = Vec3::new(hit.x, view.y, hit.surface.z) + down * (gap / -down.z) + Vec3::Y * moved;
    let mm2 = sd_mm * sd_mm;
    let variance = sight.variance + mm2 * sight.rows_per_mm * sight.rows_per_mm;
    let landing = Landing {
        place: view.place(at + Vec3::Y * moved),
        variance: [view.camera.along_variance(spread.mirrored_mm) + sight.defocus, variance],
        electrons: electrons * share,
    };
    // Spread over its rows it may be nothing.
    if landing.peak() < view.faint {
        return None;
    }
    let passes = passes_from(on_foil, hit, film, lens, view)?;
    Some(Landing { electrons: passes * landing.electrons, ..landing }).filter(|landing| landing.peak() > view.faint)
}

/// Of the normal law the share between two deviations, and the mean and the variance of what lies there; by Polya's
/// share (1945), within 0.01.
fn normal_between(ends: [f32; 2]) -> [f32; 3] {
    let ends = ends.map(|end| end.clamp(-FAR_OFF, FAR_OFF));
    let below = ends.map(|end| {
        let half = 0.5 * (1.0 - exp(-std::f32::consts::FRAC_2_PI * end * end)).max(0.0).sqrt();
        0.5 + half.copysign(end)
    });
    let density = ends.map(|end| 0.398_942_3 * exp(-0.5 * end * end));
    let share = (below[1] - below[0]).max(LEAST_SHARE);
    let mean = ((density[0] - density[1]) / share).clamp(ends[0], ends[1]);
    let edges = (ends[0] * density[0] - ends[1] * density[1]) / share;
    [share, mean, (1.0 + edges - mean * mean).clamp(LEAST_SHARE, 1.0)]
}

impl Landing {
    /// Light in its brightest row [e-].
    fn peak(&self) -> f32 {
        0.398_942_3 * self.electrons / self.variance[1].sqrt()
    }

    /// Whether light between this column and its neighbour lands between their places.
    fn joins(&self, other: &Self) -> bool {
        (0..2).all(|i| (self.place[i] - other.place[i]).abs() < MAX_GAP_PX)
    }
}

impl LitLine<'_> {
    /// Where the mirrored light of a column is seen.
    fn landing(&self, column: usize) -> Option<Landing> {
        let hit = &self.hits[column];
        let slope2 = hit.surface.slope_x * hit.surface.slope_x + hit.surface.slope_y * hit.surface.slope_y;
        let gloss = &hit.matter.medium.gloss;
        if slope2 < MIN_SLOPE2 || !hit.lit || hit.matter.film.is_none() || gloss.share == 0.0 {
            return None;
        }
        let LineView { specimen, camera, y, .. } = self.view;
        let source = self.view.sight(hit.x, &hit.surface);
        let normal = Vec3::new(-hit.surface.slope_x, -hit.surface.slope_y, 1.0).normalize();
        let thrown = gloss.share * (1.0 - entering_share(hit.matter.medium.n_eff, normal, -source.light));
        let way = source.light - normal * (2.0 * source.light.dot(normal));
        let from = Vec3::new(hit.x, y, hit.surface.z);
        let ReflectedHit { point: at, surface, .. } =
            specimen.reflected_hit(from, way, MAX_WAY_MM, y).filter(|hit| hit.seen)?;
        let place = self.view.place(at - Vec3::Y * y);
        let sight = camera.sight(at.x, at.z, surface.slope_y);
        let facing = Vec3::new(-surface.slope_x, -surface.slope_y, 1.0).normalize().dot(sight.view).max(0.0);
        let target = (place[0].round().max(0.0) as usize).min(self.hits.len() - 1);
        let (answer, spread) = self.answer(if self.hits[target].matter.film.is_some() { target } else { column });
        let rough = 0.5 * (gloss.roughness[0] + gloss.roughness[1]) * (at - from).length();
        let mm2 = 2.0 * rough * rough + spread;
        let rows = sight.rows_per_mm * sight.rows_per_mm;
        Some(Landing {
            place,
            variance: [camera.along_variance(mm2.sqrt()) + sight.defocus, sight.variance + mm2 * rows],
            electrons: source.electrons * thrown * answer * facing,
        })
    }

    /// What a film answers to light with, and the variance of where it comes out [mm^2].
    fn answer(&self, column: usize) -> (f32, f32) {
        let (mut sum, mut moment) = (0.0, 0.0);
        for j in 0..NARROW_WIDTHS.min(BASIS) {
            let weight = self.spread.enter[j][column] * self.spread.exit[j][column];
            sum += weight;
            moment += weight * PACK_SPREAD_MM[j] * PACK_SPREAD_MM[j];
        }
        (sum, if sum > 0.0 { moment / sum } else { 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    /// Light of 200 columns that a curved wall folds over itself: none is lost, and its middle stays where it is.
    #[test]
    fn images_keep_all_light() {
        let place = |c: f32| [400.0 + 0.03 * (c - 80.0) * (c - 80.0), 300.0 + 0.2 * c];
        let landings = (0..1000)
            .map(|column| {
                let electrons = 10.0 + column as f32;
                let landing = Landing { place: place(column as f32), variance: [2.0, 3.0], electrons };
                (column < 200 && column % 50 != 49).then_some(landing)
            })
            .collect();
        let mut scratch = ReflectionScratch { landings, ..ReflectionScratch::default() };
        let sums = |of: &mut dyn Iterator<Item = [f32; 3]>| {
            of.fold([0.0f64; 3], |sum, [electrons, column, row]| {
                let e = f64::from(electrons);
                [sum[0] + e, sum[1] + e * f64::from(column), sum[2] + e * f64::from(row)]
            })
        };
        let sent = sums(&mut scratch.landings.iter().flatten().map(|l| [l.electrons, l.place[0], l.place[1]]));
        let mut reflections = Vec::new();
        scratch.draw(0.0, &mut reflections);
        let seen = sums(&mut reflections.iter().map(|s| [s.electrons, s.column as f32, s.row]));
        assert!((seen[0] / sent[0] - 1.0).abs() < 1e-4, "light {seen:?} of {sent:?}");
        let middle = [1, 2].map(|i| seen[i] / seen[0] - sent[i] / sent[0]);
        assert!(middle[0].abs() < 1.0 && middle[1].abs() < 0.1, "its middle moved by {middle:?} px");
        assert!(reflections.windows(2).all(|pair| pair[0].column <= pair[1].column), "columns rise");
        // A second line of the same scratch starts dark.
        scratch.landings.fill(None);
        scratch.draw(0.0, &mut reflections);
        assert_eq!(reflections, []);
    }

    /// Parts of the normal law between ends drawn at random, infinite ones too: share, mean and variance against sums.
    #[test]
    fn parts_of_the_normal_law_are_those_of_sums() {
        let mut rng = base::Stream::root(54).rng();
        for i in 0..200 {
            let (low, width) = (rng.random_range(-3.0..1.5f32), rng.random_range(0.3..4.0f32));
            let ends = if i % 5 == 0 { [low, f32::INFINITY] } else { [low, low + width] };
            let steps = 4000;
            let mut sums = [0.0f64; 3];
            for k in 0..steps {
                let at = -6.0 + 12.0 * (f64::from(k) + 0.5) / f64::from(steps);
                let weight = libm::exp(-0.5 * at * at) / (2.0 * std::f64::consts::PI).sqrt() * 12.0 / f64::from(steps);
                if at > f64::from(ends[0]) && at < f64::from(ends[1]) {
                    sums = [sums[0] + weight, sums[1] + weight * at, sums[2] + weight * at * at];
                }
            }
            let [share, mean, variance] = normal_between(ends).map(f64::from);
            let truth = sums[1] / sums[0];
            assert!((share - sums[0]).abs() < 0.01, "{ends:?}: {share} for {}", sums[0]);
            // What a part of less is like moves next to no light.
            let spread = sums[2] / sums[0] - truth * truth;
            let near = (mean - truth).abs() < 0.1 && (variance - spread).abs() < 0.15;
            assert!(sums[0] < 0.1 || near, "{ends:?}: {mean} and {variance} for {truth} and {spread}");
        }
    }
}
