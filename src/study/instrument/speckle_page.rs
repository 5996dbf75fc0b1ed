//! The picture of the study of speckle.

use image::{Rgb, RgbImage};

use super::page::{BLUE, CHART, GREEN, GREY, ORANGE, PURPLE, chart, corner, curve, legend, marks, page};
use super::pattern::{Correlation, overlap};
use super::speckle::{LAGS, PIXELS, STRENGTHS, Seen, WAISTS};
use super::speckle_stack::chord;
use crate::drawing::chart::Axis;
use crate::drawing::{Page, viridis};
use crate::optics::speckle::TILE;

const COLOURS: [Rgb<u8>; 5] = [BLUE, ORANGE, PURPLE, GREEN, Rgb([30, 30, 30])];

pub(super) fn draw(seen: &Seen, table: &str) -> RgbImage {
    let heading = (
        "Speckle as production makes it",
        "Contrast, law, correlation and movement of the pattern, and what it does to the line's centre. Grey: theory.",
    );
    let mut page = page(2, 4, heading, table);

    let theory = (0..=60).map(|i| 0.12 + 0.03 * f64::from(i)).map(|grain| (grain, Correlation::of(grain).contrast()));
    let measured = PIXELS.iter().zip(&seen.contrast).map(|(pixel, c)| (seen.grain_um / pixel, c.value, c.error));
    let contrast = chart(
        "Contrast in one pixel (Goodman), pixels of 12 to 1.2 um",
        Axis::even("grain over pixel", 0.0, 1.8),
        Axis::even("standard deviation over mean", 0.0, 1.0),
        vec![curve(GREY, theory), marks(BLUE, measured)],
    );
    contrast.draw(&mut page, corner(0, 0), CHART);
    let (x, y) = corner(0, 0);
    let own = PIXELS.iter().position(|pixel| *pixel == 6.0).map_or(0.0, |i| seen.contrast[i].value);
    page.words_in(
        x + 200,
        y + 250,
        &format!("the sensor's own 6 um: {own:.4}, theory {:.4}", seen.own.contrast()),
        BLUE,
    );

    let mut series = Vec::new();
    for (i, (values, law)) in seen.laws.iter().enumerate() {
        series.push(curve(GREY, (1..=150).map(|j| 0.02 * f64::from(j)).map(|v| (v, law.density(v)))));
        series.push(marks(COLOURS[i], histogram(values).into_iter()));
    }
    let laws = chart(
        "Law of one pixel: histograms, and sums of exponential parts",
        Axis::even("light over its mean", 0.0, 3.0),
        Axis::even("density", 0.0, 3.0),
        series,
    );
    laws.draw(&mut page, corner(1, 0), CHART);
    let (x, y) = corner(1, 0);
    let entries = [
        (PURPLE, "surface, 1.2 um: nearly exponential"),
        (BLUE, "surface, 6 um"),
        (ORANGE, "below, 6 um: mean of four"),
    ];
    legend(&mut page, (x + 260, y + 60), &entries);

    let lags = |way: usize| {
        let aside = if way == 0 { -0.03 } else { 0.03 };
        seen.lags[way].iter().enumerate().map(move |(i, c)| (i as f64 + 1.0 + aside, c.value, c.error))
    };
    let most = LAGS as f64 + 0.4;
    let along = chart(
        "Correlation of pixels within a profile",
        Axis::even("pixels apart", 0.0, most),
        Axis::even("", -0.02, 0.12),
        vec![
            curve(GREY, (6..=88).map(|i| 0.05 * f64::from(i)).map(|lag| (lag, seen.own.at(lag)))),
            marks(BLUE, lags(0)),
            marks(ORANGE, lags(1)),
        ],
    );
    along.draw(&mut page, corner(0, 1), CHART);
    let (x, y) = corner(0, 1);
    legend(&mut page, (x + 380, y + 60), &[(BLUE, "along columns"), (ORANGE, "along rows")]);

    let apart =
        |n: usize| seen.profiles.iter().filter(move |(_, _, m)| *m == n).map(|(lag, c, _)| (*lag, c.value, c.error));
    let mut series = vec![curve(GREY, (-80..=80).map(|i| 0.025 * f64::from(i)).map(|lag| (lag, seen.own.at(lag))))];
    series.extend((1..=5).map(|n| marks(COLOURS[n - 1], apart(n))));
    let moved = chart(
        "Correlation between profiles: the pattern moves with the object",
        Axis::even("rows apart less 0.673 rows a profile", -2.0, 2.0),
        Axis::even("", -0.1, 1.1),
        series,
    );
    moved.draw(&mut page, corner(1, 1), CHART);
    let (x, y) = corner(1, 1);
    let entries: Vec<String> = (1..=5).map(|n| format!("{n} profile{}", if n > 1 { "s" } else { "" })).collect();
    let entries: Vec<_> = COLOURS.iter().zip(&entries).map(|(colour, words)| (*colour, words.as_str())).collect();
    legend(&mut page, (x + 430, y + 60), &entries);

    let sigma = |w: usize| seen.line_px[w];
    let mut series: Vec<_> = STRENGTHS
        .iter()
        .map(|s| {
            let c = s * seen.own.contrast();
            curve(GREY, (30..=140).map(|i| 0.01 * f64::from(i)).map(move |px| (px, seen.own.wide_line(c, px))))
        })
        .collect();
    for s in 0..STRENGTHS.len() {
        let at = (0..WAISTS.len()).map(move |w| (sigma(w), seen.centre[w][s].value, seen.centre[w][s].error));
        series.push(marks(COLOURS[s], at));
        series.push(curve(COLOURS[s], (0..WAISTS.len()).map(move |w| (sigma(w), seen.sum[w][s]))));
    }
    let centre = chart(
        "Spread of the line's centre on speckle alone",
        Axis::even("standard deviation of the line [rows]", 0.3, 1.4),
        Axis::even("[rows]", 0.0, 0.2),
        series,
    );
    centre.draw(&mut page, corner(0, 2), CHART);
    let (x, y) = corner(0, 2);
    let entries: Vec<String> =
        STRENGTHS.iter().map(|s| format!("contrast {:.3}; line: sum over rows", s * seen.own.contrast())).collect();
    let mut entries: Vec<_> =
        COLOURS.iter().zip(&entries).map(|(colour, words)| (*colour, words.as_str())).rev().collect();
    entries.retain(|(_, words)| !words.is_empty());
    entries.push((GREY, "C sqrt(sigma L_c / (4 sqrt(pi)))"));
    legend(&mut page, (x + 64, y + 56), &entries);

    let (x, y) = corner(1, 2);
    page.words(x, y + 12, "The pattern, 64 x 64 pixels: of the sensor's 6 um, and of 1.2 um");
    for (i, pattern) in seen.patterns.iter().enumerate() {
        cut(&mut page, (x + i as u32 * 276, y + 30), pattern);
    }
    page.bar(x, y + 30 + 256 + 12, 256, ("0", "3 times the mean"), &|t| viridis(t));

    let theory = (0..=100).map(|i| 0.01 * f64::from(i)).map(|s| (s, overlap(s).powi(2)));
    let stack = chart(
        "Boiling: patterns of the stack, points",
        Axis::even("pupils apart over their diameter", 0.0, 1.05),
        Axis::even("correlation", -0.05, 1.0),
        vec![curve(GREY, theory), marks(BLUE, seen.boil.iter().map(|(u, c)| (chord(*u), c.value, c.error)))],
    );
    stack.draw(&mut page, corner(0, 3), CHART);
    let left = chart(
        "Boiling: what is left of the pattern between profiles",
        Axis::even("profiles apart", 0.0, 5.5),
        Axis::even("correlation, all lags over still", 0.8, 1.05),
        vec![
            curve(GREY, seen.left.iter().map(|(n, _, theory)| (*n as f64, *theory))),
            marks(ORANGE, seen.left.iter().map(|(n, c, _)| (*n as f64, c.value, c.error))),
        ],
    );
    left.draw(&mut page, corner(1, 3), CHART);
    page.0
}

/// 64 by 64 pixels of a pattern, four pixels of the page each.
fn cut(page: &mut Page, (left, top): (u32, u32), pattern: &[f64]) {
    let picture =
        RgbImage::from_fn(256, 256, |px, py| viridis((pattern[py as usize / 4 * TILE + px as usize / 4] / 3.0) as f32));
    page.picture(left, top, &picture);
}

/// Middle of each bin, density, and its standard error for independent pixels.
fn histogram(values: &[f64]) -> Vec<(f64, f64, f64)> {
    const BIN: f64 = 0.1;
    let n = values.len() as f64;
    let bin = |i: usize| {
        let (from, to) = (BIN * i as f64, BIN * (i + 1) as f64);
        let count = values.iter().filter(|v| (from..to).contains(*v)).count() as f64;
        (0.5 * (from + to), count / (n * BIN), count.sqrt() / (n * BIN))
    };
    (0..30).map(bin).collect()
}
