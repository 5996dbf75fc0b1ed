//! Scan line: the light of one position of the scan.
//!
//! Takes a specimen under camera and laser at one position ([`LineView`]); gives what each column sends to the lens and
//! what it lets out of its neighbours' light ([`crate::optics::light::ScanLine`]). Of sensor rows, of other lines and
//! of numbers nothing is known here.
//!
//! [`LineMaker`] goes in steps: what each column sees ([`crate::specimen`]); the sight of it, with laser and lens; how
//! much light its matter throws back and takes in. How light that entered spreads, by the kernel along the motion and
//! by a blur along the line; and the extras: highlights, blur out of focus, ambient light, secondary light.
//!
//! A body that reaches beyond the sensor's columns is lit there too: it is taken to go on as in a mirror at the first
//! or last column, so that as much light comes in as leaves.

mod along_line;
mod bent_film;
mod edge_search;
mod ends;
mod film;
mod front_face;
mod highlights;
mod patches;
mod pockets;
mod reflections;
mod response;
mod secondary_light;
mod spans;
mod surface_point;
mod view;

use std::ops::Range;

use base::{Film, Gloss, Medium, Surface};
use glam::{Vec2, Vec3};
use multiversion::multiversion;

use self::along_line::AlongLine;
use self::bent_film::upright;
use self::edge_search::EdgeSearch;
use self::highlights::HighlightScratch;
use self::pockets::{PocketColumn, leave_to_cavity};
use self::reflections::in_foil;
use self::response::{KEY_STEP, Response, key_lines};
use self::secondary_light::SecondaryScratch;
use self::spans::spans;
use self::view::LitLine;
use crate::frame::Sightlines;
use crate::optics::camera::{Camera, PIXEL_VARIANCE, Sight};
use crate::optics::lamps::Lamps;
use crate::optics::light::{FAR, ScanLine, WIDE, blur, blur_varying, greatest, load};
use crate::optics::speckle::TILE;
use crate::optics::speckle::coherence::{CONTRAST_COLUMNS, CONTRAST_PLACES, CONTRAST_ROWS, Coherence};
use crate::specimen::{Hit, Specimen};
use transport::fresnel;
use transport::kernel::{
    BASIS, PACK_SPREAD_MM, SPREAD_MM, SpreadRow, SurfacePoint, WidthShares, line_spread, path_laws,
};
use transport::line::LEAST_FACING;

pub(crate) use self::highlights::Highlights;
pub(crate) use self::pockets::spread_in_cavities;
pub(crate) use self::surface_point::surface_point;
pub(crate) use self::view::LineView;

/// Makes lines; holds what is worked out once.
#[derive(Debug)]
pub(crate) struct LineMaker {
    /// Of bodies of one surface, and of packs.
    shares: [WidthShares; 2],
    conveyor: Medium,
    conveyor_reflectance: f32,
    /// Where each column looks.
    columns: Sightlines,
    /// How the camera sees the bare conveyor in each column.
    conveyor_sights: Vec<Sight>,
    highlights: Highlights,
    coherence: Coherence,
    /// Lamps beside the laser.
    lamps: Option<Lamps>,
    /// Whether lines between key lines may be interpolated.
    pub(crate) interpolates: bool,
}

/// Buffers that one thread needs to make lines.
#[derive(Debug, Default)]
pub(crate) struct LineScratch {
    /// Of the line that is being made.
    response: Response,
    /// Of the last two key lines.
    keys: [Response; 2],
    /// Scan line for a key line that is not asked for.
    spare: ScanLine,
    /// Columns whose light is worked out, where it is not linear between key lines.
    exact: Vec<u32>,
    /// Light of each column towards the lens from a white Lambertian surface [e-].
    white: Vec<f32>,
    /// The same of light that fills pockets: wherever it came in, a level surface shows it [e-].
    filling: Vec<f32>,
    /// 1 in the body's columns that the lens sees, 0 in others.
    seen: Vec<f32>,
    /// Light of the body's columns that enters by the first width, by other near ones, and by those that fill pockets
    /// [e-].
    light: [Vec<f32>; 3],
    /// Buffer for blurring along the line.
    buffer: Vec<f32>,
    /// Variance along the line of what is out of focus; empty where nothing can be [px^2].
    defocus: Vec<f32>,
    /// Stretches of columns along which the surface's light is blurred without a break.
    spans: Vec<Range<usize>>,
    along: AlongLine,
    /// Diffuse reflectance for light from all sides [1].
    albedo: Vec<f32>,
    edges: EdgeSearch,
    secondary: SecondaryScratch,
    highlights: HighlightScratch,
}

