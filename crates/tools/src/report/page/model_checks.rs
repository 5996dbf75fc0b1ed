//! What `gen check --save` found: accuracy, confusion, precision and recall, calibration, slices, the worst answers.

use std::path::Path;

use maud::{Markup, html};
use serde_json::Value;

use super::elements::{staleness, table};
use crate::report::kept_documents::{KeptDocument, checks, picture};
use crate::report::page_data::PageData;
use drawing::html::{
    data_url,
    format::{count, name, number, percent, shell_word},
};

/// Wrong answers that are shown.
const MAX_MISCLASSIFIED: usize = 24;

/// The section.
pub(super) fn section(facts: &PageData) -> Markup {
    let kept = checks(facts.root, &facts.sums);
    html! {
        @if kept.is_empty() {
            p.note { "No check of a model is kept. Make one: " code { (again(facts, &Value::Null)) } }
        }
        @for check in &kept { (one(facts, check)) }
    }
}

/// The command that checks the model of a document again, as far as it names model, split and seed.
fn again(facts: &PageData, document: &Value) -> String {
    let quoted = |value: &Value| value.as_str().map(|text| shell_word(Path::new(text)));
    let model = quoted(&document["model"]["path"]).unwrap_or("MODEL.onnx".into());
    let split = quoted(&document["split"]).map_or(String::new(), |split| format!(" --split {split}"));
    let seed =
        document["seed"].as_u64().filter(|seed| *seed > 0).map_or(String::new(), |seed| format!(" --seed {seed}"));
    format!("gen check {} --model {model}{split}{seed} --save", shell_word(facts.root))
}

fn one(facts: &PageData, kept: &KeptDocument) -> Markup {
    let title = kept.name.trim_start_matches("check-").trim_end_matches(".json");
    html! {
        article.model {
            h3 { (title) }
            (staleness(kept, &again(facts, kept.document.as_ref().unwrap_or(&Value::Null))))
            @if let Ok(document) = &kept.document {
                p.dim {
                    (text(&document["task"])) ", split " (text(&document["split"])) ", "
                    (whole(&document["samples"])) " samples, "
                    (whole(&document["accuracy"]["of"])) " " (text(&document["counted"])) ", model "
                    code { (text(&document["model"]["sha256"]).chars().take(12).collect::<String>()) }
                }
                (accuracy(document))
                h4 { "Classes" } (classes(document))
                h4 { "Confusion" } (confusion(document))
                h4 { "Calibration" } (calibration(document))
                @if !list(&document["slices"]).is_empty() { h4 { "Slices" } (slices(document)) }
                @if !list(&document["worst"]).is_empty() {
                    h4 { "The most confidently wrong" } (worst(facts, document))
                }
            }
        }
    }
}

fn accuracy(document: &Value) -> Markup {
    let share = &document["accuracy"];
    html! {
        p.figures {
            span {
                strong { (per_cent(&share["accuracy"])) } " accuracy" br;
                small { "95 %: " (per_cent(&share["low"])) " to " (per_cent(&share["high"])) }
            }
            span { strong { (per_cent(&document["balanced_accuracy"])) } " mean recall" }
            @if document["task"] == "segment" { span { strong { (per_cent(&document["mean_iou"])) } " mean IoU" } }
            span { strong { (per_cent(&document["calibration"]["error"])) } " calibration error" }
        }
    }
}

fn classes(document: &Value) -> Markup {
    let numbers = ["true", "guessed", "precision", "recall", "F1", "IoU"].map(|title| (title, true));
    let rows = html! {
        @for class in list(&document["classes"]) { tr {
            th scope="row" { (name(text(&class["name"]))) }
            td.n { (whole(&class["support"])) } td.n { (whole(&class["guessed"])) }
            @for key in ["precision", "recall", "f1", "iou"] { td.n { (per_cent(&class[key])) } }
        } }
    };
    table(&[&[("Class", false)], &numbers[..]].concat(), rows)
}

/// Rows are the truth, columns the guess; the shade is the share of the row.
fn confusion(document: &Value) -> Markup {
    let names: Vec<&str> = list(&document["classes"]).iter().map(|class| text(&class["name"])).collect();
    html! {
        div.scroll tabindex="0" { table.confusion {
            thead { tr { th { "true \\ guessed" } @for title in &names { th.n { (name(title)) } } } }
            tbody { @for (row, title) in list(&document["confusion"]).iter().zip(&names) {
                @let sum = list(row).iter().filter_map(Value::as_f64).sum::<f64>().max(1.0);
                tr { th scope="row" { (name(title)) }
                    @for (i, cell) in list(row).iter().enumerate() {
                        @let share = cell.as_f64().unwrap_or(0.0) / sum;
                        td.n.right[names.get(i) == Some(title)] style=(format!("--share:{share:.3}"))
                            title=(percent(share)) { (whole(cell)) }
                    } }
            } }
        } }
    }
}

