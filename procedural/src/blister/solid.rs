//! Convex solids below the film: tablets, pieces of them, particles.
//!
//! Models: an affine image of one shape, cut by any number of half spaces. The shape is what lies within `radius` of a
//! straight segment along x seen from above (a stadium's prism), between two caps, each what lies within the cap's
//! radius of that segment moved down or up. Scaled, that is a biconvex tablet, a flat one, an oval, a caplet, a hard
//! capsule, an ellipsoid and a rod. Straight ways meet each part in a closed form.

use base::{Class, Medium};
use glam::{Mat3, Vec2, Vec3};

/// The shape before it is scaled, turned and moved [mm].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidShape {
    /// Half the length of the segment.
    pub segment: f32,
    /// Radius of the prism.
    pub radius: f32,
    /// Half the height of the straight side.
    pub band: f32,
    /// Radius of the caps, and how far the segment lies beyond the middle for each; `None` for flat faces at the band.
    pub cap: Option<[f32; 2]>,
}

/// A half space that is kept: points with `normal . p <= limit`, in the shape's coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutPlane {
    /// Unit normal out of what is kept [1].
    pub normal: Vec3,
    /// Distance of the plane from the shape's middle [mm].
    pub limit: f32,
}

/// A convex solid in the pack's coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Lowest and highest corner of a box around it [mm].
    pub bounds: [Vec3; 2],
    /// Class of its visible pixels where that is not the pocket's own.
    pub class: Class,
    /// Instance of its visible pixels; 0 where that is the pocket's own, as with tablets and pieces of them.
    pub instance: u16,
    /// What it is made of.
    pub medium: Medium,
    /// Whether its face at +z bears the pack's score line and mark.
    pub(super) marked: bool,
    shape: SolidShape,
    cuts: Vec<CutPlane>,
    /// From the pack's coordinates to the shape's: linear part, after the origin was taken off.
    inverse: Mat3,
    origin: Vec3,
}

const EVERYWHERE: [f32; 2] = [f32::NEG_INFINITY, f32::INFINITY];

impl SolidShape {
    /// Largest value of `way . p` over the shape, for any vector [mm].
    pub fn support(&self, way: Vec3) -> f32 {
        let across = (way.x * way.x + way.y * way.y).sqrt();
        let along = self.segment * way.x.abs();
        if let Some([radius, beyond]) = self.cap {
            let length = way.length();
            if radius * across <= self.radius * length {
                return along + radius * length - beyond * way.z.abs();
            }
        }
        along + self.radius * across + self.band * way.z.abs()
    }

    /// Height of its upper face over the middle, at a distance from the segment [mm].
    pub fn top(&self, distance: f32) -> f32 {
        match self.cap {
            Some([radius, beyond]) => (radius * radius - distance * distance).max(0.0).sqrt() - beyond,
            None => self.band,
        }
    }
}

impl Solid {
    /// The shape under the map `linear p + origin`.
    pub fn new(
        shape: SolidShape,
        cuts: Vec<CutPlane>,
        linear: Mat3,
        origin: Vec3,
        medium: Medium,
        class: Class,
        instance: u16,
    ) -> Self {
        let turned = linear.transpose();
        let reach = Vec3::new(shape.support(turned.x_axis), shape.support(turned.y_axis), shape.support(turned.z_axis));
        let bounds = [origin - reach, origin + reach];
        Self { bounds, class, instance, medium, marked: false, shape, cuts, inverse: linear.inverse(), origin }
    }

    /// Where the straight way `from + t way` is inside: t of entry and of exit, in units of `way`'s length; either may
    /// be negative.
    pub fn span(&self, from: Vec3, way: Vec3) -> Option<[f32; 2]> {
        let way = self.inverse * way;
        let from = self.inverse * (from - self.origin);
        // From the place nearest to the middle, so that nothing is lost to large numbers.
        let shift = -from.dot(way) / way.length_squared();
        let from = from + shift * way;
        let mut span = self.prism(from, way)?;
        if let Some([radius, beyond]) = self.shape.cap {
            let up = Vec3::new(0.0, 0.0, beyond);
            span = common(span, self.swept(from + up, way, radius)?)?;
            if beyond != 0.0 {
                span = common(span, self.swept(from - up, way, radius)?)?;
            }
        } else {
            span = common(span, slab(from.z, way.z, self.shape.band)?)?;
        }
        for cut in &self.cuts {
            span = common(span, below(cut.limit - cut.normal.dot(from), cut.normal.dot(way))?)?;
        }
        Some([span[0] + shift, span[1] + shift])
    }

