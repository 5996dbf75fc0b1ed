//! Faults of correlations, each at its place with a remedy; and the matrix of scores.

use super::*;
use crate::{Recipe, RecipeError};

const GOOD: &str = "\
name: pairs
subject: wood
unstated: fixed
laser: {waist_mm: {uniform: [0.08, 0.13]}, linewidth_nm: {log_uniform: [0.3, 1.2]}}
camera: {tilt_deg: {normal: {mean: 25, sd: 0.2}}, f_number: {choice: {values: [2.8, 4]}}}
exposure: {prnu: {uniform: [0.005, 0.015]}}
knots: {sound_count: {uniform: [1, 4]}}
classes:
  a: {share: 1}
  b: {share: 1, laser: {waist_mm: 0.1}}
";

fn faults(text: &str) -> Vec<(usize, String)> {
    match Recipe::parse("bad.yaml", text) {
        Err(RecipeError::Faulty(faults)) => {
            faults.list.iter().map(|fault| (fault.place.line, format!("{fault}"))).collect()
        }
        Err(other) => panic!("{other}"),
        Ok(_) => Vec::new(),
    }
}

/// The only fault of the recipe with these pairs, a line each, is in the line of pair `at` and says all of `words`.
fn only(pairs: &[&str], at: usize, words: &[&str]) {
    let good = GOOD;
    let text = format!("{good}correlations:\n{}", pairs.iter().map(|pair| format!("  - {pair}\n")).collect::<String>());
    let found = faults(&text);
    let [(line, told)] = found.as_slice() else { panic!("{found:#?}\n{text}") };
    assert_eq!(*line, good.lines().count() + 2 + at, "{told}");
    for word in words {
        assert!(told.contains(word), "{told} lacks {word}");
    }
}

#[test]
fn every_fault_names_its_line_and_a_remedy() {
    let pair = |keys: &str, rho: &str| format!("{{keys: [{keys}], spearman: {rho}}}");
    let one = |text: &str, words: &[&str]| only(&[text], 0, words);
    one(
        &pair("laser.waist_mm, laser.linewith_nm", "0.5"),
        &["correlations.keys", "did you mean `laser.linewidth_nm`?"],
    );
    one(&pair("laser.waist_mm, prnu", "0.5"), &["`prnu` is no key", "did you mean `exposure.prnu`?"]);
    one(&pair("laser.waist_mm, camera", "0.5"), &["it is a section", "`camera.KEY`"]);
    one(&pair("laser.waist_mm, camera.rows", "0.5"), &["the same for all samples"]);
    one(&pair("laser.waist_mm, motion.speed_mm_per_s", "0.5"), &["stands for `motion.step_mm`"]);
    one(&pair("laser.waist_mm, tablet.band_mm", "0.5"), &["blister"]);
    one(&pair("laser.waist_mm, knots.sound_count", "0.5"), &["is a count", "class"]);
    one(&pair("laser.waist_mm, laser.waist_mm", "0.5"), &["`laser.waist_mm` twice"]);
    one(&pair("laser.waist_mm", "0.5"), &["a list of 1", "two keys"]);
    one(&pair("laser.waist_mm, 7", "0.5"), &["is a number", "the path of a key"]);
    one("{keys: laser.waist_mm, spearman: 0.5}", &["correlations.keys: is a text", "two keys"]);
    for out in ["1", "-1", "1.5"] {
        one(
            &pair("laser.waist_mm, exposure.prnu", out),
            &["correlations.spearman", "out of range", "between -1 and 1"],
        );
    }
    one(&pair("laser.waist_mm, exposure.prnu", "strong"), &["correlations.spearman", "is a text"]);
    one("{keys: [laser.waist_mm, exposure.prnu]}", &["correlations.spearman: is missing"]);
    one("{spearman: 0.5}", &["correlations.keys: is missing"]);
    one("{keys: [laser.waist_mm, exposure.prnu], spearman: 0.5, pearson: 0.5}", &["`pearson` is no key", "spearman"]);
    one("strong", &["is a text", "give a map"]);
    let known = pair("laser.waist_mm, exposure.prnu", "0.5");
    only(&[&known, &pair("exposure.prnu, laser.waist_mm", "0.4")], 1, &["a pair in line 12 already", "remove one"]);
    let found = faults(&format!("{GOOD}correlations: 0.5\n"));
    assert!(found[0].1.contains("give a list of `{keys: [KEY, KEY], spearman: RHO}`"), "{found:?}");
    let found = faults(&format!("{}sampling: low_discrepency\n", GOOD));
    assert!(found[0].1.contains("did you mean `low_discrepancy`?"), "{found:?}");
    let found = faults(&GOOD.replace("{waist_mm: 0.1}", "{waist_mm: 0.1}, sampling: independent, correlations: []"));
    assert!(found.len() == 2 && found.iter().all(|(_, told)| told.contains("set it at the top level")), "{found:?}");
}

