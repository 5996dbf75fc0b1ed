//! A recipe that names a file: the dataset keeps a copy, is checked and continued by it, and refuses another content.

use std::fs;

use image::{GrayImage, Luma};
use test_support::program::{Place, assert_same, mesh_recipe, slices_recipe};

const BOX: &str = "v 0 0 0\nv 9 0 0\nv 9 8 0\nv 0 8 0\nv 0 0 3\nv 9 0 3\nv 9 8 3\nv 0 8 3\n\
                   f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

fn place() -> Place {
    let place = Place::new();
    let recipe = mesh_recipe(&[["file: meshes/clip.obj", "file: parts/my box.obj"]]);
    fs::create_dir(place.path("parts")).expect("a folder");
    place.write("tiny.yaml", recipe);
    place.write("parts/my box.obj", BOX);
    place
}

#[test]
fn a_dataset_stands_alone() {
    let place = place();
    place.make("whole", "--n 4 --samples-per-shard 2");
    place.make("set", "--n 2 --samples-per-shard 2");
    let head = place.json("set/dataset.json");
    let asset = &head["assets"][0];
    let path = asset["path"].as_str().expect("a path");
    assert!(path.starts_with("assets/") && path.ends_with("-my_box.obj"), "{path}");
    assert_eq!(fs::read_to_string(place.path("set").join(path)).expect("a copy"), BOX);
    assert_eq!(head["recipe"]["canonical"]["mesh"]["file"]["sha256"], asset["sha256"]);

    // Without the recipe and its file: rendered again, continued, looked at.
    fs::remove_dir_all(place.path("parts")).expect("removed");
    let clean = place.done("validate set --rerender 2");
    assert!(clean.out.contains("2 rendered again") && clean.out.contains("0 faults"), "{}", clean.out);
    place.done("preview --recipe set --out part.png");
    place.done("--recipe set --out set --n 4");
    assert_same(&place.tree("whole"), &place.tree("set"), "continued from the folder");

    // A folder in place of a recipe is continued as it was begun, whether it is named twice or once.
    place.done("--recipe set --out begun --n 1 --seed 9 --samples-per-shard 1");
    place.done("--recipe begun --n 2");
    place.done("--recipe begun --out begun --n 3");
    let begun = place.json("begun/dataset.json");
    assert_eq!((&begun["seed"], &begun["samples"], &begun["shards"]), (&9.into(), &3.into(), &3.into()));
    assert!(!place.path("out").exists(), "it went elsewhere");

    // A copy that is changed is named, and one that is lost is written again by whoever has the file.
    fs::write(place.path("set").join(path), BOX.replace("9", "8")).expect("written");
    let run = place.run("validate set");
    assert!(run.code == 1 && run.out.contains("file-checksum") && run.out.contains(path), "{}", run.out);
    assert!(run.out.contains("it writes the file again"), "{}", run.out);
    fs::create_dir(place.path("parts")).expect("a folder");
    place.write("parts/my box.obj", BOX);
    place.make("set", "--n 4 --samples-per-shard 2");
    place.done("validate set");

    // Another content is another recipe.
    place.write("parts/my box.obj", BOX.replace("9", "8"));
    place.run("--recipe tiny.yaml --out set --n 6 --samples-per-shard 2").refused(&["recipe.mesh.file.sha256"]);
}

#[test]
fn faults_of_a_file_name_line_key_and_remedy() {
    let place = place();
    let fails = |words: &[&str]| {
        let run = place.run("preview --recipe tiny.yaml");
        run.refused(&["mesh.file", "tiny.yaml"]);
        run.refused(words);
    };
    place.write("parts/my box.obj", BOX.replace("v 9 8 3", "v 9 8 E"));
    fails(&["position parse error", "line 7", "export the part as OBJ anew"]);
    fs::remove_file(place.path("parts/my box.obj")).expect("removed");
    fails(&["there is no file `parts/my box.obj`", "relative to the recipe's own file", "meshes/clip.obj"]);
    fs::create_dir(place.path("parts/my box.obj")).expect("a folder");
    fails(&["no plain file", "name a file"]);
    let pinned = mesh_recipe(&[["file: meshes/clip.obj", "file: {name: meshes/clip.obj, sha256: ab}"]]);
    place.write("tiny.yaml", pinned);
    fails(&["mesh.file.sha256", "64 digits"]);
    let sum = "0".repeat(64);
    let pin = format!("file: {{name: meshes/clip.obj, sha256: '{sum}'}}");
    place.write("tiny.yaml", mesh_recipe(&[["file: meshes/clip.obj", &pin]]));
    fails(&["has SHA-256", &sum]);
    let large = mesh_recipe(&[["  unit_mm: 1 ", "  unit_mm: 1000 "]]);
    place.write("tiny.yaml", large);
    place.run("preview --recipe tiny.yaml").refused(&["must be above the part"]);
}