impl LineScratch {
    /// Buffers for `columns` columns.
    pub fn new(columns: usize) -> Self {
        Self {
            response: Response::new(columns),
            keys: std::array::from_fn(|_| Response::new(columns)),
            white: vec![0.0; columns],
            filling: vec![0.0; columns],
            along: AlongLine::new(columns),
            albedo: vec![0.0; columns],
            ..Self::default()
        }
    }

    /// Whether key line `profile` is here.
    fn holds(&self, profile: isize) -> bool {
        self.keys.iter().any(|key| key.profile == Some(profile))
    }

    /// Keeps the line made last as a key line, and the other one of `needed`.
    fn keep(&mut self, needed: [isize; 2]) {
        let free = self.keys.iter().position(|key| key.profile.is_none_or(|profile| !needed.contains(&profile)));
        std::mem::swap(&mut self.response, &mut self.keys[free.unwrap_or(0)]);
    }

    /// Takes over what is linear between key lines among the columns `own`, and finds those where it is not: all others
    /// without film.
    fn interpolate(&mut self, own: Range<usize>, hits: &[Hit]) {
        let Self { response, keys, exact, .. } = self;
        match keys_about(keys, response.profile) {
            Some(keys) => response.interpolate(keys, own, exact),
            None => {
                exact.clear();
                exact.extend(own.filter(|&column| hits[column].matter.film.is_none()).map(|column| column as u32));
            }
        }
    }
}

/// The key lines before and after a line that is none; `None` where either is missing.
fn keys_about(keys: &[Response; 2], profile: Option<isize>) -> Option<[&Response; 2]> {
    let about = key_lines(profile?);
    let of = |profile: isize| keys.iter().find(|key| key.profile == Some(profile));
    if about[0] == about[1] { None } else { Some([of(about[0])?, of(about[1])?]) }
}

impl LineMaker {
    /// For a conveyor that throws back `conveyor_reflectance` of the light, all of it at the surface, below bodies that
    /// rise to `top` [mm] and have `highlights`, and a sensor of `columns` columns.
    pub fn new(
        conveyor_reflectance: f64,
        camera: &Camera,
        highlights: Highlights,
        coherence: Coherence,
        lamps: Option<Lamps>,
        columns: usize,
        top: f64,
    ) -> Self {
        let along = |column: usize| camera.rig.along(column as f64, 0.0) as f32;
        Self {
            columns: camera.rig.sightlines(columns, top),
            conveyor_sights: (0..columns).map(|column| camera.sight(along(column), 0.0, 0.0)).collect(),
            highlights,
            coherence,
            lamps,
            interpolates: true,
            shares: [SPREAD_MM, PACK_SPREAD_MM].map(WidthShares::new),
            conveyor: Medium::opaque(Gloss::NONE),
            conveyor_reflectance: conveyor_reflectance as f32,
        }
    }

    /// What each column sees with the laser at scan position `y` [mm]; fills `hits`, `[columns]`.
    pub fn look(&self, specimen: &Specimen, y: f32, hits: &mut Vec<Hit>) {
        specimen.look(y, &self.columns, self.conveyor, hits);
    }

