//! Range as heights, as sensor rows, and on an even grid: the same scan three times.

use dataset::record::Record;
use optical_bench::settings::RangeForm;
use recipe::Scene;
use test_support::target::{self, ceramic, plate, render, scene};

fn scan(range: RangeForm) -> (Scene, Record) {
    let mut scene = scene(48);
    scene.extraction.range = range;
    let record = render(&scene, plate(ceramic(), 12.0, 0.1, 0.02));
    (scene, record)
}

/// The three forms of one scan: rows give the heights, and the grid holds the same surface and the same labels at even
/// places.
#[test]
fn forms_of_one_scan_agree() {
    let (scene, heights) = scan(RangeForm::Calibrated);
    let (_, rows) = scan(RangeForm::Uncalibrated);
    let (_, grid) = scan(RangeForm::Rectified { pitch_mm: None });
    let rig = pipeline::set_up(&scene, plate(ceramic(), 12.0, 0.1, 0.02), target::patterns()).0.camera().rig;
    assert_eq!((&heights.maps.reflectance, &heights.labels), (&rows.maps.reflectance, &rows.labels));
    for (i, (z, row)) in heights.maps.range.iter().zip(&rows.maps.range).enumerate() {
        assert_eq!(z.is_nan(), row.is_nan());
        assert!(row.is_nan() || (16.0 * row).fract() == 0.0, "rows come in sixteenths");
        let [_, expected] = rig.locate((i % 256) as f64, f64::from(*row));
        assert!(z.is_nan() || (f64::from(*z) - expected).abs() < 1e-4, "{z}, not {expected}");
    }
    assert_eq!((rows.range_offset, rows.range_scale), (0.0, 0.0625));
    // Away from the ends of the grid, which the field of 12 mm above the conveyor does not reach.
    let first = grid.calibration.iter().find(|(name, _)| *name == "x_first_mm").expect("it is there").1;
    let truth = grid.truth.as_ref().expect("the recipe keeps truth maps");
    let (mut measured, mut sum) = (0, 0.0);
    for (i, (z, height)) in grid.maps.range.iter().zip(&truth.height).enumerate() {
        let (j, profile) = ((i % 256) as f64, (i / 256) as f64);
        let x = first + j * grid.col_mm;
        let plane = 12.0 + 0.1 * x + 0.02 * profile * scene.bench.motion.step_mm;
        if grid.labels.class[i] == 0 {
            assert!(height.is_nan() && z.is_nan(), "beyond the field nothing is measured");
            continue;
        }
        // The nearest column is up to half a pitch away.
        assert!((f64::from(*height) - plane).abs() < 0.1 * 0.6 * grid.col_mm + 1e-4, "{height}, not {plane}");
        if z.is_finite() {
            (measured, sum) = (measured + 1, sum + (f64::from(*z) - plane));
        }
    }
    assert!(measured > 40 * 230, "{measured} places were measured");
    assert!((sum / f64::from(measured)).abs() < 0.006, "mean error {} mm", sum / f64::from(measured));
    let shown: u64 = grid.objects.iter().map(|object| object.area_px).sum();
    assert_eq!(shown, grid.labels.instance.iter().filter(|id| **id > 0).count() as u64);
}
