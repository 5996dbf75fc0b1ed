//! Purpose: docs/guide/faults.md lists every code of a fault with its meaning and its remedy, as the program has them.
//! `BLESS=1` writes the table again.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use dataset::shares::Shortfall;
use dataset::validate::{Code, fault_table};

#[test]
fn every_code_has_its_row() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/faults.md");
    let (text, table) = (fs::read_to_string(&page).expect("a page"), fault_table());
    assert_eq!(table.lines().count(), Code::ALL.len() + 2);
    let start = text.find("| code | what is wrong |").expect("a table of faults");
    let end = text[start..].find("\n\n").map_or(text.len(), |length| start + length + 1);
    if std::env::var_os("BLESS").is_some() {
        fs::write(&page, [&text[..start], &table, &text[end..]].concat()).expect("written");
    } else {
        assert!(text[start..end] == table, "the table of {} is stale: BLESS=1 writes it", page.display());
    }
}

/// What samples fall short in has one code, in rows' findings, in dataset.json and in pages.
#[test]
fn shortfalls_have_the_codes_of_findings() {
    for shortfall in Shortfall::ALL {
        let code = Code::from(shortfall);
        assert_eq!((code.name().as_str(), code.remedy()), (shortfall.name(), shortfall.remedy()));
        assert!(code.meaning().starts_with("Warning: "), "{}", code.meaning());
    }
}

/// Whoever adds a code adds a dataset that has its fault.
#[test]
fn every_code_is_told_of_some_damage() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/validate");
    let mut damages = String::new();
    for entry in ["", "sabotage"].iter().flat_map(|part| fs::read_dir(folder.join(part)).expect("a folder")).flatten() {
        // Helpers damage nothing.
        if entry.path().is_file() && !["docs.rs", "place.rs"].iter().any(|helper| *helper == entry.file_name()) {
            damages += &fs::read_to_string(entry.path()).expect("a source");
        }
    }
    let told: BTreeSet<&str> = damages.split(|c: char| !c.is_alphanumeric()).collect();
    let silent: Vec<_> = Code::ALL.iter().filter(|code| !told.contains(format!("{code:?}").as_str())).collect();
    assert!(silent.is_empty(), "no damage in tests/validate/sabotage proves {silent:?}");
}

#[test]
fn every_code_says_what_it_means_and_what_to_do() {
    for code in Code::ALL {
        assert!(code.meaning().ends_with('.') && code.remedy().len() > 10, "{}", code.name());
    }
}
