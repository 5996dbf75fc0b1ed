//! The instrument over one scan: laser, camera, sensor and conveyor, set up for one sample.

use base::{Medium, Stream};
use glam::Vec3;

use super::camera::{Camera, PIXEL_VARIANCE};
use super::encoder::Encoder;
use super::lamps::{GreyCamera, Lamps};
use super::readout::{SignalChain, ThesisScripts};
use super::scan_line::{Highlights, LineMaker, surface_point};
use super::speckle::coherence::{CONTRAST_PLACES, Coherence, coherence_per_mm, row_contrasts};
use super::speckle::{AnchoredSpeckle, PatternCache, SpeckleConditions};
use super::unrest::UnsteadyRig;
use super::window::{Band, Glare, ScanGeometry, SecondLine};
use crate::frame::Calibration;
use crate::specimen::{Hit, Specimen, turntable::Turntable};
use optical_bench::parameters::Bench;
use optical_bench::settings::{LaserLine, Order, Postprocess, Readout, Size, SpeckleLaw};
use transport::kernel::path_laws;
use transport::line::LineSolver;

/// Light in one pixel under which secondary light is left out [DN of 8 bits].
const FAINT_DN: f32 = 0.05;

/// Everything that a [`Sensor`] is set up from.
#[derive(Debug)]
pub struct SensorSetup<'a> {
    /// Numbers of the bench.
    pub bench: &'a Bench,
    /// Kind of the laser line.
    pub line: &'a LaserLine,
    /// Columns and rows of the sensor, profiles of the scan.
    pub size: Size,
    /// Height of the specimen's upper surface, about [mm].
    pub height: f64,
    /// Medium whose path lengths decide how far speckle from below the surface is washed out.
    pub clear: &'a Medium,
    /// Law of the speckle's intensity.
    pub speckle_law: SpeckleLaw,
    /// Speckle patterns, shared by all samples.
    pub patterns: &'a PatternCache,
    /// Converter and slopes of the response.
    pub readout: Readout,
    /// The thesis' scripts in place of speckle and noise, where the order is not `physical`.
    pub postprocess: Postprocess,
    /// Where the specimen turns; `None` for a straight way.
    pub turn: Option<Turntable>,
    /// Model of light from below that answers one line at a time; `None` for the kernel.
    pub line_solver: Option<Box<dyn LineSolver>>,
    /// Stream of the sample.
    pub stream: Stream,
    /// Stream of the instrument, which samples may have in common.
    pub rig_stream: Stream,
}

/// Laser, camera and sensor over one scan.
#[derive(Debug)]
pub struct Sensor {
    pub(super) camera: Camera,
    pub(super) chain: SignalChain,
    pub(super) speckle: AnchoredSpeckle,
    /// The thesis' scripts in place of speckle and noise.
    pub(super) scripts: Option<ThesisScripts>,
    pub(super) geometry: ScanGeometry,
    pub(super) unsteady: UnsteadyRig,
    pub(super) second: Option<SecondLine>,
    /// Veiling glare of the lens; `None` without.
    pub(super) glare: Option<Glare>,
    pub(super) turn: Option<Turntable>,
    pub(super) size: Size,
    /// Light in one pixel under which secondary light is left out [e-].
    pub(super) faint: f32,
    pub(super) line_solver: Option<Box<dyn LineSolver>>,
    /// The map `grey`; `None` without lamps.
    pub(super) grey: Option<GreyCamera>,
    pub(super) maker: LineMaker,
}

