//! Interreflections: laser light that one part of a body scatters to all sides, and that another part scatters to the lens.
//!
//! Radiosity (Goral et al. 1984). A patch of the line sends out its flux times albedo by Lambert's law;
//! of that the area dA receives cos(theta) cos(theta') dA / (pi d^2), and what of light from all sides it sends to the lens is, by
//! reciprocity, the share of light from there that its film turns, and what a tablet below it throws back. What fills the pocket is not counted there: it leaves elsewhere. Patches
//! are [`STRIDE`] columns wide, and received light is worked out in every [`NODE_ROWS`]th row of a window; what is seen between is linear.
//! The card lights a pocket's walls that way, and walls the card about them: light that comes from far and falls wide, which no width of the film's own spread holds. What
//! has spread far in film glows about the line; so does what patches of the line have sent each other, a second exchange that is worked out across the motion alone. What has
//! crossed a pocket is told by the pocket ([`super::pocket_light`]).
//! Neglected: what stands between two patches that face each other, exchanges after the second, light from beyond the
//! tiles next to a tile's own or beyond the line's own window, how far light spreads in films before it leaves, which way they prefer to
//! scatter, what lies open in holes, bodies of wood, and the conveyor.

use std::ops::Range;

use glam::Vec3;
use multiversion::multiversion;
use procedural::{Film, Surface};

use super::band::Band;
use super::camera::Sight;
use super::film::{entering_share, spread};
use super::reflections::LitRow;
use super::row::{Patches, Row};
use super::scan_geometry::ScanGeometry;
use super::speckle::TILE;
use super::widths::FAR;
use super::window::{ROWS, Window, window_start};
use crate::specimen::Hit;
use transport::fresnel::ENTERS_FROM_ALL_SIDES;
use transport::kernel::film_stack::FilmStackKernel;
use transport::kernel::{BASIS, PACK_SPREAD_MM};

/// Columns by which patches are apart.
pub(super) const STRIDE: usize = 4;
/// Patches of a tile.
pub(super) const PER_TILE: usize = TILE / STRIDE;
/// Rows by which those are apart in which received light is worked out [px].
const NODE_ROWS: usize = 2;
/// Rows of a window in which it is: every so many, and the last.
pub(super) const NODES: usize = ROWS / NODE_ROWS + 1;
/// Square of a slope from which a patch faces others [1].
const UNEVEN_SLOPE2: f32 = 0.01;
/// Square of the distance under which patches are no points to each other: light spreads about as far in films before it leaves, and
/// samples lie about as far apart [mm^2].
const NEAR_MM2: f32 = 0.06;
/// Most by which light from all sides enters better than the laser's [1].
const MAX_EASE: f32 = 2.0;
/// Patches on either side that light one once more.
const AGAIN: usize = 24;
const ROOT_3: f32 = 1.732_050_8;
/// Places of a vector.
const LANES: usize = 16;

/// A row's exchange with those that a window looks at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Exchange<'a> {
    /// Positions of the profiles.
    pub geometry: &'a ScanGeometry,
    /// Rows around the profile.
    pub band: &'a Band,
    /// Number of the profile whose line sends light out.
    pub profile: usize,
}

/// A patch that receives light, and how far the line lies from it along the motion [mm].
#[derive(Debug, Clone, Copy)]
struct Receiver {
    x: f32,
    z: f32,
    slope_x: f32,
    slope_y: f32,
    line_y: f32,
}

impl Patches {
    /// Takes the patches of a row.
    pub(crate) fn find(&mut self, lit: &LitRow<'_>, row: &Row, covers: &mut FilmStackKernel) {
        let columns = lit.hits.len();
        let padded = columns.next_multiple_of(TILE);
        let Self { x, z, slope_x, slope_y, sends, glows, glow_mm, returns, shows, facing, .. } = self;
        for field in [x, z, slope_x, slope_y, sends, glows, glow_mm, returns, shows, facing] {
            field.clear();
            field.resize(padded / STRIDE, 0.0);
        }
        self.uneven.clear();
        self.uneven.resize(padded / TILE, false);
        for column in (0..columns).step_by(STRIDE) {
            if let Some(film) = &lit.hits[middle_of(column, columns)].matter.film {
                self.take(column, lit, row, film, covers);
            }
        }
        if self.uneven.contains(&true) {
            light_once_more(self);
        }
    }