    /// Makes `lines`, the first of which is line `first` of the scan; `view` looks at a line. What enters cavities is
    /// still to spread ([`spread_in_cavities`]).
    pub fn make_all<'a>(
        &self,
        first: isize,
        lines: &mut [ScanLine],
        view: impl Fn(isize) -> LineView<'a>,
        scratch: &mut LineScratch,
    ) {
        let mut last_key = isize::MIN;
        for place in 0..lines.len() {
            let profile = first + place as isize;
            let keys = key_lines(profile);
            // Light below film is closed form.
            let keyed = self.interpolates && !view(profile).specimen.can_mirror_itself();
            for key in keys.into_iter().filter(|&key| keyed && key != profile) {
                if scratch.holds(key) {
                    continue;
                }
                let mut spare = std::mem::take(&mut scratch.spare);
                let within = usize::try_from(key - first).ok().and_then(|place| lines.get_mut(place));
                last_key = if within.is_some() { key } else { last_key };
                self.make(view(key), scratch, within.unwrap_or(&mut spare));
                scratch.spare = spare;
                scratch.keep(keys);
            }
            if profile > last_key || keys[0] < profile {
                self.make(view(profile), scratch, &mut lines[place]);
                if keyed && keys[0] == profile {
                    scratch.keep([profile, profile + KEY_STEP]);
                }
            }
        }
    }

    /// Makes the line of what `view` looks at.
    pub(crate) fn make(&self, view: LineView<'_>, scratch: &mut LineScratch, line: &mut ScanLine) {
        self.look(view.specimen, view.y, &mut line.hits);
        line.y_mm = view.y;
        let top = line.hits.iter().map(|hit| hit.surface.z).fold(0.0, f32::max);
        line.level_rows_per_mm = view.camera.sight(0.0, top, 0.0).rows_per_mm;
        line.moved_px = view.moved_px(top);
        line.bare.clear();
        line.bare.extend(line.hits.iter().map(Hit::is_bare));
        scratch.edges.find(view.specimen, view.y, &self.columns, self.conveyor, &line.hits, &mut line.mixed);
        line.spread_mm = self.shares(view.specimen).spread_mm;
        prepare(view, scratch, line);
        let own = self.light(view, scratch, line);
        let middle = ends::cut(view, own.clone(), scratch, line);
        darken_outside(&own, scratch.white.len(), line);
        scratch.interpolate(own.clone(), &line.hits);
        self.contrasts(view, scratch, line);
        if !own.is_empty() {
            self.spread(own.clone(), view, scratch, line);
            if middle != 0.0 {
                ends::displace(middle, own.clone(), line);
            }
        }
        self.add_extras(view, own, scratch, line);
        if let Some(lamps) = &self.lamps {
            lamps.light(&line.hits, &scratch.response.spread.diffuse, self.conveyor_reflectance, &mut line.lamps);
        }
        find_greatest_exits(line);
    }

    /// Shares of the widths that light of `specimen` spreads by.
    fn shares(&self, specimen: &Specimen) -> &WidthShares {
        &self.shares[usize::from(specimen.can_mirror_itself())]
    }

    /// Sight and matter of all columns; the columns from the body's first to its last, 0..0 where there is none.
    fn light(&self, view: LineView<'_>, scratch: &mut LineScratch, line: &mut ScanLine) -> Range<usize> {
        let hits = std::mem::take(&mut line.hits);
        let (mut first, mut last) = (hits.len(), 0);
        for (column, hit) in hits.iter().enumerate() {
            // Pockets are bent alike all around.
            let on_card = hit.matter.film.is_some_and(|film| film.gap_mm.is_none());
            let about = if on_card { view.specimen.slope_about(hit, view.y) } else { None };
            let sight = self.sight(column, (hit, about), view, scratch, line);
            // Electrons of a white Lambertian surface, before its slope.
            let reach = if hit.lit && hit.seen { sight.electrons } else { 0.0 };
            if hit.is_bare() {
                self.conveyor(column, reach * sight.view.z, scratch, line);
                continue;
            }
            (first, last) = (first.min(column), column + 1);
            let normal = upright(Vec2::new(hit.surface.slope_x, hit.surface.slope_y));
            let facing = normal.dot(sight.view).max(0.0);
            let arrives = if hit.lit { sight.electrons } else { 0.0 };
            let about = about.map(upright);
            let lit = LitColumn { column, hit, sight, normal, about, white: facing * reach, arrives };
            lit.reflect(scratch, line);
            match &hit.matter.film {
                Some(film) => lit.enter_film(film, view, scratch, line),
                None => lit.enter(scratch, line),
            }
        }
        line.hits = hits;
        first.min(last)..last
    }

    /// Where and how sharp laser and lens draw the line in a column.
    #[inline]
    fn sight(
        &self,
        column: usize,
        (hit, about): (&Hit, Option<Vec2>),
        view: LineView<'_>,
        scratch: &mut LineScratch,
        line: &mut ScanLine,
    ) -> Sight {
        let sight = if hit.is_bare() && view.unrest.is_none_or(|unrest| unrest.lift_mm == 0.0) {
            view.share(self.conveyor_sights[column], hit.x, 0.0)
        } else {
            view.sight(hit.x, &hit.surface)
        };
        line.centre[column] = sight.row;
        line.rows_per_mm[column] = sight.rows_per_mm;
        let (steep, rows_per_mm) = match (&hit.matter.film, about) {
            (None, _) => (0.0, sight.rows_per_mm),
            (_, None) => (hit.surface.slope_y, sight.rows_per_mm),
            (_, Some(Vec2 { x, y })) => {
                (y, view.sight(hit.x, &Surface { slope_x: x, slope_y: y, ..hit.surface }).rows_per_mm)
            }
        };
        line.spread_rows_per_mm[column] = rows_per_mm / (1.0 + steep * steep).sqrt();
        line.variance[column] = sight.variance;
        if let Some(unit) = line.profile_unit.get_mut(column) {
            *unit = sight.unit;
            line.profile_node[column] = view.camera.laser.profile_node(hit.x, hit.surface.z);
        }
        if let Some(defocus) = scratch.defocus.get_mut(column) {
            *defocus = sight.defocus;
            line.defocus_radius[column] = sight.disc;
        }
        sight
    }

    /// Light of the bare conveyor in a column where a white one would send `white`.
    #[inline]
    fn conveyor(&self, column: usize, white: f32, scratch: &mut LineScratch, line: &mut ScanLine) {
        line.surface_light[column] = white * self.conveyor_reflectance;
        (scratch.white[column], scratch.filling[column], line.entered_light[column]) = (0.0, 0.0, 0.0);
        scratch.response.points[column] = SurfacePoint::BLACK;
        scratch.albedo[column] = self.conveyor_reflectance;
    }

    /// How much speckle is left beside the line, by the paths of the light there.
    fn contrasts(&self, view: LineView<'_>, scratch: &mut LineScratch, line: &mut ScanLine) {
        let padded = line.centre.len();
        let LineScratch { response, keys, exact, secondary, .. } = scratch;
        let keys = keys_about(keys, response.profile);
        line.contrasts.clear();
        for first in (0..padded).step_by(CONTRAST_COLUMNS) {
            let columns = first..(first + CONTRAST_COLUMNS).min(line.hits.len());
            let between = |column| keys.and_then(|keys| response.contrasts_between(keys, column, exact));
            let contrasts = match columns.into_iter().find(|&column| !line.bare[column]) {
                None => [[1.0; CONTRAST_ROWS.len()]; 2],
                Some(column) => between(column).unwrap_or_else(|| {
                    let (point, rows_per_mm) = (&response.points[column], line.rows_per_mm[column].abs().max(1e-3));
                    let blur = (line.variance[column] - PIXEL_VARIANCE) / (rows_per_mm * rows_per_mm);
                    let away = CONTRAST_PLACES.map(|rows| rows / rows_per_mm);
                    let Hit { x, surface, matter, .. } = &line.hits[column];
                    let laws = match matter.film.as_ref() {
                        Some(film) => {
                            let sight = view.sight(*x, surface);
                            let stack =
                                film::stack(matter, film, upright(Vec2::new(surface.slope_x, surface.slope_y)), &sight);
                            // Films are alike in all directions.
                            let laws = secondary.paths.laws(&stack, blur, CONTRAST_ROWS.map(|rows| rows / rows_per_mm));
                            std::array::from_fn(|place| {
                                laws[if place < laws.len() { place } else { place + 1 - laws.len() }]
                            })
                        }
                        None => path_laws(point, blur, away),
                    };
                    self.coherence.relative(&laws, point.n)
                }),
            };
            line.contrasts.push(contrasts);
        }
        response.contrasts.clone_from(&line.contrasts);
    }

    /// Lets the light of the columns `own` spread, along the motion and along the line.
    fn spread(&self, own: Range<usize>, view: LineView<'_>, scratch: &mut LineScratch, line: &mut ScanLine) {
        let relief = view.specimen.can_mirror_itself();
        let LineScratch { response: Response { points, spread, .. }, exact, along, seen, light, defocus, .. } = scratch;
        let absorbed = self.lamps.as_ref().map(|lamps| lamps.absorption);
        line_spread(points, exact, self.shares(view.specimen), absorbed, spread);
        along.find(&line.hits, own.clone(), relief);
        let (white, filling) = (&scratch.white[own.clone()], &scratch.filling[own.clone()]);
        // Beside the body's own columns (a gap seen through it, say) and out of sight nothing leaves.
        let is_seen = line.hits[own.clone()].iter().zip(&line.bare[own.clone()]).map(|(hit, bare)| hit.seen && !bare);
        seen.clear();
        seen.extend(is_seen.map(|seen| if seen { 1.0 } else { 0.0 }));
        let [near, creeps, fills] = light;
        near.clear();
        near.extend(white.iter().zip(&*seen).map(|(white, seen)| white * seen));
        for (light, far) in [(&mut *creeps, false), (fills, true)] {
            light.clone_from(near);
            // Light that fills a pocket comes in by walls that look away, too, and what creeps through film may come
            // into sight.
            let hidden = line.hidden.get(own.clone()).unwrap_or_default();
            for (column, hidden) in hidden.iter().enumerate() {
                if *hidden || (far && !line.bare[own.start + column]) {
                    light[column] = filling[column];
                }
            }
        }
        let rows_per_mm = &line.rows_per_mm[own.clone()];
        for j in 0..BASIS {
            let light = match j {
                0 => &*near,
                _ if j < FAR => &*creeps,
                _ => &*fills,
            };
            let (exit, enter) = (&spread.exit[j][own.clone()], &spread.enter[j][own.clone()]);
            for (out, (exit, seen)) in line.exit[j][own.clone()].iter_mut().zip(exit.iter().zip(&*seen)) {
                *out = exit * seen;
            }
            for (out, (enter, light)) in line.source[j][own.clone()].iter_mut().zip(enter.iter().zip(light)) {
                *out = enter * light;
            }
            let shift = spread.shift[j][own.clone()].iter().zip(rows_per_mm);
            for (out, (shift, rows_per_mm)) in line.shift[j][own.clone()].iter_mut().zip(shift) {
                *out = -shift * rows_per_mm;
            }
            along.blur(&mut line.source[j], line.spread_mm[j], &line.hits, defocus, view.camera);
        }
    }

    /// What comes on top of the line and its spread: highlights, blur along the line, ambient light, secondary light.
    fn add_extras(&self, view: LineView<'_>, own: Range<usize>, scratch: &mut LineScratch, line: &mut ScanLine) {
        let camera = view.camera;
        self.highlights.add(view, line, &mut scratch.highlights);
        // What the lens blurs along a line is even anyway.
        if camera.laser.is_point() {
            let columns = line.hits.len();
            blur(&mut line.surface_light[..columns], camera.blur_variance, [1.0; 2], &mut scratch.buffer);
        }
        if camera.blurs() {
            spans(&line.hits, 0, view.specimen.can_mirror_itself(), &mut scratch.spans);
            for span in &scratch.spans {
                let (light, own) = (&mut line.surface_light[span.clone()], &scratch.defocus[span.clone()]);
                blur_varying(light, 0.0, own, [1.0; 2], &mut scratch.buffer);
            }
        }
        ambient(own, camera, &scratch.response.spread, &mut scratch.albedo, line);
        if let Some(mut secondary) = line.secondary.take() {
            let lit = LitLine { view, hits: &line.hits, spread: &scratch.response.spread };
            secondary.make(&lit, line, &mut scratch.secondary);
            line.secondary = Some(secondary);
        }
    }
}

