//! `gen fibres`: fibre directions, knots and absorption of a board from a picture of it.

use std::f32::consts::PI;
use std::fmt::Write;
use std::io::{BufRead, BufReader, Cursor, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use glam::Vec2;
use image::{DynamicImage, ImageDecoder, ImageReader, Limits, Rgb, RgbImage};
use serde_json::{Value, json};

use super::output::{self, Written};
use super::{CommandResult, DONE, UsageError, print};
use crate::generate::MemoryEstimate;
use dataset::{ExrChannel, Fault, write_exr};
use output_schema::SampleType;
use procedural::wood::Wood;
use wood_picture::{BoardPart, Encoding, Face, FibreMap, Findings, PictureAnalysis, analyse, face_absorption};

/// Directions are drawn so far apart [mm].
const STROKE_MM: f32 = 3.0;
/// Version of the document's layout.
const SCHEMA_VERSION: u32 = 1;
/// Longest side of a picture [px]: a board of 6 m at 0.37 mm.
const MAX_SIDE: u32 = 16_384;
/// Most pixels for each byte of a file [1]: photographs have 30 at most, and headers that promise more are broken.
const MOST_PIXELS_A_BYTE: u64 = 500;
/// Rows of a picture that are taken over at a time.
const STRIP_ROWS: usize = 64;
/// Most bytes of a picture: four numbers of 16 bits a pixel, and what stands around them.
const MAX_FILE_BYTES: u64 = 8 * (MAX_SIDE as u64).pow(2) + (16 << 20);

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen fibres board.jpg --pixel-mm 0.08,0.05 --encoding srgb              board.fibres.exr and board.fibres.png
  gen fibres reflectance.png --pixel-mm 0.068,0.092 --encoding linear    a scan: rows are 0.068 mm, columns 0.092 mm
  gen fibres board.png --pixel-mm 0.1 --encoding srgb --json | jq .knots

docs/theory/boards-from-pictures.md says how it works, how good it is, and when not to trust it.")]
pub(super) struct FibresArgs {
    /// JPEG, PNG, TIFF or BMP, - for standard input; of a colour picture the red channel counts, nearest to the laser.
    /// A dark belt around the board is cut off
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
    /// Which way the length of the board lies in it; fibres run within 45 degrees of that
    #[arg(long, value_enum, default_value_t = LengthName::Down)]
    length: LengthName,
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
enum LengthName {
    /// Down the rows
    Down,
    /// Along the rows
    Across,
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
    let (grey, whole) = read(&arguments.picture)?;
    let part = BoardPart::of(&grey, whole, settings.encoding);
    let size = part.size;
    let grey = if size == whole { grey } else { part.cut(&grey, whole[1]) };
    let told = |fault: wood_picture::PictureFault| format!("{}: {fault}", arguments.picture.display());
    let (fibres, findings) = analyse(&grey, size, arguments.pixel_mm, &settings).map_err(told)?;
    // The kinds of wood of the class table: what a picture without a scale of reflectance is held to.
    let wood = Wood::from_values(&mut |parameter| parameter.default);
    let (mu_a, glossy) =
        face_absorption(&grey, &fibres, &wood.media, wood.log.latewood_share, &settings).map_err(told)?;
    let picture = output::png(&directions(&grey, &fibres))?;
    drop(grey);
    let report = Report { fibres: &fibres, findings, part, glossy };
    let document = report.document(&mu_a);
    let told = if arguments.json { format!("{document:#}\n") } else { report.text(&out, &view) };
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
    Ok(PictureAnalysis {
        encoding,
        full_scale: 1.0,
        board_mm: arguments.board_mm,
        lies_across: arguments.length == LengthName::Across,
        face,
        least_knot_mm: arguments.least_knot_mm,
        ..PictureAnalysis::default()
    })
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
        Err(error) => told(&error, &format!("give a JPEG, PNG, TIFF or BMP of at most {MAX_SIDE} pixels a side")),
    })
}

