//! Smooth random functions of position, made from hashed numbers.
//!
//! Models: noise of mean 0 and unit root mean square, all with continuous and smooth slopes.
//! `plane`, `space` and `line` are value noise: the value at each point of a lattice is uniform on (-sqrt 3, sqrt 3),
//! and between the points the values are joined by Perlin's (2002) quintic. The quintic averages neighbours; in d
//! dimensions it keeps (181/231)^d of the variance, which is divided out. Its variance is larger at lattice points than
//! between them. The lattice is therefore turned against the axes by angles whose tangents are irrational. No row or
//! column of an image meets lattice points at equal phases, and no statistic of rows or columns repeats with the cell.
//! `fibres` is sparse convolution (Lewis 1989) across and value noise along. Lanes with centres uniform in their cells
//! have the profile (1 - d^2)^3, and each lane carries value noise of one dimension with a phase and a rate of its own.
//! `score` is one such lane a cell.
//! Uniform centres and phases make its mean and covariance the same at every place, without any lattice. `bundles` does
//! so along the fibre; across it is turned value noise whose weights are scaled to equal variance everywhere.
//! `nearest` tells how far jittered points are (Worley 1996).
//! Hash: the two-multiply integer mixer "lowbias32" (Wellons 2018).
//! Limits: below a quarter of the cell it is a polynomial; over more than 2^22 cells f32 no longer resolves a cell.

use base::{BLOCK, Stream};
use glam::{Mat3, Vec2, Vec3};
use multiversion::multiversion;

/// Share of the variance that the quintic keeps along one dimension, twice the integral of its square [1].
const KEPT: f32 = 181.0 / 231.0;
/// From a hash read as a signed word to a uniform number of unit variance: sqrt 3 / 2^31 [1].
const UNIT: f32 = 1.732_050_8 / 2_147_483_648.0;
/// 1.5 * 2^23: what is added to it is rounded to a whole number, which stands in its last bits.
const WHOLE: f32 = 12_582_912.0;
/// Odd multipliers that spread lattice coordinates over the words before mixing: 2^32 over the golden ratio, and the
/// first two words of the fractional part of pi made odd.
const SPREAD: [u32; 3] = [0x9e37_79b1, 0x243f_6a89, 0x85a3_08d3];
/// No value of `plane` is larger than sqrt 3 over what the quintic keeps [1].
pub(crate) const PLANE_MOST: f32 = 2.211;
/// No value of `fibres` is larger [1]: of three lanes the profiles sum to 2 at most, each with sqrt 3 over the root of
/// what the quintic keeps.
pub(crate) const FIBRES_MOST: f32 = 4.74;
/// Each octave of the fractal sum has this many times the frequency of the one before; not 2, so that lattices part
/// [1].
const LACUNARITY: f32 = 2.03;
/// Amplitude of an octave over the one before [1].
const GAIN: f32 = 0.5;
/// Cosine and sine of the lattice's turn in a plane [1]; its tangent is 0.532, no ratio of small numbers.
const PLANE_TURN: Vec2 = Vec2::new(0.882_947_6, 0.469_471_6);
/// Axes of the lattice in space [1]: a turn of 1 rad about (1, 2, 3), whose rows have no ratios of small numbers.
const SPACE_TURN: Mat3 = Mat3::from_cols(
    Vec3::new(0.573_137_86, 0.740_348_8, -0.351_278_54),
    Vec3::new(-0.609_006_64, 0.671_644_5, 0.421_905_9),
    Vec3::new(0.548_291_8, -0.027_879_29, 0.835_822_28),
);
/// Mean over uniform centres of the sum of squared lane profiles: the integral of (1 - d^2)^6 [1].
const LANES: f32 = 2048.0 / 3003.0;
/// Depth of a score's groove over the height of its ridge [1].
const GROOVE: f32 = 0.3;
/// Mean square of scores over the half width: that of the profile 0.7138, times 1/5 for their depths, squares of
/// uniform numbers, times the half of each that is there [1].
const SCORE_POWER: f32 = 0.071_38;
/// Slowest rate of the noise along a lane, and how much faster others are [1].
const RATES: [f32; 2] = [0.7, 0.6];

