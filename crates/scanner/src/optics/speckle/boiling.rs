//! Speckle boiling: how far a movement of the object takes the speckle across the pupil.
//!
//! Light from the point S of the object reaches the point P of the pupil over |S - source| + |P - S|. A movement a of
//! the object changes the phase of the point xi of its surface by k xi . H a, with the matrix of second derivatives
//!
//! ```text
//! H = (1 - l l^T) / d_SP + (1 - l_s l_s^T) / d_SL
//! ```
//!
//! which is what a point of the pupil displaced by q would see instead, k xi . q / d_SP (Yamaguchi 1981; Bergmann et
//! al. 2016, A.3). l is the unit vector from the surface to the pupil and not the sensor's normal; d_SL is the radius
//! of the laser's wave: across the line R = s [1 + (z_R / s)^2] at s behind the waist, infinite in the waist and
//! negative before it. Along the line the distance of the fan's origin. q lies in the plane across l, so with w = d_SP
//! H a along the surface q = (w_x, w_y, -(l_x w_x + l_y w_y) / l_z). A.4 is w for a = (0, a_y, 0): 0.056 mm for a_y =
//! 0.068 mm in the waist, 0.122 mm where R = 420 mm.
//!
//! A surface that lies dz higher shows another pattern, uncorrelated after dz0 = 8 lambda (d / D)^2. Neglected: what
//! the movement along l itself adds, quadratic in dz / dz0 and under 1 in 1000 over the lit rows; slopes of the
//! surface; M^2, beyond its share in z_R.

use optical_bench::parameters::Bench;

/// Lens and laser wavefront that determine the boiling.
#[derive(Debug, Clone, Copy)]
pub struct Boiling {
    /// y and z of the lens, at x = 0 [mm].
    lens: [f64; 2],
    /// Diameter of the pupil [mm].
    pupil: f64,
    /// Height of the waist [mm].
    waist: f64,
    /// Rayleigh length [mm].
    rayleigh: f64,
    /// Height of the fan's origin [mm].
    fan: f64,
    /// Change of height after which the pattern is uncorrelated [mm].
    depth: f64,
}

impl Boiling {
    /// For a bench.
    pub fn new(bench: &Bench) -> Self {
        let (laser, camera) = (&bench.laser, &bench.camera);
        let (sin, cos) = libm::sincos(camera.tilt_deg.to_radians());
        let wavelength = laser.wavelength_nm * 1e-6;
        let pupil = camera.focal_length_mm / camera.f_number;
        let over = camera.distance_mm / pupil;
        Self {
            lens: [-camera.distance_mm * sin, camera.distance_mm * cos],
            pupil,
            waist: laser.waist_height_mm,
            rayleigh: std::f64::consts::PI * laser.waist_mm * laser.waist_mm / (laser.m_squared * wavelength),
            fan: laser.fan_height_mm,
            depth: 8.0 * wavelength * over * over,
        }
    }

    /// Displacement across the pupil, in its diameters, by a movement `a` (x, y) [mm] of the point `x`, `z` of the
    /// laser plane [1].
    pub fn diameters(&self, [x, z]: [f64; 2], a: [f64; 2]) -> f64 {
        let [w, l] = self.along_surface([x, z], a);
        let up = (l[0] * w[0] + l[1] * w[1]) / l[2];
        (w[0] * w[0] + w[1] * w[1] + up * up).sqrt() / self.pupil
    }

    /// The same by a rise of `dz` [mm] [1].
    pub fn rise(&self, dz: f64) -> f64 {
        dz / self.depth
    }

    /// w = d_SP H a along the surface [mm] and l [1].
    fn along_surface(&self, [x, z]: [f64; 2], [ax, ay]: [f64; 2]) -> [[f64; 3]; 2] {
        let to_lens = [-x, self.lens[0], self.lens[1] - z];
        let far = (to_lens[0] * to_lens[0] + to_lens[1] * to_lens[1] + to_lens[2] * to_lens[2]).sqrt();
        let l = to_lens.map(|v| v / far);
        let height = (self.fan - z).max(1.0);
        let from_fan = (x * x + height * height).sqrt();
        let side = x / from_fan;
        // 1 / R in the plane across the line: s / (s^2 + z_R^2), s along the light.
        let behind = self.waist - z;
        let bent = behind / (behind * behind + self.rayleigh * self.rayleigh);
        let along = l[0] * ax + l[1] * ay;
        let wx = ax - l[0] * along + far * ax * (1.0 - side * side) / from_fan;
        let wy = ay - l[1] * along + far * ay * bent;
        [[wx, wy, 0.0], l]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A.4: a_y (d_SP / d_SL + 1 - l_y^2) is 0.0558 mm in the waist, 0.122 and 0.195 mm for waves of 420 and 200 mm; in
    /// the plane across l it is longer by 1 / cos 25 deg. A height change of 11 mm is one pupil.
    #[test]
    fn movement_over_the_pupil_is_that_of_the_appendix() {
        let mut bench = Bench::default();
        // A short Rayleigh length: the wave's radius is then the distance from the waist.
        (bench.laser.waist_mm, bench.laser.waist_height_mm) = (0.005, 0.0);
        let w = |below: f64| {
            let mut bench = bench;
            bench.laser.waist_height_mm = below;
            let boiling = Boiling::new(&bench);
            let [w, l] = boiling.along_surface([0.0, 0.0], [0.0, 0.068]);
            let whole = boiling.diameters([0.0, 0.0], [0.0, 0.068]) * boiling.pupil;
            assert!((whole * l[2] / w[1].abs() - 1.0).abs() < 1e-9, "across l {whole}, along the surface {}", w[1]);
            w[1]
        };
        for (radius, known) in [(0.0, 0.0558), (420.0, 0.122), (200.0, 0.195)] {
            assert!((w(radius) / known - 1.0).abs() < 6e-3, "{} mm for a wave of {radius} mm", w(radius));
        }
        let boiling = Boiling::new(&bench);
        assert!((boiling.rise(11.1) - 1.0).abs() < 0.01, "{}", boiling.rise(11.1));
        // Before the waist the wave shrinks: the pattern boils less, and the other way round.
        assert!((w(-400.0) + 0.0138).abs() < 2e-4, "{}", w(-400.0));
    }
}
