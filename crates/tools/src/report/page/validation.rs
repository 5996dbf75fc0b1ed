//! What `gen validate --save` found. The document is shown by its keys: those that are known in words, others as they
//! are.

use maud::{Markup, html};
use serde_json::{Map, Value};

use super::elements::staleness;
use crate::report::kept_documents::{VALIDATION, kept};
use crate::report::page_data::PageData;
use drawing::html::format::{bytes, count, name, number, shell_word};

/// Name of the document.
const DOCUMENT_NAME: &str = "validation.json";
/// Faults of one code that are listed.
const MAX_LISTED_FAULTS: usize = 20;
/// Rows of any other table.
const MAX_TABLE_ROWS: usize = 400;
/// Numbers of the document, and what is said of one and of several.
const COUNTED: [(&str, &str, &str); 5] = [
    ("samples", "sample", "samples"),
    ("images", "image", "images"),
    ("rerendered", "sample rendered again", "samples rendered again"),
    ("rows", "row exposed again", "rows exposed again"),
    ("files", "file", "files"),
];
/// Keys that are shown elsewhere.
const KEYS_SHOWN_ELSEWHERE: [&str; 18] = [
    "format",
    "schema_version",
    "clean",
    "fault_counts",
    "faults",
    "warning_counts",
    "warnings",
    "dataset_sha256",
    "manifests_sha256",
    "dataset",
    "generator",
    "samples",
    "images",
    "rerendered",
    "files",
    "bytes",
    "shards",
    "chosen",
];

/// The section.
pub(super) fn section(facts: &PageData) -> Markup {
    let again = format!("gen validate {} --save", shell_word(facts.root));
    let Some(kept) = kept(facts.root, DOCUMENT_NAME, &VALIDATION, &facts.sums) else {
        return html! { p.note { "Nothing is kept. Make it: " code { (again) } } };
    };
    // The sums are of the documents alone: what became of other files since, the page may have found itself.
    let damaged = !facts.folder.troubles.is_empty();
    let current = kept.is_current == Some(true);
    let was_clean = kept.document.as_ref().is_ok_and(|document| document["clean"] == true);
    html! {
        (staleness(&kept, &again))
        @if current && was_clean && damaged {
            p.stale {
                strong { "Damaged since? " } "This page finds files " a href="#troubles" { "missing or damaged" }
                ". Make it again: " code { (again) }
            }
        }
        @if let Ok(document) = &kept.document {
            (verdict(document, current && !damaged))
            (findings(&document["faults"])) (findings(&document["warnings"])) (others(document))
        }
    }
}

/// The verdict, which `holds` of the dataset as it is now or held when it was validated.
fn verdict(document: &Value, holds: bool) -> Markup {
    let [faults, warnings] = ["faults", "warnings"].map(|key| document[key].as_array().map_or(0, Vec::len));
    html! {
        p.state {
            @match document["clean"].as_bool() {
                Some(true) if holds => { span.badge.good { "clean" } " no fault" }
                Some(true) => "clean when it was validated",
                _ => { span.badge.bad { "faults" } " " (count(faults as u64)) " listed" }
            }
            @if warnings > 0 { " " span.badge.bad { "warnings" } " " (count(warnings as u64)) " listed" }
            @for (key, one, several) in COUNTED {
                @if let Some(n) = document[key].as_u64() { ", " (count(n)) " " (if n == 1 { one } else { several }) }
            }
            @if let Some(n) = document["bytes"].as_f64() { ", " (bytes(n)) }
            @for (key, value) in document.as_object().into_iter().flatten() {
                @if let (Some(n), false) = (value.as_u64(), KEYS_SHOWN_ELSEWHERE.contains(&key.as_str())) {
                    ", " (count(n)) " " (name(key))
                }
            }
        }
    }
}

/// Faults or warnings by code.
fn findings(list: &Value) -> Markup {
    let list: Vec<&Value> = list.as_array().into_iter().flatten().collect();
    let text = |fault: &Value, key: &str| fault[key].as_str().unwrap_or("").to_owned();
    let mut codes: Vec<String> = list.iter().map(|fault| text(fault, "code")).collect();
    codes.sort_unstable();
    codes.dedup();
    html! {
        @for code in &codes {
            @let of: Vec<_> = list.iter().filter(|fault| text(fault, "code") == *code).collect();
            details.fault open {
                summary { code { (code) } " " small { (of.len()) } " " span.dim { (of.first().map_or(String::new(),
                    |fault| text(fault, "remedy"))) } }
                ul { @for fault in of.iter().take(MAX_LISTED_FAULTS) {
                    li { code { (text(fault, "place")) } ": " (text(fault, "what")) }
                } }
                @if of.len() > MAX_LISTED_FAULTS { p.dim { "and " (of.len() - MAX_LISTED_FAULTS) " more" } }
            }
        }
    }
}

/// Everything else that the document says.
fn others(document: &Value) -> Markup {
    html! {
        @for (key, value) in document.as_object().into_iter().flatten() {
            @if !KEYS_SHOWN_ELSEWHERE.contains(&key.as_str()) && (value.is_object()
                || value.as_array().is_some_and(|list| !list.is_empty())) {
                details.group { summary { (key.replace('_', " ")) } (any(value, 0)) }
            }
        }
    }
}

/// A value: lists of objects as tables, objects as lists of names and values.
fn any(value: &Value, depth: usize) -> Markup {
    match value {
        Value::Object(fields) if depth < 6 => html! {
            dl.fixed { @for (key, value) in fields { div { dt { (key.replace('_', " ")) } dd { (any(value,
                depth + 1)) } } } }
        },
        Value::Array(list) if depth < 6 && list.iter().all(Value::is_object) => {
            let rows: Vec<&Map<String, Value>> = list.iter().filter_map(Value::as_object).collect();
            let mut keys: Vec<&String> = Vec::new();
            for key in rows.iter().flat_map(|row| row.keys()) {
                if !keys.contains(&key) {
                    keys.push(key);
                }
            }
            html! {
                div.scroll tabindex="0" { table {
                    thead { tr { @for key in &keys { th { (key.replace('_', " ")) } } } }
                    tbody { @for row in rows.iter().take(MAX_TABLE_ROWS) { tr { @for key in &keys { td {
                        (row.get(*key).map_or(html! {}, |value| any(value, depth + 1))) } } } } }
                } }
                @if rows.len() > MAX_TABLE_ROWS { p.dim { "and " (rows.len() - MAX_TABLE_ROWS) " more" } }
            }
        }
        Value::Array(list) => html! { (list.iter().take(MAX_TABLE_ROWS).map(plain).collect::<Vec<_>>().join(", ")) },
        other => html! { (plain(other)) },
    }
}

fn plain(value: &Value) -> String {
    match value {
        Value::Null => "-".into(),
        Value::Bool(yes) => if *yes { "yes" } else { "no" }.into(),
        Value::Number(n) => n.as_u64().map_or_else(|| n.as_f64().map_or(n.to_string(), number), count),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}
