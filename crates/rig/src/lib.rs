//! The rig of a scene in the words of data sheets: field of view, resolution, line, exposure, speckle, and the noise of
//! Range that follows from them; with what is likely to be meant otherwise.
//!
//! Range noise is that of the line's centre of gravity on a white matte surface, in rows times the height of a row:
//!
//! - photons: sigma / sqrt(N) for a line of standard deviation sigma with N electrons in its column (Winick 1986)
//! - dark noise: sigma_e sqrt(w (w + 1) (2 w + 1) / 3) / N in a window of w rows on each side
//! - speckle: C sqrt(sigma L / (4 sqrt(pi))), L the correlation length along the rows ([`PixelCorrelation`])
//! - rounding to subpixel steps: step / sqrt(12)
//!
//! Where white saturates, N is that of matter that peaks at 70 % of saturation, which is how exposures are chosen.
//! Light from below the surface widens the line and has less speckle: matter that scatters in depth has another noise.

pub mod check;
pub mod mistakes;
mod pixel_correlation;

use std::f64::consts::PI;

use serde_json::{Map, Value, json};

use optical_bench::settings::{RangeForm, Script, Transport};
use pipeline::{body, set_up};
use recipe::Scene;
use scanner::extract::margin;
use scanner::optics::Sensor;
use scanner::optics::camera::Sight;
use scanner::optics::speckle::PatternCache;

pub use crate::pixel_correlation::{PixelCorrelation, grain_px};

/// Full width at half maximum over the standard deviation of a Gaussian.
const FWHM: f64 = 2.354_820_045;
/// Peak of clear matter for which exposures are chosen [share of saturation].
const USUAL_PEAK: f64 = 0.7;
/// Above this peak of a white surface matter saturates that gives back half of the light; wood spreads part of it
/// beside the line
/// [share of saturation].
const BRIGHT_PEAK: f64 = 2.0;
/// Below this peak of a white surface half of the numbers are without use [share of saturation].
const DIM_PEAK: f64 = 0.3;
/// Most rows of a window on each side of the peak [px].
const WIDEST_WINDOW: usize = 15;
/// Below this the centre of gravity is biased by where in a row the line lies [px].
const NARROW_LINE_PX: f64 = 0.5;
/// Rows of motion during an exposure above which the line is visibly smeared [px].
const MUCH_TRAVEL_PX: f64 = 1.0;
/// Distance of profiles over that of columns, or the other way round, beyond which pixels are far from square [1].
const MUCH_STRETCH: f64 = 3.0;
/// The same beyond which samples are of little use [1].
const FAR_STRETCH: f64 = 20.0;

/// One number of a rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigNumber {
    /// Its name, ending in its unit.
    pub name: &'static str,
    /// What it is.
    pub doc: &'static str,
    /// Its value.
    pub value: f64,
}

/// What a rig is.
#[derive(Debug, Clone, PartialEq)]
pub struct RigReport {
    /// The numbers, in the order of the light.
    pub numbers: Vec<RigNumber>,
    /// What is likely to be meant otherwise, each with what to do.
    pub warnings: Vec<String>,
}

impl RigReport {
    /// A line for each number.
    pub fn table(&self) -> String {
        let line = |number: &RigNumber| format!("{:28}{:>9}  {}\n", number.name, figure(number.value), number.doc);
        self.numbers.iter().map(line).collect()
    }

    /// The same as a document; a number that there is not is null.
    pub fn json(&self) -> Value {
        let numbers: Map<String, Value> =
            self.numbers.iter().map(|number| (number.name.to_owned(), json!(number.value))).collect();
        json!({ "numbers": numbers, "warnings": self.warnings })
    }
}

