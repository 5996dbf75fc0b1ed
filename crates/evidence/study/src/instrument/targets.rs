//! Flat targets under the bench at its nominal values, and exposures of them by the simulator's own light and sensor.

use base::{Body, Gloss, Medium, Stream};
use procedural::flat::Flat;

use super::Trials;
use optical_bench::parameters::Bench;
use pipeline::Equipment;
use recipe::{Recipe, Scene};
use scanner::frame::Frame;
use scanner::optics::speckle::PatternCache;
use scanner::optics::{Band, ROWS, Scratch, Sensor, TILE, TileOfProfile};

/// First profile that looks at nothing but the conveyor where the target is [`bare`].
pub(super) const BARE_PROFILE: usize = 64;
/// Gloss of the metal plate: facets alone, so that light leaves where it entered.
const METAL: Gloss = Gloss { share: 1.0, reflectance: 0.5, roughness: [0.45; 2], matte: 0.0 };

/// Every number of the bench at its declared default, over a scene with the extraction of the small recipe.
pub(super) fn scene(stream: Stream, columns: usize, profiles: usize) -> Scene {
    let recipe = Recipe::parse("wood-small.yaml", include_str!("../../../../../recipes/wood-small.yaml"));
    let mut scene = recipe.expect("the recipe that is built in loads").draw(0, 0);
    scene.bench = Bench::default();
    (scene.size.columns, scene.size.profiles, scene.stream) = (columns, profiles, stream);
    scene
}

/// The stream of one repeat of a study.
pub(super) fn stream(study: &str, trials: Trials, repeat: u64) -> Stream {
    Stream::root(trials.seed).child("study").child(study).index(repeat)
}

/// A wide plate of metal: height at the origin [mm], dz/dx, dz/dy.
pub(super) fn plate(height_mm: f32, slope_x: f32, slope_y: f32) -> Body {
    flat(Medium::opaque(METAL), height_mm, slope_x, slope_y)
}

/// A level plate of dense white ceramic: light leaves some thousandths of a mm from where it entered [mm].
pub(super) fn ceramic(height_mm: f32) -> Body {
    flat(Medium::isotropic(5.0, 1500.0, 1.0, Gloss::NONE), height_mm, 0.0, 0.0)
}

fn flat(medium: Medium, height_mm: f32, slope_x: f32, slope_y: f32) -> Body {
    Body::new(Flat { height_mm, slope_x, slope_y, width_mm: 600.0, length_mm: 400.0, medium })
}

/// The radiance factor of the plate of metal for light along `light` seen along `view` [1].
pub(super) fn metal_radiance_factor(light: glam::Vec3, view: glam::Vec3) -> f64 {
    f64::from(transport::fresnel::gloss(&METAL, glam::Vec3::Z, light, view))
}

/// A plate so small that from profile [`BARE_PROFILE`] on only the conveyor is seen, a white
/// Lambertian plane at z = 0 where its reflectance is 1.
pub(super) fn bare() -> Body {
    let medium = Medium::opaque(Gloss::NONE);
    Body::new(Flat { height_mm: 0.01, slope_x: 0.0, slope_y: 0.0, width_mm: 1.0, length_mm: 1.0, medium })
}

/// Switches photon noise and row noise off and sets the least read noise.
pub(super) fn quiet(scene: &mut Scene) {
    let exposure = &mut scene.bench.exposure;
    exposure.shot_noise = 0.0;
    (exposure.dark_noise_dn, exposure.row_noise_dn, exposure.row_pattern_dn) = (0.3, 0.0, 0.0);
}

/// Digital numbers per electron of a scene [DN/e-].
pub(super) fn gain(scene: &Scene) -> f64 {
    let exposure = &scene.bench.exposure;
    (255.0 - exposure.dark_level_dn) / exposure.full_well_e
}

/// Some profiles of a target, ready to be exposed.
pub(crate) struct TargetView {
    sensor: Sensor,
    pub band: Band,
    columns: usize,
}

impl TargetView {
    /// View of `profiles` of a scene with a target under its bench.
    pub(crate) fn new<'e>(
        scene: &Scene,
        body: Body,
        by: impl Into<Equipment<'e>>,
        profiles: std::ops::Range<usize>,
    ) -> Self {
        let (sensor, specimen) = pipeline::set_up(scene, body, by);
        let band = sensor.band(&specimen, profiles);
        Self { sensor, band, columns: scene.size.columns }
    }

    /// Contrast of speckle in each row of a profile's middle column, light from below [1].
    pub(super) fn contrasts_from_below(&self, profile: usize) -> [f64; ROWS] {
        let (patterns, line) = (self.sensor.speckle_contrast()[1], self.band.line(profile));
        std::array::from_fn(|row| f64::from(patterns * line.contrast_in_row(self.columns / 2, row)))
    }

    /// Light of a profile before any noise, `[ROWS, columns]`, row-major [e-].
    pub(crate) fn light(&self, profile: usize) -> Vec<f64> {
        let mut light = vec![0.0; ROWS * self.columns];
        let mut scratch = Scratch::default();
        for column in 0..self.columns {
            if column.is_multiple_of(TILE) {
                self.sensor.window(&self.band, profile, column / TILE, &mut scratch);
            }
            for k in 0..ROWS {
                light[k * self.columns + column] = f64::from(scratch.electrons(k, column % TILE));
            }
        }
        light
    }

    /// One exposure of all columns.
    pub(super) fn frame(&self, profile: usize) -> Frame {
        let (mut scratch, mut frames, mut offsets) = (Scratch::default(), <[Frame; 2]>::default(), Vec::new());
        self.sensor.row_offsets(profile, &mut offsets);
        let mut whole = Frame {
            cols: self.columns,
            rows: ROWS,
            first_col: 0,
            first_row: vec![0; self.columns],
            dn: vec![0; ROWS * self.columns],
        };
        for number in 0..self.columns.div_ceil(TILE) {
            self.sensor.expose(
                &TileOfProfile { band: &self.band, profile, tile: number, offsets: &offsets },
                &mut scratch,
                &mut frames,
            );
            // Targets are no packs: one window holds all light.
            let tile = &frames[0];
            let first = tile.first_col;
            whole.first_row[first..first + tile.cols].copy_from_slice(&tile.first_row);
            for k in 0..ROWS {
                whole.dn[k * self.columns + first..][..tile.cols]
                    .copy_from_slice(&tile.dn[k * tile.cols..][..tile.cols]);
            }
        }
        whole
    }

    /// The full sensor frame of a profile, `[rows, columns]`, row-major [DN].
    pub(super) fn sensor_frame(&self, profile: usize) -> Vec<u16> {
        self.sensor.full_frame(&self.band, profile)
    }
}

/// Sets the exposure time so that the middle column's greatest pixel holds `peak` [DN over dark].
pub(super) fn expose_to_peak(scene: &mut Scene, body: &Body, patterns: &PatternCache, profile: usize, peak: f64) {
    let look = TargetView::new(scene, body.clone(), patterns, profile..profile + 1);
    let (light, columns) = (look.light(profile), scene.size.columns);
    let most = (0..ROWS).map(|k| light[k * columns + columns / 2]).fold(0.0, f64::max);
    scene.bench.exposure.time_us *= peak / (gain(scene) * most);
}
