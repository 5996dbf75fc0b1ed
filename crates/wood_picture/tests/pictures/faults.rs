//! Each fault by a picture that has it.

use base::{Stream, normal};
use wood_picture::{Encoding, PictureAnalysis, PictureFault, absorption_map, analyse, fibre_map};

use crate::board::{BoardPicture, picture, wood};

fn linear() -> PictureAnalysis {
    PictureAnalysis { encoding: Encoding::Linear, ..PictureAnalysis::default() }
}

fn good() -> BoardPicture {
    let stream = Stream::root(3).child("fault");
    let mut wood = wood(stream, 0.0, 0.0);
    (wood.board.width_mm, wood.board.length_mm) = (30.0, 45.0);
    picture(stream, wood, 0.15)
}

fn fault(
    board: &BoardPicture,
    change: impl Fn(&mut Vec<f32>, &mut [usize; 2], &mut [f32; 2], &mut PictureAnalysis),
) -> PictureFault {
    let (mut light, mut size, mut pixel_mm) = (board.light.clone(), board.size, board.pixel_mm);
    let mut settings = linear();
    change(&mut light, &mut size, &mut pixel_mm, &mut settings);
    let fault = fibre_map(&light, size, pixel_mm, &settings).expect_err("the picture has a fault");
    let words = fault.to_string();
    println!("{words}");
    // What, and what to do.
    assert!(words.contains(';'), "{words}");
    fault
}

#[test]
fn each_fault_is_told_as_that_fault() {
    use PictureFault as F;
    let board = good();
    assert!(fibre_map(&board.light, board.size, board.pixel_mm, &linear()).is_ok());
    let kept = PictureAnalysis { board_mm: Some([45.5, 29.5]), ..linear() };
    assert!(fibre_map(&board.light, board.size, board.pixel_mm, &kept).is_ok());

    assert!(matches!(fault(&board, |light, _, _, _| light.truncate(100)), F::Length { .. }));
    assert!(matches!(fault(&board, |_, _, pixel, _| pixel[0] = 0.0), F::Pixel { .. }));
    assert!(matches!(fault(&board, |_, _, pixel, _| pixel[0] = f32::NAN), F::Pixel { .. }));
    assert!(matches!(fault(&board, |_, _, pixel, _| pixel[0] *= 5.0), F::Pixel { .. }));
    assert!(matches!(fault(&board, |_, _, pixel, _| *pixel = [0.6; 2]), F::Coarse { .. }));
    assert!(matches!(fault(&board, |_, _, pixel, _| *pixel = [0.02; 2]), F::TooSmall { .. }));
    assert!(matches!(fault(&board, |_, _, _, settings| settings.board_mm = Some([30.0, 45.0])), F::Aspect { .. }));
    assert_eq!(fault(&board, |_, _, _, settings| settings.encoding = Encoding::Unknown), F::NotLinear);
    assert!(matches!(fault(&board, |_, _, _, settings| settings.encoding = Encoding::Gamma(22.0)), F::Gamma { .. }));
    assert!(matches!(fault(&board, |light, _, _, _| light[777] = f32::NAN), F::Value { row: 3, .. }));
    assert!(matches!(fault(&board, |light, _, _, _| light[2] = -0.1), F::Value { row: 0, col: 2, .. }));
    assert!(matches!(fault(&board, |light, _, _, _| light.fill(0.4)), F::Constant { .. }));
    assert!(matches!(fault(&board, |light, _, _, _| light.fill(0.0)), F::Constant { .. }));
    let glare = |light: &mut Vec<f32>| light.iter_mut().for_each(|v| *v = (1.5 * *v).min(1.0));
    assert!(matches!(fault(&board, |light, _, _, _| glare(light)), F::Saturated { .. }));
    // A few glints are told and do no harm.
    let (mut glints, mut sorted) = (board.light.clone(), board.light.clone());
    let end = crate::quantile(&mut sorted, 0.97);
    glints.iter_mut().for_each(|light| *light = (*light / end).min(1.0));
    let [plain, clipped] = [&board.light, &glints]
        .map(|light| analyse(light, board.size, board.pixel_mm, &linear()).expect("it is a board").1);
    assert!(plain.clipped_share == 0.0 && (0.03..0.045).contains(&clipped.clipped_share), "{clipped:?}");
    assert!(crate::apart_deg(plain.azimuth_rad, clipped.azimuth_rad) < 0.5, "{plain:?} {clipped:?}");
    let noise = |light: &mut Vec<f32>| {
        let mut rng = Stream::root(5).rng();
        light.iter_mut().for_each(|v| *v = (0.5 + 0.02 * normal(&mut rng)) as f32);
    };
    assert!(matches!(fault(&board, |light, _, _, _| noise(light)), F::NoWood { .. }));
    // Ten times too small a size is told by the width of the streaks, of a picture large enough for it.
    let stripes = |light: &mut Vec<f32>, size: &mut [usize; 2]| {
        let mut rng = Stream::root(6).rng();
        *size = [400, 400];
        *light = (0..160_000)
            .map(|i| {
                let streak = (0.05 * (i % 400) as f32).sin() * (1.0 + 0.3 * (0.031 * (i / 400) as f32).sin());
                0.5 + 0.1 * streak + (0.002 * normal(&mut rng)) as f32
            })
            .collect();
    };
    assert!(matches!(
        fault(&board, |light, size, pixel, _| {
            stripes(light, size);
            *pixel = [0.3; 2];
        }),
        F::Scale { .. }
    ));
}

#[test]
fn a_map_of_another_size_is_refused() {
    let board = good();
    let map = fibre_map(&board.light, board.size, board.pixel_mm, &linear()).expect("it is a board");
    let (media, share) = (board.wood.media, board.wood.log.latewood_share);
    let fault = absorption_map(&board.light[1..], &map, &media, share, &linear()).expect_err("a pixel is missing");
    assert!(matches!(fault, PictureFault::Length { .. }), "{fault}");
}
