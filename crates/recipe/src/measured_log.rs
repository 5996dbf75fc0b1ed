//! The files of a measured log: pith, radii and knots as tables of numbers -> `procedural::wood::Stem`.
//!
//! A table is CSV (numbers separated by commas, `#` begins a line of remarks) or JSON (an array of rows, each an array
//! of numbers), by the ending of its name. The three files of the scanned spruce log of Larsson et al. (2022) are such
//! JSON as they were published; an extract of them is built in. What the numbers must be is `Stem::measured`'s to say.

use procedural::wood::{Stem, StemError};

use crate::asset::{Asset, AssetFault};
use crate::built_in::GRAN_1;

/// Keys of the three files.
pub(crate) const KEYS: [&str; 3] = ["log.pith_file", "log.radii_file", "log.knots_file"];
/// What the tables are called in faults of a stem.
const TABLES: [&str; 3] = ["pith", "radii", "knots"];

/// The log of the files of pith, radii and knots.
///
/// # Errors
/// The key whose file is at fault, what is wrong there, and what to do.
pub(crate) fn read_log(files: [&Asset; 3]) -> Result<Stem, (&'static str, AssetFault)> {
    let is_gran_1: Vec<bool> = files.iter().zip(GRAN_1).map(|(file, [(_, bytes)])| file.bytes() == bytes).collect();
    if let Some(other) = is_gran_1.iter().position(|own| *own != is_gran_1[0]) {
        let built_in = if is_gran_1[0] { 0 } else { other };
        let problem = format!("`{}` is of the built-in log, and not all three files are", files[built_in].name());
        return Err((
            KEYS[built_in],
            AssetFault::new(problem, format!("name the files of one log: {}", KEYS.join(", "))),
        ));
    }
    let [pith, radii, knots] = [0, 1, 2].map(|n| table(files[n]).map_err(|fault| (KEYS[n], fault)));
    let pith = rows(&pith?, files[0], "x, y and height").map_err(|fault| (KEYS[0], fault))?;
    let knots = rows(&knots?, files[2], "A to I").map_err(|fault| (KEYS[2], fault))?;
    Stem::measured(&pith, &radii?, &knots).map_err(|error| told(&error, files))
}

/// A fault of the numbers, at the file that has them.
fn told(error: &StemError, files: [&Asset; 3]) -> (&'static str, AssetFault) {
    let text = error.to_string();
    let number = TABLES.iter().position(|table| text.starts_with(table)).unwrap_or_default();
    (KEYS[number], AssetFault::told(files[number].name(), error, "measure it again"))
}

/// Rows of `N` numbers, which are called `what`.
fn rows<const N: usize>(table: &[Vec<f64>], file: &Asset, what: &str) -> Result<Vec<[f64; N]>, AssetFault> {
    let row = |(index, row): (usize, &Vec<f64>)| {
        <[f64; N]>::try_from(row.as_slice()).map_err(|_| {
            let problem = format!("`{}`: row {} has {} numbers, not {N}", file.name(), index + 1, row.len());
            AssetFault::new(problem, format!("give {what} in every row"))
        })
    };
    table.iter().enumerate().map(row).collect()
}

/// The numbers of a file, row by row.
fn table(file: &Asset) -> Result<Vec<Vec<f64>>, AssetFault> {
    let name = file.name();
    let ending = name.rsplit_once('.').map(|(_, ending)| ending.to_ascii_lowercase()).unwrap_or_default();
    match ending.as_str() {
        "csv" => csv(file),
        "json" => serde_json::from_slice(file.bytes()).map_err(|error| {
            let problem = format!("`{name}` is no array of rows of numbers: {error}");
            AssetFault::new(problem, "give [[number, ...], ...], one inner array for each row")
        }),
        _ => {
            let problem = format!("`{name}` has the ending of no table that is read");
            Err(AssetFault::new(problem, "give a file that ends in .csv, .json"))
        }
    }
}

