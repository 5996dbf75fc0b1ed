//! Radiosity in a closed room (Goral et al. 1984): flat facets that send light by Lambert's law, over a floor that may
//! be a mirror.
//!
//! Of what a facet sends, `cos(theta) cos(theta') A' / (pi d^2 + A')` arrives at another (disc to point), straight or
//! by way of the mirror, and all of it somewhere: the room is closed, so that shares are scaled to 1 before the mirror
//! takes its part. Neglected: directions that a facet prefers, the roughness of the mirror, where on a facet light
//! arrives.

use std::ops::Range;

use glam::Vec3;
use multiversion::multiversion;

/// A part of a room's walls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Facet {
    /// Its middle [mm].
    pub at: Vec3,
    /// Its normal into the room, as long as its area [mm^2].
    pub area: Vec3,
    /// Share of light that it throws back [1].
    pub returns: f32,
}

/// A floor that mirrors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mirror {
    /// Its height [mm].
    pub z: f32,
    /// Share of light that it mirrors [1].
    pub reflectance: f32,
}

/// Share of what `from` sends that arrives at `to`, were nothing else there, nearer than a facet's size too [1].
#[inline(always)]
pub(super) fn arrives(from: &Facet, to: (Vec3, Vec3)) -> f32 {
    let d = to.0 - from.at;
    let d2 = d.length_squared();
    let (sent, received) = (from.area.dot(d), -to.1.dot(d));
    if sent <= 0.0 || received <= 0.0 {
        return 0.0;
    }
    sent * received / (from.area.length() * d2 * (std::f32::consts::PI * d2 + to.1.length()))
}

/// Facets that light arrives at, structure of arrays.
#[derive(Debug, Default)]
struct Targets {
    at: [Vec<f32>; 3],
    area: [Vec<f32>; 3],
    size: Vec<f32>,
}

impl Targets {
    fn of(facets: &[Facet]) -> Self {
        let each = |value: &dyn Fn(&Facet) -> f32| facets.iter().map(value).collect();
        Self {
            at: std::array::from_fn(|i| each(&|facet| facet.at[i])),
            area: std::array::from_fn(|i| each(&|facet| facet.area[i])),
            size: each(&|facet| facet.area.length()),
        }
    }
}

/// [`arrives`] at each of `targets`, straight and by way of a mirror at height `mirror_z` [1].
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn arrive_at(from: &Facet, targets: &Targets, mirror_z: f32, [straight, mirrored]: [&mut [f32]; 2]) {
    let n = targets.size.len();
    let [x, y, z] = targets.at.each_ref().map(|at| &at[..n]);
    let [normal_x, normal_y, normal_z] = targets.area.each_ref().map(|area| &area[..n]);
    let (size, straight, mirrored) = (&targets.size[..n], &mut straight[..n], &mut mirrored[..n]);
    let own = from.area.length();
    for to in 0..n {
        let [dx, dy] = [x[to] - from.at.x, y[to] - from.at.y];
        let heights = [(z[to], normal_z[to]), (2.0 * mirror_z - z[to], -normal_z[to])];
        let mut arrives = [0.0f32; 2];
        for (way, (z, normal_z)) in heights.into_iter().enumerate() {
            let dz = z - from.at.z;
            let d2 = dx * dx + dy * dy + dz * dz;
            let sent = (from.area.x * dx + from.area.y * dy + from.area.z * dz).max(0.0);
            let received = (-normal_x[to] * dx - normal_y[to] * dy - normal_z * dz).max(0.0);
            // Nothing arrives where it starts.
            arrives[way] = sent * received / (own * d2 * (std::f32::consts::PI * d2 + size[to])).max(f32::MIN_POSITIVE);
        }
        [straight[to], mirrored[to]] = arrives;
    }
}

/// Whether something stands on the way between two points that goes by a mirror.
fn is_mirrored_behind(a: Vec3, b: Vec3, mirror_z: f32, blocked: &impl Fn(Vec3, Vec3) -> bool) -> bool {
    let [above, other] = [a.z, b.z].map(|z| (z - mirror_z).max(0.0));
    let part = if above + other > 0.0 { above / (above + other) } else { 0.5 };
    let on = (a + (b - a) * part).truncate().extend(mirror_z);
    // What stands on the floor is met first there.
    blocked(on, a) || blocked(on, b)
}

