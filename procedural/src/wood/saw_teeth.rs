//! What single teeth of a band or circular saw leave on the face: torn fibre in dashes across the grain, and scores of
//! the tooth that stands out.
//!
//! Models: u = y + x tan slant + b x^2 runs along the feed, x across. Dashes f are noise of two sizes, stretched across
//! (`Noise::plane`); fine ones lean against the scores. They come and go in patches p. A tooth that stands out leaves
//! one score g a pass: a ridge of raised fibre before a groove, somewhere in the middle half of its pass, of a depth of
//! its own, in pieces that begin and end along it (`Noise::score`). The height is h n with n = sqrt(1 - q^2)
//! (1 + 0.45 p)^2 f / 1.52 + q g, of root mean square h, where q is the scores' share. Of light, each way, hollows take
//! c (2 - n - p), within 0 and 4 c: torn places are brighter. Between the marks cut and crushed cell walls take m
//! (2 - w), within 0 and 4 m, of noise w of two sizes that is hardly stretched. Fibre that stands above one root mean
//! square throws light back before any enters, and mirrors less.
//!
//! Source: the twenty open photographs of sawn spruce and pine (Kodytek et al. 2021). Their marks between 0.15 and 1.5
//! mm spread by 0.049 to 0.017 of ln tone when smoothed by 0.15 to 6 mm across, and by 0.035 to 0.017 when smoothed by
//! 0.05 to 0.5 mm along: these gave sizes and balance of the dashes. Tone along the board over 1 to 60 mm gave the
//! patches. Ridges over three spreads (1575: 0.30 mm wide, 3 to 21 mm long, 2.5 to 5.4 degrees aslant) and their
//! distances (2.2 mm and its multiples) gave the scores. Heights are an engineering estimate. Limits: one machine sawed
//! them all; marks are alike in early- and latewood and in knots.

use base::{BLOCK, Stream, Surface, normal};
use glam::Vec2;
use multiversion::multiversion;

use super::Wood;
use crate::noise::Noise;

/// Cells of fine and coarse dashes along the feed and across it [mm].
const DASHES_MM: [Vec2; 2] = [Vec2::new(0.22, 1.0), Vec2::new(0.6, 2.2)];
/// Their shares of the root mean square; squares sum to 1 [1].
const DASH_SHARES: [f32; 2] = [0.793, 0.61];
/// Cells of the mottle of cut cells along the feed and across it [mm], and their shares, whose squares sum to 1 [1].
const MOTTLE_MM: [Vec2; 2] = [Vec2::new(0.2, 0.28), Vec2::new(0.7, 1.0)];
const MOTTLE_SHARES: [f32; 2] = [0.6, 0.8];
/// Spread of the fine dashes' slope against the scores from board to board [1].
const DASH_LEAN: f64 = 0.1;
/// Spread of the bend of all marks [mm^-1]: arcs of two metres.
const BEND_PER_MM: f64 = 2.5e-4;
/// Cells of the patches across and along the board [mm], how much they vary the dashes' root, and the root mean square
/// that this makes [1].
const PATCH_MM: Vec2 = Vec2::new(110.0, 10.0);
const PATCHES: f32 = 0.45;
const PATCHED: f32 = 1.518;
/// Half width of a score's ridge along the feed, at most this share of the pitch, and the mean length of its pieces
/// [mm].
const SCORE_MM: Vec2 = Vec2::new(0.22, 14.0);
const SCORE_OF_PITCH: f32 = 0.12;
/// How much brighter a patch is, in heights [1], and the heights between which hollows take light [1].
const PATCH_TONE: f32 = 1.0;
const SHADED: [f32; 2] = [-2.0, 2.0];
/// Light that fibre throws back before any enters, for each root mean square above the first, of which there are at
/// most this many [1].
const RAISED_MATTE: f32 = 0.01;
const RAISED_MOST: f32 = 4.0;
/// Share of the gloss that raised fibre loses [1].
const DULL: f32 = 0.5;

/// The marks of a saw's teeth.
#[derive(Debug, Clone)]
pub(super) struct SawTeeth {
    /// Root mean square of the height [mm].
    height: f32,
    /// Shares of dashes and scores in it; squares sum to 1 [1].
    shares: [f32; 2],
    /// Passes per millimetre [mm^-1], and half width of a score [pass].
    per_pitch: f32,
    half: f32,
    slant: f32,
    lean: f32,
    bend: f32,
    shade: f32,
    /// How much the mottle varies light, root mean square [1].
    mottle: f32,
    dashes: [Noise; 2],
    mottles: [Noise; 2],
    patches: Noise,
    scores: Noise,
}

/// What a face torn by teeth does to light.
#[derive(Debug, Clone, Copy)]
pub(super) struct TornLight {
    /// Share that passes the hollows, each way [1].
    pub coat: f32,
    /// Share that raised fibre throws back evenly before any enters [1].
    pub matte: f32,
    /// Factor on the gloss [1].
    pub gloss: f32,
}

impl SawTeeth {
    /// The marks that the numbers ask for.
    pub fn grow(stream: Stream, wood: &Wood) -> Option<Self> {
        let asked = &wood.machining;
        let drawn = |name: &str, sd: f64| (sd * normal(&mut stream.child(name).rng())) as f32;
        let noise = |name: &str| Noise::new(stream.child(name));
        let (pitch, scores) = (asked.teeth_pitch_mm as f32, asked.teeth_scores as f32);
        (asked.teeth_um > 0.0).then(|| Self {
            height: 1.0e-3 * asked.teeth_um as f32,
            shares: [(1.0 - scores * scores).sqrt() / PATCHED, scores],
            per_pitch: 1.0 / pitch,
            half: SCORE_OF_PITCH.min(SCORE_MM.x / pitch),
            slant: libm::tan(asked.teeth_slant_deg.to_radians()) as f32,
            lean: drawn("lean", DASH_LEAN),
            bend: drawn("bend", BEND_PER_MM),
            shade: asked.teeth_shade as f32,
            mottle: asked.teeth_mottle as f32,
            dashes: ["fine", "coarse"].map(noise),
            mottles: ["fine mottle", "coarse mottle"].map(noise),
            patches: noise("patches"),
            scores: noise("scores"),
        })
    }

