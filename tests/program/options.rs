//! Options: short ones, `--set`, standard input and output, names of files that say what they are not, completions.

use std::fs;
use std::io::Write;
use std::process::Stdio;

use serde_json::{Value, json};
use test_support::program::{Place, assert_same, mesh_recipe, recipe};

/// Runs a command that is refused as unusable with all of `words`, and leaves nothing.
fn unusable(place: &Place, arguments: &str, words: &[&str]) {
    let before = place.tree("");
    let run = place.run(arguments);
    assert_eq!(run.code, 2, "gen {arguments}:\n{}{}", run.out, run.err);
    for word in words {
        assert!(run.err.contains(word), "gen {arguments}: no `{word}` in\n{}", run.err);
    }
    assert_same(&before, &place.tree(""), arguments);
}

#[test]
fn numbers_below_zero_are_values() {
    let place = Place::with(&[]);
    for option in ["--n", "-n", "--seed", "--threads", "--samples-per-shard"] {
        unusable(&place, &format!("--recipe tiny.yaml {option} -5"), &["'-5'", "whole number that is not negative"]);
    }
    unusable(&place, "preview --recipe tiny.yaml --index -1", &["'-1'", "--index"]);
    unusable(&place, "study speckle --repeats -3", &["'-3'", "--repeats"]);
}

#[test]
fn standard_output_is_no_file_named_minus() {
    let place = Place::with(&[]);
    place.make("set", "--n 1");
    for command in [
        "--recipe tiny.yaml --n 1 --out -",
        "report set --out -",
        "compare set set --out -",
        "export png set --out -",
        "study laser --out -",
        "check set --model none.onnx --out -",
    ] {
        unusable(&place, command, &["standard output takes no", "./-"]);
    }
    // A picture and an answer can go there.
    let preview = place.command("preview --recipe tiny.yaml --out -").output().expect("it runs");
    assert!(preview.status.success() && preview.stdout.starts_with(b"\x89PNG"), "{:?}", preview.status);
    place.done("preview --recipe tiny.yaml --out named.png");
    assert_eq!(preview.stdout, fs::read(place.path("named.png")).expect("a picture"));
    let ask = "transport --medium clear-wood --model kernel";
    assert_eq!(place.done(&format!("{ask} --out -")).out, place.done(ask).out);
    assert!(!place.path("-").exists());
}

#[test]
fn names_of_files_say_what_they_hold() {
    let place = Place::with(&[]);
    place.make("set", "--n 1");
    unusable(&place, "preview --recipe tiny.yaml --out x.jpg", &["x.jpg", "PNG", "x.png"]);
    unusable(&place, "compare set set --out x.pdf", &["x.pdf", "x.png"]);
    unusable(&place, "study laser --out x.jpeg", &["x.jpeg", "x.png"]);
    unusable(&place, "report set --out page.pdf", &["page.pdf", "page.html"]);
    unusable(&place, "transport --medium clear-wood --model kernel --out a.png", &["a.png", "a.json"]);
    place.done("preview --recipe tiny.yaml --out x.PNG");
    place.done("preview --recipe tiny.yaml -o without-ending");
}

#[test]
fn short_options_are_the_long_ones() {
    let place = Place::with(&[]);
    place.done("--recipe tiny.yaml --n 2 --out long --threads 1");
    place.done("--recipe tiny.yaml -n 2 -o short -j 1");
    assert_same(&place.tree("long"), &place.tree("short"), "short options");
    let quiet = place.done("--recipe tiny.yaml -n 3 -o short -q");
    assert_eq!((quiet.out.as_str(), quiet.err.as_str()), ("", ""));
    assert_eq!(place.done("preview --recipe tiny.yaml -q").err, "");
    let more = place.done("--recipe tiny.yaml -n 4 -o short -v").err;
    for word in ["recipe wood-small about wood", "shard 0 is finished", "threads"] {
        assert!(more.contains(word), "no `{word}` in {more}");
    }
    // Faults are said all the same.
    let refused = place.run("--recipe nowhere.yaml -n 3 -q");
    assert!(refused.code == 1 && refused.err.contains("nowhere.yaml"), "{}", refused.err);
}

