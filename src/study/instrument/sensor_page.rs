//! The picture of the study of the sensor.

use image::{Rgb, RgbImage};

use super::page::{BLUE, CHART, GREEN, GREY, ORANGE, PURPLE, chart, corner, curve, legend, marks, page};
use super::sensor::Seen;
use super::setup::gain;
use crate::drawing::chart::Axis;
use crate::drawing::{INK, Page};

/// Side of a cut of a dark frame [px], and pixels of the page for each of its.
const CUT: u32 = 120;
const ZOOM: u32 = 2;

pub(super) fn draw(seen: &Seen, table: &str) -> RgbImage {
    let exposure = seen.scene.bench.exposure;
    let heading = (
        "The sensor by photon transfer",
        "A white plane under a broad line without speckle, exposed again and again; read off digital numbers alone. Grey: theory.",
    );
    let mut page = page(2, 3, heading, table);
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
    slopes(&mut page, seen);
    page.0
}

/// Numbers and noise over light with one slope and with two.
fn slopes(page: &mut Page, seen: &Seen) {
    const COLOURS: [Rgb<u8>; 4] = [BLUE, ORANGE, PURPLE, GREEN];
    let light = || Axis::log("light / light that fills one slope", 0.03, 20.0);
    for (place, title, axis) in [
        (0, "Two slopes: mean less dark", Axis::even("[DN]", 0.0, 260.0)),
        (1, "Two slopes: variance in time", Axis::even("[DN^2]", 0.0, 4.0)),
    ] {
        let theory = seen.modes.iter().map(|mode| curve(GREY, mode.expected.iter().map(|v| (v[0], v[1 + place]))));
        let measured = seen.modes.iter().zip(COLOURS);
        let measured =
            measured.map(|(mode, colour)| marks(colour, mode.seen.iter().map(|v| (v[0], v[1 + place], 0.0))));
        let place = corner(place as u32, 2);
        chart(title, light(), axis, theory.chain(measured).collect()).draw(page, place, CHART);
        let names: Vec<_> =
            COLOURS.into_iter().zip(&seen.modes).map(|(colour, mode)| (colour, mode.hdr.name())).collect();
        legend(page, (place.0 + 90, place.1 + 70), &names);
    }
}

/// Variance that rows have of their own [DN^2].
fn rows(seen: &Seen) -> f64 {
    let exposure = seen.scene.bench.exposure;
    exposure.row_noise_dn.powi(2) + exposure.row_pattern_dn.powi(2)
}
