//! MVTec 3D-AD layout: beside each picture the places of its pixels, and a mask.
//!
//! ```text
//! <split>/<good or defect>/rgb/<name>.png    .../xyz/<name>.tiff    test/<good or defect>/gt/<name>.png
//! ```
//!
//! `xyz` is TIFF with three 32-bit floats a pixel: x along the laser line, y along the scan, z upwards [mm], and three
//! zeros where nothing was measured. Where Range is calibrated, x follows from the camera: a column looks along a line,
//! and x is where that has the measured height.

use std::io::Cursor;
use std::path::Path;

use clap::Args;
use output_schema::DatasetHead;
use serde_json::Value;
use tiff::TiffError;
use tiff::encoder::TiffEncoder;
use tiff::encoder::colortype::RGB32Float;

use super::anomaly::{AnomalyLayout, AnomalyOptions, AnomalyPart, write};
use super::export_folder::{ExportFolder, ExportSummary};
use super::format::{Export, ExportFormat};
use super::map_scale::physical_scale;
use super::sample::{ExportSample, Region};
use super::source::{ExportProgress, ExportSource};
use dataset::Fault;
use optical_bench::lens::Distortion;
use optical_bench::split::Split;

pub(super) const FORMAT: ExportFormat = ExportFormat::of::<Mvtec3d>(
    "mvtec3d",
    "MVTec 3D-AD folders",
    ["mvtec3d packs --out packs-3d", "pictures and places of pixels for anomaly detection"],
);

const LAYOUT: AnomalyLayout = AnomalyLayout { name: FORMAT.name, splits: &Split::ALL, images: &["range"], put };

/// Rows of a strip of TIFF [px].
const STRIP_ROWS: usize = 64;

/// Folders as MVTec 3D-AD has them: rgb, xyz and gt of each picture
#[derive(Debug, Args)]
struct Mvtec3d {
    #[command(flatten)]
    options: AnomalyOptions,
}

impl Export for Mvtec3d {
    fn check(&self) -> Result<(), String> {
        self.options.pictures.check()
    }

    fn write(&self, source: &ExportSource, out: &Path, progress: ExportProgress) -> Result<ExportSummary, Fault> {
        if source.head().range_unit() == "px" {
            let what = "its Range is sensor rows, and the layout holds places in mm";
            let remedy = "make it anew without `extraction: {range: uncalibrated}`, or export it as mvtec";
            return Err(Fault::at(source.root(), what, remedy));
        }
        write(LAYOUT, &self.options, source, out, progress)
    }
}

fn put(out: &ExportFolder, part: &AnomalyPart) -> Result<(), Fault> {
    let AnomalyPart { sample, region, split, folder, name, .. } = part;
    let folder = format!("{}/{folder}", split.name());
    out.put(&format!("{folder}/rgb/{name}.png"), || Ok(part.picture().colours().png()))?;
    out.put(&format!("{folder}/xyz/{name}.tiff"), || {
        let places = PixelPlaces::of(sample)?;
        places.tiff(*region).map_err(|e| sample.fault(format!("the places of its pixels are no TIFF: {e}")))
    })?;
    if *split == Split::Test {
        out.put(&format!("{folder}/gt/{name}.png"), || Ok(part.mask()))?;
    }
    Ok(())
}

/// Where the pixels of a sample lie.
struct PixelPlaces {
    cols: usize,
    /// Numbers of Range; 0 is missing.
    range: Vec<u16>,
    /// Height: offset and scale of Range [mm].
    height_mm: [f64; 2],
    row_mm: f64,
    columns: ColumnPlaces,
}

/// Where columns look.
enum ColumnPlaces {
    /// On an even grid: the first column and the distance between two [mm].
    Even([f64; 2]),
    /// Along lines of sight.
    Seen(ColumnSight),
}

/// What decides where in the laser plane a column of the sensor looks.
struct ColumnSight {
    /// From the lens to the origin [mm].
    distance: f64,
    /// Sine and cosine of the angle between the optical axis and the laser plane.
    tilt: [f64; 2],
    /// Slope of the sensor about its rows.
    lean: f64,
    /// Directions of columns without distortion: that of the first one and the step [1].
    direction: [f64; 2],
    distortion: Distortion,
}

