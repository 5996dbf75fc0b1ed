//! Parts of photographs of real boards: directions, marks, knots. `photographs/README.md` says where they come from.

use glam::Vec2;
use procedural::wood::Wood;
use wood_picture::{Encoding, FibreMap, Findings, PictureAnalysis, analyse, face_absorption};

use crate::quantile;

/// Its fibres, what was found of it, its absorption [mm^-1], and the share that is brighter than wood [1].
fn seen(file: &[u8]) -> (FibreMap, Findings, Vec<f32>, f64) {
    let picture = image::load_from_memory(file).expect("a picture").into_rgb8();
    let size = [picture.height() as usize, picture.width() as usize];
    let red: Vec<f32> = picture.pixels().map(|pixel| f32::from(pixel.0[0]) / 255.0).collect();
    let settings = PictureAnalysis { encoding: Encoding::Srgb, ..PictureAnalysis::default() };
    let (map, board) = analyse(&red, size, [0.08, 0.05], &settings).expect("a board");
    let wood = Wood::from_values(&mut |parameter| parameter.default);
    let face = face_absorption(&red, &map, &wood.media, wood.log.latewood_share, &settings).expect("a board");
    (map, board, face.0, face.1)
}

/// Axes of rings [deg] are those of a structure tensor of its own (light averaged by 1.5 mm along the board, slopes at
/// 0.3 mm across it) outside of knots; knots are as people have drawn them: middle (x, y) [mm] and whether they are
/// dead.
#[test]
fn photographs_are_read() {
    let dead = include_bytes!("../photographs/dead-knot.jpg").as_slice();
    let three = include_bytes!("../photographs/three-knots.jpg").as_slice();
    let cut = include_bytes!("../photographs/cut-knot.jpg").as_slice();
    let living = [(Vec2::new(45.4, 21.0), false), (Vec2::new(8.8, 20.1), false), (Vec2::new(27.7, 9.0), false)];
    for (file, rings_deg, knots) in [
        (dead, -1.1, &[(Vec2::new(15.6, 14.6), true)][..]),
        (three, 2.2, &living[..]),
        (cut, 1.2, &[(Vec2::new(23.9, 41.2), true)][..]),
    ] {
        let (map, board, mu_a, glossy) = seen(file);
        let (azimuth, error) = (board.azimuth_rad.to_degrees(), board.error_rad.to_degrees());
        let marks = board.marks.expect("marks of a planer");
        println!("{azimuth:.2} deg +- {error:.2}, rings {rings_deg}; {marks:?}; {} knots", map.knots.len());
        // Three of the errors that are told, which are large where knots fill a small picture.
        assert!((azimuth - rings_deg).abs() < (3.0 * error).min(4.0) && error < 15.0);
        assert!(marks.strength > 0.012);
        for &(middle, is_dead) in knots {
            let found = map.knots.iter().find(|knot| knot.centre_mm.distance(middle) < 3.0);
            let found = found.unwrap_or_else(|| panic!("no knot at {middle}: {:?}", map.knots));
            assert_eq!(found.dead, is_dead, "{found:?}");
            let of = |is_asked: &dyn Fn(f32) -> bool| {
                let pixels = (0..mu_a.len()).filter(|&pixel| is_asked(found.within(map.place_mm(pixel))));
                quantile(&mut pixels.map(|pixel| mu_a[pixel]).collect::<Vec<_>>(), 0.5)
            };
            let darker = of(&|within| within < 0.8) / of(&|within| within > 3.0);
            println!("knot at {middle}: {darker:.1} times the absorption; {:.1} % glossy", 100.0 * glossy);
            assert!(darker > if is_dead { 5.0 } else { 1.5 }, "{darker}");
        }
        assert!(map.knots.len() <= knots.len() + 1, "{:?}", map.knots);
        // Torn fibres and glints, not the quarter of the board that lies under the lamps.
        assert!(glossy < 0.12, "{glossy} of it are brighter than wood");
    }
}
