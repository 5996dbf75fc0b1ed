//! What a page of `gen report` says in words and figures is true of the dataset, and where it may be written.

use std::{fs, os::unix::fs::symlink};

use parquet::record::Field;
use serde_json::json;
use test_support::pages::{between, page, page_of_damage, planks_page, values};
use test_support::program::{self, Place, Sample};

/// What a table says of a sample as a number.
fn figure(sample: &Sample, column: &str) -> f64 {
    match sample.columns[column] {
        Field::Double(value) => value,
        Field::Int(value) => value.into(),
        ref other => panic!("{column} is {other:?}"),
    }
}

/// The figures on a card, where they are of what `place` says: median, missing, saturated.
fn figures<'a>(card: &'a str, place: &str) -> Vec<&'a str> {
    let start = format!("<dt>{place}</dt><dd>");
    let told = between(card, &start, "</dd>").first().copied().unwrap_or_else(|| panic!("no `{place}` on {card}"));
    let figures: Vec<&str> = told.split(" · ").collect();
    let starts = ["median Range ", "Range missing ", "saturated "];
    assert_eq!(figures.len(), starts.len(), "{told}");
    let figures = figures.into_iter().zip(starts);
    figures.map(|(figure, start)| figure.strip_prefix(start).unwrap_or_else(|| panic!("{start}: {told}"))).collect()
}

/// Figures on cards are of the whole maps: the median to the last digit that is written, shares of what they name. What
/// rounding alone varies has no histogram.
#[test]
fn cards_tell_of_the_maps() {
    let place = Place::of_each_subject(&[]).into_iter().nth(2).expect("the saw-tooth piece");
    place.make("piece", "--n 4");
    let html = page(&place, "piece", "--frames 0");
    let drawn = between(&html, "<figure class=\"multiple\" data-name=\"", "\"");
    let dark = |path: &&&str| path.ends_with("scatter_dark_dn");
    // One dark level for all samples: its sums differ by rounding.
    assert_eq!((values(&html, "data-name").iter().filter(dark).count(), drawn.iter().filter(dark).count()), (1, 0));
    let cards = between(&html, "<article class=\"card\"", "</article>");
    for (index, sample) in place.samples("piece") {
        let card = cards.iter().find(|card| card.contains(&format!("id=\"s{index}\""))).expect("a card");
        let (range, label) = (sample.image("range").2, sample.image("label").2);
        let on: Vec<u16> = range.iter().zip(&label).filter(|(_, label)| **label > 0).map(|(range, _)| *range).collect();
        let mut measured: Vec<u16> = on.iter().copied().filter(|range| *range > 0).collect();
        measured.sort_unstable();
        let (low, high) = (measured[(measured.len() - 1) / 2], measured[measured.len() / 2]);
        let middle = 0.5 * (f64::from(low) + f64::from(high));
        let median = figure(&sample, "range_offset_mm") + middle * figure(&sample, "range_scale_mm");
        let told = figures(card, "on the object");
        // Four digits that count.
        let text: f64 = told[0].trim_end_matches(" mm").parse().expect("a number");
        assert!((text - median).abs() <= 0.6e-3 * median.abs(), "sample {index}: {told:?} and {median}");
        let share = |of: &[u16]| 100.0 * of.iter().filter(|n| **n == 0).count() as f64 / of.len() as f64;
        let missing = told[1].trim_end_matches(" of all pixels)").split(" (");
        for (text, share) in missing.zip([share(&on), share(&range)]) {
            let digits: f64 = text.trim_start_matches("< ").trim_end_matches(" %").parse().expect("a number");
            assert!((digits - share).abs() <= 0.051, "sample {index}: {told:?} and {share}");
        }
        let most = sample
            .image("reflectance")
            .2
            .iter()
            .zip(&label)
            .filter(|(_, label)| **label > 0)
            .filter(|(dn, _)| **dn == 255)
            .count();
        let share = 100.0 * most as f64 / on.len() as f64;
        let digits: f64 = told[2].trim_start_matches("< ").trim_end_matches(" %").parse().expect("a number");
        assert!((digits - share).abs() <= 0.051, "sample {index}: {told:?} and {share}");
    }
}

