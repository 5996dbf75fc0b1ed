//! The fibre map: what the texture says, what knots do to fibres, and how sure both are.
//!
//! Model: fibres run within 45 degrees of the board's length ([`crate::length`]). A first azimuth is the median of the
//! board in windows of 8 mm. Boards with marks across the grain ([`crate::marks`]) are averaged along the grain by 2
//! mm, which leaves the marks out, and are read by their rings alone, strong ones above weak ones; the streaks between
//! rings are lost under marks. Their first azimuth is that of all rings, and its error is what squares of the board and
//! means along other directions make of it, with half of what those would answer otherwise. Knots part the fibres as
//! streams around Rankine ovals and bend the layers in which they lie ([`procedural::wood::KnotSurroundings`],
//! stretched from each knot's circle to its ellipse), which gives a guess of azimuth and the dive; the texture then
//! says how far the azimuth is off ([`crate::orientation`]). Guess and texture are weighed by their variances: that of
//! the guess is 3 degrees in clear wood and half of what the knots add to it. In a knot fibres follow the branch. Dive:
//! of a living knot whose face lies on the bark's side, fibres rise to its outline from both ends by up to 21 degrees;
//! with the pith's side up they sink; around a dead knot they do neither, since layers after its death bend the other
//! way. Confidence: the expected cosine of twice the azimuth's error, exp(-2 se^2). Error of a board's direction: what
//! lasts, and half of what sixteen parts of the board say of their mean's error. Limits: beside the tips of a knot,
//! where fibres part, streaks may turn more than fibres. Rings of marked boards turn from their fibres by what dive and
//! spiral grain do, which no picture of one face shows. A dive of clear wood does not show in a picture and is 0; the
//! pith's tilt makes it a degree.

use std::borrow::Cow;
use std::f32::consts::FRAC_PI_2;

use glam::{Vec2, Vec3};
use procedural::wood::KnotSurroundings;

use crate::knots::{self, PictureKnot, azimuth, direction};
use crate::length::direction_of_length;
use crate::marks::{self, SawMarks};
use crate::orientation::{LOST_RAD, in_window, orientation, wrap};
use crate::raster::{around, quantile, quantile_of};
use crate::rings::{along_direction, along_lines, without_rings};
use crate::texture::{CellTexture, Cells, Look, RINGS_MM, RINGS_RAD, STREAKS_MM, texture};
use crate::{Face, PictureAnalysis, PictureFault, grain_scale};
use crate::{picture, ripple};

