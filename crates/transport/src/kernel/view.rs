//! Light towards a view: radiance factors, and how far beside light to all sides it leaves; of cone light and of the
//! rest, by length of path.
//!
//! Cone light keeps its angle to the fibre. For light from above and fibres f that dive by d, with v' the direction
//! inside that refraction turns into the view v, it would leave where c = v' . f - sin(d) is 0; dispersion blurs that.
//! Fitted to what Monte Carlo measures, with s the part of v along the fibre's track (positive on its diving side), x
//! the part across it and u its height:
//!
//! ```text
//! factor of cone light    exp( a0 + a1 c + a2 c^2 + a3 (1 - u) )
//! factor of the rest      a0 + a1 s + a2 s^2 + a3 x^2
//! shift along the track   b0 + b1 s
//! shift across it         b2 x
//! variance along it       d0 + d1 s, of that of light to all sides
//! variance across it      d2, of that of light to all sides
//! ```
//!
//! A Lambertian surface has the factor 1 everywhere. Beyond 53 degrees the factors fall as the law of exit does and not
//! as their formulas (`grazing`). Light that leaves towards the lens was on its way there when it
//! was last turned, below and behind the point of exit: that is the shift. It grows with the path until the light has
//! forgotten where it came from. The last runs of light to all sides spread it by their directions and lengths, those
//! of light to one view by their lengths alone: light to a view lies narrower beside the line, down to half, and where
//! fibres dive away from the view wider.
//!
//! Light that was turned once leaves near the lens, what was turned more often lies around it in a wide tail: after 0.2
//! to 20 mean free paths a bin of the rest is skewed. It stands as two Gaussians of half its light, the one nearer to
//! the lens narrow and the other one wide (`SkewedBin`).
//!
//! Each kind has [`KIND_GROUPS`] groups of two bins of path lengths with coefficients of their own, so that absorption,
//! which takes long paths, changes where light goes by itself. Bins beyond the walked ones are like the last group.

use numerics::lanes::exp;

use crate::fresnel::fresnel_dielectric;

/// Bins of path lengths of light that met cylinders alone.
pub const CONE_BINS: usize = 14;
/// Groups of path lengths of either kind of light.
pub const KIND_GROUPS: usize = CONE_BINS / 2;
/// Lanes of groups: cone light in the first half, the rest in the second, each padded.
pub const VIEW_LANES: usize = 16;
/// Coefficients of a group: four of the factor, three of the shift, three of the variance.
pub const VIEW_TERMS: usize = 10;

/// Third central moments of light of the rest to a view, along the motion, over its shift and its variance, by group
/// from the second on. `make kernel-table` tells them from the table's own walks, where they go with shift times
/// variance by correlations of 0.73, 0.85, 0.80 and 0.57. Later groups have next to none [1].
const SKEWNESS: [f32; 4] = [-0.84, -0.87, -0.6, -0.29];
/// Half of the way between both halves of a skewed bin, over its shift [1].
const HALVES_APART: f32 = 0.5;
/// Most of a variance that is between the halves [1].
const MOST_BETWEEN: f32 = 0.3;
/// Least part of a variance that is left to the nearer half [1].
const LEAST_VARIANCE: f32 = 0.1;
/// First of the table's bins that are skewed.
pub(crate) const FIRST_SKEWED: usize = CONE_BINS + 2;
/// Skewed bins.
pub(crate) const SKEWED_BINS: usize = 2 * SKEWNESS.len();

/// A skewed bin as two Gaussians of half its light each.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SkewedBin {
    /// Where the half lies that is nearer to the lens, beside the middle of both; the other one lies as far on the
    /// other side.
    pub nearer: f32,
    /// Variances of the nearer half and of the other one.
    pub variances: [f32; 2],
}

impl SkewedBin {
    /// Of skewed bin `number` with this `shift` and `variance`, of the same mean, variance and third moment.
    #[inline(always)]
    pub(crate) fn new(number: usize, shift: f32, variance: f32) -> Self {
        let nearer = HALVES_APART * shift;
        let within = variance - (nearer * nearer).min(MOST_BETWEEN * variance);
        let apart = variance * SKEWNESS[number / 2] / (3.0 * HALVES_APART);
        let near = (within + apart).max(LEAST_VARIANCE * variance);
        Self { nearer, variances: [near, 2.0 * within - near] }
    }
}

