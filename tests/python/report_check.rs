//! What `gen check` keeps is on the page of `gen report`.

use test_support::pages::{between, page};

use crate::models;

/// What `gen check --save` keeps is on the page, with its figures and pictures, until the dataset changes.
#[test]
fn checks_are_kept_and_shown() {
    let place = models::planks();
    let class = place.json("planks/dataset.json")["classes"][0].as_str().expect("a class").to_owned();
    let sidecar = format!(
        "task: classify_pixels\n{}\nwindow_px: 8\npatches_per_class: 20\nclasses: [{{name: a, of: [clear]}}, {{name: \
            b, of: [rot]}}]",
        models::CHANNEL
    );
    let run = models::run(&place, "mean_sign.onnx", &sidecar, "--save --worst 3");
    assert!(run.code == 0 && run.err.contains("reports/check-mean_sign-all.json"), "{class}: {}", run.err);
    let kept = place.json("planks/reports/check-mean_sign-all.json");
    assert_eq!(kept["dataset_sha256"].as_str().map(str::len), Some(64));
    let pictures: Vec<_> = kept["worst"].as_array().expect("a list").iter().map(|w| w["picture"].as_str()).collect();
    assert!(
        !pictures.is_empty()
            && pictures.iter().all(|name| name.is_some_and(|name| name.starts_with("check-mean_sign-all-wrong-")))
    );
    let html = page(&place, "planks", "--frames 0");
    let model = between(&html, "<article class=\"model\"", "</article>");
    assert_eq!(model.len(), 1);
    assert!(!model[0].contains("class=\"stale\""));
    assert_eq!(model[0].matches("<img").count(), pictures.len());
    for row in kept["confusion"].as_array().expect("a table") {
        assert!(row.as_array().expect("a row").iter().all(|n| model[0].contains(&format!(">{n}</td>"))), "{row}");
    }
    place.make("planks", "--n 8 --samples-per-shard 4");
    assert!(page(&place, "planks", "--frames 0").contains("Stale: "));
}
