//! Clouds of known laws, and a recipe whose statistics are known functions of its keys.

use base::{Stream, normal};
use rand::RngExt;
use tools::compare::summary::SummaryLaw;

use super::*;

/// A statistic in the plain scale.
fn named(key: &str) -> SummaryStatistic {
    SummaryStatistic { key: key.into(), name: key.into(), unit: "1", law: SummaryLaw::Plain, scaled: None }
}

/// A scan of twelve statistics that go together, of unlike laws: normal, skewed, even, with wide tails.
fn of_laws(rng: &mut impl rand::Rng) -> ScanNumbers {
    let common = normal(rng);
    (0..12)
        .map(|j| {
            let x = 0.7 * common + 0.7 * normal(rng);
            Some(match j % 4 {
                0 => x,
                1 => libm::exp(x),
                2 => rng.random::<f64>(),
                _ => x / rng.random::<f64>().max(0.05).sqrt(),
            })
        })
        .collect()
}

/// Scans of the same law raise an alarm once in a hundred, whatever the laws are: of 2000 over ten clouds 20 are
/// expected; limits that are themselves drawn, from 400 scans, let out 45 at most in all but one of a thousand cases.
#[test]
fn clean_scans_raise_no_alarm() {
    let list: Vec<SummaryStatistic> = (0..12).map(|j| named(&j.to_string())).collect();
    let alarms: usize = (0..10)
        .map(|seed| {
            let mut rng = Stream::root(seed).rng();
            let scans: Vec<ScanNumbers> = (0..400).map(|_| of_laws(&mut rng)).collect();
            let spread = ScanSpread::new(&scans, None, &list, 12, &|_| true);
            let limits = SpreadLimits::new(&scans, &list, 12, &|_| true);
            let is_outside = |scan: &ScanNumbers| {
                let out = spread.out(scan).into_iter().flatten().fold(0.0, f64::max);
                out > limits.out || spread.depth(&spread.standard(scan)) > limits.depth
            };
            (0..200).filter(|_| is_outside(&of_laws(&mut rng))).count()
        })
        .sum();
    println!("{alarms} alarms of 2000");
    assert!(alarms <= 45, "{alarms}");
}

/// A point that lies inside in each of two statistics and across what they have in common lies outside in depth; the
/// distance is that of the law, and what is far out in one is so many times as far as the farthest.
#[test]
fn depth_and_distance_by_hand() {
    let mut rng = Stream::root(1).rng();
    let scans: Vec<ScanNumbers> = (0..2000)
        .map(|_| {
            let [a, b] = [normal(&mut rng), normal(&mut rng)];
            vec![Some(a), Some(0.9 * a + 0.19_f64.sqrt() * b), Some(7.0)]
        })
        .collect();
    let list = [named("a"), named("b"), named("same")];
    let spread = ScanSpread::new(&scans, None, &list, 3, &|j| j < 2);
    let depth = |a: f64, b: f64| spread.depth(&spread.standard(&[Some(a), Some(b), None]));
    // x^2 + ((y - 0.9 x)^2 / 0.19); drawing in and shrinking leave a few parts of a hundred.
    for (a, b) in [(1.5, 1.5), (1.5, -1.5), (0.0, 2.0)] {
        let expected = (a * a + (b - 0.9 * a) * (b - 0.9 * a) / 0.19_f64).sqrt();
        assert!((depth(a, b) / expected - 1.0).abs() < 0.1, "{} for {expected}", depth(a, b));
    }
    let limits = SpreadLimits::new(&scans, &list, 3, &|j| j < 2);
    assert!(depth(1.5, -1.5) > limits.depth && depth(1.5, 1.5) < limits.depth);
    let farthest = scans.iter().filter_map(|scan| scan[0]).fold(0.0, f64::max);
    let out = spread.out(&[Some(2.0 * farthest), None, Some(9.0)]);
    assert!(out[0].is_some_and(|out| (out - 2.0).abs() < 0.05) && out[1..] == [None, None]);
    // What is the same in all scans has a reach of a twentieth.
    let all = ScanSpread::new(&scans, None, &list, 3, &|_| true);
    assert!(all.out(&[None, None, Some(7.1)])[2].is_some_and(|out| (out - 2.0).abs() < 1e-9));
    assert_eq!(limits.share_beyond(0.0), 1.0);
}

