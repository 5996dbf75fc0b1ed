use base::{Natural, Parameter};
use recipe::Distribution;
use tools::compare::ScanMaps;

use crate::result::{Fit, FittedKey, KeyState, MapsOfScan, ScanFit, StatisticFit};

static WAIST: Parameter = Parameter {
    group: "laser",
    name: "waist_mm",
    min: 0.01,
    max: 1.0,
    default: 0.1,
    integer: false,
    doc: "Radius of the waist.",
    source: "a test",
    natural: Natural::Fixed,
    conditions: &[],
};

/// Elements that have no end.
const VOID: [&str; 4] = ["meta", "link", "input", "br"];

fn key(path: &str, state: KeyState) -> FittedKey {
    FittedKey {
        path: path.into(),
        parameter: &WAIST,
        prior: Distribution::LogUniform { min: 0.05, max: 0.5 },
        state,
        before: [0.056, 0.158, 0.446],
        after: [0.09, 0.1, 0.11],
        of_scans: Vec::new(),
        width: 0.1,
        widening: 1.25,
        moves: ("range noise along the line".into(), 12.5),
        draws: (0..100).map(|i| 0.09 + 0.0002 * f64::from(i)).collect(),
        is_log: true,
        distribution: "0.1".into(),
    }
}

fn statistic(name: &str, real: Option<f64>, distance: Option<f64>) -> StatisticFit {
    StatisticFit {
        key: name.replace(' ', "_"),
        name: name.into(),
        unit: "um",
        before: Some([1.0, 20.0, 300.0]),
        after: Some([4.0, 5.0, 6.0]),
        real,
        real_ends: real.map(|real| [0.9 * real, 1.1 * real]),
        from_scatter: distance,
        from_halves: distance,
    }
}

fn maps(cols: usize, rows: usize) -> ScanMaps {
    let light: Vec<f32> = (0..cols * rows).map(|i| (i % 200) as f32).collect();
    let range = (0..cols * rows).map(|i| if i % 11 == 0 { f64::NAN } else { (i % 5) as f64 }).collect();
    ScanMaps { cols, rows, range, reflectance: Some(light.clone()), scatter: Some(light), ..ScanMaps::default() }
}

fn scan(name: &str) -> ScanFit {
    let statistics = vec![
        statistic("range noise", Some(5.0), Some(0.5)),
        statistic("edges along", Some(42.0), Some(7.25)),
        statistic("speckle contrast", None, None),
    ];
    ScanFit {
        name: name.into(),
        statistics,
        maps: MapsOfScan { real: maps(40, 30), before: maps(50, 30), after: maps(400, 30) },
    }
}

fn example() -> Fit {
    let states = [KeyState::Determined, KeyState::Weak, KeyState::Undetermined];
    Fit {
        recipe: "plate".into(),
        seed: 7,
        simulations: 2400,
        rounds: [3, 7],
        keys: states.map(|state| key(&format!("laser.{}", state.name()), state)).to_vec(),
        correlations: Vec::new(),
        pairs: vec![(["laser.waist_mm".into(), "camera.blur_um".into()], -0.91)],
        scans: vec![scan("first.exr"), scan("second.exr")],
    }
}

/// Faults a page whose elements do not end where they should, and returns its words without tags and styles.
fn words(page: &str) -> String {
    let (mut open, mut words) = (Vec::new(), String::new());
    let mut rest = page.strip_prefix("<!DOCTYPE html>").expect("a document type");
    while let Some((text, behind)) = rest.split_once('<') {
        if open.last() != Some(&"style") {
            words += text;
        }
        let (tag, behind) = behind.split_once('>').expect("a tag ends");
        rest = behind;
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "...{}", &words[words.len().saturating_sub(80)..]);
        } else {
            let name = tag.split_whitespace().next().expect("a tag has a name");
            if !VOID.contains(&name) && name != "img" {
                open.push(name);
            }
        }
        words.push(' ');
    }
    assert!(open.is_empty() && rest.trim().is_empty(), "{open:?} {rest}");
    words
}

/// The part of a page that is one section.
fn section<'a>(page: &'a str, id: &str) -> &'a str {
    let start = format!("<section id=\"{id}\"");
    let from = page.split(&start).nth(1).unwrap_or_else(|| panic!("no section {id}"));
    from.split("</section>").next().expect("it has a beginning")
}

