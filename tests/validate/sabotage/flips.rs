//! A byte that is changed anywhere in a dataset is found, and nothing panics.

use std::fs;

use base::Stream;
use dataset::Dataset;
use rand::RngExt;
use sheetlight::generate::ExpectedDataset;

use super::place::{compare, inspect};
use test_support::program::{FRAMES, Place};

/// Kinds of files, and flips in each: 820 in a shard's, and some in the documents beside them.
const FLIPS: [(&str, usize); 6] = [
    ("dataset.json", 60),
    ("README.md", 60),
    ("croissant.json", 60),
    ("shards/", 170),
    (".parquet", 325),
    (".exr", 325),
];

/// 1000 bytes with any other value: of documents, of manifests, of tables and of EXR files.
#[test]
#[ignore = "long"]
fn a_thousand_flips_are_found() {
    let place = Place::with(&[FRAMES]);
    place.make("set", "--n 2");
    let root = place.path("set");
    let folder = Dataset::open(&root).expect("it opens");
    let again = ExpectedDataset::of(&folder).expect("its recipe loads");
    assert!(compare(&root, Ok(&again)).is_clean());
    let files = place.tree("set");
    let mut rng = Stream::root(6).child("flips").rng();
    for (kind, wanted) in FLIPS {
        let files: Vec<_> = files.iter().filter(|(path, _)| path.contains(kind)).collect();
        let total: usize = files.iter().map(|(_, bytes)| bytes.len()).sum();
        let mut flips = 0;
        while flips < wanted {
            let mut at = rng.random_range(0..total);
            let place = files.iter().find(|(_, bytes)| match at.checked_sub(bytes.len()) {
                Some(beyond) => {
                    at = beyond;
                    false
                }
                None => true,
            });
            let (path, bytes) = place.expect("a file");
            // The licence is its owner's.
            let line = bytes[..at].iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
            let words: [&[u8]; 2] = [b"license: ", b"  \"license\": "];
            if words.iter().any(|words| bytes[line..].starts_with(words) && at >= line + words.len()) {
                continue;
            }
            let mut damaged = (*bytes).clone();
            damaged[at] ^= rng.random_range(1..=255u8);
            fs::write(root.join(path), &damaged).expect("written");
            // What the recipe draws is read from the folder itself, where that was changed.
            let report = if kind == "dataset.json" { inspect(&root) } else { compare(&root, Ok(&again)) };
            assert!(!report.is_clean(), "byte {at} of {path}: {} -> {}", bytes[at], damaged[at]);
            fs::write(root.join(path), bytes).expect("written");
            flips += 1;
        }
    }
    assert!(inspect(&root).is_clean());
}
