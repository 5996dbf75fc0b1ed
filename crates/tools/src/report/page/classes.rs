//! Classes of samples against the recipe's shares, areas of pixel classes, and objects with their sizes.

use maud::{Markup, html};

use super::elements::table;
use super::svg;
use crate::report::histogram::DRAWN_ROUNDING;
use crate::report::page_data::PageData;
use crate::report::palette::class_hex;
use drawing::html::format::{count, name, number, percent};
use optical_bench::split::Split;

/// The section.
pub(super) fn section(facts: &PageData) -> Markup {
    html! {
        h3 { "Samples of each class" }
        (samples(facts))
        h3 { "Pixels and objects" }
        (pixels(facts))
    }
}

fn samples(facts: &PageData) -> Markup {
    let (counts, total) = (&facts.counts, facts.counts.total());
    let share = |class: &String| {
        let recipe = facts.recipe.as_ref().ok()?;
        recipe.classes().iter().find(|known| known.name == *class).map(|known| known.share)
    };
    let rows: Vec<_> = facts.head.classes.iter().enumerate().map(|(i, class)| (i, class, share(class))).collect();
    let most = rows.iter().map(|(i, _, share)| (counts.of_class(*i) as f64).max(share.unwrap_or(0.0) * total as f64));
    let most = most.fold(1.0, f64::max);
    let width = |n: f64| format!("{:.2}", 300.0 * n / most);
    html! {
        p.key {
            @for (place, split) in Split::ALL.iter().enumerate() {
                span { i class={ "swatch split" (place) } {} (split.name()) }
            }
            span { i.tick {} "the recipe's share" }
        }
        div.scroll tabindex="0" {
            table.counts {
                thead { tr { th { "Class" } th { "" } th.n { "samples" } th.n { "expected" }
                    @for split in Split::ALL { th.n { (split.name()) } } } }
                tbody {
                    @for (class, title, share) in &rows {
                        @let splits = counts.samples[*class];
                        @let expected = share.map(|share| share * total as f64);
                        tr data-class=(title) {
                            th scope="row" { i class={ "dot c" (class) } {} (name(title)) }
                            td.bar {
                                svg viewBox="0 0 300 14" preserveAspectRatio="none" role="img"
                                    aria-label={ (counts.of_class(*class)) " samples" } {
                                    @for place in 0..3 {
                                        rect class={ "split" (place) } y="2" height="10"
                                            x=(width(splits[..place].iter().sum::<u64>() as f64))
                                                width=(width(splits[place] as f64)) {}
                                    }
                                    @if let Some(expected) = expected { line.expected x1=(width(expected))
                                        x2=(width(expected)) y1="0" y2="14" {} }
                                }
                            }
                            td.n { (count(counts.of_class(*class))) }
                            td.n { (expected.map_or("-".into(), number)) }
                            @for n in splits { td.n { (count(n)) } }
                        }
                    }
                }
                tfoot { tr { th scope="row" { "all" } td {} td.n { (count(total)) } td.n { (count(total)) }
                    @for place in 0..3 { td.n { (count(counts.samples.iter().map(|splits| splits[place]).sum())) } } } }
            }
        }
    }
}

fn pixels(facts: &PageData) -> Markup {
    let all: u64 = facts.counts.kinds.iter().map(|kind| kind.pixels).sum();
    let total = facts.counts.total();
    let columns = [
        ("Pixel class", false),
        ("of all pixels", true),
        ("samples with it", true),
        ("objects", true),
        ("mean diameter", true),
        ("diameters [mm]", false),
    ];
    let rows = html! {
        @for kind in &facts.counts.kinds {
            tr {
                th scope="row" { span.swatch style={ "background:" (class_hex(kind.value)) } {} (name(&kind.name)) }
                td.n { (percent(kind.pixels as f64 / all.max(1) as f64)) }
                td.n { (count(kind.samples)) " (" (percent(kind.samples as f64 / total.max(1) as f64)) ")" }
                td.n { (count(kind.objects)) }
                td.n { @if let Some(mean) = kind.extent.mean() { (number(mean)) " mm" } @else { "-" } }
                td.small {
                    @if let Some(cells) = &kind.cells {
                        (svg::histogram(cells, &[], None, &format!("Diameters of {}", name(&kind.name))))
                    } @else if kind.extent.is_constant(DRAWN_ROUNDING) { "all " (number(kind.extent.min)) }
                }
            }
        }
    };
    table(&columns, rows)
}
