//! Recipes that extend others: what is merged, what is refused, and that nothing of it can panic.

use std::fs;
use std::path::Path;

use base::Stream;
use rand::RngExt;
use recipe::asset_source::{AssetSource, KeptAsset};
use recipe::{Recipe, RecipeError, YamlFaults};
use serde_json::{Map, Value, json};

use super::support::GOOD;

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("it has one")).expect("made");
        fs::write(path, text).expect("written");
    }
    folder
}

fn load(folder: &tempfile::TempDir, name: &str) -> Result<Recipe, RecipeError> {
    Recipe::load(&folder.path().join(name).to_string_lossy())
}

fn good(text: &str) -> Recipe {
    Recipe::parse("good.yaml", text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn faults(found: Result<Recipe, RecipeError>) -> YamlFaults {
    match found {
        Err(RecipeError::Faulty(faults)) => faults,
        Err(other) => panic!("{other}"),
        Ok(recipe) => panic!("accepted:\n{}", recipe.text()),
    }
}

#[test]
fn stated_keys_win_and_nothing_removes() {
    let parent = "\
name: parent
subject: wood
unstated: fixed
family: kin
laser: {power_mw: 70, waist_mm: {uniform: [0.1, 0.2]}}
camera: {tilt_deg: {normal: {mean: 25, sd: 1}}, f_number: 4}
transport: {model: path, photons_per_profile: 5000}
output: {bin: {columns: 2, profiles: 2}, png: [range, label]}
correlations: [{keys: [laser.waist_mm, camera.tilt_deg], spearman: 0.5}]
classes:
  clear: {share: 2}
  knotty: {share: 1, knots: {sound_count: 2, width_mm: 7}}
";
    let child = "\
extends: parent.yaml
name: child
laser: {power_mw: 60}
camera: {tilt_deg: {uniform: [20, 30]}, f_number: null}
transport: {model: diffusion}
output: {bin: {columns: 4}, png: [scatter]}
classes:
  clear: null
  knotty: {knots: {sound_count: 3}}
  rotten: {share: 3, rot: {reach_mm: 2}}
";
    let grandchild = "extends: child.yaml\nfamily: null\ncorrelations: null\nset: {laser.power_mw: 65}\n";
    let folder = folder(&[("parent.yaml", parent), ("child.yaml", child), ("grandchild.yaml", grandchild)]);
    let flat = |family: &str, power: f64, more: &str| {
        good(&format!(
            "name: child\nsubject: wood\nunstated: fixed\n\
             {family}laser: {{power_mw: {power}, waist_mm: {{uniform: [0.1, 0.2]}}}}\n\
                camera: {{tilt_deg: {{uniform: [20, 30]}}}}\ntransport: diffusion\n\
                output: {{bin: {{columns: 4, profiles: 2}}, png: [scatter]}}\nclasses:\n\
                \x20 knotty: {{share: 1, knots: {{sound_count: 3, width_mm: 7}}}}\n\
                \x20 rotten: {{share: 3, rot: {{reach_mm: 2}}}}\n{more}"
        ))
    };
    let pair = "correlations: [{keys: [laser.waist_mm, camera.tilt_deg], spearman: 0.5}]\n";
    let [child, grandchild] = ["child.yaml", "grandchild.yaml"].map(|name| load(&folder, name).expect("it is good"));
    assert_eq!(child.canonical(), flat("family: kin\n", 60.0, pair).canonical());
    assert_eq!(grandchild.canonical(), flat("", 65.0, "").canonical());

    // What is written is kept; what it means is one text, which names what it was made from.
    assert!(grandchild.written().starts_with("extends: child.yaml"));
    let names =
        grandchild.text().lines().filter_map(|line| line.strip_prefix("# ")?.split_once("  ")).map(|line| line.1);
    assert!(names.eq(["grandchild.yaml", "child.yaml", "parent.yaml"]), "{}", grandchild.text());
    let kept = Recipe::parse_with("dataset.json", grandchild.text(), &AssetSource::Kept(Vec::new())).expect("whole");
    assert_eq!((kept.hash(), kept.text()), (grandchild.hash(), grandchild.text()));

    // Changes from outside reach what is inherited.
    let path = folder.path().join("grandchild.yaml");
    let changes = ["camera.f_number=8", "classes.knotty.share=5"].map(|change| change.parse().expect("a change"));
    let changed = Recipe::load_changed(&path.to_string_lossy(), &changes).expect("good");
    let keys = recipe::differences(&grandchild.canonical_json(), &changed.canonical_json());
    assert_eq!(keys[0], "camera.f_number: 2.8 -> 8.0");
    assert!(keys[1..].iter().all(|key| key.starts_with("classes.")) && keys.len() == 3, "{keys:?}");
    assert_eq!(Recipe::parse("again", changed.text()).expect("good").hash(), changed.hash());
}

/// Of several parents the last one counts most; one may have a few sections alone, and all may have one in common.
#[test]
fn the_last_of_several_parents_counts_most() {
    let media = "media: {gloss: 0.2, clear_n_eff: 1.2}\n\
                 correlations: [{keys: [laser.waist_mm, camera.blur_um], spearman: 0.5}]\n";
    let folder = folder(&[
        ("media.yaml", media),
        ("steep.yaml", "extends: wood-small\nname: steep\ncamera: {tilt_deg: 35}\nmedia: {gloss: 0.5}\n"),
        ("child.yaml", "extends: [wood-small, steep.yaml, media.yaml]\nmedia: {clear_n_eff: null}\n"),
        ("other.yaml", "extends: [media.yaml, steep.yaml]\n"),
        ("none.yaml", "extends: []\n"),
        ("nine.yaml", &format!("extends: [{}]\n", ["media.yaml"; 9].join(", "))),
        ("self.yaml", "extends: [wood-small, self.yaml]\n"),
    ]);
    let [child, other] = ["child.yaml", "other.yaml"].map(|name| load(&folder, name).expect("it is good"));
    let more = "camera: {tilt_deg: 35}\n";
    let flat = |more: &str| good(&format!("extends: wood-small\nname: steep\n{more}")).canonical();
    let pair = media.split_once('\n').expect("two lines").1;
    assert_eq!(child.canonical(), flat(&format!("{more}media: {{gloss: 0.2, clear_n_eff: null}}\n{pair}")));
    // What `steep.yaml` has from its own parent counts more, too.
    assert_eq!(other.canonical(), flat(&format!("{more}media: {{gloss: 0.5}}\n{pair}")));
    for name in ["child.yaml", "steep.yaml", "wood-small", "media.yaml"] {
        assert!(child.text().lines().any(|line| line.starts_with("# ") && line.ends_with(&format!("  {name}"))));
    }
    for (name, words) in [
        ("none.yaml", "names no recipe"),
        ("nine.yaml", "has more than 8 recipes above it"),
        ("self.yaml", "comes back to itself"),
    ] {
        let found = faults(load(&folder, name));
        assert!(found.to_string().contains(words) && !found.list[0].remedy.is_empty(), "{found}");
    }
}

/// A key in the words of data sheets and the keys that it stands for remove each other.
#[test]
fn words_of_data_sheets_replace_what_they_stand_for() {
    let legs = "camera: {working_distance_mm: 400, baseline_mm: 200, f_number: 4}\nlaser: {waist_mm: 0.2}\n";
    let sides = "camera: {distance_mm: 420, tilt_deg: 30, f_number: 4}\nlaser: {waist_fwhm_mm: 0.2}\n";
    let extending = |keys: &str| format!("extends: parent.yaml\n{keys}");
    for (parent, child) in [(legs, sides), (sides, legs)] {
        let texts = [format!("{GOOD}{parent}"), extending(child)];
        let folder = folder(&[("parent.yaml", &texts[0]), ("child.yaml", &texts[1])]);
        let found = load(&folder, "child.yaml").unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(found.canonical(), good(&format!("{GOOD}{child}")).canonical());
    }
    // One of two sides does not say what the other is.
    let folder = folder(&[
        ("parent.yaml", &format!("{GOOD}{legs}")),
        ("child.yaml", "extends: parent.yaml\ncamera: {tilt_deg: 30}\n"),
    ]);
    let told = faults(load(&folder, "child.yaml")).to_string();
    assert!(told.contains("parent.yaml:4:") && told.contains("stands for `tilt_deg`, which is given too"), "{told}");
}

#[test]
fn faults_name_the_file_and_line_where_a_value_stands() {
    let folder = folder(&[
        ("far/parent.yaml", &format!("{GOOD}\ncamera:\n  f_number: -1\n  tilt_deg: 25\n")),
        ("child.yaml", "extends: far/parent.yaml\ncamera: {tilt_deg: 200}\nlaser: {colour: 3}\n"),
        ("broken.yaml", "extends: bad.yaml\n"),
        ("bad.yaml", "name: x\n\tsubject: wood\nunstated: fixed\n"),
        ("list.yaml", "- 1\n"),
        ("of-list.yaml", "extends: list.yaml\n"),
    ]);
    let found = faults(load(&folder, "child.yaml"));
    let places: Vec<_> =
        found.list.iter().map(|fault| (fault.origin.as_deref(), fault.place.line, fault.key.as_str())).collect();
    let expected =
        [(None, 2, "camera.tilt_deg"), (None, 3, "laser.colour"), (Some("far/parent.yaml"), 6, "camera.f_number")];
    assert_eq!(places, expected, "{found}");
    assert!(found.list.iter().all(|fault| !fault.remedy.is_empty()));
    let told = found.to_string();
    for words in ["far/parent.yaml:6:13: camera.f_number", "     6 |   f_number: -1", "or remove it: `key: null`"] {
        assert!(told.contains(words), "no `{words}` in {told}");
    }
    let told = faults(load(&folder, "broken.yaml")).to_string();
    assert!(told.contains("bad.yaml:2:1: ") && told.contains("tab"), "{told}");
    let told = faults(load(&folder, "of-list.yaml")).to_string();
    assert!(told.contains("list.yaml:1:1: ") && told.contains("is a list"), "{told}");
    // Of several levels that of the middle.
    let text = "extends: wood-small\ncamera: {tilt_deg: steep}\n";
    fs::write(folder.path().join("middle.yaml"), text).expect("written");
    fs::write(folder.path().join("child.yaml"), "extends: middle.yaml\n").expect("written");
    let found = faults(load(&folder, "child.yaml"));
    assert_eq!((found.list[0].origin.as_deref(), found.list[0].place.line), (Some("middle.yaml"), 2));
}

#[test]
fn parents_that_cannot_be_had_are_refused() {
    let folder = folder(&[
        ("self.yaml", "extends: self.yaml\n"),
        ("a.yaml", "extends: deep/b.yaml\n"),
        ("deep/b.yaml", "extends: ../a.yaml\n"),
        ("missing.yaml", "extends: wood-smal\n"),
        ("folder.yaml", "extends: deep\n"),
        ("nothing.yaml", &format!("{GOOD}extends:\n")),
        ("number.yaml", &format!("{GOOD}extends: 3\n")),
        ("spelt.yaml", &format!("{GOOD}extend: wood\n")),
        ("set.yaml", &format!("{GOOD}set: {{extends: wood}}\n")),
    ]);
    fs::write(folder.path().join("binary.yaml"), [0xff, 0xfe]).expect("written");
    fs::write(folder.path().join("of-binary.yaml"), "extends: binary.yaml\n").expect("written");
    for (name, words) in [
        ("self.yaml", "`self.yaml` comes back to itself"),
        ("a.yaml", "`../a.yaml` comes back to itself"),
        ("missing.yaml", "did you mean `wood-small`?"),
        ("folder.yaml", "no file `deep` beside it"),
        ("nothing.yaml", "is nothing; give the name of"),
        ("number.yaml", "is a number; give the name of"),
        ("spelt.yaml", "did you mean `extends`?"),
        ("set.yaml", "write it in the recipe's text"),
        ("of-binary.yaml", "`binary.yaml` is no UTF-8"),
    ] {
        let found = faults(load(&folder, name));
        assert!(found.to_string().contains(words), "{found}");
        assert!(found.list.iter().all(|fault| !fault.remedy.is_empty()), "{found}");
    }
    if Path::new("/dev/zero").exists() {
        fs::write(folder.path().join("zero.yaml"), "extends: /dev/zero\n").expect("written");
        assert!(faults(load(&folder, "zero.yaml")).to_string().contains("cannot be read"));
    }
    // As many parents as there may be, and one more.
    fs::write(folder.path().join("0.yaml"), GOOD).expect("written");
    for level in 1..=9 {
        let text = format!("extends: {}.yaml\nlaser: {{power_mw: {level}}}\n", level - 1);
        fs::write(folder.path().join(format!("{level}.yaml")), text).expect("written");
    }
    assert_eq!(load(&folder, "8.yaml").expect("eight parents").draw(0, 0).bench.laser.power_mw, 8.0);
    let told = faults(load(&folder, "9.yaml")).to_string();
    assert!(told.contains("has more than 8 recipes above it"), "{told}");
    // A text from no file knows built-in recipes alone, that of a dataset none.
    let text = format!("extends: {}\n", folder.path().join("0.yaml").display());
    assert!(faults(Recipe::parse("a", &text)).to_string().contains("no built-in recipe"));
    let kept = AssetSource::Kept(vec![KeptAsset { key: String::new(), name: String::new(), content: Ok(Vec::new()) }]);
    let told = faults(Recipe::parse_with("dataset.json", "extends: wood\n", &kept)).to_string();
    assert!(told.contains("keeps the whole text"), "{told}");
}

/// A parent names files from where it lies.
#[test]
fn files_of_a_parent_stay_its_own() {
    let part = "v 0 0 0\nv 4 0 0\nv 0 4 1\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    let parent = |file: &str| {
        format!(
            "name: part\nsubject: mesh\nunstated: fixed\n\
             classes: {{a: {{share: 1}}}}\nmesh: {{file: {file}, unit_mm: 1}}\n"
        )
    };
    let folder = folder(&[
        ("far/parts/own.obj", part),
        ("far/own.yaml", &parent("parts/own.obj")),
        ("far/long.yaml", &parent("{name: parts/own.obj}")),
        ("far/built-in.yaml", &parent("meshes/clip.obj")),
        ("far/none.yaml", &parent("parts/none.obj")),
        ("parts/none.obj", part),
    ]);
    let extending = |name: &str| {
        fs::write(folder.path().join("child.yaml"), format!("extends: far/{name}.yaml\n")).expect("written");
        load(&folder, "child.yaml")
    };
    for name in ["own", "long", "built-in"] {
        let direct = load(&folder, &format!("far/{name}.yaml")).expect("it is good");
        let child = extending(name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(child.hash(), direct.hash(), "{name}");
        let beside = AssetSource::Beside(folder.path().to_owned());
        assert_eq!(Recipe::parse_with("flat", child.text(), &beside).expect("it is good").hash(), direct.hash());
    }
    let told = extending("none").expect_err("its file is not there").to_string();
    assert!(told.contains("far/none.yaml:5:") && told.contains("far/parts/none.obj"), "{told}");
}

/// What `b` changes of `a`, by the shape of canonical forms alone: sections have other maps or keys that are no form.
fn difference(path: &str, a: &Value, b: &Value) -> Value {
    let forms = ["uniform", "log_uniform", "normal", "lognormal", "choice", "truncated", "every", "sha256"];
    let section = |value: &Value| {
        let map = value.as_object().filter(|_| path != "transport")?;
        (!map.keys().any(|key| forms.contains(&key.as_str()))).then(|| map.clone())
    };
    let (Some(a), Some(b)) = (section(a), section(b)) else { return b.clone() };
    let mut own = Map::new();
    for (key, value) in &b {
        match a.get(key) {
            Some(before) if before == value => {}
            Some(before) => {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                own.insert(key.clone(), difference(&path, before, value));
            }
            None => {
                own.insert(key.clone(), value.clone());
            }
        }
    }
    a.keys().filter(|key| !b.contains_key(*key)).for_each(|key| {
        own.insert(key.clone(), Value::Null);
    });
    own.into()
}

/// Pairs of recipes about one subject: the difference of the second from the first extends the first, and means the
/// second. Every second pair, which takes four seconds.
#[test]
fn the_difference_of_two_recipes_extends_the_first() {
    let all: Vec<Recipe> = Recipe::embedded().map(|known| Recipe::load(known.name).expect("built in")).collect();
    let folder = folder(&[]);
    let mut pairs = 0;
    for (n, a) in all.iter().enumerate() {
        fs::write(folder.path().join("a.yaml"), a.text()).expect("written");
        for b in all.iter().skip(n % 2).step_by(2).filter(|b| b.subject() == a.subject()) {
            let mut child = difference("", &a.canonical(), &b.canonical());
            child["extends"] = json!("a.yaml");
            let beside = AssetSource::Beside(folder.path().to_owned());
            let found = Recipe::parse_with("child.yaml", &child.to_string(), &beside);
            let found = found.unwrap_or_else(|error| panic!("{} of {}: {error}", b.name(), a.name()));
            assert_eq!(found.canonical(), b.canonical(), "{} of {}", b.name(), a.name());
            pairs += 1;
        }
    }
    assert!(pairs > 150, "{pairs}");
}

/// The built-in recipes are written as what they change, and their flat texts mean the same.
#[test]
fn built_in_recipes_are_short() {
    let mut bytes = 0;
    for known in Recipe::embedded() {
        let recipe = Recipe::load(known.name).expect("built in");
        let flat = Recipe::parse("flat", recipe.text()).unwrap_or_else(|error| panic!("{}: {error}", known.name));
        assert_eq!(flat.canonical(), recipe.canonical(), "{}", known.name);
        bytes += if known.name.starts_with("thesis/") { 0 } else { known.text.len() };
    }
    let real = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../recipes/real");
    for entry in fs::read_dir(real).expect("recipes/real") {
        let path = entry.expect("an entry").path();
        bytes +=
            if path.extension().is_some_and(|end| end == "yaml") { fs::read(path).expect("a text").len() } else { 0 };
    }
    assert!(bytes <= 63_500, "{bytes} bytes of recipes");
}

/// Three recipes that extend each other, mutated: each loads or is refused with words, and what loads has a flat text
/// that means the same.
#[test]
fn nothing_panics() {
    const TOKENS: [&str; 14] = [
        "extends: b.yaml\n",
        "extends: c.yaml\n",
        "extends: ",
        "wood",
        "a.yaml",
        "null",
        "{}",
        ": ",
        "\n",
        "  ",
        "classes:\n",
        "set: {camera.tilt_deg: 3}\n",
        "&a ",
        "[1, 2]",
    ];
    let mut rng = Stream::root(7).rng();
    let good = [
        "extends: b.yaml\nname: a\ncamera: {tilt_deg: 20, f_number: null}\nclasses: {x: null, z: {share: 1}}\n",
        "extends: c.yaml\nlaser:\n  power_mw: 40\nlog: {streak: 0.1}\nclasses:\n  x: {knots: {sound_count: 2}}\n",
        "extends: wood-small\nname: c\ncamera: {f_number: 4}\nclasses: {x: {share: 2}, y: {share: 1}, rot: null}\n",
    ];
    let (folder, mut accepted) = (folder(&[]), 0);
    for round in 0..300 {
        for (name, text) in ["a.yaml", "b.yaml", "c.yaml"].iter().zip(good) {
            let mut text = text.to_owned();
            for _ in 0..rng.random_range(0..3) {
                let at = rng.random_range(0..=text.len());
                match rng.random_range(0..4) {
                    0 | 1 => text.insert_str(at, TOKENS[rng.random_range(0..TOKENS.len())]),
                    2 => text.replace_range(at..(at + rng.random_range(0..9)).min(text.len()), ""),
                    // A line goes.
                    _ => {
                        let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
                        let end = text[at..].find('\n').map_or(text.len(), |end| at + end + 1);
                        text.replace_range(start..end, "");
                    }
                }
            }
            fs::write(folder.path().join(name), text).expect("written");
        }
        match load(&folder, "a.yaml") {
            Ok(recipe) => {
                accepted += 1;
                recipe.draw(0, round);
                assert_eq!(Recipe::parse("flat", recipe.text()).expect("good").hash(), recipe.hash());
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
    assert!((15..285).contains(&accepted), "{accepted} of 300 accepted");
}