#[test]
fn keys_are_changed_on_the_command_line() {
    let place = Place::with(&[]);
    let set = "--set laser.power_mw=60 --set camera.tilt_deg={\"uniform\":[24,26]} --set classes.rot.share=0.3";
    place.done(&format!("--recipe tiny.yaml {set} --n 2 --out set"));
    let head = place.json("set/dataset.json");
    let canonical = &head["recipe"]["canonical"];
    assert_eq!(canonical["laser"]["power_mw"], 60.0);
    assert_eq!(canonical["camera"]["tilt_deg"], json!({ "uniform": [24.0, 26.0] }));
    let text = head["recipe"]["text"].as_str().expect("a text");
    assert!(text.starts_with(recipe(&[]).trim_end()), "the recipe's own text stays: {text}");
    for line in ["\nset:\n", "  laser.power_mw: 60\n", "  camera.tilt_deg: {uniform: [24, 26]}\n"] {
        assert!(text.ends_with('\n') && text.contains(line), "no `{line}` in {text}");
    }
    // The folder alone makes and checks the same samples, and the recipe can be printed, changed or not.
    place.done("validate set --rerender 2");
    place.done("--recipe set --n 3");
    place.done(&format!("--recipe tiny.yaml {set} --n 3 --out set"));
    assert_eq!(place.done("recipe show set").out, text);
    assert_eq!(place.done(&format!("recipe show tiny.yaml {set}")).out, text);
    let again = place.done("recipe show set --set laser.power_mw=70 --set laser.power_mw=80 --json").out;
    let again: Value = serde_json::from_str(&again).expect("it is JSON");
    assert_eq!((&again["laser"]["power_mw"], &again["camera"]["tilt_deg"]["uniform"][0]), (&80.0.into(), &24.0.into()));
    // Without the changes it is another recipe.
    let other = place.run("--recipe tiny.yaml --n 4 --out set");
    assert!(other.code == 1 && other.err.contains("laser.power_mw: 60"), "{}", other.err);
    // The canonical form is one map in braces; its text can be changed too.
    place.write("flow.yaml", place.done("recipe show tiny.yaml --json").out);
    let changed = place.done("recipe show flow.yaml --set laser.power_mw=60").out;
    place.write("changed.yaml", changed);
    let changed: Value = serde_json::from_str(&place.done("recipe show changed.yaml --json").out).expect("it is JSON");
    assert_eq!((&changed["laser"]["power_mw"], &changed["scan"]["columns"]), (&60.0.into(), &64.into()));
}

#[test]
fn faults_of_changed_keys_are_as_good_as_those_of_files() {
    let place = Place::with(&[]);
    for (set, words) in [
        ("camera.tilt_deg=90", ["--set camera.tilt_deg: 90 is out of range", "5 to 75 deg"]),
        ("camera.tilt_dg=30", ["--set camera.tilt_dg: `tilt_dg` is no key", "did you mean `tilt_deg`"]),
        ("cammera.tilt_deg=30", ["--set cammera: `cammera` is no key", "did you mean `camera`"]),
        ("camera.tilt_deg={\"unifrom\":[20,30]}", ["--set camera.tilt_deg.unifrom", "did you mean `uniform`"]),
        ("name.first=a", ["--set name.first: `name` is a text, which has no keys", "set `name` as a whole"]),
        ("transport=monte", ["--set transport: `monte` is unknown", "path"]),
    ] {
        let run = place.run(&format!("preview --recipe tiny.yaml --set {set}"));
        assert_eq!(run.code, 1, "{set}: {}", run.err);
        for word in words {
            assert!(run.err.contains(word), "{set}: no `{word}` in {}", run.err);
        }
        assert!(run.err.contains("--set | "), "{set}: the line is shown: {}", run.err);
    }
    unusable(&place, "preview --recipe tiny.yaml --set camera.tilt_deg", &["KEY=VALUE", "camera.tilt_deg=30"]);
    unusable(&place, "preview --recipe tiny.yaml --set =3", &["no key"]);
    unusable(&place, "preview --recipe tiny.yaml --set camera.tilt_deg={\"uniform\":[2", &["unclosed", "close each"]);
    // Faults of the file keep their lines.
    place.write("tiny.yaml", recipe(&[["power_mw: 50", "power_w: 50"]]));
    let run = place.run("preview --recipe tiny.yaml --set camera.tilt_deg=90");
    assert!(
        run.err.contains("2 faults") && run.err.contains("tiny.yaml:") && run.err.contains("--set "),
        "{}",
        run.err
    );
}

