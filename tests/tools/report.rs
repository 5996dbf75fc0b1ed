//! `gen report` as its users run it: the page against the dataset, damaged datasets, hostile text, kept results.

use std::{collections::BTreeMap, fs};

use parquet::record::Field;
use serde_json::json;
use test_support::pages::{between, page, page_of_damage, planks_page, values};
use test_support::program::Place;

/// What a saved validation calls itself.
const VALIDATION: &str = "sheetlight-validation";

/// The page counts what the tables hold, shows every class, and gives the same bytes twice and on any number of
/// threads.
#[test]
fn the_page_says_what_is_in_the_dataset() {
    let (place, html) = planks_page("");
    let head = place.json("planks/dataset.json");
    let samples = place.samples("planks");
    let cards = between(&html, "<article class=\"card\"", "</article>");
    assert_eq!(cards.len(), samples.len());
    let names = head["classes"].as_array().expect("classes");
    let mut expected: BTreeMap<&str, usize> = BTreeMap::new();
    for sample in samples.values() {
        let Field::Long(class) = sample.columns["class"] else { panic!("no class") };
        *expected.entry(names[class as usize].as_str().expect("a name")).or_default() += 1;
    }
    let classes: Vec<_> = cards.iter().map(|card| values(card, "data-class")[0]).collect();
    for (class, count) in &expected {
        assert_eq!(classes.iter().filter(|name| *name == class).count(), *count, "{class}");
        let rows = between(&html, &format!("<tr data-class=\"{class}\">"), "</tr>");
        let told: Vec<_> = between(rows[0], "<td class=\"n\">", "</td>");
        assert_eq!(told[0], count.to_string(), "{class}: {told:?}");
    }
    for (card, (index, sample)) in cards.iter().zip({
        let mut sorted: Vec<_> = samples.iter().collect();
        sorted.sort_by_key(|(index, sample)| (format!("{:?}", sample.columns["class"]), **index));
        sorted
    }) {
        assert!(card.contains(&format!("Sample {index}<")) && card.contains(sample.text("id")), "{index}");
        assert_eq!(values(card, "data-split"), [sample.text("split")]);
        assert_eq!(card.matches("src=\"data:image/png;base64,").count(), 3);
        assert!(card.contains("--labels:url(data:image/png;base64,"));
    }
    let numbers = head["parameters"].as_array().expect("numbers").iter();
    let paths: Vec<_> =
        numbers.map(|n| format!("{}.{}", n["group"].as_str().unwrap(), n["key"].as_str().unwrap())).collect();
    let shown = values(&html, "data-name");
    assert!(paths.iter().all(|path| shown.contains(&path.as_str())), "{} of {}", shown.len(), paths.len());
    assert!(html.contains(head["recipe"]["hash"].as_str().expect("a hash")) && html.contains("complete"));
    assert!(between(&html, "<article class=\"frame\"", "</article>").len() > 2);
    assert!(html.contains("gen validate planks --save") && html.contains("No time was measured"));
    // An element of SVG that is left open swallows those behind it.
    for name in ["rect", "line", "path", "circle", "image", "text", "svg"] {
        let opened = html.matches(&format!("<{name}")).count();
        assert_eq!(opened, html.matches(&format!("</{name}>")).count(), "{name}");
    }
    assert_eq!(page(&place, "planks", "--threads 1"), html);
    assert!(html.len() < 10_000_000, "{} bytes", html.len());
}

/// Nothing is asked of a network or of another file: every address is in the page, and its policy forbids others.
#[test]
fn nothing_is_fetched() {
    let (_place, html) = planks_page("--frames 0");
    for attribute in ["src", "href", "xlink:href", "action", "poster", "srcset", "data"] {
        for value in values(&html, attribute) {
            assert!(
                value.starts_with("data:") || value.starts_with('#'),
                "{attribute}: {}",
                &value[..value.len().min(60)]
            );
        }
    }
    for word in
        ["@import", "fetch(", "XMLHttpRequest", "WebSocket", "importScripts", "sendBeacon", "url(http", "url(//"]
    {
        assert!(!html.contains(word), "{word}");
    }
    assert!(html.contains("default-src 'none'"), "a policy forbids what the page does not need");
}