/// Share of what each of `facets` sends that arrives at each, `[to][from]`; `blocked`, if anything can stand between
/// facets, says whether something stands between two points [1].
pub(super) fn exchange(facets: &[Facet], mirror: Mirror, blocked: Option<impl Fn(Vec3, Vec3) -> bool>) -> Vec<f32> {
    let n = facets.len();
    let targets = Targets::of(facets);
    let mut shares = vec![0.0f32; n * n];
    let (mut straight, mut mirrored) = (vec![0.0f32; n], vec![0.0f32; n]);
    // Either way alike; each facet asks of those before it what they have found.
    let mut stands = vec![[false; 2]; if blocked.is_some() { n * n } else { 0 }];
    for (number, from) in facets.iter().enumerate() {
        arrive_at(from, &targets, mirror.z, [&mut straight, &mut mirrored]);
        if let Some(blocked) = &blocked {
            for (place, to) in facets.iter().enumerate() {
                let known = place < number;
                let mut between = if known { stands[place * n + number] } else { [false; 2] };
                if !known && straight[place] > 0.0 {
                    between[0] = blocked(from.at, to.at);
                }
                if !known && mirrored[place] > 0.0 {
                    between[1] = is_mirrored_behind(from.at, to.at, mirror.z, blocked);
                }
                stands[number * n + place] = between;
                straight[place] = if between[0] { 0.0 } else { straight[place] };
                mirrored[place] = if between[1] { 0.0 } else { mirrored[place] };
            }
        }
        let all = straight.iter().chain(&mirrored).sum::<f32>().max(f32::MIN_POSITIVE);
        for (place, (straight, mirrored)) in straight.iter().zip(&mirrored).enumerate() {
            shares[place * n + number] = (straight + mirror.reflectance * mirrored) / all;
        }
    }
    shares
}

/// Places of a vector: lines whose light is followed together.
pub(super) const LANES: usize = 16;
/// Light of so many lines.
pub(super) type LineLight = [f32; LANES];
/// Least share that facets throw back: by it what has arrived is told from what is sent on [1].
const LEAST_RETURNED: f32 = 0.02;
/// Rows that elimination takes at a time: others are read and written once for all of them.
const BLOCK: usize = 16;
/// Columns of a block that stay in the first-level cache while it is taken off other rows.
const TILE: usize = 256;
/// Rows of a matrix that are multiplied together, so that sums don't wait for each other.
const ROWS: usize = 8;

/// A room in which all exchanges between all facets are known.
#[derive(Debug)]
pub(super) struct Enclosure {
    /// The two triangles of 1 - r F among the sources, after all other facets are eliminated, `[to][from]`.
    factors: Vec<f32>,
    /// Share of light that each source throws back [1].
    returns: Vec<f32>,
}

impl Enclosure {
    /// Of facets that exchange these `shares` of light, of which the last `sources` send it.
    pub fn of(facets: &[Facet], shares: &[f32], sources: usize) -> Self {
        let n = facets.len();
        let returns = |facet: &Facet| facet.returns.max(LEAST_RETURNED);
        let rows = shares.chunks_exact(n.max(1)).zip(facets);
        let mut matrix: Vec<f32> =
            rows.flat_map(|(row, facet)| row.iter().map(move |share| -share * returns(facet))).collect();
        for i in 0..n {
            matrix[i * n + i] += 1.0;
        }
        eliminate(&mut matrix, n);
        let kept = matrix.chunks_exact(n.max(1)).skip(n - sources);
        Self {
            factors: kept.flat_map(|row| &row[n - sources..]).copied().collect(),
            returns: facets[n - sources..].iter().map(returns).collect(),
        }
    }

    /// What arrives in the end at each source of what these send: H with H = F (sent + r H). All that leaves, sent + r
    /// H, is (1 - r F)^-1 times what is sent.
    pub fn arrives(&self, sent: &[LineLight]) -> Vec<LineLight> {
        let mut all = sent.to_vec();
        leave(&self.factors, &mut all);
        for ((all, sent), returns) in all.iter_mut().zip(sent).zip(&self.returns) {
            for lane in 0..LANES {
                all[lane] = (all[lane] - sent[lane]) / returns;
            }
        }
        all
    }
}

/// Solves with the two triangles `factors`, in place.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn leave(factors: &[f32], light: &mut [LineLight]) {
    let n = light.len();
    let factor = |row: usize, column: usize| factors[row * n + column];
    for first in (0..n).step_by(ROWS) {
        let end = (first + ROWS).min(n);
        let sums = products(factors, n, first, 0..first, light);
        for row in first..end {
            for lane in 0..LANES {
                light[row][lane] -= sums[row - first][lane];
            }
            for column in first..row {
                for lane in 0..LANES {
                    light[row][lane] -= factor(row, column) * light[column][lane];
                }
            }
        }
    }
    for first in (0..n).step_by(ROWS).rev() {
        let end = (first + ROWS).min(n);
        let sums = products(factors, n, first, end..n, light);
        for row in (first..end).rev() {
            for lane in 0..LANES {
                light[row][lane] -= sums[row - first][lane];
            }
            for column in row + 1..end {
                for lane in 0..LANES {
                    light[row][lane] -= factor(row, column) * light[column][lane];
                }
            }
            let inverse = 1.0 / factor(row, row);
            for lane in 0..LANES {
                light[row][lane] *= inverse;
            }
        }
    }
}

