//! What the numbers of Range mean: the grid of a rectified scan, offset and scale.

use crate::extract::RectifiedGrid;
use crate::frame::Rig;
use crate::recipe::Scene;
use crate::settings::RangeForm;

/// The grid of a rectified scan.
pub(super) fn grid(scene: &Scene, rig: &Rig) -> Option<RectifiedGrid> {
    match scene.extraction.range {
        RangeForm::Rectified { pitch_mm } => Some(RectifiedGrid::new(rig, scene.size.columns, pitch_mm)),
        RangeForm::Calibrated | RangeForm::Uncalibrated => None,
    }
}

/// Offset and scale of Range as whole numbers up to 65535, of which 0 is missing [mm or px].
pub(super) fn steps(scene: &Scene, rig: &Rig) -> (f64, f64) {
    let rows = scene.size.rows as f64;
    if scene.extraction.range == RangeForm::Uncalibrated {
        // A step of the extraction, or of the finest that fits where it gives none.
        let finest = (65535.0 / rows).floor();
        let asked = f64::from(scene.extraction.subpixel_steps);
        return (0.0, 1.0 / if asked > 0.0 { asked.min(finest) } else { finest });
    }
    // The sensor's whole height.
    let (low, high) = rig.heights(scene.size.columns, scene.size.rows);
    let scale = (high - low) / 65534.0;
    (low - scale, scale)
}
