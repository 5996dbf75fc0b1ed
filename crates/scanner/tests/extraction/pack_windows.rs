//! A column read from two windows of rows is read as from the whole sensor, as long as they hold all of its light.

use base::Stream;
use optical_bench::lens::{Distortion, image_distance, scheimpflug};
use rand::RngExt;
use recipe::Recipe;
use scanner::extract::{MeasuredProfile, extract};
use scanner::frame::{Calibration, Frame, Rig};

const ROWS: usize = 44;
const SENSOR: usize = 240;
const COLUMNS: usize = 96;
const DARK: u16 = 12;

/// Lines of DN in both windows, brighter now in one and now in the other, at times saturated over several rows.
#[test]
fn two_windows_read_like_the_whole_sensor() {
    let settings = Recipe::load("wood-small.yaml").expect("the embedded recipe loads").draw(0, 0).extraction;
    let rig = Rig {
        distance: 410.0,
        tilt: 0.44,
        focal_length: 25.0,
        image_distance: image_distance(25.0, 410.0),
        sensor_tilt: scheimpflug(25.0, 410.0, 0.44),
        distortion: Distortion { radial: [0.0; 3], tangential: [0.0; 2] },
        pixel: 6e-3,
        centre_col: 0.5 * (COLUMNS as f64 - 1.0),
        centre_row: 120.0,
    };
    let calibration = Calibration::new(rig, [COLUMNS, SENSOR], f32::from(DARK));
    let mut rng = Stream::root(3).rng();
    let mut windows: [Frame; 2] = std::array::from_fn(|_| Frame {
        cols: COLUMNS,
        rows: ROWS,
        first_col: 0,
        first_row: Vec::new(),
        dn: vec![DARK; ROWS * COLUMNS],
    });
    let mut whole = Frame {
        cols: COLUMNS,
        rows: SENSOR,
        first_col: 0,
        first_row: vec![0; COLUMNS],
        dn: vec![DARK; SENSOR * COLUMNS],
    };
    let mut other = 0;
    for column in 0..COLUMNS {
        // Side by side in every third column, either above the other.
        let gap = if column % 3 == 0 { ROWS } else { ROWS + rng.random_range(1..80) } as i32;
        let first = rng.random_range(20..60);
        let mut stands = [first, first + gap];
        if column % 2 == 0 {
            stands.reverse();
        }
        let heights = [rng.random_range(60.0..400.0), rng.random_range(60.0..400.0)];
        other += usize::from(heights[1] > heights[0] && heights[0] < 255.0);
        for (window, (stand, height)) in windows.iter_mut().zip(stands.into_iter().zip(heights)) {
            window.first_row.push(stand);
            let middle = rng.random_range(20.0..24.0f64);
            for k in 0..ROWS {
                let light: f64 = height * (-0.5 * (k as f64 - middle).powi(2) / 2.2).exp();
                let dn = (f64::from(DARK) + light).min(255.0) as u16;
                window.dn[k * COLUMNS + column] = dn;
                whole.dn[(stand as usize + k) * COLUMNS + column] = dn;
            }
        }
    }
    assert!(other > COLUMNS / 5, "the second window holds the peak in {other} columns");
    let read = |frames: &[Frame; 2]| {
        let (mut range, mut reflectance, mut scatter) = (vec![0.0; COLUMNS], vec![0.0; COLUMNS], vec![0.0; COLUMNS]);
        let mut out = MeasuredProfile { range: &mut range, reflectance: &mut reflectance, scatter: &mut scatter };
        extract(frames, &calibration, &settings, &mut out);
        (range, reflectance, scatter)
    };
    let one = read(&[whole, Frame::default()]);
    assert!(one.0.iter().all(|z| z.is_finite()), "every column has its peak");
    assert_eq!(read(&windows), one);
}
