//! Pictures that boards are cut from: picture of a face, maps of fibres, pictures of classes ->
//! `wood_picture::BoardPicture`.
//!
//! Everything is read and analysed once, with the recipe, and the fibres of a picture are kept for the next run, so
//! that a picture that does not serve is a fault of the recipe; samples share what comes of it. Rows are brought to the
//! order of the scan: the first row of a photograph from above is the far end. Colours of directions are those of the
//! thesis (section 3.2.3, Figure 3.9): between red and green the slope is R / G, rising, between blue and green B / G,
//! falling; as a vector (G, R - B), right and up as the map is looked at. Limits: memory is 20 bytes a pixel, and some
//! times that while the picture is analysed.

use std::io::Cursor;

use base::Class;
use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers, read};
use files::Cache;
use image::{DynamicImage, ImageDecoder, ImageError, ImageReader, Limits};
use wood_picture::{BoardPart, BoardPicture, Depth, Encoding, FibreMap, PictureAnalysis, PictureFault};

use crate::asset::{Asset, AssetFault};
use crate::keys::settings::PictureSettings;
use crate::subject::Subject;
use analysed::fibres_of;
use optical_bench::settings::{FirstRow, PictureDepth, PictureEncoding};

mod analysed;

/// Longest side [px].
const MAX_SIDE: u32 = 16_384;
/// Most pixels: a board of 2.4 m by 0.25 m at 0.14 mm [px].
const MAX_PIXELS: usize = 32 << 20;
/// Most channels of an EXR.
const MAX_CHANNELS: usize = 16;
/// Share of light below which a patch of a drawn map is looked at as a knot: 0.5 in the thesis.
const LEAST_SHARE: f32 = 0.02;

/// What the settings name; the key that a fault belongs to comes with it.
pub(crate) fn read_picture(own: &PictureSettings) -> Result<Option<BoardPicture>, (&'static str, AssetFault)> {
    const FILE: &str = "picture.file";
    const FIBRES: &str = "picture.fibres";
    const LABELS: &str = "picture.labels";
    let pixel_mm = [own.pixel_mm, own.pixel_across_mm.unwrap_or(own.pixel_mm)].map(|mm| mm as f32);
    let depth = match own.depth {
        PictureDepth::Feature => Depth::Feature,
        PictureDepth::Even => Depth::Even(own.depth_mm as f32),
    };
    let analysis = PictureAnalysis {
        encoding: match own.encoding {
            PictureEncoding::Srgb => Encoding::Srgb,
            PictureEncoding::Linear => Encoding::Linear,
            PictureEncoding::Gamma => Encoding::Gamma(own.gamma as f32),
        },
        face: own.face,
        least_knot_mm: own.least_knot_mm as f32,
        ..PictureAnalysis::default()
    };
    let lens = RowOrder { is_far: own.first_row == FirstRow::Far };
    let read = |file| grey(file, own.dark as f32, analysis.encoding, &lens).map(|grey| (file, grey));
    let grey = own.file.asset().map(read).transpose().map_err(|fault| (FILE, fault))?;
    let board = grey.as_ref().map(|(_, (_, whole, part))| (*whole, *part));
    let read = |file| fibres(file, pixel_mm, own.least_knot_mm as f32, &lens).map(|fibres| (file, fibres));
    let drawn = own.fibres.asset().map(read).transpose().map_err(|fault| (FIBRES, fault))?;
    let told = |key: &'static str, file: &Asset| {
        let name = file.name().to_owned();
        move |fault: PictureFault| (key, AssetFault::told(&name, &fault, "give another picture"))
    };
    let picture = match (grey, drawn) {
        (Some((file, (grey, _, BoardPart { size, .. }))), drawn) => {
            let map = match drawn {
                Some((_, (map, _))) if map.size != size => return Err((FIBRES, other_size(map.size, size))),
                Some((_, (map, _))) => Ok(map),
                None => fibres_of(Cache::of_user().as_ref(), &grey, size, pixel_mm, &analysis),
            };
            let picture = map.and_then(|map| BoardPicture::with_fibres(&grey, map, &analysis, depth));
            picture.map_err(told(FILE, file))?
        }
        (None, Some((file, (map, shares)))) => {
            BoardPicture::drawn(&shares, map, own.face, depth).map_err(told(FIBRES, file))?
        }
        (None, None) => return Ok(None),
    };
    let Some(file) = own.labels.asset() else { return Ok(Some(picture)) };
    let size = picture.fibres().size;
    let (whole, part) = board.unwrap_or((size, BoardPart { first: [0, 0], size }));
    let classes = labels(file, whole, part, &lens).map_err(|fault| (LABELS, fault))?;
    Ok(Some(picture.labelled(classes).map_err(told(LABELS, file))?))
}

/// Order of a file's rows.
struct RowOrder {
    /// The first row is the far end.
    is_far: bool,
}

