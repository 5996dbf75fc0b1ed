//! Adding method for a film over air and tablet, or over foil, as production uses it.
//!
//! Each layer answers for itself ([`table`]: films, measured by Monte Carlo; the half space's own table: tablets), and
//! light that passes from one to the next loses its direction: it leaves by Lambert's law. In the space of frequencies q
//! along the motion (`spectrum`) spreads one after the other are products, and all bounces between film and what lies below
//! are a geometric series (van de Hulst 1980). With T0 the straight light that a film lets through, R and T what it
//! reflects and lets through turned (small letters: of Lambert light), h and g the spread of light from the film and of
//! Lambert light over the gap, B what a tablet sends out again, m the share that a surface mirrors:
//!
//! ```text
//! down   A = T0 / (1 - rho m0), rho what the film's two surfaces throw down again of straight light from below
//! loop   L = (1 - m) B g^2 + m g(2 d)
//! up     X = [(1 - m0) A B g + T ((1 - m) B h g + m h(2 d)) + (1 - F) R Y L] / (1 - r L)
//! mirror Y = m0 A, spread by the roughness of foil: 2 d alpha for d in g, the same law (slopes of GGX, Walter et al. 2007)
//! film   R + (1 - F) T Y + t X
//! below  B [(1 - m0) A + (1 - m) (T h + ((1 - F) R Y + r X) g)], seen through the film
//! ```
//!
//! Valid for plane parallel layers whose films are wide against gap and thickness, light from straight above; of light that meets a slope the
//! straight part is what is left of its longer way. Neglected:
//! walls of pockets, tilt of film against tablet, direction of light after its first bounce, the change of exit angles with distance.

mod answer;
pub mod paths;
mod sealed;
mod shares;
mod single_scattering;
mod spectrum;
pub mod table;
mod underlayer;

use std::sync::{Arc, LazyLock};

use glam::Vec3;
use multiversion::multiversion;
use procedural::{Film, Medium};

pub(super) use self::answer::solve;
use self::sealed::{HOP, SealedGlint, sealed_glint};
pub use self::shares::FilmShares;
use self::single_scattering::{
    turned_depth, turned_down, turned_once, turned_once_aslant, turned_once_in_all, turned_once_level,
};
use self::spectrum::{FREQUENCY_COUNT, LambertTransfer, LengthInterpolation, Spectrum, WidthFit, frequency};
use self::table::FilmTable;
use self::underlayer::Underlayer;
use super::widths::{BASIS, PACK_SPREAD_MM};
use crate::fresnel::{fresnel_dielectric, gloss, normal_reflectance};
use crate::stack;

/// Gap above foil under which light that film and foil throw to each other again meets it from all sides rather than from above; of 0.25,
/// 0.35 and 0.5 the one that suited the first sixty packs of tests/reference/drawn_packs.rs best [mm].
const NEAR_GAP_MM: f32 = 0.25;
/// Sideways way of Lambert light in a film over that in air of the film's thickness: tan(inside) / tan(outside) near 60 degrees, where light comes from
/// that lands beside the line [1].
const IN_FILM: f32 = 0.41;
/// Height in air over which Lambert light spreads as light that pigment turned once does from its depth, over the film's thickness [1].
const ONCE_AROUND: f32 = 0.15;
/// Factor by which the law of exit of light that pigment turns more than once is at most unlike that of all light [1].
const MOST_UNLIKE: f32 = 2.0;
/// Mean way of light from all sides across air, over its height, near the line [1].
const LAMBERT_WAY: f32 = 1.1;
/// Least cosine of a view by whose way through air light counts [1].
const LEAST_VIEW_UP: f32 = 0.2;
/// Largest gain of light between film and what lies below that is believed [1].
const MAX_LOOP_GAIN: f32 = 0.98;

/// A film over something, as light from straight above meets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmStack {
    /// The film's own matter.
    pub medium: Medium,
    /// Its thickness and what lies below.
    pub film: Film,
    /// Share of light that enters the film [1].
    pub enter: f32,
    /// Cosine of the view against the film's normal [1].
    pub view_up: f32,
    /// Cosine of the laser's light against it [1].
    pub light_up: f32,
    /// Unit vector to the lens; x along the line, y along the motion, z up.
    pub view: Vec3,
    /// Unit vector to the laser.
    pub light: Vec3,
    /// Unit normal of the film.
    pub normal: Vec3,
}

