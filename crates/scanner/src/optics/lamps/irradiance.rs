//! Irradiance of a surface by lamps, and what the surface itself throws back of it.
//!
//! A lamp is an arc of even radiance in the plane across the line, from zenith angle a to b on one side. On a surface
//! with slope s along the motion, whose normal has the cosine u against upright, it gives
//!
//! ```text
//! E = u ((sin m - sin a) + s (cos m - cos a)) / (sin b - sin a),   m = min(b, horizon)
//! ```
//!
//! so that E = 1 on a level surface; the horizon is the steepest rise of heights along the motion on the lamp's side.
//! Light from all sides gives (1 + u) / 2, less what horizons above [`LOW_HORIZON`] and above the surface's own plane
//! hide of it.
//!
//! Each fibre is a cylinder that mirrors a lamp into a cone about itself (Marschner et al. 2005). Axes of fibres lean
//! about their mean direction f by a normal law of standard deviation t. With the half vector h of lamp and lens they
//! add A exp(-(f . h)^2 / (2 t^2)) to the radiance factor, where A is that of fibres across h. Attenuation inside of
//! fibres and the cone's own width are part of A and t.
//!
//! Valid for lamps that are long against their distance and far against the object. Neglected: rises along the line.

use base::{BLOCK, Gloss};
use glam::Vec3;
use multiversion::multiversion;

use crate::optics::light::LampLine;
use crate::specimen::Hit;
use optical_bench::parameters::Bench;
use optical_bench::settings;
use transport::kernel::DIFFUSE_GROUPS;

/// Rise of a horizon up to which it hides nothing: tan(20 degrees), where the lowest lamp ends [1].
pub(super) const LOW_HORIZON: f32 = 0.363_97;
/// Its sine.
const SIN_LOW: f32 = 0.342_02;

/// One lamp.
#[derive(Debug, Clone, Copy)]
struct Lamp {
    /// Side on which it stands: 1 for profiles to come, -1 for those before.
    side: f32,
    /// Sine and cosine of the zenith angles at which it begins and ends.
    from: [f32; 2],
    to: [f32; 2],
    /// Unit vector to its middle, and between that and the one to the lens.
    towards: Vec3,
    half: Vec3,
    /// Part of the way from normal incidence to grazing that Fresnel's law goes between them, by Schlick's fit [1].
    grazing: f32,
    /// Share of all light [1].
    share: f32,
}

/// Lamps of one sample.
#[derive(Debug, Clone)]
pub(crate) struct Lamps {
    lamps: Vec<Lamp>,
    /// Share of the light that comes from all sides [1].
    fill: f32,
    /// Absorption at their wavelength over that at the laser's [1].
    pub absorption: f32,
    /// Unit vector to the lens.
    view: Vec3,
    /// What their width adds to the square of facets' roughness along the motion [1].
    blunt: f32,
    /// Radiance factor of fibres across the half vector [1], and one over twice the variance of what leans [1].
    sheen: [f32; 2],
}

impl Lamps {
    /// Those of a bench; `None` where it has none.
    pub fn new(bench: &Bench) -> Option<Self> {
        let own = &bench.lamps;
        let second = match bench.optics.lamps {
            settings::Lamps::None => return None,
            settings::Lamps::One => 0.0,
            settings::Lamps::Two => own.second_share,
        };
        let half_deg = 0.5 * own.width_deg;
        let (sin, cos) = libm::sincos(bench.camera.tilt_deg.to_radians());
        let view = Vec3::new(0.0, -sin as f32, cos as f32);
        let lamp = |tilt_deg: f64, share: f64| {
            let at = |deg: f64| libm::sincos(deg.to_radians());
            let pair = |(sin, cos): (f64, f64)| [sin as f32, cos as f32];
            let (sin, cos) = at(tilt_deg);
            let towards = Vec3::new(0.0, sin as f32, cos as f32);
            let half = (towards + view).normalize();
            let c = 1.0 - half.dot(view);
            Lamp {
                side: if tilt_deg < 0.0 { -1.0 } else { 1.0 },
                from: pair(at(tilt_deg.abs() - half_deg)),
                to: pair(at(tilt_deg.abs() + half_deg)),
                towards,
                half,
                grazing: c * c * c * c * c,
                share: (share * (1.0 - own.fill)) as f32,
            }
        };
        let lamps = [lamp(own.tilt_deg, 1.0 - second), lamp(own.second_tilt_deg, second)];
        // Half of an angle again; an even law has a twelfth of its width's square.
        let leans = own.sheen_spread_deg.to_radians().powi(2) + own.width_deg.to_radians().powi(2) / 48.0;
        let apart = bench.laser.wavelength_nm - own.wavelength_nm;
        Some(Self {
            lamps: lamps.into_iter().filter(|lamp| lamp.share > 0.0).collect(),
            fill: own.fill as f32,
            absorption: libm::exp(apart / own.absorption_decay_nm) as f32,
            view,
            // A half vector goes along by half of an angle: twice the variance of an even law, as Beckmann's roughness.
            blunt: (own.width_deg.to_radians().powi(2) / 24.0) as f32,
            sheen: [own.sheen as f32, (0.5 / leans) as f32],
        })
    }

