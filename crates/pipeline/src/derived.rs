//! What of a sample follows from its scene without rendering it whole: without any light bench, effective physics, the
//! body's own instances, and what the label image shows in some rows; with light the rows that are asked for.

use std::collections::BTreeSet;

use super::exposed_rows::{expose_frames, exposed_rows};
use super::{Equipment, Scan, binning, body, grid, set_up, truth_maps, truth_row};
use crate::labels;
use base::{Class, Instance};
use dataset::record::{AskedRows, DerivedSample, Labels, Maps, StackFrame, TrueRow};
use optical_bench::settings::Movement;
use recipe::Scene;
use scanner::optics::Sensor;
use scanner::specimen::{Hit, Specimen, height_below};

/// Rows that are made again wherever instances lie, evenly spread.
const EVENLY_SPREAD_ROWS: usize = 4;
/// Most rows through the middles of instances.
const MAX_MIDDLE_ROWS: usize = 20;
/// Part of an instance's diameter, to each side of its middle, in which a row surely meets it [1].
const CORE: f64 = 0.2;

/// What of a sample follows without light, and the rows and frames `asked`: to the bit those of [`super::render`].
/// Frames go to `take_frame` as they are made, in any order.
pub fn derived<'a>(
    scene: &Scene,
    by: impl Into<Equipment<'a>>,
    asked: &AskedRows,
    take_frame: &(dyn Fn(StackFrame) + Sync),
) -> DerivedSample {
    let (sensor, specimen) = set_up(scene, body(scene), by);
    let exposed = exposed_rows(scene, &sensor, &specimen, &asked.strips);
    expose_frames(scene, &sensor, &specimen, &asked.frames, take_frame);
    let scan = Scan { maps: Maps::default(), labels: Labels::default(), truth: None, stack: Vec::new() };
    let instances = specimen.body().instances().to_vec();
    let mut rows = chosen(scene, &instances);
    rows.extend(&asked.unlit);
    rows.retain(|&row| row < scene.size.profiles / scene.output.bin_profiles);
    let rows = rows.into_iter().map(|row| true_row(scene, &sensor, &specimen, row)).collect();
    DerivedSample { record: scan.record(scene, &sensor, &specimen), instances, rows, exposed }
}

/// Rows of the image to make again: some that are evenly spread, and through each instance one, as far as it is known
/// without light where these lie.
fn chosen(scene: &Scene, instances: &[Instance]) -> BTreeSet<usize> {
    let (profiles, bin) = (scene.size.profiles, scene.output.bin_profiles);
    let rows = profiles / bin;
    let mut chosen: BTreeSet<usize> =
        (0..EVENLY_SPREAD_ROWS).map(|k| (2 * k + 1) * rows / (2 * EVENLY_SPREAD_ROWS)).collect();
    // On a turntable the row of a place is another in each column.
    if scene.movement == Movement::Linear {
        let row = |y: f64| {
            let profile = (y / scene.bench.motion.step_mm).round().clamp(0.0, profiles.saturating_sub(1) as f64);
            profile as usize / bin
        };
        // Of others the largest extent says nothing of that along the scan.
        let is_round = |class| matches!(class, Class::SoundKnot | Class::DeadKnot | Class::Pocket);
        let reach = |own: &Instance| if is_round(own.class) { CORE * own.diameter_mm } else { 0.0 };
        // Of an instance that the first or the last row cuts, that row is the one nearest to its middle.
        let placed = instances.iter().filter(|own| own.y_mm.is_finite() && reach(own).is_finite());
        let cores = placed.map(|own| [own.y_mm - reach(own), own.y_mm, own.y_mm + reach(own)].map(row));
        let mut cores: Vec<[usize; 3]> = cores.collect();
        cores.sort_unstable_by_key(|core| core[2]);
        // Each row that is taken passes through as many as it can: the last one of the first to end.
        let (mut taken, mut open): (Vec<usize>, Vec<[usize; 3]>) = (Vec::new(), Vec::new());
        for core in cores {
            if open.iter().any(|first| core[0] > first[2]) {
                taken.extend(through(&open));
                open.clear();
            }
            open.push(core);
        }
        taken.extend(through(&open));
        chosen.extend(taken.iter().step_by(taken.len().div_ceil(MAX_MIDDLE_ROWS).max(1)));
    }
    chosen
}

/// A row through all of these instances, each with the first, middle and last row of its core: the middle of one of
/// them where that lies in all.
fn through(open: &[[usize; 3]]) -> Option<usize> {
    let (from, to) = (open.iter().map(|core| core[0]).max()?, open.iter().map(|core| core[2]).min()?);
    let middles = open.iter().map(|core| core[1]).filter(|middle| (from..=to).contains(middle));
    Some(middles.min_by_key(|middle| middle.abs_diff((from + to) / 2)).unwrap_or((from + to) / 2))
}

/// One row, binned as the image is.
fn true_row(scene: &Scene, sensor: &Sensor, specimen: &Specimen, row: usize) -> TrueRow {
    let (cols, profiles) = (scene.size.columns, scene.output.bin_profiles);
    let grid = grid(scene, &sensor.camera().rig);
    let mut labels = Labels { class: vec![0; cols * profiles], instance: vec![0; cols * profiles] };
    let mut truth = truth_maps(scene, cols * profiles);
    let mut lower = Vec::new();
    let mut hits = Vec::new();
    for (place, profile) in (row * profiles..(row + 1) * profiles).enumerate() {
        sensor.hits(specimen, profile, &mut hits);
        if let Some(grid) = &grid {
            hits = labels::on_grid(&hits, grid.first_mm, grid.pitch_mm);
        }
        let line = place * cols..(place + 1) * cols;
        labels::label_row(&hits, &mut labels.class[line.clone()], &mut labels.instance[line.clone()]);
        truth_row(scene, &hits, truth.maps_mut().into_iter().map(|map| &mut map[line.clone()]).collect());
        let below = |hit: &Hit| hit.matter.film.as_ref().map_or(hit.surface.z, |film| height_below(&hit.surface, film));
        lower.extend(hits.iter().map(|hit| if hit.matter.class == Class::Background { f32::NAN } else { below(hit) }));
    }
    let binning = binning(scene, &sensor.camera().rig);
    let Labels { class, instance } = binning.labels(labels);
    let (lower, truth) = (binning.mean_on_body(lower, &class), binning.truth(truth, &class));
    TrueRow { row, class, instance, truth, lower }
}
