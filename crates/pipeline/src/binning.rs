//! Binning of images: groups of pixels that become one, measured maps, labels and truth each by a rule of its own.

use base::{Class, atan2};
use dataset::record::{Below, Labels, Maps, TruthMaps};

/// Binning: groups of pixels that become one.
///
/// Of the measured pixels of a group those are averaged that show one surface, the one of their median height: no pixel
/// stands half way up an edge. A group is missing where fewer than half of its pixels are measured, as its label is
/// that of the greater part.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Binning {
    /// Columns of the images before [px].
    pub cols: usize,
    /// Columns of a group [px].
    pub columns: usize,
    /// Rows of a group [px].
    pub rows: usize,
    /// Greatest difference of two heights of one surface within a group, in the unit of Range.
    pub step: f32,
}

/// Products of a fibre's components, which are the same for both of its ends: with f across, along the scan and up,
/// f_y^2 - f_x^2, 2 f_x f_y, -2 f_x f_z, -2 f_y f_z and f_z^2 [1].
fn fibre_products(azimuth: &[f32], dive: &[f32]) -> [Vec<f32>; 5] {
    let product = |of: fn([f32; 4]) -> f32| -> Vec<f32> {
        let pairs = azimuth.iter().zip(dive).map(|(azimuth, dive)| {
            let ((sin, cos), (down, level)) = (libm::sincosf(azimuth.to_radians()), libm::sincosf(dive.to_radians()));
            of([sin, cos, down, level])
        });
        pairs.collect()
    };
    [
        product(|[sin, cos, _, level]| level * level * (cos * cos - sin * sin)),
        product(|[sin, cos, _, level]| 2.0 * level * level * sin * cos),
        product(|[sin, _, down, level]| 2.0 * level * sin * down),
        product(|[_, cos, down, level]| 2.0 * level * cos * down),
        product(|[_, _, down, _]| down * down),
    ]
}

/// Azimuth and dive [deg] of fibres of such products; where their ends are taken along the scan.
fn fibre_angles([cos, sin, across, along, steep]: &[Vec<f32>; 5]) -> (Vec<f32>, Vec<f32>) {
    let angles = |i: usize| {
        let azimuth = 0.5 * atan2(sin[i], cos[i]);
        // Twice the dive has these two for sine and cosine.
        let (sine, cosine) = libm::sincosf(azimuth);
        let twice = [across[i] * sine + along[i] * cosine, libm::hypotf(cos[i], sin[i]) - steep[i]];
        (azimuth.to_degrees(), 0.5 * atan2(twice[0], twice[1]).to_degrees())
    };
    (0..cos.len()).map(angles).unzip()
}

impl Binning {
    fn is_none(self) -> bool {
        self.columns == 1 && self.rows == 1
    }

    /// Labels of groups of pixels: the most frequent class (the greater value on a tie, so that a small defect is not
    /// lost to sound wood), and among its pixels the most frequent instance.
    pub fn labels(self, labels: Labels) -> Labels {
        if self.is_none() {
            return labels;
        }
        let Self { cols, columns, rows, .. } = self;
        let (out_cols, out_rows) = (cols / columns, labels.class.len() / cols / rows);
        let mut out = Labels { class: Vec::with_capacity(out_cols * out_rows), instance: Vec::new() };
        let mut group: Vec<(u8, u16)> = Vec::with_capacity(columns * rows);
        for row in 0..out_rows {
            for column in 0..out_cols {
                group.clear();
                for r in row * rows..(row + 1) * rows {
                    let line = r * cols + column * columns;
                    group.extend((line..line + columns).map(|i| (labels.class[i], labels.instance[i])));
                }
                group.sort_unstable();
                let class = most_frequent(group.iter().map(|&(class, _)| u16::from(class)));
                let instance = most_frequent(group.iter().filter(|p| u16::from(p.0) == class).map(|&(_, i)| i));
                out.class.push(class as u8);
                out.instance.push(instance);
            }
        }
        out
    }

