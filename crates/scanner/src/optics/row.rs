//! Light of one row of the specimen, as the camera sees it when the laser stands on that row.
//!
//! Subsurface response depends only on the body, so a row is worked out once for each position of the scan and used by
//! every profile whose window holds it: as the source of its own line, and as the exit of its neighbours' light.

use super::coherence::{CONTRAST_COLUMNS, RowContrasts};
use super::mixed_columns::MixedColumn;
use super::speckle::TILE;
use super::streak::Streak;
use super::widths::{NARROW_WIDTHS, NEAR_WIDTHS};
use super::window::{UNIT_EXIT, load};
use crate::specimen::Hit;
use crate::specimen::cavity::CavityLight;
use transport::kernel::{BASIS, PACK_SPREAD_MM};

/// Numbers of one position of the scan, structure of arrays over sensor columns, padded with zeros to whole tiles.
#[derive(Debug, Clone, Default)]
pub struct Row {
    /// Place along the motion [mm].
    pub y_mm: f32,
    /// Rows per mm along the motion of a level surface in the middle, as high as the row's highest place [px/mm].
    pub level_rows_per_mm: f32,
    /// Standard deviations of the fixed widths [mm].
    pub spread_mm: [f32; BASIS],
    /// What each column sees; noise-free truth.
    pub hits: Vec<Hit>,
    /// Whether each column sees the bare conveyor; not padded.
    pub bare: Vec<bool>,
    /// Sensor row of the line's centre [px].
    pub centre: Vec<f32>,
    /// Rows per mm along the motion [px/mm].
    pub rows_per_mm: Vec<f32>,
    /// Rows per mm along the way that light spreads on: of a film, which keeps light to itself, along its slope [px/mm].
    pub spread_rows_per_mm: Vec<f32>,
    /// Variance of laser, lens and pixel [px^2].
    pub variance: Vec<f32>,
    /// Whether each column's line on film is hidden from the lens; empty without film.
    pub hidden: Vec<bool>,
    /// Whether each column's film stands over the air of a pocket; empty without film.
    pub rooms: Vec<bool>,
    /// Unit of the laser's line profile; empty for a Gaussian line [px].
    pub profile_unit: Vec<f32>,
    /// Position along the line profile's nodes; empty for a Gaussian line [1].
    pub profile_node: Vec<f32>,
    /// Radius along the rows of the circle of confusion, whose variance `variance` holds; empty where nothing can be out
    /// of focus [px].
    pub defocus_radius: Vec<f32>,
    /// Light thrown back by the surface itself [e-].
    pub surface_light: Vec<f32>,
    /// Light that entered below the surface, as a white Lambertian surface would return it to the lens [e-].
    pub entered_light: Vec<f32>,
    /// Light that entered, by width, spread along the line, `[BASIS][columns]` [sqrt(1) e-].
    pub source: [Vec<f32>; BASIS],
    /// Shift of each width's light against the centre, `[BASIS][columns]` [px].
    pub shift: [Vec<f32>; BASIS],
    /// Factor by which each width leaves here towards the lens, `[BASIS][columns]` [sqrt(1)].
    pub exit: [Vec<f32>; BASIS],
    /// The same for light of rows behind this one, which leaves through a front face where this row is bare: of the tiles in
    /// which that makes a difference.
    pub front: Vec<FrontTile>,
    /// Greatest exits in each tile of columns, but for the front faces [sqrt(1)].
    pub greatest_exits: Vec<[f32; BASIS]>,
    /// Contrasts of speckle in light from below beside the line, of that of the patterns, for every [`CONTRAST_COLUMNS`] columns [1].
    pub(crate) contrasts: Vec<RowContrasts>,
    /// Ambient light in a pixel that looks here; empty where there is none [e-].
    pub ambient: Vec<f32>,
    /// What else of this line's light the camera sees; `None` for a body that cannot send it elsewhere.
    pub secondary: Option<Box<SecondaryLight>>,
    /// Columns that see past an edge, by rising column.
    pub mixed: Vec<MixedColumn>,
    /// Single fibres that guide light out of the line, by rising column.
    pub streaks: Vec<Streak>,
}

impl Row {
    /// Contrast of speckle on the line in light from below, of that of the sample's patterns [1].
    pub fn contrast_on_line(&self, column: usize) -> f32 {
        self.contrasts[column / CONTRAST_COLUMNS][0]
    }

    /// Contrasts of the columns of a tile, [`CONTRAST_COLUMNS`] together.
    pub(crate) fn contrasts_of(&self, tile: usize) -> &[RowContrasts] {
        let groups = TILE / CONTRAST_COLUMNS;
        &self.contrasts[tile * groups..][..groups]
    }

    /// Radii of the circles of confusion of a tile; `None` where all is sharp.
    pub(crate) fn defocus_radius_of(&self, start: usize) -> Option<&[f32; TILE]> {
        self.defocus_radius.get(start..)?.first_chunk()
    }

    /// Which columns of a tile have film over the air of a pocket; `None` without film.
    pub(crate) fn rooms_of(&self, start: usize) -> Option<&[bool; TILE]> {
        self.rooms.get(start..)?.first_chunk()
    }

    /// Which columns of a tile have their line on film where the lens does not see it; `None` where none has.
    pub(crate) fn hidden_of(&self, start: usize) -> Option<&[bool; TILE]> {
        self.hidden.get(start..)?.first_chunk().filter(|hidden| hidden.contains(&true))
    }

