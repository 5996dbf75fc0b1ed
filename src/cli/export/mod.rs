//! `gen export`: a dataset in other people's formats.

mod options;

use std::path::Path;

use clap::ValueEnum;
use serde_json::json;

pub(super) use options::ExportCommand;
use options::{CocoArgs, ExportIconArgs, MapChoice, MaskChoice};

use super::console::Console;
use super::generate::threads;
use super::progress::{Progress, counted, describe_bytes};
use super::{CommandResult, DONE, UsageError, output, print};
use bench::split::Split;
use dataset::Fault;
use tools::export::{
    ExportProgress, ExportSummary, PictureContent, Selection, Source, coco, icon, mvtec, png, webdataset,
};

/// Version of the layout of the document that `--json` prints.
const SCHEMA_VERSION: u32 = 1;

pub(super) fn run(format: &ExportCommand, console: &Console) -> CommandResult {
    let common = format.common();
    if let Some(what) = format.without_effect() {
        return Err(UsageError(what.into()).into());
    }
    let splits = match (format, common.split.split()) {
        (ExportCommand::Mvtec(_), None) => vec![Split::Train, Split::Test],
        (ExportCommand::Mvtec(_), Some(Split::Validation)) => {
            return Err(
                UsageError("the layout has no folder for validation: give --split train, test or all".into()).into()
            );
        }
        (_, split) => split.into_iter().collect(),
    };
    output::check_outside_datasets(&common.out, false)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads(common.threads)?).build()?;
    let source = Source::open(&common.dir, Selection { splits, indices: common.index.clone() })?;
    if let ExportCommand::Coco(CocoArgs { pictures, bits, .. }) = format
        && (bits == "16" && pictures.show() == PictureContent::Reflectance && source.head().images.bits <= 8)
    {
        let what = "--bits 16 has no effect: the dataset stores reflectance with 8 bits; leave it away, or give another --image";
        return Err(UsageError(what.into()).into());
    }
    if matches!(format, ExportCommand::Icon(ExportIconArgs { words: true, .. })) && source.head().range_unit() == "px" {
        let what = "--words has no effect: heights of an uncalibrated dataset are sensor rows, which always are WORD; leave it away";
        return Err(UsageError(what.into()).into());
    }
    if source.unfinished > 0 {
        console.note(&format!("not finished and left out: {} of the dataset", counted(source.unfinished, "shard")));
    }
    let folder = common.out.clone();
    console.on_stop(move || format!("what is written in {} is kept; the same command finishes it", folder.display()));
    let progress = Progress::new(console, "samples", None);
    let summary = pool.install(|| write(format, &source, &common.out, &|done, all| progress.set(done, all)));
    drop(progress);
    let summary = summary?;
    if common.json {
        let document = json!({
            "schema_version": SCHEMA_VERSION,
            "format": format.name(),
            "dataset": common.dir.display().to_string(),
            "out": common.out.display().to_string(),
            "samples": source.samples,
            "unfinished_shards": source.unfinished,
            "nothing_to_do": summary.nothing_to_do,
            "files": (!summary.nothing_to_do).then_some(summary.files),
            "bytes": (!summary.nothing_to_do).then_some(summary.bytes),
            "notes": &summary.notes,
        });
        print(&format!("{document:#}\n"))?;
    }
    let out = common.out.display();
    for note in &summary.notes {
        console.note(&format!("note: {note}"));
    }
    console.note(&match summary.nothing_to_do {
        true => format!("{out} is finished already; there is nothing to do"),
        false => format!(
            "{out}: {} of {}, {}",
            counted(summary.files, "file"),
            counted(source.samples, "sample"),
            describe_bytes(summary.bytes)
        ),
    });
    Ok(DONE)
}

fn write(
    format: &ExportCommand,
    source: &Source,
    out: &Path,
    progress: ExportProgress,
) -> Result<ExportSummary, Fault> {
    match format {
        ExportCommand::Coco(coco) => {
            let options = coco::CocoOptions {
                show: coco.pictures.show(),
                stored: coco.bits == "16",
                mask: match coco.mask {
                    MaskChoice::Whole => coco::MaskExtent::Whole,
                    MaskChoice::Own => coco::MaskExtent::Own,
                },
                plain: coco.plain_rle,
                ends: coco.pictures.ends(),
            };
            coco::export(source, out, &options, progress)
        }
        ExportCommand::Mvtec(mvtec) => {
            let options = mvtec::MvtecOptions {
                show: mvtec.pictures.show(),
                good: mvtec.good.clone(),
                patch_px: mvtec.patch_px.map(|side| side as usize),
                ends: mvtec.pictures.ends(),
            };
            mvtec::export(source, out, &options, progress)
        }
        ExportCommand::Webdataset(tars) => {
            let options =
                webdataset::WebDatasetOptions { maps: names(&tars.maps), most_bytes: tars.tar_mb * 1_000_000 };
            webdataset::export(source, out, &options, progress)
        }
        ExportCommand::Png(png) => {
            png::export(source, out, &png::PngOptions { maps: names(&png.maps), colour: png.colour }, progress)
        }
        ExportCommand::Icon(icon) => {
            let options =
                icon::IconOptions { words: icon.words, rate: icon.rate.unwrap_or(1000.0), sensor: icon.sensor };
            icon::export(source, out, &options, progress)
        }
    }
}

fn names(maps: &[MapChoice]) -> Vec<String> {
    let name = |map: &MapChoice| map.to_possible_value().map(|value| value.get_name().to_owned());
    maps.iter().filter_map(name).collect()
}