/// Variances of light to a view over those of light to all sides are kept between these [1].
const VARIANCE_RANGE: (f32, f32) = (0.1, 3.0);

/// Logarithms of radiance factors of cone light are kept between these [1].
const CONE_LOGARITHM_RANGE: (f32, f32) = (-12.0, 2.5);

/// Cosines of 25 and 53 degrees, where straight lines fitted to the law of exit up to 60 degrees meet it [1].
const FITTED_UP: [f32; 2] = [0.9063, 0.6018];
/// Two thirds of diffusion's boundary factor A(n) as a polynomial of n - 1, within 1.5 % [1].
const BOUNDARY: [f32; 3] = [0.667, 2.13, 2.73];

/// Radiance towards a view under cosine `up` out of matter of index `n` where light goes all ways (diffusion at a
/// plane), up to a factor: what Fresnel's law lets out of 2/3 A + mu under cosine mu inside [1].
fn law_of_exit(up: f32, n: f32) -> f32 {
    let (thrown, inside) = fresnel_dielectric(1.0, n.into(), up.max(0.0).into());
    let [constant, linear, square] = BOUNDARY;
    let m = n - 1.0;
    (1.0 - thrown as f32) * (constant + m * (linear + m * square) + inside as f32)
}

/// Radiance towards a view under cosine `up` over what formulas have that were fitted to tilts up to 60 degrees: a
/// straight line in the square of the sine, where the surface lets less out the flatter light leaves [1].
#[inline(always)]
pub(crate) fn grazing(up: f32, n: f32) -> f32 {
    let [near, far] = FITTED_UP;
    if up >= far {
        return 1.0;
    }
    let [at, high, low] = [up, near, far].map(|up| law_of_exit(up, n));
    let beyond = (near * near - up * up) / (near * near - far * far);
    at / (high + (low - high) * beyond)
}

/// Lane of the group of a bin, counted from the first of its kind.
#[inline(always)]
pub const fn view_group(cone: bool, bin: usize) -> usize {
    let group = if bin / 2 < KIND_GROUPS { bin / 2 } else { KIND_GROUPS - 1 };
    if cone { group } else { VIEW_LANES / 2 + group }
}

/// Lane of the group of a bin of the table, cone light first.
#[inline(always)]
pub(crate) const fn group_of(bin: usize) -> usize {
    if bin < CONE_BINS { view_group(true, bin) } else { view_group(false, bin - CONE_BINS) }
}

/// What goes to a view, by group.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Towards {
    /// Radiance factor [1].
    pub factor: [f32; VIEW_LANES],
    /// Shift along the motion against light to all sides [mean free paths].
    pub shift: [f32; VIEW_LANES],
    /// Its variance along the fibres' track over that of light to all sides [1].
    pub along: [f32; VIEW_LANES],
    /// The same across the track [1].
    pub across: [f32; VIEW_LANES],
}

/// Coordinates of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Change of the cosine to the fibre [1].
    pub cone: f32,
    /// Along the fibre's track, towards its diving end [1].
    pub along: f32,
    /// Cosine against the normal [1].
    pub up: f32,
}

impl View {
    /// A view with part `along` and `up` onto matter of index `n` with fibres of sine of dive `sin_dive`.
    #[inline(always)]
    pub fn new(along: f32, up: f32, n: f32, sin_dive: f32) -> Self {
        let inside = (1.0 - (1.0 - up * up) / (n * n)).max(0.0).sqrt();
        let cos_dive = (1.0 - sin_dive * sin_dive).max(0.0).sqrt();
        Self { cone: along / n * cos_dive - inside * sin_dive - sin_dive, along, up }
    }

    /// Terms that the coefficients of cone light multiply.
    #[inline(always)]
    pub fn cone_terms(self) -> [f32; 4] {
        [1.0, self.cone, self.cone * self.cone, 1.0 - self.up]
    }

    /// Terms that the coefficients of the rest multiply.
    #[inline(always)]
    pub fn rest_terms(self) -> [f32; 4] {
        let s2 = self.along * self.along;
        [1.0, self.along, s2, (1.0 - self.up * self.up - s2).max(0.0)]
    }

