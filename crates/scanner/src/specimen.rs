//! Specimen: a body prepared for visibility queries: which point each sensor column sees in the laser plane, and
//! whether laser and camera reach it.
//!
//! Boards and packs are height fields, whose upper surface is asked directly; their hull in the ray tracer serves for
//! shadows on the conveyor next to the body. A board with cracks, holes or wane and a blister pack occlude themselves:
//! their upper surface is sampled on a grid (`surface_grid`), which answers what its pockets hide from the lens and
//! where reflected light lands. Where its film is clear, the surface of tablets and foil below has a grid of its own.
//!
//! Saw-teeth and parts from files have the triangles of the hull as their surface, overhangs and holes included. In the
//! laser plane the points that a column can see lie on one line, straight but for distortion, from above the object
//! down to the conveyor. The first point from above counts that is lit (nothing stands between it and the fan's origin)
//! and seen (nothing stands between it and the lens), laser and lens being on the same side of the surface. Where there
//! is none, the first intersection is shown, dark.
//!
//! Neglected: light that a body reflects onto the conveyor; of pieces made of triangles the other lit points of a
//! column (behind the rim of a gap, say), facets steeper than 88.9 degrees, which count as that steep, and light that
//! the piece reflects onto itself.

pub(crate) mod cavity;
mod enclosure;
mod outline;
mod rays;
mod room;
pub(crate) mod surface_grid;
pub mod turntable;

use base::{BLOCK, Body, Class, Film, Matter, Medium, Relief, Slice, Surface};
use glam::{Vec2, Vec3};

use self::cavity::Pocket;
use self::outline::ConvexOutline;
use self::rays::{Intersection, LEAVE_MM, TriangleBvh};
use self::surface_grid::{Differences, SurfaceGrid};
use self::turntable::{BodyPose, Turntable};
use crate::frame::{Rig, Sightline, Sightlines};

/// Depth below the surface at which matter is looked up [mm]: light that leaves wood was turned and absorbed there, a
/// free path below its face. Of 0 to 0.4 mm this depth came nearest to the reference on whole boards **[C]**. Labels
/// and fibres are of that matter too; of packs and parts it is the same at any depth.
const MATTER_DEPTH_MM: f32 = 0.125;

/// What one sensor column sees at one position of the scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Along the laser line [mm].
    pub x: f32,
    /// The surface there.
    pub surface: Surface,
    /// What it is, just below the surface; the conveyor has class `Background`.
    pub matter: Matter,
    /// Whether the laser reaches it.
    pub lit: bool,
    /// Whether the camera reaches it.
    pub seen: bool,
}

impl Hit {
    /// Whether it is the conveyor.
    #[inline]
    pub fn is_bare(&self) -> bool {
        self.matter.class == Class::Background
    }
}

/// Where light reflected by a body lands on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ReflectedHit {
    /// The point [mm].
    pub point: Vec3,
    /// The surface there.
    pub surface: Surface,
    /// Whether the lens sees it.
    pub seen: bool,
}

/// A body prepared for visibility queries.
#[derive(Debug)]
pub struct Specimen {
    body: Body,
    triangles: TriangleBvh,
    outline: ConvexOutline,
    rig: Rig,
    /// Height of the point that the laser fan comes from [mm].
    fan_height: f32,
    /// The upper surface of a body that can occlude itself.
    upper: Option<SurfaceGrid>,
    /// The surface below its film, where the film is clear.
    lower: Option<SurfaceGrid>,
    /// Its pockets, where light in them is asked for.
    pub(crate) pockets: Vec<Pocket>,
    /// The turntable; `None` for a straight scan.
    turntable: Option<Turntable>,
}

