//! One row of the specimen in the words of the camera: what each column sends out when the laser stands on it, and what
//! it lets out of its neighbours' light.
//!
//! The light's answer at a point belongs to the object: it is worked out once for each position of the scan and used by
//! every profile whose window holds it.

use std::ops::Range;

use glam::Vec3;
use procedural::{Class, Gloss, Medium};

use super::beside::{self, Beside};
use super::blur::{blur, blur_unlike};
use super::camera::{Camera, Sight};
use super::film::{self, Watch};
use super::lamps;
use super::mirror::Lit;
use super::pieces::pieces;
use super::shine::{self, Shine};
use super::speckle::TILE;
use super::streak::Streak;
use super::texel::texel;
use crate::frame::Sightlines;
use crate::specimen::{Hit, Specimen};
use crate::transport::fresnel;
use crate::transport::kernel::{
    BASIS, SPREAD_ACROSS_OVER_ALONG, SPREAD_MM, SpreadRow, SurfacePoint, WidthShares, exit_shift, line_spread,
};

/// What comes back of light that would cross a wall, which lets it out: less than nothing, since the wall takes of what
/// stands near it too; from the judge's scatter beside a crack and at the side of a board [1].
const SIDE: f32 = -0.5;

/// Numbers of one position of the scan, structure of arrays over sensor columns, padded with zeros to whole tiles.
#[derive(Debug, Clone, Default)]
pub struct Row {
    /// What each column sees; noise-free truth.
    pub hits: Vec<Hit>,
    /// Sensor row of the line's centre [px].
    pub centre: Vec<f32>,
    /// Rows per mm along the motion [px/mm].
    pub rows_per_mm: Vec<f32>,
    /// Variance of laser, lens and pixel [px^2].
    pub variance: Vec<f32>,
    /// Unit of the laser's section; empty for a Gaussian line [px].
    pub unit: Vec<f32>,
    /// Place along the section's nodes; empty for a Gaussian line [1].
    pub node: Vec<f32>,
    /// Radius along the rows of the disc that a point is out of focus by, whose variance `variance` holds; empty where
    /// nothing can be [px].
    pub disc: Vec<f32>,
    /// Light thrown back by the surface itself [e-].
    pub glare: Vec<f32>,
    /// Light that entered below the surface, as a white Lambertian surface would return it to the lens [e-].
    pub power: Vec<f32>,
    /// Light that entered, by width, spread along the line, `[BASIS][columns]` [sqrt(1) e-].
    pub source: [Vec<f32>; BASIS],
    /// Shift of each width's light against the centre, `[BASIS][columns]` [px].
    pub shift: [Vec<f32>; BASIS],
    /// Factor by which each width leaves here towards the lens, `[BASIS][columns]` [sqrt(1)].
    pub exit: [Vec<f32>; BASIS],
    /// The same for light of rows behind this one, which leaves through a front face where this row is bare; `None` where
    /// that makes no difference.
    pub faced: Option<Box<[Vec<f32>; BASIS]>>,
    /// Light of lamps and windows in a pixel that looks here; empty where there is none [e-].
    pub ambient: Vec<f32>,
    /// What else of this line's light the camera sees; `None` for a body that cannot send it elsewhere.
    pub beside: Option<Box<Beside>>,
    /// Single fibres that guide light out of the line, by rising column.
    pub streaks: Vec<Streak>,
}

impl Row {
    /// Radii of the discs of a tile; `None` where all is sharp.
    pub fn disc_of(&self, start: usize) -> Option<&[f32; TILE]> {
        self.disc.get(start..)?.first_chunk()
    }
}

/// Makes rows; holds what is worked out once.
#[derive(Debug)]
pub struct RowMaker {
    shares: WidthShares,
    conveyor: Medium,
    conveyor_reflectance: f32,
    /// Where each column looks.
    columns: Sightlines,
    /// How the camera sees the bare conveyor in each column.
    conveyor_sights: Vec<Sight>,
    shine: Shine,
}

/// Room that one thread needs to make rows.
#[derive(Debug)]
pub struct RowScratch {
    texels: Vec<SurfacePoint>,
    spread: SpreadRow,
    electrons: Vec<f32>,
    line: Vec<f32>,
    /// How much nearer to the lens light is seen to leave, along the motion [mm].
    pull: Vec<f32>,
    /// Variance along the line of what is out of focus; empty where nothing can be [px^2].
    defocus: Vec<f32>,
    /// Diffuse reflectance for light from all sides [1].
    albedo: Vec<f32>,
    pieces: Vec<Range<usize>>,
    beside: beside::Room,
    shine: shine::Room,
}

