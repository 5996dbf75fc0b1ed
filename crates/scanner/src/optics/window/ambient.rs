//! Ambient light: light of lamps and windows that passes the filter, uniform on everything that a pixel looks at.
//!
//! [`crate::optics::camera`] has the equation (vignetting.rs). A point returns the albedo that it has for uniform light
//! from above: the sum of all widths of its spread, plus what its surface throws back. The pixel of a sensor row sees
//! the point that the row looks at, as for light from below the surface. Ambient light has photon noise and, since its
//! band is broad, no speckle. Neglected: shadows of the object on itself and on the conveyor; a hidden point shows its
//! own brightness and not that of what hides it; points beyond the lines that a band holds show the last one's.

use super::electrons::{Scratch, Window};
use super::lit_profile::LitProfile;
use crate::optics::light::{ROWS, window_start};
use crate::optics::speckle::TILE;

impl LitProfile<'_> {
    /// Adds ambient light to the windows of a tile.
    pub fn add_ambient(&self, tile: usize, scratch: &mut Scratch) {
        let Self { camera, geometry, band, profile } = *self;
        if !camera.has_ambient() {
            scratch.windows.iter_mut().for_each(|window| window.ambient.clear());
            return;
        }
        let start = tile * TILE;
        let centre = &self.line().centre[start..start + TILE];
        let Scratch { windows, used, .. } = scratch;
        for window in &mut windows[..*used] {
            let Window { ambient, first_row, .. } = window;
            ambient.resize(ROWS, [0.0; TILE]);
            let at_the_line = first_row.iter().zip(centre).all(|(&first, &row)| first == window_start(row));
            for (k, line) in ambient.iter_mut().enumerate() {
                if at_the_line {
                    line.copy_from_slice(&band.neighbour(profile, geometry.neighbours[k]).ambient[start..start + TILE]);
                } else {
                    for (c, pixel) in line.iter_mut().enumerate() {
                        let offset = geometry.neighbour_at(centre[c] - (first_row[c] + k as i32) as f32);
                        *pixel = band.neighbour(profile, offset).ambient[start + c];
                    }
                }
            }
        }
    }

    /// Ambient light in pixel `[row, column]` of the whole sensor [e-].
    pub fn ambient_in(&self, [row, column]: [usize; 2]) -> f32 {
        let Self { camera, geometry, band, profile } = *self;
        if !camera.has_ambient() {
            return 0.0;
        }
        let offset = geometry.neighbour_at(self.line().centre[column] - row as f32);
        band.neighbour(profile, offset).ambient[column]
    }
}
