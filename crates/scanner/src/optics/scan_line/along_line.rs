//! Spread of light along the laser line: of each fixed width a blur over the columns, span by span ([`super::spans`]).
//!
//! Light does not leave a body by its sides as by its face: [`WALL_RETURN`] for upright walls of wood,
//! [`FILM_END_RETURN`] for a film's end. Film that rises along the line keeps light to itself, which spreads along its
//! slope. Light that fills a pocket stays there, but for what its walls let out, as their film does.

use std::ops::Range;

use super::spans::spans;
use crate::optics::camera::Camera;
use crate::optics::light::blur_varying;
use crate::specimen::Hit;
use transport::kernel::SPREAD_ACROSS_OVER_ALONG;

/// Share that comes back of light that would cross an upright wall, which lets it out: negative, since the wall takes
/// of the light near it too; from Monte Carlo scatter beside a crack and at the side of a board [1].
const WALL_RETURN: f32 = -0.5;
/// The same of the end of a film: what its inner side throws back of light from all sides, index 1.54 [1].
const FILM_END_RETURN: f32 = 0.6;
/// Least fixed width of light that fills a pocket [mm].
const LEAST_FILLING_MM: f32 = 0.7;
/// Slope of film along the line from which on light's way along it counts [1].
const LEAST_SLOPE: f32 = 0.2;

/// Stretches of a line's columns along which light spreads, and buffers for it.
#[derive(Debug, Default)]
pub(crate) struct AlongLine {
    /// Without a break in the surface.
    spans: Vec<Range<usize>>,
    /// The same for light that fills pockets: without a beginning or an end of one either; empty where there are none.
    rooms: Vec<Range<usize>>,
    /// Whether a span, then a room, has film that rises along the line.
    rises: [Vec<bool>; 2],
    /// Share of light from below that each column's film throws back down [1].
    holds: Vec<f32>,
    variance: Vec<f32>,
    buffer: Vec<f32>,
}

impl AlongLine {
    /// Buffers for `columns` columns.
    pub fn new(columns: usize) -> Self {
        Self { holds: vec![0.0; columns], ..Self::default() }
    }

    /// Notes what share of light from all sides the film of a column throws back down [1].
    pub fn note(&mut self, column: usize, holds: f32) {
        self.holds[column] = holds;
    }

    /// Finds the stretches of the columns `own` of a line; `relief` where a body has film.
    pub fn find(&mut self, hits: &[Hit], own: Range<usize>, relief: bool) {
        let Self { spans: all, rooms, rises, .. } = self;
        spans(&hits[own.clone()], own.start, relief, all);
        rooms.clear();
        rises.iter_mut().for_each(Vec::clear);
        if !relief {
            return;
        }
        for span in all.iter() {
            let mut start = span.start;
            for part in hits[span.clone()].chunk_by(|a, b| is_open(a) == is_open(b)) {
                rooms.push(start..start + part.len());
                start += part.len();
            }
        }
        for (stretches, rises) in [&*all, &*rooms].into_iter().zip(rises) {
            rises.extend(stretches.iter().map(|stretch| hits[stretch.clone()].iter().any(is_rising_film)));
        }
    }

    /// Blurs `source`, light of a fixed width of `spread_mm` by columns that are out of focus by `defocus`.
    pub fn blur(&mut self, source: &mut [f32], spread_mm: f32, hits: &[Hit], defocus: &[f32], camera: &Camera) {
        let Self { spans, rooms, rises, holds, variance, buffer } = self;
        let relief = !rooms.is_empty();
        let sideways = if relief { 1.0 } else { SPREAD_ACROSS_OVER_ALONG };
        let (level, all) = (camera.along_variance(0.0), camera.along_variance(spread_mm * sideways));
        let fills = relief && spread_mm >= LEAST_FILLING_MM;
        let (stretches, rises) = if fills { (&*rooms, &rises[1]) } else { (&*spans, &rises[0]) };
        let side = |edge: usize, inside: usize| match &hits[inside].matter.film {
            // What goes on beyond the sensor's columns.
            _ if edge == 0 || edge == hits.len() => 1.0,
            _ if fills && is_open(&hits[edge - 1]) != is_open(&hits[edge]) => {
                holds[if is_open(&hits[edge]) { edge } else { edge - 1 }]
            }
            _ if spread_mm == 0.0 => 1.0,
            Some(_) => FILM_END_RETURN,
            None => WALL_RETURN,
        };
        for (number, stretch) in stretches.iter().enumerate() {
            let defocus = defocus.get(stretch.clone()).unwrap_or_default();
            let sides = [side(stretch.start, stretch.start), side(stretch.end, stretch.end - 1)];
            let source = &mut source[stretch.clone()];
            if !rises.get(number).is_some_and(|&rises| rises) {
                blur_varying(source, all, defocus, sides, buffer);
                continue;
            }
            variance.clear();
            let slopes = hits[stretch.clone()].iter().map(|hit| hit.surface.slope_x);
            variance.extend(slopes.map(|slope| (all - level) / (1.0 + slope * slope)));
            for (sum, defocus) in variance.iter_mut().zip(defocus) {
                *sum += defocus;
            }
            blur_varying(source, level, variance, sides, buffer);
        }
    }
}

/// Whether a column sees film over air.
fn is_open(hit: &Hit) -> bool {
    hit.matter.film.is_some_and(|film| film.gap_mm.is_some())
}

/// Whether a column sees film that rises along the line.
fn is_rising_film(hit: &Hit) -> bool {
    hit.matter.film.is_some() && hit.surface.slope_x.abs() > LEAST_SLOPE
}