/// The rig of a scene over the upper surface of its object.
pub fn report(scene: &Scene) -> RigReport {
    let patterns = PatternCache::new(0);
    let by_kernel = scene.transport == Transport::Kernel;
    // What it is does not depend on who answers for light below the surface.
    let mut scene = scene.clone();
    scene.transport = Transport::Kernel;
    let scene = &scene;
    let body = body(scene);
    let top = f64::from(body.bounds().1.z);
    let (sensor, specimen) = set_up(scene, body, &patterns);
    let facts = Facts::of(scene, &sensor, top);
    let fan = check::cut_by_fan(scene, &sensor, &specimen);
    let out_of_view = check::out_of_view(scene, &sensor, &specimen);
    let in_doubt = if by_kernel { check::light_in_doubt(scene, &sensor, &specimen) } else { None };
    let own = facts.warnings(fan.is_some());
    let mistakes = mistakes::mistakes_of_scene(scene).into_iter().map(|told| format!("{}; {}", told.what, told.remedy));
    let warnings = own.into_iter().chain(fan).chain(out_of_view).chain(in_doubt).chain(mistakes).collect();
    RigReport { numbers: facts.numbers(), warnings }
}

/// What numbers and warnings are made from.
struct Facts<'a> {
    scene: &'a Scene,
    top: f64,
    /// Field of view on the conveyor and on the object [mm].
    field_mm: [f64; 2],
    column_mm: f64,
    height_per_row_mm: f64,
    /// Heights that every column can measure [mm].
    heights_mm: [f64; 2],
    /// Standard deviation of the line on the object [mm] and on the sensor [px].
    line_mm: f64,
    line_px: f64,
    rows_per_mm: f64,
    /// Peak of a white surface [share of saturation].
    peak: f64,
    /// Electrons in a column of a white surface.
    electrons: f64,
    /// Rows that the object moves in an exposure.
    travel_px: f64,
    /// Contrast of speckle on a surface in a pixel, and its grain [1, px].
    contrast: f64,
    grain_px: f64,
    magnification: f64,
}

/// Standard deviations of Range on a white matte surface [um].
struct NoiseFacts {
    photons: f64,
    dark: f64,
    speckle: f64,
    rounding: f64,
}

impl NoiseFacts {
    fn of(facts: &Facts) -> Self {
        let (scene, bench, line_px) = (facts.scene, &facts.scene.bench, facts.line_px);
        let per_row_um = 1e3 * facts.height_per_row_mm;
        let (electrons, peak) = (facts.electrons, facts.peak);
        let usual = if peak > USUAL_PEAK { electrons * USUAL_PEAK / peak } else { electrons };
        let per_electron = (255.0 - bench.exposure.dark_level_dn) / bench.exposure.full_well_e;
        let dark_e = bench.exposure.dark_noise_dn / per_electron;
        let w = scene.extraction.window_rows as f64;
        let steps = f64::from(scene.extraction.subpixel_steps);
        let has_speckle = bench.speckle.strength > 0.0 || scene.postprocess.order.steps().contains(&Script::Speckle);
        let correlation = PixelCorrelation::of(facts.grain_px);
        Self {
            photons: bench.exposure.shot_noise * per_row_um * line_px / usual.sqrt(),
            dark: per_row_um * dark_e * (w * (w + 1.0) * (2.0 * w + 1.0) / 3.0).sqrt() / usual,
            speckle: if has_speckle {
                per_row_um * facts.contrast * (line_px * correlation.length() / (4.0 * PI.sqrt())).sqrt()
            } else {
                0.0
            },
            rounding: if steps > 0.0 { per_row_um / steps / 12f64.sqrt() } else { 0.0 },
        }
    }

    fn total(&self) -> f64 {
        let Self { photons, dark, speckle, rounding } = self;
        (photons * photons + dark * dark + speckle * speckle + rounding * rounding).sqrt()
    }
}