impl RowScratch {
    /// Room for `columns` columns.
    pub fn new(columns: usize) -> Self {
        Self {
            texels: vec![SurfacePoint::BLACK; columns],
            spread: SpreadRow::new(columns),
            electrons: vec![0.0; columns],
            line: Vec::new(),
            pull: vec![0.0; columns],
            defocus: Vec::new(),
            albedo: vec![0.0; columns],
            pieces: Vec::new(),
            beside: beside::Room::default(),
            shine: shine::Room::default(),
        }
    }
}

impl RowMaker {
    /// For a conveyor that throws back `conveyor_reflectance` of the light, all of it at the surface, below bodies that
    /// rise to `top` [mm] and have places that `shine`, and a sensor of `columns` columns.
    pub fn new(conveyor_reflectance: f64, camera: &Camera, shine: Shine, columns: usize, top: f64) -> Self {
        let along = |column: usize| camera.rig.along(column as f64, 0.0) as f32;
        Self {
            columns: camera.rig.sightlines(columns, top),
            conveyor_sights: (0..columns).map(|column| camera.sight(along(column), 0.0, 0.0)).collect(),
            shine,
            shares: WidthShares::new(),
            conveyor: Medium::opaque(Gloss::NONE),
            conveyor_reflectance: conveyor_reflectance as f32,
        }
    }

    /// What each column sees with the laser at scan position `y` [mm]; fills `hits`, `[columns]`.
    pub fn look(&self, specimen: &Specimen, y: f32, hits: &mut Vec<Hit>) {
        specimen.look(y, &self.columns, self.conveyor, hits);
    }