    /// Takes the patch of the columns from `column` on, of which the middle one sees this film. Its place and slope are the means of
    /// its columns: sampled, walls a few patches wide would flicker from profile to profile.
    fn take(&mut self, column: usize, lit: &LitRow<'_>, row: &Row, film: &Film, covers: &mut FilmStackKernel) {
        let hits = &lit.hits[column..(column + STRIDE).min(lit.hits.len())];
        let mean = |value: &dyn Fn(&Hit) -> f32| hits.iter().map(value).sum::<f32>() / hits.len() as f32;
        let share = |holds: &dyn Fn(&Hit) -> bool| mean(&|hit| f32::from(u8::from(holds(hit))));
        let (hit, place) = (&lit.hits[middle_of(column, lit.hits.len())], column / STRIDE);
        let medium = &hit.matter.medium;
        let [x, z] = [mean(&|hit| hit.x), mean(&|hit| hit.surface.z)];
        let [slope_x, slope_y] = [mean(&|hit| hit.surface.slope_x), mean(&|hit| hit.surface.slope_y)];
        let upright2 = 1.0 + slope_x * slope_x + slope_y * slope_y;
        let normal = Vec3::new(-slope_x, -slope_y, 1.0) / upright2.sqrt();
        let sight = lit.view.sight(x, &Surface { z, slope_x, slope_y });
        // A wall scatters to where the lens is not.
        let spread = spread(&hit.matter, film, normal, &Sight { view: normal, ..sight }, covers);
        (self.x[place], self.z[place]) = (x, z);
        (self.slope_x[place], self.slope_y[place]) = (slope_x, slope_y);
        let near = spread.enter.iter().zip(spread.exit).take(FAR);
        // What has crossed a pocket leaves that elsewhere.
        let alone = |j: usize| if film.is_over_room() { spread.alone[j] } else { 1.0 };
        let own: f32 = near.enumerate().map(|(j, (enter, exit))| enter * exit * alone(j)).sum();
        let through = spread.passes * spread.below.iter().sum::<f32>();
        let out = medium.gloss.matte + own + through;
        let columns = hits.len() as f32;
        self.sends[place] = columns * share(&|hit| hit.lit) * sight.electrons * out / upright2.sqrt();
        let (mut glow, mut moment) = (0.0, 0.0);
        for j in FAR..BASIS {
            let source = row.source[j][column..column + hits.len()].iter().sum::<f32>();
            let flux = source * spread.exit[j] / sight.view.z;
            glow += flux;
            moment += flux * PACK_SPREAD_MM[j] * PACK_SPREAD_MM[j];
        }
        // A wall has more area than the card below it, and all of it glows.
        self.glows[place] = glow;
        self.glow_mm[place] = if glow > 0.0 { (moment / glow).sqrt() } else { 0.0 };
        let [before, behind] = [column.saturating_sub(1), (column + STRIDE).min(lit.hits.len() - 1)];
        let wide = (lit.hits[behind].x - lit.hits[before].x) / (behind - before).max(1) as f32;
        let enters = entering_share(medium.n_eff, normal, -sight.light);
        let ease = (ENTERS_FROM_ALL_SIDES / enters.max(f32::MIN_POSITIVE)).min(MAX_EASE);
        // What has crossed the film fills the pocket, and is not seen here; what foil mirrors goes elsewhere.
        let turned: f32 = spread.enter.iter().take(FAR).map(|enter| enter * enter).sum();
        let passed = if film.under.gloss.is_metal() { 0.0 } else { through };
        let reflectance = medium.gloss.matte + ease * (turned + passed);
        let reflects = wide.clamp(0.0, 2.0 * sight.column_mm) * reflectance;
        self.returns[place] = columns * reflects / upright2.sqrt();
        let facing = share(&|hit| hit.seen) * normal.dot(sight.view).max(0.0);
        self.shows[place] = std::f32::consts::FRAC_1_PI * reflects * facing;
        self.facing[place] = reflectance * facing;
        self.uneven[column / TILE] |= upright2 > 1.0 + UNEVEN_SLOPE2;
    }

