//! The absorption map: how much light the wood takes up, at the face and below it.
//!
//! Model: the wood's own tone ([`crate::tone`]) over the mean of clear wood, times the mean reflectance of earlywood
//! and latewood of the stated media by their shares, is the pixel's own diffuse reflectance (the median would be
//! earlywood's alone). Stains and gloss that are not clear wood count in that mean by no more than a quarter. The
//! absorption that has it follows from [`HalfSpace`], with the scattering of clear wood's mean outside of knots and of
//! knot wood in them, and the dive of the fibre map: steep fibres lead light down and darken without any absorption.
//! Below the face (an assumption, no measurement): a feature of width w lasts to a depth of about w, so that at depth d
//! the logarithm of absorption is that of the face under a Gaussian of standard deviation d / 2. In a knot the colour
//! of the face follows the branch's axis and does not fade. Sources: docs/theory/physics.md for the reflectance,
//! docs/theory/wood.md for the media. Limits: scattering that differs from the mean counts as absorption; light spreads
//! by a millimetre below the face, so that fine streaks are stronger in the wood than in the picture. Light that
//! changes over centimetres by a fifth is that of lamps and is taken off. Nothing is paler than half of earlywood's
//! absorption. Light that is brighter than that by more than a tenth is that of gloss or torn fibres: the farther
//! beyond, the less it is believed, down to clear wood's mean (a redescending function, Hampel 1974).

use base::Medium;
use glam::Vec2;
use procedural::wood::Media;

use crate::background::evened;
use crate::raster::{Beyond, around, quantile, smooth};
use crate::{FibreMap, HalfSpace, PictureAnalysis, PictureFault, picture, tone};

/// Steps of the dive from 0 to 90 degrees [deg].
const DIVE_STEP_DEG: f32 = 2.0;
/// Entries of the inverse over reflectances from 0 to 1.
const ENTRIES: usize = 1024;
/// Least absorption that is told over earlywood's [1].
const PALEST: f64 = 0.5;
/// Light over clear wood's beyond the palest wood's that counts as the palest wood's [1]; brighter is gloss, or torn
/// fibres.
const BRIGHTER: f32 = 0.1;
/// Spread of the middle nine tenths of lamps over their median that is no longer even [1]: the tone of even boards
/// wanders by as much.
const UNEVEN: f32 = 0.2;
/// Clear wood around whose light is that of the lamps [mm].
const LAMPS_MM: f32 = 10.0;
/// Depths of the levels [mm]; light of 660 nm goes a millimetre or two deep.
const DEPTHS_MM: [f32; 5] = [0.0, 0.5, 1.0, 2.0, 4.0];
/// All of them.
pub(crate) const LEVELS: usize = DEPTHS_MM.len();
/// Standard deviation of the Gaussian over the depth [1].
const FADING: f32 = 0.5;
/// Fibres that dive less are flat [rad]: 3 degrees, which darken by under 1 %.
const FLAT_RAD: f32 = 0.05;
/// Light of clear wood over its median [1]: latewood has 0.83 of earlywood; stains, checks and glints lie beyond.
const CLEAR: [f32; 2] = [0.75, 1.25];
/// Flattest branch that is followed: its slope in the face over its depth [1].
const STEEPEST_SHEAR: f32 = 4.0;

/// Absorption of a board at its face and below.
#[derive(Debug, Clone, PartialEq)]
pub struct AbsorptionMap {
    /// Rows and columns.
    pub size: [usize; 2],
    /// Size of a pixel, down and across [mm].
    pub pixel_mm: [f32; 2],
    /// At the face, `[rows, cols]` [mm^-1].
    pub mu_a_per_mm: Vec<f32>,
    /// Logarithm of clear wood's absorption at [`DEPTHS_MM`], over knots filled from beside them.
    levels: Vec<Vec<f32>>,
    pub(crate) knots: Vec<crate::PictureKnot>,
}

impl AbsorptionMap {
    /// At a place (x, y) from the picture's corner and a depth below the face [mm] [mm^-1].
    pub fn at(&self, place: Vec2, depth_mm: f32) -> f32 {
        let read = |values: &[f32], place: Vec2| -> f32 {
            let at = [place.y / self.pixel_mm[0] - 0.5, place.x / self.pixel_mm[1] - 0.5];
            around(self.size, at).iter().map(|&(i, weight)| weight * values[i]).sum()
        };
        if let Some((_, foot)) = self.branch(place, depth_mm) {
            return read(&self.mu_a_per_mm, foot);
        }
        // Right at the face knots' rims are as they are seen.
        if depth_mm <= 0.0 {
            return read(&self.mu_a_per_mm, place);
        }
        let last = DEPTHS_MM.len() - 1;
        let above = DEPTHS_MM.iter().rposition(|&level| level <= depth_mm).unwrap_or(0).min(last - 1);
        let share = ((depth_mm - DEPTHS_MM[above]) / (DEPTHS_MM[above + 1] - DEPTHS_MM[above])).clamp(0.0, 1.0);
        libm::expf((1.0 - share) * read(&self.levels[above], place) + share * read(&self.levels[above + 1], place))
    }
}

