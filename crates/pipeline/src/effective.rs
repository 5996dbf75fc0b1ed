//! Effective physics: numbers that follow from a scene's draws and that a reader of the images wants to know.

use base::{Gloss, Medium};
use procedural::blister::Blister;
use procedural::wood::Media;

use optical_bench::settings::ScatterDark;
use recipe::{LogBoard, Plan, Recipe, Scene, Subject};
use scanner::extract;
use scanner::frame::Rig;
use scanner::optics::Sensor;
use scanner::optics::camera::Sight;
use transport::fresnel::boundary_factor;
use transport::kernel::diffusion;

/// One effective number of a `T`: its name, which ends in its unit, its meaning, and its value.
type EffectiveNumber<T> = (&'static str, &'static str, fn(&T) -> f64);

/// A sensor over a scene, whose upper surface is seen in `sight`.
struct SetUpScene<'a> {
    scene: &'a Scene,
    sensor: &'a Sensor,
    sight: Sight,
}

/// Numbers of the bench, which every subject has.
fn bench_numbers<'a>() -> [EffectiveNumber<SetUpScene<'a>>; 10] {
    [
        ("magnification", "Magnification of the lens at the origin.", |set_up| {
            set_up.sensor.camera().rig.magnification()
        }),
        ("scheimpflug_deg", "Tilt of the sensor; solved, it focuses the laser plane.", |set_up| {
            set_up.sensor.camera().rig.sensor_tilt.to_degrees()
        }),
        ("height_per_row_mm", "Height that one sensor row stands for, at the sensor's middle.", |set_up| {
            let rig = &set_up.sensor.camera().rig;
            rig.height(rig.centre_row - 0.5) - rig.height(rig.centre_row + 0.5)
        }),
        (
            "motion_per_row_mm",
            "Distance along the motion that one sensor row stands for, on a flat upper surface.",
            |set_up| 1.0 / f64::from(set_up.sight.rows_per_mm),
        ),
        (
            "line_sigma_px",
            "Standard deviation of the line on the upper surface, laser, lens and pixel together.",
            |set_up| f64::from(set_up.sight.variance.sqrt()),
        ),
        (
            "electrons_white_e",
            "Electrons in one column from a white Lambertian surface at the upper surface's height.",
            |set_up| f64::from(set_up.sight.electrons * set_up.sight.view.z),
        ),
        ("gain_dn_per_e", "Digital numbers per electron.", |set_up| {
            let exposure = &set_up.scene.bench.exposure;
            set_up.scene.readout.scale() * (255.0 - exposure.dark_level_dn) / exposure.full_well_e
        }),
        ("speckle_surface", "Contrast of speckle in one pixel, light from the surface.", |set_up| {
            f64::from(set_up.sensor.speckle_contrast()[0])
        }),
        (
            "speckle_volume",
            "Contrast of speckle in one pixel on the line, light from below the surface; beside the line, and in \
                  other matter than the typical, as paths of light there have it.",
            |set_up| f64::from(set_up.sensor.speckle_contrast()[1]),
        ),
        ("scatter_dark_dn", "What the dark level adds to Scatter.", |set_up| {
            let extraction = &set_up.scene.extraction;
            let scatter_dark = match extraction.scatter_dark {
                ScatterDark::Kept => f64::from(set_up.sensor.calibration().dark_level),
                ScatterDark::Subtracted => 0.0,
            };
            extract::scatter_pixels(extraction) as f64 * scatter_dark
        }),
    ]
}

/// Numbers of wood, by its clear earlywood.
const WOOD: [EffectiveNumber<Medium>; 3] = [
    ("clear_diffusion_along_mm", "Diffusion coefficient of earlywood along the fibre.", diffusion_along),
    ("clear_diffusion_across_mm", "Diffusion coefficient of earlywood across the fibre.", diffusion_across),
    ("clear_boundary_factor", "Boundary factor A of clear wood against air.", medium_boundary_factor),
];

/// Numbers of a board of a log that has several.
const LOG_BOARD: [EffectiveNumber<LogBoard>; 2] = [
    (
        "log_number",
        "Number of the log: boards with the same number were sawn from one log, and are in one split.",
        |board| board.log as f64,
    ),
    ("log_board", "Number of the board in its log, from 0, in the order of the sawing pattern.", |board| {
        board.board as f64
    }),
];

