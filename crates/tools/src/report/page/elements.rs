//! Elements that several sections of the page share.

use maud::{Markup, html};
use output_schema::DatasetHead;

use crate::report::kept_documents::KeptDocument;

/// Pixel classes that are no defect and no object of interest: what surfaces show where all is well.
pub(crate) fn plain_classes(head: &DatasetHead) -> Vec<u8> {
    let sound = ["background", "clear", "flange", "tooth", "object"];
    head.shown_classes()
        .filter(|(_, name)| sound.contains(name))
        .filter_map(|(value, _)| value.try_into().ok())
        .collect()
}

/// A table that scrolls where it is wide; of each column its title, and whether it holds numbers.
pub(super) fn table(columns: &[(&str, bool)], rows: Markup) -> Markup {
    html! {
        div.scroll tabindex="0" {
            table {
                thead { tr { @for (title, is_number) in columns {
                    @if *is_number { th.n { (title) } } @else { th { (title) } }
                } } }
                tbody { (rows) }
            }
        }
    }
}

/// Notice above a kept result that belongs to another state of the dataset, or cannot be read.
pub(super) fn staleness(kept: &KeptDocument, again: &str) -> Markup {
    html! {
        @match (&kept.document, kept.is_current) {
            (Err(what), _) => p.stale {
                code { "reports/" (kept.name) } " cannot be read: " (what) ". Make it again: " code { (again) }
            }
            (Ok(_), Some(true)) => {}
            (Ok(_), Some(false)) => p.stale {
                strong { "Stale: " } "the dataset has changed since. Make it again: " code { (again) }
            }
            (Ok(_), None) => p.stale {
                strong { "Of what dataset? " } "It does not say what it was made from. Make it again: " code { (again) }
            }
        }
    }
}
