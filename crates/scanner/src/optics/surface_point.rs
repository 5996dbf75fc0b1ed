//! Surface point: the medium, slope and view of a point, as the kernel of subsurface light asks for them.

use glam::Vec3;
use procedural::Medium;

use transport::fresnel;
use transport::kernel::SurfacePoint;

/// A point of the surface as the kernel asks for it.
pub(crate) fn surface_point(medium: &Medium, normal: Vec3, view: Vec3) -> SurfacePoint {
    // The fibre's sign has no meaning: take the end that dives.
    let fibre = if medium.fibre.dot(normal) > 0.0 { -medium.fibre } else { medium.fibre };
    let sin_dive = (-fibre.dot(normal)).clamp(0.0, 1.0);
    let flat = fibre + normal * sin_dive;
    let length = flat.length();
    let track = if length > 1e-4 { flat / length } else { Vec3::Y };
    // What facets of denser matter throw back does not enter; facets of the matter itself are its own surface.
    let own = fresnel::normal_reflectance(medium.n_eff);
    let facets = medium.gloss.reflectance > 1.01 * own;
    let thrown = if facets { medium.gloss.share * medium.gloss.reflectance } else { 0.0 } + medium.gloss.matte;
    SurfacePoint {
        mu_a: medium.mu_a,
        sigma_i: medium.sigma_i,
        k: medium.k,
        n: medium.n_eff,
        enter: (1.0 - thrown) * (1.0 - own),
        sin_dive,
        cos_azimuth: track.y,
        view_along: view.dot(track),
        view_motion: view.y,
        view_up: view.dot(normal),
    }
}
