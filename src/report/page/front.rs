//! The head of the page: what the dataset is, how it was made, and what is missing of it.

use maud::{Markup, html};

use super::super::Facts;
use super::super::folder::unfinished;
use super::words::{bytes, count, number, word};
use crate::shard::samples_per_shard;

/// The head.
pub(super) fn front(facts: &Facts) -> Markup {
    let (head, folder) = (facts.head, &facts.folder);
    let missing = unfinished(head, folder);
    let images = &head.images;
    let sizes = facts.samples.first().map(|sample| sample.extent);
    let splits = head.splits.named().map(|(name, share)| format!("{name} {}", number(share)));
    html! {
        header.front {
            p.kind { "Dataset of simulated laser-triangulation scans" }
            h1 { (head.recipe.name) }
            p.lead {
                (count(head.samples)) " scans of " (subject(&head.subject)) ", " (images.cols) " × " (images.rows) " px"
                @if let Some([rows, cols]) = sizes { " (" (number(cols)) " × " (number(rows)) " mm)" }
                ": range, reflectance and scatter as a line-laser profiler measures them, with pixel-exact labels."
            }
            p.state {
                @if missing == 0 && folder.troubles.is_empty() {
                    span.badge.good { "complete" }
                } @else {
                    span.badge.bad { @if missing > 0 { "unfinished" } @else { "damaged" } }
                }
                " " (count(folder.finished)) " of " (count(head.shards)) " shards finished, "
                (count(facts.tally.total())) " of " (count(head.samples)) " samples read, "
                (bytes(folder.bytes() as f64)) " on disk"
            }
            dl.facts {
                div { dt { "Subject" } dd { (head.subject) } }
                div { dt { "Classes" } dd { (head.classes.len()) } }
                div { dt { "Splits" } dd { (splits.join(", ")) } }
                div { dt { "Seed" } dd { (head.seed) } }
                div { dt { "Images" } dd { (list(&images.png)) @if images.exr.is_empty() { "; no EXR" } @else { "; EXR too" } } }
                div { dt { "Range" } dd { (images.range) ", " (head.range_unit()) } }
                div { dt { "Digital numbers" } dd { (images.bits) " bits" } }
                div { dt { "Sensor" } dd { (images.sensor_cols) " × " (images.sensor_rows) " px" } }
                div { dt { "Generator" } dd { (head.generator.name) " " (head.generator.version) } }
                div { dt { "Target" } dd { (head.target) } }
                div { dt { "Schema" } dd { (head.schema_version[0]) "." (head.schema_version[1]) } }
                div.wide { dt { "Recipe hash" } dd { code { (head.recipe.hash) } } }
                div.wide { dt { "Made again by" } dd { code { (again(facts)) } } }
            }
        }
    }
}

/// The command that makes the dataset again, with the size of its shards where the recipe alone gives another.
fn again(facts: &Facts) -> String {
    let head = facts.head;
    let own = facts.recipe.as_ref().ok().map(|recipe| samples_per_shard(&recipe.output(), &recipe.size()) as u64);
    let shards = match own {
        Some(own) if own == head.samples_per_shard => String::new(),
        _ => format!(" --samples-per-shard {}", head.samples_per_shard),
    };
    format!("gen --recipe {} --seed {} --n {}{shards} --out again", word(facts.root), head.seed, head.samples)
}

fn subject(name: &str) -> &str {
    match name {
        "wood" => "sawn wood",
        "blister" => "blister packs",
        "sawtooth" => "a saw-tooth calibration piece",
        "mesh" => "a part from a file of triangles",
        other => other,
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "no PNG".into() } else { names.join(", ") }
}

/// What is missing or cannot be read; nothing where all is well.
pub(super) fn troubles(facts: &Facts) -> Markup {
    let folder = &facts.folder;
    html! {
        @if !folder.troubles.is_empty() {
            section.trouble id="troubles" {
                h2 { "What is missing or damaged" }
                div.scroll tabindex="0" {
                    table {
                        thead { tr { th { "File" } th { "What" } th { "Remedy" } } }
                        tbody {
                            @for trouble in &folder.troubles {
                                tr { td { code { (trouble.place) } } td { (trouble.what) } td { (trouble.remedy) } }
                            }
                        }
                    }
                }
                @if folder.more > 0 { p { "And " (count(folder.more)) " more." } }
                p.note { "Everything below is of what can be read." }
            }
        }
    }
}
