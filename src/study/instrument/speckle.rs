//! Speckle as production makes it, against the theory of [`super::pattern`].
//!
//! - Contrast in frames of an evenly lit white plane without noise, for eight pixels from 1.2 to 12 um.
//! - The law of one pixel, read off the pattern itself ([`Tiles`]) at pixels far enough apart to be independent: distance of
//!   Kolmogorov and Smirnov to the law of Karhunen and Loeve's exponential parts. Mean and contrast of a pattern are its own.
//! - Correlation along columns and rows, and between profiles: the pattern lies on the object, so that profile n + j shows
//!   that of profile n moved by j step rows/mm rows, and less of it, since it boils.
//! - Patterns of the stack before pixels (`speckle_stack`).
//! - Spread of the line's centre on a plane of speckle alone, through production's Range.
//!
//! Repeats have patterns of their own, since all columns and profiles of one share a pattern of 128 by 128 pixels.

use serde_json::json;

use super::beam::{lens_variance, rows_per_mm};
use super::centre::beyond_first_order;
use super::pattern::{Correlation, Law, boiled, grain_px, pupils};
use super::setup::stream;
use super::speckle_look::{
    centre, contrast, correlations, law, lined, middle, middle_line, neighbours, skewness, stack, sum_of_line, white,
};
use super::{Figure, Trials, chance, document, each, repeat, speckle_page, speckle_stack, table};
use crate::optics::speckle::Tiles;
use crate::study::{Report, Watch};
use crate::transport::answer::Estimate;

/// Pixels whose contrast is measured [um].
pub(super) const PIXELS: [f64; 8] = [1.2, 2.4, 3.45, 4.8, 5.5, 6.0, 9.0, 12.0];
/// The sensor's own.
pub(super) const OWN: usize = 5;
/// Profiles that go once around a pattern, and those whose contrast is taken: together they show all of it.
pub(super) const ROUND: usize = 190;
pub(super) const EVERY: usize = 27;
/// Patterns averaged in light from below.
pub(super) const BELOW: usize = 4;
/// Waist of the line under which patterns are looked at [mm].
pub(super) const BROAD_MM: f64 = 2.0;
/// Largest lag in pixels, and largest number of profiles apart.
pub(super) const LAGS: usize = 4;
pub(super) const APART: usize = 5;
/// Lags between profiles, in rows, that are looked at.
pub(super) const AHEAD: std::ops::RangeInclusive<i64> = -2..=6;
/// Scales of contrast at which the line's centre is measured.
pub(super) const STRENGTHS: [f64; 2] = [0.5, 1.0];
/// Waists of the lines whose centre is measured [mm].
pub(super) const WAISTS: [f64; 3] = [0.05, 0.1, 0.2];

/// What has to be known.
const NOTES: [&str; 1] =
    ["Mean and contrast of a pattern are its own; grains in steps of 3 %, contrast carried over by Goodman's ratio."];

struct Found {
    /// Contrast by pixel [1].
    contrast: Vec<f64>,
    /// Correlation at lags 1.. along columns and along rows [1].
    lags: [Vec<f64>; 2],
    /// Correlation between profiles by distance and lag, over that at lag 0 [1].
    profiles: Vec<Vec<f64>>,
    /// Independent pixels of the pattern at 6 um, for light from the surface and from below, and at 1.2 um [1].
    laws: [Vec<f64>; 3],
    /// Correlation of neighbouring columns behind 12 um [1].
    wide: f64,
    /// Spread of the line's centre by waist and strength [px].
    centre: Vec<Vec<f64>>,
    /// Patterns before pixels.
    stack: speckle_stack::Found,
}

/// Everything that the picture shows.
pub(super) struct Seen {
    pub contrast: Vec<Estimate>,
    pub lags: [Vec<Estimate>; 2],
    /// Lag less movement, correlation, and number of profiles apart [px, 1].
    pub profiles: Vec<(f64, Estimate, usize)>,
    pub laws: Vec<(Vec<f64>, Law)>,
    /// Spread of the line's centre by waist and strength, what the sum over rows says of it, and the line's own width [px].
    pub centre: Vec<Vec<Estimate>>,
    pub sum: Vec<Vec<f64>>,
    pub line_px: Vec<f64>,
    pub own: Correlation,
    pub grain_um: f64,
    /// The pattern of the sensor's own pixels and that of 1.2 um, [rows, TILE] from fine rows a pixel apart [1].
    pub patterns: [Vec<f64>; 2],
    /// Patterns apart in Bergmann's stack, and correlation [1].
    pub boil: Vec<(f64, Estimate)>,
    /// Number of profiles, what is left of the pattern after them, and what theory says [1].
    pub left: Vec<(usize, Estimate, f64)>,
}

