//! The page: sections in the order in which an engineer asks. All text is escaped where it is put in; styles and the
//! script are files of their own.

mod chart;
mod classes;
mod frames;
mod front;
mod models;
mod numbers;
mod sheet;
mod size;
mod validation;
mod words;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use output_schema::DatasetHead;

use super::Facts;
use super::colours::class_colours;
use super::results::Kept;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// What a browser may load: what is in the page.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// Pixel classes that are no defect and no object of interest: what surfaces show where all is well.
pub(super) fn plain(head: &DatasetHead) -> Vec<u8> {
    let sound = ["background", "clear", "flange", "tooth", "object"];
    head.shown_classes()
        .filter(|(_, name)| sound.contains(name))
        .filter_map(|(value, _)| value.try_into().ok())
        .collect()
}

/// Whether the dataset keeps an image of that name, as PNG or in EXR files.
fn keeps(head: &DatasetHead, name: &str) -> bool {
    head.images.png.iter().chain(&head.images.exr).any(|kept| kept.eq_ignore_ascii_case(name))
}

/// The page of a dataset.
pub(super) fn page(facts: &Facts) -> Markup {
    let sections = [
        ("samples", "Samples", sheet::section(facts)),
        ("classes", "Classes", classes::section(facts)),
        ("numbers", "Numbers", numbers::section(facts)),
        ("frames", "Frames", frames::section(facts)),
        ("size", "Size and time", size::section(facts)),
        ("validation", "Validation", validation::section(facts)),
        ("models", "Models", models::section(facts)),
        ("recipe", "Recipe", recipe(facts)),
    ];
    let title = format!("{}: {} samples", facts.head.recipe.name, facts.head.samples);
    document(
        &title,
        &colours(facts.head),
        html! {
            (front::front(facts))
            nav aria-label="Sections" { @for (id, name, _) in &sections { a href={ "#" (id) } { (name) } } }
            main {
                (front::troubles(facts))
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

/// Bytes of a PNG as an address.
fn address(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

/// Styles that give what belongs to a class of the recipe its colour: `c0` for the first one, and so on.
fn colours(head: &DatasetHead) -> String {
    let colours = class_colours(head).into_iter().enumerate();
    colours.map(|(class, colour)| format!(".c{class} {{ --c: {colour}; }}\n")).collect()
}

/// What stands above a kept result that is not of this dataset, or cannot be read.
fn staleness(kept: &Kept, again: &str) -> Markup {
    html! {
        @match (&kept.document, kept.is_current) {
            (Err(what), _) => p.stale { code { "reports/" (kept.name) } " cannot be read: " (what) ". Make it again: " code { (again) } }
            (Ok(_), Some(true)) => {}
            (Ok(_), Some(false)) => p.stale { strong { "Stale: " } "the dataset has changed since. Make it again: " code { (again) } }
            (Ok(_), None) => p.stale { strong { "Of what dataset? " } "It does not say what it was made from. Make it again: " code { (again) } }
        }
    }
}

fn recipe(facts: &Facts) -> Markup {
    html! {
        @if let Err(why) = facts.recipe {
            p.stale { "This program does not read it: " (why) ". Distributions and frames are left out." }
        }
        details { summary { "The recipe as it was written" } pre.scroll tabindex="0" { (facts.head.recipe.text) } }
    }
}
