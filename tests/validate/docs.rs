//! Purpose: docs/guide/faults.md lists every code of a fault with its meaning and its remedy, as the program has
//! them.

use dataset::shares::Shortfall;
use dataset::validate::{Code, fault_table};

const PAGE: &str = include_str!("../../docs/guide/faults.md");

#[test]
fn every_code_has_its_row() {
    let section = PAGE.split("\n## ").find(|section| section.starts_with("Faults")).expect("a section of faults");
    let rows: Vec<&str> = section.lines().filter(|line| line.starts_with('|')).collect();
    let table = fault_table();
    let expected: Vec<&str> = table.lines().collect();
    assert_eq!(expected.len(), Code::ALL.len() + 2);
    assert_eq!(rows, expected);
}

/// What samples fall short in has one code, in rows' findings, in dataset.json and in pages.
#[test]
fn shortfalls_have_the_codes_of_findings() {
    for shortfall in Shortfall::ALL {
        let code = Code::from(shortfall);
        assert_eq!((code.name().as_str(), code.remedy()), (shortfall.code(), shortfall.remedy()));
        assert!(code.meaning().starts_with("Warning: "), "{}", code.meaning());
    }
}

#[test]
fn every_code_says_what_it_means_and_what_to_do() {
    for code in Code::ALL {
        assert!(code.meaning().ends_with('.') && code.remedy().len() > 10, "{}", code.name());
    }
}
