//! Poisson segment process on the surface: fibres that guide light, and facets that mirror it.
//!
//! Segments along the motion form a Poisson process with exponential lengths. A line across the motion meets the given
//! number per mm, and the parts of a segment on either side of the line have exponential lengths. Segments lie on the
//! object: they are drawn cell by cell from the sample's stream, so each appears, stays and ends as it passes under the
//! line. Segments longer than ten mean lengths are cut. An engineering model; that single tracheids guide light is
//! known (Kienle et al. 2008), their number and brightness are estimates.

use std::ops::Range;

use base::Stream;
use rand::RngExt;

use numerics::lanes::ln;

/// Side of a cell along the line [mm].
const CELL_MM: f64 = 1.0;
/// Side of a cell along the motion, in mean lengths [1].
const CELL_LENGTHS: f64 = 2.0;
/// Cells behind the line's own in which segments that reach it may start.
const CELLS_BEHIND: i64 = 5;

/// Density and mean length of the segments on an object.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SegmentProcess {
    per_mm: f64,
    length: f64,
    stream: Stream,
}

/// A segment that the line meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Position along the line [mm].
    pub x: f32,
    /// Its start along the motion, from the line, at most 0 [mm].
    pub start: f32,
    /// Its end along the motion, from the line, above 0 [mm].
    pub end: f32,
    /// A uniform random number of its own in (0, 1].
    pub draw: f32,
}

impl SegmentProcess {
    /// `per_mm` segments with the mean length `length` [mm]; `None` for none.
    pub fn new(per_mm: f64, length: f64, stream: Stream) -> Option<Self> {
        (per_mm > 0.0).then_some(Self { per_mm, length, stream })
    }

    /// Fills `found` with the segments that a line at scan position `y` meets within `x` [mm].
    pub fn meet(&self, y: f64, x: Range<f64>, found: &mut Vec<Segment>) {
        found.clear();
        let side = CELL_LENGTHS * self.length;
        let own = (y / side).floor() as i64;
        let none = libm::exp(-self.per_mm * CELL_MM * CELL_LENGTHS);
        for across in (x.start / CELL_MM).floor() as i64..=(x.end / CELL_MM).floor() as i64 {
            for along in own - CELLS_BEHIND..=own {
                let mut rng = self.stream.index(across as u64).index(along as u64).rng();
                // Poisson's law by products of uniform numbers (Knuth 1969).
                let mut left = rng.random::<f64>();
                while left > none {
                    let [across_share, start, length, draw] = std::array::from_fn(|_| 1.0 - rng.random::<f64>());
                    left *= rng.random::<f64>();
                    let start = (along as f64 + 1.0 - start) * side - y;
                    let end = start - self.length * f64::from(ln(length as f32));
                    if start <= 0.0 && end > 0.0 {
                        let x = (across as f64 + 1.0 - across_share) * CELL_MM;
                        found.push(Segment { x: x as f32, start: start as f32, end: end as f32, draw: draw as f32 });
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of segments on a line is Poisson's, their reach on either side exponential (Kolmogorov and Smirnov at
    /// alpha = 1e-3), and a segment stays where it lies while the line moves on.
    #[test]
    fn segments_are_as_many_and_as_long_as_asked_for() {
        let (per_mm, length) = (1.5, 0.4);
        let process = SegmentProcess::new(per_mm, length, Stream::root(3)).expect("some");
        let (mut found, mut reach) = (Vec::new(), [Vec::new(), Vec::new()]);
        let lines = 200;
        for line in 0..lines {
            // So far apart that few segments are met twice.
            process.meet(f64::from(line) * 5.0, -50.0..49.999, &mut found);
            for segment in &found {
                reach[0].push(f64::from(-segment.start));
                reach[1].push(f64::from(segment.end));
            }
        }
        let n = reach[0].len() as f64;
        let expected = per_mm * 100.0 * f64::from(lines);
        assert!((n - expected).abs() < 3.5 * expected.sqrt(), "{n} segments, {expected} expected");
        for side in &mut reach {
            side.sort_by(f64::total_cmp);
            let off = side.iter().enumerate().map(|(i, r)| {
                let law = 1.0 - (-r / length).exp();
                (law - i as f64 / n).abs().max((law - (i + 1) as f64 / n).abs())
            });
            assert!(off.fold(0.0, f64::max) < 1.95 / n.sqrt());
        }
        let (mut here, mut there) = (Vec::new(), Vec::new());
        process.meet(7.0, 0.0..20.0, &mut here);
        process.meet(7.05, 0.0..20.0, &mut there);
        let mut stay = 0;
        for segment in here.iter().filter(|segment| segment.end > 0.051) {
            let same = |other: &&Segment| other.x == segment.x;
            let moved = there.iter().find(same).expect("a segment that still reaches the line is still there");
            assert!((moved.start + 0.05 - segment.start).abs() < 1e-5);
            stay += 1;
        }
        assert!(stay > 10, "{stay} segments stay");
    }
}
