//! Boards cut out of pictures: the loop from a board over its picture to a board, mirrors and turns, labels, depth.

use std::sync::Arc;

use base::{Class, Stream};
use glam::Vec2;
use procedural::wood::{GivenWood, Plank};
use wood_picture::{BoardPicture, Depth, Encoding, PictureAnalysis};

use crate::board::{self, BoardPicture as Seen, look, wood};

const PIXEL_MM: f32 = 0.15;

fn linear() -> PictureAnalysis {
    PictureAnalysis { encoding: Encoding::Linear, ..PictureAnalysis::default() }
}

fn analysed(seen: &Seen, depth: Depth) -> BoardPicture {
    BoardPicture::new(&seen.light, seen.size, seen.pixel_mm, &linear(), depth).expect("a picture of wood")
}

fn small(sound: f64) -> Seen {
    let stream = Stream::root(11).child("cut");
    let mut wood = wood(stream, sound, 0.0);
    (wood.board.width_mm, wood.board.length_mm) = (42.0, 60.0);
    board::picture(stream, wood, PIXEL_MM)
}

fn median(mut values: Vec<f32>) -> f32 {
    values.sort_by(f32::total_cmp);
    values[values.len() / 2]
}

/// Board -> picture -> board from the picture: its light is that of the picture, its fibres those of the first board.
/// Bars: 3 degrees in clear wood and 10 at knots (medians), correlation of light 0.9.
#[test]
fn a_board_from_the_picture_of_a_board_is_like_it() {
    for seed in [3, 4, 5, 6] {
        let stream = Stream::root(seed).child("loop");
        let seen = board::picture(stream, wood(stream, 2.0, 0.0), PIXEL_MM);
        let cut = analysed(&seen, Depth::Feature).cut(&seen.wood);
        assert!(!cut.instances().is_empty(), "it has knots");
        let knots: Vec<_> = cut.knots().collect();
        let again = look(Plank::lay(stream.child("again"), &seen.wood, Arc::new(cut)), seen.wood, PIXEL_MM);
        let (mut clear, mut around, mut light) = (Vec::new(), Vec::new(), Vec::new());
        for i in (0..seen.light.len()).step_by(3) {
            let place = Vec2::new((i % seen.size[1]) as f32 + 0.5, (i / seen.size[1]) as f32 + 0.5) * PIXEL_MM;
            let off = (seen.azimuth_rad[i] - again.azimuth_rad[i]).to_degrees();
            let off = (off - 180.0 * (off / 180.0).round()).abs();
            let near = knots.iter().map(|knot| knot.within(place)).fold(f32::INFINITY, f32::min);
            if near > 4.0 {
                clear.push(off);
            } else if (1.0..2.0).contains(&near) {
                around.push(off);
            }
            light.push([f64::from(seen.light[i]), f64::from(again.light[i])]);
        }
        let mean = |k: usize| light.iter().map(|pair| pair[k]).sum::<f64>() / light.len() as f64;
        let means = [mean(0), mean(1)];
        let moment = |j: usize, k: usize| {
            light.iter().map(|pair| (pair[j] - means[j]) * (pair[k] - means[k])).sum::<f64>() / light.len() as f64
        };
        let correlation = moment(0, 1) / (moment(0, 0) * moment(1, 1)).sqrt();
        let off = [clear, around].map(median);
        println!(
            "seed {seed}: clear {:.2}, around {:.2} deg, light {correlation:.4}, mean ratio {:.4}",
            off[0],
            off[1],
            means[1] / means[0]
        );
        assert!(off[0] < 3.0 && off[1] < 10.0, "fibres are off by {off:?} deg");
        assert!(correlation > 0.9, "light has a correlation of {correlation}");
        assert!((means[1] / means[0] - 1.0).abs() < 0.05, "{means:?}");
    }
}

