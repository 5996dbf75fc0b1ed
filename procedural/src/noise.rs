//! Smooth random functions of position on hashed lattices.
//!
//! Models: stationary noise of mean 0 and unit root mean square; the value at each integer point is uniform on
//! (-sqrt 3, sqrt 3), and between the points the values are joined by Perlin's (2002) quintic, so that the slopes are
//! continuous and smooth. The quintic averages neighbours; in d dimensions it keeps (181/231)^d of the variance, which
//! is divided out. Lattice points are hashed with the two-multiply integer mixer "lowbias32" (Wellons 2018).
//! Limits: below a quarter of the cell it is a polynomial; over more than 2^24 cells f32 no longer resolves a cell.

use glam::{Vec2, Vec3};

use crate::Stream;

/// Share of the variance that the quintic keeps along one dimension, twice the integral of its square [1].
const KEPT: f32 = 181.0 / 231.0;
/// From a hash read as a signed word to a uniform number of unit variance: sqrt 3 / 2^31 [1].
const UNIT: f32 = 1.732_050_8 / 2_147_483_648.0;
/// Odd multipliers that spread lattice coordinates over the words before mixing: 2^32 over the golden ratio, and the
/// first two words of the fractional part of pi made odd.
const SPREAD: [u32; 3] = [0x9e37_79b1, 0x243f_6a89, 0x85a3_08d3];
/// Each octave of the fractal sum has this many times the frequency of the one before; not 2, so that lattices part [1].
const LACUNARITY: f32 = 2.03;
/// Amplitude of an octave over the one before [1].
const GAIN: f32 = 0.5;

/// One random function; two with different seeds are independent.
#[derive(Debug, Clone, Copy)]
pub struct Noise {
    seed: u32,
}

impl Noise {
    /// The function that belongs to a stream.
    pub fn new(stream: Stream) -> Self {
        let key = stream.key();
        Self { seed: (key ^ (key >> 32)) as u32 }
    }

    /// Value [1] and slope [1/cell] on a line of cells of unit length.
    #[inline]
    pub fn line(self, p: f32) -> (f32, f32) {
        let (cell, weight, slope) = split(p);
        let (a, b) = (self.corner(cell, 0, 0), self.corner(cell.wrapping_add(1), 0, 0));
        let scale = 1.0 / KEPT.sqrt();
        (scale * (a + weight * (b - a)), scale * slope * (b - a))
    }

    /// Value [1] and gradient [1/cell] on a plane of unit cells.
    #[inline]
    pub fn plane(self, p: Vec2) -> (f32, Vec2) {
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
        let ((i, u, _), (j, v, _), (k, w, _)) = (split(p.x), split(p.y), split(p.z));
        let corners = self.corners(i, j, k);
        let edge = |n: usize| corners[n] + u * (corners[n + 1] - corners[n]);
        let (near, far) = (edge(0) + v * (edge(2) - edge(0)), edge(4) + v * (edge(6) - edge(4)));
        (near + w * (far - near)) / (KEPT * KEPT.sqrt())
    }

    /// Value [1] and gradient [1/cell] in space of unit cells.
    #[inline]
    pub fn space_slope(self, p: Vec3) -> (f32, Vec3) {
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
        (scale * (near + w * (far - near)), scale * gradient)
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

    #[inline]
    fn corners(self, i: u32, j: u32, k: u32) -> [f32; 8] {
        std::array::from_fn(|n| {
            let n = n as u32;
            self.corner(i.wrapping_add(n & 1), j.wrapping_add((n >> 1) & 1), k.wrapping_add(n >> 2))
        })
    }

    #[inline]
    fn corner(self, i: u32, j: u32, k: u32) -> f32 {
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
        h as i32 as f32 * UNIT
    }
}

/// Lattice cell, weight of its upper end [1] and the slope of that weight [1/cell].
#[inline]
fn split(p: f32) -> (u32, f32, f32) {
    // Truncation and a correction: `floor` is a library call on the plainest x86-64.
    let truncated = p as i32;
    let cell = truncated - i32::from(p < truncated as f32);
    let x = p - cell as f32;
    let weight = x * x * x * (x * (6.0 * x - 15.0) + 10.0);
    let slope = 30.0 * x * x * (x - 1.0) * (x - 1.0);
    (cell as u32, weight, slope)
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
        ];
        // 4 cases, alpha 0.001 in all: 3.7 standard errors. Squares of bounded values: their sd is below 1.5.
        let n = 40_000.0_f64;
        for (case, (mean, square)) in cases.into_iter().enumerate() {
            assert!(mean.abs() < 3.7 / n.sqrt(), "case {case}: mean {mean}");
            assert!((square - 1.0).abs() < 3.7 * 1.5 / n.sqrt(), "case {case}: mean square {square}");
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
}
