//! Camera: light of lamps in a band of lines, through the lens, to digital numbers of the map `grey`.
//!
//! A digital number has the mean `dark level + white_dn radiance` and the variance of its electrons, `gain` times the
//! light's part, beside that of the dark pixel. Noise is a hash of profile and column. What stands beside the body is
//! as bright as the conveyor. Pixels whose point the lens does not see have none (NaN); others read 1 at least, so that
//! 0 can stand for these.

use std::ops::Range;

use base::Stream;
use multiversion::multiversion;

use super::irradiance::{LOW_HORIZON, Lamps};
use super::spread::Spread;
use crate::optics::light::{LampLine, ScanLine};
use crate::optics::speckle::TILE;
use crate::optics::window::Band;
use numerics::lanes::normals;
use optical_bench::parameters::Bench;
use optical_bench::settings::Readout;
use transport::kernel::{DIFFUSE_GROUPS, DIFFUSE_SPREAD_MM};

/// Share of a band's reach that spread below the surface has; lens and shadows of its sources have the rest [1].
const SPREAD_REACH: f64 = 0.6;
/// Share of it that the lens has [1].
const LENS_REACH: f64 = 0.2;
/// Standard deviations to which the lens blurs.
const LENS_SIGMAS: f64 = 3.0;

/// The camera of one sample under its lamps.
#[derive(Debug, Clone)]
pub(crate) struct GreyCamera {
    lamps: Lamps,
    /// Spread of the wider groups.
    spreads: [Spread; DIFFUSE_GROUPS - 1],
    /// Weights of the lens along the motion and along the line, from the middle outwards [1].
    lens: [Vec<f32>; 2],
    /// Distance between profiles [mm].
    step: f32,
    /// Lines to either side whose heights can shade a source of light below the surface, and a pixel.
    shadows: [usize; 2],
    chain: GreyChain,
    stream: Stream,
}

/// From radiance to digital numbers.
#[derive(Debug, Clone, Copy)]
struct GreyChain {
    /// Mean number without light, and of white over that [DN].
    dark: f32,
    white: f32,
    /// Photon noise's variance over the signal, and that of a dark pixel [DN, DN^2].
    shot: f32,
    read: f32,
    most: f32,
}

impl GreyCamera {
    /// For lines and columns `pitch` apart [mm] whose bands have `reach` lines to either side.
    pub fn new(lamps: Lamps, bench: &Bench, readout: Readout, pitch: [f64; 2], reach: usize, stream: Stream) -> Self {
        let own = &bench.lamps;
        let part = |share: f64| (share * reach as f64) as usize;
        let lens = [part(LENS_REACH), usize::MAX];
        let lens = [0, 1].map(|axis| lens_weights(own.blur_mm / pitch[axis], lens[axis]));
        let spreads = [1, 2].map(|group| Spread::new(DIFFUSE_SPREAD_MM[group], pitch, part(SPREAD_REACH)));
        let sharp = reach + 1 - lens[0].len();
        let scale = readout.scale();
        let gain = scale * (255.0 - own.dark_level_dn) / own.full_well_e;
        Self {
            lamps,
            spreads,
            lens,
            step: pitch[0] as f32,
            shadows: [sharp - part(SPREAD_REACH), sharp],
            chain: GreyChain {
                dark: (scale * own.dark_level_dn) as f32,
                white: (scale * own.white_dn) as f32,
                shot: gain as f32,
                read: (scale * own.dark_noise_dn).powi(2) as f32,
                most: f32::from(readout.most()),
            },
            stream,
        }
    }

    /// Exposes the profiles of a band: `grey` is `[profiles, columns]`, NaN where the lens sees no point of a profile
    /// [DN].
    pub fn expose(&self, band: &Band, grey: &mut [f32]) {
        let columns = band.line(band.profiles.start).lamps.up.len();
        let lines = LampLines::new(band, columns, self.step * LOW_HORIZON);
        let own = band.profiles.start as isize..band.profiles.end as isize;
        let radius = self.lens[0].len() - 1;
        let sharp = own.start - radius as isize..own.end + radius as isize;
        let light = self.radiance(&lines, sharp, columns);
        let mut row = vec![0.0; columns];
        for (place, (profile, out)) in own.zip(grey.chunks_exact_mut(columns)).enumerate() {
            weigh(&self.lens[0], &light[place..=place + 2 * radius], &mut row);
            along_line(&self.lens[1], &row, out);
            let key = self.stream.index(profile as u64).key();
            self.chain.read(out, [key as u32, (key >> 32) as u32]);
            let hidden = lines.of(profile).seen.iter().map(|seen| !seen);
            out.iter_mut().zip(hidden).filter(|(_, hidden)| *hidden).for_each(|(dn, _)| *dn = f32::NAN);
        }
    }

