//! The board's own direction: along which its light changes least, near its length.
//!
//! Model: light is summed along lines of every direction within 45 degrees of the board's length, under a Gaussian of 5
//! mm. Rings and streaks add up along their own direction alone, while marks across the grain (teeth of a saw, knives)
//! vanish in every sum. The direction under which sums change most from line to line, times the chance of a board's
//! fibres to be so far from its length (a Gaussian of 30 degrees), is the board's own.

use crate::raster::{Beyond, quantile, smooth};
use crate::texture::Cells;

/// Side of the cells [mm].
const CELL_MM: f32 = 0.4;
/// Standard deviation of the sums along lines [mm].
const ALONG_MM: f32 = 5.0;
/// Gaussian whose mean is no ring [mm].
const TREND_MM: f32 = 4.0;
/// Directions to either side of the length, and their step [deg].
const TURNS: i32 = 30;
const STEP_DEG: f32 = 1.5;
/// Rows of which one is made before the sums [1]: 1.6 mm of 5.
const GATHERED: usize = 4;
/// Standard deviation of what is expected [deg].
const EXPECTED_DEG: f32 = 30.0;
/// Light counts up to this over its median departure from the trend [1].
const MOST: f32 = 4.0;

/// Azimuth of the board's own direction [rad]; `lies_across` says that its length lies along the rows.
pub(crate) fn direction_of_length(
    log_light: &[f32],
    size: [usize; 2],
    pixel_mm: [f32; 2],
    counts: Option<&[bool]>,
    lies_across: bool,
) -> f32 {
    let (size_down, mm_down) =
        if lies_across { ([size[1], size[0]], [pixel_mm[1], pixel_mm[0]]) } else { (size, pixel_mm) };
    let cells = Cells::with_side(size_down, mm_down, CELL_MM);
    let [mut sums, mut weights] = [vec![0.0_f32; cells.count()], vec![0.0_f32; cells.count()]];
    for pixel in (0..log_light.len()).filter(|&pixel| counts.is_none_or(|counts| counts[pixel])) {
        let (row, col) = (pixel / size[1], pixel % size[1]);
        let cell = cells.of(if lies_across { [col, row] } else { [row, col] }, mm_down);
        sums[cell] += log_light[pixel];
        weights[cell] += 1.0;
    }
    let wide = [TREND_MM / cells.side_mm; 2];
    let trend = [&sums, &weights].map(|values| smooth(values, cells.size, wide, Beyond::Zero));
    let mut left: Vec<f32> = (0..cells.count())
        .map(
            |cell| if weights[cell] > 0.0 { sums[cell] / weights[cell] - trend[0][cell] / trend[1][cell] } else { 0.0 },
        )
        .collect();
    let mut sizes: Vec<f32> = left.iter().map(|value| value.abs()).collect();
    let most = MOST * quantile(&mut sizes, 0.5);
    left.iter_mut().for_each(|value| *value = value.clamp(-most, most));
    let energy = |turn: i32| {
        let angle = (turn as f32 * STEP_DEG).to_radians();
        let sheared = sheared(&left, &cells, libm::tanf(angle));
        let long = ALONG_MM * libm::cosf(angle) / cells.side_mm / GATHERED as f32;
        let along = smooth(&sheared, [sheared.len() / cells.size[1], cells.size[1]], [long, 0.0], Beyond::Zero);
        let change = along.windows(2).map(|pair| f64::from(pair[1] - pair[0]).powi(2)).sum::<f64>();
        let expected = libm::exp(-0.5 * f64::from(turn as f32 * STEP_DEG / EXPECTED_DEG).powi(2));
        change / f64::from(libm::cosf(angle)).powi(2) * expected
    };
    let energies: Vec<f64> = (-TURNS..=TURNS).map(energy).collect();
    let best = (0..energies.len()).max_by(|&a, &b| energies[a].total_cmp(&energies[b])).unwrap_or_default();
    let mut turn = best as f64 - f64::from(TURNS);
    if best > 0 && best + 1 < energies.len() {
        let [below, at, above] = [energies[best - 1], energies[best], energies[best + 1]];
        turn += 0.5 * (above - below) / (2.0 * at - above - below).max(f64::MIN_POSITIVE);
    }
    let found = (turn as f32 * STEP_DEG).to_radians();
    if lies_across { std::f32::consts::FRAC_PI_2 - found } else { found }
}

/// Values with each row moved by its distance from the middle times the slope, between two columns in proportion; some
/// rows are added up to one.
fn sheared(values: &[f32], cells: &Cells, slope: f32) -> Vec<f32> {
    let [rows, cols] = cells.size;
    // Slopes are 1 at most, so that no row moves farther than this.
    let margin = rows / 2 + 2;
    let mut line = vec![0.0; cols + 2 * margin];
    let mut moved = vec![0.0; rows.div_ceil(GATHERED) * cols];
    for row in 0..rows {
        let shift = slope * (row as f32 - 0.5 * (rows - 1) as f32);
        let whole = shift.floor();
        let part = shift - whole;
        line[margin..][..cols].copy_from_slice(&values[row * cols..][..cols]);
        let from = &line[(margin as isize + whole as isize) as usize..];
        let to = &mut moved[row / GATHERED * cols..][..cols];
        for (to, pair) in to.iter_mut().zip(from.windows(2)) {
            *to += pair[0] + part * (pair[1] - pair[0]);
        }
    }
    moved
}
