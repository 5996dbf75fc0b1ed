//! `gen compare`, `gen icon` and `gen export icon` as their users run them.

use serde_json::Value;
use test_support::program::{self, Place};
use tools::icon::{Content, PlaneContent, PlaneNumbers, open};

/// A dataset of three samples, EXR and PNG, with sensor frames.
fn planks() -> Place {
    let place = Place::with(&[program::FRAMES, program::SPECKLE]);
    let run = place.run("--recipe tiny.yaml --n 3 --out planks");
    assert_eq!(run.code, 0, "{}", run.err);
    place
}

fn json(place: &Place, arguments: &str) -> Value {
    let run = place.run(arguments);
    assert_eq!((run.code, run.err.as_str()), (0, ""), "gen {arguments}");
    serde_json::from_str(&run.out).expect("it prints JSON")
}

fn json_of(text: &str) -> Value {
    serde_json::from_str(text).expect("it prints JSON")
}

/// A dataset against itself lies nowhere apart; against other samples of its own it has other numbers, and every one of
/// them is there.
#[test]
fn a_dataset_is_like_itself() {
    let place = planks();
    let both = json(&place, "compare planks planks --json");
    for name in ["range_noise_um", "reflectance_dn", "speckle_contrast", "line_width_px"] {
        let found = &both["distances"][name];
        assert_eq!((found["ks"].as_f64(), found["wasserstein"].as_f64()), (Some(0.0), Some(0.0)), "{name}: {found}");
    }
    assert_eq!(both["sim"], both["real"]);
    assert_eq!((both["sim"]["scans"].as_u64(), both["sim"]["columns"].as_u64()), (Some(3), Some(64)));
    let one = json(&place, "compare planks planks --json --scans 1");
    assert_eq!(one["sim"]["scans"].as_u64(), Some(1));
    assert_ne!(one["sim"]["heights_mm"], both["sim"]["heights_mm"]);
    // The recipe's threshold is 20 DN, which only the conveyor is near.
    let whole = json(&place, "compare planks planks --json --whole");
    assert!(whole["sim"]["least_reflectance_dn"].as_f64().is_some_and(|dn| (20.0..40.0).contains(&dn)));
    assert!(both["sim"]["line_width_px"]["p50"].as_f64().is_some_and(|px| (1.0..30.0).contains(&px)));
}

/// The conveyor of a dataset does not count: three boards have the noise of their wood, whichever files their maps are
/// in, and so has a region or a mask of it, on either side. All of the scan has four times as much, as two thirds of it
/// are conveyor. The whole kind: statistics of a side are those of its object, and what counts is said.
#[test]
fn the_object_alone_counts() {
    let place = Place::new();
    let narrow = "--recipe wood-small --set board.width_mm=8 --set output.truth_maps=false --quiet";
    place.done(&format!("{narrow} --n 3 --out boards"));
    place.done(&format!("{narrow} --n 3 --seed 5 --out rows --set output.exr=[]"));
    let noise = |side: &Value| side["range_noise_um"]["along"].as_f64().expect("there is noise");
    let both = json(&place, "compare boards rows --json");
    for side in ["sim", "real"] {
        assert!((11.0..25.0).contains(&noise(&both[side])), "{side}: {}", both[side]["range_noise_um"]);
        assert_eq!(both[side]["part"], "object");
    }
    let whole = json(&place, "compare boards boards --json --whole");
    assert!(noise(&whole["sim"]) > 50.0 && whole["sim"]["part"] == "all", "{}", whole["sim"]["range_noise_um"]);
    // A region of the object's middle alone is nearly the same wood, of all pixels too.
    let region = json(&place, "compare boards boards --json --whole --region 96,96,64,64");
    assert_eq!((&region["sim"], &region["real"]["part"]), (&whole["sim"], &"region".into()));
    assert!((11.0..25.0).contains(&noise(&region["real"])), "{}", region["real"]["range_noise_um"]);
    assert_eq!((&region["real"]["columns"], &region["real"]["profiles"]), (&64.into(), &64.into()));
    let sim = json(&place, "compare boards boards --json --whole --sim-region 96,96,64,64");
    assert_eq!((&sim["sim"]["range_noise_um"], &sim["real"]), (&region["real"]["range_noise_um"], &whole["real"]));
    // A mask of the same pixels: nothing else counts, so nothing else is measured or missing.
    let inside = |i: u32| (96..160).contains(&(i % 256)) && (96..160).contains(&(i / 256));
    let grey = |i| if inside(i) { 255 } else { 0 };
    let mask = image::GrayImage::from_raw(256, 256, (0..256 * 256).map(grey).collect()).expect("its size");
    mask.save(place.path("mask.png")).expect("the folder is ours");
    let masked = json(&place, "compare boards boards --json --whole --mask mask.png");
    assert_eq!(masked["sim"], whole["sim"]);
    for key in ["missing_share", "saturated_share", "least_reflectance_dn", "heights_mm"] {
        assert_eq!(masked["real"][key], region["real"][key], "{key}");
    }
    let table = place.done("compare boards boards --region 0,0,256,200").out;
    assert!(table.contains("pixels that count") && table.contains("object in region"), "{table}");
    // Without labels it is said.
    place.done(&format!("{narrow} --n 1 --out bare --set output.png=[range,reflectance] --set output.exr=[]"));
    let bare = place.done("compare bare boards --json").out;
    assert!(bare.contains("all: it has no labels"), "{bare}");
    for (arguments, words) in [
        ("--region 1,1", "LEFT,TOP,COLUMNS,PROFILES"),
        ("--region 200,0,64,64", "reaches beyond its 256 columns"),
        ("--region 0,0,18446744073709551615,64", "reaches beyond its 256 columns"),
        ("--mask boards/dataset.json", "no PNG"),
        ("--region 0,0,20,20", "part of it that counts"),
    ] {
        let run = place.run(&format!("compare boards boards {arguments}"));
        assert!(run.code != 0 && run.err.contains(words), "{arguments}: '{words}' is not in: {}", run.err);
    }
}

