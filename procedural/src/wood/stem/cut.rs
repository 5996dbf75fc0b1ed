//! The outline of a stem about a board: a table of distances from the pith, section by section.

/// Azimuths of the outline's table: 120 mm from the pith its chords leave an arc by 0.01 mm.
pub(super) const AZIMUTHS: usize = 256;
/// Distance of the table's sections [mm].
pub(super) const SECTION_MM: f32 = 10.0;

/// The outline of the stem about a board.
#[derive(Debug, Clone)]
pub(in crate::wood) struct StemCut {
    /// First section [mm], from the board's middle.
    pub(super) start: f32,
    /// Distance from the pith [mm], [section, azimuth], azimuths from 0 in equal steps of a turn.
    pub(super) radii: Vec<[f32; AZIMUTHS]>,
}

impl StemCut {
    /// Place of each section along the log [mm], and its distances from the pith [mm].
    pub(super) fn sections(&self) -> impl Iterator<Item = (f32, &[f32; AZIMUTHS])> {
        self.radii.iter().enumerate().map(|(row, radii)| (self.start + row as f32 * SECTION_MM, radii))
    }

    /// Distance from the pith to the outline at an azimuth [rad] and a place along the log [mm], in mm.
    #[inline]
    pub fn radius(&self, phi: f32, l: f32) -> f32 {
        let at = ((l - self.start) / SECTION_MM).clamp(0.0, (self.radii.len() - 2) as f32);
        let (row, w) = (at as usize, at - at.floor());
        let round = (phi * (1.0 / std::f32::consts::TAU)).rem_euclid(1.0) * AZIMUTHS as f32;
        let (column, v) = (round as usize % AZIMUTHS, round - round.floor());
        let section = |row: usize| {
            let (a, b) = (self.radii[row][column], self.radii[row][(column + 1) % AZIMUTHS]);
            a + v * (b - a)
        };
        let low = section(row);
        low + w.min(1.0) * (section(row + 1) - low)
    }
}