    /// Fills what lamps find on a line; `diffuse` is the reflectance of its matter by group of widths, and the bare
    /// conveyor throws back `conveyor`, all of it at the surface.
    pub fn light(&self, hits: &[Hit], diffuse: &[Vec<f32>; DIFFUSE_GROUPS], conveyor: f32, line: &mut LampLine) {
        let LampLine { height, slope, up, surface, roots, seen } = line;
        for field in [&mut *height, &mut *slope, &mut *up, &mut *surface] {
            field.resize(hits.len(), 0.0);
        }
        seen.clear();
        seen.extend(hits.iter().map(|hit| hit.seen));
        let mut facets = Facets::default();
        for (block, hits) in hits.chunks(BLOCK).enumerate() {
            let columns = block * BLOCK..block * BLOCK + hits.len();
            for (n, hit) in hits.iter().enumerate() {
                height[columns.start + n] = hit.surface.z;
                facets.put(n, hit, conveyor);
            }
            facets.shine(self);
            slope[columns.clone()].copy_from_slice(&facets.slope[1][..hits.len()]);
            up[columns.clone()].copy_from_slice(&facets.up[..hits.len()]);
            surface[columns].copy_from_slice(&facets.light[..hits.len()]);
        }
        for (roots, diffuse) in roots.iter_mut().zip(diffuse) {
            roots.clear();
            roots.extend(diffuse.iter().map(|share| share.sqrt()));
            // Empty where a line shows no body.
            roots.resize(hits.len(), 0.0);
        }
        for (column, _) in hits.iter().enumerate().filter(|(_, hit)| hit.is_bare()) {
            roots.iter_mut().for_each(|roots| roots[column] = 0.0);
        }
    }

    /// Irradiance in `columns` of a line without shadows, into `out`.
    pub fn unshaded(&self, line: &LampLine, columns: std::ops::Range<usize>, out: &mut [f32]) {
        let numbers: Vec<[f32; 2]> = self.lamps.iter().map(|lamp| [lamp.share, lamp.side * lamp.lean()]).collect();
        unshaded(&numbers, self.fill, &line.slope[columns.clone()], &line.up[columns], out);
    }

    /// Irradiance of one column of a line whose horizons rise by `rises` before it and behind it.
    pub fn shaded(&self, slope: f32, up: f32, rises: [f32; 2]) -> f32 {
        let horizons = rises.map(|rise| {
            let cos = 1.0 / (1.0 + rise * rise).sqrt();
            [cos, rise * cos]
        });
        let of = |lamp: &Lamp| lamp.share * lamp.shaded(slope, up, horizons[usize::from(lamp.side > 0.0)]);
        // What rises above the surface's own plane, which (1 + u) / 2 knows.
        let hides = |side: usize| {
            let own = if side == 0 { -slope } else { slope };
            0.5 * (horizons[side][1] - SIN_LOW.max(own / (1.0 + own * own).sqrt())).max(0.0) / (1.0 - SIN_LOW)
        };
        let hidden = hides(0) + hides(1);
        self.lamps.iter().map(of).sum::<f32>() + self.fill * 0.5 * (1.0 + up) * (1.0 - hidden)
    }
}

/// Surfaces of some columns, structure of arrays, and what they throw back themselves.
#[derive(Debug, Default)]
struct Facets {
    /// Slopes along the line and along the motion [1].
    slope: [[f32; BLOCK]; 2],
    /// Share of facets, their reflectance, and what is matte [1].
    share: [f32; BLOCK],
    reflectance: [f32; BLOCK],
    matte: [f32; BLOCK],
    /// Roughness along the line and along the motion [1].
    roughness: [[f32; BLOCK]; 2],
    /// Direction of fibres along the motion and upwards, and 1 where there are any [1].
    fibre: [[f32; BLOCK]; 2],
    is_fibrous: [f32; BLOCK],
    /// Cosine of the normal against upright [1].
    up: [f32; BLOCK],
    /// Radiance factor without shadows [1].
    light: [f32; BLOCK],
}

