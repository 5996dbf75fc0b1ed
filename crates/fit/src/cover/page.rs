//! The page of `gen cover`: one HTML file without scripts, in the style of a fit's.

use drawing::html::format::{behind, counted, ends, percent, short};
use drawing::html::{HtmlPage, PageSection, sections};
use maud::{Markup, html};

use super::result::{Cover, CoverPlace, CoveredScan, CoveredStatistic};
use crate::page::{STYLE, svg};

/// Scans whose tables are open.
const OPEN: usize = 2;

impl Cover {
    /// One HTML file.
    pub fn page(&self) -> String {
        let content: Vec<PageSection> = if self.scans.is_empty() {
            vec![("keys", "What keys do", keys(self)), ("still", "What hardly varies", still(self))]
        } else {
            vec![("widen", "What to widen", widen(self)), ("scans", "Real scans", scans(self))]
        };
        let title = format!("What {} covers", self.recipe);
        let body = sections(header(self), html! {}, &content, "");
        HtmlPage { title: &title, style: &[STYLE], script: None }.around(body).into_string()
    }

    /// What was found, in one sentence.
    pub fn verdict(&self) -> String {
        let (outside, scans) = (self.outside(), self.scans.len());
        match () {
            () if scans == 0 => {
                let idle = self.keys.iter().filter(|key| key.is_idle).count();
                let [keys, still] = [counted(self.keys.len(), "drawn key"), counted(self.still.len(), "statistic")];
                let of = if self.classes.len() > 1 { "what is told by class" } else { "what a scan tells" };
                format!("Of {keys}, {idle} do nothing for {of}; {still} hardly vary.")
            }
            () if outside == 0 => {
                format!(
                    "The recipe covers {}: nothing of them lies outside of its spread.",
                    counted(scans, "real scan")
                )
            }
            () => {
                let of = counted(scans, "real scan");
                let tail = match self.widen.first() {
                    Some(first) => format!("first, {}.", first.words()),
                    None => "no key alone explains it: look at object, light and surroundings.".into(),
                };
                format!("Look at {outside} of {of}: outside of what the recipe makes; {tail}")
            }
        }
    }
}

fn header(cover: &Cover) -> Markup {
    let outside = cover.outside();
    html! {
        header.front {
            p.kind { "What a recipe covers" }
            h1 { (cover.recipe) }
            p.lead { (cover.verdict()) }
            p.state {
                @if cover.scans.is_empty() { "No real scan was given." }
                @else if outside > 0 { span.badge.bad { "look at this" } " " (counted(outside, "scan")) " outside" }
                @else { span.badge.good { "covered" } " every real scan" }
            }
            dl.facts {
                div { dt { "Recipe" } dd { (cover.recipe) } }
                div { dt { "Seed" } dd { (cover.seed) } }
                div { dt { "Simulated scans" } dd { (cover.simulations) } }
                @if !cover.scans.is_empty() { div { dt { "Real scans" } dd { (cover.scans.len()) } } }
                @if !cover.classes.is_empty() {
                    div.wide { dt { "Labelled classes" } dd { (cover.classes.join(", ")) } }
                }
            }
        }
    }
}

fn widen(cover: &Cover) -> Markup {
    html! {
        @if cover.outside() == 0 { p { "Nothing lies outside." } }
        @else if cover.widen.is_empty() {
            p.note {
                "Of " (counted(cover.asked, "key")) " none alone explains a tenth of what lies outside. Look at what \
                    no key is about: the object's shape, its surroundings, settings such as threshold and window."
            }
        } @else {
            p {
                "Each of " (counted(cover.asked, "key")) " was moved beyond what the recipe draws, alone. These \
                    explain most of what lies outside; two that do the same cannot be told apart by these scans."
            }
            div.scroll { table.keys {
                thead { tr {
                    th scope="col" { "Key" }
                    th.n scope="col" { "Drawn" }
                    th scope="col" { "What to do" }
                    th.n scope="col" { "Left of the squared distance" }
                    th scope="col" { "Then" }
                    th scope="col" { "Does the same" }
                } }
                tbody { @for key in &cover.widen {
                    tr {
                        th scope="row" { code title=(key.parameter.doc) { (key.path) } }
                        td.n data-label="Drawn" { (short(key.drawn[0])) " to " (short(key.drawn[1])) }
                        td data-label="What to do" { (key.words()) }
                        td.n data-label="Left" { (percent(key.left)) }
                        td data-label="Then" { @if key.covers { "covered" } @else { "still outside" } }
                        td data-label="Does the same" {
                            @if key.alike.is_empty() { span.dim { "none" } } @else { (key.alike.join(", ")) }
                        }
                    }
                } }
            } }
        }
    }
}

