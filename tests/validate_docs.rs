//! Purpose: docs/validate.md lists every code of a fault with its remedy, and nothing else.

use sheetlight::validate::Code;

const PAGE: &str = include_str!("../docs/validate.md");
const SOURCE: &str = include_str!("../src/validate/report.rs");

/// Names of the codes in the source, as reports have them.
fn names() -> Vec<String> {
    let body = SOURCE.split("pub enum Code {").nth(1).and_then(|rest| rest.split("\n}").next()).expect("the codes");
    let variants = body.lines().map(str::trim).filter(|line| !line.starts_with("//") && line.ends_with(','));
    let kebab = |variant: &str| {
        let mut name = String::new();
        for c in variant.trim_end_matches(',').chars() {
            if c.is_uppercase() && !name.is_empty() {
                name.push('-');
            }
            name.push(c.to_ascii_lowercase());
        }
        name
    };
    variants.map(kebab).collect()
}

#[test]
fn every_code_has_its_row() {
    let section = PAGE.split("\n## ").find(|section| section.starts_with("Faults")).expect("a section of faults");
    let rows: Vec<Vec<&str>> = section
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| line.trim_matches('|').split(" | ").map(|cell| cell.trim().trim_matches('`')).collect())
        .collect();
    let names = names();
    assert!(names.len() > 40, "{names:?}");
    let listed: Vec<&str> = rows.iter().map(|row| row[0]).collect();
    assert_eq!(listed, names, "in the order of the source");
    for row in rows {
        let code: Code = serde_json::from_value(row[0].into()).expect("a code's name");
        assert_eq!(code.name(), row[0]);
        assert_eq!(row.len(), 4, "{row:?}");
        assert_eq!(row[3], code.remedy(), "{}", row[0]);
        assert!(!row[1].is_empty() && row[2].len() > 15, "{row:?}");
    }
}
