//! The picture of the study of the sensor.

use image::{Rgb, RgbImage};

use super::page::{BLUE, CHART, GREY, ORANGE, chart, corner, curve, legend, marks, page};
use super::sensor::Seen;
use super::setup::gain;
use crate::drawing::INK;
use crate::study::chart::Axis;

/// Side of a cut of a dark frame [px], and pixels of the page for each of its.
const CUT: u32 = 120;
const ZOOM: u32 = 2;

pub(super) fn draw(seen: &Seen, table: &str) -> RgbImage {
    let exposure = seen.scene.bench.exposure;
    let heading = (
        "The sensor by photon transfer",
        "A white plane under a broad line without speckle, exposed again and again; read off digital numbers alone. Grey: theory.",
    );
    let mut page = page(2, 2, heading, table);
    let (k, dark) = (gain(&seen.scene), exposure.dark_level_dn);

    let transfer = chart(
        "Photon transfer: the slope is the gain",
        Axis::even("mean [DN]", 0.0, 265.0),
        Axis::even("variance in time [DN^2]", 0.0, 4.0),
        vec![
            curve(GREY, seen.expected.iter().map(|e| (e[1], e[2]))),
            marks(BLUE, seen.levels.iter().map(|(_, mean, v)| (mean.value, v.value, v.error))),
        ],
    );
    transfer.draw(&mut page, corner(0, 0), CHART);
    let (x, y) = corner(0, 0);
    page.words_in(x + 74, y + 66, &format!("K = {:.6} +- {:.6} DN/e-", seen.gain.value, seen.gain.error), BLUE);
    page.words_in(x + 74, y + 82, &format!("set: {k:.6}"), GREY);
    page.words_in(x + 400, y + 230, "clipped at 255", GREY);

    let linear = chart(
        "Linearity: mean less dark and K e, % of full",
        Axis::even("electrons / 1000", 0.0, 29.0),
        Axis::even("[%]", -0.15, 0.15),
        vec![
            curve(GREY, seen.expected.iter().map(|e| (e[0] / 1e3, 100.0 * (e[1] - dark - k * e[0]) / (255.0 - dark)))),
            marks(
                BLUE,
                seen.levels.iter().map(|(e, mean, _)| {
                    let off = mean.value - dark - k * e;
                    (e / 1e3, 100.0 * off / (255.0 - dark), 100.0 * mean.error / (255.0 - dark))
                }),
            ),
        ],
    );
    linear.draw(&mut page, corner(1, 0), CHART);

    let n = 2.0 * (seen.spectra[0].len() - 1) as f64;
    let spectrum = |i: usize| seen.spectra[i].iter().enumerate().map(move |(f, p)| (f as f64 / n, *p));
    let level =
        |i: usize| if i == 0 { exposure.dark_noise_dn.powi(2) - rows(seen) } else { exposure.dark_noise_dn.powi(2) };
    let zero = |power: f64| vec![(0.0, power, 0.0)].into_iter();
    let spectra = chart(
        "Dark frames: power along the rows",
        Axis::even("cycles a pixel", -0.01, 0.5),
        Axis::log("[DN^2]", 0.5, 100.0),
        vec![
            curve(GREY, [0.0, 0.5].map(|f| (f, level(0))).into_iter()),
            curve(GREY, [0.0, 0.5].map(|f| (f, level(1))).into_iter()),
            curve(ORANGE, spectrum(1).skip(1)),
            curve(BLUE, spectrum(0).skip(1)),
            marks(ORANGE, zero(seen.spectra[1][0])),
            marks(BLUE, zero(seen.spectra[0][0])),
        ],
    );
    spectra.draw(&mut page, corner(0, 1), CHART);
    let (x, y) = corner(0, 1);
    legend(&mut page, (x + 90, y + 70), &[(BLUE, "rows stand out (as set)"), (ORANGE, "row noise and pattern off")]);
    page.words_in(x + 66, y + 120, "<- row means: frequency 0", GREY);

    let (x, y) = corner(1, 1);
    page.words(x, y + 12, "Dark frames, 120 x 120 pixels, 9 to 15 DN");
    for (i, (frame, words)) in
        seen.frames.iter().zip(["rows stand out (as set)", "row noise and pattern off"]).enumerate()
    {
        let left = x + 20 + i as u32 * (CUT * ZOOM + 30);
        let columns = frame.len() as u32 / seen.scene.size.rows as u32;
        let picture = RgbImage::from_fn(CUT * ZOOM, CUT * ZOOM, |px, py| {
            let dn = frame[(py / ZOOM * columns + px / ZOOM) as usize];
            let grey = ((f32::from(dn) - 9.0) / 6.0).clamp(0.0, 1.0) * 255.0;
            Rgb([grey as u8; 3])
        });
        page.picture(left, y + 40, &picture);
        page.words_in(left, y + 40 + CUT * ZOOM + 16, words, [BLUE, ORANGE][i]);
    }
    let words = "mean 11.6, sd 1.09 DN in both";
    page.words_in(x + 20, y + 40 + CUT * ZOOM + 34, words, INK);
    page.0
}

/// Variance that rows have of their own [DN^2].
fn rows(seen: &Seen) -> f64 {
    let exposure = seen.scene.bench.exposure;
    exposure.row_noise_dn.powi(2) + exposure.row_pattern_dn.powi(2)
}