/// Scattering depth of a film above which nothing is seen through it [1].
const OPAQUE_FILM_DEPTH: f32 = 4.0;
/// Height by which a surface may lie off a guess [mm]: a column then looks as good as there.
const GUESS_TOLERANCE_MM: f32 = 0.05;
/// Most steps of Newton's method towards the point that a column sees on a steep surface.
const MAX_NEWTON_STEPS: usize = 6;
/// Distance from the line of sight at which Newton's method ends [mm].
const NEWTON_TOLERANCE_MM: f32 = 0.002;
/// Least z of a surface normal: facets steeper than 88.9 degrees count as that steep, and so do overhangs [1].
const MIN_NORMAL_Z: f32 = 0.02;
/// Start of shadow rays above the surface that they leave [mm].
const SHADOW_RAY_START_MM: f32 = 0.002;
/// Step behind a surface from which the next one is searched [mm].
const NEXT_SURFACE_STEP_MM: f32 = 0.001;
/// Distance from its chord within which a line of sight counts as straight [mm].
const STRAIGHT_TOLERANCE_MM: f32 = 0.0005;
/// Height above and below within which a bent line of sight is replaced by its tangent [mm].
const BENT_SEARCH_MM: f32 = 0.5;
/// Distance from the laser plane at which columns look: a ray exactly along an edge between two triangles misses both,
/// and parts have edges at round coordinates [mm].
const PLANE_OFFSET_MM: f32 = 1e-4;
/// How far to either side of a facet the surface around it reaches [mm].
const ABOUT_MM: f32 = 0.6;
/// Least slope over that of the surface around it that makes a facet [1].
const FACET: f32 = 0.1;
/// Most surfaces, one behind the other, that a line of sight passes.
const MAX_SURFACES_PER_SIGHTLINE: usize = 64;

/// Height of the surface below a film whose upper side is `surface` [mm].
pub fn height_below(surface: &Surface, film: &Film) -> f32 {
    let upright = (1.0 + surface.slope_x * surface.slope_x + surface.slope_y * surface.slope_y).sqrt();
    surface.z - film.thickness_mm * upright - film.gap_mm.unwrap_or(0.0)
}

impl Specimen {
    /// Puts `body` under a camera and a laser fan from `fan_height` [mm].
    pub fn new(body: Body, rig: Rig, fan_height: f64) -> Self {
        let hull = body.hull();
        let (triangles, outline) = (TriangleBvh::new(&hull), ConvexOutline::around(&hull.positions));
        let (upper, lower) = surface_grids(&body, lens(&rig, 0.0));
        Self {
            body,
            triangles,
            outline,
            rig,
            fan_height: fan_height as f32,
            upper,
            lower,
            pockets: Vec::new(),
            turntable: None,
        }
    }

    /// The same with its pockets found, for the light that fills them, which the kernel asks for.
    pub fn with_pockets(self) -> Self {
        Self { pockets: cavity::find(&self.body), ..self }
    }

    /// The same without the light that fills its pockets.
    pub fn without_pockets(self) -> Self {
        Self { pockets: Vec::new(), ..self }
    }

    /// Whether it turns below the line.
    pub fn is_turned(&self) -> bool {
        self.turntable.is_some()
    }

    /// The same on a turntable, for a body without surface grids; scan positions are then the travel at its radius.
    pub fn on_turntable(self, turntable: Option<Turntable>) -> Self {
        Self { turntable, ..self }
    }

    /// The body.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Height of the body's highest point [mm].
    pub fn top(&self) -> f32 {
        self.triangles.high.z
    }

    /// Share of the body's convex outline, seen from above, that lies within a field [mm]; NaN on a turntable, where a
    /// place passes the line in more rows than one, and for a body without extent [1].
    pub fn share_within(&self, x: [f64; 2], y: [f64; 2]) -> f64 {
        if self.turntable.is_some() { f64::NAN } else { self.outline.share_within(x, y) }
    }

    /// Whether the body throws mirror images of the line onto itself, as film does; rough walls of wood do not.
    pub fn can_mirror_itself(&self) -> bool {
        matches!(self.body.relief(), Relief::Film { .. })
    }

    /// Whether the lens sees `point` below a film with the laser at scan position `y`, the film itself ignored [mm].
    pub(crate) fn sees_below(&self, point: Vec3, y: f32) -> bool {
        self.lower.as_ref().is_some_and(|lower| !lower.hides(point, lens(&self.rig, y)))
    }

