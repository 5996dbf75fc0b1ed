//! Textures of one direction, at random angles, on pixels of unlike sides, under noise.

use base::{Stream, normal};
use glam::Vec2;
use procedural::noise::Noise;
use wood_picture::{Encoding, FibreMap, Findings, PictureAnalysis, PictureFault, analyse, fibre_map};

use crate::{apart_deg, quantile};

/// Streaks as fibre bundles make them (0.2 by 4 mm, 0.8 by 15 mm) with noise, and their azimuth [rad].
fn streaks(number: u64, pixel_mm: [f32; 2], extent_mm: f32, noise: f64) -> (Vec<f32>, [usize; 2], f32) {
    let stream = Stream::root(7).child("texture").index(number);
    let mut rng = stream.child("noise").rng();
    // Within 40 degrees of the board's length, which lies across in every other picture.
    let share = (stream.key() >> 11) as f64 / (1_u64 << 53) as f64;
    let azimuth = ((80.0 * share - 40.0 + if lies_across(number) { 90.0 } else { 0.0 }) as f32).to_radians();
    let size = pixel_mm.map(|pixel| (extent_mm / pixel) as usize);
    let [fine, coarse] = ["fine", "coarse"].map(|name| Noise::new(stream.child(name)));
    let along = Vec2::new(azimuth.sin(), azimuth.cos());
    let light = (0..size[0] * size[1]).map(|i| {
        let place = Vec2::new((i % size[1]) as f32 * pixel_mm[1], (i / size[1]) as f32 * pixel_mm[0]);
        let (u, v) = (along.perp_dot(place) + 50.0, along.dot(place) + 90.0);
        let streak =
            0.02 * fine.fibres(Vec2::new(u / 0.2, v / 4.0)).0 + 0.015 * coarse.fibres(Vec2::new(u / 0.8, v / 15.0)).0;
        0.5 * (1.0 + streak) * (1.0 + noise * normal(&mut rng)) as f32
    });
    (light.collect(), size, azimuth)
}

fn lies_across(number: u64) -> bool {
    (number / 4) % 2 == 1
}

fn linear(number: u64) -> PictureAnalysis {
    PictureAnalysis { encoding: Encoding::Linear, lies_across: lies_across(number), ..PictureAnalysis::default() }
}

#[test]
fn the_azimuth_of_a_texture_is_found_and_its_error_is_as_told() {
    const PICTURES: u64 = 48;
    let (mut all, mut told): (Vec<f32>, Vec<(f32, f32)>) = (Vec::new(), Vec::new());
    for number in 0..PICTURES {
        let pixel_mm = [[0.15, 0.15], [0.2, 0.1], [0.1, 0.2], [0.12, 0.18]][number as usize % 4];
        let noise = [0.005, 0.01, 0.02, 0.04][(number / 4) as usize % 4];
        let (light, size, azimuth) = streaks(number, pixel_mm, 24.0, noise);
        let map = fibre_map(&light, size, pixel_mm, &linear(number)).expect("it is a texture of one direction");
        assert!(map.knots.is_empty(), "picture {number}: {:?}", map.knots);
        all.extend(map.azimuth_rad.iter().map(|&found| apart_deg(found, azimuth)));
        let middle = (size[0] / 2) * size[1] + size[1] / 2;
        told.push((map.azimuth_error_rad(middle).to_degrees(), apart_deg(map.azimuth_rad[middle], azimuth)));
    }
    let median = quantile(&mut all, 0.5);
    // Error over told error is standard normal if the told one is right. Its mean square over the surer and the less
    // sure half of 24 pictures each has a standard error of sqrt(2 / 24) = 0.29; three of them, and the part of 0.5
    // degrees that is told for rings that textures do not have, which makes it smaller.
    told.sort_by(|a, b| a.0.total_cmp(&b.0));
    let squares: Vec<f32> = told
        .chunks(told.len() / 2)
        .map(|half| half.iter().map(|(told, error)| (error / told).powi(2)).sum::<f32>() / half.len() as f32)
        .collect();
    let ends = [told[0].0, told[told.len() - 1].0];
    println!(
        "{PICTURES} textures: median error {median:.2} deg; told {ends:.2?} deg; squared error over told {squares:.2?}"
    );
    assert!(median < 1.0, "median error {median} deg");
    assert!(squares.iter().all(|square| (0.13..1.87).contains(square)), "squared error over told error {squares:?}");
    assert!(ends[1] > 1.5 * ends[0], "all errors are told alike: {ends:?}");
}

