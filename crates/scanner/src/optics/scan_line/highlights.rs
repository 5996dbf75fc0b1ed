//! Highlights: fibres of wood that guide light out of the line, and facets of metal that mirror it into the lens.
//!
//! They are two of the three mechanisms that make hairs of a laser line (docs/theory/instrument/laser.md): a facet
//! brightens its column, and with it all of the halo that the laser has there; a fibre draws a streak beside the line
//! ([`Streak`]). The third, speckle of the halo, comes by itself. Neglected: facets off the line that the halo lights.

use std::ops::Range;

use super::view::LineView;
use crate::optics::laser::segment_process::{Segment, SegmentProcess};
use crate::optics::light::{ScanLine, Streak, column_shares};
use crate::specimen::Hit;
use base::{Medium, Stream};
use numerics::lanes::ln;
use optical_bench::parameters::LaserParameters;

/// Fibres that run straighter across the motion than this guide no light along it [1].
const MIN_FIBRE_ALONG: f32 = 0.5;

/// Highlights of one sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Highlights {
    fibres: Option<GuidingFibres>,
    facets: Option<MetalFacets>,
}

/// Fibres that guide light out of the line.
#[derive(Debug, Clone, Copy)]
struct GuidingFibres {
    segments: SegmentProcess,
    /// Width of a fibre [mm].
    width: f32,
    /// Mean share of the line's peak [1].
    share: f32,
}

/// Facets of metal that mirror the line into the lens.
#[derive(Debug, Clone, Copy)]
struct MetalFacets {
    segments: SegmentProcess,
    /// Mean gain over the light of the surface [1].
    gain: f32,
}

/// Buffers in which highlights are found.
#[derive(Debug, Default)]
pub(crate) struct HighlightScratch {
    segments: Vec<Segment>,
    /// Columns, and the light that facets add to each [e-].
    glints: Vec<(usize, f32)>,
}

impl Highlights {
    /// Of a bench; `stream` belongs to the sample.
    pub fn new(bench: &LaserParameters, stream: Stream) -> Self {
        let segments = |per_mm, length, name| SegmentProcess::new(per_mm, length, stream.child(name));
        Self {
            fibres: segments(bench.streaks_per_mm, bench.streak_length_mm, "streaks").map(|segments| GuidingFibres {
                segments,
                width: (bench.streak_width_um * 1e-3) as f32,
                share: bench.streak_share as f32,
            }),
            facets: segments(bench.glints_per_mm, bench.glint_length_mm, "glints")
                .map(|segments| MetalFacets { segments, gain: bench.glint_gain as f32 }),
        }
    }

    /// Adds highlights to a line that is worked out otherwise.
    pub fn add(&self, view: LineView<'_>, line: &mut ScanLine, scratch: &mut HighlightScratch) {
        self.add_glints(view, line, scratch);
        self.add_streaks(view, line, scratch);
    }

    /// Lets facets of metal shine that mirror light into the lens.
    fn add_glints(&self, view: LineView<'_>, line: &mut ScanLine, scratch: &mut HighlightScratch) {
        let Some(MetalFacets { segments, gain }) = &self.facets else { return };
        segments.meet(f64::from(view.y), ends(&line.hits), &mut scratch.segments);
        for segment in &scratch.segments {
            let (column, hit) = at(&line.hits, segment.x);
            let gloss = &hit.matter.medium.gloss;
            if !gloss.is_metal() {
                continue;
            }
            // An exponential law of brightness, as of facets that lie more or less right.
            let light = gain * -ln(segment.draw) * line.surface_light[column];
            let off = view.camera.project(hit.x, 0.0, hit.surface.z)[0]
                - view.camera.project(segment.x, 0.0, hit.surface.z)[0];
            for (side, part) in column_shares(-off, view.camera.lens_variance()) {
                let there = column.wrapping_add_signed(side);
                if let Some(hit) = line.hits.get(there)
                    && !hit.is_bare()
                {
                    scratch.glints.push((there, part * light));
                }
            }
        }
        for (column, electrons) in scratch.glints.drain(..) {
            line.surface_light[column] += electrons;
        }
    }

    /// Notes the fibres that guide light out of the line.
    fn add_streaks(&self, view: LineView<'_>, line: &mut ScanLine, scratch: &mut HighlightScratch) {
        line.streaks.clear();
        let Some(GuidingFibres { segments, width, share }) = &self.fibres else { return };
        segments.meet(f64::from(view.y), ends(&line.hits), &mut scratch.segments);
        for segment in &scratch.segments {
            let (column, hit) = at(&line.hits, segment.x);
            let Some(lean) = lean(&hit.matter.medium) else { continue };
            if hit.is_bare() || !hit.seen {
                continue;
            }
            let x = segment.x - segment.start * lean;
            let place = view.camera.project(x, 0.0, hit.surface.z)[0];
            let rate = line.rows_per_mm[column];
            let column_mm = view.camera.sight(hit.x, hit.surface.z, 0.0).column_mm;
            let wide = width / column_mm;
            // Even between a third and five thirds of the mean.
            let bright = share * (1.0 / 3.0 + 4.0 / 3.0 * segment.draw);
            line.streaks.push(Streak {
                column: place,
                centre: line.centre[column],
                lean: -lean / column_mm / rate,
                first_row: line.centre[column] - rate * segment.end,
                last_row: line.centre[column] - rate * segment.start,
                electrons: bright * wide * line.line_peak(column),
                column_variance: view.camera.lens_variance() + wide * wide / 12.0,
                row_variance: view.camera.lens_variance(),
            });
        }
        line.streaks.sort_by(|a, b| a.column.total_cmp(&b.column));
    }
}

/// dx/dy of the fibres of a medium; `None` where it has none that guide light along the motion.
fn lean(medium: &Medium) -> Option<f32> {
    let fibre = medium.fibre;
    (medium.k > 0.0 && fibre.y.abs() > MIN_FIBRE_ALONG).then(|| fibre.x / fibre.y)
}

/// Where a line of columns starts and ends [mm].
fn ends(hits: &[Hit]) -> Range<f64> {
    let at = |hit: Option<&Hit>| hit.map_or(0.0, |hit| f64::from(hit.x));
    at(hits.first())..at(hits.last())
}

/// The column that looks at `x`, and what it sees.
fn at(hits: &[Hit], x: f32) -> (usize, &Hit) {
    let right = hits.partition_point(|hit| hit.x < x).clamp(1, hits.len() - 1);
    let column = if x - hits[right - 1].x < hits[right].x - x { right - 1 } else { right };
    (column, &hits[column])
}
