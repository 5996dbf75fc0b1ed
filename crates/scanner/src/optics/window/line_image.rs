//! Image of the line on the sensor: the inner loops, one tile of columns at a time.
//!
//! For each fixed width j the line spread along the rows is source_j(column) G_j(row) exit_j(column, row), where the
//! source stands under the laser and the exit in the scan line that this sensor row looks at
//! ([`super::gaussian_stepper`]). docs/theory/performance.md counts operations and bytes.

use multiversion::multiversion;

use super::electrons::Window;
use super::front_exits::FrontExits;
use super::gaussian_stepper::{GaussianStepper, Gaussians, LineTile, rows_in_reach};
use super::seen_rows::SeenRows;
use crate::optics::laser::LineProfile;
use crate::optics::light::{CENTRE, FAR, ROWS, ScanLine, TransmittedLine, UNIT_EXIT, load};
use crate::optics::speckle::TILE;
use numerics::lanes::exp;
use transport::kernel::{BASIS, PACK_SPREAD_MM};

/// Rows beyond which a line is taken to lie no further from a window [px].
const MAX_BEYOND: f32 = 200.0;
/// Least variance of light that reaches beyond its line's window [px^2].
const LEAST_FAR_PX2: f32 = 25.0;

/// How the line of a line is drawn.
#[derive(Debug, Clone, Copy)]
pub struct LineShape<'a> {
    /// Sensor row of its middle, a column of the tile [px].
    pub centre: &'a [f32; TILE],
    /// Variance on top of the line's own [px^2].
    pub blur: f32,
    /// What it is across, where that is more than one Gaussian.
    pub profile: Option<&'a LineProfile>,
}

/// Light that the surface throws back, and where the windows lie; darkens the volume.
#[inline(always)]
pub(crate) fn surface_line(
    own: &ScanLine,
    start: usize,
    line: &LineShape<'_>,
    variance: &[f32; TILE],
    window: &mut Window,
) -> [f32; TILE] {
    let phase = place(line.centre, window);
    let tile = LineTile { own, start, profile: line.profile };
    let light = Gaussians { phase: &phase, variance, source: load(&own.surface_light, start) };
    tile.add(None, light, |_| &UNIT_EXIT, &window.drawn, &mut window.surface);
    phase
}

/// Puts a dark window about lines at `centre`; the distance from each line to the window's middle row [px].
#[inline(always)]
fn place(centre: &[f32; TILE], window: &mut Window) -> [f32; TILE] {
    let mut phase = [0.0f32; TILE];
    for c in 0..TILE {
        let whole = centre[c].floor();
        phase[c] = whole - centre[c];
        window.first_row[c] = whole as i32 - CENTRE as i32;
    }
    window.darken();
    phase
}

/// Draws the line of `own` and what `neighbours`, a row of the window each, let out of its light.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn draw(own: &ScanLine, neighbours: &[&ScanLine; ROWS], start: usize, line: &LineShape<'_>, window: &mut Window) {
    let rows_per_mm = load(&own.spread_rows_per_mm, start);
    let mut variance = *load(&own.variance, start);
    for c in 0..TILE {
        variance[c] += line.blur;
    }
    let phase = surface_line(own, start, line, &variance, window);
    let (tile, rows) = (LineTile { own, start, profile: line.profile }, window.drawn.clone());
    let mut fronts = FrontExits::of(neighbours, start);
    let seen = if line.profile.is_none() { SeenRows::of(own, neighbours, start) } else { None };
    let hidden = own.hidden_of(start);
    let ways = seen.as_ref().filter(|_| hidden.is_some()).map(|seen| seen.ways_mm(neighbours, start));
    let sides = seen.as_ref().map(|seen| same_side(own, neighbours, seen, start));
    for j in 0..BASIS {
        let source = load(&own.source[j], start);
        if source.iter().all(|&s| s == 0.0) {
            continue;
        }
        let split = hidden.filter(|_| j < FAR).map(|hidden| apart(source, hidden));
        let source = split.as_ref().map_or(source, |[shown, _]| shown);
        let shift = load(&own.shift[j], start);
        let (mut wide, mut place) = (variance, phase);
        let level_sigma = own.spread_mm[j] * own.level_rows_per_mm;
        for c in 0..TILE {
            let sigma = own.spread_mm[j] * rows_per_mm[c];
            wide[c] += sigma * sigma;
            place[c] -= shift[c];
        }
        if let (Some(seen), Some(ways), Some([_, creeps])) = (&seen, &ways, &split) {
            let exits: [&[f32; TILE]; ROWS] = std::array::from_fn(|k| load(&neighbours[k].exit[j], start));
            let exit = |k: usize, c: usize| exits[usize::from(seen.node[k][c])][c];
            let creeping = variance.map(|variance| variance + level_sigma * level_sigma);
            add_over_relief(ways, own.level_rows_per_mm, [&[0.0; TILE], &creeping, creeps], exit, window);
        }
        if let Some((seen, sides)) = seen.as_ref().zip(sides.as_ref()).filter(|_| j >= FAR) {
            let exits: [&[f32; TILE]; ROWS] = std::array::from_fn(|k| load(&neighbours[k].exit[j], start));
            let exit = |k: usize, c: usize| {
                let exit = exits[usize::from(seen.node[k][c])][c];
                if sides[k][c] { exit } else { 0.0 }
            };
            let mut moved = *shift;
            for c in 0..TILE {
                wide[c] = variance[c] + level_sigma * level_sigma;
                moved[c] *= own.level_rows_per_mm / own.rows_per_mm[start + c].max(f32::MIN_POSITIVE);
            }
            add_over_relief(&seen.away_mm, own.level_rows_per_mm, [&moved, &wide, source], exit, window);
            continue;
        }
        let is_one = line.profile.is_none() && own.defocus_radius.is_empty();
        fronts.look(j, own, start, &if is_one { rows_in_reach(&wide) } else { 0..ROWS });
        let exit = |k: usize| fronts.row(k).unwrap_or_else(|| load(&neighbours[k].exit[j], start));
        let light = Gaussians { phase: &place, variance: &wide, source };
        tile.add(Some(j), light, exit, &rows, &mut window.volume);
    }
}