impl FilmStack {
    /// How far along the motion light that pigment turns on its way down, and that foil below mirrors, leaves the film beside where it met
    /// it: twice through the air below the film and, from half of its thickness on, as far through the film [mm].
    pub fn mirrored_beside(&self) -> f32 {
        mirrored_depth_mm(&self.medium, &self.film, self.view) * self.view.y / self.view.z
    }

    /// How far along the motion the lens sees light of each width leave the film beside where it leaves towards all sides: what was turned
    /// once comes from where the laser's light was turned, light of wider widths was turned last deeper [mm].
    fn film_beside(&self) -> [f32; BASIS] {
        let Self { medium, film, view, .. } = self;
        let late = (ESCAPE_FREE_PATHS / (medium.mu_a + medium.sigma_i)).min(0.5 * film.thickness_mm);
        let (once, slant) = (turned_depth(self)[0], in_film(medium.n_eff, *view));
        PACK_SPREAD_MM.map(|width| slant * (once + (late - once) * width * width / (width * width + late * late)))
    }

    /// How far along the motion light from below that the film does not turn leaves it beside where it left what lies below: by the
    /// slant of the view in the air, and by that which refraction leaves of it in the film [mm].
    pub fn seen_beside(&self) -> f32 {
        let Film { thickness_mm, gap_mm, .. } = self.film;
        gap_mm.unwrap_or(0.0) * self.view.y / self.view.z + thickness_mm * in_film(self.medium.n_eff, self.view)
    }
}

/// How far below level film foil shows the film's lower side to a lens along `view` [mm].
pub fn mirrored_depth_mm(medium: &Medium, film: &Film, view: Vec3) -> f32 {
    let (_, up) = refracted(medium.n_eff, view.z);
    2.0 * film.gap_mm.unwrap_or(0.0) + 1.5 * film.thickness_mm * view.z / (medium.n_eff * up)
}

/// Mean depth at which light that leaves a film towards a lens was turned last, where the film is thick, in free paths 1 / (mu_a + sigma_i) [1].
const ESCAPE_FREE_PATHS: f32 = 1.3;

/// Slant along the motion inside a level film of index `n` of light that leaves it along `view` [1].
#[inline(always)]
fn in_film(n: f32, view: Vec3) -> f32 {
    let (_, up) = refracted(n, view.z);
    view.y / (n * up)
}

/// Share of light from below that passes `film` of `medium` unturned towards a view under cosine `up` [1].
pub fn passed_unturned(medium: &Medium, film: &Film, up: f32) -> f32 {
    let extinction = (medium.sigma_i / (1.0 - PIGMENT_G) + medium.mu_a) * film.thickness_mm;
    seen_through(medium.n_eff, extinction, up)
}

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
    /// Weight of each width times radiance factor, of light that what lies below sends towards the lens: it is seen where it left the
    /// surface below [1].
    pub below: [f32; BASIS],
    /// Share of that which the film has not thrown down again, by width; 1 but over pockets [1].
    pub below_first: [f32; BASIS],
    /// Radiance factor of light from all sides that what lies below throws to the lens, over its reflectance [1].
    pub below_law: f32,
    /// How far along the motion the lens sees light of each width leave the film beside where it leaves towards all sides [mm].
    pub film_beside: [f32; BASIS],
    /// How far along the motion that light leaves the surface below beside light to all sides [mm].
    pub below_beside: f32,
    /// Radiance factor, before it passes the film again, of light that pigment has turned on its way down and that foil mirrors to the lens: the
    /// film's lower side, as foil shows it [1].
    pub mirrored: f32,
    /// Its standard deviation along the motion, by the foil's roughness [mm].
    pub mirrored_mm: f32,
    /// Share of the light from below which passes the film without being turned [1].
    pub passes: f32,
    /// Share of light from all sides that the film throws back into the room below [1].
    pub holds: f32,
}

