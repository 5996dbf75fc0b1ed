//! `gen export`: a dataset in other people's formats.

mod options;

use std::path::Path;
use std::process::ExitCode;

use clap::ValueEnum;

pub(super) use options::Format;
use options::{Coco, Icon, Map, Mask};

use super::generate::threads;
use super::progress::{Things, bytes, counted, say};
use super::{Outcome, Usage, whole};
use crate::export::{
    ExportError, ExportProgress, ExportSummary, PictureContent, Selection, Source, coco, icon, mvtec, png, webdataset,
};
use crate::split::Split;

pub(super) fn run(format: &Format) -> Outcome {
    let common = format.common();
    if let Some(what) = format.without_effect() {
        return Err(Usage(what.into()).into());
    }
    let splits = match (format, common.split.split()) {
        (Format::Mvtec(_), None) => vec![Split::Train, Split::Test],
        (Format::Mvtec(_), Some(Split::Validation)) => {
            return Err(Usage("the layout has no folder for validation: give --split train, test or all".into()).into());
        }
        (_, split) => split.into_iter().collect(),
    };
    if let Some(out) = whole::place(&common.out)
        && common.dir.canonicalize().is_ok_and(|dir| out.starts_with(dir))
    {
        let what = "it lies in the dataset, where nothing else may lie; choose a folder elsewhere";
        return Err(Usage(format!("--out {}: {what}", common.out.display())).into());
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads(common.threads)?).build()?;
    let source = Source::open(&common.dir, Selection { splits, indices: common.index.clone() })?;
    if let Format::Coco(Coco { pictures, bits, .. }) = format
        && (bits == "16" && pictures.show() == PictureContent::Reflectance && source.head().images.bits <= 8)
    {
        let what = "--bits 16 has no effect: the dataset stores reflectance with 8 bits; leave it away, or give another --image";
        return Err(Usage(what.into()).into());
    }
    if matches!(format, Format::Icon(Icon { words: true, .. })) && source.head().range_unit() == "px" {
        let what = "--words has no effect: heights of an uncalibrated dataset are sensor rows, which always are WORD; leave it away";
        return Err(Usage(what.into()).into());
    }
    if source.unfinished > 0 {
        say(&format!("not finished and left out: {} of the dataset", counted(source.unfinished, "shard")));
    }
    let bar = Things::new("samples");
    let summary = pool.install(|| write(format, &source, &common.out, &|done, all| bar.show(done, all)));
    bar.end();
    let summary = summary?;
    let out = common.out.display();
    for note in &summary.notes {
        say(&format!("note: {note}"));
    }
    say(&match summary.nothing_to_do {
        true => format!("{out} is finished already; there is nothing to do"),
        false => format!(
            "{out}: {} of {}, {}",
            counted(summary.files, "file"),
            counted(source.samples, "sample"),
            bytes(summary.bytes)
        ),
    });
    Ok(ExitCode::SUCCESS)
}

fn write(format: &Format, source: &Source, out: &Path, progress: ExportProgress) -> Result<ExportSummary, ExportError> {
    match format {
        Format::Coco(coco) => {
            let options = coco::CocoOptions {
                show: coco.pictures.show(),
                stored: coco.bits == "16",
                mask: match coco.mask {
                    Mask::Whole => coco::MaskExtent::Whole,
                    Mask::Own => coco::MaskExtent::Own,
                },
                plain: coco.plain_rle,
                range: coco.pictures.range_ends,
                scatter: coco.pictures.scatter_ends,
            };
            coco::export(source, out, &options, progress)
        }
        Format::Mvtec(mvtec) => {
            let options = mvtec::MvtecOptions {
                show: mvtec.pictures.show(),
                good: mvtec.good.clone(),
                patch_px: mvtec.patch_px.map(|side| side as usize),
                range: mvtec.pictures.range_ends,
                scatter: mvtec.pictures.scatter_ends,
            };
            mvtec::export(source, out, &options, progress)
        }
        Format::Webdataset(tars) => {
            let options =
                webdataset::WebDatasetOptions { maps: names(&tars.maps), most_bytes: tars.tar_mb * 1_000_000 };
            webdataset::export(source, out, &options, progress)
        }
        Format::Png(png) => {
            png::export(source, out, &png::PngOptions { maps: names(&png.maps), colour: png.colour }, progress)
        }
        Format::Icon(icon) => {
            let options =
                icon::IconOptions { words: icon.words, rate: icon.rate.unwrap_or(1000.0), sensor: icon.sensor };
            icon::export(source, out, &options, progress)
        }
    }
}

fn names(maps: &[Map]) -> Vec<String> {
    let name = |map: &Map| map.to_possible_value().map(|value| value.get_name().to_owned());
    maps.iter().filter_map(name).collect()
}