impl PixelPlaces {
    fn of(sample: &ExportSample) -> Result<Self, Fault> {
        let number = |name: &str| sample.row.number(name).map_err(|what| sample.fault(what));
        let columns = match sample.head().images.range.as_str() {
            "rectified" => ColumnPlaces::Even([calibration(sample, "x_first_mm")?, number("col_mm")?]),
            _ => ColumnPlaces::Seen(ColumnSight::of(sample, sample.head())?),
        };
        Ok(Self {
            cols: sample.cols,
            range: sample.grey("range")?.numbers(),
            height_mm: physical_scale(sample, "range")?,
            row_mm: number("row_mm")?,
            columns,
        })
    }

    /// x, y and z of a pixel [mm].
    fn place(&self, row: usize, col: usize) -> [f32; 3] {
        let n = self.range[row * self.cols + col];
        if n == 0 {
            return [0.0; 3];
        }
        let z = self.height_mm[0] + self.height_mm[1] * f64::from(n);
        let x = match &self.columns {
            ColumnPlaces::Even([first, step]) => first + step * col as f64,
            ColumnPlaces::Seen(sight) => sight.along(col as f64, z),
        };
        [x, self.row_mm * row as f64, z].map(|mm| mm as f32)
    }

    /// A part of it as TIFF.
    fn tiff(&self, region: Region) -> Result<Vec<u8>, TiffError> {
        let Region { top, left, rows, cols } = region;
        let mut file = Cursor::new(Vec::new());
        // Not compressed: places hardly are, and the crate writes strips as they come.
        let mut encoder = TiffEncoder::new(&mut file)?;
        let mut image = encoder.new_image::<RGB32Float>(cols as u32, rows as u32)?;
        image.rows_per_strip(STRIP_ROWS as u32)?;
        for first in (top..top + rows).step_by(STRIP_ROWS) {
            let lines = first..(first + STRIP_ROWS).min(top + rows);
            let places = lines.flat_map(|row| (left..left + cols).flat_map(move |col| self.place(row, col)));
            image.write_strip(&places.collect::<Vec<f32>>())?;
        }
        image.finish()?;
        Ok(file.into_inner())
    }
}

impl ColumnSight {
    fn of(sample: &ExportSample, head: &DatasetHead) -> Result<Self, Fault> {
        let number = |name: &str| calibration(sample, name);
        let [tilt, sensor_tilt] = [number("tilt_deg")?, number("sensor_tilt_deg")?].map(f64::to_radians);
        let (sin, cos) = libm::sincos(tilt);
        // A column of the image is the middle of those of the sensor that it averages.
        let binned = head.images.sensor_cols as f64 / sample.cols as f64;
        let step = 1e-3 * number("pixel_um")? / number("image_distance_mm")?;
        let first = (0.5 * binned - 0.5 - number("centre_col_px")?) * step;
        Ok(Self {
            distance: number("distance_mm")?,
            tilt: [sin, cos],
            lean: libm::tan(sensor_tilt),
            direction: [first, step * binned],
            distortion: Distortion {
                radial: [number("k1")?, number("k2")?, number("k3")?],
                tangential: [number("p1")?, number("p2")?],
            },
        })
    }

    /// Place along the laser line of a height `z` that is seen in a column [mm].
    fn along(&self, col: f64, z: f64) -> f64 {
        let [sin, cos] = self.tilt;
        let depth = self.distance - z * cos;
        let [first, step] = self.direction;
        self.distortion.seen_in_column(first + step * col, self.lean, z * sin / depth) * depth
    }
}

/// A number of `calibration`.
fn calibration(sample: &ExportSample, name: &str) -> Result<f64, Fault> {
    let number = sample.row.values.get("calibration").and_then(|all| all.get(name)).and_then(Value::as_f64);
    number.ok_or_else(|| sample.fault(format!("`calibration.{name}` is no number")))
}
