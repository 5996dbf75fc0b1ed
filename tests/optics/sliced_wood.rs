//! Boards out of stacks of slices, rendered: what is dense is dark where it lies.

use std::sync::Arc;

use base::{Class, Medium};
use dataset::record::Record;
use optical_bench::settings::Transport;
use pipeline::Equipment;
use procedural::wood::Media;
use recipe::{Plan, Recipe, Scene, WoodVolume};
use scanner::extract::scatter_pixels;
use test_support::target::{nominal, patterns};
use wood_picture::{DensityLaw, DensityStack, FibreAxis, HalfSpace, KindDensities};

/// Densities of the two kinds of wood.
const KINDS: KindDensities = KindDensities { earlywood: 320.0, latewood: 800.0 };
/// Side of a voxel [mm].
const VOXEL_MM: f32 = 0.2;
/// The dense part, from the board's left side and from its near end [mm].
const SLAB_MM: [f32; 2] = [6.0, 9.0];

/// 12 x 12 x 4 mm of wood whose density is asked by the voxel: from slice to slice, down, across.
fn wood(density: impl Fn([usize; 3]) -> f32) -> Arc<WoodVolume> {
    let mut stack = DensityStack::new([60, 20, 60], [VOXEL_MM; 3], FibreAxis::Through).expect("room");
    for slice in 0..60 {
        stack.push(&(0..20 * 60).map(|i| density([slice, i / 60, i % 60])).collect::<Vec<f32>>());
    }
    Arc::new(stack.finish(KINDS).expect("wood"))
}

/// Wood of 400 kg/m3 with a slab of 800 across an axis of the stack.
fn slab(axis: usize) -> Arc<WoodVolume> {
    let lies = |voxel: [usize; 3]| (SLAB_MM[0]..SLAB_MM[1] - 0.01).contains(&(voxel[axis] as f32 * VOXEL_MM));
    wood(|voxel| if lies(voxel) { 800.0 } else { 400.0 })
}

/// A board as large as the wood, in a quiet scan without gloss.
fn scene(wood: Arc<WoodVolume>) -> Scene {
    let mut scene = Recipe::load("wood-slices.yaml").expect("the embedded recipe loads").draw(0, 0);
    let mut numbers = *scene.plan.wood().expect("a board");
    let board = &mut numbers.board;
    (board.width_mm, board.length_mm, board.thickness_mm, board.lead_in_mm) = (12.0, 12.0, 4.0, 4.0);
    (board.cup_mm, board.twist_deg, board.saw_ripple_um, board.roughness_um) = (0.0, 0.0, 0.0, 0.0);
    numbers.cracks.check_count = 0.0;
    numbers.media.gloss = 0.0;
    numbers.media.earlywood_mu_a_per_mm = 0.08;
    let place = &mut numbers.slices;
    (place.quarter_turns, place.mirrored, place.turned) = (0.0, 0.0, 0.0);
    let step_mm = scene.bench.motion.step_mm;
    scene.bench = nominal();
    scene.bench.motion.step_mm = step_mm;
    scene.bench.speckle.strength = 0.0;
    scene.size.profiles = 200;
    scene.slices = Some(wood);
    scene.plan = Plan::Wood(numbers);
    scene
}

/// Mean of Scatter over the board's inner half along one axis of the image, by place along the other, with where the
/// board begins and ends there [pixel].
fn means(record: &Record, down: bool) -> (Vec<f64>, [usize; 2]) {
    let [rows, cols] = [record.rows, record.cols];
    let pixel = |i: usize, j: usize| if down { i * cols + j } else { j * cols + i };
    let [count, others] = if down { [rows, cols] } else { [cols, rows] };
    let is_wood = |i: usize, j: usize| record.labels.class[pixel(i, j)] == Class::Clear as u8;
    let ends = |count: usize, is: &dyn Fn(usize) -> bool| {
        let first = (0..count).find(|i| is(*i)).expect("a board");
        [first, (0..count).rfind(|i| is(*i)).expect("a board") + 1]
    };
    let own = ends(count, &|i| is_wood(i, others / 2));
    let [near, far] = ends(others, &|j| is_wood((own[0] + own[1]) / 2, j));
    let inner = near + (far - near) / 4..far - (far - near) / 4;
    let mean =
        |i: usize| inner.clone().map(|j| f64::from(record.maps.scatter[pixel(i, j)])).sum::<f64>() / inner.len() as f64;
    ((0..count).map(mean).collect(), own)
}

