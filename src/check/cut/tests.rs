//! Windows by hand.

use super::*;

fn channel(mean: f64, sd: f64, missing: f64, relative: bool) -> Channel {
    Channel { name: "scatter".into(), mean, sd, missing, relative }
}

/// Three rows of four: 1 2 3 4 / 5 0 7 8 / 9 10 11 12, 0 is missing.
fn picture() -> Picture {
    let pixels = vec![1, 2, 3, 4, 5, 0, 7, 8, 9, 10, 11, 12];
    let labels = vec![0, 0, 1, 1, 0, 0, 1, 1, 2, 2, 2, 2];
    Picture { size: [3, 4], planes: vec![Plane::Eight(pixels)], labels }
}

fn cut(window: Window, size: [usize; 2], channel: &Channel) -> Vec<f32> {
    let mut out = vec![f32::MAX; size[0] * size[1]];
    fill(&mut out, &picture(), window, std::slice::from_ref(channel), size, Layout::Nchw);
    out
}

#[test]
fn windows_are_cut_and_normalised() {
    let plain = channel(0.0, 1.0, -1.0, false);
    let window = Window::around([1, 1], [2, 2]);
    assert_eq!(window, Window { first: [0, 0], size: [2, 2] });
    assert_eq!(cut(window, [2, 2], &plain), [1.0, 2.0, 5.0, -1.0]);
    assert_eq!(cut(window, [2, 2], &channel(1.0, 2.0, -9.0, false)), [0.0, 0.5, 2.0, -9.0]);
    // The mean of 1, 2 and 5 is 8/3.
    let relative = cut(window, [2, 2], &channel(0.0, 1.0, 0.0, true));
    for (found, wanted) in relative.iter().zip([1.0 - 8.0 / 3.0, 2.0 - 8.0 / 3.0, 5.0 - 8.0 / 3.0, 0.0]) {
        assert!((found - wanted).abs() < 1e-6);
    }
    // Over the border everything is missing.
    assert_eq!(
        cut(Window::around([0, 0], [3, 3]), [3, 3], &plain),
        [-1.0, -1.0, -1.0, -1.0, 1.0, 2.0, -1.0, 5.0, -1.0]
    );
    assert_eq!(cut(Window::around([50, 50], [2, 1]), [2, 1], &plain), [-1.0, -1.0]);
}

/// Whole factors take means of what was measured; others share pixels between cells; growing repeats them.
#[test]
fn resizing_takes_means() {
    let plain = channel(0.0, 1.0, -1.0, false);
    let whole = Window { first: [0, 0], size: [3, 4] };
    assert_eq!(cut(whole, [1, 2], &plain), [27.0 / 5.0, 45.0 / 6.0]);
    assert_eq!(cut(whole, [3, 1], &plain), [2.5, 20.0 / 3.0, 10.5]);
    // Rows 0 to 1 and 1 to 2.
    assert_eq!(cut(Window { first: [0, 0], size: [3, 1] }, [2, 1], &plain), [3.0, 7.0]);
    assert_eq!(cut(Window { first: [0, 2], size: [1, 1] }, [2, 2], &plain), [3.0; 4]);
}

/// Cells of one pixel are that pixel, wherever the window lies; outside of the image nothing was measured.
#[test]
fn copies_are_the_pixels() {
    let pixels: [u8; 12] = std::array::from_fn(|i| i as u8);
    for (row, col) in (-4..6).flat_map(|row| (-5..7).map(move |col| (row, col))) {
        let window = Window { first: [row, col], size: [2, 3] };
        let (mut short, mut long) = ([0.0; 6], [0.0; 6]);
        copy(&mut short, &pixels, f32::from, [3, 4], window);
        // Every pixel on its own.
        for (cell, out) in long.iter_mut().enumerate() {
            let [r, c] = [row + cell as i64 / 3, col + cell as i64 % 3];
            let inside = (0..3).contains(&r) && (0..4).contains(&c);
            *out = if inside { (4 * r + c) as f32 } else { f32::NAN };
        }
        assert!(
            short.iter().zip(long).all(|(a, b)| *a == b || a.is_nan() && b.is_nan()),
            "{window:?}: {short:?} {long:?}"
        );
    }
}

#[test]
fn layouts_interleave() {
    let mut picture = picture();
    picture.planes.push(Plane::Sixteen { pixels: (0..12).collect(), offset: 0.5, scale: 0.25 });
    picture.planes.push(Plane::Float((0..12).map(|i| i as f32).collect()));
    let channels = [0, 1, 2].map(|_| channel(0.0, 1.0, -1.0, false));
    let window = Window { first: [0, 0], size: [1, 2] };
    let mut out = vec![0.0; 6];
    fill(&mut out, &picture, window, &channels, [1, 2], Layout::Nchw);
    assert_eq!(out, [1.0, 2.0, -1.0, 0.75, 0.0, 1.0]);
    fill(&mut out, &picture, window, &channels, [1, 2], Layout::Nhwc);
    assert_eq!(out, [1.0, -1.0, 0.0, 2.0, 0.75, 1.0]);
}

#[test]
fn truth_is_the_middle_pixels_class() {
    let classes = [Some(1), None, Some(0)];
    let whole = Window { first: [0, 0], size: [3, 4] };
    assert_eq!(truth(&picture(), whole, [3, 4], &classes), [1, 1, 255, 255, 1, 1, 255, 255, 0, 0, 0, 0]);
    // Middle pixels: row 1 (the 2nd of 3), columns 1 and 3.
    assert_eq!(truth(&picture(), whole, [1, 2], &classes), [1, 255]);
    let beyond = Window { first: [2, 3], size: [2, 2] };
    assert_eq!(truth(&picture(), beyond, [2, 2], &classes), [0, 255, 255, 255]);
}

/// The mean of what was measured, however many cells there are (sums of whole numbers are exact); 0 where nothing was.
#[test]
fn means_leave_out_what_is_missing() {
    for count in [0_u8, 1, 2, 7, 8, 9, 64, 101] {
        let plane: Vec<f32> = (0..count).map(|i| if i % 3 == 0 { f32::NAN } else { f32::from(i) }).collect();
        let known: Vec<f64> = plane.iter().filter(|value| !value.is_nan()).map(|&value| f64::from(value)).collect();
        let wanted = known.iter().sum::<f64>() / known.len().max(1) as f64;
        assert_eq!(mean(&plane), wanted, "{count} cells");
    }
}
