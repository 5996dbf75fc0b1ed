//! `gen icon`: samples as files of the real camera, and what such files hold.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use output_schema::file::DATASET;

use super::progress::say;
use super::{Outcome, Usage, print, whole};
use crate::compare::{Dataset, Frame, Unit};
use crate::icon::{
    Content, IconError, Light, Mark, Range, Scan, ScanReader, ScanWriter, Scatter, SensorImage, SensorTraits, Traits,
    WorldTraits, open, write_image,
};

/// Rows that are handled at a time.
const ROWS: usize = 256;

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen icon planks --index 3 --out plank            writes plank.dat and plank.xml
  gen icon planks --index 3 --out plank --words    heights as 16-bit steps instead of floats
  gen icon planks --index 3 --out plank --rate 7000  timestamps of 7000 profiles a second
  gen icon planks --index 3 --out frame --sensor   the middle one of its sensor frames
  gen icon plank.xml                               what a file holds

A dataset made with `extraction: {range: uncalibrated}` becomes an uncalibrated scan, Range in
sixteenths of a sensor row; others become calibrated ones. Mark holds an encoder that counts
micrometres and a clock that counts microseconds.

docs/files/icon.md describes the files.")]
pub(super) struct Icon {
    /// A dataset to take a sample from, or the .xml of a file to look at
    path: PathBuf,
    /// Which sample [default: 0]
    #[arg(long, value_name = "I", requires = "out")]
    index: Option<u64>,
    /// Where the files go: NAME.dat and NAME.xml
    #[arg(long, value_name = "NAME")]
    out: Option<PathBuf>,
    /// Heights as WORD instead of FLOAT
    #[arg(long, requires = "out")]
    words: bool,
    /// Profiles a second, for the timestamps in Mark
    #[arg(long, value_name = "HZ", requires = "out", default_value_t = 1000.0, value_parser = rate)]
    rate: f64,
    /// A sensor frame instead of the scan
    #[arg(long, requires = "out", conflicts_with = "words")]
    sensor: bool,
}

pub(super) fn run(arguments: &Icon) -> Outcome {
    let is_dataset = arguments.path.join(DATASET).is_file();
    match &arguments.out {
        Some(_) if !is_dataset => {
            let path = arguments.path.display();
            Err(Usage(format!(
                "{path} holds no {DATASET}: name the folder of a dataset, or leave --out away to look at a file"
            ))
            .into())
        }
        Some(out) => {
            let (data, text) = (beside(out, "dat"), beside(out, "xml"));
            whole::check(&data)?;
            let dataset = Dataset::open(&arguments.path)?;
            let frame = dataset.frame(arguments.index.unwrap_or(0))?;
            if frame.bits > 8 {
                let what = format!("its numbers have {} bits, and the camera's files hold 8", frame.bits);
                let remedy = "set `exposure: {bits: 8}` in the recipe and make it anew";
                return Err(format!("{}: {what}; {remedy}", arguments.path.display()).into());
            }
            if frame.unit != Unit::Mm && dataset.binned_columns() > 1 {
                let what = "its sensor rows are means of several columns, which no camera writes";
                let place = arguments.path.display();
                return Err(format!("{place}: {what}; make it anew without `output: {{bin: ..}}`").into());
            }
            if arguments.sensor {
                sensor(out, &frame)?
            } else {
                export(out, &frame, arguments)?
            }
            say(&format!("{}, {}", data.display(), text.display()));
            Ok(ExitCode::SUCCESS)
        }
        None if is_dataset => {
            Err(Usage("a dataset has many samples: choose one with --index I and a place with --out NAME".into())
                .into())
        }
        None => {
            print(&match open(&arguments.path)? {
                Content::Scan(mut reader) => describe(&mut reader)?,
                Content::Image(image) => describe_image(&image),
            });
            Ok(ExitCode::SUCCESS)
        }
    }
}

fn beside(out: &Path, extension: &str) -> PathBuf {
    match out.extension() {
        Some(known) if known == "dat" || known == "xml" => out.with_extension(extension),
        _ => PathBuf::from(format!("{}.{extension}", out.display())),
    }
}

/// A number of profiles a second.
fn rate(text: &str) -> Result<f64, String> {
    let rate: f64 = text.parse().map_err(|_| "it is no number".to_owned())?;
    if (0.001..=1e6).contains(&rate) { Ok(rate) } else { Err("give 0.001 to 1000000 Hz".into()) }
}

/// Notes of one profile: an encoder that counts micrometres of the way, and a clock that counts microseconds.
fn mark(profile: usize, row_mm: f64, rate: f64) -> Mark {
    // The counters of the camera have 32 bits and wrap.
    let encoder = (profile as f64 * row_mm * 1e3).round() as i64 as i32;
    let timestamp = (profile as f64 * 1e6 / rate).round() as u64 as u32;
    Mark { encoder, timestamp, ..Mark::default() }
}