impl<'a> Facts<'a> {
    fn of(scene: &'a Scene, sensor: &Sensor, top: f64) -> Self {
        let (rig, bench, size) = (sensor.camera().rig, &scene.bench, scene.size);
        let sight = sensor.camera().sight(0.0, top as f32, 0.0);
        let ends = [-0.5, size.columns as f64 - 0.5];
        let field_mm = [0.0, top].map(|z| rig.along(ends[1], z) - rig.along(ends[0], z));
        // A peak nearer to the sensor's edge than what is read beside it is not measured.
        let margin = margin(&scene.extraction) as f64;
        let rows = [size.rows as f64 - 0.5 - margin, margin - 0.5];
        let across = [ends[0], rig.centre_col, ends[1]];
        let low = across.map(|col| rig.locate(col, rows[0])[1]).into_iter().fold(f64::NEG_INFINITY, f64::max);
        let high = across.map(|col| rig.locate(col, rows[1])[1]).into_iter().fold(f64::INFINITY, f64::min);
        let row = f64::from(sight.row);
        let height_per_row_mm = rig.height(row - 0.5) - rig.height(row + 0.5);
        let line_px = f64::from(sight.variance).sqrt();
        let line_mm = f64::from(sight.laser_variance).sqrt() / f64::from(sight.rows_per_mm);
        let electrons = f64::from(sight.electrons * sight.view.z);
        let peak = white_peak(&sight, bench.exposure.full_well_e);
        let contrast = f64::from(sensor.speckle_contrast()[0]);
        let grain = grain_px(bench);

        let rate = bench.motion.line_rate_hz;
        Self {
            scene,
            top,
            field_mm,
            column_mm: f64::from(sight.column_mm),
            height_per_row_mm,
            heights_mm: [low, high],
            line_mm,
            line_px,
            rows_per_mm: f64::from(sight.rows_per_mm),
            peak,
            electrons,
            travel_px: bench.motion.step_mm * rate * bench.exposure.time_us * 1e-6 * f64::from(sight.rows_per_mm),
            contrast,
            grain_px: grain,
            magnification: rig.magnification(),
        }
    }

    fn numbers(&self) -> Vec<RigNumber> {
        let bench = &self.scene.bench;
        let (motion, camera, exposure) = (&bench.motion, &bench.camera, &bench.exposure);
        let (sin, cos) = libm::sincos(camera.tilt_deg.to_radians());
        let fastest_hz = 1e6 / exposure.time_us;
        let speed = |rate: f64| if rate > 0.0 { rate * motion.step_mm } else { f64::NAN };
        let number = |name, doc, value| RigNumber { name, doc, value };
        let noise = NoiseFacts::of(self);
        vec![
            number("working_distance_mm", "height of the lens over the conveyor", camera.distance_mm * cos),
            number("baseline_mm", "from the laser plane to the lens", camera.distance_mm * sin),
            number("object_height_mm", "upper end of the object", self.top),
            number("field_of_view_mm", "along the line, on the object", self.field_mm[1]),
            number("field_on_conveyor_mm", "along the line, on the conveyor", self.field_mm[0]),
            number("column_mm", "a column, on the object", self.column_mm),
            number("height_per_row_um", "a sensor row, on the object", 1e3 * self.height_per_row_mm),
            number("lowest_mm", "height that every column can still measure", self.heights_mm[0]),
            number("highest_mm", "the same", self.heights_mm[1]),
            number("profile_step_mm", "from profile to profile", motion.step_mm),
            number(
                "line_rate_hz",
                "profiles a second; - where it stands still while it is exposed",
                speed(motion.line_rate_hz) / motion.step_mm,
            ),
            number("speed_mm_per_s", "of the object", speed(motion.line_rate_hz)),
            number("fastest_mm_per_s", "speed at which exposures follow each other without a pause", speed(fastest_hz)),
            number("travel_px", "rows that the line moves in an exposure", self.travel_px),
            number("line_width_mm", "laser line on the object, full width at half maximum", FWHM * self.line_mm),
            number("line_width_1_e2_mm", "the same at 1/e^2 of the peak", 4.0 * self.line_mm),
            number("line_width_px", "line on the sensor, full width at half maximum", FWHM * self.line_px),
            number("exposure_us", "exposure time", exposure.time_us),
            number("white_peak", "peak of a white matte surface, share of saturation", self.peak),
            number("electrons_white_e", "its electrons in a column", self.electrons),
            number("speckle_contrast", "in a pixel, light from the surface", self.contrast),
            number("speckle_grain_px", "speckle on the sensor", self.grain_px),
            number("speckle_grain_um", "the same on the object", self.grain_px * camera.pixel_um / self.magnification),
            number("range_noise_um", "of a white matte surface, standard deviation", noise.total()),
            number("range_noise_photons_um", "its part of photons", noise.photons),
            number("range_noise_dark_um", "its part of the sensor", noise.dark),
            number("range_noise_speckle_um", "its part of speckle", noise.speckle),
            number("range_noise_rounding_um", "its part of subpixel steps", noise.rounding),
        ]
    }

