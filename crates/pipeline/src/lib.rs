//! The spine: `Scene -> Record`, the only function that a newcomer must read.

pub mod effective;
pub mod labels;

mod binning;
mod derived;
mod equipment;
mod exposed_rows;
mod range_scale;
mod region;

use std::sync::Arc;

use std::ops::Range;

use base::{Body, Mesh};
use procedural::blister::Pack;
use procedural::solid::{self, Sawtooth};
use procedural::wood::{BoardStreams, Plank, Stem};
use rayon::prelude::*;

use crate::binning::Binning;
use crate::effective::{calibration_numbers, effective, typical};
use dataset::record::{Below, Labels, Maps, Record, StackFrame, TruthMaps};
use optical_bench::settings::{Lamps, LogSource, RangeForm, SensorStack, Transport};
use recipe::{Plan, Scene, Subject};
use scanner::extract::{MAX_SURFACE_SLOPE, MeasuredProfile, RectifiedGrid, extract, rectify};
use scanner::frame::{Calibration, Frame, Rig};
use scanner::optics::encoder::turn;
use scanner::optics::{Band, Scratch, Sensor, SensorSetup, TILE, TileOfProfile};
use scanner::specimen::{Hit, Specimen};

pub use self::derived::derived;
pub use self::equipment::{Equipment, LineSolvers};
use self::range_scale::{grid, range_scale};
pub use self::region::{PixelRegion, cropped, render_region};

/// Profiles of a band: half as many as the rows that its windows reach to before and behind it. The next band of a run
/// uses those again; with 2560 columns they take 70 MB a thread.
const BAND_PROFILES: usize = 32;
/// Runs of neighbouring bands that a thread has of a scan, to share the work evenly; a run makes the rows about its
/// bands once.
const RUNS_PER_THREAD: usize = 2;
/// Fewest profiles of a run, in rows that its windows reach before and behind it: small samples are left whole to one
/// thread.
const MIN_RUN_HALOS: usize = 4;

/// Renders one sample. `progress` is told the number of profiles whenever some are finished.
///
/// The result depends on the scene alone: not on the number of threads, on bands, or on what was rendered before.
pub fn render<'a>(scene: &Scene, by: impl Into<Equipment<'a>>, progress: &(dyn Fn(u64) + Sync)) -> Record {
    render_body(scene, body(scene), by, progress)
}

/// Grows or forms the object of a scene.
pub fn body(scene: &Scene) -> Body {
    match &scene.plan {
        Plan::Wood(wood) => {
            let stream = scene.stream.child("plank");
            let streams = BoardStreams { board: stream, log: scene.log_stream.child("plank") };
            Body::new(match scene.log {
                LogSource::Placed => Plank::grow(stream, wood),
                LogSource::Stem | LogSource::Measured => match scene.measured.as_deref() {
                    Some(measured) => Plank::saw_of_log(streams, wood, measured),
                    None => Plank::saw_of_log(streams, wood, &Stem::grow(streams.log.child("stem"), &wood.stem)),
                },
                LogSource::Picture => {
                    // A recipe about boards from a picture has one.
                    let picture = scene.picture.as_deref().expect("the recipe was refused without a picture");
                    Plank::lay(stream, wood, Arc::new(picture.cut(wood)))
                }
                LogSource::Slices => {
                    let slices = scene.slices.as_ref().expect("the recipe was refused without slices");
                    Plank::lay(stream, wood, Arc::new(slices.cut(wood)))
                }
            })
        }
        Plan::Blister(blister) => Body::new(Pack::form(scene.stream.child("pack"), blister)),
        Plan::Sawtooth(piece, material) => Body::new(Sawtooth::new(piece, material)),
        Plan::Mesh(placing, material) => {
            // A recipe about meshes has one; a scene made by hand without one lays nothing down.
            let none = Mesh::default();
            Body::new(solid::Part::new(scene.mesh.as_deref().unwrap_or(&none), placing, material))
        }
    }
}

/// [`render`] for any body.
pub fn render_body<'a>(
    scene: &Scene,
    body: Body,
    by: impl Into<Equipment<'a>>,
    progress: &(dyn Fn(u64) + Sync),
) -> Record {
    let (sensor, specimen) = set_up(scene, body, by);
    render_set_up(scene, &sensor, &specimen, progress)
}