/// The same of the bytes of a picture.
fn decode(mut bytes: impl BufRead + Seek) -> CommandResult<(Vec<f32>, [usize; 2])> {
    let length = bytes.seek(SeekFrom::End(0))?;
    bytes.rewind()?;
    let mut reader = ImageReader::new(bytes).with_guessed_format()?;
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    // Memory is asked for below, all of it together.
    limits.max_alloc = Some(MAX_FILE_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder()?;
    let (cols, rows) = decoder.dimensions();
    if u64::from(cols) * u64::from(rows) > MOST_PIXELS_A_BYTE * length {
        return Err(format!("{length} bytes are too few for its {cols} x {rows} pixels").into());
    }
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

/// Directions drawn over the picture, yellow where they are sure and grey where they are not; knots outlined, sound
/// ones in green and dead ones in red.
fn directions(grey: &[f32], fibres: &FibreMap) -> RgbImage {
    let [rows, cols] = fibres.size;
    let mut picture = RgbImage::from_fn(cols as u32, rows as u32, |x, y| {
        Rgb([(255.0 * grey[y as usize * cols + x as usize].clamp(0.0, 1.0)) as u8; 3])
    });
    let pixel_mm = Vec2::new(fibres.pixel_mm[1], fibres.pixel_mm[0]);
    let mut draw = |place: Vec2, colour: [u8; 3]| {
        let at = (place / pixel_mm).floor();
        if at.cmpge(Vec2::ZERO).all() && at.x < cols as f32 && at.y < rows as f32 {
            picture.put_pixel(at.x as u32, at.y as u32, Rgb(colour));
        }
    };
    let step = 0.5 * pixel_mm.min_element();
    let line = |count: f32| (0..=(2.0 * count / step) as usize).map(move |i| i as f32 * step - count);
    let extent = Vec2::new(cols as f32, rows as f32) * pixel_mm;
    for row in 0..(extent.y / STROKE_MM) as usize {
        for col in 0..(extent.x / STROKE_MM) as usize {
            let middle = STROKE_MM * Vec2::new(col as f32 + 0.5, row as f32 + 0.5);
            let at = middle / pixel_mm;
            let pixel = at.y as usize * cols + at.x as usize;
            let along = fibres.fibre(pixel).truncate();
            let sure = fibres.confidence[pixel].clamp(0.0, 1.0);
            let colour = [255.0, 220.0, 0.0].map(|full: f32| (sure * full + (1.0 - sure) * 128.0) as u8);
            line(0.4 * STROKE_MM).for_each(|off| draw(middle + off * along, colour));
        }
    }
    for knot in &fibres.knots {
        let colour = if knot.dead { [230, 0, 0] } else { [0, 200, 0] };
        let (sin, cos) = libm::sincosf(knot.azimuth_rad);
        let [long, short] = knot.half_axes_mm;
        let turns = (2.0 * PI * long / step) as usize;
        for turn in 0..turns {
            let (y, x) = libm::sincosf(2.0 * PI * turn as f32 / turns as f32);
            let off = Vec2::new(long * x * sin + short * y * cos, long * x * cos - short * y * sin);
            for wide in [0.99, 1.0, 1.01] {
                draw(knot.centre_mm + wide * off, colour);
            }
        }
    }
    picture
}

/// What is told of a board.
struct Report<'a> {
    fibres: &'a FibreMap,
    findings: Findings,
    /// Where it lies in the picture.
    part: BoardPart,
    /// Share of its pixels that are brighter than wood [1].
    glossy: f64,
}

impl Report<'_> {
    fn document(&self, mu_a: &[f32]) -> Value {
        let Self { fibres, findings, part, glossy } = self;
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
        let marks = findings.marks.map(|marks| json!({"pitch_mm": marks.pitch_mm, "strength": marks.strength}));
        json!({
            "schema_version": SCHEMA_VERSION, "rows": fibres.size[0], "columns": fibres.size[1],
            "first_row": part.first[0], "first_column": part.first[1],
            "pixel_mm": fibres.pixel_mm, "azimuth_deg": findings.azimuth_rad.to_degrees(),
            "azimuth_error_deg": findings.error_rad.to_degrees(), "marks": marks,
            "mean_confidence": mean(&fibres.confidence), "mean_absorption_per_mm": mean(mu_a),
            "glossy_share": glossy, "clipped_share": findings.clipped_share, "knots": knots,
        })
    }

    fn text(&self, out: &Path, view: &Path) -> String {
        let Self { fibres, findings, part, glossy } = self;
        let [rows, cols] = fibres.size;
        let mut text = format!(
            "{cols} x {rows} px; azimuth {:.1} deg +- {:.1}, confidence {:.2} (mean); {} knots\n",
            findings.azimuth_rad.to_degrees(),
            findings.error_rad.to_degrees(),
            mean(&fibres.confidence),
            fibres.knots.len()
        );
        if part.first != [0, 0] {
            _ = writeln!(text, "  the board begins at column {}, row {}", part.first[1], part.first[0]);
        }
        if let Some(marks) = findings.marks {
            let pitch = marks.pitch_mm.map_or_else(String::new, |mm| format!(" every {mm:.1} mm"));
            _ = writeln!(text, "  marks across the grain{pitch} were taken out");
        }
        if findings.clipped_share > 0.0 {
            _ = writeln!(text, "  {:.1} % of it have reached the end of the scale", 100.0 * findings.clipped_share);
        }
        if *glossy > 0.0 {
            _ = writeln!(text, "  {:.1} % of it are brighter than wood: gloss or torn fibres", 100.0 * glossy);
        }
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
        _ = writeln!(text, "{}: maps\n{}: directions and knots over the picture", out.display(), view.display());
        text
    }
}