/// A sample as EXR, as images of its row, and as files of the camera has the same statistics but for rounding.
#[test]
fn formats_agree() {
    let place = planks();
    let run = place.run("export icon planks --index 2 --out plank");
    assert_eq!(run.code, 0, "{}", run.err);
    assert_eq!(place.run("export icon planks --index 2 --out steps --words").code, 0);
    assert!(place.run("icon steps/00000002.xml").out.contains("Range WORD"));
    let folder = std::fs::read_dir(place.path("planks/exr/00000")).expect("EXR files are there");
    let named = |path: &std::path::Path| {
        let bytes = std::fs::read(path).expect("it can be read");
        let text = dataset::read_exr(&bytes).expect("it is whole").3;
        serde_json::from_str::<Value>(&text).expect("it is JSON")["index"] == 2
    };
    let exr = folder.flatten().map(|entry| entry.path()).find(|path| named(path)).expect("sample 2 is there");
    std::fs::copy(exr, place.path("plank.exr")).expect("the folder is ours");
    let same = json(&place, "compare plank.exr plank/00000002.xml --json");
    for key in ["missing_share", "saturated_share", "range_noise_um", "speckle_contrast"] {
        assert_eq!(same["sim"][key], same["real"][key], "{key}");
    }
    // A height of exactly 0 is stored as the least number above it, as 0 means missing there: at most the last digits
    // of where noise ends change.
    for way in ["along", "across"] {
        let at = |side: &str| same[side]["range_noise_correlation"][way].as_array().cloned().expect("a list");
        for (a, b) in at("sim").iter().zip(&at("real")) {
            let (a, b) = (a.as_f64().expect("a number"), b.as_f64().expect("a number"));
            assert!((a - b).abs() < 1e-4, "{way}: {a} and {b}");
        }
    }
    let heights = |name: &str| {
        let name = format!("{name}/00000002");
        let Ok(Content::Scan(mut reader)) = open(&place.path(&name)) else { panic!("{name} is no scan") };
        reader.read(0, 48).expect("it is whole").heights()
    };
    let alike = |name: &str, error: f64| {
        for (a, b) in heights("plank").iter().zip(heights(name)) {
            assert!(a.is_nan() && b.is_nan() || (a - b).abs() <= error, "{name}: {a} and {b} mm");
        }
    };
    // Half of 1/65534 of less than 30 mm.
    alike("steps", 30.0 / 65534.0 / 2.0);
    // Without EXR the images of the row are taken: range in steps, reflectance in whole numbers.
    let other = Place::with(&[
        program::SPECKLE,
        ["exr: [range, reflectance, scatter, label, instance]", "exr: []"],
        ["truth_maps: true", "truth_maps: false"],
    ]);
    assert_eq!(other.run("--recipe tiny.yaml --n 3 --out planks").code, 0);
    assert_eq!(other.run("export icon planks --index 2 --out rows").code, 0);
    std::fs::create_dir(place.path("rows")).expect("the folder is ours");
    for side in ["rows/00000002.xml", "rows/00000002.dat"] {
        std::fs::copy(other.path(side), place.path(side)).expect("the folder is ours");
    }
    // Half of 1/32766 of all heights that the sensor can see, less than 250 mm.
    alike("rows", 250.0 / 32766.0 / 2.0);
    let rows = json(&place, "compare plank.exr rows/00000002.xml --json");
    for key in ["missing_share", "saturated_share", "least_reflectance_dn"] {
        assert_eq!(rows["sim"][key], rows["real"][key], "{key}");
    }
}