/// Pixels up to this are put together [mm]: the finest scale has 0.2 mm.
const FINE_MM: f32 = 0.15;
/// Means along the fibre [mm]: half a short streak to either side, and their step.
const STREAK_MM: [f32; 2] = [2.0, 0.6];
/// Grain of a camera or a laser from which rings stay in [mm]: weak streaks alone would then turn by more than rings
/// do. Noise of 2 % at 0.15 mm is 0.003, speckle of scans 0.01.
const GRAINY_MM: f32 = 0.006;
/// What rings and grain turn together [rad], an engineering estimate (2 deg): medians of ten rendered scans were 0.6 to
/// 3, one 6.
const GRAINY_RAD: f32 = 0.035;
/// Means along the grain that leave no marks [mm], and their step.
const UNMARKED_MM: [f32; 2] = [2.0, 0.35];
/// Scale of the texture of marked boards [mm].
const MARKED_MM: f32 = 0.3;
/// Least of that scale over the side of a pixel [1]: below it the noise of pixels turns directions.
const MARKED_PIXELS: f32 = 4.2;
/// Pixels up to this are put together where a marked board is read as a whole [mm].
const ROUGH_MM: f32 = 0.35;
/// How far from the first answer its rings are asked (8 deg) [rad], and how often.
const ASKED_RAD: f32 = 0.14;
const ROUNDS: usize = 5;
/// Most of a turn that may be left [1].
const MOST_KEPT: f32 = 0.8;
/// What the distance between two ways to the answer leaves of its error [1].
const APART_SHARE: f32 = 0.5;
/// What stays of the error of marked boards [rad], 0.9 deg: twenty photographs of sawn spruce and pine (docs/real.md).
const MARKED_RAD: f32 = 0.015;
/// Parts of a board's length and width whose directions are compared [1].
const PARTS: usize = 4;
/// What their spread leaves of the error of a mean in a board's direction [1]: twenty photographs, each half of which
/// says the same (docs/real.md).
const PARTS_SHARE: f32 = 0.5;
/// Side of the squares that speak independently of a board's direction [mm].
const BLOCK_MM: f32 = 12.0;
/// Least coherence of a marked board's texture [1].
const LEAST_COHERENCE: f32 = 0.03;
/// Least deviation of means along the grain over that of means of noise [1]: noise has 1, lattices of numbers that are
/// no good noise 4, three photographs of boards 51 to 78.
const LEAST_OVER_NOISE: f32 = 8.0;
/// Texture that runs farther from the board's length is not its grain [rad]: 30 deg.
const MOST_OFF_RAD: f32 = 0.52;
/// Squares whose texture runs farther from the median of all tell of knots, torn fibres and arches [rad]: 17 deg.
const ALIKE_RAD: f32 = 0.3;
/// Window of the first azimuth [mm].
const BASE_MM: f32 = 8.0;
/// Standard deviation of the guess in clear wood [rad]: how fibres vary over a board (3 deg).
const CLEAR_RAD: f32 = 0.05;
/// The same over what knots add to the guess [1].
const FLOW_SHARE: f32 = 0.5;
/// What streaks turn from the fibre [rad], an engineering estimate (0.5 deg): the notch that the rings leave.
const STREAKS_RAD: f32 = 0.009;
/// Wood between a knot's outline and the texture that counts [mm]: the reach of the finest derivative.
const RIND_MM: f32 = 0.6;
/// Least of the grain's strength over its standard error, median over the picture [1]; noise has 1.2.
const LEAST_SIGNIFICANCE: f32 = 4.0;
/// Light below this part of the median counts as this part [1].
const DARKEST: f32 = 0.02;
/// Azimuth's error in a knot over how much is not told of its lean: the cosine of the dive times this gives none [1].
const KNOT_ERROR: f32 = 0.12;

/// Fibres of a board's face, pixel by pixel `[rows, cols]`.
#[derive(Debug, Clone, PartialEq)]
pub struct FibreMap {
    /// Rows and columns.
    pub size: [usize; 2],
    /// Size of a pixel, down and across [mm].
    pub pixel_mm: [f32; 2],
    /// From y (down the rows) towards x (along a row), in (-pi/2, pi/2], as FibreAzimuth of datasets [rad].
    pub azimuth_rad: Vec<f32>,
    /// Into the wood, of the end that points to larger y, as FibreDive of datasets, in [-pi/2, pi/2] [rad].
    pub dive_rad: Vec<f32>,
    /// Expected cosine of twice the azimuth's error: 1 for sure, 0 for unknown [1].
    pub confidence: Vec<f32>,
    /// Knots by their place down the picture.
    pub knots: Vec<PictureKnot>,
}

impl FibreMap {
    /// Cosine and sine of twice the azimuth [1] and the dive [rad] of every pixel: nothing jumps where an azimuth
    /// passes 90 degrees but the sign of the dive.
    pub fn non_singular(&self) -> Vec<[f32; 3]> {
        let twice = |(azimuth, &dive): (&f32, &f32)| {
            let (sin, cos) = libm::sincosf(2.0 * azimuth);
            [cos, sin, dive]
        };
        self.azimuth_rad.iter().zip(&self.dive_rad).map(twice).collect()
    }

    /// Unit vector along the fibre of a pixel: x, y of the picture and z out of the face; its sign has no meaning [1].
    pub fn fibre(&self, pixel: usize) -> Vec3 {
        let (sin, cos) = libm::sincosf(self.dive_rad[pixel]);
        (cos * direction(self.azimuth_rad[pixel])).extend(-sin)
    }

    /// Standard error of the azimuth of a pixel, as its confidence says [rad].
    pub fn azimuth_error_rad(&self, pixel: usize) -> f32 {
        (-0.5 * libm::logf(self.confidence[pixel].max(f32::MIN_POSITIVE))).sqrt().min(LOST_RAD)
    }

