//! The settings of a recipe by path, and as the plain structs that the rest of the program takes.

use std::collections::BTreeMap;

use super::picture;
use super::setting::Value;
use crate::asset::Asset;
use crate::settings::{
    Channel, Direction, Extraction, Fan, Filter, Hdr, LensModel, Line, Method, Optics, Order, Output, Pattern, Peak,
    Postprocess, RangeForm, Readout, ScatterDark, ScatterMode, Scheimpflug, SensorStack, Shape, Size, SpeckleLaw,
    Splits, ThesisMethod, Transport, Way,
};

/// Every setting that has an effect by its path; a path or kind that the tables do not declare is a mistake of ours and panics in each test.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Settings(pub BTreeMap<String, Value>);

impl Settings {
    /// The setting at `path`.
    pub fn get(&self, path: &str) -> Value {
        self.0.get(path).cloned().unwrap_or_else(|| panic!("no table declares {path}"))
    }

    /// The whole number at `path`.
    pub fn count(&self, path: &str) -> usize {
        match self.get(path) {
            Value::Count(count) => count,
            other => panic!("{path} is {other:?}"),
        }
    }

    /// The number at `path`.
    pub fn number(&self, path: &str) -> f64 {
        match self.get(path) {
            Value::Number(number) => number,
            other => panic!("{path} is {other:?}"),
        }
    }

    /// The file at `path`; `None` where the recipe names none.
    pub fn file(&self, path: &str) -> Option<&Asset> {
        match self.0.get(path) {
            Some(Value::File(file)) => Some(file),
            _ => None,
        }
    }

    /// Every file with the key that names it, by key.
    pub fn files(&self) -> impl Iterator<Item = (&str, &Asset)> {
        self.0.iter().filter_map(|(path, value)| match value {
            Value::File(file) => Some((path.as_str(), file)),
            _ => None,
        })
    }

    /// Sizes of the scan.
    pub fn size(&self) -> Size {
        let [columns, rows, profiles] = ["scan.columns", "camera.rows", "scan.profiles"].map(|path| self.count(path));
        Size { columns, rows, profiles }
    }

    /// How the sensor is read out.
    pub fn readout(&self) -> Readout {
        let name = self.word("exposure.hdr");
        let hdr = Hdr::ALL.into_iter().find(|known| known.name() == name);
        // The table ends bits at 12.
        Readout { bits: self.count("exposure.bits") as u32, hdr: hdr.unwrap_or_else(|| panic!("no slopes {name}")) }
    }

    /// What is done to frames before they are read; numbers that have no effect are 0.
    pub fn postprocess(&self) -> Postprocess {
        let has = |name: &str| self.0.contains_key(&format!("postprocess.{name}"));
        let number = |name: &str| if has(name) { self.number(&format!("postprocess.{name}")) } else { 0.0 };
        let count = |name: &str| if has(name) { self.count(&format!("postprocess.{name}")) } else { 0 };
        let order = self.word("postprocess.order");
        let order = Order::ALL.into_iter().find(|known| known.name() == order);
        Postprocess {
            order: order.unwrap_or_else(|| panic!("no such order")),
            blur_radius_px: number("blur_radius_px"),
            intensity_scale: number("intensity_scale"),
            pattern: Pattern {
                size_px: count("pattern_px"),
                mask_px: count("mask_px"),
                factor: count("sampling_factor"),
                law: self.speckle_law(),
            },
        }
    }

    /// Lens and shape of the laser's line.
    pub fn fan(&self) -> (Fan, Shape) {
        let (fan, shape) = (self.word("laser.fan"), self.word("laser.profile"));
        let named = |names: &[&str], name| names.iter().position(|known| *known == name).unwrap_or_default();
        (Fan::ALL[named(&Fan::NAMES, fan)], Shape::ALL[named(&Shape::NAMES, shape)])
    }

    /// What of the laser is not drawn.
    pub fn line(&self) -> Line {
        let (fan, shape) = self.fan();
        // A file that is no picture is a fault of the recipe.
        let picture = self.file("laser.texture").and_then(|file| picture::read(file.bytes()).ok());
        Line { fan, shape, picture }
    }

    /// What of the camera is the same for all samples.
    pub fn optics(&self) -> Optics {
        let chosen = |path: &str, word: &str| self.word(path) == word;
        Optics {
            scheimpflug: if chosen("camera.scheimpflug", "given") { Scheimpflug::Given } else { Scheimpflug::Solved },
            lens: if chosen("camera.lens", "pinhole") { LensModel::Pinhole } else { LensModel::ThinLens },
            filter: if chosen("camera.filter", "band_pass") { Filter::BandPass } else { Filter::None },
            diffraction: self.get("camera.diffraction") == Value::Flag(true),
            offset_columns: self.number("camera.offset_columns"),
            offset_rows: self.number("camera.offset_rows"),
        }
    }