    /// Height and thickness of the film about a place; `None` where nothing is seen through film [mm].
    pub(crate) fn film(&self, place: Vec2) -> Option<[Differences; 2]> {
        Some([self.upper.as_ref()?.bent(place), self.lower.as_ref()?.film(place)])
    }

    /// Slope of the surface around `hit`, seen with the laser at scan position `y`: the mean over [`ABOUT_MM`] to
    /// either side, where that is less steep than the surface itself by a [`FACET`] and more, as on flanks of embossed
    /// codes [1].
    pub(crate) fn slope_about(&self, hit: &Hit, y: f32) -> Option<Vec2> {
        let own = Vec2::new(hit.surface.slope_x, hit.surface.slope_y);
        if own.length_squared() < FACET * FACET {
            return None;
        }
        let upper = self.upper.as_ref()?;
        let slope = |side: Vec2| {
            let (ahead, behind) = (Vec2::new(hit.x, y) + side, Vec2::new(hit.x, y) - side);
            (upper.height(ahead.x, ahead.y) - upper.height(behind.x, behind.y)) / (2.0 * ABOUT_MM)
        };
        let about = Vec2::new(slope(Vec2::X * ABOUT_MM), slope(Vec2::Y * ABOUT_MM));
        (about.length() + FACET < own.length()).then_some(about)
    }

    /// Where light that leaves `from` on the surface along the unit vector `direction` lands on the body within `reach`
    /// [mm], with the laser at scan position `y` [mm].
    pub(crate) fn reflected_hit(&self, from: Vec3, direction: Vec3, reach: f32, y: f32) -> Option<ReflectedHit> {
        let upper = self.upper.as_ref()?;
        let at = upper.first_hit(from, direction, reach)?;
        let slope = upper.slope(at.x, at.y);
        let surface = Surface { z: at.z, slope_x: slope.x, slope_y: slope.y };
        let lens = lens(&self.rig, y);
        let seen = faces(&surface, lens - at) && !upper.hides(at, lens);
        Some(ReflectedHit { point: at, surface, seen })
    }

    /// What `columns` see with the laser at scan position `y` [mm]; fills `hits`, one a column.
    pub fn look(&self, y: f32, columns: &Sightlines, conveyor: Medium, hits: &mut Vec<Hit>) {
        let pose = self.turntable.map_or_else(|| BodyPose::moved(y), |table| table.pose(f64::from(y)));
        let stands = [Vec3::new(0.0, 0.0, self.fan_height), lens(&self.rig, 0.0)];
        let stands = stands.map(|stand| pose.point_into_body(stand));
        let bare_at = |x: f32| {
            let point = pose.point_into_body(Vec3::new(x, 0.0, 0.0));
            let [lit, seen] = stands.map(|stand| self.sees(point, stand));
            Hit { x, lit, seen, ..bare(conveyor) }
        };
        if self.body.is_its_hull() {
            return self.look_at_triangles(&pose, stands, columns, bare_at, hits);
        }
        if self.turntable.is_some() {
            return self.look_turned(&pose, columns, bare_at, hits);
        }
        let slice = self.body.slice(y);
        // Hits are large: what stands there already is not written again.
        hits.resize(columns.len(), bare(conveyor));
        if let Some(upper) = &self.upper {
            self.look_into(upper, &*slice, y, columns, conveyor, hits);
        } else {
            self.look_onto(&*slice, columns, conveyor, hits);
        }
        for (column, hit) in hits.iter_mut().enumerate().filter(|(_, hit)| hit.is_bare()) {
            let Hit { x, lit, seen, .. } = bare_at(columns.of(column).at(0.0));
            (hit.x, hit.lit, hit.seen) = (x, lit, seen);
        }
        if self.upper.is_some() {
            self.shade(hits);
        }
    }