/// A recipe about a part with five keys that are drawn, and one more that counts.
const PLATE: &str = "
name: plate
subject: sawtooth
unstated: fixed
scan: {columns: 64, profiles: 64}
laser: {waist_mm: {log_uniform: [0.08, 0.12]}}
camera: {blur_um: {uniform: [2, 3]}}
exposure: {time_us: {log_uniform: [90, 120]}, dark_level_dn: {uniform: [4, 6]}, row_noise_dn: {uniform: [0.1, 0.2]}}
classes: {all: {share: 1}}
";

/// Statistics as functions of keys with scatter: width of the line by waist and blur, light by exposure and power, and
/// so on. The last one needs light.
fn simulate(recipe: &Recipe, index: u64) -> ScanNumbers {
    let scene = recipe.draw(0, index);
    let mut rng = Stream::root(9).index(index).rng();
    let of = |path: &str| scene.draws().into_iter().find(|(known, _)| known == path).map_or(f64::NAN, |(_, x)| x);
    let light = libm::log(of("exposure.time_us") * of("laser.power_mw"));
    let width =
        (of("laser.waist_mm") * of("laser.waist_mm") + 1e-3 * of("camera.blur_um") * of("camera.blur_um")).sqrt();
    let means =
        [light, libm::log(width), of("exposure.dark_level_dn"), 5.0 * of("exposure.row_noise_dn") - 0.2 * light];
    let mut scan: ScanNumbers = means.iter().map(|mean| Some(mean + 0.05 * normal(&mut rng))).collect();
    scan.push((light > -3.0).then(|| 0.5 * light + libm::log(width) + 0.05 * normal(&mut rng)));
    scan
}

/// The key that lies outside is found among all of a recipe, or one that does the same; its value too, and with none
/// outside nothing is named: over random hidden values.
#[test]
fn the_hidden_key_is_named() {
    let recipe = Recipe::parse("plate", PLATE).expect("it is a recipe");
    let list: Vec<SummaryStatistic> = ["light", "width", "dark", "rows", "both"].into_iter().map(named).collect();
    let names = StatisticNames { list, whole: 5 };
    let asked = CoverQuestion { recipe: &recipe, simulate: &simulate, names, watch: &|_| () };
    let scans = asked.scans(&recipe, &(0..300).collect::<Vec<_>>());
    let mut rng = Stream::root(3).rng();
    for turn in 0..20_u64 {
        let far = 1.0 + rng.random::<f64>();
        let (key, value, alike) = [
            ("laser.waist_mm", 0.12 * libm::pow(1.5, far), "camera.blur_um"),
            ("exposure.time_us", 90.0 / libm::pow(1.6, far), "laser.power_mw"),
            ("exposure.dark_level_dn", 6.0 + far, ""),
            ("exposure.row_noise_dn", 0.2 + 0.1 * far, ""),
        ][turn as usize % 4];
        let hidden = recipe.with_values([(key, value)]);
        let real = simulate(&hidden, 1000 + turn);
        let place = asked.place("real", &real, &[], &scans).expect("it is placed");
        assert!(place.told.is_outside(), "{key} {value}: {:?}", place.told);
        let (widen, all) = asked.widen(&scans, &[place.point]);
        let first: Vec<&str> = widen.iter().take(3).map(|key| key.path.as_str()).collect();
        println!("{key} {value:.3}: {:?}", widen.iter().map(WidenedKey::words).collect::<Vec<_>>());
        assert!(first.contains(&key) && all > 20, "{key} is not among {first:?}");
        let found = widen.iter().find(|known| known.path == key).expect("it is named");
        assert!((found.values[0] / value - 1.0).abs() < 0.3 && found.covers, "{key} at {:?}", found.values);
        let pairs =
            widen.iter().find(|known| known.path == alike).is_none_or(|other| other.alike.contains(&key.into()));
        assert!(pairs, "{key} and {alike} do the same");
    }
    let alarms = (0..100).filter(|turn| {
        let place = asked.place("real", &simulate(&recipe, 2000 + turn), &[], &scans).expect("it is placed");
        place.told.is_outside()
    });
    let alarms = alarms.count();
    assert!(alarms <= 6, "{alarms} alarms of 100 clean scans, where one is expected");
}

