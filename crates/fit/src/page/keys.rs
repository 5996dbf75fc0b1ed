//! The keys: what was believed, what is known now, and which of them cannot be told apart.

use drawing::html::format::{behind, counted, ends, short};
use maud::{Markup, html};
use output_schema::unit_of;
use recipe::Distribution;

use super::svg::{self, DrawnAxis};
use crate::result::{Fit, FittedKey, KeyState};

/// Share of a prior without bounds that is left out at either end of its axis.
const TAIL: f64 = 0.002;
/// What two columns hold.
const WIDTH: &str = "Width of the posterior over that of the prior, in scores";
const WIDENED: &str = "By how much the check on simulated scans with known values has widened the posterior";

/// The section.
pub(super) fn section(fit: &Fit) -> Markup {
    html! {
        @if fit.keys.is_empty() { p.note { "No key was fitted." } }
        @else {
            p {
                strong { "Determined" } ": the scans narrow the key. "
                strong { "Weak" } ": it moves statistics, but other keys can make up for it; where the posterior is \
                    no narrower than the prior, the recipe keeps the prior. "
                strong { "Undetermined" } ": over its whole prior it moves no statistic beyond its scatter from scan \
                    to scan; "
                "the recipe keeps its distribution. Bars are draws of the posterior over the range of the prior."
            }
            ul.key aria-label="Lines" {
                li { span.swatch.after {} "fitted, 5, 50 and 95 %" }
                li { span.swatch.before {} "before, 5, 50 and 95 %" }
            }
            div.scroll {
                table.keys {
                    thead { tr {
                        th scope="col" { "Key" }
                        th scope="col" { "Unit" }
                        th scope="col" { "State" }
                        th.n scope="col" { "Before, 90 %" }
                        th.n scope="col" { "Fitted, median and 90 %" }
                        th scope="col" { "Draws" }
                        th scope="col" { "Moves most" }
                        th.n scope="col" { abbr title=(WIDTH) { "Width" } }
                        th.n scope="col" { abbr title=(WIDENED) { "Widened" } }
                    } }
                    tbody { @for key in &fit.keys { (row(fit, key)) } }
                }
            }
            (pairs(fit))
        }
    }
}

fn row(fit: &Fit, key: &FittedKey) -> Markup {
    let is_told = key.state != KeyState::Undetermined;
    let unit = unit_of(key.parameter.name);
    let title = if is_told {
        format!("{}: before {}, fitted {}{}", key.path, ends(key.before), ends(key.after), behind(unit))
    } else {
        format!("{}: before {}{}, undetermined", key.path, ends(key.before), behind(unit))
    };
    html! {
        tr class=(key.state.name()) {
            th scope="row" { code title=(key.parameter.doc) { (key.path) } }
            td data-label="Unit" { @if unit == "1" { span.dim { "none" } } @else { (unit) } }
            td data-label="State" { span.state { (key.state.name()) } }
            td.n data-label="Before, 90 %" { (ends(key.before)) }
            @if is_told {
                td.n data-label="Fitted" {
                    strong { (short(key.after[1])) } br; (ends(key.after))
                    @if !key.of_scans.is_empty() { (of_scans(fit, key)) }
                }
            } @else {
                td data-label="Fitted" { p.say { "The scans say nothing about it; the recipe keeps its \
                    distribution." } }
            }
            td.drawing data-label="Draws" {
                @if let Some(axis) = axis(key) {
                    (svg::histogram(axis, &key.draws, is_told.then_some(key.after), key.before, &title))
                }
            }
            td data-label="Moves most" {
                @if key.moves.0.is_empty() { span.dim { "nothing" } }
                @else { (key.moves.0) ", by " (short(key.moves.1)) " deviations" }
            }
            td.n data-label="Width" { (short(key.width)) }
            td.n data-label="Widened" { (short(key.widening)) }
        }
    }
}

/// Intervals of each scan, where each has its own.
fn of_scans(fit: &Fit, key: &FittedKey) -> Markup {
    html! {
        details.each {
            summary { "each of " (counted(key.of_scans.len(), "scan")) }
            ul {
                @for (i, three) in key.of_scans.iter().enumerate() {
                    li {
                        @match fit.scans.get(i) { Some(scan) => (scan.name), None => { "scan " (i + 1) } }
                        ": " (short(three[1])) " (" (ends(*three)) ")"
                    }
                }
            }
        }
    }
}

/// The range of a key's prior: its bounds, or where these lie far beyond what it draws, nearly all of its draws.
fn axis(key: &FittedKey) -> Option<DrawnAxis> {
    let (min, max) = key.prior.bounds(key.parameter);
    let (low, high) = match &key.prior {
        Distribution::Normal { .. } | Distribution::Lognormal { .. } | Distribution::Truncated { .. } => {
            let [low, high] = [TAIL, 1.0 - TAIL].map(|share| key.prior.quantile(key.parameter, share));
            (low.max(min), high.min(max))
        }
        _ => (min, max),
    };
    DrawnAxis::new(low, high, key.is_log)
}

fn pairs(fit: &Fit) -> Markup {
    html! {
        h3 { "Keys that cannot be told apart" }
        @if fit.pairs.is_empty() { p { "None: no two keys go together in what is known of them." } }
        @else {
            p {
                "Along these pairs the scans fix a combination, not each key. A measurement of one of the two by \
                    other means "
                "settles the other."
            }
            ul.pairs {
                @for ([a, b], r) in &fit.pairs {
                    li {
                        code { (a) } " and " code { (b) } ": correlation " (short(*r))
                        @if *r > 0.0 { ", they rise together" } @else { ", one rises as the other falls" }
                    }
                }
            }
        }
    }
}
