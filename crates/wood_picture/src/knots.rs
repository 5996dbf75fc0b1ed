//! Knots in a picture: dark ellipses on clear wood, and how their branches lean.
//!
//! Model: light over that of the clear wood around it ([`crate::background`]), in cells of 0.3 mm under a Gaussian of
//! 0.5 mm, is cut at levels from 0.3 to 0.9. A patch below a level is a knot where it fills the ellipse of its moments
//! and is darker inside than outside all around, as far as the picture shows it (a closed contour; bands of latewood
//! are open or fill no ellipse). It has a dark core or much contrast (stains have neither), is wide enough, and does
//! not lie along the grain as resin pockets, cracks and the pith do. Of patches that overlap, the one with the most
//! contrast whose level lies midway between inside and outside stays; it is then cut at midway itself, where blur does
//! not move an outline. Of a knot that the picture's edge cuts the ellipse is that of the part that is seen. Lean: a
//! round branch cut at the angle `dive` to its axis shows an ellipse with minor / major = sin(dive), its major axis
//! along the lean. Outlines wobble; an elongation e = 1 - minor / major counts as sqrt(e^2 - 0.07^2). Which end leans
//! out: away from the pith, where rings follow each other more closely (across), and to the lower side of the branch,
//! which compression wood makes darker (along; branches of the scanned log of Larsson et al. 2022 droop by 10 degrees).
//! Dead is what is dark as a whole or has the black of bark or of a hole in it. Limits: two that touch are one or none;
//! rot in round patches is a knot. Levels, shares and cues are engineering estimates, tested on boards of `procedural`
//! and on twenty photographs.

use std::f32::consts::PI;

use glam::{Mat2, Vec2, Vec3};

use crate::background::evened;
use crate::components::flood;
use crate::orientation::wrap;
use crate::raster::{Beyond, around, quantile, smooth};
use crate::texture::Cells;

/// Side of the cells [mm].
const CELL_MM: f32 = 0.3;
/// Gaussian over them [mm]: fibres vanish, the smallest knots stay.
const BLUR_MM: f32 = 0.5;
/// Levels over the median light [1]: bark lies at 0.1, dead knots at 0.3, sound ones at 0.5 to 0.75, wide latewood at
/// 0.85.
const LEVELS: [f32; 13] = [0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9];
/// Least part of the ellipse of its moments that a patch fills [1]: an ellipse has 1, an arc 0.6.
const LEAST_FILL: f32 = 0.8;
/// Longest ellipse over its width [1]: dives under 12 degrees, spike knots, are found where an edge cuts them.
const MOST_ASPECT: f32 = 5.0;
/// Places around the contour that are looked at.
const CONTOUR: usize = 48;
/// Where inside and outside are looked at, in half axes [1].
const INSIDE_OUTSIDE: [f32; 2] = [0.65, 1.35];
/// Share of the contour that must be darker inside by a third of the contrast [1].
const LEAST_CLOSED: f32 = 0.8;
/// Least difference of light between outside and inside over clear wood's [1].
const LEAST_CONTRAST: f32 = 0.25;
/// With less contrast than this, the darkest twentieth of a knot has less light than that [1]: stains have no core.
const SURE_CONTRAST: f32 = 0.3;
const DARK: f32 = 0.55;
/// Below this light over clear wood's a knot is dead [1]: sound ones of the class table have 0.52, dead ones 0.27.
const DEAD: f32 = 0.4;
/// The same of the darkest twentieth of it: bark and cracks around a branch that had died [1].
const DEAD_RIM: f32 = 0.12;
/// A level this far from midway between inside and outside, over half of the contrast, is no outline's [1].
const MOST_OFF: f32 = 0.6;
/// Clear wood around whose mean light counts [mm].
const AROUND_MM: f32 = 10.0;
/// Resin pockets, pith and cracks lie along the grain: within this of it and so much longer than wide [rad], [1].
const ALONG_RAD: f32 = 0.52;
const ALONG_ASPECT: f32 = 2.2;
/// Least places of a contour that lie in the picture [1].
const LEAST_SEEN: usize = CONTOUR / 4;
/// Elongation of an upright knot by its outline's wobble [1]: harmonics of 3.5 % of the radius in all, the oval the
/// largest.
const WOBBLE: f32 = 0.07;
/// Reach of the look at rings on both sides of a knot [mm].
const RINGS_MM: f32 = 15.0;
/// Least cells of clear wood on a side: 50 square mm.
const LEAST_BESIDE: usize = 500;

