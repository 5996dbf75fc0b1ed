//! `gen fibres`: fibre directions, knots and absorption of a board from a picture of it.

use std::f32::consts::{FRAC_PI_2, PI};
use std::fmt::Write;
use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits, Rgb, RgbImage};
use serde_json::{Value, json};

use super::output::{self, Written};
use super::{CommandResult, DONE, UsageError, print};
use crate::generate::MemoryEstimate;
use dataset::{ExrChannel, Fault, write_exr};
use output_schema::SampleType;
use procedural::wood::Wood;
use wood_picture::{Encoding, Face, FibreMap, PictureAnalysis, face_absorption, fibre_map};

/// Version of the document's layout.
const SCHEMA_VERSION: u32 = 1;
/// Longest side of a picture [px]: a board of 6 m at 0.37 mm.
const MAX_SIDE: u32 = 16_384;
/// Rows of a picture that are taken over at a time.
const STRIP_ROWS: usize = 64;
/// Most bytes of a PNG: four numbers of 16 bits a pixel, and what stands around them.
const MAX_FILE_BYTES: u64 = 8 * (MAX_SIDE as u64).pow(2) + (16 << 20);

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen fibres board.png --pixel-mm 0.1 --encoding srgb                    board.fibres.exr and board.fibres.png
  gen fibres reflectance.png --pixel-mm 0.068,0.092 --encoding linear    a scan: rows are 0.068 mm, columns 0.092 mm
  gen fibres board.png --pixel-mm 0.1 --encoding srgb --json | jq .knots

