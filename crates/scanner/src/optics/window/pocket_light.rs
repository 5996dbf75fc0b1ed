//! Pocket light: what pockets let out of the light that enters through their film, wherever that has gone in them
//! ([`crate::specimen::cavity`]).
//!
//! Near the line the planar model of film and what lies below stands (`film` of [`crate::optics::scan_line`]): its
//! widths up to half a millimetre. Wider ones know no walls and are left out in pockets; the cavity tells what leaves
//! at each place, of which the near widths' part is taken off. So is light that the film throws down again and that
//! tablets or foil then show through it. Both are worked out in patches of [`STRIDE`] columns and every [`NODE_ROWS`]th
//! row of a window, at the place that the row looks at, and are linear between; beyond the rows that a window looks at
//! the surface goes on level, and light by its place. The card around a pocket shows what it receives of the walls'
//! light. Neglected: what leaves film beyond the window's rows where that is not level, what one pocket sends into
//! another.

use glam::Vec2;

use super::electrons::Window;
use super::interreflections::{NODES, Node, lay};
use super::lit_profile::LitProfile;
use crate::optics::light::{NEAR, NEAR_WIDTHS, PER_TILE, Patches, PocketLight, ROWS, STRIDE, ScanLine, middle_of};
use crate::optics::speckle::TILE;
use crate::specimen::cavity::CavityLight;
use numerics::lanes::exp;
use transport::kernel::PACK_SPREAD_MM;

/// Square of the standard deviations beyond which their light is nothing.
const NEAR_REACH2: f32 = 30.0;
/// Places on either side beyond the rows that a window looks at, and their distance [mm].
const BEYOND: usize = 8;
const BEYOND_MM: f32 = 0.5;

impl PocketLight {
    /// Whether pockets that the line lights show anything of it in a tile of its line, whose patches these are.
    pub fn reaches(&self, patches: &Patches, tile: usize) -> bool {
        let of = (tile * PER_TILE).saturating_sub(1)..((tile + 1) * PER_TILE + 1).min(patches.x.len());
        let (first, last) = (patches.x[of.start], patches.x[of.end - 1]);
        self.lit.iter().any(|light| light.is_within(first.min(last), first.max(last)))
    }
}

/// Heights of the near widths' Gaussians at a distance from the line, before they are divided by the widths.
fn heights(away_mm: f32) -> [f32; NEAR_WIDTHS] {
    std::array::from_fn(|k| {
        let off = away_mm / PACK_SPREAD_MM[NEAR.start + k];
        if off * off < NEAR_REACH2 { exp(-0.5 * off * off) } else { 0.0 }
    })
}

/// Light of the near widths where their Gaussians are so high [e-/mm].
fn near(light: [f32; NEAR_WIDTHS], heights: &[f32; NEAR_WIDTHS]) -> f32 {
    let widths = PACK_SPREAD_MM[NEAR].iter().zip(heights);
    light.into_iter().zip(widths).map(|(light, (spread, height))| light * 0.398_942_3 / spread * height).sum()
}

/// A place that a window looks at: the number of a node, and how far beyond it [mm].
type Place = (usize, f32);

/// Places of a window from behind the line to before it, whose nodes are `away` from it [mm].
fn places(away: &[f32; NODES]) -> [Place; NODES + 2 * BEYOND] {
    let side = |end: usize| if away[end] < 0.0 { -BEYOND_MM } else { BEYOND_MM };
    std::array::from_fn(|k| match k {
        0..BEYOND => (0, (BEYOND - k) as f32 * side(0)),
        _ if k < BEYOND + NODES => (k - BEYOND, 0.0),
        _ => (NODES - 1, (k - BEYOND - NODES + 1) as f32 * side(NODES - 1)),
    })
}

