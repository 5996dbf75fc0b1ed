//! The scripts under python/ as people run them, in the project's own environment, without a network.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use parquet::record::Field;
use serde_json::Value;

use test_support::program::{Place, Sample, pack_recipe, recipe};

/// What a script said.
pub struct Said {
    /// Exit status.
    pub code: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Said {
    /// What stands in the one line that starts so, behind that start.
    pub fn line(&self, start: &str) -> &str {
        let mut found = self.out.lines().filter_map(|line| line.strip_prefix(start));
        match (found.next(), found.next()) {
            (Some(rest), None) => rest,
            _ => panic!("not one line starts with `{start}` in\n{}", self.out),
        }
    }

    /// The numbers of that line, in order; anything between them is passed over.
    pub fn numbers(&self, start: &str) -> Vec<f64> {
        numbers(self.line(start))
    }
}

/// Every number of a text, signs and points included.
pub fn numbers(text: &str) -> Vec<f64> {
    let parts = text.split(|c: char| !(c.is_ascii_digit() || "-.".contains(c)));
    parts.filter_map(|part| part.trim_end_matches('.').parse().ok()).collect()
}

/// Python of the environment that `make venv` makes. What it compiles lies below target/, not beside the sources.
pub fn interpreter() -> Command {
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join(".venv/bin/python");
    assert!(
        program.exists(),
        "{} is missing: `make venv` makes it (python3 -m venv .venv; .venv/bin/pip install -r python/requirements.txt)",
        program.display()
    );
    let mut command = Command::new(program);
    // Where it may not be kept, each start of torch costs six seconds more.
    command.env("PYTHONPYCACHEPREFIX", concat!(env!("CARGO_TARGET_TMPDIR"), "/pycache"));
    command.env_remove("PYTHONDONTWRITEBYTECODE");
    command
}

/// Runs python with these arguments, the first a script below python/ unless it is an option; `home` is for caches.
pub fn python(home: &Path, arguments: &[&str]) -> Said {
    let run = once(home, arguments);
    // The interpreter's end may race with threads of the C++ libraries that it loaded: the work is done by then.
    let run = if run.code < 0 && run.err.trim_end().ends_with(RACE) { once(home, arguments) } else { run };
    assert!(!run.err.trim_end().ends_with(RACE), "twice: {}", run.err);
    run
}

/// What the C++ runtime says where a thread outlives the interpreter.
const RACE: &str = "terminate called without an active exception";

fn once(home: &Path, arguments: &[&str]) -> Said {
    let run = interpreter()
        .args(arguments)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/python"))
        .env("HF_HUB_OFFLINE", "1")
        .env("HF_HOME", home.join("hf"))
        .output()
        .expect("python starts");
    let text = |bytes| String::from_utf8(bytes).expect("python writes UTF-8");
    Said { code: run.status.code().unwrap_or(-1), out: text(run.stdout), err: text(run.stderr) }
}

/// Runs an example on a dataset; it does what it is asked.
pub fn example(home: &Path, name: &str, dataset: &Path, more: &[&str]) -> Said {
    let (script, dataset) = (format!("examples/{name}.py"), dataset.to_string_lossy().into_owned());
    let arguments: Vec<&str> = [script.as_str(), &dataset].into_iter().chain(more.iter().copied()).collect();
    let said = python(home, &arguments);
    assert_eq!(said.code, 0, "{name}:\n{}{}\nif a package is missing: make venv", said.out, said.err);
    said
}

/// Every image in the tables.
pub const IMAGES: [&str; 2] =
    ["png: [range, reflectance, scatter, label]", "png: [range, reflectance, scatter, label, instance]"];

/// Fourteen boards and ten packs in shards of six, and their samples.
pub fn datasets() -> [(Place, BTreeMap<i64, Sample>); 2] {
    // Large enough for knots of each kind.
    let boards = recipe(&[IMAGES])
        .replace("\n  columns: 64 ", "\n  columns: 192 ")
        .replace("\n  profiles: 48 ", "\n  profiles: 160 ");
    let packs = pack_recipe(&[["sensor_stack: none", "sensor_stack: {every: 48}"]]);
    [(boards, 14), (packs, 10)].map(|(text, n)| {
        let place = Place::new();
        place.write("tiny.yaml", text);
        place.make("set", &format!("--n {n} --samples-per-shard 6"));
        let samples = place.samples("set");
        (place, samples)
    })
}

/// A number of whatever type.
pub fn number(field: &Field) -> f64 {
    match field {
        Field::Double(value) => *value,
        Field::Long(value) => *value as f64,
        Field::Int(value) => f64::from(*value),
        other => panic!("{other:?} is no number"),
    }
}

/// Names of `classes` or `pixel_classes` in `dataset.json`.
pub fn names(head: &Value, list: &str) -> Vec<String> {
    let names = head[list].as_array().expect("a list").iter();
    names.map(|name| name.as_str().expect("a name").to_string()).collect()
}

/// The first sample of the first file of the split that comes first in `order`.
pub fn first<'a>(samples: &'a BTreeMap<i64, Sample>, order: &[&str]) -> (i64, &'a Sample) {
    let of = |split: &&str| samples.iter().find(|(_, sample)| sample.text("split") == *split);
    order.iter().find_map(of).map(|(index, sample)| (*index, sample)).expect("a sample")
}

/// Exact for images.
pub fn sum(numbers: &[u16]) -> f64 {
    numbers.iter().map(|&n| f64::from(n)).sum()
}
