//! Surface point: the medium, slope and view of a point, as the kernel of subsurface light asks for them.

use base::Medium;
use glam::Vec3;

use transport::fresnel;
use transport::kernel::SurfacePoint;

/// A point of the surface as the kernel asks for it; `light` travels to it, `view` looks back at the lens.
pub(crate) fn surface_point(medium: &Medium, normal: Vec3, light: Vec3, view: Vec3) -> SurfacePoint {
    // What facets of denser matter throw back does not enter; facets of the matter itself are its own surface.
    let own = fresnel::normal_reflectance(medium.n_eff);
    let facets = medium.gloss.reflectance > 1.01 * own;
    let thrown = if facets { medium.gloss.share * medium.gloss.reflectance } else { 0.0 } + medium.gloss.matte;
    let matter = SurfacePoint {
        mu_a: medium.mu_a,
        sigma_i: medium.sigma_i,
        k: medium.k,
        n: medium.n_eff,
        dispersion_deg: medium.dispersion_deg,
        enter: (1.0 - thrown) * (1.0 - own),
        ..SurfacePoint::BLACK
    };
    matter.facing(medium.fibre, normal, light, view)
}
