//! SVG drawings: an axis of numbers, a histogram of draws, a strip of intervals.

use std::fmt::Write;

use drawing::html::format::{number, short};
use maud::{Markup, html};

/// Bars of a histogram.
const BARS: usize = 40;
/// Width of a drawing's inside.
const WIDTH: f64 = 200.0;
/// Height of a histogram's bars.
const HEIGHT: f64 = 44.0;
/// Ratio of the largest to the smallest number from which a strip is logarithmic.
const WIDE: f64 = 30.0;

/// An axis from `low` to `high`, both finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DrawnAxis {
    low: f64,
    high: f64,
    is_log: bool,
}

impl DrawnAxis {
    /// From `low` to `high`; where they are one number, around it. `None` where a number is not finite.
    pub fn new(low: f64, high: f64, is_log: bool) -> Option<Self> {
        if !low.is_finite() || !high.is_finite() || high < low {
            return None;
        }
        let is_log = is_log && low > 0.0;
        let (low, high) = match high > low {
            true => (low, high),
            false if is_log => (low / 2.0, low * 2.0),
            false => (low - 0.5 * low.abs().max(1.0), low + 0.5 * low.abs().max(1.0)),
        };
        Some(Self { low, high, is_log })
    }

    /// That holds these numbers, logarithmic where they spread widely above 0.
    pub fn around(numbers: &[f64]) -> Option<Self> {
        let finite = || numbers.iter().copied().filter(|x| x.is_finite());
        let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
        Self::new(low, high, low > 0.0 && high > WIDE * low)
    }

    /// Whether it is logarithmic.
    pub fn is_log(&self) -> bool {
        self.is_log
    }

    /// Where a number lies, 0 at the left end, 1 at the right one; numbers beyond lie at the ends.
    pub fn place(&self, value: f64) -> f64 {
        let scale = |x: f64| if self.is_log { libm::log(x.max(f64::MIN_POSITIVE)) } else { x };
        let (low, high) = (scale(self.low), scale(self.high));
        let t = (scale(value) - low) / (high - low);
        if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.5 }
    }

    fn x(&self, value: f64) -> String {
        format!("{:.1}", self.place(value) * WIDTH)
    }
}

/// Draws as bars, below them the inner 90 % of the posterior and that of the prior, each with its median.
pub(super) fn histogram(
    axis: DrawnAxis,
    draws: &[f64],
    after: Option<[f64; 3]>,
    before: [f64; 3],
    title: &str,
) -> Markup {
    let mut bars = [0_usize; BARS];
    for &draw in draws.iter().filter(|draw| draw.is_finite()) {
        bars[((axis.place(draw) * BARS as f64) as usize).min(BARS - 1)] += 1;
    }
    let most = bars.iter().copied().max().unwrap_or(0).max(1) as f64;
    let step = WIDTH / BARS as f64;
    let mut path = String::new();
    for (i, &n) in bars.iter().enumerate().filter(|(_, n)| **n > 0) {
        let high = n as f64 / most * HEIGHT;
        let (left, top, wide) = (i as f64 * step + 0.25, HEIGHT - high, step - 0.5);
        let _ = write!(path, "M{left:.2} {top:.1}h{wide:.2}v{high:.1}h-{wide:.2}z");
    }
    html! {
        svg.histogram viewBox="-2 -2 204 78" role="img" aria-label=(title) {
            @if !path.is_empty() { path.bars d=(path) {} }
            line.axis x1="0" x2="200" y1="44" y2="44" {}
            @if let Some(after) = after { (interval(axis, after, 50.0, "after")) }
            (interval(axis, before, 58.0, "before"))
            text x="0" y="73" { (number(axis.low)) }
            @if axis.is_log { text x="100" y="73" text-anchor="middle" { "logarithmic" } }
            text x="200" y="73" text-anchor="end" { (number(axis.high)) }
        }
    }
}

