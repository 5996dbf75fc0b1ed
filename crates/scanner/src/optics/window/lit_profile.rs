//! A profile under the laser: what every step that draws its windows asks for.

use super::band::Band;
use super::scan_geometry::ScanGeometry;
use crate::optics::camera::Camera;
use crate::optics::light::{ROWS, ScanLine};

/// One profile of a scan, whose windows are drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LitProfile<'a> {
    /// Camera and laser.
    pub camera: &'a Camera,
    /// Positions of the profiles.
    pub geometry: &'a ScanGeometry,
    /// Lines around the profile.
    pub band: &'a Band,
    /// Number of the profile.
    pub profile: usize,
}

impl<'a> LitProfile<'a> {
    /// The line under the laser.
    pub fn line(&self) -> &'a ScanLine {
        self.band.line(self.profile)
    }

    /// The lines that a window of the profile looks at.
    pub fn neighbours(&self) -> [&'a ScanLine; ROWS] {
        let offsets = self.band.neighbours(self.profile, self.geometry);
        std::array::from_fn(|k| self.band.neighbour(self.profile, offsets[k]))
    }
}