/// Fills the ambient light of `line`, whose body stands in the columns `own`; `albedo` holds what surfaces throw back.
fn ambient(own: Range<usize>, camera: &Camera, spread: &SpreadRow, albedo: &mut [f32], line: &mut ScanLine) {
    line.ambient.clear();
    if !camera.has_ambient() {
        return;
    }
    for column in own.filter(|&column| !line.bare[column]) {
        albedo[column] += (0..BASIS).map(|j| spread.enter[j][column] * spread.exit[j][column]).sum::<f32>();
    }
    let light = |(hit, albedo): (&Hit, &f32)| albedo * camera.ambient(hit.x, hit.surface.z);
    line.ambient.extend(line.hits.iter().zip(&*albedo).map(light));
    line.ambient.resize(line.centre.len(), 0.0);
}

/// Finds the greatest exit of each width in each tile of a line.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn find_greatest_exits(line: &mut ScanLine) {
    let ScanLine { exit, greatest_exits, centre, .. } = line;
    greatest_exits.clear();
    let tiles = (0..centre.len()).step_by(TILE);
    greatest_exits.extend(tiles.map(|start| exit.each_ref().map(|exit| greatest(load(exit, start)))));
}

/// Gives a line and its buffers their lengths, and takes away what another line has left.
fn prepare(view: LineView<'_>, scratch: &mut LineScratch, line: &mut ScanLine) {
    let LineView { specimen, camera, .. } = view;
    let columns = scratch.white.len();
    let padded = columns.next_multiple_of(TILE);
    for field in [
        &mut line.centre,
        &mut line.rows_per_mm,
        &mut line.spread_rows_per_mm,
        &mut line.variance,
        &mut line.surface_light,
        &mut line.entered_light,
    ] {
        field.resize(padded, 0.0);
    }
    let profiled = if camera.laser.line_profile().is_some() { padded } else { 0 };
    line.profile_unit.resize(profiled, 0.0);
    line.profile_node.resize(profiled, 0.0);
    if specimen.can_mirror_itself() {
        line.secondary.get_or_insert_default();
        line.hidden.clear();
        line.hidden.resize(padded, false);
        line.rooms.clear();
        line.rooms.extend(line.hits.iter().map(|hit| hit.matter.film.is_some_and(|film| film.is_over_room())));
        line.rooms.resize(padded, false);
        scratch.secondary.pockets.clear();
        scratch.secondary.pockets.resize(columns, PocketColumn::default());
        scratch.secondary.transmission.clear(columns);
        scratch.secondary.reflections.clear(columns);
    } else {
        line.secondary = None;
        line.hidden.clear();
        line.rooms.clear();
    }
    (scratch.response.profile, scratch.response.y_mm) = (Some(view.profile), view.y);
    scratch.defocus.resize(if camera.blurs() { columns } else { 0 }, 0.0);
    line.defocus_radius.resize(if camera.blurs() { padded } else { 0 }, 0.0);
}

