//! The film over the whole card: pockets on a grid, the flange between them, bumps and crevices.
//!
//! Models: heights are those of the upper side over the conveyor on a flat card; the lower side lies the thickness
//! across the film below it, thickness sqrt(1 + slope^2) upright. Every place belongs to the nearest pocket of the
//! grid. Formed film has smooth bumps and, along the level lines of a second noise, crevices of about their height.
//! Neglected: the curvature of the film over its own thickness.

use base::{Gloss, Medium, Stream};
use glam::Vec2;

use super::Blister;
use super::formed_pocket::FormedPocket;
use super::parameters::Pocket;
use super::tablet::TabletForm;
use super::texture::{Texture, hump};
use crate::noise::{Noise, smoothstep};

/// Flange that is left between two pockets, or pocket and edge [mm].
pub const FLANGE_MM: f32 = 0.6;
/// Depth of crevices over the size of the bumps, their half width in units of the noise that draws them, and the bump
/// from which on they run, in units of its size [1].
const CREVICE: [f32; 3] = [1.0, 0.4, 0.4];
/// Axis of the second noise [1].
const TURN: Vec2 = Vec2::new(0.8, 0.6);
/// Bumps are at most this share of their size high, root mean square [1].
const STEEPEST: f32 = 0.05;
/// The highest bump over their root mean square [1].
const HIGHEST_BUMP: f32 = 2.3;
/// How far the pockets make room for a code [mm].
const CODE_SHIFT_MM: f32 = 2.5;
/// Distance from a pocket over which knurl and code fade out [mm].
const FADE_MM: [f32; 2] = [0.2, 0.8];

/// A pocket of the grid.
#[derive(Debug, Clone, Copy)]
pub struct PocketCell {
    /// Middle on the card [mm].
    pub middle: Vec2,
    /// Its depth over that of the form [1].
    pub factor: f32,
    /// How far its film is stretched, see [`FormedPocket::stretch`] [1].
    pub stretch: f32,
}

/// The film.
#[derive(Debug, Clone)]
pub struct FormedWeb {
    /// The form of the pockets.
    pub formed: FormedPocket,
    /// Every pocket, rows along the laser line one after another.
    pub cells: Vec<PocketCell>,
    /// Upper side of the foil [mm].
    pub foil_mm: f32,
    /// Thickness of the flange [mm].
    pub flat_mm: f32,
    count: [usize; 2],
    pitch: Vec2,
    shift: f32,
    texture: Texture,
    bumps_mm: f32,
    bump_size: f32,
    spread: f32,
    noise: [Noise; 2],
    medium: Medium,
    roughness: [f32; 2],
}

/// The film at a place of the card.
#[derive(Debug, Clone, Copy)]
pub struct WebFilm {
    /// Upper side over the conveyor [mm].
    pub top: f32,
    /// Its gradient in the axes of the card [1].
    pub slope: Vec2,
    /// Thickness across the film [mm].
    pub thickness: f32,
    /// Distance inwards from the nearest pocket's outline; far less than 0 away from it [mm].
    pub inset: f32,
    /// How far it is drawn [1].
    pub drawn: f32,
}

impl WebFilm {
    /// Lower side over the conveyor on a flat card, where the card as it lies is tilted by that slope [mm].
    #[inline]
    pub fn low(&self, tilt: Vec2) -> f32 {
        self.top - self.thickness * (1.0 + (self.slope + tilt).length_squared()).sqrt()
    }

    /// Thins the film as far as its lower side would lie below `low` [mm].
    pub fn keep_above(&mut self, low: f32, tilt: Vec2) {
        let steep = (1.0 + (self.slope + tilt).length_squared()).sqrt();
        self.thickness = self.thickness.min((self.top - low) / steep);
    }
}

/// Root mean square of the bumps [mm].
fn bumps_mm(pocket: &Pocket) -> f32 {
    (1.0e-3 * pocket.bumps_um as f32).min(STEEPEST * pocket.bump_size_mm as f32)
}

/// Largest bump of such pockets [mm].
pub fn highest_bump_mm(pocket: &Pocket) -> f32 {
    HIGHEST_BUMP * bumps_mm(pocket)
}