    /// Means of the measured pixels that show a group's surface; of light of lamps means of all that there are.
    pub fn maps(self, mut maps: Maps) -> Maps {
        if self.is_none() {
            return maps;
        }
        self.leave_one_surface(&mut maps.range);
        let light = |map: Vec<f32>| -> Vec<f32> {
            let known = map.iter().zip(&maps.range).map(|(&v, z)| if z.is_nan() { f32::NAN } else { v }).collect();
            self.mean(known, 0.0)
        };
        let (reflectance, scatter) = (light(maps.reflectance), light(maps.scatter));
        let grey = self.mean(maps.grey, f32::NAN);
        Maps { range: self.mean(maps.range, f32::NAN), reflectance, scatter, grey }
    }

    /// Takes away the heights of a group that are not of the surface of their median, the upper one of an even number,
    /// and all of a group of which fewer than half are measured.
    fn leave_one_surface(self, range: &mut [f32]) {
        let Self { cols, columns, rows, step } = self;
        let mut heights = Vec::with_capacity(columns * rows);
        for band in range.chunks_exact_mut(cols * rows) {
            for first in (0..cols / columns).map(|column| column * columns) {
                heights.clear();
                for line in band.chunks_exact(cols) {
                    heights.extend(line[first..first + columns].iter().filter(|z| !z.is_nan()));
                }
                let half = heights.len() / 2;
                let median = if 2 * heights.len() < columns * rows {
                    f32::NAN
                } else {
                    *heights.select_nth_unstable_by(half, f32::total_cmp).1
                };
                for line in band.chunks_exact_mut(cols) {
                    for z in &mut line[first..first + columns] {
                        // NaN fails as well.
                        *z = if (*z - median).abs() <= step { *z } else { f32::NAN };
                    }
                }
            }
        }
    }

    /// Means of truth pixels of groups with these classes; angles by their vectors, NaN left out; NaN off the body.
    pub fn truth(self, truth: TruthMaps, class: &[u8]) -> TruthMaps {
        if self.is_none() {
            return truth;
        }
        let mean = |map: Vec<f32>| self.mean_on_body(map, class);
        let below = match truth.below {
            Below::Fibre { azimuth, dive } => {
                // Both ends of a fibre are alike: what does not tell them apart, products of its components, is
                // averaged.
                let (azimuth, dive) = fibre_angles(&fibre_products(&azimuth, &dive).map(mean));
                Below::Fibre { azimuth, dive }
            }
            Below::Film { thickness, gap } => Below::Film { thickness: mean(thickness), gap: mean(gap) },
            Below::Solid(subject) => Below::Solid(subject),
        };
        TruthMaps { height: mean(truth.height), below }
    }

    /// Means over groups with these classes, NaN left out; NaN off the body.
    pub fn mean_on_body(self, map: Vec<f32>, class: &[u8]) -> Vec<f32> {
        let mut means = self.mean(map, f32::NAN);
        let off = |(_, class): &(&mut f32, &u8)| **class == Class::Background as u8;
        means.iter_mut().zip(class).filter(off).for_each(|(mean, _)| *mean = f32::NAN);
        means
    }

    /// Means of the pixels that are numbers; `missing` where none is.
    fn mean(self, map: Vec<f32>, missing: f32) -> Vec<f32> {
        if self.is_none() {
            return map;
        }
        let Self { cols, columns, rows, .. } = self;
        let mut out = Vec::with_capacity(map.len() / columns / rows);
        for band in map.chunks_exact(cols * rows) {
            for column in 0..cols / columns {
                let (mut sum, mut count) = (0.0f64, 0u32);
                for line in band.chunks_exact(cols) {
                    for &v in line[column * columns..(column + 1) * columns].iter().filter(|v| !v.is_nan()) {
                        sum += f64::from(v);
                        count += 1;
                    }
                }
                out.push(if count > 0 { (sum / f64::from(count)) as f32 } else { missing });
            }
        }
        out
    }
}