/// Makes the study.
pub fn study(trials: Trials, watch: Watch) -> Report {
    let found = repeat(trials, watch, |one| found(trials, one));
    let (figures, seen) = figures(trials, &found);
    let table = table("Speckle", trials, &figures, &NOTES);
    let mut json = document("speckle", trials, &figures);
    json["pixels_um"] = json!(PIXELS);
    json["contrast"] = json!(seen.contrast);
    json["between_profiles"] = seen
        .profiles
        .iter()
        .map(|(lag, c, n)| json!({ "profiles": n, "lag_less_movement_px": lag, "correlation": c }))
        .collect();
    Report { picture: speckle_page::draw(&seen, &table), table, json }
}

fn found(trials: Trials, one: u64) -> Found {
    let own = stream("speckle", trials, one);
    let tiles = Tiles::new(own.key());
    let (lags, profiles) = correlations(own.child("correlation"), &tiles);
    let grain = grain_px(&white(own, PIXELS[OWN]).bench);
    let lines = |(i, waist): (usize, &f64)| {
        let each =
            |strength: &f64| centre(&lined(own.child("line").index(i as u64), *waist, *strength, &tiles), &tiles);
        STRENGTHS.iter().map(each).collect()
    };
    Found {
        contrast: PIXELS.iter().map(|pixel| contrast(own.child("contrast"), *pixel, &tiles)).collect(),
        lags,
        profiles,
        laws: [law(&tiles, grain, 0, 2), law(&tiles, grain, 1, 2), law(&tiles, grain * PIXELS[OWN] / PIXELS[0], 0, 3)],
        wide: neighbours(&tiles, grain * PIXELS[OWN] / PIXELS[PIXELS.len() - 1]),
        centre: WAISTS.iter().enumerate().map(lines).collect(),
        stack: speckle_stack::found(own.child("stack")),
    }
}

