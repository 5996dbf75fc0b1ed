//! Reading the laser line off exposures: means of frames, a Gaussian through the line, a beam through its widths.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::beam::electrons;
use super::laser::{EXPOSURES, HEIGHTS};
use super::setup::{BARE, Look, gain};
use crate::optics::parameters::Bench;
use crate::optics::speckle::Tiles;
use crate::optics::{CENTRE, ROWS};
use crate::recipe::Scene;

/// Columns taken together along the line.
pub(super) const BIN: usize = 40;

/// Mean of some exposures less the same without light, a row of the window after another, `[ROWS][columns]` [e-].
pub(super) fn line(scene: &Scene, body: &procedural::Body, tiles: &Tiles) -> Vec<Vec<f64>> {
    let profiles = BARE..BARE + EXPOSURES;
    let mut dark = scene.clone();
    // As little light as there may be, other noise, the same fixed pattern.
    (dark.bench.laser.power_mw, dark.bench.exposure.time_us) = (0.01, 0.1);
    let lit = Look::at(scene, body.clone(), tiles, profiles.clone());
    let unlit = Look::at(&dark, body.clone(), tiles, profiles.start + EXPOSURES..profiles.end + EXPOSURES);
    let scale = 1.0 / (gain(scene) * EXPOSURES as f64);
    let columns = scene.size.columns;
    let mut sum = vec![vec![0.0; columns]; ROWS];
    for profile in profiles {
        let (bright, dark) = (lit.frame(profile), unlit.frame(profile + EXPOSURES));
        for (k, row) in sum.iter_mut().enumerate() {
            for (c, sum) in row.iter_mut().enumerate() {
                let at = k * columns + c;
                *sum += scale * (f64::from(bright.dn[at]) - f64::from(dark.dn[at]));
            }
        }
    }
    sum
}

/// Light, centre and standard deviation of a Gaussian by least squares (Gauss and Newton) [e-, px, px].
pub(super) fn gaussian(line: &[f64]) -> [f64; 3] {
    let peak = (0..line.len()).max_by(|&a, &b| line[a].total_cmp(&line[b])).unwrap_or(0);
    let mut p = [2.5 * line[peak], peak as f64, 1.0];
    for _ in 0..30 {
        let (mut m, mut r) = ([[0.0; 3]; 3], [0.0; 3]);
        for (k, value) in line.iter().enumerate() {
            let t = (k as f64 - p[1]) / p[2];
            let shape = libm::exp(-0.5 * t * t) / ((2.0 * PI).sqrt() * p[2]);
            let slope = [shape, p[0] * shape * t / p[2], p[0] * shape * (t * t - 1.0) / p[2]];
            for i in 0..3 {
                r[i] += slope[i] * (value - p[0] * shape);
                for j in 0..3 {
                    m[i][j] += slope[i] * slope[j];
                }
            }
        }
        let matrix = DMat3::from_cols_array_2d(&m);
        let step = matrix.inverse() * DVec3::from_array(r);
        p = [p[0] + step.x, p[1] + step.y, (p[2] + step.z).clamp(0.3, 8.0)];
    }
    p
}

/// Mean over columns.
pub(super) fn mean_line(line: &[Vec<f64>]) -> Vec<f64> {
    line.iter().map(|row| row.iter().sum::<f64>() / row.len() as f64).collect()
}

/// Light of each bin of columns: rows about the middle that hold it all [e-].
pub(super) fn bins(line: &[Vec<f64>]) -> Vec<f64> {
    let rows = &line[CENTRE - 8..=CENTRE + 8];
    let column = |c: usize| rows.iter().map(|row| row[c]).sum::<f64>();
    let bin = line[0].len().min(BIN);
    (0..line[0].len() / bin).map(|b| (b * bin..(b + 1) * bin).map(column).sum::<f64>() / bin as f64).collect()
}

/// Waist, its height and M^2 from the parabola w^2 = a + b z + c z^2 through measured widths [mm, mm, 1].
pub(super) fn beam(width: &[f64], wavelength_nm: f64) -> [f64; 3] {
    let (mut m, mut r) = ([[0.0; 3]; 3], DVec3::ZERO);
    for (z, w) in HEIGHTS.into_iter().zip(width) {
        let (terms, weight) = (DVec3::new(1.0, z, z * z), w.powi(-4));
        r += weight * w * w * terms;
        for (i, column) in m.iter_mut().enumerate() {
            for (j, entry) in column.iter_mut().enumerate() {
                *entry += weight * terms[i] * terms[j];
            }
        }
    }
    let p = DMat3::from_cols_array_2d(&m).inverse() * r;
    let least = p.x - p.y * p.y / (4.0 * p.z);
    let rayleigh = (least / p.z).sqrt();
    [least.sqrt(), -0.5 * p.y / p.z, PI * least / (rayleigh * wavelength_nm * 1e-6)]
}

/// Distance from the middle at which the light along the line is half of what an even line has there [mm].
pub(super) fn half_light(bins: &[f64], bench: &Bench, place: impl Fn(usize) -> f64) -> f64 {
    let mut even = *bench;
    even.laser.fan_angle_deg = 60.0;
    let share = |i: usize| bins[i] / electrons(&even, place(i), 0.0);
    let full = share(bins.len() / 2);
    let ends = [1.0, -1.0].map(|side| {
        let at = |i: usize| if side > 0.0 { bins.len() / 2 + i } else { bins.len() / 2 - 1 - i };
        let i = (1..bins.len() / 2).find(|&i| share(at(i)) < 0.5 * full).unwrap_or(1);
        let (near, far) = (share(at(i - 1)), share(at(i)));
        let t = (near - 0.5 * full) / (near - far);
        let (from, to) = (place(at(i - 1)).abs(), place(at(i)).abs());
        from + t * (to - from)
    });
    0.5 * (ends[0] + ends[1])
}