    /// Its highest and lowest height above (x, y) [mm].
    pub fn column(&self, x: f32, y: f32) -> Option<[f32; 2]> {
        let [low, high] = self.bounds;
        if x < low.x || x > high.x || y < low.y || y > high.y {
            return None;
        }
        let middle = self.origin.z;
        self.span(Vec3::new(x, y, middle), Vec3::Z).map(|[from, to]| [middle + from, middle + to])
    }

    /// Every column of it on a grid of that pitch: place, lowest and highest height [mm].
    pub(super) fn columns(&self, pitch: f32) -> impl Iterator<Item = (Vec2, [f32; 2])> {
        let [low, high] = self.bounds.map(Vec3::truncate);
        let counts = ((high - low) / pitch).clamp(Vec2::splat(3.0), Vec2::splat(200.0)).as_uvec2();
        (0..counts.x * counts.y).filter_map(move |k| {
            let share = (Vec2::new((k % counts.x) as f32, (k / counts.x) as f32) + 0.5) / counts.as_vec2();
            let p = low + (high - low) * share;
            self.column(p.x, p.y).map(|column| (p, column))
        })
    }

    /// Outward unit normal of its surface nearest to `at` [1].
    pub fn normal(&self, at: Vec3) -> Vec3 {
        let p = self.inverse * (at - self.origin);
        let away = |p: Vec3| p - Vec3::X * p.x.clamp(-self.shape.segment, self.shape.segment);
        let side = away(Vec3::new(p.x, p.y, 0.0));
        let mut best = (side.length() - self.shape.radius, side.normalize_or(Vec3::X));
        let mut offer = |distance: f32, normal: Vec3| {
            if distance > best.0 {
                best = (distance, normal);
            }
        };
        match self.shape.cap {
            Some([radius, beyond]) => {
                for up in [beyond, -beyond] {
                    let arm = away(p + Vec3::new(0.0, 0.0, up));
                    offer(arm.length() - radius, arm.normalize_or(Vec3::Z));
                }
            }
            None => offer(p.z.abs() - self.shape.band, Vec3::Z * p.z.signum()),
        }
        for cut in &self.cuts {
            offer(cut.normal.dot(p) - cut.limit, cut.normal);
        }
        (self.inverse.transpose() * best.1).normalize_or(Vec3::Z)
    }

    /// A place in the coordinates of the shape [mm].
    pub(super) fn own(&self, at: Vec3) -> Vec3 {
        self.inverse * (at - self.origin)
    }

    /// A slope along its own x and y, in millimetres of `scale` times its shape, along the pack's x and y [1].
    pub(super) fn slope(&self, scale: Vec3, slope: Vec2) -> Vec2 {
        let along = |axis: Vec3| (axis * scale).truncate().dot(slope);
        Vec2::new(along(self.inverse.x_axis), along(self.inverse.y_axis))
    }

    /// Where the way is in the prism.
    fn prism(&self, from: Vec3, way: Vec3) -> Option<[f32; 2]> {
        self.swept(from.with_z(0.0), way.with_z(0.0), self.shape.radius)
    }

    /// Where the way is within `radius` of the segment: between the outermost ends of two balls and a cylinder.
    #[inline]
    fn swept(&self, from: Vec3, way: Vec3, radius: f32) -> Option<[f32; 2]> {
        let segment = self.shape.segment;
        if segment == 0.0 {
            return within(from.length_squared() - radius * radius, from.dot(way), way.length_squared());
        }
        let ball = |x: f32| {
            let from = from - Vec3::X * x;
            within(from.length_squared() - radius * radius, from.dot(way), way.length_squared())
        };
        let (side, across) = (from.with_x(0.0), way.with_x(0.0));
        let tube = within(side.length_squared() - radius * radius, side.dot(across), across.length_squared())
            .and_then(|span| common(span, slab(from.x, way.x, segment)?));
        [ball(-segment), tube, ball(segment)].into_iter().flatten().reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }
}

