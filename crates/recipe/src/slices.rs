//! Stacks of slices that boards are cut from: grey PNGs of a microscope or a tomograph -> `wood_picture::WoodVolume`.
//!
//! Model: density rises in proportion to the grey number, from `black_kg_per_m3` at 0 to `white_kg_per_m3` at the end of the scale of 8 or
//! 16 bits. Everything is read once, with the recipe; samples share what comes of it. Headers are read before any picture is decoded, and
//! slices one after another, so that memory is the volume's (4 bytes a voxel that is kept, 256 MiB at most), the files' and one slice's.
//! Limits: PNG alone is read (no TIFF, no DICOM: save them as grey PNG); the grey number goes with density by one line.

use std::io::Cursor;

use image::codecs::png::PngDecoder;
use image::{ColorType, DynamicImage, ImageDecoder, Limits};
use wood_picture::{DensityStack, FibreAxis, KindDensities, VolumeFault, WoodVolume};

use crate::asset::{Asset, AssetFault, BuiltIn};
use crate::keys::settings::SlicesSettings;
use crate::slice_tar;

/// Stacks that are built in.
pub(crate) const BUILT_IN: [BuiltIn; 1] = [("slices/spruce.tar", include_bytes!("../../../recipes/slices/spruce.tar"))];

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
    volume(own, file).map(Some).map_err(|fault| ("slices.stack", fault))
}

fn volume(own: &SlicesSettings, file: &Asset) -> Result<WoodVolume, AssetFault> {
    let slices = slice_tar::pictures(file)?;
    if slices.len() < LEAST_SLICES {
        let problem = format!("`{}` has {} PNG files", file.name(), slices.len());
        return Err(AssetFault::new(problem, format!("give at least {LEAST_SLICES} slices, one PNG each")));
    }
    let heads = slices.iter().map(|slice| Head::of(file, slice)).collect::<Result<Vec<_>, _>>()?;
    let first = &heads[0];
    if let Some((slice, head)) = slices.iter().zip(&heads).find(|(_, head)| *head != first) {
        let problem = format!("{} has {head}, and `{}` has {first}", place(file, &slice.0), slices[0].0);
        return Err(AssetFault::new(problem, "give slices of one size and one number of bits"));
    }
    let [rows, cols] = first.size;
    let voxels = rows.saturating_mul(cols).saturating_mul(slices.len());
    if rows.saturating_mul(cols) > MOST_PIXELS || voxels > MOST_VOXELS {
        let problem = format!(
            "`{}` has {} slices of {cols} x {rows} pixels; a slice may have {MOST_PIXELS} and all of them {MOST_VOXELS}",
            file.name(),
            slices.len()
        );
        return Err(AssetFault::new(problem, "crop the slices, leave some out, or average voxels to 0.1 mm"));
    }
    let told = |fault: VolumeFault| {
        let words = fault.to_string();
        let (problem, remedy) = words.split_once("; ").unwrap_or((&words, "give another stack"));
        AssetFault::new(format!("`{}`: {problem}", file.name()), remedy)
    };
    let down = own.pixel_mm;
    let voxel_mm = [own.slice_mm.unwrap_or(down), down, own.pixel_across_mm.unwrap_or(down)].map(|mm| mm as f32);
    let fibres = match own.fibres {
        bench::settings::FibreAxis::Through => FibreAxis::Through,
        bench::settings::FibreAxis::Down => FibreAxis::Down,
        bench::settings::FibreAxis::Across => FibreAxis::Across,
    };
    let mut stack = DensityStack::new([slices.len(), rows, cols], voxel_mm, fibres).map_err(told)?;
    let density = |grey: u16| {
        let share = f64::from(grey) / f64::from(u16::MAX);
        (own.black_kg_per_m3 + share * (own.white_kg_per_m3 - own.black_kg_per_m3)) as f32
    };
    for slice in &slices {
        let grey = decoded(file, slice)?.into_luma16().into_raw();
        stack.push(&grey.into_iter().map(density).collect::<Vec<f32>>());
    }
    let [earlywood, latewood] = [own.earlywood_kg_per_m3, own.latewood_kg_per_m3].map(|density| density as f32);
    stack.finish(KindDensities { earlywood, latewood }).map_err(told)
}

/// A slice, as faults call it.
fn place(file: &Asset, name: &str) -> String {
    format!("`{}`: the slice `{name}`", file.name())
}

/// What the header of a slice says.
#[derive(Debug, PartialEq)]
struct Head {
    /// Rows and columns.
    size: [usize; 2],
    bits: u16,
}

impl std::fmt::Display for Head {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{} x {} pixels of {} bits", self.size[1], self.size[0], self.bits)
    }
}

impl Head {
    /// The header of a slice, which must be grey alone.
    fn of(file: &Asset, slice: &(String, &[u8])) -> Result<Self, AssetFault> {
        let decoder = decoder(file, slice)?;
        let (cols, rows) = decoder.dimensions();
        let bits = match decoder.color_type() {
            ColorType::L8 => 8,
            ColorType::L16 => 16,
            other => {
                let what = if other.has_color() { "colours" } else { "an alpha channel" };
                let remedy = "save it as PNG with one grey channel of 8 or 16 bits, without a palette or transparency";
                return Err(AssetFault::new(format!("{} has {what}", place(file, &slice.0)), remedy));
            }
        };
        Ok(Self { size: [rows as usize, cols as usize], bits })
    }
}

fn decoder<'s>(file: &Asset, (name, bytes): &(String, &'s [u8])) -> Result<PngDecoder<Cursor<&'s [u8]>>, AssetFault> {
    PngDecoder::with_limits(Cursor::new(*bytes), Limits::default()).map_err(|error| unreadable(file, name, &error))
}

/// The picture of a slice.
fn decoded(file: &Asset, slice: &(String, &[u8])) -> Result<DynamicImage, AssetFault> {
    DynamicImage::from_decoder(decoder(file, slice)?).map_err(|error| unreadable(file, &slice.0, &error))
}

fn unreadable(file: &Asset, name: &str, error: &image::ImageError) -> AssetFault {
    let problem = format!("{} is no picture that can be read: {error}", place(file, name));
    AssetFault::new(problem, "save it as PNG anew, or bring the file back")
}

#[cfg(test)]
mod tests;