impl RowOrder {
    /// Rows in the order of the scan.
    fn sorted<T: Copy>(&self, pixels: Vec<T>, cols: usize) -> Vec<T> {
        if self.is_far { pixels.chunks(cols).rev().flatten().copied().collect() } else { pixels }
    }
}

fn other_size(found: [usize; 2], wanted: [usize; 2]) -> AssetFault {
    let [[rows, cols], [all_rows, all_cols]] = [found, wanted];
    AssetFault::new(
        format!("it has {cols} x {rows} pixels, and the picture has {all_cols} x {all_rows}"),
        "give a map of the same picture, pixel by pixel",
    )
}

/// A reader that refuses pictures of more rows or columns than `most`.
pub(crate) fn limited(mut reader: ImageReader<Cursor<&[u8]>>, most: u32) -> ImageReader<Cursor<&[u8]>> {
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(most), Some(most));
    reader.limits(limits);
    reader
}

/// Pixels of a PNG, JPEG, TIFF or BMP.
fn pixels(file: &Asset) -> Result<DynamicImage, AssetFault> {
    let reader = ImageReader::new(Cursor::new(file.bytes())).with_guessed_format().expect("memory can be read");
    let unreadable = |error: ImageError| {
        AssetFault::new(
            format!("`{}` is no picture that can be read: {error}", file.name()),
            format!("save it as PNG or JPEG of at most {MAX_SIDE} pixels a side"),
        )
    };
    let decoder = limited(reader, MAX_SIDE).into_decoder().map_err(unreadable)?;
    let (cols, rows) = decoder.dimensions();
    check_size(file, cols as usize, rows as usize)?;
    DynamicImage::from_decoder(decoder).map_err(unreadable)
}

fn check_size(file: &Asset, cols: usize, rows: usize) -> Result<(), AssetFault> {
    if cols.saturating_mul(rows) > MAX_PIXELS {
        let problem = format!("`{}` has {cols} x {rows} pixels, more than {MAX_PIXELS}", file.name());
        return Err(AssetFault::new(problem, "crop it, or average pixels to 0.15 mm"));
    }
    Ok(())
}

/// Numbers of a picture's board from 0 to 1 less the dark level, of colours red; the picture's size, and where in it
/// the board lies.
fn grey(
    file: &Asset,
    dark: f32,
    encoding: Encoding,
    rows: &RowOrder,
) -> Result<(Vec<f32>, [usize; 2], BoardPart), AssetFault> {
    let picture = pixels(file)?;
    let size = [picture.height() as usize, picture.width() as usize];
    let number = |raw: u16| (f32::from(raw) / 65535.0 - dark).max(0.0) / (1.0 - dark);
    let grey: Vec<f32> = if picture.color().has_color() {
        picture.into_rgb16().pixels().map(|pixel| number(pixel.0[0])).collect()
    } else {
        picture.into_luma16().into_raw().into_iter().map(number).collect()
    };
    let part = BoardPart::of(&grey, size, encoding);
    Ok((rows.sorted(part.cut(&grey, size[1]), part.size[1]), size, part))
}

/// Classes of a board in a grey PNG of 8 bits; 0 is clear wood.
fn labels(file: &Asset, wanted: [usize; 2], part: BoardPart, rows: &RowOrder) -> Result<Vec<Class>, AssetFault> {
    let picture = pixels(file)?;
    let DynamicImage::ImageLuma8(picture) = picture else {
        let problem = format!("`{}` has {:?} pixels, and classes are grey of 8 bits", file.name(), picture.color());
        return Err(AssetFault::new(problem, "save it as PNG with 8 bits and one grey channel, without a palette"));
    };
    let size = [picture.height() as usize, picture.width() as usize];
    if size != wanted {
        return Err(other_size(size, wanted));
    }
    let class =
        |(pixel, number): (usize, u8)| {
            let is_of_wood = |class: &Class| class.subject() == Some(Subject::Wood.name());
            let number = if number == 0 { Class::Clear as u8 } else { number };
            Class::of(number).filter(is_of_wood).ok_or_else(|| {
            let (row, col) = (pixel / size[1], pixel % size[1]);
            let others = Class::ALL.into_iter().filter(|class| is_of_wood(class) && *class > Class::Rot);
            let others: Vec<String> = others.map(|class| (class as u8).to_string()).collect();
            AssetFault::new(
                format!("`{}` has the number {number} in row {row}, column {col}, which is no class of \
                    wood", file.name()),
                format!(
                    "give numbers of pixel classes: 1 clear, 2 sound_knot, 3 dead_knot, 4 rot, or others of wood as \
                        labels have \
                     them: {}",
                    others.join(", ")
                ),
            )
        })
        };
    let classes = picture.into_raw().into_iter().enumerate().map(class).collect::<Result<Vec<_>, _>>()?;
    Ok(rows.sorted(part.cut(&classes, size[1]), part.size[1]))
}

