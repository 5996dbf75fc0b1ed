//! Header of the page: what the dataset is, how it was made, and what is missing of it.

use maud::{Markup, html};
use output_schema::DatasetHead;

use super::elements::table;
use crate::report::dataset_counts::ShortSamples;
use crate::report::histogram::RunningRange;
use crate::report::page_data::PageData;
use dataset::{objects_in_words, samples_per_shard};
use drawing::html::format::{bytes, count, number, shell_word};
use output_schema::row::MEASURED;
use recipe::Recipe;

/// The head.
pub(super) fn header(facts: &PageData) -> Markup {
    let (head, folder) = (facts.head, &facts.folder);
    let missing = head.shards.saturating_sub(folder.finished);
    let images = &head.images;
    let [rows, cols] = &facts.counts.field;
    let splits = head.splits.named().map(|(name, share)| format!("{name} {}", number(share)));
    html! {
        header.front {
            p.kind { "Dataset of simulated laser-triangulation scans" }
            h1 { (head.recipe.name) }
            p.lead {
                (count(head.samples)) " scans of " (objects_in_words(head)) ", " (images.cols) " × " (images.rows) " px"
                @if cols.count > 0 { " (" (span(cols)) " × " (span(rows)) " mm)" }
                (holds(head))
            }
            p.state {
                @if missing == 0 && folder.troubles.is_empty() {
                    span.badge.good { "complete" }
                } @else {
                    span.badge.bad { @if missing > 0 { "unfinished" } @else { "damaged" } }
                }
                @if is_of_little_use(facts) { " " a href="#warnings" { span.badge.bad { "of little use" } } }
                " " (count(folder.finished)) " of " (count(head.shards)) " shards finished, "
                (count(facts.counts.total())) " of " (count(head.samples)) " samples read, "
                (bytes(folder.bytes() as f64)) " on disk"
            }
            dl.facts {
                div { dt { "Subject" } dd { (head.subject) } }
                div { dt { "Classes" } dd { (head.classes.len()) } }
                div { dt { "Splits" } dd { (splits.join(", ")) } }
                div { dt { "Seed" } dd { (head.seed) } }
                div { dt { "Images" }
                    dd { (list(&images.png)) @if head.has_exr() { "; EXR too" } @else { "; no EXR" } } }
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
fn again(facts: &PageData) -> String {
    let head = facts.head;
    let size_of = |recipe: &Recipe| samples_per_shard(&recipe.output(), &recipe.size(), recipe.sample_seconds()) as u64;
    let own = facts.recipe.as_ref().ok().copied().map(size_of);
    let shards = match own {
        Some(own) if own == head.samples_per_shard => String::new(),
        _ => format!(" --samples-per-shard {}", head.samples_per_shard),
    };
    format!("gen --recipe {} --seed {} --n {}{shards} --out again", shell_word(facts.root), head.seed, head.samples)
}

/// The lowest and the highest, where they differ as they are written.
fn span(extent: &RunningRange) -> String {
    let (low, high) = (number(extent.min), number(extent.max));
    if low == high { low } else { format!("{low} to {high}") }
}

/// Which maps the dataset keeps, and whether labels with them: the end of a sentence.
fn holds(head: &DatasetHead) -> String {
    let labels = if head.images.holds("label") { "with pixel-exact labels" } else { "without labels" };
    let maps: Vec<&str> = MEASURED.into_iter().filter(|map| head.images.holds(map)).collect();
    match &maps[..] {
        [] => format!(", {labels}."),
        [map] => format!(": {map} as a line-laser profiler measures it, {labels}."),
        [first @ .., last] => {
            format!(": {} and {last} as a line-laser profiler measures them, {labels}.", first.join(", "))
        }
    }
}

fn list(names: &[String]) -> String {
    if names.is_empty() { "no PNG".into() } else { names.join(", ") }
}

/// Whether the check of the rig warned, or samples fall short.
fn is_of_little_use(facts: &PageData) -> bool {
    !facts.head.warnings.is_empty() || facts.counts.short.iter().any(|short| short.count > 0)
}

/// What the check of the rig warned of, and samples that fall short; nothing where all is well.
pub(super) fn warnings(facts: &PageData) -> Markup {
    let short = || facts.counts.short.iter().filter(|short| short.count > 0);
    let total = facts.counts.total();
    let rows = html! {
        @for warning in &facts.head.warnings {
            tr {
                td { code { (warning.code) } } td { "Before the first sample: " (warning.what) }
                td { (warning.remedy) }
            }
        }
        @for short in short() {
            tr {
                td { code { (short.shortfall.name()) } } td { (found(short, total)) }
                td { (short.shortfall.remedy()) }
            }
        }
    };
    html! {
        @if is_of_little_use(facts) {
            section.trouble.alarm id="warnings" {
                h2 { "Of little use" }
                (table(&[("What", false), ("Found", false), ("Remedy", false)], rows))
            }
        }
    }
}

/// How many of `total` samples fall short, and which.
fn found(short: &ShortSamples, total: u64) -> String {
    let named: Vec<String> = short.first.iter().map(u64::to_string).collect();
    let more = if short.count > named.len() as u64 { " and others" } else { "" };
    format!("{} of {} samples: {}{more}", count(short.count), count(total), named.join(", "))
}

/// What is missing or cannot be read; nothing where all is well.
pub(super) fn troubles(facts: &PageData) -> Markup {
    let folder = &facts.folder;
    let rows = html! {
        @for trouble in &folder.troubles {
            tr { td { code { (trouble.place) } } td { (trouble.what) } td { (trouble.remedy) } }
        }
    };
    html! {
        @if !folder.troubles.is_empty() {
            section.trouble id="troubles" {
                h2 { "What is missing or damaged" }
                (table(&[("File or shards", false), ("What", false), ("Remedy", false)], rows))
                @if folder.more > 0 { p { "And " (count(folder.more)) " more." } }
                p.note { "Everything below is of what can be read." }
            }
        }
    }
}