/// Diffuse reflectance of a half space of wood of a density, by the law and the closed form [1].
fn reflectance(density: f32) -> f64 {
    let media = Media::from_values(&mut |parameter| parameter.default);
    let [mu_a, sigma_i, k] = DensityLaw::new(&media, KINDS).at(density);
    HalfSpace::new(&Medium { sigma_i, k, ..Medium::CLEAR_WOOD }, 0.0).reflectance(f64::from(mu_a))
}

/// A slab of twice the density absorbs twice as much: a darker band, by the ratio of the reflectances within 5 %, whose
/// sides (half of the way from bright to dark) are the slab's within a quarter of a millimetre, across the fibres and
/// along them.
#[test]
fn a_dense_slab_is_a_dark_band_where_it_lies() {
    for (axis, down) in [(2, false), (0, true)] {
        let scene = scene(slab(axis));
        let record = pipeline::render(&scene, patterns(), &|_| ());
        let (means, [first, last]) = means(&record, down);
        let at = |mm: f32| first + (mm / 12.0 * (last - first) as f32) as usize;
        let none = scatter_pixels(&scene.extraction) as f64 * scene.bench.exposure.dark_level_dn;
        let level =
            |range: std::ops::Range<usize>| means[range.clone()].iter().sum::<f64>() / range.len() as f64 - none;
        let (bright, dark) = (level(at(2.0)..at(4.0)), level(at(7.0)..at(8.0)));
        let half = none + 0.5 * (bright + dark);
        let inner = at(2.0)..at(11.0);
        let begins = inner.clone().find(|i| means[*i] < half).expect("a band");
        let ends = inner.clone().rfind(|i| means[*i] < half).expect("a band") + 1;
        let place = |i: usize| 12.0 * (i - first) as f32 / (last - first) as f32;
        let wanted = reflectance(800.0) / reflectance(400.0);
        println!(
            "down {down}: {bright:.1} and {dark:.1} DN, {:.3} of it, by reflectance {wanted:.3}, from {:.2} to {:.2} \
                mm",
            dark / bright,
            place(begins),
            place(ends)
        );
        assert!((dark / bright / wanted - 1.0).abs() < 0.05, "{dark} and {bright}");
        assert!((place(begins) - SLAB_MM[0]).abs() < 0.25 && (place(ends) - SLAB_MM[1]).abs() < 0.25);
    }
}

/// What absorbs 0.3 mm below the face takes light where photons are followed through the volume; the kernel asks the
/// face alone.
#[test]
#[ignore = "long"]
fn what_lies_below_the_face_counts_with_path() {
    let light = |transport, deep: f32| {
        // It varies a little, as wood must.
        let face = |voxel: [usize; 3]| if voxel[2].is_multiple_of(2) { 321.0 } else { 329.0 };
        let mut scene = scene(wood(|voxel| face(voxel) + if voxel[1] < 2 { 0.0 } else { deep }));
        let mut numbers = *scene.plan.wood().expect("a board");
        let media = &mut numbers.media;
        (media.latewood_mu_a_ratio, media.latewood_sigma_i_ratio, media.latewood_k_ratio) = (20.0, 1.0, 1.0);
        scene.plan = Plan::Wood(numbers);
        (scene.transport, scene.size.profiles, scene.bench.motion.step_mm) = (transport, 5, 2.0);
        let equipment = Equipment { patterns: patterns(), line_solvers: reference::line_solver };
        let record = pipeline::render(&scene, equipment, &|_| ());
        let none = scatter_pixels(&scene.extraction) as f64 * scene.bench.exposure.dark_level_dn;
        let inner = 3 * record.cols + record.cols * 2 / 5..3 * record.cols + record.cols * 3 / 5;
        inner.clone().map(|i| f64::from(record.maps.scatter[i])).sum::<f64>() / inner.len() as f64 - none
    };
    let [kernel, path] = [Transport::Kernel, Transport::Path { photons: 100_000 }]
        .map(|transport| light(transport, 475.0) / light(transport, 0.0));
    println!("light over wood that is dense below: {kernel:.4} by the kernel, {path:.4} by path");
    assert!((kernel - 1.0).abs() < 1.0e-9 && path < 0.95, "{kernel} and {path}");
}