    /// What `columns` see of a level surface; the others become bare.
    fn look_onto(&self, slice: &dyn Slice, columns: &Sightlines, conveyor: Medium, hits: &mut [Hit]) {
        let mut guess = self.triangles.high.z;
        for (block, hits) in hits.chunks_mut(BLOCK).enumerate() {
            let line = |n: usize| columns.of((block * BLOCK + n).min(columns.len() - 1));
            let mut x: [f32; BLOCK] = std::array::from_fn(|n| line(n).at(guess));
            let mut found = slice.surfaces(&x);
            for n in 0..BLOCK {
                if let Some(first) = found[n]
                    && (first.z - guess).abs() > GUESS_TOLERANCE_MM
                {
                    // The guess was from another part of the body: look again where this column really meets it.
                    x[n] = line(n).at(first.z);
                    found[n] = slice.surface(x[n]);
                }
            }
            for (n, hit) in hits.iter_mut().enumerate() {
                match found[n] {
                    Some(surface) => (hit.x, hit.surface, hit.lit, hit.seen) = (x[n], surface, true, true),
                    None if hit.is_bare() => {}
                    None => *hit = bare(conveyor),
                }
            }
            let seen = hits.len();
            let places =
                std::array::from_fn(|n| Some(Vec2::new(x[n], found[n].filter(|_| n < seen)?.z - MATTER_DEPTH_MM)));
            slice.matters(&places, &mut |n, matter| hits[n].matter = matter);
            guess = found.iter().flatten().last().map_or(guess, |surface| surface.z);
        }
    }

    /// What `columns` see of a surface that may hide parts of itself; the others become bare.
    fn look_into(
        &self,
        upper: &SurfaceGrid,
        slice: &dyn Slice,
        y: f32,
        columns: &Sightlines,
        conveyor: Medium,
        hits: &mut [Hit],
    ) {
        let lens = lens(&self.rig, y);
        let (mut guess, mut last) = (self.triangles.high.z, (0.0, 0.0));
        for (column, hit) in hits.iter_mut().enumerate() {
            let line = columns.of(column);
            let along = |z: f32| line.at(z);
            // Extrapolated along the slope of the last point, within limits.
            guess += ((along(guess) - last.0) * last.1).clamp(-0.5, 0.5);
            let look = |x: f32| slice.surface(x).map(|surface| (x, surface));
            // Where the card ends on the lens's far side, a guess as high as the pockets looks past its edge.
            let mut found = look(along(guess)).or_else(|| look(along(0.0)));
            if let Some((_, first)) = found
                && (first.z - guess).abs() > GUESS_TOLERANCE_MM
            {
                // The guess was from another part of the body: look again where this column really meets it.
                found = look(along(first.z));
            }
            let Some((x, surface)) = found else {
                if !hit.is_bare() {
                    *hit = bare(conveyor);
                }
                continue;
            };
            let (x, surface) = approach(x, surface, line, |x| slice.surface(x));
            guess = surface.z;
            last = (x, surface.slope_x);
            let point = Vec3::new(x, y, surface.z);
            let seen = faces(&surface, lens - point) && !upper.hides(point, lens);
            *hit = Hit { x, surface, matter: slice.matter(x, surface.z - MATTER_DEPTH_MM), lit: true, seen };
        }
    }

    /// Marks as unlit what lies in the shadow of the body's own steep walls: outwards along the line the fan's angle
    /// must grow from point to point.
    fn shade(&self, hits: &mut [Hit]) {
        let middle = hits.partition_point(|hit| hit.x < 0.0);
        let (left, right) = hits.split_at_mut(middle);
        let shade = |hits: &mut dyn Iterator<Item = &mut Hit>| {
            let mut widest = 0.0f32;
            for hit in hits {
                let angle = hit.x.abs() / (self.fan_height - hit.surface.z);
                hit.lit &= angle >= widest;
                widest = widest.max(angle);
            }
        };
        shade(&mut right.iter_mut());
        shade(&mut left.iter_mut().rev());
    }

    /// Intersection of a column's line of sight, which distortion bends, with the surface that its chord meets at
    /// `chord`: point and normal; `None` where the line is straight, or meets nothing near.
    fn meet_bent(&self, pose: &BodyPose, line: &Sightline, chord: Vec3) -> Option<(Vec3, Vec3)> {
        if (pose.point_from_body(chord).x - line.at(chord.z)).abs() < STRAIGHT_TOLERANCE_MM {
            return None;
        }
        let (x, lean) = (line.at(chord.z), line.lean(chord.z));
        let at = |z: f32| pose.point_into_body(Vec3::new(x + lean * (z - chord.z), PLANE_OFFSET_MM, z));
        let (from, to) = (at(chord.z + BENT_SEARCH_MM), at(chord.z - BENT_SEARCH_MM));
        let Intersection { distance, normal } = self.triangles.first_hit(from, to, 0.0)?;
        Some((from + (to - from).normalize() * distance, normal))
    }

