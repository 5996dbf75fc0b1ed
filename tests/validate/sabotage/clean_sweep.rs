//! A clean sweep: `gen validate` calls nothing faulty, and accuses nothing, that the program made, whatever is on the
//! objects and however it is written.
//!
//! Kind of fault that it guards: a rule that is a guess about physics (what a hole shows, where light ends) beside an
//! exact comparison, told of clean data. Small recipes at their full field, binned 4 x 4; each number that switches
//! something on is on in one dataset, found by its declaration, so that a new defect joins by itself; forms of files,
//! recipes and seeds pairwise. The sweep proves itself: the rule that held the middle fibre of every knot, holes too,
//! to the knot's axis fires in it.

use std::collections::{BTreeMap, BTreeSet};

use base::{Parameter, Stream};
use dataset::validate::{ValidationOptions, ValidationReport, validate};
use dataset::{Dataset, Encoded};
use procedural::blister::Defects;
use procedural::wood::Wood;
use rand::RngExt;
use recipe::{Change, Recipe};
use scanner::optics::speckle::PatternCache;
use sheetlight::generate::{DatasetRequest, ExpectedDataset, dataset_head, render_sample};

use super::place::{ESTIMATES, channel, compare, compare_rows, write_as};

/// Recipes, whose boards and packs become one class.
const RECIPES: [&str; 4] = ["wood-small", "blister-small", "sawtooth-small", "mesh-small"];
/// What is written, in every way that rules tell apart.
const FORMS: [(&str, &[&str]); 4] = [
    (
        "output",
        &[
            "png=[range, reflectance, scatter, label, instance] exr=[range, reflectance, scatter, label, instance] \
                truth_maps=true",
            "png=[] exr=[range, reflectance, scatter, label, instance] truth_maps=true",
            "png=[range, reflectance, scatter, label] exr=[] truth_maps=false",
            "png=[range] exr=[] truth_maps=false",
            "png=[reflectance, label] exr=[range, instance] truth_maps=false",
        ],
    ),
    ("extraction", &["range=calibrated", "range=uncalibrated", "range=rectified"]),
    ("exposure", &["bits=8", "bits=10", "bits=12"]),
    ("output", &["sensor_stack=none", "sensor_stack={every: 64}"]),
];
const SEEDS: u64 = 3;
/// What boards have that are not placed in a log, but cut from elsewhere.
const OTHER_SOURCES: [&str; 3] = ["stem", "picture", "slices"];
/// Where truth maps and instances are, which the rule of before was about.
const WITH_TRUTH: usize = 0;

/// One dataset: its recipe, what is switched on, samples, and the level of each form, then the seed.
struct SweptDataset {
    recipe: usize,
    switch: Option<String>,
    samples: u64,
    levels: [usize; FORMS.len() + 1],
}

impl SweptDataset {
    fn name(&self) -> String {
        let forms = FORMS.iter().zip(self.levels).map(|((_, levels), level)| levels[level]);
        let switch = self.switch.as_deref().unwrap_or("as it is");
        let forms = forms.collect::<Vec<_>>().join(" ");
        format!("{}, {switch}, {forms}, seed {}", RECIPES[self.recipe], self.seed())
    }

    fn seed(&self) -> u64 {
        self.levels[FORMS.len()] as u64
    }

    fn recipe(&self) -> Result<Recipe, String> {
        let mut changes = vec!["output.bin={columns: 4, profiles: 4}".to_owned(), "speckle.strength=0".to_owned()];
        for ((group, levels), level) in FORMS.iter().zip(self.levels) {
            // Blanks divide changes, but for those within lists.
            let keys = levels[level].split(' ').fold(Vec::<String>::new(), |mut keys, word| {
                match keys.last_mut() {
                    Some(last) if !word.contains('=') => *last = format!("{last} {word}"),
                    _ => keys.push(word.to_owned()),
                }
                keys
            });
            changes.extend(keys.iter().map(|key| format!("{group}.{key}")));
        }
        if let Some(switch) = &self.switch {
            changes.push("classes={a: {share: 1}}".into());
            changes.extend(switch.split(", ").map(str::to_owned));
        }
        let changes: Vec<Change> = changes.iter().map(|change| change.parse().expect("a change")).collect();
        Recipe::load_changed(RECIPES[self.recipe], &changes).map_err(|error| error.to_string())
    }
}

