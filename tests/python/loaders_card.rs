//! The dataset card: the hub reads it, its snippets and its command run, and it promises what the dataset holds.

use std::fs;

use crate::scripts::{datasets, example, first, python};
use dataset::read_exr;
use serde_json::{Value, json};
use test_support::program::{self, Place, assert_same, mesh_recipe};

/// The hub's own reader takes the card's front matter, and every file of `configs` is there.
#[test]
fn the_hub_reads_the_card() {
    for (place, _) in datasets() {
        let front = front_matter(&place, "set");
        assert_eq!(front["license"], "cc0-1.0");
        assert_eq!(front["annotations_creators"], json!(["machine-generated"]));
        assert_eq!(front["source_datasets"], json!(["original"]));
        assert_eq!(front["size_categories"], json!(["n<1K"]));
        assert_eq!(tasks(&front, "task_ids")[..2], ["semantic-segmentation", "instance-segmentation"]);
        for file in front["configs"][0]["data_files"].as_array().expect("a list") {
            let split = file["split"].as_str().expect("a name");
            assert_eq!(file["path"], json!(format!("data/{split}-*.parquet")));
            assert!(place.tree("set/data").keys().any(|name| name.starts_with(split)), "{split}");
        }
        let text = card(&place, "set");
        for part in ["## Loading", "## How it was made", "## Limits", "## Checking", "## Citing", "## License"] {
            assert!(text.contains(part), "{part}");
        }
    }
}

/// Every line of Python in the card runs as it stands, and gives the samples and the maps of one of them; images under
/// torch are what docs/guide/loading.md says.
#[test]
fn the_snippets_of_a_card_run() {
    let look = r#"
print("scans:", len(scans))
print("rows:", rows.height, rows.columns)
print("bright:", row["index"], maps["Y"].pixels.sum(dtype="float64"))
"#;
    let torch = r#"
pixels = scans.with_format("torch")[0]["range"]
print("torch:", pixels.dtype, pixels.ndim, int(pixels.float().max()))
"#;
    for (i, (place, samples)) in datasets().into_iter().enumerate() {
        let blocks = blocks(&card(&place, "set"), "python");
        assert_eq!(blocks.len(), 1);
        let script = blocks[0].replace("PATH", &place.path("set").to_string_lossy());
        // Importing torch takes seconds, and packs have the same images.
        let said =
            python(&place.path("."), &["-c", &[script.as_str(), look, if i == 0 { torch } else { "" }].concat()]);
        assert_eq!(said.code, 0, "{script}\n{}", said.err);
        let (_, sample) = first(&samples, &["train", "validation", "test"]);
        let count = samples.values().filter(|other| other.text("split") == sample.text("split")).count();
        assert_eq!(said.line("scans: "), count.to_string());
        let columns = "['id', 'index', 'class', 'objects', 'physics']";
        assert_eq!(said.line("rows: "), format!("{} {columns}", samples.len()));
        if i == 0 {
            let most = sample.image("range").2.into_iter().max().expect("pixels");
            assert_eq!(said.line("torch: "), format!("torch.uint16 3 {most}"));
        }
        // The first file by name.
        let (index, sample) = first(&samples, &["test", "train"]);
        let channels = read_exr(&sample.exr).expect("it is EXR").2;
        let bright = channels.iter().find(|channel| channel.name == "Y").expect("Y is there").numbers.clone();
        let total: f64 = bright.iter().map(|&v| f64::from(v)).sum();
        assert_eq!(said.numbers("bright: "), [index as f64, total]);
    }
}

