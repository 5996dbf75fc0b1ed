//! The contact sheet: for a spread of samples Range, Reflectance and Scatter side by side, labels laid over them.

use maud::{Markup, html};
use output_schema::DatasetHead;

use super::elements::plain_classes;
use crate::report::page_data::PageData;
use crate::report::palette::{class_hex, labels_png, map_png};
use crate::report::sheet_sample::SheetSample;
use drawing::html::{
    ColourMap, colour_scale, data_url,
    format::{count, name, number, percent, with_unit},
};
use optical_bench::split::Split;

/// Titles and colours of the maps.
const PANELS: [(&str, ColourMap); 4] = [
    ("Range", ColourMap::Viridis),
    ("Reflectance", ColourMap::Grey),
    ("Scatter", ColourMap::Inferno),
    ("Grey", ColourMap::Grey),
];

/// The colours of a map: what is taken off each sample, and the ends of the scale.
struct ColourScale {
    relative: bool,
    low: f32,
    high: f32,
}

/// The section.
pub(super) fn section(facts: &PageData) -> Markup {
    let panels = if facts.head.images.holds("grey") { PANELS.len() } else { PANELS.len() - 1 };
    let scales: Vec<Option<ColourScale>> = (0..panels).map(|map| scale(&facts.samples, map)).collect();
    let (plain, labelled) = (plain_classes(facts.head), facts.head.images.holds("label"));
    html! {
        p {
            (shown(facts)) " "
            "Rows grow downwards in the order of exposure. Colours have one scale for all samples; tap or click a \
                sample to see it large."
        }
        (controls(facts))
        div.legends {
            @for ((map, (title, ramp)), scale) in PANELS.iter().enumerate().zip(&scales) {
                @if let Some(scale) = scale {
                    figure {
                        figcaption {
                            strong { (title) } " "
                            @match map {
                                0 if scale.relative => { "[" (facts.head.range_unit()) "], less the sample's median" }
                                0 => { "[" (facts.head.range_unit()) "]" }
                                1 => { "[DN], at the peak, dark level included" }
                                3 => { "[DN], under lamps, dark level included" }
                                _ => { "[DN], sum beside the peak, dark level included" }
                            }
                        }
                        (colour_scale(*ramp, scale.low.into(), scale.high.into(),
                            if map == 0 { facts.head.range_unit() } else { "DN" }))
                    }
                }
            }
        }
        ul.key aria-label=(if labelled { "Pixel classes" } else { "Colours" }) {
            @for kind in facts.counts.kinds.iter().filter(|kind| labelled && (kind.pixels > 0 || kind.value == 0)) {
                li { span.swatch style={ "background:" (class_hex(kind.value)) } {} (name(&kind.name))
                    @if plain.contains(&(kind.value as u8)) { span.dim { " (not tinted)" } } }
            }
            li { span.swatch style="background:#466ebe" {} "nothing measured" }
        }
        div.sheet id="sheet" {
            @for sample in &facts.samples { (card(facts, sample, &scales, &plain)) }
        }
        p.note hidden id="none" { "No sample on this page is of that class and split; the dataset may have some." }
    }
}

/// Which samples are shown, in words.
fn shown(facts: &PageData) -> String {
    let (shown, total) = (facts.samples.len() as u64, facts.counts.total());
    match (shown, total) {
        (_, 0) => "No sample can be read.".into(),
        (1, 1) => "The only sample.".into(),
        _ if shown == total && total < facts.head.samples => format!("All {} samples that can be read.", count(total)),
        _ if shown == total => format!("All {} samples.", count(total)),
        _ => format!(
            "{shown} of {} samples: classes share the places evenly, as far as each has samples, and each is spread \
                over the dataset.",
            count(total)
        ),
    }
}

