//! The channels of `exr/*/*.exr`: one layer, scan lines from the top, row 0 exposed first.
//!
//! `dataset/src/exr.rs` writes a channel, and the rule `exr` of validate checks it.

use self::SampleType::*;
use crate::row::LIGHT;

/// Type of a channel's samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleType {
    /// 16-bit float: whole numbers up to 2048 are exact.
    Half,
    /// 32-bit float: whole numbers up to 16 777 216 are exact.
    Float,
    /// 32-bit unsigned whole number.
    Uint,
}

impl SampleType {
    /// Name in OpenEXR.
    pub fn name(self) -> &'static str {
        match self {
            Self::Half => "HALF",
            Self::Float => "FLOAT",
            Self::Uint => "UINT",
        }
    }
}

/// A form in which Range is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WrittenRange {
    /// Value of `images.range` in `dataset.json`.
    pub name: &'static str,
    /// Unit of Range.
    pub unit: &'static str,
    /// Values that it may take.
    pub range: &'static str,
    /// What it means.
    pub doc: &'static str,
}

/// Every form of Range.
pub const RANGE_FORMS: [WrittenRange; 3] = [
    WrittenRange {
        name: "calibrated",
        unit: "mm",
        range: "any",
        doc: "Measured height at each sensor column. Columns are not evenly apart; `calibration` says where they see.",
    },
    WrittenRange {
        name: "uncalibrated",
        unit: "px",
        range: "0 to sensor_rows - 1",
        doc: "Sensor row of the laser line at each sensor column, row 0 at the top; `calibration` makes heights of it.",
    },
    WrittenRange {
        name: "rectified",
        unit: "mm",
        range: "any",
        doc: "Measured height on an even grid along the line: column j stands at calibration.x_first_mm + j * col_mm.",
    },
];

/// The form of that name.
pub fn range_form(name: &str) -> Option<WrittenRange> {
    RANGE_FORMS.into_iter().find(|form| form.name == name)
}

/// The declaration of one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel {
    /// Name in the file.
    pub name: &'static str,
    /// The key that asks for it: a name in `images.exr` of `dataset.json`, or `truth_maps`.
    pub asked_by: &'static str,
    /// The subject whose files have it; empty for all.
    pub subject: &'static str,
    /// Type of the samples.
    pub samples: SampleType,
    /// Unit.
    pub unit: &'static str,
    /// Values that it may take.
    pub range: &'static str,
    /// How a missing value is written.
    pub missing: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// Why this type.
    pub why: &'static str,
}

impl Channel {
    /// A channel of every subject whose missing values are NaN.
    const fn new(
        name: &'static str,
        asked_by: &'static str,
        samples: SampleType,
        unit: &'static str,
        range: &'static str,
    ) -> Self {
        Self { name, asked_by, subject: "", samples, unit, range, missing: "NaN", doc: "", why: "" }
    }

    /// The same in files of one subject alone.
    const fn of(self, subject: &'static str) -> Self {
        Self { subject, ..self }
    }

    /// The same with another way to write missing values.
    const fn missing(self, missing: &'static str) -> Self {
        Self { missing, ..self }
    }

    /// The same with its meaning, and why it has this type.
    const fn means(self, doc: &'static str, why: &'static str) -> Self {
        Self { doc, why, ..self }
    }
}

