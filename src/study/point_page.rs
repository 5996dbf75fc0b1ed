//! The picture of the study of a point: maps with their contours, and charts of aspect and angle.

use glam::DVec2;
use image::{Rgb, RgbImage};

use super::by::By;
use super::colour;
use super::point::{ACROSS, CELL_MM, Case, Contour, Spot};
use crate::drawing::chart::{Axis, Chart, Series};
use crate::drawing::{LETTER, MARGIN, Page, viridis};

/// Side of a map [px], and what it shows on either side of the point [mm].
const SIDE: u32 = 330;
const REACH_MM: f64 = 3.3;
const HEAD: u32 = 40;
const FOOT: u32 = 50;
const CHART: u32 = 400;
/// Ends of the scale of light [mm^-2].
const LEAST: f64 = 1e-5;
const MOST: f64 = 10.0;
const WHITE: Rgb<u8> = Rgb([255, 255, 255]);
const FIBRE: Rgb<u8> = Rgb([255, 120, 60]);
const GREY: Rgb<u8> = Rgb([150, 150, 150]);
/// How far an angle may be off [deg].
const BAR_DEG: f64 = 1.6;

pub(super) fn draw(cases: &[Case]) -> RgbImage {
    let row = HEAD + SIDE + FOOT;
    let width = By::all().count() as u32 * (SIDE + MARGIN);
    let mut page = Page::new(MARGIN + width, cases.len() as u32 * row + CHART + MARGIN);
    for (i, case) in cases.iter().enumerate() {
        let top = i as u32 * row;
        let title = format!("{}: light of a point, fibre at {} deg", case.title, case.drawn());
        page.words(MARGIN, top + 16, &title);
        let spots = case.spots.iter().filter(|spot| spot.azimuth == case.drawn());
        for (column, spot) in spots.enumerate() {
            let left = MARGIN + column as u32 * (SIDE + MARGIN);
            let name = spot.by.name();
            page.words_in(left, top + HEAD - 6, name, colour(spot.by));
            page.words(left + LETTER * (name.len() as u32 + 2), top + HEAD - 6, &spot.note);
            map(&mut page, (left, top + HEAD), spot, case);
        }
        let ramp = |t: f32| viridis(t);
        page.bar(MARGIN, top + HEAD + SIDE + 8, SIDE, ("1e-5", "log scale  10 per mm2"), &ramp);
        let words =
            "white: equal light at 0.5, 1, 1.5 mm across the fibre; orange: the fibre; x right, y (motion) down";
        page.words(2 * MARGIN + SIDE, top + HEAD + SIDE + 17, words);
    }
    let top = cases.len() as u32 * row;
    let charts: Vec<_> = cases.iter().map(aspects).chain([angles(&cases[0])]).collect();
    let pitch = width / charts.len() as u32;
    for (column, chart) in charts.iter().enumerate() {
        chart.draw(&mut page, (MARGIN + column as u32 * pitch, top), (pitch - MARGIN, CHART));
    }
    page.0
}

