//! Damage to dataset.json, manifests and card, without any file that gives away its bytes.

use std::fs;
use std::path::Path;

use dataset::validate::Code::*;
use serde_json::{Value, json};

use super::place::{MANIFEST, after, edit};

const HEAD: &str = "dataset.json";

#[test]
#[ignore = "long"]
fn dataset_json() {
    let head = |change: fn(&mut Value)| move |root: &Path| edit(&root.join(HEAD), change);
    after(|root| fs::remove_file(root.join(HEAD)).expect("there"), &[DatasetMissing], HEAD, "no head");
    after(|root| fs::write(root.join(HEAD), "").expect("written"), &[DatasetUnreadable], HEAD, "an empty head");
    after(|root| fs::write(root.join(HEAD), "{").expect("written"), &[DatasetUnreadable], HEAD, "no JSON");
    after(head(|v| v["format"] = "tiff".into()), &[DatasetUnreadable], HEAD, "another format");
    after(head(|v| v["schema_version"] = json!([2, 0])), &[VersionUnknown], HEAD, "a newer schema");
    after(head(|v| v["schema_version"] = json!([0, 9])), &[VersionUnknown], HEAD, "an older schema");
    after(head(|v| v["subject"] = "blister".into()), &[DatasetUnreadable], HEAD, "another subject");
    after(head(|v| v["shards"] = 3.into()), &[DatasetUnreadable], HEAD, "more shards than samples ask for");
    // Manifests name generator and hash too.
    let version = head(|v| v["generator"]["version"] = "0.0.1".into());
    after(version, &[DatasetDiffers], HEAD, "another program version");
    after(head(|v| v["target"] = "riscv64-none".into()), &[WriterDiffers, CardDiffers], HEAD, "another target");
    let name = head(|v| v["recipe"]["name"] = "knots".into());
    after(name, &[DatasetDiffers, CardDiffers], HEAD, "another name");
    let edited = |v: &mut Value| {
        let text = v["recipe"]["text"].as_str().expect("a text").replacen("power_mw: 50", "power_mw: 60", 1);
        v["recipe"]["text"] = text.into();
    };
    after(|root| edit(&root.join(HEAD), edited), &[RecipeDiffers, CardDiffers], HEAD, "an edited recipe");
    after(head(|v| v["recipe"]["text"] = "a: [".into()), &[RecipeDiffers, CardDiffers], HEAD, "no recipe");
    let hash = head(|v| v["recipe"]["hash"] = "0".repeat(64).into());
    after(hash, &[DatasetDiffers], HEAD, "another hash");
    let comment = |v: &mut Value| {
        let text = v["recipe"]["text"].as_str().expect("a text").replacen("small scan", "large scan", 1);
        v["recipe"]["text"] = text.into();
    };
    after(|root| edit(&root.join(HEAD), comment), &[CardDiffers], "README.md", "an edited comment");
    let seed = head(|v| v["seed"] = 6.into());
    after(seed, &[DatasetDiffers], HEAD, "another seed");
    after(head(|v| v["classes"][0] = "oak".into()), &[DatasetDiffers, SchemaDiffers, CardDiffers], HEAD, "a class");
    let share = head(|v| v["splits"]["train"] = 0.7.into());
    after(share, &[DatasetDiffers, CardDiffers], HEAD, "another share");
    let doc = head(|v| v["parameters"][3]["doc"] = "A number.".into());
    after(doc, &[DatasetDiffers, SchemaDiffers, CardDiffers], HEAD, "what a number means");
    after(head(|v| v["extra"] = 1.into()), &[DatasetDiffers, CardDiffers], HEAD, "a key too many");
    let compact = |root: &Path| {
        let value: Value = serde_json::from_slice(&fs::read(root.join(HEAD)).expect("there")).expect("JSON");
        fs::write(root.join(HEAD), value.to_string()).expect("written");
    };
    after(compact, &[DatasetDiffers, CardDiffers], HEAD, "other blanks");
}

#[test]
#[ignore = "long"]
fn manifests() {
    let list = |change: fn(&mut Value)| move |root: &Path| edit(&root.join(MANIFEST), change);
    let unfinished = |root: &Path| fs::remove_file(root.join(MANIFEST)).expect("there");
    after(unfinished, &[ManifestMissing, FileUnexpected], MANIFEST, "no manifest");
    let empty = |root: &Path| fs::write(root.join(MANIFEST), "").expect("written");
    after(empty, &[ManifestUnreadable], MANIFEST, "an empty manifest");
    after(list(|v| v["count"] = 2.into()), &[ManifestDiffers], MANIFEST, "another count");
    after(list(|v| v["first"] = 1.into()), &[ManifestDiffers], MANIFEST, "another first index");
    after(list(|v| v["shard"] = 1.into()), &[ManifestDiffers], MANIFEST, "another number");
    after(list(|v| v["seed"] = 1.into()), &[ManifestDiffers], MANIFEST, "another seed");
    after(list(|v| v["recipe_hash"] = "0".into()), &[ManifestDiffers], MANIFEST, "another recipe");
    after(list(|v| v["schema_version"] = json!([9, 0])), &[VersionUnknown], MANIFEST, "a newer schema");
    after(list(|v| v["samples"][1]["class"] = "rot".into()), &[ManifestDiffers], MANIFEST, "the class of a sample");
    after(list(|v| v["samples"][0]["sha256"] = "0".into()), &[SampleChecksum], "sample 0", "the sum of a sample");
    after(list(|v| v["files"][0]["sha256"] = "0".into()), &[FileChecksum], "data/", "the sum of a file");
    after(list(|v| v["files"][0]["bytes"] = 7.into()), &[FileSize], "data/", "the size of a file");
    after(list(|v| v["files"][0]["rows"] = 9.into()), &[RowCount], "data/", "the rows of a file");
    let exr_rows = list(|v| {
        let files = v["files"].as_array_mut().expect("a list");
        let exr = files.iter_mut().find(|file| file["path"].as_str().is_some_and(|path| path.starts_with("exr")));
        exr.expect("an EXR file")["rows"] = 3.into();
    });
    after(exr_rows, &[ManifestDiffers], MANIFEST, "rows of a file without any");
    let twice = list(|v| {
        let file = v["files"][0].clone();
        v["files"].as_array_mut().expect("files").insert(0, file);
    });
    after(twice, &[ManifestDiffers], MANIFEST, "a file that is named twice");
    let outside = list(|v| v["files"][0]["path"] = "../../etc/passwd".into());
    after(outside, &[ManifestDiffers, FileUnexpected], MANIFEST, "a file outside of the folder");
}

#[test]
fn card() {
    let card = |change: fn(&str) -> String| {
        move |root: &Path| {
            let text = fs::read_to_string(root.join("README.md")).expect("there");
            fs::write(root.join("README.md"), change(&text)).expect("written");
        }
    };
    after(|root| fs::remove_file(root.join("README.md")).expect("there"), &[FileMissing], "README.md", "no card");
    after(card(|text| text.replacen("data/train-", "data/test-", 1)), &[CardDiffers], "README.md", "files of a split");
    after(card(|text| text.replacen("power_mw: 50", "power_mw: 60", 1)), &[CardDiffers], "README.md", "its recipe");
    // What its owner may change.
    let folder = super::place::whole();
    card(|text| text.replacen("license: cc0-1.0", "license: mit", 1) + "\n## Thanks\n\nTo the sawmill.\n")(
        folder.path(),
    );
    let report = super::place::inspect(folder.path());
    assert!(report.is_clean(), "{report}");
}
