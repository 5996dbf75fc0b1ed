//! Adding method, step by step: where a line's light goes in a film over air and tablet or foil.
//!
//! The equations are those of [`super`], one step each: straight light, the film's own transfer, the gap, what lies
//! below, light that pigment turns once, and the bounces between film and what lies below. Film sealed to foil has no
//! room below it: its table answers for both ([`super::sealed`]).

use std::sync::Arc;

use base::{Gloss, Medium};
use glam::Vec3;
use multiversion::multiversion;

use super::film::{FACET_TURN, FilmStack, PIGMENT_G, in_film, inside, refracted, seen_through, under_normal};
use super::sealed::{HOP, MOST_ASIDE, SealedGlint, SealedMirror, across_share, sealed_glint, spreading};
use super::single_scattering::{
    turned_depth, turned_down, turned_once, turned_once_aslant, turned_once_in_all, turned_once_level,
};
use super::spectrum::{FREQUENCY_COUNT, LambertTransfer, LengthInterpolation, Spectrum, frequency};
use super::table::{self, FilmNode, FilmTable, SealedNode, TableFoil};
use super::underlayer::Underlayer;
use crate::fresnel::{fresnel_dielectric, gloss, normal_reflectance};
use numerics::lanes::exp;

/// Gap above foil under which light that film and foil throw to each other again meets it from all sides rather than
/// from above; of 0.25, 0.35 and 0.5 the one that suited the first sixty packs of tests/reference/drawn_packs.rs best
/// [mm].
const NEAR_GAP_MM: f32 = 0.25;
/// Sideways way of Lambert light in a film over that in air of the film's thickness: tan(inside) / tan(outside) near 60
/// degrees, where light comes from that lands beside the line [1].
const IN_FILM: f32 = 0.41;
/// Height in air over which Lambert light spreads as light that pigment turned once does from its depth, over the
/// film's thickness [1].
const ONCE_AROUND: f32 = 0.15;
/// Factor by which the law of exit of light that pigment turns more than once is at most unlike that of all light [1].
const MOST_UNLIKE: f32 = 2.0;
/// Mean way of light from all sides across air, over its height, near the line [1].
const LAMBERT_WAY: f32 = 1.1;
/// Least cosine of a view by whose way through air light counts [1].
const LEAST_VIEW_UP: f32 = 0.2;
/// Largest gain of light between film and what lies below that is believed [1].
const MAX_LOOP_GAIN: f32 = 0.98;
/// Variance, about each of two axes, of the directions into which pigment turns light ahead once: 1 - g, as for small
/// angles [rad^2].
const TURNED_SPREAD: f32 = 1.0 - PIGMENT_G;

/// What the steps read: films, what lies below, and Lambert's law.
#[derive(Debug, Clone)]
pub(super) struct StackTables {
    pub films: Arc<FilmTable>,
    pub under: Underlayer,
    lambert: LambertTransfer,
    /// Squares of the fixed frequencies [mm^-2].
    squares: Spectrum,
    /// The last film that was sealed to foil: that of a card is alike everywhere.
    sealed: Option<Box<SealedFilm>>,
}

impl StackTables {
    /// For films of `film` over `under`.
    pub fn of(film: &Medium, under: &Medium) -> Self {
        Self {
            films: FilmTable::of(film.n_eff),
            under: Underlayer::of(under),
            lambert: LambertTransfer::new(),
            squares: std::array::from_fn(|i| (frequency(i) * frequency(i)) as f32),
            sealed: None,
        }
    }

    /// The same for all of `stack`.
    pub fn remember_stack(&mut self, stack: &FilmStack) {
        self.remember(&stack.medium, &stack.film.under);
        let key = SealedFilm::key(stack);
        if is_sealed(stack) && self.sealed.as_ref().is_none_or(|sealed| sealed.key != key) {
            self.sealed = Some(Box::new(sealed_film(self, stack)));
        }
    }

    /// Reads anew what `film` over `under` needs and the last one did not.
    pub fn remember(&mut self, film: &Medium, under: &Medium) {
        if self.films.n != film.n_eff {
            self.films = FilmTable::of(film.n_eff);
        }
        if self.under.medium != *under {
            self.under = Underlayer::of(under);
        }
    }
}

