//! Gaussian stepper: the Gaussians of a tile of columns, stepped from row to row.
//!
//! They follow by recursion from the middle outwards, g(d + 1) = g(d) q(d), q(d + 1) = q(d) exp(-1 / sigma^2), whose
//! relative error after 22 rows is under 1e-4. A narrow Gaussian on whole rows sums to
//!
//! ```text
//! 1 + 2 exp(-2 pi^2 v) cos(2 pi d) + 2 exp(-8 pi^2 v) cos(4 pi d) + ...
//! ```
//!
//! (Poisson's sum), by which it is divided, so that a column's light does not depend on where between rows the line
//! lies. What is more than one Gaussian across the line is drawn component by component ([`LineProfile`]). Neglected:
//! that a pixel gathers over its box, where a Gaussian has the box's variance alone.

use std::ops::Range;

use crate::optics::camera::circle_of_confusion;
use crate::optics::laser::LineProfile;
use crate::optics::light::{CENTRE, MIN_VARIANCE, ROWS, ScanLine, UNIT_EXIT, load};
use crate::optics::speckle::TILE;
use numerics::lanes::{cos_sin_turns, exp};

/// Standard deviations of a Gaussian beyond which it is left out: 1e-9 of its peak.
const REACH_SIGMAS: f32 = 6.5;
/// Variance over which a Gaussian on whole rows sums to 1 within 1e-4 [px^2].
pub(crate) const NARROW_VARIANCE: f32 = 0.5;
/// Columns that are stepped together, so that their Gaussians stay in registers.
const BLOCK: usize = 32;
/// Exponent at which a Gaussian is too faint to be stepped from there.
const MAX_EXPONENT: f32 = 60.0;

/// Rows of a window, a tile wide.
pub(crate) type TileRows = [[f32; TILE]; ROWS];

/// Factors by which light leaves in each row of a window [sqrt(1)].
pub(crate) trait Exit<'a>: Fn(usize) -> &'a [f32; TILE] + Copy {}

impl<'a, F: Fn(usize) -> &'a [f32; TILE] + Copy> Exit<'a> for F {}

/// Gaussians along the rows, one a column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gaussians<'a> {
    /// Distance from each one's middle to the window's middle row [px].
    pub phase: &'a [f32; TILE],
    /// Variance [px^2].
    pub variance: &'a [f32; TILE],
    /// Light before it leaves by an exit.
    pub source: &'a [f32; TILE],
}

/// A tile of a lit line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LineTile<'a> {
    /// The lit line.
    pub own: &'a ScanLine,
    /// First column of the tile.
    pub start: usize,
    /// What the line is across, where that is more than one Gaussian.
    pub profile: Option<&'a LineProfile>,
}

impl LineTile<'_> {
    /// Adds light that matter spreads by fixed width `j`, or light reflected by the surface, as `line` has it about the
    /// middle of what the line is across, blurred by the discs that it is out of focus by.
    #[inline(always)]
    pub fn add<'a>(
        &self,
        j: Option<usize>,
        line: Gaussians<'_>,
        exit: impl Exit<'a>,
        rows: &Range<usize>,
        out: &mut TileRows,
    ) {
        let disc = self.own.defocus_radius_of(self.start);
        let Some(profile) = self.profile else {
            return match disc {
                None => GaussianStepper::new(line.phase, line.variance).add(line.source, exit, rows, out),
                Some(disc) => add_defocused(disc, line, exit, rows, out),
            };
        };
        let (mixture, unit) = (profile.mixture(j), load(&self.own.profile_unit, self.start));
        for (number, component) in mixture.components.iter().enumerate() {
            let (mut phase, mut variance, mut source) = (*line.phase, *line.variance, *line.source);
            for c in 0..TILE {
                phase[c] += component.offset * unit[c];
                variance[c] += (component.variance - profile.core) * unit[c] * unit[c];
                source[c] *= component.weight;
            }
            if mixture.varies() {
                let node = load(&self.own.profile_node, self.start);
                for c in 0..TILE {
                    source[c] = line.source[c] * mixture.weight(number, node[c]);
                }
            }
            let strand = Gaussians { phase: &phase, variance: &variance, source: &source };
            match disc {
                None => add_placed(strand, exit, rows, out),
                Some(disc) => add_defocused(disc, strand, exit, rows, out),
            }
        }
    }
}