    /// A map drawn by hand: for every pixel the direction (x, y) in the face, `None` for no direction, as the colours
    /// of the thesis' direction maps give it. Such maps have no dive; where they say no direction confidence is 0.
    /// Knots are told by a share of light below 0.8 in a closed patch, `alpha` being that share.
    ///
    /// # Errors
    /// Where arrays and size do not go together, or pixels have no size.
    pub fn from_directions(
        directions: &[Option<[f64; 2]>],
        alpha: &[f64],
        size: [usize; 2],
        pixel_mm: [f32; 2],
        least_knot_mm: f32,
    ) -> Result<Self, PictureFault> {
        let [rows, cols] = size;
        if let Some(pixels) = [directions.len(), alpha.len()].into_iter().find(|&n| rows.checked_mul(cols) != Some(n)) {
            return Err(PictureFault::Length { pixels, rows, cols });
        }
        if !(pixel_mm[0].min(pixel_mm[1]) > 0.0 && rows > 0 && cols > 0) {
            return Err(PictureFault::Pixel { pixel_mm });
        }
        let light: Vec<f32> = alpha.iter().map(|&share| share as f32).collect();
        let knots = knots::find(&light, size, pixel_mm, 0.0, least_knot_mm);
        let turned = |told: &Option<[f64; 2]>| told.map(|[x, y]| wrap(azimuth(Vec2::new(x as f32, y as f32))));
        let azimuths: Vec<Option<f32>> = directions.iter().map(turned).collect();
        let mut map = Self {
            size,
            pixel_mm,
            azimuth_rad: azimuths.iter().map(|told| told.unwrap_or(0.0)).collect(),
            dive_rad: vec![0.0; directions.len()],
            confidence: azimuths.iter().map(|told| f32::from(told.is_some())).collect(),
            knots,
        };
        map.follow_branches();
        Ok(map)
    }

    /// Place of a pixel's middle from the picture's corner (x, y) [mm].
    pub fn place_mm(&self, pixel: usize) -> Vec2 {
        let (row, col) = (pixel / self.size[1], pixel % self.size[1]);
        Vec2::new((col as f32 + 0.5) * self.pixel_mm[1], (row as f32 + 0.5) * self.pixel_mm[0])
    }

    /// In knots fibres follow the branch.
    fn follow_branches(&mut self) {
        for knot in self.knots.clone() {
            let turn = if knot.axis.y < 0.0 { -1.0 } else { 1.0 };
            let cosine = knot.axis.truncate().length();
            let azimuth = if cosine > 0.0 { wrap(azimuth(turn * knot.axis.truncate())) } else { 0.0 };
            let dive = -turn * knot.dive_rad();
            let error = (KNOT_ERROR / cosine.max(KNOT_ERROR)).min(1.0) * LOST_RAD;
            let reach = knot.half_axes_mm[0];
            let rows =
                [knot.centre_mm.y - reach, knot.centre_mm.y + reach].map(|y| (y / self.pixel_mm[0]).max(0.0) as usize);
            for pixel in rows[0] * self.size[1]..((rows[1] + 1).min(self.size[0])) * self.size[1] {
                if knot.within(self.place_mm(pixel)) < 1.0 {
                    self.azimuth_rad[pixel] = azimuth;
                    self.dive_rad[pixel] = dive;
                    self.confidence[pixel] = libm::expf(-2.0 * error * error);
                }
            }
        }
    }
}

/// Fibres of the board in a picture: `grey` are the numbers of one channel `[rows, cols]`, row 0 at the smallest y (a
/// photograph from above has its rows turned about), red if the picture has colours.
///
/// # Errors
/// Where the picture is no evenly lit, sharp picture of bare wood of the stated scale; each fault says what to do.
pub fn fibre_map(
    grey: &[f32],
    size: [usize; 2],
    pixel_mm: [f32; 2],
    settings: &PictureAnalysis,
) -> Result<FibreMap, PictureFault> {
    Ok(analyse(grey, size, pixel_mm, settings)?.0)
}

