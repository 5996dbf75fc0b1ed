//! The camera against published numbers and the exact geometry.

use super::*;
use optical_bench::lens::{DistortedDirection, image_distance};
use optical_bench::parameters::CameraParameters;

fn camera_of(bench: &Bench) -> Camera {
    Camera::new(bench, &SIZE, &LaserLine::PLAIN, Stream::root(0), Stream::root(1))
}

const SIZE: Size = Size { columns: 2560, rows: 832, profiles: 1 };

/// The numbers of docs/theory/instrument.md for d = 410 mm.
#[test]
fn geometry_matches_published_numbers() {
    let rig = rig(&Bench::default(), &SIZE);
    assert!((rig.magnification() - 0.06494).abs() < 1e-5);
    assert!((rig.sensor_tilt.to_degrees() - 7.93).abs() < 0.01);
    assert!((rig.along(1280.5, 0.0) - rig.along(1279.5, 0.0) - 0.0924).abs() < 1e-4);
    let centre = rig.centre_row;
    assert!(((rig.height(centre - 0.5) - rig.height(centre + 0.5)) - 0.2166).abs() < 2e-4);
    let sight = camera_of(&Bench::default()).sight(0.0, 0.0, 0.0);
    assert!((1.0 / sight.rows_per_mm - 0.1010).abs() < 2e-4, "row pitch {}", 1.0 / sight.rows_per_mm);
    // 50 mW over 236 mm, R = 0.7, QE 0.5: 1.83e9 electrons a second and column.
    let mut b = Bench::default();
    b.exposure.quantum_efficiency = 0.5;
    b.exposure.time_us = 50.0;
    b.laser.fan_angle_deg = 2.0 * (118.2f64 / 400.0).atan().to_degrees();
    let sight = camera_of(&b).sight(0.0, 0.0, 0.0);
    let electrons = sight.electrons * sight.view.z * 0.7;
    assert!((electrons / 91.0e3 - 1.0).abs() < 0.02, "electrons a column {electrons}");
}

/// Projection and back-projection undo each other, and `sight` agrees with the exact projection off the plane.
#[test]
fn projection_inverts() {
    let camera = camera_of(&Bench::default());
    for z in [-50.0, -3.0, 0.0, 22.0, 60.0] {
        let (col, row) = camera.rig.project(31.0, 0.0, z);
        assert!((camera.rig.height(row) - z).abs() < 1e-9);
        assert!((camera.rig.along(col, z) - 31.0).abs() < 1e-9);
        let exact = camera.rig.project(31.0, -2.5, z);
        let [along, across] = camera.project(31.0, -2.5, z as f32).map(f64::from);
        assert!((along - exact.0).abs() < 1e-3 && (across - exact.1).abs() < 1e-3, "{along} {across} {exact:?}");
        for slope in [0.0, 0.2] {
            let sight = camera.sight(31.0, z as f32, slope as f32);
            assert!((f64::from(sight.row) - row).abs() < 1e-3);
            let step = 1e-4;
            let (_, ahead) = camera.rig.project(31.0, step, z + slope * step);
            let rate = (row - ahead) / step;
            assert!((f64::from(sight.rows_per_mm) / rate - 1.0).abs() < 1e-3, "{} {rate}", sight.rows_per_mm);
        }
    }
}

/// A lens as bent as those of the kind are, on a sensor that stands as nobody would solve it.
fn bent() -> Bench {
    let mut b = Bench::default();
    let camera = &mut b.camera;
    (camera.distortion_k1, camera.distortion_k2, camera.distortion_k3) = (-0.1, 0.1, -0.05);
    (camera.distortion_p1, camera.distortion_p2) = (5e-4, -5e-4);
    (camera.sensor_tilt_deg, camera.focus_distance_mm) = (5.0, 380.0);
    b.optics.scheimpflug = Scheimpflug::Given;
    (b.optics.offset_columns, b.optics.offset_rows) = (37.0, -51.0);
    b
}

/// Places of the whole sensor go to the laser plane and come back; x of a column by its height is found too, by the
/// exact way and by the cubic that production uses.
#[test]
fn bent_lenses_are_straightened_exactly() {
    for bench in [Bench::default(), bent()] {
        let rig = rig(&bench, &SIZE);
        let (low, high) = (0.0, 74.0);
        let columns = rig.sightlines(SIZE.columns, high);
        let mut worst = [0.0f64; 2];
        for row in 0..=64 {
            for column in (0..SIZE.columns).step_by(71).chain([SIZE.columns - 1]) {
                let (col, row) = (column as f64, f64::from(row) * 13.0);
                let [x, z] = rig.locate(col, row);
                let (back_col, back_row) = rig.project(x, 0.0, z);
                worst[0] = worst[0].max((back_col - col).abs()).max((back_row - row).abs());
                assert!((rig.along(col, z) - x).abs() < 1e-9, "column {col}, height {z}");
                if (low..high).contains(&z) {
                    let near = f64::from(columns.of(column).at(z as f32));
                    let (near_col, _) = rig.project(near, 0.0, z);
                    worst[1] = worst[1].max((near_col - col).abs());
                    let step = 0.01;
                    let lean = (rig.along(col, z + step) - rig.along(col, z - step)) / (2.0 * step);
                    assert!((f64::from(columns.of(column).lean(z as f32)) - lean).abs() < 1e-4, "lean {lean}");
                }
            }
        }
        println!("inverse {:.1e} px, cubic {:.1e} px", worst[0], worst[1]);
        assert!(worst[0] < 1e-6 && worst[1] < 0.01, "inverse {} px, cubic {} px", worst[0], worst[1]);
        let (bottom, top) = rig.heights(SIZE.columns, SIZE.rows);
        assert!(rig.locate(3.0, 831.0)[1] >= bottom && rig.locate(3.0, 0.0)[1] <= top);
    }
}

