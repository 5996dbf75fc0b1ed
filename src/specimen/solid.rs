//! What columns see of a piece whose triangles are its surface: saw-teeth and parts, overhangs and holes included.
//!
//! In the laser plane the places that a column can see lie on one line, straight but for distortion, which leads past the
//! object from above to the conveyor. Wherever it meets the surface light of the fan can be seen, if the straight ways to the fan's origin and
//! to the lens are free, and both stand on the same side of the surface. Of several such places the first from above
//! counts. Ways are rays through the triangles themselves. Where no place is both lit and seen, the first one stands, dark.
//!
//! Neglected: the other lit places of a column (behind the rim of a gap, say), whose light is weaker by nothing but
//! distance; facets steeper than [`UPRIGHT`], which count as that steep; light that the piece throws on itself.

use glam::Vec3;
use procedural::Surface;

use super::turned::Pose;
use super::{Hit, Specimen, lens};
use crate::frame::{Sightline, Sightlines};

/// Least rise of a surface normal: facets steeper than 88.9 degrees are taken for that steep, and so are overhangs [1].
const UPRIGHT: f32 = 0.02;
/// Start of shadow rays over the surface that they leave [mm].
const OVER_MM: f32 = 0.002;
/// Step behind a surface to look for the next one [mm].
const BEHIND_MM: f32 = 0.001;
/// How far off its chord a line of sight counts as bent [mm].
const STRAIGHT_MM: f32 = 0.0005;
/// How far above and below a bent line is followed by its tangent [mm].
const NEAR_MM: f32 = 0.5;
/// How far beside the laser plane columns look: a ray that runs exactly along an edge between two triangles misses both,
/// and parts have edges at round places [mm].
const ASIDE_MM: f32 = 1e-4;
/// Surfaces that a column looks through at most, one behind the other.
const MOST_SURFACES: usize = 64;

impl Specimen {
    /// Where a column's line of sight, which distortion bends, meets the surface that its chord met at `chord`, and the
    /// normal there; `None` where it is straight, or meets nothing near.
    fn bend(&self, pose: &Pose, line: &Sightline, chord: Vec3) -> Option<(Vec3, Vec3)> {
        if (pose.place(chord).x - line.at(chord.z)).abs() < STRAIGHT_MM {
            return None;
        }
        let (x, lean) = (line.at(chord.z), line.lean(chord.z));
        let at = |z: f32| pose.into_body(Vec3::new(x + lean * (z - chord.z), ASIDE_MM, z));
        let (from, to) = (at(chord.z + NEAR_MM), at(chord.z - NEAR_MM));
        let (far, normal) = self.rays.meet(from, to, 0.0)?;
        Some((from + (to - from).normalize() * far, normal))
    }

    /// [`Specimen::look`] for pieces whose triangles are their surface.
    ///
    /// The body stands in `pose`; `conveyor` is what is seen at x where it is not.
    pub(super) fn look_at_triangles(
        &self,
        pose: &Pose,
        columns: &Sightlines,
        conveyor: impl Fn(f32) -> Hit,
        hits: &mut Vec<Hit>,
    ) {
        let (low, high) = (self.rays.low, self.rays.high);
        let [sky, ground] = [high.z + 1.0, low.z.min(0.0) - super::LEAVE_MM];
        let [fan, lens] = [Vec3::new(0.0, 0.0, self.fan_height), lens(&self.rig, 0.0)].map(|from| pose.into_body(from));
        for column in 0..columns.len() {
            let line = columns.of(column);
            let at = |z: f32| pose.into_body(Vec3::new(line.at(z), ASIDE_MM, z));
            let (from, to) = (at(sky), at(ground));
            let (least, most) = (from.min(to), from.max(to));
            let beside = most.x < low.x || least.x > high.x || most.y < low.y || least.y > high.y;
            let (mut first, mut found) = (None, None);
            let mut start = 0.0;
            for _ in 0..if beside { 0 } else { MOST_SURFACES } {
                let Some((far, normal)) = self.rays.meet(from, to, start) else { break };
                start = far + BEHIND_MM;
                let chord = from + (to - from).normalize() * far;
                let (point, normal) = self.bend(pose, &line, chord).unwrap_or((chord, normal));
                // The side that faces the laser.
                let normal = if normal.dot(fan - point) < 0.0 { -normal } else { normal };
                let over = point + normal * OVER_MM;
                let lit = self.rays.free(over, fan);
                let seen = normal.dot(lens - point) > 0.0 && self.rays.free(over, lens);
                let (up, out) = (normal.z.max(UPRIGHT), pose.out(normal));
                let surface = Surface { z: point.z, slope_x: -out.x / up, slope_y: -out.y / up };
                let mut matter = self.body.slice(point.y).matter(point.x, point.z);
                matter.medium.fibre = pose.out(matter.medium.fibre);
                let hit = Hit { x: pose.place(point).x, surface, matter, lit, seen };
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
}
