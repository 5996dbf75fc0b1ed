//! One row of the specimen in the words of the camera: what each column sends out when the laser stands on it, and what
//! it lets out of its neighbours' light.
//!
//! The light's answer at a point belongs to the object: it is worked out once for each position of the scan and used by
//! every profile whose window holds it.

use std::ops::Range;

use glam::Vec3;
use procedural::{Class, Gloss, Medium};

use super::ambient;
use super::box_filter::{blur, blur_varying};
use super::camera::{Camera, Sight};
use super::film;
use super::highlights::{HighlightScratch, Highlights};
use super::reflections::LitRow;
use super::row::Row;
use super::row_view::RowView;
use super::secondary_light::SecondaryScratch;
use super::spans::spans;
use super::speckle::TILE;
use super::surface_point::surface_point;
use crate::frame::Sightlines;
use crate::specimen::{Hit, Specimen};
use crate::transport::fresnel;
use crate::transport::kernel::{
    BASIS, SPREAD_ACROSS_OVER_ALONG, SPREAD_MM, SpreadRow, SurfacePoint, WidthShares, exit_shift, line_spread,
};

/// What comes back of light that would cross a wall, which lets it out: less than nothing, since the wall takes of what
/// stands near it too; from the judge's scatter beside a crack and at the side of a board [1].
const WALL_RETURN: f32 = -0.5;

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
    highlights: Highlights,
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
    secondary: SecondaryScratch,
    highlights: HighlightScratch,
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
            secondary: SecondaryScratch::default(),
            highlights: HighlightScratch::default(),
        }
    }
}

impl RowMaker {
    /// For a conveyor that throws back `conveyor_reflectance` of the light, all of it at the surface, below bodies that
    /// rise to `top` [mm] and have `highlights`, and a sensor of `columns` columns.
    pub fn new(conveyor_reflectance: f64, camera: &Camera, highlights: Highlights, columns: usize, top: f64) -> Self {
        let along = |column: usize| camera.rig.along(column as f64, 0.0) as f32;
        Self {
            columns: camera.rig.sightlines(columns, top),
            conveyor_sights: (0..columns).map(|column| camera.sight(along(column), 0.0, 0.0)).collect(),
            highlights,
            shares: WidthShares::new(),
            conveyor: Medium::opaque(Gloss::NONE),
            conveyor_reflectance: conveyor_reflectance as f32,
        }
    }

    /// What each column sees with the laser at scan position `y` [mm]; fills `hits`, `[columns]`.
    pub fn look(&self, specimen: &Specimen, y: f32, hits: &mut Vec<Hit>) {
        specimen.look(y, &self.columns, self.conveyor, hits);
    }

    /// The row of what `view` looks at.
    pub fn make(&self, view: RowView<'_>, scratch: &mut RowScratch, row: &mut Row) {
        let RowView { specimen, camera, y, .. } = view;
        let columns = scratch.electrons.len();
        self.look(specimen, y, &mut row.hits);
        row.front_exit = None;
        let padded = columns.next_multiple_of(TILE);
        for field in
            [&mut row.centre, &mut row.rows_per_mm, &mut row.variance, &mut row.surface_light, &mut row.entered_light]
        {
            field.resize(padded, 0.0);
        }
        let section = camera.laser.line_profile();
        let own = if section.is_some() { padded } else { 0 };
        row.profile_unit.resize(own, 0.0);
        row.profile_node.resize(own, 0.0);
        let relief = specimen.can_occlude_itself();
        if relief {
            row.secondary.get_or_insert_default();
            scratch.secondary.transmission.clear(columns);
        } else {
            row.secondary = None;
        }
        scratch.defocus.resize(if camera.blurs() { columns } else { 0 }, 0.0);
        row.defocus_radius.resize(if camera.blurs() { columns.next_multiple_of(TILE) } else { 0 }, 0.0);
        let (mut first, mut last) = (columns, 0);
        for (column, hit) in row.hits.iter().enumerate() {
            let bare = hit.matter.class == Class::Background;
            let sight = if bare {
                view.share(self.conveyor_sights[column], hit.x, 0.0)
            } else {
                view.sight(hit.x, &hit.surface)
            };
            row.centre[column] = sight.row;
            row.rows_per_mm[column] = sight.rows_per_mm;
            row.variance[column] = sight.variance;
            if section.is_some() {
                row.profile_unit[column] = sight.unit;
                row.profile_node[column] = camera.laser.node(hit.x, hit.surface.z);
            }
            if let Some(defocus) = scratch.defocus.get_mut(column) {
                *defocus = sight.defocus;
                row.defocus_radius[column] = sight.disc;
            }
            let reach = if hit.lit && hit.seen { sight.electrons } else { 0.0 };
            if bare {
                row.surface_light[column] = reach * sight.view.z * self.conveyor_reflectance;
                (scratch.electrons[column], row.entered_light[column]) = (0.0, 0.0);
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
            row.surface_light[column] = white * fresnel::gloss(&medium.gloss, normal, -sight.light, sight.view);
            scratch.albedo[column] = medium.gloss.matte + medium.gloss.share * medium.gloss.reflectance;
            if let Some(under) = &hit.matter.film {
                let spread = film::spread(&hit.matter, under, normal, &sight, &mut scratch.secondary.covers);
                for j in 0..BASIS {
                    scratch.spread.enter[j][column] = spread.enter[j];
                    scratch.spread.exit[j][column] = spread.exit[j];
                    scratch.spread.shift[j][column] = 0.0;
                }
                row.entered_light[column] = white * film::entering_share(medium.n_eff, normal, -sight.light);
                scratch.pull[column] = film::exit_shift(medium, under, sight.view);
                scratch.albedo[column] += spread.through.iter().sum::<f32>();
                scratch.secondary.transmission.note(column, hit, under, &spread.through, &view);
                continue;
            }
            let texel = surface_point(medium, normal, sight.view);
            row.entered_light[column] = white * texel.enter;
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
        self.highlights.add(view, row, &mut scratch.highlights);
        // What the lens blurs along a line is even anyway.
        if camera.laser.is_point() {
            blur(&mut row.surface_light[..columns], camera.blur_variance, 1.0, &mut scratch.line);
        }
        if camera.blurs() {
            spans(&row.hits, 0, relief, &mut scratch.pieces);
            for piece in &scratch.pieces {
                let (glare, own) = (&mut row.surface_light[piece.clone()], &scratch.defocus[piece.clone()]);
                blur_varying(glare, 0.0, own, 1.0, &mut scratch.line);
            }
        }
        ambient::row(first..last, camera, &scratch.spread, &mut scratch.albedo, row);
        if let Some(mut secondary) = row.secondary.take() {
            let lit = LitRow { view, hits: &row.hits, spread: &scratch.spread };
            secondary.make(&lit, row, &mut scratch.secondary);
            row.secondary = Some(secondary);
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
        spans(&row.hits[first..last], first, relief, &mut scratch.pieces);
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
            let side = if SPREAD_MM[j] > 0.0 { WALL_RETURN } else { 1.0 };
            for piece in &scratch.pieces {
                let own = scratch.defocus.get(piece.clone()).unwrap_or_default();
                blur_varying(&mut row.source[j][piece.clone()], variance, own, side, &mut scratch.line);
            }
        }
    }
}
