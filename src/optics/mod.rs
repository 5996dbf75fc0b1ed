//! What the light does: from a specimen to digitised frames.
//!
//! `Specimen -> Band` works the light out once for each position of the scan, `Band -> Frame` exposes: every profile
//! looks at the rows around its own. Exposure runs over tiles of [`TILE`] columns, so that the window of rows stays in
//! the cache while the profiles of a band pass by.

mod ambient;
mod band;
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
pub mod fixed_pattern;
mod front_face;
mod full_frame;
mod gaussian_stepper;
mod highlights;
pub mod laser;
mod motion_blur;
pub mod per_line;
pub mod postprocess;
pub mod reflections;
pub mod row;
mod second_line;
pub mod secondary_light;
pub mod signal_chain;
mod spans;
pub mod speckle;
pub mod streak;
mod surface_point;
mod vignetting;

use procedural::{Medium, Stream};

use self::band::looks;
use self::camera::Camera;
use self::digitise::{TileExposure, digitise};
use self::encoder::Encoder;
use self::highlights::Highlights;
use self::postprocess::ThesisScripts;
use self::row::RowMaker;
use self::second_line::SecondLine;
use self::signal_chain::SignalChain;
use self::speckle::{AnchoredSpeckle, PatternCache, SpeckleConditions};
use crate::frame::{Calibration, Frame};
use crate::parameters::{Bench, ExposureParameters};
use crate::settings::{Line, Order, Postprocess, Readout, Size, SpeckleLaw, Transport};
use crate::specimen::{Hit, Specimen, turntable::Turntable};
use crate::transport::fresnel;

pub use self::band::Band;
pub use self::expose::{CENTRE, ROWS, Scratch};
pub use self::speckle::TILE;

/// Most rows of the specimen that a profile looks at before or behind its own; for steps under 0.035 mm the light that
/// leaves further away is let out by the last of them.
const MAX_NEIGHBOURS: usize = 64;

/// Light in one pixel that is left out where it lies beside the line [DN of 8 bits].
const FAINT_DN: f32 = 0.05;

/// Laser, camera and sensor over one scan.
#[derive(Debug)]
pub struct Sensor {
    camera: Camera,
    exposure: ExposureParameters,
    chain: SignalChain,
    /// The thesis' scripts in place of speckle and noise.
    scripts: Option<ThesisScripts>,
    speckle: AnchoredSpeckle,
    /// Which row lets light out, for each row of the window: its distance [mm] and, where steps are even, offset [profiles].
    away: [f64; ROWS],
    neighbours: [isize; ROWS],
    /// Profiles by row, on a flat surface as high as the object.
    profiles_per_row: f64,
    /// Share of a step that the object moves while it is exposed [1].
    way: f32,
    second: Option<SecondLine>,
    /// Light in one pixel that is left out where it lies beside the line [e-].
    faint: f32,
    encoder: Encoder,
    turn: Option<Turntable>,
    size: Size,
    transport: Transport,
    stream: Stream,
    maker: RowMaker,
}

impl Sensor {
    /// Sets the bench up over a specimen whose upper surface lies about `height` [mm]; `clear` is the medium whose paths
    /// decide how far speckle from below is washed out; `stream` belongs to the sample.
    pub fn new(
        bench: &Bench,
        line: &Line,
        size: Size,
        height: f64,
        clear: &Medium,
        (law, tiles): (SpeckleLaw, &PatternCache),
        stream: Stream,
    ) -> Self {
        let camera = Camera::new(bench, &size, line, stream);
        let working = bench.camera.f_number * camera.rig.image_distance / camera.rig.focal_length;
        let grain = bench.laser.wavelength_nm * 1e-3 * working / bench.camera.pixel_um;
        let boundary = fresnel::boundary_factor(f64::from(clear.n_eff));
        let paths = coherence::coherence_contrast(clear, boundary, bench.laser.wavelength_nm, bench.laser.linewidth_nm);
        let rows_per_mm = f64::from(camera.sight(0.0, height as f32, 0.0).rows_per_mm);
        let encoder = Encoder::new(&bench.motion, stream.child("travel"));
        let chain = SignalChain::new(&bench.exposure, Readout::PLAIN, &size, stream.child("sensor"));
        let step = bench.motion.step_mm;
        let profiles_per_row = 1.0 / (rows_per_mm * step);
        let way = bench.motion.line_rate_hz * bench.exposure.time_us * 1e-6;
        let ground = SpeckleConditions { grain, rows_per_mm, height, paths, travel: way / profiles_per_row };
        let away: [f64; ROWS] = std::array::from_fn(|k| (CENTRE as f64 - k as f64) / rows_per_mm);
        let neighbours = away.map(|away| looks(away / step));
        Self {
            speckle: AnchoredSpeckle::new(bench, &ground, law, tiles, stream.child("speckle").key()),
            away,
            neighbours,
            profiles_per_row,
            way: way as f32,
            size,
            transport: Transport::Kernel,
            stream,
            maker: RowMaker::new(
                bench.motion.conveyor_reflectance,
                &camera,
                Highlights::new(&bench.laser, stream.child("shining")),
                size.columns,
                height,
            ),
            second: SecondLine::new(&bench.laser, step),
            faint: FAINT_DN / chain.gain,
            exposure: bench.exposure,
            encoder,
            turn: None,
            chain,
            scripts: None,
            camera,
        }
    }