/// Faults words that a number makes which is none.
fn has_only_numbers(page: &str) {
    let words = words(page);
    for word in
        page.split(|c: char| !c.is_ascii_alphanumeric()).chain(words.split(|c: char| !c.is_ascii_alphanumeric()))
    {
        assert!(!["NaN", "nan", "inf"].contains(&word), "{words}");
    }
}

/// Every section is there and filled, elements end where they should, and a browser may load nothing but pictures in
/// the page.
#[test]
fn the_page_is_whole() {
    let page = example().page("a: 1\nb: 2\n", "a: 1\nb: 3\n");
    has_only_numbers(&page);
    for (id, words) in [
        ("maps", "recipe as it was</strong>"),
        ("keys", "laser.weak"),
        ("statistics", "range noise"),
        ("reach", "edges along"),
        ("recipe", "<ins>b: 3"),
    ] {
        assert!(section(&page, id).contains(words), "{id}: {words}");
        assert!(page.contains(&format!("<a href=\"#{id}\">")), "{id} is in the list of sections");
    }
    assert!(page.contains("default-src 'none'; img-src data:; style-src 'unsafe-inline'"));
    assert!(!page.contains("://") && !page.contains("<script") && !page.contains("url("));
    let sources: Vec<&str> = page.split(" src=\"").skip(1).collect();
    assert_eq!(sources.len(), 2 * 3 * 3, "three kinds of maps, three sides, two scans");
    assert!(sources.iter().all(|source| source.starts_with("data:image/png;base64,")));
}

/// The verdict counts states and what is out of reach, and a fit that time has ended says so.
#[test]
fn the_verdict_counts() {
    let page = example().page("", "");
    let head = page.split("<nav").next().expect("a head");
    let verdict = "Of 3 keys, 1 determined, 1 weak and 1 undetermined; 2 of 4 statistics of 2 scans are out of reach.";
    for words in [verdict, "stopped early", "after 3 of 7 rounds", "first.exr, second.exr", "2400"] {
        assert!(head.contains(words), "{words}\n{head}");
    }
    let done = Fit { rounds: [7, 7], ..example() };
    assert!(!done.page("", "").contains("stopped early"));
}

/// Of an undetermined key no posterior is shown; of another it is, with that of each scan.
#[test]
fn states_are_said_in_words() {
    let mut fit = example();
    fit.keys[0].of_scans = vec![[0.09, 0.095, 0.1], [0.1, 0.105, 0.11]];
    let page = fit.page("", "");
    let rows: Vec<&str> = section(&page, "keys").split("<tr class=").skip(1).collect();
    let kept = "the recipe keeps its distribution";
    let is_kept: Vec<bool> = rows.iter().map(|row| row.contains(kept)).collect();
    assert_eq!(is_kept, [false, false, true]);
    let posteriors: Vec<bool> = rows.iter().map(|row| row.contains("0.09 to 0.11")).collect();
    assert_eq!(posteriors, [true, true, false]);
    let states: Vec<bool> =
        rows.iter().zip(&fit.keys).map(|(row, key)| row.contains(&format!(">{}</span>", key.state.name()))).collect();
    assert_eq!(states, [true; 3]);
    assert!(rows[0].contains("second.exr: 0.105 (0.1 to 0.11)") && !rows[1].contains("second.exr"));
    assert!(section(&page, "keys").contains("correlation \u{2212}0.91, one rises as the other falls"));
}

/// What is out of reach is marked by a word and told with its numbers; what the real scan does not tell is listed
/// apart.
#[test]
fn what_is_out_of_reach_is_said() {
    let mut fit = example();
    fit.keys[1].after = [0.45, 0.47, 0.49];
    let page = fit.page("", "");
    let table = section(&page, "statistics");
    let rows: Vec<&str> = table.split("<tr class=\"").skip(1).collect();
    let marks: Vec<(bool, bool)> =
        rows.iter().map(|row| (row.starts_with("out"), row.contains(">out of reach<"))).collect();
    assert_eq!(marks, [(false, false), (true, true), (false, false), (true, true)]);
    assert!(rows[1].contains("+7.2") && rows[1].contains("37.8 to 46.2"), "{}", rows[1]);
    let untold = table.split("<details class=\"untold\">").nth(1).expect("a list of what is not told");
    assert!(untold.contains("<li>speckle contrast</li>") && !rows.iter().any(|row| row.starts_with("speckle")));
    let reach = words(&fit.page("", ""));
    for words in [
        "the real scan has 42 um (37.8 to 46.2), scans of the fitted recipe 4 to 6 um; it lies 7.25 deviations above",
        "Before the fit the recipe made 1 to 300 um: the value itself is made, but not together",
        "in 2 of 2 scans",
        "half of the posterior lies in the highest 5 % of the prior",
        "--set 'key={uniform: [a, b]}'",
    ] {
        assert!(reach.contains(words), "{words}\n{reach}");
    }
    fit.keys.truncate(1);
    fit.scans.iter_mut().for_each(|scan| scan.statistics[1].from_halves = Some(1.0));
    let page = fit.page("", "");
    assert!(
        section(&page, "reach").contains("make every statistic") && !section(&page, "reach").contains("What to do")
    );
}