/// Every number of a board whose default, 0, leaves something away, with a value that a small board has room for.
fn switches() -> Vec<String> {
    let mut numbers: Vec<&'static Parameter> = Vec::new();
    Wood::from_values(&mut |number| {
        numbers.push(number);
        number.default
    });
    let value = |number: &Parameter| match (number.integer, number.max <= 1.0) {
        (true, _) => 2_f64.min(number.max),
        (false, true) => 0.7 * number.max,
        (false, false) => number.max / 50.0,
    };
    let is_switch =
        |number: &&&Parameter| number.default == 0.0 && number.min == 0.0 && !OTHER_SOURCES.contains(&number.group);
    numbers.iter().filter(is_switch).map(|number| format!("{}={}", number.path(), value(number))).collect()
}

/// The datasets: one for each switch, those of knots with truth maps and each seed, and a few without any, with forms,
/// recipes and seeds pairwise.
fn swept() -> Vec<SweptDataset> {
    let plain = |recipe, switch, samples| SweptDataset { recipe, switch, samples, levels: [0; FORMS.len() + 1] };
    let mut free: Vec<SweptDataset> = switches().into_iter().map(|switch| plain(0, Some(switch), 1)).collect();
    let counts = Defects::PARAMETERS.iter().filter(|number| number.integer);
    free.extend(counts.map(|count| plain(1, Some(format!("{}=1", count.path())), 1)));
    free.extend((0..16).map(|place| plain(2 + place % 2, None, 2)));
    let mut fixed = Vec::new();
    for seed in 0..SEEDS as usize {
        for kind in ["sound_count", "dead_count", "hole_count", "loose_count"] {
            let mut knots = plain(0, Some(format!("knots.{kind}=2, knots.width_mm=7")), 2);
            (knots.levels[0], knots.levels[FORMS.len()]) = (WITH_TRUTH, seed);
            fixed.push(knots);
        }
    }
    pairwise(&mut free);
    free.extend(fixed);
    free
}

/// How many levels each factor has: the recipe, the forms, the seed.
fn counts() -> Vec<usize> {
    std::iter::once(RECIPES.len()).chain(FORMS.iter().map(|(_, levels)| levels.len())).chain([SEEDS as usize]).collect()
}

/// The pairs of levels of a dataset, each as two factors with their levels.
fn pairs(dataset: &SweptDataset) -> impl Iterator<Item = [(usize, usize); 2]> {
    let levels: Vec<usize> = std::iter::once(dataset.recipe).chain(dataset.levels).collect();
    let both = (0..levels.len()).flat_map(move |a| (0..a).map(move |b| (a, b)));
    both.map(move |(a, b)| [(a, levels[a]), (b, levels[b])])
}

/// Gives each dataset the levels, of some that are drawn, that bring the most pairs that no dataset before has.
fn pairwise(datasets: &mut [SweptDataset]) {
    let mut rng = Stream::root(1).child("sweep").rng();
    let mut seen = BTreeSet::new();
    // Recipes with few datasets first: they have the least choice.
    let mut order: Vec<usize> = (0..datasets.len()).collect();
    order.sort_by_key(|&place| std::cmp::Reverse(datasets[place].recipe));
    for place in order {
        let dataset = &mut datasets[place];
        let best = (0..60).map(|_| {
            for (level, count) in dataset.levels.iter_mut().zip(&counts()[1..]) {
                *level = rng.random_range(0..*count);
            }
            (pairs(dataset).filter(|pair| !seen.contains(pair)).count(), dataset.levels)
        });
        dataset.levels = best.max().expect("some").1;
        seen.extend(pairs(dataset));
    }
    let counts = counts();
    for a in 0..counts.len() {
        for b in 0..a {
            for (i, j) in (0..counts[a]).flat_map(|i| (0..counts[b]).map(move |j| (i, j))) {
                assert!(
                    seen.contains(&[(a, i), (b, j)]),
                    "level {i} of factor {a} never meets level {j} of factor {b}"
                );
            }
        }
    }
}