    /// The same with another converter, or with a knee.
    pub fn with_readout(self, readout: Readout) -> Self {
        if readout == Readout::PLAIN {
            return self;
        }
        let chain = SignalChain::new(&self.exposure, readout, &self.size, self.stream.child("sensor"));
        Self { chain, ..self }
    }

    /// The same with light from below by another model than the kernel.
    pub fn with_transport(self, transport: Transport) -> Self {
        Self { transport, ..self }
    }

    /// The same under an object that turns: light is let out by the matter of its own line.
    pub fn with_turn(self, turn: Option<Turntable>) -> Self {
        let (away, neighbours) = if turn.is_some() { ([0.0; ROWS], [0; ROWS]) } else { (self.away, self.neighbours) };
        Self { turn, away, neighbours, ..self }
    }

    /// The same with the thesis' scripts in place of speckle and noise, where the order is not `physical`.
    pub fn with_postprocess(self, bench: &Bench, readout: Readout, postprocess: Postprocess) -> Self {
        let stream = self.stream.child("postprocess");
        let make = || ThesisScripts::new(postprocess, bench, readout, stream);
        let scripts = (postprocess.order != Order::Physical).then(make);
        Self { scripts, ..self }
    }

    /// Whether frames are made whole by the thesis' scripts ([`Self::processed`]) and not by [`Self::expose`].
    pub fn is_scripted(&self) -> bool {
        self.scripts.is_some()
    }

    /// The geometry and radiometry in use.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Contrast of speckle from the surface and from below in one pixel [1].
    pub fn speckle_contrast(&self) -> [f32; 2] {
        self.speckle.contrast()
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
        self.encoder.position(profile)
    }

    /// What each column sees in `profile`, without light; fills `hits`, `[columns]`.
    pub fn hits(&self, specimen: &Specimen, profile: usize, hits: &mut Vec<Hit>) {
        self.maker.look(specimen, self.position(profile) as f32, hits);
    }

    /// Offsets of the sensor's rows in exposure `profile` [DN]; common to all tiles of the profile.
    pub fn row_offsets(&self, profile: usize, offsets: &mut Vec<f32>) {
        self.chain.row_offsets(profile, offsets);
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
        let hits = &band.row(profile).hits[tile * TILE..][..scratch.columns];
        let place = [hits[scratch.columns / 2].x, usual_height(hits)].map(f64::from);
        // Speckle moves as far as the object does here.
        let way = self.position(profile) * self.turn.map_or(1.0, |turn| turn.share(place[0]));
        let exposure = TileExposure { profile, tile, columns: scratch.columns, place, way, offsets };
        frames[1].rows = 0;
        for number in 0..scratch.used {
            digitise(self, &exposure, number, &scratch.windows[number], &mut scratch.signal, &mut frames[number]);
        }
    }
}

/// Median height of every fourth column of a tile, of those that laser and lens reach where there are some [mm]; a narrow
/// ridge in the middle of a tile does not change what the rest of it sees.
fn usual_height(hits: &[Hit]) -> f32 {
    let (mut heights, mut count) = ([0.0f32; TILE], 0);
    let reached = |hit: &&Hit| hit.lit && hit.seen;
    for hit in hits.iter().step_by(4).filter(reached) {
        heights[count] = hit.surface.z;
        count += 1;
    }
    if count == 0 {
        return hits[hits.len() / 2].surface.z;
    }
    *heights[..count].select_nth_unstable_by(count / 2, f32::total_cmp).1
}