fn export(out: &Path, frame: &Frame, arguments: &Icon) -> Result<(), IconError> {
    let valid = || frame.range.iter().filter(|z| z.is_finite());
    let low = valid().copied().reduce(f64::min).unwrap_or(0.0);
    let high = valid().copied().reduce(f64::max).unwrap_or(0.0);
    let (col_mm, row_mm) = (frame.col_mm.unwrap_or(1.0), frame.row_mm.unwrap_or(0.0));
    let width = frame.cols as f64 * col_mm;
    let left = frame.first_mm.map_or(-width / 2.0, |first| first - col_mm / 2.0);
    let traits = match frame.unit {
        Unit::Mm => {
            Traits::World(WorldTraits { lower: [left, low], upper: [left + width, high], row_mm: frame.row_mm })
        }
        Unit::Px { sensor_rows } => Traits::Sensor(SensorTraits::new(sensor_rows, [0.0, 0.0])),
    };
    let words = arguments.words || frame.unit != Unit::Mm;
    let rows = |from: usize, to: usize| {
        let pixels = from * frame.cols..to * frame.cols;
        let heights = &frame.range[pixels.clone()];
        let part = |map: &Option<Vec<f32>>| map.as_ref().map(|map| map[pixels.clone()].to_vec());
        Scan {
            width: frame.cols,
            rows: to - from,
            traits,
            range: if words {
                Range::Steps(heights.iter().map(|&z| traits.steps(z)).collect())
            } else {
                Range::World(heights.iter().map(|&z| written(z as f32)).collect())
            },
            // Casts of floats saturate.
            light: part(&frame.reflectance)
                .map(|map| Light::Reflectance(map.into_iter().map(|dn| dn.round() as u8).collect())),
            scatter: part(&frame.scatter)
                .map(|map| Scatter::Word(map.into_iter().map(|dn| dn.round() as u16).collect())),
            marks: Some((from..to).map(|profile| mark(profile, row_mm, arguments.rate)).collect()),
        }
    };
    let mut writer = ScanWriter::create(out, &rows(0, 0), frame.rows)?;
    for from in (0..frame.rows).step_by(ROWS) {
        writer.push(&rows(from, (from + ROWS).min(frame.rows)))?;
    }
    writer.finish()
}

/// A height as FLOAT: 0 means missing, so a height of just 0 is the least number above.
fn written(height: f32) -> f32 {
    if height.is_nan() {
        0.0
    } else if height == 0.0 {
        f32::MIN_POSITIVE
    } else {
        height
    }
}

fn sensor(out: &Path, frame: &Frame) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let Some(exposure) = frame.exposures.get(frame.exposures.len() / 2) else {
        let what =
            "no sensor frame was kept; set `output: {sensor_stack: {every: 100}}` in the recipe and make it anew";
        return Err(format!("{}: {what}", frame.name).into());
    };
    let rows = exposure.dn.len() / exposure.cols.max(1);
    let image = SensorImage { cols: exposure.cols, rows, offset: [0, 0], dn: exposure.dn.clone() };
    Ok(write_image(out, &image)?)
}

fn describe_image(image: &SensorImage) -> String {
    let most = image.dn.iter().max().copied().unwrap_or(0);
    let [x, y] = image.offset;
    format!("sensor image, {} x {} px from column {x}, row {y}; brightest {most} DN\n", image.cols, image.rows)
}

/// What a scan holds; rows pass through, so its length does not matter.
fn describe(reader: &mut ScanReader) -> Result<String, IconError> {
    let mut planes = Vec::new();
    let (mut missing, mut low, mut high) = (0_usize, f64::INFINITY, f64::NEG_INFINITY);
    let (mut saturated, mut encoder): (usize, Option<(i32, i32)>) = (0, None);
    for from in (0..reader.rows()).step_by(ROWS) {
        let scan = reader.read(from, ROWS)?;
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

fn names(scan: &Scan) -> Vec<&'static str> {
    let range = match scan.range {
        Range::Steps(_) => "Range WORD",
        Range::World(_) => "Range FLOAT",
    };
    let light = scan.light.as_ref().map(|light| match light {
        Light::Intensity(_) => "Intensity BYTE",
        Light::Reflectance(_) => "Reflectance BYTE",
    });
    let scatter = scan.scatter.as_ref().map(|scatter| match scatter {
        Scatter::Byte(_) => "Scatter BYTE",
        Scatter::Word(_) => "Scatter WORD",
    });
    [Some(range), light, scatter, scan.marks.as_ref().map(|_| "Mark")].into_iter().flatten().collect()
}