fn csv(file: &Asset) -> Result<Vec<Vec<f64>>, AssetFault> {
    let name = file.name();
    let text = std::str::from_utf8(file.bytes())
        .map_err(|_| AssetFault::new(format!("`{name}` is no text of UTF-8"), "save it as CSV anew"))?;
    // Spreadsheets begin their tables with a byte order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut table = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let row: Result<Vec<f64>, AssetFault> = line
            .split(',')
            .map(|cell| {
                cell.trim().parse().map_err(|_| {
                    let shown: String = cell.trim().chars().filter(|c| !c.is_control()).take(40).collect();
                    let problem = format!("`{name}`, line {}: `{shown}` is no number", index + 1);
                    AssetFault::new(problem, "give numbers with decimal points, separated by commas; # begins a remark")
                })
            })
            .collect();
        table.push(row?);
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AssetSource, Recipe};

    fn built_in() -> [Asset; 3] {
        GRAN_1.map(|[(name, bytes)]| Asset::new(name, bytes.to_vec()))
    }

    fn read(files: &[Asset; 3]) -> Result<Stem, (&'static str, AssetFault)> {
        read_log([&files[0], &files[1], &files[2]])
    }

    /// The same tables as JSON.
    fn as_json(file: &Asset, n: usize) -> Asset {
        let rows = table(file).expect("a table");
        Asset::new(&format!("own_{}.json", TABLES[n]), serde_json::to_vec(&rows).expect("JSON"))
    }

    #[test]
    fn a_byte_order_mark_is_no_number() {
        let [(name, bytes)] = GRAN_1[0];
        let marked = Asset::new("pith.csv", ["\u{feff}".as_bytes(), bytes].concat());
        assert_eq!(table(&marked).expect("a table"), table(&Asset::new(name, bytes.to_vec())).expect("a table"));
    }

    #[test]
    fn csv_and_json_are_the_same_log() {
        let files = built_in();
        let json = [0, 1, 2].map(|n| as_json(&files[n], n));
        let (a, b) = (read(&files).expect("a log"), read(&json).expect("a log"));
        assert!(a == b && a.branches().len() == 108 && a.ends_mm() == [0.0, 3990.0]);
        let mixed = [json[0].clone(), files[1].clone(), files[2].clone()];
        let (key, fault) = read(&mixed).expect_err("two logs");
        assert!(key == KEYS[1] && fault.problem.contains("gran_1_radii.csv") && fault.remedy.contains(KEYS[0]));
    }

    /// Each cell in turn is spoilt in each file: the fault names the file's key, its row, and what to do.
    #[test]
    fn every_damage_is_told_with_its_place() {
        let files = built_in();
        let own = [0, 1, 2].map(|n| {
            let text = std::str::from_utf8(files[n].bytes()).expect("text");
            text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect::<Vec<_>>()
        });
        for (turn, (spoilt, wanted)) in [
            ("x", "is no number"),
            ("NaN", "is not a finite number"),
            ("1e9", "outside"),
            ("", "is no number"),
            ("1,1", "numbers"),
        ]
        .into_iter()
        .cycle()
        .take(60)
        .enumerate()
        {
            let n = turn % 3;
            let row = 1 + (turn * 37) % (own[n].len() - 1);
            // The first number: x of the pith and a radius have other ranges than A.
            let mut tables = own.clone();
            let (_, rest) = tables[n][row].split_once(',').expect("more than one number");
            tables[n][row] = format!("{spoilt},{rest}");
            let assets =
                [0, 1, 2].map(|n| Asset::new(&format!("{}.csv", TABLES[n]), tables[n].join("\n").into_bytes()));
            // Nothing bounds where the pith lies across the stem.
            if n == 0 && spoilt == "1e9" {
                continue;
            }
            let wanted = if n == 1 && spoilt == "1,1" { "radii where" } else { wanted };
            let (key, fault) = read(&assets).expect_err(spoilt);
            assert_eq!(key, KEYS[n], "{fault:?}");
            assert!(fault.problem.contains(wanted) && fault.problem.contains(&(row + 1).to_string()), "{fault:?}");
            assert!(fault.problem.contains(assets[n].name()) && !fault.remedy.is_empty(), "{fault:?}");
        }
        let other = [files[0].clone(), files[1].clone(), Asset::new("knots.txt", files[2].bytes().to_vec())];
        assert!(read(&other).is_err());
        let broken = [0, 1, 2].map(|n| Asset::new(&format!("{}.json", TABLES[n]), b"{}".to_vec()));
        assert!(read(&broken).expect_err("no rows").1.problem.contains("no array"));
    }

    /// A recipe says where the files are; each sample has the log, and recipes without it name no file of one.
    #[test]
    fn a_recipe_loads_the_log_that_it_names() {
        let text = |log: &str| {
            format!("name: a\nsubject: wood\nunstated: fixed\nlog: {{{log}}}\nclasses: {{a: {{share: 1}}}}\n")
        };
        let recipe = Recipe::parse("a", &text("source: measured")).expect("a recipe");
        assert_eq!(recipe.files().map(|(key, _)| key).collect::<Vec<_>>(), KEYS);
        let stem = recipe.draw(0, 3).measured.expect("a log");
        assert!(*stem == read(&built_in()).expect("a log"));
        let grown = Recipe::parse("a", &text("source: stem")).expect("a recipe");
        assert!(grown.draw(0, 3).measured.is_none() && grown.files().next().is_none());
        let refused = Recipe::parse("a", &text("source: stem, pith_file: logs/gran_1_pith.csv")).expect_err("idle");
        assert!(refused.to_string().contains("log.pith_file"), "{refused}");
        let folder = tempfile::tempdir().expect("a folder");
        for (n, file) in built_in().iter().enumerate() {
            let json = as_json(file, n);
            std::fs::write(folder.path().join(json.name()), json.bytes()).expect("written");
        }
        let own = "source: measured, pith_file: own_pith.json, radii_file: own_radii.json, knots_file: own_knots.json";
        let beside = AssetSource::Beside(folder.path().to_owned());
        let other = Recipe::parse_with("a", &text(own), &beside).expect("a recipe");
        assert!(other.draw(0, 3).measured.as_deref() == Some(&*stem) && other.hash() != recipe.hash());
        std::fs::write(folder.path().join("own_radii.json"), "[[1, 2]]").expect("written");
        let refused = Recipe::parse_with("a", &text(own), &beside).expect_err("no log").to_string();
        assert!(refused.contains("log.radii_file") && refused.contains("own_radii.json"), "{refused}");
    }
}