    /// Whether the window of the centre of gravity cuts the line.
    fn is_wider_than_window(&self) -> bool {
        self.scene.extraction.window_rows > 1 && self.window_rows() < 4.0 * self.line_px
    }

    fn wide_line(&self) -> String {
        let (window, width) = (self.window_rows(), 4.0 * self.line_px);
        format!("the window of {window:.0} rows cuts the line, which is {width:.1} rows wide at 1/e^2")
    }

    /// What makes a line fit its window: by what widens it most.
    fn narrow_line_remedy(&self) -> String {
        let on_sensor = "bring it into focus on the sensor (camera.scheimpflug: solved; camera.focus_distance_mm, \
            f_number, blur_um)";
        let on_object = "narrow it on the object (laser.waist_mm, laser.waist_height_mm near the surface)";
        // Both in rows, one after the other along the light.
        let laser_px = self.line_mm * self.rows_per_mm;
        let narrower = if 2.0 * laser_px * laser_px < self.line_px * self.line_px { on_sensor } else { on_object };
        // More rows are a remedy where enough of them are to be had, and where the line is not wide for being far from
        // its waist.
        let is_enough = 4.0 * self.line_px <= (2 * WIDEST_WINDOW + 1) as f64;
        let is_near_waist = self.line_mm < self.scene.bench.laser.waist_mm;
        if self.scene.extraction.window_rows < WIDEST_WINDOW && is_enough && is_near_waist {
            format!("{narrower}, or raise extraction.window_rows, {WIDEST_WINDOW} at most")
        } else {
            narrower.to_owned()
        }
    }

    /// What tells of profiles that are hardly any.
    fn far_apart(&self) -> Option<String> {
        let stretch = self.stretch();
        let even = self.scene.extraction.range != RangeForm::Uncalibrated;
        (even && stretch > FAR_STRETCH).then(|| {
            let step_mm = self.scene.bench.motion.step_mm;
            if self.is_binned() {
                format!("profiles are {step_mm} mm apart, and binned pixels {stretch:.0} times as long as wide")
            } else {
                format!("profiles are {step_mm} mm apart, {stretch:.0} times as far as columns")
            }
        })
    }

    fn is_binned(&self) -> bool {
        self.scene.output.bin_columns * self.scene.output.bin_profiles > 1
    }

    /// How many times as long along the scan as wide pixels of the images are [1].
    fn stretch(&self) -> f64 {
        let output = &self.scene.output;
        let (profile_mm, column_mm) = (self.scene.bench.motion.step_mm, self.column_mm);
        profile_mm * output.bin_profiles as f64 / (column_mm * output.bin_columns as f64)
    }

    /// Digital number at the peak of clear matter as exposures are chosen, and no more than that of a white surface
    /// [DN].
    fn usual_dn(&self) -> f64 {
        let dark = self.scene.bench.exposure.dark_level_dn;
        dark + self.peak.min(USUAL_PEAK) * (255.0 - dark)
    }

    fn window_rows(&self) -> f64 {
        (2 * self.scene.extraction.window_rows + 1) as f64
    }