    /// [`Specimen::look`] for pieces whose triangles are their surface.
    ///
    /// The body stands in `pose`, fan and lens in its frame at `fan` and `lens`; `conveyor` is what is seen at x where
    /// it is not.
    fn look_at_triangles(
        &self,
        pose: &BodyPose,
        [fan, lens]: [Vec3; 2],
        columns: &Sightlines,
        conveyor: impl Fn(f32) -> Hit,
        hits: &mut Vec<Hit>,
    ) {
        let (low, high) = (self.triangles.low, self.triangles.high);
        let [sky, ground] = [high.z + 1.0, low.z.min(0.0) - LEAVE_MM];
        hits.clear();
        for column in 0..columns.len() {
            let line = columns.of(column);
            let at = |z: f32| pose.point_into_body(Vec3::new(line.at(z), PLANE_OFFSET_MM, z));
            let (from, to) = (at(sky), at(ground));
            let (least, most) = (from.min(to), from.max(to));
            let beside = most.x < low.x || least.x > high.x || most.y < low.y || least.y > high.y;
            let (mut first, mut found) = (None, None);
            let mut start = 0.0;
            for _ in 0..if beside { 0 } else { MAX_SURFACES_PER_SIGHTLINE } {
                let Some(met) = self.triangles.first_hit(from, to, start) else { break };
                start = met.distance + NEXT_SURFACE_STEP_MM;
                let chord = from + (to - from).normalize() * met.distance;
                let (point, normal) = self.meet_bent(pose, &line, chord).unwrap_or((chord, met.normal));
                // The side that faces the laser.
                let normal = if normal.dot(fan - point) < 0.0 { -normal } else { normal };
                let over = point + normal * SHADOW_RAY_START_MM;
                let lit = self.triangles.unobstructed(over, fan);
                let seen = normal.dot(lens - point) > 0.0 && self.triangles.unobstructed(over, lens);
                let (up, out) = (normal.z.max(MIN_NORMAL_Z), pose.direction_from_body(normal));
                let surface = Surface { z: point.z, slope_x: -out.x / up, slope_y: -out.y / up };
                let mut matter = self.body.slice(point.y).matter(point.x, point.z);
                matter.medium.fibre = pose.direction_from_body(matter.medium.fibre);
                let hit = Hit { x: pose.point_from_body(point).x, surface, matter, lit, seen };
                first = first.or(Some(hit));
                if lit && seen {
                    found = Some(hit);
                    break;
                }
            }
            let conveyor = || conveyor(line.at(0.0));
            hits.push(match (found, first) {
                (Some(hit), _) => hit,
                (None, Some(first)) => Some(conveyor()).filter(|bare| bare.lit && bare.seen).unwrap_or(first),
                (None, None) => conveyor(),
            });
        }
    }

    /// [`Specimen::look`] on a turntable, where the body stands in `pose`.
    fn look_turned(&self, pose: &BodyPose, columns: &Sightlines, conveyor: impl Fn(f32) -> Hit, hits: &mut Vec<Hit>) {
        hits.clear();
        let mut guess = self.triangles.high.z;
        for column in 0..columns.len() {
            let line = columns.of(column);
            let at = |z: f32| (line.at(z), pose.point_into_body(Vec3::new(line.at(z), 0.0, z)));
            let look = |z: f32| {
                let (x, point) = at(z);
                self.body.slice(point.y).surface(point.x).map(|surface| (x, point, surface))
            };
            let mut found = look(guess);
            if let Some((.., first)) = found
                && (first.z - guess).abs() > GUESS_TOLERANCE_MM
            {
                found = look(first.z);
            }
            hits.push(match found {
                Some((x, point, surface)) => {
                    guess = surface.z;
                    let mut matter = self.body.slice(point.y).matter(point.x, surface.z);
                    matter.medium.fibre = pose.direction_from_body(matter.medium.fibre);
                    let slope = pose.direction_from_body(Vec3::new(surface.slope_x, surface.slope_y, 0.0));
                    let surface = Surface { z: surface.z, slope_x: slope.x, slope_y: slope.y };
                    Hit { x, surface, matter, lit: true, seen: true }
                }
                None => conveyor(line.at(0.0)),
            });
        }
    }