    /// The row of what `watch` looks at.
    pub fn make(&self, watch: Watch<'_>, scratch: &mut RowScratch, row: &mut Row) {
        let Watch { specimen, camera, y, .. } = watch;
        let columns = scratch.electrons.len();
        self.look(specimen, y, &mut row.hits);
        row.faced = None;
        let padded = columns.next_multiple_of(TILE);
        for field in [&mut row.centre, &mut row.rows_per_mm, &mut row.variance, &mut row.glare, &mut row.power] {
            field.resize(padded, 0.0);
        }
        let section = camera.laser.line_profile();
        let own = if section.is_some() { padded } else { 0 };
        row.unit.resize(own, 0.0);
        row.node.resize(own, 0.0);
        let relief = specimen.has_relief();
        if relief {
            row.beside.get_or_insert_default();
            scratch.beside.second.clear(columns);
        } else {
            row.beside = None;
        }
        scratch.defocus.resize(if camera.blurs() { columns } else { 0 }, 0.0);
        row.disc.resize(if camera.blurs() { columns.next_multiple_of(TILE) } else { 0 }, 0.0);
        let (mut first, mut last) = (columns, 0);
        for (column, hit) in row.hits.iter().enumerate() {
            let bare = hit.matter.class == Class::Background;
            let sight = if bare {
                watch.share(self.conveyor_sights[column], hit.x, 0.0)
            } else {
                watch.sight(hit.x, &hit.surface)
            };
            row.centre[column] = sight.row;
            row.rows_per_mm[column] = sight.rows_per_mm;
            row.variance[column] = sight.variance;
            if section.is_some() {
                row.unit[column] = sight.unit;
                row.node[column] = camera.laser.node(hit.x, hit.surface.z);
            }
            if let Some(defocus) = scratch.defocus.get_mut(column) {
                *defocus = sight.defocus;
                row.disc[column] = sight.disc;
            }
            let reach = if hit.lit && hit.seen { sight.electrons } else { 0.0 };
            if bare {
                row.glare[column] = reach * sight.view.z * self.conveyor_reflectance;
                (scratch.electrons[column], row.power[column]) = (0.0, 0.0);
                scratch.texels[column] = SurfacePoint::BLACK;
                scratch.albedo[column] = self.conveyor_reflectance;
                continue;
            }
            let normal = Vec3::new(-hit.surface.slope_x, -hit.surface.slope_y, 1.0).normalize();
            let facing = normal.dot(sight.view).max(0.0);
            // Lambert's share towards the lens; what follows multiplies it by radiance factors.
            let white = facing * reach;
            scratch.electrons[column] = white;
            let medium = &hit.matter.medium;
            (first, last) = (first.min(column), column + 1);
            row.glare[column] = white * fresnel::gloss(&medium.gloss, normal, -sight.light, sight.view);
            scratch.albedo[column] = medium.gloss.matte + medium.gloss.share * medium.gloss.reflectance;
            if let Some(under) = &hit.matter.film {
                let spread = film::spread(&hit.matter, under, normal, &sight, &mut scratch.beside.covers);
                for j in 0..BASIS {
                    scratch.spread.enter[j][column] = spread.enter[j];
                    scratch.spread.exit[j][column] = spread.exit[j];
                    scratch.spread.shift[j][column] = 0.0;
                }
                row.power[column] = white * film::enters(medium.n_eff, normal, -sight.light);
                scratch.pull[column] = film::pull(medium, under, sight.view);
                scratch.albedo[column] += spread.through.iter().sum::<f32>();
                scratch.beside.second.note(column, hit, under, &spread.through, &watch);
                continue;
            }
            let texel = texel(medium, normal, sight.view);
            row.power[column] = white * texel.enter;
            scratch.pull[column] = exit_shift(&texel);
            // A coat is passed both ways.
            scratch.texels[column] = SurfacePoint { enter: texel.enter * medium.coat * medium.coat, ..texel };
        }
        for j in 0..BASIS {
            for field in [&mut row.source[j], &mut row.exit[j], &mut row.shift[j]] {
                field.resize(columns.next_multiple_of(TILE), 0.0);
                field[..first.min(last)].fill(0.0);
                field[last..].fill(0.0);
            }
        }
        if first < last {
            self.spread(first..last, camera, relief, scratch, row);
        }
        self.shine.add(watch, row, &mut scratch.shine);
        // What the lens blurs along a line is even anyway.
        if camera.laser.is_point() {
            blur(&mut row.glare[..columns], camera.blur_variance, 1.0, &mut scratch.line);
        }
        if camera.blurs() {
            pieces(&row.hits, 0, relief, &mut scratch.pieces);
            for piece in &scratch.pieces {
                let (glare, own) = (&mut row.glare[piece.clone()], &scratch.defocus[piece.clone()]);
                blur_unlike(glare, 0.0, own, 1.0, &mut scratch.line);
            }
        }
        lamps::row(first..last, camera, &scratch.spread, &mut scratch.albedo, row);
        if let Some(mut beside) = row.beside.take() {
            let lit = Lit { watch, hits: &row.hits, spread: &scratch.spread };
            beside.make(&lit, row, &mut scratch.beside);
            row.beside = Some(beside);
        }
    }

    /// Lets the light of the columns `own` spread, along the motion and along the line.
    fn spread(&self, own: Range<usize>, camera: &Camera, relief: bool, scratch: &mut RowScratch, row: &mut Row) {
        let (first, last) = (own.start, own.end);
        let mut start = first;
        for part in row.hits[own].chunk_by(|a, b| a.matter.film.is_some() == b.matter.film.is_some()) {
            if part[0].matter.film.is_none() {
                line_spread(&scratch.texels[start..start + part.len()], start, &self.shares, &mut scratch.spread);
            }
            start += part.len();
        }
        pieces(&row.hits[first..last], first, relief, &mut scratch.pieces);
        let sideways = if relief { 1.0 } else { SPREAD_ACROSS_OVER_ALONG };
        for j in 0..BASIS {
            for column in first..last {
                // Beside the body's own columns (a gap seen through it, say) and out of sight nothing leaves.
                let hit = &row.hits[column];
                let inside = if hit.matter.class == Class::Background || !hit.seen { 0.0 } else { 1.0 };
                row.exit[j][column] = scratch.spread.exit[j][column] * inside;
                row.source[j][column] = scratch.spread.enter[j][column] * scratch.electrons[column] * inside;
                let shift = scratch.spread.shift[j][column] + scratch.pull[column];
                row.shift[j][column] = -shift * row.rows_per_mm[column];
            }
            let variance = camera.along_variance(SPREAD_MM[j] * sideways);
            let side = if SPREAD_MM[j] > 0.0 { SIDE } else { 1.0 };
            for piece in &scratch.pieces {
                let own = scratch.defocus.get(piece.clone()).unwrap_or_default();
                blur_unlike(&mut row.source[j][piece.clone()], variance, own, side, &mut scratch.line);
            }
        }
    }
}