/// What the reference shows is read, and the schema names the same keys.
#[test]
fn the_reference_shows_pairs_that_are_read() {
    let page = crate::reference_markdown();
    let example = page.split("```yaml\n").find(|part| part.starts_with(CORRELATIONS)).expect("an example");
    let example = example.split("```").next().expect("its end");
    let text = "name: a\nsubject: wood\nunstated: fixed\n\
        laser: {waist_mm: {uniform: [0.08, 0.13]}, m_squared: {uniform: [1.1, 1.6]}}\n\
                log: {ring_width_mm: {uniform: [1, 2]}, latewood_share: {uniform: [0.1, 0.3]}}\nclasses: {a: {share: \
                1}}\n";
    let recipe = Recipe::parse("README.md", &format!("{text}{example}")).unwrap_or_else(|error| panic!("{error}"));
    let schema = crate::schema();
    let canonical = recipe.canonical();
    for pair in canonical[CORRELATIONS].as_array().expect("pairs") {
        for key in pair.as_object().expect("a pair").keys() {
            assert!(schema["properties"][CORRELATIONS]["items"]["properties"][key].is_object(), "{key}");
        }
    }
    assert_eq!(canonical[CORRELATIONS][0]["keys"], json!(["laser.m_squared", "laser.waist_mm"]));
}

/// All faults come at once, and a key with a fault of its own makes no second one.
#[test]
fn faults_come_all_at_once() {
    let text = format!(
        "{}correlations:\n  - {{keys: [laser.waist_mm, nothing.x], spearman: 2}}\n  - {{keys: [laser.waist_mm, \
            laser.linewidth_nm], spearman: 0.2}}\n",
        GOOD.replace("[0.08, 0.13]", "[0.13, 0.08]")
    );
    let found = faults(&text);
    assert_eq!(found.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [4, 12, 12], "{found:#?}");
}

#[test]
fn pairs_without_an_effect_are_refused() {
    let pair = |keys: &str| format!("{{keys: [{keys}], spearman: 0.5}}");
    let never = ["`camera.distance_mm` is fixed or a choice in every class", "`uniform`"];
    only(&[&pair("laser.waist_mm, camera.distance_mm")], 0, &never);
    only(&[&pair("laser.waist_mm, camera.f_number")], 0, &["`camera.f_number` is fixed or a choice"]);
    // Each is drawn in one class, and never both.
    let text = "name: a\nsubject: wood\nunstated: fixed\n\
        classes:\n  a: {share: 1, laser: {waist_mm: {uniform: [0.08, 0.13]}}}\n  \
                b: {share: 1, exposure: {prnu: {uniform: [0.005, 0.015]}}}\n";
    let pairs = "correlations: [{keys: [laser.waist_mm, exposure.prnu], spearman: 0.5}]\n";
    let found = faults(&format!("{text}{pairs}"));
    assert!(found.len() == 1 && found[0].1.contains("no class draws both"), "{found:?}");
    // One class that draws both is enough.
    let both = text.replace("b: {share: 1, ", "b: {share: 1, laser: {waist_mm: {uniform: [0.08, 0.1]}}, ");
    assert!(faults(&format!("{both}{pairs}")).is_empty());
}