    /// Radiance factor of the rest by its coefficients [1].
    #[inline(always)]
    pub(crate) fn rest(self, coefficients: [f32; 4]) -> f32 {
        weighed(coefficients, self.rest_terms()).max(0.0)
    }

    /// What goes to this view by a table's coefficients out of matter of index `n`; the track makes an angle of cosine
    /// `cos_azimuth` with the motion, along which the view has the part `motion`.
    #[inline(always)]
    pub(crate) fn towards(
        self,
        terms: &[[f32; VIEW_LANES]; VIEW_TERMS],
        n: f32,
        cos_azimuth: f32,
        motion: f32,
    ) -> Towards {
        let (cone, rest) = (self.cone_terms(), self.rest_terms());
        let beside = motion - self.along * cos_azimuth;
        let (least, most) = VARIANCE_RANGE;
        let grazing = grazing(self.up, n);
        let mut to = Towards {
            factor: [0.0; VIEW_LANES],
            shift: [0.0; VIEW_LANES],
            along: [0.0; VIEW_LANES],
            across: [0.0; VIEW_LANES],
        };
        for lane in 0..VIEW_LANES / 2 {
            let logarithm = weighed([terms[0][lane], terms[1][lane], terms[2][lane], terms[3][lane]], cone);
            to.factor[lane] = grazing * exp(logarithm.clamp(CONE_LOGARITHM_RANGE.0, CONE_LOGARITHM_RANGE.1));
        }
        for lane in VIEW_LANES / 2..VIEW_LANES {
            let factor = weighed([terms[0][lane], terms[1][lane], terms[2][lane], terms[3][lane]], rest);
            to.factor[lane] = grazing * factor.max(0.0);
        }
        for lane in 0..VIEW_LANES {
            to.shift[lane] = cos_azimuth * (terms[4][lane] + terms[5][lane] * self.along) + terms[6][lane] * beside;
            to.along[lane] = (terms[7][lane] + terms[8][lane] * self.along).max(least).min(most);
            to.across[lane] = terms[9][lane].max(least).min(most);
        }
        to
    }
}

#[inline(always)]
fn weighed(coefficients: [f32; 4], terms: [f32; 4]) -> f32 {
    coefficients[0] * terms[0] + coefficients[1] * terms[1] + coefficients[2] * terms[2] + coefficients[3] * terms[3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fresnel::boundary_factor;

    /// The law of exit is Fresnel's and diffusion's, and what the table's formulas make of it, fitted to its tilts by
    /// its weights, is off by as much as `grazing` says, within 1.5 %.
    #[test]
    fn formulas_leave_the_law_of_exit_where_light_grazes() {
        let tilts = [(10.0, 1.0), (25.0, 3.0), (40.0, 1.0), (60.0, 0.3)].map(|(tilt, seen): (f64, f64)| {
            let (sin, cos) = libm::sincos(tilt.to_radians());
            (sin * sin, cos as f32, sin * cos * seen)
        });
        for n in [1.0f32, 1.06, 1.12, 1.18, 1.25, 1.33, 1.4, 1.48, 1.55] {
            let boundary = 2.0 / 3.0 * boundary_factor(n.into());
            let told = f64::from(law_of_exit(1.0, n)) / (1.0 - fresnel_dielectric(1.0, n.into(), 1.0).0) - 1.0;
            assert!((told / boundary - 1.0).abs() < 0.015, "{n}: {told} for {boundary}");
            let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
                tilts.iter().map(|&(x, up, weight)| weight * of(x, law_of_exit(up, n).into())).sum()
            };
            let [one, x, xx, y, xy] =
                [sum(&|_, _| 1.0), sum(&|x, _| x), sum(&|x, _| x * x), sum(&|_, y| y), sum(&|x, y| x * y)];
            let slope = (one * xy - x * y) / (one * xx - x * x);
            for tilt in 0..85 {
                let (sin, cos) = libm::sincos(f64::from(tilt).to_radians());
                let fitted = (y - slope * x) / one + slope * sin * sin;
                let law = f64::from(law_of_exit(cos as f32, n));
                let told = f64::from(grazing(cos as f32, n));
                assert!((fitted * told / law - 1.0).abs() < 0.015, "{n}, {tilt} degrees: {told}");
            }
        }
    }
}
