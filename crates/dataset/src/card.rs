//! The dataset card: what a person and the Hugging Face hub read first.

use std::collections::BTreeMap;

use output_schema::file::{SHARDS_PER_FOLDER, patterns};
use output_schema::row::{CALIBRATION, LIGHT, MEASURED, OBJECT, ROW};
use output_schema::{ColumnKind, DatasetHead, Generator};
use serde_json::Value;

use super::limits::limits;
use super::recipe_words::{is_entered_by_light, objects_in_words};
use optical_bench::split::Split;

/// Samples of each class in each split.
pub(crate) type ClassCounts = BTreeMap<(String, String), u64>;

/// `README.md` of a dataset whose `present` splits have files; `counts` is empty while it is not finished.
pub(super) fn card(head: &DatasetHead, present: &[Split], counts: &ClassCounts) -> String {
    let mut page = String::new();
    front_matter(&mut page, head, present);
    page += &format!("\n# {}\n\n{}\n\n", head.recipe.name, description(head));
    loading(&mut page, head, present);
    made(&mut page, head);
    shares(&mut page, head, counts);
    columns(&mut page, head);
    if !head.warnings.is_empty() {
        page += "\n## Warnings\n\nBefore the first sample the check of the rig warned:\n\n";
        head.warnings.iter().for_each(|warning| page += &format!("- {}; {}\n", warning.what, warning.remedy));
    }
    page += "\n## Limits\n\n";
    limits(head).iter().for_each(|limit| page += &format!("- {limit}\n"));
    page += "\nTest on real scans before you trust a model that was trained here.\n\n";
    page += "## Checking\n\n`gen validate PATH` reads every file again: checksums, columns, ranges, labels against \
        pictures. `gen validate PATH\n--rerender 4` renders four samples anew and compares bytes. `shards/*.json` \
        hold the SHA-256 of every file.\n\n";
    page += &format!("## Citing\n\n```bibtex\n{}\n```\n\n", citation(head));
    page += "## License\n\nCC0 1.0, as the front matter and `croissant.json` say: the authors of the generator claim \
        no rights in what it\nwrites. Whoever publishes this dataset may change both lines; the generator's own \
        licence is another.\n";
    if !head.assets.is_empty() {
        page += "\nThe files in `assets/` are copies of files that the recipe names. They keep the licences that they \
            came with, and\nCC0 says nothing about them: see that you may pass them on before you publish this \
            folder.\n";
    }
    page
}

fn loading(page: &mut String, head: &DatasetHead, present: &[Split]) {
    let split = present.first().map_or("train", |split| split.name());
    *page += "## Loading\n\nPATH is this folder; for `load_dataset` it may be a name on the hub.\n\n```python\n";
    *page += &format!("from datasets import load_dataset\nscans = load_dataset(\"PATH\", split=\"{split}\")\n\n");
    *page += "import polars as pl  # numbers alone: columns of images are not read unless asked for\n\
        wanted = [\"id\", \"index\", \"class\", \"objects\", \"physics\"]\n";
    let is_spread = head.shards > SHARDS_PER_FOLDER;
    let tables = if is_spread { "**/*.parquet" } else { "*.parquet" };
    *page += &format!("rows = pl.scan_parquet(\"PATH/data/{tables}\").select(wanted).collect()\n");
    if head.has_exr() {
        *page += "\nimport OpenEXR  # maps of one row in physical units, NaN where nothing was measured\n\
            row = rows.row(0, named=True)\n";
        let mut folder = format!("{{row['index'] // {}:05}}", head.samples_per_shard);
        if is_spread {
            // The first thousand shards lie in no folder of their thousand.
            *page += &format!("shard = row['index'] // {}\n", head.samples_per_shard);
            *page += &format!(
                "thousand = f\"{{shard // {SHARDS_PER_FOLDER}:03}}/\" if shard >= {SHARDS_PER_FOLDER} else \"\"\n"
            );
            folder = "{thousand}{shard:05}".into();
        }
        let name = format!("PATH/exr/{folder}/{{row['id']}}.exr");
        *page += &format!("maps = OpenEXR.File(f\"{name}\", separate_channels=True).channels()\n");
    }
    *page += "```\n";
    let png = &head.images.png;
    if png.is_empty() {
        let images = if head.images.exr.is_empty() {
            "It was made without images: its recipe's `output` has neither `png` nor `exr`."
        } else {
            "For images take the EXR files."
        };
        *page += &format!("\nThe tables hold no images, so `datasets` gives numbers and objects alone. {images}\n");
    } else {
        let (names, zeros) = (png.join(", "), zeros(png));
        *page += &format!("\nThe tables hold the images {names} as PNG, which `datasets` decodes. 0 is {zeros}.\n");
    }
    if png.iter().any(|name| name == "range") {
        let unit = head.range_unit();
        *page += &format!("Range [{unit}] is `range_offset_{unit} + r * range_scale_{unit}` for a pixel r above 0.\n");
    }
    if png.iter().any(|name| LIGHT.contains(&name.as_str())) && head.images.bits > 8 {
        *page += &format!(
            "Digital numbers have {} bits, 0 to {}, in 16-bit PNG.\n",
            head.images.bits,
            head.images.most_dn()
        );
    }
    *page += "\n";
}

