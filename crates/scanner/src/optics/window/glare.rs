//! Veiling glare: light of the line that lens, window and the dust on them spread far about its image.
//!
//! Of all light a share g goes there (ISO 9358 measures it). Its law is a Moffat halo of exponent 2,
//!
//! ```text
//! 1 / (pi a^2) (1 + r^2 / a^2)^-2        half of it within a; across a line 1 / (2 a) (1 + x^2 / a^2)^-1.5
//! ```
//!
//! four round Gaussians by the fit of the laser's skirt ([`crate::optics::laser::SKIRT_COMPONENTS`]), each of which
//! factors into columns and rows. Light of all columns is blurred along the line, with the row that it comes from, and
//! laid on rows about the mean of these. Glare has photon noise and no speckle. g and the halo's shape are engineering
//! estimates. Light that has spread beside the line counts as light on it. Neglected: ghosts; glare of lamps, of
//! ambient light and of a second line; steps of the line's height within the halo, which count by their mean row.

use optical_bench::parameters::Bench;

use super::band::Band;
use super::electrons::Scratch;
use super::lit_profile::LitProfile;
use crate::optics::laser::SKIRT_COMPONENTS;
use crate::optics::light::{GlarePart, ROWS, ScanLine, blur};
use crate::optics::speckle::TILE;
use transport::kernel::BASIS;

/// The halo of a lens.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Glare {
    /// Light in it over that which is left in the image [1].
    ratio: f32,
    /// Radius of half of it [px].
    radius: f32,
}

impl Glare {
    /// Of a bench; `None` without.
    pub fn new(bench: &Bench) -> Option<Self> {
        let share = bench.camera.glare_share;
        let radius = (bench.camera.glare_um / bench.camera.pixel_um) as f32;
        (share > 0.0).then(|| Self { ratio: (share / (1.0 - share)) as f32, radius })
    }

    /// About the line of `profile`, which `band` holds.
    pub fn about(&self, band: &Band, profile: usize) -> Vec<GlarePart> {
        let line = band.line(profile);
        let all = all_light(line, band.volume(profile));
        let columns = line.hits.len();
        let mut buffer = Vec::new();
        SKIRT_COMPONENTS
            .iter()
            .map(|&(weight, sigma)| {
                let sigma = sigma as f32 * self.radius;
                let mut light: Vec<f32> = all[..columns].iter().map(|l| weight as f32 * self.ratio * l).collect();
                let mut row: Vec<f32> = light.iter().zip(&line.centre).map(|(light, row)| light * row).collect();
                for field in [&mut light, &mut row] {
                    blur(field, sigma * sigma, [1.0; 2], &mut buffer);
                }
                for ((row, light), own) in row.iter_mut().zip(&light).zip(&line.centre) {
                    *row = if *light > f32::MIN_POSITIVE { *row / light } else { *own };
                }
                light.resize(line.centre.len(), 0.0);
                row.resize(line.centre.len(), 0.0);
                GlarePart { light, row, variance: sigma * sigma }
            })
            .collect()
    }
}

/// All light of a line that the lens takes in, a column [e-].
fn all_light(line: &ScanLine, volume: Option<&[Vec<f32>; 2]>) -> Vec<f32> {
    let mut all = line.surface_light.clone();
    let padded = all.len();
    match volume {
        Some(windows) => {
            for (place, light) in windows.iter().flat_map(|window| window.iter().enumerate()) {
                all[place % padded] += light;
            }
        }
        None => {
            for (source, exit) in line.source.iter().zip(&line.exit) {
                all.iter_mut().zip(source.iter().zip(exit)).for_each(|(all, (source, exit))| *all += source * exit);
            }
            let Some(secondary) = &line.secondary else { return all };
            let through = &secondary.transmitted;
            let within = |tile: usize| through.columns.start < tile + TILE && through.columns.end > tile;
            for tile in (0..padded).step_by(TILE).filter(|&tile| within(tile)) {
                for j in 0..BASIS {
                    let leaves = through.leaves(j, tile).iter().zip(&through.source[j][tile..]);
                    all[tile..].iter_mut().zip(leaves).for_each(|(all, (exit, source))| *all += source * exit);
                }
            }
            secondary.reflections.iter().for_each(|image| all[image.column] += image.electrons);
        }
    }
    all
}