/// A map of fibres, and the share of clear wood's light in each pixel.
fn fibres(
    file: &Asset,
    pixel_mm: [f32; 2],
    least_knot_mm: f32,
    rows: &RowOrder,
) -> Result<(FibreMap, Vec<f32>), AssetFault> {
    if file.name().to_ascii_lowercase().ends_with(".exr") {
        exr(file, pixel_mm, rows)
    } else {
        colours(file, pixel_mm, least_knot_mm, rows)
    }
}

/// The thesis' colours.
fn colours(
    file: &Asset,
    pixel_mm: [f32; 2],
    least_knot_mm: f32,
    rows: &RowOrder,
) -> Result<(FibreMap, Vec<f32>), AssetFault> {
    let picture = pixels(file)?;
    if !picture.color().has_color() {
        let problem = format!("`{}` is grey, and directions are told by colours", file.name());
        return Err(AssetFault::new(problem, "give a PNG with red, green and blue, or an EXR of `gen fibres`"));
    }
    let picture = picture.into_rgba8();
    let size = [picture.height() as usize, picture.width() as usize];
    let pixels = rows.sorted(picture.pixels().map(|pixel| pixel.0).collect(), size[1]);
    let up = if rows.is_far { 1.0 } else { -1.0 };
    let direction = |[red, green, blue, _]: &[u8; 4]| {
        let (x, y) = (f64::from(*green), up * (f64::from(*red) - f64::from(*blue)));
        (x != 0.0 || y != 0.0).then_some([x, y])
    };
    let directions: Vec<_> = pixels.iter().map(direction).collect();
    if directions.iter().all(Option::is_none) {
        let problem = format!("`{}` has no colour with a direction", file.name());
        return Err(AssetFault::new(problem, "paint it: red and green are rising lines, blue and green falling ones"));
    }
    let alpha: Vec<f64> = pixels.iter().map(|pixel| f64::from(pixel[3]) / 255.0).collect();
    let map = FibreMap::from_directions(&directions, &alpha, size, pixel_mm, least_knot_mm)
        .map_err(|fault| AssetFault::new(format!("`{}`: {fault}", file.name()), "give another map"))?;
    Ok((map, alpha.iter().map(|share| (*share as f32).max(LEAST_SHARE)).collect()))
}

/// The maps of `gen fibres`.
fn exr(file: &Asset, pixel_mm: [f32; 2], rows: &RowOrder) -> Result<(FibreMap, Vec<f32>), AssetFault> {
    let remedy = "give an EXR with FibreCos2, FibreSin2 and FibreDive [deg] as `gen fibres` writes it";
    let wrong = |problem: String| AssetFault::new(format!("`{}`: {problem}", file.name()), remedy);
    let reader = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    // Headers first: channels that are small in the file and large in memory, or many, are not decoded.
    let headers =
        MetaData::read_from_buffered(Cursor::new(file.bytes()), false).map_err(|e| wrong(e.to_string()))?.headers;
    for header in &headers {
        check_size(file, header.layer_size.width(), header.layer_size.height())?;
        if header.channels.list.len() > MAX_CHANNELS {
            return Err(wrong(format!("it has {} channels, more than {MAX_CHANNELS}", header.channels.list.len())));
        }
    }
    // Not in parallel: what is small is read as fast by one thread.
    let image = reader.non_parallel().from_buffered(Cursor::new(file.bytes())).map_err(|e| wrong(e.to_string()))?;
    let layer = image.layer_data;
    let size = [layer.size.height(), layer.size.width()];
    check_size(file, size[1], size[0])?;
    let channel = |name: &str| {
        let found = layer.channel_data.list.iter().find(|channel| channel.name.to_string() == name);
        found.map(|channel| rows.sorted(channel.sample_data.values_as_f32().collect(), size[1]))
    };
    let needed = |name: &str| channel(name).ok_or_else(|| wrong(format!("it has no channel {name}")));
    let [cos, sin, dive] = [needed("FibreCos2")?, needed("FibreSin2")?, needed("FibreDive")?];
    let turn = if rows.is_far { -1.0 } else { 1.0 };
    let is_whole = |i: &usize| cos[*i].hypot(sin[*i]) > 0.1 && cos[*i].hypot(sin[*i]) < 10.0 && dive[*i].abs() <= 90.0;
    if let Some(pixel) = (0..cos.len()).find(|i| !is_whole(i)) {
        let (row, col) = (pixel / size[1], pixel % size[1]);
        return Err(wrong(format!("row {row}, column {col} has no direction, or a dive beyond 90 degrees")));
    }
    let count = cos.len();
    let map = FibreMap {
        size,
        pixel_mm,
        azimuth_rad: sin.iter().zip(&cos).map(|(sin, cos)| turn * 0.5 * libm::atan2f(*sin, *cos)).collect(),
        dive_rad: dive.iter().map(|dive| turn * dive.to_radians()).collect(),
        confidence: channel("FibreConfidence").unwrap_or_else(|| vec![1.0; count]),
        knots: Vec::new(),
    };
    Ok((map, vec![1.0; count]))
}

#[cfg(test)]
mod tests;
