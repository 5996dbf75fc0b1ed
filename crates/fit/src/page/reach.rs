//! What the model does not reach, in words, and what to do.

use drawing::html::format::{behind, ends, short};
use maud::{Markup, html};

use crate::result::{Fit, FittedKey, KeyState, ScanFit, StatisticFit};

/// The section.
pub(super) fn section(fit: &Fit) -> Markup {
    let [out, told] = fit.reach();
    let at_ends: Vec<(&FittedKey, &str)> = fit.keys.iter().filter_map(|key| Some((key, end(key)?))).collect();
    html! {
        @if told == 0 {
            p.note {
                "The real scans tell no statistic: nothing can be said of what the recipe reaches. Give larger scans, \
                    or a larger "
                "part of them."
            }
        } @else if out == 0 {
            p {
                "Fitted recipes make every statistic that the real scans tell. What no statistic asks about may \
                    differ all the same."
            }
        } @else {
            p {
                "Real scans have these, which no value of the fitted keys makes. A network that sees them in real \
                    scans has not "
                "seen them in simulated ones."
            }
            ul.reach { @for (name, found) in by_statistic(fit) {
                li {
                    strong { (name) }
                    @match &found[..] {
                        [(_, statistic)] if fit.scans.len() == 1 => { ": " (sentence(statistic)) }
                        _ => {
                            ", in " (found.len()) " of " (fit.scans.len()) " scans"
                            ul { @for (scan, statistic) in &found { li { (scan.name) ": " (sentence(statistic)) } } }
                        }
                    }
                }
            } }
        }
        @if !at_ends.is_empty() {
            h3 { "Keys at an end of what was believed" }
            ul { @for (key, end) in &at_ends {
                li {
                    code { (key.path) } ": half of the posterior lies in the \
                        " (end) " 5 % of the prior. A wider prior may fit better."
                }
            } }
        }
        @if out > 0 || !at_ends.is_empty() {
            h3 { "What to do" }
            ul {
                li {
                    "Widen a prior: \
                        " code { "--set 'key={uniform: [a, \
                            b]}'" } ", first of keys at an end of it, and of keys that move "
                    "what is out of reach."
                }
                li {
                    "Free other keys: give keys that hold one value a distribution. Optics and noise that are fixed \
                        at wrong values "
                    "cannot be made up for."
                }
                li {
                    "Mask what the recipe does not make: \
                        " code { "--mask" } " or " code { "--region" } " keep clamps, background and "
                    "rims out of the statistics of real scans."
                }
                li {
                    "Look at the maps above: a shape that the real object has and the simulated one has not moves \
                        edges, missing "
                    "heights and spectra. Give the recipe that shape, or do not trust keys that follow these."
                }
            }
            p { code { "docs/guide/fit.md" } " says which statistics follow which keys, and when not to trust a fit." }
        }
    }
}

/// What is out of reach, statistic by statistic in the order of their first scan: its name, and the scans that have it.
fn by_statistic(fit: &Fit) -> Vec<(&str, Vec<(&ScanFit, &StatisticFit)>)> {
    let mut found: Vec<(&StatisticFit, Vec<(&ScanFit, &StatisticFit)>)> = Vec::new();
    for scan in &fit.scans {
        for statistic in scan.statistics.iter().filter(|statistic| statistic.is_out_of_reach()) {
            match found.iter_mut().find(|(first, _)| first.key == statistic.key) {
                Some((_, scans)) => scans.push((scan, statistic)),
                None => found.push((statistic, vec![(scan, statistic)])),
            }
        }
    }
    found.into_iter().map(|(first, scans)| (first.name.as_str(), scans)).collect()
}

fn sentence(statistic: &StatisticFit) -> Markup {
    let unit = behind(statistic.unit);
    let is_between =
        statistic.before.zip(statistic.real).is_some_and(|([low, _, high], real)| (low..=high).contains(&real));
    let direction = if statistic.from_scatter.is_some_and(|z| z > 0.0) { "above" } else { "below" };
    html! {
        "the real scan has "
        (statistic.real.map_or("-".into(), short)) (unit)
        @if let Some([low, high]) = statistic.real_ends { " (" (short(low)) " to " (short(high)) ")" }
        ", scans of the fitted recipe " (statistic.after.map_or("-".into(), ends)) (unit)
        @if let Some(z) = statistic.from_scatter { "; it lies " (short(z.abs())) " deviations " (direction) }
        @if let Some(before) = statistic.before {
            ". Before the fit the recipe made " (ends(before)) (unit)
            @if is_between { ": the value itself is made, but not together with the other statistics" }
        }
        "."
    }
}

/// The end of its prior at which half of a key's posterior lies.
fn end(key: &FittedKey) -> Option<&'static str> {
    match () {
        () if key.state == KeyState::Undetermined => None,
        () if key.after[1] < key.before[0] => Some("lowest"),
        () if key.after[1] > key.before[2] => Some("highest"),
        () => None,
    }
}
