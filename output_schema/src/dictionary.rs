//! The data dictionary: declarations -> `output_schema/README.md`.

use base::Class;

use crate::channel::{ATTRIBUTE, CHANNEL_SHAPE, CHANNELS, RANGE_FORMS};
use crate::column::Column;
use crate::dataset::{OLDEST_MINOR, SCHEMA_VERSION};
use crate::file::FILES;
use crate::row::{CALIBRATION, OBJECT, ROW};
use crate::stack::STACK;

/// The whole page, Markdown.
pub fn dictionary() -> String {
    let mut page = String::new();
    let [major, minor] = SCHEMA_VERSION;
    page += "# What is on disk\n\nThis page is written from the declarations in `src/`; `BLESS=1 cargo test -p \
        output_schema` renews it.\n\n";
    page += &format!(
        "Schema version {major}.{minor}. [How versions change](#how-versions-change) says what readers do with \
         another.\n\n"
    );
    page += "Lengths are in mm, angles in deg, digital numbers (DN) as the camera gives them. Images are `[rows, \
        cols]`,\nrow-major: x along the columns (the laser line), y along the rows (the scan, row 0 exposed first), z \
        up.\n\n";

    page += "## Files\n\n| path | when | what |\n|---|---|---|\n";
    for file in &FILES {
        page += &format!("| `{}` | {} | {} |\n", file.path, file.when, file.doc);
    }
    page += "\n`<shard>` has five digits. Temporary names start with `.tmp-`, lock files with `.lock-`; a finished \
        dataset has\nneither. A shard without a manifest is not finished and is made again.\n";

    page += "\n## Pixel classes\n\n| value | name | subject |\n|---|---|---|\n";
    for class in Class::ALL {
        let subject = class.subject().unwrap_or("all");
        page += &format!("| {} | `{}` | {subject} |\n", class as u8, class.name());
    }
    page += "\n`label_values` of `dataset.json` lists the values that labels of the dataset's subject can have; \
        `class_area_px` has\na field for each of them.\n";

    page += "\n`follows from` says what `gen validate` holds a column to: what the head says and the recipe *draws*; \
        the *scene*, made\nagain without light and compared bit for bit; or the *images*. `since` is the oldest \
        schema with it that is read.\n";
    table(&mut page, "Columns of `data/*.parquet`", &ROW);
    page += "\nThe columns of `parameters` and `physics` are listed with unit and meaning in `dataset.json`, and in \
        the\nmetadata (`unit`, `doc`) of each Arrow field. Images are there only where the recipe's output asks for \
        them.\n";
    table(&mut page, "Fields of `calibration`", &CALIBRATION);
    table(&mut page, "Fields of `objects`", &OBJECT);
    places(&mut page);

    page += "\n## Forms of Range\n\n| `images.range` | unit | values | meaning |\n|---|---|---|---|\n";
    for form in &RANGE_FORMS {
        page += &format!("| `{}` | {} | {} | {} |\n", form.name, form.unit, form.range, form.doc);
    }

    page += "\nIn EXR files Range has its unit; in PNG a pixel r above 0 stands for `range_offset_mm + r * \
        range_scale_mm`, or the same\nwith `_px`. 0 is missing.\n\nRange is what the camera measures, and `Height` of \
        the EXR files is where the surface is. Where light goes into matter,\n\
        the camera sees it leave lower: Range lies below `Height`, by up to some tenths of a mm on wood and plastic, \
        and not at all\non metal.\n";
    page += "\n## Channels of `exr/<shard>/<id>.exr`\n\n";
    page += "| channel | subject | type | shape | unit | values | missing | meaning | why this type |\n\
        |---|---|---|---|---|---|---|---|---|\n";
    for c in &CHANNELS {
        let (samples, unit) = (c.samples.name(), c.unit);
        let subject = if c.subject.is_empty() { "all" } else { c.subject };
        let row = format!(
            "| `{}` | {subject} | {samples} | {CHANNEL_SHAPE} | {unit} | {} | {} |",
            c.name, c.range, c.missing
        );
        page += &format!("{row} {} | {} |\n", c.doc, c.why);
    }
    page += "\n`Height` and the channels of one subject are written with `truth_maps`, the others where the recipe's \
        output asks for\n";
    page += &format!(
        "them. The text attribute `{ATTRIBUTE}` holds id, index, spacing and units as ASCII JSON; `pixelAspectRatio` \
         and\n"
    );
    page += "`xDensity` hold the spacing for programs that know OpenEXR alone.\n";

    table(&mut page, "Columns of `stacks/*.parquet`", &STACK);
    versions(&mut page);
    page
}

/// What the table of objects has no room for: which are pockets, and where x and y begin.
fn places(page: &mut String) {
    *page += "\nThe pockets of a pack are its objects with `within` 0 whose class is none of `wrinkle`, `delamination` \
        and\n`tablet_on_flange`. They have the instances 1 to P, row after row along the laser line; a pocket of \
        which no pixel shows\nanything is not in the list.\n\nWith a sensor columns and b profiles to a pixel \
        (`output.bin`: 1 unless the recipe says otherwise), column j of an image\n\
        is centred on sensor column c = (j + 1/2) a - 1/2, and row r on y = (r + 1/2 - 1/(2 b)) `row_mm`. At the \
        upper surface x\nis about (c - `calibration.centre_col_px`) `col_mm` / a; python/calibrate.py has it exactly, \
        and of rectified scans it is\n`calibration.x_first_mm` + j `col_mm`. On a turntable `x_mm` and `y_mm` are \
        places on the object before it has turned.\n";
}

fn versions(page: &mut String) {
    let [major, minor] = SCHEMA_VERSION;
    *page += "\n## How versions change\n\n`schema_version` stands in `dataset.json` and in each manifest as `[major, \
        minor]`, and in the metadata of each Parquet\nfile as `sheetlight.schema_version`.\n\n\
        - **Minor** grows where something is added: a column, a channel, a key, a kind of file. What was there stays \
        as it was, so\n  a reader takes every newer minor number of its major one, and passes over what it does not \
        know.\n- **Major** grows where an old reader would misread: something is renamed, removed, or means another \
        thing. Readers look\n  at the version before anything else and refuse a newer major number, in words that say \
        to take a newer program.\n";
    *page += &format!(
        "- This program reads {major}.{OLDEST_MINOR} and newer of {major}.x, writes {major}.{minor}, and continues \
         only what it wrote itself.\n"
    );
}

fn table(page: &mut String, title: &str, columns: &[Column]) {
    let [major, _] = SCHEMA_VERSION;
    *page += &format!(
        "\n## {title}\n\n| column | type | shape | unit | values | missing | follows from | since | meaning |\n\
         |---|---|---|---|---|---|---|---|---|\n"
    );
    for c in columns {
        *page += &format!(
            "| `{}` | {} | {} | {} | {} | {} | {} | {major}.{} | {} |\n",
            c.name,
            c.kind.name(),
            c.kind.shape(),
            c.unit,
            c.range,
            c.missing,
            c.follows.name(),
            c.since.max(OLDEST_MINOR),
            c.doc
        );
    }
}