impl AbsorptionMap {
    /// The knot whose branch a place at a depth lies in, by its number, and where its axis through there meets the face
    /// [mm].
    pub(crate) fn branch(&self, place: Vec2, depth_mm: f32) -> Option<(usize, Vec2)> {
        self.knots.iter().enumerate().find_map(|(number, knot)| {
            let shear = knot.axis.truncate() / knot.axis.z.max(1.0e-3);
            let foot = place + depth_mm * shear.clamp_length_max(STEEPEST_SHEAR);
            let is_near = foot.distance(knot.centre_mm) < knot.half_axes_mm[0];
            (is_near && knot.within(foot) < 1.0).then_some((number, foot))
        })
    }

    /// At the face alone [mm^-1].
    pub(crate) fn on_face(&self, place: Vec2) -> f32 {
        let at = [place.y / self.pixel_mm[0] - 0.5, place.x / self.pixel_mm[1] - 0.5];
        around(self.size, at).iter().map(|&(i, weight)| weight * self.mu_a_per_mm[i]).sum()
    }
}

/// Half spaces of one medium at all dives, each turned about: absorption over reflectance.
struct Inverse {
    tables: Vec<Vec<f32>>,
    least: f32,
}

impl Inverse {
    fn new(medium: &Medium, least: f32) -> Self {
        let steps = (90.0 / DIVE_STEP_DEG) as usize;
        let table = |step: usize| {
            let space = HalfSpace::new(medium, (step as f32 * DIVE_STEP_DEG).to_radians());
            (0..=ENTRIES).map(|i| space.absorption(i as f64 / ENTRIES as f64) as f32).collect()
        };
        Self { tables: (0..=steps).map(table).collect(), least }
    }

    fn at(&self, reflectance: f32, dive_rad: f32) -> f32 {
        let step = (dive_rad.abs().to_degrees() / DIVE_STEP_DEG).clamp(0.0, (self.tables.len() - 1) as f32);
        let below = (step as usize).min(self.tables.len() - 2);
        let place = [step, reflectance.clamp(0.0, 1.0) * ENTRIES as f32];
        let entry = (place[1] as usize).min(ENTRIES - 1);
        let (v, u) = (step - below as f32, place[1] - entry as f32);
        let line = |table: &[f32]| table[entry] + u * (table[entry + 1] - table[entry]);
        ((1.0 - v) * line(&self.tables[below]) + v * line(&self.tables[below + 1])).max(self.least)
    }
}

/// Absorption of the board in a picture whose fibres are known: `grey` and `settings` as of [`crate::fibre_map`];
/// `latewood_share` is the mean share of latewood in a ring, `log.latewood_share` of recipes [1].
///
/// # Errors
/// Those of the picture itself, and a size other than the fibre map's.
pub fn absorption_map(
    grey: &[f32],
    fibres: &FibreMap,
    media: &Media,
    latewood_share: f64,
    settings: &PictureAnalysis,
) -> Result<AbsorptionMap, PictureFault> {
    Ok(absorption_of(&relative_light(grey, fibres, settings)?, fibres, media, latewood_share, LEVELS))
}

/// The same at the face alone, which takes a third of the memory, `[rows, cols]` [mm^-1], and the share of the pixels
/// that are brighter than wood [1].
///
/// # Errors
/// As [`absorption_map`].
pub fn face_absorption(
    grey: &[f32],
    fibres: &FibreMap,
    media: &Media,
    latewood_share: f64,
    settings: &PictureAnalysis,
) -> Result<(Vec<f32>, f64), PictureFault> {
    let light = relative_light(grey, fibres, settings)?;
    let face = FaceLaw::new(media, latewood_share);
    let glossy = light.iter().filter(|light| **light > face.most).count() as f64 / light.len() as f64;
    Ok((face.absorption(&light, &inside(fibres), fibres), glossy))
}

