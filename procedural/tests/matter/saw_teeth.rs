//! Marks of a saw's teeth: height, spacing, slant and length of scores, torn fibre between them, and what both do to
//! light.

use crate::boards::{grow, wood};
use base::{BodyKind, Stream};
use procedural::wood::{Plank, Wood};
use rand::RngExt;

/// A flat board with nothing on it but marks of teeth of drawn numbers; `scores` is their share.
fn toothed(seed: u64, scores: f64) -> Wood {
    let mut wood = wood(0.0, 0.0);
    let mut rng = Stream::root(seed).child("teeth of a test").rng();
    let mut draw = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    (wood.board.saw_ripple_um, wood.board.roughness_um) = (0.0, 0.0);
    (wood.board.cup_mm, wood.board.twist_deg) = (0.0, 0.0);
    let asked = &mut wood.machining;
    (asked.teeth_um, asked.teeth_pitch_mm) = (draw(2.0, 60.0), draw(1.5, 4.0));
    (asked.teeth_slant_deg, asked.teeth_scores) = (draw(-20.0, 20.0), scores);
    asked.teeth_shade = draw(0.01, 0.1);
    wood
}

/// Height over the root mean square that was asked for [1].
fn height(plank: &Plank, wood: &Wood, x: f64, y: f64) -> f64 {
    let z = plank.slice(y as f32).surface(x as f32).expect("inside").z;
    1.0e3 * (f64::from(z) - wood.board.thickness_mm) / wood.machining.teeth_um
}

/// Heights along the board at `x` [mm], `step` apart.
fn column(plank: &Plank, wood: &Wood, x: f64, step: f64) -> Vec<f64> {
    (0..(180.0 / step) as usize).map(|i| height(plank, wood, x, 30.0 + step * i as f64)).collect()
}

fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / n;
    let (a, b) = (mean(&|p| p.0), mean(&|p| p.1));
    let (aa, bb) = (mean(&|p| (p.0 - a).powi(2)), mean(&|p| (p.1 - b).powi(2)));
    mean(&|p| (p.0 - a) * (p.1 - b)) / (aa * bb).sqrt()
}

#[test]
fn marks_are_as_high_as_asked() {
    for scores in [0.0, 0.4, 1.0] {
        let mut all = 0.0;
        for seed in 0..12 {
            let wood = toothed(seed, scores);
            let plank = grow(seed, &wood);
            let own: Vec<f64> = (0..8).flat_map(|i| column(&plank, &wood, 11.0 * f64::from(i) - 40.0, 0.7)).collect();
            let square = own.iter().map(|z| z * z).sum::<f64>() / own.len() as f64;
            // A board shows some ten wide patches, whose heights differ by half more than they are.
            assert!((0.2..2.8).contains(&square), "seed {seed}, scores {scores}: {square}");
            all += square / 12.0;
        }
        // Twelve boards of them: 0.4 over the root of 12, two and a half times that.
        assert!((all - 1.0).abs() < 0.3, "scores {scores}: {all}");
    }
}

/// One score a pass at most, at places that no comb has, and fewer than passes.
#[test]
fn scores_follow_each_other_irregularly_by_the_pitch() {
    for seed in 0..12 {
        let wood = toothed(seed, 1.0);
        let plank = grow(seed, &wood);
        let pitch = wood.machining.teeth_pitch_mm;
        let mut distances = Vec::new();
        for i in 0..6 {
            let z = column(&plank, &wood, 13.0 * f64::from(i) - 33.0, 0.03);
            let peaks: Vec<f64> = (1..z.len() - 1)
                .filter(|&i| z[i] > 0.8 && z[i] >= z[i - 1] && z[i] > z[i + 1])
                .map(|i| 0.03 * i as f64 / pitch)
                .collect();
            distances.extend(peaks.windows(2).map(|pair| pair[1] - pair[0]));
        }
        let n = distances.len() as f64;
        let mean = distances.iter().sum::<f64>() / n;
        let sd = (distances.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / n).sqrt();
        let least = distances.iter().fold(f64::INFINITY, |least, &d| least.min(d));
        // Scores lie in the middle half of their passes, which slant and bend make no shorter than a tenth.
        assert!(least > 0.4, "seed {seed}: {least} passes");
        assert!((1.0..8.0).contains(&mean) && sd > 0.3 * mean, "seed {seed}: {mean} passes, spread {sd}");
        // Steps of half a pass are as likely as whole ones: no comb.
        let whole = distances.iter().filter(|d| (*d - d.round()).abs() < 0.1).count() as f64 / n;
        assert!(whole < 0.55, "seed {seed}: {whole} of the distances are whole passes");
    }
}