/// Distortion is what Brown and Conrady wrote down, and its slopes are its derivatives.
#[test]
fn distortion_by_hand() {
    let distortion = Distortion { radial: [-0.06, 0.05, 0.2], tangential: [1e-3, -2e-3] };
    let (x, y) = (0.3, -0.1);
    let r2: f64 = 0.1;
    let gain = 1.0 - 0.06 * r2 + 0.05 * r2 * r2 + 0.2 * r2 * r2 * r2;
    let by_hand = [
        x * gain + 2.0 * 1e-3 * x * y - 2e-3 * (r2 + 2.0 * x * x),
        y * gain + 1e-3 * (r2 + 2.0 * y * y) - 2.0 * 2e-3 * x * y,
    ];
    let DistortedDirection { direction: to, slopes } = distortion.distort(x, y);
    assert!((0..2).all(|i| (to[i] - by_hand[i]).abs() < 1e-15));
    let step = 1e-6;
    let rate = |dx: f64, dy: f64, i: usize| {
        (distortion.distort(x + dx, y + dy).direction[i] - distortion.distort(x - dx, y - dy).direction[i])
            / (2.0 * step)
    };
    for (slope, rate) in slopes.into_iter().zip([rate(step, 0.0, 0), rate(0.0, step, 0), rate(0.0, step, 1)]) {
        assert!((slope - rate).abs() < 1e-8, "{slope} {rate}");
    }
}

/// What each lit point is given agrees with the exact projection over the whole field of a bent lens: row, row scale on
/// slopes, and the width of a column, which its light goes by.
#[test]
fn sight_follows_the_bent_lens() {
    let (bench, open) = (bent(), Bench { camera: Bench::default().camera, ..bent() });
    let camera = camera_of(&bench);
    let straight = camera_of(&Bench {
        camera: CameraParameters { sensor_tilt_deg: 5.0, focus_distance_mm: 380.0, ..open.camera },
        ..open
    });
    for (x, z) in [(0.0, 0.0), (110.0, 0.0), (-104.0, 30.0), (60.0, 60.0), (-100.0, -60.0)] {
        let (_, row) = camera.rig.project(x, 0.0, z);
        for slope in [0.0, 0.2] {
            let sight = camera.sight(x as f32, z as f32, slope as f32);
            assert!((f64::from(sight.row) - row).abs() < 1e-3, "row {} {row}", sight.row);
            let step = 1e-4;
            let (_, ahead) = camera.rig.project(x, step, z + slope * step);
            let rate = (row - ahead) / step;
            assert!((f64::from(sight.rows_per_mm) / rate - 1.0).abs() < 1e-4, "{} {rate}", sight.rows_per_mm);
        }
        let width = |rig: &Rig| {
            let (col, _) = rig.project(x, 0.0, z);
            rig.along(col + 0.5, z) - rig.along(col - 0.5, z)
        };
        let light = camera.sight(x as f32, z as f32, 0.0).electrons / straight.sight(x as f32, z as f32, 0.0).electrons;
        let wide = width(&camera.rig) / width(&straight.rig);
        assert!((f64::from(light) / wide - 1.0).abs() < 1e-4, "light {light} of columns {wide} as wide");
    }
}

/// The published discs: 1.7, 3.3, 6.7 and 16.7 um for light 0.5, 1, 2 and 5 mm off the plane that the tilted sensor
/// sees sharp, none on it; 6.5, 13.1 and 26.8 um at 5, 10 and 20 mm of height without the tilt; and by tracing the rim.
#[test]
fn discs_out_of_focus_match_published_numbers() {
    let solved = camera_of(&Bench::default());
    for (y, um) in [(0.5, 1.7), (1.0, 3.3), (2.0, 6.7), (5.0, 16.7)] {
        let c = 1e3 * solved.circle_of_confusion(y, 0.0);
        assert!((c - um).abs() < 0.06, "{y} mm off the plane: {c} um, published {um}");
    }
    for z in [-60.0, 0.0, 50.0] {
        assert!(
            solved.circle_of_confusion(0.0, z) < 2e-5,
            "the plane itself: {} mm",
            solved.circle_of_confusion(0.0, z)
        );
    }
    let mut b = Bench::default();
    b.optics.scheimpflug = Scheimpflug::Given;
    let level = camera_of(&b);
    for (z, um) in [(5.0, 6.5), (10.0, 13.1), (20.0, 26.8)] {
        let c = 1e3 * level.circle_of_confusion(0.0, z);
        assert!((c - um).abs() < 0.1, "{z} mm high: {c} um, published {um}");
    }
    // Rays through the rim of the pupil to the point's image, cut by the tilted sensor: half of the spread along the
    // rows.
    b.camera.sensor_tilt_deg = 4.0;
    let camera = camera_of(&b);
    let rig = camera.rig;
    for z in [-40.0f64, 15.0, 40.0] {
        let (sin, cos) = rig.tilt.sin_cos();
        let zc = rig.distance - z * cos;
        let (yn, image) = (z * sin / zc, image_distance(rig.focal_length, zc));
        let pupil = b.camera.focal_length_mm / b.camera.f_number;
        let lean = rig.sensor_tilt.tan();
        let meets = |u: f64| {
            let slope = yn - u / image;
            (u + rig.image_distance * slope) / (1.0 - lean * slope) / rig.sensor_tilt.cos() / rig.pixel
        };
        let spread = (meets(0.5 * pupil) - meets(-0.5 * pupil)).abs();
        let variance = f64::from(camera.defocus(0.0, z as f32)[1]);
        assert!((variance / (spread * spread / 16.0) - 1.0).abs() < 0.02, "{z} mm: {variance}, rays {spread} px");
    }
}
