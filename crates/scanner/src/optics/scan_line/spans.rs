//! Spans of a line along which light spreads without a break: between upright walls, gaps and edges.

use std::ops::Range;

use crate::specimen::Hit;

/// Step between neighbouring columns that counts as an upright wall [mm].
const WALL_MM: f32 = 0.3;

/// Spans of a line between upright walls and gaps, of the columns `first..`. A film goes on through its walls, and
/// around its holes.
pub fn spans(hits: &[Hit], first: usize, relief: bool, spans: &mut Vec<Range<usize>>) {
    spans.clear();
    let mut start = 0;
    for i in 1..=hits.len() {
        let wall = |pair: &[Hit]| (pair[0].surface.z - pair[1].surface.z).abs() > WALL_MM;
        let ends = |pair: &[Hit]| pair[0].is_bare() != pair[1].is_bare() || (!relief && wall(pair));
        if i == hits.len() || ends(&hits[i - 1..=i]) {
            spans.push(first + start..first + i);
            start = i;
        }
    }
}
