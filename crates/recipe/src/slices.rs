//! Stacks of slices that boards are cut from: grey PNGs of a microscope or a tomograph -> `wood_picture::WoodVolume`.
//!
//! Model: density rises in proportion to the grey number, from `black_kg_per_m3` at 0 to `white_kg_per_m3` at the end
//! of the scale of 8 or 16 bits. Everything is read once, with the recipe; samples share what comes of it. Headers are
//! read before any picture is decoded, and slices one after another, so that memory is the volume's (4 bytes a voxel
//! that is kept, 256 MiB at most), the files' and one slice's. Limits: PNG alone is read (no TIFF, no DICOM: save them
//! as grey PNG); the grey number goes with density by one line.

use std::io::Cursor;

use image::codecs::png::PngDecoder;
use image::{ColorType, DynamicImage, ImageDecoder, Limits};
use wood_picture::{DensityStack, KindDensities, VolumeFault, WoodVolume};

use crate::asset::{Asset, AssetFault, printable};
use crate::keys::settings::SlicesSettings;
use crate::slice_tar;

/// Fewest slices: densities lie between two.
const LEAST_SLICES: usize = 2;
/// Most pixels of one slice [px].
const MOST_PIXELS: usize = 32 << 20;
/// Most voxels of all slices, before fine ones are put together: a cube of 1024.
const MOST_VOXELS: usize = 1 << 30;

/// The wood of the stack that the settings name; the key that a fault belongs to comes with it.
pub(crate) fn read_slices(own: &SlicesSettings) -> Result<Option<WoodVolume>, (&'static str, AssetFault)> {
    // Grey that is no density is a fault of its own, whatever the slices show.
    let Some(file) = own.stack.asset().filter(|_| own.black_kg_per_m3 != own.white_kg_per_m3) else { return Ok(None) };
    let called = own.stack.name().map(printable).unwrap_or_default();
    volume(own, file, &called).map(Some).map_err(|fault| ("slices.stack", fault))
}

/// A slice.
struct SliceFile<'f> {
    name: String,
    /// Its name and that of the stack, as faults have them.
    place: String,
    bytes: &'f [u8],
}

/// The wood of a stack, which the recipe calls `called`.
fn volume(own: &SlicesSettings, file: &Asset, called: &str) -> Result<WoodVolume, AssetFault> {
    let slice = |(name, bytes): (String, _)| {
        let name = printable(&name);
        SliceFile { place: format!("`{called}`: the slice `{name}`"), name, bytes }
    };
    let slices: Vec<SliceFile> = slice_tar::pictures(file, called)?.into_iter().map(slice).collect();
    if slices.len() < LEAST_SLICES {
        let problem = format!("`{called}` has {} PNG files", slices.len());
        return Err(AssetFault::new(problem, format!("give at least {LEAST_SLICES} slices, one PNG each")));
    }
    let heads = slices.iter().map(Head::of).collect::<Result<Vec<_>, _>>()?;
    let first = &heads[0];
    if let Some((slice, head)) = slices.iter().zip(&heads).find(|(_, head)| *head != first) {
        let problem = format!("{} has {head}, and `{}` has {first}", slice.place, slices[0].name);
        return Err(AssetFault::new(problem, "give slices of one size and one number of bits"));
    }
    let [rows, cols] = first.size;
    let voxels = rows.saturating_mul(cols).saturating_mul(slices.len());
    if voxels > MOST_VOXELS {
        let problem = format!(
            "`{called}` has {} slices of {cols} x {rows} pixels, {voxels} in all, more than {MOST_VOXELS}",
            slices.len()
        );
        return Err(AssetFault::new(problem, "crop the slices, leave some out, or average voxels to 0.1 mm"));
    }
    let told = |fault: VolumeFault| AssetFault::told(called, &fault, "give another stack");
    let down = own.pixel_mm;
    let voxel_mm = [own.slice_mm.unwrap_or(down), down, own.pixel_across_mm.unwrap_or(down)].map(|mm| mm as f32);
    let mut stack = DensityStack::new([slices.len(), rows, cols], voxel_mm, own.fibres).map_err(told)?;
    let density = |grey: u16| {
        let share = f64::from(grey) / f64::from(u16::MAX);
        (own.black_kg_per_m3 + share * (own.white_kg_per_m3 - own.black_kg_per_m3)) as f32
    };
    for slice in &slices {
        let grey = decoded(slice)?.into_luma16().into_raw();
        stack.push(&grey.into_iter().map(density).collect::<Vec<f32>>());
    }
    let [earlywood, latewood] = [own.earlywood_kg_per_m3, own.latewood_kg_per_m3].map(|density| density as f32);
    stack.finish(KindDensities { earlywood, latewood }).map_err(told)
}