    /// The patch at a place, with the line that far from it along the motion [mm].
    fn receiver(&self, place: usize, line_y: f32) -> Receiver {
        Receiver {
            x: self.x[place],
            z: self.z[place],
            slope_x: self.slope_x[place],
            slope_y: self.slope_y[place],
            line_y,
        }
    }
}

/// Adds to what glows the light that the line's patches send each other: what they send on is the second exchange. Of a patch that
/// is even along the motion, at a distance r across it, the integral of 1 / d^4 along the motion is pi / (2 r^3), and that of y^2 / d^4 is r^2 times that.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn light_once_more(patches: &mut Patches) {
    let places = patches.x.len();
    for at in 0..places {
        let [x, z, slope_x] = [patches.x[at], patches.z[at], patches.slope_x[at]];
        let near = at.saturating_sub(AGAIN) / LANES * LANES..(at + AGAIN).next_multiple_of(LANES).min(places);
        let (mut fluxes, mut moments) = ([0.0f32; LANES], [0.0f32; LANES]);
        for start in near.step_by(LANES) {
            let [xs, zs, slopes, sends] = [&patches.x, &patches.z, &patches.slope_x, &patches.sends]
                .map(|field| field[start..].first_chunk::<LANES>().expect("a tile holds whole vectors"));
            for lane in 0..LANES {
                let (dx, dz) = (xs[lane] - x, zs[lane] - z);
                let (received, sent) = ((dz - slope_x * dx).max(0.0), (slopes[lane] * dx - dz).max(0.0));
                let r2 = dx * dx + dz * dz + NEAR_MM2;
                let flux = sends[lane] * received * sent / (r2 * r2.sqrt());
                fluxes[lane] += flux;
                moments[lane] += flux * r2;
            }
        }
        let (flux, moment) = (fluxes.iter().sum::<f32>(), moments.iter().sum::<f32>());
        let returned = 0.5 * patches.returns[at];
        let (glow, variance) = (patches.glows[at], patches.glow_mm[at] * patches.glow_mm[at]);
        let all = glow + returned * flux;
        if all > 0.0 {
            patches.glow_mm[at] = ((glow * variance + returned * moment) / all).sqrt();
            patches.glows[at] = all;
        }
    }
}

/// Flux that each of `receivers` gets by area of the level plane from the patches `from`, times pi [e-/mm^2].
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn receive(from: &Patches, places: Range<usize>, near_mm2: f32, receivers: &[Receiver; NODES], got: &mut [f32; NODES]) {
    let fields = [&from.x, &from.z, &from.slope_x, &from.slope_y, &from.sends, &from.glows, &from.glow_mm]
        .map(|field| &field[places.clone()]);
    for (at, got) in receivers.iter().zip(got) {
        let mut sums = [0.0f32; LANES];
        for start in (0..fields[0].len()).step_by(LANES) {
            let [x, z, slope_x, slope_y, sends, glows, glow_mm] =
                fields.map(|field| field[start..].first_chunk::<LANES>().expect("a tile holds whole vectors"));
            // The line, and where what glows about it lies (Gauss and Hermite's rule of three nodes).
            for (deviations, weight) in [(0.0, 2.0 / 3.0), (-ROOT_3, 1.0 / 6.0), (ROOT_3, 1.0 / 6.0)] {
                let line = if deviations == 0.0 { 1.0 } else { 0.0 };
                for lane in 0..LANES {
                    let (dx, dz) = (x[lane] - at.x, z[lane] - at.z);
                    let dy = at.line_y + deviations * glow_mm[lane];
                    let received = (dz - at.slope_x * dx - at.slope_y * dy).max(0.0);
                    let sent = (slope_x[lane] * dx + slope_y[lane] * dy - dz).max(0.0);
                    let d2 = dx * dx + dy * dy + dz * dz + near_mm2;
                    sums[lane] += (line * sends[lane] + weight * glows[lane]) * received * sent / (d2 * d2);
                }
            }
        }
        *got = sums.iter().sum();
    }
}

