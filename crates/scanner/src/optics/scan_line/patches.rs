//! Patches of a line that send light to each other: what each sends out, what it glows with, what it shows of light
//! that it receives. Who receives how much is worked out where windows are drawn ([`crate::optics::window`]).
//!
//! A patch is [`STRIDE`] columns wide and sends out its flux times albedo by Lambert's law. What of light from all
//! sides it sends to the lens is, by reciprocity, the share of light from there that its film turns, and what a tablet
//! below it throws back. Light that has spread far in film glows about the line; so does what patches of the line have
//! sent each other, a second exchange that is worked out across the motion alone. What fills a pocket is not counted
//! here: it leaves elsewhere.

use base::{Film, Surface};
use glam::Vec3;
use multiversion::multiversion;

use super::film::{entering_share, spread};
use super::view::LitLine;
use crate::optics::camera::Sight;
use crate::optics::light::{FAR, NEAR_MM2, Patches, STRIDE, ScanLine, middle_of};
use crate::optics::speckle::TILE;
use crate::specimen::Hit;
use transport::fresnel::ENTERS_FROM_ALL_SIDES;
use transport::kernel::film_stack::FilmStackKernel;
use transport::kernel::{BASIS, PACK_SPREAD_MM};

/// Square of a slope from which a patch faces others [1].
const UNEVEN_SLOPE2: f32 = 0.01;
/// Most by which light from all sides enters better than the laser's [1].
const MAX_EASE: f32 = 2.0;
/// Patches on either side that light one once more.
const AGAIN: usize = 24;
/// Places of a vector.
const LANES: usize = 16;

impl Patches {
    /// Takes the patches of a line.
    pub(crate) fn find(&mut self, lit: &LitLine<'_>, line: &ScanLine, films: &mut FilmStackKernel) {
        let columns = lit.hits.len();
        let padded = columns.next_multiple_of(TILE);
        let Self { x, z, slope_x, slope_y, sends, glows, glow_mm, returns, shows, facing, .. } = self;
        for field in [x, z, slope_x, slope_y, sends, glows, glow_mm, returns, shows, facing] {
            field.clear();
            field.resize(padded / STRIDE, 0.0);
        }
        self.uneven.clear();
        self.uneven.resize(padded / TILE, false);
        for column in (0..columns).step_by(STRIDE) {
            if let Some(film) = &lit.hits[middle_of(column, columns)].matter.film {
                self.take(column, lit, line, film, films);
            }
        }
        if self.uneven.contains(&true) {
            light_once_more(self);
        }
    }