impl Facets {
    #[inline(always)]
    fn put(&mut self, n: usize, hit: &Hit, conveyor: f32) {
        let gloss = if hit.is_bare() { Gloss { matte: conveyor, ..Gloss::NONE } } else { hit.matter.medium.gloss };
        (self.slope[0][n], self.slope[1][n]) = (hit.surface.slope_x, hit.surface.slope_y);
        (self.share[n], self.reflectance[n], self.matte[n]) = (gloss.share, gloss.reflectance, gloss.matte);
        (self.roughness[0][n], self.roughness[1][n]) = (gloss.roughness[0], gloss.roughness[1]);
        let medium = &hit.matter.medium;
        self.is_fibrous[n] = f32::from(!hit.is_bare() && medium.k > 0.0);
        (self.fibre[0][n], self.fibre[1][n]) = (medium.fibre.y, medium.fibre.z);
    }

    fn shine(&mut self, lamps: &Lamps) {
        shine(self, lamps);
        if lamps.sheen[0] > 0.0 {
            self.gleam(lamps);
        }
    }

    /// Adds the highlights of fibres.
    fn gleam(&mut self, lamps: &Lamps) {
        let [strength, steep] = lamps.sheen;
        for lamp in &lamps.lamps {
            for n in 0..BLOCK {
                let apart = self.fibre[0][n] * lamp.half.y + self.fibre[1][n] * lamp.half.z;
                let gleam = self.is_fibrous[n] * strength * libm::expf(-steep * apart * apart);
                self.light[n] += lamp.share * gleam * lit(lamp, self.slope[1][n], self.up[n]);
            }
        }
    }
}

/// Fills cosines and light of facets: [`transport::fresnel::gloss`] with half vectors that are the same for all, for
/// lamps that are as wide as they are.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn shine(facets: &mut Facets, lamps: &Lamps) {
    let Facets { slope: [across, along], share, reflectance, matte, roughness: [ax, ay], up, light, .. } = facets;
    for n in 0..BLOCK {
        up[n] = 1.0 / (1.0 + across[n] * across[n] + along[n] * along[n]).sqrt();
        light[n] = lamps.fill * 0.5 * (1.0 + up[n]) * (matte[n] + share[n] * reflectance[n]);
    }
    for lamp in &lamps.lamps {
        for n in 0..BLOCK {
            let normal = [-across[n] * up[n], -along[n] * up[n]];
            let cosine = |to: Vec3| to.y * normal[1] + to.z * up[n];
            let middle = cosine(lamp.half);
            // Parts of the half vector along the surface's tangents nearest to x and y, squared.
            let level = (1.0 - normal[0] * normal[0]).max(1e-6);
            let tx = middle * middle * normal[0] * normal[0] / level;
            let ty = (1.0 - middle * middle - tx).max(0.0);
            let ay = (ay[n] * ay[n] + lamps.blunt).sqrt();
            let d = tx / (ax[n] * ax[n]) + ty / (ay * ay) + middle * middle;
            let fresnel = reflectance[n] + (1.0 - reflectance[n]) * lamp.grazing;
            let facing = cosine(lamp.towards).max(0.05) * cosine(lamps.view).max(0.05);
            let lobe = share[n] * fresnel / (ax[n] * ay * d * d * 4.0 * facing);
            light[n] += lamp.share * (matte[n] + lobe) * lit(lamp, along[n], up[n]);
        }
    }
}

/// Irradiance by a lamp without shadows, of a surface with a slope along the motion and a cosine against upright [1].
#[inline(always)]
fn lit(lamp: &Lamp, along: f32, up: f32) -> f32 {
    ((1.0 - lamp.side * lamp.lean() * along) * up).max(0.0)
}

impl Lamp {
    /// Tangent of the angle at which it stands, in the mean [1].
    fn lean(&self) -> f32 {
        (self.from[1] - self.to[1]) / (self.to[0] - self.from[0])
    }

