//! The instrument over one scan: laser, camera, sensor and conveyor, set up for one sample.

use glam::Vec3;
use procedural::{Medium, Stream};

use super::band::Band;
use super::camera::Camera;
use super::coherence::{Coherence, coherence_per_mm, path_contrast};
use super::encoder::Encoder;
use super::highlights::Highlights;
use super::per_line::PerLine;
use super::postprocess::ThesisScripts;
use super::row_maker::{RowMaker, RowScratch};
use super::row_view::RowView;
use super::scan_geometry::ScanGeometry;
use super::second_line::SecondLine;
use super::signal_chain::SignalChain;
use super::speckle::{AnchoredSpeckle, PatternCache, SpeckleConditions};
use super::surface_point::surface_point;
use crate::frame::Calibration;
use crate::specimen::{Hit, Specimen, turntable::Turntable};
use bench::parameters::Bench;
use bench::settings::{LaserLine, Order, Postprocess, Readout, Size, SpeckleLaw};
use transport::kernel::path_laws;
use transport::line::LineSolver;

/// Light in one pixel under which secondary light is left out [DN of 8 bits].
const FAINT_DN: f32 = 0.05;
/// Rows by which those are apart that a look at one profile works out.
const SPARSE_ROWS: usize = 8;

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
    pub(super) second: Option<SecondLine>,
    pub(super) turn: Option<Turntable>,
    pub(super) size: Size,
    /// Light in one pixel under which secondary light is left out [e-].
    pub(super) faint: f32,
    line_solver: Option<Box<dyn LineSolver>>,
    maker: RowMaker,
}