fn controls(facts: &PageData) -> Markup {
    let classes = facts.head.classes.iter().enumerate();
    html! {
        div.controls {
            div.needs-js {
                fieldset {
                    legend { "Class" }
                    label.chip {
                        input type="radio" name="class" value="" checked;
                        span { "all " small { (count(facts.counts.total())) } }
                    }
                    @for (class, title) in classes {
                        label class={ "chip c" (class) } {
                            input type="radio" name="class" value=(title) data-c=(class);
                            span { i.dot {} (name(title)) " " small { (count(facts.counts.of_class(class))) } }
                        }
                    }
                }
                fieldset {
                    legend { "Split" }
                    label.chip { input type="radio" name="split" value="" checked; span { "all" } }
                    @for (place, split) in Split::ALL.iter().enumerate() {
                        label.chip {
                            input type="radio" name="split" value=(split.name());
                            span { (split.name()) " " small {
                                (count(facts.counts.samples.iter().map(|splits| splits[place]).sum())) } }
                        }
                    }
                }
                p { output id="shown" aria-live="polite" { (facts.samples.len()) " samples shown" }
                    span.dim { " · the address keeps the filter" } }
            }
            noscript { p.note { "Scripts are off: every sample is shown, and filters do not work." } }
            @if facts.head.images.holds("label") {
                label.switch { input type="checkbox" id="labels" checked; " Labels over the maps" }
            }
        }
    }
}

fn card(facts: &PageData, sample: &SheetSample, scales: &[Option<ColourScale>], plain: &[u8]) -> Markup {
    let class = facts.head.classes.get(sample.class).map_or("?", String::as_str);
    let on = if facts.head.images.holds("label") { "on the object" } else { "of all pixels" };
    let figures = figures(sample, facts.head);
    let overlay = labels_png(&sample.labels, sample.width, plain).ok().filter(|_| !sample.labels.is_empty());
    let style = overlay.map(|png| format!("--labels:url({})", data_url(&png)));
    let seen = sample.objects.iter().map(|(class, count)| format!("{count} {}", kind(facts, *class)));
    let seen: Vec<String> = seen.collect();
    html! {
        article.card id={ "s" (sample.index) } data-class=(class) data-split=(Split::ALL[sample.split].name()) {
            h3 {
                "Sample " (sample.index)
                span class={ "tag c" (sample.class) } { i.dot {} (name(class)) }
                span.tag { (Split::ALL[sample.split].name()) }
            }
            a.maps.wide[sample.width > sample.height] href={ "#s" (sample.index) } style=[style]
                aria-label={ "Sample " (sample.index) ", larger" } {
                @for ((map, (title, ramp)), scale) in PANELS.iter().enumerate().zip(scales) {
                    figure {
                        @match (&sample.maps[map], scale) {
                            (Some(values), Some(scale)) => {
                                span.map { img width=(sample.width) height=(sample.height)
                                    alt={ (title) " of sample " (sample.index) ", class " (name(class)) }
                                    src=(painted(values, sample, scale, *ramp)); }
                            }
                            (values, _) => {
                                span.map.empty style=(format!("aspect-ratio:{}/{}", sample.width, sample.height)) {
                                    @if values.is_some() { "nothing measured" } @else { "not kept" }
                                }
                            }
                        }
                        figcaption { (title) }
                    }
                }
            }
            dl {
                @if !sample.short.is_empty() {
                    div.wide.alarm { dt { "of little use" } dd { (sample.short.join("; ")) } }
                }
                @if !seen.is_empty() { div.wide { dt { "shows" } dd { (seen.join(", ")) } } }
                @if !figures.is_empty() { div.wide { dt { (on) } dd { (figures.join(" · ")) } } }
                @for number in sample.numbers.iter().filter(|number| varies(facts, &number.path)) {
                    div { dt { (number.path) } dd { (with_unit(number.value, &number.unit)) } }
                }
                div { dt { "size" } dd { (sample.size[1]) " × " (sample.size[0]) " px" } }
                div.wide { dt { "id" } dd { code { (sample.id) } } }
            }
        }
    }
}