/// One random function; two with different seeds are independent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    seed: u32,
}

impl Noise {
    /// The function that belongs to a stream.
    pub fn new(stream: Stream) -> Self {
        let key = stream.key();
        Self { seed: (key ^ (key >> 32)) as u32 }
    }

    /// Value [1] and slope [1/cell] on a line of cells of unit length: a straight cut through the plane.
    #[inline]
    pub fn line(self, p: f32) -> (f32, f32) {
        let (value, slope) = self.plane(Vec2::new(p, 0.0));
        (value, slope.x)
    }

    /// Value [1] and gradient [1/cell] on a plane of unit cells.
    #[inline(always)]
    pub fn plane(self, p: Vec2) -> (f32, Vec2) {
        let (value, gradient) = self.upright_plane(PLANE_TURN.rotate(p));
        (value, Vec2::new(PLANE_TURN.dot(gradient), PLANE_TURN.perp_dot(gradient)))
    }

    #[inline(always)]
    fn upright_plane(self, p: Vec2) -> (f32, Vec2) {
        let ((i, u, du), (j, v, dv)) = (split(p.x), split(p.y));
        let (i1, j1) = (i.wrapping_add(1), j.wrapping_add(1));
        let (a, b) = (self.corner(i, j, 0), self.corner(i1, j, 0));
        let (c, d) = (self.corner(i, j1, 0), self.corner(i1, j1, 0));
        let (low, high) = (a + u * (b - a), c + u * (d - c));
        let across = (b - a) + v * ((d - c) - (b - a));
        let scale = 1.0 / KEPT;
        (scale * (low + v * (high - low)), scale * Vec2::new(du * across, dv * (high - low)))
    }

    /// Value in space of unit cells [1].
    #[inline]
    pub fn space(self, p: Vec3) -> f32 {
        let p = SPACE_TURN * p;
        let ((i, u, _), (j, v, _), (k, w, _)) = (split(p.x), split(p.y), split(p.z));
        let corners = self.corners(i, j, k);
        let edge = |n: usize| corners[n] + u * (corners[n + 1] - corners[n]);
        let (near, far) = (edge(0) + v * (edge(2) - edge(0)), edge(4) + v * (edge(6) - edge(4)));
        (near + w * (far - near)) / (KEPT * KEPT.sqrt())
    }

    /// Value [1] and gradient [1/cell] in space of unit cells.
    #[inline]
    pub fn space_slope(self, p: Vec3) -> (f32, Vec3) {
        let p = SPACE_TURN * p;
        let ((i, u, du), (j, v, dv), (k, w, dw)) = (split(p.x), split(p.y), split(p.z));
        let c = self.corners(i, j, k);
        let step = [c[1] - c[0], c[3] - c[2], c[5] - c[4], c[7] - c[6]];
        let edge = [c[0] + u * step[0], c[2] + u * step[1], c[4] + u * step[2], c[6] + u * step[3]];
        let (rise_near, rise_far) = (edge[1] - edge[0], edge[3] - edge[2]);
        let (near, far) = (edge[0] + v * rise_near, edge[2] + v * rise_far);
        let (step_near, step_far) = (step[0] + v * (step[1] - step[0]), step[2] + v * (step[3] - step[2]));
        let gradient = Vec3::new(
            du * (step_near + w * (step_far - step_near)),
            dv * (rise_near + w * (rise_far - rise_near)),
            dw * (far - near),
        );
        let scale = 1.0 / (KEPT * KEPT.sqrt());
        (scale * (near + w * (far - near)), scale * (SPACE_TURN.transpose() * gradient))
    }