    /// Takes the patch of the columns from `column` on, of which the middle one sees this film. Its place and slope are
    /// the means of its columns: sampled, walls a few patches wide would flicker from profile to profile.
    fn take(&mut self, column: usize, lit: &LitLine<'_>, line: &ScanLine, film: &Film, films: &mut FilmStackKernel) {
        let hits = &lit.hits[column..(column + STRIDE).min(lit.hits.len())];
        let mean = |value: &dyn Fn(&Hit) -> f32| hits.iter().map(value).sum::<f32>() / hits.len() as f32;
        let share = |holds: &dyn Fn(&Hit) -> bool| mean(&|hit| f32::from(u8::from(holds(hit))));
        let (hit, place) = (&lit.hits[middle_of(column, lit.hits.len())], column / STRIDE);
        let medium = &hit.matter.medium;
        let [x, z] = [mean(&|hit| hit.x), mean(&|hit| hit.surface.z)];
        let [slope_x, slope_y] = [mean(&|hit| hit.surface.slope_x), mean(&|hit| hit.surface.slope_y)];
        let upright2 = 1.0 + slope_x * slope_x + slope_y * slope_y;
        let normal = Vec3::new(-slope_x, -slope_y, 1.0) / upright2.sqrt();
        let sight = lit.view.sight(x, &Surface { z, slope_x, slope_y });
        // A wall scatters to where the lens is not.
        let spread = spread(&hit.matter, film, normal, &Sight { view: normal, ..sight }, films);
        (self.x[place], self.z[place]) = (x, z);
        (self.slope_x[place], self.slope_y[place]) = (slope_x, slope_y);
        let near = spread.enter.iter().zip(spread.exit).take(FAR);
        // What has crossed a pocket leaves that elsewhere.
        let alone = |j: usize| if film.is_over_room() { spread.alone[j] } else { 1.0 };
        let own: f32 = near.enumerate().map(|(j, (enter, exit))| enter * exit * alone(j)).sum();
        let through = spread.passes * spread.below.iter().sum::<f32>();
        let out = medium.gloss.matte + own + through;
        let columns = hits.len() as f32;
        self.sends[place] = columns * share(&|hit| hit.lit) * sight.electrons * out / upright2.sqrt();
        let (mut glow, mut moment) = (0.0, 0.0);
        for j in FAR..BASIS {
            let source = line.source[j][column..column + hits.len()].iter().sum::<f32>();
            let flux = source * spread.exit[j] / sight.view.z;
            glow += flux;
            moment += flux * PACK_SPREAD_MM[j] * PACK_SPREAD_MM[j];
        }
        // A wall has more area than the card below it, and all of it glows.
        self.glows[place] = glow;
        self.glow_mm[place] = if glow > 0.0 { (moment / glow).sqrt() } else { 0.0 };
        let [before, behind] = [column.saturating_sub(1), (column + STRIDE).min(lit.hits.len() - 1)];
        let wide = (lit.hits[behind].x - lit.hits[before].x) / (behind - before).max(1) as f32;
        let enters = entering_share(medium.n_eff, normal, -sight.light);
        let ease = (ENTERS_FROM_ALL_SIDES / enters.max(f32::MIN_POSITIVE)).min(MAX_EASE);
        // What has crossed the film fills the pocket, and is not seen here; what foil mirrors goes elsewhere.
        let turned: f32 = spread.enter.iter().take(FAR).map(|enter| enter * enter).sum();
        let passed = if film.under.gloss.is_metal() { 0.0 } else { through };
        let reflectance = medium.gloss.matte + ease * (turned + passed);
        let reflects = wide.clamp(0.0, 2.0 * sight.column_mm) * reflectance;
        self.returns[place] = columns * reflects / upright2.sqrt();
        let facing = share(&|hit| hit.seen) * normal.dot(sight.view).max(0.0);
        self.shows[place] = std::f32::consts::FRAC_1_PI * reflects * facing;
        self.facing[place] = reflectance * facing;
        self.uneven[column / TILE] |= upright2 > 1.0 + UNEVEN_SLOPE2;
    }
}

/// Adds to what glows the light that the line's patches send each other: what they send on is the second exchange. Of a
/// patch that is even along the motion, at a distance r across it, the integral of 1 / d^4 along the motion is pi / (2
/// r^3), and that of y^2 / d^4 is r^2 times that.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn light_once_more(patches: &mut Patches) {
    let places = patches.x.len();
    for at in 0..places {
        let [x, z, slope_x] = [patches.x[at], patches.z[at], patches.slope_x[at]];
        let near = at.saturating_sub(AGAIN) / LANES * LANES..(at + AGAIN).next_multiple_of(LANES).min(places);
        let (mut fluxes, mut moments) = ([0.0f32; LANES], [0.0f32; LANES]);
        for start in near.step_by(LANES) {
            let [xs, zs, slopes, sends] = [&patches.x, &patches.z, &patches.slope_x, &patches.sends]
                .map(|field| field[start..].first_chunk::<LANES>().expect("a tile holds whole vectors"));
            for lane in 0..LANES {
                let (dx, dz) = (xs[lane] - x, zs[lane] - z);
                let (received, sent) = ((dz - slope_x * dx).max(0.0), (slopes[lane] * dx - dz).max(0.0));
                let r2 = dx * dx + dz * dz + NEAR_MM2;
                let flux = sends[lane] * received * sent / (r2 * r2.sqrt());
                fluxes[lane] += flux;
                moments[lane] += flux * r2;
            }
        }
        let (flux, moment) = (fluxes.iter().sum::<f32>(), moments.iter().sum::<f32>());
        let returned = 0.5 * patches.returns[at];
        let (glow, variance) = (patches.glows[at], patches.glow_mm[at] * patches.glow_mm[at]);
        let all = glow + returned * flux;
        if all > 0.0 {
            patches.glow_mm[at] = ((glow * variance + returned * moment) / all).sqrt();
            patches.glows[at] = all;
        }
    }
}
