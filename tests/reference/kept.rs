//! What the reference said, kept: its walks take minutes, and their figures change only with the question or with the
//! reference Monte Carlo.
//!
//! `tests/data/reference/<test>.json` holds figures by case. The key of a case follows from all that is asked, so that
//! another question does not get an old answer. `make reference` asks all of them anew, BLESS=new those alone that are
//! not kept. In each run a case of pockets,
//! borders, slopes, random wood and random packs is asked again ([`Kept::still_says`]) and must give the figures that
//! are kept.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::path::PathBuf;

use base::Stream;

/// Relative difference of figures that are the same: sums of other builds may end in other digits.
const SAME: f64 = 1e-6;

/// The reference's figures for one test.
pub struct Kept {
    file: PathBuf,
    bless: bool,
    known: BTreeMap<String, Vec<f64>>,
    told: BTreeMap<String, Vec<f64>>,
}

impl Kept {
    /// For the test of a name.
    pub fn of(test: &str) -> Self {
        let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("tests/data/reference/{test}.json"));
        let asked = std::env::var_os("BLESS");
        let (bless, all_anew) = (asked.is_some(), asked.is_some_and(|what| what != "new"));
        let known = match std::fs::read_to_string(&file) {
            Ok(text) if !all_anew => serde_json::from_str(&text).expect("figures by case"),
            _ => BTreeMap::new(),
        };
        Self { file, bless, known, told: BTreeMap::new() }
    }

    /// Whether nothing was asked yet.
    pub fn is_new(&self) -> bool {
        self.told.is_empty()
    }

    /// Figures of `case`: what `ask` says of the `question`.
    pub fn says(&mut self, case: &str, question: &impl Debug, ask: impl FnOnce() -> Vec<f64>) -> Vec<f64> {
        let key = format!("{case} {:016x}", Stream::root(0).child(&format!("{question:?}")).key());
        let figures = match self.known.get(&key) {
            Some(kept) => kept.clone(),
            None if self.bless => ask(),
            None => panic!("{case}: the reference was not asked this; BLESS=new asks it ({})", self.file.display()),
        };
        self.told.insert(key, figures.clone());
        figures
    }

    /// The same, and asks again: what is kept is what the reference says today.
    pub fn still_says(&mut self, case: &str, question: &impl Debug, ask: impl FnOnce() -> Vec<f64>) -> Vec<f64> {
        let now = ask();
        let kept = self.says(case, question, || now.clone());
        let same = |(now, kept): (&f64, &f64)| (now - kept).abs() <= SAME * kept.abs();
        assert!(
            now.len() == kept.len() && now.iter().zip(&kept).all(same),
            "{case}: the reference says {now:?} today and {kept:?} before; where that is meant, BLESS=1 asks for all \
                cases"
        );
        kept
    }

    /// Ends the test: nothing is kept that was not used.
    pub fn finish(self) {
        if self.bless {
            let line = |(case, figures): (&String, &Vec<f64>)| {
                format!("{}: {}", serde_json::to_string(case).unwrap(), serde_json::to_string(figures).unwrap())
            };
            let lines: Vec<String> = self.told.iter().map(line).collect();
            std::fs::write(&self.file, format!("{{\n{}\n}}\n", lines.join(",\n"))).expect("the file can be written");
            return;
        }
        let unused: Vec<&String> = self.known.keys().filter(|key| !self.told.contains_key(*key)).collect();
        assert!(unused.is_empty(), "nobody asks for {unused:?} of {}; BLESS=1 drops them", self.file.display());
    }
}
