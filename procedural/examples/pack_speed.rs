//! Measures how long packs take to form, and surface and matter at a point.
//!
//! `cargo run --release -p procedural --example pack_speed`

use std::hint::black_box;
use std::time::Instant;

use procedural::Stream;
use procedural::blister::{Blister, Pack};

/// Distance of samples along the laser line [mm].
const STEP_X_MM: f32 = 0.03;
/// Distance of profiles [mm].
const STEP_Y_MM: f32 = 0.2;

fn main() {
    for (name, shape, length, width, defects) in [
        ("round", 0.0, 11.0, 11.0, 0.0),
        ("oval", 0.0, 14.0, 8.0, 0.0),
        ("capsules", 2.0, 15.0, 6.0, 0.0),
        ("defects", 0.0, 11.0, 11.0, 1.0),
    ] {
        let mut blister =
            Blister::from_values(&mut |p| if p.group == "defects" && p.integer { defects } else { p.default });
        blister.tablet.shape = shape;
        blister.tablet.length_mm = length;
        blister.tablet.width_mm = width;
        let start = Instant::now();
        let pack = Pack::form(Stream::root(1), &blister);
        let form = start.elapsed().as_micros();
        let start = Instant::now();
        let corners = pack.hull().positions.len();
        let hull = start.elapsed().as_micros();
        let (low, high) = pack.bounds();
        let count = ((high.x - low.x) / STEP_X_MM) as usize;
        let profiles = ((high.y - low.y) / STEP_Y_MM) as usize;
        let points = (count * profiles) as f64;
        let places = || (0..profiles).map(|j| low.y + j as f32 * STEP_Y_MM);
        let (mut sum, start) = (0.0, Instant::now());
        for y in places() {
            let slice = pack.slice(y);
            for i in 0..count {
                sum += slice.surface(low.x + i as f32 * STEP_X_MM).map_or(0.0, |s| s.z + s.slope_x + s.slope_y);
            }
        }
        let surface = start.elapsed().as_nanos() as f64 / points;
        let start = Instant::now();
        for y in places() {
            let slice = pack.slice(y);
            for i in 0..count {
                let matter = slice.matter(low.x + i as f32 * STEP_X_MM);
                sum += matter.medium.mu_a + matter.film.map_or(0.0, |film| film.thickness_mm);
            }
        }
        let matter = start.elapsed().as_nanos() as f64 / points;
        black_box(sum);
        println!(
            "{name}: form {form} us, hull of {corners} corners {hull} us, surface {surface:.0} ns, matter {matter:.0} ns"
        );
    }
}