fn mean(numbers: &[f32]) -> f64 {
    numbers.iter().map(|&number| f64::from(number)).sum::<f64>() / numbers.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use image::{DynamicImage, ImageFormat};

    use super::*;

    /// Three hundred broken files: a fault or a picture, and no panic.
    #[test]
    fn broken_pictures_are_told() {
        let board = image::load_from_memory(include_bytes!("../../recipes/pictures/board.png")).expect("a picture");
        let board: DynamicImage = image::imageops::crop_imm(&board, 0, 0, 160, 160).to_image().into();
        let board: DynamicImage = board.into_rgb8().into();
        let settings = PictureAnalysis { encoding: Encoding::Srgb, ..PictureAnalysis::default() };
        let (mut state, mut told, mut read) = (7_u64, 0, 0);
        let mut draw = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        for format in [ImageFormat::Jpeg, ImageFormat::Tiff, ImageFormat::Bmp] {
            let mut file = Cursor::new(Vec::new());
            board.write_to(&mut file, format).expect("encoded");
            let file = file.into_inner();
            let whole = decode(Cursor::new(&file)).expect("a picture");
            assert!(whole.1 == [160, 160] && analyse(&whole.0, whole.1, [0.15; 2], &settings).is_ok());
            for number in 0..100 {
                let mut broken = file.clone();
                // Headers first: they say how large all the rest is.
                let among = if number % 2 == 0 { broken.len().min(700) } else { broken.len() };
                for _ in 0..1 + draw(4) {
                    let at = draw(among);
                    broken[at] = draw(256) as u8;
                }
                if number % 5 == 0 {
                    broken.truncate(1 + draw(file.len()));
                }
                match decode(Cursor::new(&broken)) {
                    Err(error) => told += usize::from(!error.to_string().is_empty()),
                    Ok((grey, size)) => {
                        assert_eq!(grey.len(), size[0] * size[1]);
                        read += 1;
                        if number % 4 == 0 {
                            _ = analyse(&grey, size, [0.15; 2], &settings);
                        }
                    }
                }
            }
        }
        assert!(told + read == 300 && told > 50 && read > 50, "{told} told, {read} read");
    }
}
