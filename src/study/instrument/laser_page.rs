//! The picture of the study of the laser.

use std::f64::consts::PI;

use image::RgbImage;

use super::beam::{electrons, half_width};
use super::laser::{Beam, HEIGHTS, Seen};
use super::page::{BLUE, CHART, GREY, ORANGE, chart, corner, curve, legend, marks, page};
use crate::drawing::chart::Axis;
use crate::drawing::{MARGIN, viridis};

/// How far the line is shown on either side [mm].
const REACH_MM: f64 = 0.4;
/// Rows on either side that a point between rows is made of.
const LOBES: f64 = 5.0;

pub(super) fn draw(seen: &Seen, table: &str) -> RgbImage {
    let bench = &seen.bench;
    let heading = (
        "The laser line",
        "Read off averaged frames: its width over height, its light along itself and at several heights. Grey: closed forms.",
    );
    let mut page = page(2, 2, heading, table);

    let heights = || (0..=140).map(|i| -55.0 + f64::from(i));
    let width = chart(
        "Half width at 1/e^2 over height",
        Axis::even("z [mm]", -60.0, 80.0),
        Axis::even("[mm]", 0.0, 0.3),
        vec![
            curve(GREY, heights().filter(|z| *z <= 75.0).map(|z| (z, half_width(bench, z)))),
            marks(BLUE, HEIGHTS.iter().zip(&seen.width).map(|(z, w)| (*z, w.value, w.error))),
        ],
    );
    width.draw(&mut page, corner(0, 0), CHART);
    let (x, y) = corner(0, 0);
    let [waist, place, quality] = seen.beam_fit;
    let words = [
        format!("waist   {:.5} +- {:.5} mm, set {}", waist.value, waist.error, bench.laser.waist_mm),
        format!("height  {:.3} +- {:.3} mm, set {}", place.value, place.error, bench.laser.waist_height_mm),
        format!("M^2     {:.4} +- {:.4}, set {}", quality.value, quality.error, bench.laser.m_squared),
    ];
    for (i, words) in words.iter().enumerate() {
        page.words_in(x + 190, y + 240 + 16 * i as u32, words, BLUE);
    }

    let (x, y) = corner(1, 0);
    page.words(x, y + 12, "The line across itself over height, as the sensor has it;");
    page.words(x, y + 28, "each height over its own peak; white: the laser's half width alone");
    caustic(&mut page, (x + 48, y + 40), (CHART.0 - 48 - MARGIN, CHART.1 - 40 - 40), seen);

    let series = |which: usize, colour| {
        vec![
            curve(GREY, seen.along[which].iter().map(|(x, _, t)| (*x, t / 1e3))),
            marks(colour, seen.along[which].iter().map(|(x, e, _)| (*x, e.value / 1e3, e.error / 1e3))),
        ]
    };
    let along = chart(
        "Light along the line on a white plane, z = 0",
        Axis::even("x [mm]", -125.0, 125.0),
        Axis::even("electrons a column / 1000, 40 us", 0.0, 160.0),
        [series(0, BLUE), series(1, ORANGE)].concat(),
    );
    along.draw(&mut page, corner(0, 1), CHART);
    let (x, y) = corner(0, 1);
    legend(
        &mut page,
        (x + 180, y + 240),
        &[(BLUE, "fan of 45 deg, the default"), (ORANGE, "fan of 27 deg, its ends in sight")],
    );

    let off = seen.along[0].iter().map(|(x, e, t)| (*x, 100.0 * (e.value / t - 1.0), 100.0 * e.error / t));
    let even = chart(
        "The same over the closed form, 45 deg",
        Axis::even("x [mm]", -125.0, 125.0),
        Axis::even("[%]", -0.5, 0.5),
        vec![curve(GREY, [(-118.0, 0.0), (118.0, 0.0)].into_iter()), marks(BLUE, off)],
    );
    even.draw(&mut page, corner(1, 1), CHART);
    let (x, y) = corner(1, 1);
    let words = format!("middle: {:.0} electrons a column by the closed form", electrons(bench, 0.0, 0.0));
    page.words_in(x + 70, y + 56, &words, GREY);
    page.0
}

/// Brightness across the line (up) over height (right), between measured heights in between.
fn caustic(page: &mut crate::drawing::Page, (left, top): (u32, u32), (width, height): (u32, u32), seen: &Seen) {
    let (low, high) = (HEIGHTS[0], HEIGHTS[HEIGHTS.len() - 1]);
    let z = |px: f64| low + px / f64::from(width) * (high - low);
    let at = |which: usize, mm: f64| {
        let Beam { rows_per_mm, centre, peak, line } = &seen.beam[which];
        let place = centre + mm * rows_per_mm;
        // Lanczos: straight pieces or cubics would show the rows' own grid.
        let wave = |x: f64| if x.abs() < 1e-9 { 1.0 } else { libm::sin(PI * x) / (PI * x) };
        let lobe = |x: f64| if x.abs() < LOBES { wave(x) * wave(x / LOBES) } else { 0.0 };
        let value: f64 = line.iter().enumerate().map(|(k, v)| v * lobe(place - k as f64)).sum();
        value / peak
    };
    let picture = RgbImage::from_fn(width, height, |px, py| {
        let mm = REACH_MM * (1.0 - 2.0 * (f64::from(py) + 0.5) / f64::from(height));
        let place = (z(f64::from(px)) - low) / (high - low) * (HEIGHTS.len() - 1) as f64;
        let (i, t) = ((place as usize).min(HEIGHTS.len() - 2), place - (place as usize).min(HEIGHTS.len() - 2) as f64);
        viridis(((1.0 - t) * at(i, mm) + t * at(i + 1, mm)) as f32)
    });
    page.picture(left, top, &picture);
    let white = image::Rgb([255, 255, 255]);
    for side in [-1.0, 1.0] {
        for px in 0..width - 1 {
            let up = |px: u32| {
                let w = side * half_width(&seen.bench, z(f64::from(px)));
                (f64::from(left + px), f64::from(top) + f64::from(height) * 0.5 * (1.0 - w / REACH_MM))
            };
            page.line(up(px), up(px + 1), white, 1);
        }
    }
    for (i, mm) in [REACH_MM, 0.0, -REACH_MM].into_iter().enumerate() {
        page.words(left - 40, top + 10 + i as u32 * (height - 10) / 2, &format!("{mm:>5.1}"));
    }
    for z in [-50.0, -20.0, 10.0, 40.0, 70.0] {
        let px = (z - low) / (high - low) * f64::from(width);
        page.words((f64::from(left) + px - 10.0) as u32, top + height + 16, &format!("{z:.0}"));
    }
    page.words(left + width - 56, top + height + 34, "z [mm]");
    page.words(left - 48, top + height + 34, "across [mm]");
}