/// Where a line's light goes, as transforms; shares of what arrived.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FilmFlow {
    /// Leaves upwards, turned by the film on its last way through [1].
    pub film: Spectrum,
    /// The same times its radiance factor towards the lens [1].
    pub towards: Spectrum,
    /// Of that, what has never been below the film, or has not left it [1].
    pub alone: Spectrum,
    /// Radiance factor of what lies below [1].
    pub below: Spectrum,
    /// Of that, what the film has not thrown down again [1].
    pub below_first: Spectrum,
    /// Of that, straight light that foil mirrors to the lens at once [1].
    pub straight: f32,
    /// Radiance factor of what foil shows of the film's lower side [1].
    pub mirrored: f32,
    /// Share of that which foil has mirrored before [1].
    pub mirrored_twice: f32,
    /// Share of what lies below that is seen through the film [1].
    pub passes: f32,
    /// Radiance factor of light from all sides that passes the film turned [1].
    pub through: f32,
    /// Share of light from all sides below that the film throws back [1].
    pub holds: f32,
    /// Leaves upwards in any way [1].
    pub all: Spectrum,
    /// All of that, however far it spreads [1].
    pub total: f32,
    /// Never comes back from what lies below [1].
    pub sunk: f32,
}

/// Follows a line's light through film and gap and back, where air absorbs `air_per_mm`.
#[inline(always)]
pub(super) fn flow(tables: &StackTables, stack: &FilmStack, air_per_mm: f32) -> FilmFlow {
    // Pass straight light through the film (Beer's law, Fresnel's law at both sides).
    let straight = StraightLight::of(stack);
    if is_sealed(stack) {
        return sealed_flow(tables, stack, &straight);
    }
    // Read what the film turns, back and on.
    let film = FilmTransfer::of(tables, stack);
    // Spread light over the gap, by Lambert's law and by the slopes of what the film has turned.
    let gap = GapTransfer::over(tables, stack, &film, air_per_mm);
    // Reflect it by what lies below, to all sides and to the lens.
    let under = UnderReflection::of(tables, stack);
    // Tell light that pigment turns once from the rest: it leaves where it came in.
    let once = TurnedOnce::of(tables, stack, &film);
    let layers = FilmLayers { straight, film, gap, under };
    // Mirror by foil what pigment has turned on its way down.
    let [lower_side, twice] = layers.mirrored_by_foil(stack);
    let FilmLayers { straight, film, gap, under } = &layers;
    let enter = stack.enter;
    let mut out = FilmFlow {
        mirrored: lower_side + twice,
        mirrored_twice: twice / (lower_side + twice).max(f32::MIN_POSITIVE),
        straight: if under.foil { enter * gap.air_up * straight.passes * gap.air * under.glint } else { 0.0 },
        passes: seen_through(stack.medium.n_eff, straight.extinction, stack.view_up),
        through: film.laws[1],
        holds: film.diffuse_back[0],
        ..FilmFlow::default()
    };
    for i in 0..FREQUENCY_COUNT {
        // Sum the bounces between film and what lies below (a geometric series).
        let bounces = layers.bounces(i);
        // Let light out that the film turned last.
        out.film[i] = enter * (film.back[i] + bounces.passed);
        out.alone[i] = once.alone(i, enter, film, tables.squares[i]);
        out.towards[i] = out.alone[i] + enter * film.laws[1] * bounces.passed;
        // Send light from below to the lens.
        let [first, later] = layers.sent(i, &bounces);
        out.below[i] = enter * gap.air_up * (first + later);
        out.below_first[i] = enter * gap.air_up * first;
        // Count all that leaves, and what never does.
        let crossed = if gap.lambert[i] > 1e-6 { (gap.above[i] / gap.lambert[i]).min(1.0) } else { 1.0 };
        let diffuse = film.node.diffuse_straight * bounces.up;
        let metallic = (1.0 - straight.fresnel) * straight.passes * under.mirrors_straight * bounces.arrives;
        let turned = film.back[i] + straight.mirrored + bounces.passed;
        out.all[i] = enter * (turned + diffuse * crossed + metallic * gap.lobe_above[i]);
        if i == 0 {
            out.total = enter * (turned + diffuse + metallic * gap.lobe[i]);
            out.sunk = enter * under.sunk(&bounces);
        }
    }
    out
}