/// A bar from 5 to 95 % with a mark at the median.
fn interval(axis: DrawnAxis, [low, middle, high]: [f64; 3], y: f64, class: &str) -> Markup {
    let at = |y: f64| format!("{y:.1}");
    html! {
        @if low.is_finite() && middle.is_finite() && high.is_finite() {
            line class={ "interval " (class) } x1=(axis.x(low)) x2=(axis.x(high)) y1=(at(y)) y2=(at(y)) {}
            line class={ "median \
                " (class) } x1=(axis.x(middle)) x2=(axis.x(middle)) y1=(at(y - 3.5)) y2=(at(y + 3.5)) {}
        }
    }
}

/// Intervals of a statistic before and after the fit, and what the real scan has with its own spread, on one axis.
pub(crate) fn strip(
    before: Option<[f64; 3]>,
    after: Option<[f64; 3]>,
    real: f64,
    real_ends: Option<[f64; 2]>,
) -> Markup {
    let numbers: Vec<f64> =
        before.into_iter().chain(after).flatten().chain(real_ends.into_iter().flatten()).chain([real]).collect();
    let words = |three: Option<[f64; 3]>| {
        three.map_or("none".into(), |[low, _, high]| format!("{} to {}", short(low), short(high)))
    };
    html! {
        @if let Some(axis) = DrawnAxis::around(&numbers) {
            svg.strip viewBox="-4 0 208 26" role="img"
                aria-label={
                    "before " (words(before)) ", after " (words(after)) ", real " (short(real))
                    @if axis.is_log() { ", logarithmic" }
                } {
                @if let Some(before) = before { (interval(axis, before, 6.0, "before")) }
                @if let Some(after) = after { (interval(axis, after, 14.0, "after")) }
                line.real x1=(axis.x(real)) x2=(axis.x(real)) y1="1" y2="25" {}
                @if let Some([low, high]) = real_ends.filter(|ends| ends.iter().all(|end| end.is_finite())) {
                    line.real-ends x1=(axis.x(low)) x2=(axis.x(high)) y1="22" y2="22" {}
                    @for end in [low, high] { line.real-ends x1=(axis.x(end)) x2=(axis.x(end)) y1="20" y2="24" {} }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Places follow the axis, in either scale, and numbers beyond it lie at its ends.
    #[test]
    fn places_by_hand() {
        let even = DrawnAxis::new(2.0, 4.0, false).expect("an axis");
        let log = DrawnAxis::new(0.1, 10.0, true).expect("an axis");
        for (axis, value, place) in
            [(even, 3.0, 0.5), (even, 9.0, 1.0), (even, -9.0, 0.0), (log, 1.0, 0.5), (log, -1.0, 0.0)]
        {
            assert!((axis.place(value) - place).abs() < 1e-12, "{axis:?} {value}");
        }
        assert_eq!(DrawnAxis::new(f64::NAN, 1.0, false), None);
        assert!(DrawnAxis::around(&[0.01, 1.0]).is_some_and(|axis| axis.is_log()));
        assert!(DrawnAxis::around(&[0.0, 1.0]).is_some_and(|axis| !axis.is_log()));
        let one = DrawnAxis::new(0.0, 0.0, false).expect("an axis");
        assert_eq!(one.place(0.0), 0.5);
    }

    /// A histogram's highest bar is as high as the drawing, and every draw is in a bar.
    #[test]
    fn bars_stand_for_their_draws() {
        let axis = DrawnAxis::new(0.0, 40.0, false).expect("an axis");
        let draws = [0.5, 0.6, 10.5, 39.9, 40.0, 1e9, f64::NAN];
        let text = histogram(axis, &draws, None, [1.0, 2.0, 3.0], "t").into_string();
        let path = text.split(" d=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a path");
        let bars: Vec<&str> = path.split('M').skip(1).map(|bar| bar.split('h').next().unwrap_or("")).collect();
        assert_eq!(bars, ["0.25 14.7", "50.25 29.3", "195.25 0.0"]);
    }
}
