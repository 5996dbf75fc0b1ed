//! Cost of each effect of the instrument: rows and exposure of the full scan's recipe with one effect more, one core,
//! to be held against `none`. One line in [`EFFECTS`] an effect.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use optical_bench::settings::{Fan, Filter, Hdr, LineShape, Scheimpflug, SpeckleLaw};
use recipe::{Recipe, Scene};
use scanner::frame::Frame;
use scanner::optics::speckle::PatternCache;
use scanner::optics::{Band, Scratch, Sensor, TILE, TileOfProfile};
use scanner::specimen::Specimen;

/// Profiles of one band.
const PROFILES: usize = 64;

/// An effect of the instrument.
struct Effect {
    name: &'static str,
    /// Switches it on.
    enable: fn(&mut Scene),
}

const fn effect(name: &'static str, enable: fn(&mut Scene)) -> Effect {
    Effect { name, enable }
}

/// Every effect.
const EFFECTS: &[Effect] = &[
    effect("none", |_| ()),
    effect("laser: cylindrical fan", |s| s.line.fan = Fan::Cylindrical),
    effect("laser: ripple", |s| s.bench.laser.fan_ripple = 0.1),
    effect("laser: narrow line", |s| s.bench.laser.waist_mm = 0.03),
    effect("laser: slit of 0.3 mm", |s| s.line.shape = LineShape::Slit),
    effect("laser: texture", |s| s.line.shape = LineShape::Texture),
    effect("laser: point", |s| s.line.shape = LineShape::Point),
    effect("laser: second line", |s| s.bench.laser.second_line_mm = 3.0),
    effect("laser: smile", |s| s.bench.laser.smile_um = 30.0),
    effect("laser: lobes", |s| s.bench.laser.lobe_share = 0.02),
    effect("laser: skirt", |s| s.bench.laser.skirt_share = 0.02),
    effect("laser: width jitter", |s| s.bench.laser.width_jitter = 0.05),
    effect("laser: streaks", |s| s.bench.laser.streaks_per_mm = 1.0),
    effect("camera: out of focus", |s| s.bench.optics.scheimpflug = Scheimpflug::Given),
    effect("camera: distortion", |s| s.bench.camera.distortion_k1 = -0.06),
    effect("camera: vignetting and filter", |s| {
        (s.bench.camera.vignetting, s.bench.optics.filter) = (0.2, Filter::BandPass);
    }),
    effect("camera: ambient light", |s| s.bench.camera.ambient_w_per_m2_nm = 0.01),
    effect("camera: motion blur", |s| s.bench.motion.line_rate_hz = 0.5e6 / s.bench.exposure.time_us),
    // The recipe has pixels that differ.
    effect("sensor: pixels alike", without_fixed_pattern),
    effect("sensor: PRNU alone", |s| {
        without_fixed_pattern(s);
        s.bench.exposure.prnu = 0.01;
    }),
    effect("sensor: DSNU alone", |s| {
        without_fixed_pattern(s);
        s.bench.exposure.dsnu_dn = 0.25;
    }),
    effect("sensor: column pattern alone", |s| {
        without_fixed_pattern(s);
        s.bench.exposure.column_pattern_dn = 0.1;
    }),
    effect("sensor: blooming", |s| s.bench.exposure.blooming = 0.5),
    effect("sensor: two slopes", |s| s.readout.hdr = Hdr::Medium),
    effect("sensor: 12 bits", |s| s.readout.bits = 12),
    effect("speckle: none", |s| s.bench.speckle.strength = 0.0),
    effect("speckle: the thesis' law", |s| s.speckle_law = SpeckleLaw::Rayleigh),
    effect("speckle: depolarised", |s| s.bench.speckle.surface_patterns = 2.0),
    effect("motion: encoder jitter", |s| s.bench.motion.encoder_jitter_um = 5.0),
    effect("motion: wow", |s| s.bench.motion.wow_um = 50.0),
];

fn without_fixed_pattern(scene: &mut Scene) {
    let exposure = &mut scene.bench.exposure;
    (exposure.prnu, exposure.dsnu_dn, exposure.column_pattern_dn) = (0.0, 0.0, 0.0);
}

/// A board with one effect under the bench.
struct BoardUnderBench {
    scene: Scene,
    sensor: Sensor,
    specimen: Specimen,
}

impl BoardUnderBench {
    fn new(name: &str) -> Self {
        let recipe = Recipe::load("wood.yaml").expect("the embedded recipe loads");
        let mut scene = recipe.draw(0, 0);
        let effect = EFFECTS.iter().find(|effect| effect.name == name).expect("a name of the table");
        (effect.enable)(&mut scene);
        let (sensor, specimen) = pipeline::set_up(&scene, pipeline::body(&scene), &PatternCache::new(0));
        Self { scene, sensor, specimen }
    }

    fn band(&self) -> Band {
        self.sensor.band(&self.specimen, 1500..1500 + PROFILES)
    }
}

fn names() -> impl Iterator<Item = &'static str> {
    EFFECTS.iter().map(|effect| effect.name)
}

fn main() {
    divan::main();
}

/// Light of the rows that a band needs, a profile.
#[divan::bench(args = names())]
fn rows(bencher: Bencher, name: &str) {
    let board = BoardUnderBench::new(name);
    bencher.counter(ItemsCount::new(PROFILES)).bench(|| board.band());
}

/// Exposure without extraction.
#[divan::bench(args = names())]
fn expose(bencher: Bencher, name: &str) {
    let board = BoardUnderBench::new(name);
    let band = board.band();
    let mut offsets = vec![Vec::new(); PROFILES];
    for (place, profile) in band.profiles.clone().enumerate() {
        board.sensor.row_offsets(profile, &mut offsets[place]);
    }
    bencher.counter(ItemsCount::new(PROFILES)).bench(|| {
        let (mut scratch, mut frames) = (Scratch::default(), <[Frame; 2]>::default());
        for tile in 0..board.scene.size.columns / TILE {
            for (place, profile) in band.profiles.clone().enumerate() {
                board.sensor.expose(
                    &TileOfProfile { band: &band, profile, tile, offsets: &offsets[place] },
                    &mut scratch,
                    &mut frames,
                );
                black_box(&frames);
            }
        }
    });
}