/// Straight light: what is left of it after one way through, and what Fresnel's law throws back at both sides.
#[derive(Debug, Clone, Copy)]
struct StraightLight {
    /// Optical thickness of the film, straight through [1].
    extinction: f32,
    /// What is left after one way [1].
    left: f32,
    /// Reflectance of a side for light from straight above [1].
    fresnel: f32,
    /// Leaves on the other side [1].
    passes: f32,
    /// Leaves on the side where it entered, thrown back by the other [1].
    mirrored: f32,
}

impl StraightLight {
    #[inline(always)]
    fn of(stack: &FilmStack) -> Self {
        let (medium, thickness) = (&stack.medium, stack.film.thickness_mm);
        let extinction = medium.sigma_i * thickness / (1.0 - PIGMENT_G) + medium.mu_a * thickness;
        let (_, steep) = refracted(medium.n_eff, stack.light_up);
        let left = exp(-extinction / steep);
        let fresnel = normal_reflectance(medium.n_eff);
        let inner = 1.0 / (1.0 - fresnel * fresnel * left * left);
        let passes = (1.0 - fresnel) * left * inner;
        let mirrored = (1.0 - fresnel) * fresnel * left * left * inner;
        Self { extinction, left, fresnel, passes, mirrored }
    }
}

/// Whether no air lies between film and foil.
#[inline(always)]
fn is_sealed(stack: &FilmStack) -> bool {
    stack.film.gap_mm.is_none() && stack.film.under.gloss.is_metal()
}

/// Film sealed to foil, as light from any side finds it.
#[derive(Debug, Clone)]
struct SealedFilm {
    /// What it is made of.
    key: [f32; 7],
    node: SealedNode,
    mirror: SealedMirror,
    /// Light that the film has turned.
    turned: Spectrum,
    /// Light that foil throws back, the first time that it leaves; and how far it goes from foil to foil.
    lobe: Spectrum,
    hop: Spectrum,
}

impl SealedFilm {
    /// All numbers that it depends on.
    fn key(stack: &FilmStack) -> [f32; 7] {
        let (medium, film) = (&stack.medium, &stack.film);
        let [along, across] = film.under.gloss.roughness;
        [medium.n_eff, medium.sigma_i, medium.mu_a, film.thickness_mm, film.under.gloss.reflectance, along, across]
    }

