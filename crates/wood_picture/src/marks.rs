//! Marks across the grain: what the teeth of a saw or a planer's knives have left.
//!
//! Model: the logarithm of light is averaged across the grain under a Gaussian of 1.5 mm, and what varies along the
//! board over some tenths of a millimetre to some millimetres is left, the difference of Gaussians of 0.15 and 0.6 mm.
//! Streaks and rings have little of that; torn fibres and noise less. Its standard deviation tells marks from their
//! absence. Twenty photographs of sawn boards had 0.015 to 0.03, turned by 20 degrees 0.012 and more; a grown board
//! under band-saw ripple and noise of 8 % has less than 0.011. Pitch: the first lag along the grain at which the
//! averages, less their mean over 2 mm, are like themselves again after they were unlike. Their correlation there is
//! above five standard errors, which stretches of 6 mm tell by how they differ. Marks that lie at no distance of their
//! own have none: of twenty photographs one had a pitch, 2.5 mm. Limits: torn grain counts as marks; a pitch over 4 mm
//! is not told.

use crate::raster::{Beyond, quantile, smooth};

/// Standard deviation of the mean across the grain, and its step [mm].
pub(crate) const ACROSS_MM: [f32; 2] = [1.5, 0.5];
/// Gaussians along the grain whose difference is looked at [mm].
const ALONG_MM: [f32; 2] = [0.15, 0.6];
/// Least deviation that is told as marks [1].
const LEAST: f32 = 0.011;
/// Mean along the grain whose departures may have a pitch [mm], and the most that they count over their median [1].
const TREND_MM: f32 = 2.0;
const MOST: f32 = 4.0;
/// Pitches that are looked for [mm].
const PITCHES_MM: [f32; 2] = [0.3, 4.0];
/// Stretches of the board that speak independently [mm]; a pitch has so many standard errors of their mean [1].
const STRETCH_MM: f32 = 6.0;
const STANDS_OUT: f32 = 5.0;

/// Marks across the grain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SawMarks {
    /// Standard deviation of the logarithm of light that they make [1].
    pub strength: f32,
    /// Distance from one to the next along the grain, where they have one [mm].
    pub pitch_mm: Option<f32>,
}

/// Marks in the logarithm of light that was averaged across the grain, which lies nearer to the columns unless it
/// `lies_across`.
pub(crate) fn marks(
    across: &[f32],
    size: [usize; 2],
    pixel_mm: [f32; 2],
    counts: &[bool],
    lies_across: bool,
) -> Option<SawMarks> {
    let grain = usize::from(lies_across);
    let clear = counts.iter().filter(|counts| **counts).count().max(1) as f64;
    let mean =
        across.iter().zip(counts).map(|(value, &counts)| f64::from(if counts { *value } else { 0.0 })).sum::<f64>();
    let mean = (mean / clear) as f32;
    let level: Vec<f32> =
        across.iter().zip(counts).map(|(value, &counts)| if counts { value - mean } else { 0.0 }).collect();
    let along = |along_mm: f32| {
        let mut sigma = [0.0; 2];
        sigma[grain] = along_mm / pixel_mm[grain];
        smooth(&level, size, sigma, Beyond::Same)
    };
    let [fine, wide] = ALONG_MM.map(along);
    let counted = (0..across.len()).filter(|&pixel| counts[pixel]);
    let squares = counted.map(|pixel| f64::from(fine[pixel] - wide[pixel]).powi(2)).sum::<f64>();
    let strength = (squares / clear).sqrt() as f32;
    (strength > LEAST).then(|| {
        let left: Vec<f32> = level.iter().zip(along(TREND_MM)).map(|(value, trend)| value - trend).collect();
        SawMarks { strength, pitch_mm: pitch(&left, size, pixel_mm, counts, grain) }
    })
}

/// The distance along axis `grain` at which marks are like themselves again, if there is one [mm].
fn pitch(marks: &[f32], size: [usize; 2], pixel_mm: [f32; 2], counts: &[bool], grain: usize) -> Option<f32> {
    let mut sizes: Vec<f32> = (0..marks.len()).step_by(7).filter(|&i| counts[i]).map(|i| marks[i].abs()).collect();
    let most = MOST * if sizes.is_empty() { 0.0 } else { quantile(&mut sizes, 0.5) };
    let stretch = ((STRETCH_MM / pixel_mm[grain]) as usize).max(1);
    // Neighbours across the grain are one mean.
    let [step, apart] = if grain == 0 { [size[1], 1] } else { [1, size[1]] };
    let each = ((ACROSS_MM[0] / pixel_mm[1 - grain]) as usize).max(1);
    let products = |lag: usize| {
        let mut sums = vec![0.0_f32; size[grain] / stretch + 1];
        for line in (0..size[1 - grain]).step_by(each) {
            for at in 0..size[grain].saturating_sub(lag) {
                let pixel = line * apart + at * step;
                let other = pixel + lag * step;
                if counts[pixel] && counts[other] {
                    let product = marks[pixel].clamp(-most, most) * marks[other].clamp(-most, most);
                    sums[at / stretch] += product;
                }
            }
        }
        sums
    };
    let own = products(0);
    let all = own.iter().sum::<f32>().max(f32::MIN_POSITIVE);
    let [first, last] = PITCHES_MM.map(|mm| (mm / pixel_mm[grain]) as usize);
    // Correlation at each lag with its standard error.
    let like: Vec<[f32; 2]> = (first..=last + 1)
        .map(|lag| {
            let sums = products(lag);
            let mean = sums.iter().sum::<f32>() / all;
            let off = sums.iter().zip(&own).map(|(sum, own)| (sum - mean * own).powi(2)).sum::<f32>();
            [mean, off.sqrt() / all]
        })
        .collect();
    let mut lowest = f32::INFINITY;
    for (i, near) in like.windows(3).enumerate() {
        lowest = lowest.min(near[0][0]);
        let [mean, error] = near[1];
        if lowest < 0.0 && mean > near[0][0] && mean >= near[2][0] && mean > STANDS_OUT * error {
            return Some((first + i + 1) as f32 * pixel_mm[grain]);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Marks at equal distances have that pitch, the same marks strewn at random have none, and noise is no mark.
    #[test]
    fn a_pitch_is_told_where_marks_have_one() {
        let (size, pixel_mm) = ([500, 300], [0.1, 0.2]);
        let mut state = 9_u32;
        let mut draw = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let noise: Vec<f32> = (0..150_000).map(|_| 0.02 * (draw() - 0.5)).collect();
        let strewn: Vec<f32> = (0..20 * 32).map(|_| 50.0 * draw()).collect();
        let pitch = |place: &dyn Fn(usize, usize) -> f32| {
            let mut light = noise.clone();
            for col in 0..300 {
                for mark in 0..20 {
                    let middle = place(col, mark);
                    for row in 0..500 {
                        light[row * 300 + col] -= 0.1 * libm::expf(-0.5 * ((0.1 * row as f32 - middle) / 0.2).powi(2));
                    }
                }
            }
            marks(&light, size, pixel_mm, &[true; 150_000], false).expect("marks").pitch_mm
        };
        assert!((pitch(&|_, mark| 2.5 * mark as f32).expect("a pitch") - 2.5).abs() < 0.11);
        // A mark is ten columns long, or crosses all.
        assert_eq!(pitch(&|col, mark| strewn[col / 10 * 20 + mark]), None);
        assert_eq!(pitch(&|_, mark| strewn[mark]), None);
        assert_eq!(marks(&noise, size, pixel_mm, &[true; 150_000], false), None);
    }
}