/// A remedy is right: with it the recipe is read, and beyond it not.
#[test]
fn pairs_that_cannot_be_together_are_refused_with_a_range_that_can() {
    let pairs = |of_two: &str| {
        format!(
            "{}correlations:\n  - {{keys: [laser.waist_mm, laser.linewidth_nm], spearman: 0.9}}\n  \
             - {{keys: [laser.linewidth_nm, exposure.prnu], spearman: 0.8}}\n{of_two}",
            GOOD
        )
    };
    let third = |rho: &str| format!("  - {{keys: [laser.waist_mm, exposure.prnu], spearman: {rho}}}\n");
    // Written, the third pair is one of three, of which one alone can change.
    let found = faults(&pairs(&third("0.1")));
    let [(line, told)] = found.as_slice() else { panic!("{found:#?}") };
    assert!(*line >= 12 && told.contains("cannot be together") && told.contains("give this pair `spearman` from "));
    assert!(!told.contains("a pair too"), "{told}");
    // Not written, it may be what is missing.
    let found = faults(&pairs(""));
    let [(line, told)] = found.as_slice() else { panic!("{found:#?}") };
    assert!(*line == 12 && told.contains("0.9 of `laser.linewidth_nm` and `laser.waist_mm` cannot"), "{told}");
    let ranges: Vec<[f64; 2]> = told
        .split("`spearman` from ")
        .skip(1)
        .map(|rest| {
            let words: Vec<&str> = rest.split([' ', ',']).collect();
            [words[0], words[2]].map(|end| end.parse().expect("a number"))
        })
        .collect();
    let own = |rho: f64| pairs("").replace("0.9", &rho.to_string());
    let added = |rho: f64| pairs(&third(&rho.to_string()));
    let mended: [&dyn Fn(f64) -> String; 2] = [&own, &added];
    assert_eq!(ranges.len(), 2, "{told}");
    for (range, text) in ranges.into_iter().zip(mended) {
        for good in [range[0], 0.5 * (range[0] + range[1]), range[1]] {
            assert!(faults(&text(good)).is_empty(), "{good}: {:?}", faults(&text(good)));
        }
        for bad in [range[0] - 0.02, range[1] + 0.02] {
            assert!(!faults(&text(bad)).is_empty(), "{bad} of {range:?}");
        }
    }
    // In class b the waist is a number: what cannot be together there is nothing, and is not asked.
    assert!(faults(&pairs(&third("0.7"))).is_empty());
}

/// A ring of keys of which no pair alone is the culprit, and more keys than pairs are looked at singly: all are to be
/// lowered.
#[test]
fn many_pairs_are_lowered_together() {
    let keys: Vec<_> =
        keys::parameters(Some(Subject::Wood)).filter(|p| !p.integer).take(20).map(Parameter::path).collect();
    let written: Vec<WrittenPair> = (0..keys.len())
        .flat_map(|j| (0..j).map(move |i| (i, j)))
        .map(|(i, j)| {
            let mut pair = [keys[i].clone(), keys[j].clone()];
            pair.sort();
            WrittenPair { place: TextPosition::START, pair: Correlation { keys: pair, spearman: -0.1 } }
        })
        .collect();
    let active: Vec<_> = written.iter().collect();
    let mut groups = connected(&active);
    assert_eq!(groups.len(), 1);
    let matrix = ScoreMatrix::new(groups.remove(0), &active);
    // Twenty numbers are alike below zero to -1 / 19 at most.
    let share = matrix.common_factor();
    assert!(factor(&matrix.entries).is_none() && (pearson(0.1 * share) - 1.0 / 19.0).abs() < 0.002, "{share}");
    let mut yaml = YamlReader::new("", "recipe");
    matrix.refuse(&mut yaml, &active);
    let told = yaml.finish("test").expect_err("a fault").list[0].to_string();
    assert!(told.contains("multiply `spearman` of each of them by 0.5") && told.contains("and others"), "{told}");
}

/// Rows of the factor have length 1, and their products are the matrix; of one that is only just possible too.
#[test]
fn factors_give_the_matrix_again() {
    let just = (1.0 - 0.6f64 * 0.6).sqrt() * (1.0 - 0.3f64 * 0.3).sqrt();
    let matrices = [
        vec![vec![1.0, 0.5], vec![0.5, 1.0]],
        vec![vec![1.0, 0.6, 0.3], vec![0.6, 1.0, 0.18 + just], vec![0.3, 0.18 + just, 1.0]],
        vec![vec![1.0, 0.6, 0.3], vec![0.6, 1.0, 0.18 - just], vec![0.3, 0.18 - just, 1.0]],
    ];
    for matrix in &matrices {
        let rows = factor(matrix).expect("positive semi-definite");
        for (i, a) in rows.iter().enumerate() {
            for (j, b) in rows.iter().enumerate() {
                let product: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
                assert!((product - matrix[i][j]).abs() < 1e-5, "{matrix:?}: {product} at {i}, {j}");
                assert!(i != j || (product - 1.0).abs() < 1e-15);
            }
        }
    }
    let over = |excess: f64| {
        vec![vec![1.0, 0.6, 0.3], vec![0.6, 1.0, 0.18 + just + excess], vec![0.3, 0.18 + just + excess, 1.0]]
    };
    assert!(factor(&over(1e-3)).is_none() && factor(&over(-1e-3)).is_some());
    // 2 sin(pi / 10) is the golden ratio less one.
    assert!((pearson(0.6) - 0.5 * (5f64.sqrt() - 1.0)).abs() < 1e-15);
    for rho in [-0.99, -0.6, 0.0, 0.3, 0.999] {
        assert!((spearman(pearson(rho)) - rho).abs() < 1e-14);
    }
}
