//! Photons a second of the reference on one core: a slab of Henyey and Greenstein's law, clear wood, and a plate of
//! clear wood walked as a body. `make bench` prints it; docs/theory/performance.md reads it.

use base::{Body, Medium};
use divan::Bencher;
use divan::counter::ItemsCount;
use glam::DVec3;
use procedural::flat::Flat;
use rayon::{ThreadPool, ThreadPoolBuilder};
use reference::path::line_response::line_response_with_balance;
use reference::path::{Effort, solve};
use transport::answer::Question;
use transport::line::LineSource;
use transport::stack::{Scattering, Stack};

const CLEAR: Medium = Medium::CLEAR_WOOD;

fn main() {
    divan::main();
}

fn one_core() -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(1).build().expect("a thread starts")
}

fn layers(bencher: Bencher, stack: &Stack, photons: u64) {
    let (pool, effort) = (one_core(), Effort { photons, seed: 0 });
    let question = Question { cells: 0, ..Question::default() };
    bencher.counter(ItemsCount::new(effort.walked())).bench(|| pool.install(|| solve(stack, &question, effort)));
}

/// Van de Hulst's slab: tau 2, albedo 0.9, g 0.75; the bar is 2 million photons a second.
#[divan::bench(sample_count = 5, sample_size = 1)]
fn slab(bencher: Bencher) {
    layers(bencher, &Stack::slab(0.2, 1.0, 1.0, Scattering::Isotropic { mu_s: 9.0, g: 0.75 }), 1_280_000);
}

/// Clear wood, half space.
#[divan::bench(sample_count = 5, sample_size = 1)]
fn clear_wood(bencher: Bencher) {
    layers(bencher, &Stack::from(&CLEAR), 64_000);
}

/// Clear wood as a body: a flat plate, 15 mm thick, one column of light.
#[divan::bench(sample_count = 5, sample_size = 1)]
fn plate(bencher: Bencher) {
    let flat = Flat { height_mm: 15.0, slope_x: 0.0, slope_y: 0.0, width_mm: 100.0, length_mm: 60.0, medium: CLEAR };
    let (body, view): (_, DVec3) = (Body::new(flat), Question::default().view);
    let (x, power) = ([-20.0, 0.0, 20.0], [0.0, 1.0, 0.0]);
    let line = LineSource { body: &body, y: 30.0, line_mm: 0.05, x: &x, power: &power, view, row_mm: 0.1, rows: 40 };
    let (pool, effort) = (one_core(), Effort { photons: 12_800, seed: 0 });
    bencher
        .counter(ItemsCount::new(effort.walked()))
        .bench(|| pool.install(|| line_response_with_balance(&line, effort)));
}