/// The same, with what was found of the board as a whole.
///
/// # Errors
/// As [`fibre_map`].
pub fn analyse(
    grey: &[f32],
    size: [usize; 2],
    pixel_mm: [f32; 2],
    settings: &PictureAnalysis,
) -> Result<(FibreMap, Findings), PictureFault> {
    let light = picture::light(grey, size, pixel_mm, settings)?;
    let clipped_share = picture::clipped_share(grey, settings.full_scale);
    let (light, coarse, coarse_mm) = binned(light, size, pixel_mm, FINE_MM);
    let median = quantile_of(&light, 0.5);
    let log_light: Vec<f32> = light.iter().map(|value| libm::logf(value.max(DARKEST * median))).collect();
    let lies_across = settings.lies_across;
    let length = direction_of_length(&log_light, coarse, coarse_mm, None, lies_across);
    let knots = knots::find(&light, coarse, coarse_mm, length, settings.least_knot_mm);
    drop(light);
    let clear = clear_pixels(&knots, coarse, coarse_mm);
    let length = direction_of_length(&log_light, coarse, coarse_mm, Some(&clear), lies_across);
    let cells = Cells::over(coarse, coarse_mm);
    let wider = (MARKED_PIXELS * (pixel_mm[0] * pixel_mm[1]).sqrt() / MARKED_MM).max(1.0);
    let looked = Looked { size: coarse, pixel_mm: coarse_mm, cells: &cells, clear: &clear, length, wider };
    let mut even = log_light.clone();
    if !lies_across {
        ripple::take_out(&mut even, coarse, coarse_mm, &clear);
    }
    let aside = direction(length + FRAC_PI_2);
    let across = along_direction(&even, coarse, coarse_mm, aside, &clear, marks::ACROSS_MM);
    let marks = marks::marks(&across, coarse, coarse_mm, &clear, lies_across);
    drop(across);
    let guessed = |base: [f32; 2]| Guess::new(base, &knots, &cells, settings);
    let read = if marks.is_some() {
        drop(even);
        looked.by_rings(&log_light, guessed)?
    } else {
        drop(log_light);
        grain_scale::check(&even, coarse, coarse_mm, &clear)?;
        looked.by_streaks(&even, guessed)?
    };
    let guess = &read.guess;
    let seen = orientation(&read.textures, &cells, &guess.azimuth, &guess.spread);
    let twice: Vec<Vec2> = guess.azimuth.iter().zip(&seen.delta).map(|(a, d)| direction(2.0 * (a + d))).collect();
    let mut map = FibreMap {
        size,
        pixel_mm,
        azimuth_rad: vec![0.0; grey.len()],
        dive_rad: vec![0.0; grey.len()],
        confidence: vec![0.0; grey.len()],
        knots,
    };
    for pixel in 0..grey.len() {
        let near = around(cells.size, cells.at(map.place_mm(pixel)));
        let doubled: Vec2 = near.iter().map(|&(cell, weight)| weight * twice[cell]).sum();
        map.azimuth_rad[pixel] = wrap(0.5 * azimuth(doubled));
        map.dive_rad[pixel] = near.iter().map(|&(cell, weight)| weight * guess.dive[cell]).sum();
        let variance: f32 = near.iter().map(|&(cell, weight)| weight * seen.variance[cell]).sum();
        map.confidence[pixel] = libm::expf(-2.0 * (variance + read.lasting.powi(2)));
    }
    map.follow_branches();
    let [azimuth_rad, error_rad] = of_board(&twice, &read, &cells);
    Ok((map, Findings { azimuth_rad, error_rad, marks, clipped_share }))
}

/// The grain as it is read, before knots and neighbours say more.
struct Read {
    textures: Vec<CellTexture>,
    guess: Guess,
    /// Error that stays however much texture there is [rad].
    lasting: f32,
}

/// Which pixels are looked at, in which cells, the direction of the board's length, and what the lengths are times at
/// which a marked board is read, since pixels are large [1].
struct Looked<'a> {
    size: [usize; 2],
    pixel_mm: [f32; 2],
    cells: &'a Cells,
    clear: &'a [bool],
    length: f32,
    wider: f32,
}