fn map(page: &mut Page, (left, top): (u32, u32), spot: &Spot, case: &Case) {
    let contours = match &spot.found {
        Ok(contours) => contours,
        Err(reason) => return page.words(left, top + 20, reason),
    };
    let side = libm::sqrt(spot.map.len() as f64) as i64;
    let mm = |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(SIDE) * 2.0 * REACH_MM - REACH_MM;
    let cell = |mm: f64| ((mm / CELL_MM).round() as i64 + side / 2).clamp(0, side - 1);
    let picture = RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let light = spot.map[(cell(mm(y)) * side + cell(mm(x))) as usize] / (CELL_MM * CELL_MM);
        viridis((libm::log(light.max(LEAST) / LEAST) / libm::log(MOST / LEAST)) as f32)
    });
    page.picture(left, top, &picture);
    let pixel = |place: DVec2| {
        let at = |v: f64| (v + REACH_MM) / (2.0 * REACH_MM) * f64::from(SIDE);
        (f64::from(left) + at(place.x), f64::from(top) + at(place.y))
    };
    let inside = |place: &DVec2| place.abs().max_element() < REACH_MM;
    for contour in ACROSS.iter().zip(contours).filter(|(across, _)| (*across * 2.0).fract() == 0.0) {
        let Some(Contour { ellipse, .. }) = contour.1 else { continue };
        let at = |i: u32| {
            let (sin, cos) = libm::sincos(f64::from(i) * std::f64::consts::TAU / 180.0);
            ellipse.centre + ellipse.frame() * DVec2::new(cos, sin)
        };
        for i in 0..180 {
            let (from, to) = (at(i), at(i + 1));
            if inside(&from) && inside(&to) {
                page.line(pixel(from), pixel(to), WHITE, 1);
            }
        }
    }
    let (x, y) = libm::sincos(spot.azimuth.to_radians());
    let flat = libm::cos(case.wood.dive.to_radians());
    for sign in [-1.0, 1.0] {
        let way = sign * DVec2::new(x, y);
        page.line(pixel((3.1 - 0.5 * flat) * way), pixel(3.1 * way), FIBRE, 2);
    }
    let (x, y) = pixel(DVec2::new(-3.0, 3.0));
    let (end, _) = pixel(DVec2::new(-2.0, 3.0));
    page.line((x, y), (end, y), WHITE, 3);
    page.words_in(end as u32 + 6, y as u32 + 4, "1 mm", WHITE);
}

fn aspects(case: &Case) -> Chart {
    let axis = Axis::even("half diameter across the fibre [mm]", 0.0, 1.6);
    let (low, high) = if case.far() > 1.5 { (0.0, 4.0) } else { (0.6, 1.6) };
    let mut series = vec![
        Series {
            name: "diffusion, far away".into(),
            colour: GREY,
            points: vec![(0.0, case.far(), 0.0), (1.6, case.far(), 0.0)],
            joined: true,
        },
        Series { name: "docs/physics.md".into(), colour: GREY, points: vec![(1.5, case.known, 0.0)], joined: false },
    ];
    for by in By::all() {
        let spots = || case.spots.iter().filter(move |spot| spot.by == by);
        let at = |i: usize| {
            let found: Vec<_> = spots().filter_map(|s| s.found.as_ref().ok()?[i]).collect();
            let n = found.len() as f64;
            let mean = found.iter().map(|c| c.aspect.value).sum::<f64>() / n;
            let error = found.iter().map(|c| c.aspect.error * c.aspect.error).sum::<f64>().sqrt() / n;
            (!found.is_empty()).then_some((ACROSS[i], mean, error))
        };
        let points = (0..ACROSS.len()).filter_map(at).collect();
        series.push(Series { name: by.name().into(), colour: colour(by), points, joined: true });
    }
    let title = if case.wood.dive > 0.0 { "Sound knot" } else { "Clear wood" };
    Chart {
        title: title.into(),
        x: axis,
        y: Axis::even("half diameter along over across", low, high),
        series,
        foot: (String::new(), GREY),
    }
}

fn angles(case: &Case) -> Chart {
    let flat = |off: f64| Series {
        name: String::new(),
        colour: GREY,
        points: vec![(0.0, off, 0.0), (90.0, off, 0.0)],
        joined: true,
    };
    let mut series = vec![flat(BAR_DEG), flat(-BAR_DEG)];
    for by in By::all() {
        let last = |spot: &Spot| spot.found.as_ref().ok()?.last().copied().flatten().map(|c| (spot.azimuth, c));
        let spots = case.spots.iter().filter(|spot| spot.by == by).filter_map(last);
        // Side by side, so that none hides another.
        let aside = 1.2 * series.len() as f64 - 4.8;
        let points = spots.map(|(azimuth, c)| (azimuth + aside, c.off.value, c.off.error)).collect();
        series.push(Series { name: by.name().into(), colour: colour(by), points, joined: false });
    }
    Chart {
        title: "Clear wood, 1.5 mm across the fibre".into(),
        x: Axis::even("azimuth of the fibre [deg]", -5.0, 95.0),
        y: Axis::even("long axis less fibre [deg]; grey: 1.6 deg", -12.0, 16.0),
        series,
        foot: (String::new(), GREY),
    }
}
