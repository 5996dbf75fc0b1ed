//! SVG drawings: histograms stacked by class, and paths.

use std::fmt::Write;

use maud::{Markup, html};

use crate::report::histogram::{Histogram, HistogramAxis};
use drawing::html::format::number;

/// Size of a histogram's drawing, and of its bars.
const HISTOGRAM_WIDTH: f64 = 200.0;
const HISTOGRAM_HEIGHT: f64 = 60.0;

/// Bars stacked by class, a curve of what is expected, a line for what is declared, and the ends of the axis.
pub(super) fn histogram(cells: &Histogram, curve: &[f64], declared: Option<(f64, f64)>, title: &str) -> Markup {
    let n = cells.axis.bins();
    let most = curve.iter().copied().fold(cells.most().max(1) as f64, |a, b| if b < 2.0 * a { a.max(b) } else { a });
    let scale = HISTOGRAM_HEIGHT / most;
    let step = HISTOGRAM_WIDTH / n as f64;
    let mut below = vec![0u64; n];
    let mut paths = Vec::new();
    for (class, counts) in cells.counts.iter().enumerate() {
        let mut path = String::new();
        for (cell, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let (top, high) = (HISTOGRAM_HEIGHT - (below[cell] + count) as f64 * scale, count as f64 * scale);
            // A bar, half a unit apart from the next one.
            let (left, wide) = (cell as f64 * step + 0.25, step - 0.5);
            let _ = write!(path, "M{left:.1} {top:.1}h{wide:.1}v{high:.1}h-{wide:.1}z");
            below[cell] += count;
        }
        paths.push((class, path));
    }
    let x = |value: f64| (cells.axis.place(value) * HISTOGRAM_WIDTH).clamp(0.0, HISTOGRAM_WIDTH);
    let point = |(i, value): (usize, &f64)| {
        let x = i as f64 / (curve.len() - 1).max(1) as f64 * HISTOGRAM_WIDTH;
        [x, (HISTOGRAM_HEIGHT - value * scale).max(-4.0)]
    };
    let line = polyline(curve.iter().enumerate().map(point), 1);
    let (left, right) = match cells.axis {
        HistogramAxis::Linear(min, max) | HistogramAxis::Log(min, max) | HistogramAxis::Whole(min, max) => (min, max),
    };
    html! {
        svg.histogram viewBox="0 -4 200 86" role="img" aria-label=(title) {
            g.bars { @for (class, path) in paths.iter().filter(|(_, path)| !path.is_empty()) {
                path class={ "c" (class) } data-c=(class) d=(path) {}
            } }
            line.axis x1="0" x2="200" y1="60" y2="60" {}
            @if let Some((min, max)) = declared {
                line.declared x1=(format!("{:.1}", x(min))) x2=(format!("{:.1}",
                    x(max).max(x(min) + 1.0))) y1="64" y2="64" {}
            }
            @if !line.is_empty() { path.curve d=(line) {} }
            text x="0" y="78" { (number(left)) }
            text x="200" y="78" text-anchor="end" { (number(right)) }
            @if matches!(cells.axis, HistogramAxis::Log(..)) { text.dim x="100" y="78" text-anchor="middle" {
                "logarithmic" } }
        }
    }
}

/// A path through the places that are there; one that is not breaks it.
pub(super) fn polyline(points: impl Iterator<Item = [f64; 2]>, digits: usize) -> String {
    let (mut path, mut drawing) = (String::new(), false);
    for [x, y] in points {
        if x.is_finite() && y.is_finite() {
            let _ = write!(path, "{}{x:.digits$} {y:.digits$}", if drawing { 'L' } else { 'M' });
        }
        drawing = x.is_finite() && y.is_finite();
    }
    path
}
