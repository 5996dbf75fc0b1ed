//! The part of the dataset card that lists columns, pixel classes, channels and sensor frames.

use output_schema::row::{CALIBRATION, OBJECT, ROW};
use output_schema::{DatasetHead, Kind};

use super::card::add;

/// Everything that the files hold, each with unit, missing rule and meaning.
pub(super) fn columns(page: &mut String, head: &DatasetHead) {
    add(
        page,
        "\n## Columns\n\nLengths in mm, angles in deg, DN as the camera gives them. Images are `[rows, cols]`: x along the columns (the laser",
    );
    add(page, "line), y along the rows (the scan), z up.\n\n| column | unit | missing | meaning |\n|---|---|---|---|");
    for column in ROW.iter().filter(|c| head.has(c)) {
        match column.kind {
            Kind::Parameters => head.parameters.iter().for_each(|n| entry(page, &n.path(), &n.unit, "", &n.doc)),
            Kind::Physics => {
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
    add(page, &format!("\nPixel classes: {}.", classes.collect::<Vec<_>>().join(", ")));
    if !head.images.exr.is_empty() {
        let channels: Vec<String> = head.channels().iter().map(|c| format!("{} [{}]", c.name, c.unit)).collect();
        add(
            page,
            &format!(
                "\n`exr/<shard>/<id>.exr` holds the channels {}; see the attribute `sheetlight` of each file.",
                channels.join(", ")
            ),
        );
    }
    if let Some(step) = head.images.stack_every {
        let (rows, cols) = (head.images.sensor_rows, head.images.sensor_cols);
        add(
            page,
            &format!(
                "\n`stacks/<shard>.parquet` holds every profile whose number is a multiple of {step} as the sensor saw it, [{rows}, {cols}] DN."
            ),
        );
    }
}

/// One row of the table.
fn entry(page: &mut String, name: &str, unit: &str, missing: &str, doc: &str) {
    let missing = if missing.is_empty() { "never" } else { missing };
    add(page, &format!("| `{name}` | {unit} | {missing} | {} |", doc.replace('|', "\\|")));
}
