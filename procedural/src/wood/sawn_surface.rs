//! The sawn upper surface: warp, saw ripple and roughness.
//!
//! Models: z = thickness + warp + ripple + roughness above the conveyor. Warp is a parabola across the board (cup) plus
//! a turn that grows along it (twist). The band saw leaves a ripple sqrt2 rms a(y) sin(2 pi (y + q x) / pitch + p(y))
//! whose amplitude a and phase p drift. Torn fibres leave raised strands and furrows of three sizes that run along the
//! log, side by side at random places and of random length (`Noise::fibres`). The long edges leave straight lines by
//! noise of two scales. Sources: sizes in docs/theory/wood.md. Marks of planers, other saws
//! and teeth: `tool_marks`, `saw_teeth`. Limits:
//! chips pressed into the face are not modelled.

use std::f32::consts::{PI, SQRT_2, TAU};

use base::{BLOCK, Mesh, Stream, Surface, normal};
use glam::{Vec2, Vec3};

use super::saw_teeth::{SawTeeth, TornLight};
use super::tool_marks::{ToolMarks, sin_cos};
use super::{EDGE_MOST, Wood};
use crate::noise::Noise;

/// How much the ripple's amplitude drifts, root mean square [1].
const RIPPLE_DRIFT: f32 = 0.25;
/// How much its phase drifts, root mean square [rad].
const RIPPLE_PHASE: f32 = 0.7;
/// Cells of both drifts [pitch].
const RIPPLE_CELL: f32 = 2.5;
/// Spread of the ridges' slant against the laser line from board to board [1].
const RIPPLE_SLANT: f64 = 0.03;
/// Half widths of torn strands across the fibre and their mean lengths along it [mm]: a few tracheids, a splinter, a
/// torn-out furrow. Their slope is 5.6 rad/mm of height across and 0.6 along.
const STRANDS_MM: [Vec2; 3] = [Vec2::new(0.25, 2.2), Vec2::new(0.6, 5.0), Vec2::new(1.6, 11.0)];
/// Their shares of the root mean square; squares sum to 1 [1].
const STRAND_SHARES: [f32; 3] = [0.66, 0.57, 0.49];
/// Cells of an edge's wander along it [mm], and their shares of its root mean square; squares sum to 1 [1].
const EDGE_CELLS_MM: [f32; 2] = [45.0, 7.0];
const EDGE_SHARES: [f32; 2] = [0.9, 0.44];
/// Longest edge of the hull [mm].
const HULL_EDGE_MM: f32 = 5.0;
/// Most edges of the hull across and along: warp needs few, and a hull of millions would help nobody.
const HULL_LIMITS: [f32; 2] = [64.0, 2000.0];
/// Hull edges in a pitch of the ripple [1].
const HULL_PER_PITCH: f32 = 6.0;
/// Lowest place of the hull's upper side [mm].
const HULL_LOWEST_MM: f32 = 0.01;

/// The upper surface of a board.
#[derive(Debug, Clone)]
pub(super) struct SawnSurface {
    /// Middle of the board and half its size [mm].
    middle: Vec2,
    half: Vec2,
    thickness: f32,
    cup: f32,
    /// Slope across the board gained along it [mm^-1].
    twist: f32,
    /// Wander of the left and the right edge, root mean square [mm].
    edge_wander: f32,
    edges: [Noise; 2],
    /// Amplitude of the ripple without drift [mm].
    ripple: f32,
    pitch: f32,
    slant: f32,
    /// Drift of amplitude and phase.
    drift: [Noise; 2],
    /// Root mean square [mm].
    roughness: f32,
    /// Torn strands of each size.
    strands: [Noise; 3],
    /// Cosine and sine of the log's turn [1].
    turn: Vec2,
    marks: ToolMarks,
    teeth: Option<SawTeeth>,
}

/// The upper surface along one profile.
#[derive(Debug, Clone, Copy)]
pub(super) struct SawnProfile<'a> {
    sawn: &'a SawnSurface,
    /// From the left to the right edge, from the board's middle [mm]; empty before and behind the board.
    edges: [f32; 2],
    /// Distance of the profile from the board's middle [mm].
    dy: f32,
    /// Amplitude of the ripple [mm] and its slope along the scan [1].
    amplitude: Vec2,
    /// Phase of the ripple in the board's middle [rad] and its slope along the scan [rad/mm].
    phase: Vec2,
}