impl Looked<'_> {
    fn texture(&self, light: &[f32], look: Look) -> CellTexture {
        texture(light, self.size, self.pixel_mm, self.cells, look, self.clear)
    }

    /// Means along lines of these azimuths in cells; the lengths are those of [`along_lines`].
    fn averaged(&self, light: &[f32], azimuths: &[f32], lengths_mm: [f32; 2]) -> Vec<f32> {
        let lines: Vec<Vec2> = azimuths.iter().map(|&azimuth| direction(azimuth)).collect();
        along_lines(light, self.size, self.pixel_mm, self.cells, &lines, self.clear, lengths_mm)
    }

    /// Texture of a marked board.
    fn rings(&self, along: &[f32]) -> CellTexture {
        self.texture(along, Look { scale_mm: self.wider * MARKED_MM, bias_rad: MARKED_RAD, by_size: true })
    }

    /// Means along the grain that leave no marks, as [`UNMARKED_MM`].
    fn unmarked_mm(&self) -> [f32; 2] {
        UNMARKED_MM.map(|mm| self.wider * mm)
    }

    /// What was found, where it is the board's grain.
    fn along_the_board(&self, [azimuth, error]: [f32; 2]) -> [f32; 2] {
        [if wrap(azimuth - self.length).abs() < MOST_OFF_RAD { azimuth } else { self.length }, error]
    }

    /// Refuses a picture whose means along the grain vary no more than those of noise, which is what marks are if there
    /// is no grain: the deviation of independent pixels is that of their second differences.
    fn check_rings(&self, log_light: &[f32], along: &[f32]) -> Result<(), PictureFault> {
        let [sigma, step] = self.unmarked_mm();
        let weights =
            (1..=(2.0 * sigma / step).round() as i32).map(|i| libm::expf(-0.5 * (i as f32 * step / sigma).powi(2)));
        let (sum, squares) = weights.fold((1.0, 1.0), |(sum, squares), w| (sum + 2.0 * w, squares + 2.0 * w * w));
        let pixel_mm = (self.pixel_mm[0] * self.pixel_mm[1]).sqrt();
        let of_noise = grain_mm(log_light, self.size, self.pixel_mm) / pixel_mm * squares.sqrt() / sum;
        let seen: Vec<f64> =
            along.iter().zip(self.clear).filter(|(_, clear)| **clear).map(|(mean, _)| f64::from(*mean)).collect();
        let middle = seen.iter().sum::<f64>() / seen.len().max(1) as f64;
        let variance = seen.iter().map(|mean| (mean - middle).powi(2)).sum::<f64>() / seen.len().max(1) as f64;
        let over = variance.sqrt() as f32 / of_noise.max(f32::MIN_POSITIVE);
        let significance = LEAST_SIGNIFICANCE * over / LEAST_OVER_NOISE;
        if significance < LEAST_SIGNIFICANCE {
            return Err(PictureFault::NoWood { significance, least: LEAST_SIGNIFICANCE });
        }
        Ok(())
    }

    /// What rings say of a board with marks, whatever was answered first, and the error of that [rad]. Means along a
    /// direction look as if they ran along it, so rings are asked from both sides of the first answer, each time along
    /// what they said before. The share k of the turn that is left says how much of the answer is the question's:
    /// k / (1 - k) of the turn is an error.
    fn settled(&self, log_light: &[f32]) -> [f32; 2] {
        let counts = self.clear.iter().map(|clear| f32::from(*clear)).collect();
        let rough_mm = self.wider * ROUGH_MM;
        let (rough, size, pixel_mm) = binned(log_light.to_vec(), self.size, self.pixel_mm, rough_mm);
        let clear: Vec<bool> =
            binned(counts, self.size, self.pixel_mm, rough_mm).0.into_iter().map(|share| share == 1.0).collect();
        let looked = Looked { size, pixel_mm, clear: &clear, ..*self };
        let mut ends = [[0.0; 2]; 2];
        for (end, turn) in ends.iter_mut().zip([-ASKED_RAD, ASKED_RAD]) {
            end[0] = self.length + turn;
            for _ in 0..ROUNDS {
                let along = along_direction(&rough, size, pixel_mm, direction(end[0]), &clear, self.unmarked_mm());
                *end = whole(&looked.rings(&along), self.cells);
            }
        }
        let apart = wrap(ends[1][0] - ends[0][0]);
        let kept = (0.5 * apart / ASKED_RAD).clamp(0.0, MOST_KEPT);
        let error = libm::hypotf(0.5 * (ends[0][1] + ends[1][1]), ASKED_RAD * kept / (1.0 - kept));
        [wrap(ends[0][0] + 0.5 * apart), error]
    }

    /// Boards with marks across the grain: rings alone, averaged along the grain.
    fn by_rings(&self, log_light: &[f32], guessed: impl Fn([f32; 2]) -> Guess) -> Result<Read, PictureFault> {
        let along = self.averaged(log_light, &vec![self.length; self.cells.count()], self.unmarked_mm());
        self.check_rings(log_light, &along)?;
        let first = whole(&self.rings(&along), self.cells);
        let along = self.averaged(log_light, &guessed(self.along_the_board(first)).azimuth, self.unmarked_mm());
        let mut rings = self.rings(&along);
        check_coherence(&rings)?;
        rings.correlated *= (1.0 + (UNMARKED_MM[0] / MARKED_MM).powi(2)).sqrt();
        let [last, _] = whole(&rings, self.cells);
        let guess = guessed(self.along_the_board([last, MARKED_RAD]));
        let [settled, error] = self.settled(log_light);
        // Rings that lead away from the grain say nothing of it, but that the answer is none that lasts.
        let away = wrap(settled - self.length).abs() > MOST_OFF_RAD;
        let apart = if away { ASKED_RAD } else { APART_SHARE * wrap(settled - last) };
        Ok(Read { textures: vec![rings], guess, lasting: libm::hypotf(libm::hypotf(error, apart), MARKED_RAD) })
    }

    /// Boards without: streaks, at several scales, and rings.
    fn by_streaks(&self, log_light: &[f32], guessed: impl Fn([f32; 2]) -> Guess) -> Result<Read, PictureFault> {
        let grainy = grain_mm(log_light, self.size, self.pixel_mm) > GRAINY_MM;
        let streaks = if grainy {
            Cow::Borrowed(log_light)
        } else {
            Cow::Owned(without_rings(log_light, self.size, self.pixel_mm, self.cells, self.clear))
        };
        let seen = |light: &[f32], scale_mm: f32, bias_rad: f32| {
            self.texture(light, Look { scale_mm, bias_rad, by_size: false })
        };
        let mut textures = [
            seen(&streaks, STREAKS_MM[0], STREAKS_RAD),
            seen(&streaks, STREAKS_MM[1], STREAKS_RAD),
            seen(&streaks, STREAKS_MM[2], STREAKS_RAD),
            seen(log_light, RINGS_MM, RINGS_RAD),
        ];
        let mut guess = guessed(self.along_the_board(base(&textures, self.cells)?));
        if grainy {
            // Grain that is no streak has all directions: means along the fibre leave little of it.
            let along = self.averaged(&streaks, &guess.azimuth, STREAK_MM);
            for (i, scale) in STREAKS_MM.into_iter().enumerate() {
                textures[i] = seen(&along, scale, STREAKS_RAD);
                textures[i].correlated *= (1.0 + (STREAK_MM[0] / scale).powi(2)).sqrt();
            }
            guess = guessed(self.along_the_board(base(&textures, self.cells)?));
        }
        let lasting = if grainy { GRAINY_RAD } else { STREAKS_RAD };
        Ok(Read { textures: textures.into(), guess, lasting })
    }
}

