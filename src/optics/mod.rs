//! What the light does: from a specimen to digitised frames.
//!
//! `Specimen -> Band` works the light out once for each position of the scan, `Band -> Frame` exposes: every profile
//! looks at the rows around its own. Exposure runs over tiles of [`TILE`] columns, so that the window of rows stays in
//! the cache while the profiles of a band pass by.

mod arrange;
pub mod beside;
mod blur;
pub mod camera;
pub mod coherence;
mod digitise;
mod disc;
pub mod expose;
mod field;
pub mod film;
mod focus;
mod lamps;
pub mod laser;
pub mod mirror;
mod moved;
pub mod parameters;
mod pieces;
pub mod row;
mod second;
pub mod sensor;
pub mod slow;
pub mod speckle;
pub mod streak;

use std::sync::Arc;

use procedural::{Medium, Stream};

use self::camera::Camera;
use self::digitise::{Shot, digitise};
use self::film::Watch;
use self::laser::spots::Shining;
use self::parameters::Bench;
use self::row::{Row, RowMaker, RowScratch};
use self::second::SecondLine;
use self::sensor::Chain;
use self::speckle::{FINE, Tile, Tiles};
use crate::frame::{Calibration, Frame};
use crate::lanes;
use crate::settings::{Line, Size, Transport};
use crate::specimen::Specimen;
use crate::transport::fresnel;

pub use self::expose::{CENTRE, ROWS, Scratch};
pub use self::speckle::TILE;

/// Most rows of the specimen that a profile looks at before or behind its own; for steps under 0.035 mm the light that
/// leaves further away is let out by the last of them.
const FARTHEST: usize = 64;

/// Light in one pixel that is left out where it lies beside the line [DN].
const FAINT_DN: f32 = 0.05;

/// Laser, camera and sensor over one scan.
#[derive(Debug)]
pub struct Sensor {
    camera: Camera,
    chain: Chain,
    tiles: Arc<[Tile; 2]>,
    /// Contrast of light from the surface and from below [1].
    contrast: [f32; 2],
    /// Offset of the row that lets light out, for each row of the window [profiles].
    neighbours: [isize; ROWS],
    /// Profiles by row, on a flat surface as high as the object.
    profiles_per_row: f64,
    /// Share of a step that the object moves while it is exposed [1].
    way: f32,
    /// Movement of the pattern with the object [fine rows/mm].
    drift: f64,
    second: Option<SecondLine>,
    /// Light in one pixel that is left out where it lies beside the line [e-].
    faint: f32,
    step: f64,
    size: Size,
    transport: Transport,
    stream: Stream,
    speckle_key: u64,
    maker: RowMaker,
}

/// Rows of the specimen around some profiles of the scan.
#[derive(Debug, Default)]
pub struct Band {
    /// Profiles that can be exposed.
    pub profiles: std::ops::Range<usize>,
    /// Rows before the first profile.
    halo: usize,
    rows: Vec<Row>,
    /// Light from below by a slow model, a profile; empty where the kernel answers.
    windows: Vec<slow::Window>,
}

impl Band {
    /// The row under the laser in `profile`.
    pub fn row(&self, profile: usize) -> &Row {
        self.neighbour(profile, 0)
    }

    fn window(&self, profile: usize) -> Option<&[f32]> {
        self.windows.get(profile - self.profiles.start).map(Vec::as_slice)
    }

    fn neighbour(&self, profile: usize, offset: isize) -> &Row {
        let place = (profile - self.profiles.start + self.halo) as isize + offset;
        &self.rows[place as usize]
    }
}

/// Whole profiles, within the farthest that is looked at.
fn looks(profiles: f64) -> isize {
    (profiles.round() as isize).clamp(-(FARTHEST as isize), FARTHEST as isize)
}

impl Sensor {
    /// Sets the bench up over a specimen whose upper surface lies about `height` [mm]; `clear` is the medium whose paths
    /// decide how far speckle from below is washed out; `stream` belongs to the sample.
    pub fn new(
        bench: &Bench,
        line: Line,
        size: Size,
        height: f64,
        clear: &Medium,
        tiles: &Tiles,
        stream: Stream,
    ) -> Self {
        let camera = Camera::new(bench, &size, line, stream);
        let working = bench.camera.f_number * camera.rig.image_distance / camera.rig.focal_length;
        let grain = bench.laser.wavelength_nm * 1e-3 * working / bench.camera.pixel_um;
        let developed = speckle::pixel_contrast(grain) * bench.speckle.strength;
        let boundary = fresnel::boundary_factor(f64::from(clear.n_eff));
        let paths = coherence::coherence_contrast(clear, boundary, bench.laser.wavelength_nm, bench.laser.linewidth_nm);
        let contrast = [
            developed / bench.speckle.surface_patterns.sqrt(),
            developed * paths / bench.speckle.volume_patterns.sqrt(),
        ];
        let rows_per_mm = f64::from(camera.sight(0.0, height as f32, 0.0).rows_per_mm);
        let step = bench.motion.step_mm;
        let chain = Chain::new(&bench.exposure, size.rows, stream.child("sensor"));
        let profiles_per_row = 1.0 / (rows_per_mm * step);
        let neighbours = std::array::from_fn(|k| looks((CENTRE as f64 - k as f64) * profiles_per_row));
        Self {
            tiles: tiles.get(grain),
            contrast: contrast.map(|c| c as f32),
            neighbours,
            profiles_per_row,
            way: (bench.motion.line_rate_hz * bench.exposure.time_us * 1e-6) as f32,
            drift: rows_per_mm * FINE as f64,
            step,
            size,
            transport: Transport::Kernel,
            stream,
            speckle_key: stream.child("speckle").key(),
            maker: RowMaker::new(
                bench.motion.conveyor_reflectance,
                &camera,
                Shining::new(&bench.laser, stream.child("shining")),
                size.columns,
                height,
            ),
            second: SecondLine::new(&bench.laser, step),
            faint: FAINT_DN / chain.gain,
            chain,
            camera,
        }
    }