/// A scan of a Ruler, as its tools write it: a plane of places along the line beside that of heights, a plane that
/// nobody knows, another component, and marks.
fn ruler(place: &Place, name: &str, kind: &str) {
    let (cols, rows) = (240, 60);
    let bytes = if kind == "FLOAT" { 4 } else { 2 };
    let plane = |name: &str, kind: &str, bytes: usize, width: usize| {
        let size = bytes * width;
        format!(
            "<subcomponent valuetype=\"{kind}\" name=\"{name}\"><parameter name=\"size\">{size}</parameter>\
             <parameter name=\"width\">{width}</parameter></subcomponent>"
        )
    };
    let planes = [
        plane("Range X", kind, bytes, cols),
        plane("Range R", "FLOAT", 4, cols),
        plane("Intensity", "BYTE", 1, cols),
        plane("Temperature", "WORD", 2, 3),
        plane("Mark", "INT", 4, 5),
    ];
    let size = cols * (bytes + 5) + 6 + 20 + 7;
    let xml = format!(
        "<icon_data_format><parameter name=\"size\">{size}</parameter><parameter name=\"version\">1</parameter>\
         <parameter name=\"layout\">SUBCOMPONENT</parameter><component name=\"Ranger3Range\"><worldrangetraits>\
         <parameter name=\"lower bound x\">0</parameter><parameter name=\"lower bound R\">0</parameter>\
         <parameter name=\"upper bound x\">422.4</parameter><parameter name=\"upper bound \
         R\">200</parameter></worldrangetraits>\
         {}</component><component name=\"Gray\">{}</component></icon_data_format>",
        planes.concat(),
        plane("Grey", "BYTE", 1, 7)
    );
    place.write(&format!("{name}.xml"), xml);
    // Columns stand 0.59, 0.49 and 0.69 mm apart on a slope, under noise of 12 um.
    let x = |i: usize| 150.0 + 0.59 * (i % cols) as f64 - if i % cols % 3 == 2 { 0.1 } else { 0.0 };
    let mut state = 7_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31)
    };
    // Nearly: the sum of twelve has a variance of 1.
    let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
    let mut data = Vec::new();
    let is_missing = |i: usize| i.is_multiple_of(101);
    for i in 0..cols * rows {
        let place = if is_missing(i) { 0.0 } else { x(i) };
        data.extend_from_slice(&(place as f32).to_le_bytes()[4 - bytes..]);
    }
    for i in 0..cols * rows {
        let z = if is_missing(i) { 0.0 } else { 0.5 * x(i) + 0.012 * normal() };
        data.extend((z as f32).to_le_bytes());
    }
    data.extend(vec![90; cols * rows]);
    data.extend(vec![1; (6 + 20 + 7) * rows]);
    place.write(&format!("{name}.dat"), data);
}

/// Places along the line of a Ruler's file are read: pitch and noise are those of the places, not of columns in the
/// bounds of the scan. The whole kind: whatever a file of the camera holds beside what is used is named.
#[test]
fn places_along_the_line_are_read() {
    let place = Place::new();
    ruler(&place, "ruler", "FLOAT");
    let side = json(&place, "compare ruler.xml ruler.dat --json")["real"].clone();
    let number = |value: &Value| value.as_f64().expect("a number");
    assert!((number(&side["pitch_mm"]["along"]) - 0.59).abs() < 1e-3, "{}", side["pitch_mm"]);
    // 4600 second differences: a standard error of 1.167 / sqrt(4600), alpha 1e-4. By columns the slope makes it four
    // times as much.
    let noise = number(&side["range_noise_um"]["along"]);
    assert!((noise / 12.0 - 1.0).abs() < 3.9 * 0.0172, "{noise} um");
    assert_eq!(side["unused"], serde_json::json!(["Temperature WORD", "Grey BYTE", "Mark INT"]));
    let table = place.done("compare ruler.xml ruler.xml --region 10,0,200,60").out;
    assert!(table.contains("not used of ruler.xml: Temperature WORD, Grey BYTE, Mark INT\n"), "{table}");
    assert!(table.contains("0.5900, -"), "{table}");
    let told = place.done("icon ruler.xml").out;
    for words in
        ["Range X FLOAT, Range FLOAT, Intensity BYTE, Mark", "0.58999", "not read: Temperature WORD, Grey BYTE\n"]
    {
        assert!(told.contains(words), "'{words}' is not in: {told}");
    }
    let scan = json_of(&place.done("icon ruler.xml --json").out);
    assert!((number(&scan["x_mm"][0]) - 150.0).abs() < 0.7 && (number(&scan["col_mm"]) - 0.59).abs() < 1e-3, "{scan}");
    assert_eq!(scan["unused"], serde_json::json!(["Temperature WORD", "Grey BYTE"]));
    // Places of a type that nothing explains are named, and not guessed.
    ruler(&place, "words", "WORD");
    let side = json(&place, "compare words.xml words.xml --json")["sim"].clone();
    assert_eq!(side["unused"][0], "Range X WORD");
    assert!((number(&side["pitch_mm"]["along"]) - 1.76).abs() < 1e-9, "{}", side["pitch_mm"]);
}