    /// Value [1] and gradient [1/cell] of fibres side by side on a plane: `p` is (across, along) in cells, a lane's
    /// half width and the mean length over which it changes.
    #[inline(always)]
    pub fn fibres(self, p: Vec2) -> (f32, Vec2) {
        let (cell, ..) = split(p.x);
        let (mut value, mut gradient) = (0.0, Vec2::ZERO);
        for step in 0..3_u32 {
            let number = cell.wrapping_add(step).wrapping_sub(1);
            let lane = self.lane(number, 0);
            let d = p.x - number as i32 as f32 - lane.place;
            let left = (1.0 - d * d).max(0.0);
            let profile = left * left * left;
            let (along, slope) = lane.at(p.y);
            value += profile * along;
            gradient += Vec2::new(-6.0 * d * left * left * along, profile * slope);
        }
        let scale = 1.0 / LANES.sqrt();
        (scale * value, scale * gradient)
    }

    /// Value [1] and gradient [1/pass, 1/cell] of scores, one a pass, in the middle half of it: `p` counts passes, and
    /// cells along over which scores begin and end. `half` is the half width of a ridge, an eighth of a pass at most; a
    /// groove lies behind it.
    #[inline(always)]
    pub fn score(self, p: Vec2, half: f32) -> (f32, Vec2) {
        let (number, ..) = split(p.x);
        let lane = self.lane(number, 1);
        let d = (p.x - number as i32 as f32 - 0.25 - 0.5 * lane.place) / half;
        let (along, slope) = lane.at(p.y);
        let depth = (lane.rate - RATES[0]) / RATES[1];
        let scale = if along > 0.0 { depth * depth / (half * SCORE_POWER).sqrt() } else { 0.0 };
        let bump = |d: f32| {
            let left = (1.0 - d * d).max(0.0);
            Vec2::new(left * left * left, -6.0 * d * left * left)
        };
        let profile = bump(d) - GROOVE * bump(d - 1.0);
        (scale * along * profile.x, scale * Vec2::new(along * profile.y / half, slope * profile.x))
    }

    /// [`Self::fibres`] at places that have `across` and `along` in common order: values, and both parts of the
    /// gradients.
    #[inline]
    pub fn fibres_at(self, across: &[f32; BLOCK], along: &[f32; BLOCK]) -> [[f32; BLOCK]; 3] {
        fibres_at(self, across, along)
    }

    /// [`Self::bundles`] at places by their coordinates.
    #[inline]
    pub fn bundles_at(self, p: &[[f32; BLOCK]; 3]) -> [f32; BLOCK] {
        bundles_at(self, p)
    }

    /// Value of bundles of fibres side by side in space [1]: the first two of `p` are across, the third along, in
    /// cells.
    #[inline(always)]
    pub fn bundles(self, p: Vec3) -> f32 {
        let across = PLANE_TURN.rotate(p.truncate());
        let ((i, u, _), (j, v, _)) = (split(across.x), split(across.y));
        let lane = |i: u32, j: u32| self.lane(i, j).at(p.z).0;
        let (i1, j1) = (i.wrapping_add(1), j.wrapping_add(1));
        let (a, b, c, d) = (lane(i, j), lane(i1, j), lane(i, j1), lane(i1, j1));
        let (low, high) = (a + u * (b - a), c + u * (d - c));
        // By the root of the sum of squared weights, so that the variance is the same between lanes as on them.
        let power = (1.0 - 2.0 * u * (1.0 - u)) * (1.0 - 2.0 * v * (1.0 - v));
        (low + v * (high - low)) / power.sqrt()
    }

    /// Four numbers of a cell, uniform on [0, 1) in steps of 1/1024 [1].
    #[inline]
    pub fn cell(self, i: i32, j: i32) -> [f32; 4] {
        let first = self.hash(i as u32, j as u32, SPREAD[2]);
        let second = self.hash(j as u32, i as u32, SPREAD[0]);
        let share = |word: u32, shift: u32| ((word >> shift) & 0x3ff) as f32 / 1024.0;
        [share(first, 0), share(first, 11), share(second, 0), share(second, 11)]
    }

    #[inline(always)]
    fn lane(self, i: u32, j: u32) -> Lane {
        let key = self.hash(i, j, SPREAD[1]);
        // Bits of one hash: place, rate and phase; the whole of it is the key of the values along.
        let share = |shift: u32, bits: u32| ((key >> shift) & ((1 << bits) - 1)) as f32 / (1_u32 << bits) as f32;
        Lane {
            values: Self { seed: key },
            place: share(0, 12),
            rate: RATES[0] + RATES[1] * share(12, 8),
            phase: share(20, 12),
        }
    }

