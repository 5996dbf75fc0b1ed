//! Profiles a second on the recipe of the full scan, 2560 columns, every effect on, one core: the light of the rows,
//! exposure and extraction apart and together. `make bench` prints it; docs/theory/performance.md reads it.

use base::Body;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use optical_bench::settings::{Extraction, PeakChoice, PeakMethod, RangeForm, SearchDirection};
use procedural::blister::{Blister, Pack};
use recipe::{Recipe, Scene};
use scanner::extract::{MeasuredProfile, extract};
use scanner::frame::{Calibration, Frame};
use scanner::optics::speckle::PatternCache;
use scanner::optics::{Band, Scratch, Sensor, TILE, TileOfProfile};
use scanner::specimen::Specimen;

/// Profiles of one band.
const PROFILES: usize = 64;

struct BoardUnderBench {
    scene: Scene,
    sensor: Sensor,
    calibration: Calibration,
    specimen: Specimen,
    start: usize,
}

impl BoardUnderBench {
    /// The first board with knots, `across` the middle of it.
    fn new() -> Self {
        let recipe = Recipe::load("wood.yaml").expect("the embedded recipe loads");
        let scene = (0..)
            .map(|i| recipe.draw(0, i))
            .find(|s| s.plan.wood().is_some_and(|wood| wood.knots.sound_count >= 2.0))
            .expect("some board has knots");
        let (sensor, specimen) = pipeline::set_up(&scene, pipeline::body(&scene), &PatternCache::new(0));
        let calibration = sensor.calibration();
        Self { scene, sensor, calibration, specimen, start: 1500 }
    }

    fn band(&self) -> Band {
        self.sensor.band(&self.specimen, self.start..self.start + PROFILES)
    }

    fn expose(&self, band: &Band, read: bool) {
        let columns = self.scene.size.columns;
        let (mut scratch, mut frames) = (Scratch::default(), <[Frame; 2]>::default());
        let (mut range, mut reflectance, mut scatter) = ([0.0; TILE], [0.0; TILE], [0.0; TILE]);
        let mut offsets = vec![Vec::new(); PROFILES];
        for (place, profile) in band.profiles.clone().enumerate() {
            self.sensor.row_offsets(profile, &mut offsets[place]);
        }
        for tile in 0..columns / TILE {
            for (place, profile) in band.profiles.clone().enumerate() {
                self.sensor.expose(
                    &TileOfProfile { band, profile, tile, offsets: &offsets[place] },
                    &mut scratch,
                    &mut frames,
                );
                if read {
                    let mut out =
                        MeasuredProfile { range: &mut range, reflectance: &mut reflectance, scatter: &mut scatter };
                    extract(&frames, &self.calibration, &self.scene.extraction, &mut out);
                }
                black_box((&frames, &range, &scatter));
            }
        }
    }
}

fn main() {
    divan::main();
}

/// Matter, geometry and line spread of the rows (halo included, as two neighbouring bands pay for it: 64 + 66 rows for
/// 64 profiles).
#[divan::bench]
fn rows(bencher: Bencher) {
    let bench = BoardUnderBench::new();
    let rows = PROFILES + bench.sensor.halo().iter().sum::<usize>();
    bencher.counter(ItemsCount::new(rows)).bench(|| bench.band());
}

/// Exposure alone.
#[divan::bench]
fn expose(bencher: Bencher) {
    let bench = BoardUnderBench::new();
    let band = bench.band();
    bencher.counter(ItemsCount::new(PROFILES)).bench(|| bench.expose(&band, false));
}

/// Exposure and extraction.
#[divan::bench]
fn expose_and_extract(bencher: Bencher) {
    let bench = BoardUnderBench::new();
    let band = bench.band();
    bencher.counter(ItemsCount::new(PROFILES)).bench(|| bench.expose(&band, true));
}

/// A way of extraction whose cost is measured.
struct Reading {
    name: &'static str,
    /// Changes the settings of the recipe.
    change: fn(&mut Extraction),
}

/// Every way; the first is the recipe's own.
const READINGS: [Reading; 7] = [
    Reading { name: "centre of gravity", change: |_| () },
    Reading { name: "reverse", change: |e| e.direction = SearchDirection::Reverse },
    Reading { name: "first", change: |e| e.peak = PeakChoice::First },
    Reading { name: "uncalibrated", change: |e| e.range = RangeForm::Uncalibrated },
    Reading { name: "gaussian", change: |e| e.method = PeakMethod::Gaussian },
    Reading { name: "blais_rioux 4", change: |e| e.method = PeakMethod::BlaisRioux { order: 4 } },
    Reading { name: "fir 5", change: |e| e.method = PeakMethod::Fir { length: 5 } },
];

/// Extraction alone, of frames that were exposed before.
#[divan::bench(args = READINGS.iter().map(|reading| reading.name))]
fn read(bencher: Bencher, name: &str) {
    let bench = BoardUnderBench::new();
    let band = bench.band();
    let reading = READINGS.iter().find(|reading| reading.name == name).expect("a name of the table");
    let mut settings = bench.scene.extraction;
    (reading.change)(&mut settings);
    let (mut scratch, mut offsets) = (Scratch::default(), Vec::new());
    let mut frames = Vec::new();
    for tile in 0..bench.scene.size.columns / TILE {
        let mut pair = <[Frame; 2]>::default();
        bench.sensor.row_offsets(bench.start, &mut offsets);
        bench.sensor.expose(
            &TileOfProfile { band: &band, profile: bench.start, tile, offsets: &offsets },
            &mut scratch,
            &mut pair,
        );
        frames.push(pair);
    }
    let (mut range, mut reflectance, mut scatter) = ([0.0; TILE], [0.0; TILE], [0.0; TILE]);
    bencher.counter(ItemsCount::new(1usize)).bench_local(|| {
        for pair in &frames {
            let mut out = MeasuredProfile { range: &mut range, reflectance: &mut reflectance, scatter: &mut scatter };
            extract(black_box(pair), &bench.calibration, &settings, &mut out);
        }
        black_box((&range, &scatter));
    });
}

/// The whole scan of one sample as `gen` renders it, on all cores: the figure to quote.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn sample(bencher: Bencher) {
    let bench = BoardUnderBench::new();
    let patterns = PatternCache::new(0);
    bencher
        .counter(ItemsCount::new(bench.scene.size.profiles))
        .bench(|| pipeline::render(&bench.scene, &patterns, &|_| ()));
}

/// A thousand profiles of a blister pack of the declared defaults on the same bench, filled and clear, on all cores: to
/// be held against `sample`.
#[divan::bench(args = [12.0, 0.01], sample_count = 3, sample_size = 1)]
fn pack(bencher: Bencher, film_sigma_per_mm: f64) {
    let mut scene = BoardUnderBench::new().scene;
    scene.size.profiles = 1000;
    let mut blister = Blister::from_values(&mut |parameter| parameter.default);
    blister.web.sigma_per_mm = film_sigma_per_mm;
    let body = Body::new(Pack::form(scene.stream.child("pack"), &blister));
    let patterns = PatternCache::new(0);
    bencher
        .counter(ItemsCount::new(scene.size.profiles))
        .bench(|| pipeline::render_body(&scene, body.clone(), &patterns, &|_| ()));
}
