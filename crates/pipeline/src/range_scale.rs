//! Scale of Range: what its whole numbers mean, and the grid of a rectified scan.

use bench::settings::RangeForm;
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

/// What the whole numbers of Range mean, up to 65535, of which 0 is missing [mm or px].
pub(super) struct RangeScale {
    /// Range of the number 0 [mm or px].
    pub offset: f64,
    /// Range of one step [mm or px].
    pub scale: f64,
}

/// The scale of Range of a scene under a rig.
pub(super) fn range_scale(scene: &Scene, rig: &Rig) -> RangeScale {
    let rows = scene.size.rows as f64;
    if scene.extraction.range == RangeForm::Uncalibrated {
        // A step of the extraction, or of the finest that fits where it gives none.
        let finest = (65535.0 / rows).floor();
        let asked = f64::from(scene.extraction.subpixel_steps);
        return RangeScale { offset: 0.0, scale: 1.0 / if asked > 0.0 { asked.min(finest) } else { finest } };
    }
    // The sensor's whole height.
    let (low, high) = rig.heights(scene.size.columns, scene.size.rows);
    let scale = (high - low) / 65534.0;
    RangeScale { offset: low - scale, scale }
}