fn figures(trials: Trials, found: &[Found]) -> (Vec<Figure>, Seen) {
    let own = stream("speckle", trials, 0);
    let tiles = Tiles::new(own.key());
    let bench = white(own, PIXELS[OWN]).bench;
    let grain = grain_px(&bench);
    let theory = |pixel: f64| Correlation::of(grain * PIXELS[OWN] / pixel);
    let coarse = theory(PIXELS[OWN]);
    let mut figures: Vec<_> = (0..PIXELS.len())
        .map(|i| {
            let name = format!("contrast behind {} um, grain {:.2} px [1]", PIXELS[i], grain * PIXELS[OWN] / PIXELS[i]);
            Figure::of(&name, &each(found, |f| f.contrast[i]), theory(PIXELS[i]).contrast())
        })
        .collect();
    let names = ["from the surface, 6 um", "from below, 6 um", "from the surface, 1.2 um"];
    let made = [grain, grain * PIXELS[OWN] / PIXELS[0]].map(|grain| stack(&tiles, grain).grain());
    let of = [Law::of(made[0], 1), Law::of(made[0], BELOW), Law::of(made[1], 1)];
    let mut laws = Vec::new();
    for (i, (name, law)) in names.iter().zip(of).enumerate() {
        let mut all: Vec<f64> = found.iter().flat_map(|f| f.laws[i].iter().copied()).collect();
        let distance = chance::distance(&mut all, |x| law.below(x));
        figures.push(Figure::distance(&format!("distance to the law, {name} [1]"), distance, all.len()));
        figures.push(Figure::of(
            &format!("skewness, {name} [1]"),
            &each(found, |f| skewness(&f.laws[i])),
            law.skewness(),
        ));
        laws.push((all, law));
    }
    for (way, name) in ["columns", "rows"].iter().enumerate() {
        for lag in 0..2 {
            let name = format!("correlation {} px apart along the {name} [1]", lag + 1);
            figures.push(Figure::of(&name, &each(found, |f| f.lags[way][lag]), coarse.at(lag as f64 + 1.0)));
        }
    }
    let last = PIXELS[PIXELS.len() - 1];
    let name = format!("correlation 1 px apart along the columns, {last} um [1]");
    figures.push(Figure::of(&name, &each(found, |f| f.wide), theory(last).at(1.0)));
    let size = white(own, PIXELS[OWN]).size;
    let move_px = bench.motion.step_mm * rows_per_mm(&bench, &size, 0.0);
    for n in [1, APART] {
        let expected: Vec<f64> = AHEAD.map(|lag| coarse.at(lag as f64 - n as f64 * move_px)).collect();
        let name = format!("movement of the pattern in {n} profile{} [px]", if n > 1 { "s" } else { "" });
        let near = n as f64 * move_px;
        figures.push(Figure::of(&name, &each(found, |f| middle(&f.profiles[n - 1], near)), middle(&expected, near)));
    }
    // Contrast and correlations are taken under a broad line, whose wave is flat.
    let mut broad = bench;
    broad.laser.waist_mm = BROAD_MM;
    let expected = |n: usize| boiled(grain, n as f64 * pupils(&broad, broad.motion.step_mm));
    // Lags that have something in common; further ones add noise alone.
    let left = |f: &Found, n: usize| {
        let near = |lag: i64| lag as f64 - n as f64 * move_px;
        let lags = || AHEAD.zip(&f.profiles[n - 1]).filter(|(lag, _)| near(*lag).abs() < 1.5);
        lags().map(|(_, c)| c).sum::<f64>() / lags().map(|(lag, _)| coarse.at(near(lag))).sum::<f64>()
    };
    for n in [1, APART] {
        let name = format!("left of the pattern after {n} profile{} [1]", if n > 1 { "s" } else { "" });
        figures.push(Figure::of(&name, &each(found, |f| left(f, n)), expected(n)));
    }
    figures.extend(speckle_stack::figures(&found.iter().map(|f| &f.stack).collect::<Vec<_>>()));
    let estimate = |number: &dyn Fn(&Found) -> f64| Estimate::of(each(found, number).iter().copied());
    let (mut centre, mut sum, mut line_px) = (Vec::new(), Vec::new(), Vec::new());
    for (w, waist) in WAISTS.into_iter().enumerate() {
        let (mut of_waist, mut sums) = (Vec::new(), Vec::new());
        for (s, strength) in STRENGTHS.into_iter().enumerate() {
            let scene = lined(own, waist, strength, &tiles);
            let contrast = strength * coarse.contrast();
            let theory = sum_of_line(&scene, contrast, &tiles).sqrt()
                * beyond_first_order(&middle_line(&scene, &tiles), &laws[0].1, strength);
            let name = format!("spread of the centre, w {waist} mm, C {contrast:.3} [px]");
            figures.push(Figure::of(&name, &each(found, |f| f.centre[w][s]), theory));
            of_waist.push(estimate(&|f| f.centre[w][s]));
            sums.push(theory);
        }
        centre.push(of_waist);
        sum.push(sums);
        let laser = 0.5 * waist * rows_per_mm(&bench, &size, 0.0);
        line_px.push((laser * laser + lens_variance(&bench, &size) + 1.0 / 12.0).sqrt());
    }
    let profiles = (1..=APART).flat_map(|n| AHEAD.enumerate().map(move |(i, lag)| (n, i, lag)));
    let seen = Seen {
        contrast: (0..PIXELS.len()).map(|i| estimate(&|f| f.contrast[i])).collect(),
        lags: [0, 1].map(|way| (0..LAGS).map(|lag| estimate(&|f| f.lags[way][lag])).collect()),
        profiles: profiles
            .map(|(n, i, lag)| (lag as f64 - n as f64 * move_px, estimate(&|f| f.profiles[n - 1][i]), n))
            .collect(),
        laws,
        centre,
        sum,
        line_px,
        own: coarse.clone(),
        grain_um: grain * PIXELS[OWN],
        patterns: [OWN, 0].map(|i| law(&tiles, grain * PIXELS[OWN] / PIXELS[i], 0, 1)),
        left: (1..=APART).map(|n| (n, estimate(&|f| left(f, n)), expected(n))).collect(),
        boil: speckle_stack::STEPS.iter().enumerate().map(|(i, u)| (*u, estimate(&|f| f.stack.alike[i]))).collect(),
    };
    (figures, seen)
}
