//! What film over pockets lets in of a line's light and shows of what is in them, column by column and by patches; the
//! light that enters spreads in the cavity ([`crate::specimen::cavity`]).
//!
//! Near the line the planar model of film and what lies below stands ([`super::film`]): its widths up to half a
//! millimetre. Wider ones know no walls and are left out in pockets. Where pockets let their light out again is worked
//! out where windows are drawn ([`crate::optics::window`]).

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::view::LitLine;
use crate::optics::camera::Sight;
use crate::optics::light::{FILLING, NEAR, NEAR_WIDTHS, PocketLight, STRIDE, ScanLine};
use crate::optics::speckle::TILE;
use crate::specimen::Hit;
use crate::specimen::cavity::{Cavity, CavityLight};
use transport::kernel::film_stack::FilmStackSpread;

/// Lets light of lines that are all made spread in the cavities that it has entered.
pub(crate) fn spread_in_cavities<'a>(lines: impl Iterator<Item = &'a mut ScanLine>) {
    let lit = lines.filter_map(|line| line.secondary.as_mut());
    CavityLight::spread(lit.flat_map(|secondary| &mut secondary.pockets.lit).collect());
}

/// What a column's film over a pocket lets in and out.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PocketColumn {
    /// Light that enters the film [e-].
    enters: f32,
    /// What of light by area the column shows [1].
    shows: f32,
    /// Light of the line that has crossed the pocket and that the near widths hold [e-].
    near: [f32; NEAR_WIDTHS],
}

impl PocketColumn {
    /// Of film with this `normal` under `hit`, which spreads light like `spread`; `arrives` of the laser's light, of
    /// which `enters` goes in.
    pub fn of(hit: &Hit, normal: Vec3, sight: &Sight, spread: &FilmStackSpread, [arrives, enters]: [f32; 2]) -> Self {
        let facing = if hit.seen { normal.dot(sight.view).max(0.0) } else { 0.0 };
        let passed = |j: usize| spread.enter[j] * spread.exit[j] * (1.0 - spread.alone[j]);
        Self {
            enters: arrives * enters,
            shows: facing * spread.through,
            near: std::array::from_fn(|k| arrives * facing * passed(NEAR.start + k)),
        }
    }
}

/// Takes from a pocket's film the wide light that the planar model gives it.
pub(crate) fn leave_to_cavity(spread: &mut FilmStackSpread) {
    for (j, alone) in spread.alone.iter().enumerate().skip(FILLING) {
        let left = alone.sqrt();
        spread.enter[j] *= left;
        spread.exit[j] *= left;
    }
}

impl PocketLight {
    /// Takes the light of a line with these columns.
    pub fn find(&mut self, lit: &LitLine<'_>, columns: &[PocketColumn]) {
        let patches = columns.len().next_multiple_of(TILE) / STRIDE;
        for field in std::iter::once(&mut self.shows).chain(&mut self.near) {
            field.clear();
            field.resize(patches, 0.0);
        }
        for (patch, columns) in columns.chunks(STRIDE).enumerate() {
            let mean =
                |value: &dyn Fn(&PocketColumn) -> f32| columns.iter().map(value).sum::<f32>() / columns.len() as f32;
            self.shows[patch] = mean(&|column| column.shows);
            for (k, near) in self.near.iter_mut().enumerate() {
                near[patch] = mean(&|column| column.near[k]);
            }
        }
        self.enter(lit, columns);
    }

    /// Lets the line's light into the cavities that it crosses, where it is still to spread.
    fn enter(&mut self, lit: &LitLine<'_>, columns: &[PocketColumn]) {
        self.lit.clear();
        let pockets = &lit.view.specimen.pockets;
        let mut last: Option<&Arc<Cavity>> = None;
        for (column, of) in columns.iter().enumerate().filter(|(_, of)| of.enters > 0.0) {
            let place = Vec2::new(lit.hits[column].x, lit.view.y);
            let near = last.filter(|cavity| cavity.holds(place));
            let Some(cavity) = near.or_else(|| pockets.iter().find_map(|pocket| pocket.at(place))) else { continue };
            last = Some(cavity);
            let at = self.lit.iter().position(|light| light.is_of(cavity)).unwrap_or_else(|| {
                self.lit.push(CavityLight::none(cavity));
                self.lit.len() - 1
            });
            let [before, behind] = [column.saturating_sub(1), (column + 1).min(columns.len() - 1)];
            let wide = (lit.hits[behind].x - lit.hits[before].x).abs() / (behind - before).max(1) as f32;
            self.lit[at].enter(place, of.enters * wide);
        }
    }
}