/// Rows of `matrix` `[row][length]` from `first` on times `values`, of which those `of` a range count. Sums go by
/// rising number; beyond the last row they are that one's.
#[inline(always)]
fn products(matrix: &[f32], length: usize, first: usize, of: Range<usize>, values: &[LineLight]) -> [LineLight; ROWS] {
    let last = (matrix.len() / length.max(1)).saturating_sub(1);
    let rows: [&[f32]; ROWS] = std::array::from_fn(|row| &matrix[(first + row).min(last) * length..][of.start..of.end]);
    let mut sums = [[0.0f32; LANES]; ROWS];
    for (at, values) in values[of].iter().enumerate() {
        for row in 0..ROWS {
            let factor = rows[row][at];
            for lane in 0..LANES {
                sums[row][lane] += factor * values[lane];
            }
        }
    }
    sums
}

/// `matrix` `[out][values]` times `values`, which are zero but for those `of` a range.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn multiply(matrix: &[f32], values: &[LineLight], of: Range<usize>, out: &mut [LineLight]) {
    for (block, out) in out.chunks_mut(ROWS).enumerate() {
        let sums = products(matrix, values.len(), block * ROWS, of.clone(), values);
        out.copy_from_slice(&sums[..out.len()]);
    }
}

/// Gaussian elimination of `matrix` `[n][n]`, which becomes its two triangles: factors below the diagonal, and what is
/// left from there on. Without pivots: columns' diagonals dominate, as no facet's light arrives more than once.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn eliminate(matrix: &mut [f32], n: usize) {
    let mut factors = Vec::with_capacity(n);
    for first in (0..n).step_by(BLOCK) {
        let end = (first + BLOCK).min(n);
        let (pivots, below) = matrix[first * n..].split_at_mut((end - first) * n);
        for k in 0..end - first {
            let (above, rest) = pivots.split_at_mut((k + 1) * n);
            let pivot = &above[k * n..];
            for row in rest.chunks_exact_mut(n) {
                let factor = row[first + k] / pivot[first + k];
                subtract(&mut row[first + k + 1..], factor, &pivot[first + k + 1..]);
                row[first + k] = factor;
            }
        }
        factors.clear();
        for row in below.chunks_exact_mut(n) {
            let mut of_row = [0.0f32; BLOCK];
            for k in 0..end - first {
                let pivot = &pivots[k * n..(k + 1) * n];
                of_row[k] = row[first + k] / pivot[first + k];
                subtract(&mut row[first + k + 1..end], of_row[k], &pivot[first + k + 1..end]);
                row[first + k] = of_row[k];
            }
            factors.push(of_row);
        }
        subtract_products(below, &factors, pivots, n, end..n);
    }
}

/// Subtracts a row times a factor.
#[inline(always)]
fn subtract(from: &mut [f32], factor: f32, row: &[f32]) {
    from.iter_mut().zip(row).for_each(|(value, row)| *value -= factor * row);
}

