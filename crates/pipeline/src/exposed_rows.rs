//! Some rows and sensor frames of a sample, exposed without the others.
//!
//! A profile depends on the scene and on its own number alone: noise is keyed by profile and pixel, speckle by the
//! place of the object, and the light of the rows around it by their places. A band of a few profiles therefore holds
//! to the bit what the bands of a whole scan hold. It costs the rows that its windows look at, before, between and
//! behind its profiles: 66 or so for one profile of a board, so that neighbours are nearly free.

use std::ops::Range;

use rayon::prelude::*;

use super::{Measurement, Scan};
use dataset::record::{ExposedRows, StackFrame};
use optical_bench::settings::SensorStack;
use recipe::Scene;
use scanner::optics::Sensor;
use scanner::specimen::Specimen;

/// Frames that are exposed one after the other, each with the rows of the one before as far as both look at them.
const FRAMES_IN_TURN: usize = 16;

/// The rows that are asked for, as far as the images have them.
pub(super) fn exposed_rows(
    scene: &Scene,
    sensor: &Sensor,
    specimen: &Specimen,
    strips: &[Range<usize>],
) -> Vec<ExposedRows> {
    let (bin, rows) = (scene.output.bin_profiles, scene.size.profiles / scene.output.bin_profiles);
    let measurement = Measurement::new(scene, sensor, SensorStack::None);
    let mut bands = sensor.bands(specimen);
    let mut exposed = Vec::new();
    for strip in strips.iter().map(|strip| strip.start..strip.end.min(rows)).filter(|strip| !strip.is_empty()) {
        let part = strip.start * bin..strip.end * bin;
        let mut scan = Scan::new(scene, part.len());
        for whole in scan.parts(scene.size.columns * part.len()) {
            whole.fill(&measurement, bands.make(part.clone()));
        }
        let Scan { maps, labels, truth, .. } = scan.binned(scene, &sensor.camera().rig);
        let cols = scene.size.columns / scene.output.bin_columns;
        exposed.push(ExposedRows { first: strip.start, cols, maps, labels, truth });
    }
    exposed
}

/// Exposes the sensor frames of `profiles`, rising, as far as the scan has them.
pub(super) fn expose_frames(
    scene: &Scene,
    sensor: &Sensor,
    specimen: &Specimen,
    profiles: &[usize],
    take: &(dyn Fn(StackFrame) + Sync),
) {
    let profiles = &profiles[..profiles.partition_point(|profile| *profile < scene.size.profiles)];
    profiles.par_chunks(FRAMES_IN_TURN).for_each(|part| {
        let mut bands = sensor.bands(specimen);
        for &profile in part {
            let band = bands.make(profile..profile + 1);
            let dn = match sensor.is_scripted() {
                true => sensor.processed(band, profile).dn,
                false => sensor.full_frame(band, profile),
            };
            take(StackFrame { profile: profile as u32, dn });
        }
    });
}