/// Numbers of a pack.
const BLISTER: [EffectiveNumber<Blister>; 5] = [
    ("film_optical_thickness", "Reduced scattering lengths across the flange's film.", film_optical_thickness),
    (
        "film_transmission",
        "Share of diffuse light that passes the flange's film, by 1 / (1 + 3/4 optical thickness).",
        film_transmission,
    ),
    ("tablet_reflectance", "Diffuse reflectance of a bare tablet without end, coat included.", tablet_reflectance),
    ("tablet_diffusion_mm", "Diffusion coefficient of a tablet.", |blister| {
        1.0 / (3.0 * (blister.tablet.sigma_per_mm + blister.tablet.mu_a_per_mm))
    }),
    ("tablet_boundary_factor", "Boundary factor A of a tablet against air.", |blister| {
        boundary_factor(blister.tablet.n)
    }),
];

/// Numbers of a body of one medium.
const MATERIAL: [EffectiveNumber<Medium>; 3] = [
    ("material_diffusion_along_mm", "Diffusion coefficient of the material along the fibre.", diffusion_along),
    ("material_diffusion_across_mm", "Diffusion coefficient of the material across the fibre.", diffusion_across),
    ("material_boundary_factor", "Boundary factor A of the material against air.", medium_boundary_factor),
];

/// Name (ending in its unit) and meaning of each effective number of a recipe, in the order of [`effective`].
pub fn declared(recipe: &Recipe) -> Vec<(&'static str, &'static str)> {
    fn of<T>(table: &[EffectiveNumber<T>]) -> Vec<(&'static str, &'static str)> {
        table.iter().map(|(name, doc, _)| (*name, *doc)).collect()
    }
    let own = match recipe.subject() {
        Subject::Wood => [of(&WOOD), if recipe.boards_per_log() > 1 { of(&LOG_BOARD) } else { Vec::new() }].concat(),
        Subject::Blister => of(&BLISTER),
        Subject::Sawtooth | Subject::Mesh => of(&MATERIAL),
    };
    [of(&bench_numbers()), own].concat()
}

/// The effective numbers of a scene whose upper surface lies about `top` [mm].
pub fn effective(scene: &Scene, sensor: &Sensor, top: f64) -> Vec<(&'static str, f64)> {
    fn of<T>(table: &[EffectiveNumber<T>], subject: &T) -> Vec<(&'static str, f64)> {
        table.iter().map(|(name, _, of)| (*name, of(subject))).collect()
    }
    let set_up = SetUpScene { scene, sensor, sight: sensor.camera().sight(0.0, top as f32, 0.0) };
    let own = match &scene.plan {
        Plan::Wood(wood) => {
            let log_board = scene.log_board.map_or_else(Vec::new, |board| of(&LOG_BOARD, &board));
            [of(&WOOD, &earlywood(&wood.media)), log_board].concat()
        }
        Plan::Blister(blister) => of(&BLISTER, blister),
        Plan::Sawtooth(_, material) | Plan::Mesh(_, material) => of(&MATERIAL, &material.medium()),
    };
    [of(&bench_numbers(), &set_up), own].concat()
}

/// The numbers of a rig as files give them, in the order of `output_schema::row::CALIBRATION`; `x_first_mm` is NaN
/// where Range lies on sensor columns.
pub(crate) fn calibration_numbers(rig: &Rig, x_first_mm: f64) -> Vec<(&'static str, f64)> {
    vec![
        ("distance_mm", rig.distance),
        ("tilt_deg", rig.tilt.to_degrees()),
        ("image_distance_mm", rig.image_distance),
        ("sensor_tilt_deg", rig.sensor_tilt.to_degrees()),
        ("pixel_um", rig.pixel * 1e3),
        ("centre_col_px", rig.centre_col),
        ("centre_row_px", rig.centre_row),
        ("k1", rig.distortion.radial[0]),
        ("k2", rig.distortion.radial[1]),
        ("k3", rig.distortion.radial[2]),
        ("p1", rig.distortion.tangential[0]),
        ("p2", rig.distortion.tangential[1]),
        ("x_first_mm", x_first_mm),
    ]
}