impl Sensor {
    /// Sets the instrument up.
    pub fn new(setup: SensorSetup<'_>) -> Self {
        let SensorSetup { bench, size, height, clear, stream, .. } = setup;
        let camera = Camera::new(bench, &size, setup.line, stream);
        let working = bench.camera.f_number * camera.rig.image_distance / camera.rig.focal_length;
        let grain = bench.laser.wavelength_nm * 1e-3 * working / bench.camera.pixel_um;
        let sight = camera.sight(0.0, height as f32, 0.0);
        let rows_per_mm = f64::from(sight.rows_per_mm);
        // Patterns are those of light on the line.
        let per_mm = coherence_per_mm(bench.laser.wavelength_nm, bench.laser.linewidth_nm) as f32;
        let point = surface_point(clear, Vec3::Z, sight.light, sight.view);
        let [law] = path_laws(&point, sight.variance / (sight.rows_per_mm * sight.rows_per_mm), [0.0]);
        let patterns = path_contrast(per_mm * clear.n_eff, &law);
        let coherence = Coherence { per_mm, patterns };
        let step = bench.motion.step_mm;
        let exposed_share = bench.motion.line_rate_hz * bench.exposure.time_us * 1e-6;
        let travel = exposed_share / (1.0 / (rows_per_mm * step));
        let conditions = SpeckleConditions { grain, rows_per_mm, height, paths: f64::from(patterns), travel };
        let encoder = Encoder::new(&bench.motion, stream.child("travel"));
        let scripted = setup.postprocess.order != Order::Physical;
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
            geometry: ScanGeometry::new(encoder, step, rows_per_mm, exposed_share, setup.turn.is_some()),
            second: SecondLine::new(&bench.laser, step),
            turn: setup.turn,
            size,
            faint: FAINT_DN / gain,
            line_solver: setup.line_solver,
            maker: RowMaker::new(
                bench.motion.conveyor_reflectance,
                &camera,
                Highlights::new(&bench.laser, stream.child("shining")),
                coherence,
                size.columns,
                height,
            ),
            camera,
        }
    }

    /// The same with the light of every row worked out for itself, where otherwise many are interpolated: what that is held against.
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
        self.speckle.contrast()
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

    /// Rows of the specimen that a profile needs before and behind its own, and one for the front faces of the last.
    pub fn halo(&self) -> [usize; 2] {
        let [before, behind] = self.second.map_or([0; 2], |second| second.reach());
        [self.geometry.halo() + before, self.geometry.halo() + behind]
    }

    /// Distance that the image of a flat surface moves along the rows while it is exposed [px].
    pub fn travel_px(&self) -> f64 {
        self.geometry.exposed_px()
    }

    /// Works out the light at every position that `profiles` look at. `band` is empty, or one of this sensor and specimen
    /// that is no longer needed: its memory is used again, and so are the rows that both hold.
    pub fn band(&self, specimen: &Specimen, profiles: std::ops::Range<usize>, mut band: Band) -> Band {
        let kept = band.restart(profiles, self.halo());
        let first = (band.profiles.start + kept) as isize - band.halo as isize;
        let mut scratch = self.row_scratch(&mut band);
        self.maker.make_all(first, &mut band.rows[kept..], |profile| self.view(specimen, profile), &mut scratch);
        self.finish(specimen, band, scratch)
    }

    /// The same for a look at one profile: every eighth row around it stands for those beside it, which takes a fraction of the
    /// time and shows light that comes from other rows less finely: what has crept under the surface, front faces, light that parts of a body throw at
    /// each other.
    pub fn sparse_band(&self, specimen: &Specimen, profile: usize, mut band: Band) -> Band {
        band.restart(profile..profile + 1, self.halo());
        let own = band.halo;
        // Rows below a line, and those that a moving object has come to, do not stand for others.
        let lines = self.second.map(|second| second.rows()).into_iter().chain([0..=0]);
        let moved = isize::from(self.geometry.exposed_share > 0.0);
        let exact: Vec<isize> = lines.flat_map(|rows| *rows.start()..=*rows.end() + moved).collect();
        let is_made = |place: usize| {
            let away = place as isize - own as isize;
            away.unsigned_abs().is_multiple_of(SPARSE_ROWS) || exact.contains(&away)
        };
        let mut scratch = self.row_scratch(&mut band);
        for place in (0..band.rows.len()).filter(|&place| is_made(place)) {
            let view = self.view(specimen, (profile + place) as isize - own as isize);
            self.maker.make(view, &mut scratch, &mut band.rows[place]);
        }
        for place in (0..band.rows.len()).filter(|&place| !is_made(place)) {
            let sides = |away: usize| [place.checked_sub(away), Some(place + away)].into_iter().flatten();
            let near = (1..SPARSE_ROWS).flat_map(sides).find(|&near| near < band.rows.len() && is_made(near));
            band.rows[place] = band.rows[near.unwrap_or(own)].clone();
        }
        band.is_sparse = true;
        self.finish(specimen, band, scratch)
    }

    fn row_scratch(&self, band: &mut Band) -> Box<RowScratch> {
        band.scratch.take().unwrap_or_else(|| Box::new(RowScratch::new(self.size.columns)))
    }

    fn view<'a>(&'a self, specimen: &'a Specimen, profile: isize) -> RowView<'a> {
        let y = self.geometry.position(profile) as f32;
        RowView { specimen, camera: &self.camera, y, profile, faint: self.faint }
    }

    /// What follows once a band's rows are made.
    fn finish(&self, specimen: &Specimen, mut band: Band, scratch: Box<RowScratch>) -> Band {
        band.scratch = Some(scratch);
        if let Some(last) = band.rows.last_mut() {
            last.front.clear();
        }
        let view = self.camera.sight(0.0, 0.0, 0.0).view;
        for place in (1..band.rows.len()).rev() {
            let (before, from) = band.rows.split_at_mut(place);
            before[place - 1].open_front(&from[0], -view.z / view.y);
        }
        // The light that a moving object has in the next profile counts too.
        band.offsets = self.geometry.uneven_neighbours(band.profiles.start..band.profiles.end + 1);
        band.volumes.clear();
        if let Some(solver) = self.line_solver.as_deref() {
            let model = PerLine { specimen, camera: &self.camera, solver };
            let last = band.profiles.end + usize::from(self.geometry.exposed_share > 0.0);
            let volume = |profile: usize| model.volume(band.row(profile), profile as u64, self.position(profile));
            band.volumes = (band.profiles.start..last).map(volume).collect();
        }
        band
    }
}
