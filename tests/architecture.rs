//! The table of dependencies in ARCHITECTURE.md, read off the sources.

use std::fs;
use std::path::PathBuf;

/// Folder or file, and what may not be named there.
const FORBIDDEN: [(&str, &[&str]); 32] = [
    ("crates/bench/src/lens.rs", &["crate::", "procedural"]),
    ("crates/bench/src/split.rs", &["crate::", "procedural"]),
    ("crates/bench/src/parameters.rs", &["crate::optics", "crate::recipe", "crate::frame", "crate::lens"]),
    ("crates/recipe/src/asset.rs", &["crate::", "procedural", "output_schema"]),
    ("crates/numerics/src/chance", &["crate::", "procedural", "output_schema"]),
    ("crates/numerics/src/quadrature.rs", &["crate::", "procedural", "output_schema"]),
    ("procedural/src", &["sheetlight", "output_schema", "arrow", "parquet", "obvhs", "exr", "image"]),
    ("output_schema/src", &["sheetlight", "procedural", "parquet", "exr", "image"]),
    (
        "crates/recipe/src",
        &[
            "crate::optics",
            "crate::frame",
            "crate::specimen",
            "crate::extract",
            "crate::dataset",
            "crate::pipeline",
            "crate::labels",
        ],
    ),
    ("crates/yaml/src", &["crate::recipe", "crate::medium", "crate::transport", "crate::settings", "procedural"]),
    (
        "crates/study/src/medium",
        &["crate::recipe", "crate::optics", "crate::specimen", "crate::dataset", "crate::study"],
    ),
    ("crates/study/src", &["crate::specimen", "crate::extract", "crate::labels", "crate::dataset", "crate::validate"]),
    (
        "crates/transport/src",
        &[
            "crate::recipe",
            "crate::optics",
            "crate::specimen",
            "crate::extract",
            "crate::labels",
            "crate::record",
            "crate::dataset",
            "crate::pipeline",
            "crate::cli",
            "crate::study",
        ],
    ),
    (
        "crates/scanner/src/optics",
        &["crate::recipe", "crate::extract", "crate::labels", "crate::dataset", "crate::record"],
    ),
    ("crates/pipeline/src/labels.rs", &["crate::frame", "crate::extract", "crate::optics"]),
    ("crates/dataset/src", &["crate::recipe", "crate::optics", "crate::specimen", "crate::extract", "crate::pipeline"]),
    ("crates/dataset/src/atomic_file.rs", &["crate::", "procedural", "output_schema"]),
    ("crates/dataset/src/validate", &["crate::optics", "crate::extract", "crate::specimen", "crate::recipe"]),
    ("crates/scanner/src/specimen", &["crate::recipe", "crate::extract", "crate::dataset", "crate::optics"]),
    (
        "crates/recipe/src/mesh",
        &["crate::recipe", "crate::optics", "crate::specimen", "crate::dataset", "crate::settings"],
    ),
    ("crates/scanner/src/specimen.rs", &["crate::recipe", "crate::extract", "crate::dataset", "crate::optics"]),
    (
        "crates/scanner/src/frame.rs",
        &["crate::recipe", "crate::optics", "crate::specimen", "crate::parameters", "crate::settings", "procedural"],
    ),
    (
        "crates/scanner/src/frame",
        &["crate::recipe", "crate::optics", "crate::specimen", "crate::parameters", "crate::settings", "procedural"],
    ),
    (
        "crates/tools/src/icon",
        &[
            "crate::recipe",
            "crate::optics",
            "crate::specimen",
            "crate::extract",
            "crate::record",
            "crate::dataset",
            "crate::compare",
            "procedural",
        ],
    ),
    (
        "crates/tools/src/compare",
        &[
            "crate::recipe",
            "crate::optics",
            "crate::specimen",
            "crate::extract",
            "crate::labels",
            "crate::transport",
            "crate::pipeline",
            "crate::validate",
            "crate::study",
        ],
    ),
    (
        "crates/tools/src/check",
        &[
            "crate::recipe",
            "crate::optics",
            "crate::specimen",
            "crate::extract",
            "crate::labels",
            "crate::transport",
            "crate::pipeline",
            "crate::validate",
        ],
    ),
    (
        "crates/tools/src/export",
        &[
            "crate::recipe",
            "crate::optics",
            "crate::specimen",
            "crate::extract",
            "crate::labels",
            "crate::transport",
            "crate::pipeline",
            "crate::validate",
            "crate::check",
            "crate::preview",
            "crate::cli",
        ],
    ),
    (
        "crates/tools/src/report",
        &[
            "crate::optics",
            "crate::specimen",
            "crate::extract",
            "crate::labels",
            "crate::transport",
            "crate::pipeline",
            "crate::validate",
            "crate::check",
            "crate::preview",
        ],
    ),
    ("crates/pipeline/src/lib.rs", &["crate::dataset", "crate::validate", "crate::cli"]),
    ("crates/pipeline/src", &["crate::dataset", "crate::validate", "crate::cli"]),
    ("crates/pipeline/src/effective.rs", &["crate::specimen", "crate::labels", "crate::dataset"]),
    (
        "crates/dataset/src/record.rs",
        &["crate::recipe", "crate::optics", "crate::extract", "crate::dataset", "crate::specimen"],
    ),
];