    /// Irradiance where the horizon stands at a zenith angle of this sine and cosine.
    fn shaded(&self, slope: f32, up: f32, horizon: [f32; 2]) -> f32 {
        let [sin, cos] = if horizon[0] < self.to[0] { horizon } else { self.to };
        if sin <= self.from[0] {
            return 0.0;
        }
        let sum = sin - self.from[0] + self.side * slope * (cos - self.from[1]);
        (up * sum / (self.to[0] - self.from[0])).max(0.0)
    }
}

/// Irradiance without shadows by lamps of these shares and leans and light from all sides.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn unshaded(lamps: &[[f32; 2]], fill: f32, slope: &[f32], up: &[f32], out: &mut [f32]) {
    for ((out, slope), up) in out.iter_mut().zip(slope).zip(up) {
        let mut sum = fill * 0.5 * (1.0 + up);
        for [share, lean] in lamps {
            sum += share * ((1.0 - lean * slope) * up).max(0.0);
        }
        *out = sum;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use transport::fresnel;

    /// Gloss is that of the laser's model, slope by slope.
    #[test]
    fn facets_shine_as_under_the_laser() {
        let mut bench = Bench::default();
        bench.optics.lamps = settings::Lamps::One;
        bench.lamps.fill = 0.0;
        let lamps = Lamps::new(&bench).expect("a lamp");
        let blunted = (0.4f32 * 0.4 + lamps.blunt).sqrt();
        let gloss = Gloss { share: 0.7, reflectance: 0.3, roughness: [0.2, blunted], matte: 0.1 };
        let mut facets = Facets::default();
        for n in 0..BLOCK {
            let slopes = [0.05 * n as f32 - 0.4, 0.3 - 0.04 * n as f32];
            (facets.slope[0][n], facets.slope[1][n], facets.share[n], facets.matte[n]) =
                (slopes[0], slopes[1], 0.7, 0.1);
            (facets.reflectance[n], facets.roughness[0][n], facets.roughness[1][n]) = (0.3, 0.2, 0.4);
        }
        facets.shine(&lamps);
        for n in 0..BLOCK {
            let normal = Vec3::new(-facets.slope[0][n], -facets.slope[1][n], 1.0).normalize();
            let lit = (1.0 - lamps.lamps[0].lean() * facets.slope[1][n]) * normal.z;
            let expected = lit * fresnel::gloss(&gloss, normal, lamps.lamps[0].towards, lamps.view);
            assert!((facets.light[n] / expected - 1.0).abs() < 1e-4, "{n}: {} for {expected}", facets.light[n]);
        }
    }

    /// Fibres that lie across the half vector have the whole highlight, others what the normal law leaves of it.
    #[test]
    fn fibres_gleam_where_they_mirror_a_lamp() {
        let mut bench = Bench::default();
        bench.optics.lamps = settings::Lamps::One;
        (bench.lamps.fill, bench.lamps.width_deg) = (0.0, 1.0);
        (bench.lamps.sheen, bench.lamps.sheen_spread_deg) = (0.3, 9.0);
        for (tilt_deg, lens_deg) in [(45.0, 25.0), (-30.0, 25.0), (55.0, -10.0)] {
            (bench.lamps.tilt_deg, bench.camera.tilt_deg) = (tilt_deg, lens_deg);
            let lamps = Lamps::new(&bench).expect("a lamp");
            // Lamp and lens stand at tilt and -lens from upright: fibres lie across the middle of both at this dive.
            let mirrors = -0.5f64 * (tilt_deg - lens_deg);
            let mut facets = Facets { roughness: [[0.3; BLOCK]; 2], ..Facets::default() };
            for n in 0..BLOCK {
                let (sin, cos) = (mirrors + 3.0 * n as f64).to_radians().sin_cos();
                (facets.fibre[0][n], facets.fibre[1][n]) = (cos as f32, sin as f32);
                facets.is_fibrous[n] = f32::from(n + 1 < BLOCK);
            }
            facets.shine(&lamps);
            for n in 0..BLOCK - 1 {
                // A degree of width adds an eighth of a percent to the variance.
                let apart = (3.0 * n as f64).to_radians().sin() / 9.0f64.to_radians();
                let expected = 0.3 * (-0.5 * apart * apart).exp();
                let told = f64::from(facets.light[n]);
                assert!((told / expected - 1.0).abs() < 0.02, "{tilt_deg}, {n}: {told} for {expected}");
            }
            assert_eq!(facets.light[BLOCK - 1], 0.0, "no fibres, no highlight");
        }
    }
}
