//! Groups: what their samples share, how even they are, and that splits part none of them.

use std::collections::{BTreeMap, BTreeSet};

use super::*;
use crate::{Recipe, Scene};

fn parse(text: &str) -> Recipe {
    Recipe::parse("test", text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Three classes of one subject, with a key of the rig, of the lot and of the sample.
fn text(subject: &str, rest: &str) -> String {
    let own = match subject {
        "wood" => "log: {source: stem, ring_width_mm: {uniform: [1, 3]}LOG}\nboard: {length_mm: 150}\n",
        _ => "film: {sigma_per_mm: {uniform: [5, 20]}}\npack: {turn_deg: {uniform: [-1, 1]}}\n",
    };
    format!(
        "name: groups\nsubject: {subject}\nunstated: fixed\nclasses: {{a: {{share: 3}}, b: {{share: 2}}, c: {{share: \
         1}}}}\nlaser: {{power_mw: {{uniform: [40, 60]}}}}\n{own}{rest}"
    )
}

fn of(scene: &Scene, path: &str) -> f64 {
    scene.draws().into_iter().find(|(key, _)| key == path).expect("a key").1
}

/// A number of an instrument is the same in all that it scans, one of a batch in all of the batch, others differ.
#[test]
fn numbers_are_those_of_their_group() {
    for sampling in ["", "sampling: low_discrepancy\n"] {
        let recipe = parse(&text("blister", &format!("rigs: 3\nsamples_per_batch: 4\n{sampling}")));
        let mut seen: [BTreeMap<u64, f64>; 2] = Default::default();
        let mut turns = BTreeSet::new();
        for index in 0..120 {
            let scene = recipe.draw(5, index);
            let SampleGroups { rig, log, batch } = scene.groups;
            let batch = batch.expect("a pack has a batch");
            assert_eq!((scene.groups, log, batch), (recipe.groups_of(5, index), None, index / 4));
            for (group, number, path) in [(0, rig, "laser.power_mw"), (1, batch, "film.sigma_per_mm")] {
                let value = of(&scene, path);
                assert_eq!(*seen[group].entry(number).or_insert(value), value, "{path} of {number}");
            }
            assert!(turns.insert(of(&scene, "pack.turn_deg").to_bits()));
        }
        for (group, groups) in seen.iter().zip([3, 30]) {
            let values: BTreeSet<u64> = group.values().map(|value| value.to_bits()).collect();
            assert_eq!((group.len(), values.len()), (groups, groups));
        }
    }
}

/// Without groups each sample has its own, and every draw is what it was.
#[test]
fn one_of_each_is_no_group() {
    let (plain, one) = (parse(&text("blister", "")), parse(&text("blister", "samples_per_batch: 1\n")));
    assert_eq!((plain.hash(), plain.draw(1, 7)), (one.hash(), one.draw(1, 7)));
    assert_eq!(plain.draw(1, 7).groups, SampleGroups { rig: 7, log: None, batch: Some(7) });
    let board = parse(&text("wood", "").replace("LOG", ""));
    assert_eq!(board.draw(1, 7).groups, SampleGroups { rig: 7, log: Some(7), batch: None });
}

/// Instruments scan evenly much of each class, in every prefix.
#[test]
fn rigs_scan_evenly() {
    let recipe = parse(&text("blister", "rigs: 5\n"));
    let mut counts: BTreeMap<(String, u64), u64> = BTreeMap::new();
    for index in 0..600 {
        let scene = recipe.draw(2, index);
        *counts.entry((scene.class, scene.groups.rig)).or_default() += 1;
        if (index + 1) % 100 == 0 {
            for class in ["a", "b", "c"] {
                let own: Vec<u64> = (0..5).map(|rig| counts.get(&(class.into(), rig)).copied().unwrap_or(0)).collect();
                let (least, most) = (own.iter().min().expect("five"), own.iter().max().expect("five"));
                assert!(most - least <= 1, "{class} after {index}: {own:?}");
            }
        }
    }
}

/// Over 200 drawn recipes no rig, log or batch that `by` names is in two splits; shares are met within the largest
/// group, and counts are those of a walk.
#[test]
fn splits_part_no_group() {
    let root = Stream::root(11);
    let mut parted = 0;
    for round in 0..200u64 {
        let pick = |name: &str, most: u64| root.child(name).index(round).key() % most;
        let is_wood = pick("subject", 2) == 0;
        let (rigs, lot) = ([0, 3, 4, 7, 12][pick("rigs", 5) as usize], 1 + pick("lot", 6));
        let by = ["[log, batch]", "[rig]", "[rig, log, batch]", "[]", "[batch]", "[log]"][pick("by", 6) as usize];
        let by = if rigs == 0 { by.replace("rig, ", "").replace("rig", "") } else { by.to_owned() };
        let shares = ["", ", train: 0.6, validation: 0.2, test: 0.2", ", train: 0.5, validation: 0, test: 0.5"]
            [pick("shares", 3) as usize];
        let mut rest = format!("splits: {{by: {by}{shares}}}\n");
        if rigs > 0 {
            rest += &format!("rigs: {rigs}\n");
        }
        let (subject, of_log) =
            if is_wood { ("wood", format!(", boards_per_log: {lot}")) } else { ("blister", "".into()) };
        if !is_wood && lot > 1 {
            rest += &format!("samples_per_batch: {lot}\n");
        }
        let recipe = parse(&text(subject, &rest).replace("LOG", &of_log));
        let samples = 100 + pick("samples", 300);
        let mut splits: [BTreeMap<u64, BTreeSet<Split>>; 2] = Default::default();
        let mut walked = vec![[0u64; 3]; 3];
        for index in 0..samples {
            let (groups, split) = (recipe.groups_of(round, index), recipe.split_of(round, index));
            let lot = groups.log.or(groups.batch).expect("a lot");
            [groups.rig, lot].into_iter().zip(&mut splits).for_each(|(group, of)| {
                of.entry(group).or_default().insert(split);
            });
            let class = recipe.class_of(round, index);
            let place = recipe.classes().iter().position(|known| known.name == class.name).expect("a class");
            walked[place][split as usize] += 1;
        }
        assert_eq!(recipe.class_counts(round, samples), walked, "{rest} {of_log}");
        let lots = by.contains(if is_wood { "log" } else { "batch" });
        let whole = |of: &BTreeMap<u64, BTreeSet<Split>>| of.values().all(|splits| splits.len() == 1);
        assert!(!by.contains("rig") || whole(&splits[0]), "{rest}");
        assert!(!(lots || by.contains("rig")) || whole(&splits[1]), "{rest} {of_log}");
        parted += usize::from(lot > 1 && !lots && !by.contains("rig") && !whole(&splits[1]));
        let largest = if by.contains("rig") { samples.div_ceil(rigs) + 6 * lot } else { lot };
        let sum = |split: usize| walked.iter().map(|counts| counts[split]).sum::<u64>() as f64;
        let asked = recipe.splits();
        for (split, share) in [asked.train, asked.validation, asked.test].into_iter().enumerate() {
            let far = (sum(split) - share * samples as f64).abs();
            assert!(far <= 3.0 * 2.0 * largest as f64, "{rest}{of_log}: split {split} has {} of {samples}", sum(split));
        }
    }
    assert!(parted > 10, "groups are parted where nothing forbids it: {parted}");
}

#[test]
fn what_cannot_be_parted_is_refused_with_a_remedy() {
    let refused = |subject: &str, rest: &str, parts: &[&str]| {
        let text = text(subject, rest).replace("LOG", "");
        let fault = Recipe::parse("test", &text).expect_err("a fault").to_string();
        assert!(parts.iter().all(|part| fault.contains(part)), "{fault}");
    };
    refused("blister", "splits: {by: [rig]}\n", &["splits.by", "an instrument of its own", "give `rigs` too"]);
    refused("blister", "splits: {by: [rig]}\nrigs: 2\n", &["splits.by", "2 of them", "at least `rigs: 3`"]);
    refused("blister", "splits: {by: [line]}\n", &["splits.by", "`line` is unknown", "one of rig, log, batch"]);
    refused("wood", "samples_per_batch: 4\n", &["samples_per_batch", "boards", "give `log.boards_per_log`"]);
    refused("blister", "rigs: 0\n", &["rigs", "0 is out of range", "1 to 1000"]);
    let pair = "correlations: [{keys: [laser.power_mw, film.sigma_per_mm], spearman: 0.5}]\n";
    refused("blister", &format!("rigs: 4\n{pair}"), &["once for a rig", "once for a sample", "remove `rigs`"]);
    parse(&text("blister", pair));
    let by_class = text("blister", "").replace("a: {share: 3}", "a: {share: 3, rigs: 4}");
    let fault = Recipe::parse("test", &by_class).expect_err("a fault").to_string();
    assert!(fault.contains("is the same for all classes"), "{fault}");
}
