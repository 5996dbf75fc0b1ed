//! Interreflections: laser light that one part of a body scatters to all sides, and that another part scatters to the
//! lens.
//!
//! Radiosity (Goral et al. 1984). A patch of the line sends out light by Lambert's law; of that the area dA receives
//! cos(theta) cos(theta') dA / (pi d^2). Received light is worked out in every [`NODE_ROWS`]th row of a window; what is
//! seen between is linear. The card lights a pocket's walls that way, and walls the card about them: light that comes
//! from far and falls wide, which no width of the film's own spread holds. What has crossed a pocket is told by the
//! pocket ([`super::pocket_light`]). Neglected: what stands between two patches that face each other, exchanges after
//! the second, light from beyond the tiles next to a tile's own or beyond the line's own window. Neglected too: how far
//! light spreads in films before it leaves, which way they prefer to scatter, what lies open in holes, bodies of wood,
//! and the conveyor.

use std::ops::Range;

use multiversion::multiversion;

use super::electrons::Window;
use super::lit_profile::LitProfile;
use crate::optics::light::{NEAR_MM2, PER_TILE, Patches, ROWS, STRIDE, ScanLine, middle_of, window_start};
use crate::optics::speckle::TILE;

/// Rows by which those are apart in which received light is worked out [px].
const NODE_ROWS: usize = 2;
/// Rows of a window in which it is: every so many, and the last.
pub(crate) const NODES: usize = ROWS / NODE_ROWS + 1;
const ROOT_3: f32 = 1.732_050_8;
/// Places of a vector.
const LANES: usize = 16;

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

/// Flux that each of `receivers` gets by area of the level plane from the patches `from`, times pi; none where nothing
/// receives [e-/mm^2].
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn receive(
    from: &Patches,
    places: Range<usize>,
    near_mm2: f32,
    receivers: &[Option<Receiver>; NODES],
    got: &mut [f32; NODES],
) {
    let fields = [&from.x, &from.z, &from.slope_x, &from.slope_y, &from.sends, &from.glows, &from.glow_mm]
        .map(|field| &field[places.clone()]);
    for (at, got) in receivers.iter().zip(got) {
        let Some(at) = at else { continue };
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

impl LitProfile<'_> {
    /// Whether a tile's columns may send each other light.
    pub fn may_exchange(&self, tile: usize) -> bool {
        uneven_near(self.line(), tile) || self.node_lines().into_iter().any(|line| uneven_near(line, tile))
    }

    /// Offsets of the lines in which received light is worked out [profiles].
    fn offsets(&self) -> [isize; NODES] {
        let offsets = self.band.neighbours(self.profile, self.geometry);
        std::array::from_fn(|node| offsets[(node * NODE_ROWS).min(ROWS - 1)])
    }

    pub(crate) fn node_lines(&self) -> [&ScanLine; NODES] {
        self.offsets().map(|offset| self.band.neighbour(self.profile, offset))
    }

    /// Adds what the tile's columns show of each other's light to the window about their line.
    pub fn add_exchange(&self, tile: usize, window: &mut Window) {
        let own = self.line();
        let Some(from) = own.secondary.as_ref().map(|secondary| &secondary.patches) else { return };
        if !self.may_exchange(tile) {
            return;
        }
        let lines = self.node_lines();
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
            let patches = lines.map(|line| line.secondary.as_ref().map_or(from, |secondary| &secondary.patches));
            // What the lens does not see is not worked out.
            let shows = |node: usize| patches[node].shows[place] > 0.0;
            let receivers = std::array::from_fn(|node| shows(node).then(|| patches[node].receiver(place, -away[node])));
            let mut got = [0.0; NODES];
            receive(from, sources.clone(), NEAR_MM2, &receivers, &mut got);
            let mut nodes = [Node::default(); NODES];
            for (node, seen) in nodes.iter_mut().enumerate() {
                let line = lines[node];
                *seen = Node {
                    row: line.row_beside(own, column) - away[node] * own.level_rows_per_mm - first,
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
    /// Adds light of patches: of the tile's own and one more on either side, `[patch][row]`, linear from the middle of
    /// one to that of the next.
    pub(crate) fn add_patches(&mut self, shown: &[[f32; ROWS]; PER_TILE + 2]) {
        add_linear(shown, self.drawn.clone(), &mut self.volume);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn add_linear(shown: &[[f32; ROWS]; PER_TILE + 2], rows: Range<usize>, volume: &mut [[f32; TILE]; ROWS]) {
    // Which two patches each column of a patch lies between, of three beside each other, and how far it is from the
    // first to the second.
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

/// Whether a tile of a line, or one beside it, faces others.
fn uneven_near(line: &ScanLine, tile: usize) -> bool {
    let near = |uneven: &[bool]| uneven[tile.saturating_sub(1)..(tile + 2).min(uneven.len())].contains(&true);
    line.secondary.as_ref().is_some_and(|secondary| near(&secondary.patches.uneven))
}

/// Light that a column shows in one scan line.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Node {
    /// Where in the window it is seen [px].
    pub row: f32,
    /// Where along the motion it comes from [mm].
    pub y: f32,
    /// Light by length along the motion [e-/mm].
    pub by_mm: f32,
}

/// Lays the light between two nodes on the rows of a window.
pub(crate) fn lay(a: Node, b: Node, rows: &mut [f32; ROWS]) {
    let (step, length) = (b.row - a.row, (b.y - a.y).abs());
    if step.abs() < 1e-3 || (a.by_mm == 0.0 && b.by_mm == 0.0) {
        return;
    }
    let (low, high) = (a.row.min(b.row).max(-0.5), a.row.max(b.row).min(ROWS as f32 - 0.5));
    let by_row = length / step.abs();
    let mut from = low;
    while from < high {
        // Pixels end halfway between rows; none lies before the first.
        let row = (from + 0.5) as usize;
        let to = (row as f32 + 0.5).min(high);
        let middle = (0.5 * (from + to) - a.row) / step;
        let light = a.by_mm + (b.by_mm - a.by_mm) * middle;
        if let Some(sum) = rows.get_mut(row) {
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

    /// Card and wall of a pocket with a line across both: rays by Lambert's law from the card, followed to the wall,
    /// land as often in each strip along the motion and each part of the height as patches say, within 4 %, and 15 % at
    /// the wall's foot.
    #[test]
    fn walls_receive_what_rays_from_the_card_bring() {
        let mut rng = base::Stream::root(41).rng();
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
                    let receivers = ys.map(|y| {
                        Some(Receiver {
                            x: lean * y + over(y),
                            z: steep * over(y),
                            slope_x: steep,
                            slope_y: -steep * lean,
                            line_y: -y,
                        })
                    });
                    let mut got = [0.0; NODES];
                    receive(&card, 0..places, 0.003, &receivers, &mut got);
                    let area = wall_end / steps_x as f32 * 8.0 / ((steps_y / NODES + 1) * NODES) as f32;
                    for (receiver, got) in receivers.iter().flatten().zip(got) {
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
        let mut rng = base::Stream::root(42).rng();
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