/// What is exported says what it is; heights, reflectance and scatter are the sample's own, and a sensor frame is a
/// whole exposure.
#[test]
fn samples_become_files_of_the_camera() {
    let place = planks();
    assert_eq!(place.run("export icon planks --index 1 --out plank").code, 0);
    let told = place.run("icon plank/00000001.xml");
    for words in ["64 columns x 48 profiles", "Range FLOAT, Reflectance BYTE, Scatter WORD", "between profiles 0.0"] {
        assert!(told.out.contains(words), "'{words}' is not in: {}", told.out);
    }
    let Ok(Content::Scan(mut reader)) = open(&place.path("plank/00000001")) else { panic!("it is no scan") };
    let scan = reader.read(0, 48).expect("it is whole");
    let missing: Vec<bool> = scan.heights().iter().map(|z| z.is_nan()).collect();
    let dark: Vec<bool> = scan.light_dn().expect("it has light").iter().map(|dn| *dn == 0).collect();
    let range = scan.plane(PlaneContent::Range);
    assert!(matches!(range, Some(PlaneNumbers::Float(_))) && missing == dark && missing.contains(&false));
    assert_eq!(place.run("export icon planks --index 1 --out frame --sensor").code, 0);
    let Ok(Content::Image(image)) = open(&place.path("frame/00000001.xml")) else { panic!("it is no image") };
    // Of the profiles 0, 16 and 32 that were kept the middle one: as bright as its reflectance.
    let light = scan.light_dn().expect("it has light");
    assert_eq!((image.cols, image.dn.iter().max()), (64, light[16 * 64..17 * 64].iter().max()));
}

/// What `gen icon` and `gen export` say is there for programs too: the same numbers.
#[test]
fn documents_tell_what_words_tell() {
    let place = planks();
    let run = place.run("export icon planks --index 1 --out plank --json");
    let made = json_of(&run.out);
    let bytes: u64 =
        place.tree("plank").iter().filter(|(name, _)| *name != "export.json").map(|(_, b)| b.len() as u64).sum();
    assert_eq!((&made["format"], &made["samples"], &made["out"]), (&"icon".into(), &1.into(), &"plank".into()));
    assert_eq!(made["nothing_to_do"], Value::Bool(false));
    assert!(made["files"].as_u64().is_some_and(|files| files >= 2), "{made}");
    assert!(made["bytes"].as_u64().is_some_and(|told| told >= bytes), "{made} and {bytes} bytes");
    assert!(run.err.contains(&format!("{} files of 1 sample", made["files"])), "{}", run.err);
    let again = json_of(&place.done("export icon planks --index 1 --out plank --json").out);
    assert_eq!((&again["nothing_to_do"], &again["files"]), (&Value::Bool(true), &Value::Null));
    let told = place.done("icon plank/00000001.xml").out;
    let scan = json_of(&place.done("icon plank/00000001.xml --json").out);
    assert_eq!((&scan["content"], &scan["columns"], &scan["profiles"]), (&"scan".into(), &64.into(), &48.into()));
    assert_eq!(scan["planes"][0], "Range FLOAT");
    let percent = |key: &str| format!("{:.2} %", 100.0 * scan[key].as_f64().expect("a share"));
    assert!(told.contains(&format!("missing {}, saturated {}", percent("missing_share"), percent("saturated_share"))));
    let [low, high] = [0, 1].map(|i| scan["range_mm"][i].as_f64().expect("a height"));
    assert!(told.contains(&format!("Range {low:.4} to {high:.4} mm")), "{told}{scan}");
    assert!(scan["calibrated"] == Value::Bool(true) && scan["row_mm"].is_f64() && scan["encoder"].is_array(), "{scan}");
    place.done("export icon planks --index 1 --out frame --sensor");
    let image = json_of(&place.done("icon frame/00000001.xml --json").out);
    assert_eq!((&image["content"], &image["columns"]), (&"sensor_image".into(), &64.into()));
    let brightest = format!("brightest {} DN", image["brightest_dn"]);
    assert!(place.done("icon frame/00000001.xml").out.contains(&brightest), "{image}");
}

