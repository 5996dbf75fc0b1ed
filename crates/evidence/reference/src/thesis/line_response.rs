//! Line response of the thesis' method: a laser line on a body, and a laser point on a map, spread as pictures.
//!
//! The body around the line is cut into square pixels. Each column's power is laid evenly over the width it stands for
//! and as a Gaussian across the line, spread, and collected again by overlap of areas, so that resampling keeps light.
//! All light leaves as Lambert's law says: the model has no directions.

use glam::DVec2;
use rayon::prelude::*;

use super::{LightPicture, PixelGround, SpreadMethod, ThesisSettings, spread};
use crate::columns::column_edges;
use transport::line::{LineResponse, LineSource};

/// What the picture shows beyond the wanted cells, on each side [mm].
const MARGIN_MM: f64 = 2.0;

/// Pixels along one axis.
#[derive(Debug, Clone, Copy)]
struct PixelAxis {
    /// Lower edge of the first [mm].
    from: f64,
    /// Size [mm].
    pitch: f64,
    /// Number.
    count: usize,
}

impl PixelAxis {
    /// The pixels that lie between two places, and the length of each that does [mm].
    fn between(self, low: f64, high: f64) -> impl Iterator<Item = (usize, f64)> {
        let place = move |at: f64| ((at - self.from) / self.pitch).floor().clamp(0.0, self.count as f64) as usize;
        let edge = move |i: usize| self.from + self.pitch * i as f64;
        (place(low)..(place(high) + 1).min(self.count))
            .map(move |i| (i, (high.min(edge(i + 1)) - low.max(edge(i))).max(0.0)))
    }

    /// Middle of the first pixel [mm].
    fn first(self) -> f64 {
        self.from + 0.5 * self.pitch
    }
}

/// The model's answer for a line on a body.
pub fn line_response(line: &LineSource, settings: &ThesisSettings) -> LineResponse {
    let (columns, side) = (line.x.len(), 2 * line.rows + 1);
    if columns == 0 {
        return LineResponse { columns, rows: line.rows, light: Vec::new(), error: Vec::new() };
    }
    let edges = column_edges(line.x, line.row_mm);
    let pitch = settings.pitch_mm;
    let across = edges[columns] - edges[0] + 2.0 * MARGIN_MM;
    let along = 0.5 * side as f64 * line.row_mm + MARGIN_MM;
    let xs = PixelAxis { from: edges[0] - MARGIN_MM, pitch, count: (across / pitch).ceil() as usize };
    // The line runs through the middle of a row.
    let half = (along / pitch - 0.5).ceil().max(0.0);
    let ys = PixelAxis { from: line.y - pitch * (half + 0.5), pitch, count: 2 * half as usize + 1 };

    let mut entering = vec![0.0; xs.count];
    for (pair, &power) in edges.windows(2).zip(line.power) {
        for (i, length) in xs.between(pair[0], pair[1]) {
            entering[i] += f64::from(power) * length / (pair[1] - pair[0]);
        }
    }
    let mut picture = LightPicture::dark(ys.count, xs.count);
    for (row, light) in picture.light.chunks_mut(xs.count).enumerate() {
        let low = pitch * (row as f64 - half - 0.5);
        let share = gaussian_share(low, low + pitch, line.line_mm);
        light.iter_mut().zip(&entering).for_each(|(light, power)| *light = share * power);
    }

    let ground = PixelGround::of_body(line.body, DVec2::new(xs.first(), ys.first()), pitch, ys.count, xs.count);
    let spread = spread(&picture, &ground, settings.method);

    let row = |k: usize| {
        let middle = line.y + line.row_mm * (k as f64 - line.rows as f64);
        let mut sums = vec![0.0; xs.count];
        for (i, length) in ys.between(middle - 0.5 * line.row_mm, middle + 0.5 * line.row_mm) {
            let light = &spread.light[i * xs.count..(i + 1) * xs.count];
            sums.iter_mut().zip(light).for_each(|(sum, light)| *sum += light * length / pitch);
        }
        let cell = |pair: &[f64]| xs.between(pair[0], pair[1]).map(|(i, length)| sums[i] * length / pitch).sum::<f64>();
        edges.windows(2).map(|pair| cell(pair) as f32).collect::<Vec<_>>()
    };
    let light = (0..side).into_par_iter().flat_map_iter(row).collect();
    LineResponse { columns, rows: line.rows, light, error: Vec::new() }
}

/// Share of a normal law of this standard deviation between two places.
fn gaussian_share(low: f64, high: f64, deviation: f64) -> f64 {
    let scale = std::f64::consts::FRAC_1_SQRT_2 / deviation.max(1e-9);
    0.5 * (libm::erf(high * scale) - libm::erf(low * scale))
}

/// A laser point: a filled circle with a Gaussian profile, unit light in all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaserPoint {
    /// Middle as (column, row) [px].
    pub at: DVec2,
    /// Diameter; the thesis' is 55 [px].
    pub diameter: f64,
    /// Standard deviation of the Gaussian, which the thesis does not state [px].
    pub deviation: f64,
}

impl LaserPoint {
    /// The thesis' point of 55 pixels at (column, row); at its edge are two standard deviations (our choice).
    pub fn thesis(at: DVec2) -> Self {
        Self { at, diameter: 55.0, deviation: 13.75 }
    }

    /// The point before it is spread.
    pub fn picture(&self, rows: usize, cols: usize) -> LightPicture {
        let at = |i: usize| {
            let far2 = (DVec2::new((i % cols) as f64, (i / cols) as f64) - self.at).length_squared();
            let inside = far2 <= 0.25 * self.diameter * self.diameter;
            if inside { libm::exp(-0.5 * far2 / (self.deviation * self.deviation)) } else { 0.0 }
        };
        let mut light: Vec<f64> = (0..rows * cols).map(at).collect();
        let sum: f64 = light.iter().sum();
        light.iter_mut().for_each(|light| *light /= sum.max(f64::MIN_POSITIVE));
        LightPicture { rows, cols, light }
    }
}

/// A laser point on `ground`: Figures 4.23 and 4.24 of the thesis with [`SpreadMethod::ON_CLEAR_WOOD`] and
/// [`SpreadMethod::ON_A_KNOT`].
pub fn point(ground: &PixelGround, spot: &LaserPoint, method: SpreadMethod) -> LightPicture {
    spread(&spot.picture(ground.map.rows(), ground.map.cols()), ground, method)
}