/// Text of a recipe, of file names and of kept results never becomes markup.
#[test]
fn text_is_escaped() {
    let place = Place::with(&[]);
    place.make("planks", "--n 2");
    let mut head = place.json("planks/dataset.json");
    head["recipe"]["name"] = json!("</title><script>alert(1)</script>");
    head["recipe"]["text"] = json!("# </pre><img src=x onerror=alert(2)>");
    head["classes"][0] = json!("\"><script>alert(3)</script>");
    head["parameters"][0]["doc"] = json!("\" onmouseover=\"alert(4)");
    place.write("planks/dataset.json", head.to_string());
    fs::create_dir(place.path("planks/reports")).expect("a folder");
    let fault = json!({"code": "<script>alert(5)</script>", "place": "<b>", "what": "</li>", "remedy": "<i>"});
    place.write(
        "planks/reports/validation.json",
        json!({"format": VALIDATION, "clean": false, "faults": [fault], "<u>": [{"<s>": "<q>"}]}).to_string(),
    );
    let check = json!({
        "format": "sheetlight-check", "model": {}, "task": "<b>", "split": "<b>", "accuracy": {}, "confusion": [],
            "calibration": {},
        "classes": [{"name": "<script>alert(6)</script>"}], "worst": [{"picture": "../../tiny.yaml"}],
    });
    place.write("planks/reports/check-<x>.json", check.to_string());
    let html = page(&place, "planks", "");
    assert_eq!(html.matches("<script>").count(), 1, "the page's own");
    for text in ["<img src=x", "onmouseover=\"", "<b>", "<u>", "<s>", "<q>", "check-<x>", "<title></title>"] {
        assert!(!html.contains(text), "{text}");
    }
    assert!(html.contains("&lt;script&gt;alert(1)&lt;/script&gt;") && html.contains("&lt;script&gt;alert(6)"));
}

/// Kept results are shown; those of another dataset, damaged ones and absent ones say so.
#[test]
fn kept_results_are_shown_or_stale() {
    let (place, html) = planks_page("--frames 0");
    assert!(html.contains("Nothing is kept") && html.contains("No check of a model is kept"));
    let sha = |bytes: &[u8]| {
        use sha2::{Digest, Sha256};
        Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect::<String>()
    };
    let read = |name: &str| fs::read(place.path(name)).expect("the file is there");
    let manifests = [read("planks/shards/00000.json"), read("planks/shards/00001.json")].concat();
    let mut document = json!({
        "format": VALIDATION, "clean": false, "samples": 6, "images": 1, "bytes": 1_500_000,
        "dataset_sha256": sha(&read("planks/dataset.json")), "manifests_sha256": sha(&manifests),
        "faults": [{"code": "file-checksum", "place": "data/x.parquet", "what": "another \
            sum", "remedy": "make it again"}],
    });
    place.write("planks/reports/validation.json", document.to_string());
    let current = page(&place, "planks", "--frames 0");
    for text in ["file-checksum", "data/x.parquet", "another sum", "make it again", "6 samples, 1 image, 1.5 MB"] {
        assert!(current.contains(text), "{text}");
    }
    assert!(!current.contains("class=\"stale\""), "it is of this dataset");
    document["manifests_sha256"] = json!("0");
    place.write("planks/reports/validation.json", document.to_string());
    place.write("planks/reports/check-a.json", "{");
    let stale = page(&place, "planks", "--frames 0");
    assert!(stale.contains("Stale: ") && stale.contains("reports/check-a.json</code> cannot be read"));
    assert_eq!(stale.matches("class=\"stale\"").count(), 2, "one notice for each document");
}

/// Only a validation of the dataset as it is, in which the page finds no damage, reads as clean.
#[test]
fn clean_is_said_of_what_was_validated() {
    let (place, _) = planks_page("--frames 0");
    let verdict =
        || between(&page(&place, "planks", "--frames 0"), "<section id=\"validation\"", "</section>")[0].to_owned();
    let good = "<span class=\"badge good\">clean</span>";
    place.done("validate planks --save --rerender 0");
    assert!(verdict().contains(good), "{}", verdict());
    let table = place.tree("planks/data").into_keys().next().expect("a table");
    let path = format!("planks/data/{table}");
    let whole = fs::read(place.path(&path)).expect("the table is there");
    // The footer is cut off, the length stays, and no sum of a document changes.
    let damaged: Vec<u8> = whole.iter().take(whole.len() - 100).copied().chain([0; 100]).collect();
    place.write(&path, damaged);
    let html = page_of_damage(&place, "planks", "--frames 0");
    let told = between(&html, "<section id=\"validation\"", "</section>")[0];
    assert!(
        !told.contains(good) && told.contains("clean when it was validated") && told.contains("#troubles"),
        "{told}"
    );
    place.write(&path, whole);
    assert!(verdict().contains(good));
    for (text, what) in [
        ("{}", "its `format` is not \"sheetlight-validation\""),
        ("[]", "its `format` is not"),
        ("{\"format\": \"sheetlight-check\", \"clean\": true, \"faults\": []}", "its `format` is not"),
        ("{\"format\": \"sheetlight-validation\", \"faults\": []}", "its `clean` is missing or not true or false"),
    ] {
        place.write("planks/reports/validation.json", text);
        let told = verdict();
        let escaped = what.replace('"', "&quot;");
        assert!(!told.contains(good) && told.contains("cannot be read: ") && told.contains(&escaped), "{text}: {told}");
    }
    place.write("planks/reports/check-x.json", "{\"format\": \"other\"}");
    let html = page(&place, "planks", "--frames 0");
    let model = between(&html, "<article class=\"model\"", "</article>")[0];
    assert!(model.contains("its `format` is not &quot;sheetlight-check&quot;") && !model.contains("<h4>"), "{model}");
}