    /// Fractal sum of three octaves in space, again of unit root mean square [1].
    #[inline]
    pub fn fractal(self, p: Vec3) -> f32 {
        let mut sum = 0.0;
        let mut power = 0.0;
        let (mut amplitude, mut frequency) = (1.0_f32, 1.0_f32);
        for octave in 0..3_u32 {
            let layer = Self { seed: self.seed.wrapping_add(octave.wrapping_mul(SPREAD[0])) };
            sum += amplitude * layer.space(p * frequency);
            power += amplitude * amplitude;
            amplitude *= GAIN;
            frequency *= LACUNARITY;
        }
        sum / power.sqrt()
    }

    /// Distance to the nearest of points that lie one in each unit cell, in cells [1].
    pub fn nearest(self, p: Vec3) -> f32 {
        let p = SPACE_TURN * p;
        let corner = [p.x, p.y, p.z].map(|x| split(x).0.wrapping_sub(1));
        let distance = |n: u32| {
            let steps = [n % 3, n / 3 % 3, n / 9];
            let [i, j, k]: [u32; 3] = std::array::from_fn(|axis| corner[axis].wrapping_add(steps[axis]));
            let word = self.hash(i, j, k);
            let share = |shift: u32| ((word >> shift) & 0x3ff) as f32 / 1024.0;
            let cell = Vec3::new(i as i32 as f32, j as i32 as f32, k as i32 as f32);
            p.distance_squared(cell + Vec3::new(share(0), share(11), share(22)))
        };
        (0..27).map(distance).fold(f32::INFINITY, f32::min).sqrt()
    }

    #[inline(always)]
    fn corners(self, i: u32, j: u32, k: u32) -> [f32; 8] {
        let mut corners = [0.0; 8];
        for (n, corner) in (0..8).zip(&mut corners) {
            *corner = self.corner(i.wrapping_add(n & 1), j.wrapping_add((n >> 1) & 1), k.wrapping_add(n >> 2));
        }
        corners
    }

    #[inline(always)]
    fn corner(self, i: u32, j: u32, k: u32) -> f32 {
        self.hash(i, j, k) as i32 as f32 * UNIT
    }

    #[inline(always)]
    fn hash(self, i: u32, j: u32, k: u32) -> u32 {
        let mut h = self
            .seed
            .wrapping_add(i.wrapping_mul(SPREAD[0]))
            .wrapping_add(j.wrapping_mul(SPREAD[1]))
            .wrapping_add(k.wrapping_mul(SPREAD[2]));
        h ^= h >> 16;
        h = h.wrapping_mul(0x7feb_352d);
        h ^= h >> 15;
        h = h.wrapping_mul(0x846c_a68b);
        h ^= h >> 16;
        h
    }
}

/// One fibre or bundle: noise along a line.
#[derive(Debug, Clone, Copy)]
struct Lane {
    values: Noise,
    /// Its centre within its cell [cell].
    place: f32,
    /// Cells of its own in a cell along [1].
    rate: f32,
    /// Where its own cells begin [cell].
    phase: f32,
}

impl Lane {
    /// Value [1] and slope [1/cell] along the fibre, of unit root mean square.
    #[inline(always)]
    fn at(self, along: f32) -> (f32, f32) {
        let (k, w, dw) = split(along * self.rate + self.phase);
        let (a, b) = (self.values.corner(k, 0, 0), self.values.corner(k.wrapping_add(1), 0, 0));
        let scale = 1.0 / KEPT.sqrt();
        (scale * (a + w * (b - a)), scale * self.rate * dw * (b - a))
    }
}

