//! Effective physics: numbers that follow from a scene's draws and that a reader of the images wants to know.

use procedural::Medium;

use crate::extract;
use crate::optics::Sensor;
use crate::recipe::Scene;
use crate::transport::fresnel::boundary_factor;

/// Name (ending in its unit) and meaning of each effective number, in the order of [`effective`].
pub const EFFECTIVE: [(&str, &str); 13] = [
    ("magnification", "Magnification of the lens at the origin."),
    ("scheimpflug_deg", "Tilt of the sensor that focuses the laser plane."),
    ("height_per_row_mm", "Height that one sensor row stands for, at the sensor's middle."),
    ("motion_per_row_mm", "Distance along the motion that one sensor row stands for, on a flat upper surface."),
    ("line_sigma_px", "Standard deviation of the line on the upper surface, laser, lens and pixel together."),
    ("electrons_white_e", "Electrons in one column from a white Lambertian surface at the upper surface's height."),
    ("gain_dn_per_e", "Digital numbers per electron."),
    ("speckle_surface", "Contrast of speckle in one pixel, light from the surface."),
    ("speckle_volume", "Contrast of speckle in one pixel, light from below the surface."),
    ("scatter_dark_dn", "What the dark level adds to Scatter."),
    ("clear_diffusion_along_mm", "Diffusion coefficient of earlywood along the fibre."),
    ("clear_diffusion_across_mm", "Diffusion coefficient of earlywood across the fibre."),
    ("clear_boundary_factor", "Boundary factor A of clear wood against air."),
];

/// The effective numbers of a scene whose upper surface lies about `top` [mm]; `clear` is its earlywood.
pub fn effective(scene: &Scene, sensor: &Sensor, clear: &Medium, top: f64) -> Vec<(&'static str, f64)> {
    let camera = sensor.camera();
    let rig = &camera.rig;
    let sight = camera.sight(0.0, top as f32, 0.0);
    let [surface, volume] = sensor.speckle_contrast();
    let exposure = &scene.bench.exposure;
    let (along, across) = crate::transport::kernel::diffusion(f64::from(clear.sigma_i), f64::from(clear.k));
    let values = [
        rig.magnification(),
        rig.scheimpflug().to_degrees(),
        rig.height(rig.centre_row - 0.5) - rig.height(rig.centre_row + 0.5),
        1.0 / f64::from(sight.rows_per_mm),
        f64::from(sight.variance.sqrt()),
        f64::from(sight.electrons * sight.view.z),
        (255.0 - exposure.dark_level_dn) / exposure.full_well_e,
        f64::from(surface),
        f64::from(volume),
        extract::scatter_pixels(&scene.extraction) as f64 * exposure.dark_level_dn,
        along,
        across,
        boundary_factor(f64::from(clear.n_eff)),
    ];
    EFFECTIVE.iter().map(|(name, _)| *name).zip(values).collect()
}