/// [`render`] for what [`set_up`] has put under the bench of that scene.
pub fn render_set_up(scene: &Scene, sensor: &Sensor, specimen: &Specimen, progress: &(dyn Fn(u64) + Sync)) -> Record {
    let mut scan = Scan::new(scene, scene.size.profiles);
    scan.expose(scene, sensor, specimen, progress);
    scan.record(scene, sensor, specimen)
}

/// Puts a body under a scene's bench.
pub fn set_up<'a>(scene: &Scene, body: Body, by: impl Into<Equipment<'a>>) -> (Sensor, Specimen) {
    let sensor = sensor_over(scene, &body, by);
    let specimen = specimen_under(scene, body, &sensor);
    (sensor, specimen)
}

/// The instrument of a scene over its body.
pub fn sensor_over<'a>(scene: &Scene, body: &Body, by: impl Into<Equipment<'a>>) -> Sensor {
    let Equipment { patterns, line_solvers } = by.into();
    let height = f64::from(body.bounds().1.z);
    let matter = typical(&scene.plan);
    let turn = turn(&scene.bench.motion, scene.movement);
    Sensor::new(SensorSetup {
        bench: &scene.bench,
        line: &scene.line,
        size: scene.size,
        height,
        clear: &matter,
        speckle_law: scene.speckle_law,
        patterns,
        readout: scene.readout,
        postprocess: scene.postprocess,
        turn,
        line_solver: line_solvers(scene.transport, scene.stream),
        stream: scene.stream,
        rig_stream: scene.rig_stream,
    })
}

/// A scene's body under its instrument. Of the scene it takes the movement and the laser's place, of the instrument
/// where the camera is and whether it solves lines: where these are the same, so is what comes of a body.
pub fn specimen_under(scene: &Scene, body: Body, sensor: &Sensor) -> Specimen {
    let turn = turn(&scene.bench.motion, scene.movement);
    let specimen = Specimen::new(body, sensor.camera().rig, scene.bench.laser.fan_height_mm).on_turntable(turn);
    // Models that follow light through packs find out for themselves what fills pockets.
    if sensor.solves_lines() { specimen } else { specimen.with_pockets() }
}

/// Full-size maps of one sample or of some of its profiles, `[profiles, columns]`, row-major.
struct Scan {
    maps: Maps,
    labels: Labels,
    truth: Option<TruthMaps>,
    stack: Vec<StackFrame>,
}

/// How frames of a scene are read.
struct Measurement<'a> {
    scene: &'a Scene,
    sensor: &'a Sensor,
    calibration: Calibration,
    /// The grid of a rectified scan.
    grid: Option<RectifiedGrid>,
    /// Which sensor frames are wanted.
    keeps: SensorStack,
    /// Tiles of columns that are exposed, where frames are not made whole.
    tiles: Range<usize>,
}

impl<'a> Measurement<'a> {
    fn new(scene: &'a Scene, sensor: &'a Sensor, keeps: SensorStack) -> Self {
        let calibration = sensor.calibration();
        let tiles = 0..scene.size.columns.div_ceil(TILE);
        Self { scene, sensor, grid: grid(scene, &calibration.rig), calibration, keeps, tiles }
    }
}

/// The part of a scan's maps that one band fills.
struct BandMaps<'a> {
    range: &'a mut [f32],
    reflectance: &'a mut [f32],
    scatter: &'a mut [f32],
    /// Empty without lamps.
    grey: &'a mut [f32],
    class: &'a mut [u8],
    instance: &'a mut [u16],
    truth: Option<Vec<&'a mut [f32]>>,
}

impl Scan {
    /// Of so many profiles.
    fn new(scene: &Scene, profiles: usize) -> Self {
        let pixels = scene.size.columns * profiles;
        let map = || vec![0.0f32; pixels];
        let grey = if scene.bench.optics.lamps == Lamps::None { Vec::new() } else { map() };
        Self {
            maps: Maps { range: map(), reflectance: map(), scatter: map(), grey },
            labels: Labels { class: vec![0; pixels], instance: vec![0; pixels] },
            truth: scene.output.truth_maps.then(|| truth_maps(scene, pixels)),
            stack: Vec::new(),
        }
    }

