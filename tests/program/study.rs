//! Purpose: the studies write what they say, and bytes are stable. What they say is held by
//! crates/evidence/study/tests.

use test_support::program::{self, Place};

#[test]
#[ignore = "long"]
fn the_study_of_a_point_writes_table_json_and_picture() {
    let place = Place::new();
    let run = place.done("study point --photons 1000 --out here");
    for word in ["Clear wood", "Sound knot", "path", "kernel", "thesis", "1.5 mm across", "2.17", "67.5"] {
        assert!(run.out.contains(word), "no `{word}` in {}", run.out);
    }
    assert!(run.err.contains("point.json") && run.err.contains("point.png"), "{}", run.err);
    let json = place.json("here/point.json");
    // Five azimuths by four, and one by the conservative stencil.
    assert_eq!(json["cases"][0]["spots"].as_array().expect("spots").len(), 21);
    let picture = image::open(place.path("here/point.png")).expect("a picture");
    assert!(picture.width() > 900 && picture.height() > 900, "{} x {}", picture.width(), picture.height());
}

#[test]
fn the_study_of_lines_writes_table_json_and_picture() {
    let place = Place::new();
    let run = place.done("study transport --photons 1000 --out here --threads 1");
    for word in ["clear along motion", "wet", "S(1,8)", "S(7,5)", "asymmetry", "diffusion", "kernel within its bars"] {
        assert!(run.out.contains(word), "no `{word}` in {}", run.out);
    }
    let json = place.json("here/transport.json");
    let media = json["media"].as_array().expect("media");
    assert_eq!(media.len(), 15);
    for medium in media {
        let path = &medium["models"][0];
        assert!(path["reflectance"]["error"].as_f64().expect("an error") > 0.0, "{medium}");
        assert_eq!(path["line"].as_array().expect("rows").len(), 41);
        let kernel = &medium["models"][2];
        let off =
            kernel["reflectance"]["value"].as_f64().expect("R") - path["reflectance"]["value"].as_f64().expect("R");
        // A thousand photons leave 0.016: it is within the bar or nobody can tell.
        assert!(off.abs() < 0.08 && medium["kernel_marks"]["reflectance"] != "ok", "{off} {}", medium["kernel_marks"]);
    }
    let picture = image::open(place.path("here/transport.png")).expect("a picture");
    assert!(picture.width() > 1000 && picture.height() > 1000);
    place.done("study transport --photons 1000 --out there --threads 2");
    program::assert_same(&place.tree("here"), &place.tree("there"), "threads");
}

#[test]
#[ignore = "long"]
fn a_profile_of_a_board_is_asked_of_every_model() {
    let place = Place::new();
    let run = place.done("study profile --recipe wood-small.yaml --index 15 --photons 8000 --out here");
    assert!(run.out.contains("Profile 128 of sample 15 (rot)"), "{}", run.out);
    let json = place.json("here/profile.json");
    let models = json["models"].as_array().expect("models");
    let names: Vec<_> = models.iter().map(|model| model["model"].as_str().expect("a name")).collect();
    assert_eq!(names, ["path", "diffusion", "kernel", "thesis"]);
    let middle = |model: usize, what: &str| models[model]["scatter_e"][16][what].as_f64().expect("a number");
    assert!(middle(0, "error") > 0.0, "the reference says how sure it is");
    // Eight thousand photons over 230 columns leave some 15 % a bin; models are farther apart than that.
    assert!(
        (middle(2, "value") / middle(0, "value") - 1.0).abs() < 0.6 && middle(3, "value") > 1.5 * middle(2, "value")
    );
    assert!(image::open(place.path("here/profile.png")).expect("a picture").width() > 1000);
    let beyond = place.run("study profile --recipe wood-small.yaml --profile 256 --out here");
    assert!(beyond.code == 1 && beyond.err.contains("--profile 0 to 255"), "{}", beyond.err);
}

#[test]
fn studies_say_where_they_cannot_write() {
    let place = Place::new();
    place.write("file", "");
    let run = place.run("study point --photons 128 --out file");
    assert_eq!((run.code, run.out.as_str()), (1, ""));
    assert!(run.err.contains("cannot make file") && run.err.contains("--out"), "{}", run.err);
    assert_eq!(place.run("study lines").code, 2);
    assert!(place.done("study --help").out.contains("point"));
}

/// What crates/evidence/study/tests/figures.rs holds is printed, drawn and written, the same on any number of threads.
#[test]
fn a_study_of_the_instrument_is_the_same_on_any_number_of_threads() {
    let place = Place::new();
    let run = place.done("study sensor --repeats 2 --out here --threads 1");
    assert!(run.out.contains("measured") && run.out.contains("figures hold"), "{}", run.out);
    assert!(image::open(place.path("here/sensor.png")).expect("a picture").width() > 1000);
    assert!(place.json("here/sensor.json")["figures"].as_array().expect("figures").len() > 10);
    place.done("study sensor --repeats 2 --out there --threads 2");
    program::assert_same(&place.tree("here"), &place.tree("there"), "threads");
    assert_eq!(place.run("study sensor --repeats 1").code, 2);
    for study in ["triangulation", "sensor", "speckle", "laser"] {
        assert!(place.done(&format!("study {study} --help")).out.contains("Examples:"), "{study}");
    }
}

/// Packs with one defect each: the pocket concerned tells by its Scatter, through clear film by Range, and is outlined.
#[test]
#[ignore = "long"]
fn the_study_of_packs_shows_each_defect() {
    let place = Place::new();
    let run = place.done("study packs --out here --threads 2");
    let json = place.json("here/packs.json");
    let packs = json["packs"].as_array().expect("a list");
    // A line for each, and two of heads.
    assert!(packs.len() >= 24);
    assert_eq!(run.out.lines().count(), packs.len() + 2);
    let pack = |name: &str| packs.iter().find(|pack| pack["name"] == name).unwrap_or_else(|| panic!("no {name}"));
    let told = |name: &str, of: &str| {
        let pack = pack(name);
        [&pack["concerned"][of], &pack["others"][of]].map(|value| value.as_f64().unwrap_or(f64::NAN))
    };
    assert_eq!(pack("sound")["defects"].as_array().map(Vec::len), Some(0));
    for pack in packs.iter().filter(|pack| pack["name"] != "sound") {
        assert!(pack["defects"].as_array().is_some_and(|defects| !defects.is_empty()), "{pack}");
    }
    let [empty, filled] = told("missing", "scatter_dn");
    assert!(empty < 0.85 * filled, "{empty} of {filled}");
    let [range, other] = told("missing", "range_mm");
    assert!((range - other).abs() < 0.1, "{range} and {other}");
    let [range, other] = told("missing, clear film", "range_mm");
    assert!(range < 0.3 && other > 1.0, "{range} and {other} through clear film");
    let picture = image::open(place.path("here/packs.png")).expect("a PNG").to_rgb8();
    let outlined = picture.pixels().filter(|pixel| pixel.0 == [255, 60, 40]).count();
    assert!(outlined > 2000, "{outlined} pixels of outlines");
    let refused = place.run("study packs --recipe wood-small --out here");
    assert!(refused.code != 0 && refused.err.contains("about wood"), "{}", refused.err);
}
