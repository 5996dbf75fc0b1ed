//! Windows: the light of lines gathers in windows of sensor rows.
//!
//! Takes the lines that a profile looks at ([`Band`]); gives electrons in one or two windows of [`ROWS`] rows about the
//! line, a tile of columns at a time ([`Scratch`]). What each column of a line sends and lets out is known by then;
//! here it is laid on the rows where the lens sees it.

mod ambient;
mod band;
mod compositing;
mod electrons;
mod front_exits;
mod gaussian_stepper;
mod glare;
mod interreflections;
mod line_image;
mod lit_profile;
mod mixed_columns;
mod motion_blur;
mod per_line;
mod pocket_light;
mod rows_left_out;
mod scan_geometry;
mod second_line;
mod seen_rows;
mod streaks;

use std::ops::Range;

use self::electrons::ExposureKey;
use self::line_image::{LineShape, draw, surface_line};
use self::motion_blur::MotionBlur;
use self::rows_left_out::{light_beyond, mix_bounds};
use self::seen_rows::SeenRows;
use crate::optics::light::{MixedColumn, ROWS, Streak, WindowNeed, greater, load};
use crate::optics::speckle::{AnchoredSpeckle, TILE};
use transport::kernel::BASIS;

pub use self::band::Band;
pub(crate) use self::electrons::WindowSignal;
pub use self::electrons::{Scratch, Window};
pub(crate) use self::glare::Glare;
pub(crate) use self::lit_profile::LitProfile;
pub(crate) use self::per_line::PerLine;
pub(crate) use self::scan_geometry::ScanGeometry;
pub(crate) use self::second_line::SecondLine;

/// What is drawn of a profile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drawing<'a> {
    /// The profile under the laser.
    pub lit: LitProfile<'a>,
    /// A second line beside the laser's.
    pub second: Option<&'a SecondLine>,
    /// Light in one pixel under which no window of its own is given to it [e-].
    pub faint: f32,
}

impl Drawing<'_> {
    /// Fills `scratch` with the electrons of one tile, as they are when the shutter closes.
    pub fn draw(&self, tile: usize, scratch: &mut Scratch) {
        let LitProfile { geometry, band, profile, .. } = self.lit;
        if geometry.exposed_share > 0.0 {
            let blur = MotionBlur { share: 0.5 * geometry.exposed_share, faint: self.faint };
            let key = ExposureKey { band: band.number, profile, tile };
            motion_blur::window(blur, key, scratch, |profile, scratch| {
                Drawing { lit: LitProfile { profile, ..self.lit }, ..*self }.draw_still(tile, 0..ROWS, scratch);
            });
        } else {
            self.draw_still(tile, 0..ROWS, scratch);
        }
        self.lit.add_ambient(tile, scratch);
        self.lit.add_glare(tile, scratch);
    }

    /// Light of an object that stands still under the laser alone, in these rows of the first window.
    pub fn draw_still(&self, tile: usize, rows: Range<usize>, scratch: &mut Scratch) {
        let (start, lit) = (tile * TILE, &self.lit);
        let own = lit.line();
        scratch.columns = (own.hits.len() - start).min(TILE);
        scratch.used = 1;
        let first = &mut scratch.windows[0];
        first.drawn = rows;
        let line = LineShape { centre: load(&own.centre, start), blur: 0.0, profile: lit.camera.laser.line_profile() };
        match lit.band.volume(lit.profile) {
            Some(volume) => {
                surface_line(own, start, &line, load(&own.variance, start), first);
                if let Some(secondary) = &own.secondary {
                    compositing::stand(secondary, tile, scratch);
                }
                for (window, volume) in scratch.windows.iter_mut().take(scratch.used).zip(volume) {
                    let padded = volume.len() / ROWS;
                    for (k, row) in window.volume.iter_mut().enumerate() {
                        *row = *load(volume, k * padded + start);
                    }
                }
                if let Some(secondary) = &own.secondary {
                    compositing::add_surface_reflections(secondary, tile, &mut scratch.windows[..scratch.used]);
                }
            }
            None => {
                let neighbours = lit.neighbours();
                draw(own, &neighbours, start, &line, first);
                lit.add_exchange(tile, first);
                if let Some(secondary) = &own.secondary {
                    compositing::composite(own, &neighbours, secondary, tile, scratch);
                    let used = scratch.used;
                    scratch.windows[..used].iter_mut().for_each(|window| lit.add_pocket_light(tile, window));
                }
                streaks::draw(Streak::near_tile(&own.streaks, tile), start, &mut scratch.windows[0]);
                if let Some(second) = self.second {
                    second.add(lit, tile, scratch);
                }
            }
        }
        mixed_columns::mix(&own.mixed, tile, &mut scratch.windows[0]);
    }

    /// Whether a tile shows nothing but a line that is one Gaussian and what spreads from it over a level surface, but
    /// for edges whose sides do not mix rows.
    pub fn is_line_alone(&self, tile: usize) -> bool {
        let LitProfile { camera, geometry, band, profile } = self.lit;
        let own = self.lit.line();
        geometry.exposed_share == 0.0
            && camera.laser.line_profile().is_none()
            && !camera.has_ambient()
            && band.glare.is_empty()
            && self.second.is_none()
            && band.volume(profile).is_none()
            && own.defocus_radius.is_empty()
            && !self.lit.may_exchange(tile)
            && own.secondary.as_ref().is_none_or(|secondary| !secondary.pockets.reaches(&secondary.patches, tile))
            && own.secondary.as_ref().is_none_or(|secondary| secondary.needs[tile] == WindowNeed::Line)
            && mixed_columns::share_rows_or_none(&own.mixed, tile, load(&own.centre, tile * TILE))
            && Streak::near_tile(&own.streaks, tile).is_empty()
            && !SeenRows::are_uneven(own, &self.lit.neighbours(), tile * TILE)
    }

    /// A bound on the light of the line in the rows of a tile's window that are not among `rows`, a column [e-]; `None`
    /// where front faces let some of it out.
    pub fn light_beyond(&self, tile: usize, rows: &Range<usize>, speckle: &AnchoredSpeckle) -> Option<[f32; TILE]> {
        let (start, own) = (tile * TILE, self.lit.line());
        let neighbours = self.lit.neighbours();
        let mut exits = [0.0f32; BASIS];
        for k in (0..rows.start).chain(rows.end..ROWS) {
            if neighbours[k].front_of(start).is_some() {
                return None;
            }
            let greatest = neighbours[k].greatest_exits[tile];
            exits.iter_mut().zip(greatest).for_each(|(most, exit)| *most = greater(*most, exit));
        }
        // Light of short paths, as from knots, keeps more contrast than that of the wood that the patterns are made
        // for.
        let contrasts = own.contrasts_of(tile).as_flattened().as_flattened();
        let brightest = speckle.brightest(contrasts.iter().fold(1.0, |most: f32, contrast| most.max(*contrast)));
        let mut light = light_beyond(own, start, rows, &exits, brightest);
        mix_bounds(MixedColumn::of_tile(&own.mixed, tile), start, load(&own.centre, start), &mut light);
        Some(light)
    }
}