impl Exchange<'_> {
    /// Whether a tile's columns may send each other light.
    pub fn is_near(&self, tile: usize) -> bool {
        uneven_near(self.band.row(self.profile), tile) || self.rows().into_iter().any(|row| uneven_near(row, tile))
    }

    /// Offsets of the rows in which received light is worked out [profiles].
    fn offsets(&self) -> [isize; NODES] {
        let offsets = self.band.neighbours(self.profile, self.geometry);
        std::array::from_fn(|node| offsets[(node * NODE_ROWS).min(ROWS - 1)])
    }

    pub(super) fn rows(&self) -> [&Row; NODES] {
        self.offsets().map(|offset| self.band.neighbour(self.profile, offset))
    }

    /// Adds what the tile's columns show of each other's light to the window about their line.
    pub fn add(&self, tile: usize, window: &mut Window) {
        let own = self.band.row(self.profile);
        let Some(from) = own.secondary.as_ref().map(|secondary| &secondary.patches) else { return };
        if !self.is_near(tile) {
            return;
        }
        let rows = self.rows();
        let own_y = self.geometry.position(self.profile as isize);
        let away = self.offsets().map(|offset| (self.geometry.position(self.profile as isize + offset) - own_y) as f32);
        let tiles = from.uneven.len();
        let sources = tile.saturating_sub(1) * PER_TILE..(tile + 2).min(tiles) * PER_TILE;
        // One more patch on either side, to go over from one to the next.
        let mut shown = [[0.0f32; ROWS]; PER_TILE + 2];
        for (i, shown) in shown.iter_mut().enumerate() {
            let place = (tile * PER_TILE + i).saturating_sub(1).min(from.x.len() - 1);
            let column = middle_of(place * STRIDE, own.hits.len());
            let first = window_start(own.centre[column]) as f32;
            let patches = rows.map(|row| row.secondary.as_ref().map_or(from, |secondary| &secondary.patches));
            let receivers = std::array::from_fn(|node| patches[node].receiver(place, -away[node]));
            let mut got = [0.0; NODES];
            receive(from, sources.clone(), NEAR_MM2, &receivers, &mut got);
            let mut nodes = [Node::default(); NODES];
            for (node, seen) in nodes.iter_mut().enumerate() {
                let row = rows[node];
                *seen = Node {
                    row: row.centre[column] - away[node] * own.level_rows_per_mm - first,
                    y: away[node],
                    by_mm: got[node] * patches[node].shows[place],
                };
            }
            for pair in nodes.windows(2) {
                lay(pair[0], pair[1], shown);
            }
        }
        window.add_patches(&shown);
    }
}