/// What 0 means in these images.
fn zeros(png: &[String]) -> String {
    let has = |name: &&str| png.iter().any(|one| one == name);
    let measured = MEASURED.into_iter().filter(has).collect::<Vec<_>>().join(", ");
    let missing = if measured.is_empty() { None } else { Some(format!("missing in {measured}")) };
    let label = has(&"label").then(|| "background in label".to_owned());
    let instance = has(&"instance").then(|| "no object in instance".to_owned());
    missing.into_iter().chain(label).chain(instance).collect::<Vec<_>>().join("; ")
}

fn made(page: &mut String, head: &DatasetHead) {
    let recipe = &head.recipe;
    *page += "## How it was made\n\n";
    *page += &format!("| | |\n|---|---|\n| generator | {} {} |\n", head.generator.name, head.generator.version);
    *page += &format!("| schema | {}.{} |\n", head.schema_version[0], head.schema_version[1]);
    *page += &format!("| target | {} |\n| recipe | {} (sha256 `{}`) |\n", head.target, recipe.name, recipe.hash);
    *page += &format!("| seed | {} |\n| samples | {} |\n", head.seed, head.samples);
    *page += &format!("| shards | {} of {} samples |\n", head.shards, head.samples_per_shard);
    *page += &format!("| images | {} columns, {} rows |\n", head.images.cols, head.images.rows);
    if let Some(transport) = transport(&recipe.canonical) {
        *page += &format!("| transport | {transport} |\n");
    }
    let Some(command) = head.generator.name.split_whitespace().last() else { return };
    // Files that a recipe names lie in the folder, and nowhere else for whoever was given it.
    let (file, from) = if head.assets.is_empty() {
        ("recipe.yaml", "`recipe.yaml` holds the lines below")
    } else {
        ("PATH", "PATH is this folder: `assets/` holds the files that the recipe names")
    };
    *page += &format!(
        "\n```sh\n{command} --recipe {file} --seed {} --n {} --samples-per-shard {} --out again\n```\n\n",
        head.seed, head.samples, head.samples_per_shard
    );
    *page += &format!(
        "makes these files again, byte for byte on the same target; {from}. The recipe, as\n\
         `dataset.json` holds it too:\n\n"
    );
    *page += &format!("```yaml\n{}\n```\n", recipe.text.trim_end());
}

