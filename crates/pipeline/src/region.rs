//! A region of a sample's maps, rendered without the rest.
//!
//! A profile depends on the scene and on its own number alone, so a region holds to the bit what the same pixels of the
//! whole scan hold ([`super::exposed_rows`]). Light of a line is worked out in all columns, since it spreads along the
//! line; it is exposed and read in the tiles alone that the region touches. Frames of scripts and rectified profiles
//! are read whole: there a column depends on its neighbours.

use std::ops::Range;

use rayon::prelude::*;

use super::{BAND_PROFILES, Measurement, Scan, grid};
use dataset::record::{Labels, Maps};
use optical_bench::settings::{SensorStack, Size, Transport};
use recipe::Scene;
use scanner::optics::{Sensor, TILE};
use scanner::specimen::Specimen;

/// Some profiles and columns of a scan, before pixels are put together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PixelRegion {
    /// Profiles.
    pub profiles: Range<usize>,
    /// Columns.
    pub columns: Range<usize>,
}

impl PixelRegion {
    /// The region of so many profiles and columns about a pixel, as far as the scan has them: at its edges it is moved
    /// inwards.
    pub fn about([profile, column]: [usize; 2], [profiles, columns]: [usize; 2], size: Size) -> Self {
        let span = |middle: usize, wanted: usize, all: usize| {
            let wanted = wanted.clamp(1, all);
            let first = middle.saturating_sub(wanted / 2).min(all - wanted);
            first..first + wanted
        };
        Self { profiles: span(profile, profiles, size.profiles), columns: span(column, columns, size.columns) }
    }
}

/// The maps and labels of a region, `[profiles, columns]`, row-major, to the bit those that [`super::render`] gives
/// there without binning. `None` as soon as `is_stopped` says so, which it is asked between bands of profiles.
pub fn render_region(
    scene: &Scene,
    sensor: &Sensor,
    specimen: &Specimen,
    region: &PixelRegion,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Option<(Maps, Labels)> {
    let all = scene.size.columns;
    let mut measurement = Measurement::new(scene, sensor, SensorStack::None);
    if grid(scene, &sensor.camera().rig).is_none() {
        measurement.tiles = region.columns.start / TILE..region.columns.end.div_ceil(TILE);
    }
    let mut scan = Scan::new(scene, region.profiles.len());
    // Each thread has neighbouring profiles, whose lines it works out once.
    let each = match scene.transport {
        Transport::Kernel => region.profiles.len().div_ceil(rayon::current_num_threads()).max(1),
        _ => 1,
    };
    let parts: Vec<Vec<_>> = {
        let mut bands = scan.parts(each.min(BAND_PROFILES) * all).into_iter().enumerate();
        let bands_each = each.div_ceil(BAND_PROFILES);
        std::iter::from_fn(|| Some(bands.by_ref().take(bands_each).collect()).filter(|part: &Vec<_>| !part.is_empty()))
            .collect()
    };
    let length = each.min(BAND_PROFILES);
    let done: Vec<Option<()>> = parts
        .into_par_iter()
        .map(|part| {
            let mut bands = sensor.bands(specimen);
            for (number, maps) in part {
                if is_stopped() {
                    return None;
                }
                let first = region.profiles.start + number * length;
                let band = bands.make(first..(first + length).min(region.profiles.end));
                maps.fill(&measurement, band);
            }
            Some(())
        })
        .collect();
    done.into_iter().collect::<Option<()>>()?;
    let Scan { maps, labels, .. } = scan;
    let cut = |map: &[f32]| cropped(map, all, &region.columns);
    let maps = Maps {
        range: cut(&maps.range),
        reflectance: cut(&maps.reflectance),
        scatter: cut(&maps.scatter),
        grey: cut(&maps.grey),
    };
    let class = cropped(&labels.class, all, &region.columns);
    Some((maps, Labels { class, instance: cropped(&labels.instance, all, &region.columns) }))
}

/// Some columns of a map that has `all`.
pub fn cropped<T: Copy>(map: &[T], all: usize, columns: &Range<usize>) -> Vec<T> {
    map.chunks(all).flat_map(|row| row[columns.clone()].iter().copied()).collect()
}
