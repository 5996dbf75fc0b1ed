//! Purpose: what is written beside the code for other programs says what the code says: versions, toolchain, links.

use std::fs;
use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

fn text(path: impl AsRef<Path>) -> String {
    let path = Path::new(ROOT).join(path);
    fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// What stands between `before` and `after` in a file, each time, and never nothing.
fn stated(path: &str, before: &str, after: &str) -> Vec<String> {
    let text = text(path);
    let found: Vec<String> =
        text.split(before).skip(1).map(|rest| rest.split(after).next().unwrap_or_default().to_owned()).collect();
    assert!(!found.is_empty(), "{path} states nothing after `{before}`");
    found
}

#[test]
fn versions_are_that_of_the_crate() {
    let cluster = "python/examples/cluster";
    for (path, before, after) in [
        ("CITATION.cff", "\nversion: ", "\n"),
        (&format!("{cluster}/kubernetes.yaml"), "/sheetlight-scale:", "\n"),
        (&format!("{cluster}/kubernetes-finish.yaml"), "/sheetlight-scale:", "\n"),
        (".github/ISSUE_TEMPLATE/bug.yml", "placeholder: gen ", ","),
    ] {
        for version in stated(path, before, after) {
            assert_eq!(version, env!("CARGO_PKG_VERSION"), "{path}, after `{before}`");
        }
    }
}

#[test]
fn toolchains_are_the_one_that_cargo_names() {
    let workflow = |name: &str| format!(".github/workflows/{name}.yml");
    for (path, before, after) in [
        ("Dockerfile", "ARG RUST=", "\n"),
        (&workflow("ci"), "image: rust:", "-"),
        (&workflow("wheels"), "rust-toolchain: \"", "\""),
        (&workflow("wheels"), "rustup toolchain install ", " "),
        (&workflow("wheels"), "rustup default ", "\n"),
        (&workflow("release"), "rustup toolchain install ", " "),
        (&workflow("release"), "rustup default ", "\n"),
    ] {
        for version in stated(path, before, after) {
            assert_eq!(version, env!("CARGO_PKG_RUST_VERSION"), "{path}, after `{before}`");
        }
    }
}

/// A README that is read to its end.
#[test]
fn the_readme_is_short() {
    let bytes = text("README.md").len();
    assert!(bytes <= 9000, "README.md has {bytes} bytes: move something to docs/");
}

/// Links between documents lead to files.
#[test]
fn links_lead_somewhere() {
    let mut pages: Vec<PathBuf> =
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "recipes/README.md"]
            .map(PathBuf::from)
            .to_vec();
    for entry in fs::read_dir(Path::new(ROOT).join("docs")).expect("docs/").flatten() {
        let name = entry.file_name();
        if name.to_string_lossy().ends_with(".md") {
            pages.push(Path::new("docs").join(name));
        }
    }
    let mut links = 0;
    for page in pages {
        let content = text(&page);
        for rest in content.split("](").skip(1) {
            let target = rest.split([')', '#']).next().unwrap_or_default();
            if target.is_empty() || target.contains("://") {
                continue;
            }
            let place = Path::new(ROOT).join(page.parent().unwrap_or(Path::new(""))).join(target);
            assert!(place.exists(), "{}: nothing lies at {target}", page.display());
            links += 1;
        }
    }
    assert!(links > 100, "only {links} links were found");
}