impl LitProfile<'_> {
    /// Adds glare to the windows of a tile.
    pub fn add_glare(&self, tile: usize, scratch: &mut Scratch) {
        let parts = self.band.glare_about(self.profile);
        if parts.is_empty() {
            return;
        }
        for window in &mut scratch.windows[..scratch.used] {
            window.ambient.resize(ROWS, [0.0; TILE]);
            for (k, pixels) in window.ambient.iter_mut().enumerate() {
                for part in parts {
                    for (c, pixel) in pixels.iter_mut().enumerate() {
                        *pixel += part.at(tile * TILE + c, (window.first_row[c] + k as i32) as f32);
                    }
                }
            }
        }
    }

    /// Glare in pixel `[row, column]` of the whole sensor [e-].
    pub fn glare_in(&self, [row, column]: [usize; 2]) -> f32 {
        self.band.glare_about(self.profile).iter().map(|part| part.at(column, row as f32)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Glare about light in one column, `(column, row)` of 1 electron, of a lens with a share of 0.02.
    fn about(columns: usize, at: (usize, f32), radius_um: f64) -> Band {
        let mut bench = Bench::default();
        (bench.camera.glare_share, bench.camera.glare_um) = (0.02, radius_um);
        let padded = columns.next_multiple_of(TILE);
        let hit = crate::specimen::Hit {
            x: 0.0,
            surface: base::Surface { z: 0.0, slope_x: 0.0, slope_y: 0.0 },
            matter: base::Matter {
                medium: base::Medium::opaque(base::Gloss::NONE),
                film: None,
                class: base::Class::Clear,
                instance: 0,
            },
            lit: true,
            seen: true,
        };
        let mut line = ScanLine { centre: vec![at.1; padded], hits: vec![hit; columns], ..ScanLine::default() };
        line.surface_light = vec![0.0; padded];
        line.surface_light[at.0] = 0.98;
        let mut band = Band { profiles: 0..1, lines: vec![line], ..Band::default() };
        band.glare = vec![Glare::new(&bench).expect("glare").about(&band, 0)];
        band
    }

    /// All of the share arrives, half of it within the radius, and across a line it has the law's projection.
    #[test]
    fn glare_keeps_light_and_has_its_law() {
        // 8 pixels of 6 um.
        let band = about(1025, (512, 500.3), 48.0);
        let parts = band.glare_about(0);
        let (mut all, mut within) = (0.0, 0.0);
        let mut rows = vec![0.0; 1001];
        for column in 0..1025 {
            for row in 0..1001 {
                let light: f32 = parts.iter().map(|part| part.at(column, row as f32)).sum();
                let r = (column as f64 - 512.0).hypot(f64::from(row as f32) - 500.3);
                all += f64::from(light);
                within += if r < 8.0 { f64::from(light) } else { 0.0 };
                rows[row] += f64::from(light);
            }
        }
        assert!((all / 0.02 - 1.0).abs() < 1e-3, "{all}");
        assert!((within / all - 0.5).abs() < 0.02, "{} within the radius", within / all);
        for off in [0, 4, 8, 16, 32, 60] {
            let x = (f64::from(off) - 0.3) / 8.0;
            let law = 0.02 * 0.5 / 8.0 * (1.0 + x * x).powf(-1.5);
            let got = rows[500 + off as usize];
            // The fit is within 2.2 % of its height.
            assert!((got - law).abs() < 0.025 * 0.02 * 0.5 / 8.0, "{off} rows off: {got} for {law}");
        }
    }
}
