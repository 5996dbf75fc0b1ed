//! Purpose: what is written beside the code for other programs says what the code says: versions, toolchain, links.

use std::collections::BTreeSet;
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
        ("Dockerfile", "FROM rust:", "-"),
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

/// A package of a lock: what it is called, its version, where it comes from, and what it asks for.
struct Locked {
    name: String,
    version: String,
    is_ours: bool,
    asks: BTreeSet<String>,
}

fn locked(path: &str) -> Vec<Locked> {
    let package = |block: &str| {
        let value = |key: &str| block.lines().find_map(|line| line.strip_prefix(key)?.strip_suffix('"'));
        let asks = block.lines().filter_map(|line| line.strip_prefix(" \"")?.split(['"', ' ']).next());
        Locked {
            name: value("name = \"").expect("a name").into(),
            version: value("version = \"").expect("a version").into(),
            is_ours: value("source = \"").is_none(),
            asks: asks.map(String::from).collect(),
        }
    };
    text(path).split("[[package]]\n").skip(1).map(package).collect()
}

/// What the manifest of a crate asks for beside its tests.
fn asked(manifest: &str) -> BTreeSet<String> {
    let sections = manifest.split("\n[").filter(|section| {
        let header = section.split(']').next().unwrap_or_default();
        header.rsplit('.').next().is_some_and(|last| last == "dependencies" || last == "build-dependencies")
    });
    let lines = sections.flat_map(|section| section.lines().skip(1));
    lines
        .filter_map(|line| Some(line.split_once(['.', ' '])?.0))
        .filter(|name| *name != "#")
        .map(String::from)
        .collect()
}

/// The fuzzer's workspace is one of its own. Its lock has our versions, and of our crates what their manifests ask for.
#[test]
fn the_fuzzers_lock_follows_ours() {
    let (ours, fuzzers) = (locked("Cargo.lock"), locked("fuzz/Cargo.lock"));
    let is_fuzzers = |package: &&Locked| ["sheetlight-fuzz", "libfuzzer-sys", "arbitrary"].contains(&&*package.name);
    for package in fuzzers.iter().filter(|package| !is_fuzzers(package)) {
        let Locked { name, version, is_ours, asks } = package;
        let has = ours.iter().any(|own| own.name == *name && own.version == *version);
        assert!(has, "Cargo.lock has no {name} {version}: run `cargo update {name} --precise ..` in fuzz");
        if *is_ours {
            let folder = [format!("crates/{name}"), name.clone()];
            let folder = folder.iter().find(|folder| Path::new(ROOT).join(folder).exists()).expect("a crate");
            let remedy = "run `cargo update --workspace` in fuzz";
            assert_eq!(*asks, asked(&text(format!("{folder}/Cargo.toml"))), "what {name} asks for: {remedy}");
        }
    }
}

/// Guards all that others could change under us: each action and each image is named by the digest of its content, with
/// the version beside it for people, and a file renews them.
#[test]
fn actions_and_images_are_named_by_digest() {
    let is_digest = |text: &str, digits: usize| text.len() == digits && text.bytes().all(|b| b.is_ascii_hexdigit());
    let mut stages = Vec::new();
    let (mut actions, mut images) = (0, 0);
    let workflows = fs::read_dir(Path::new(ROOT).join(".github/workflows")).expect("workflows").flatten();
    let mut files: Vec<PathBuf> = workflows.map(|entry| entry.path()).collect();
    files.push("Dockerfile".into());
    for file in files {
        let content = text(&file);
        for line in content.lines().map(str::trim) {
            let line = line.strip_prefix("- ").unwrap_or(line);
            if let Some(action) = line.strip_prefix("uses: ").filter(|action| !action.starts_with("./")) {
                let (digest, version) =
                    action.split_once('@').and_then(|(_, rest)| rest.split_once(" # v")).unwrap_or_default();
                let good = is_digest(digest, 40) && version.starts_with(|c: char| c.is_ascii_digit());
                assert!(good, "{}: `{line}` wants the digest of a commit and `# vX.Y.Z`", file.display());
                actions += 1;
            }
            let image = line.strip_prefix("FROM ").or_else(|| line.strip_prefix("image: "));
            if let Some(image) = image {
                let (image, stage) = image.split_once(" AS ").unwrap_or((image, ""));
                if !stages.contains(&image.to_owned()) {
                    let digest = image.split_once("@sha256:").map_or("", |(_, digest)| digest);
                    assert!(is_digest(digest, 64), "{}: `{line}` wants `@sha256:` and a digest", file.display());
                    images += 1;
                }
                stages.push(stage.to_owned());
            }
            assert!(!line.starts_with("# syntax="), "{}: `{line}` names an image by its tag", file.display());
        }
    }
    assert!(actions >= 18 && images >= 4, "only {actions} actions and {images} images were found");
    let renewal: serde_json::Value = serde_json::from_str(&text(".github/renovate.json")).expect("it is JSON");
    for preset in ["helpers:pinGitHubActionDigestsToSemver", "docker:pinDigests"] {
        assert!(renewal["extends"].as_array().is_some_and(|all| all.contains(&preset.into())), "nothing has {preset}");
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
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md"].map(PathBuf::from).to_vec();
    let mut folders = ["docs", "recipes"].map(|folder| Path::new(ROOT).join(folder)).to_vec();
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).expect("a folder of pages").flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                pages.push(path);
            }
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
