//! Optics: laser, lens and sensor, from a specimen to digitised frames.
//!
//! `Specimen -> Band` works the light out once for each position of the scan, `Band -> Frame` exposes: every profile
//! looks at the rows around its own. Exposure runs over tiles of [`TILE`] columns, so that the window of rows stays in
//! the cache while the profiles of a band pass by.

mod along_line;
mod ambient;
mod band;
mod bent_film;
pub mod blooming;
mod box_filter;
pub mod camera;
mod circle_of_confusion;
pub mod coherence;
mod compositing;
mod defocus;
mod digitise;
pub mod encoder;
pub mod expose;
pub mod film;
pub(crate) mod fixed_pattern;
mod front_face;
mod full_frame;
mod gaussian_stepper;
mod highlights;
mod interreflections;
pub mod laser;
mod line_image;
mod mixed_columns;
mod motion_blur;
pub(crate) mod per_line;
mod pocket_light;
pub mod postprocess;
pub mod reflections;
mod response;
pub mod row;
mod row_maker;
mod row_view;
mod rows_left_out;
mod scan_geometry;
mod second_line;
pub(crate) mod secondary_light;
mod seen_rows;
pub mod sensor;
pub(crate) mod signal_chain;
mod spans;
pub mod speckle;
pub mod streak;
mod surface_point;
mod vignetting;
mod window;

pub use self::band::Band;
pub use self::expose::TileOfProfile;
pub use self::sensor::{Sensor, SensorSetup};
pub use self::speckle::TILE;
pub use self::window::{CENTRE, ROWS, Scratch, Window};