impl SawnSurface {
    /// The surface of a board.
    pub fn grow(stream: Stream, wood: &Wood) -> Self {
        let board = &wood.board;
        let noise = |name: &str| Noise::new(stream.child(name));
        let slant = normal(&mut stream.child("slant").rng());
        let (sin, cos) = libm::sincos(wood.log.turn_deg().to_radians());
        Self {
            middle: Vec2::new(board.offset_mm as f32, (board.lead_in_mm + 0.5 * board.length_mm) as f32),
            half: 0.5 * Vec2::new(board.width_mm as f32, board.length_mm as f32),
            thickness: board.thickness_mm as f32,
            cup: board.cup_mm as f32,
            twist: (libm::tan(board.twist_deg.to_radians()) / board.length_mm) as f32,
            ripple: SQRT_2 * 1.0e-3 * board.saw_ripple_um as f32 / (1.0 + RIPPLE_DRIFT * RIPPLE_DRIFT).sqrt(),
            pitch: board.saw_pitch_mm as f32,
            edge_wander: board.edge_wander_mm as f32,
            edges: ["left edge", "right edge"].map(noise),
            slant: (RIPPLE_SLANT * slant) as f32,
            drift: [noise("amplitude"), noise("phase")],
            roughness: 1.0e-3 * board.roughness_um as f32,
            strands: ["fine", "middle", "coarse"].map(noise),
            turn: Vec2::new(cos as f32, sin as f32),
            marks: ToolMarks::grow(stream.child("tool"), wood),
            teeth: SawTeeth::grow(stream.child("teeth"), wood),
        }
    }