/// Objects in which the rule that was removed sees a fault: the median dive of at least 200 pixels of anything that has
/// an axis is over 20 degrees from it.
fn old_rule(sample: &Encoded) -> usize {
    let (dive, instance) = (channel(sample, "FibreDive"), channel(sample, "Instance"));
    let is_wrong = |object: &dataset::record::Object| {
        let own = dive.iter().zip(&instance).filter(|(dive, i)| **i == f32::from(object.instance.id) && !dive.is_nan());
        let mut own: Vec<f32> = own.map(|(dive, _)| dive.abs()).collect();
        own.sort_by(f32::total_cmp);
        own.len() >= 200 && (own[own.len() / 2] - object.instance.dive_deg.abs() as f32).abs() > 20.0
    };
    sample.objects.iter().filter(|object| object.instance.dive_deg.is_finite() && is_wrong(object)).count()
}

#[test]
#[ignore = "long"]
fn nothing_that_the_program_made_is_accused() {
    let mut patterns: BTreeMap<(usize, u64), PatternCache> = BTreeMap::new();
    let (mut fired, mut faulty, mut refused, mut samples) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for swept in swept() {
        let (name, seed) = (swept.name(), swept.seed());
        let recipe = match swept.recipe() {
            Ok(recipe) => recipe,
            Err(why) => {
                refused.push(format!("{name}: {why}"));
                continue;
            }
        };
        let patterns =
            patterns.entry((swept.recipe, seed)).or_insert_with(|| PatternCache::new(recipe.streams(seed).key()));
        let made: Vec<Encoded> =
            (0..swept.samples).map(|index| render_sample(&recipe, seed, index, patterns, &|_| ())).collect();
        if swept.levels[0] == WITH_TRUTH && swept.recipe == 0 {
            let wrong: usize = made.iter().map(old_rule).sum();
            fired.extend((wrong > 0).then(|| format!("{wrong} in {name}")));
        }
        let (samples_per_shard, out) = (Some(swept.samples), "set".into());
        let order = DatasetRequest { samples: swept.samples, seed, out, part: (0, 1), samples_per_shard };
        // The rig's check is no rule of validation, and takes half a second.
        let place = write_as(dataset_head(&recipe, &order, Vec::new()), made);
        let folder = Dataset::open(place.path()).expect("it opens");
        let again = ExpectedDataset::with_warnings(&folder, |_, _| Vec::new()).expect("its recipe loads");
        // As by default, without rows, and where the recipe cannot be drawn again.
        let reports: [ValidationReport; 3] = [
            compare_rows(place.path(), Ok(&again), again.rows(None, 1)),
            compare(place.path(), Ok(&again)),
            validate(place.path(), &ValidationOptions::default()),
        ];
        samples += swept.samples;
        for report in reports {
            let accuses = report.warnings.iter().any(|warning| ESTIMATES.contains(&warning.code));
            if !report.is_clean() || accuses || report.samples != swept.samples {
                faulty.push(format!("{name}:\n{report}"));
            }
        }
    }
    println!("{samples} samples, the old rule fires in {} datasets: {fired:#?}", fired.len());
    assert!(refused.is_empty(), "these recipes do not load: {refused:#?}");
    assert!(faulty.is_empty(), "{} reports:\n{}", faulty.len(), faulty.join("\n"));
    assert!(fired.len() >= 3, "the sweep would not have seen the rule: {fired:?}");
}