    /// Radiance of `profiles` before the lens, a row for each; 1 is white.
    fn radiance(&self, lines: &LampLines<'_>, profiles: Range<isize>, columns: usize) -> Vec<Vec<f32>> {
        let mut direct = vec![0.0; columns];
        let mut light: Vec<Vec<f32>> = profiles
            .clone()
            .map(|profile| {
                let line = lines.of(profile);
                let mut out = line.surface.clone();
                // Shadows darken the surface as they do what lies below it.
                for tile in self.irradiance(lines, profile, self.shadows[1], &mut direct) {
                    let mut open = [0.0; TILE];
                    self.lamps.unshaded(line, tile.clone(), &mut open[..tile.len()]);
                    for (column, open) in tile.zip(open) {
                        out[column] *= direct[column] / open.max(1e-3);
                    }
                }
                enters(&line.roots[0], &line.roots[0], &direct, &mut out);
                out
            })
            .collect();
        for (spread, group) in self.spreads.iter().zip(1..) {
            let sources: Vec<Vec<f32>> = spread
                .sources(profiles.clone())
                .map(|profile| {
                    self.irradiance(lines, profile, self.shadows[0], &mut direct);
                    let roots = &lines.of(profile).roots[group];
                    roots.iter().zip(&direct).map(|(root, light)| root * light).collect()
                })
                .collect();
            let left = spread.spread(&sources, profiles.clone(), columns);
            for ((out, left), profile) in light.iter_mut().zip(left).zip(profiles.clone()) {
                let roots = &lines.of(profile).roots[group];
                out.iter_mut().zip(roots.iter().zip(left)).for_each(|(out, (root, left))| *out += root * left);
            }
        }
        light
    }

    /// Irradiance on the line of a profile, shaded by `reach` lines to either side; the tiles where shadows may lie.
    fn irradiance(&self, lines: &LampLines<'_>, profile: isize, reach: usize, out: &mut [f32]) -> Vec<Range<usize>> {
        let line = lines.of(profile);
        self.lamps.unshaded(line, 0..out.len(), out);
        let mut shaded = Vec::new();
        for tile in (0..out.len().div_ceil(TILE)).filter(|&tile| lines.is_steep(profile, reach, tile)) {
            let columns = tile * TILE..((tile + 1) * TILE).min(out.len());
            let rises = [-1, 1].map(|side| lines.rises(profile, side, reach, columns.clone(), self.step));
            for (n, column) in columns.clone().enumerate() {
                out[column] = self.lamps.shaded(line.slope[column], line.up[column], rises.map(|rise| rise[n]));
            }
            shaded.push(columns);
        }
        shaded
    }
}

impl GreyChain {
    /// Makes digital numbers of radiance.
    fn read(&self, row: &mut [f32], keys: [u32; 2]) {
        read(row, keys, *self);
    }
}

/// Digital numbers with noise, two neighbours by one hash.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn read(row: &mut [f32], keys: [u32; 2], chain: GreyChain) {
    for (counter, pair) in row.chunks_mut(2).enumerate() {
        let noise = normals(counter as u32, keys);
        for (dn, noise) in pair.iter_mut().zip([noise.0, noise.1]) {
            let signal = chain.white * dn.max(0.0);
            let noisy = chain.dark + signal + (chain.shot * signal + chain.read).sqrt() * noise;
            *dn = (noisy + 0.5).max(1.0).min(chain.most) as i32 as f32;
        }
    }
}

/// The lamps' lines of a band, with where their heights are steep.
struct LampLines<'a> {
    band: &'a Band,
    /// Whether some height rises above the low horizon from each line to the next, a tile.
    steep: Vec<Vec<bool>>,
}