/// A knot that a picture shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureKnot {
    /// Its middle from the picture's corner at row 0, column 0: across (x) and down the rows (y) [mm].
    pub centre_mm: Vec2,
    /// Half length and half width of its outline [mm].
    pub half_axes_mm: [f32; 2],
    /// Azimuth of the outline's length, from y towards x [rad].
    pub azimuth_rad: f32,
    /// The branch's axis outwards; its x and y are of the picture, z out of the face [1].
    pub axis: Vec3,
    /// How sure the end is that leans out, from 0 (guessed) to 1 [1].
    pub end_confidence: f32,
    /// Light in it over that of clear wood [1].
    pub brightness: f32,
    /// It had died: darker than a living branch can be.
    pub dead: bool,
}

impl PictureKnot {
    /// A place [mm] in half axes from the middle: 1 on the outline [1].
    pub fn within(&self, place: Vec2) -> f32 {
        (self.to_circle() * (place - self.centre_mm)).length()
    }

    /// From mm off the middle to the circle that the outline becomes.
    pub(crate) fn to_circle(self) -> Mat2 {
        let long = direction(self.azimuth_rad);
        let [a, b] = self.half_axes_mm;
        // Rows are the long and the short axis over their lengths.
        Mat2::from_cols(Vec2::new(long.x / a, -long.y / b), Vec2::new(long.y / a, long.x / b))
    }

    /// Angle between the branch's axis and the face [rad].
    pub fn dive_rad(&self) -> f32 {
        libm::asinf(self.axis.z.clamp(0.0, 1.0))
    }
}

/// Direction of an azimuth, (x, y) [1].
pub(crate) fn direction(azimuth: f32) -> Vec2 {
    let (sin, cos) = libm::sincosf(azimuth);
    Vec2::new(sin, cos)
}

/// Azimuth of a direction in (-pi, pi] [rad].
pub(crate) fn azimuth(direction: Vec2) -> f32 {
    base::atan2(direction.x, direction.y)
}

/// A patch below a level.
struct LevelPatch {
    centre: Vec2,
    half_axes: [f32; 2],
    azimuth: f32,
    inside: f32,
    outside: f32,
    score: f32,
}

/// Light of a picture in cells over its median.
struct Ground {
    cells: Cells,
    light: Vec<f32>,
}

impl Ground {
    fn at(&self, place: Vec2) -> f32 {
        around(self.cells.size, self.cells.at(place)).iter().map(|&(i, w)| w * self.light[i]).sum()
    }
}

/// Knots at least `least_mm` wide in a board whose grain has the azimuth `length_rad`, by their place down the picture.
pub(crate) fn find(
    light: &[f32],
    size: [usize; 2],
    pixel_mm: [f32; 2],
    length_rad: f32,
    least_mm: f32,
) -> Vec<PictureKnot> {
    let ground = ground(&evened(light, size, pixel_mm, AROUND_MM), size, pixel_mm);
    let mut patches: Vec<LevelPatch> = LEVELS.iter().flat_map(|&level| patches(&ground, level, least_mm)).collect();
    patches.retain(|patch| {
        let off = wrap(patch.azimuth - length_rad).abs();
        off > ALONG_RAD || patch.half_axes[0] < ALONG_ASPECT * patch.half_axes[1]
    });
    patches.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut kept: Vec<LevelPatch> = Vec::new();
    for patch in patches {
        let apart = |other: &LevelPatch| {
            let reach = other.half_axes[0].max(patch.half_axes[0]);
            other.centre.distance(patch.centre) > reach
        };
        if kept.iter().all(apart) {
            kept.push(patch);
        }
    }
    for patch in &mut kept {
        let midway = 0.5 * (patch.inside + patch.outside);
        let near = |other: &LevelPatch| other.centre.distance(patch.centre) < 0.5 * patch.half_axes[1];
        if let Some(better) = crate::knots::patches(&ground, midway, least_mm).into_iter().find(near) {
            *patch = better;
        }
    }
    kept.sort_by(|a, b| a.centre.y.total_cmp(&b.centre.y));
    kept.iter().map(|patch| knot(&ground, patch, &kept)).collect()
}

/// Means of light over cells, blurred, over their median.
fn ground(light: &[f32], [rows, cols]: [usize; 2], pixel_mm: [f32; 2]) -> Ground {
    let cells = Cells::with_side([rows, cols], pixel_mm, CELL_MM);
    let (mut sums, mut counts) = (vec![0.0_f32; cells.count()], vec![0.0_f32; cells.count()]);
    for (i, value) in light.iter().enumerate() {
        let cell = cells.of([i / cols, i % cols], pixel_mm);
        sums[cell] += value;
        counts[cell] += 1.0;
    }
    let mut mean: Vec<f32> = sums.iter().zip(&counts).map(|(sum, count)| sum / count.max(1.0)).collect();
    // The last row and column may hold less than a pixel.
    let [_, wide] = cells.size;
    for cell in (0..cells.count()).filter(|&cell| counts[cell] == 0.0) {
        let inner = if cell % wide + 1 == wide && cell >= 1 && counts[cell - 1] > 0.0 {
            cell - 1
        } else {
            cell.saturating_sub(wide)
        };
        mean[cell] = mean[inner];
    }
    let mut light = smooth(&mean, cells.size, [BLUR_MM / cells.side_mm; 2], Beyond::Same);
    let clear = quantile(&mut light.clone(), 0.5).max(f32::MIN_POSITIVE);
    light.iter_mut().for_each(|value| *value /= clear);
    Ground { cells, light }
}