/// Classes and splits: shares of the recipe, and what there is of each.
fn shares(page: &mut String, head: &DatasetHead, counts: &ClassCounts) {
    *page += "\n## Classes and splits\n\n";
    let splits = head.splits.named();
    let named = splits.map(|(name, share)| format!("{name} ({share})"));
    *page += &format!("| class | share | {} |\n|---|---|---|---|---|\n", named.join(" | "));
    let share = |class: &String| head.recipe.canonical["classes"][class]["share"].as_f64();
    let sum: f64 = head.classes.iter().filter_map(share).sum();
    for class in &head.classes {
        let part = share(class).filter(|_| sum > 0.0).map_or(String::new(), |share| format!("{:.3}", share / sum));
        let count = |split: &str| counts.get(&(class.clone(), split.to_string())).copied().unwrap_or(0).to_string();
        let there = splits.map(|(name, _)| if counts.is_empty() { String::new() } else { count(name) });
        *page += &format!("| {class} | {part} | {} |\n", there.join(" | "));
    }
    *page +=
        "\nShares are the recipe's; the columns of splits count samples. Splits follow from seed and index alone.\n";
}

/// Everything that the files hold, each with unit, missing rule and meaning.
fn columns(page: &mut String, head: &DatasetHead) {
    *page += "\n## Columns\n\nLengths in mm, angles in deg, DN as the camera gives them. Images are `[rows, cols]`: x \
        along the columns (the laser\nline), y along the rows (the scan), z up.\n\n\
        | column | unit | missing | meaning |\n|---|---|---|---|\n";
    for column in ROW.iter().filter(|c| head.has(c)) {
        match column.kind {
            ColumnKind::Parameters => head.parameters.iter().for_each(|n| entry(page, &n.path(), &n.unit, "", &n.doc)),
            ColumnKind::Physics => {
                for n in &head.physics {
                    entry(page, &format!("physics.{}", n.key), &n.unit, column.missing, &n.doc);
                }
            }
            _ => entry(page, column.name, column.unit, column.missing, column.doc),
        }
    }
    for field in &CALIBRATION {
        entry(page, &format!("calibration.{}", field.name), field.unit, field.missing, field.doc);
    }
    for field in &OBJECT {
        entry(page, &format!("objects.{}", field.name), field.unit, field.missing, field.doc);
    }
    let classes = head.shown_classes().map(|(value, name)| format!("{value} {name}"));
    *page += &format!("\nPixel classes: {}.\n", classes.collect::<Vec<_>>().join(", "));
    if head.has_exr() {
        let channels: Vec<String> = head.channels().iter().map(|c| format!("{} [{}]", c.name, c.unit)).collect();
        *page += &format!(
            "\n`exr/<shard>/<id>.exr` holds the channels {}; see the attribute `sheetlight` of each file.\n",
            channels.join(", ")
        );
    }
    if let Some(step) = head.images.stack_every {
        let (rows, cols) = (head.images.sensor_rows, head.images.sensor_cols);
        *page += &format!(
            "\n`stacks/<shard>.parquet` holds every profile whose number is a multiple of {step} as the sensor saw it, \
             [{rows}, {cols}] DN.\n"
        );
    }
}

/// One row of the table.
fn entry(page: &mut String, name: &str, unit: &str, missing: &str, doc: &str) {
    let missing = if missing.is_empty() { "never" } else { missing };
    *page += &format!("| `{name}` | {unit} | {missing} | {} |\n", doc.replace('|', "\\|"));
}

/// What the dataset is, in two sentences.
pub(super) fn description(head: &DatasetHead) -> String {
    let what = objects_in_words(head);
    let light = if is_entered_by_light(head) { "; light spreads below the surface" } else { "" };
    let labels = if holds(head, "label") || holds(head, "instance") { " with pixel-exact labels" } else { "" };
    let maps: Vec<&str> = MEASURED.into_iter().filter(|name| holds(head, name)).collect();
    let maps = match &maps[..] {
        [] => "Numbers and objects of each scan without its measured images".to_owned(),
        [one] => format!("The {one} image as a line-laser profiler measures it"),
        [most @ .., last] => {
            format!("Images of {} and {last} as a line-laser profiler measures them", most.join(", "))
        }
    };
    format!(
        "{} simulated laser-triangulation scans of {what}{labels}, from the recipe {}. {maps}{light}.",
        head.samples, head.recipe.name
    )
}