    /// The surface along the profile at `y` [mm].
    pub fn cut(&self, y: f32) -> SawnProfile<'_> {
        let dy = y - self.middle.y;
        let cell = RIPPLE_CELL * self.pitch;
        let drift = self.drift.map(|noise| {
            let (value, slope) = noise.line(y / cell);
            Vec2::new(value, slope / cell)
        });
        let phase = RIPPLE_PHASE * drift[1] + TAU / self.pitch * Vec2::new(dy, 1.0);
        SawnProfile {
            sawn: self,
            edges: if dy.abs() <= self.half.y { self.edges(y) } else { [f32::INFINITY, f32::NEG_INFINITY] },
            dy,
            amplitude: self.ripple * (Vec2::X + RIPPLE_DRIFT * drift[0]),
            phase: Vec2::new(phase.x.rem_euclid(TAU) - PI, phase.y),
        }
    }

    /// Left and right edge at a place along the scan, from the board's middle [mm].
    pub fn edges(&self, y: f32) -> [f32; 2] {
        if self.edge_wander == 0.0 {
            return [-self.half.x, self.half.x];
        }
        let wander = self.edges.map(|noise| {
            let scales = EDGE_CELLS_MM.into_iter().zip(EDGE_SHARES).enumerate();
            let sum: f32 = scales.map(|(i, (cell, share))| share * noise.line(y / cell + 1000.0 * i as f32).0).sum();
            self.edge_wander * sum.clamp(-EDGE_MOST, EDGE_MOST)
        });
        [-self.half.x + wander[0], self.half.x + wander[1]]
    }

    /// The nominal corner nearest to the start of scan and laser line [mm].
    pub fn corner(&self) -> Vec2 {
        self.middle - self.half
    }

    /// Lowest and highest corner of the board with all its warp [mm].
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let half = self.half + Vec2::new(EDGE_MOST * self.edge_wander, 0.0);
        let warp = self.cup.abs() + (self.twist * self.half.x * self.half.y).abs();
        // Beyond the nominal width, where edges wander, parabola and turn go on.
        let cup = (self.cup / 3.0).max(self.cup * (1.0 / 3.0 - (half.x / self.half.x).powi(2)));
        let warp = warp.max(cup + (self.twist * half.x * half.y).abs());
        let rise = warp + 2.0 * self.ripple + self.marks();
        let (low, high) = (self.middle - half, self.middle + half);
        (low.extend(0.0), high.extend(self.thickness + rise + 4.0 * self.roughness))
    }

    /// Height of the face before warp, ripple and roughness [mm].
    pub fn thickness(&self) -> f32 {
        self.thickness
    }

    /// How far ripple and roughness leave the warped face, but for the rarest strands [mm].
    pub fn relief(&self) -> f32 {
        2.0 * self.ripple + 4.0 * self.roughness + self.marks()
    }

    /// How far marks of tools leave it [mm].
    fn marks(&self) -> f32 {
        self.marks.relief() + self.teeth.as_ref().map_or(0.0, SawTeeth::relief)
    }

    /// A closed hull without the roughness, down to the conveyor.
    pub fn hull(&self) -> Mesh {
        let edge = if self.ripple > 0.0 { HULL_EDGE_MM.min(self.pitch / HULL_PER_PITCH) } else { HULL_EDGE_MM };
        let nx = (2.0 * self.half.x / HULL_EDGE_MM).ceil().clamp(1.0, HULL_LIMITS[0]) as u32;
        let ny = (2.0 * self.half.y / edge).ceil().clamp(1.0, HULL_LIMITS[1]) as u32;
        let mut positions = Vec::new();
        for j in 0..=ny {
            let y = self.middle.y + self.half.y * (2.0 * j as f32 / ny as f32 - 1.0);
            let (cut, [left, right]) = (self.cut(y), self.edges(y));
            for i in 0..=nx {
                let share = 2.0 * i as f32 / nx as f32 - 1.0;
                let dx = 0.5 * (right + left) + 0.5 * (right - left) * share;
                let z = self.thickness + cut.warp(dx).z + cut.ripple(dx).z;
                positions.push(Vec3::new(self.middle.x + dx, y, z.max(HULL_LOWEST_MM)));
            }
        }
        let at = |i: u32, j: u32| j * (nx + 1) + i;
        let mut triangles = Vec::new();
        for j in 0..ny {
            for i in 0..nx {
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        // Around the upper rim, counter-clockwise from above, with a foot below each corner.
        let rim: Vec<u32> = (0..nx)
            .map(|i| at(i, 0))
            .chain((0..ny).map(|j| at(nx, j)))
            .chain((0..nx).map(|i| at(nx - i, ny)))
            .chain((0..ny).map(|j| at(0, ny - j)))
            .collect();
        let foot = positions.len() as u32;
        let feet: Vec<Vec3> = rim.iter().map(|&corner| positions[corner as usize].with_z(0.0)).collect();
        positions.extend(feet);
        let centre = positions.len() as u32;
        positions.push(self.middle.extend(0.0));
        for (side, &corner) in rim.iter().enumerate() {
            let next = (side + 1) % rim.len();
            let (low, next_low) = (foot + side as u32, foot + next as u32);
            triangles.push([corner, low, next_low]);
            triangles.push([corner, next_low, rim[next]]);
            triangles.push([centre, next_low, low]);
        }
        Mesh { positions, triangles }
    }
}

impl SawnProfile<'_> {
    /// How far the board's matter was moved upwards at `dx` from its middle [mm], with slopes.
    #[inline]
    pub fn warp(&self, dx: f32) -> Surface {
        let sawn = self.sawn;
        let share = dx / sawn.half.x;
        Surface {
            // The mean of the parabola over the width is taken out, so that cupping keeps the thickness.
            z: sawn.cup * (1.0 / 3.0 - share * share) + sawn.twist * dx * self.dy,
            slope_x: -2.0 * sawn.cup * share / sawn.half.x + sawn.twist * self.dy,
            slope_y: sawn.twist * dx,
        }
    }

    #[inline]
    fn ripple(&self, dx: f32) -> Surface {
        let across = TAU / self.sawn.pitch * self.sawn.slant;
        let (sin, cos) = sin_cos(self.phase.x + across * dx);
        Surface {
            z: self.amplitude.x * sin,
            slope_x: self.amplitude.x * cos * across,
            slope_y: self.amplitude.x * cos * self.phase.y + self.amplitude.y * sin,
        }
    }

    /// The place at `dx` from the board's middle, across and along the strands [mm].
    #[inline]
    fn across_strands(&self, dx: f32) -> Vec2 {
        let turn = self.sawn.turn;
        Vec2::new(dx * turn.x - self.dy * turn.y, dx * turn.y + self.dy * turn.x)
    }

    /// Torn strands of all sizes together, each with its height [1] and its slope [1/cell].
    #[inline]
    fn roughness(&self, strand: impl Fn(usize) -> (f32, Vec2)) -> Surface {
        let (mut z, mut slope) = (0.0, Vec2::ZERO);
        for (i, (size, share)) in STRANDS_MM.into_iter().zip(STRAND_SHARES).enumerate() {
            let (height, tilt) = strand(i);
            z += share * height;
            slope += share * tilt / size;
        }
        let (rough, turn) = (self.sawn.roughness, self.sawn.turn);
        let (z, slope) = (rough * z, rough * slope);
        Surface { z, slope_x: slope.x * turn.x + slope.y * turn.y, slope_y: slope.y * turn.x - slope.x * turn.y }
    }

    /// The upper surface above some `x` [mm]; `None` beside the board.
    pub fn surfaces(&self, x: &[f32; BLOCK]) -> [Option<Surface>; BLOCK] {
        let dx = x.map(|x| x - self.sawn.middle.x);
        let inside = dx.map(|dx| self.is_inside(dx));
        if !inside.contains(&true) {
            return [None; BLOCK];
        }
        let log = dx.map(|dx| self.across_strands(dx));
        let strands = [0, 1, 2].map(|i| {
            let size = STRANDS_MM[i];
            self.sawn.strands[i].fibres_at(&log.map(|log| log.x / size.x), &log.map(|log| log.y / size.y))
        });
        let teeth = self.sawn.teeth.as_ref().map(|teeth| teeth.surfaces(&dx, self.dy));
        std::array::from_fn(|n| {
            let strand = |i: usize| {
                let [height, across, along] = &strands[i];
                (height[n], Vec2::new(across[n], along[n]))
            };
            inside[n].then(|| self.face(dx[n], self.roughness(strand), teeth.map(|teeth| teeth[n])))
        })
    }

    /// The upper surface above `x` [mm]; `None` beside the board.
    #[inline]
    pub fn surface(&self, x: f32) -> Option<Surface> {
        let dx = x - self.sawn.middle.x;
        let log = self.across_strands(dx);
        let strand = |i: usize| self.sawn.strands[i].fibres(log / STRANDS_MM[i]);
        let teeth = || Some(self.sawn.teeth.as_ref()?.surfaces(&[dx; BLOCK], self.dy)[0]);
        self.is_inside(dx).then(|| self.face(dx, self.roughness(strand), teeth()))
    }

    /// Whether the board is there at `dx` from its middle [mm].
    #[inline]
    fn is_inside(&self, dx: f32) -> bool {
        let [left, right] = self.edges;
        (left..=right).contains(&dx)
    }

    /// The upper surface at `dx` from the board's middle, where it is as rough as this and teeth left that [mm].
    #[inline]
    fn face(&self, dx: f32, roughness: Surface, teeth: Option<Surface>) -> Surface {
        let (warp, ripple) = (self.warp(dx), self.ripple(dx));
        let mut face = Surface {
            z: self.sawn.thickness + warp.z + ripple.z + roughness.z,
            slope_x: warp.slope_x + ripple.slope_x + roughness.slope_x,
            slope_y: warp.slope_y + ripple.slope_y + roughness.slope_y,
        };
        let tools = &self.sawn.marks;
        let marks = (!tools.is_empty()).then(|| tools.at(Vec2::new(dx, self.dy)));
        for mark in marks.into_iter().chain(teeth) {
            face.z += mark.z;
            face.slope_x += mark.slope_x;
            face.slope_y += mark.slope_y;
        }
        face
    }

    /// What torn fibre does to light above `x` [mm]; `None` where no tooth has torn any.
    pub fn torn(&self, x: &[f32; BLOCK]) -> Option<[TornLight; BLOCK]> {
        let teeth = self.sawn.teeth.as_ref()?;
        Some(teeth.lights(&x.map(|x| x - self.sawn.middle.x), self.dy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_is_sine_and_cosine() {
        for i in -4000..4000 {
            let angle = i as f32 * 0.003_7;
            let (sin, cos) = sin_cos(angle);
            // The first terms left out are (pi/2)^11/11! and (pi/2)^12/12!; doubling doubles them.
            assert!((sin - angle.sin()).abs() < 1.2e-5 && (cos - angle.cos()).abs() < 1.2e-5, "at {angle}");
        }
    }
}