/// Patches below a level that could be knots.
fn patches(ground: &Ground, level: f32, least_mm: f32) -> Vec<LevelPatch> {
    let [rows, cols] = ground.cells.size;
    let mut seen = vec![false; rows * cols];
    let mut found = Vec::new();
    let least_area = 0.25 * PI * least_mm * least_mm;
    for start in 0..rows * cols {
        if seen[start] || ground.light[start] >= level {
            continue;
        }
        seen[start] = true;
        let patch = flood(start, [rows, cols], |cell| {
            let is_new = !seen[cell] && ground.light[cell] < level;
            seen[cell] |= is_new;
            is_new
        });
        let (mut low, mut high) = ([rows, cols], [0, 0]);
        for (row, col) in patch.iter().map(|cell| (cell / cols, cell % cols)) {
            (low, high) = ([low[0].min(row), low[1].min(col)], [high[0].max(row), high[1].max(col)]);
        }
        if patch.len() as f32 * ground.cells.side_mm.powi(2) >= least_area {
            let filled = filled(&patch, cols, low, high);
            found.extend(shaped(ground, &filled, level, least_mm));
        }
    }
    found
}

/// A patch with its holes.
fn filled(patch: &[usize], cols: usize, low: [usize; 2], high: [usize; 2]) -> Vec<usize> {
    // A frame of one cell around the patch, from which what lies outside is reached.
    let [tall, wide] = [high[0] - low[0] + 3, high[1] - low[1] + 3];
    let mut taken = vec![false; tall * wide];
    for &cell in patch {
        taken[(cell / cols - low[0] + 1) * wide + cell % cols - low[1] + 1] = true;
    }
    let mut reached = taken.clone();
    reached[0] = true;
    flood(0, [tall, wide], |cell| !std::mem::replace(&mut reached[cell], true));
    let in_it = |&i: &usize| taken[i] || !reached[i];
    (0..tall * wide).filter(in_it).map(|i| (i / wide + low[0] - 1) * cols + i % wide + low[1] - 1).collect()
}

