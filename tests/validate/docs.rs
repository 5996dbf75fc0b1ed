//! Purpose: docs/validate.md lists every code of a fault with its meaning and its remedy, as the program has them.

use dataset::validate::{Code, fault_table};

const PAGE: &str = include_str!("../../docs/validate.md");

#[test]
fn every_code_has_its_row() {
    let section = PAGE.split("\n## ").find(|section| section.starts_with("Faults")).expect("a section of faults");
    let rows: Vec<&str> = section.lines().filter(|line| line.starts_with('|')).collect();
    let table = fault_table();
    let expected: Vec<&str> = table.lines().collect();
    assert_eq!(expected.len(), Code::ALL.len() + 2);
    assert_eq!(rows, expected);
}

#[test]
fn every_code_says_what_it_means_and_what_to_do() {
    for code in Code::ALL {
        assert!(code.meaning().ends_with('.') && code.remedy().len() > 10, "{}", code.name());
    }
}