/// What was found of a board as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Findings {
    /// Azimuth of its grain [rad].
    pub azimuth_rad: f32,
    /// Standard error of that [rad].
    pub error_rad: f32,
    /// Marks across the grain, if there are any.
    pub marks: Option<SawMarks>,
    /// Share of pixels that have reached the end of the scale [1].
    pub clipped_share: f32,
}

/// Means of so many rows and columns that pixels have this side at most.
fn binned(light: Vec<f32>, size: [usize; 2], pixel_mm: [f32; 2], most_mm: f32) -> (Vec<f32>, [usize; 2], [f32; 2]) {
    let by = pixel_mm.map(|mm| ((most_mm / mm) as usize).max(1));
    if by == [1, 1] {
        return (light, size, pixel_mm);
    }
    let coarse = [size[0].div_ceil(by[0]), size[1].div_ceil(by[1])];
    let [mut sums, mut counts] = [vec![0.0_f32; coarse[0] * coarse[1]], vec![0.0_f32; coarse[0] * coarse[1]]];
    for (pixel, light) in light.iter().enumerate() {
        let to = pixel / size[1] / by[0] * coarse[1] + pixel % size[1] / by[1];
        sums[to] += light;
        counts[to] += 1.0;
    }
    sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum /= count);
    (sums, coarse, [by[0] as f32 * pixel_mm[0], by[1] as f32 * pixel_mm[1]])
}

/// Which pixels lie outside of knots and their rinds.
fn clear_pixels(knots: &[PictureKnot], [rows, cols]: [usize; 2], pixel_mm: [f32; 2]) -> Vec<bool> {
    let mut clear = vec![true; rows * cols];
    for knot in knots {
        let [a, b] = knot.half_axes_mm;
        let wider = PictureKnot { half_axes_mm: [a + RIND_MM, b + RIND_MM], ..*knot };
        for (pixel, clear) in clear.iter_mut().enumerate() {
            let (row, col) = (pixel / cols, pixel % cols);
            let place = Vec2::new((col as f32 + 0.5) * pixel_mm[1], (row as f32 + 0.5) * pixel_mm[0]);
            *clear &= wider.within(place) >= 1.0;
        }
    }
    clear
}