/// Lattice cell, weight of its upper end [1] and the slope of that weight [1/cell].
#[inline(always)]
fn split(p: f32) -> (u32, f32, f32) {
    // The nearest whole number and a correction: `floor` is a library call on the plainest x86-64, and conversions that
    // saturate are no vector code.
    let shifted = p + WHOLE;
    let nearest = shifted - WHOLE;
    let above = nearest > p;
    let cell = (shifted.to_bits() as i32).wrapping_sub(WHOLE.to_bits() as i32) - i32::from(above);
    let x = p - if above { nearest - 1.0 } else { nearest };
    let weight = x * x * x * (x * (6.0 * x - 15.0) + 10.0);
    let slope = 30.0 * x * x * (x - 1.0) * (x - 1.0);
    (cell as u32, weight, slope)
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn fibres_at(noise: Noise, across: &[f32; BLOCK], along: &[f32; BLOCK]) -> [[f32; BLOCK]; 3] {
    let mut out = [[0.0; BLOCK]; 3];
    for n in 0..BLOCK {
        let (value, gradient) = noise.fibres(Vec2::new(across[n], along[n]));
        [out[0][n], out[1][n], out[2][n]] = [value, gradient.x, gradient.y];
    }
    out
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn bundles_at(noise: Noise, p: &[[f32; BLOCK]; 3]) -> [f32; BLOCK] {
    let mut out = [0.0; BLOCK];
    for n in 0..BLOCK {
        out[n] = noise.bundles(Vec3::new(p[0][n], p[1][n], p[2][n]));
    }
    out
}

/// Hermite step from 0 at `from` to 1 at `to` [1].
#[inline]
pub fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise() -> Noise {
        Noise::new(Stream::root(11).child("noise"))
    }

    /// Mean and mean square of one value a cell, at a place that moves through the cell.
    fn moments(value: impl Fn(f32, f32) -> f32) -> (f64, f64) {
        let n = 40_000_u32;
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in 0..n {
            // Every third cell, so that samples share no lattice point; the golden ratio fills the cell evenly.
            let v = f64::from(value(i as f32 * 3.0, (i as f32 * 0.618_034).fract()));
            sum += v;
            squares += v * v;
        }
        (sum / f64::from(n), squares / f64::from(n))
    }

    #[test]
    fn unit_root_mean_square_in_every_dimension() {
        let n = noise();
        let turn = |f: f32, by: f32| (f * 7.0 + by).fract();
        let cases = [
            moments(|i, f| n.line(i + f).0),
            moments(|i, f| n.plane(Vec2::new(i + f, turn(f, 0.3))).0),
            moments(|i, f| n.space(Vec3::new(i + f, turn(f, 0.3), turn(turn(f, 0.1), 0.7)))),
            moments(|i, f| n.fractal(Vec3::new(i * 7.0 + f, turn(f, 0.3), turn(turn(f, 0.1), 0.7)))),
            moments(|i, f| n.fibres(Vec2::new(i + f, 40.0 * turn(f, 0.3))).0),
            moments(|i, f| n.bundles(Vec3::new(i + f, turn(f, 0.3), 40.0 * turn(turn(f, 0.1), 0.7)))),
        ];
        // 6 cases, alpha 0.001 in all: 3.8 standard errors. Squares of bounded values: their sd is below 1.5.
        let n = 40_000.0_f64;
        for (case, (mean, square)) in cases.into_iter().enumerate() {
            assert!(mean.abs() < 3.8 / n.sqrt(), "case {case}: mean {mean}");
            assert!((square - 1.0).abs() < 3.8 * 1.5 / n.sqrt(), "case {case}: mean square {square}");
        }
    }

    #[test]
    fn slopes_are_derivatives() {
        let n = noise();
        let h = 1.0e-2_f32;
        // Central differences of a quintic: error h^2/6 times the third derivative, below 60 * 2 sqrt 3 * 1.5 a cell^3.
        let bound = h * h / 6.0 * 320.0 + 1.0e-4;
        for i in 0..500 {
            let p = Vec3::new(i as f32 * 0.137, i as f32 * -0.071, i as f32 * 0.211);
            let line = (n.line(p.x + h).0 - n.line(p.x - h).0) / (2.0 * h);
            assert!((line - n.line(p.x).1).abs() < bound);
            let q = Vec2::new(p.x, p.y);
            let slope = n.plane(q).1;
            for (axis, analytic) in [(Vec2::X, slope.x), (Vec2::Y, slope.y)] {
                let numeric = (n.plane(q + h * axis).0 - n.plane(q - h * axis).0) / (2.0 * h);
                assert!((numeric - analytic).abs() < bound);
            }
            let (value, slope) = n.space_slope(p);
            assert!((value - n.space(p)).abs() < 1.0e-5);
            for (axis, analytic) in [(Vec3::X, slope.x), (Vec3::Y, slope.y), (Vec3::Z, slope.z)] {
                let numeric = (n.space(p + h * axis) - n.space(p - h * axis)) / (2.0 * h);
                assert!((numeric - analytic).abs() < bound);
            }
        }
    }

    /// Spreads of the rows and of the columns of a picture of `size` squared pixels.
    fn spreads(size: usize, pixel: impl Fn(usize, usize) -> f32) -> [Vec<f64>; 2] {
        let picture: Vec<f64> = (0..size * size).map(|i| f64::from(pixel(i % size, i / size))).collect();
        let spread = |start: usize, step: usize| {
            let values = || (0..size).map(|i| picture[start + i * step]);
            let mean = values().sum::<f64>() / size as f64;
            (values().map(|v| (v - mean).powi(2)).sum::<f64>() / size as f64).sqrt()
        };
        [(0..size).map(|row| spread(row * size, 1)).collect(), (0..size).map(|column| spread(column, size)).collect()]
    }

    /// Autocorrelation of a series at each of the lags.
    fn correlations(series: &[f64], lags: std::ops::Range<usize>) -> Vec<f64> {
        let n = series.len();
        let mean = series.iter().sum::<f64>() / n as f64;
        let product = |lag: usize| {
            series[lag..].iter().zip(series).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / (n - lag) as f64
        };
        let variance = product(0);
        lags.map(|lag| product(lag) / variance).collect()
    }

    #[test]
    fn no_lattice_shows_in_the_spread_of_rows_and_columns() {
        const SIZE: usize = 256;
        // Steps a pixel [cell], unlike in the two directions as on a sensor; slopes show a lattice more than values do.
        let at = |i: usize, j: usize| Vec2::new(0.171 * i as f32 + 40.0, 0.077 * j as f32 + 70.0);
        let long = |i: usize, j: usize| Vec2::new(0.25 * i as f32 + 40.0, 0.077 * j as f32 + 70.0);
        type Pixel = fn(Noise, Vec2) -> f32;
        let kinds: [(&str, Pixel); 8] = [
            ("plane", |n, p| n.plane(p).0),
            ("slope of a plane", |n, p| n.plane(p).1.y),
            ("space", |n, p| n.space(p.extend(7.3))),
            ("slope in space", |n, p| n.space_slope(p.extend(7.3)).1.y),
            ("fibres", |n, p| n.fibres(p).0),
            ("slope along fibres", |n, p| n.fibres(p).1.y),
            ("bundles along", |n, p| n.bundles(Vec3::new(3.0 * p.x, 0.3, p.y))),
            ("bundles across", |n, p| n.bundles(Vec3::new(p.x, p.y, 0.2))),
        ];
        for (name, kind) in kinds {
            let fibrous = name.contains("fibres");
            let mut sums = [vec![0.0; 60], vec![0.0; 60]];
            let boards = 12;
            for board in 0..boards {
                let noise = Noise::new(Stream::root(board).child("board"));
                let pixel = |i, j| kind(noise, if fibrous { long(i, j) } else { at(i, j) });
                for (sum, series) in sums.iter_mut().zip(spreads(SIZE, pixel)) {
                    for (sum, value) in sum.iter_mut().zip(correlations(&series, 40..100)) {
                        *sum += value / boards as f64;
                    }
                }
            }
            // Beyond three cells nothing is related. A mean of 12 series of 256 that keep their value over some 10 of
            // their steps: standard error sqrt(10/256/12) = 0.06, the largest of 120 lags some 4 times that. A lattice
            // that stands upright gives 0.5 to 0.95.
            let largest = sums.iter().flatten().fold(0.0_f64, |most, &v| most.max(v));
            assert!(largest < 0.25, "{name}: {largest}");
        }
    }
}