    /// How a profile is read.
    pub fn extraction(&self) -> Extraction {
        let method = match self.word("extraction.method") {
            "parabola" => Method::Parabola,
            "gaussian" => Method::Gaussian,
            "blais_rioux" => Method::BlaisRioux { order: self.count("extraction.blais_rioux_order") },
            "fir" => Method::Fir { length: self.count("extraction.fir_length") },
            _ => Method::CentreOfGravity,
        };
        let mode = self.word("extraction.scatter_mode");
        Extraction {
            method,
            peak: match self.word("extraction.peak") {
                "first" => Peak::First,
                _ => Peak::Strongest,
            },
            direction: match self.word("extraction.direction") {
                "reverse" => Direction::Reverse,
                _ => Direction::Standard,
            },
            window_rows: match method {
                Method::Parabola | Method::Gaussian => 1,
                _ => self.count("extraction.window_rows"),
            },
            threshold_dn: self.number("extraction.threshold_dn") * self.readout().scale(),
            // The table ends it at 256.
            subpixel_steps: self.count("extraction.subpixel_steps") as u32,
            scatter_mode: ScatterMode::ALL
                .into_iter()
                .find(|known| known.name() == mode)
                .unwrap_or_else(|| panic!("no scatter mode {mode:?}")),
            scatter_offset_rows: self.count("extraction.scatter_offset_rows"),
            scatter_width_rows: self.count("extraction.scatter_width_rows"),
            scatter_dark: match self.word("extraction.scatter_dark") {
                "subtracted" => ScatterDark::Subtracted,
                _ => ScatterDark::Kept,
            },
            range: match self.word("extraction.range") {
                "uncalibrated" => RangeForm::Uncalibrated,
                "rectified" => RangeForm::Rectified {
                    pitch_mm: match self.get("extraction.rectified_pitch_mm") {
                        Value::Number(mm) => Some(mm),
                        _ => None,
                    },
                },
                _ => RangeForm::Calibrated,
            },
        }
    }

    /// How light spreads below the surface.
    pub fn transport(&self) -> Transport {
        match self.word("transport.model") {
            "kernel" => Transport::Kernel,
            "path" => Transport::Path { photons: self.count("transport.photons_per_profile") as u64 },
            "diffusion" => Transport::Diffusion { voxel_mm: self.number("transport.voxel_mm") },
            "thesis" => {
                let name = self.word("transport.method");
                let method = ThesisMethod::ALL.into_iter().find(|method| method.name() == name);
                let method = method.unwrap_or_else(|| panic!("no method {name}"));
                let iterations = if method.iterates() { self.count("transport.iterations") } else { 0 };
                Transport::Thesis { method, iterations, pixel_mm: self.number("transport.pixel_mm") }
            }
            other => panic!("no model {other}"),
        }
    }

    /// How the object moves.
    pub fn way(&self) -> Way {
        if self.word("motion.kind") == "turntable" { Way::Turntable } else { Way::Linear }
    }

    /// Law of speckle in a point.
    pub fn speckle_law(&self) -> SpeckleLaw {
        let name = self.word("speckle.law");
        SpeckleLaw::ALL.into_iter().find(|law| law.name() == name).unwrap_or_else(|| panic!("no law {name}"))
    }

    /// What is written.
    pub fn output(&self) -> Output {
        Output {
            bin_columns: self.count("output.bin.columns"),
            bin_profiles: self.count("output.bin.profiles"),
            png: self.channels("output.png"),
            exr: self.channels("output.exr"),
            truth_maps: self.get("output.truth_maps") == Value::Flag(true),
            sensor_stack: match self.get("output.sensor_stack") {
                Value::Every(k) => SensorStack::Every(k),
                Value::Word("all") => SensorStack::All,
                _ => SensorStack::None,
            },
            samples_per_shard: match self.get("output.samples_per_shard") {
                Value::Count(samples) => Some(samples),
                _ => None,
            },
            bits: self.readout().bits,
        }
    }

    /// Shares of the splits.
    pub fn splits(&self) -> Splits {
        let [train, validation, test] =
            ["train", "validation", "test"].map(|name| self.number(&format!("splits.{name}")));
        Splits { train, validation, test }
    }

    /// The word at `path`, where there is one.
    pub fn word_or_none(&self, path: &str) -> Option<&'static str> {
        match self.0.get(path) {
            Some(Value::Word(word)) => Some(word),
            _ => None,
        }
    }

    fn word(&self, path: &str) -> &'static str {
        match self.get(path) {
            Value::Word(word) => word,
            other => panic!("{path} is {other:?}"),
        }
    }

    fn channels(&self, path: &str) -> Vec<Channel> {
        match self.get(path) {
            Value::Channels(chosen) => Channel::chosen(chosen),
            other => panic!("{path} is {other:?}"),
        }
    }
}
