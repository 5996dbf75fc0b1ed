//! Optics: laser, lens and sensor, from a specimen to digitised frames.
//!
//! | phase | takes | gives |
//! |---|---|---|
//! | `scan_line` | a specimen at one position of the scan | a [`ScanLine`]: what each column sends to the lens |
//! | `window` | the lines that a profile looks at (a [`Band`]) | electrons in windows of sensor rows about the line |
//! | `readout` | those electrons | digital numbers |
//!
//! `lamps` beside the laser have a way of their own, from what a line's columns see to the map `grey` of a band.
//!
//! Each line is worked out once and serves all profiles that look at it. Exposure runs over tiles of [`TILE`] columns,
//! so that the window of rows stays in the cache while the profiles of a band pass by. `laser`, [`camera`] and
//! [`speckle`] are what the phases ask; [`Sensor`] holds it all.
//!
//! Words: a *row* and a *column* are the sensor's. A *scan line* is what stands in the laser plane at one position of
//! the scan ([`ScanLine`], `line`). A *profile* is the number of such a position and of its exposure. A *band* is the
//! scan lines that some neighbouring profiles look at. A *tile* is [`TILE`] columns, a *window* [`ROWS`] rows of each
//! about its line.

mod bands;
pub mod camera;
mod correlated_noise;
pub mod encoder;
mod expose;
mod full_frame;
mod lamps;
mod laser;
mod light;
mod readout;
mod scan_line;
mod sensor;
pub mod speckle;
mod unrest;
mod window;

pub use self::bands::Bands;
pub use self::expose::TileOfProfile;
pub use self::light::{CENTRE, ROWS, ScanLine};
pub use self::sensor::{Sensor, SensorSetup};
pub use self::speckle::TILE;
pub use self::window::{Band, Scratch, Window};
