//! Adding method for a film over air and tablet, or over foil, as production uses it.
//!
//! Each layer answers for itself ([`table`]: films, measured by Monte Carlo; the half space's own table: tablets), and
//! light that passes from one to the next loses its direction: it leaves by Lambert's law. In the space of frequencies
//! q along the motion (`spectrum`) spreads one after the other are products, and all bounces between film and what lies
//! below are a geometric series (van de Hulst 1980). Let T0 be the straight light that a film lets through, R and T
//! what it reflects and lets through turned (small letters: of Lambert light). With h and g the spread of light from
//! the film and of Lambert light over the gap, B what a tablet sends out again, m the share that a surface mirrors:
//!
//! ```text
//! down   A = T0 / (1 - rho m0), rho what the film's two surfaces throw down again of straight light from below
//! loop   L = (1 - m) B g^2 + m g(2 d)
//! up     X = [(1 - m0) A B g + T ((1 - m) B h g + m h(2 d)) + (1 - F) R Y L] / (1 - r L)
//! mirror Y = m0 A, spread by the roughness of foil: 2 d alpha for d in g, about the same law (GGX, Walter et al. 2007)
//! film   R + (1 - F) T Y + t X
//! below  B [(1 - m0) A + (1 - m) (T h + ((1 - F) R Y + r X) g)], seen through the film
//! ```
//!
//! Valid for plane parallel layers whose films are wide against gap and thickness, light from straight above; of light
//! that meets a slope the straight part is what is left of its longer way. Neglected: walls of pockets, tilt of film
//! against tablet, direction of light after its first bounce, the change of exit angles with distance.

mod adding;
mod answer;
mod film;
pub mod paths;
mod sealed;
mod shares;
mod single_scattering;
mod spectrum;
pub mod table;
mod underlayer;

use std::sync::LazyLock;

use base::Medium;
use multiversion::multiversion;

use self::adding::{FilmFlow, StackTables, flow};
pub(super) use self::answer::{film_stack, solve};
use self::film::in_film;
pub use self::film::{FACET_TURN, FilmStack, mirrored_depth_mm, mirrored_view, passed_unturned, under_normal};
pub use self::shares::FilmShares;
use self::single_scattering::turned_depth;
use self::spectrum::WidthFit;
use super::widths::{BASIS, PACK_SPREAD_MM};

/// What a film does to a line of light: two patterns on the fixed widths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmStackSpread {
    /// Square root of each width's weight, of light that leaves from the film [1].
    pub enter: [f32; BASIS],
    /// The same times the film's radiance factor [1].
    pub exit: [f32; BASIS],
    /// Share of that which has never been below the film, by width; 1 but over pockets [1].
    pub alone: [f32; BASIS],
    /// Radiance factor, towards the lens, of light from all sides below that the film turns on its way out [1].
    pub through: f32,
    /// Weight of each width times radiance factor, of light that what lies below sends towards the lens: it is seen
    /// where it left the surface below [1].
    pub below: [f32; BASIS],
    /// Share of that which the film has not thrown down again, by width; 1 but over pockets [1].
    pub below_first: [f32; BASIS],
    /// Radiance factor of light from all sides that what lies below throws to the lens, over its reflectance [1].
    pub below_law: f32,
    /// How far along the motion the lens sees light of each width leave the film beside where it leaves towards all
    /// sides [mm].
    pub film_beside: [f32; BASIS],
    /// How far along the motion that light leaves the surface below beside light to all sides [mm].
    pub below_beside: f32,
    /// Radiance factor, before it passes the film again, of light that pigment has turned on its way down and that foil
    /// mirrors to the lens: the film's lower side, as foil shows it [1].
    pub mirrored: f32,
    /// Its standard deviation along the motion, by the foil's roughness [mm].
    pub mirrored_mm: f32,
    /// Share of the light from below which passes the film without being turned [1].
    pub passes: f32,
    /// Share of light from all sides that the film throws back into the room below [1].
    pub holds: f32,
}

/// Answers for film stacks, one after the other. It remembers what the last ones were made of, which saves time and
/// changes no bit of an answer.
#[derive(Debug, Clone)]
pub struct FilmStackKernel {
    tables: StackTables,
    back: WidthFit,
}

impl FilmStackKernel {
    /// Ready for any stack.
    pub fn new() -> Self {
        static READY: LazyLock<FilmStackKernel> = LazyLock::new(FilmStackKernel::make);
        READY.clone()
    }

    /// The fit of widths takes milliseconds, as much as a small sample's profiles.
    fn make() -> Self {
        let medium = Medium::isotropic(0.0, 1.0, 1.53, base::Gloss::NONE);
        Self { tables: StackTables::of(&medium, &medium), back: WidthFit::new() }
    }

    /// What `stack` does to a line of light.
    pub fn spread(&mut self, stack: &FilmStack) -> FilmStackSpread {
        self.tables.remember_stack(stack);
        spread(self, stack)
    }
}