    /// How far they leave the face [mm], but for the rarest.
    pub fn relief(&self) -> f32 {
        4.0 * self.height
    }

    /// Height over its root mean square [1] at a place from the board's middle [mm], its gradient [mm^-1], and the
    /// patch [1].
    #[inline(always)]
    fn mark(&self, d: Vec2) -> (f32, Vec2, f32) {
        // Along the feed, with its gradient.
        let (u, by) = (d.y + (self.slant + self.bend * d.x) * d.x, Vec2::new(self.slant + 2.0 * self.bend * d.x, 1.0));
        let (patch, patch_slope) = self.patches.plane(d / PATCH_MM);
        let root = (1.0 + PATCHES * patch).max(0.0);
        let much = self.shares[0] * root * root;
        let much_slope = 2.0 * self.shares[0] * root * PATCHES * patch_slope / PATCH_MM;
        let (fine, fine_slope) = self.dash(0, u + self.lean * d.x, d.x, by + Vec2::new(self.lean, 0.0));
        let (coarse, coarse_slope) = self.dash(1, u, d.x, by);
        let (score, slope) = self.scores.score(Vec2::new(u * self.per_pitch, d.x / SCORE_MM.y), self.half);
        let score_slope = slope.x * self.per_pitch * by + Vec2::new(slope.y / SCORE_MM.y, 0.0);
        let height = much * (fine + coarse) + self.shares[1] * score;
        let dash_slope = much * (fine_slope + coarse_slope) + much_slope * (fine + coarse);
        (height, dash_slope + self.shares[1] * score_slope, patch)
    }

    /// Dashes of one size, and their gradient [mm^-1], at `u` along the feed, whose gradient is `by`, and `x` [mm].
    #[inline(always)]
    fn dash(&self, size: usize, u: f32, x: f32, by: Vec2) -> (f32, Vec2) {
        let (value, slope) = self.dashes[size].plane(Vec2::new(u, x) / DASHES_MM[size]);
        let slope = DASH_SHARES[size] * slope / DASHES_MM[size];
        (DASH_SHARES[size] * value, slope.x * by + Vec2::new(slope.y, 0.0))
    }

    /// Mottle of cut cells over its root mean square [1].
    #[inline(always)]
    fn cut_cells(&self, d: Vec2) -> f32 {
        // No closure: one that is not inlined takes the whole loop out of vector code.
        let d = Vec2::new(d.y, d.x);
        let (fine, _) = self.mottles[0].plane(d / MOTTLE_MM[0]);
        let (coarse, _) = self.mottles[1].plane(d / MOTTLE_MM[1]);
        MOTTLE_SHARES[0] * fine + MOTTLE_SHARES[1] * coarse
    }

    #[inline(always)]
    fn light(&self, d: Vec2) -> TornLight {
        let (n, _, patch) = self.mark(d);
        let lit = (n + PATCH_TONE * patch).clamp(SHADED[0], SHADED[1]);
        let cut = if self.mottle > 0.0 { self.cut_cells(d).clamp(SHADED[0], SHADED[1]) } else { SHADED[1] };
        let raised = (n - 1.0).clamp(0.0, RAISED_MOST);
        TornLight {
            coat: (1.0 - self.shade * (SHADED[1] - lit)) * (1.0 - self.mottle * (SHADED[1] - cut)),
            matte: RAISED_MATTE * raised,
            gloss: 1.0 - DULL * raised.min(1.0),
        }
    }

    #[inline(always)]
    fn surface(&self, d: Vec2) -> Surface {
        let (n, slope, _) = self.mark(d);
        Surface { z: self.height * n, slope_x: self.height * slope.x, slope_y: self.height * slope.y }
    }

    /// Height of the marks [mm] and slopes at places `dx` across and `dy` along from the board's middle [mm].
    pub fn surfaces(&self, dx: &[f32; BLOCK], dy: f32) -> [Surface; BLOCK] {
        surfaces(self, dx, dy)
    }

    /// What they do to light there.
    pub fn lights(&self, dx: &[f32; BLOCK], dy: f32) -> [TornLight; BLOCK] {
        lights(self, dx, dy)
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn surfaces(teeth: &SawTeeth, dx: &[f32; BLOCK], dy: f32) -> [Surface; BLOCK] {
    let mut out = [[0.0; BLOCK]; 3];
    for n in 0..BLOCK {
        let Surface { z, slope_x, slope_y } = teeth.surface(Vec2::new(dx[n], dy));
        [out[0][n], out[1][n], out[2][n]] = [z, slope_x, slope_y];
    }
    let [z, slope_x, slope_y] = out;
    std::array::from_fn(|n| Surface { z: z[n], slope_x: slope_x[n], slope_y: slope_y[n] })
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn lights(teeth: &SawTeeth, dx: &[f32; BLOCK], dy: f32) -> [TornLight; BLOCK] {
    let mut out = [[0.0; BLOCK]; 3];
    for n in 0..BLOCK {
        let TornLight { coat, matte, gloss } = teeth.light(Vec2::new(dx[n], dy));
        [out[0][n], out[1][n], out[2][n]] = [coat, matte, gloss];
    }
    let [coat, matte, gloss] = out;
    std::array::from_fn(|n| TornLight { coat: coat[n], matte: matte[n], gloss: gloss[n] })
}