/// Whether what a window's rows see and the line are both over pockets, or neither, `[ROWS][TILE]`: light goes far in
/// the air of one pocket, or in film that is sealed, and not from one to the other.
#[inline(always)]
fn same_side(
    own: &ScanLine,
    neighbours: &[&ScanLine; ROWS],
    seen: &SeenRows,
    start: usize,
) -> Box<[[bool; TILE]; ROWS]> {
    const NONE: [bool; TILE] = [false; TILE];
    let rooms: [&[bool; TILE]; ROWS] = std::array::from_fn(|k| neighbours[k].rooms_of(start).unwrap_or(&NONE));
    let own = own.rooms_of(start).unwrap_or(&NONE);
    let mut same = Box::new([[false; TILE]; ROWS]);
    for (same, node) in same.iter_mut().zip(&seen.node) {
        for c in 0..TILE {
            same[c] = own[c] == rooms[usize::from(node[c])][c];
        }
    }
    same
}

/// Light of a tile's columns: of those whose line is seen, and of those where it is `hidden`.
#[inline(always)]
fn apart(source: &[f32; TILE], hidden: &[bool; TILE]) -> [[f32; TILE]; 2] {
    [false, true].map(|of| std::array::from_fn(|c| if hidden[c] == of { source[c] } else { 0.0 }))
}

/// Adds light of a width that has spread over a surface that rises and falls, by its shift, variance and source, to
/// rows that show what is this far away.
#[inline(always)]
fn add_over_relief(
    away_mm: &[[f32; TILE]; ROWS],
    rows_per_mm: f32,
    [shift, variance, source]: [&[f32; TILE]; 3],
    exit: impl Fn(usize, usize) -> f32,
    window: &mut Window,
) {
    let (mut scale, mut half) = ([0.0f32; TILE], [0.0f32; TILE]);
    for c in 0..TILE {
        half[c] = 0.5 / variance[c];
        scale[c] = source[c] * 0.564_189_6 * half[c].sqrt();
    }
    for k in window.drawn.clone() {
        let (away, row) = (&away_mm[k], &mut window.volume[k]);
        let exit: [f32; TILE] = std::array::from_fn(|c| exit(k, c));
        for c in 0..TILE {
            let d = away[c] * rows_per_mm + shift[c];
            row[c] += scale[c] * exit[c] * exp(-d * d * half[c]);
        }
    }
}

/// Draws the line of `own` that is seen through a film in a window of its own, and what `neighbours` let out of its
/// light.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(crate) fn draw_transmitted(
    own: &TransmittedLine,
    neighbours: &[&TransmittedLine; ROWS],
    start: usize,
    window: &mut Window,
) {
    let phase = place(load(&own.centre, start), window);
    let (rows_per_mm, variance) = (load(&own.rows_per_mm, start), load(&own.variance, start));
    for j in 0..BASIS {
        let source = load(&own.source[j], start);
        if source.iter().all(|&s| s == 0.0) {
            continue;
        }
        let mut wide = *variance;
        for c in 0..TILE {
            let sigma = PACK_SPREAD_MM[j] * rows_per_mm[c];
            wide[c] += sigma * sigma;
        }
        GaussianStepper::new(&phase, &wide).add(
            source,
            |k| neighbours[k].leaves(j, start),
            &(0..ROWS),
            &mut window.volume,
        );
    }
}

