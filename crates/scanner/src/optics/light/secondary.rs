//! Secondary light: what the camera sees of a line besides the line itself, where there is film.

use super::tile::{UNIT_EXIT, load};
use super::widths::{NARROW_WIDTHS, NEAR_WIDTHS};
use crate::optics::speckle::TILE;
use crate::specimen::cavity::CavityLight;
use multiversion::multiversion;
use transport::kernel::{BASIS, PACK_SPREAD_MM};

/// Columns by which patches are apart.
pub(crate) const STRIDE: usize = 4;
/// Patches of a tile.
pub(crate) const PER_TILE: usize = TILE / STRIDE;

/// The column in the middle of the patch that begins at `column`, of so many columns.
pub(crate) fn middle_of(column: usize, columns: usize) -> usize {
    (column + STRIDE / 2).min(columns - 1)
}

/// Square of the distance under which patches are no points to each other: light spreads about as far in films before
/// it leaves, and samples lie about as far apart [mm^2].
pub(crate) const NEAR_MM2: f32 = 0.06;

/// Patches of a line that send light to each other, structure of arrays padded to whole tiles.
#[derive(Debug, Clone, Default)]
pub struct Patches {
    /// Place along the line [mm].
    pub(crate) x: Vec<f32>,
    /// Height [mm].
    pub(crate) z: Vec<f32>,
    pub(crate) slope_x: Vec<f32>,
    pub(crate) slope_y: Vec<f32>,
    /// Flux of the line that the patch sends out, by length of the normal (-slope_x, -slope_y, 1); as light that a
    /// white Lambertian surface shows the lens [e-].
    pub(crate) sends: Vec<f32>,
    /// The same of light that has spread far in the film, which leaves about the line with a standard deviation of
    /// `glow_mm` along the motion.
    pub(crate) glows: Vec<f32>,
    pub(crate) glow_mm: Vec<f32>,
    /// What of a flux by area of the level plane the patch sends on, by length of the line along the motion and of the
    /// normal [mm].
    pub(crate) returns: Vec<f32>,
    /// What of a flux by area of the level plane a column shows to the lens, by length of the line along the motion,
    /// over pi; 0 where the lens does not see it [mm].
    pub(crate) shows: Vec<f32>,
    /// What it shows to the lens of light by its own area, as Lambertian surfaces show all of it towards their normal
    /// [1].
    pub(crate) facing: Vec<f32>,
    /// Whether any patch of a tile faces others.
    pub(crate) uneven: Vec<bool>,
}

/// What pockets let out of a line's light, and what its columns show of others'.
#[derive(Debug, Clone, Default)]
pub(crate) struct PocketLight {
    /// In each cavity that the line crosses.
    pub lit: Vec<CavityLight>,
    /// What of light by area film over pockets shows, a patch [1].
    pub shows: Vec<f32>,
    /// Light of the line that the near widths hold, a patch [e-].
    pub near: [Vec<f32>; NEAR_WIDTHS],
}

/// What a line sends to the camera besides its line, and where its windows of sensor lines stand for that.
#[derive(Debug, Clone, Default)]
pub struct SecondaryLight {
    /// The line through the film.
    pub transmitted: TransmittedLine,
    /// Mirror images, by rising column.
    pub reflections: Vec<Reflection>,
    /// What sends light to other parts of the body, and shows theirs.
    pub(crate) patches: Patches,
    /// What pockets let out of its light.
    pub(crate) pockets: PocketLight,
    /// Sensor row of the first row of each window, a column [px].
    pub windows: [Vec<i32>; 2],
    /// Whether a tile of columns needs more than its line's own window.
    pub needs: Vec<WindowNeed>,
}

impl SecondaryLight {
    /// Mirror images in the columns of a tile.
    pub fn tile(&self, tile: usize) -> &[Reflection] {
        let at = |column: usize| self.reflections.partition_point(|reflection| reflection.column < column);
        &self.reflections[at(tile * TILE)..at((tile + 1) * TILE)]
    }
}

