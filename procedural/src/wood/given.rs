//! Given wood: a board whose matter something else knows, a picture for instance, in the place of a grown log.
//!
//! Model: whoever gives the wood answers for each place of the face and each depth below it; shape, saw, openings and
//! coats stay the board's own. Depth is counted from the sawn face without ripple and roughness, since a picture shows
//! what lies on top; what lies above counts as depth 0. Beyond the board's sides the nearest place answers. Limits:
//! cracks run along one direction of the whole board and are radial about a pith that is not seen
//! (`log.pith_depth_mm`); they do not begin at knots.

use std::fmt::Debug;

use base::{Class, Instance};
use glam::{Vec2, Vec3};

/// Wood of a board as something else knows it.
pub trait GivenWood: Debug + Send + Sync {
    /// The wood at a place (x, y) from the board's near left corner and a depth below its face [mm].
    fn at(&self, place: Vec2, depth_mm: f32) -> GivenMatter;

    /// What it labels, by number from 1; places are from the board's near left corner [mm].
    fn instances(&self) -> Vec<Instance>;

    /// Direction of most fibres in the face, from the scan towards the laser line [deg].
    fn azimuth_deg(&self) -> f32;

    /// Whether the pith lies above the face.
    fn pith_is_above(&self) -> bool;
}

/// Given wood at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GivenMatter {
    /// Absorption [mm^-1].
    pub mu_a: f32,
    /// Isotropic reduced scattering [mm^-1].
    pub sigma_i: f32,
    /// Cylinder scattering [mm^-1].
    pub k: f32,
    /// Effective refractive index [1].
    pub n_eff: f32,
    /// Unit vector along the fibre, z out of the face; its sign has no meaning [1].
    pub fibre: Vec3,
    /// How much knots disturb the fibres' order, 0 far from them and 1 in them [1].
    pub disturbed: f32,
    /// What it is.
    pub class: Class,
    /// Which one it is: 0 for none.
    pub instance: u16,
}