/// Adds the light of `own` that falls into a window beyond the one that its line was drawn in, which begins at `drawn`:
/// what spreads far over a pocket shows about the other line too. The surface goes on level from the last scan line on
/// either side that the line's window looks at.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(crate) fn add_beyond(
    own: &ScanLine,
    neighbours: &[&ScanLine; ROWS],
    start: usize,
    drawn: &[i32; TILE],
    window: &mut Window,
) {
    let ends = [neighbours[0], neighbours[ROWS - 1]];
    let exits = |j: usize| ends.map(|end| load(&end.exit[j], start));
    let centres = ends.map(|end| load(&end.centre, start));
    let level = [own.level_rows_per_mm; TILE];
    let lines = [load(&own.variance, start), &level];
    let shift = |j: usize| {
        let shift = load(&own.shift[j], start);
        std::array::from_fn(|c| shift[c] * level[c] / own.rows_per_mm[start + c].max(f32::MIN_POSITIVE))
    };
    beyond(centres, lines, |j| load(&own.source[j], start), shift, exits, drawn, window);
}

/// The same of a line that is seen through a film.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(crate) fn add_transmitted_beyond(
    own: &TransmittedLine,
    neighbours: &[&TransmittedLine; ROWS],
    start: usize,
    drawn: &[i32; TILE],
    window: &mut Window,
) {
    let exits = |j| [0, ROWS - 1].map(|k| neighbours[k].leaves(j, start));
    let lines = [load(&own.variance, start), load(&own.rows_per_mm, start)];
    let shift = |_| [0.0; TILE];
    beyond([load(&own.centre, start); 2], lines, |j| load(&own.source[j], start), shift, exits, drawn, window);
}

/// Adds the far widths of lines, by where they are seen from before their windows and from behind, and their variances
/// and rows per mm, to the rows of a window that lie outside of the windows that begin at `drawn`. Each leaves by the
/// last row on its side that those look at.
#[inline(always)]
fn beyond<'a>(
    centres: [&[f32; TILE]; 2],
    [variance, rows_per_mm]: [&[f32; TILE]; 2],
    source: impl Fn(usize) -> &'a [f32; TILE],
    shift: impl Fn(usize) -> [f32; TILE],
    exits: impl Fn(usize) -> [&'a [f32; TILE]; 2],
    drawn: &[i32; TILE],
    window: &mut Window,
) {
    if window.first_row == *drawn {
        return;
    }
    for j in FAR..BASIS {
        let source = source(j);
        if source.iter().all(|&s| s == 0.0) {
            continue;
        }
        let ([before, behind], shift) = (exits(j), shift(j));
        let (mut light, mut step, mut ratio) = ([0.0f32; TILE], [0.0f32; TILE], [0.0f32; TILE]);
        for c in 0..TILE {
            let sigma = PACK_SPREAD_MM[j] * rows_per_mm[c];
            let spread = sigma * sigma;
            // What a narrow line sends so far is nothing, and not to be stepped from there.
            let half = 0.5 / (variance[c] + spread).max(LEAST_FAR_PX2);
            // The window's rows beyond those drawn lie on one side of them.
            let centre = if window.first_row[c] < drawn[c] { centres[0][c] } else { centres[1][c] };
            let away = (window.first_row[c] as f32 - centre - shift[c]).clamp(-MAX_BEYOND, MAX_BEYOND);
            let reaches = if spread < LEAST_FAR_PX2 { 0.0 } else { source[c] };
            light[c] = reaches * 0.564_189_6 * half.sqrt() * exp(-away * away * half);
            step[c] = exp(-(2.0 * away + 1.0) * half);
            ratio[c] = exp(-2.0 * half);
        }
        for (k, row) in window.volume.iter_mut().enumerate() {
            for c in 0..TILE {
                let at = window.first_row[c] + k as i32 - drawn[c];
                let exit = if at < 0 { before[c] } else { behind[c] };
                row[c] += if (0..ROWS as i32).contains(&at) { 0.0 } else { light[c] * exit };
                light[c] *= step[c];
                step[c] *= ratio[c];
            }
        }
    }
}
