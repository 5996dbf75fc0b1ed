//! The picture of the study of lines: one chart a medium.

use image::RgbImage;

use super::by::By;
use super::colour;
use super::lines::{Case, FIGURES, Mark, ROWS, marked};
use crate::drawing::chart::{Axis, Chart, Series};
use crate::drawing::{MARGIN, Page};
use crate::transport::model::Model;

const COLUMNS: u32 = 3;
/// Width and height of a chart [px].
const CHART: (u32, u32) = (430, 270);
const HEAD: u32 = 46;

pub(super) fn draw(cases: &[Case]) -> RgbImage {
    let rows = (cases.len() as u32).div_ceil(COLUMNS);
    let mut page = Page::new(MARGIN + COLUMNS * (CHART.0 + MARGIN), HEAD + rows * (CHART.1 + MARGIN) + MARGIN);
    let words = "A line of light: share of its energy that leaves in each row along the motion. Below each chart the kernel \
                 against its bars: ok, off, or ? where the judge's error hides it";
    page.words(MARGIN, 20, words);
    page.words_in(MARGIN, 36, marked(cases).trim_end(), colour(By::Model(Model::Kernel)));
    for (i, case) in cases.iter().enumerate() {
        let (row, column) = (i as u32 / COLUMNS, i as u32 % COLUMNS);
        let place = (MARGIN + column * (CHART.0 + MARGIN), HEAD + row * (CHART.1 + MARGIN));
        chart(case).draw(&mut page, place, CHART);
    }
    page.0
}

fn chart(case: &Case) -> Chart {
    let series = Model::ALL.into_iter().zip(&case.answers).filter_map(|(model, answer)| {
        let answer = answer.as_ref().ok()?;
        let at = |(row, share): (usize, &crate::transport::answer::Estimate)| {
            ((row as f64 - ROWS as f64) * answer.row_mm, share.value, share.error)
        };
        let points = answer.line.iter().enumerate().map(at).collect();
        Some(Series { name: model.name().into(), colour: colour(By::Model(model)), points, joined: !model.walks() })
    });
    let [mu_a, s, k, n] = case.wood.coefficients;
    Chart {
        title: format!("{}: mu_a {mu_a}, sigma_i {s}, sigma_c {k}, n {n}", case.wood.name),
        x: Axis::even("y [mm]", -2.1, 2.1),
        y: Axis::log("share of the energy in a row", 1e-4, 0.5),
        series: series.collect(),
        foot: (marks(case), colour(By::Model(Model::Kernel))),
    }
}

/// What the kernel's bars say.
fn marks(case: &Case) -> String {
    let each = |marks| FIGURES.iter().zip(marks).map(|(figure, mark): (_, Mark)| [figure.name, mark.name()].join(" "));
    case.marks().map_or_else(String::new, |marks| each(marks).collect::<Vec<_>>().join("  "))
}
