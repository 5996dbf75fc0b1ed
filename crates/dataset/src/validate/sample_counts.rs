//! Sample counts: what rows say, counted, from which the statistics of a dataset follow: their size does not grow with its samples.

use numerics::chance::{DrawLaw, UnitHistogram};

/// How the rows of a dataset are drawn, as its recipe declares it.
pub struct DeclaredLaws {
    /// Names and shares of the classes, in the order of `classes` of `dataset.json`; the shares sum to 1.
    pub classes: Vec<(String, f64)>,
    /// The class of a sample by its index.
    pub class_of: Box<dyn Fn(u64) -> usize + Send + Sync>,
    /// Samples in a row that are one unit of classes and splits.
    pub group: u64,
    /// Names and shares of the splits; the shares sum to 1.
    pub splits: Vec<(String, f64)>,
    /// The split of a sample by its index, as a place in `splits`.
    pub split_of: Box<dyn Fn(u64) -> usize + Send + Sync>,
    /// Every drawn number, in the order of `parameters` of `dataset.json`.
    pub parameters: Vec<ParameterLaws>,
}

/// How one number is drawn.
pub struct ParameterLaws {
    /// Its path, for instance `laser.power_mw`.
    pub path: String,
    /// The laws that it has in one class or another.
    pub laws: Vec<DrawLaw>,
    /// For each class, which of the laws it follows.
    pub law_of_class: Vec<usize>,
    /// Whether it is drawn once for each group of samples: then that of the group's first sample counts.
    pub by_group: bool,
}

/// What one row says: some hundreds of bytes, whatever the size of the images.
#[derive(Debug, Clone, PartialEq)]
pub struct RowNumbers {
    /// Number in the dataset.
    pub index: u64,
    /// Name of its split.
    pub split: String,
    /// Value of the column `class`; one that the head names.
    pub class: usize,
    /// Drawn numbers in the order of the head's parameters.
    pub numbers: Vec<f64>,
}

/// The numbers of one parameter that follow one law.
pub(super) struct LawCounts {
    /// How many there are.
    pub(super) samples: u64,
    /// How many of them the law never draws, and the first of these by its index.
    pub(super) impossible: u64,
    pub(super) first: Option<(u64, f64)>,
    /// How often each cell of a discrete law came.
    pub(super) cells: Vec<u64>,
    /// Where the numbers of a continuous law lie in it.
    pub(super) grid: Option<UnitHistogram>,
}

/// Floats that a range must hold for its numbers to count as continuous [1]: many more than the test has cells.
const MIN_FLOATS_IN_RANGE: f64 = 1e5;

/// Counts of all rows.
pub(super) struct SampleCounts<'a> {
    pub(super) declared: &'a DeclaredLaws,
    pub(super) samples: u64,
    /// Samples of each class, as rows say and as their indices say.
    pub(super) classes: Vec<[u64; 2]>,
    /// Samples of each class in each split, as rows say and as their indices say.
    pub(super) splits: Vec<Vec<[u64; 2]>>,
    /// By parameter, then by law.
    pub(super) parameters: Vec<Vec<LawCounts>>,
}

impl<'a> SampleCounts<'a> {
    /// Nothing counted.
    pub(super) fn new(declared: &'a DeclaredLaws) -> Self {
        let classes = declared.classes.len();
        let numbers = |law: &DrawLaw| LawCounts {
            samples: 0,
            impossible: 0,
            first: None,
            cells: if let DrawLaw::Discrete(cells) = law { vec![0; cells.len()] } else { Vec::new() },
            grid: is_fine(law).then(UnitHistogram::default),
        };
        Self {
            declared,
            samples: 0,
            classes: vec![[0; 2]; classes],
            splits: vec![vec![[0; 2]; declared.splits.len()]; classes],
            parameters: declared.parameters.iter().map(|p| p.laws.iter().map(numbers).collect()).collect(),
        }
    }

    /// Counts one row. The order of rows does not matter.
    pub(super) fn add(&mut self, row: &RowNumbers) {
        let declared = self.declared;
        let drawn = (declared.class_of)(row.index);
        if row.class >= self.classes.len() || drawn >= self.classes.len() {
            return;
        }
        self.samples += 1;
        self.classes[row.class][0] += 1;
        self.classes[drawn][1] += 1;
        if let Some(split) = declared.splits.iter().position(|(name, _)| *name == row.split) {
            self.splits[row.class][split][0] += 1;
        }
        if let Some(counts) = self.splits[drawn].get_mut((declared.split_of)(row.index)) {
            counts[1] += 1;
        }
        for ((parameter, tallies), &value) in declared.parameters.iter().zip(&mut self.parameters).zip(&row.numbers) {
            if parameter.by_group && !row.index.is_multiple_of(declared.group) {
                continue;
            }
            let law = parameter.law_of_class[row.class];
            tallies[law].add(&parameter.laws[law], row.index, value);
        }
    }
}

/// Whether a law is continuous and its range wide enough for the spread of its numbers to be told: where floats are as
/// coarse as the range, its numbers come in steps that no continuous law knows.
fn is_fine(law: &DrawLaw) -> bool {
    matches!(law, DrawLaw::Continuous { min, max, .. } if max - min > MIN_FLOATS_IN_RANGE * f64::EPSILON * min.abs().max(max.abs()))
}

impl LawCounts {
    fn add(&mut self, law: &DrawLaw, index: u64, value: f64) {
        self.samples += 1;
        let possible = match law {
            DrawLaw::Fixed(fixed) => value == *fixed,
            // A sum with 0 takes the sign from -0, to which small counts are rounded.
            DrawLaw::Discrete(cells) => match cells.binary_search_by(|cell| cell.0.total_cmp(&(value + 0.0))) {
                Ok(cell) => {
                    self.cells[cell] += 1;
                    true
                }
                Err(_) => false,
            },
            DrawLaw::Continuous { min, max, cdf: below } => {
                let inside = (min..=max).contains(&&value);
                if let (true, Some(grid)) = (inside, &mut self.grid) {
                    grid.add(below(value));
                }
                inside
            }
        };
        if !possible {
            self.impossible += 1;
            if self.first.is_none_or(|(first, _)| index < first) {
                self.first = Some((index, value));
            }
        }
    }
}

/// Names of the classes that follow law number `law` of a parameter; empty where all do.
pub(super) fn classes_of(declared: &DeclaredLaws, parameter: &ParameterLaws, law: usize) -> Vec<String> {
    if parameter.laws.len() == 1 {
        return Vec::new();
    }
    let own = declared.classes.iter().zip(&parameter.law_of_class).filter(|(_, of)| **of == law);
    own.map(|((name, _), _)| name.clone()).collect()
}
