//! Numbers that are legal alone and absurd beside the others of their scene: the usual mistakes in copying a data
//! sheet, each with the number that was likely to be meant.
//!
//! A row of [`MISTAKES`] knows one key. It holds where the number is absurd and the other reading of it is an ordinary
//! one; absurd numbers without such a reading are left to what the rig's check finds. Nothing is rendered, and no
//! object is made.
//!
//! Not found: a reading that changes a number by so little that both are ordinary (the diameter of a waist for its
//! radius, a camera's angle with the conveyor for that with the laser), and numbers beyond the bounds of their key,
//! which the recipe refuses.

use std::collections::BTreeMap;

use super::check::{RigFault, RigWarning, samples_of_classes};
use super::{DIM_PEAK, white_peak};
use optical_bench::settings::Filter;
use recipe::{Recipe, Scene};
use scanner::optics::camera::{Camera, Sight};

/// Peaks of a white surface that exposures are chosen for, within a factor of a few [share of saturation].
const ORDINARY_PEAK: std::ops::RangeInclusive<f64> = 0.1..=5.0;
/// Distances of laser and camera over each other that benches have [1].
const ORDINARY_DISTANCES: std::ops::RangeInclusive<f64> = 0.4..=2.5;

/// A usual mistake.
#[derive(Debug)]
pub struct Mistake {
    /// The key whose number it is.
    pub key: &'static str,
    /// What the number looks like.
    pub looks_like: &'static str,
    /// A built-in recipe and the changes that make the mistake in it.
    pub example: [&'static str; 2],
    /// The number that was likely to be meant; `None` where the number is not absurd.
    likely: fn(&Drawn<'_>, f64) -> Option<f64>,
}

impl Mistake {
    /// Millimetres at a key of micrometres.
    const fn of_micrometres(
        key: &'static str,
        example: [&'static str; 2],
        likely: fn(&Drawn<'_>, f64) -> Option<f64>,
    ) -> Self {
        Self { key, looks_like: "millimetres in place of micrometres", example, likely }
    }
}

/// Every mistake that is known.
pub const MISTAKES: &[Mistake] = &[
    Mistake {
        key: "motion.line_rate_hz",
        looks_like: "kilohertz in place of hertz",
        example: ["wood-small", "motion.line_rate_hz=5"],
        likely: |drawn, rate| {
            let fastest = 1e6 / drawn.of("exposure.time_us");
            (rate > 0.0 && rate < 20.0 && 1e3 * rate < fastest).then_some(1e3 * rate)
        },
    },
    Mistake::of_micrometres("motion.wow_um", ["wood-small", "motion.wow_um=0.05"], |_, um| below(um, 0.5)),
    Mistake::of_micrometres("motion.encoder_jitter_um", ["wood-small", "motion.encoder_jitter_um=0.002"], |_, um| {
        below(um, 0.02)
    }),
    Mistake {
        key: "laser.power_mw",
        looks_like: "watts in place of milliwatts",
        example: ["wood-small", "laser.power_mw=0.05"],
        likely: |drawn, power| (power < 1.0).then(|| drawn.brighter(power, 1e3)).flatten(),
    },
    Mistake {
        key: "laser.waist_height_mm",
        looks_like: "the waist's distance from the laser in place of its height over the conveyor",
        example: ["wood-small", "laser.waist_height_mm=400"],
        likely: |drawn, height| {
            let likely = drawn.of("laser.fan_height_mm") - height;
            // In Rayleigh lengths from the surface.
            let far = |waist: f64| (waist - drawn.top).abs() / drawn.rayleigh_mm();
            (far(height) > 3.0 && far(likely) < 1.5).then_some(likely)
        },
    },
    Mistake {
        key: "laser.fan_height_mm",
        looks_like: "centimetres in place of millimetres",
        example: ["wood-small", "laser.fan_height_mm=40"],
        likely: |drawn, height| centimetres(height, drawn.of("camera.distance_mm")),
    },
    Mistake {
        key: "laser.fan_angle_deg",
        looks_like: "radians in place of degrees",
        example: ["wood-small", "laser.fan_angle_deg=1.05"],
        likely: |drawn, angle| {
            let degrees = angle.to_degrees();
            (degrees <= 120.0 && drawn.lit_share(angle) < 0.9 && drawn.lit_share(degrees) >= 1.0).then_some(degrees)
        },
    },
    Mistake {
        key: "laser.fan_angle_deg",
        looks_like: "half of the fan's angle in place of all of it",
        example: ["wood", "laser.fan_angle_deg=10"],
        likely: |drawn, angle| {
            let all = 2.0 * angle;
            // A laser that stands too low has another fault.
            let stands =
                ORDINARY_DISTANCES.contains(&(drawn.of("laser.fan_height_mm") / drawn.of("camera.distance_mm")));
            (stands && angle > 2.1 && drawn.lit_share(angle) < 0.9 && drawn.lit_share(all) >= 1.0).then_some(all)
        },
    },
    Mistake {
        key: "laser.fan_angle_deg",
        looks_like: "the line's length in millimetres in place of the fan's angle",
        example: ["wood-small", "laser.fan_angle_deg=100"],
        likely: |drawn, length| {
            let angle = 2.0 * libm::atan(0.5 * length / drawn.depth_mm()).to_degrees();
            (length > 90.0 && drawn.lit_share(angle) >= 1.0).then_some(angle)
        },
    },
    Mistake::of_micrometres("laser.smile_um", ["wood-small", "laser.smile_um=0.03"], |_, um| below(um, 0.5)),
    Mistake::of_micrometres("laser.smile_cubic_um", ["wood-small", "laser.smile_cubic_um=-0.03"], |_, um| {
        below(um, 0.5)
    }),
    Mistake {
        key: "camera.distance_mm",
        looks_like: "centimetres in place of millimetres",
        example: ["wood-small", "camera.distance_mm=60"],
        likely: |drawn, distance| centimetres(distance, drawn.of("laser.fan_height_mm")),
    },
    Mistake {
        key: "camera.f_number",
        looks_like: "the aperture's diameter in place of the f-number",
        example: ["wood-small", "camera.f_number=20 camera.focal_length_mm=50"],
        likely: |drawn, diameter| {
            let number = drawn.of("camera.focal_length_mm") / diameter;
            (diameter > 16.0 && number >= 1.0).then_some(number)
        },
    },
    Mistake::of_micrometres("camera.blur_um", ["wood-small", "camera.blur_um=0.003"], |_, um| below(um, 0.02)),
    Mistake {
        key: "camera.filter_centre_nm",
        looks_like: "a filter for another laser",
        example: ["wood-small", "camera.filter=band_pass camera.filter_centre_nm=450"],
        likely: |drawn, centre| {
            let laser = drawn.of("laser.wavelength_nm");
            let passes = (centre - laser).abs() < drawn.of("camera.filter_width_nm");
            (drawn.scene.bench.optics.filter == Filter::BandPass && !passes).then_some(laser)
        },
    },
    Mistake {
        key: "exposure.time_us",
        looks_like: "milliseconds in place of microseconds",
        example: ["wood-small", "exposure.time_us=0.1"],
        likely: |drawn, time| (time < 2.0).then(|| drawn.brighter(time, 1e3)).flatten(),
    },
    Mistake {
        key: "exposure.time_us",
        looks_like: "nanoseconds in place of microseconds",
        example: ["wood-small", "exposure.time_us=40000"],
        likely: |drawn, time| (time > 5000.0).then(|| drawn.brighter(time, 1e-3)).flatten(),
    },
    Mistake {
        key: "exposure.dark_level_dn",
        looks_like: "a number of the converter in place of one on the scale of 8 bits",
        example: ["wood-small", "exposure.bits=12 exposure.dark_level_dn=100 extraction.threshold_dn=110"],
        likely: |drawn, level| (level > 40.0).then(|| drawn.on_8_bits(level)).flatten(),
    },
    Mistake {
        key: "exposure.dark_noise_dn",
        looks_like: "electrons in place of digital numbers",
        example: ["wood-small", "exposure.dark_noise_dn=13"],
        likely: |drawn, noise| {
            let per_electron = (255.0 - drawn.of("exposure.dark_level_dn")) / drawn.of("exposure.full_well_e");
            // No converter has less than the key's least.
            (noise > 4.0 && noise * per_electron < 1.0).then_some((noise * per_electron).max(0.3))
        },
    },
    Mistake {
        key: "extraction.threshold_dn",
        looks_like: "a number of the converter in place of one on the scale of 8 bits",
        example: ["wood-small", "exposure.bits=12 extraction.threshold_dn=250"],
        likely: |drawn, threshold| {
            let likely = drawn.on_8_bits(threshold)?;
            (threshold > 200.0 && likely > drawn.of("exposure.dark_level_dn")).then_some(likely)
        },
    },
    Mistake {
        key: "board.length_mm",
        looks_like: "metres in place of millimetres",
        example: ["wood-small", "board.length_mm=4.2"],
        likely: |drawn, length| {
            let across = drawn.of("board.width_mm").max(drawn.of("board.thickness_mm"));
            (length <= 10.0 && length < 0.25 * across).then_some(1e3 * length)
        },
    },
    Mistake {
        key: "board.width_mm",
        looks_like: "centimetres in place of millimetres",
        example: ["wood", "board.width_mm=5"],
        likely: |drawn, width| (width < 0.25 * drawn.of("board.thickness_mm")).then_some(10.0 * width),
    },
    Mistake::of_micrometres("board.saw_ripple_um", ["wood-small", "board.saw_ripple_um=0.05"], |_, um| below(um, 0.5)),
    Mistake::of_micrometres("board.roughness_um", ["wood-small", "board.roughness_um=0.012"], |_, um| below(um, 0.2)),
    Mistake::of_micrometres("pack.knurl_um", ["blister-small", "pack.knurl_um=0.025"], |_, um| below(um, 0.2)),
    Mistake::of_micrometres("pocket.bumps_um", ["blister-small", "pocket.bumps_um=0.025"], |_, um| below(um, 0.2)),
    Mistake {
        key: "mesh.unit_mm",
        looks_like: "the unit of another file: no part is so small",
        example: ["mesh-small", "mesh.unit_mm=0.001"],
        likely: |drawn, unit| {
            let size = drawn.mesh_size()?;
            (size * unit < 0.5 && (1.0..=2000.0).contains(&(1e3 * size * unit))).then_some(1e3 * unit)
        },
    },
];

/// A number of micrometres that is far below what can be seen or made, in the unit that it is likely to be in [um].
fn below(um: f64, least: f64) -> Option<f64> {
    (um != 0.0 && um.abs() < least).then_some(1e3 * um)
}

/// A distance that is far below the other one and, in centimetres, about as long [mm].
fn centimetres(mm: f64, other_mm: f64) -> Option<f64> {
    (mm < 0.25 * other_mm && ORDINARY_DISTANCES.contains(&(10.0 * mm / other_mm))).then_some(10.0 * mm)
}

/// The numbers of a scene, and what they make together.
struct Drawn<'a> {
    scene: &'a Scene,
    values: BTreeMap<String, f64>,
    /// Upper end of a board; 0 for what is not known without making it [mm].
    top: f64,
    sight: Sight,
}

impl<'a> Drawn<'a> {
    fn of_scene(scene: &'a Scene) -> Self {
        let mut values: BTreeMap<String, f64> = scene.draws().into_iter().collect();
        let threshold = scene.extraction.threshold_dn / scene.readout.scale();
        values.insert("extraction.threshold_dn".into(), threshold);
        let top = values.get("board.thickness_mm").copied().unwrap_or(0.0);
        let camera = Camera::new(&scene.bench, &scene.size, &scene.line, scene.stream, scene.rig_stream);
        Self { scene, values, top, sight: camera.sight(0.0, top as f32, 0.0) }
    }

    /// The number at a key; NaN where the scene has none, which no comparison holds for.
    fn of(&self, key: &str) -> f64 {
        self.values.get(key).copied().unwrap_or(f64::NAN)
    }

    /// The number times `factor` where white is far from the light of an ordinary exposure and then is near it.
    fn brighter(&self, number: f64, factor: f64) -> Option<f64> {
        let peak = white_peak(&self.sight, self.of("exposure.full_well_e"));
        let absurd = peak < DIM_PEAK * ORDINARY_PEAK.start() || peak > 10.0 * ORDINARY_PEAK.end();
        (absurd && ORDINARY_PEAK.contains(&(factor * peak))).then_some(factor * number)
    }

    /// A number of the converter on the scale of 8 bits; `None` where these are the same [DN].
    fn on_8_bits(&self, dn: f64) -> Option<f64> {
        let scale = self.scene.readout.scale();
        (scale > 1.0).then(|| dn / scale)
    }

    /// From the fan's origin to the object [mm].
    fn depth_mm(&self) -> f64 {
        self.of("laser.fan_height_mm") - self.top
    }

    fn rayleigh_mm(&self) -> f64 {
        let waist = self.of("laser.waist_mm");
        std::f64::consts::PI * waist * waist / (self.of("laser.m_squared") * self.of("laser.wavelength_nm") * 1e-6)
    }

    /// Length of a fan's line over that of what is to be lit, the object or as much of it as the field shows [1].
    fn lit_share(&self, angle_deg: f64) -> f64 {
        let line = 2.0 * self.depth_mm() * libm::tan(0.5 * angle_deg.to_radians());
        let field = f64::from(self.sight.column_mm) * self.scene.size.columns as f64;
        let widths = ["board.width_mm", "pack.width_mm", "sawtooth.width_mm"].map(|key| self.of(key));
        let part = self.mesh_size().map(|size| size * self.of("mesh.unit_mm"));
        line / widths.into_iter().chain(part).fold(field, f64::min)
    }

    /// Greatest extent of a part in units of its file.
    fn mesh_size(&self) -> Option<f64> {
        let corners = &self.scene.mesh.as_ref()?.positions;
        let (low, high) = corners
            .iter()
            .fold((*corners.first()?, *corners.first()?), |(low, high), corner| (low.min(*corner), high.max(*corner)));
        Some((high - low).max_element().into())
    }
}

/// The mistakes that one scene seems to have, in the order of [`MISTAKES`]: the place there, and the numbers that it
/// has and that were likely to be meant.
fn found(scene: &Scene) -> Vec<(usize, [f64; 2])> {
    let drawn = Drawn::of_scene(scene);
    let one = |(place, mistake): (usize, &Mistake)| {
        let number = drawn.of(mistake.key);
        Some((place, [number, (mistake.likely)(&drawn, number)?]))
    };
    MISTAKES.iter().enumerate().filter_map(one).collect()
}

fn told((place, [number, likely]): (usize, [f64; 2])) -> RigWarning {
    let Mistake { key, looks_like, .. } = &MISTAKES[place];
    let [number, likely] = [number, likely].map(|value| {
        // Three digits are what a data sheet has.
        let digits = 10f64.powi(2 - libm::log10(value.abs()).floor() as i32);
        if value == 0.0 { 0.0 } else { (value * digits).round() / digits }
    });
    RigWarning {
        fault: RigFault::UnlikelyValue,
        what: format!("{key} is {number}, which looks like {looks_like}"),
        remedy: format!("did you mean {likely}?"),
    }
}

/// The mistakes that the first samples of each frequent class of a recipe all seem to have.
pub fn mistakes(recipe: &Recipe, seed: u64) -> Vec<RigWarning> {
    let mut all: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
    for (_, samples) in samples_of_classes(recipe, seed) {
        let mut found = samples.iter().map(|index| found(&recipe.draw(seed, *index)));
        let first = found.next().unwrap_or_default();
        let others: Vec<_> = found.collect();
        let in_all = |place: usize| others.iter().all(|other| other.iter().any(|(known, _)| *known == place));
        for (place, numbers) in first.into_iter().filter(|(place, _)| in_all(*place)) {
            all.entry(place).or_insert(numbers);
        }
    }
    all.into_iter().map(told).collect()
}

/// The same of one scene alone.
pub fn mistakes_of_scene(scene: &Scene) -> Vec<RigWarning> {
    found(scene).into_iter().map(told).collect()
}