/// Windows that a tile of columns needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum WindowNeed {
    /// The line's own window holds all there is.
    #[default]
    Line,
    /// More light, in one window.
    One,
    /// More light, in two windows.
    Two,
}

/// The line that is seen through a film, structure of arrays over sensor columns, padded to whole tiles.
#[derive(Debug, Clone, Default)]
pub struct TransmittedLine {
    /// Sensor row of the line's centre [px].
    pub centre: Vec<f32>,
    /// Rows per mm along the motion [px/mm].
    pub rows_per_mm: Vec<f32>,
    /// Variance of laser, lens and pixel [px^2].
    pub variance: Vec<f32>,
    /// Light towards the lens, by width, spread along the line, `[BASIS][columns]` [sqrt(1) e-].
    pub source: [Vec<f32>; BASIS],
    /// Where the light that a pocket's tablet or foil shows here has come from: a place along the line, and how far
    /// along the motion from here [mm].
    pub(crate) lands: [Vec<f32>; 2],
    /// What of that light by area is seen; 0 where there is no pocket [1].
    pub(crate) shows: Vec<f32>,
    /// Light of the line that film has thrown down before and that the near widths hold [e-].
    pub(crate) near: [Vec<f32>; NEAR_WIDTHS],
    /// Factor by which each width leaves here through the film, `[BASIS][columns]`; narrow ones have left already
    /// [sqrt(1)].
    pub exit: [Vec<f32>; BASIS],
    /// Whether metal throws it back.
    pub metal: Vec<bool>,
    /// Columns that hold any of it.
    pub columns: std::ops::Range<usize>,
}

impl TransmittedLine {
    /// Factors by which width `j` of another line's line leaves here in the tile that begins at column `start`
    /// [sqrt(1)].
    #[inline(always)]
    pub(crate) fn leaves(&self, j: usize, start: usize) -> &[f32; TILE] {
        if j < NARROW_WIDTHS { &UNIT_EXIT } else { load(&self.exit[j], start) }
    }

    /// Fills `peaks` with the light in the brightest row of the transmitted line, for each column that holds any [e-].
    pub(crate) fn peaks(&self, peaks: &mut Vec<f32>) {
        let columns = self.columns.clone();
        peaks.clear();
        peaks.resize(columns.len(), 0.0);
        let (variance, rows_per_mm) = (&self.variance[columns.clone()], &self.rows_per_mm[columns.clone()]);
        for (j, spread_mm) in PACK_SPREAD_MM.into_iter().enumerate() {
            let light = [&self.source[j][columns.clone()], &self.exit[j][columns.clone()]];
            add_peaks(spread_mm, light, [variance, rows_per_mm], peaks);
        }
    }
}

/// Adds the middles of Gaussians of one fixed width, a column each, by the two factors of their light, their variances
/// without that width and rows per mm [e-].
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn add_peaks(spread_mm: f32, [source, exit]: [&[f32]; 2], [variance, rows_per_mm]: [&[f32]; 2], peaks: &mut [f32]) {
    let n = peaks.len();
    let (source, exit, variance, rows_per_mm) = (&source[..n], &exit[..n], &variance[..n], &rows_per_mm[..n]);
    for c in 0..n {
        let sigma = spread_mm * rows_per_mm[c];
        peaks[c] += 0.398_942_3 * (source[c] * exit[c]) / (variance[c] + sigma * sigma).sqrt();
    }
}

/// Mirror image of the line in one column: a Gaussian along the rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflection {
    /// Sensor column [px].
    pub column: usize,
    /// Sensor row of its centre [px].
    pub row: f32,
    /// Its variance along the rows [px^2].
    pub variance: f32,
    /// All of its light in this column [e-].
    pub electrons: f32,
    /// Whether foil shows it below a film, which models that follow light through packs draw themselves.
    pub in_foil: bool,
}

impl Reflection {
    /// Light in its brightest row [e-].
    pub fn peak(&self) -> f32 {
        0.398_942_3 * self.electrons / self.variance.sqrt()
    }
}
