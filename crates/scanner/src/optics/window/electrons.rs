//! Electrons of a tile's windows: the arrays that every step of an exposure works on. Steps draw light into a window
//! [e-]; digitising turns it into numbers.

use std::ops::Range;

use crate::optics::light::ROWS;
use crate::optics::speckle::TILE;

/// Electrons of one window before noise, and where it lies.
#[derive(Debug, Clone)]
pub struct Window {
    /// Light from below the surface `[ROWS][TILE]` [e-].
    pub volume: Box<[[f32; TILE]; ROWS]>,
    /// Light from the surface `[ROWS][TILE]` [e-].
    pub surface: Box<[[f32; TILE]; ROWS]>,
    /// Ambient light `[ROWS][TILE]`; empty without [e-].
    pub ambient: Vec<[f32; TILE]>,
    /// Sensor row of the window's first row, a column [px].
    pub first_row: [i32; TILE],
    /// The rows that light is drawn into; what stands in others means nothing.
    pub drawn: Range<usize>,
}

impl Default for Window {
    fn default() -> Self {
        let rows = || Box::new([[0.0; TILE]; ROWS]);
        Self { volume: rows(), surface: rows(), ambient: Vec::new(), first_row: [0; TILE], drawn: 0..ROWS }
    }
}

impl Window {
    /// Takes all light of the laser away.
    #[inline(always)]
    pub(crate) fn darken(&mut self) {
        for k in self.drawn.clone() {
            self.volume[k] = [0.0; TILE];
            self.surface[k] = [0.0; TILE];
        }
    }
}

/// Signals of one window: what is read, and the part of it that makes photon noise [DN over dark].
#[derive(Debug, Clone)]
pub struct WindowSignal {
    /// What is read `[ROWS][TILE]`.
    pub level: Box<[[f32; TILE]; ROWS]>,
    /// What of it is noisy `[ROWS][TILE]`.
    pub noisy: Box<[[f32; TILE]; ROWS]>,
    /// What is added to it `[ROWS][TILE]` [DN].
    pub offset: Box<[[f32; TILE]; ROWS]>,
}

impl Default for WindowSignal {
    fn default() -> Self {
        let rows = || Box::new([[0.0; TILE]; ROWS]);
        Self { level: rows(), noisy: rows(), offset: rows() }
    }
}

/// Electrons of a tile's windows, and the buffers of its exposure.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    /// About the line that the camera will read, and about other light.
    pub windows: [Window; 2],
    /// How many of them hold light.
    pub used: usize,
    /// Columns of the tile that the sensor has.
    pub columns: usize,
    /// Buffer for a line in a window of its own.
    pub spare: Window,
    /// Buffer for signals on their way to numbers.
    pub signal: WindowSignal,
    /// Light of the next profile, where the object moves while it is exposed.
    pub next: Option<Box<NextProfile>>,
}

impl Scratch {
    /// Electrons of the laser without noise in row `k` of the first window [e-].
    pub fn electrons(&self, k: usize, column: usize) -> f32 {
        self.windows[0].volume[k][column] + self.windows[0].surface[k][column]
    }
}

/// Light of a tile in the next profile, kept for that profile's own exposure.
#[derive(Debug, Clone, Default)]
pub struct NextProfile {
    /// Whose light it is; `None` where nothing is kept.
    pub key: Option<ExposureKey>,
    /// The light.
    pub light: Scratch,
}

/// One exposure of one tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExposureKey {
    /// Number of the band, which no other band of this run has.
    pub band: u64,
    /// Number of the profile.
    pub profile: usize,
    /// Number of the tile.
    pub tile: usize,
}