/// Answers for film stacks, one after the other. It remembers what the last ones were made of, which saves time and changes no
/// bit of an answer.
#[derive(Debug, Clone)]
pub struct FilmStackKernel {
    films: Arc<FilmTable>,
    under: Underlayer,
    lambert: LambertTransfer,
    back: WidthFit,
    /// Squares of the fixed frequencies [mm^-2].
    squares: Spectrum,
}

/// Where a line's light goes, as transforms; shares of what arrived.
#[derive(Debug, Clone, Copy)]
struct FilmFlow {
    /// Leaves upwards, turned by the film on its last way through [1].
    film: Spectrum,
    /// The same times its radiance factor towards the lens [1].
    towards: Spectrum,
    /// Of that, what has never been below the film, or has not left it [1].
    alone: Spectrum,
    /// Radiance factor of what lies below [1].
    below: Spectrum,
    /// Of that, what the film has not thrown down again [1].
    below_first: Spectrum,
    /// Of that, straight light that foil mirrors to the lens at once [1].
    straight: f32,
    /// Radiance factor of what foil shows of the film's lower side [1].
    mirrored: f32,
    /// Share of that which foil has mirrored before [1].
    mirrored_twice: f32,
    /// Share of what lies below that is seen through the film [1].
    passes: f32,
    /// Radiance factor of light from all sides that passes the film turned [1].
    through: f32,
    /// Share of light from all sides below that the film throws back [1].
    holds: f32,
    /// Leaves upwards in any way [1].
    all: Spectrum,
    /// All of that, however far it spreads [1].
    total: f32,
    /// Never comes back from what lies below [1].
    sunk: f32,
}

impl FilmStackKernel {
    /// Ready for any stack.
    pub fn new() -> Self {
        static READY: LazyLock<FilmStackKernel> = LazyLock::new(FilmStackKernel::make);
        READY.clone()
    }

    /// The fit of widths takes milliseconds, as much as a small sample's profiles.
    fn make() -> Self {
        let medium = Medium::isotropic(0.0, 1.0, 1.53, procedural::Gloss::NONE);
        Self {
            films: FilmTable::of(medium.n_eff),
            under: Underlayer::of(&medium),
            lambert: LambertTransfer::new(),
            back: WidthFit::new(),
            squares: std::array::from_fn(|i| (frequency(i) * frequency(i)) as f32),
        }
    }

    /// What `stack` does to a line of light.
    pub fn spread(&mut self, stack: &FilmStack) -> FilmStackSpread {
        self.remember(&stack.medium, &stack.film.under);
        spread(self, stack)
    }

    fn remember(&mut self, film: &Medium, under: &Medium) {
        if self.films.n() != film.n_eff {
            self.films = FilmTable::of(film.n_eff);
        }
        if self.under.medium() != under {
            self.under = Underlayer::of(under);
        }
    }
}