    #[inline(always)]
    fn of(tables: &StackTables, stack: &FilmStack) -> Self {
        let (medium, gloss, thickness) = (&stack.medium, &stack.film.under.gloss, stack.film.thickness_mm);
        let [along, across] = gloss.roughness;
        // Slopes have this mean logarithm over all directions, as facets of one roughness have.
        let roughness = 0.5 * (along + across);
        let foil = TableFoil { reflectance: gloss.reflectance, roughness, spreading: spreading(gloss.roughness) };
        let mirror = SealedMirror::of(stack);
        let (turns, absorbed) = (medium.sigma_i * thickness, medium.mu_a * thickness);
        let node = tables.films.sealed(turns, absorbed, foil, |met| mirror.out(met));
        Self {
            key: Self::key(stack),
            mirror,
            turned: LengthInterpolation::new(thickness, table::LOWEST_FREQUENCY as f32).read(&node.turned),
            lobe: mirror.spread(thickness, medium.n_eff, &tables.lambert),
            hop: tables.lambert.over(HOP * thickness * across_share(gloss.roughness)),
            node,
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn sealed_film(tables: &StackTables, stack: &FilmStack) -> SealedFilm {
    SealedFilm::of(tables, stack)
}

/// A line's light in a film that is sealed to foil.
#[inline(always)]
fn sealed_flow(tables: &StackTables, stack: &FilmStack, straight: &StraightLight) -> FilmFlow {
    let (medium, film, enter) = (&stack.medium, &stack.film, stack.enter);
    let (n, gloss) = (medium.n_eff, &film.under.gloss);
    let [along, across] = gloss.roughness;
    let roughness = 0.5 * (along + across);
    let other;
    let sealed = match &tables.sealed {
        Some(sealed) if sealed.key == SealedFilm::key(stack) => &**sealed,
        _ => {
            other = SealedFilm::of(tables, stack);
            &other
        }
    };
    let SealedFilm { node, mirror, turned, lobe, hop, .. } = sealed;
    let law = node.law(stack.view_up);
    let (_, up) = refracted(n, stack.view_up);
    let passes =
        exp(-straight.extinction / up) * (1.0 - fresnel_dielectric(1.0, n.into(), stack.view_up.into()).0 as f32);
    let [light_inside, view_inside] = [stack.light, stack.view].map(|way| inside(n, way));
    let glint = enter * straight.left * metal(gloss, under_normal(film), light_inside, view_inside) / (n * n);
    // Beyond the table's foils and indices light must not become more than there is.
    let mirrored = node.mirrored.max(0.0);
    let kept = ((1.0 - mirrored) / turned[0].max(f32::MIN_POSITIVE)).min(1.0);
    let turned = turned.map(|part| kept * part);
    let SealedGlint { first, again } = sealed_glint(stack, mirror, straight.left, mirrored);
    let later = mirrored - first;
    let mut out = FilmFlow { straight: glint, passes, through: law, ..FilmFlow::default() };
    let aslant = turned_once_aslant(stack);
    // Facets that lean along the line more than across it throw less of it at a lens across the line.
    let twice = |roughness: [f32; 2]| {
        let gloss = Gloss { roughness: roughness.map(|alpha| std::f32::consts::SQRT_2 * alpha), ..*gloss };
        metal(&gloss, under_normal(film), light_inside, view_inside)
    };
    let [own, alike] = [twice([along, across]), twice([roughness; 2])];
    let to_lens = if alike > 1e-6 { (own / alike).min(MOST_ASIDE) } else { 1.0 };
    out.total = enter * (turned[0] + mirrored);
    out.sunk = enter - out.total;
    for i in 0..FREQUENCY_COUNT {
        let hops = later * hop[i] * (1.0 - again) / (1.0 - again * hop[i]);
        out.film[i] = enter * (turned[i] + hops);
        out.towards[i] = enter * (law * (turned[i] + to_lens * hops) + aslant);
        out.alone[i] = out.towards[i];
        (out.below[i], out.below_first[i]) = (glint, glint);
        out.all[i] = enter * (turned[i] + first * lobe[i] + hops);
    }
    out
}

/// What a film in air does to light, in the letters of [`super`]: R and T of straight light, r and t of Lambert light.
#[derive(Debug, Clone, Copy)]
struct FilmTransfer {
    node: FilmNode,
    /// R: straight light, turned, leaves where it entered.
    back: Spectrum,
    /// T: straight light, turned, leaves on the other side.
    on: Spectrum,
    /// r: Lambert light leaves where it arrived.
    diffuse_back: Spectrum,
    /// t: Lambert light, turned, leaves on the other side.
    diffuse_on: Spectrum,
    /// Radiance factors towards the lens of R and t [1].
    laws: [f32; 2],
}

impl FilmTransfer {
    #[inline(always)]
    fn of(tables: &StackTables, stack: &FilmStack) -> Self {
        let (medium, thickness) = (&stack.medium, stack.film.thickness_mm);
        let node = tables.films.at(medium.sigma_i * thickness, medium.mu_a * thickness);
        let place = LengthInterpolation::new(thickness, table::LOWEST_FREQUENCY as f32);
        Self {
            node,
            back: place.read(&node.back),
            on: place.read(&node.on),
            diffuse_back: place.read(&node.diffuse_back),
            diffuse_on: place.read(&node.diffuse_on),
            laws: node.laws(stack.view_up),
        }
    }
}

/// What the air between film and what lies below does to light.
#[derive(Debug, Clone, Copy)]
struct GapTransfer {
    /// What air leaves of light straight down, and up to the lens [1].
    air: f32,
    air_up: f32,
    /// h: light that the film has turned crosses the gap; there and back.
    turned: Spectrum,
    turned_twice: Spectrum,
    /// g: Lambert light crosses the gap; there and back.
    lambert: Spectrum,
    lambert_twice: Spectrum,
    /// Lambert light crosses gap and film.
    above: Spectrum,
    /// The lobe of rough foil crosses the gap; gap and film.
    lobe: Spectrum,
    lobe_above: Spectrum,
}

impl GapTransfer {
    #[inline(always)]
    fn over(tables: &StackTables, stack: &FilmStack, film: &FilmTransfer, air_per_mm: f32) -> Self {
        let (gap, thickness) = (stack.film.gap_mm.unwrap_or(0.0), stack.film.thickness_mm);
        let (lowest, slopes) = (table::LOWEST_FREQUENCY as f32, &film.node.slopes);
        let (once, twice) = (LengthInterpolation::new(gap, lowest), LengthInterpolation::new(2.0 * gap, lowest));
        // Straight down, slanting as light from all sides, and up to the lens.
        let [air, aslant, air_up] =
            [1.0, LAMBERT_WAY, 1.0 / stack.view_up.max(LEAST_VIEW_UP)].map(|way| exp(-air_per_mm * gap * way));
        let lobe = |height: f32| match stack.film.under.gloss.is_metal() {
            true => tables.lambert.over(height * tables.under.lobe),
            false => [1.0; FREQUENCY_COUNT],
        };
        // Light that passes the film unturned leaves it further away than it met it: steep light by its refracted
        // slope, Lambert light by about half of what air of the film's thickness would add.
        Self {
            air,
            air_up,
            turned: once.read(slopes).map(|h| h * aslant),
            turned_twice: twice.read(slopes).map(|h| h * aslant * aslant),
            lambert: tables.lambert.over(gap).map(|g| g * aslant),
            lambert_twice: tables.lambert.over(2.0 * gap).map(|g| g * aslant * aslant),
            above: tables.lambert.over(gap + IN_FILM * thickness),
            lobe: lobe(gap),
            lobe_above: lobe(gap + thickness / stack.medium.n_eff),
        }
    }
}

/// What lies below the film: tablet or foil.
#[derive(Debug, Clone, Copy)]
struct UnderReflection<'a> {
    foil: bool,
    /// B: what a tablet sends out again, to all sides and to the lens.
    body: &'a Spectrum,
    seen_body: &'a Spectrum,
    /// m: share that the surface mirrors of light from all sides; m0: of straight light [1].
    mirrors: f32,
    mirrors_straight: f32,
    /// Radiance factor towards the lens of straight light that foil mirrors, or of light that a tablet sends out [1].
    glint: f32,
    /// What the glossy surface of a tablet throws to the lens itself [1].
    shine: f32,
    /// Radiance factor towards the lens of light from all sides that foil mirrors [1].
    glow: f32,
    /// Part of light that pigment has turned ahead once by which foil shows the film's lower side [1].
    shown: f32,
}

impl<'a> UnderReflection<'a> {
    #[inline(always)]
    fn of(tables: &'a StackTables, stack: &FilmStack) -> Self {
        let (under, normal) = (&stack.film.under, under_normal(&stack.film));
        let foil = under.gloss.is_metal();
        let [mirrors, mirrors_straight] = tables.under.mirrors;
        let glint = if foil {
            metal(&under.gloss, normal, stack.light, stack.view)
        } else {
            tables.under.towards(stack.view.dot(normal))
        };
        let shine = if foil { 0.0 } else { gloss(&under.gloss, normal, stack.light, stack.view) };
        // Foil right below mirrors light from all sides to the lens; foil far below only what comes down steeply.
        let gap = stack.film.gap_mm.unwrap_or(0.0);
        let near = NEAR_GAP_MM * NEAR_GAP_MM / (NEAR_GAP_MM * NEAR_GAP_MM + gap * gap);
        let glow = if foil { near * mirrors + (1.0 - near) * glint.min(mirrors) } else { 0.0 };
        // Light that pigment has turned ahead once has two ways to the lens: it was turned towards the lens' mirror
        // image, and foil shows it beside where it was turned; or the lobe of rough foil turns it there, from where it
        // met the foil.
        let lobe2 = (FACET_TURN * under.gloss.roughness[1]).powi(2);
        let shown = TURNED_SPREAD / (TURNED_SPREAD + lobe2);
        let (body, seen_body) = (&tables.under.body, &tables.under.seen);
        Self { foil, body, seen_body, mirrors, mirrors_straight, glint, shine, glow, shown }
    }

    /// Light that never comes back from what lies below, by the bounces at the lowest frequency [1].
    #[inline(always)]
    fn sunk(&self, bounces: &Bounces) -> f32 {
        let kept = |mirrors: f32| if self.foil { 1.0 - mirrors } else { (1.0 - mirrors) * (1.0 - self.body[0]) };
        let straight = if self.foil { self.mirrors } else { self.mirrors_straight };
        kept(straight) * bounces.arrives + kept(self.mirrors) * bounces.down
    }
}

/// Light that pigment turns once, which leaves where it came in and by a law of its own; the rest leaves by what is
/// left of that of all light.
#[derive(Debug, Clone, Copy)]
struct TurnedOnce {
    /// Radiance factor towards the lens, as it is and as it would be of level film [1].
    aslant: f32,
    level: f32,
    /// What of it the lens sees one beside the other, from one depth or another [1], and its variance [mm^2].
    beside: f32,
    smear: f32,
    /// Share of what arrives, and its spread towards all sides from its depth.
    in_all: f32,
    around: Spectrum,
    /// Radiance factor of the rest [1].
    law_often: f32,
}

impl TurnedOnce {
    #[inline(always)]
    fn of(tables: &StackTables, stack: &FilmStack, film: &FilmTransfer) -> Self {
        let FilmTransfer { back, laws, .. } = film;
        let in_all = turned_once_in_all(stack).min(back[0]);
        let (radiance, often) = (laws[0] * back[0], back[0] - in_all);
        let law_often = (radiance - turned_once_level(stack, stack.view_up)) / often.max(f32::MIN_POSITIVE);
        let law_often = law_often.clamp(laws[0] / MOST_UNLIKE, laws[0] * MOST_UNLIKE);
        Self {
            aslant: turned_once_aslant(stack),
            level: radiance - law_often * often,
            beside: turned_once(stack, stack.light_up, stack.light.dot(stack.view)),
            smear: in_film(stack.medium.n_eff, stack.view).powi(2) * turned_depth(stack)[1],
            in_all,
            around: tables.lambert.over(ONCE_AROUND * stack.film.thickness_mm),
            law_often,
        }
    }

    /// Light towards the lens that has never been below the film, at frequency `i`, of which `square` is the square
    /// [1].
    #[inline(always)]
    fn alone(&self, i: usize, enter: f32, film: &FilmTransfer, square: f32) -> f32 {
        let smeared = self.beside * (1.0 - exp(-0.5 * self.smear * square));
        let often = (film.back[i] - self.in_all * self.around[i]).max(0.0) * self.law_often;
        enter * (self.level + often + self.aslant - smeared)
    }
}

/// Light between film and what lies below, at one frequency; shares of what entered.
#[derive(Debug, Clone, Copy)]
struct Bounces {
    /// A: straight light that leaves the film downwards, with what its surfaces throw down again.
    arrives: f32,
    /// The same as it meets what lies below.
    below: f32,
    /// X: Lambert light that meets the film from below.
    up: f32,
    /// Light from all sides that meets what lies below.
    down: f32,
    /// Leaves the film upwards, turned by it on its last way through.
    passed: f32,
}

/// What the steps have found of film, gap and what lies below.
#[derive(Debug, Clone, Copy)]
struct FilmLayers<'a> {
    straight: StraightLight,
    film: FilmTransfer,
    gap: GapTransfer,
    under: UnderReflection<'a>,
}

impl FilmLayers<'_> {
    /// Radiance factors of what foil mirrors to the lens beside its glint: the film's lower side, lit by light that
    /// pigment has turned on its way down; and straight light that foil, film and foil have mirrored [1].
    #[inline(always)]
    fn mirrored_by_foil(&self, stack: &FilmStack) -> [f32; 2] {
        let Self { straight, film, gap, under } = self;
        if !under.foil {
            return [0.0; 2];
        }
        let lower_side = stack.enter * under.mirrors * under.shown * turned_down(stack, film.on[0]);
        // Straight light leaves by two lobes, which reach further: turned half of the way by each, it goes towards the
        // lens between them.
        let gloss = stack.film.under.gloss;
        let wide = Gloss { roughness: gloss.roughness.map(|roughness| FACET_TURN * roughness), ..gloss };
        let back_down = straight.fresnel + (1.0 - straight.fresnel) * straight.mirrored;
        let again = back_down * under.mirrors;
        let glint = metal(&wide, under_normal(&stack.film), stack.light, stack.view);
        let twice = stack.enter * straight.passes * again / (1.0 - again) * glint;
        [lower_side * gap.air_up.powi(2), twice * gap.air_up.powi(4)]
    }