/// Where c + 2 b t + a t^2 <= 0.
#[inline]
fn within(c: f32, b: f32, a: f32) -> Option<[f32; 2]> {
    if a <= 1.0e-12 {
        return (c <= 0.0).then_some(EVERYWHERE);
    }
    let root = b * b - a * c;
    if root <= 0.0 {
        return None;
    }
    let root = root.sqrt();
    Some([(-b - root) / a, (-b + root) / a])
}

/// Where |p + t w| <= half.
#[inline]
fn slab(p: f32, w: f32, half: f32) -> Option<[f32; 2]> {
    common(below(half - p, w)?, below(half + p, -w)?)
}

/// Where t w <= room.
#[inline]
fn below(room: f32, w: f32) -> Option<[f32; 2]> {
    if w.abs() <= 1.0e-9 {
        (room >= 0.0).then_some(EVERYWHERE)
    } else if w > 0.0 {
        Some([f32::NEG_INFINITY, room / w])
    } else {
        Some([room / w, f32::INFINITY])
    }
}

#[inline]
fn common(a: [f32; 2], b: [f32; 2]) -> Option<[f32; 2]> {
    let both = [a[0].max(b[0]), a[1].min(b[1])];
    (both[0] < both[1]).then_some(both)
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::{Gloss, Stream};
    use rand::RngExt;

    /// Whether a place of the shape's coordinates is inside, straight from the definition.
    fn inside(shape: &SolidShape, cuts: &[CutPlane], p: Vec3) -> bool {
        let away = |p: Vec3| (p - Vec3::X * p.x.clamp(-shape.segment, shape.segment)).length();
        let capped = match shape.cap {
            Some([radius, beyond]) => [beyond, -beyond].iter().all(|&up| away(p + Vec3::Z * up) < radius),
            None => p.z.abs() < shape.band,
        };
        capped && away(p.with_z(0.0)) < shape.radius && cuts.iter().all(|cut| cut.normal.dot(p) < cut.limit)
    }

    #[test]
    fn ways_enter_and_leave_where_the_definition_says() {
        let lens = SolidShape { segment: 0.0, radius: 4.0, band: 1.0, cap: Some([8.5, 6.5]) };
        let caplet = SolidShape { segment: 3.0, ..lens };
        let flat = SolidShape { cap: None, ..caplet };
        let rod = SolidShape { segment: 5.0, radius: 3.0, band: 0.0, cap: Some([3.0, 0.0]) };
        let cut = CutPlane { normal: Vec3::new(0.6, 0.0, 0.8), limit: 1.0 };
        let mut rng = Stream::root(1).child("ways").rng();
        let mut vector = || Vec3::from_array(std::array::from_fn(|_| 2.0 * rng.random::<f32>() - 1.0));
        let linear = Mat3::from_cols(Vec3::new(1.2, 0.3, 0.1), Vec3::new(-0.2, 0.9, 0.2), Vec3::new(0.0, -0.1, 1.0));
        let mut hits = 0;
        for shape in [lens, caplet, flat, rod] {
            for cuts in [vec![], vec![cut]] {
                let medium = Medium::opaque(Gloss::NONE);
                let origin = Vec3::new(30.0, 60.0, 3.0);
                let solid = Solid::new(shape, cuts.clone(), linear, origin, medium, Class::Pocket, 0);
                for _ in 0..3000 {
                    let (from, way) = (origin + 12.0 * vector(), vector());
                    let holds = |t: f32| inside(&shape, &cuts, linear.inverse() * (from + t * way - origin));
                    match solid.span(from, way) {
                        Some([a, b]) => {
                            hits += 1;
                            let e = 1.0e-4 / way.length();
                            assert!(!holds(a - e) && !holds(b + e), "{shape:?} reaches beyond its span");
                            assert!(b - a < 4.0 * e || holds(a + e) && holds(b - e), "{shape:?} leaves its span");
                            let ends = [from + a * way, from + b * way];
                            for (end, sign) in ends.into_iter().zip([-1.0, 1.0]) {
                                assert!(
                                    sign * solid.normal(end).dot(way) > -1.0e-3,
                                    "{shape:?}: a normal points inwards"
                                );
                                assert!(end.cmpge(solid.bounds[0] - 1.0e-4).all());
                                assert!(end.cmple(solid.bounds[1] + 1.0e-4).all());
                            }
                        }
                        None => assert!((-40..40).all(|i| !holds(i as f32)), "{shape:?} is missed"),
                    }
                }
            }
        }
        assert!(hits > 3000, "{hits} hits");
    }
}
