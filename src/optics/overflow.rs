//! Blooming: charge above the full well flows to the neighbours along the column.
//!
//! Of what is above the full well a share flows on, half of it up and half down, and fills the room of the pixels that it
//! meets until it is used up; the rest goes down the drain. Phenomenology of an anti-blooming drain that is too weak
//! (Janesick 2001); a pixel that overflows still reads full. Charge that flows on makes photon noise where it arrives. What
//! leaves the window of the line is lost.

use super::TILE;
use super::expose::ROWS;

/// Signals of one tile's window: what is read, and the part of it that makes photon noise [DN over dark].
#[derive(Debug, Clone)]
pub struct Charge {
    /// What is read `[ROWS][TILE]`.
    pub level: Box<[[f32; TILE]; ROWS]>,
    /// What of it is noisy `[ROWS][TILE]`.
    pub noisy: Box<[[f32; TILE]; ROWS]>,
    /// What is added to it `[ROWS][TILE]` [DN].
    pub offset: Box<[[f32; TILE]; ROWS]>,
}

impl Default for Charge {
    fn default() -> Self {
        let rows = || Box::new([[0.0; TILE]; ROWS]);
        Self { level: rows(), noisy: rows(), offset: rows() }
    }
}

impl Charge {
    /// Lets `share` of what is above `full` flow on.
    pub fn overflow(&mut self, full: f32, share: f32) {
        let over: Vec<[f32; TILE]> = self.level.iter().map(|row| row.map(|v| 0.5 * share * (v - full).max(0.0))).collect();
        for c in 0..TILE {
            if over.iter().any(|row| row[c] > 0.0) {
                self.flow(&over, full, c, 0..ROWS);
                self.flow(&over, full, c, (0..ROWS).rev());
            }
        }
    }

    fn flow(&mut self, over: &[[f32; TILE]], full: f32, c: usize, rows: impl Iterator<Item = usize>) {
        let mut carried = 0.0f32;
        for k in rows {
            let taken = carried.min((full - self.level[k][c]).max(0.0));
            self.level[k][c] += taken;
            self.noisy[k][c] += taken;
            carried += over[k][c] - taken;
        }
    }
}