    fn expose(&mut self, scene: &Scene, sensor: &Sensor, specimen: &Specimen, progress: &(dyn Fn(u64) + Sync)) {
        let (columns, profiles) = (scene.size.columns, scene.size.profiles);
        // A slow model takes so long for a line that work and progress go profile by profile.
        let (length, run) = match scene.transport {
            Transport::Kernel => {
                let length = BAND_PROFILES.min(profiles);
                let even = profiles.div_ceil(RUNS_PER_THREAD * rayon::current_num_threads());
                let run = even.max(MIN_RUN_HALOS * sensor.halo().iter().sum::<usize>());
                (length, run.div_ceil(length))
            }
            Transport::Path { .. } | Transport::Diffusion { .. } | Transport::Thesis { .. } => (1, 1),
        };
        let measurement = Measurement::new(scene, sensor, scene.output.sensor_stack);
        let stacks: Vec<Vec<StackFrame>> = self
            .parts(length * columns)
            .into_par_iter()
            .with_min_len(run)
            .enumerate()
            .map_init(
                || sensor.bands(specimen),
                |bands, (number, part)| {
                    let start = number * length;
                    let profiles = start..(start + length).min(profiles);
                    let band = bands.make(profiles);
                    let stack = part.fill(&measurement, band);
                    progress(band.profiles.len() as u64);
                    stack
                },
            )
            .collect();
        self.stack = stacks.into_iter().flatten().collect();
    }

    /// The maps in parts of `step` pixels.
    fn parts(&mut self, step: usize) -> Vec<BandMaps<'_>> {
        let mut parts: Vec<BandMaps<'_>> = Vec::with_capacity(self.maps.range.len().div_ceil(step));
        let maps = self.truth.as_mut().map(TruthMaps::maps_mut);
        let mut truth = maps.map(|maps| maps.into_iter().map(|map| map.chunks_mut(step)).collect::<Vec<_>>());
        let measured = self.maps.range.chunks_mut(step).zip(self.maps.reflectance.chunks_mut(step));
        let measured = measured.zip(self.maps.scatter.chunks_mut(step));
        let mut grey = self.maps.grey.chunks_mut(step);
        let labelled = self.labels.class.chunks_mut(step).zip(self.labels.instance.chunks_mut(step));
        for (((range, reflectance), scatter), (class, instance)) in measured.zip(labelled) {
            let truth = truth.as_mut().map(|maps| maps.iter_mut().map(|map| map.next().unwrap_or_default()).collect());
            let grey = grey.next().unwrap_or_default();
            parts.push(BandMaps { range, reflectance, scatter, grey, class, instance, truth });
        }
        parts
    }

    fn record(self, scene: &Scene, sensor: &Sensor, specimen: &Specimen) -> Record {
        let (columns, rows, cols) = (scene.output.bin_columns, scene.output.bin_profiles, scene.size.columns);
        let rig = sensor.camera().rig;
        let Self { maps, labels, truth, stack } = self.binned(scene, &rig);
        let top = f64::from(specimen.top());
        let grid = grid(scene, &rig);
        // The mean of the columns, which a bent lens makes unlike.
        let mean = || (rig.along(cols as f64 - 1.0, top) - rig.along(0.0, top)) / (cols as f64 - 1.0);
        let pitch = grid.map_or_else(mean, |grid| grid.pitch_mm);
        let (col_mm, row_mm) = (pitch * columns as f64, scene.bench.motion.step_mm * rows as f64);
        let instances = specimen.body().instances();
        let x = |column: f64| grid.map_or_else(|| rig.along(column, top), |g| g.first_mm + column * g.pitch_mm);
        let share =
            |column: f64| turn(&scene.bench.motion, scene.movement).map_or(1.0, |turn| turn.share(x(column)).abs());
        let areas = labels::areas(cols, columns, col_mm * row_mm, share);
        let turned = turn(&scene.bench.motion, scene.movement).is_some();
        let pixel_mm = [row_mm, col_mm].map(|side| if turned { f64::NAN } else { side });
        let objects = labels::objects(&labels, &areas, pixel_mm, instances);
        let (defects, unseen) = labels::defects(&objects, instances);
        let [range_offset, range_scale] = range_scale(scene, &rig);
        // The middle of the columns that are averaged into the first.
        let x_first = grid.map_or(f64::NAN, |grid| grid.first_mm + 0.5 * (col_mm - pitch));
        let [field_x, field_y] = field(scene, sensor, specimen);
        Record {
            index: scene.index,
            id: scene.id.clone(),
            split: scene.split,
            class: scene.class.clone(),
            groups: scene.groups,
            cols: cols / columns,
            rows: scene.size.profiles / rows,
            row_mm,
            col_mm,
            range: scene.extraction.range,
            range_offset,
            range_scale,
            sensor_rows: scene.size.rows,
            calibration: calibration_numbers(&rig, x_first),
            draws: scene.draws(),
            physics: effective(scene, sensor, top),
            maps,
            labels,
            truth,
            objects,
            defects,
            unseen,
            object_in_view: specimen.share_within(field_x, field_y),
            stack,
        }
    }

    /// Maps of the pixels that are written.
    fn binned(self, scene: &Scene, rig: &Rig) -> Self {
        let binning = binning(scene, rig);
        let (maps, labels) = (binning.maps(self.maps), binning.labels(self.labels));
        let truth = self.truth.map(|truth| binning.truth(truth, &labels.class));
        Self { maps, labels, truth, stack: self.stack }
    }
}