/// The head gives the field from the smallest to the largest of all samples, not that of the one sample that is shown.
#[test]
fn the_field_is_that_of_all_samples() {
    let place = Place::with(&[]);
    place.make("planks", "--n 6");
    let html = page(&place, "planks", "--frames 0 --samples 1");
    let samples = place.samples("planks");
    for (text, [count, pitch]) in
        between(&html, " px (", " mm)")[0].split(" × ").zip([["cols", "col_mm"], ["rows", "row_mm"]])
    {
        let mut sides: Vec<f64> =
            samples.values().map(|sample| figure(sample, count) * figure(sample, pitch)).collect();
        sides.sort_unstable_by(f64::total_cmp);
        let ends: Vec<f64> = text.split(" to ").map(|end| end.parse().expect("a number")).collect();
        for (end, side) in [(ends[0], sides[0]), (ends[ends.len() - 1], sides[5])] {
            assert!((end - side).abs() <= 0.6e-3 * side, "{count}: {text} and {sides:?}");
        }
        assert_eq!(ends.len() == 2, sides[5] - sides[0] > 1e-3 * sides[0], "{count}: {text} and {sides:?}");
    }
}

/// Of maps and labels that a dataset does not keep the page says nothing but that.
#[test]
fn what_is_not_kept_is_not_promised() {
    let without = [
        ["png: [range, reflectance, scatter, label]", "png: [range, reflectance]"],
        ["exr: [range, reflectance, scatter, label, instance]", "exr: []"],
    ];
    let place = Place::with(&without);
    place.make("planks", "--n 2");
    let html = page(&place, "planks", "--frames 1");
    assert!(html.contains(": range and reflectance as a line-laser profiler measures them, without labels."));
    for text in ["id=\"labels\"", "aria-label=\"Pixel classes\"", "part with most to see"] {
        assert!(!html.contains(text), "{text}");
    }
    let cards = between(&html, "<article class=\"card\"", "</article>");
    for card in &cards {
        assert_eq!(figures(card, "of all pixels").len(), 3);
        assert!(!card.contains("on the object"));
        assert_eq!((card.matches("not kept").count(), card.matches("<img").count()), (1, 2));
    }
    let (_, html) = planks_page("--frames 1");
    assert!(
        html.contains(
            ": range, reflectance and scatter as a line-laser profiler measures them, with pixel-exact labels."
        )
    );
    assert!(html.contains("id=\"labels\"") && html.contains("aria-label=\"Pixel classes\""));
    assert!(html.contains("part with most to see"));
}

/// Which samples are shown is said of classes of any sizes, and classes are coloured as their pixels are.
#[test]
fn samples_and_classes_are_told_as_they_are() {
    let (place, html) = planks_page("--frames 0");
    assert!(html.contains("<p>All 6 samples. "));
    assert!(
        page(&place, "planks", "--frames 0 --samples 4").contains("<p>4 of 6 samples: classes share the places evenly")
    );
    let head = place.json("planks/dataset.json");
    let classes: Vec<&str> =
        head["classes"].as_array().expect("classes").iter().filter_map(|name| name.as_str()).collect();
    let colour = |class: usize| between(&html, &format!(".c{class} {{ --c: "), ";")[0];
    for (class, name) in classes.iter().enumerate() {
        let swatch = format!("background:{}\"></span>{}", colour(class), name.replace('_', " "));
        assert_eq!(html.contains(&swatch), *name != "mixed", "{name}: {}", colour(class));
        assert!((0..class).all(|other| colour(other) != colour(class)), "{name}");
    }
    assert!(classes.contains(&"rot") && classes.contains(&"mixed"), "{classes:?}");
}