/// Labels that the recipe leaves out are no task of the dataset, and images that are nowhere are named nowhere.
#[test]
fn a_card_promises_what_the_dataset_holds() {
    let maps = "exr: [range, reflectance, scatter, label, instance]";
    let png = "png: [range, reflectance, scatter, label]";
    let place = Place::new();
    let make = |name: &str, text: String| {
        place.write("tiny.yaml", text);
        place.make(name, "--n 2");
        let words = place.json(&format!("{name}/croissant.json"));
        let promises = words["description"].as_str().is_some_and(|text| text.contains("pixel-exact labels"));
        assert_eq!(promises, words["keywords"].as_array().is_some_and(|all| all.contains(&json!("segmentation"))));
        (front_matter(&place, name), card(&place, name), promises)
    };
    let truth = ["truth_maps: true", "truth_maps: false"];
    let wood = |png_has: &str, exr_has: &str| program::recipe(&[[png, png_has], [maps, exr_has], truth]);
    let ids = |front: &Value| tasks(front, "task_ids").join(" ");
    let [semantic, instance, sorts] =
        ["semantic-segmentation", "instance-segmentation", "multi-class-image-classification"];

    // As wood-train has it: classes of pixels, and no instances.
    let (front, text, labels) = make("labels", wood(png, "exr: []"));
    assert_eq!(ids(&front), format!("{semantic} {sorts}"));
    assert!(labels && text.contains("0 is missing in range, reflectance, scatter; background in label."), "{text}");
    // Boxes are in the tables whatever images there are.
    let (front, text, labels) = make("bright", wood("png: [reflectance]", "exr: []"));
    assert_eq!(tasks(&front, "task_categories"), ["object-detection", "image-classification"]);
    assert_eq!(ids(&front), sorts);
    assert!(
        !labels && text.contains("The reflectance image as") && text.contains("0 is missing in reflectance."),
        "{text}"
    );
    // Masks in EXR files are masks.
    let (front, _, labels) = make("masks", wood("png: [range]", "exr: [instance]"));
    assert_eq!((ids(&front), labels), (format!("{instance} {sorts}"), true));
    // Without any image, and the examples know.
    let (front, text, labels) = make("none", wood("png: []", "exr: []"));
    assert!(ids(&front) == sorts && !labels && text.contains("It was made without images: "), "{text}");
    let said = example(&place.path("."), "load_datasets", &place.path("none"), &[]);
    assert_eq!(said.line("images: "), "none in the tables; none in EXR files either");
    let set = place.path("none").to_string_lossy().into_owned();
    let told = python(&place.path("."), &["examples/load_openexr.py", &set]).err;
    assert!(told.contains("make it anew with output.exr") && !told.contains("PNG"), "{told}");
    // Nothing to tell apart, and no labels: no task at all.
    let lists = [
        ["png: [range, reflectance, scatter, label, instance]", "png: [range]"],
        ["exr: all", "exr: []\n  truth_maps: false"],
    ];
    let piece = mesh_recipe(&lists);
    let (front, _, _) = make("piece", piece);
    assert!(front.get("task_ids").is_none() && front.get("task_categories").is_none(), "{front}");
}

/// The card's command makes every file again: from the recipe in the card, or from the folder alone where the recipe
/// names a file, which is told to mlcroissant and in the words on licences.
#[test]
fn the_command_of_a_card_makes_the_dataset_again() {
    let place = Place::with(&[]);
    place.make("set", "--n 3 --samples-per-shard 2 --seed 7");
    let text = card(&place, "set");
    assert!(!text.contains("assets/"), "{text}");
    let yaml = blocks(&text, "yaml");
    place.write("recipe.yaml", &yaml[0]);
    again(&place, &text);

    let place = Place::new();
    place.write("tiny.yaml", mesh_recipe(&[["file: meshes/clip.obj", "file: my part.obj"]]));
    place.write("my part.obj", "v 0 0 0\nv 9 0 0\nv 9 8 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    place.make("set", "--n 3 --samples-per-shard 2 --seed 7");
    // Whoever is given the folder has neither.
    fs::remove_file(place.path("tiny.yaml")).expect("removed");
    fs::remove_file(place.path("my part.obj")).expect("removed");
    let text = card(&place, "set");
    assert!(text.contains("They keep the licences that they came with"), "{text}");
    again(&place, &text);
    let asset = &place.json("set/dataset.json")["assets"][0];
    let files = place.json("set/croissant.json")["distribution"].clone();
    let listed = files.as_array().expect("a list").iter().find(|file| file["contentUrl"] == asset["path"]);
    let listed = listed.expect("croissant.json lists the copy");
    assert_eq!(listed["sha256"], asset["sha256"]);
    assert!(listed["description"].as_str().is_some_and(|text| text.contains("licence")), "{listed}");
    let said = example(&place.path("."), "croissant", &place.path("set"), &[]);
    assert!(said.line("accepted: ").starts_with("0 errors, 0 warnings, version "), "{}", said.out);
}

/// Runs the card's command in the place of `set`.
fn again(place: &Place, card: &str) {
    let commands = blocks(card, "sh");
    let command = commands[0].replace("PATH", "set");
    place.done(command.trim().strip_prefix("gen ").expect("it is the program's"));
    assert_same(&place.tree("set"), &place.tree("again"), &command);
}

fn card(place: &Place, set: &str) -> String {
    fs::read_to_string(place.path(set).join("README.md")).expect("a card")
}

/// What stands between fences of a language.
fn blocks(card: &str, language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    let parts = card.split(&fence).skip(1);
    parts.map(|part| part.split_once("```").expect("the block ends").0.to_owned()).collect()
}

/// The card's front matter as the hub's own reader has it.
fn front_matter(place: &Place, set: &str) -> Value {
    let ask = "import sys, json; from huggingface_hub import DatasetCard; \
               print(json.dumps(DatasetCard.load(sys.argv[1]).data.to_dict()))";
    let card = place.path(set).join("README.md").to_string_lossy().into_owned();
    let said = python(&place.path("."), &["-c", ask, &card]);
    assert_eq!(said.code, 0, "{}", said.err);
    serde_json::from_str(&said.out).expect("it is JSON")
}

/// Names in a list of the front matter.
fn tasks<'a>(front: &'a Value, key: &str) -> Vec<&'a str> {
    let list = front[key].as_array().into_iter().flatten();
    list.map(|name| name.as_str().expect("a name")).collect()
}