    /// The bounces at frequency `i`.
    #[inline(always)]
    fn bounces(&self, i: usize) -> Bounces {
        let Self { film, gap, under, .. } = self;
        let StraightLight { fresnel, passes, mirrored, .. } = self.straight;
        let (mirrors, mirrors_straight) = (under.mirrors, under.mirrors_straight);
        let [back, on, diffuse_back] = [film.back[i], film.on[i], film.diffuse_back[i]];
        let [g1, g2] = [gap.lambert[i], gap.lambert_twice[i]];
        let [h1, h2] = [gap.turned[i], gap.turned_twice[i]];
        let scattered = (1.0 - mirrors) * under.body[i];
        let turn = scattered * g1 * g1 + mirrors * g2;
        // Straight light that is mirrored meets the film's surfaces, which throw part of it down again.
        let bounce = mirrors_straight * gap.lobe[i] * gap.air * gap.air;
        let arrives = passes / (1.0 - (fresnel + (1.0 - fresnel) * mirrored) * bounce);
        let mirror = bounce * arrives;
        let again = (1.0 - fresnel) * back * mirror;
        let below = arrives * gap.air;
        let first = (1.0 - mirrors_straight) * below * under.body[i] * g1
            + on * (scattered * h1 * g1 + mirrors * h2)
            + again * turn;
        let up = first / (1.0 - (diffuse_back * turn).min(MAX_LOOP_GAIN));
        let down = on * h1 + (again + diffuse_back * up) * g1;
        let passed = (1.0 - fresnel) * on * mirror + film.diffuse_on[i] * up;
        Bounces { arrives, below, up, down, passed }
    }

