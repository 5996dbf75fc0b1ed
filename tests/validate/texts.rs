//! Purpose: no text of a fault changes by accident. `tests/data/fault_texts.txt` holds every code of a finding with its
//! sentence and remedy, then every sentence that the sources of the dataset crate can put into a fault, sorted, so that
//! moved code leaves it as it is. `BLESS=1` renews it.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use dataset::validate::Code;

/// Sources that write documents, whose sentences are no faults.
const DOCUMENTS: [&str; 3] = ["card.rs", "croissant.rs", "limits.rs"];

#[test]
fn texts_of_faults_are_those_on_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut text = String::from("# Codes\n\n");
    let mut of_codes = BTreeSet::new();
    for code in Code::ALL {
        text += &format!("{}\n    {}\n    {}\n", code.name(), code.meaning(), code.remedy());
        of_codes.extend([code.meaning(), code.remedy()]);
    }
    let mut sentences = BTreeSet::new();
    let mut folders = vec![root.join("crates/dataset/src")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("a folder").flatten() {
            let (path, name) = (entry.path(), entry.file_name());
            if path.is_dir() {
                folders.push(path);
            } else if !DOCUMENTS.iter().any(|document| *document == name) {
                sentences.extend(literals(&fs::read_to_string(path).expect("a source")));
            }
        }
    }
    sentences.retain(|sentence| sentence.contains(' ') && !of_codes.contains(sentence.as_str()));
    text += "\n# Sentences\n\n";
    sentences.iter().for_each(|sentence| text += &format!("{sentence}\n"));
    let file = root.join("tests/data/fault_texts.txt");
    if std::env::var_os("BLESS").is_some() {
        fs::write(&file, &text).expect("written");
    }
    let kept = fs::read_to_string(&file).expect("it is there");
    let [now, before]: [BTreeSet<&str>; 2] = [&text, &kept].map(|text| text.lines().collect());
    let (new, gone): (Vec<_>, Vec<_>) = (now.difference(&before).collect(), before.difference(&now).collect());
    assert!(kept == text, "new texts {new:#?}, texts that are gone {gone:#?}; where that is meant: BLESS=1");
}

/// The string literals of a source as they are written, tests apart; lines that are continued are one.
fn literals(source: &str) -> Vec<String> {
    let source = source.split("\n#[cfg(test)]\nmod ").next().unwrap_or_default();
    let mut found = Vec::new();
    let mut rest = source;
    while let Some(at) = rest.find(['"', '\'', '/']) {
        let (before, from) = rest.split_at(at);
        let skipped = if from.starts_with("//") {
            from.find('\n').unwrap_or(from.len())
        } else if from.starts_with('"') {
            let hashes = before.len() - before.trim_end_matches('#').len();
            let is_raw = before.trim_end_matches('#').ends_with('r');
            let end = format!("\"{}", &"#".repeat(if is_raw { hashes } else { 0 }));
            let mut length = 1;
            while !from[length..].starts_with(&end) {
                let escape = usize::from(!is_raw && from[length..].starts_with('\\'));
                length += from[length..].chars().take(1 + escape).map(char::len_utf8).sum::<usize>();
            }
            let mut lines = from[1..length].split("\\\n");
            let first = lines.next().unwrap_or_default().to_owned();
            found.push(lines.fold(first, |text, line| text + line.trim_start()));
            length + end.len()
        } else if from.starts_with("'\\") {
            // A character in one escape, such as '\'' or '\n'.
            3 + from[3..].find('\'').map_or(0, |end| end + 1)
        } else if from.starts_with('\'') && from[1..].chars().nth(1) == Some('\'') {
            from.char_indices().nth(3).map_or(from.len(), |(end, _)| end)
        } else {
            1
        };
        rest = &from[skipped..];
    }
    found
}

#[test]
fn literals_are_found() {
    let source = "let a = \"one two\"; // \"no\"\nlet b = r#\"three \"four\"\"#; 'a: loop { '\"'; '\\''; \
        b\"\\\"five\"; \"si\\\n   x\" }";
    assert_eq!(literals(source), ["one two", "three \"four\"", "\\\"five", "six"]);
}
