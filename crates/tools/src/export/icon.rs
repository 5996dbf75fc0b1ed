//! iCon files: a `.dat` and an `.xml`, as the real camera writes them, for each chosen sample.

use std::path::Path;

use clap::Args;
use output_schema::{DatasetHead, Manifest};
use serde_json::json;

use super::export_folder::{ExportFolder, ExportSummary};
use super::format::{Export, ExportFormat};
use super::sample::key;
use super::source::{ExportProgress, ExportSource};
use crate::compare::{RangeUnit, ScanMaps, SensorFrame, frame_of};
use crate::icon::{IconFiles, IconScan, PlaneContent, PlaneNumbers, SensorImage, SensorTraits, Traits, WorldTraits};
use dataset::Fault;

pub(super) const FORMAT: ExportFormat = ExportFormat::of::<Icon>(
    "icon",
    "files of the real camera",
    ["icon planks --out scans --index 3", "files of the real camera"],
);

/// Files of the real camera (iCon .dat and .xml), one pair for each sample
#[derive(Debug, Args)]
struct Icon {
    /// Heights as WORD instead of FLOAT
    #[arg(long)]
    words: bool,
    /// Profiles a second, for the timestamps in Mark [default: 1000]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    rate: Option<f64>,
    /// The middle sensor frame of each sample instead of its scan
    #[arg(long)]
    sensor: bool,
}

/// A number of profiles a second.
fn rate(text: &str) -> Result<f64, String> {
    let rate: f64 = text.parse().map_err(|_| "it is no number".to_owned())?;
    if (0.001..=1e6).contains(&rate) { Ok(rate) } else { Err("give 0.001 to 1000000 Hz".into()) }
}

impl Icon {
    /// Profiles a second [Hz].
    fn rate_hz(&self) -> f64 {
        self.rate.unwrap_or(1000.0)
    }

    /// The files of a sample.
    fn files(&self, source: &ExportSource, manifest: &Manifest, index: u64) -> Result<IconFiles, Fault> {
        let frame = frame_of(&source.dataset, manifest, index, self.sensor)?;
        if !self.sensor {
            return Ok(scan(frame, self).files());
        }
        let middle = frame.exposures.len() / 2;
        let missing = || Fault::damaged(frame.name.as_ref(), "it has no sensor frame");
        let SensorFrame { cols, dn, .. } = frame.exposures.into_iter().nth(middle).ok_or_else(missing)?;
        Ok(SensorImage { cols, rows: dn.len() / cols.max(1), offset: [0, 0], dn }.files())
    }
}

impl Export for Icon {
    fn check(&self) -> Result<(), String> {
        let idle = [(self.words, "--words", "heights"), (self.rate.is_some(), "--rate", "marks")];
        match idle.into_iter().find(|(given, ..)| self.sensor && *given) {
            Some((_, option, what)) => Err(format!(
                "{option} is of the {what} of scans, and --sensor writes sensor frames; leave one of them away"
            )),
            None => Ok(()),
        }
    }

    fn check_for(&self, head: &DatasetHead) -> Result<(), String> {
        if self.words && head.range_unit() == "px" {
            let what = "--words has no effect: heights of an uncalibrated dataset are sensor rows, which always are \
                WORD; \
                leave it away";
            return Err(what.into());
        }
        Ok(())
    }