impl FormedWeb {
    /// The film of a pack on a card of half size `half`; `slack` as in [`FormedPocket::new`].
    pub fn new(stream: Stream, blister: &Blister, form: &TabletForm, half: Vec2, slack: f32) -> Self {
        let (card, pocket, web) = (&blister.card, &blister.pocket, &blister.web);
        let formed = FormedPocket::new(pocket, web, form, slack);
        let box_mm = 2.0 * formed.reach() + FLANGE_MM;
        let asked = Vec2::new(card.pitch_x_mm as f32, card.pitch_y_mm as f32);
        let pitch = asked.max(box_mm);
        // As many pockets as the card has room for.
        let room = |asked: f64, size: f32, box_mm: f32, pitch: f32| {
            let fit = if size < box_mm + FLANGE_MM { 0.0 } else { 1.0 + (size - box_mm - FLANGE_MM) / pitch };
            (asked as usize).min(fit as usize)
        };
        let count =
            [room(card.columns, 2.0 * half.x, box_mm.x, pitch.x), room(card.rows, 2.0 * half.y, box_mm.y, pitch.y)];
        // Room for the code at the far edge, as far as there is any.
        let spare = half.y - 0.5 * (count[1] as f32 - 1.0) * pitch.y - 0.5 * box_mm.y - 0.5 * FLANGE_MM;
        let shift = if card.code_mm > 0.0 { -spare.clamp(0.0, CODE_SHIFT_MM) } else { 0.0 };
        let stretch = formed.stretch(1.0);
        let at = |i: usize, n: usize| i as f32 - 0.5 * (n as f32 - 1.0);
        let cells = (0..count[0] * count[1])
            .map(|i| {
                let middle = pitch * Vec2::new(at(i % count[0], count[0]), at(i / count[0], count[1]));
                let middle = middle + Vec2::new(0.0, shift);
                PocketCell { middle, factor: 1.0, stretch }
            })
            .collect();
        let gloss = Gloss {
            share: 1.0,
            reflectance: super::fresnel(web.n as f32),
            roughness: [web.roughness as f32; 2],
            matte: 0.0,
        };
        let bump_size = pocket.bump_size_mm as f32;
        Self {
            formed,
            cells,
            foil_mm: blister.foil.thickness_mm as f32,
            flat_mm: web.thickness_mm as f32,
            count,
            pitch,
            shift,
            texture: Texture::new(stream, card, web, half.y),
            bumps_mm: bumps_mm(pocket),
            bump_size,
            spread: web.thinning_spread as f32,
            noise: [Noise::new(stream.child("bumps")), Noise::new(stream.child("thinning"))],
            medium: Medium::isotropic(web.mu_a_per_mm as f32, web.sigma_per_mm as f32, web.n as f32, gloss),
            roughness: [web.roughness, web.formed_roughness].map(|r| r as f32),
        }
    }

    /// Number of the nearest pocket; `None` on a card without any.
    #[inline]
    pub fn nearest(&self, p: Vec2) -> Option<usize> {
        let [columns, rows] = self.count;
        if columns * rows == 0 {
            return None;
        }
        let share = (p - Vec2::new(0.0, self.shift)) / self.pitch + 0.5 * Vec2::new(columns as f32, rows as f32);
        let (i, j) = (share.x.max(0.0) as usize, share.y.max(0.0) as usize);
        Some(j.min(rows - 1) * columns + i.min(columns - 1))
    }

    /// Pockets whose cells a box of the card reaches into.
    pub fn cells_in(&self, low: Vec2, high: Vec2) -> Vec<usize> {
        let (Some(first), Some(last)) = (self.nearest(low), self.nearest(high)) else { return Vec::new() };
        let columns = self.count[0];
        let rows = first / columns..=last / columns;
        rows.flat_map(|row| (first % columns..=last % columns).map(move |column| row * columns + column)).collect()
    }

    /// Forms a pocket `factor` times as deep as the form.
    pub fn deepen(&mut self, cell: usize, factor: f32) {
        self.cells[cell].factor = factor;
        self.cells[cell].stretch = self.formed.stretch(factor);
    }

    /// Pockets along the laser line and along the scan, and their distance [mm].
    pub fn grid(&self) -> ([usize; 2], Vec2) {
        (self.count, self.pitch)
    }

    /// Where the middle of all pockets lies along the card [mm].
    pub fn shift(&self) -> f32 {
        self.shift
    }

    /// Height of what tools pressed into film and foil [mm] and its slope [1], with the nearest pocket `inset` away.
    #[inline]
    pub fn relief(&self, p: Vec2, inset: f32) -> (f32, Vec2) {
        let fade = smoothstep(FADE_MM[0], FADE_MM[1], -inset);
        if fade == 0.0 {
            return (0.0, Vec2::ZERO);
        }
        let (height, slope) = self.texture.relief(p);
        (fade * height, fade * slope)
    }

