//! The reference of the exposure: light followed ray by ray from the laser over true triangles through the lens to
//! pixels.
//!
//! Nothing here is taken from production but the numbers of the bench. Light leaves the laser's virtual source, meets
//! the first triangle in its way and is thrown back evenly (Lambert, radiance = matte x irradiance / pi). A point of
//! the lens's aperture is drawn, the way to it must be free, the thin lens sends the ray on through the point's image,
//! and the tilted sensor cuts it where it is. The lens's other blur moves the place by a normal draw. A pixel gathers
//! what falls on its square. Every ray carries its exact weight, so means have no error but that of chance, which is
//! given a pixel. No light passes the surface; walls are as matte as their triangles say.

pub mod eye;
pub mod light;
pub mod object;
pub mod scenes;
pub mod shapes;
pub mod verdict;

use glam::DVec3;

use eye::Eye;
use light::Light;
use object::Object;

/// Uniform and normal draws, xoshiro256++ (Blackman and Vigna 2019) from a seed by splitmix64.
pub struct Chance([u64; 4]);

impl Chance {
    /// A generator of its own for each seed.
    pub fn new(seed: u64) -> Self {
        let mut state = seed;
        Self(std::array::from_fn(|_| {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            z ^ (z >> 31)
        }))
    }

    fn next(&mut self) -> u64 {
        let s = &mut self.0;
        let out = s[0].wrapping_add(s[3]).rotate_left(23).wrapping_add(s[0]);
        let t = s[1] << 17;
        s[2] ^= s[0];
        s[3] ^= s[1];
        s[1] ^= s[2];
        s[0] ^= s[3];
        s[2] ^= t;
        s[3] = s[3].rotate_left(45);
        out
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Two independent standard normal numbers (Box and Muller 1958).
    pub fn normals(&mut self) -> [f64; 2] {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * self.uniform()).sin_cos();
        [radius * cos, radius * sin]
    }
}

/// A rectangle of the sensor [px].
#[derive(Debug, Clone, Copy)]
pub struct Region {
    pub first_col: usize,
    pub cols: usize,
    pub first_row: i32,
    pub rows: usize,
}

impl Region {
    /// Where a place of the sensor lies in the rectangle.
    fn index(&self, [col, row]: [f64; 2]) -> Option<usize> {
        let col = (col + 0.5).floor() - self.first_col as f64;
        let row = (row + 0.5).floor() - f64::from(self.first_row);
        let inside = (0.0..self.cols as f64).contains(&col) && (0.0..self.rows as f64).contains(&row);
        inside.then(|| row as usize * self.cols + col as usize)
    }
}

/// Electrons of each pixel of a region, with standard errors `[rows, cols]`, row-major [e-].
#[derive(Debug, Clone)]
pub struct Picture {
    pub region: Region,
    pub mean: Vec<f64>,
    pub error: Vec<f64>,
    /// Electrons of one ray where rays weigh most, which tells how many rays a pixel had [e-].
    pub quantum: f64,
}

/// Follows `rays` rays; each one's weight is the electrons that it stands for.
pub fn picture(light: &Light, object: &Object, eye: &Eye, region: Region, rays: usize, seed: u64) -> Picture {
    let mut chance = Chance::new(seed);
    let (mut sum, mut square) = (vec![0.0; region.cols * region.rows], vec![0.0; region.cols * region.rows]);
    for _ in 0..rays {
        let ray = light.shine(&mut chance);
        let Some((at, facet)) = object.first(ray.from, ray.way) else { continue };
        let normal = facet.normal;
        if facet.matte == 0.0 || normal.dot(ray.way) >= 0.0 {
            continue;
        }
        let aperture = eye.aperture(&mut chance);
        let to = aperture - at;
        let distance2 = to.length_squared();
        let view = to / distance2.sqrt();
        let leaves = normal.dot(view);
        if leaves <= 0.0 || !object.free(at + normal * 1e-3, aperture) {
            continue;
        }
        let Some(place) = eye.image(at, aperture, &mut chance) else { continue };
        let Some(index) = region.index(place) else { continue };
        // Radiance x projected area x solid angle of the aperture, in electrons.
        let gathered = facet.matte / std::f64::consts::PI * leaves * -view.dot(eye.axis) * eye.area() / distance2;
        let weight = light.watts(&ray, at) * gathered * eye.electrons_per_watt;
        sum[index] += weight;
        square[index] += weight * weight;
    }
    let n = rays as f64;
    let total: [f64; 2] = [sum.iter().sum(), square.iter().sum()];
    let mean: Vec<f64> = sum.iter().map(|s| s / n).collect();
    let error = mean.iter().zip(&square).map(|(m, s)| ((s / n - m * m).max(0.0) / n).sqrt()).collect();
    Picture { region, mean, error, quantum: total[1] / total[0] / n }
}

/// A vector from single precision.
pub fn exact(v: glam::Vec3) -> DVec3 {
    DVec3::new(f64::from(v.x), f64::from(v.y), f64::from(v.z))
}
