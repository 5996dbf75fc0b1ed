//! HTML page of the report: sections in the order in which an engineer needs them. All text is escaped where it is put in; styles and the
//! script are files of their own.

mod classes;
mod contact_sheet;
mod elements;
mod format;
mod header;
mod model_checks;
mod numbers;
mod sensor_frames;
mod size;
mod svg;
mod validation;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use output_schema::DatasetHead;

pub(super) use elements::plain_classes;

use super::page_data::PageData;
use super::palette::class_colours;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// What a browser may load: what is in the page.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// The page of a dataset.
pub(super) fn page(facts: &PageData) -> Markup {
    let sections = [
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
    document(
        &title,
        &colours(facts.head),
        html! {
            (header::header(facts))
            nav aria-label="Sections" { @for (id, name, _) in &sections { a href={ "#" (id) } { (name) } } }
            main {
                (header::troubles(facts))
                (header::warnings(facts))
                @for (id, name, content) in &sections {
                    section id=(id) aria-labelledby={ (id) "-title" } {
                        h2 id={ (id) "-title" } { (name) }
                        (content)
                    }
                }
            }
            footer {
                p { "Made by gen " (env!("CARGO_PKG_VERSION")) " from the folder alone. Nothing on this page comes from a network." }
            }
        },
    )
}

/// The page of a folder that cannot be opened.
pub(super) fn unreadable(place: &str, what: &str) -> Markup {
    document(
        "No dataset",
        "",
        html! {
            header.front { h1 { "No dataset can be read here" } }
            main {
                section.trouble {
                    p { code { (place) } }
                    pre { (what) }
                    p { code { "gen validate" } " says what is damaged; a copy of " code { "dataset.json" } " brings the rest back." }
                }
            }
        },
    )
}

fn document(title: &str, colours: &str, body: Markup) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                link rel="icon" href="data:,";
                style { (PreEscaped(STYLE)) (PreEscaped(colours)) }
            }
            body {
                (body)
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
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
        details { summary { "The recipe as it was written" } pre.scroll tabindex="0" { (facts.head.recipe.text) } }
    }
}