    /// Radiance factor, at frequency `i`, of light that what lies below sends to the lens: that the film has not thrown
    /// down again, and the rest [1].
    #[inline(always)]
    fn sent(&self, i: usize, bounces: &Bounces) -> [f32; 2] {
        let Self { straight, film, gap, under } = self;
        let ahead = film.on[i] * gap.turned[i];
        if under.foil {
            let first = straight.passes * gap.air * under.glint + ahead * (1.0 - under.shown) * under.mirrors;
            [first, (bounces.down - ahead) * under.glow]
        } else {
            let (sent, below) = (under.seen_body[i] * under.glint, bounces.below);
            let first = sent * (1.0 - under.mirrors_straight) * below + below * under.shine;
            [first, sent * (1.0 - under.mirrors) * bounces.down]
        }
    }
}

/// Radiance factor of rough metal [1]. Facets that lean by more than 45 degrees throw light at other facets, which
/// throw it on: nothing of it is lost. By GGX's law 1 / sqrt((1 + a^2) (1 + b^2)) lean less, of roughness a and b.
#[inline(always)]
fn metal(of: &base::Gloss, normal: Vec3, light: Vec3, view: Vec3) -> f32 {
    let [along, across] = of.roughness;
    gloss(of, normal, light, view) * ((1.0 + along * along) * (1.0 + across * across)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White metal of any roughness throws back all light from above: up to the 3 degrees above the surface within
    /// which radiance is bounded, what facets that lean less than half as far as that throw there, whose tangents t of
    /// GGX are as often below as t^2 / (a^2 + t^2).
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
