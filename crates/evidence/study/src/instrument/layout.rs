//! Layout of the pictures of the instrument's studies: heading, charts side by side, legends, table.

use image::Rgb;

use drawing::chart::{Axis, Chart, Series};
use drawing::{Area, INK, LETTER, MARGIN, Page};

/// Width and height of a chart [px].
pub(super) const CHART_WIDTH: u32 = 560;
pub(super) const CHART_HEIGHT: u32 = 340;
/// Height of the heading [px].
pub(super) const HEADING_PX: u32 = 58;
/// Height of a line of the table [px].
const TABLE_LINE_PX: u32 = 15;
/// What was measured.
pub(super) const BLUE: Rgb<u8> = Rgb([44, 113, 142]);
/// A second thing that was measured.
pub(super) const ORANGE: Rgb<u8> = Rgb([214, 96, 30]);
/// A third one.
pub(super) const PURPLE: Rgb<u8> = Rgb([160, 50, 140]);
/// A fourth one.
pub(super) const GREEN: Rgb<u8> = Rgb([80, 140, 40]);
/// Theory.
pub(super) const GREY: Rgb<u8> = Rgb([120, 120, 116]);

/// Words at the top of a page.
#[derive(Debug, Clone, Copy)]
pub(super) struct Heading {
    /// What the study is about, in large letters.
    pub title: &'static str,
    /// What was done, in a line below.
    pub subtitle: &'static str,
}

/// A page of `columns` by `rows` charts with a heading above and a table below.
pub(super) fn page(columns: u32, rows: u32, heading: Heading, table: &str) -> Page {
    let lines = table.lines().count() as u32;
    let width = MARGIN + columns * (CHART_WIDTH + MARGIN);
    let mut page = Page::new(width, HEADING_PX + rows * (CHART_HEIGHT + MARGIN) + lines * TABLE_LINE_PX + 2 * MARGIN);
    page.title(MARGIN, 24, heading.title);
    page.words_in(MARGIN, 44, heading.subtitle, GREY);
    page.line((f64::from(MARGIN), 52.0), (f64::from(width - MARGIN), 52.0), GREY, 1);
    let top = HEADING_PX + rows * (CHART_HEIGHT + MARGIN) + MARGIN;
    for (i, line) in table.lines().enumerate() {
        let colour = if line.ends_with("OFF") { ORANGE } else { INK };
        page.words_in(MARGIN, top + TABLE_LINE_PX * i as u32 + 10, line, colour);
    }
    page
}

/// Where the chart in `column` and `row` of the page is drawn.
pub(super) fn area(column: u32, row: u32) -> Area {
    let (left, top) = (MARGIN + column * (CHART_WIDTH + MARGIN), HEADING_PX + 6 + row * (CHART_HEIGHT + MARGIN));
    Area { left, top, width: CHART_WIDTH, height: CHART_HEIGHT }
}

/// Draws a chart without foot in a column and row of the page, and says where it is.
pub(super) fn chart(
    page: &mut Page,
    [column, row]: [u32; 2],
    title: &str,
    x: Axis,
    y: Axis,
    series: Vec<Series>,
) -> Area {
    let area = area(column, row);
    Chart::new(title, x, y, series).draw(page, area);
    area
}

/// Words in colours below each other, with a short line before each.
pub(super) fn legend(page: &mut Page, x: u32, y: u32, entries: &[(Rgb<u8>, &str)]) {
    for (i, (colour, words)) in entries.iter().enumerate() {
        let line = y + 15 * i as u32;
        page.line((f64::from(x), f64::from(line) - 4.0), (f64::from(x) + 14.0, f64::from(line) - 4.0), *colour, 3);
        page.words_in(x + 14 + LETTER, line, words, *colour);
    }
}
