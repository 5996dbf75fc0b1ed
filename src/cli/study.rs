//! `gen study`: models of light inside matter side by side.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Subcommand};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};

use super::progress::{Photons, say};
use super::{Outcome, print, whole};
use crate::recipe::Recipe;
use crate::study::{Report, Step, Watch, lines, point, profile};
use crate::transport::path::Effort;

/// Most photons for a single question: days of work.
const MOST_PHOTONS: u64 = 10_000_000_000;

#[derive(Debug, Subcommand)]
pub(super) enum Study {
    /// A point of light on clear wood and on a knot: the ellipses that it makes
    #[command(after_help = "Examples:
  gen study point                                  writes out/study/point.json and point.png
  gen study point --photons 100000 --out quick     a rough look")]
    Point(Arguments),
    /// A line of light on fifteen media: reflectance, spread, asymmetry
    #[command(after_help = "Examples:
  gen study transport                              writes out/study/transport.json and transport.png
  gen study transport --photons 3000000            errors three times smaller")]
    Transport(Arguments),
    /// One profile of a recipe's sample by every model, with the judge's standard errors
    #[command(after_help = "Examples:
  gen study profile --recipe wood-small.yaml --index 12 --profile 128
                                                   writes out/study/profile.json and profile.png")]
    Profile(Profile),
}

#[derive(Debug, Args)]
pub(super) struct Profile {
    /// Recipe: a YAML file, or a built-in one
    #[arg(long, value_name = "FILE")]
    recipe: String,
    /// Which sample
    #[arg(long, default_value_t = 0)]
    index: u64,
    /// Which profile of it [default: the middle one]
    #[arg(long, value_name = "P")]
    profile: Option<usize>,
    #[command(flatten)]
    arguments: Arguments,
}

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Folder for the JSON file and the picture; made where it is missing
    #[arg(long, value_name = "DIR", default_value = "out/study")]
    out: PathBuf,
    /// Photons for each question [default: 1000000 for point, 300000 for transport, 2000000 for profile]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MOST_PHOTONS))]
    photons: Option<u64>,
    /// Seed of all chance
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    /// Threads [default: all cores]
    #[arg(long, value_name = "T")]
    threads: Option<usize>,
}

pub(super) fn run(study: &Study) -> Outcome {
    match study {
        Study::Point(arguments) => make(arguments, "point", point::PHOTONS, point::work, point::study),
        Study::Transport(arguments) => make(arguments, "transport", lines::PHOTONS, lines::work, lines::study),
        Study::Profile(one) => {
            let scene = Recipe::load(&one.recipe)?.draw(one.arguments.seed, one.index);
            let chosen = one.profile.unwrap_or(scene.size.profiles / 2);
            if chosen >= scene.size.profiles {
                let last = scene.size.profiles - 1;
                return Err(format!("profile {chosen} is beyond the scan: give --profile 0 to {last}").into());
            }
            let study = |effort: Effort, watch: Watch<'_>| profile::study(&scene, chosen, effort, watch);
            make(&one.arguments, "profile", profile::PHOTONS, profile::work, study)
        }
    }
}

fn make(
    arguments: &Arguments,
    name: &str,
    photons: u64,
    work: fn(Effort) -> u64,
    study: impl Fn(Effort, Watch) -> Report + Sync,
) -> Outcome {
    let threads = super::generate::threads(arguments.threads)?;
    let out = &arguments.out;
    std::fs::create_dir_all(out)
        .map_err(|error| format!("cannot make {}: {error}; give another folder with --out", out.display()))?;
    let (json, png) = (out.join(format!("{name}.json")), out.join(format!("{name}.png")));
    whole::check(&json)?;
    let effort = Effort { photons: arguments.photons.unwrap_or(photons), seed: arguments.seed };
    let bar = Photons::new(work(effort));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let report = pool.install(|| {
        study(effort, &|step| match step {
            Step::Asks(what) => bar.say(what),
            Step::Photons(photons) => bar.done(photons),
        })
    });
    bar.end();
    print(&report.table);
    whole::write(&json, format!("{:#}\n", report.json).as_bytes())?;
    whole::write(&png, &encoded(&report)?)?;
    let told = |path: &Path| path.display().to_string();
    say(&format!("{}, {}", told(&json), told(&png)));
    Ok(ExitCode::SUCCESS)
}

fn encoded(report: &Report) -> Result<Vec<u8>, image::ImageError> {
    let mut bytes = Vec::new();
    report.picture.write_with_encoder(PngEncoder::new_with_quality(
        &mut bytes,
        CompressionType::Best,
        FilterType::Adaptive,
    ))?;
    Ok(bytes)
}