/// Names of files and keys are text, whatever is in them.
#[test]
fn names_are_escaped() {
    let hostile = "<b>&\"'</style><script>";
    let mut fit = example();
    hostile.clone_into(&mut fit.recipe);
    hostile.clone_into(&mut fit.keys[0].path);
    hostile.clone_into(&mut fit.keys[0].moves.0);
    hostile.clone_into(&mut fit.pairs[0].0[0]);
    hostile.clone_into(&mut fit.scans[0].name);
    hostile.clone_into(&mut fit.scans[0].statistics[1].name);
    hostile.clone_into(&mut fit.scans[0].statistics[1].key);
    hostile.clone_into(&mut fit.scans[0].statistics[2].name);
    let page = fit.page(hostile, &format!("{hostile}\nb: {hostile}"));
    let words = words(&page);
    assert!(!page.contains("<b>") && !page.contains("<script") && page.matches("</style>").count() == 1);
    let count = words.matches("&lt;b&gt;&amp;").count();
    // Recipe: title, heading, facts. Scan: facts, maps, statistics, reach. Key, what it moves, pair. Statistics: a row
    // and reach, and one that is not told. Lines of the texts.
    assert_eq!(count, 3 + 4 + 1 + 1 + 1 + 2 + 1 + 2);
}

/// A fit that found nothing, scans that tell nothing, and numbers that are none still make a page that says so.
#[test]
fn nothing_told_is_said() {
    let empty = Fit { keys: Vec::new(), pairs: Vec::new(), scans: Vec::new(), ..example() };
    let page = empty.page("", "");
    has_only_numbers(&page);
    for (id, words) in [
        ("maps", "There is no real scan."),
        ("keys", "No key was fitted."),
        ("statistics", "There is no real scan."),
        ("reach", "tell no statistic"),
    ] {
        assert!(section(&page, id).contains(words), "{id}");
    }
    let mut fit = example();
    let none = f64::NAN;
    for key in &mut fit.keys {
        (key.before, key.after, key.width, key.widening) = ([none; 3], [none, f64::INFINITY, none], none, none);
        (key.draws, key.moves) = (vec![none, f64::NEG_INFINITY], (String::new(), none));
        key.prior = Distribution::Uniform { min: none, max: none };
    }
    fit.pairs[0].1 = none;
    for scan in &mut fit.scans {
        scan.statistics[0] =
            StatisticFit { real: Some(none), real_ends: Some([none; 2]), ..scan.statistics[0].clone() };
        scan.statistics[1] = StatisticFit { before: None, after: Some([none; 3]), ..scan.statistics[1].clone() };
        scan.statistics[2] = StatisticFit { real: Some(3.0), after: None, before: None, ..scan.statistics[2].clone() };
        scan.maps.real.range.fill(none);
        scan.maps.real.scatter = None;
        scan.maps.before.reflectance = None;
        scan.maps.after = ScanMaps::default();
    }
    let page = fit.page("", "");
    has_only_numbers(&page);
    let maps = section(&page, "maps");
    assert!(maps.contains("The real scan has no Scatter; that of simulated scans is left out."));
    assert_eq!(maps.matches("no such map").count(), 2 * (1 + 2), "Range and Reflectance of two scans");
    assert!(section(&page, "statistics").contains("not simulated"));
    fit.scans.iter_mut().flat_map(|scan| &mut scan.statistics).for_each(|statistic| statistic.real = None);
    let page = fit.page("", "");
    assert_eq!(section(&page, "statistics").matches("tells none of the statistics").count(), 2);
    assert!(page.contains("nothing told"));
}