/// Leaves no spread light outside of the columns `own` of a line of `columns` columns.
fn darken_outside(own: &Range<usize>, columns: usize, line: &mut ScanLine) {
    for j in 0..BASIS {
        for field in [&mut line.source[j], &mut line.exit[j], &mut line.shift[j]] {
            field.resize(columns.next_multiple_of(TILE), 0.0);
            field[..own.start].fill(0.0);
            field[own.end..].fill(0.0);
        }
    }
}

/// A column that sees the body.
#[derive(Debug, Clone, Copy)]
struct LitColumn<'a> {
    column: usize,
    hit: &'a Hit,
    sight: Sight,
    /// Unit normal of the surface.
    normal: Vec3,
    /// The same of the surface around it, where it is a facet: wide light leaves through that.
    about: Option<Vec3>,
    /// Light towards the lens from a white Lambertian surface; what follows multiplies it by radiance factors [e-].
    white: f32,
    /// The laser's light there, seen or not, as a white Lambertian surface that faces the lens would show it [e-].
    arrives: f32,
}

impl LitColumn<'_> {
    /// Light that the surface itself throws back.
    #[inline]
    fn reflect(&self, scratch: &mut LineScratch, line: &mut ScanLine) {
        let Self { column, sight, normal, white, arrives, .. } = *self;
        let gloss = &self.hit.matter.medium.gloss;
        scratch.white[column] = white;
        scratch.filling[column] = arrives * sight.view.z;
        line.surface_light[column] = white * fresnel::gloss(gloss, normal, -sight.light, sight.view);
        scratch.albedo[column] = gloss.matte + gloss.share * gloss.reflectance;
    }

    /// Light that enters a film over something else.
    #[inline]
    fn enter_film(&self, film: &Film, view: LineView<'_>, scratch: &mut LineScratch, line: &mut ScanLine) {
        let Self { column, hit, sight, normal, about, arrives, .. } = *self;
        let medium = &hit.matter.medium;
        // Its paths decide the contrast of speckle.
        scratch.response.points[column] = surface_point(medium, normal, sight.light, sight.view);
        let mut spread = film::spread(&hit.matter, film, normal, &sight, &mut scratch.secondary.films);
        if let Some(about) = about {
            let wide = film::spread(&hit.matter, film, about, &sight, &mut scratch.secondary.films);
            let facing = about.dot(sight.view).max(LEAST_FACING) / normal.dot(sight.view).max(LEAST_FACING);
            for j in WIDE..BASIS {
                (spread.enter[j], spread.exit[j]) = (wide.enter[j], wide.exit[j] * facing);
            }
        }
        scratch.along.note(column, spread.holds);
        line.hidden[column] = hit.lit && !hit.seen;
        let enters = film::entering_share(medium.n_eff, normal, -sight.light);
        if film.is_over_room() {
            scratch.secondary.pockets[column] = PocketColumn::of(hit, normal, &sight, &spread, [arrives, enters]);
            leave_to_cavity(&mut spread);
        }
        for j in 0..BASIS {
            scratch.response.spread.enter[j][column] = spread.enter[j];
            scratch.response.spread.exit[j][column] = spread.exit[j];
            scratch.response.spread.shift[j][column] = spread.film_beside[j];
        }
        // What enters where the lens does not see it comes out elsewhere.
        let facing = normal.dot(sight.view).max(LEAST_FACING);
        line.entered_light[column] = arrives * facing * enters;
        scratch.albedo[column] += spread.passes * spread.below.iter().sum::<f32>();
        scratch.secondary.transmission.note(column, (hit, &sight), film, &spread, &view);
        scratch.secondary.reflections.in_foil[column] = in_foil(hit, film, &spread, (normal, sight.view), &view);
    }

    /// Light that enters a body of one medium.
    #[inline]
    fn enter(&self, scratch: &mut LineScratch, line: &mut ScanLine) {
        let Self { column, sight, normal, white, .. } = *self;
        let medium = &self.hit.matter.medium;
        let point = surface_point(medium, normal, sight.light, sight.view);
        line.entered_light[column] = white * point.enter;
        // A coat is passed both ways.
        scratch.response.points[column] = SurfacePoint { enter: point.enter * medium.coat * medium.coat, ..point };
    }
}