impl Window {
    /// Adds light of patches: of the tile's own and one more on either side, `[patch][row]`, linear from the middle of one to that of the next.
    pub(super) fn add_patches(&mut self, shown: &[[f32; ROWS]; PER_TILE + 2]) {
        add_linear(shown, self.drawn.clone(), &mut self.volume);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn add_linear(shown: &[[f32; ROWS]; PER_TILE + 2], rows: Range<usize>, volume: &mut [[f32; TILE]; ROWS]) {
    // Which two patches each column of a patch lies between, of three beside each other, and how far it is from the first to the second.
    let between: [(usize, f32); STRIDE] = std::array::from_fn(|c| {
        let along = c as f32 / STRIDE as f32 + 1.0 - 0.5 * (STRIDE - 1) as f32 / STRIDE as f32;
        (along as usize, along.fract())
    });
    for k in rows {
        let light: [f32; PER_TILE + 2] = std::array::from_fn(|patch| shown[patch][k]);
        let mut linear = [[0.0f32; STRIDE]; PER_TILE];
        for (c, (first, part)) in between.into_iter().enumerate() {
            for patch in 0..PER_TILE {
                linear[patch][c] = light[patch + first] * (1.0 - part) + light[patch + first + 1] * part;
            }
        }
        for (sum, light) in volume[k].iter_mut().zip(linear.as_flattened()) {
            *sum += light;
        }
    }
}

/// The column in the middle of the patch that begins at `column`, of so many columns.
pub(super) fn middle_of(column: usize, columns: usize) -> usize {
    (column + STRIDE / 2).min(columns - 1)
}

/// Whether a tile of a row, or one beside it, faces others.
fn uneven_near(row: &Row, tile: usize) -> bool {
    let near = |uneven: &[bool]| uneven[tile.saturating_sub(1)..(tile + 2).min(uneven.len())].contains(&true);
    row.secondary.as_ref().is_some_and(|secondary| near(&secondary.patches.uneven))
}

/// Light that a column shows in one row of the specimen.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Node {
    /// Where in the window it is seen [px].
    pub row: f32,
    /// Where along the motion it comes from [mm].
    pub y: f32,
    /// Light by length along the motion [e-/mm].
    pub by_mm: f32,
}

/// Lays the light between two nodes on the rows of a window.
pub(super) fn lay(a: Node, b: Node, rows: &mut [f32; ROWS]) {
    let (step, length) = (b.row - a.row, (b.y - a.y).abs());
    if step.abs() < 1e-3 || (a.by_mm == 0.0 && b.by_mm == 0.0) {
        return;
    }
    let (low, high) = (a.row.min(b.row).max(-0.5), a.row.max(b.row).min(ROWS as f32 - 0.5));
    let by_row = length / step.abs();
    let mut from = low;
    while from < high {
        // Pixels end halfway between rows.
        let row = (from + 0.5).floor();
        let to = (row + 0.5).min(high);
        let middle = (0.5 * (from + to) - a.row) / step;
        let light = a.by_mm + (b.by_mm - a.by_mm) * middle;
        if let Some(sum) = rows.get_mut(row as usize) {
            *sum += (to - from) * by_row * light;
        }
        from = to.max(from + 1e-3);
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use rand::RngExt;

    use super::*;

    /// Card and wall of a pocket with a line across both: rays by Lambert's law from the card, followed to the wall, land as often in each
    /// strip along the motion and each part of the height as patches say, within 4 %, and 15 % at the wall's foot.
    #[test]
    fn walls_receive_what_rays_from_the_card_bring() {
        let mut rng = procedural::Stream::root(41).rng();
        for _ in 0..12 {
            let [steep, lean] = [rng.random_range(0.5..4.0f32), rng.random_range(-0.5..0.5f32)];
            let (pitch, columns) = (0.06f32, 2 * TILE);
            // The card ends at x = 0, where the line meets the wall's foot, and the wall rises to z = 3.
            let wall_end = 3.0 / steep;
            let x = |place: usize| ((place as f32 - (columns / STRIDE / 2) as f32) + 0.5) * pitch * STRIDE as f32;
            let places = columns / STRIDE;
            let zeros = || vec![0.0; places];
            let mut card = Patches {
                x: zeros(),
                z: zeros(),
                slope_x: zeros(),
                slope_y: zeros(),
                sends: zeros(),
                glows: zeros(),
                glow_mm: zeros(),
                ..Patches::default()
            };
            for place in 0..places {
                card.x[place] = x(place);
                if x(place) < 0.0 {
                    card.sends[place] = STRIDE as f32 * pitch;
                }
            }
            let length = pitch * STRIDE as f32 * (places / 2) as f32;
            // The wall is z = steep (x - lean y).
            let mut sums = [[0.0f64; 3]; 4];
            let bin = |y: f32, z: f32| [((y + 4.0) / 2.0) as usize, z.clamp(0.0, 2.99) as usize];
            let (steps_x, steps_y) = (60, 160);
            for i in 0..steps_x {
                for j in 0..steps_y / NODES + 1 {
                    let ys: [f32; NODES] = std::array::from_fn(|node| {
                        -4.0 + 8.0 * ((j * NODES + node) as f32 + 0.5) / ((steps_y / NODES + 1) * NODES) as f32
                    });
                    let over = |_: f32| wall_end * (i as f32 + 0.5) / steps_x as f32;
                    let receivers = ys.map(|y| Receiver {
                        x: lean * y + over(y),
                        z: steep * over(y),
                        slope_x: steep,
                        slope_y: -steep * lean,
                        line_y: -y,
                    });
                    let mut got = [0.0; NODES];
                    receive(&card, 0..places, 0.003, &receivers, &mut got);
                    let area = wall_end / steps_x as f32 * 8.0 / ((steps_y / NODES + 1) * NODES) as f32;
                    for (receiver, got) in receivers.iter().zip(got) {
                        let [row, height] = bin(-receiver.line_y, receiver.z);
                        sums[row][height] += f64::from(got * area * std::f32::consts::FRAC_1_PI);
                    }
                }
            }
            let rays = 400_000;
            let mut counts = [[0.0f64; 3]; 4];
            for _ in 0..rays {
                let from = Vec3::new(-length * rng.random::<f32>(), 0.0, 0.0);
                let (turn, sin2) = (std::f32::consts::TAU * rng.random::<f32>(), rng.random::<f32>());
                let way = Vec3::new(sin2.sqrt() * turn.cos(), sin2.sqrt() * turn.sin(), (1.0 - sin2).sqrt());
                // z = steep (x - lean y) on the ray.
                let closing = steep * (way.x - lean * way.y) - way.z;
                let t = -steep * from.x / closing;
                let at = from + way * t;
                if closing > 0.0 && at.y.abs() < 4.0 && at.z < 3.0 {
                    let [row, height] = bin(at.y, at.z);
                    counts[row][height] += 1.0;
                }
            }
            for (place, (sums, counts)) in sums.as_flattened().iter().zip(counts.as_flattened()).enumerate() {
                let flux = counts * f64::from(length) / f64::from(rays);
                let error = counts.max(1.0).sqrt() * f64::from(length) / f64::from(rays);
                let off = (sums - flux).abs();
                // In the lowest millimetre patches lie as far apart as from where the line meets the wall.
                let coarse = if place % 3 == 0 { 0.15 } else { 0.04 };
                assert!(off < 4.0 * error + coarse * flux, "{sums} and {flux} +- {error}, slopes {steep} and {lean}");
            }
        }
    }

    /// Rows hold the light between two nodes wherever these lie, folded images too.
    #[test]
    fn rows_hold_all_light_between_nodes() {
        let mut rng = procedural::Stream::root(42).rng();
        for _ in 0..300 {
            let mut node = |y: f32| Node { row: rng.random_range(1.0..42.0), y, by_mm: rng.random_range(0.0..9.0) };
            let (a, b) = (node(0.3), node(1.1));
            let mut rows = [0.0; ROWS];
            lay(a, b, &mut rows);
            let (sum, whole) = (rows.iter().sum::<f32>(), 0.5 * (a.by_mm + b.by_mm) * 0.8);
            assert!((sum - whole).abs() < 2e-3 * whole, "{sum} of {whole} between {a:?} and {b:?}");
        }
    }
}
