//! docs/guide/symptoms.md: each symptom of its first table is made, told by the command that the page names, and cured.

use std::fs;
use std::path::Path;

use serde_json::Value;
use test_support::program::Place;

/// What tells a symptom.
enum Tell<'a> {
    /// A number of `gen rig` or of `gen compare`, which is above a bound, or below it.
    Number { path: &'a str, is_above: bool, bound: f64 },
    /// Words of a warning of `gen rig`.
    Warning(&'a str),
}

/// The texts between backticks of a cell.
fn quoted(cell: &str) -> Vec<&str> {
    cell.split('`').skip(1).step_by(2).collect()
}

impl<'a> Tell<'a> {
    /// The command and what it tells.
    fn of(cell: &'a str) -> (&'a str, Self) {
        let [command, path] = quoted(cell)[..] else { panic!("{cell}") };
        let rest = cell.rsplit('`').next().unwrap_or_default().trim();
        let tell = match rest.split_once(' ') {
            Some((side, bound)) => {
                assert!(["above", "below"].contains(&side), "{cell}");
                Self::Number { path, is_above: side == "above", bound: bound.parse().expect("a number") }
            }
            None => Self::Warning(path),
        };
        (command, tell)
    }

    /// Whether a document tells it.
    fn is_told(&self, document: &Value) -> bool {
        match self {
            Self::Number { path, is_above, bound } => {
                let step =
                    |value: &Value, key: &str| key.parse().map_or(value[key].clone(), |i: usize| value[i].clone());
                let found = path.split('.').fold(document.clone(), |value, key| step(&value, key));
                let number = found.as_f64().unwrap_or_else(|| panic!("no number {path}: {found}"));
                println!("{path}: {number}");
                if *is_above { number > *bound } else { number < *bound }
            }
            Self::Warning(words) => document["warnings"].to_string().contains(words),
        }
    }
}

/// What a command says of wood-small with changes.
fn said(place: &Place, command: &str, changes: &[&str]) -> Value {
    let set: String = changes.iter().flat_map(|text| text.split(' ')).map(|set| format!(" --set {set}")).collect();
    let json = |text: &str| serde_json::from_str::<Value>(text).expect("it prints JSON");
    if command == "gen rig" {
        let mut found = json(&place.done(&format!("rig wood-small --json{set}")).out);
        let warnings = found["warnings"].clone();
        found["numbers"]["warnings"] = warnings;
        return found["numbers"].clone();
    }
    assert_eq!(command, "gen compare");
    let _ = fs::remove_dir_all(place.path("set"));
    place.done(&format!("wood-small --n 2 --out set --quiet --set output.truth_maps=false{set}"));
    json(&place.done("compare set set --json").out)["sim"].clone()
}

#[test]
#[ignore = "long"]
fn each_symptom_is_made_told_and_cured() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/symptoms.md");
    let text = fs::read_to_string(page).expect("the page is there");
    let table = text.split("| made by |").nth(1).expect("a table").split("\n\n").next().expect("its rows");
    let place = Place::new();
    let healthy = ["gen rig", "gen compare"].map(|command| (command, said(&place, command, &[])));
    let mut rows = 0;
    for row in table.lines().skip(2) {
        let cells: Vec<&str> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        let [seen, made, tells, cured, keys] = cells[..] else { panic!("{row}") };
        println!("{seen}");
        let (command, tell) = Tell::of(tells);
        let well = &healthy.iter().find(|(known, _)| *known == command).expect("a command").1;
        assert!(!tell.is_told(well), "{seen}: told of what is well");
        let (made, cured) = (quoted(made)[0], quoted(cured)[0]);
        assert!(tell.is_told(&said(&place, command, &[made])), "{seen}: {made} is not told");
        assert!(!tell.is_told(&said(&place, command, &[made, cured])), "{seen}: {cured} does not cure it");
        assert!(!keys.is_empty());
        rows += 1;
    }
    assert!(rows >= 15, "{rows} rows");
}
