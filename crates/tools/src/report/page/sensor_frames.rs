//! Sensor frames with the line that extraction finds, and the profile that it makes.

use maud::{Markup, html};

use super::svg::polyline;
use crate::report::exposed_profile::ExposedProfile;
use crate::report::page_data::PageData;
use crate::report::palette::frame_png;
use drawing::html::{
    data_url,
    format::{name, number},
};
use optical_bench::split::Split;

/// The section.
pub(super) fn section(facts: &PageData) -> Markup {
    html! {
        @if facts.exposures.is_empty() {
            p.note { "No frame was exposed: the recipe cannot be read, its model of transport is a slow one, or \
                nothing was asked for." }
        } @else {
            p {
                "One exposure of each of " (facts.exposures.len()) " samples, made again from recipe, seed and index "
                @if facts.head.images.holds("label") { "through the part with most to see: " }
                @else { "through the middle: " }
                "the square root of digital numbers, the line that extraction finds, and below it the heights that it \
                    stands for."
            }
            div.frames { @for (sample, exposure) in &facts.exposures { (frame(facts, *sample, exposure)) } }
        }
    }
}

fn frame(facts: &PageData, place: usize, exposure: &ExposedProfile) -> Markup {
    let sample = &facts.samples[place];
    let class = facts.head.classes.get(sample.class).map_or("?", String::as_str);
    let rows = exposure.dn.len() / exposure.cols.max(1);
    let picture =
        frame_png(&exposure.dn, exposure.cols as u32, exposure.max_dn).map_or(String::new(), |png| data_url(&png));
    let found = exposure.line.iter().filter(|row| !row.is_nan()).count();
    let line = exposure.line.iter().enumerate();
    let line =
        polyline(line.map(|(column, row)| [column as f64 + 0.5, f64::from(*row) + 0.5 - exposure.first_row as f64]), 2);
    html! {
        article.frame data-class=(class) data-split=(Split::ALL[sample.split].name()) {
            h3 { "Sample " (sample.index) span class={ "tag c" (sample.class) } { i.dot {} (name(class)) } }
            p.dim {
                "profile " (exposure.profile) " of " (exposure.profiles) ", y = " (number(exposure.y_mm))
                " mm; sensor rows " (exposure.first_row) " to " (exposure.first_row + rows.saturating_sub(1)) " of "
                (facts.head.images.sensor_rows) "; found in " (found) " of " (exposure.cols) " columns"
            }
            svg.sensor viewBox={ "0 0 " (exposure.cols) " " (rows) } preserveAspectRatio="none" role="img"
                style={ "aspect-ratio:" (exposure.cols) "/" (rows.max(exposure.cols / 5)) }
                aria-label={ "Sensor frame of sample " (sample.index) " with the extracted line" } {
                image href=(picture) width=(exposure.cols) height=(rows) preserveAspectRatio="none"
                    style="image-rendering:pixelated" {}
                path.found d=(line) {}
            }
            (profile(exposure))
        }
    }
}

/// Height over the place along the laser line.
fn profile(exposure: &ExposedProfile) -> Markup {
    let known: Vec<[f64; 2]> =
        exposure.points.iter().filter(|[x, z]| x.is_finite() && z.is_finite()).copied().collect();
    let ends = |axis: usize| {
        known.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p[axis]), high.max(p[axis])))
    };
    let ((left, right), (low, high)) = (ends(0), ends(1));
    if known.len() < 2 || right <= left {
        return html! { p.note { "No line is found in this frame." } };
    }
    let (low, high) = (low - 0.05 * (high - low).max(0.02), high + 0.05 * (high - low).max(0.02));
    let (x, z) =
        (|v: f64| 44.0 + (v - left) / (right - left) * 350.0, |v: f64| 104.0 - (v - low) / (high - low) * 98.0);
    let line = polyline(exposure.points.iter().map(|p| [x(p[0]), z(p[1])]), 1);
    html! {
        svg.profile viewBox="0 0 400 136" role="img" aria-label="Profile: height over place along the laser line" {
            @for tick in drawing::round_ticks(low, high) {
                line.grid x1="44" x2="394" y1=(format!("{:.1}", z(tick))) y2=(format!("{:.1}", z(tick))) {}
                text x="40" y=(format!("{:.1}", z(tick) + 3.0)) text-anchor="end" { (number(tick)) }
            }
            @for tick in drawing::round_ticks(left, right) {
                line.axis x1=(format!("{:.1}", x(tick))) x2=(format!("{:.1}", x(tick))) y1="104" y2="108" {}
                text x=(format!("{:.1}", x(tick))) y="119" text-anchor="middle" { (number(tick)) }
            }
            line.axis x1="44" x2="394" y1="104" y2="104" {}
            path.line d=(line) {}
            text x="394" y="132" text-anchor="end" { "x along the laser line [mm]" }
            text x="0" y="132" { "height z [mm]" }
        }
    }
}