impl Default for FilmStackKernel {
    fn default() -> Self {
        Self::new()
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn spread(kernel: &FilmStackKernel, stack: &FilmStack) -> FilmStackSpread {
    let flow = flow(&kernel.tables, stack, 0.0);
    let (weights, towards) = (kernel.back.weights(&flow.film), kernel.back.weights(&flow.towards));
    let (mut enter, mut exit) = ([0.0f32; BASIS], [0.0f32; BASIS]);
    for j in 0..BASIS {
        enter[j] = weights[j].sqrt();
        exit[j] = towards[j] / enter[j].max(1e-12);
    }
    // What foil mirrors at once out of film that is sealed to it is as narrow as the laser's line: the fit would leave
    // a hundredth of it in wide widths.
    let mut below = [0.0f32; BASIS];
    if stack.film.gap_mm.is_none() && stack.film.under.gloss.is_metal() {
        below[0] = flow.straight;
    } else {
        below = kernel.back.weights(&flow.below);
    }
    // Only pockets ask what has crossed them.
    let (mut alone, mut below_first) = ([1.0f32; BASIS], [1.0f32; BASIS]);
    if stack.film.is_over_room() {
        alone = shares(kernel.back.weights(&flow.alone), &towards);
        below_first = shares(kernel.back.weights(&flow.below_first), &below);
    }
    let below_law = if stack.film.under.gloss.is_metal() {
        1.0
    } else {
        kernel.tables.under.towards(stack.view.dot(under_normal(&stack.film)))
    };
    let below_beside = kernel.tables.under.beside * stack.view.y;
    let FilmFlow { passes, through, holds, mirrored, .. } = flow;
    let mirrored_mm = mirrored_mm(stack, flow.mirrored_twice);
    FilmStackSpread {
        enter,
        exit,
        alone,
        through,
        below,
        below_first,
        below_law,
        film_beside: film_beside(stack),
        below_beside,
        mirrored,
        mirrored_mm,
        passes,
        holds,
    }
}

/// Share of `all` that `of` is, by width; 1 where there is none [1].
#[inline(always)]
fn shares(of: [f32; BASIS], all: &[f32; BASIS]) -> [f32; BASIS] {
    let mut shares = [1.0f32; BASIS];
    for j in 0..BASIS {
        if all[j] > 0.0 {
            shares[j] = (of[j] / all[j]).clamp(0.0, 1.0);
        }
    }
    shares
}

/// How far nearer to the lens light leaves that goes there, over its spread, where film hardly turns it [1]. This and
/// the next number suited packs of two seeds best, of which that of tests/reference/accepted.rs is one.
const GOES_ON: f32 = 1.15;
/// How much more smooth foil keeps the way of light that clear film holds to it; by 1 plus its roughness less [1].
const FOIL_KEEPS: f32 = 1.4;

/// How far along the motion the lens sees light of each width leave the film beside where it leaves towards all sides
/// [mm].
///
/// What was turned once comes from where the laser's light was turned, and lies as wide as that is deep. Light that has
/// gone along the film goes on that way when it is turned last, the more the wider it has spread, up to some free path
/// 1 / (mu_a + sigma_i).
fn film_beside(stack: &FilmStack) -> [f32; BASIS] {
    let FilmStack { medium, film, view, .. } = stack;
    let ([depth, deep], slant) = (turned_depth(stack), in_film(medium.n_eff, *view));
    let gloss = &film.under.gloss;
    let keeps = if film.gap_mm.is_none() && gloss.is_metal() {
        (FOIL_KEEPS / (1.0 + gloss.roughness[1]) - 1.0) / (1.0 + medium.sigma_i * film.thickness_mm)
    } else {
        0.0
    };
    let ahead = GOES_ON * (1.0 + keeps) * view.y;
    PACK_SPREAD_MM.map(|width| {
        let square = width * width;
        let along = width * square / (square + slant * slant * deep).max(f32::MIN_POSITIVE);
        depth * slant + ahead * along / (1.0 + (medium.mu_a + medium.sigma_i) * width)
    })
}

/// Standard deviation along the motion of light that foil shows of a film's lower side: from half of the film's
/// thickness on, through the air; turned at one depth or another [mm].
#[inline(always)]
fn mirrored_mm(stack: &FilmStack, twice: f32) -> f32 {
    let (thickness, n) = (stack.film.thickness_mm, stack.medium.n_eff);
    let beneath = stack.film.gap_mm.unwrap_or(0.0) + 0.5 * thickness / n;
    let lobe_mm = beneath * FACET_TURN * stack.film.under.gloss.roughness[1];
    let smear_mm = in_film(n, stack.view) * thickness;
    (lobe_mm * lobe_mm * (1.0 + twice) + smear_mm * smear_mm / 12.0).sqrt()
}
