//! Scale of Range: what its whole numbers mean, and the grid of a rectified scan.

use optical_bench::settings::RangeForm;
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

/// Largest number of a height. Readers that take 16-bit PNG for signed numbers (torchvision, old versions of PIL and of
/// many programs for pictures) see what is above as negative; 32767 steps over all that the sensor sees are finer than
/// its sixteenths of rows.
const MOST: f64 = 32767.0;

/// What the whole numbers of Range of a scene under a rig mean, of which 0 is missing: Range of the number 0, and of
/// one step [mm or px].
pub(super) fn range_scale(scene: &Scene, rig: &Rig) -> [f64; 2] {
    let rows = scene.size.rows as f64;
    if scene.extraction.range == RangeForm::Uncalibrated {
        // A step of the extraction, as the camera has it, up to 16 bits; or the finest of 15 bits where it gives none.
        let asked = f64::from(scene.extraction.subpixel_steps);
        let finest = |most: f64| (most / rows).floor();
        let steps = if asked > 0.0 { asked.min(finest(65535.0)) } else { finest(MOST) };
        return [0.0, 1.0 / steps];
    }
    // The sensor's whole height.
    let (low, high) = rig.heights(scene.size.columns, scene.size.rows);
    let scale = (high - low) / (MOST - 1.0);
    [low - scale, scale]
}