/// Whether an image is in the tables or in the EXR files.
pub(super) fn holds(head: &DatasetHead, image: &str) -> bool {
    head.images.png.iter().chain(&head.images.exr).any(|name| name == image)
}

/// How to cite the dataset, BibTeX.
pub(super) fn citation(head: &DatasetHead) -> String {
    let Generator { name, version } = &head.generator;
    let title: String = head.recipe.name.chars().map(|c| if "{}\\".contains(c) { ' ' } else { c }).collect();
    format!(
        "@misc{{sheetlight-{0}-seed-{1},\n  title = {{{title}: simulated laser-triangulation scans}},\n  note = {{{2} \
            samples by \
         {name} {version}, recipe SHA-256 {3}, seed {1}}}\n}}",
        head.recipe.hash.get(..8).unwrap_or("unknown"),
        head.seed,
        head.samples,
        head.recipe.hash
    )
}

/// How light was spread, as the recipe has it: the model, then its settings.
fn transport(canonical: &Value) -> Option<String> {
    let keys = canonical["transport"].as_object()?;
    let model = keys.get("model")?.as_str()?.to_owned();
    let others = keys.iter().filter(|(name, _)| *name != "model");
    Some(others.fold(model, |text, (name, value)| {
        let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        format!("{text}, {name} {value}")
    }))
}

fn front_matter(page: &mut String, head: &DatasetHead, present: &[Split]) {
    let sizes = match head.samples {
        0..1_000 => "n<1K",
        1_000..10_000 => "1K<n<10K",
        10_000..100_000 => "10K<n<100K",
        100_000..1_000_000 => "100K<n<1M",
        1_000_000..10_000_000 => "1M<n<10M",
        10_000_000..100_000_000 => "10M<n<100M",
        _ => "100M<n<1B",
    };
    // JSON text is YAML text: any name is quoted rightly.
    let name = serde_json::Value::from(head.recipe.name.as_str());
    *page += &format!("---\npretty_name: {name}\nlicense: cc0-1.0\n");
    *page += "annotations_creators:\n- machine-generated\nsource_datasets:\n- original\n";
    // Pieces of one material have no defects to find, and a recipe with one class nothing to tell apart. Boxes are in
    // the tables, masks in images that a recipe may leave out.
    let defects = head.label_values.len() > 2;
    let sorts = defects && head.classes.len() > 1;
    let (classes, instances) = (holds(head, "label"), defects && holds(head, "instance"));
    let list = |key: &str, all: &[(bool, &str)]| {
        let fit: String = all.iter().filter(|(fits, _)| *fits).map(|(_, name)| format!("\n- {name}")).collect();
        if fit.is_empty() { fit } else { format!("{key}:{fit}\n") }
    };
    let categories =
        [(classes || instances, "image-segmentation"), (defects, "object-detection"), (sorts, "image-classification")];
    let ids = [
        (classes, "semantic-segmentation"),
        (instances, "instance-segmentation"),
        (sorts, "multi-class-image-classification"),
    ];
    page.push_str(&list("task_categories", &categories));
    page.push_str(&list("task_ids", &ids));
    let scattering = if is_entered_by_light(head) { "\n- subsurface-scattering" } else { "" };
    *page += &format!(
        "tags:\n- synthetic\n- laser-triangulation{scattering}\n- {}\nsize_categories:\n- {sizes}\n",
        head.subject
    );
    *page += "configs:\n- config_name: default\n  data_files:\n";
    let shares = head.splits.named();
    for split in present.iter().filter(|split| shares.iter().any(|(name, share)| *name == split.name() && *share > 0.0))
    {
        *page += &format!("  - split: {}\n", split.name());
        match &patterns("data", &format!("{}-*.parquet", split.name()), head.shards)[..] {
            [all] => *page += &format!("    path: {all}\n"),
            several => {
                *page += "    path:\n";
                several.iter().for_each(|pattern| *page += &format!("    - {pattern}\n"));
            }
        }
    }
    *page += "---\n";
}