    /// What the numbers alone warn of; light that a fan puts beside much of the object is not called too much.
    fn warnings(&self, is_cut_by_fan: bool) -> Vec<String> {
        let motion = &self.scene.bench.motion;
        let mut warnings = Vec::new();
        let mut warn = |holds: bool, text: String| {
            if holds {
                warnings.push(text);
            }
        };
        let [low, high] = self.heights_mm;
        warn(
            self.top > high || low > 0.0,
            format!(
                "heights from 0 to {} mm are not seen in all columns, which measure {} to {} mm: raise camera.rows or \
                 camera.distance_mm, or lower camera.tilt_deg",
                figure(self.top),
                figure(low),
                figure(high)
            ),
        );
        warn(
            self.peak > BRIGHT_PEAK && !is_cut_by_fan,
            format!(
                "matter that reflects more than {} saturates: shorten exposure.time_us or lower laser.power_mw",
                percent(1.0 / self.peak)
            ),
        );
        warn(
            self.peak < DIM_PEAK,
            format!(
                "a white surface peaks at {} of saturation: lengthen exposure.time_us or raise laser.power_mw",
                percent(self.peak)
            ),
        );
        warn(
            self.line_px < NARROW_LINE_PX,
            format!(
                "the line is {} rows wide (standard deviation), too narrow for places between rows: raise \
                 laser.waist_mm or camera.blur_um",
                figure(self.line_px)
            ),
        );
        warn(self.is_wider_than_window(), format!("{}: {}", self.wide_line(), self.narrow_line_remedy()));
        warn(
            self.travel_px > MUCH_TRAVEL_PX,
            format!("the line moves {} rows in an exposure: shorten exposure.time_us", figure(self.travel_px)),
        );
        let stretch = self.stretch();
        let [times, shape] = match stretch {
            long if long >= 1.0 => [figure(long), "as long as wide".to_owned()],
            flat => [figure(1.0 / flat), "as wide as long".to_owned()],
        };
        let even = self.scene.extraction.range != RangeForm::Uncalibrated;
        let [pixels, remedy] = if self.is_binned() {
            ["pixels of the binned images", "motion.step_mm or output.bin"]
        } else {
            ["pixels", "motion.step_mm"]
        };
        warn(
            even && !(1.0 / MUCH_STRETCH..=MUCH_STRETCH).contains(&stretch),
            format!(
                "profiles are {} mm and columns {} mm apart: {pixels} are {times} times {shape}; set {remedy}",
                motion.step_mm,
                figure(self.column_mm)
            ),
        );
        warnings
    }
}

/// Peak of a white matte surface under a line that is seen like this [share of saturation].
fn white_peak(sight: &Sight, full_well_e: f64) -> f64 {
    let (electrons, line_px) = (f64::from(sight.electrons * sight.view.z), f64::from(sight.variance).sqrt());
    electrons * libm::erf(0.5 / (2f64.sqrt() * line_px)) / full_well_e
}

/// A number with two significant digits at least, and with three below a hundredth.
fn figure(value: f64) -> String {
    match value.abs() {
        size if size.is_nan() => "-".to_owned(),
        0.0 => "0".to_owned(),
        1000.0.. => format!("{value:.0}"),
        10.0.. => format!("{value:.1}"),
        1.0.. => format!("{value:.2}"),
        0.01.. => format!("{value:.3}"),
        0.0001.. => format!("{value:.6}"),
        _ => format!("{value:.2e}"),
    }
}

/// A share in per cent, with digits enough to differ from none.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    let digits = if percent > 0.0 { (1.0 - libm::log10(percent).floor()).clamp(0.0, 9.0) as usize } else { 0 };
    format!("{percent:.digits$} %")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guards against figures of a fixed number of decimals, of which none is left where the number is small.
    #[test]
    fn no_figure_of_a_number_reads_as_none() {
        for exponent in -12..=6 {
            for lead in [1.0, 2.345, 9.994] {
                let value = lead * 10f64.powi(exponent);
                for value in [value, -value] {
                    let read: f64 = figure(value).parse().expect("a number");
                    assert!((read / value - 1.0).abs() < 0.05, "{value} as {}", figure(value));
                    assert!(figure(value).len() <= 9, "{}", figure(value));
                }
            }
        }
        assert_eq!([figure(0.0), figure(f64::NAN), figure(0.068)], ["0", "-", "0.068"]);
    }
}