/// All that the instrument's own software may know.
const EXTRACT_MAY: [&str; 2] = ["crate::frame", "crate::settings"];

/// The only file that names the ray tracer.
const RAYS: &str = "crates/scanner/src/specimen/rays.rs";

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Every Rust file below a path of the repository, or the file itself, with its text.
fn sources(relative: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut paths = vec![root().join(relative)];
    while let Some(path) = paths.pop() {
        if path.is_dir() {
            let entries = fs::read_dir(&path).expect("the folder can be listed");
            paths.extend(entries.map(|entry| entry.expect("the folder can be listed").path()));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let name = path.strip_prefix(root()).expect("it lies below").to_string_lossy().into_owned();
            found.push((name, fs::read_to_string(&path).expect("it is text")));
        }
    }
    assert!(!found.is_empty(), "no source at {relative}");
    found
}

/// The paths that a source names: of its `use` lines with groups taken apart, and those in the code.
fn paths(text: &str) -> Vec<String> {
    let code: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
    let code = code.join("\n");
    let mut paths = Vec::new();
    for (start, _) in code.match_indices("use ") {
        let before = code[..start].trim_end();
        if !(before.is_empty() || before.ends_with([';', '}', '{', ']', ')']) || before.ends_with("pub")) {
            continue;
        }
        let rest = &code[start + 4..];
        spread("", &rest[..rest.find(';').unwrap_or(rest.len())], &mut paths);
    }
    let word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    paths.extend(code.split(|c| !word(c)).filter(|path| path.contains("::")).map(String::from));
    paths
}

/// `a::{b, c::{d, e}}` as `a::b`, `a::c::d` and `a::c::e`.
fn spread(prefix: &str, tree: &str, paths: &mut Vec<String>) {
    let (mut depth, mut from) = (0, 0);
    let mut parts = Vec::new();
    for (i, c) in tree.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&tree[from..i]);
                from = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&tree[from..]);
    for part in parts.into_iter().map(str::trim).filter(|part| !part.is_empty()) {
        match part.split_once('{') {
            Some((head, tail)) => spread(&format!("{prefix}{head}"), tail.trim_end_matches('}'), paths),
            None => paths.push(format!("{prefix}{part}")),
        }
    }
}

/// Whether `path` lies in what `name` names: a module, a crate, or a family of crates.
fn within(path: &str, name: &str) -> bool {
    let path = path.strip_prefix("::").unwrap_or(path);
    match path.strip_prefix(name) {
        Some(rest) => {
            name.ends_with("::")
                || rest.is_empty()
                || rest.starts_with("::")
                || (name == "arrow" && rest.starts_with('_'))
        }
        None => false,
    }
}

#[test]
fn paths_are_found() {
    let text = "use a::{b, c::{self, d}};\npub(crate) use e::f as g;\nfn h() { i::j(k::l::M); } // use n::o;\nuse p;";
    let found = paths(text);
    for path in ["a::b", "a::c::self", "a::c::d", "i::j", "k::l::M", "p"] {
        assert!(found.iter().any(|p| p == path), "{path} is not in {found:?}");
    }
    assert!(found.iter().any(|p| within(p, "e::f")) && !found.iter().any(|p| p.contains("n::o")), "{found:?}");
    assert!(
        within("arrow_array::Array", "arrow") && !within("images::a", "image") && within("crate::a::B", "crate::a")
    );
}

#[test]
fn nothing_names_what_it_must_not_know() {
    let mut faults = Vec::new();
    for (place, forbidden) in FORBIDDEN {
        for (file, text) in sources(place) {
            let named = paths(&text);
            let bad = forbidden.iter().filter(|name| named.iter().any(|path| within(path, name)));
            faults.extend(bad.map(|name| format!("{file} names {name}")));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn extraction_sees_frames_alone() {
    for (file, text) in sources("crates/scanner/src/extract") {
        let known = paths(&text).into_iter().filter(|path| within(path, "crate") || within(path, "procedural"));
        let beyond: Vec<_> = known.filter(|path| !EXTRACT_MAY.iter().any(|name| within(path, name))).collect();
        assert!(beyond.is_empty(), "{file} names {beyond:?}");
    }
}

#[test]
fn one_file_names_the_ray_tracer() {
    let naming: Vec<String> = sources("src")
        .into_iter()
        .filter(|(_, text)| paths(text).iter().any(|path| within(path, "obvhs")))
        .map(|(file, _)| file)
        .collect();
    assert_eq!(naming, [RAYS]);
}

#[test]
fn two_files_name_onnxruntime() {
    let names = |text: &str| paths(text).iter().any(|path| within(path, "ort"));
    let mut naming: Vec<String> =
        sources("src").into_iter().filter(|(_, text)| names(text)).map(|(file, _)| file).collect();
    naming.sort();
    assert_eq!(naming, ["crates/tools/src/check/model.rs", "crates/tools/src/check/onnxruntime.rs"]);
}
