//! The same scene for production and for the reference.

use base::{Body, Gloss, Medium};
use glam::DVec3;
use optical_bench::parameters::Bench;
use pipeline;
use recipe::Scene;
use scanner::optics::{ROWS, Scratch, TILE};

use super::eye::Eye;
use super::light::Light;
use super::object::{Facet, Object};
use super::verdict::Verdict;
use super::{Picture, Region, picture};
use test_support::target;

/// Rows of every sensor here [px].
pub const SENSOR_ROWS: usize = 832;

/// Matter that throws back `share` of the light evenly and none of it from below.
pub fn matte(share: f32) -> Medium {
    Medium { mu_a: 1.0e6, ..Medium::opaque(Gloss { matte: share, ..Gloss::NONE }) }
}

/// A scene of the nominal bench on a sensor of `columns` columns.
pub fn scene(columns: usize) -> Scene {
    let mut scene = target::scene(400);
    (scene.size.columns, scene.size.rows) = (columns, SENSOR_ROWS);
    // A scene of its own is held to Airy's rings.
    scene.bench.optics.diffraction = false;
    scene
}

/// A scene as both sides see it.
pub struct Trial<'a> {
    pub name: &'a str,
    pub scene: &'a Scene,
    /// Under production.
    pub body: Body,
    /// The laser stands here over the body.
    pub profile: usize,
    /// Under the reference, as triangles in the body's own coordinates [mm].
    pub facets: Vec<Facet>,
    /// Lowest and highest place of it [mm].
    pub heights: [f64; 2],
    pub first_col: usize,
    pub cols: usize,
    pub rays: usize,
}

impl Trial<'_> {
    /// The reference's camera at the scene's numbers.
    pub fn eye(&self) -> Eye {
        Eye::new(&self.scene.bench, self.scene.size.columns, self.scene.size.rows)
    }

    /// Range of tan(theta) that lights the columns judged, with room for blur on both sides.
    pub fn tans(&self, eye: &Eye) -> [f64; 2] {
        let bench: &Bench = &self.scene.bench;
        let ends = [self.first_col as f64 - 5.0, (self.first_col + self.cols) as f64 + 4.0];
        let corner = |col: f64, z: f64| {
            // The chief ray's column is linear in x to first order: two steps of the secant suffice.
            let column = |x: f64| eye.chief(DVec3::new(x, 0.0, z))[0];
            let (mut x, step) = (0.0, 0.1);
            for _ in 0..20 {
                x += (col - column(x)) * step / (column(x + step) - column(x));
            }
            x / (bench.laser.fan_height_mm - z)
        };
        let all: Vec<f64> = ends.iter().flat_map(|&c| self.heights.map(|z| corner(c, z))).collect();
        [all.iter().copied().fold(f64::MAX, f64::min), all.iter().copied().fold(f64::MIN, f64::max)]
    }

    /// Production's electrons in the columns judged, on the rows that its windows reach `[rows, cols]` [e-].
    pub fn production(&self) -> (Region, Vec<f64>) {
        let (sensor, specimen) = pipeline::set_up(self.scene, self.body.clone(), target::patterns());
        let band = sensor.band(&specimen, self.profile..self.profile + 1);
        let mut scratch = Scratch::default();
        let mut columns: Vec<Vec<(i32, f64)>> = Vec::new();
        for col in self.first_col..self.first_col + self.cols {
            if columns.is_empty() || col.is_multiple_of(TILE) {
                sensor.window(&band, self.profile, col / TILE, &mut scratch);
            }
            let c = col % TILE;
            let mut column = Vec::new();
            for window in &scratch.windows[..scratch.used] {
                let light = |k: usize| f64::from(window.volume[k][c] + window.surface[k][c]);
                column.extend((0..ROWS).map(|k| (window.first_row[c] + k as i32, light(k))));
            }
            columns.push(column);
        }
        let rows = || columns.iter().flatten().map(|&(row, _)| row);
        let first_row = rows().min().unwrap_or(0).max(0);
        let last = rows().max().unwrap_or(0).min(self.scene.size.rows as i32 - 1);
        let region =
            Region { first_col: self.first_col, cols: self.cols, first_row, rows: (last - first_row + 1) as usize };
        let mut light = vec![0.0; region.rows * region.cols];
        for (c, column) in columns.iter().enumerate() {
            for &(row, electrons) in column {
                if (first_row..=last).contains(&row) {
                    light[(row - first_row) as usize * region.cols + c] += electrons;
                }
            }
        }
        (region, light)
    }

    /// The reference's electrons under `light` and `eye` on a region of the sensor.
    pub fn reference(&self, light: &Light, eye: &Eye, region: Region) -> Picture {
        let y = self.profile as f64 * self.scene.bench.motion.step_mm;
        let moved = |facet: &Facet| Facet { corners: facet.corners.map(|c| c - DVec3::Y * y), ..*facet };
        let object = Object::new(self.facets.iter().map(moved).collect());
        // A seed of its own for each scene: its name.
        let seed = self.name.bytes().fold(0u64, |seed, byte| seed.wrapping_mul(257).wrapping_add(u64::from(byte)));
        picture(light, &object, eye, region, self.rays, seed)
    }

    /// Both sides under a Gaussian sheet behind a Powell lens and the camera of the scene.
    pub fn compare(&self) -> Verdict {
        let eye = self.eye();
        let light = Light::plain(&self.scene.bench.laser, self.tans(&eye));
        self.compare_under(&light, &eye)
    }

    /// Both sides, the reference's under `light` and `eye`.
    pub fn compare_under(&self, light: &Light, eye: &Eye) -> Verdict {
        let (region, production) = self.production();
        Verdict { name: self.name.to_owned(), reference: self.reference(light, eye, region), production }
    }
}

/// A plane z = height + slope . (x, y) over a wide rectangle that starts at y = 0, black underneath.
pub fn plane(height: f64, slope: [f64; 2], matte: f64) -> Vec<Facet> {
    let at = |x: f64, y: f64| DVec3::new(x, y, height + slope[0] * x + slope[1] * y);
    let (half, length) = (200.0, 400.0);
    Facet::quad([at(-half, 0.0), at(half, 0.0), at(half, length), at(-half, length)], matte).to_vec()
}

/// A box with a matte top and black walls.
pub fn box_of(x: [f64; 2], y: [f64; 2], z: [f64; 2], matte: f64) -> Vec<Facet> {
    let at = |i: usize, j: usize, k: usize| DVec3::new(x[i], y[j], z[k]);
    let top = Facet::quad([at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)], matte);
    let sides = [
        [at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)],
        [at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1)],
        [at(1, 1, 0), at(0, 1, 0), at(0, 1, 1), at(1, 1, 1)],
        [at(0, 1, 0), at(0, 0, 0), at(0, 0, 1), at(0, 1, 1)],
    ];
    top.into_iter().chain(sides.into_iter().flat_map(|side| Facet::quad(side, 0.0))).collect()
}