/// What the analysis of a picture has found is kept for the next run, and changes nothing: whether it is found, taken
/// from the cache, damaged there, or cannot be kept.
#[test]
#[ignore = "long"]
fn a_picture_is_analysed_once() {
    let place = Place::new();
    let made = |name: &str, cache: &str| {
        let order = "--recipe wood-picture --set scan.columns=64 --set scan.profiles=48 --n 1 --out";
        let output =
            place.command(&format!("{order} {name}")).env("SHEETLIGHT_CACHE", cache).output().expect("it starts");
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        place.tree(name)
    };
    let without = made("without", "");
    assert_same(&without, &made("cold", "cache"), "found and kept");
    let kept = place.tree("cache");
    let name = kept.keys().next().expect("it is kept").clone();
    assert!(kept.len() == 1 && name.ends_with(".fibres"), "{:?}", kept.keys());
    let time = |name: &str| fs::metadata(place.path(name)).and_then(|found| found.modified()).expect("it is there");
    let written = time(&format!("cache/{name}"));
    assert_same(&without, &made("warm", "cache"), "taken from there");
    assert_eq!(time(&format!("cache/{name}")), written, "nothing is written anew");
    place.write(&format!("cache/{name}"), &kept[&name][..kept[&name].len() / 2]);
    assert_same(&without, &made("damaged", "cache"), "damaged there");
    assert_same(&kept, &place.tree("cache"), "mended");
    place.write("file", "");
    assert_same(&without, &made("nowhere", "file"), "where nothing can be kept");
}

/// A folder of slices is one file of a dataset: kept as a tar, checked, continued, and refused with other slices.
#[test]
fn a_dataset_keeps_its_slices() {
    let place = Place::new();
    place.write("tiny.yaml", slices_recipe(&[["stack: slices/spruce.tar", "stack: scan"]]));
    fs::create_dir(place.path("scan")).expect("a folder");
    let save = |number: u32, by: u32| {
        let slice = GrayImage::from_fn(160, 40, |x, y| Luma([(60 + (7 * x + 5 * y + by) % 70) as u8]));
        slice.save(place.path(&format!("scan/s{number}.png"))).expect("written");
    };
    (0..60).for_each(|number| save(number, number));
    place.make("set", "--n 2 --samples-per-shard 2");
    let head = place.json("set/dataset.json");
    let asset = &head["assets"][0];
    let path = asset["path"].as_str().expect("a path");
    assert!(path.ends_with("-scan.tar") && asset["key"] == "slices.stack", "{asset}");
    assert_eq!(head["recipe"]["canonical"]["slices"]["stack"]["sha256"], asset["sha256"]);
    place.make("set", "--n 4 --samples-per-shard 2");
    save(7, 3);
    place.run("--recipe tiny.yaml --out set --n 6 --samples-per-shard 2").refused(&["recipe.slices.stack.sha256"]);
    // Without the slices: rendered again, and continued.
    fs::remove_dir_all(place.path("scan")).expect("removed");
    let clean = place.done("validate set --rerender 2");
    assert!(clean.out.contains("2 rendered again") && clean.out.contains("0 faults"), "{}", clean.out);
    place.done("--recipe set --out set --n 6");
    let tar = place.path("set").join(path);
    fs::write(&tar, &fs::read(&tar).expect("a copy")[512..]).expect("written");
    let run = place.run("validate set");
    assert!(run.code == 1 && run.out.contains(path), "{}", run.out);
}
