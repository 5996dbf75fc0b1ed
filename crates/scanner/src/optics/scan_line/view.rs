//! View of one line: body, camera and laser at one position of the scan.

use crate::optics::camera::{Camera, Sight};
use crate::optics::laser::SpotLight;
use crate::optics::unrest::Unrest;
use crate::specimen::{Hit, Specimen};
use base::Surface;
use glam::Vec3;
use transport::kernel::SpreadRow;

/// Body, camera and laser at one position of the scan.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LineView<'a> {
    /// The body.
    pub specimen: &'a Specimen,
    /// The camera.
    pub camera: &'a Camera,
    /// Scan position [mm].
    pub y: f32,
    /// The profile that stands there.
    pub profile: isize,
    /// What it has otherwise than an instrument at rest.
    pub unrest: Option<Unrest>,
    /// Light in one pixel under which secondary light is left out [e-].
    pub faint: f32,
}

/// A line under the laser, as far as what it sends elsewhere asks for it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LitLine<'a> {
    /// What looks at it.
    pub view: LineView<'a>,
    /// What each column sees.
    pub hits: &'a [Hit],
    /// What the films of the line do to light.
    pub spread: &'a SpreadRow,
}

impl LineView<'_> {
    /// What becomes of the light at `x` on a surface.
    #[inline]
    pub fn sight(&self, x: f32, surface: &Surface) -> Sight {
        let z = self.unrest.map_or(surface.z, |unrest| surface.z + unrest.lift_mm);
        let sight = self.camera.sight_on(x, z, [surface.slope_x, surface.slope_y]);
        self.share(sight, x, surface.z)
    }

    /// Rows by which a line about height `z` lies beside where an instrument at rest has it [px].
    pub fn moved_px(&self, z: f32) -> f32 {
        let moved = |unrest: Unrest| {
            let [rest, lifted] = [0.0, unrest.lift_mm].map(|lift| self.camera.sight(0.0, z + lift, 0.0));
            unrest.change(lifted).row - rest.row
        };
        self.unrest.map_or(0.0, moved)
    }

    /// Sensor column and row of a point, y from the laser plane [px].
    pub fn place(&self, at: Vec3) -> [f32; 2] {
        let [column, row] = self.camera.project(at.x, at.y, at.z);
        [column, row + self.moved_px(at.z)]
    }

    /// A sight as the instrument has it in this profile, with what a column gets of a point laser.
    #[inline]
    pub fn share(&self, sight: Sight, x: f32, z: f32) -> Sight {
        let sight = self.unrest.map_or(sight, |unrest| unrest.change(sight));
        match self.camera.laser.spot_light(self.profile, x, z, sight.column_mm) {
            Some(SpotLight { share, off }) => {
                // A column looks along a slant: beside the spot's middle it sees more of one half than of the other.
                let row = sight.row + off * self.camera.sightline_lean(x, z) * sight.rows_per_mm;
                Sight { electrons: sight.electrons * share / sight.column_mm, row, ..sight }
            }
            None => sight,
        }
    }
}