    /// The film over a place of the card, nearest to pocket `cell`.
    #[inline]
    pub fn leaf(&self, p: Vec2, cell: Option<usize>) -> WebFilm {
        let base = self.foil_mm + self.flat_mm;
        let mut inset = f32::NEG_INFINITY;
        let mut cuts = (0.0, Vec2::ZERO);
        if let Some(number) = cell {
            let cell = &self.cells[number];
            let q = p - cell.middle;
            let beyond = q.abs() - self.formed.reach();
            if beyond.max_element() < FADE_MM[1] {
                let skin = self.formed.skin(q, cell.factor);
                inset = skin.inset;
                if inset > 0.0 {
                    let (bump, tilt, noise) = self.bumps(p, skin.rise, skin.slope, cell.factor);
                    let thickness = self.formed.thickness_mm(skin.drawn, cell.stretch) * (1.0 + noise);
                    let top = base + skin.rise + bump;
                    return WebFilm { top, slope: skin.slope + tilt, thickness, inset, drawn: skin.drawn };
                }
            }
            let (column, row) = (number % self.count[0], number / self.count[0]);
            let open = [column > 0, column + 1 < self.count[0], row > 0, row + 1 < self.count[1]];
            cuts = self.texture.cuts(q, 0.5 * self.pitch, open);
        }
        let (height, slope) = self.relief(p, inset);
        WebFilm {
            top: base + height - cuts.0,
            slope: slope - cuts.1,
            thickness: self.flat_mm - cuts.0,
            inset,
            drawn: 0.0,
        }
    }

    /// Distances from a place of the card to the pocket's ends against the unit vector `way` and along it [mm].
    pub fn ends(&self, p: Vec2, cell: usize, way: Vec2) -> [f32; 2] {
        self.formed.ends(p - self.cells[cell].middle, way)
    }

    /// Bumps and crevices of formed film [mm], their slope [1], and the relative variation of its thickness [1].
    #[inline]
    fn bumps(&self, p: Vec2, rise: f32, slope: Vec2, factor: f32) -> (f32, Vec2, f32) {
        let depth = factor * self.formed.depth_mm().0;
        let full = rise >= depth;
        let weight = if full { 1.0 } else { rise / depth };
        let size = 1.0 / self.bump_size;
        let (bump, tilt) = self.noise[0].plane(p * size);
        // Turned lattice, so that the two do not line up; crevices run where the bumps are high.
        let lattice = 0.8 * size * TURN;
        let (thin, lean) = self.noise[1].plane(Vec2::new(lattice.dot(p), lattice.perp_dot(p)));
        let lean = lean.x * lattice + lean.y * lattice.perp();
        let (groove, steep) = hump(thin / CREVICE[1]);
        let t = ((bump - CREVICE[2]) / CREVICE[2]).clamp(0.0, 1.0);
        let (high, rising) = (t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t) / CREVICE[2]);
        let height = bump - CREVICE[0] * groove * high;
        let mut gradient = weight
            * (size * (1.0 - CREVICE[0] * groove * rising) * tilt - (CREVICE[0] * steep * high / CREVICE[1]) * lean);
        if !full {
            gradient += height / depth * slope;
        }
        // Towards the foot the variation fades with the draw, so that flange and pocket meet.
        (self.bumps_mm * weight * height, self.bumps_mm * gradient, (self.spread * weight * thin).max(-0.8))
    }

    /// Thickness of the film where it was drawn farthest, but for its variation from place to place [mm].
    pub fn thinnest_mm(&self) -> f32 {
        let drawn = self.cells.iter().map(|cell| self.formed.thickness_mm(1.0, cell.stretch));
        drawn.fold(self.formed.thickness_mm(0.0, 0.0), f32::min)
    }

    /// Largest bump [mm].
    pub fn highest_bump(&self) -> f32 {
        HIGHEST_BUMP * self.bumps_mm
    }

    /// Highest that tools pressed up the flange [mm].
    pub fn highest_relief(&self) -> f32 {
        self.texture.highest()
    }

    /// What film that is drawn so far is made of.
    #[inline]
    pub fn medium(&self, drawn: f32) -> Medium {
        let rough = self.roughness[0] + (self.roughness[1] - self.roughness[0]) * drawn.min(1.0);
        let mut medium = self.medium;
        medium.gloss.roughness = [rough; 2];
        medium
    }
}