    fn write(&self, source: &ExportSource, out: &Path, progress: ExportProgress) -> Result<ExportSummary, Fault> {
        let images = &source.head().images;
        if images.bits > 8 {
            let what = format!("its numbers have {} bits, and the camera's files hold 8", images.bits);
            return Err(Fault::at(source.root(), what, "set `exposure: {bits: 8}` in the recipe and make it anew"));
        }
        if source.head().range_unit() == "px" && images.binned_columns() > 1 {
            let what = "its sensor rows are means of several columns, which no camera writes";
            return Err(Fault::at(source.root(), what, "make it anew without `output: {bin: ..}`"));
        }
        if self.sensor && images.stack_every.is_none() {
            let remedy = "set `output: {sensor_stack: {every: 100}}` in the recipe and make it anew";
            return Err(Fault::at(source.root(), "no sensor frame was kept", remedy));
        }
        let asked = json!({"words": self.words, "rate_hz": self.rate_hz(), "sensor": self.sensor});
        ExportFolder::write(out, FORMAT.name, asked, source, |out| {
            let work = |manifest: &Manifest, index: u64| {
                let [data, description] = ["dat", "xml"].map(|extension| format!("{}.{extension}", key(index)));
                let is_done = out.length(&data)?.is_some() && out.length(&description)?.is_some();
                let files = if is_done { IconFiles::default() } else { self.files(source, manifest, index)? };
                out.put(&data, || Ok(files.data))?;
                out.put(&description, || Ok(files.description.into_bytes()))
            };
            source.each_index(work, progress)?;
            out.finish(&json!({"samples": source.samples}), Vec::new())
        })
    }
}

/// Mark of one profile: an encoder that counts micrometres of travel, and a clock that counts microseconds; status,
/// pulse and scan are 0.
fn mark(profile: usize, row_mm: f64, rate: f64) -> [u32; 5] {
    // The counters of the camera have 32 bits and wrap.
    let encoder = (profile as f64 * row_mm * 1e3).round() as i64 as i32;
    let timestamp = (profile as f64 * 1e6 / rate).round() as u64 as u32;
    [encoder.cast_unsigned(), 0, timestamp, 0, 0]
}

/// A sample as the camera would have stored it.
fn scan(frame: ScanMaps, options: &Icon) -> IconScan {
    let valid = || frame.range.iter().filter(|z| z.is_finite());
    let low = valid().copied().reduce(f64::min).unwrap_or(0.0);
    let high = valid().copied().reduce(f64::max).unwrap_or(0.0);
    let (col_mm, row_mm) = (frame.col_mm.unwrap_or(1.0), frame.row_mm.unwrap_or(0.0));
    let width = frame.cols as f64 * col_mm;
    let left = frame.first_mm.map_or(-width / 2.0, |first| first - col_mm / 2.0);
    let traits = match frame.unit {
        RangeUnit::Mm => {
            Traits::World(WorldTraits { lower: [left, low], upper: [left + width, high], row_mm: frame.row_mm })
        }
        RangeUnit::Px { sensor_rows } => Traits::Sensor(SensorTraits::new(sensor_rows, [0.0, 0.0])),
    };
    let heights = if options.words || frame.unit != RangeUnit::Mm {
        PlaneNumbers::Word(frame.range.iter().map(|&z| traits.steps(z)).collect())
    } else {
        PlaneNumbers::Float(frame.range.iter().map(|&z| float_height(z as f32)).collect())
    };
    // Casts of floats saturate.
    let bytes = |map: &Vec<f32>| PlaneNumbers::Byte(map.iter().map(|dn| dn.round() as u8).collect());
    let words = |map: &Vec<f32>| PlaneNumbers::Word(map.iter().map(|dn| dn.round() as u16).collect());
    let marks = (0..frame.rows).flat_map(|profile| mark(profile, row_mm, options.rate_hz()));
    let planes = [
        (PlaneContent::Range, Some(heights)),
        (PlaneContent::Reflectance, frame.reflectance.as_ref().map(bytes)),
        (PlaneContent::Scatter, frame.scatter.as_ref().map(words)),
        (PlaneContent::Mark, Some(PlaneNumbers::Int(marks.collect()))),
    ];
    let planes = planes.into_iter().filter_map(|(part, numbers)| Some((part, numbers?))).collect();
    IconScan { width: frame.cols, rows: frame.rows, traits, planes }
}

/// A height as FLOAT: 0 means missing, so a height of just 0 is the least number above.
fn float_height(height: f32) -> f32 {
    if height.is_nan() {
        0.0
    } else if height == 0.0 {
        f32::MIN_POSITIVE
    } else {
        height
    }
}
