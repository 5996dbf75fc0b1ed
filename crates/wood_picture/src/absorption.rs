//! The absorption map: how much light the wood takes up, at the face and below it.
//!
//! Model: light of a pixel over the mean of clear wood, times the mean reflectance of earlywood and latewood of the
//! stated media by their shares, is the pixel's own diffuse reflectance (the median would be earlywood's alone). The
//! absorption that has it follows from [`HalfSpace`], with the scattering of clear wood's mean outside of knots and of
//! knot wood in them, and the dive of the fibre map: steep fibres lead light down and darken without any absorption.
//! Below the face (an assumption, no measurement): a feature of width w lasts to a depth of about w, so that at depth d
//! the logarithm of absorption is that of the face under a Gaussian of standard deviation d / 2. In a knot the colour
//! of the face follows the branch's axis and does not fade. Sources: docs/theory/physics.md for the reflectance,
//! docs/theory/wood.md for the media. Limits: scattering that differs from the mean counts as absorption; light spreads
//! by a millimetre below the face, so that fine streaks are stronger in the wood than in the picture. Light that
//! changes over 20 mm and more by a fifth is that of lamps and is taken off; what is paler than half of earlywood's
//! absorption is gloss or torn fibres, and has that absorption.

use base::Medium;
use glam::Vec2;
use procedural::wood::Media;

use crate::background::evened;
use crate::raster::{Beyond, around, quantile, smooth};
use crate::{FibreMap, HalfSpace, PictureAnalysis, PictureFault, picture};

/// Steps of the dive from 0 to 90 degrees [deg].
const DIVE_STEP_DEG: f32 = 2.0;
/// Entries of the inverse over reflectances from 0 to 1.
const ENTRIES: usize = 1024;
/// Least absorption that is told over earlywood's [1]: what is brighter is gloss, or torn fibres.
const PALEST: f64 = 0.5;
/// Spread of the middle nine tenths of lamps over their median that is no longer even [1]: the tone of even boards
/// wanders by as much.
const UNEVEN: f32 = 0.2;
/// Clear wood around whose mean light is that of the lamps [mm].
const LAMPS_MM: f32 = 20.0;
/// Depths of the levels [mm]; light of 660 nm goes a millimetre or two deep.
const DEPTHS_MM: [f32; 5] = [0.0, 0.5, 1.0, 2.0, 4.0];
/// All of them.
pub(crate) const LEVELS: usize = DEPTHS_MM.len();
/// Standard deviation of the Gaussian over the depth [1].
const FADING: f32 = 0.5;
/// Fibres that dive less are flat [rad]: 3 degrees, which darken by under 1 %.
const FLAT_RAD: f32 = 0.05;
/// Part of the pixels at either end whose light counts as that of the next [1]: checks, resin and glints.
const TRIM: f32 = 0.005;
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
    /// Light over reflectance: divides a pixel's light [1].
    pub light_per_reflectance: f32,
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
    let (light, mean_light) = relative_light(grey, fibres, settings)?;
    let mut map = absorption_of(&light, fibres, media, latewood_share, LEVELS);
    map.light_per_reflectance *= mean_light as f32;
    Ok(map)
}

/// The same at the face alone, which takes a third of the memory, `[rows, cols]` [mm^-1].
///
/// # Errors
/// As [`absorption_map`].
pub fn face_absorption(
    grey: &[f32],
    fibres: &FibreMap,
    media: &Media,
    latewood_share: f64,
    settings: &PictureAnalysis,
) -> Result<Vec<f32>, PictureFault> {
    let (light, _) = relative_light(grey, fibres, settings)?;
    Ok(face(&light, &inside(fibres), fibres, media, latewood_share).0)
}

/// Light of every pixel over the mean of clear wood, and that mean [1].
fn relative_light(
    grey: &[f32],
    fibres: &FibreMap,
    settings: &PictureAnalysis,
) -> Result<(Vec<f32>, f64), PictureFault> {
    let light = picture::light(grey, fibres.size, fibres.pixel_mm, settings)?;
    let whole = clear_light(&light, fibres);
    let mut light = without_lamps(light, fibres);
    let mean = clear_light(&light, fibres);
    light.iter_mut().for_each(|light| *light = (f64::from(*light) / mean) as f32);
    Ok((light, whole))
}

/// Light without what uneven lamps do to it, where they are uneven.
pub(crate) fn without_lamps(light: Vec<f32>, fibres: &FibreMap) -> Vec<f32> {
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

/// Absorption of the palest wood of these media [mm^-1]: what looks paler has gloss.
pub fn palest_per_mm(media: &Media) -> f32 {
    (PALEST * media.earlywood_mu_a_per_mm) as f32
}

/// Mean light of clear wood [1].
pub(crate) fn clear_light(light: &[f32], fibres: &FibreMap) -> f64 {
    let inside = inside(fibres);
    // Where fibres dive light is led down: only flat ones say how bright clear wood is.
    let flat = |pixel: usize| !inside[pixel] && fibres.dive_rad[pixel].abs() < FLAT_RAD;
    let mut clear_light = Vec::with_capacity(light.len());
    clear_light.extend((0..light.len()).filter(|&pixel| flat(pixel)).map(|pixel| light[pixel]));
    if clear_light.is_empty() {
        clear_light.extend_from_slice(light);
    }
    let [low, high] = [TRIM, 1.0 - TRIM].map(|part| quantile(&mut clear_light, part));
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
    let (mu_a_per_mm, mean_reflectance) = face(light, &inside, fibres, media, latewood_share);
    let levels = levels(&mu_a_per_mm, &inside, fibres, count);
    AbsorptionMap {
        size: fibres.size,
        pixel_mm: fibres.pixel_mm,
        mu_a_per_mm,
        light_per_reflectance: (1.0 / mean_reflectance) as f32,
        levels,
        knots: fibres.knots.clone(),
    }
}

/// Absorption at the face [mm^-1], and the mean reflectance of clear wood [1].
fn face(light: &[f32], inside: &[bool], fibres: &FibreMap, media: &Media, latewood_share: f64) -> (Vec<f32>, f64) {
    let [clear, knotted] = means(media, latewood_share);
    let kind = |mu_a: f64, sigma_i: f64, k: f64| {
        let medium = Medium { sigma_i: sigma_i as f32, k: k as f32, ..clear };
        HalfSpace::new(&medium, 0.0).reflectance(mu_a)
    };
    let early = (media.earlywood_mu_a_per_mm, media.earlywood_sigma_i_per_mm, media.earlywood_k_per_mm);
    let late = kind(
        early.0 * media.latewood_mu_a_ratio,
        early.1 * media.latewood_sigma_i_ratio,
        early.2 * media.latewood_k_ratio,
    );
    let mean_reflectance = (1.0 - latewood_share) * kind(early.0, early.1, early.2) + latewood_share * late;
    let inverses = [&clear, &knotted].map(|medium| Inverse::new(medium, palest_per_mm(media)));
    let mu_a = |i: usize| inverses[usize::from(inside[i])].at(light[i] * mean_reflectance as f32, fibres.dive_rad[i]);
    ((0..light.len()).map(mu_a).collect(), mean_reflectance)
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