    /// Whether nothing of the body stands between a point of the conveyor and `stand`.
    #[inline]
    fn sees(&self, point: Vec3, stand: Vec3) -> bool {
        let TriangleBvh { low, high, .. } = &self.triangles;
        // The body's top casts its shadow no further than the ray to the stand at its height, and a margin.
        let ray = stand - point;
        let reach = ray.abs() * (1.2 * high.z / (ray.z - high.z).max(1.0)) + 0.5;
        let near = point.x > low.x - reach.x
            && point.x < high.x + reach.x
            && point.y > low.y - reach.y
            && point.y < high.y + reach.y;
        !near || self.triangles.unobstructed(point, stand)
    }
}

/// The conveyor at x = 0 where laser and lens reach it.
fn bare(medium: Medium) -> Hit {
    let surface = Surface { z: 0.0, slope_x: 0.0, slope_y: 0.0 };
    let matter = Matter { medium, film: None, class: Class::Background, instance: 0 };
    Hit { x: 0.0, surface, matter, lit: true, seen: true }
}

/// Position of the lens with the laser at scan position `y` [mm].
fn lens(rig: &Rig, y: f32) -> Vec3 {
    let (sin, cos) = libm::sincos(rig.tilt);
    Vec3::new(0.0, y - (rig.distance * sin) as f32, (rig.distance * cos) as f32)
}

/// Whether a surface faces `direction`.
fn faces(surface: &Surface, direction: Vec3) -> bool {
    Vec3::new(-surface.slope_x, -surface.slope_y, 1.0).dot(direction) > 0.0
}

/// Intersection of a column's line of sight with a surface, x and surface there, by Newton's method from a point near
/// it. Where the surface ends before, the last point counts.
fn approach(
    mut x: f32,
    mut here: Surface,
    line: Sightline,
    surface: impl Fn(f32) -> Option<Surface>,
) -> (f32, Surface) {
    for _ in 0..MAX_NEWTON_STEPS {
        let off = x - line.at(here.z);
        if off.abs() < NEWTON_TOLERANCE_MM {
            break;
        }
        let next = x - off / (1.0 - line.lean(here.z) * here.slope_x).max(0.5);
        match surface(next) {
            Some(there) => (x, here) = (next, there),
            None => break,
        }
    }
    (x, here)
}

/// The upper surface of a body that can occlude itself, and the surface below its film where that is clear.
fn surface_grids(body: &Body, lens: Vec3) -> (Option<SurfaceGrid>, Option<SurfaceGrid>) {
    let clearest = match body.relief() {
        Relief::Film { clearest } => clearest,
        Relief::Openings => f32::INFINITY,
        Relief::Smooth => return (None, None),
    };
    let (low, high) = body.bounds();
    let upper = SurfaceGrid::new(low, high, lens, false, |y, x, row, _| {
        let slice = body.slice(y);
        for (z, &x) in row.iter_mut().zip(x) {
            *z = slice.surface(x).map_or(0.0, |surface| surface.z);
        }
    });
    let lower = (clearest < OPAQUE_FILM_DEPTH).then(|| {
        SurfaceGrid::new(low, high, lens, true, |y, x, heights, films| {
            let slice = body.slice(y);
            for ((z, thickness), &x) in heights.iter_mut().zip(films).zip(x) {
                let Some(surface) = slice.surface(x) else { continue };
                let film = slice.matter(x, surface.z).film;
                *z = film.map_or(surface.z, |film| height_below(&surface, &film));
                *thickness = film.map_or(0.0, |film| film.thickness_mm);
            }
        })
    });
    (Some(upper), lower)
}