/// Shards in a row that are not finished are one row of the page.
#[test]
fn unfinished_shards_are_told_together() {
    let place = Place::with(&[]);
    place.make("planks", "--n 6 --samples-per-shard 1");
    for shard in [1, 2, 3, 5] {
        fs::remove_file(place.path(&format!("planks/shards/0000{shard}.json"))).expect("a manifest");
    }
    let html = page(&place, "planks", "--frames 0");
    let section = between(&html, "<section class=\"trouble\" id=\"troubles\"", "</section>")[0];
    let rows: Vec<_> = between(section, "<tr><td><code>", "</code>");
    assert_eq!(rows, ["shards 1 to 3", "shards/00005.json"]);
    assert!(section.contains("their 3 manifests are missing") && html.contains("All 2 samples that can be read."));
}

/// A check that is stale is made again with its own model, split and seed.
#[test]
fn a_check_is_made_again_as_it_was() {
    let place = Place::with(&[]);
    place.make("planks", "--n 2");
    fs::create_dir(place.path("planks/reports")).expect("a folder");
    let check = json!({
        "format": "sheetlight-check", "model": {"path": "my \
            models/knots.onnx"}, "task": "segment", "split": "train", "seed": 3,
        "accuracy": {}, "classes": [], "confusion": [], "calibration": {},
    });
    place.write("planks/reports/check-knots-train.json", check.to_string());
    place.write("planks/reports/check-other-all.json", "{");
    let html = page(&place, "planks", "--frames 0");
    let models = between(&html, "<article class=\"model\"", "</article>");
    assert!(
        models[0].contains("gen check planks --model 'my models/knots.onnx' --split train --seed 3 --save"),
        "{}",
        models[0]
    );
    assert!(models[1].contains("gen check planks --model MODEL.onnx --save"), "{}", models[1]);
}

/// A validation that found the damage is not asked whether the damage is newer.
#[test]
fn a_validation_that_lists_the_damage_is_current() {
    let (place, _) = planks_page("--frames 0");
    let table = place.tree("planks/data").into_keys().next().expect("a table");
    let path = format!("planks/data/{table}");
    let whole = fs::read(place.path(&path)).expect("the table is there");
    place.write(&path, &whole[..whole.len() / 2]);
    assert_ne!(place.run("validate planks --save --rerender 0").code, 0);
    let html = page_of_damage(&place, "planks", "--frames 0");
    let section = between(&html, "<section id=\"validation\"", "</section>")[0];
    assert!(section.contains(&table) && !section.contains("Damaged since?"), "{section}");
    assert!(values(&html, "id").contains(&"troubles"));
}

/// A page never takes the place of what belongs to the dataset or of a kept result, whatever path leads there.
#[test]
fn a_page_does_not_overwrite_the_dataset() {
    let place = Place::with(&[]);
    place.make("planks", "--n 1");
    place.done("validate planks --save --rerender 0");
    symlink(place.path("planks"), place.path("link")).expect("a link");
    symlink(place.path("planks/data"), place.path("tables")).expect("a link");
    let before = place.tree("planks");
    for out in [
        "planks/dataset.json",
        "planks/page.html",
        "planks/shards/00000.json",
        "planks/reports/../dataset.json",
        "planks/reports/validation.json",
        "./planks/data/../../planks/README.md",
        "link/dataset.json",
        "tables/page.html",
    ] {
        for dataset in ["planks", "link"] {
            let run = place.run(&format!("report {dataset} --frames 0 --no-timing --out {out}"));
            assert!(run.code == 2 && run.err.contains("choose"), "{dataset} {out}: {} {}", run.code, run.err);
        }
        program::assert_same(&before, &place.tree("planks"), out);
    }
    for out in [
        "planks/reports/other.html",
        "link/reports/third.html",
        "planks/data/../reports/fourth.html",
        "planks/../page.html",
    ] {
        place.done(&format!("report planks --frames 0 --no-timing --out {out}"));
        assert!(place.path(out).is_file(), "{out}");
    }
}
