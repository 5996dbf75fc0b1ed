//! The scripts under python/ as people run them, in the project's own environment, without a network.

#![allow(dead_code)]

use std::path::Path;
use std::process::Command;

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

/// Runs python with these arguments, the first a script below python/ unless it is an option; `home` is for caches.
pub fn python(home: &Path, arguments: &[&str]) -> Said {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = root.join(".venv/bin/python");
    assert!(
        program.exists(),
        "{} is missing: `make venv` makes it (python3 -m venv .venv; .venv/bin/pip install -r python/requirements.txt)",
        program.display()
    );
    let run = Command::new(&program)
        .args(arguments)
        .current_dir(root.join("python"))
        .env("HF_HUB_OFFLINE", "1")
        .env("HF_HOME", home.join("hf"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
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