docs/theory/boards-from-pictures.md says how it works, how good it is, and when not to trust it.")]
pub(super) struct FibresArgs {
    /// PNG with 8 or 16 bits, - for standard input; of a colour picture the red channel counts, which is nearest to the
    /// laser
    picture: PathBuf,
    /// Size of a pixel, or down the rows and across them [mm]
    #[arg(long, value_name = "MM[,MM]", value_parser = pixel_sides)]
    pixel_mm: [f32; 2],
    /// How its numbers go with light; absorption follows from light
    #[arg(long, value_enum)]
    encoding: EncodingName,
    /// The power of light that a number to 1 is turned into, for `--encoding gamma`
    #[arg(long, value_name = "POWER", required_if_eq("encoding", "gamma"))]
    gamma: Option<f32>,
    /// Which side of the board it shows
    #[arg(long, value_enum, default_value_t = FaceName::Bark)]
    face: FaceName,
    /// Length (down the rows) and width of the board, if the picture shows all of it: its size is then checked [mm]
    #[arg(long, value_name = "LENGTH,WIDTH", value_parser = board_sides)]
    board_mm: Option<[f32; 2]>,
    /// Least width of a knot [mm]
    #[arg(long, value_name = "MM", default_value_t = PictureAnalysis::default().least_knot_mm)]
    least_knot_mm: f32,
    /// Where the maps go [default: the picture's name with .fibres.exr]; a picture of them lies beside it, .png
    #[arg(short, long, value_name = "FILE", value_parser = output::file("exr"))]
    out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EncodingName {
    /// In proportion to light: raw files, Reflectance of a scan less its dark level
    Linear,
    /// The curve of ordinary files
    Srgb,
    /// A power, given with --gamma
    Gamma,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FaceName {
    /// The pith lies below it
    Bark,
    /// The pith lies above it
    Pith,
}

pub(super) fn run(arguments: &FibresArgs) -> CommandResult {
    let settings = settings(arguments)?;
    let out = match &arguments.out {
        Some(out) => out.clone(),
        None if files::is_standard_input(&arguments.picture) => {
            return Err(UsageError("standard input has no name beside which maps could go: give --out".into()).into());
        }
        None => arguments.picture.with_extension("fibres.exr"),
    };
    let view = out.with_extension("png");
    if output::resolve(&view) == output::resolve(&arguments.picture) {
        return Err(
            UsageError(format!("{} would be replaced: choose another --out", arguments.picture.display())).into()
        );
    }
    output::check_replaceable(&out, Written::Exr)?;
    output::check_replaceable(&view, Written::Png)?;
    let (grey, size) = read(&arguments.picture)?;
    let told = |fault: wood_picture::PictureFault| format!("{}: {fault}", arguments.picture.display());
    let fibres = fibre_map(&grey, size, arguments.pixel_mm, &settings).map_err(told)?;
    // The kinds of wood of the class table: what a picture without a scale of reflectance is held to.
    let wood = Wood::from_values(&mut |parameter| parameter.default);
    let mu_a = face_absorption(&grey, &fibres, &wood.media, wood.log.latewood_share, &settings).map_err(told)?;
    drop(grey);
    let document = document(&fibres, &mu_a);
    let told = if arguments.json { format!("{document:#}\n") } else { text(&fibres, &out, &view) };
    let picture = output::png(&directions(&fibres))?;
    output::write(&out, &maps(fibres, mu_a, &document))?;
    output::write(&view, &picture)?;
    print(&told)?;
    Ok(DONE)
}

/// Lengths above 0 between commas.
fn lengths(text: &str) -> Result<Vec<f32>, String> {
    let length = |part: &str| part.trim().parse().ok().filter(|mm: &f32| *mm > 0.0 && mm.is_finite());
    text.split(',').map(length).collect::<Option<_>>().ok_or_else(|| "give lengths above 0 in mm".into())
}

/// The sides of a pixel, down the rows and across them: one number where they are alike [mm].
fn pixel_sides(text: &str) -> Result<[f32; 2], String> {
    match lengths(text)?[..] {
        [side] => Ok([side; 2]),
        [down, across] => Ok([down, across]),
        _ => Err("give one number, or two with a comma: down the rows and across them [mm]".into()),
    }
}

/// Length and width of a board [mm].
fn board_sides(text: &str) -> Result<[f32; 2], String> {
    match lengths(text)?[..] {
        [length, width] => Ok([length, width]),
        _ => Err("give two numbers with a comma: length (down the rows) and width [mm]".into()),
    }
}

fn settings(arguments: &FibresArgs) -> Result<PictureAnalysis, UsageError> {
    let encoding = match (arguments.encoding, arguments.gamma) {
        (EncodingName::Linear, None) => Encoding::Linear,
        (EncodingName::Srgb, None) => Encoding::Srgb,
        (EncodingName::Gamma, Some(gamma)) => Encoding::Gamma(gamma),
        _ => return Err(UsageError("--gamma belongs to --encoding gamma: give both, or neither".into())),
    };
    if !(arguments.least_knot_mm > 0.0 && arguments.least_knot_mm.is_finite()) {
        return Err(UsageError("--least-knot-mm: give a width above 0".into()));
    }
    let face = match arguments.face {
        FaceName::Bark => Face::Bark,
        FaceName::Pith => Face::Pith,
    };
    let (board_mm, least_knot_mm) = (arguments.board_mm, arguments.least_knot_mm);
    Ok(PictureAnalysis { encoding, full_scale: 1.0, board_mm, face, least_knot_mm, ..PictureAnalysis::default() })
}

/// Numbers of a picture from 0 to 1, its rows and columns.
fn read(path: &Path) -> Result<(Vec<f32>, [usize; 2]), String> {
    let told = |error: &dyn std::fmt::Display, remedy: &str| format!("{}: {error}; {remedy}", files::shown(path));
    let unreadable = |error: std::io::Error| told(&error, "name a picture that can be read");
    let decoded = if files::is_standard_input(path) {
        let bytes = files::read_or_standard_input(path, MAX_FILE_BYTES).map_err(unreadable)?;
        decode(Cursor::new(bytes))
    } else {
        let (file, _) = files::open_within(path, MAX_FILE_BYTES).map_err(unreadable)?;
        decode(BufReader::new(file))
    };
    decoded.map_err(|error| match error.downcast::<Fault>() {
        Ok(fault) => fault.to_string(),
        Err(error) => told(&error, &format!("give a PNG of at most {MAX_SIDE} pixels a side")),
    })
}

/// The same of the bytes of a PNG.
fn decode(bytes: impl BufRead + Seek) -> CommandResult<(Vec<f32>, [usize; 2])> {
    let mut reader = ImageReader::with_format(bytes, ImageFormat::Png);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    // Memory is asked for below, all of it together.
    limits.max_alloc = Some(MAX_FILE_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder()?;
    let (cols, rows) = decoder.dimensions();
    MemoryEstimate::of_picture(u64::from(cols) * u64::from(rows)).check()?;
    let picture = DynamicImage::from_decoder(decoder)?;
    let mut grey = Vec::with_capacity(cols as usize * rows as usize);
    let number = |number: u16| f32::from(number) / 65535.0;
    // Strip by strip: the whole picture in other numbers would be there twice more.
    for first in (0..rows).step_by(STRIP_ROWS) {
        let strip = picture.crop_imm(0, first, cols, (rows - first).min(STRIP_ROWS as u32));
        if strip.color().has_color() {
            grey.extend(strip.into_rgb16().pixels().map(|pixel| number(pixel.0[0])));
        } else {
            grey.extend(strip.into_luma16().into_raw().into_iter().map(number));
        }
    }
    Ok((grey, [rows as usize, cols as usize]))
}

/// The maps as an EXR file: twice the azimuth by cosine and sine, dive [deg], confidence, absorption at the face
/// [mm^-1].
fn maps(fibres: FibreMap, mu_a: Vec<f32>, document: &Value) -> Vec<u8> {
    let FibreMap { size, pixel_mm, azimuth_rad, dive_rad, confidence, .. } = fibres;
    let (sin, cos) = azimuth_rad.into_iter().map(|azimuth| libm::sincosf(2.0 * azimuth)).unzip();
    let channel = |name: &str, numbers: Vec<f32>| ExrChannel { name: name.into(), samples: SampleType::Float, numbers };
    let mut channels = vec![
        channel("Absorption", mu_a),
        channel("FibreConfidence", confidence),
        channel("FibreCos2", cos),
        channel("FibreDive", dive_rad.into_iter().map(f32::to_degrees).collect()),
        channel("FibreSin2", sin),
    ];
    channels.sort_by(|a, b| a.name.cmp(&b.name));
    let [down, across] = pixel_mm.map(f64::from);
    write_exr(channels, size[1], (across, down), document)
}

/// Azimuth as hue over half a turn, confidence as its strength; knots' outlines in black.
fn directions(fibres: &FibreMap) -> RgbImage {
    let [rows, cols] = fibres.size;
    RgbImage::from_fn(cols as u32, rows as u32, |x, y| {
        let pixel = y as usize * cols + x as usize;
        let place = fibres.place_mm(pixel);
        let line = fibres.pixel_mm[0].max(fibres.pixel_mm[1]);
        let on_outline =
            |knot: &wood_picture::PictureKnot| (knot.within(place) - 1.0).abs() * knot.half_axes_mm[1] < line;
        if fibres.knots.iter().any(on_outline) {
            return Rgb([0; 3]);
        }
        let turn = (fibres.azimuth_rad[pixel] + FRAC_PI_2) / PI;
        let strength = fibres.confidence[pixel].clamp(0.0, 1.0);
        Rgb([0.0, 1.0 / 3.0, 2.0 / 3.0].map(|phase| {
            let wave = 0.5 + 0.5 * libm::cosf(2.0 * PI * (turn - phase));
            (255.0 * (1.0 + strength * (wave - 1.0))) as u8
        }))
    })
}

fn document(fibres: &FibreMap, mu_a: &[f32]) -> Value {
    let knots: Vec<Value> = fibres
        .knots
        .iter()
        .map(|knot| {
            json!({
                "x_mm": knot.centre_mm.x, "y_mm": knot.centre_mm.y,
                "length_mm": 2.0 * knot.half_axes_mm[0], "width_mm": 2.0 * knot.half_axes_mm[1],
                "azimuth_deg": knot.azimuth_rad.to_degrees(), "dive_deg": knot.dive_rad().to_degrees(),
                "end_confidence": knot.end_confidence, "brightness": knot.brightness, "dead": knot.dead,
            })
        })
        .collect();
    json!({
        "schema_version": SCHEMA_VERSION, "rows": fibres.size[0], "columns": fibres.size[1],
        "pixel_mm": fibres.pixel_mm, "mean_confidence": mean(&fibres.confidence),
        "mean_absorption_per_mm": mean(mu_a), "knots": knots,
    })
}

fn mean(numbers: &[f32]) -> f64 {
    numbers.iter().map(|&number| f64::from(number)).sum::<f64>() / numbers.len().max(1) as f64
}

fn text(fibres: &FibreMap, out: &Path, view: &Path) -> String {
    let mut azimuths: Vec<f32> = fibres.azimuth_rad.iter().map(|azimuth| azimuth.to_degrees()).collect();
    let middle = azimuths.len() / 2;
    let azimuth = *azimuths.select_nth_unstable_by(middle, f32::total_cmp).1;
    let mut text = format!(
        "{} x {} px; azimuth {:.1} deg (median), confidence {:.2} (mean); {} knots\n",
        fibres.size[1],
        fibres.size[0],
        azimuth,
        mean(&fibres.confidence),
        fibres.knots.len()
    );
    for knot in &fibres.knots {
        let kind = if knot.dead { "dead" } else { "sound" };
        let [long, wide] = knot.half_axes_mm.map(|half| 2.0 * half);
        let (at, dive) = (knot.centre_mm, knot.dive_rad().to_degrees());
        _ = writeln!(
            text,
            "  {kind} knot at {:.1}, {:.1} mm: {long:.1} x {wide:.1} mm, dive {dive:.0} deg",
            at.x, at.y
        );
    }
    _ = writeln!(text, "{}: maps\n{}: directions as hue", out.display(), view.display());
    text
}