/// Scores lie along the asked slant, and end.
#[test]
fn scores_lie_along_their_slant_and_end() {
    for seed in 0..8 {
        let wood = toothed(seed, 1.0);
        let plank = grow(seed, &wood);
        let slope = wood.machining.teeth_slant_deg.to_radians().tan();
        let along = |far: f64, slope: f64| {
            let pair = |i: usize| {
                let (x, y) = (-20.0 + 7.0 * (i % 4) as f64, 45.0 + 0.04 * i as f64);
                (height(&plank, &wood, x, y), height(&plank, &wood, x + far, y - slope * far))
            };
            correlation(&(0..3600).map(pair).collect::<Vec<_>>())
        };
        let [near, aside, far] = [along(2.0, slope), along(2.0, slope + 0.35), along(40.0, slope)];
        assert!(near > 0.7 && aside < 0.4 && far < 0.4, "seed {seed}: {near} along, {aside} beside, {far} far on");
    }
}

/// Power at a wavelength of a series of step 0.1 mm.
fn power(series: &[f64], wavelength: f64) -> f64 {
    let turn = std::f64::consts::TAU * 0.1 / wavelength;
    let (c, s) = series.iter().enumerate().fold((0.0, 0.0), |(c, s), (i, z)| {
        let (sin, cos) = (turn * i as f64).sin_cos();
        (c + z * cos, s + z * sin)
    });
    c * c + s * s
}

/// The passes show in the spectrum along the board by no more than on photographs, where the strongest line between 2
/// and 3.3 mm has 2.3 to 4.2 times the median about it (quartiles of twenty boards).
#[test]
fn no_line_stands_out_of_the_spectrum() {
    let mut found: Vec<f64> = (0..12)
        .map(|seed| {
            let wood = toothed(seed, 0.4);
            let plank = grow(seed, &wood);
            let pitch = wood.machining.teeth_pitch_mm;
            let columns: Vec<Vec<f64>> =
                (0..6).map(|i| column(&plank, &wood, 13.0 * f64::from(i) - 33.0, 0.1)).collect();
            let at = |share: f64| columns.iter().map(|z| power(z, share * pitch)).sum::<f64>();
            let lines: Vec<f64> = (-25..=25).map(|k| at(1.0 + 0.012 * f64::from(k))).collect();
            let mut sorted = lines.clone();
            sorted.sort_by(f64::total_cmp);
            lines[21..30].iter().fold(0.0_f64, |most, &line| most.max(line)) / sorted[25]
        })
        .collect();
    found.sort_by(f64::total_cmp);
    assert!(found[6] < 4.2, "{found:?}");
}

/// Hollows take light by the asked share, raised fibre throws some back and mirrors less; without a share hollows take
/// none.
#[test]
fn torn_fibre_shades_and_throws_light_back() {
    for seed in 0..8 {
        let wood = toothed(seed, 0.3);
        let mut open = wood;
        open.machining.teeth_shade = 0.0;
        let (plank, open) = (grow(seed, &wood), grow(seed, &open));
        let (mut pairs, mut taken, mut raised) = (Vec::new(), 0.0, 0.0);
        for i in 0..2500 {
            let (x, y) = (-40.0 + 1.6 * f64::from(i % 50), 35.0 + 0.07 * f64::from(i));
            let (n, slice) = (height(&plank, &wood, x, y), plank.slice(y as f32));
            let medium = slice.matter(x as f32, wood.board.thickness_mm as f32).medium;
            let other = open.slice(y as f32).matter(x as f32, wood.board.thickness_mm as f32).medium;
            assert_eq!((other.coat, other.gloss), (1.0, medium.gloss));
            assert!(medium.coat > 0.0 && medium.coat <= 1.0);
            // Heights are known to a millionth of the thickness.
            if (n - 1.0).abs() > 0.01 {
                assert_eq!(medium.gloss.matte > 0.0, n > 1.0, "{n}");
                assert_eq!(f64::from(medium.gloss.share) < wood.media.gloss - 1.0e-6, n > 1.0, "{n}");
            }
            pairs.push((n, f64::from(medium.coat)));
            taken += f64::from(1.0 - medium.coat) / wood.machining.teeth_shade / 2500.0;
            raised += f64::from(u8::from(n > 1.0)) / 2500.0;
        }
        // Two heights in the mean, less what no hollow has and more where patches are dark.
        assert!((1.3..2.7).contains(&taken), "seed {seed}: {taken}");
        assert!((0.01..0.3).contains(&raised), "seed {seed}: {raised}");
        assert!(correlation(&pairs) > 0.5, "seed {seed}: {}", correlation(&pairs));
    }
}
