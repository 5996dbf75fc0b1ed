//! `gen icon`: describes files of the real camera.

use std::fmt::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use output_schema::file::DATASET;

use super::{CommandResult, UsageError, print};
use dataset::Fault;
use tools::icon::{Content, IconScan, PeakLight, RangeValues, ScanReader, Scatter, SensorImage, Traits, open};

/// Rows that are handled at a time.
const ROWS_AT_A_TIME: usize = 256;

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen icon scans/00000003.xml                      what a file holds
  gen export icon planks --index 3 --out scans     writes such files: scans/00000003.dat and .xml

docs/files/icon.md describes the files.")]
pub(super) struct IconArgs {
    /// The .xml of a file to look at, with its .dat beside it
    path: PathBuf,
}

pub(super) fn run(arguments: &IconArgs) -> CommandResult {
    if arguments.path.join(DATASET).is_file() {
        let dir = arguments.path.display();
        let remedy = format!("`gen export icon {dir} --index 0 --out OUT` writes its samples as such files");
        return Err(UsageError(format!("{dir} is a dataset, not a file of the camera: {remedy}")).into());
    }
    print(&match open(&arguments.path)? {
        Content::Scan(mut reader) => describe(&mut reader)?,
        Content::Image(image) => describe_image(&image),
    })?;
    Ok(ExitCode::SUCCESS)
}

fn describe_image(image: &SensorImage) -> String {
    let most = image.dn.iter().max().copied().unwrap_or(0);
    let [x, y] = image.offset;
    format!("sensor image, {} x {} px from column {x}, row {y}; brightest {most} DN\n", image.cols, image.rows)
}

/// What a scan holds; rows pass through, so its length does not matter.
fn describe(reader: &mut ScanReader) -> Result<String, Fault> {
    let mut planes = Vec::new();
    let (mut missing, mut low, mut high) = (0_usize, f64::INFINITY, f64::NEG_INFINITY);
    let (mut saturated, mut encoder): (usize, Option<(i32, i32)>) = (0, None);
    for from in (0..reader.rows()).step_by(ROWS_AT_A_TIME) {
        let scan = reader.read(from, ROWS_AT_A_TIME)?;
        for z in scan.heights() {
            missing += usize::from(!z.is_finite());
            (low, high) = (low.min(z), high.max(z));
        }
        saturated += scan.light_dn().map_or(0, |dn| dn.iter().filter(|dn| **dn == u8::MAX).count());
        if let Some(marks) = &scan.marks
            && let (Some(first), Some(last)) = (marks.first(), marks.last())
        {
            encoder = Some((encoder.map_or(first.encoder, |(first, _)| first), last.encoder));
        }
        planes = names(&scan);
    }
    let (width, rows) = (reader.width(), reader.rows());
    let mut text = format!("scan, {width} columns x {rows} profiles: {}\n", planes.join(", "));
    // Writing to a string cannot fail.
    let unit = match reader.traits() {
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
            let [from, to] = [world.lower[0], world.upper[0]];
            let col = world.col_mm(width);
            let _ = writeln!(text, "calibrated: x {from} to {to} mm, {col:.6} mm a column; between profiles {step}");
            "mm"
        }
    };
    let all = (width * rows).max(1) as f64;
    let _ = writeln!(
        text,
        "missing {:.2} %, saturated {:.2} %",
        100.0 * missing as f64 / all,
        100.0 * saturated as f64 / all
    );
    if low <= high {
        let _ = writeln!(text, "Range {low:.4} to {high:.4} {unit}");
    }
    if let Some((first, last)) = encoder {
        let _ = writeln!(text, "encoder {first} to {last}");
    }
    Ok(text)
}

fn names(scan: &IconScan) -> Vec<&'static str> {
    let range = match scan.range {
        RangeValues::Steps(_) => "Range WORD",
        RangeValues::World(_) => "Range FLOAT",
    };
    let light = scan.light.as_ref().map(|light| match light {
        PeakLight::Intensity(_) => "Intensity BYTE",
        PeakLight::Reflectance(_) => "Reflectance BYTE",
    });
    let scatter = scan.scatter.as_ref().map(|scatter| match scatter {
        Scatter::Byte(_) => "Scatter BYTE",
        Scatter::Word(_) => "Scatter WORD",
    });
    [Some(range), light, scatter, scan.marks.as_ref().map(|_| "Mark")].into_iter().flatten().collect()
}
