//! Some rows of a sample, exposed without the others.
//!
//! A profile depends on the scene and on its own number alone: noise is keyed by profile and pixel, speckle by the place of the
//! object, and the light of the rows around it by their places. A band of a few profiles therefore holds to the bit what the
//! bands of a whole scan hold. It costs the rows that its windows look at, before, between and behind its profiles: 66 or so
//! for one profile of a board, so that neighbours are nearly free.

use std::ops::Range;

use super::{BandMaps, Measurement, Scan, grid};
use dataset::record::{AskedRows, ExposedRows, StackFrame, TruthMaps};
use recipe::Scene;
use scanner::optics::{Band, Sensor};
use scanner::specimen::Specimen;

/// The rows that are asked for, as far as the images have them, then that of the sensor frame; and the frame.
pub(super) fn exposed_rows(
    scene: &Scene,
    sensor: &Sensor,
    specimen: &Specimen,
    asked: &AskedRows,
) -> (Vec<ExposedRows>, Option<StackFrame>) {
    let (bin, profiles) = (scene.output.bin_profiles, scene.size.profiles);
    let rows = profiles / bin;
    let frame = asked.frame.filter(|profile| *profile < profiles);
    let strips = asked.strips.iter().map(|strip| strip.start..strip.end.min(rows)).filter(|strip| !strip.is_empty());
    let mut strips: Vec<Range<usize>> = strips.collect();
    if let Some(row) = frame.map(|profile| profile / bin)
        && !strips.iter().any(|strip| strip.contains(&row))
    {
        strips.push(row..row + 1);
    }

    let calibration = sensor.calibration();
    let grid = grid(scene, &calibration.rig);
    let keeps = |profile: usize| frame == Some(profile);
    let measurement = Measurement { scene, calibration: &calibration, grid: grid.as_ref(), keeps: &keeps };
    let mut band = Band::default();
    let (mut exposed, mut frames) = (Vec::new(), Vec::new());
    for strip in strips {
        let part = strip.start * bin..(strip.end * bin).min(profiles);
        let mut scan = Scan::new(scene, part.len());
        band = sensor.band(specimen, part, band);
        frames.extend(scan.whole().fill(&measurement, sensor, &band));
        // The last profiles of a scan can be too few for a row: they have a sensor frame alone.
        if strip.end <= rows {
            let Scan { maps, labels, truth, .. } = scan.binned(scene, &sensor.camera().rig);
            let cols = scene.size.columns / scene.output.bin_columns;
            exposed.push(ExposedRows { first: strip.start, cols, maps, labels, truth });
        }
    }
    // Strips may lie over each other.
    (exposed, frames.into_iter().next())
}

impl Scan {
    /// All of its maps, to be filled by one band.
    fn whole(&mut self) -> BandMaps<'_> {
        let truth = self.truth.as_mut().map(TruthMaps::maps_mut);
        BandMaps {
            range: &mut self.maps.range,
            reflectance: &mut self.maps.reflectance,
            scatter: &mut self.maps.scatter,
            class: &mut self.labels.class,
            instance: &mut self.labels.instance,
            truth: truth.map(|maps| maps.into_iter().map(Vec::as_mut_slice).collect()),
        }
    }
}
