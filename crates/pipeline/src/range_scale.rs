//! Scale of Range: what its whole numbers mean, heights on it, and the grid of a rectified scan.

use dataset::{range_numbers, range_values};
use optical_bench::settings::{MAX_RANGE_NUMBER, RangeForm};
use rayon::prelude::*;
use recipe::Scene;
use scanner::extract::RectifiedGrid;
use scanner::frame::Rig;

/// The grid of a rectified scan.
pub(super) fn grid(scene: &Scene, rig: &Rig) -> Option<RectifiedGrid> {
    match scene.extraction.range {
        RangeForm::Rectified { pitch_mm } => Some(RectifiedGrid::new(rig, scene.size.columns, pitch_mm)),
        RangeForm::Calibrated | RangeForm::Uncalibrated => None,
    }
}

/// What the whole numbers of Range of a scene under a rig mean, of which 0 is missing: Range of the number 0, and of
/// one step [mm or px].
pub(super) fn range_scale(scene: &Scene, rig: &Rig) -> [f64; 2] {
    let rows = scene.size.rows as f64;
    if scene.extraction.range == RangeForm::Uncalibrated {
        // A step of the extraction, as the camera has it, up to 16 bits; or the finest of 15 bits where it gives none.
        let asked = f64::from(scene.extraction.subpixel_steps);
        let finest = |most: f64| (most / rows).floor();
        let steps = if asked > 0.0 { asked.min(finest(65535.0)) } else { finest(f64::from(MAX_RANGE_NUMBER)) };
        return [0.0, 1.0 / steps];
    }
    // The sensor's whole height.
    let (low, high) = rig.heights(scene.size.columns, scene.size.rows);
    let scale = (high - low) / (f64::from(MAX_RANGE_NUMBER) - 1.0);
    [low - scale, scale]
}

/// Range as its whole numbers have it, as a camera gives it, where these are finer than the steps of the extraction:
/// images and maps are then the same.
pub(super) fn on_scale(scene: &Scene, rig: &Rig, range: &mut [f32]) {
    if !scene.output.range_is_whole(&scene.extraction, scene.size.rows) {
        return;
    }
    let [offset, scale] = range_scale(scene, rig);
    range.par_chunks_mut(scene.size.columns).for_each(|line| {
        let values = range_values(&range_numbers(line, offset, scale), offset, scale);
        line.copy_from_slice(&values);
    });
}