/// How pixels of a scene are put together.
fn binning(scene: &Scene, rig: &Rig) -> Binning {
    let (size, columns, rows) = (scene.size, scene.output.bin_columns, scene.output.bin_profiles);
    let middle = 0.5 * size.columns as f64;
    let column_mm = rig.along(middle, 0.0) - rig.along(middle - 1.0, 0.0);
    let side_mm = (column_mm.abs() * columns as f64).max(scene.bench.motion.step_mm * rows as f64);
    let step_mm = f64::from(MAX_SURFACE_SLOPE) * side_mm;
    let step = match scene.extraction.range {
        RangeForm::Calibrated | RangeForm::Rectified { .. } => step_mm,
        RangeForm::Uncalibrated => {
            let (low, high) = rig.heights(size.columns, size.rows);
            step_mm * size.rows as f64 / (high - low)
        }
    };
    Binning { cols: size.columns, columns, rows, step: step as f32 }
}

/// The field of the images: along the line what the columns see at the height of the object's upper end, along the scan
/// the profiles with half a step around them; first and last x, first and last y [mm].
pub fn field(scene: &Scene, sensor: &Sensor, specimen: &Specimen) -> [[f64; 2]; 2] {
    let (size, output) = (scene.size, &scene.output);
    let (rig, top) = (sensor.camera().rig, f64::from(specimen.top()));
    // What does not fill a whole pixel of binned images is not in them.
    let [columns, profiles] = [(size.columns, output.bin_columns), (size.profiles, output.bin_profiles)]
        .map(|(pixels, bin)| pixels / bin * bin);
    let mut x = [-0.5, columns as f64 - 0.5].map(|column| rig.along(column, top));
    if let Some(grid) = grid(scene, &rig) {
        let place = |column: f64| grid.first_mm + column * grid.pitch_mm;
        x = [x[0].max(place(-0.5)), x[1].min(place(columns as f64 - 0.5))];
    }
    let half = 0.5 * scene.bench.motion.step_mm;
    let y = [sensor.position(0) - half, sensor.position(profiles.saturating_sub(1)) + half];
    [x, y]
}

/// The profiles of a sample by these numbers, one after the other, measured and labelled as [`render`] does it but for
/// light that comes from other rows than the lines', which are further apart ([`scanner::optics::Bands::make_sparse`]).
pub fn render_profiles(scene: &Scene, sensor: &Sensor, specimen: &Specimen, profiles: &[usize]) -> (Maps, Labels) {
    let mut scan = Scan::new(scene, profiles.len());
    let measurement = Measurement::new(scene, sensor, SensorStack::None);
    let mut bands = sensor.bands(specimen);
    for (part, &profile) in scan.parts(scene.size.columns).into_iter().zip(profiles) {
        part.fill(&measurement, bands.make_sparse(profile));
    }
    (scan.maps, scan.labels)
}

/// What the pixels of a profile show, without light.
pub fn profile_hits(scene: &Scene, sensor: &Sensor, specimen: &Specimen, profile: usize) -> Vec<Hit> {
    let mut hits = Vec::new();
    sensor.hits(specimen, profile, &mut hits);
    match grid(scene, &sensor.camera().rig) {
        Some(grid) => labels::on_grid(&hits, grid.first_mm, grid.pitch_mm),
        None => hits,
    }
}