impl LitProfile<'_> {
    /// Adds what pockets let out of the line's light to a window of a tile.
    pub fn add_pocket_light(&self, tile: usize, window: &mut Window) {
        let own = self.line();
        let Some(from) = &own.secondary else { return };
        if !from.pockets.reaches(&from.patches, tile) {
            return;
        }
        let lines = self.node_lines();
        let away = lines.map(|line| line.y_mm - own.y_mm);
        let places = places(&away).map(|(node, more)| (node, more, heights(away[node] + more)));
        let mut shown = [[0.0f32; ROWS]; PER_TILE + 2];
        let mut is_dark = true;
        for (i, shown) in shown.iter_mut().enumerate() {
            let patch = (tile * PER_TILE + i).saturating_sub(1).min(from.pockets.shows.len() - 1);
            let Some(lit) = from.pockets.near_patch(&from.patches, patch) else { continue };
            let column = middle_of(patch * STRIDE, own.hits.len());
            let first = window.first_row[column.clamp(tile * TILE, tile * TILE + TILE - 1) - tile * TILE];
            let mut last: [Option<Node>; 2] = [None; 2];
            for (node, more, heights) in &places {
                let (line, d) = (lines[*node], away[*node] + more);
                let film = Some([line.row_beside(own, column), lit.film_shows(line, *more, heights)]);
                let seen = [film, lit.below_shows(own, line, column, *more, heights)];
                for (seen, last) in seen.into_iter().zip(&mut last) {
                    let node = seen.map(|[centre, by_mm]| {
                        let row = centre - d * own.level_rows_per_mm - first as f32;
                        Node { row, y: d, by_mm }
                    });
                    if let (Some(a), Some(b)) = (*last, node) {
                        is_dark &= a.by_mm <= 0.0 && b.by_mm <= 0.0;
                        lay(a, b, shown);
                    }
                    *last = node;
                }
            }
        }
        if !is_dark {
            window.add_patches(&shown);
        }
    }
}

/// Most cavities whose light a patch shows.
const NEAR_CAVITIES: usize = 3;

/// Light of cavities near a patch of the line that they are lit by.
struct PatchLight<'a> {
    lit: [Option<&'a CavityLight>; NEAR_CAVITIES],
    from: &'a PocketLight,
    patch: usize,
}

impl PocketLight {
    /// Light of the cavities near a patch; `None` where there is none.
    fn near_patch(&self, patches: &Patches, patch: usize) -> Option<PatchLight<'_>> {
        let x = patches.x[patch];
        let mut near = self.lit.iter().filter(|light| light.is_within(x, x));
        let lit = std::array::from_fn(|_| near.next());
        lit[0].is_some().then_some(PatchLight { lit, from: self, patch })
    }
}

impl PatchLight<'_> {
    fn lit(&self) -> impl Iterator<Item = &CavityLight> {
        self.lit.iter().map_while(|light| *light)
    }

    /// Light that film over a pocket, or the card beside it, shows in the patch of `line`, or as far beyond it, where
    /// near widths are so high [e-/mm].
    fn film_shows(&self, line: &ScanLine, beyond: f32, heights: &[f32; NEAR_WIDTHS]) -> f32 {
        let (Some(secondary), patch) = (&line.secondary, self.patch) else { return 0.0 };
        let at = Vec2::new(secondary.patches.x[patch], line.y_mm + beyond);
        let shows = secondary.pockets.shows[patch];
        if shows > 0.0 {
            let leaves = self.lit().find_map(|light| light.leaves(at)).unwrap_or(0.0);
            (shows * leaves - near(self.from.near.each_ref().map(|near| near[patch]), heights)).max(0.0)
        } else {
            secondary.patches.facing[patch] * self.lit().filter_map(|light| light.card(at)).sum::<f32>()
        }
    }

    /// Where the line below the film of `line` is seen, and what lies there shows of the light of `own`'s line [px,
    /// e-/mm].
    fn below_shows(
        &self,
        own: &ScanLine,
        line: &ScanLine,
        column: usize,
        beyond: f32,
        heights: &[f32; NEAR_WIDTHS],
    ) -> Option<[f32; 2]> {
        let below = &line.secondary.as_ref()?.transmitted;
        let shows = below.shows[column];
        if shows <= 0.0 {
            return None;
        }
        let [x, y] = below.lands.each_ref().map(|lands| lands[column]);
        let at = Vec2::new(x, line.y_mm + y + beyond);
        let light = self.lit().find_map(|light| light.below(at)).unwrap_or(0.0);
        let moved = line.moved_px - own.moved_px;
        let own = &own.secondary.as_ref()?.transmitted;
        let near = near(own.near.each_ref().map(|near| near[column]), heights);
        Some([below.centre[column] - moved, (shows * light - near).max(0.0)])
    }
}
