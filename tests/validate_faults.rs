//! The page of faults has every code with its meaning and remedy.

use sheetlight::validate::{Code, fault_table};

#[test]
fn the_page_lists_every_fault() {
    let page = include_str!("../docs/faults.md");
    let table = fault_table();
    assert!(page.ends_with(&table), "docs/faults.md ends with this table:\n{table}");
    assert_eq!(table.lines().count(), Code::ALL.len() + 2);
    for code in Code::ALL {
        assert!(code.meaning().ends_with('.') && code.remedy().len() > 10, "{}", code.name());
    }
}