/// The ellipse of a patch's moments, where the patch is one and is darker than what lies around it.
fn shaped(ground: &Ground, patch: &[usize], level: f32, least_mm: f32) -> Option<LevelPatch> {
    let n = patch.len() as f32;
    let centre = patch.iter().map(|&cell| ground.cells.middle(cell)).sum::<Vec2>() / n;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for &cell in patch {
        let d = ground.cells.middle(cell) - centre;
        (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
    }
    // A cell is no point: it has a twelfth of its side's square.
    let own = ground.cells.side_mm.powi(2) / 12.0;
    let (xx, xy, yy) = (xx / n + own, xy / n, yy / n + own);
    let (mean, half) = (0.5 * (xx + yy), libm::hypotf(0.5 * (yy - xx), xy));
    // An ellipse has a quarter of a half axis' square.
    let half_axes = [2.0 * (mean + half).sqrt(), 2.0 * (mean - half).max(own).sqrt()];
    let azimuth = 0.5 * base::atan2(2.0 * xy, yy - xx);
    let fill = n * ground.cells.side_mm.powi(2) / (PI * half_axes[0] * half_axes[1]);
    if fill < LEAST_FILL || half_axes[0] > MOST_ASPECT * half_axes[1] || 2.0 * half_axes[1] < least_mm {
        return None;
    }
    let (long, short) = (direction(azimuth), direction(azimuth).perp());
    let mut around = Vec::with_capacity(CONTOUR);
    let extent = ground.cells.side_mm * Vec2::new(ground.cells.size[1] as f32, ground.cells.size[0] as f32);
    for i in 0..CONTOUR {
        let (sin, cos) = libm::sincosf(2.0 * PI * i as f32 / CONTOUR as f32);
        let places =
            INSIDE_OUTSIDE.map(|part| centre + part * (half_axes[0] * cos * long + half_axes[1] * sin * short));
        if places.iter().all(|place| place.cmpgt(Vec2::ZERO).all() && place.cmplt(extent).all()) {
            around.push(places.map(|place| ground.at(place)));
        }
    }
    if around.len() < LEAST_SEEN {
        return None;
    }
    let seen = around.len() as f32;
    let [inside, outside] = [0, 1].map(|i| around.iter().map(|pair| pair[i]).sum::<f32>() / seen);
    let contrast = outside - inside;
    let closed = around.iter().filter(|[inside, outside]| outside - inside > contrast / 3.0).count() as f32;
    let mut lights: Vec<f32> = patch.iter().map(|&cell| ground.light[cell]).collect();
    let is_dark = contrast > SURE_CONTRAST || quantile(&mut lights, 0.05) < DARK;
    if !is_dark || contrast < LEAST_CONTRAST || closed < LEAST_CLOSED * seen {
        return None;
    }
    let off = 2.0 * (level - 0.5 * (inside + outside)).abs() / contrast;
    if off > MOST_OFF {
        return None;
    }
    let score = contrast * half_axes[1] * (1.0 - off).max(0.1);
    Some(LevelPatch { centre, half_axes, azimuth, inside, outside, score })
}

/// The knot of a patch: how it leans, and to which end.
fn knot(ground: &Ground, patch: &LevelPatch, all: &[LevelPatch]) -> PictureKnot {
    let [a, b] = patch.half_axes;
    let mut knot = PictureKnot {
        centre_mm: patch.centre,
        half_axes_mm: patch.half_axes,
        azimuth_rad: patch.azimuth,
        axis: Vec3::Z,
        end_confidence: 0.0,
        brightness: 0.0,
        dead: false,
    };
    let elongation = 1.0 - b / a;
    let elongation = (elongation * elongation - WOBBLE * WOBBLE).max(0.0).sqrt();
    let sine = 1.0 - elongation;
    let mut long = direction(patch.azimuth);
    let mut lights = Vec::new();
    // Slope of the light along y over the knot, in its light a half length.
    let (mut slope, mut squares) = (0.0, 0.0);
    for cell in 0..ground.cells.count() {
        let place = ground.cells.middle(cell);
        let off = knot.to_circle() * (place - knot.centre_mm);
        if off.length_squared() < 0.64 {
            let y = (place.y - knot.centre_mm.y) / a;
            lights.push(ground.light[cell]);
            slope += y * ground.light[cell];
            squares += y * y;
        }
    }
    if !lights.is_empty() {
        knot.brightness = quantile(&mut lights, 0.5);
        knot.dead = knot.brightness < DEAD || quantile(&mut lights, 0.05) < DEAD_RIM;
        let darker = -slope / squares.max(f32::MIN_POSITIVE) / knot.brightness.max(f32::MIN_POSITIVE);
        let rings = rings_beside(ground, patch, all);
        // A tenth of the light over a half length, or half as much ring again on one side, is sure.
        let cue = long.y * (darker / 0.1).clamp(-1.0, 1.0) + 1.5 * long.x * (rings / 0.4).clamp(-1.0, 1.0);
        if cue < 0.0 {
            long = -long;
        }
        knot.end_confidence = cue.abs().min(1.0);
    }
    knot.axis = ((1.0 - sine * sine).max(0.0).sqrt() * long).extend(sine);
    knot
}

/// Logarithm of the rings' frequency squared at larger x over that at smaller x beside a knot [1].
fn rings_beside(ground: &Ground, patch: &LevelPatch, all: &[LevelPatch]) -> f32 {
    let [rows, cols] = ground.cells.size;
    let side = |sign: f32| {
        // Squares of slopes and of departures from the mean of a row's stretch: their ratio goes with frequency
        // squared.
        let (mut slopes, mut squares, mut seen) = (0.0_f32, 0.0_f32, 0);
        for row in 0..rows {
            let stretch: Vec<usize> = (1..cols - 1)
                .map(|col| row * cols + col)
                .filter(|&cell| {
                    let place = ground.cells.middle(cell);
                    let beside = sign * (place.x - patch.centre.x) - patch.half_axes[0];
                    (1.0..1.0 + RINGS_MM).contains(&beside)
                        && all.iter().all(|other| other.centre.distance(place) > 2.0 * other.half_axes[0])
                })
                .collect();
            let mean = stretch.iter().map(|&cell| ground.light[cell]).sum::<f32>() / stretch.len().max(1) as f32;
            for &cell in &stretch {
                slopes += (ground.light[cell + 1] - ground.light[cell - 1]).powi(2);
                squares += (ground.light[cell] - mean).powi(2);
            }
            seen += stretch.len();
        }
        (seen > LEAST_BESIDE && squares > 0.0).then(|| slopes / squares)
    };
    match (side(1.0), side(-1.0)) {
        (Some(more), Some(less)) if more > 0.0 && less > 0.0 => libm::logf(more / less),
        _ => 0.0,
    }
}