    /// Light in the brightest row of a column's line [e-].
    pub(crate) fn line_peak(&self, column: usize) -> f32 {
        let rows_per_mm = self.spread_rows_per_mm[column];
        peak(&self.spread_mm, self.surface_light[column], self.variance[column], rows_per_mm, |j| {
            self.source[j][column] * self.exit[j][column]
        })
    }
}

/// What leaves through a front face, in one tile of a bare row.
#[derive(Debug, Clone, PartialEq)]
pub struct FrontTile {
    /// First column of the tile.
    pub start: usize,
    /// Factors by which each width would leave here if the surface went on [sqrt(1)].
    pub exit: [[f32; TILE]; BASIS],
    /// Place of the front edge along the motion [mm].
    pub edge_mm: [f32; TILE],
    /// Distance of this row from there [mm].
    pub before_mm: [f32; TILE],
    /// Depth of the face that the lens sees in this row, beyond any depth below its foot; 0 where there is none [mm].
    pub depth_mm: [f32; TILE],
    /// Height of the face [mm].
    pub height_mm: [f32; TILE],
}

/// Patches of a row that send light to each other, structure of arrays padded to whole tiles.
#[derive(Debug, Clone, Default)]
pub struct Patches {
    /// Place along the line [mm].
    pub(super) x: Vec<f32>,
    /// Height [mm].
    pub(super) z: Vec<f32>,
    pub(super) slope_x: Vec<f32>,
    pub(super) slope_y: Vec<f32>,
    /// Flux of the line that the patch sends out, by length of the normal (-slope_x, -slope_y, 1); as light that a white Lambertian surface shows the lens [e-].
    pub(super) sends: Vec<f32>,
    /// The same of light that has spread far in the film, which leaves about the line with a standard deviation of `glow_mm` along the motion.
    pub(super) glows: Vec<f32>,
    pub(super) glow_mm: Vec<f32>,
    /// What of a flux by area of the level plane the patch sends on, by length of the line along the motion and of the normal [mm].
    pub(super) returns: Vec<f32>,
    /// What of a flux by area of the level plane a column shows to the lens, by length of the line along the motion, over pi; 0 where the lens does not see it [mm].
    pub(super) shows: Vec<f32>,
    /// What it shows to the lens of light by its own area, as Lambertian surfaces show all of it towards their normal [1].
    pub(super) facing: Vec<f32>,
    /// Whether any patch of a tile faces others.
    pub(super) uneven: Vec<bool>,
}

/// What pockets let out of a row's light, and what its columns show of others'.
#[derive(Debug, Clone, Default)]
pub(super) struct PocketLight {
    /// In each cavity that the line crosses.
    pub lit: Vec<CavityLight>,
    /// What of light by area film over pockets shows, a patch [1].
    pub shows: Vec<f32>,
    /// Light of the line that the near widths hold, a patch [e-].
    pub near: [Vec<f32>; NEAR_WIDTHS],
}

/// What a row sends to the camera besides its line, and where its windows of sensor rows stand for that.
#[derive(Debug, Clone, Default)]
pub struct SecondaryLight {
    /// The line through the film.
    pub transmitted: TransmittedLine,
    /// Mirror images, by rising column.
    pub reflections: Vec<Reflection>,
    /// What sends light to other parts of the body, and shows theirs.
    pub(super) patches: Patches,
    /// What pockets let out of its light.
    pub(super) pockets: PocketLight,
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
    /// Where the light that a pocket's tablet or foil shows here has come from: a place along the line, and how far along the motion from here [mm].
    pub(super) lands: [Vec<f32>; 2],
    /// What of that light by area is seen; 0 where there is no pocket [1].
    pub(super) shows: Vec<f32>,
    /// Light of the line that film has thrown down before and that the near widths hold [e-].
    pub(super) near: [Vec<f32>; NEAR_WIDTHS],
    /// Factor by which each width leaves here through the film, `[BASIS][columns]`; narrow ones have left already [sqrt(1)].
    pub exit: [Vec<f32>; BASIS],
    /// Whether metal throws it back.
    pub metal: Vec<bool>,
    /// Columns that hold any of it.
    pub columns: std::ops::Range<usize>,
}

impl TransmittedLine {
    /// Factors by which width `j` of another row's line leaves here in the tile that begins at column `start` [sqrt(1)].
    #[inline(always)]
    pub(crate) fn leaves(&self, j: usize, start: usize) -> &[f32; TILE] {
        if j < NARROW_WIDTHS { &UNIT_EXIT } else { load(&self.exit[j], start) }
    }

    /// Light in the brightest row of a column's transmitted line [e-].
    pub fn peak(&self, column: usize) -> f32 {
        peak(&PACK_SPREAD_MM, 0.0, self.variance[column], self.rows_per_mm[column], |j| {
            self.source[j][column] * self.exit[j][column]
        })
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

/// Sum of Gaussians in their common middle: `surface_light` of the line's own variance, the rest on the fixed widths [e-].
fn peak(
    spread_mm: &[f32; BASIS],
    surface_light: f32,
    variance: f32,
    rows_per_mm: f32,
    light: impl Fn(usize) -> f32,
) -> f32 {
    let spread = |j: usize| {
        let sigma = spread_mm[j] * rows_per_mm;
        light(j) / (variance + sigma * sigma).sqrt()
    };
    0.398_942_3 * (surface_light / variance.sqrt() + (0..BASIS).map(spread).sum::<f32>())
}