/// Without real scans: the key that does nothing is called so, and statistics that hardly vary are.
#[test]
fn idle_keys_and_still_statistics() {
    let text = PLATE.replace("row_noise_dn: {uniform: [0.1, 0.2]}", "dark_noise_dn: {uniform: [1, 2]}");
    let recipe = Recipe::parse("plate", &text).expect("it is a recipe");
    let list: Vec<SummaryStatistic> =
        ["light", "width", "dark", "rows", "both", "same"].into_iter().map(named).collect();
    let names = StatisticNames { list, whole: 6 };
    let simulate = |recipe: &Recipe, index: u64| {
        let mut scan = simulate(recipe, index);
        scan.push(Some(3.0));
        scan
    };
    let asked = CoverQuestion { recipe: &recipe, simulate: &simulate, names, watch: &|_| () };
    let scans = asked.scans(&recipe, &(0..300).collect::<Vec<_>>());
    let (still, classes) = asked.still(&scans);
    assert!(classes.is_empty() && still.iter().map(|still| still.key.as_str()).eq(["same"]), "{still:?}");
    let (keys, held) = asked.effects(&scans);
    let idle: Vec<&str> = keys.iter().filter(|key| key.is_idle).map(|key| key.path.as_str()).collect();
    assert_eq!((keys.len(), idle, held.len()), (5, vec!["exposure.dark_noise_dn"], 0));
    assert!(keys.iter().any(|key| key.path == "exposure.dark_level_dn" && key.statistic == "dark"));
}

/// The page says what was found, escapes names, and has no number that is none.
#[test]
fn the_page_is_whole() {
    let recipe = Recipe::parse("plate", PLATE).expect("it is a recipe");
    let list: Vec<SummaryStatistic> = ["<b>light", "width", "dark", "rows", "both"].into_iter().map(named).collect();
    let names = StatisticNames { list, whole: 5 };
    let asked = CoverQuestion { recipe: &recipe, simulate: &simulate, names, watch: &|_| () };
    let scans = asked.scans(&recipe, &(0..200).collect::<Vec<_>>());
    let mut real = simulate(&recipe.with_values([("exposure.dark_level_dn", 12.0)]), 1);
    real[4] = None;
    let place = asked.place("<script>", &real, &[Some(0.1)], &scans).expect("it is placed");
    let mut found = Cover { recipe: "plate".into(), simulations: 200, scans: vec![place.told], ..Cover::default() };
    (found.widen, found.asked) = asked.widen(&scans, &[place.point]);
    let page = found.page();
    for words in ["look at this", "widen exposure.dark_level_dn above 6", "1 outside", "&lt;b&gt;light", "not placed"] {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains("<script") && !page.contains("<b>") && !page.contains("://") && !page.contains("NaN"));
    let none = asked.place("blank", &[None; 5], &[], &scans);
    assert!(none.is_err_and(|fault| fault.to_string().contains("gen preview")));
    (found.keys, found.held) = asked.effects(&scans);
    found.scans.clear();
    assert!(found.page().contains("What hardly varies") && found.page().contains("No real scan was given."));
    assert_eq!(found.json()["keys"].as_array().map(Vec::len), Some(5));
}
