//! The page of a fit: one HTML file without scripts, in the order in which an engineer asks. All text is escaped where
//! it is put in; nothing of it depends on a clock or a machine.

mod keys;
mod maps;
mod reach;
mod recipe_lines;
mod statistics;
pub(crate) mod svg;
#[cfg(test)]
mod tests;

use drawing::html::format::{counted, list};
use drawing::html::{HtmlPage, sections};
use maud::{Markup, html};

use crate::result::{Fit, KeyState};

pub(crate) const STYLE: &str = include_str!("page.css");

impl Fit {
    /// One HTML file; `before` and `after` are the texts of the recipe as it was and of the fitted one.
    pub fn page(&self, before: &str, after: &str) -> String {
        let content = [
            ("maps", "Maps", maps::section(self)),
            ("keys", "Keys", keys::section(self)),
            ("statistics", "Statistics", statistics::section(self)),
            ("reach", "Out of reach", reach::section(self)),
            ("recipe", "Recipe", recipe_lines::section(before, after)),
        ];
        let title = format!("{} fitted to {}", self.recipe, counted(self.scans.len(), "real scan"));
        let body = sections(header(self), html! {}, &content, "");
        HtmlPage { title: &title, style: &[STYLE], script: None }.around(body).into_string()
    }

    /// Statistics out of reach over all scans, and those that the real scans tell.
    fn reach(&self) -> [usize; 2] {
        let told = || self.scans.iter().flat_map(|scan| &scan.statistics).filter(|statistic| statistic.real.is_some());
        [told().filter(|statistic| statistic.is_out_of_reach()).count(), told().count()]
    }
}

fn header(fit: &Fit) -> Markup {
    let [done, asked] = fit.rounds;
    let [out, told] = fit.reach();
    let names: Vec<&str> = fit.scans.iter().map(|scan| scan.name.as_str()).collect();
    html! {
        header.front {
            p.kind { "Recipe fitted to scans of a real camera" }
            h1 { (fit.recipe) }
            p.lead { (verdict(fit)) }
            p.state {
                @if done < asked {
                    span.badge.bad { "stopped early" } " the time was up after " (done) " of " (asked) " rounds "
                }
                @if told == 0 {
                    span.badge.bad { "nothing told" } " no real scan tells any statistic"
                } @else if out > 0 {
                    a href="#reach" { span.badge.bad { "out of reach" } " " (counted(out, "statistic")) }
                } @else {
                    span.badge.good { "within reach" } " every statistic that the real scans tell"
                }
            }
            dl.facts {
                div { dt { "Recipe" } dd { (fit.recipe) } }
                div { dt { "Seed" } dd { (fit.seed) } }
                div { dt { "Simulated scans" } dd { (fit.simulations) } }
                div { dt { "Rounds" } dd { (done) " of " (asked) } }
                div { dt { "Keys" } dd { (fit.keys.len()) } }
                div.wide {
                    dt { "Real scans" }
                    dd { @if names.is_empty() { "none" } @else { (names.join(", ")) } }
                }
            }
        }
    }
}

/// What was found, in one sentence.
fn verdict(fit: &Fit) -> String {
    let of_state = |state: KeyState| fit.keys.iter().filter(|key| key.state == state).count();
    let [out, told] = fit.reach();
    let states: Vec<String> = KeyState::ALL.map(|state| format!("{} {}", of_state(state), state.name())).to_vec();
    let scans = if fit.scans.len() > 1 { format!(" of {} scans", fit.scans.len()) } else { String::new() };
    let keys = counted(fit.keys.len(), "key");
    format!("Of {keys}, {}; {out} of {}{scans}", list(&states), counted(told, "statistic"))
        + if out == 1 { " is out of reach." } else { " are out of reach." }
}