/// A recipe on standard input makes the dataset of the same recipe in a file; files that it names lie beside the
/// caller.
#[test]
fn standard_input_holds_a_recipe() {
    let place = Place::with(&[]);
    let piped = |text: &str, arguments: &str| {
        let mut child = place.command(arguments).stdin(Stdio::piped()).spawn().expect("it starts");
        child.stdin.take().expect("a pipe").write_all(text.as_bytes()).expect("it is read");
        let output = child.wait_with_output().expect("it ends");
        (output.status.code(), String::from_utf8(output.stderr).expect("it is text"))
    };
    place.make("named", "--n 2");
    let (code, told) = piped(&recipe(&[]), "--recipe - --n 2 --out piped");
    assert_eq!(code, Some(0), "{told}");
    assert_same(&place.tree("named"), &place.tree("piped"), "a recipe on standard input");
    let (code, told) = piped(&recipe(&[["power_mw: 50", "power_w: 50"]]), "--recipe - --n 2 --out none");
    assert!(code == Some(1) && told.contains("standard input:") && told.contains("did you mean"), "{told}");
    let (code, told) = piped("", "--recipe - --n 2 --out none");
    assert!(code == Some(1) && told.contains("the file is empty"), "{told}");
    fs::create_dir(place.path("parts")).expect("a folder");
    place.write("parts/flat.obj", "v 0 0 0\nv 9 0 0\nv 9 8 0\nv 0 8 3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    let (code, told) =
        piped(&mesh_recipe(&[["meshes/clip.obj", "parts/flat.obj"]]), "preview --recipe - --out part.png");
    assert_eq!(code, Some(0), "{told}");
}

#[test]
fn shells_get_their_completions() {
    let place = Place::new();
    for (shell, words) in [
        ("bash", ["--samples-per-shard", "COMPREPLY"]),
        ("zsh", ["#compdef gen", "preview"]),
        ("fish", ["complete -c gen", "samples-per-shard"]),
    ] {
        let script = place.done(&format!("completions {shell}")).out;
        words.iter().for_each(|word| assert!(script.contains(word), "{shell}: no `{word}`"));
    }
    unusable(&place, "completions none", &["none", "bash"]);
    let page = place.done("man").out;
    assert!(page.starts_with(".ie") && page.contains(".TH") && page.contains("samples"), "{page}");
    assert!(place.done("man export coco").out.contains("run\\-length"), "the page of a command");
    unusable(&place, "man export none", &["no command `none`", "coco"]);
}

/// Guards pages that list commands by hand: the program writes a page for each command that it has, and the guide asks
/// it to.
#[test]
fn manual_pages_are_those_of_all_commands() {
    let place = Place::new();
    fs::create_dir(place.path("man1")).expect("a folder");
    place.done("man --all man1");
    let mut expected = vec!["gen.1".to_owned()];
    let commands = |page: &str| -> Vec<String> {
        let help = place.done(&format!("{page} --help")).out;
        let (_, list) = help.split_once("\nCommands:\n").unwrap_or_default();
        let named = list.lines().take_while(|line| !line.is_empty()).filter(|line| !line.starts_with("    "));
        named
            .filter_map(|line| line.split_whitespace().next())
            .filter(|name| *name != "help")
            .map(String::from)
            .collect()
    };
    for command in commands("") {
        expected.push(format!("gen-{command}.1"));
        expected.extend(commands(&command).iter().map(|below| format!("gen-{command}-{below}.1")));
    }
    expected.sort();
    let entries = fs::read_dir(place.path("man1")).expect("the folder").flatten();
    let mut pages: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    pages.sort();
    assert!(expected.len() > 25, "only {expected:?}");
    assert_eq!(pages, expected);
    let page = fs::read_to_string(place.path("man1/gen-export-coco.1")).expect("a page");
    assert_eq!(page, place.done("man export coco").out);
    place.run("man --all none").refused(&["none", "cannot write", "folder"]);
    let guide = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/guide/install.md")).expect("the guide");
    for words in ["gen man --all ", "rustup", "glibc 2."] {
        assert!(guide.contains(words), "docs/guide/install.md lacks `{words}`");
    }
}

/// Guards commands that take a recipe in one of two ways only: as a word and behind `--recipe` it is the same one.
#[test]
fn a_recipe_is_a_word_or_an_option() {
    let place = Place::with(&[]);
    for (before, after) in
        [("rig", "--json"), ("recipe show", ""), ("preview", "--out -"), ("", "--n 2 --out set --estimate --json")]
    {
        let run = |recipe: &str| place.command(&format!("{before} {recipe} {after}")).output().expect("it runs");
        let [word, option] = [run("tiny.yaml"), run("--recipe tiny.yaml")];
        assert!(word.status.success(), "gen {before} tiny.yaml {after}: {}", String::from_utf8_lossy(&word.stderr));
        if before.is_empty() {
            assert!(option.status.success(), "{before}");
        } else {
            assert_eq!(word.stdout, option.stdout, "gen {before}");
        }
    }
    place.done("tiny.yaml -n 1 --out word");
    place.done("--recipe tiny.yaml -n 1 --out option");
    assert_same(&place.tree("word"), &place.tree("option"), "the same dataset");
    for command in ["rig", "recipe show", "preview", "fit --real word", "cover"] {
        unusable(&place, command, &["which recipe?", "--recipe wood.yaml"]);
    }
}

/// Guards words that are near to something else: what is meant is named.
#[test]
fn what_was_meant_is_named() {
    let place = Place::with(&[]);
    unusable(&place, "valdate set", &["valdate", "did you mean `gen validate`?"]);
    unusable(&place, "--recipe tiny.yaml --samples 5", &["-n 5"]);
    unusable(&place, "tiny.yaml --count 5", &["-n 5"]);
    place.run("recipe show oak").refused(&["did you mean `species/oak`?"]);
    place.run("oak -n 1").refused(&["did you mean `species/oak`?"]);
    for (word, key) in [
        ("QE", "exposure.quantum_efficiency"),
        ("aperture", "camera.f_number"),
        ("bit_depth", "exposure.bits"),
        ("resolution", "scan.columns"),
        ("gain", "exposure.full_well_e"),
        ("species", "species/oak"),
    ] {
        for place_of in [word.to_owned(), format!("camera.{word}")] {
            place.run(&format!("rig tiny.yaml --set {place_of}=1")).refused(&[word, key]);
        }
    }
}