    /// The same with light from below by another model than the kernel.
    pub fn with_transport(self, transport: Transport) -> Self {
        Self { transport, ..self }
    }

    /// The geometry and radiometry in use.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Contrast of speckle from the surface and from below in one pixel [1].
    pub fn speckle_contrast(&self) -> [f32; 2] {
        self.contrast
    }

    /// What a reader of the frames has to know.
    pub fn calibration(&self) -> Calibration {
        Calibration::new(self.camera.rig, [self.size.columns, self.size.rows], self.chain.dark_level)
    }

    /// Scan position under the laser in `profile` [mm].
    pub fn position(&self, profile: usize) -> f64 {
        self.position_of(profile as isize)
    }

    fn position_of(&self, profile: isize) -> f64 {
        profile as f64 * self.step
    }

    /// Rows of the specimen that a profile needs before and behind its own, and one for the front faces of the last.
    pub fn halo(&self) -> [usize; 2] {
        let window = self.neighbours[0].max(-self.neighbours[ROWS - 1]) as usize + 1 + usize::from(self.way > 0.0);
        let [before, behind] = self.second.map_or([0; 2], |second| second.reach());
        [window + before, window + behind]
    }

    /// Profiles from its own to the one that a profile looks at `rows` above its line, as far as a band has rows.
    fn looks(&self, rows: f32) -> isize {
        looks(f64::from(rows) * self.profiles_per_row).clamp(self.neighbours[ROWS - 1], self.neighbours[0])
    }

    /// Way that the image of a flat surface moves while it is exposed, along the rows [px].
    pub fn travel_px(&self) -> f64 {
        f64::from(self.way) / self.profiles_per_row
    }

    /// Works out the light at every position that `profiles` look at, in the room of a band that is no longer needed.
    pub fn band(&self, specimen: &Specimen, profiles: std::ops::Range<usize>, mut band: Band) -> Band {
        let [before, behind] = self.halo();
        (band.halo, band.profiles) = (before, profiles);
        band.rows.resize_with(band.profiles.len() + before + behind, Row::default);
        let mut scratch = RowScratch::new(self.size.columns);
        for (place, row) in band.rows.iter_mut().enumerate() {
            let profile = (band.profiles.start + place) as isize - band.halo as isize;
            let y = self.position_of(profile) as f32;
            let watch = Watch { specimen, camera: &self.camera, y, profile, faint: self.faint };
            self.maker.make(watch, &mut scratch, row);
        }
        for place in (1..band.rows.len()).rev() {
            let (before, from) = band.rows.split_at_mut(place);
            before[place - 1].face(&from[0]);
        }
        let slow = slow::Slow { specimen, camera: &self.camera, transport: self.transport, stream: self.stream };
        let window = |profile: usize| slow.window(band.row(profile), profile as u64, self.position(profile));
        // The light that a moving object has in the next profile counts too.
        let last = band.profiles.end + usize::from(self.way > 0.0);
        band.windows = (band.profiles.start..last).map_while(window).collect();
        band
    }

    /// Offsets of the sensor's rows in exposure `profile` [DN]; common to all tiles of the profile.
    pub fn row_offsets(&self, profile: usize, offsets: &mut Vec<f32>) {
        self.chain.rows(profile, offsets);
    }

    /// Exposes columns `tile * TILE ..` of `profile`; `offsets` come from [`Self::row_offsets`]. The second frame has no
    /// rows where one window holds all light.
    pub fn expose(
        &self,
        band: &Band,
        profile: usize,
        tile: usize,
        offsets: &[f32],
        scratch: &mut Scratch,
        frames: &mut [Frame; 2],
    ) {
        expose::window(self, band, profile, tile, scratch);
        let shot = Shot { profile, tile, columns: scratch.columns, offsets };
        frames[1].rows = 0;
        for number in 0..scratch.used {
            digitise(self, &shot, number, &scratch.windows[number], &mut frames[number]);
        }
    }

    /// The whole sensor in exposure `profile`, `[rows, columns]`, row-major [DN]; rows outside the windows are dark.
    pub fn full_frame(&self, band: &Band, profile: usize) -> Vec<u8> {
        let (rows, columns) = (self.size.rows, self.size.columns);
        let mut offsets = Vec::new();
        self.row_offsets(profile, &mut offsets);
        let keys = self.chain.keys("dark", profile);
        let mut sensor: Vec<u8> = (0..rows * columns)
            .map(|pixel| {
                let (normal, _) = lanes::normals(pixel as u32, keys);
                let ambient = lamps::pixel(self, band, profile, pixel % columns, pixel / columns);
                self.chain.digitise(self.chain.gain * ambient, normal, offsets[pixel / columns]) as u8
            })
            .collect();
        let (mut scratch, mut frames) = (Scratch::default(), <[Frame; 2]>::default());
        for tile in 0..columns.div_ceil(TILE) {
            self.expose(band, profile, tile, &offsets, &mut scratch, &mut frames);
            for (k, frame) in frames.iter().flat_map(|frame| (0..frame.rows).map(move |k| (k, frame))) {
                for column in 0..frame.cols {
                    let row = frame.first_row[column] + k as i32;
                    if (0..rows as i32).contains(&row) {
                        sensor[row as usize * columns + frame.first_col + column] =
                            frame.dn[k * frame.cols + column] as u8;
                    }
                }
            }
        }
        sensor
    }
}