/// What the header of a slice says.
#[derive(Debug, PartialEq)]
struct Head {
    /// Rows and columns.
    size: [usize; 2],
    bits: u8,
}

impl std::fmt::Display for Head {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} x {} pixels of {} bits", self.size[1], self.size[0], self.bits)
    }
}

impl Head {
    /// The header of a slice, which must be grey alone.
    fn of(slice: &SliceFile) -> Result<Self, AssetFault> {
        let place = &slice.place;
        let Some(rest) = slice.bytes.strip_prefix(b"\x89PNG\r\n\x1a\n") else {
            let what = if slice.bytes.is_empty() { "is empty" } else { "is no PNG, whatever its name says" };
            return Err(AssetFault::new(format!("{place} {what}"), "save it as PNG, or remove it"));
        };
        // Length and name of the first chunk; columns, rows, bits (ISO 15948, 11.2.1). The decoder tells what else is
        // wrong with them.
        let number = |at: usize| rest.get(at..at + 4).and_then(|word| word.try_into().ok()).map(u32::from_be_bytes);
        let (Some(cols), Some(rows), Some(bits)) = (number(8), number(12), rest.get(16).copied()) else {
            return Err(AssetFault::new(format!("{place} {DAMAGED}"), ANEW));
        };
        let size = [rows, cols].map(|count| count as usize);
        if size[0].saturating_mul(size[1]) > MOST_PIXELS {
            let problem = format!("{place} has {cols} x {rows} pixels, more than {MOST_PIXELS}");
            return Err(AssetFault::new(problem, "crop the slices, or average voxels to 0.1 mm"));
        }
        let refused = |what: &str| {
            let remedy = "save it as PNG with one grey channel of 8 or 16 bits, without a palette or transparency";
            Err(AssetFault::new(format!("{place} has {what}"), remedy))
        };
        match decoder(slice)?.color_type() {
            ColorType::L8 | ColorType::L16 if matches!(bits, 8 | 16) => Ok(Self { size, bits }),
            ColorType::L8 | ColorType::L16 => refused("fewer than 8 bits a pixel"),
            other => refused(if other.has_color() { "colours" } else { "an alpha channel" }),
        }
    }
}

fn decoder<'s>(slice: &SliceFile<'s>) -> Result<PngDecoder<Cursor<&'s [u8]>>, AssetFault> {
    PngDecoder::with_limits(Cursor::new(slice.bytes), Limits::default()).map_err(|error| damaged(slice, &error))
}

/// The picture of a slice.
fn decoded(slice: &SliceFile) -> Result<DynamicImage, AssetFault> {
    DynamicImage::from_decoder(decoder(slice)?).map_err(|error| damaged(slice, &error))
}

/// What is said of a slice that cannot be decoded, and what to do.
const DAMAGED: &str = "is a PNG that is damaged or cut short";
const ANEW: &str = "save it as PNG anew, or bring the file back";

fn damaged(slice: &SliceFile, error: &image::ImageError) -> AssetFault {
    AssetFault::new(format!("{} {DAMAGED} (the decoder says: {error})", slice.place), ANEW)
}

#[cfg(test)]
mod tests;
