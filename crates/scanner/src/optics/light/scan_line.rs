//! Scan line: the light of one position of the scan, as the camera sees it when the laser stands there.
//!
//! Subsurface response depends only on the body, so a line is worked out once for each position of the scan and used by
//! every profile whose window holds it: as the source of its own line, and as the exit of its neighbours' light.

use super::lamp_line::LampLine;
use super::mixed_column::MixedColumn;
use super::secondary::SecondaryLight;
use super::streak::Streak;
use super::tile::CENTRE;
use super::widths::peak;
use crate::optics::speckle::TILE;
use crate::optics::speckle::coherence::{CONTRAST_COLUMNS, RowContrasts, contrast_at};
use crate::specimen::Hit;
use transport::kernel::BASIS;

/// Numbers of one position of the scan, structure of arrays over sensor columns, padded with zeros to whole tiles.
#[derive(Debug, Clone, Default)]
pub struct ScanLine {
    /// Place along the motion [mm].
    pub y_mm: f32,
    /// Rows per mm along the motion of a level surface in the middle, as high as the line's highest place [px/mm].
    pub level_rows_per_mm: f32,
    /// Rows by which an instrument that is not at rest has the line beside its place [px].
    pub moved_px: f32,
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
    /// Rows per mm along the way that light spreads on: of a film, which keeps light to itself, along its slope
    /// [px/mm].
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
    /// Radius along the rows of the circle of confusion, whose variance `variance` holds; empty where nothing can be
    /// out of focus [px].
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
    /// The same for light of lines behind this one, which leaves through a front face where this line is bare: of the
    /// tiles in which that makes a difference.
    pub front: Vec<FrontTile>,
    /// Greatest exits in each tile of columns, but for the front faces [sqrt(1)].
    pub greatest_exits: Vec<[f32; BASIS]>,
    /// Contrasts of speckle in light from below beside the line, of that of the patterns, for every
    /// [`CONTRAST_COLUMNS`] columns [1].
    pub(crate) contrasts: Vec<RowContrasts>,
    /// Ambient light in a pixel that looks here; empty where there is none [e-].
    pub ambient: Vec<f32>,
    /// What else of this line's light the camera sees; `None` for a body that cannot send it elsewhere.
    pub secondary: Option<Box<SecondaryLight>>,
    /// What lamps find here; empty without lamps.
    pub(crate) lamps: LampLine,
    /// Columns that see past an edge, by rising column.
    pub mixed: Vec<MixedColumn>,
    /// Single fibres that guide light out of the line, by rising column.
    pub streaks: Vec<Streak>,
}

impl ScanLine {
    /// Sensor row of the line's centre in a column, as an instrument has it that exposes the line `own` [px].
    pub(crate) fn row_beside(&self, own: &Self, column: usize) -> f32 {
        self.centre[column] - (self.moved_px - own.moved_px)
    }

    /// Contrast of speckle in light from below in a row of a column's window, of that of the sample's patterns [1].
    pub fn contrast_in_row(&self, column: usize, k: usize) -> f32 {
        let beyond = self.centre[column] - self.centre[column].floor();
        contrast_at(&self.contrasts[column / CONTRAST_COLUMNS], CENTRE as f32 - k as f32 + beyond)
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

    /// What leaves through a front face in the tile that begins at column `start`.
    pub(crate) fn front_of(&self, start: usize) -> Option<&FrontTile> {
        self.front.iter().find(|tile| tile.start == start)
    }

    /// Light in the brightest row of a column's line [e-].
    pub(crate) fn line_peak(&self, column: usize) -> f32 {
        let rows_per_mm = self.spread_rows_per_mm[column];
        peak(&self.spread_mm, self.surface_light[column], self.variance[column], rows_per_mm, |j| {
            self.source[j][column] * self.exit[j][column]
        })
    }
}

/// What leaves through a front face, in one tile of a bare line.
#[derive(Debug, Clone, PartialEq)]
pub struct FrontTile {
    /// First column of the tile.
    pub start: usize,
    /// Factors by which each width would leave here if the surface went on [sqrt(1)].
    pub exit: [[f32; TILE]; BASIS],
    /// Place of the front edge along the motion [mm].
    pub edge_mm: [f32; TILE],
    /// Distance of this line from there [mm].
    pub before_mm: [f32; TILE],
    /// Depth of the face that the lens sees in this line, beyond any depth below its foot; 0 where there is none [mm].
    pub depth_mm: [f32; TILE],
    /// Height of the face [mm].
    pub height_mm: [f32; TILE],
}
