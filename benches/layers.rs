//! Cost of a surface point under a film in the kernel: a row of equal media, and one where each tablet differs.

use base::{Film, Gloss, Medium};
use divan::Bencher;
use divan::counter::ItemsCount;
use glam::Vec3;
use transport::kernel::film_stack::{FilmStack, FilmStackKernel};

/// Surface points of a row.
const POINTS: usize = 2560;

fn main() {
    divan::main();
}

fn row(bencher: Bencher, change: f32) {
    let medium = Medium::isotropic(0.02, 12.0, 1.53, Gloss::NONE);
    let stack = |i: usize| {
        let under = Medium::isotropic(0.005 + change * i as f32, 40.0, 1.5, Gloss::NONE);
        let film = Film {
            thickness_mm: 0.1 + 1e-5 * i as f32,
            gap_mm: Some(0.5),
            room_mm: [f32::INFINITY; 2],
            under,
            under_slope: [0.0; 2],
        };
        FilmStack {
            medium,
            film,
            enter: 0.95,
            view_up: 0.9,
            view: Vec3::new(0.0, -0.435_89, 0.9),
            light_up: 1.0,
            light: Vec3::Z,
            normal: Vec3::Z,
        }
    };
    let stacks: Vec<FilmStack> = (0..POINTS).map(stack).collect();
    let mut kernel = FilmStackKernel::new();
    bencher
        .counter(ItemsCount::new(POINTS))
        .bench_local(|| stacks.iter().map(|stack| kernel.spread(stack).below[0]).sum::<f32>());
}

/// Films of changing thickness over one kind of tablet.
#[divan::bench]
fn equal_media(bencher: Bencher) {
    row(bencher, 0.0);
}

/// Another tablet at each texel.
#[divan::bench]
fn unlike_media(bencher: Bencher) {
    row(bencher, 1e-7);
}
