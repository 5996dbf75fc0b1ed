//! Reflection and transmission of a thin scattering film: the measurements behind
//! [`kernel::film_stack::table`](transport::kernel::film_stack::table), and how they become its entries.
//!
//! A plane slab of thickness 1 in air, index n, whose pigment scatters by Henyey and Greenstein's law with mean cosine
//! [`PIGMENT_G`], is walked without absorption in these ways: light from straight above that has entered, Lambert
//! light, and light from straight above with each of some foils below. Absorption takes exp(-mu_a path) of what leaves
//! after a path, so all absorptions come from the same walk. Light that pigment turned is counted apart from light that
//! it did not.
//!
//! Where light leaves is kept as a transform, the mean of cos(k x), for a grid of frequencies k in units of 1 /
//! thickness; x and y serve alike. Valid and neglected as in `reference::path::plane_layers`.

use base::Stream;
use glam::DVec3;
use rayon::prelude::*;

use reference::path::plane_layers::{PreparedLayer, StackGeometry, StackObserver};
use reference::path::tracker::{Geometry, Photon};
use reference::phase::disc;
use transport::fresnel::fresnel_dielectric;
use transport::kernel::film_stack::table::{EXIT_BINS, NODE, SEALED_NODE, TABLE_FREQUENCIES, transmission_scale};
use transport::stack::{Foil, PIGMENT_G, Scattering, Stack, Substrate};

/// Independent batches.
const FILM_BATCHES: u64 = 32;

/// A film in units of its thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredFilm {
    /// Refractive index [1].
    pub n: f64,
    /// Reduced scattering times thickness [1].
    pub turns: f64,
}

/// Light that leaves one side of a film after it was turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmSide {
    /// Transform of where it leaves; the total where the frequency is 0 [1].
    pub spread: [f64; TABLE_FREQUENCIES],
    /// Total [1].
    pub total: f64,
    /// Part of it in each bin of directions [1].
    pub directions: [f64; EXIT_BINS],
    /// Transform of the slope of its direction along one axis, horizontal over vertical [1].
    pub slopes: [f64; TABLE_FREQUENCIES],
}

impl Default for FilmSide {
    fn default() -> Self {
        let none = [0.0; TABLE_FREQUENCIES];
        Self { spread: none, total: 0.0, directions: [0.0; EXIT_BINS], slopes: none }
    }
}

/// What becomes of light, per photon, for one absorption.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FilmResponse {
    /// Leaves upwards, turned.
    pub up: FilmSide,
    /// Leaves downwards, turned.
    pub down: FilmSide,
    /// Leaves upwards without having been turned, the first surface's share included [1].
    pub straight_up: f64,
    /// Leaves downwards without having been turned [1].
    pub straight_down: f64,
}

/// How light comes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FilmIllumination {
    /// From straight above, per photon that entered.
    Straight,
    /// From everywhere above by Lambert's law, per photon that arrived.
    Lambert,
    /// As `Straight`, this foil below.
    Sealed(Foil),
}

struct FilmObserver<'a> {
    frequencies: &'a [f64; TABLE_FREQUENCIES],
    absorptions: &'a [f64],
    turned: bool,
    responses: Vec<FilmResponse>,
}

impl StackObserver for FilmObserver<'_> {
    fn collide(&mut self, _: &Photon, _: &PreparedLayer, _: &mut impl rand::Rng) {
        self.turned = true;
    }

    fn absorb(&mut self, _: usize, _: f64) {}

    fn leave(&mut self, photon: &Photon) {
        let up = photon.direction.z > 0.0;
        let kept = |absorption: f64| photon.weight * libm::exp(-absorption * photon.path);
        if !self.turned {
            for (response, &absorption) in self.responses.iter_mut().zip(self.absorptions) {
                *(if up { &mut response.straight_up } else { &mut response.straight_down }) += kept(absorption);
            }
            return;
        }
        let mean = |k: f64, a: f64, b: f64| 0.5 * (libm::cos(k * a) + libm::cos(k * b));
        let (position, direction) = (photon.position, photon.direction);
        let spread = self.frequencies.map(|k| mean(k, position.x, position.y));
        let (along, across) = (direction.x / direction.z, direction.y / direction.z);
        let slopes = if up { [0.0; TABLE_FREQUENCIES] } else { self.frequencies.map(|k| mean(k, along, across)) };
        let bin = ((1.0 - direction.z * direction.z) * EXIT_BINS as f64) as usize;
        for (response, &absorption) in self.responses.iter_mut().zip(self.absorptions) {
            let weight = kept(absorption);
            let side = if up { &mut response.up } else { &mut response.down };
            side.total += weight;
            side.directions[bin.min(EXIT_BINS - 1)] += weight;
            for i in 0..TABLE_FREQUENCIES {
                side.spread[i] += weight * spread[i];
                side.slopes[i] += weight * slopes[i];
            }
        }
    }
}

