//! Search of edges: the columns of a line that see past an edge of the surface.
//!
//! Between two neighbours of which one looks past an edge that the other does not (a jump of height, the end of the
//! body, the border of a shadow) the edge is found to a sixteenth of a column. Neglected: texture of matter finer than
//! a column; self-shadows of bodies that cannot occlude themselves.

use base::Medium;

use crate::frame::Sightlines;
use crate::optics::light::MixedColumn;
use crate::specimen::{Hit, Specimen};

/// Jump of height between neighbours, beyond what their slopes make, that is an edge [mm].
const EDGE_MM: f32 = 0.1;
/// Halvings of the distance between two columns in which an edge is sought.
const HALVINGS: usize = 4;

/// Finds the mixed columns of a line.
#[derive(Debug, Default)]
pub(crate) struct EdgeSearch {
    /// The edges' columns to the left, and between which parts of the way to the next column they lie.
    edges: Vec<(usize, [f32; 2])>,
    hits: Vec<Hit>,
}

impl EdgeSearch {
    /// The mixed columns of the line at `y` [mm], whose columns look along `columns` and see `hits`, by rising column.
    pub fn find(
        &mut self,
        specimen: &Specimen,
        y: f32,
        columns: &Sightlines,
        conveyor: Medium,
        hits: &[Hit],
        mixed: &mut Vec<MixedColumn>,
    ) {
        mixed.clear();
        let jumps = |pair: &[Hit]| !alike(&pair[0], &pair[1]);
        self.edges.clear();
        self.edges.extend(hits.windows(2).enumerate().filter(|(_, pair)| jumps(pair)).map(|(i, _)| (i, [0.0, 1.0])));
        if self.edges.is_empty() {
            return;
        }
        for _ in 0..HALVINGS {
            let between = columns.between(self.edges.iter().map(|(column, [from, to])| (*column, 0.5 * (from + to))));
            specimen.look(y, &between, conveyor, &mut self.hits);
            for ((column, range), hit) in self.edges.iter_mut().zip(&self.hits) {
                let middle = 0.5 * (range[0] + range[1]);
                let left = nearer(hit, &hits[*column], &hits[*column + 1]);
                range[if left { 0 } else { 1 }] = middle;
            }
        }
        for &(column, [from, to]) in &self.edges {
            let off = 0.5 * (from + to) - 0.5;
            let (cut, beside) = if off < 0.0 { (column, column + 1) } else { (column + 1, column) };
            mixed.push(MixedColumn { column: cut, beside, share: off.abs() });
        }
    }
}

/// Whether both see the same surface: no jump, and laser and lens reach both or neither.
fn alike(a: &Hit, b: &Hit) -> bool {
    if a.is_bare() != b.is_bare() || (a.lit && a.seen) != (b.lit && b.seen) {
        return false;
    }
    let expected = 0.5 * (a.surface.slope_x + b.surface.slope_x) * (b.x - a.x);
    let bend = 0.5 * ((b.surface.slope_x - a.surface.slope_x) * (b.x - a.x)).abs();
    a.is_bare() || (b.surface.z - a.surface.z - expected).abs() < EDGE_MM + bend
}

/// Whether `hit` is on the side of `left` and not of `right`.
fn nearer(hit: &Hit, left: &Hit, right: &Hit) -> bool {
    let apart = |other: &Hit| {
        let bare = hit.is_bare() != other.is_bare();
        let reached = (hit.lit && hit.seen) != (other.lit && other.seen);
        let height = (hit.surface.z - other.surface.z - other.surface.slope_x * (hit.x - other.x)).abs();
        1e3 * f32::from(u8::from(bare)) + 1e2 * f32::from(u8::from(reached)) + height
    };
    apart(left) <= apart(right)
}