/// Noise of a pixel over the mean, times the root of its area, from second differences down the rows [mm].
fn grain_mm(log_light: &[f32], [rows, cols]: [usize; 2], pixel_mm: [f32; 2]) -> f32 {
    let bend = |i: usize| (log_light[i - cols] - 2.0 * log_light[i] + log_light[i + cols]).abs();
    let mut bends: Vec<f32> = (cols..(rows - 1) * cols).step_by(7).map(bend).collect();
    // The median of a Gaussian's size is 0.6745 of its deviation; 1, -2 and 1 make root 6 of noise.
    quantile(&mut bends, 0.5) / (0.6745 * 6.0_f32.sqrt()) * (pixel_mm[0] * pixel_mm[1]).sqrt()
}

/// The first azimuth: the board's median, from the texture that tells most, and its error [rad].
fn base(textures: &[CellTexture], cells: &Cells) -> Result<[f32; 2], PictureFault> {
    let mut best: Option<(f32, [f32; 2])> = None;
    for texture in textures {
        let seen = in_window(texture, cells, BASE_MM);
        let mut strengths: Vec<f32> =
            seen.iter().map(|&(_, error)| 0.5 / libm::hypotf(error, texture.bias_rad)).collect();
        let strength = quantile(&mut strengths, 0.5);
        if best.is_none_or(|(most, _)| strength > most) {
            let mean: Vec2 = seen.iter().map(|&(azimuth, error)| direction(2.0 * azimuth) / (error * error)).sum();
            let mean = 0.5 * azimuth(mean);
            let mut off: Vec<f32> = seen.iter().map(|&(azimuth, _)| wrap(azimuth - mean)).collect();
            best = Some((strength, [mean + quantile(&mut off, 0.5), texture.bias_rad]));
        }
    }
    let (significance, base) = best.unwrap_or_default();
    if significance < LEAST_SIGNIFICANCE {
        return Err(PictureFault::NoWood { significance, least: LEAST_SIGNIFICANCE });
    }
    Ok(base)
}

/// The median azimuth of cells outside of knots, with its error [rad], which parts of the board tell by how they
/// differ.
fn of_board(twice: &[Vec2], read: &Read, cells: &Cells) -> [f32; 2] {
    let [rows, cols] = cells.size;
    let clear: Vec<usize> = (0..cells.count()).filter(|&cell| read.textures[0].pixels[cell] > 0.0).collect();
    let mut parts = [Vec2::ZERO; PARTS * PARTS];
    for &cell in &clear {
        parts[cell / cols * PARTS / rows * PARTS + cell % cols * PARTS / cols] += twice[cell];
    }
    let mean = 0.5 * azimuth(parts.iter().sum());
    let mut offs: Vec<f32> = clear.iter().map(|&cell| wrap(0.5 * azimuth(twice[cell]) - mean)).collect();
    if offs.is_empty() {
        return [mean, LOST_RAD];
    }
    let middle = mean + quantile(&mut offs, 0.5);
    let spread = |part: &Vec2| part.length() * wrap(0.5 * azimuth(*part) - middle).powi(2);
    let all = parts.iter().map(|part| part.length()).sum::<f32>();
    let seen = parts.iter().filter(|part| **part != Vec2::ZERO).count() as f32;
    let variance = parts.iter().map(spread).sum::<f32>() / all / (seen - 1.0).max(1.0);
    let error = libm::hypotf(PARTS_SHARE * variance.sqrt(), read.lasting);
    [wrap(middle), error.min(LOST_RAD)]
}