/// What is found of rings 3 mm apart of that contrast under marks across them, 0.3 by 8 mm, of 6 %, and how far that is
/// off [deg].
fn marked(number: u64, contrast: f32) -> Result<(Findings, f32), PictureFault> {
    const PIXEL_MM: f32 = 0.12;
    let size = [600, 400];
    let stream = Stream::root(8).child("marked").index(number);
    let (marks, mut rng) = (Noise::new(stream.child("marks")), stream.child("noise").rng());
    let azimuth = [-18.0_f32, -7.0, 10.0, 19.0][number as usize % 4].to_radians();
    let along = Vec2::new(azimuth.sin(), azimuth.cos());
    let light: Vec<f32> = (0..size[0] * size[1])
        .map(|i| {
            let place = Vec2::new((i % size[1]) as f32, (i / size[1]) as f32) * PIXEL_MM;
            let (u, v) = (along.perp_dot(place), along.dot(place) + 50.0);
            let mark = 0.06 * marks.fibres(Vec2::new(v / 0.3, u / 8.0)).0;
            let ring = contrast * (std::f32::consts::TAU * u / 3.0).sin();
            0.5 * (mark + ring).exp() * (1.0 + 0.005 * normal(&mut rng)) as f32
        })
        .collect();
    let settings = PictureAnalysis { encoding: Encoding::Linear, ..PictureAnalysis::default() };
    let findings = analyse(&light, size, [PIXEL_MM; 2], &settings)?.1;
    Ok((findings, apart_deg(findings.azimuth_rad, azimuth)))
}

/// Strong rings are read through marks; weak ones are refused, or the error says that they are weak.
#[test]
fn boards_under_marks_say_how_sure_their_direction_is() {
    for number in 0..4 {
        let (strong, off) = marked(number, 0.1).expect("a board");
        let told = strong.error_rad.to_degrees();
        println!("{number}: off by {off:.2} of {told:.2} deg, {:?}", strong.marks);
        assert!(strong.marks.is_some() && off < 1.5 && told < 2.0, "{off} deg, {strong:?}");
        match marked(number, 0.01) {
            Ok((weak, weak_off)) => {
                let weak_told = weak.error_rad.to_degrees();
                println!("   under weak rings by {weak_off:.2} of {weak_told:.2} deg");
                assert!(weak_told > told && weak_off < 3.0 * weak_told, "{weak_off} deg, {weak:?}");
            }
            Err(fault) => assert!(matches!(fault, PictureFault::NoWood { .. }), "{fault}"),
        }
    }
}

#[test]
fn pixels_of_unlike_sides_turn_nothing() {
    // The same place seen with pixels long across and long down: sampling must not turn lines to either side.
    let mut signed = [0.0_f32; 2];
    for number in 100..112 {
        for (sum, pixel_mm) in signed.iter_mut().zip([[0.25, 0.1], [0.1, 0.25]]) {
            let (light, size, azimuth) = streaks(number, pixel_mm, 20.0, 0.01);
            let map = fibre_map(&light, size, pixel_mm, &linear(number)).expect("it is a texture of one direction");
            let twice: Vec2 = map.non_singular().iter().map(|f| Vec2::new(f[0], f[1])).sum();
            let found = 0.5 * twice.y.atan2(twice.x);
            // Towards the rows or towards the columns: what stretched pixels would do.
            let turned = (0.5 * (2.0 * (found - azimuth)).sin().atan2((2.0 * (found - azimuth)).cos())).to_degrees();
            *sum += turned * (2.0 * azimuth).sin() / 12.0;
        }
    }
    println!("turned by {signed:.2?} deg towards the columns");
    // Errors of about 1 degree over 12 pictures, times the root mean square of a sine: 0.2; three of them.
    assert!(signed.iter().all(|turned| turned.abs() < 0.6), "{signed:?}");
}

#[test]
fn maps_drawn_by_hand_are_fibre_maps() {
    let (size, pixel_mm) = ([120, 160], [0.25, 0.25]);
    // A disc of 8 mm with half of the light and no direction in wood at 30 degrees from x.
    let place = |i: usize| Vec2::new((i % 160) as f32 + 0.5, (i / 160) as f32 + 0.5) * 0.25;
    let knot = |i: usize| place(i).distance(Vec2::new(20.0, 15.0)) < 4.0;
    let line = [30.0_f64.to_radians().cos(), 30.0_f64.to_radians().sin()];
    let directions: Vec<_> = (0..size[0] * size[1]).map(|i| (!knot(i)).then_some(line)).collect();
    let alpha: Vec<_> = (0..size[0] * size[1]).map(|i| if knot(i) { 0.5 } else { 1.0 }).collect();
    let map = FibreMap::from_directions(&directions, &alpha, size, pixel_mm, 4.0).expect("its size is right");
    assert_eq!(map.knots.len(), 1);
    let found = &map.knots[0];
    assert!(found.centre_mm.distance(Vec2::new(20.0, 15.0)) < 0.2, "{found:?}");
    assert!(found.half_axes_mm.iter().all(|half| (half / 4.0 - 1.0).abs() < 0.05), "{found:?}");
    assert!(found.dive_rad().to_degrees() > 80.0 && map.confidence[0] == 1.0);
    // 30 degrees from x is 60 from y.
    assert!((map.azimuth_rad[0].to_degrees() - 60.0).abs() < 0.01, "{}", map.azimuth_rad[0].to_degrees());
    let middle = 60 * 160 + 80;
    assert!(map.dive_rad[middle].abs().to_degrees() > 80.0 && map.fibre(middle).z.abs() > 0.98);
}