#[test]
fn a_mirrored_or_turned_board_has_the_same_wood_elsewhere() {
    let seen = small(1.0);
    let whole = analysed(&seen, Depth::Feature);
    let mut numbers = seen.wood;
    (numbers.board.width_mm, numbers.board.length_mm) = (30.03, 40.02);
    (numbers.picture.along, numbers.picture.across) = (0.3, 0.8);
    let plain = whole.cut(&numbers);
    for (mirrored, turned) in [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        (numbers.picture.mirrored, numbers.picture.turned) = (mirrored, turned);
        let other = whole.cut(&numbers);
        let (flip_x, flip_y) = ((mirrored > 0.0) != (turned > 0.0), turned > 0.0);
        for i in 0..400 {
            let place = Vec2::new(1.0 + (i % 20) as f32 * 1.41, 1.0 + (i / 20) as f32 * 1.93);
            let there = Vec2::new(
                if flip_x { 30.03 - place.x } else { place.x },
                if flip_y { 40.02 - place.y } else { place.y },
            );
            let (a, b) = (plain.at(place, 0.0), other.at(there, 0.0));
            assert!((a.mu_a / b.mu_a - 1.0).abs() < 0.02, "{place}: {} and {}", a.mu_a, b.mu_a);
            let mut fibre = b.fibre;
            fibre.x *= if flip_x { -1.0 } else { 1.0 };
            fibre.y *= if flip_y { -1.0 } else { 1.0 };
            assert!(a.fibre.dot(fibre).abs() > 0.999, "{place}: {} and {fibre}", a.fibre);
        }
    }
    // Other places of the picture are other wood.
    (numbers.picture.mirrored, numbers.picture.turned) = (0.0, 0.0);
    for (along, across) in [(0.9, 0.8), (0.3, 0.1)] {
        (numbers.picture.along, numbers.picture.across) = (along, across);
        let place = Vec2::new(15.0, 20.0);
        assert!(whole.cut(&numbers).at(place, 0.0) != plain.at(place, 0.0));
    }
}

#[test]
fn depth_is_as_stated() {
    let seen = small(0.0);
    let even = analysed(&seen, Depth::Even(1.0)).cut(&seen.wood);
    let feature = analysed(&seen, Depth::Feature).cut(&seen.wood);
    let places: Vec<Vec2> =
        (0..200).map(|i| Vec2::new(2.0 + (i % 10) as f32 * 3.7, 2.0 + (i / 10) as f32 * 2.7)).collect();
    let spread = |wood: &dyn GivenWood, depth: f32| {
        let logs: Vec<f32> = places.iter().map(|place| wood.at(*place, depth).mu_a.ln()).collect();
        let mean = logs.iter().sum::<f32>() / logs.len() as f32;
        (logs.iter().map(|log| (log - mean).powi(2)).sum::<f32>() / logs.len() as f32).sqrt()
    };
    for place in &places {
        assert_eq!(even.at(*place, 0.0), even.at(*place, 0.9));
        assert!((even.at(*place, 0.0).mu_a / feature.at(*place, 0.0).mu_a - 1.0).abs() < 1e-5);
    }
    assert!(spread(&even, 1.1) < 1e-6 && spread(&even, 0.0) > 0.05);
    assert!(spread(&feature, 3.0) < 0.8 * spread(&feature, 0.0), "features fade");
}

#[test]
fn labels_that_are_given_are_the_labels() {
    let seen = small(1.0);
    let found = analysed(&seen, Depth::Feature).cut(&seen.wood).instances();
    assert!(found.len() == 1 && found[0].class == Class::SoundKnot, "{found:?}");
    let mut classes = vec![Class::Clear; seen.light.len()];
    for row in 40..60 {
        classes[row * seen.size[1] + 30..row * seen.size[1] + 50].fill(Class::ResinPocket);
        classes[row * seen.size[1] + 100..row * seen.size[1] + 110].fill(Class::DeadKnot);
    }
    let cut = analysed(&seen, Depth::Feature).labelled(classes).expect("few patches").cut(&seen.wood);
    let told: Vec<_> = cut.instances().iter().map(|one| (one.id, one.class)).collect();
    assert_eq!(told, [(1, Class::ResinPocket), (2, Class::DeadKnot)]);
    for one in cut.instances() {
        let here = cut.at(Vec2::new(one.x_mm as f32, one.y_mm as f32), 0.0);
        assert_eq!((here.class, here.instance), (one.class, one.id));
    }
    assert_eq!(cut.at(Vec2::new(1.0, 1.0), 0.0).class, Class::Clear);
}

/// How recipes/pictures/board.png was made: light of a grown board in sRGB with the colour of spruce, far end first.
#[test]
#[ignore = "writes the picture of the recipe wood-picture"]
fn write_the_picture_of_the_recipe() {
    let stream = Stream::root(7).child("picture of the recipe");
    let mut numbers = wood(stream, 2.0, 1.0);
    (numbers.board.width_mm, numbers.board.length_mm) = (60.0, 90.0);
    let seen = board::picture(stream, numbers, PIXEL_MM);
    let [rows, cols] = seen.size;
    let encoded = |light: f32| {
        let light = light.clamp(0.0, 1.0);
        let number = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
        (255.0 * number).round() as u8
    };
    let picture = image::RgbImage::from_fn(cols as u32, rows as u32, |x, y| {
        let light = seen.light[(rows - 1 - y as usize) * cols + x as usize];
        // Darker wood is browner.
        image::Rgb([light, 0.86 * light.powf(1.25), 0.72 * light.powf(1.6)].map(encoded))
    });
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../recipes/pictures/board.png");
    picture.save(path).expect("written");
}