impl<'a> LampLines<'a> {
    /// Of a band; `rise` is that of the low horizon from a line to the next [mm].
    fn new(band: &'a Band, columns: usize, rise: f32) -> Self {
        let steep = |pair: &[ScanLine]| -> Vec<bool> {
            let heights = [&pair[0].lamps.height, &pair[1].lamps.height];
            (0..columns.div_ceil(TILE))
                .map(|tile| {
                    let columns = tile * TILE..((tile + 1) * TILE).min(columns);
                    greatest_step(&heights[0][columns.clone()], &heights[1][columns]) > rise
                })
                .collect()
        };
        Self { band, steep: band.lines.windows(2).map(steep).collect() }
    }

    fn place(&self, profile: isize) -> usize {
        (profile - self.band.profiles.start as isize + self.band.halo as isize) as usize
    }

    fn of(&self, profile: isize) -> &'a LampLine {
        &self.band.lines[self.place(profile)].lamps
    }

    /// Whether a horizon within `reach` lines can hide light from a tile.
    fn is_steep(&self, profile: isize, reach: usize, tile: usize) -> bool {
        let place = self.place(profile);
        self.steep[place - reach..place + reach].iter().any(|steep| steep[tile])
    }

    /// Greatest rise of heights over the distance on one side of `columns`, the low horizon's at least [1].
    fn rises(&self, profile: isize, side: isize, reach: usize, columns: Range<usize>, step: f32) -> [f32; TILE] {
        let own = &self.of(profile).height[columns.clone()];
        let mut rises = [LOW_HORIZON; TILE];
        for away in 1..=reach {
            let other = &self.of(profile + side * away as isize).height[columns.clone()];
            let over = 1.0 / (away as f32 * step);
            for ((rise, own), other) in rises.iter_mut().zip(own).zip(other) {
                *rise = rise.max((other - own) * over);
            }
        }
        rises
    }
}

/// Greatest difference of heights from a line to the next [mm].
fn greatest_step(line: &[f32], next: &[f32]) -> f32 {
    line.iter().zip(next).fold(0.0, |most: f32, (a, b)| most.max((b - a).abs()))
}

/// Adds light that leaves where it entered.
fn enters(roots: &[f32], exits: &[f32], light: &[f32], out: &mut [f32]) {
    for (((out, root), exit), light) in out.iter_mut().zip(roots).zip(exits).zip(light) {
        *out += root * exit * light;
    }
}

/// Weights of a Gaussian of `sigma` pixels, from the middle to at most `reach` away; they sum to 1 on both sides.
fn lens_weights(sigma: f64, reach: usize) -> Vec<f32> {
    let radius = ((LENS_SIGMAS * sigma).ceil() as usize).min(reach);
    let weight = |d: usize| if d == 0 { 1.0 } else { libm::exp(-0.5 * (d as f64 / sigma).powi(2)) };
    let sum = 1.0 + 2.0 * (1..=radius).map(weight).sum::<f64>();
    (0..=radius).map(|d| (weight(d) / sum) as f32).collect()
}

/// The weighed sum of rows about the middle one.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn weigh(weights: &[f32], rows: &[Vec<f32>], out: &mut [f32]) {
    let middle = weights.len() - 1;
    out.iter_mut().zip(&rows[middle]).for_each(|(out, v)| *out = weights[0] * v);
    for (d, weight) in weights.iter().enumerate().skip(1) {
        let pair = rows[middle - d].iter().zip(&rows[middle + d]);
        out.iter_mut().zip(pair).for_each(|(out, (a, b))| *out += weight * (a + b));
    }
}

/// The same of columns; beyond the ends the row goes on as in a mirror.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn along_line(weights: &[f32], row: &[f32], out: &mut [f32]) {
    let (radius, last) = (weights.len() - 1, row.len() - 1);
    let mut padded = Vec::with_capacity(row.len() + 2 * radius);
    padded.extend((1..=radius).rev().map(|d| row[d.min(last)]));
    padded.extend_from_slice(row);
    padded.extend((1..=radius).map(|d| row[last - d.min(last)]));
    out.iter_mut().zip(row).for_each(|(out, v)| *out = weights[0] * v);
    for (d, weight) in weights.iter().enumerate().skip(1) {
        let pair = padded[radius - d..].iter().zip(&padded[radius + d..]);
        out.iter_mut().zip(pair).for_each(|(out, (a, b))| *out += weight * (a + b));
    }
}