/// The board's direction from all of a texture, with its error [rad]: strong rings say more than weak ones, and squares
/// of 12 mm speak independently.
fn whole(texture: &CellTexture, cells: &Cells) -> [f32; 2] {
    let blocks = Cells {
        size: cells.size.map(|count| ((count as f32 * cells.side_mm / BLOCK_MM).ceil() as usize).max(1)),
        side_mm: BLOCK_MM,
    };
    let mut sums = vec![Vec2::ZERO; blocks.count()];
    for cell in 0..cells.count() {
        sums[blocks.of_place(cells.middle(cell))] += Vec2::new(texture.sums[2][cell], texture.sums[1][cell]);
    }
    let mean = 0.5 * azimuth(sums.iter().sum());
    let mut offs: Vec<f32> =
        sums.iter().filter(|sum| **sum != Vec2::ZERO).map(|sum| wrap(0.5 * azimuth(*sum) - mean)).collect();
    if offs.is_empty() {
        return [mean, LOST_RAD];
    }
    let middle = mean + quantile(&mut offs, 0.5);
    sums.retain(|sum| wrap(0.5 * azimuth(*sum) - middle).abs() < ALIKE_RAD);
    let alike: Vec2 = sums.iter().sum();
    // What a jackknife says that leaves out a square in turn, for small errors.
    let aside = sums.iter().map(|sum| sum.perp_dot(alike).powi(2)).sum::<f32>().sqrt();
    [0.5 * azimuth(alike), (0.5 * aside / alike.length_squared()).min(LOST_RAD)]
}

/// Refuses a marked board whose texture has hardly a direction.
fn check_coherence(texture: &CellTexture) -> Result<(), PictureFault> {
    let [length, re, im] = [0, 1, 2].map(|i| texture.sums[i].iter().sum::<f32>());
    let significance = LEAST_SIGNIFICANCE * libm::hypotf(re, im) / length.max(f32::MIN_POSITIVE) / LEAST_COHERENCE;
    if significance < LEAST_SIGNIFICANCE {
        return Err(PictureFault::NoWood { significance, least: LEAST_SIGNIFICANCE });
    }
    Ok(())
}

/// What is expected of fibres before the texture is asked.
struct Guess {
    /// Azimuth of every cell [rad].
    azimuth: Vec<f32>,
    /// Its standard deviation [rad].
    spread: Vec<f32>,
    /// Dive [rad].
    dive: Vec<f32>,
}

impl Guess {
    fn new([base, error]: [f32; 2], knots: &[PictureKnot], cells: &Cells, settings: &PictureAnalysis) -> Self {
        let surroundings = KnotSurroundings::new(settings.flow_ratio);
        let side = match settings.face {
            Face::Bark => 1.0,
            Face::Pith => -1.0,
        };
        let count = cells.count();
        let spread = vec![libm::hypotf(CLEAR_RAD, error); count];
        let mut guess = Self { azimuth: vec![base; count], spread, dive: vec![0.0; count] };
        if knots.is_empty() {
            return guess;
        }
        for cell in 0..count {
            let place = cells.middle(cell);
            let along = direction(guess.azimuth[cell]);
            let across = along.perp();
            let (mut stream, mut slope) = (Vec2::ZERO, Vec2::ZERO);
            for knot in knots {
                let to_circle = knot.to_circle();
                // The undisturbed fibre in the circle that the outline becomes.
                let speed = to_circle * along;
                let ahead = speed.normalize();
                let off = to_circle * (place - knot.centre_mm);
                let Some(here) = surroundings.at(Vec2::new(off.dot(ahead), ahead.perp_dot(off))) else { continue };
                // Back on the face, in speeds of the undisturbed stream.
                let aside = to_circle.inverse() * ahead.perp() * speed.length();
                let added = here.stream.x * along + here.stream.y * aside;
                stream += Vec2::new(added.dot(along), added.dot(across));
                if !knot.dead {
                    // Layers rise by the half width of the branch for each half width of the circle.
                    let gradient = here.slope.x * ahead + here.slope.y * ahead.perp();
                    let gradient = side * knot.half_axes_mm[1] * (to_circle.transpose() * gradient);
                    slope += Vec2::new(gradient.dot(along), gradient.dot(across));
                }
            }
            let fibre = KnotSurroundings::fibre(stream, slope);
            let flat = fibre.x * along + fibre.y * across;
            let added = base::atan2(flat.dot(direction(guess.azimuth[cell] + 0.5 * std::f32::consts::PI)), fibre.x);
            guess.azimuth[cell] += added;
            guess.spread[cell] += FLOW_SHARE * added.abs();
            let turn = if flat.y < 0.0 { -1.0 } else { 1.0 };
            guess.dive[cell] = -turn * libm::asinf(fibre.z.clamp(-1.0, 1.0));
        }
        guess
    }
}
