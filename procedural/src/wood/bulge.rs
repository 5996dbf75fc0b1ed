//! How growth layers bulge around a knot: the time-of-growth field.
//!
//! Models: t is the radius that the trunk had when a point grew [mm]; annual rings are its level sets. Far from knots t
//! is the distance r from the pith. Near a knot trunk and branch merge by a smooth minimum of their times,
//!
//! ```text
//! smin(1, x) = (1 + x^-k)^(-1/k),  k = 3.25 - 0.8 (x - 1) / (x - 0.7)
//! ```
//!
//! Here x is the distance from the axis over the knot's half width, 1 on its outline and beyond it measured 1.6 times
//! shorter along the grain, and
//!
//! ```text
//! t = r - f h w (1 - smin),  w = (1 - u^2)^3,  u = (x - 1) / 3,  h = 2.5 half widths
//! ```
//!
//! The slope of t, which is the fibre's dive on a flat-sawn face, falls steadily from 21 deg at the knot to 3 deg three
//! half widths along the grain from its outline, and without a step to 0 at x = 4. After the branch's death f falls
//! from 1 to -1/2: rings stop bulging outwards and bend in around the stub. Source: Larsson et al. (2022) for the
//! merging and f. Their k falls by 1.75 instead of 0.8, and their bulge scales with the trunk's radius; here it scales
//! with the knot's and ends sooner, so that small knots bend few rings. Limits: inside a knot the branch's own rings
//! replace this field. A knot's height is drawn about this law, and its layers lean along the grain besides (`growth`).

/// Largest distance from the axis at which a knot disturbs wood [half widths across, 1.6 times as many along].
pub(super) const REACH: f32 = 4.0;
/// Where the flow of fibres around the knot begins to fade [half widths].
const FADE_FROM: f32 = 1.5;
/// The disturbance is longer along the grain than across by this [1]; chosen by eye on flat-sawn spruce.
pub(super) const ASPECT: f32 = 1.6;
/// What that leaves of a square along the grain [1].
pub(super) const SHORTEN: f32 = 1.0 / (ASPECT * ASPECT);
/// Distance from the axis within which only the branch has fibres, whatever its outline's wobble [half widths].
const INSIDE: f32 = 0.8;
/// Height of the merging over the knot's half width [1]; the bulge at the knot is a fifth of it.
const HEIGHT: f32 = 2.5;
/// Growth of the trunk after the branch's death at which bulging turns into bending in [mm]: an eighth of 120 mm.
const DEATH_SCALE_MM: f32 = 15.0;
/// Entries of the table.
const STEPS: usize = 256;

/// The merging of trunk and branch, tabulated over the distance from the axis.
#[derive(Debug, Clone)]
pub(super) struct Bulge {
    /// w (1 - smin), its slope over the distance, and the weight of the flow around the knot, in equal steps.
    table: Vec<[f32; 3]>,
    /// One over the depth at the knot's outline [1].
    per_rim: f32,
}

/// Where a point lies in the bulge of a knot.
#[derive(Debug, Clone, Copy)]
pub(super) struct BulgePlace {
    /// Distance from the axis: 1 on the outline all around, from where it grows by [`ASPECT`] more slowly along the
    /// grain
    /// [half widths].
    pub x: f32,
    /// Slope of x over the offset from the axis, times x: parts of that offset, and of the offset shortened along the
    /// grain
    /// [1 / half width].
    pub steepness: [f32; 2],
    /// Slope of x over the half width's logarithm, times -x [1].
    pub widened: f32,
}

impl BulgePlace {
    /// At `whole` half widths from the axis, which are `shortened` where lengths along the grain count less.
    #[inline]
    pub fn of(whole: f32, shortened: f32) -> Self {
        // Within the outline, wobble and all, nothing but the branch has a fibre: there x is even in scale.
        if whole < INSIDE {
            let (on_whole, on_shortened) = (1.0 / INSIDE, 1.0 - 1.0 / INSIDE);
            let x = on_whole * whole + on_shortened * shortened;
            let steepness = [x * on_whole / whole.max(f32::EPSILON), x * on_shortened / shortened.max(f32::EPSILON)];
            return Self { x, steepness, widened: x * x };
        }
        let per_whole = 1.0 / whole;
        let x = 1.0 + shortened - shortened * per_whole;
        let steepness = [x * shortened * per_whole * per_whole * per_whole, x * (1.0 - per_whole) / shortened];
        Self { x, steepness, widened: x * shortened }
    }
}

/// The merging at one distance from the axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct BulgeMerge {
    /// Depth of the bulge over its height [1].
    pub depth: f32,
    /// Slope of that depth over x, divided by x [1].
    pub slope_over_x: f32,
    /// Weight of the flow of fibres around the knot, 1 near and 0 at the reach [1].
    pub weight: f32,
}

fn depth(x: f64) -> f64 {
    let k = 3.25 - 0.8 * (x - 1.0) / (x - 0.7);
    let u = ((x - 1.0) / (f64::from(REACH) - 1.0)).clamp(0.0, 1.0);
    (1.0 - u * u).powi(3) * (1.0 - libm::pow(1.0 + libm::pow(x, -k), -1.0 / k))
}

fn weight(x: f64) -> f64 {
    let u = ((x - f64::from(FADE_FROM)) / f64::from(REACH - FADE_FROM)).clamp(0.0, 1.0);
    1.0 - u * u * u * (u * (6.0 * u - 15.0) + 10.0)
}

