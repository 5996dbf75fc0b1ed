//! The dataset card: what a person and the Hugging Face hub read first.

use std::fmt::Write;

use output_schema::row::{CALIBRATION, OBJECT, ROW};
use output_schema::{DatasetHead, Kind};
use serde_json::Value;

use crate::record::Split;

/// `README.md` of a dataset whose `present` splits have files.
pub(crate) fn card(head: &DatasetHead, present: &[Split]) -> String {
    let mut page = String::new();
    front_matter(&mut page, head, present);
    let recipe = &head.recipe;
    add(&mut page, &format!("\n# {}\n", recipe.name));
    add(
        &mut page,
        "Simulated laser-triangulation scans with pixel-exact labels: range, reflectance and scatter images as a",
    );
    add(&mut page, "line-laser profiler measures them, with light that spreads below the surface.\n");
    add(
        &mut page,
        "```python\nfrom datasets import load_dataset\nscans = load_dataset(\"PATH\", split=\"train\")  # PATH: this folder\n```\n",
    );

    add(&mut page, "## How it was made\n");
    add(&mut page, &format!("| | |\n|---|---|\n| generator | {} {} |", head.generator.name, head.generator.version));
    add(&mut page, &format!("| target | {} |\n| recipe | {} (sha256 `{}`) |", head.target, recipe.name, recipe.hash));
    add(&mut page, &format!("| seed | {} |\n| samples | {} |", head.seed, head.samples));
    add(&mut page, &format!("| shards | {} of {} samples |", head.shards, head.samples_per_shard));
    add(&mut page, &format!("| images | {} columns, {} rows |", head.images.cols, head.images.rows));
    if let Some(transport) = transport(&recipe.canonical) {
        add(&mut page, &format!("| transport | {transport} |"));
    }
    add(&mut page, &format!("| classes | {} |", head.classes.join(", ")));
    let shares = head.splits.named().map(|(name, share)| format!("{name} {share}"));
    add(&mut page, &format!("| splits | {} |\n", shares.join(", ")));
    add(
        &mut page,
        "The recipe, as `dataset.json` holds it too; with the generator it makes these files again, byte for byte on the",
    );
    add(&mut page, "same target:\n");
    add(&mut page, &format!("```yaml\n{}\n```", recipe.text.trim_end()));

    add(
        &mut page,
        "\n## Columns\n\nLengths in mm, angles in deg, DN as the camera gives them. Images are `[rows, cols]`: x along the columns (the laser",
    );
    add(
        &mut page,
        "line), y along the rows (the scan), z up.\n\n| column | unit | missing | meaning |\n|---|---|---|---|",
    );
    for column in ROW.iter().filter(|c| head.has(c)) {
        match column.kind {
            Kind::Parameters => head.parameters.iter().for_each(|n| entry(&mut page, &n.path(), &n.unit, "", &n.doc)),
            Kind::Physics => {
                for n in &head.physics {
                    entry(&mut page, &format!("physics.{}", n.key), &n.unit, column.missing, &n.doc);
                }
            }
            _ => entry(&mut page, column.name, column.unit, column.missing, column.doc),
        }
    }
    for field in &CALIBRATION {
        entry(&mut page, &format!("calibration.{}", field.name), field.unit, field.missing, field.doc);
    }
    for field in &OBJECT {
        entry(&mut page, &format!("objects.{}", field.name), field.unit, field.missing, field.doc);
    }
    let classes = head.shown_classes().map(|(value, name)| format!("{value} {name}"));
    add(&mut page, &format!("\nPixel classes: {}.", classes.collect::<Vec<_>>().join(", ")));
    if !head.images.exr.is_empty() {
        let channels: Vec<String> = head.channels().iter().map(|c| format!("{} [{}]", c.name, c.unit)).collect();
        add(
            &mut page,
            &format!(
                "\n`exr/<shard>/<id>.exr` holds the channels {}; see the attribute `sheetlight` of each file.",
                channels.join(", ")
            ),
        );
    }
    if let Some(step) = head.images.stack_every {
        let (rows, cols) = (head.images.sensor_rows, head.images.sensor_cols);
        add(
            &mut page,
            &format!(
                "\n`stacks/<shard>.parquet` holds every profile whose number is a multiple of {step} as the sensor saw it, [{rows}, {cols}] DN."
            ),
        );
    }

    add(
        &mut page,
        "\n## What is not modelled\n\nThe scans are simulated: no real object was measured. Vibration, dust, wear of the",
    );
    add(
        &mut page,
        "instrument and anything that the recipe does not name are absent. Numbers that the recipe draws follow its",
    );
    add(
        &mut page,
        "distributions, which need not be those of your line. Test on real scans before you trust a model that was trained here.\n",
    );
    add(
        &mut page,
        "## License\n\nThe front matter says CC0: the authors of the generator claim no rights in what it writes. Whoever publishes this",
    );
    add(&mut page, "dataset may change that line.");
    page
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

fn add(page: &mut String, text: &str) {
    // Writing to a String cannot fail.
    let _ = writeln!(page, "{text}");
}

fn entry(page: &mut String, name: &str, unit: &str, missing: &str, doc: &str) {
    let missing = if missing.is_empty() { "never" } else { missing };
    add(page, &format!("| `{name}` | {unit} | {missing} | {} |", doc.replace('|', "\\|")));
}

fn front_matter(page: &mut String, head: &DatasetHead, present: &[Split]) {
    let sizes = match head.samples {
        0..1_000 => "n<1K",
        1_000..10_000 => "1K<n<10K",
        10_000..100_000 => "10K<n<100K",
        100_000..1_000_000 => "100K<n<1M",
        _ => "1M<n<10M",
    };
    // JSON text is YAML text: any name is quoted rightly.
    let name = serde_json::Value::from(head.recipe.name.as_str());
    add(page, &format!("---\npretty_name: {name}\nlicense: cc0-1.0"));
    add(page, "task_categories:\n- image-segmentation\n- object-detection\n- image-classification");
    add(
        page,
        &format!("tags:\n- synthetic\n- laser-triangulation\n- subsurface-scattering\nsize_categories:\n- {sizes}"),
    );
    add(page, "configs:\n- config_name: default\n  data_files:");
    let shares = head.splits.named();
    for split in present.iter().filter(|split| shares.iter().any(|(name, share)| *name == split.name() && *share > 0.0))
    {
        add(page, &format!("  - split: {0}\n    path: data/{0}-*.parquet", split.name()));
    }
    add(page, "---");
}