/// Every channel in the order of files (by name, as OpenEXR asks).
pub const CHANNELS: [Channel; 13] = [
    Channel::new("FibreAzimuth", "truth_maps", Half, "deg", "-90 to 90")
        .of("wood")
        .means("Angle of the fibre in the surface against the scan direction.", "rounded by at most 0.03 deg"),
    Channel::new("FibreDive", "truth_maps", Half, "deg", "-90 to 90").of("wood").means(
        "Angle by which the fibre, followed along `FibreAzimuth`, runs below the surface; where it rises, below 0.",
        "rounded by at most 0.03 deg",
    ),
    Channel::new("FilmGap", "truth_maps", Half, "mm", "0 or more").of("blister").means(
        "Air between the film and what it covers; 0 where it is sealed, or where there is no film.",
        "rounded by at most 2 um below 8 mm",
    ),
    Channel::new("FilmThickness", "truth_maps", Half, "mm", "0 or more")
        .of("blister")
        .means("Thickness of the film; 0 where there is none.", "rounded by at most 0.2 um below 0.5 mm"),
    Channel::new("Grey", "grey", Half, "DN", "1 to 255, or to the end of 10 or 12 bits").means(
        "Digital number under lamps beside the laser; a whole number unless binned. Missing where the lens does not \
         see the pixel's point.",
        "as Reflectance",
    ),
    Channel::new("Height", "truth_maps", Float, "mm", "any").means(
        "True height of the surface.",
        "half would round 20 mm to 0.016 mm; written in steps of 2^-13 mm (0.12 um), which compress",
    ),
    Channel::new("Instance", "instance", Float, "", "0 for none, else `objects.instance`")
        .missing("never")
        .means("Which defect or pocket each pixel really shows.", "exact; half is up to 2048 only"),
    Channel::new("Label", "label", Half, "", "number of a pixel class")
        .missing("never")
        .means("What each pixel really shows.", "exact"),
    Channel::new("Range", "range", Float, "mm or px", "see Range").means(
        "What was measured, in the form that `images.range` names.",
        "half would round 20 mm to 0.016 mm; written in steps of 2^-13 mm (0.12 um) or px, which compress",
    ),
    Channel::new("RangeRest", "range_rest", Uint, "", "0, else about 2^15").missing("0").means(
        "What a number of the image `range` leaves: 2^15 and so many steps of 2^-13 mm or px more. 0 where the same \
         number has left as much higher up in its column. Its height, offset + number * scale as float32 in such \
         steps, and what it leaves are Range to the last bit.",
        "whole numbers, most of them 0, hardly take room",
    ),
    Channel::new("Reflectance", "reflectance", Half, "DN", "0 to 255, or to the end of 10 or 12 bits").means(
        "Digital number at the peak of the laser line; a whole number unless binned or rectified.",
        "whole numbers are exact, others rounded by at most 0.0625 DN, far below the noise; FLOAT for more than 8 bits",
    ),
    Channel::new("Scatter", "scatter", Float, "DN", "0 or more").means(
        "Sum of digital numbers beside the peak.",
        "sums pass 2048, where half is not exact, and may pass its end at 65504",
    ),
    Channel::new("Y", "reflectance", Half, "DN", "as Reflectance").missing("0").means(
        "Reflectance once more, 0 where missing, under the name that OpenCV and viewers look for.",
        "as Reflectance",
    ),
];

/// Shape of every channel, row-major.
pub const CHANNEL_SHAPE: &str = "[rows, cols]";

/// The one text attribute that holds units, spacing and id as ASCII JSON.
pub const ATTRIBUTE: &str = "sheetlight";

/// The channels that a file holds, given the asked images, whether truth maps are written, the subject, the name of the
/// form of Range, and the bits of a digital number; none where there is no file.
pub fn channels(asked: &[String], truth_maps: bool, subject: &str, range: &str, bits: u64) -> Vec<Channel> {
    let asks =
        |c: &Channel| if c.asked_by == "truth_maps" { truth_maps } else { asked.iter().any(|a| a == c.asked_by) };
    let holds = |c: &Channel| asks(c) && (c.subject.is_empty() || c.subject == subject);
    let formed = |c: Channel| match range_form(range).filter(|_| c.name == "Range") {
        Some(form) => Channel { unit: form.unit, range: form.range, doc: form.doc, ..c },
        // Halfs are whole numbers up to 2048 only.
        None if bits > 8 && LIGHT.contains(&c.asked_by) => Channel { samples: Float, ..c },
        None => c,
    };
    CHANNELS.into_iter().filter(|c| holds(c)).map(formed).collect()
}