impl Bulge {
    /// Tabulates the merging.
    pub fn new() -> Self {
        let h = 1.0e-5;
        let slope = |x: f64| (depth(x + h) - depth(x - h)) / (2.0 * h);
        // Within one half width the depth levels off to the axis, as the surface does that joins the knot's sides.
        let (rim, rim_slope) = (depth(1.0 + 2.0 * h), slope(1.0 + 2.0 * h));
        let table = (0..=STEPS + 1).map(|i| {
            let x = i as f64 * f64::from(REACH) / STEPS as f64;
            if x < 1.0 {
                [(rim + 0.5 * rim_slope * (x * x - 1.0)) as f32, rim_slope as f32, 1.0]
            } else {
                [depth(x) as f32, (slope(x.max(1.0 + 2.0 * h)) / x) as f32, weight(x) as f32]
            }
        });
        Self { table: table.collect(), per_rim: (1.0 / rim) as f32 }
    }

    /// One over the depth at a knot's outline [1].
    pub fn per_rim(&self) -> f32 {
        self.per_rim
    }

    /// How much the order of fibres is disturbed: the root of a bulge's depth over that at the knot's outline, 1 inside
    /// of it; by eye, so that the flame of light on fibres that dive neither stands out nor makes way for a halo [1].
    #[inline]
    pub fn disorder(&self, merge: &BulgeMerge) -> f32 {
        (merge.depth * self.per_rim).clamp(0.0, 1.0).sqrt()
    }

    /// The merging at `x` half widths from the axis, below the reach.
    #[inline]
    pub fn at(&self, x: f32) -> BulgeMerge {
        let at = x * (STEPS as f32 / REACH);
        let i = (at as usize).min(STEPS);
        let w = at - i as f32;
        let (a, b) = (self.table[i], self.table[i + 1]);
        let mix = |n: usize| a[n] + w * (b[n] - a[n]);
        BulgeMerge { depth: mix(0), slope_over_x: mix(1), weight: mix(2) }
    }
}

/// Height of a bulge [mm] around a knot of that half width [mm], and its slope over the distance from the pith [1];
/// `beyond` is how far the trunk has grown since the branch died [mm], negative while it lived.
#[inline]
pub(super) fn height(half_width: f32, widening: f32, beyond: f32) -> (f32, f32) {
    if beyond <= 0.0 {
        return (HEIGHT * half_width, HEIGHT * widening);
    }
    let q = beyond / DEATH_SCALE_MM - 1.0;
    let away = 0.3 + q.abs();
    // At death q = -1 and the factor is 1 but for the constant that makes it so exactly.
    let (turn, most) = (0.85, 1.0 / 1.3);
    let factor = 1.0 - turn * (most + q / away);
    let slope = -turn * 0.3 / (away * away * DEATH_SCALE_MM);
    (HEIGHT * half_width * factor, HEIGHT * (widening * factor + half_width * slope))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bulge_at_the_knot_is_the_smooth_minimum_of_equal_times() {
        let merge = Bulge::new().at(1.0);
        assert!((merge.depth - (1.0 - 2.0_f32.powf(-1.0 / 3.25))).abs() < 2.0e-3, "{merge:?}");
        let end = Bulge::new().at(REACH - 1.0e-4);
        assert!(end.depth.abs() < 1.0e-6 && end.weight.abs() < 1.0e-6);
    }

    #[test]
    fn the_dive_falls_steadily_and_is_small_two_diameters_along_the_grain() {
        let bulge = Bulge::new();
        let dive = |x: f32| (HEIGHT / ASPECT * bulge.at(x).slope_over_x * x).abs().atan().to_degrees();
        let dives: Vec<f32> = (0..=60).map(|i| dive(1.0 + 0.05 * (i as f32 - 0.01).max(0.1))).collect();
        assert!(dives.windows(2).all(|w| w[1] < w[0] && w[0] - w[1] < 1.5), "an outline shows: {dives:?}");
        assert!(dives[0] < 25.0 && dive(1.0 + 3.0 / ASPECT) < 3.5 && dive(3.0) < 2.0, "{dives:?}");
    }

    #[test]
    fn the_slope_is_the_derivative() {
        let bulge = Bulge::new();
        let h = 2.0 * REACH / STEPS as f32;
        for i in 4..250 {
            let x = i as f32 * REACH / STEPS as f32;
            let numeric = (bulge.at(x + h).depth - bulge.at(x - h).depth) / (2.0 * h);
            // The curvature jumps at the rim; elsewhere the error is h^2/6 times a third derivative of about 2.
            let bound = if (x - 1.0).abs() < 2.0 * h { 0.01 } else { 2.0e-3 };
            assert!((numeric - bulge.at(x).slope_over_x * x).abs() < bound, "at {x}");
        }
    }

    #[test]
    fn a_dead_branch_bends_rings_in() {
        assert_eq!(height(6.0, 0.1, -1.0), (15.0, 0.25));
        let (at_death, _) = height(6.0, 0.0, 1.0e-4);
        assert!((at_death - 15.0).abs() < 1.0e-3);
        let (late, _) = height(6.0, 0.0, 1.0e4);
        assert!((late / 15.0 + 0.5).abs() < 5.0e-3, "late factor {}", late / 15.0);
        for beyond in [5.0, 14.0, 16.0, 40.0] {
            let numeric = (height(6.0, 0.0, beyond + 0.01).0 - height(6.0, 0.0, beyond - 0.01).0) / 0.02;
            assert!((numeric - height(6.0, 0.0, beyond).1).abs() < 2.0e-3);
        }
    }
}
