//! Square cells about a line of light, at whose nodes heights are taken.

use glam::DVec2;

use transport::line::LineSource;

/// Cells are as near to this size as divides the body evenly [mm].
pub(super) const TARGET_PITCH_MM: f64 = 0.1;
/// Deviations of a line from an end of the body within which it falls on that too, and length of cells there over
/// [`TARGET_PITCH_MM`] [1].
const END_DEVIATIONS: f64 = 2.5;
const END_SHARE: f64 = 0.2;
/// The region goes on so far beyond the line's rows and columns [mm].
const MARGIN_MM: f64 = 20.0;

/// Cells over a body; nodes lie half a cell off its border.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeightCells {
    /// Place of the first node [mm].
    pub low: DVec2,
    /// Size of cells [mm].
    pub pitch: DVec2,
    /// Cells along x and y.
    pub size: [usize; 2],
}

impl HeightCells {
    /// The cells about `line` of a body between two corners [mm]. Where the line falls on an end of it they are short
    /// along y: the end is a ramp as long as a cell.
    pub fn about(line: &LineSource, body: [DVec2; 2]) -> Self {
        let ends = [line.x.first(), line.x.last()].map(|x| f64::from(x.copied().unwrap_or(0.0)));
        let rows = line.row_mm * (line.rows as f64 + 0.5);
        let region = [DVec2::new(ends[0], line.y - rows) - MARGIN_MM, DVec2::new(ends[1], line.y + rows) + MARGIN_MM];
        let at_end = body.iter().any(|end| (line.y - end.y).abs() < END_DEVIATIONS * line.line_mm);
        let along = TARGET_PITCH_MM * if at_end { END_SHARE } else { 1.0 };
        Self::of_pitch(body, region, DVec2::new(TARGET_PITCH_MM, along))
    }

    /// The cells of a body within a region; both by their low and high corners [mm].
    #[cfg(test)]
    pub fn new(body: [DVec2; 2], region: [DVec2; 2]) -> Self {
        Self::of_pitch(body, region, DVec2::splat(TARGET_PITCH_MM))
    }

    fn of_pitch([from, to]: [DVec2; 2], region: [DVec2; 2], target: DVec2) -> Self {
        let count = ((to - from) / target).round().max(DVec2::ONE);
        let pitch = (to - from) / count;
        // One node beyond the body on each side closes it.
        let [first, last] = region.map(|v| ((v - from) / pitch).floor().clamp(DVec2::NEG_ONE, count));
        let size = (last - first).max(DVec2::ONE);
        Self { low: from + (first + 0.5) * pitch, pitch, size: [size.x as usize, size.y as usize] }
    }
}