impl Sensor {
    /// Sets the instrument up.
    pub fn new(setup: SensorSetup<'_>) -> Self {
        let SensorSetup { bench, size, height, clear, stream, .. } = setup;
        let camera = Camera::new(bench, &size, setup.line, stream, setup.rig_stream);
        let working = bench.camera.f_number * camera.rig.image_distance / camera.rig.focal_length;
        let grain = bench.laser.wavelength_nm * 1e-3 * working / bench.camera.pixel_um;
        let sight = camera.sight(0.0, height as f32, 0.0);
        let rows_per_mm = f64::from(sight.rows_per_mm);
        // Patterns are those of light on the line.
        let per_mm = coherence_per_mm(bench.laser.wavelength_nm, bench.laser.linewidth_nm) as f32;
        let point = surface_point(clear, Vec3::Z, sight.light, sight.view);
        let blur = (sight.variance - PIXEL_VARIANCE) / (sight.rows_per_mm * sight.rows_per_mm);
        let laws = path_laws(&point, blur, CONTRAST_PLACES.map(|rows| rows / sight.rows_per_mm));
        let [[patterns, ..], _] = row_contrasts(per_mm * clear.n_eff, &laws);
        let coherence = Coherence { per_mm, patterns };
        let step = bench.motion.step_mm;
        let exposed_share = bench.motion.line_rate_hz * bench.exposure.time_us * 1e-6;
        let travel = exposed_share / (1.0 / (rows_per_mm * step));
        let conditions = SpeckleConditions { grain, rows_per_mm, height, paths: f64::from(patterns), travel };
        let encoder = Encoder::new(&bench.motion, stream.child("travel"));
        let scripted = setup.postprocess.order != Order::Physical;
        let geometry = ScanGeometry::new(encoder, step, rows_per_mm, exposed_share, setup.turn.is_some());
        let lamps = Lamps::new(bench);
        let column_mm = f64::from(sight.column_mm);
        let grey = lamps.clone().map(|lamps| {
            GreyCamera::new(lamps, bench, setup.readout, [step, column_mm], geometry.halo(), stream.child("grey"))
        });
        // On the scale of 8 bits, whatever the converter.
        let gain = ((255.0 - bench.exposure.dark_level_dn) / bench.exposure.full_well_e) as f32;
        Self {
            chain: SignalChain::new(&bench.exposure, setup.readout, &size, stream.child("sensor")),
            speckle: AnchoredSpeckle::new(
                bench,
                &conditions,
                setup.speckle_law,
                setup.patterns,
                stream.child("speckle").key(),
            ),
            scripts: scripted
                .then(|| ThesisScripts::new(setup.postprocess, bench, setup.readout, stream.child("postprocess"))),
            geometry,
            unsteady: UnsteadyRig::new(bench, &camera.rig, size.profiles, stream.child("unrest")),
            grey,
            glare: Glare::new(bench),
            second: SecondLine::new(&bench.laser, step),
            turn: setup.turn,
            size,
            faint: FAINT_DN / gain,
            line_solver: setup.line_solver,
            maker: LineMaker::new(
                bench.motion.conveyor_reflectance,
                &camera,
                Highlights::new(&bench.laser, stream.child("shining")),
                coherence,
                lamps,
                size.columns,
                height,
            ),
            camera,
        }
    }

    /// The same with the light of every line worked out for itself, where otherwise many are interpolated: what that is
    /// held against.
    pub fn without_interpolation(mut self) -> Self {
        self.maker.interpolates = false;
        self
    }

    /// Whether frames are made whole by the thesis' scripts ([`Self::processed`]) and not by [`Self::expose`].
    pub fn is_scripted(&self) -> bool {
        self.scripts.is_some()
    }

    /// Whether another model than the kernel works out each line's light from below the surface.
    pub fn solves_lines(&self) -> bool {
        self.line_solver.is_some()
    }

    /// The geometry and radiometry in use.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Contrast of speckle from the surface and, on the line, from below in one pixel [1].
    pub fn speckle_contrast(&self) -> [f32; 2] {
        self.speckle.contrast
    }

    /// What a reader of the frames has to know.
    pub fn calibration(&self) -> Calibration {
        Calibration::new(self.camera.rig, [self.size.columns, self.size.rows], self.chain.dark_level)
    }

    /// Scan position under the laser in `profile` [mm].
    pub fn position(&self, profile: usize) -> f64 {
        self.geometry.position(profile as isize)
    }

    /// What each column sees in `profile`, without light; fills `hits`, `[columns]`.
    pub fn hits(&self, specimen: &Specimen, profile: usize, hits: &mut Vec<Hit>) {
        self.maker.look(specimen, self.position(profile) as f32, hits);
    }

    /// Offsets of the sensor's rows in exposure `profile` [DN]; common to all tiles of the profile.
    pub fn row_offsets(&self, profile: usize, offsets: &mut Vec<f32>) {
        self.chain.row_offsets(profile, offsets);
    }

    /// Exposes a band under lamps: fills `grey`, `[profiles, columns]`, NaN where the lens does not see the point of a
    /// profile; leaves it where there are no lamps [DN].
    pub fn expose_grey(&self, band: &Band, grey: &mut [f32]) {
        if let Some(camera) = &self.grey {
            camera.expose(band, grey);
        }
    }

    /// Scan lines that a profile needs before and behind its own, and one for the front faces of the last.
    pub fn halo(&self) -> [usize; 2] {
        let [before, behind] = self.second.map_or([0; 2], |second| second.reach());
        [self.geometry.halo() + before, self.geometry.halo() + behind]
    }

    /// Distance that the image of a flat surface moves along the rows while it is exposed [px].
    pub fn travel_px(&self) -> f64 {
        self.geometry.exposed_px()
    }
}