/// The command that makes a dataset again is one that a shell takes, and names what the recipe does not.
#[test]
fn the_command_makes_it_again() {
    let place = Place::with(&[]);
    place.make("planks", "--n 2");
    let html = page(&place, "planks", "--frames 0");
    assert!(html.contains("gen --recipe planks --seed 0 --n 2 --out again"), "the recipe's own size of shards");
    place.make("parts", "--n 2 --samples-per-shard 1");
    fs::rename(place.path("parts"), place.path("my parts")).expect("a folder can be renamed");
    let run = place.command("report --no-timing --frames 0").arg("my parts").output().expect("the program starts");
    assert!(run.status.success());
    let html = fs::read_to_string(place.path("my parts/reports/report.html")).expect("a page");
    assert!(html.contains("gen --recipe 'my parts' --seed 0 --n 2 --samples-per-shard 1 --out again"));
    assert!(html.contains("gen validate 'my parts' --save"));
}

/// What is said to be on disk is there: a missing file is counted nowhere, one that is cut short has the size it has.
#[test]
fn sizes_are_of_what_is_there() {
    let place = Place::of_each_subject(&[]).into_iter().next_back().expect("the mesh");
    place.make("part", "--n 2");
    let (asset, bytes) = place.tree("part/assets").into_iter().next().expect("the file of triangles");
    let row_of = |html: String, kind: &str| {
        let row =
            between(&html, &format!("<th scope=\"row\">{kind}</th>"), "</tr>").first().map(|row| (*row).to_owned());
        row.map(|row| between(&row, "<td class=\"n\">", "</td>")[..2].join(" ")).unwrap_or_default()
    };
    let whole = row_of(page(&place, "part", "--frames 0"), "files of the recipe");
    assert_eq!(whole.split(' ').next(), Some("1"));
    let row = |kind: &str| row_of(page_of_damage(&place, "part", "--frames 0"), kind);
    place.write(&format!("part/assets/{asset}"), &bytes[..100]);
    assert_eq!(row("files of the recipe"), "1 100 bytes");
    fs::remove_file(place.path(&format!("part/assets/{asset}"))).expect("a file");
    assert_eq!(row("files of the recipe"), "");
}

/// An unfinished or damaged dataset has a page that says what is missing, with status 1 where it is damaged: guards
/// every result made of a part of the data that is told as if it were of all. What is no dataset is refused.
#[test]
fn damage_has_a_page_too() {
    let (place, _) = planks_page("--frames 0");
    fs::remove_file(place.path("planks/shards/00001.json")).expect("a manifest");
    let html = page(&place, "planks", "--frames 0");
    assert!(html.contains("unfinished") && html.contains("shards/00001.json"));
    assert_eq!(between(&html, "<article class=\"card\"", "</article>").len(), 4);
    let newer = place.path("planks/shards/00000.json");
    let manifest = fs::read_to_string(&newer).expect("a manifest");
    fs::write(&newer, manifest.replacen("\"schema_version\": [\n    1", "\"schema_version\": [\n    2", 1))
        .expect("it is written");
    let html = page_of_damage(&place, "planks", "--frames 0");
    assert!(html.contains("newer") && html.contains("shards/00000.json") && html.contains("run gen validate"));
    fs::write(&newer, manifest).expect("it is written");
    let table = place.tree("planks/data").into_keys().find(|name| name.contains("00000")).expect("a table");
    let path = format!("planks/data/{table}");
    let bytes = fs::read(place.path(&path)).expect("the table is there");
    place.write(&path, &bytes[..bytes.len() / 2]);
    let html = page_of_damage(&place, "planks", "--frames 0");
    assert!(html.contains("and should have") && html.contains(&table));
    fs::remove_file(place.path(&path)).expect("a table");
    assert!(page_of_damage(&place, "planks", "--frames 0").contains("is missing"));

    place.write("planks/dataset.json", "{\"format\": 1");
    let run = place.run("report planks --out page.html");
    assert_eq!(run.code, 1, "{}", run.err);
    assert!(fs::read_to_string(place.path("page.html")).expect("a page").contains("No dataset can be read here"));
    assert_eq!(place.run("report nothing").code, 2);
    assert_eq!(place.run("report .").code, 2);
    let run = place.run("report planks --out no/where.html");
    assert!(run.code == 1 && run.err.contains("--out"), "{}", run.err);
}

/// Every subject has a page: samples, frames and histograms.
#[test]
fn every_subject_has_a_page() {
    for place in Place::of_each_subject(&[]) {
        place.make("set", "--n 3");
        let html = page(&place, "set", "--frames 2 --samples 2");
        assert_eq!(between(&html, "<article class=\"card\"", "</article>").len(), 2);
        assert_eq!(html.matches("class=\"found\"").count(), 2);
        assert!(html.matches("class=\"histogram\"").count() > 10);
    }
}
