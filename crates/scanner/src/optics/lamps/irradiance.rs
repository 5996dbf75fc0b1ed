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
//! Light from all sides gives (1 + u) / 2, less what horizons above [`LOW_HORIZON`] hide of it.
//!
//! Valid for lamps that are long against their distance and far against the object. Neglected: rises along the line.

use base::Gloss;
use glam::Vec3;
use multiversion::multiversion;

use crate::optics::light::LampLine;
use crate::specimen::Hit;
use optical_bench::parameters::Bench;
use optical_bench::settings;
use transport::fresnel;
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
    /// Unit vector to its middle.
    towards: Vec3,
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
        let half = 0.5 * own.width_deg;
        let lamp = |tilt_deg: f64, share: f64| {
            let at = |deg: f64| libm::sincos(deg.to_radians());
            let pair = |(sin, cos): (f64, f64)| [sin as f32, cos as f32];
            let (sin, cos) = at(tilt_deg);
            Lamp {
                side: if tilt_deg < 0.0 { -1.0 } else { 1.0 },
                from: pair(at(tilt_deg.abs() - half)),
                to: pair(at(tilt_deg.abs() + half)),
                towards: Vec3::new(0.0, sin as f32, cos as f32),
                share: (share * (1.0 - own.fill)) as f32,
            }
        };
        let lamps = [lamp(own.tilt_deg, 1.0 - second), lamp(own.second_tilt_deg, second)];
        let apart = bench.laser.wavelength_nm - own.wavelength_nm;
        let (sin, cos) = libm::sincos(bench.camera.tilt_deg.to_radians());
        Some(Self {
            lamps: lamps.into_iter().filter(|lamp| lamp.share > 0.0).collect(),
            fill: own.fill as f32,
            absorption: libm::exp(apart / own.absorption_decay_nm) as f32,
            view: Vec3::new(0.0, -sin as f32, cos as f32),
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
        for (column, hit) in hits.iter().enumerate() {
            let normal = Vec3::new(-hit.surface.slope_x, -hit.surface.slope_y, 1.0).normalize();
            (height[column], slope[column], up[column]) = (hit.surface.z, hit.surface.slope_y, normal.z);
            surface[column] =
                if hit.is_bare() { conveyor } else { self.surface(&hit.matter.medium.gloss, normal, slope[column]) };
        }
        for (roots, diffuse) in roots.iter_mut().zip(diffuse) {
            roots.clear();
            roots.extend(hits.iter().enumerate().map(|(column, hit)| {
                if hit.is_bare() { 0.0 } else { diffuse.get(column).map_or(0.0, |share| share.sqrt()) }
            }));
        }
    }

    /// Radiance factor of a surface itself, without shadows [1].
    fn surface(&self, gloss: &Gloss, normal: Vec3, slope: f32) -> f32 {
        if gloss.share == 0.0 && gloss.matte == 0.0 {
            return 0.0;
        }
        let of = |lamp: &Lamp| {
            let lobe = fresnel::gloss(gloss, normal, lamp.towards, self.view);
            lamp.share * lobe * lamp.unshaded(slope, normal.z)
        };
        let even = 0.5 * (1.0 + normal.z) * (gloss.matte + gloss.share * gloss.reflectance);
        self.lamps.iter().map(of).sum::<f32>() + self.fill * even
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
        let hidden: f32 = horizons.iter().map(|[_, sin]| 0.5 * (sin - SIN_LOW).max(0.0) / (1.0 - SIN_LOW)).sum();
        self.lamps.iter().map(of).sum::<f32>() + self.fill * 0.5 * (1.0 + up) * (1.0 - hidden)
    }
}

impl Lamp {
    /// Tangent of the angle at which it stands, in the mean [1].
    fn lean(&self) -> f32 {
        (self.from[1] - self.to[1]) / (self.to[0] - self.from[0])
    }

    /// Irradiance without shadows.
    fn unshaded(&self, slope: f32, up: f32) -> f32 {
        ((1.0 - self.side * self.lean() * slope) * up).max(0.0)
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