/// Walks `photons` for each of `absorptions` [1 / thickness] at once.
pub fn measure(
    slab: MeasuredFilm,
    light: FilmIllumination,
    frequencies: &[f64; TABLE_FREQUENCIES],
    absorptions: &[f64],
    photons: u64,
    seed: u64,
) -> Vec<FilmResponse> {
    let pigment = Scattering::Isotropic { mu_s: slab.turns / (1.0 - PIGMENT_G), g: PIGMENT_G };
    let mut stack = Stack::slab(1.0, slab.n, 0.0, pigment);
    if let FilmIllumination::Sealed(foil) = light {
        stack.below = Substrate::Foil(foil);
    }
    let geometry = StackGeometry::new(&stack, f64::INFINITY);
    let each = photons.div_ceil(FILM_BATCHES);
    let batches: Vec<Vec<FilmResponse>> = (0..FILM_BATCHES)
        .into_par_iter()
        .map(|batch| {
            let mut rng = Stream::root(seed).child("transport").child("film").index(batch).rng();
            let responses = vec![FilmResponse::default(); absorptions.len()];
            let mut sums = FilmObserver { frequencies, absorptions, turned: false, responses };
            for _ in 0..each {
                let (mut direction, mut weight) = (DVec3::NEG_Z, 1.0);
                if light == FilmIllumination::Lambert {
                    let (x, y, s) = disc(&mut rng);
                    let (thrown, cosine) = fresnel_dielectric(1.0, slab.n, (1.0 - s).sqrt());
                    sums.responses.iter_mut().for_each(|response| response.straight_up += thrown);
                    (direction, weight) = (DVec3::new(x / slab.n, y / slab.n, -cosine), 1.0 - thrown);
                }
                sums.turned = false;
                let position = DVec3::ZERO;
                let photon = Photon { position, direction, weight, layer: 0, path: 0.0, turned: 0, guided: 0 };
                geometry.track(photon, &mut sums, &mut rng);
            }
            sums.responses
        })
        .collect();
    let share = 1.0 / (each * FILM_BATCHES) as f64;
    (0..absorptions.len()).map(|a| mean(batches.iter().map(|responses| &responses[a]), share)).collect()
}

/// Sum of batches times `share`.
fn mean<'a>(batches: impl Iterator<Item = &'a FilmResponse>, share: f64) -> FilmResponse {
    let mut sum = FilmResponse::default();
    let add = |sum: &mut FilmSide, side: &FilmSide| {
        sum.total += share * side.total;
        for i in 0..TABLE_FREQUENCIES {
            sum.spread[i] += share * side.spread[i];
            sum.slopes[i] += share * side.slopes[i];
        }
        for i in 0..EXIT_BINS {
            sum.directions[i] += share * side.directions[i];
        }
    };
    for response in batches {
        add(&mut sum.up, &response.up);
        add(&mut sum.down, &response.down);
        sum.straight_up += share * response.straight_up;
        sum.straight_down += share * response.straight_down;
    }
    sum
}

/// Radiance factor of each bin, against Lambert's law.
fn law(side: &FilmSide) -> [f64; EXIT_BINS] {
    let even = side.total / EXIT_BINS as f64;
    if side.total > 1e-6 { side.directions.map(|part| part / even) } else { [1.0; EXIT_BINS] }
}

/// The table's entry for a film in air that was measured under straight light and under Lambert light.
pub fn condense(turns: f64, straight: &FilmResponse, lambert: &FilmResponse) -> [f32; NODE] {
    let scale = transmission_scale(turns);
    let down = straight.down;
    // A clear film turns nothing; then it does not matter how.
    let slopes = if down.total > 1e-6 { down.slopes.map(|slope| slope / down.total) } else { [1.0; TABLE_FREQUENCIES] };
    let transforms = [
        straight.up.spread,
        down.spread.map(|part| part * scale),
        lambert.up.spread.map(|part| part + lambert.straight_up),
        lambert.down.spread.map(|part| part * scale),
        slopes,
    ];
    let laws = [law(&straight.up), law(&lambert.down)];
    let mut values = transforms.into_iter().flatten().chain(laws.into_iter().flatten()).chain([lambert.straight_down]);
    std::array::from_fn(|_| values.next().expect("a node has as many numbers") as f32)
}

/// The table's entry for a film that was measured sealed to foil.
pub fn condense_sealed(sealed: &FilmResponse) -> [f32; SEALED_NODE] {
    let mut values = sealed.up.spread.into_iter().chain(law(&sealed.up)).chain([sealed.straight_up]);
    std::array::from_fn(|_| values.next().expect("a node has as many numbers") as f32)
}
