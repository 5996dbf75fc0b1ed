//! HTML page of the report: sections in the order in which an engineer needs them. All text is escaped where it is put
//! in; styles and the script are files of their own.

mod classes;
mod contact_sheet;
mod elements;
mod header;
mod model_checks;
mod numbers;
mod sensor_frames;
mod size;
mod svg;
mod validation;

use drawing::html::{HtmlPage, sections};
use maud::{Markup, html};
use output_schema::DatasetHead;

pub(super) use elements::plain_classes;

use super::page_data::PageData;
use super::palette::class_colours;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The page of a dataset.
pub(super) fn page(facts: &PageData) -> Markup {
    let content = [
        ("samples", "Samples", contact_sheet::section(facts)),
        ("classes", "Classes", classes::section(facts)),
        ("numbers", "Numbers", numbers::section(facts)),
        ("frames", "Frames", sensor_frames::section(facts)),
        ("size", "Size and time", size::section(facts)),
        ("validation", "Validation", validation::section(facts)),
        ("models", "Models", model_checks::section(facts)),
        ("recipe", "Recipe", recipe(facts)),
    ];
    let title = format!("{}: {} samples", facts.head.recipe.name, facts.head.samples);
    let before = html! { (header::troubles(facts)) (header::warnings(facts)) };
    let body = sections(header::header(facts), before, &content, " from the folder alone");
    HtmlPage { title: &title, style: &[STYLE, &colours(facts.head)], script: Some(SCRIPT) }.around(body)
}

/// The page of a folder that cannot be opened.
pub(super) fn unreadable(place: &str, what: &str) -> Markup {
    let body = html! {
        header.front { h1 { "No dataset can be read here" } }
        main {
            section.trouble {
                p { code { (place) } }
                pre { (what) }
                p {
                    code { "gen validate" } " says what is damaged; a copy of " code { "dataset.json" }
                    " brings the rest back."
                }
            }
        }
    };
    HtmlPage { title: "No dataset", style: &[STYLE], script: Some(SCRIPT) }.around(body)
}

/// Styles that give what belongs to a class of the recipe its colour: `c0` for the first one, and so on.
fn colours(head: &DatasetHead) -> String {
    let colours = class_colours(head).into_iter().enumerate();
    colours.map(|(class, colour)| format!(".c{class} {{ --c: {colour}; }}\n")).collect()
}

fn recipe(facts: &PageData) -> Markup {
    html! {
        @if let Err(why) = facts.recipe {
            p.stale { "This program does not read it: " (why) ". Distributions and frames are left out." }
        }
        @if let Ok(recipe) = facts.recipe {
            @let variation = recipe.variation();
            p.note { (variation.told()) "." }
            @if let Some(warning) = variation.warning() { p.note { "Note: " (warning) "." } }
        }
        details { summary { "The recipe as it was written" } pre.scroll tabindex="0" { (facts.head.recipe.text) } }
    }
}
