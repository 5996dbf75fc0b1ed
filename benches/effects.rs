//! What each effect of the instrument costs: rows and exposure of the full scan's recipe with one effect more, one core, to
//! be held against `none`. One line in [`EFFECTS`] an effect.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use sheetlight::frame::Frame;
use sheetlight::optics::speckle::PatternCache;
use sheetlight::optics::{Band, Scratch, Sensor, TILE};
use sheetlight::pipeline;
use sheetlight::recipe::{Recipe, Scene};
use sheetlight::settings::{Fan, Filter, Hdr, Scheimpflug, Shape, SpeckleLaw};
use sheetlight::specimen::Specimen;

/// Profiles of one band.
const PROFILES: usize = 64;

/// An effect: its name, and the change that switches it on.
type Effect = (&'static str, fn(&mut Scene));

/// Every effect.
const EFFECTS: &[Effect] = &[
    ("none", |_| ()),
    ("laser: cylindrical fan", |s| s.line.fan = Fan::Cylindrical),
    ("laser: ripple", |s| s.bench.laser.fan_ripple = 0.1),
    ("laser: narrow line", |s| s.bench.laser.waist_mm = 0.03),
    ("laser: slit of 0.3 mm", |s| s.line.shape = Shape::Slit),
    ("laser: texture", |s| s.line.shape = Shape::Texture),
    ("laser: point", |s| s.line.shape = Shape::Point),
    ("laser: second line", |s| s.bench.laser.second_line_mm = 3.0),
    ("laser: smile", |s| s.bench.laser.smile_um = 30.0),
    ("laser: lobes", |s| s.bench.laser.lobe_share = 0.02),
    ("laser: skirt", |s| s.bench.laser.skirt_share = 0.02),
    ("laser: width jitter", |s| s.bench.laser.width_jitter = 0.05),
    ("laser: streaks", |s| s.bench.laser.streaks_per_mm = 1.0),
    ("camera: out of focus", |s| s.bench.optics.scheimpflug = Scheimpflug::Given),
    ("camera: distortion", |s| s.bench.camera.distortion_k1 = -0.06),
    ("camera: vignetting and filter", |s| {
        (s.bench.camera.vignetting, s.bench.optics.filter) = (0.2, Filter::BandPass);
    }),
    ("camera: ambient light", |s| s.bench.camera.ambient_w_per_m2_nm = 0.01),
    ("camera: motion blur", |s| s.bench.motion.line_rate_hz = 0.5e6 / s.bench.exposure.time_us),
    // The recipe has pixels that differ.
    ("sensor: pixels alike", alike),
    ("sensor: PRNU alone", |s| {
        alike(s);
        s.bench.exposure.prnu = 0.01;
    }),
    ("sensor: DSNU alone", |s| {
        alike(s);
        s.bench.exposure.dsnu_dn = 0.25;
    }),
    ("sensor: column pattern alone", |s| {
        alike(s);
        s.bench.exposure.column_pattern_dn = 0.1;
    }),
    ("sensor: blooming", |s| s.bench.exposure.blooming = 0.5),
    ("sensor: two slopes", |s| s.readout.hdr = Hdr::Medium),
    ("sensor: 12 bits", |s| s.readout.bits = 12),
    ("speckle: none", |s| s.bench.speckle.strength = 0.0),
    ("speckle: the thesis' law", |s| s.speckle_law = SpeckleLaw::Rayleigh),
    ("speckle: depolarised", |s| s.bench.speckle.surface_patterns = 2.0),
    ("motion: encoder jitter", |s| s.bench.motion.encoder_jitter_um = 5.0),
    ("motion: wow", |s| s.bench.motion.wow_um = 50.0),
];

fn alike(scene: &mut Scene) {
    let exposure = &mut scene.bench.exposure;
    (exposure.prnu, exposure.dsnu_dn, exposure.column_pattern_dn) = (0.0, 0.0, 0.0);
}

/// A board with one effect under the bench.
struct Set {
    scene: Scene,
    sensor: Sensor,
    specimen: Specimen,
}

impl Set {
    fn new(name: &str) -> Self {
        let recipe = Recipe::load("wood.yaml").expect("the embedded recipe loads");
        let mut scene = recipe.draw(0, 0);
        let (_, change) = EFFECTS.iter().find(|(known, _)| *known == name).expect("a name of the table");
        change(&mut scene);
        let (sensor, specimen) = pipeline::set_up(&scene, pipeline::body(&scene), &PatternCache::new(0));
        Self { scene, sensor, specimen }
    }

    fn band(&self) -> Band {
        self.sensor.band(&self.specimen, 1500..1500 + PROFILES, Band::default())
    }
}

fn names() -> impl Iterator<Item = &'static str> {
    EFFECTS.iter().map(|(name, _)| *name)
}

fn main() {
    divan::main();
}

/// Light of the rows that a band needs, a profile.
#[divan::bench(args = names())]
fn rows(bencher: Bencher, name: &str) {
    let set = Set::new(name);
    bencher.counter(ItemsCount::new(PROFILES)).bench(|| set.band());
}

/// Exposure without extraction.
#[divan::bench(args = names())]
fn expose(bencher: Bencher, name: &str) {
    let set = Set::new(name);
    let band = set.band();
    let mut offsets = vec![Vec::new(); PROFILES];
    for (place, profile) in band.profiles.clone().enumerate() {
        set.sensor.row_offsets(profile, &mut offsets[place]);
    }
    bencher.counter(ItemsCount::new(PROFILES)).bench(|| {
        let (mut scratch, mut frames) = (Scratch::default(), <[Frame; 2]>::default());
        for tile in 0..set.scene.size.columns / TILE {
            for (place, profile) in band.profiles.clone().enumerate() {
                set.sensor.expose(&band, profile, tile, &offsets[place], &mut scratch, &mut frames);
                black_box(&frames);
            }
        }
    });
}
