//! The picture of the study of triangulation.

use image::{Rgb, RgbImage};

use super::beam::{column_width, height_per_row};
use super::page::{BLUE, CHART, GREEN, GREY, ORANGE, PURPLE, chart, corner, curve, legend, marks, page};
use super::triangulation::{HEIGHTS, SHOWN, Seen};
use crate::drawing::chart::Axis;
use crate::drawing::{MARGIN, Page};

/// Ends of the map's scale [um].
const MOST_UM: f64 = 45.0;

pub(super) fn draw(seen: &Seen, table: &str) -> RgbImage {
    let heading = (
        "Triangulation on flat targets",
        "Range of level and tilted plates, rendered from body to map, less the plane itself. Grey: theory.",
    );
    let mut page = page(2, 2, heading, table);
    let z = || (0..=110).map(|i| 0.5 * f64::from(i));
    let aside = |slope: usize| 0.8 * (slope as f64 - 1.0);

    let colours = [BLUE, ORANGE, PURPLE];
    let error = |slope: usize| {
        let at = HEIGHTS.iter().zip(&seen.error[slope]);
        marks(colours[slope], at.map(move |(z, e)| (z + aside(slope), e.value, e.error)))
    };
    let errors = chart(
        "Mean error of Range, metal plates",
        Axis::even("height [mm]", 0.0, 55.0),
        Axis::even("[um]; bars: standard errors", -2.0, 2.0),
        vec![curve(GREY, [(0.0, 0.0), (55.0, 0.0)].into_iter()), error(0), error(1), error(2)],
    );
    errors.draw(&mut page, corner(0, 0), CHART);
    let (x, y) = corner(0, 0);
    legend(&mut page, (x + 380, y + 52), &[(BLUE, "level"), (ORANGE, "dz/dx = 0.15"), (PURPLE, "dz/dy = 0.15")]);
    page.words_in(x + 60, y + 52, "1 um is 1/200 row", GREY);

    let level = HEIGHTS.iter().zip(&seen.spread[0]).map(|(z, e)| (*z, e.value, e.error));
    let white = SHOWN.iter().zip(&seen.ceramic).map(|(i, (e, _))| (HEIGHTS[*i], e.value, e.error));
    let spread = chart(
        "Spread of Range, level plates",
        Axis::even("height [mm]", 0.0, 55.0),
        Axis::even("standard deviation [um]", 0.0, 16.0),
        vec![
            curve(GREY, HEIGHTS.iter().zip(&seen.expected).map(|(z, e)| (*z, *e))),
            curve(GREY, SHOWN.iter().zip(&seen.ceramic).map(|(i, (_, e))| (HEIGHTS[*i], *e))),
            marks(BLUE, level),
            marks(GREEN, white),
        ],
    );
    spread.draw(&mut page, corner(1, 0), CHART);
    let (x, y) = corner(1, 0);
    legend(&mut page, (x + 300, y + 52), &[(GREEN, "ceramic, speckle and noise"), (BLUE, "metal, sensor noise alone")]);

    let scales = chart(
        "A row in height, a column in width",
        Axis::even("height [mm]", 0.0, 55.0),
        Axis::even("[um]", 60.0, 240.0),
        vec![
            curve(GREY, z().map(|z| (z, 1000.0 * height_per_row(&seen.bench, z)))),
            curve(GREY, z().map(|z| (z, 1000.0 * column_width(&seen.bench, z)))),
            marks(BLUE, seen.row_um.iter().map(|(z, e)| (*z, e.value, e.error))),
            marks(ORANGE, seen.column_um.iter().map(|(z, e)| (*z, e.value, e.error))),
        ],
    );
    scales.draw(&mut page, corner(0, 1), CHART);
    let (x, y) = corner(0, 1);
    legend(
        &mut page,
        (x + 270, y + 180),
        &[(BLUE, "height of a row, level plates"), (ORANGE, "width of a column, dz/dx = 0.15")],
    );

    let (x, y) = corner(1, 1);
    page.words(x, y + 12, "Range less truth on level ceramic at 23 mm, speckle and noise");
    page.words(x, y + 28, "columns right, profiles down");
    map(&mut page, (x, y + 40), seen);
    page.0
}

fn map(page: &mut Page, (left, top): (u32, u32), seen: &Seen) {
    let (columns, errors) = &seen.map;
    let rows = errors.len() / columns;
    let (width, height) = (CHART.0 - MARGIN, (CHART.0 - MARGIN) * rows as u32 / *columns as u32);
    let at = |px: u32, py: u32| {
        let (column, row) = (px as usize * columns / width as usize, py as usize * rows / height as usize);
        errors[row * columns + column]
    };
    let picture = RgbImage::from_fn(width, height, |px, py| diverging(at(px, py) / MOST_UM));
    page.picture(left, top, &picture);
    let ramp = |t: f32| diverging(2.0 * f64::from(t) - 1.0);
    page.bar(left, top + height + 12, width / 2, (&format!("-{MOST_UM:.0}"), &format!("+{MOST_UM:.0} um")), &ramp);
}

/// Blue below, white at 0, red above, for a number in [-1, 1].
fn diverging(t: f64) -> Rgb<u8> {
    let t = t.clamp(-1.0, 1.0);
    let end = if t < 0.0 { [33.0, 90.0, 160.0] } else { [190.0, 60.0, 30.0] };
    Rgb([0, 1, 2].map(|c| (248.0 + (end[c] - 248.0) * t.abs()) as u8))
}
