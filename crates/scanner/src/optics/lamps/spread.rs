//! Spread of light of lamps: what leaves beside where it entered, of one group of widths.
//!
//! Lines and columns are put together to cells, whose sides are at most the group's width: [`CELL_SIDES`] lines or
//! columns, or one. Cells count from the scan's first profile, so that what they hold depends on no band. They are
//! blurred along the line by boxes and along the motion by a Gaussian's weights, as far as lines are there, and read
//! linearly in between; cells and reading have a variance of their own, which the blur lacks. Weights sum to 1: what
//! would go further stays within reach. Beside the body nothing comes back.

use std::ops::Range;

use crate::optics::light::blur;
use transport::kernel::SPREAD_ACROSS_OVER_ALONG;

/// Lines, or columns, of a cell.
const CELL_SIDES: [usize; 2] = [4, 2];

/// The spread of one group of widths.
#[derive(Debug, Clone)]
pub(super) struct Spread {
    /// Lines and columns of a cell.
    cell: [usize; 2],
    /// Weights along the motion, from the middle cell outwards [1].
    weights: Vec<f32>,
    /// Variance along the line [cells^2].
    variance: f32,
}

impl Spread {
    /// Of `spread_mm` along the motion, on lines and columns `pitch` apart, by lines up to `reach` away.
    pub fn new(spread_mm: f32, pitch: [f64; 2], reach: usize) -> Self {
        let sigma = [f64::from(spread_mm), f64::from(spread_mm * SPREAD_ACROSS_OVER_ALONG)];
        let pixels = [sigma[0] / pitch[0], sigma[1] / pitch[1]];
        let fits = |axis: usize, side: &usize| *side as f64 <= pixels[axis] && (axis == 1 || 2 * side - 1 <= reach);
        let cell = [0, 1].map(|axis| CELL_SIDES.into_iter().find(|side| fits(axis, side)).unwrap_or(1));
        // Of cells as boxes, and of what is linear between their middles.
        let variance = |axis: usize| {
            let own = (pixels[axis] / cell[axis] as f64).powi(2);
            let cells = (cell[axis] * cell[axis]) as f64;
            (own - if cell[axis] > 1 { (1.0 - 1.0 / cells) / 12.0 + 1.0 / 6.0 } else { 0.0 }).max(0.0)
        };
        let beside = if cell[0] > 1 { 2 * cell[0] - 1 } else { 0 };
        let most = reach.saturating_sub(beside) / cell[0];
        let along = variance(0);
        let weight = |d: usize| if along > 0.0 { libm::exp(-0.5 * (d * d) as f64 / along) } else { f64::from(d == 0) };
        let sum = weight(0) + 2.0 * (1..=most).map(weight).sum::<f64>();
        Self { cell, weights: (0..=most).map(|d| (weight(d) / sum) as f32).collect(), variance: variance(1) as f32 }
    }

    /// Lines of which `profiles` show light.
    pub fn sources(&self, profiles: Range<isize>) -> Range<isize> {
        let [first, last] = self.cells(&profiles);
        let (lines, far) = (self.cell[0] as isize, self.weights.len() as isize - 1);
        (first - far) * lines..(last + far + 1) * lines
    }

    /// First and last cell that the light of profiles is read from.
    fn cells(&self, profiles: &Range<isize>) -> [isize; 2] {
        let lines = self.cell[0] as isize;
        let beside = isize::from(lines > 1);
        [profiles.start.div_euclid(lines) - beside, (profiles.end - 1).div_euclid(lines) + beside]
    }

    /// Light that leaves in `profiles`, a row of `columns` for each, from what entered on the lines of
    /// [`Self::sources`].
    pub fn spread(&self, sources: &[Vec<f32>], profiles: Range<isize>, columns: usize) -> Vec<Vec<f32>> {
        let [lines, wide] = self.cell;
        let mut buffer = Vec::new();
        let cells: Vec<Vec<f32>> = sources
            .chunks_exact(lines)
            .map(|group| {
                let mut cells = in_cells(group, wide, columns);
                blur(&mut cells, self.variance, [1.0; 2], &mut buffer);
                cells
            })
            .collect();
        let far = self.weights.len() - 1;
        let smooth: Vec<Vec<f32>> = (far..cells.len() - far).map(|at| self.along_motion(&cells, at)).collect();
        let first = self.cells(&profiles)[0];
        profiles.map(|profile| self.between(&smooth, profile - first * lines as isize, columns)).collect()
    }

    /// The weighed sum of rows of cells about one of them.
    fn along_motion(&self, cells: &[Vec<f32>], at: usize) -> Vec<f32> {
        let mut out: Vec<f32> = cells[at].iter().map(|v| self.weights[0] * v).collect();
        for (d, weight) in self.weights.iter().enumerate().skip(1) {
            let pair = cells[at - d].iter().zip(&cells[at + d]);
            out.iter_mut().zip(pair).for_each(|(out, (before, behind))| *out += weight * (before + behind));
        }
        out
    }

    /// A line of columns that is linear between the middles of cells; `line` counts from the first cell's first line.
    fn between(&self, cells: &[Vec<f32>], line: isize, columns: usize) -> Vec<f32> {
        let [lines, wide] = self.cell;
        let (row, part) = place(line as usize, lines);
        let row: Vec<f32> = match cells.get(row + 1).filter(|_| part > 0.0) {
            Some(next) => cells[row].iter().zip(next).map(|(a, b)| a + part * (b - a)).collect(),
            None => cells[row].clone(),
        };
        if wide == 1 {
            return row;
        }
        // A cell before the first and one behind the last are like these.
        let at = |cell: usize| row[cell.saturating_sub(1).min(row.len() - 1)];
        let mut out = Vec::with_capacity(columns + wide);
        for cell in 0..=row.len() {
            let (from, to) = (at(cell), at(cell + 1));
            let way = (0..wide).map(|n| (n as f32 + 0.5) / wide as f32);
            out.extend(way.map(|way| from + way * (to - from)));
        }
        out.drain(..wide / 2);
        out.truncate(columns);
        out
    }
}

/// The cell whose middle lies before a line, and the way from there to the next one's [1].
fn place(line: usize, lines: usize) -> (usize, f32) {
    if lines == 1 {
        return (line, 0.0);
    }
    // In halves of lines from the first cell's middle.
    let halves = 2 * line + 1 - lines;
    (halves / (2 * lines), (halves % (2 * lines)) as f32 / (2 * lines) as f32)
}

/// Means of `wide` columns of some lines; the last cell has what columns are left.
fn in_cells(lines: &[Vec<f32>], wide: usize, columns: usize) -> Vec<f32> {
    let cells = columns.div_ceil(wide);
    let mut out = vec![0.0; cells];
    for line in lines {
        for (out, part) in out.iter_mut().zip(line.chunks(wide)) {
            *out += part.iter().sum::<f32>() / (part.len() * lines.len()) as f32;
        }
    }
    out
}
