//! Measures growing a board [us] and one `surface` and one `matter` of it [ns]: clear, with knots, with knots and rot.
//!
//! `cargo run --release -p procedural --example board_speed`

use std::hint::black_box;
use std::time::Instant;

use procedural::Stream;
use procedural::wood::Plank;
use procedural::wood::parameters::Wood;

/// Distance of samples along the laser line [mm].
const STEP_X_MM: f32 = 0.05;
/// Distance of profiles [mm].
const STEP_Y_MM: f32 = 0.7;

fn main() {
    for (name, sound, dead, reach) in
        [("clear", 0.0, 0.0, 0.0), ("4 knots", 2.0, 2.0, 0.0), ("4 knots, rot", 2.0, 2.0, 30.0)]
    {
        let mut wood = Wood::from_values(&mut |p| p.default);
        wood.knots.sound_count = sound;
        wood.knots.dead_count = dead;
        wood.rot.reach_mm = reach;
        let start = Instant::now();
        let plank = Plank::grow(Stream::root(1), &wood);
        let grow = start.elapsed().as_micros();
        let (low, high) = plank.bounds();
        let count = ((high.x - low.x) / STEP_X_MM) as usize;
        let profiles = ((high.y - low.y) / STEP_Y_MM) as usize;
        let points = (count * profiles) as f64;
        let places = || (0..profiles).map(|j| low.y + j as f32 * STEP_Y_MM);
        let (mut sum, start) = (0.0, Instant::now());
        for y in places() {
            let slice = plank.slice(y);
            for i in 0..count {
                sum += slice.surface(low.x + i as f32 * STEP_X_MM).map_or(0.0, |s| s.z + s.slope_x + s.slope_y);
            }
        }
        let surface = start.elapsed().as_nanos() as f64 / points;
        let start = Instant::now();
        for y in places() {
            let slice = plank.slice(y);
            for i in 0..count {
                let matter = slice.matter(low.x + i as f32 * STEP_X_MM, 22.0);
                sum += matter.medium.mu_a + matter.medium.k + matter.medium.fibre.z;
            }
        }
        let matter = start.elapsed().as_nanos() as f64 / points;
        black_box(sum);
        println!("{name}: grow {grow} us, surface {surface:.0} ns, matter {matter:.0} ns");
    }
}
