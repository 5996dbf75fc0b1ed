//! Every drawn and derived number as a small histogram, by section of the recipe, with what the recipe declares.

use maud::{Markup, html};

use super::svg;
use crate::report::dataset_counts::NumberCounts;
use crate::report::page_data::PageData;
use drawing::html::format::{count, number, with_unit};

/// The section.
pub(super) fn section(facts: &PageData) -> Markup {
    let mut groups: Vec<(&str, Vec<&NumberCounts>)> = Vec::new();
    for number in &facts.counts.numbers {
        let group = if number.column.group.is_empty() { "physics" } else { &number.column.group };
        match groups.iter_mut().find(|(name, _)| *name == group) {
            Some((_, numbers)) => numbers.push(number),
            None => groups.push((group, vec![number])),
        }
    }
    let varied = facts.counts.numbers.iter().filter(|number| number.cells.is_some()).count();
    html! {
        p {
            (varied) " of " (facts.counts.numbers.len()) " numbers vary. Bars are the samples, the line over them is "
            "the density that the recipe declares, the thick line below is its range. "
            em { "physics" } " follows from the others."
        }
        div.controls {
            label.search.needs-js {
                "Find " input type="search" id="find" placeholder="exposure, knot, _mm ..." autocomplete="off";
            }
            label.switch { input type="checkbox" id="by-class"; " Colour by class" }
        }
        @for (group, numbers) in &groups {
            details.group open {
                summary { (group) " " small { (numbers.iter().filter(|n| n.cells.is_some()).count()) " varied, "
                    (numbers.iter().filter(|n| n.cells.is_none()).count()) " fixed" } }
                div.multiples { @for number in numbers.iter().filter(|n| n.cells.is_some()) { (multiple(number)) } }
                @let fixed: Vec<_> = numbers.iter().filter(|n| n.cells.is_none()).collect();
                @if !fixed.is_empty() {
                    dl.fixed { @for number in fixed {
                        div.multiple data-name=(number.column.path()) title=(number.column.doc) {
                            dt { (number.column.key) }
                            dd { @if number.extent.count > 0 { (with_unit(number.extent.min, &number.column.unit)) }
                                @else { "no value" } }
                        }
                    } }
                }
            }
        }
    }
}

fn multiple(drawn: &NumberCounts) -> Markup {
    let (column, extent) = (&drawn.column, &drawn.extent);
    let unit = if column.unit == "1" { String::new() } else { format!(" [{}]", column.unit) };
    let title = format!(
        "{}{unit}: {} to {}, mean {}",
        column.path(),
        number(extent.min),
        number(extent.max),
        number(extent.mean().unwrap_or(f64::NAN))
    );
    let declared = drawn.declared.as_ref();
    html! {
        figure.multiple data-name=(column.path()) title=(column.doc) {
            figcaption { (column.key) span.dim { (unit) } }
            @if let Some(cells) = &drawn.cells {
                (svg::histogram(cells, &declared.map_or(Vec::new(), |law| law.curve(cells.axis)),
                    declared.map(|law| (law.min, law.max)), &title))
            }
            p.dim {
                "mean " (number(extent.mean().unwrap_or(f64::NAN)))
                @if extent.missing > 0 { ", missing in " (count(extent.missing)) }
                @if let Some(law) = declared { br; (law.words) }
            }
        }
    }
}