/// Truth maps of so many pixels, those that the subject has.
fn truth_maps(scene: &Scene, pixels: usize) -> TruthMaps {
    let map = || vec![0.0f32; pixels];
    TruthMaps {
        height: map(),
        below: match scene.plan.subject() {
            Subject::Wood => Below::Fibre { azimuth: map(), dive: map() },
            Subject::Blister => Below::Film { thickness: map(), gap: map() },
            Subject::Sawtooth | Subject::Mesh => Below::Solid(scene.plan.subject().name()),
        },
    }
}

/// Writes the truth of one profile into its lines of the [`truth_maps`].
fn truth_row(scene: &Scene, hits: &[Hit], maps: Vec<&mut [f32]>) {
    match scene.plan.subject() {
        Subject::Wood => labels::truth_row(hits, maps, labels::fibre),
        Subject::Blister => labels::truth_row(hits, maps, labels::film),
        Subject::Sawtooth | Subject::Mesh => labels::truth_row(hits, maps, |hit| [hit.surface.z]),
    }
}

impl BandMaps<'_> {
    /// Fills the part with the profiles of `band` and returns the sensor frames that are wanted.
    fn fill(mut self, measurement: &Measurement<'_>, band: &Band) -> Vec<StackFrame> {
        let Measurement { scene, sensor, calibration, grid, keeps, tiles } = measurement;
        let (columns, profiles) = (scene.size.columns, band.profiles.clone());
        let mut offsets = vec![Vec::new(); profiles.len()];
        let mut stack = Vec::new();
        for (place, profile) in profiles.clone().enumerate() {
            let line = place * columns..(place + 1) * columns;
            let hits = &band.line(profile).hits;
            let even = grid.map(|grid| labels::on_grid(hits, grid.first_mm, grid.pitch_mm));
            let hits = even.as_ref().unwrap_or(hits);
            labels::label_row(hits, &mut self.class[line.clone()], &mut self.instance[line.clone()]);
            if let Some(maps) = &mut self.truth {
                truth_row(scene, hits, maps.iter_mut().map(|map| &mut map[line.clone()]).collect());
            }
            sensor.row_offsets(profile, &mut offsets[place]);
            if sensor.is_scripted() {
                let frame = sensor.processed(band, profile);
                if is_kept(*keeps, profile) {
                    stack.push(StackFrame { profile: profile as u32, dn: frame.dn.clone() });
                }
                extract(&[frame, Frame::default()], calibration, &scene.extraction, &mut self.pixels(line));
            } else if is_kept(*keeps, profile) {
                stack.push(StackFrame { profile: profile as u32, dn: sensor.full_frame(band, profile) });
            }
        }
        if !sensor.is_scripted() {
            let (mut scratch, mut frames) = (Scratch::default(), <[Frame; 2]>::default());
            for tile in tiles.clone() {
                for (place, profile) in profiles.clone().enumerate() {
                    let part = TileOfProfile { band, profile, tile, offsets: &offsets[place] };
                    let line = place * columns + tile * TILE..place * columns + ((tile + 1) * TILE).min(columns);
                    let buffers = (&mut scratch, &mut frames);
                    sensor.measure(&part, calibration, &scene.extraction, buffers, &mut self.pixels(line));
                }
            }
        }
        sensor.expose_grey(band, self.grey);
        if let Some(grid) = grid {
            for (grey, profile) in self.grey.chunks_mut(columns).zip(profiles) {
                labels::light_on_grid(&band.line(profile).hits, grid.first_mm, grid.pitch_mm, grey);
            }
            let maps = self.range.chunks_mut(columns).zip(self.reflectance.chunks_mut(columns));
            for ((range, reflectance), scatter) in maps.zip(self.scatter.chunks_mut(columns)) {
                rectify(calibration, grid, MeasuredProfile { range, reflectance, scatter });
            }
        }
        stack
    }

    /// Where the numbers of the pixels `line` go.
    fn pixels(&mut self, line: Range<usize>) -> MeasuredProfile<'_> {
        MeasuredProfile {
            range: &mut self.range[line.clone()],
            reflectance: &mut self.reflectance[line.clone()],
            scatter: &mut self.scatter[line],
        }
    }
}

/// Whether the recipe keeps the sensor frame of `profile`.
fn is_kept(stack: SensorStack, profile: usize) -> bool {
    match stack {
        SensorStack::None => false,
        SensorStack::All => true,
        SensorStack::Every(k) => profile.is_multiple_of(k),
    }
}