fn scans(cover: &Cover) -> Markup {
    let out: usize = cover.scans.iter().map(|scan| scan.counts()[2]).sum();
    html! {
        p {
            "Bars are 5, 50 and 95 % of simulated scans. A statistic lies at the edge beyond these, and outside where \
                it lies farther from the median than scans of the recipe do, all statistics together: each simulated \
                scan was asked the same among the others. " em { "Out" } " is the distance from the median over that \
                of the farthest simulated scan."
        }
        ul.key aria-label="Lines" {
            li { span.swatch.before {} "simulated scans" }
            li { span.swatch.real {} "real scan, with its standard error below" }
        }
        label.switch { input type="checkbox" id="only-out"; " Only what is outside (" (out) ")" }
        @for (i, scan) in cover.scans.iter().enumerate() { (of_scan(scan, i < OPEN)) }
    }
}

fn of_scan(scan: &CoveredScan, is_open: bool) -> Markup {
    let [inside, edge, outside] = scan.counts();
    let told = scan.statistics.iter().filter(|statistic| statistic.place.is_some());
    let untold: Vec<&CoveredStatistic> = scan.statistics.iter().filter(|statistic| statistic.place.is_none()).collect();
    html! {
        details.group open[is_open] {
            summary { (scan.name) " " small { (inside) " inside, " (edge) " at the edge, " (outside) " outside" } }
            p {
                "All together it lies " (short(scan.depth)) " from the middle, where the limit is " (short(scan.limit))
                ": " (percent(scan.share_beyond)) " of the recipe's own scans lie as far. "
                @if scan.depth > scan.limit { strong.alarm { "outside" } }
            }
            div.scroll { table.statistics {
                thead { tr {
                    th scope="col" { "Statistic" }
                    th.n scope="col" { "Real" }
                    th scope="col" { "Drawing" }
                    th.n scope="col" { "Simulated: median, 90 %" }
                    th.n scope="col" { "Below it" }
                    th.n scope="col" { "Out" }
                    th scope="col" { "Place" }
                } }
                tbody { @for statistic in told { (row(statistic)) } }
            } @if outside == 0 { p.none-out.note { "None of them is outside." } } }
            @if !untold.is_empty() {
                details.untold {
                    summary { (counted(untold.len(), "statistic")) " that are not placed" }
                    p { "The real scan, or most simulated ones, do not tell them." }
                    ul { @for statistic in untold { li { (statistic.name) } } }
                }
            }
        }
    }
}

fn row(statistic: &CoveredStatistic) -> Markup {
    let is_out = statistic.place == Some(CoverPlace::Outside);
    let real = statistic.real.unwrap_or(f64::NAN);
    html! {
        tr.out[is_out].in-reach[!is_out] {
            th scope="row" title=(statistic.key) {
                (statistic.name)
                @if statistic.unit != "1" { " " span.dim { "[" (statistic.unit) "]" } }
            }
            td.n data-label="Real" { strong { (short(real)) } }
            td.drawing data-label="Drawing" { (svg::strip(statistic.simulated, None, real, statistic.real_ends)) }
            td.n data-label="Simulated" {
                @match statistic.simulated { Some(three) => { (short(three[1])) br; (ends(three)) } None => { "-" } }
            }
            td.n data-label="Below it" { (statistic.below.map_or("-".into(), percent)) }
            td.n data-label="Out" { (statistic.out.map_or("-".into(), short)) }
            td data-label="Place" {
                @match statistic.place {
                    Some(CoverPlace::Outside) => strong.alarm { "outside" },
                    Some(place) => span.dim { (place.name()) },
                    None => "-",
                }
            }
        }
    }
}

fn keys(cover: &Cover) -> Markup {
    let of = if cover.classes.len() > 1 { "of the pixels of any class" } else { "of a scan" };
    html! {
        p {
            "What each key that is drawn does from 5 to 95 % of its distribution to the statistic " (of) " that it \
                moves most, in robust deviations of simulated scans. One that moves none by a third of a deviation \
                explains less than a hundredth of what varies: to hold it costs nothing, to draw it teaches nothing."
        }
        div.scroll { table.keys {
            thead { tr {
                th scope="col" { "Key" }
                th scope="col" { "Moves most" }
                th.n scope="col" { "Deviations" }
                th scope="col" { "Does" }
            } }
            tbody { @for key in &cover.keys {
                tr.undetermined[key.is_idle] {
                    th scope="row" { code title=(key.parameter.doc) { (key.path) } }
                    td data-label="Moves most" { @if key.statistic.is_empty() { "none" } @else { (key.statistic) } }
                    td.n data-label="Deviations" { (short(key.by)) }
                    td data-label="Does" { span.state { @if key.is_idle { "nothing" } @else { "something" } } }
                }
            } }
        } }
        @if !cover.held.is_empty() {
            p.note { "Not asked, since classes change them or other keys go with them: " (cover.held.join(", ")) "." }
        }
    }
}

fn still(cover: &Cover) -> Markup {
    html! {
        p {
            "Statistics that 90 % of the simulated scans share within a tenth (of odds, where they are shares). A \
                network never sees another value; a real camera may show one."
        }
        @if cover.still.is_empty() { p { "None." } }
        @else { ul { @for statistic in &cover.still {
            li { (statistic.name) ": " (ends(statistic.three)) (behind(statistic.unit)) }
        } } }
    }
}
