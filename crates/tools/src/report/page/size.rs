//! Bytes by kind of file, and how long a sample takes.

use maud::{Markup, html};

use crate::report::page_data::PageData;
use drawing::html::format::{bytes, count, time};

/// The section.
pub(super) fn section(facts: &PageData) -> Markup {
    let (folder, total) = (&facts.folder, facts.counts.total().max(1));
    let all = folder.bytes() as f64;
    let row = |n: f64| bytes(n / total as f64);
    html! {
        div.scroll tabindex="0" {
            table {
                thead { tr { th { "Kind of file" } th.n { "files" } th.n { "size" } th.n { "a sample" } } }
                tbody { @for (kind, files) in &folder.kinds {
                    tr { th scope="row" { (kind) } td.n { (count(files.count)) } td.n { (bytes(files.bytes as f64)) }
                        td.n { (row(files.bytes as f64)) } }
                } }
                tfoot { tr { th scope="row" { "all" } td.n {
                    (count(folder.kinds.values().map(|files| files.count).sum())) } td.n { (bytes(all)) }
                        td.n { (row(all)) } } }
            }
        }
        @if let Some(timing) = facts.timing {
            div id="timing" {
                p {
                    "Sample " (timing.index) " was rendered and encoded again for this page: "
                    strong { (time(timing.seconds)) } " on this machine with " (timing.threads)
                    @if timing.threads == 1 { " thread" } @else { " threads" } ", one sample at a time; all "
                    (count(facts.head.samples)) " would take "
                    strong { (time(timing.seconds * facts.head.samples as f64)) }
                    " at that rate. The dataset itself keeps no times."
                }
            }
        } @else {
            p.note { "No time was measured." }
        }
    }
}
