//! Bands of one specimen under one sensor, made one after the other: what one of them has worked out serves the next.

use super::scan_line::{LineScratch, LineView, spread_in_cavities};
use super::sensor::Sensor;
use super::window::{Band, PerLine};
use crate::specimen::Specimen;

/// Lines by which those are apart that a look at one profile works out.
const SPARSE_LINES: usize = 8;

/// Makes bands of one specimen. Each takes the memory of the one before it, and the lines that both hold.
#[derive(Debug)]
pub struct Bands<'a> {
    sensor: &'a Sensor,
    specimen: &'a Specimen,
    band: Band,
    scratch: LineScratch,
}

impl Sensor {
    /// Works out the light at every position that `profiles` look at.
    pub fn band(&self, specimen: &Specimen, profiles: std::ops::Range<usize>) -> Band {
        let mut bands = self.bands(specimen);
        bands.make(profiles);
        bands.band
    }

    /// Bands of a specimen, to be made one after the other.
    pub fn bands<'a>(&'a self, specimen: &'a Specimen) -> Bands<'a> {
        Bands { sensor: self, specimen, band: Band::default(), scratch: LineScratch::new(self.size.columns) }
    }
}

impl Bands<'_> {
    /// Works out the light at every position that `profiles` look at.
    pub fn make(&mut self, profiles: std::ops::Range<usize>) -> &Band {
        let Self { sensor, specimen, band, scratch } = self;
        let kept = band.restart(profiles, sensor.halo());
        let first = (band.profiles.start + kept) as isize - band.halo as isize;
        sensor.maker.make_all(first, &mut band.lines[kept..], |profile| view(sensor, specimen, profile), scratch);
        spread_in_cavities(band.lines[kept..].iter_mut());
        self.finish()
    }

    /// The same for a look at one profile. Every eighth line around it stands for those beside it, which takes a
    /// fraction of the time and shows light that comes from other lines less finely: what has crept under the surface,
    /// front faces, light that parts of a body throw at each other.
    pub fn make_sparse(&mut self, profile: usize) -> &Band {
        let Self { sensor, specimen, band, scratch } = self;
        band.restart(profile..profile + 1, sensor.halo());
        let own = band.halo;
        // Lines below a line, and those that a moving object has come to, do not stand for others.
        let under = sensor.second.map(|second| second.lines()).into_iter().chain([0..=0]);
        let moved = isize::from(sensor.geometry.exposed_share > 0.0);
        let exact: Vec<isize> = under.flat_map(|lines| *lines.start()..=*lines.end() + moved).collect();
        let is_made = |place: usize| {
            let away = place as isize - own as isize;
            away.unsigned_abs().is_multiple_of(SPARSE_LINES) || exact.contains(&away)
        };
        for place in (0..band.lines.len()).filter(|&place| is_made(place)) {
            let view = view(sensor, specimen, (profile + place) as isize - own as isize);
            sensor.maker.make(view, scratch, &mut band.lines[place]);
        }
        let made = band.lines.iter_mut().enumerate().filter(|(place, _)| is_made(*place));
        spread_in_cavities(made.map(|(_, line)| line));
        for place in (0..band.lines.len()).filter(|&place| !is_made(place)) {
            let sides = |away: usize| [place.checked_sub(away), Some(place + away)].into_iter().flatten();
            let near = (1..SPARSE_LINES).flat_map(sides).find(|&near| near < band.lines.len() && is_made(near));
            band.lines[place] = band.lines[near.unwrap_or(own)].clone();
        }
        band.is_sparse = true;
        self.finish()
    }

    /// What follows once a band's lines are made.
    fn finish(&mut self) -> &Band {
        let Self { sensor, specimen, band, .. } = self;
        if let Some(last) = band.lines.last_mut() {
            last.front.clear();
        }
        let view = sensor.camera.sight(0.0, 0.0, 0.0).view;
        for place in (1..band.lines.len()).rev() {
            let (before, from) = band.lines.split_at_mut(place);
            before[place - 1].open_front(&from[0], -view.z / view.y);
        }
        // The light that a moving object has in the next profile counts too.
        band.offsets = sensor.geometry.uneven_neighbours(band.profiles.start..band.profiles.end + 1);
        band.volumes.clear();
        if let Some(solver) = sensor.line_solver.as_deref() {
            let model = PerLine { specimen, camera: &sensor.camera, solver };
            let last = band.profiles.end + usize::from(sensor.geometry.exposed_share > 0.0);
            let volume = |profile: usize| model.volume(band.line(profile), profile as u64, sensor.position(profile));
            band.volumes = (band.profiles.start..last).map(volume).collect();
        }
        band.glare.clear();
        if let Some(glare) = &sensor.glare {
            band.glare = band.profiles.clone().map(|profile| glare.about(band, profile)).collect();
        }
        band
    }
}

/// Body, camera and laser where `profile` stands.
fn view<'a>(sensor: &'a Sensor, specimen: &'a Specimen, profile: isize) -> LineView<'a> {
    let y = sensor.geometry.position(profile) as f32;
    let unrest = sensor.unsteady.at(profile);
    LineView { specimen, camera: &sensor.camera, y, profile, unrest, faint: sensor.faint }
}