/// The matter that stands for a scene's object as a whole: what most light from below has gone through.
///
/// Of a pack that is the tablet: films are a few mean free paths thick at most, so the long paths, which wash speckle
/// out, lie in the tablet. Over an empty pocket speckle is washed out too much by that.
pub(crate) fn typical(plan: &Plan) -> Medium {
    match plan {
        Plan::Wood(wood) => earlywood(&wood.media),
        Plan::Sawtooth(_, material) | Plan::Mesh(_, material) => material.medium(),
        Plan::Blister(blister) => {
            let tablet = &blister.tablet;
            let r0 = boundary_reflectance(tablet.n);
            let gloss = Gloss {
                share: tablet.gloss as f32,
                reflectance: r0 as f32,
                roughness: [tablet.roughness as f32; 2],
                matte: 0.0,
            };
            Medium::isotropic(tablet.mu_a_per_mm as f32, tablet.sigma_per_mm as f32, tablet.n as f32, gloss)
        }
    }
}

/// Clear earlywood.
pub fn earlywood(media: &Media) -> Medium {
    Medium {
        mu_a: media.earlywood_mu_a_per_mm as f32,
        sigma_i: media.earlywood_sigma_i_per_mm as f32,
        k: media.earlywood_k_per_mm as f32,
        n_eff: media.clear_n_eff as f32,
        fibre: glam::Vec3::Y,
        dispersion_deg: media.fibre_dispersion_deg as f32,
        gloss: Gloss::wood(media.gloss as f32),
        coat: 1.0,
    }
}

fn diffusion_along(medium: &Medium) -> f64 {
    diffusion(f64::from(medium.sigma_i), f64::from(medium.k)).0
}

fn diffusion_across(medium: &Medium) -> f64 {
    diffusion(f64::from(medium.sigma_i), f64::from(medium.k)).1
}

fn medium_boundary_factor(medium: &Medium) -> f64 {
    boundary_factor(f64::from(medium.n_eff))
}

fn film_optical_thickness(blister: &Blister) -> f64 {
    blister.web.sigma_per_mm * blister.web.thickness_mm
}

/// Diffusion through a slab without boundary reflection or absorption (Ishimaru 1978).
fn film_transmission(blister: &Blister) -> f64 {
    1.0 / (1.0 + 0.75 * film_optical_thickness(blister))
}

/// Diffusion with one isotropic source (Flock, Patterson, Wilson and Wyman 1989),
/// R = a' / (1 + (1 + 2 A / 3) sqrt(3 (1 - a')) + 2 A (1 - a')) for the reduced albedo a' and the boundary factor A.
fn tablet_reflectance(blister: &Blister) -> f64 {
    let tablet = &blister.tablet;
    let albedo = tablet.sigma_per_mm / (tablet.sigma_per_mm + tablet.mu_a_per_mm);
    let (a, lost) = (boundary_factor(tablet.n), 1.0 - albedo);
    let within = albedo / (1.0 + (1.0 + 2.0 * a / 3.0) * (3.0 * lost).sqrt() + 2.0 * a * lost);
    let entered = (1.0 - boundary_reflectance(tablet.n)) * tablet.coat * tablet.coat;
    entered * within
}

/// Fresnel reflectance at normal incidence against air.
fn boundary_reflectance(n: f64) -> f64 {
    ((n - 1.0) / (n + 1.0)) * ((n - 1.0) / (n + 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_a_pack_by_hand() {
        let Plan::Blister(mut blister) = Plan::from_values(Subject::Blister, &mut |p| p.default) else {
            panic!("no pack")
        };
        (blister.web.sigma_per_mm, blister.web.thickness_mm) = (40.0, 0.12);
        (blister.tablet.mu_a_per_mm, blister.tablet.sigma_per_mm, blister.tablet.n) = (0.005, 40.0, 1.5);
        blister.tablet.coat = 1.0;
        let [thickness, transmission, reflectance, d, _] = BLISTER.map(|(_, _, of)| of(&blister));
        assert!((thickness - 4.8).abs() < 1e-12 && (transmission - 0.2174).abs() < 1e-4, "{transmission}");
        // The reference says 0.8994 +- 0.0004 of a white tablet; its diffusion is a third of the mean free path.
        assert!((reflectance - 0.8994).abs() < 0.0015, "{reflectance}");
        assert!((d - 1.0 / 120.015).abs() < 1e-9, "{d}");
        blister.tablet.coat = 0.5;
        assert!((tablet_reflectance(&blister) - 0.25 * reflectance).abs() < 1e-12);
    }
}
