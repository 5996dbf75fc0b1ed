//! What the fields of a board cost beside its rendering: surface and matter of every pixel that shows the board,
//! against rows, exposure and extraction of the same profiles, on one core. A whole board's fields are to stay under
//! half of its rendering; docs/theory/performance.md has the figures.

use base::Body;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use recipe::{Recipe, Scene};
use scanner::extract::MeasuredProfile;
use scanner::frame::Frame;
use scanner::optics::speckle::PatternCache;
use scanner::optics::{Scratch, Sensor, TILE, TileOfProfile};
use scanner::specimen::Specimen;

/// Profiles of one band.
const PROFILES: usize = 64;

/// Pixels of these recipes across the board [mm].
const COLUMN_MM: f32 = 0.0922;

/// A recipe and the class of samples of which the first board is taken.
const BOARDS: [(&str, &str); 8] = [
    ("wood", "clear"),
    ("wood", "mixed"),
    ("wood-grading", "sound_knot"),
    ("wood-grading", "crack"),
    ("wood-grading", "resin"),
    ("wood-grading", "pocket_rot"),
    ("wood-stem", "flat_sawn"),
    ("wood-stem", "quarter_sawn"),
];

struct BoardUnderBench {
    scene: Scene,
    body: Body,
    sensor: Sensor,
    specimen: Specimen,
}

impl BoardUnderBench {
    fn new(name: &str) -> Self {
        let (recipe, class) = name.split_once(' ').expect("a recipe and a class");
        let recipe = Recipe::load(recipe).expect("the embedded recipe loads");
        let scene =
            (0..).map(|i| recipe.draw(0, i)).find(|scene| scene.class == class).expect("some board of the class");
        let (sensor, specimen) = pipeline::set_up(&scene, pipeline::body(&scene), &PatternCache::new(0));
        Self { body: pipeline::body(&scene), scene, sensor, specimen }
    }

    /// The profiles in the middle of the scan.
    fn profiles(&self) -> std::ops::Range<usize> {
        let start = self.scene.size.profiles / 2;
        start..start + PROFILES
    }
}

fn names() -> impl Iterator<Item = String> {
    BOARDS.iter().map(|(recipe, class)| format!("{recipe} {class}"))
}

fn main() {
    divan::main();
}

/// Surface and matter at every column of the board's width, a profile.
#[divan::bench(args = names())]
fn fields(bencher: Bencher, name: &str) {
    let board = BoardUnderBench::new(name);
    let (low, high) = board.body.bounds();
    let middle = 0.5 * (low.y + high.y);
    bencher.counter(ItemsCount::new(PROFILES)).bench(|| {
        for row in 0..PROFILES {
            let slice = board.body.slice(middle + (row as f64 * board.scene.bench.motion.step_mm) as f32);
            let columns = ((high.x - low.x) / COLUMN_MM) as usize;
            for x in (0..columns).map(|column| low.x + (column as f32 + 0.5) * COLUMN_MM) {
                if let Some(surface) = slice.surface(x) {
                    black_box(slice.matter(x, surface.z));
                }
            }
        }
    });
}

/// Rows, exposure and extraction as a scan makes them, fields with them, a profile: in a band that follows another one.
#[divan::bench(args = names())]
fn render(bencher: Bencher, name: &str) {
    let board = BoardUnderBench::new(name);
    let (calibration, extraction) = (board.sensor.calibration(), &board.scene.extraction);
    let profiles = board.profiles();
    let before = profiles.start - PROFILES..profiles.start;
    let input = || {
        let mut bands = board.sensor.bands(&board.specimen);
        bands.make(before.clone());
        bands
    };
    bencher.counter(ItemsCount::new(PROFILES)).with_inputs(input).bench_values(|mut bands| {
        let band = bands.make(profiles.clone());
        let (mut scratch, mut frames) = (Scratch::default(), <[Frame; 2]>::default());
        let (mut range, mut reflectance, mut scatter) = ([0.0; TILE], [0.0; TILE], [0.0; TILE]);
        let mut offsets = vec![Vec::new(); PROFILES];
        for (place, profile) in band.profiles.clone().enumerate() {
            board.sensor.row_offsets(profile, &mut offsets[place]);
        }
        for tile in 0..board.scene.size.columns / TILE {
            for (place, profile) in band.profiles.clone().enumerate() {
                let part = TileOfProfile { band, profile, tile, offsets: &offsets[place] };
                let mut out =
                    MeasuredProfile { range: &mut range, reflectance: &mut reflectance, scatter: &mut scatter };
                board.sensor.measure(&part, &calibration, extraction, (&mut scratch, &mut frames), &mut out);
                black_box((&range, &reflectance, &scatter));
            }
        }
        bands
    });
}