fn calibration(document: &Value) -> Markup {
    let bins = list(&document["calibration"]["bins"]);
    let most = bins.iter().filter_map(|bin| bin["count"].as_f64()).fold(1.0, f64::max);
    let place = |value: &Value| value.as_f64().map(|value| value.clamp(0.0, 1.0));
    html! {
        svg.calibration viewBox="0 -6 246 242" role="img"
            aria-label="Accuracy over confidence; on the diagonal confidence is right" {
            rect.frame x="34" y="6" width="200" height="200" {}
            line.grid x1="34" y1="206" x2="234" y2="6" {}
            @for bin in bins {
                @if let (Some(confidence), Some(right)) = (place(&bin["confidence"]), place(&bin["accuracy"])) {
                    @let size = 3.0 + 7.0 * (bin["count"].as_f64().unwrap_or(0.0) / most).sqrt();
                    circle.point cx=(format!("{:.1}", 34.0 + 200.0 * confidence))
                        cy=(format!("{:.1}", 206.0 - 200.0 * right)) r=(format!("{size:.1}")) {
                        title {
                            "confidence " (number(confidence)) ", accuracy " (number(right)) ", " (whole(&bin["count"]))
                        }
                    }
                }
            }
            @for (share, words) in [(0.0, "0"), (0.5, "0.5"), (1.0, "1")] {
                text x=(34.0 + 200.0 * share) y="218" text-anchor="middle" { (words) }
                text x="30" y=(209.0 - 200.0 * share) text-anchor="end" { (words) }
            }
            text x="134" y="232" text-anchor="middle" { "confidence" }
            text x="10" y="106" text-anchor="middle" transform="rotate(-90 10 106)" { "accuracy" }
        }
    }
}

fn slices(document: &Value) -> Markup {
    let columns = [("from", true), ("to", true), ("", false), ("accuracy", true), ("95 %", true), ("samples", true)];
    let row = |group: &Value| {
        let right = group["accuracy"].as_f64().unwrap_or(0.0).clamp(0.0, 1.0);
        html! {
            tr {
                td.n { (amount(&group["from"])) } td.n { (amount(&group["to"])) }
                td.bar { svg viewBox="0 0 100 10" preserveAspectRatio="none" aria-hidden="true" {
                    rect.split0 width=(format!("{:.1}", 100.0 * right)) height="10" {} } }
                td.n { (per_cent(&group["accuracy"])) }
                td.n { (per_cent(&group["low"])) " to " (per_cent(&group["high"])) } td.n { (whole(&group["samples"])) }
            }
        }
    };
    html! {
        div.slices { @for slice in list(&document["slices"]) {
            figure {
                figcaption { (text(&slice["column"])) }
                (table(&columns, html! { @for group in list(&slice["groups"]) { (row(group)) } }))
            }
        } }
    }
}

fn worst(facts: &PageData, document: &Value) -> Markup {
    html! {
        div.worst { @for wrong in list(&document["worst"]).iter().take(MAX_MISCLASSIFIED) {
            figure {
                @if let Some(png) = wrong["picture"].as_str().and_then(|name| picture(facts.root, name)) {
                    img loading="lazy" alt={ "What the model saw of sample " (whole(&wrong["index"])) }
                        src=(data_url(&png));
                }
                figcaption {
                    "sample " (whole(&wrong["index"])) ", row " (whole(&wrong["first"][0])) ", column "
                    (whole(&wrong["first"][1])) ": " strong { (name(text(&wrong["truth"]))) } " taken for "
                    strong { (name(text(&wrong["guess"]))) } ", confidence " (amount(&wrong["confidence"]))
                }
            }
        } }
    }
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or("-")
}

fn whole(value: &Value) -> String {
    value.as_i64().map_or("-".into(), |n| if n < 0 { n.to_string() } else { count(n.unsigned_abs()) })
}

fn amount(value: &Value) -> String {
    value.as_f64().map_or("-".into(), number)
}

fn per_cent(value: &Value) -> String {
    value.as_f64().map_or("-".into(), percent)
}
