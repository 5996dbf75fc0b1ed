//! `gen icon`: describes files of the real camera.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;
use output_schema::file::DATASET;
use serde_json::{Value, json};

use super::{CommandResult, DONE, UsageError, print};
use dataset::Fault;
use tools::icon::{Content, IconScan, PlaneContent, ScanReader, SensorImage, Traits, open};

/// Version of the document's layout.
const SCHEMA_VERSION: u32 = 1;
/// Rows that are handled at a time.
const ROWS_AT_A_TIME: usize = 256;

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen icon scans/00000003.xml                      what a file holds
  gen icon scans/00000003.xml --json | jq .missing_share
  gen export icon planks --index 3 --out scans     writes such files: scans/00000003.dat and .xml

docs/guide/icon.md describes the files, and the fields of the JSON.")]
pub(super) struct IconArgs {
    /// The .xml of a file to look at, with its .dat beside it
    path: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &IconArgs) -> CommandResult {
    if arguments.path.join(DATASET).is_file() {
        let dir = arguments.path.display();
        let remedy = format!("`gen export icon {dir} --index 0 --out OUT` writes its samples as such files");
        return Err(UsageError(format!("{dir} is a dataset, not a file of the camera: {remedy}")).into());
    }
    let (text, mut document) = match open(&arguments.path)? {
        Content::Scan(mut reader) => {
            let scan = ScanDescription::of(&mut reader)?;
            (scan.text(), scan.json())
        }
        Content::Image(image) => (describe_image(&image), image_json(&image)),
    };
    if arguments.json {
        document["path"] = arguments.path.display().to_string().into();
        print(&format!("{document:#}\n"))?;
    } else {
        print(&text)?;
    }
    Ok(DONE)
}

fn brightest(image: &SensorImage) -> u8 {
    image.dn.iter().max().copied().unwrap_or(0)
}

fn describe_image(image: &SensorImage) -> String {
    let [x, y] = image.offset;
    let (cols, rows) = (image.cols, image.rows);
    format!("sensor image, {cols} x {rows} px from column {x}, row {y}; brightest {} DN\n", brightest(image))
}

fn image_json(image: &SensorImage) -> Value {
    json!({
        "schema_version": SCHEMA_VERSION, "content": "sensor_image", "columns": image.cols, "rows": image.rows,
        "offset_px": image.offset, "brightest_dn": brightest(image),
    })
}

/// What a scan holds.
struct ScanDescription {
    cols: usize,
    rows: usize,
    planes: Vec<String>,
    traits: Traits,
    /// Least and largest place along the line of a calibrated scan, and distance between two columns [mm].
    x_mm: Option<[f64; 2]>,
    col_mm: Option<f64>,
    /// What the file holds and is not read.
    unused: Vec<String>,
    /// Share of pixels without a height [1].
    missing: f64,
    /// Share of pixels of 255 DN [1].
    saturated: f64,
    /// Lowest and highest height [mm or px].
    ends: Option<[f64; 2]>,
    /// Counter at the first and at the last profile.
    encoder: Option<[i32; 2]>,
}

