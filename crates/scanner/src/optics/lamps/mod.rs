//! Lamps: diffuse light beside the laser, and the map `grey` that the camera takes of it.
//!
//! Each profile's point is seen under one or two long lamps parallel to the laser line and under light from all sides.
//! A level white Lambertian surface has radiance 1. With R the diffuse reflectance of the matter in groups g of widths
//! of spread ([`transport::kernel::line_spread`]), E the irradiance and K_g the group's Gaussian:
//!
//! ```text
//! radiance = surface + sum over g of sqrt(R_g) (K_g * (sqrt(R_g) E))
//! ```
//!
//! - `irradiance`: E by slope, width of the lamps and the horizon of heights along the motion; gloss and matte of the
//!   surface itself by its microfacets.
//! - `spread`: light that leaves beside where it entered, narrower across the motion, as the kernel's light of the
//!   laser.
//! - `camera`: the lens's blur, electrons, noise and digital numbers.
//!
//! R is the kernel's for light along the laser plane's normal, all directions out taken together. By reciprocity that
//! is what a lens there sees under light from all sides; cone light makes other views and lamps differ. Neglected:
//! that, shadows along the line, light from wall to wall of openings, and light that goes on further than a band of
//! lines reaches (some 1 mm along the motion for shadows of lamps and 1 mm for spread).

mod camera;
mod irradiance;
mod spread;

pub(crate) use self::camera::GreyCamera;
pub(crate) use self::irradiance::Lamps;