/// Light of the wood in a picture over the mean of clear wood [1].
pub(crate) fn relative_light(
    grey: &[f32],
    fibres: &FibreMap,
    settings: &PictureAnalysis,
) -> Result<Vec<f32>, PictureFault> {
    let inside = inside(fibres);
    let tone = tone::of_wood(&picture::light(grey, fibres.size, fibres.pixel_mm, settings)?, fibres, &inside);
    let mut light = without_lamps(tone, fibres);
    let mean = clear_light(&light, fibres, &inside).max(f64::MIN_POSITIVE);
    light.iter_mut().for_each(|light| *light = (f64::from(*light) / mean) as f32);
    Ok(light)
}

/// Light without what uneven lamps do to it, where they are uneven.
fn without_lamps(light: Vec<f32>, fibres: &FibreMap) -> Vec<f32> {
    let even = evened(&light, fibres.size, fibres.pixel_mm, LAMPS_MM);
    // Every hundredth pixel is enough for quantiles.
    let mut lamps: Vec<f32> = light.iter().zip(&even).step_by(97).map(|(light, even)| light / even).collect();
    lamps.retain(|lamp| lamp.is_finite());
    if lamps.is_empty() {
        return light;
    }
    let [low, middle, high] = [0.05, 0.5, 0.95].map(|part| quantile(&mut lamps, part));
    if high - low > UNEVEN * middle { even } else { light }
}

/// Mean light of clear wood [1].
fn clear_light(light: &[f32], fibres: &FibreMap, inside: &[bool]) -> f64 {
    // Where fibres dive light is led down: only flat ones say how bright clear wood is.
    let flat = |pixel: usize| !inside[pixel] && fibres.dive_rad[pixel].abs() < FLAT_RAD;
    let mut clear_light = Vec::with_capacity(light.len());
    clear_light.extend((0..light.len()).filter(|&pixel| flat(pixel)).map(|pixel| light[pixel]));
    if clear_light.is_empty() {
        clear_light.extend_from_slice(light);
    }
    let median = quantile(&mut clear_light, 0.5);
    let [low, high] = CLEAR.map(|part| part * median);
    clear_light.iter().map(|light| f64::from(light.clamp(low, high))).sum::<f64>() / clear_light.len() as f64
}

/// Which pixels lie in knots.
fn inside(fibres: &FibreMap) -> Vec<bool> {
    let [rows, cols] = fibres.size;
    let mut inside = vec![false; rows * cols];
    for knot in &fibres.knots {
        // The pixels of the box about its outline, and one more on each side.
        let span = |middle: f32, pixel: f32, count: usize| {
            let [low, high] = [-1.0, 1.0].map(|side| (middle + side * knot.half_axes_mm[0]) / pixel);
            ((low - 1.0).max(0.0) as usize).min(count)..((high + 2.0).max(0.0) as usize).min(count)
        };
        let across = span(knot.centre_mm.x, fibres.pixel_mm[1], cols);
        for row in span(knot.centre_mm.y, fibres.pixel_mm[0], rows) {
            for pixel in across.clone().map(|col| row * cols + col) {
                inside[pixel] |= knot.within(fibres.place_mm(pixel)) < 1.0;
            }
        }
    }
    inside
}

/// The mean of clear wood, and knot wood, whose scattering pictures are held to.
pub(crate) fn means(media: &Media, latewood_share: f64) -> [Medium; 2] {
    let mean = |ratio: f64| (1.0 - latewood_share) + latewood_share * ratio;
    let medium = |sigma_i: f64, k: f64, n_eff: f64| Medium {
        mu_a: (media.earlywood_mu_a_per_mm * mean(media.latewood_mu_a_ratio)) as f32,
        sigma_i: sigma_i as f32,
        k: k as f32,
        n_eff: n_eff as f32,
        ..Medium::CLEAR_WOOD
    };
    let (sigma_i, k) = (media.earlywood_sigma_i_per_mm, media.earlywood_k_per_mm);
    [
        medium(sigma_i * mean(media.latewood_sigma_i_ratio), k * mean(media.latewood_k_ratio), media.clear_n_eff),
        medium(sigma_i * media.knot_sigma_i_ratio, k * media.knot_k_ratio, media.knot_n_eff),
    ]
}

/// Absorption from light over the mean of clear wood, with so many levels of depth.
pub(crate) fn absorption_of(
    light: &[f32],
    fibres: &FibreMap,
    media: &Media,
    latewood_share: f64,
    count: usize,
) -> AbsorptionMap {
    let inside = inside(fibres);
    let mu_a_per_mm = FaceLaw::new(media, latewood_share).absorption(light, &inside, fibres);
    let levels = levels(&mu_a_per_mm, &inside, fibres, count);
    AbsorptionMap { size: fibres.size, pixel_mm: fibres.pixel_mm, mu_a_per_mm, levels, knots: fibres.knots.clone() }
}