impl ScanDescription {
    /// That of a scan; rows pass through, so its length does not matter.
    fn of(reader: &mut ScanReader) -> Result<Self, Fault> {
        let mut planes = Vec::new();
        let (mut missing, mut low, mut high) = (0_usize, f64::INFINITY, f64::NEG_INFINITY);
        let (mut saturated, mut encoder): (usize, Option<[i32; 2]>) = (0, None);
        let mut x_mm = match reader.traits() {
            Traits::World(world) => Some([world.lower[0], world.upper[0]]),
            Traits::Sensor(_) => None,
        };
        let (mut ends_of_places, mut col_mm): (Option<[f64; 2]>, _) = (None, None);
        for from in (0..reader.rows()).step_by(ROWS_AT_A_TIME) {
            let scan = reader.read(from, ROWS_AT_A_TIME)?;
            for z in scan.heights() {
                missing += usize::from(!z.is_finite());
                (low, high) = (low.min(z), high.max(z));
            }
            saturated += scan.light_dn().map_or(0, |dn| dn.iter().filter(|dn| **dn == u8::MAX).count());
            for x in scan.places().into_iter().flatten().filter(|x| x.is_finite()) {
                let [low, high] = ends_of_places.unwrap_or([x; 2]);
                ends_of_places = Some([low.min(x), high.max(x)]);
            }
            col_mm = col_mm.or_else(|| scan.col_mm());
            if let Some(marks) = scan.marks()
                && let (Some(first), Some(last)) = (marks.first(), marks.last())
            {
                encoder = Some([encoder.map_or(first.encoder, |[first, _]| first), last.encoder]);
            }
            planes = names(&scan);
        }
        x_mm = ends_of_places.or(x_mm);
        let (cols, rows) = (reader.width(), reader.rows());
        let share = |count: usize| count as f64 / (cols * rows).max(1) as f64;
        Ok(Self {
            cols,
            rows,
            planes,
            traits: reader.traits(),
            x_mm,
            col_mm,
            unused: reader.unused().to_vec(),
            missing: share(missing),
            saturated: share(saturated),
            ends: (low <= high).then_some([low, high]),
            encoder,
        })
    }

    /// In words.
    fn text(&self) -> String {
        let mut text = format!("scan, {} columns x {} profiles: {}\n", self.cols, self.rows, self.planes.join(", "));
        // Writing to a string cannot fail.
        let unit = match &self.traits {
            Traits::Sensor(sensor) => {
                let _ = writeln!(
                    text,
                    "uncalibrated: {} sensor rows from column {}, row {}; {} rows a step",
                    sensor.region_rows, sensor.origin[0], sensor.origin[1], sensor.scale[1]
                );
                "px"
            }
            Traits::World(world) => {
                let step = world.row_mm.map_or("unknown".into(), |mm| format!("{mm} mm"));
                let [from, to] = self.x_mm.unwrap_or([f64::NAN; 2]);
                let col = self.col_mm.map_or("unknown".into(), |mm| format!("{mm:.6} mm"));
                let _ = writeln!(text, "calibrated: x {from} to {to} mm, {col} a column; between profiles {step}");
                "mm"
            }
        };
        let (missing, saturated) = (100.0 * self.missing, 100.0 * self.saturated);
        let _ = writeln!(text, "missing {missing:.2} %, saturated {saturated:.2} %");
        if let Some([low, high]) = self.ends {
            let _ = writeln!(text, "Range {low:.4} to {high:.4} {unit}");
        }
        if let Some([first, last]) = self.encoder {
            let _ = writeln!(text, "encoder {first} to {last}");
        }
        if !self.unused.is_empty() {
            let _ = writeln!(text, "not read: {}", self.unused.join(", "));
        }
        text
    }

    /// For programs.
    fn json(&self) -> Value {
        let mut document = json!({
            "schema_version": SCHEMA_VERSION, "content": "scan", "columns": self.cols, "profiles": self.rows,
            "planes": self.planes, "missing_share": self.missing, "saturated_share": self.saturated,
            "encoder": self.encoder, "unused": self.unused,
        });
        let of_traits = match &self.traits {
            Traits::Sensor(sensor) => json!({
                "calibrated": false, "range_px": self.ends, "sensor_rows": sensor.region_rows,
                "origin_px": sensor.origin, "rows_per_step": sensor.scale[1],
            }),
            Traits::World(world) => json!({
                "calibrated": true, "range_mm": self.ends, "x_mm": self.x_mm,
                "col_mm": self.col_mm, "row_mm": world.row_mm,
            }),
        };
        if let (Value::Object(document), Value::Object(of_traits)) = (&mut document, of_traits) {
            document.extend(of_traits);
        }
        document
    }
}

/// Names and types of the planes that are read.
fn names(scan: &IconScan) -> Vec<String> {
    let planes = scan.planes.iter().filter(|(part, _)| *part != PlaneContent::RangeX || scan.places().is_some());
    let name = |part: PlaneContent, kind: &str| match part {
        PlaneContent::Mark => part.name().into(),
        _ => format!("{} {kind}", part.name()),
    };
    planes.map(|(part, numbers)| name(*part, numbers.kind().name())).collect()
}