impl Default for FilmStackKernel {
    fn default() -> Self {
        Self::new()
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn spread(kernel: &FilmStackKernel, stack: &FilmStack) -> FilmStackSpread {
    let flow = flow(kernel, stack, 0.0);
    let (weights, towards) = (kernel.back.weights(&flow.film), kernel.back.weights(&flow.towards));
    let enter = weights.map(f32::sqrt);
    let exit = std::array::from_fn(|j| towards[j] / enter[j].max(1e-12));
    let below = kernel.back.weights(&flow.below);
    // Only pockets ask what has crossed them.
    let shares = |of: &Spectrum, all: [f32; BASIS]| {
        let of = if stack.film.is_over_room() { kernel.back.weights(of) } else { all };
        std::array::from_fn(|j| if all[j] > 0.0 { (of[j] / all[j]).clamp(0.0, 1.0) } else { 1.0 })
    };
    let below_law = if stack.film.under.gloss.is_metal() {
        1.0
    } else {
        kernel.under.towards(stack.view.dot(under_normal(&stack.film)))
    };
    let below_beside = kernel.under.beside() * stack.view.y;
    let FilmFlow { passes, through, holds, mirrored, .. } = flow;
    let mirrored_mm = mirrored_mm(stack, flow.mirrored_twice);
    FilmStackSpread {
        enter,
        exit,
        alone: shares(&flow.alone, towards),
        through,
        below,
        below_first: shares(&flow.below_first, below),
        below_law,
        film_beside: stack.film_beside(),
        below_beside,
        mirrored,
        mirrored_mm,
        passes,
        holds,
    }
}

/// Standard deviation along the motion of light that foil shows of a film's lower side: from half of the film's thickness on, through the air; turned
/// at one depth or another [mm].
#[inline(always)]
fn mirrored_mm(stack: &FilmStack, twice: f32) -> f32 {
    let (thickness, n) = (stack.film.thickness_mm, stack.medium.n_eff);
    let beneath = stack.film.gap_mm.unwrap_or(0.0) + 0.5 * thickness / n;
    let lobe_mm = beneath * FACET_TURN * stack.film.under.gloss.roughness[1];
    let smear_mm = in_film(n, stack.view) * thickness;
    (lobe_mm * lobe_mm * (1.0 + twice) + smear_mm * smear_mm / 12.0).sqrt()
}

/// Radiance factor of rough metal [1]. Facets throw a part of the light, about a b / (1 + a b) for roughness a and b, at other facets, which throw it
/// on: nothing of it is lost.
#[inline(always)]
fn metal(of: &procedural::Gloss, normal: Vec3, light: Vec3, view: Vec3) -> f32 {
    let [along, across] = of.roughness;
    gloss(of, normal, light, view) * (1.0 + along * across)
}

/// Unit vector, downwards, along which light goes that what lies below `film` mirrors to a lens along `view`.
#[inline(always)]
pub fn mirrored_view(film: &Film, view: Vec3) -> Vec3 {
    let up = under_normal(film);
    view - up * (2.0 * view.dot(up))
}

/// Unit normal of what lies below a film.
#[inline(always)]
pub fn under_normal(film: &Film) -> Vec3 {
    Vec3::new(-film.under_slope[0], -film.under_slope[1], 1.0).normalize()
}

/// A direction in air as a level film of index `n` bends it.
#[inline(always)]
fn inside(n: f32, way: Vec3) -> Vec3 {
    let flat = Vec3::new(way.x, way.y, 0.0) / n;
    flat + Vec3::Z * (1.0 - flat.length_squared()).max(0.0).sqrt()
}

/// Follows a line's light through film and gap and back, where air absorbs `air_per_mm`.
#[inline(always)]
fn flow(kernel: &FilmStackKernel, stack: &FilmStack, air_per_mm: f32) -> FilmFlow {
    let (medium, film, enter) = (&stack.medium, &stack.film, stack.enter);
    let n = medium.n_eff;
    let (thickness, foil) = (film.thickness_mm, film.under.gloss.is_metal());
    let (turns, absorbed) = (medium.sigma_i * thickness, medium.mu_a * thickness);
    let place = LengthInterpolation::new(thickness, table::LOWEST_FREQUENCY as f32);
    // Straight light: what is left after one way through, and Fresnel's law on both sides.
    let extinction = turns / (1.0 - PIGMENT_G) + absorbed;
    let (_, steep) = refracted(n, stack.light_up);
    let left = numerics::lanes::exp(-extinction / steep);
    let fresnel = normal_reflectance(n);
    let inner = 1.0 / (1.0 - fresnel * fresnel * left * left);
    let (straight, mirrored) = ((1.0 - fresnel) * left * inner, (1.0 - fresnel) * fresnel * left * left * inner);
    let seen = seen_through(n, extinction, stack.view_up);
    let normal = under_normal(film);
    let under = &film.under;
    let aslant = turned_once_aslant(stack);
    if let (None, true) = (film.gap_mm, foil) {
        let [along, across] = under.gloss.roughness;
        let roughness = (0.5 * (along * along + across * across)).sqrt();
        let sealed = kernel.films.sealed(turns, absorbed, under.gloss.reflectance, roughness);
        let (turned, law) = (place.read(&sealed.turned()), sealed.law(stack.view_up));
        let (_, up) = refracted(n, stack.view_up);
        let out = numerics::lanes::exp(-extinction / up)
            * (1.0 - fresnel_dielectric(1.0, n.into(), stack.view_up.into()).0 as f32);
        let glint = enter * left * metal(&under.gloss, normal, inside(n, stack.light), inside(n, stack.view)) / (n * n);
        // Beyond the table's foils and indices light must not become more than there is.
        let mirrored = sealed.mirrored().max(0.0);
        let kept = ((1.0 - mirrored) / turned[0].max(f32::MIN_POSITIVE)).min(1.0);
        let turned = turned.map(|part| kept * part);
        let SealedGlint { first, slope, again } = sealed_glint(stack, left, mirrored);
        let later = mirrored - first;
        let lobe = kernel.lambert.over(2.0 * thickness * slope);
        let hop = kernel.lambert.over(HOP * thickness);
        let hops: Spectrum = std::array::from_fn(|i| later * hop[i] * (1.0 - again) / (1.0 - again * hop[i]));
        let all = std::array::from_fn(|i| enter * (turned[i] + first * lobe[i] + hops[i]));
        let total = enter * (turned[0] + mirrored);
        let towards: Spectrum = std::array::from_fn(|i| enter * (law * (turned[i] + hops[i]) + aslant));
        return FilmFlow {
            film: std::array::from_fn(|i| enter * (turned[i] + hops[i])),
            towards,
            alone: towards,
            below: [glint; FREQUENCY_COUNT],
            below_first: [glint; FREQUENCY_COUNT],
            straight: glint,
            mirrored: 0.0,
            mirrored_twice: 0.0,
            passes: out,
            through: law,
            holds: 0.0,
            all,
            total,
            sunk: enter - total,
        };
    }
    let of = kernel.films.at(turns, absorbed);
    let laws = of.laws(stack.view_up);
    let gap = film.gap_mm.unwrap_or(0.0);
    let (back, on) = (place.read(&of.back()), place.read(&of.on()));
    let (diffuse_back, diffuse_on) = (place.read(&of.diffuse_back()), place.read(&of.diffuse_on()));
    let slopes = of.slopes();
    let lowest = table::LOWEST_FREQUENCY as f32;
    let (h1, h2) = (
        LengthInterpolation::new(gap, lowest).read(&slopes),
        LengthInterpolation::new(2.0 * gap, lowest).read(&slopes),
    );
    // Straight down, slanting as light from all sides, and up to the lens.
    let [air, air_aslant, air_up] = [1.0, LAMBERT_WAY, 1.0 / stack.view_up.max(LEAST_VIEW_UP)]
        .map(|way| numerics::lanes::exp(-air_per_mm * gap * way));
    let (h1, h2) = (h1.map(|h| h * air_aslant), h2.map(|h| h * air_aslant * air_aslant));
    let (g1, g2) = (kernel.lambert.over(gap), kernel.lambert.over(2.0 * gap));
    let (g1, g2) = (g1.map(|g| g * air_aslant), g2.map(|g| g * air_aslant * air_aslant));
    let lobe = |height: f32| match foil {
        true => kernel.lambert.over(2.0 * height * under.gloss.roughness[1]),
        false => [1.0; FREQUENCY_COUNT],
    };
    // Light that passes the film unturned leaves it further away than it met it: steep light by its refracted slope, Lambert light by
    // about half of what air of the film's thickness would add.
    let (lobe, lobe_above) = (lobe(gap), lobe(gap + thickness / n));
    let above = kernel.lambert.over(gap + IN_FILM * thickness);
    let (body, seen_body) = (kernel.under.body(), kernel.under.seen());
    let [mirrors, mirrors_straight] = kernel.under.mirrors();
    let glint = if foil {
        metal(&under.gloss, normal, stack.light, stack.view)
    } else {
        kernel.under.towards(stack.view.dot(normal))
    };
    // What the glossy surface of a tablet throws to the lens itself.
    let shine = if foil { 0.0 } else { gloss(&under.gloss, normal, stack.light, stack.view) };
    // Foil right below mirrors light from all sides to the lens; foil far below only what comes down steeply.
    let near = NEAR_GAP_MM * NEAR_GAP_MM / (NEAR_GAP_MM * NEAR_GAP_MM + gap * gap);
    let glow = if foil { near * mirrors + (1.0 - near) * glint.min(mirrors) } else { 0.0 };
    // Light that pigment has turned ahead once has two ways to the lens: it was turned towards the lens' mirror image, and foil shows it beside
    // where it was turned; or the lobe of rough foil turns it there, from where it met the foil.
    let lobe2 = (FACET_TURN * under.gloss.roughness[1]).powi(2);
    let shown = TURNED_SPREAD / (TURNED_SPREAD + lobe2);
    let lower_side = if foil { enter * mirrors * shown * turned_down(stack, on[0]) } else { 0.0 };
    // Straight light that foil, film and foil mirror leaves by two lobes, which reach further: turned half of the way by each, it goes towards the
    // lens between them.
    let twice = if foil {
        let [along, across] = under.gloss.roughness.map(|roughness| FACET_TURN * roughness);
        let wide = procedural::Gloss { roughness: [along, across], ..under.gloss };
        let back_down = fresnel + (1.0 - fresnel) * mirrored;
        let again = back_down * mirrors;
        enter * straight * again / (1.0 - again) * metal(&wide, normal, stack.light, stack.view)
    } else {
        0.0
    };
    // At one depth or another, which the lens sees one beside the other.
    let smear = in_film(n, stack.view).powi(2) * turned_depth(stack)[1];
    let once = turned_once(stack, stack.light_up, stack.light.dot(stack.view));
    let (lower_side, twice) = (lower_side * air_up.powi(2), twice * air_up.powi(4));
    // What pigment turns once leaves where it came in and by a law of its own, the rest by what is left of that of all light.
    let once_in_all = turned_once_in_all(stack).min(back[0]);
    let (radiance, often) = (laws[0] * back[0], back[0] - once_in_all);
    let law_often = (radiance - turned_once_level(stack, stack.view_up)) / often.max(f32::MIN_POSITIVE);
    let law_often = law_often.clamp(laws[0] / MOST_UNLIKE, laws[0] * MOST_UNLIKE);
    let level_once = radiance - law_often * often;
    // From its depth towards all sides.
    let once_around = kernel.lambert.over(ONCE_AROUND * thickness);
    let mut out = FilmFlow {
        mirrored: lower_side + twice,
        mirrored_twice: twice / (lower_side + twice).max(f32::MIN_POSITIVE),
        film: [0.0; FREQUENCY_COUNT],
        towards: [0.0; FREQUENCY_COUNT],
        alone: [0.0; FREQUENCY_COUNT],
        below: [0.0; FREQUENCY_COUNT],
        below_first: [0.0; FREQUENCY_COUNT],
        straight: if foil { enter * air_up * straight * air * glint } else { 0.0 },
        passes: seen,
        through: laws[1],
        holds: diffuse_back[0],
        all: [0.0; FREQUENCY_COUNT],
        total: 0.0,
        sunk: 0.0,
    };
    for i in 0..FREQUENCY_COUNT {
        let scattered = (1.0 - mirrors) * body[i];
        let turn = scattered * g1[i] * g1[i] + mirrors * g2[i];
        // Straight light that is mirrored meets the film's surfaces, which throw part of it down again.
        let bounce = mirrors_straight * lobe[i] * air * air;
        let arrives = straight / (1.0 - (fresnel + (1.0 - fresnel) * mirrored) * bounce);
        let mirror = bounce * arrives;
        let again = (1.0 - fresnel) * back[i] * mirror;
        let below = arrives * air;
        let first = (1.0 - mirrors_straight) * below * body[i] * g1[i]
            + on[i] * (scattered * h1[i] * g1[i] + mirrors * h2[i])
            + again * turn;
        let up = first / (1.0 - (diffuse_back[i] * turn).min(MAX_LOOP_GAIN));
        let down = on[i] * h1[i] + (again + diffuse_back[i] * up) * g1[i];
        let passed = (1.0 - fresnel) * on[i] * mirror + diffuse_on[i] * up;
        out.film[i] = enter * (back[i] + passed);
        let smeared = once * (1.0 - numerics::lanes::exp(-0.5 * smear * kernel.squares[i]));
        let often = (back[i] - once_in_all * once_around[i]).max(0.0) * law_often;
        out.alone[i] = enter * (level_once + often + aslant - smeared);
        out.towards[i] = out.alone[i] + enter * laws[1] * passed;
        let ahead = on[i] * h1[i];
        let (first, later) = if foil {
            (straight * air * glint + ahead * (1.0 - shown) * mirrors, (down - ahead) * glow)
        } else {
            let sent = seen_body[i] * glint;
            (sent * (1.0 - mirrors_straight) * below + below * shine, sent * (1.0 - mirrors) * down)
        };
        out.below[i] = enter * air_up * (first + later);
        out.below_first[i] = enter * air_up * first;
        let crossed = if g1[i] > 1e-6 { (above[i] / g1[i]).min(1.0) } else { 1.0 };
        let (diffuse, metallic) = (of.diffuse_straight() * up, (1.0 - fresnel) * straight * mirrors_straight * arrives);
        out.all[i] = enter * (back[i] + mirrored + passed + diffuse * crossed + metallic * lobe_above[i]);
        if i == 0 {
            out.total = enter * (back[i] + mirrored + passed + diffuse + metallic * lobe[i]);
            let lost = if foil { 1.0 - mirrors } else { (1.0 - mirrors) * (1.0 - body[0]) };
            let lost_straight = if foil { 1.0 - mirrors } else { (1.0 - mirrors_straight) * (1.0 - body[0]) };
            out.sunk = enter * (lost_straight * arrives + lost * down);
        }
    }
    out
}

/// Variance, about each of two axes, of the directions into which pigment turns light ahead once: 1 - g, as for small angles [rad^2].
const TURNED_SPREAD: f32 = 1.0 - PIGMENT_G;
/// Standard deviation of a lobe's slopes over the roughness of the facets: these lean by 1 / sqrt(2) of it, and turn light by twice that [1].
pub const FACET_TURN: f32 = std::f32::consts::SQRT_2;

/// Mean cosine of the pigment of films [1].
const PIGMENT_G: f32 = stack::PIGMENT_G as f32;

/// Sine and cosine inside a film of index `n` of light that leaves it under cosine `up` [1].
#[inline(always)]
fn refracted(n: f32, up: f32) -> (f32, f32) {
    let sin2 = (1.0 - up * up).max(0.0) / (n * n);
    (sin2.sqrt(), (1.0 - sin2).sqrt())
}

/// Share of radiance from below that passes a film unturned towards a lens under cosine `up` [1].
#[inline(always)]
fn seen_through(n: f32, extinction: f32, up: f32) -> f32 {
    let (_, inside) = refracted(n, up);
    let left = numerics::lanes::exp(-extinction / inside);
    let thrown = fresnel_dielectric(1.0, n.into(), up.into()).0 as f32;
    (1.0 - thrown) * (1.0 - thrown) * left / (1.0 - thrown * thrown * left * left)
}

#[cfg(test)]
mod tests {
    use super::*;
    use procedural::Gloss;

    /// White metal of any roughness throws back all light from above: up to the 3 degrees above the surface within which radiance is bounded, what
    /// facets that lean less than half as far as that throw there, whose tangents t of GGX are as often below as t^2 / (a^2 + t^2).
    #[test]
    fn rough_metal_loses_nothing() {
        let lowest = 0.05f32;
        for step in 0..12 {
            let alpha = 0.1 + 0.9 * step as f32 / 11.0;
            let white = Gloss { share: 1.0, reflectance: 1.0, roughness: [alpha; 2], matte: 0.0 };
            // Even in the square of the sine, that is in what light of a radiance factor of 1 carries.
            let (rings, most) = (4000, 1.0 - lowest * lowest);
            let ring = |i: i32| {
                let sin2 = most * (i as f32 + 0.5) / rings as f32;
                metal(&white, Vec3::Z, Vec3::Z, Vec3::new(0.0, sin2.sqrt(), (1.0 - sin2).sqrt()))
            };
            let all = most * (0..rings).map(ring).sum::<f32>() / rings as f32;
            let (tan2, a2) = ((1.0 - lowest) / (1.0 + lowest), alpha * alpha);
            let expected = tan2 / (a2 + tan2) * (1.0 + a2);
            assert!((all / expected - 1.0).abs() < 0.005, "roughness {alpha}: {all} for {expected}");
        }
    }
}
