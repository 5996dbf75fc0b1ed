//! Statistics of each real scan beside those of simulated ones.

use drawing::html::format::{counted, ends, short, signed};
use maud::{Markup, html};

use super::svg;
use crate::result::{Fit, ScanFit, StatisticFit};

/// Scans whose tables are open.
const OPEN: usize = 2;
/// What two columns hold.
const DEVIATIONS: &str = "Distance in deviations of fitted scans";
const ERRORS: &str = "Distance in standard errors of the real scan, from its halves";

/// The section.
pub(super) fn section(fit: &Fit) -> Markup {
    let out = fit.reach()[0];
    html! {
        @if fit.scans.is_empty() { p.note { "There is no real scan." } }
        @else {
            p {
                "Each statistic of a real scan with one standard error either way, from halves of the scan, beside 5, \
                    50 and 95 % of "
                "simulated scans. Distances are those of the real scan from fitted ones: in deviations of these from \
                    scan to scan, and "
                "in standard errors of the real scan. A statistic is out of reach where both are more than 3, or the \
                    first where "
                "halves do not tell the second. A drawing spans what its row holds, in a logarithmic scale where that \
                    is wide."
            }
            ul.key aria-label="Lines" {
                li { span.swatch.before {} "recipe as it was" }
                li { span.swatch.after {} "fitted recipe" }
                li { span.swatch.real {} "real scan, with its standard error below" }
            }
            label.switch { input type="checkbox" id="only-out"; " Only what is out of reach (" (out) ")" }
            @for (i, scan) in fit.scans.iter().enumerate() { (of_scan(scan, i < OPEN)) }
        }
    }
}

fn of_scan(scan: &ScanFit, is_open: bool) -> Markup {
    let (told, untold): (Vec<&StatisticFit>, Vec<&StatisticFit>) =
        scan.statistics.iter().partition(|statistic| statistic.real.is_some());
    let out = told.iter().filter(|statistic| statistic.is_out_of_reach()).count();
    html! {
        details.group open[is_open] {
            summary { (scan.name) " " small { (out) " of " (counted(told.len(), "statistic")) " out of reach" } }
            @if told.is_empty() { p.note { "The real scan tells none of the statistics." } }
            @else {
                div.scroll {
                    table.statistics {
                        thead { tr {
                            th scope="col" { "Statistic" }
                            th.n scope="col" { "Real" }
                            th scope="col" { "Drawing" }
                            th.n scope="col" { "Before: median, 90 %" }
                            th.n scope="col" { "Fitted: median, 90 %" }
                            th.n scope="col" { abbr title=(DEVIATIONS) { "Deviations" } }
                            th.n scope="col" { abbr title=(ERRORS) { "Errors" } }
                            th scope="col" { "Reach" }
                        } }
                        tbody { @for statistic in &told { (row(statistic)) } }
                    }
                    @if out == 0 { p.none-out.note { "None of them is out of reach." } }
                }
            }
            @if !untold.is_empty() {
                details.untold {
                    summary { (counted(untold.len(), "statistic")) " that the real scan does not tell" }
                    p { "Too few pixels tell them, or the map that they are of is missing; they play no part in the \
                        fit." }
                    ul { @for statistic in &untold { li { (statistic.name) } } }
                }
            }
        }
    }
}

fn row(statistic: &StatisticFit) -> Markup {
    let is_out = statistic.is_out_of_reach();
    let real = statistic.real.unwrap_or(f64::NAN);
    html! {
        tr.out[is_out].in-reach[!is_out] {
            th scope="row" title=(statistic.key) {
                (statistic.name)
                @if statistic.unit != "1" { " " span.dim { "[" (statistic.unit) "]" } }
            }
            td.n data-label="Real" {
                strong { (short(real)) }
                @if let Some([low, high]) = statistic.real_ends { br; (short(low)) " to " (short(high)) }
            }
            td.drawing data-label="Drawing" { (svg::strip(statistic.before, statistic.after, real,
                statistic.real_ends)) }
            (interval("Before", statistic.before))
            (interval("Fitted", statistic.after))
            td.n data-label="Deviations" { (signed(statistic.from_scatter)) }
            td.n data-label="Errors" { (signed(statistic.from_halves)) }
            td data-label="Reach" {
                @if is_out { strong.alarm { "out of reach" } }
                @else if statistic.after.is_none() { "not simulated" }
                @else { span.dim { "within" } }
            }
        }
    }
}

fn interval(label: &str, three: Option<[f64; 3]>) -> Markup {
    html! {
        td.n data-label=(label) {
            @match three {
                Some(three) => { (short(three[1])) br; (ends(three)) }
                None => { "-" }
            }
        }
    }
}
