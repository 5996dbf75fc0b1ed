//! Cost of each effect of the instrument: rows and exposure of a full scan with one effect more, one core, to be held
//! against `none`. The effects are those of the recipe's keys: each word of a setting of the instrument that is not its
//! default, and each number that is 0 by default, a twentieth of the most that it may be.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use recipe::{Recipe, Scene};
use scanner::frame::Frame;
use scanner::optics::speckle::PatternCache;
use scanner::optics::{Band, Scratch, Sensor, TILE, TileOfProfile};
use scanner::specimen::Specimen;

/// Profiles of one band.
const PROFILES: usize = 64;
/// A board under the bench at its defaults.
const RECIPE: &str = "name: effects\nsubject: wood\nunstated: fixed\nclasses: {one: {share: 1}}\nset:";
/// Sections of the instrument.
const SECTIONS: [&str; 5] = ["motion", "laser", "camera", "exposure", "speckle"];

/// The recipe with an effect, as `KEY: VALUE`; `None` where it has none on a board.
fn recipe_with(effect: &str) -> Option<Recipe> {
    let set = if effect == "none" { String::new() } else { format!("\n  {effect}") };
    Recipe::parse("effects.yaml", &format!("{RECIPE}{set}\n")).ok()
}

/// Every effect.
fn effects() -> Vec<String> {
    let schema = recipe::schema();
    let mut effects = vec!["none".to_owned()];
    for section in SECTIONS {
        let keys = schema["properties"][section]["properties"].as_object().expect("a section has keys");
        for (key, said) in keys {
            let values = match said["enum"].as_array() {
                Some(words) => words.iter().filter(|word| **word != said["default"]).cloned().collect(),
                None if said["default"] == 0.0 => {
                    let most = said["oneOf"][0]["maximum"].as_f64();
                    most.map(|most| serde_json::json!(0.05 * most)).into_iter().collect()
                }
                None => Vec::new(),
            };
            effects.extend(values.iter().map(|value| format!("{section}.{key}: {value}")));
        }
    }
    effects.retain(|effect| recipe_with(effect).is_some());
    effects
}

/// A board with one effect under the bench.
struct BoardUnderBench {
    scene: Scene,
    sensor: Sensor,
    specimen: Specimen,
}

impl BoardUnderBench {
    fn new(name: &str) -> Self {
        let scene = recipe_with(name).expect("one of the effects").draw(0, 0);
        let (sensor, specimen) = pipeline::set_up(&scene, pipeline::body(&scene), &PatternCache::new(0));
        Self { scene, sensor, specimen }
    }

    fn band(&self) -> Band {
        self.sensor.band(&self.specimen, 1500..1500 + PROFILES)
    }
}

fn main() {
    divan::main();
}

/// Light of the rows that a band needs, a profile.
#[divan::bench(args = effects())]
fn rows(bencher: Bencher, name: &str) {
    let board = BoardUnderBench::new(name);
    bencher.counter(ItemsCount::new(PROFILES)).bench(|| board.band());
}

/// Exposure without extraction.
#[divan::bench(args = effects())]
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