/// Most frequent value of a sorted sequence; the greatest of several.
fn most_frequent(sorted: impl Iterator<Item = u16>) -> u16 {
    let (mut best, mut best_count, mut value, mut count) = (0, 0, 0, 0);
    for v in sorted {
        count = if v == value { count + 1 } else { 1 };
        value = v;
        if count >= best_count {
            (best, best_count) = (value, count);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn majority_wins_and_ties_go_to_the_defect() {
        let labels = Labels { class: vec![1, 1, 2, 1, 1, 2, 2, 0], instance: vec![0, 0, 3, 0, 0, 3, 3, 0] };
        let binned = Binning { cols: 4, columns: 2, rows: 2, step: 1.0 }.labels(labels);
        assert_eq!(binned.class, vec![1, 2]);
        assert_eq!(binned.instance, vec![0, 3]);
    }

    /// Groups of three: one surface with a pixel missing, an edge with either side in the majority, the end of an
    /// object before an unmeasured background.
    #[test]
    fn groups_at_edges_show_one_side() {
        let nan = f32::NAN;
        let range = vec![10.0, nan, 11.0, 10.0, 10.2, 3.0, 10.0, 3.0, 3.2, 10.0, nan, nan];
        let dn = vec![6.0, 0.0, 8.0, 6.0, 8.0, 1.0, 6.0, 1.0, 3.0, 6.0, 0.0, 0.0];
        let maps = Maps { range, reflectance: dn.clone(), scatter: dn, grey: Vec::new() };
        let binning = Binning { cols: 12, columns: 3, rows: 1, step: 2.0 };
        let binned = binning.maps(maps);
        let expected = [10.5, 10.1, 3.1, nan];
        for (got, expected) in binned.range.iter().zip(expected) {
            assert!((got - expected).abs() < 1e-5 || got.is_nan() && expected.is_nan(), "{:?}", binned.range);
        }
        assert_eq!(binned.reflectance, [7.0, 7.0, 2.0, 0.0]);
        assert_eq!(binned.scatter, binned.reflectance);
        // Of an even group the upper side, whose class is the greater one too.
        let even = Binning { cols: 2, columns: 2, rows: 1, step: 2.0 };
        let maps = Maps {
            range: vec![3.0, 10.0, 10.0, nan],
            reflectance: vec![1.0; 4],
            scatter: vec![1.0; 4],
            grey: Vec::new(),
        };
        assert_eq!(even.maps(maps).range, [10.0, 10.0]);
        // Truth is that of the label's side.
        let truth = TruthMaps { height: vec![10.0, nan, nan, 10.0, 11.0, nan], below: Below::Solid("mesh") };
        let binned = Binning { cols: 6, columns: 3, rows: 1, step: 2.0 }.truth(truth, &[0, 1]);
        assert!(binned.height[0].is_nan() && binned.height[1] == 10.5, "{:?}", binned.height);
    }

    #[test]
    fn fibres_are_averaged_as_axes() {
        let nan = f32::NAN;
        for (pair, mean) in [
            // Across the scan the azimuth jumps, and the dive's sign with it: these fibres are 2 degrees apart.
            ([[89.0, 10.0], [-89.0, -10.0]], [90.0, 10.0]),
            ([[0.0, 89.0], [0.0, -89.0]], [0.0, 90.0]),
            ([[20.0, 10.0], [40.0, 10.0]], [30.0, 10.0]),
            ([[5.0, -30.0], [5.0, 10.0]], [5.0, -10.0]),
            ([[20.0, 10.0], [nan, nan]], [20.0, 10.0]),
        ] {
            let map = |part: usize| pair.map(|angles| angles[part]).to_vec();
            let below = Below::Fibre { azimuth: map(0), dive: map(1) };
            let binned = Binning { cols: 2, columns: 2, rows: 1, step: 1.0 };
            let binned = binned.truth(TruthMaps { height: vec![1.0, 3.0], below }, &[Class::Clear as u8]);
            let Below::Fibre { azimuth, dive } = binned.below else { panic!("no fibres") };
            let axis = |[azimuth, dive]: [f32; 2]| {
                let (azimuth, dive) = (azimuth.to_radians(), dive.to_radians());
                glam::Vec3::new(azimuth.sin() * dive.cos(), azimuth.cos() * dive.cos(), -dive.sin())
            };
            let alike = axis([azimuth[0], dive[0]]).dot(axis(mean)).abs();
            assert!(alike > 0.9998, "{pair:?}: {} and {} in place of {mean:?}", azimuth[0], dive[0]);
            assert_eq!(binned.height[0], 2.0);
        }
    }
}
