//! What of a sample follows from its scene without any light: bench, effective physics, the body's own instances, and what
//! the label image shows in some rows.

use std::collections::BTreeSet;

use procedural::{Class, Instance};

use super::{Scan, body, grid, set_up};
use crate::labels::{self, Binning};
use bench::settings::Movement;
use dataset::record::{Labels, Maps, Record, TrueRow};
use recipe::Scene;
use scanner::optics::Sensor;
use scanner::optics::speckle::PatternCache;
use scanner::specimen::{Hit, Specimen, height_below};

/// Rows that are made again wherever instances lie, evenly spread.
const EVENLY_SPREAD_ROWS: usize = 4;
/// Most rows through the middles of instances.
const MAX_MIDDLE_ROWS: usize = 20;

/// What of a sample follows without light.
#[derive(Debug)]
pub struct Unlit {
    /// A record whose maps hold nothing.
    pub record: Record,
    /// Every instance of its body.
    pub instances: Vec<Instance>,
    /// Rows through the middles of instances, and a few others; by rising row.
    pub rows: Vec<TrueRow>,
}

/// What of a sample follows without light.
pub fn unlit(scene: &Scene, tiles: &PatternCache) -> Unlit {
    // What stays with single pixels is drawn for each of them, and nothing here asks for it.
    let mut even = scene.clone();
    let exposure = &mut even.bench.exposure;
    (exposure.prnu, exposure.dsnu_dn, exposure.column_pattern_dn, exposure.defect_share) = (0.0, 0.0, 0.0, 0.0);
    let (sensor, specimen) = set_up(&even, body(scene), tiles);
    let scan = Scan { maps: Maps::default(), labels: Labels::default(), truth: None, stack: Vec::new() };
    let instances = specimen.body().instances().to_vec();
    let rows = chosen(scene, &instances).into_iter().map(|row| true_row(scene, &sensor, &specimen, row)).collect();
    Unlit { record: scan.record(scene, &sensor, &specimen), instances, rows }
}

/// Rows of the image to make again.
fn chosen(scene: &Scene, instances: &[Instance]) -> BTreeSet<usize> {
    let rows = scene.size.profiles / scene.output.bin_profiles;
    let mut chosen: BTreeSet<usize> =
        (0..EVENLY_SPREAD_ROWS).map(|k| (2 * k + 1) * rows / (2 * EVENLY_SPREAD_ROWS)).collect();
    // On a turntable the row of a place is another in each column.
    if scene.movement == Movement::Linear {
        let place = |y: f64| (y / scene.bench.motion.step_mm).round();
        let profiles = instances.iter().map(|instance| place(instance.y_mm));
        let inside = profiles.filter(|profile| (0.0..scene.size.profiles as f64).contains(profile));
        let middles: Vec<usize> = inside.map(|profile| profile as usize / scene.output.bin_profiles).collect();
        chosen.extend(middles.iter().step_by(middles.len().div_ceil(MAX_MIDDLE_ROWS).max(1)));
    }
    chosen.retain(|&row| row < rows);
    chosen
}

/// One row, binned as the image is.
fn true_row(scene: &Scene, sensor: &Sensor, specimen: &Specimen, row: usize) -> TrueRow {
    let (cols, columns, profiles) = (scene.size.columns, scene.output.bin_columns, scene.output.bin_profiles);
    let grid = grid(scene, &sensor.camera().rig);
    let mut labels = Labels { class: vec![0; cols * profiles], instance: vec![0; cols * profiles] };
    let [mut height, mut below] = [const { Vec::new() }; 2];
    let mut hits = Vec::new();
    for (place, profile) in (row * profiles..(row + 1) * profiles).enumerate() {
        sensor.hits(specimen, profile, &mut hits);
        if let Some(grid) = &grid {
            hits = labels::on_grid(&hits, grid.first_mm, grid.pitch_mm);
        }
        let line = place * cols..(place + 1) * cols;
        labels::label_row(&hits, &mut labels.class[line.clone()], &mut labels.instance[line]);
        let known = |hit: &Hit, z: f32| if hit.matter.class == Class::Background { f32::NAN } else { z };
        height.extend(hits.iter().map(|hit| known(hit, hit.surface.z)));
        let lower = |hit: &Hit| hit.matter.film.as_ref().map_or(hit.surface.z, |film| height_below(&hit.surface, film));
        below.extend(hits.iter().map(|hit| known(hit, lower(hit))));
    }
    let binning = Binning { cols, columns, rows: profiles };
    let mean = |map: Vec<f32>| binning.mean(map, f32::NAN, |z| !z.is_nan());
    let Labels { class, instance } = binning.labels(labels);
    TrueRow { row, class, instance, height: mean(height), below: mean(below) }
}