/// Subtracts from these columns of each row `[row][stride]` the rows of a block `[k][stride]` times its factors, in the
/// order of k.
#[inline(always)]
fn subtract_products(from: &mut [f32], factors: &[[f32; BLOCK]], block: &[f32], stride: usize, columns: Range<usize>) {
    let mut tile = [[0.0f32; TILE]; BLOCK];
    for first in columns.clone().step_by(TILE) {
        let of = first..(first + TILE).min(columns.end);
        for (tile, row) in tile.iter_mut().zip(block.chunks_exact(stride)) {
            tile[..of.len()].copy_from_slice(&row[of.clone()]);
        }
        for (row, factors) in from.chunks_exact_mut(stride).zip(factors) {
            for (i, value) in row[of.clone()].iter_mut().enumerate() {
                let mut left = *value;
                for k in 0..BLOCK {
                    left -= factors[k] * tile[k][i];
                }
                *value = left;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    /// Nothing stands between facets.
    const OPEN: Option<fn(Vec3, Vec3) -> bool> = None;

    /// Facets of a half sphere of radius `r` over z = 0, which look inwards.
    fn dome(r: f32, returns: f32) -> Vec<Facet> {
        let rings = 14;
        let mut facets = Vec::new();
        for ring in 0..rings {
            // Even in z, as areas on a sphere are.
            let z = (ring as f32 + 0.5) / rings as f32;
            let around = ((1.0 - z * z).sqrt() * std::f32::consts::TAU * rings as f32 / 2.0).ceil() as usize;
            for step in 0..around {
                let (sin, cos) =
                    (std::f32::consts::TAU * (step as f32 + 0.5 * (ring % 2) as f32) / around as f32).sin_cos();
                let out = Vec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
                let area = std::f32::consts::TAU * r * r / rings as f32 / around as f32;
                facets.push(Facet { at: out * r, area: -out * area, returns });
            }
        }
        facets
    }

    /// In a sphere each place receives the same of any other's light, whatever lies between; a half sphere over a
    /// perfect mirror is one. All that is sent, a, arrives as a / (1 - returns) in the end.
    #[test]
    fn a_dome_over_a_mirror_is_an_integrating_sphere() {
        let mut rng = base::Stream::root(62).rng();
        for _ in 0..4 {
            let (r, returns) = (rng.random_range(0.7..5.0f32), rng.random_range(0.05..0.9f32));
            let facets = dome(r, returns);
            let n = facets.len();
            let shares = exchange(&facets, Mirror { z: 0.0, reflectance: 1.0 }, OPEN);
            let source = rng.random_range(0..n);
            let mut sent = vec![[0.0; LANES]; n];
            sent[source] = [1.0; LANES];
            let settled = Enclosure::of(&facets, &shares, n).arrives(&sent);
            let flux: Vec<f32> = settled.iter().map(|lines| lines[0]).collect();
            let all: f32 = flux.iter().sum();
            assert!((all * (1.0 - returns) - 1.0).abs() < 1e-3, "{all} at returns {returns}");
            let even = 1.0 / (1.0 - returns) / (std::f32::consts::TAU * r * r);
            let off = flux.iter().zip(&facets).map(|(flux, facet)| (flux / facet.area.length() / even - 1.0).abs());
            let mean = off.sum::<f32>() / n as f32;
            assert!(mean < 0.05, "light differs from place to place by {mean} in the mean");
        }
    }

    /// A mirror takes its part once a way: over one of reflectance m half of a dome's light meets it.
    #[test]
    fn a_floor_takes_what_it_does_not_mirror() {
        let facets = dome(1.0, 0.0);
        let n = facets.len();
        for reflectance in [0.0, 0.4, 0.9] {
            let shares = exchange(&facets, Mirror { z: 0.0, reflectance }, OPEN);
            let mean = shares.iter().sum::<f32>() / n as f32;
            assert!((mean - 0.5 * (1.0 + reflectance)).abs() < 0.02, "{mean} over a mirror of {reflectance}");
        }
    }

    /// What stands between hides: behind a wall across the dome it is dark.
    #[test]
    fn what_is_blocked_does_not_arrive() {
        let facets = dome(1.0, 0.5);
        let n = facets.len();
        let shares =
            exchange(&facets, Mirror { z: 0.0, reflectance: 0.9 }, Some(|a: Vec3, b: Vec3| (a.x > 0.0) != (b.x > 0.0)));
        for (to, from) in (0..n).flat_map(|to| (0..n).map(move |from| (to, from))) {
            let apart = (facets[to].at.x > 0.0) != (facets[from].at.x > 0.0);
            assert!(!apart || shares[to * n + from] == 0.0);
        }
    }

    /// The solution of random rooms, a source in each line, is that of adding one exchange after the other.
    #[test]
    fn elimination_sums_all_exchanges() {
        let mut rng = base::Stream::root(63).rng();
        for _ in 0..12 {
            let (n, sources) = (rng.random_range(3..60usize), rng.random_range(1..=LANES));
            let facets: Vec<Facet> = (0..n)
                .map(|_| Facet { at: Vec3::ZERO, area: Vec3::Z, returns: rng.random_range(0.05..0.95) })
                .collect();
            let mut shares: Vec<f32> = (0..n * n).map(|_| rng.random::<f32>()).collect();
            for from in 0..n {
                let all: f32 = (0..n).map(|to| shares[to * n + from]).sum();
                (0..n).for_each(|to| shares[to * n + from] /= all);
            }
            let sources = sources.min(n);
            let first_source = n - sources;
            let sent: Vec<LineLight> =
                (0..sources).map(|source| std::array::from_fn(|line| f32::from(u8::from(line == source)))).collect();
            let solved = Enclosure::of(&facets, &shares, sources).arrives(&sent);
            for source in 0..sources {
                let first: Vec<f32> = (0..n).map(|to| shares[to * n + first_source + source]).collect();
                let mut summed = first.clone();
                for _ in 0..800 {
                    let again = |to: usize| -> f32 {
                        (0..n).map(|from| shares[to * n + from] * facets[from].returns * summed[from]).sum()
                    };
                    summed = (0..n).map(|to| first[to] + again(to)).collect();
                }
                for (solved, summed) in solved.iter().zip(&summed[first_source..]) {
                    let solved = solved[source];
                    assert!((solved - summed).abs() < 1e-3 * summed, "{solved} for {summed}");
                }
            }
        }
    }
}
