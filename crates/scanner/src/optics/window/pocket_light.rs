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
use crate::optics::light::{
    NEAR, NEAR_WIDTHS, PER_TILE, Patches, PocketLight, ROWS, STRIDE, ScanLine, SecondaryLight, middle_of,
};
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

/// Heights of the near widths' Gaussians in the line's middle, of so much light [e-/mm].
fn near_middle(light: [f32; NEAR_WIDTHS]) -> [f32; NEAR_WIDTHS] {
    std::array::from_fn(|k| light[k] * 0.398_942_3 / PACK_SPREAD_MM[NEAR.start + k])
}

/// Light of the near widths where their Gaussians are so high, over the middle's [e-/mm].
fn near(middle: &[f32; NEAR_WIDTHS], heights: &[f32; NEAR_WIDTHS]) -> f32 {
    middle.iter().zip(heights).map(|(middle, height)| middle * height).sum()
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
        let looks = places(&away).map(|(node, more)| {
            let (line, away) = (lines[node], away[node] + more);
            SeenPlace {
                line,
                y: line.y_mm + more,
                away,
                rows_away: away * own.level_rows_per_mm,
                moved: line.moved_px - own.moved_px,
                heights: heights(away),
            }
        });
        let mut shown = [[0.0f32; ROWS]; PER_TILE + 2];
        let mut is_dark = true;
        for (i, shown) in shown.iter_mut().enumerate() {
            let patch = (tile * PER_TILE + i).saturating_sub(1).min(from.pockets.shows.len() - 1);
            let column = middle_of(patch * STRIDE, own.hits.len());
            let Some(lit) = from.near_patch(patch, column) else { continue };
            let first = window.first_row[column.clamp(tile * TILE, tile * TILE + TILE - 1) - tile * TILE] as f32;
            let row = |look: &SeenPlace<'_>, centre: f32| centre - look.moved - look.rows_away - first;
            let film = looks.each_ref().map(|look| Some(row(look, look.line.centre[column])));
            let below = looks.each_ref().map(|look| {
                let below = &look.line.secondary.as_ref()?.transmitted;
                (below.shows[column] > 0.0).then(|| row(look, below.centre[column]))
            });
            is_dark &= lay_lit(&looks, &film, |look| lit.film_shows(look), shown)
                & lay_lit(&looks, &below, |look| lit.below_shows(look), shown);
        }
        if !is_dark {
            window.add_patches(&shown);
        }
    }
}

/// Lays light on the rows that some places are seen in, which is asked for where it falls into a window; whether there
/// is none.
fn lay_lit<const N: usize>(
    looks: &[SeenPlace<'_>; N],
    rows: &[Option<f32>; N],
    light: impl Fn(&SeenPlace<'_>) -> f32,
    shown: &mut [f32; ROWS],
) -> bool {
    // A stretch that lies on one side of the window is not in it.
    let side = |row: f32| if row < -0.5 { -1 } else { i32::from(row > ROWS as f32 - 0.5) };
    let (mut last, mut is_dark): (Option<(usize, Node)>, bool) = (None, true);
    for (number, pair) in rows.windows(2).enumerate() {
        let [Some(from), Some(to)] = *pair else { continue };
        if side(from) != 0 && side(from) == side(to) {
            continue;
        }
        let node = |at: usize, row: f32| Node { row, y: looks[at].away, by_mm: light(&looks[at]) };
        let a = last.filter(|last| last.0 == number).map_or_else(|| node(number, from), |last| last.1);
        let b = node(number + 1, to);
        last = Some((number + 1, b));
        if a.by_mm > 0.0 || b.by_mm > 0.0 {
            is_dark = false;
            lay(a, b, shown);
        }
    }
    is_dark
}

/// A place that a window looks at.
struct SeenPlace<'a> {
    /// The line that stands there, or is the last before it.
    line: &'a ScanLine,
    /// Where along the motion [mm].
    y: f32,
    /// The same from the window's line on [mm], in rows of a level surface [px].
    away: f32,
    rows_away: f32,
    /// By how much the line is seen lower than by the instrument that exposes the window's [px].
    moved: f32,
    /// Of the near widths there, over the middle's [1].
    heights: [f32; NEAR_WIDTHS],
}

/// Most cavities whose light a patch shows.
const NEAR_CAVITIES: usize = 3;

/// Light of cavities near a patch of the line that they are lit by.
struct PatchLight<'a> {
    lit: [Option<&'a CavityLight>; NEAR_CAVITIES],
    patch: usize,
    column: usize,
    /// Light of the line that the near widths hold in its middle: of the film, and below it [e-/mm].
    near: [[f32; NEAR_WIDTHS]; 2],
}

impl SecondaryLight {
    /// Light of the cavities near a patch, which `column` stands for; `None` where there is none.
    fn near_patch(&self, patch: usize, column: usize) -> Option<PatchLight<'_>> {
        let x = self.patches.x[patch];
        let mut lit = self.pockets.lit.iter().filter(|light| light.is_within(x, x));
        let lit = std::array::from_fn(|_| lit.next());
        lit[0]?;
        let film = self.pockets.near.each_ref().map(|near| near[patch]);
        let below = self.transmitted.near.each_ref().map(|near| near[column]);
        Some(PatchLight { lit, patch, column, near: [film, below].map(near_middle) })
    }
}

impl PatchLight<'_> {
    #[inline(always)]
    fn lit(&self) -> impl Iterator<Item = &CavityLight> {
        self.lit.iter().map_while(|light| *light)
    }

    /// Light that film over a pocket, or the card beside it, shows in the patch [e-/mm].
    #[inline(always)]
    fn film_shows(&self, look: &SeenPlace<'_>) -> f32 {
        let Some(secondary) = &look.line.secondary else { return 0.0 };
        let at = Vec2::new(secondary.patches.x[self.patch], look.y);
        let shows = secondary.pockets.shows[self.patch];
        if shows > 0.0 {
            let leaves = self.lit().find_map(|light| light.leaves(at)).unwrap_or(0.0);
            (shows * leaves - near(&self.near[0], &look.heights)).max(0.0)
        } else {
            secondary.patches.facing[self.patch] * self.lit().filter_map(|light| light.card(at)).sum::<f32>()
        }
    }

    /// What lies below the film shows there [e-/mm].
    #[inline(always)]
    fn below_shows(&self, look: &SeenPlace<'_>) -> f32 {
        let Some(secondary) = &look.line.secondary else { return 0.0 };
        let (below, column) = (&secondary.transmitted, self.column);
        let [x, y] = below.lands.each_ref().map(|lands| lands[column]);
        let light = self.lit().find_map(|light| light.below(Vec2::new(x, look.y + y))).unwrap_or(0.0);
        (below.shows[column] * light - near(&self.near[1], &look.heights)).max(0.0)
    }
}