/// The page of plots is a picture, and with it or not, nothing but the table is said when nobody sits there.
#[test]
fn the_page_is_a_picture() {
    let place = planks();
    let run = place.run("compare planks planks --out page.png");
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    assert!(run.out.contains("range noise, along the line [um]") && run.out.contains("Wasserstein-1"), "{}", run.out);
    let page = image::open(place.path("page.png")).expect("it is a picture");
    assert!(page.width() > 1000 && page.height() > 700);
}

/// Files of any other kind are told as such, with a list of what can be read, on either side and by `gen fit` too; the
/// list is of kinds that are read: each is refused for another reason.
#[test]
fn what_can_be_read_is_listed() {
    let place = Place::with(&[]);
    let all = "give a dataset, a folder of scans, or a scan (.exr, .xml with .dat, .json, .png, .tif, .tiff, .csv, \
        .tsv, .txt, .asc, \
               .xyz, .ply)";
    for name in ["q.bmp", "q.npy", "q.pcd", "q.jpg", "q.BMP", "q.yaml", "q", "q.bmp.old"] {
        place.write(name, "nothing");
        for arguments in
            [format!("compare {name} {name}"), format!("fit --recipe tiny.yaml --real {name} --out a.yaml")]
        {
            let run = place.run(&arguments);
            assert!(run.code == 1 && run.err.contains(all), "gen {arguments}: {}", run.err);
            assert!(run.err.contains(name) && !run.err.contains(".xml:"), "gen {arguments}: {}", run.err);
        }
    }
    let recipe = place.run("compare tiny.yaml q.bmp");
    assert!(recipe.err.contains("gen --recipe FILE --out DIR"), "{}", recipe.err);
    let listed = all.split_once("a scan (").expect("it lists").1.trim_end_matches(')').split(", ");
    for ending in listed.map(|words| words.split(' ').next().expect("an ending")) {
        for name in [format!("a{ending}"), format!("a{}", ending.to_uppercase())] {
            place.write(&name, "x x x\nx x x\n");
            let run = place.run(&format!("compare {name} {name}"));
            assert!(run.code == 1 && !run.err.contains("are not read"), "{name}: {}", run.err);
        }
    }
}

/// Whatever cannot be used is told with its place and a remedy, and nothing is left behind.
#[test]
fn faults_name_the_remedy() {
    let place = planks();
    place.write("no.json", "{}");
    place.write("no.exr", "nothing");
    std::fs::create_dir(place.path("empty")).expect("the folder is ours");
    for (arguments, words) in [
        ("compare nowhere planks", "it is not there; name a dataset"),
        ("compare planks empty", "no scan (.exr, .xml with .dat, .json, .png, .tif, .tiff, .csv, .ply)"),
        ("compare planks no.json", "docs/guide/compare.md"),
        ("compare planks no.exr", "copy it again"),
        ("compare planks planks --out nowhere/page.png", "there is no folder nowhere"),
        ("compare planks planks --scans 0", "0 is not in"),
        ("icon planks", "gen export icon planks --index 0 --out OUT"),
        ("export icon planks --index 3 --out a", "give --index 0 to 2"),
        ("export icon empty --index 0 --out a", "holds no dataset.json"),
        ("icon nothing.xml", "side by side"),
        ("export icon planks --index 1 --out planks", "choose a folder elsewhere"),
    ] {
        let run = place.run(arguments);
        assert!(run.code != 0 && run.err.contains(words), "gen {arguments}: '{words}' is not in: {}", run.err);
        assert_eq!(run.out, "", "gen {arguments}");
    }
    let without = Place::with(&[]);
    assert_eq!(without.run("--recipe tiny.yaml --n 1 --out planks").code, 0);
    let run = without.run("export icon planks --index 0 --out a --sensor");
    assert!(run.code != 0 && run.err.contains("sensor_stack"), "{}", run.err);
    assert!(!without.path("a").exists());
}