/// How a face of these media looks.
struct FaceLaw {
    /// Of clear wood and of knot wood.
    inverses: [Inverse; 2],
    /// Mean reflectance of clear wood [1].
    mean_reflectance: f32,
    /// Light of the palest wood over the mean, and the most that may be wood's [1].
    palest: f32,
    most: f32,
}

impl FaceLaw {
    fn new(media: &Media, latewood_share: f64) -> Self {
        let [clear, knotted] = means(media, latewood_share);
        let kind = |mu_a: f64, sigma_i: f64, k: f64| {
            let medium = Medium { sigma_i: sigma_i as f32, k: k as f32, ..clear };
            HalfSpace::new(&medium, 0.0).reflectance(mu_a)
        };
        let early = [media.earlywood_mu_a_per_mm, media.earlywood_sigma_i_per_mm, media.earlywood_k_per_mm];
        let late = kind(
            early[0] * media.latewood_mu_a_ratio,
            early[1] * media.latewood_sigma_i_ratio,
            early[2] * media.latewood_k_ratio,
        );
        let mean = (1.0 - latewood_share) * kind(early[0], early[1], early[2]) + latewood_share * late;
        let least = PALEST * early[0];
        let palest = (HalfSpace::new(&clear, 0.0).reflectance(least) / mean) as f32;
        Self {
            inverses: [&clear, &knotted].map(|medium| Inverse::new(medium, least as f32)),
            mean_reflectance: mean as f32,
            palest,
            most: palest + BRIGHTER,
        }
    }

    /// At each pixel, from light over the mean of clear wood [mm^-1].
    fn absorption(&self, light: &[f32], inside: &[bool], fibres: &FibreMap) -> Vec<f32> {
        let believed = |light: f32| if light > self.most { (self.palest + self.most - light).max(1.0) } else { light };
        let at = |i: usize| {
            let reflectance = believed(light[i]) * self.mean_reflectance;
            self.inverses[usize::from(inside[i])].at(reflectance, fibres.dive_rad[i])
        };
        (0..light.len()).map(at).collect()
    }
}

/// Logarithm of clear wood's absorption under wider and wider Gaussians; knots are filled from beside them.
fn levels(mu_a: &[f32], inside: &[bool], fibres: &FibreMap, count: usize) -> Vec<Vec<f32>> {
    let weight: Vec<f32> = inside.iter().map(|&knot| f32::from(!knot)).collect();
    let logs: Vec<f32> = mu_a.iter().zip(&weight).map(|(mu, w)| w * libm::logf(*mu)).collect();
    let mean = logs.iter().sum::<f32>() / weight.iter().sum::<f32>().max(1.0);
    let level = |depth: f32| -> Vec<f32> {
        let sigma = fibres.pixel_mm.map(|pixel| FADING * depth / pixel);
        let [sums, weights] = [&logs, &weight].map(|values| smooth(values, fibres.size, sigma, Beyond::Same));
        // A trace of the mean fills the middle of knots, where nothing clear is near.
        sums.iter().zip(weights).map(|(sum, w)| (sum + 1.0e-3 * mean) / (w + 1.0e-3)).collect()
    };
    DEPTHS_MM[..count].iter().map(|&depth| level(depth)).collect()
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;
    use crate::PictureKnot;

    /// The boxes about the knots are only a shortcut.
    #[test]
    fn pixels_in_knots_are_those_within_their_outlines() {
        let size = [240, 160];
        let turn = |i: usize, by: f32| (0.5 + i as f32 * by).fract();
        let knot = |i: usize| PictureKnot {
            centre_mm: Vec2::new(28.0 * turn(i, 0.8192) - 2.0, 40.0 * turn(i, 0.671) - 2.0),
            half_axes_mm: [0.1 + 5.0 * turn(i, 0.5497), 0.1 + 0.1 * turn(i, 0.5497)]
                .map(|mm| mm * (1.0 + turn(i, 0.3))),
            azimuth_rad: 6.0 * turn(i, 0.45),
            axis: Vec3::Z,
            end_confidence: 0.0,
            brightness: 0.5,
            dead: false,
        };
        let count = size[0] * size[1];
        let fibres = FibreMap {
            size,
            pixel_mm: [0.16, 0.15],
            azimuth_rad: vec![0.0; count],
            dive_rad: vec![0.0; count],
            confidence: vec![1.0; count],
            knots: (0..60).map(knot).collect(),
        };
        let within = |pixel| fibres.knots.iter().any(|knot| knot.within(fibres.place_mm(pixel)) < 1.0);
        let every: Vec<bool> = (0..count).map(within).collect();
        assert!(inside(&fibres) == every && every.iter().filter(|inside| **inside).count() > 1000);
    }
}
