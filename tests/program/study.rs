//! Purpose: the studies write what they say, the ellipses of clear wood lie along the fibre, the instrument is as theory has it,
//! and bytes are stable.

use reference::model::Model;
use reference::path::Effort;
use study::compared_model::ComparedModel;
use reference::media::{CLEAR_WOOD, SOUND_KNOT, WoodMedium};
use study::point::{PHOTONS, contour};
use test_support::program::{self, Place};

/// The judge and the kernel find the fibre's azimuth on clear wood within 1.6 degrees at 1.5 mm, for azimuths of 0 to 90.
///
/// The judge walks a tenth of the study's photons, so its error is three times that of the study; the bar is some four of
/// its standard errors, twelve of the study's.
#[test]
fn ellipses_lie_along_the_fibre() {
    let effort = Effort { photons: PHOTONS / 10, seed: 0 };
    let few = [0.0, 37.0, 90.0].as_slice();
    let many: Vec<f64> = (0..=12).map(|i| 7.5 * f64::from(i)).collect();
    for (model, azimuths) in [(Model::Path, few), (Model::Kernel, &many)] {
        for &azimuth in azimuths {
            let light = ComparedModel::Model(model)
                .point_light(&CLEAR_WOOD.turned(azimuth), effort, &|_| ())
                .expect("it answers");
            let far = contour(&light, azimuth, 1.5).expect("an ellipse");
            println!("{} {azimuth}: {:?} {:?}", model.name(), far.aspect, far.misalignment);
            assert!(far.misalignment.value.abs() < 1.6, "{} at {azimuth}: {:?}", model.name(), far.misalignment);
            assert!(far.misalignment.error < 0.5, "{} at {azimuth}: {:?}", model.name(), far.misalignment);
            // The Monte Carlo of docs/physics.md found 2.17, the closed form 2.13.
            assert!((far.aspect.value / 2.17 - 1.0).abs() < 0.08, "{} at {azimuth}: {:?}", model.name(), far.aspect);
        }
    }
}

/// The thesis' method lies along the fibre where pixels do; between, its neighbours pull it to the diagonal, alike from both
/// sides. Its knot is round. The symmetric stencil follows the fibre within half a degree.
#[test]
fn pictures_of_the_thesis_are_pulled_to_the_diagonal() {
    let far = |by: ComparedModel, wood: &WoodMedium| {
        let light = by.point_light(wood, Effort { photons: 1, seed: 0 }, &|_| ()).expect("it answers");
        contour(&light, wood.azimuth, 1.5).expect("an ellipse")
    };
    let thesis = [0.0, 22.5, 45.0, 67.5, 90.0].map(|azimuth| far(ComparedModel::Thesis, &CLEAR_WOOD.turned(azimuth)));
    println!("{:?}", thesis.map(|found| (found.aspect.value, found.misalignment.value)));
    for straight in [0, 2, 4] {
        assert!(thesis[straight].misalignment.value.abs() < 1.0, "{:?}", thesis[straight].misalignment);
    }
    let [up, down] = [thesis[1].misalignment.value, -thesis[3].misalignment.value];
    assert!((8.0..12.0).contains(&up) && (8.0..12.0).contains(&down), "{up} {down}");
    let round = far(ComparedModel::Thesis, &SOUND_KNOT).aspect.value;
    assert!((round - 1.0).abs() < 0.05, "{round}");
    let kept = far(ComparedModel::Conservative, &CLEAR_WOOD.turned(22.5));
    println!("{round} {kept:?}");
    assert!(kept.misalignment.value.abs() < 0.5, "{:?}", kept.misalignment);
}

#[test]
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
fn a_profile_of_a_board_is_asked_of_every_model() {
    let place = Place::new();
    let run = place.done("study profile --recipe wood-small.yaml --index 15 --photons 8000 --out here");
    assert!(run.out.contains("Profile 128 of sample 15 (rot)"), "{}", run.out);
    let json = place.json("here/profile.json");
    let models = json["models"].as_array().expect("models");
    let names: Vec<_> = models.iter().map(|model| model["model"].as_str().expect("a name")).collect();
    assert_eq!(names, ["path", "diffusion", "kernel", "thesis"]);
    let middle = |model: usize, what: &str| models[model]["scatter_e"][16][what].as_f64().expect("a number");
    assert!(middle(0, "error") > 0.0, "the judge says how sure it is");
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

/// Figures of a study of the instrument that do not hold, other than those that are known not to (`known`).
fn off(study: &str, repeats: usize, known: &[&str]) -> Vec<String> {
    let place = Place::new();
    let run = place.done(&format!("study {study} --repeats {repeats} --out here/page.png"));
    println!("{}", run.out);
    assert!(run.out.contains("measured") && run.out.contains("figures hold"), "{}", run.out);
    assert!(image::open(place.path("here/page.png")).expect("a picture").width() > 1000);
    let json = place.json("here/page.json");
    let figures = json["figures"].as_array().expect("figures");
    assert!(figures.len() > 10, "{} figures", figures.len());
    let name = |figure: &serde_json::Value| figure["name"].as_str().expect("a name").to_owned();
    let off = figures.iter().filter(|figure| figure["holds"] == false).map(name);
    off.filter(|name| !known.iter().any(|known| name.contains(known))).collect()
}

/// Every figure within what chance does at alpha = 0.01 for the whole table.
#[test]
fn the_sensor_is_as_theory_has_it() {
    assert_eq!(off("sensor", 8, &[]), [""; 0]);
}

#[test]
fn triangulation_is_as_theory_has_it() {
    assert_eq!(off("triangulation", 6, &[]), [""; 0]);
}

/// At d = 820 mm the line is so narrow that rows sample it unevenly; docs/instrument.md.
#[test]
fn the_laser_is_as_theory_has_it() {
    assert_eq!(off("laser", 6, &["d = 820 mm"]), [""; 0]);
}

#[test]
fn speckle_is_as_theory_has_it() {
    assert_eq!(off("speckle", 4, &[]), [""; 0]);
}

#[test]
fn a_study_of_the_instrument_is_the_same_on_any_number_of_threads() {
    let place = Place::new();
    place.done("study sensor --repeats 2 --out here --threads 1");
    place.done("study sensor --repeats 2 --out there --threads 2");
    program::assert_same(&place.tree("here"), &place.tree("there"), "threads");
    assert_eq!(place.run("study sensor --repeats 1").code, 2);
    for study in ["triangulation", "sensor", "speckle", "laser"] {
        assert!(place.done(&format!("study {study} --help")).out.contains("Examples:"), "{study}");
    }
}

/// Packs with one defect each: the pocket concerned tells by its Scatter, through clear film by Range, and is outlined.
#[test]
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