/// Adds Gaussians blurred by discs, whose variance they have.
fn add_defocused<'a>(
    disc: &[f32; TILE],
    line: Gaussians<'_>,
    exit: impl Exit<'a>,
    rows: &Range<usize>,
    out: &mut TileRows,
) {
    let components = circle_of_confusion::components(disc, line.variance);
    if components.is_empty() {
        return add_placed(line, exit, rows, out);
    }
    for [node, weight] in components {
        let (mut phase, mut variance, mut source) = (*line.phase, *line.variance, *line.source);
        for c in 0..TILE {
            phase[c] += node * disc[c];
            variance[c] -= 0.25 * disc[c] * disc[c];
            source[c] *= weight;
        }
        add_placed(Gaussians { phase: &phase, variance: &variance, source: &source }, exit, rows, out);
    }
}

/// Adds Gaussians whose middles may lie apart.
#[inline(always)]
fn add_placed<'a>(line: Gaussians<'_>, exit: impl Exit<'a>, rows: &Range<usize>, out: &mut TileRows) {
    match GaussianStepper::about(line.phase, line.variance) {
        Some(stepper) => stepper.add(line.source, exit, rows, out),
        None => add_by_rows(line, exit, rows, out),
    }
}

/// Gaussians whose middles lie too far apart for one stepper, row by row.
fn add_by_rows<'a>(line: Gaussians<'_>, exit: impl Exit<'a>, rows: &Range<usize>, out: &mut TileRows) {
    let Gaussians { phase, variance, source } = line;
    for k in rows.clone() {
        let (exit, row) = (exit(k), &mut out[k]);
        for c in 0..TILE {
            let d = phase[c] + k as f32 - CENTRE as f32;
            let v = variance[c].max(MIN_VARIANCE);
            let sum = if v < NARROW_VARIANCE { row_sum(d, v) } else { 1.0 };
            row[c] += source[c] * exit[c] * 0.398_942_3 / (v.sqrt() * sum) * exp(-0.5 * d * d / v);
        }
    }
}

/// Gaussians of one tile, stepped from row to row.
#[derive(Debug)]
pub(crate) struct GaussianStepper {
    middle: [f32; TILE],
    up: [f32; TILE],
    down: [f32; TILE],
    ratio: [f32; TILE],
    /// Row of the window that they are stepped from, and how far.
    from: usize,
    reach: usize,
}

impl GaussianStepper {
    /// `phase` is the distance from the line's centre to the window's middle row [px].
    #[inline(always)]
    pub fn new(phase: &[f32; TILE], variance: &[f32; TILE]) -> Self {
        let mut stepper = Self {
            middle: [0.0; TILE],
            up: [0.0; TILE],
            down: [0.0; TILE],
            ratio: [0.0; TILE],
            from: CENTRE,
            reach: 0,
        };
        let (widest, narrowest) = extremes(variance);
        for c in 0..TILE {
            let v = variance[c].max(MIN_VARIANCE);
            let half = 0.5 / v;
            let d = phase[c];
            // 1 / sqrt(2 pi v)
            stepper.middle[c] = 0.398_942_3 / v.sqrt() * exp(-d * d * half);
            stepper.up[c] = exp(-(2.0 * d + 1.0) * half);
            stepper.down[c] = exp((2.0 * d - 1.0) * half);
            stepper.ratio[c] = exp(-2.0 * half);
        }
        if narrowest < NARROW_VARIANCE {
            for c in 0..TILE {
                stepper.middle[c] /= row_sum(phase[c], variance[c].max(MIN_VARIANCE));
            }
        }
        stepper.reach = reach(widest);
        stepper
    }

    /// The same for lines whose centres lie apart; `None` where they lie too far apart.
    #[inline(always)]
    fn about(phase: &[f32; TILE], variance: &[f32; TILE]) -> Option<Self> {
        let (mut least, mut most) = (f32::MAX, f32::MIN);
        for &phase in phase {
            (least, most) = (least.min(phase), most.max(phase));
        }
        let (_, narrowest) = extremes(variance);
        let from = (CENTRE as f32 - (0.5 * (least + most)).round()).clamp(0.0, ROWS as f32 - 1.0);
        let moved = from - CENTRE as f32;
        let far = (least + moved).abs().max((most + moved).abs());
        if 0.5 * far * far > MAX_EXPONENT * narrowest {
            return None;
        }
        let mut stepper = Self::new(&phase.map(|phase| phase + moved), variance);
        stepper.from = from as usize;
        stepper.reach = (stepper.reach + far.ceil() as usize).min(ROWS);
        Some(stepper)
    }