/// What a card says of the whole maps: of the pixels on the object, or of all pixels without labels.
fn figures(sample: &SheetSample, head: &DatasetHead) -> Vec<String> {
    let range = sample.range.as_ref();
    let median = range.and_then(|range| range.median).map(|median| number(median.into()));
    let missing = range.and_then(|range| {
        let of_all = if head.images.holds("label") {
            format!(" ({} of all pixels)", percent(range.missing_of_all))
        } else {
            String::new()
        };
        Some(percent(range.missing?) + &of_all)
    });
    let all = [
        median.map(|median| format!("median Range {median} {}", head.range_unit())),
        missing.map(|missing| format!("Range missing {missing}")),
        sample.saturated.map(|share| format!("saturated {}", percent(share))),
    ];
    all.into_iter().flatten().collect()
}

/// Whether a drawn number differs between samples.
fn varies(facts: &PageData, path: &str) -> bool {
    facts.counts.numbers.iter().any(|number| number.cells.is_some() && number.column.path() == path)
}

/// A map in its colours.
fn painted(values: &[f32], sample: &SheetSample, scale: &ColourScale, ramp: ColourMap) -> String {
    let off = if scale.relative { middle(sample) } else { 0.0 };
    let values: Vec<f32> = values.iter().map(|value| value - off).collect();
    map_png(&values, sample.width, (scale.low, scale.high), ramp).map_or(String::new(), |png| data_url(&png))
}

fn kind(facts: &PageData, value: usize) -> String {
    facts.head.pixel_classes.get(value).map_or_else(|| value.to_string(), |title| name(title))
}

/// The numbers of a map where there is an object, sorted.
fn on_object(sample: &SheetSample, map: usize) -> Vec<f32> {
    let values = sample.maps[map].as_deref().unwrap_or_default().iter().enumerate();
    let on = |i: usize| sample.labels.get(i).is_none_or(|class| *class > 0);
    let mut values: Vec<f32> = values.filter(|(i, value)| !value.is_nan() && on(*i)).map(|(_, value)| *value).collect();
    values.sort_unstable_by(f32::total_cmp);
    values
}

/// The number that a share of `sorted` lies below.
fn quantile(sorted: &[f32], share: f64) -> Option<f32> {
    sorted.get(((sorted.len() as f64 - 1.0).max(0.0) * share).round() as usize).copied()
}

/// Median of Range on the object [mm or px]; 0 where nothing was measured.
fn middle(sample: &SheetSample) -> f32 {
    sample.range.and_then(|range| range.median).unwrap_or(0.0)
}

/// One scale for all samples: from the first to the 99th percentile of what they show on objects. Range is told from
/// the sample's median where samples differ in height more than their surfaces do.
fn scale(samples: &[SheetSample], map: usize) -> Option<ColourScale> {
    let sorted = samples.iter().map(|sample| (on_object(sample, map), middle(sample)));
    let sorted: Vec<(Vec<f32>, f32)> = sorted.filter(|(values, _)| !values.is_empty()).collect();
    let mut spans: Vec<f32> =
        sorted.iter().filter_map(|(v, _)| Some(quantile(v, 0.95)? - quantile(v, 0.05)?)).collect();
    spans.sort_unstable_by(f32::total_cmp);
    let ends = (f32::INFINITY, f32::NEG_INFINITY);
    let (low, high) = sorted.iter().fold(ends, |(low, high), (_, middle)| (low.min(*middle), high.max(*middle)));
    let relative = map == 0 && high - low > quantile(&spans, 0.5)?;
    // Quantiles of each sample stand for those of all: no picture of all numbers is held.
    let mut all: Vec<f32> = Vec::new();
    for (values, middle) in &sorted {
        let off = if relative { *middle } else { 0.0 };
        all.extend((0..=200).filter_map(|i| quantile(values, f64::from(i) / 200.0)).map(|value| value - off));
    }
    all.sort_unstable_by(f32::total_cmp);
    let (low, high) = (quantile(&all, 0.01)?, quantile(&all, 0.99)?);
    let low = if map == 1 { 0.0 } else { low };
    Some(ColourScale { relative, low, high: high.max(low + 1e-3) })
}