    /// Adds source x Gaussian x exit to the `rows` of the window that are in reach.
    #[inline(always)]
    pub fn add<'a>(&self, source: &[f32; TILE], exit: impl Exit<'a>, rows: &Range<usize>, out: &mut TileRows) {
        let last = (self.from + self.reach + 1).min(rows.end);
        let first = self.from.saturating_sub(self.reach).max(rows.start);
        let mut exits = [&UNIT_EXIT; ROWS];
        for k in first..last {
            exits[k] = exit(k);
        }
        for block in (0..TILE).step_by(BLOCK) {
            let mut start = [0.0f32; BLOCK];
            let (source, middle) = (block_of(source, block), block_of(&self.middle, block));
            for c in 0..BLOCK {
                start[c] = source[c] * middle[c];
            }
            if (first..last).contains(&self.from) {
                deposit(&start, exits[self.from], block, &mut out[self.from]);
            }
            let ratio = block_of(&self.ratio, block);
            let (mut g, mut q) = (start, *block_of(&self.up, block));
            for k in self.from + 1..last {
                step(&mut g, &mut q, ratio);
                if k >= first {
                    deposit(&g, exits[k], block, &mut out[k]);
                }
            }
            let (mut g, mut q) = (start, *block_of(&self.down, block));
            for k in (first..self.from).rev() {
                step(&mut g, &mut q, ratio);
                if k < last {
                    deposit(&g, exits[k], block, &mut out[k]);
                }
            }
        }
    }
}

/// Rows to either side of a line's middle row in which Gaussians up to this variance are drawn [px].
#[inline(always)]
fn reach(widest: f32) -> usize {
    (REACH_SIGMAS * widest.sqrt() + 1.0).min(CENTRE as f32) as usize
}

/// Rows of a window in which [`GaussianStepper::new`] draws Gaussians of these variances about the middle row.
#[inline(always)]
pub(crate) fn rows_in_reach(variance: &[f32; TILE]) -> Range<usize> {
    let reach = reach(extremes(variance).0);
    CENTRE - reach..(CENTRE + reach + 1).min(ROWS)
}

/// The greatest and the least of the variances that are drawn [px^2].
#[inline(always)]
fn extremes(variance: &[f32; TILE]) -> (f32, f32) {
    // As whole numbers, whose order is that of positive floats: extremes of floats are not vector code.
    let (mut widest, mut narrowest) = (0, u32::MAX);
    for v in variance {
        let bits = v.max(MIN_VARIANCE).to_bits();
        (widest, narrowest) = (widest.max(bits), narrowest.min(bits));
    }
    (f32::from_bits(widest), f32::from_bits(narrowest))
}

/// One row on.
#[inline(always)]
fn step(g: &mut [f32; BLOCK], q: &mut [f32; BLOCK], ratio: &[f32; BLOCK]) {
    for c in 0..BLOCK {
        g[c] *= q[c];
        q[c] *= ratio[c];
    }
}

/// Adds what of `g` leaves by `exit` to the columns `from..` of a row.
#[inline(always)]
fn deposit(g: &[f32; BLOCK], exit: &[f32; TILE], from: usize, row: &mut [f32; TILE]) {
    let (exit, row) = (block_of(exit, from), row[from..].first_chunk_mut::<BLOCK>().expect("blocks fill a tile"));
    for c in 0..BLOCK {
        row[c] += g[c] * exit[c];
    }
}

/// Columns `from..` of a tile that are stepped together.
#[inline(always)]
fn block_of(values: &[f32; TILE], from: usize) -> &[f32; BLOCK] {
    values[from..].first_chunk().expect("blocks fill a tile")
}

/// Sum over whole rows of a Gaussian of variance `v` that lies `d` beside one of them [1].
#[inline(always)]
fn row_sum(d: f32, v: f32) -> f32 {
    const TWO_PI2: f32 = 19.739_209;
    let (cos, _) = cos_sin_turns(d - d.floor().min(d));
    let first = exp(-TWO_PI2 * v);
    1.0 + 2.0 * first * (cos + first * first * first * (2.0 * cos * cos - 1.0))
}
