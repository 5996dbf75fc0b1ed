//! Half spaces, films over air and sealed films, drawn at random over all that recipes accept, lenses at 5 to 75
//! degrees and unlike roughness of foil included, by the kernel against the reference; and what of it the kernel itself
//! calls doubtful.
//!
//! What the reference says of one seed is kept. `make fresh-draws` asks about another seed at each call, which takes
//! ten minutes.

use super::drawn_packs::{FAINT, figures, kernel_within_the_references_angles};
use super::kept::Kept;
use base::Stream;
use glam::DVec3;
use rand::RngExt;
use reference::path::{Effort, solve};
use transport::answer::{Answer, Question};
use transport::kernel::{self, Doubt};
use transport::stack::{CylinderPhase, Foil, Layer, PIGMENT_G, Scattering, Stack, Substrate};

/// Photons of the reference for each draw; and of clear film over foil, where light to the lens is counted in a cone of
/// 5 degrees, a hundredth of the light at most.
const PHOTONS: u64 = 100_000;
const PHOTONS_CLEAR: u64 = 1_000_000;
/// Reduced scattering times thickness below which a film is clear [1].
const CLEAR: f64 = 0.5;
/// Standard error of the reference over its figure from which on a window tells nothing [1].
const VAGUE: f64 = 0.1;
/// Draws of each group.
const DRAWS: u64 = 60;
/// Seed of what is kept: bounds of [`Doubt`] were chosen on another one.
const SEED: u64 = 101;
/// The groups, in the order in which draws take turns.
const GROUPS: [&str; 3] = ["half space", "over air", "sealed"];
/// Error of a centre of no light [rows].
const UNKNOWN: f64 = 1e9;
/// Rows on either side of the line of which the centre of gravity is taken.
const HALF_WINDOW: i64 = 7;

type Drawn = (Stack, Question);

/// Draw number `i` of a seed, of the group `i % 3`: any numbers that recipes accept, even in the logarithm where they
/// span decades; films over air lie over tablets and over foil in turn.
fn drawn(seed: u64, i: u64) -> Drawn {
    let mut rng = Stream::root(seed).child("accepted").index(i).rng();
    let mut draw = |from: f64, to: f64| from + (to - from) * rng.random::<f64>();
    let mut even = |from: f64, to: f64| libm::exp(draw(libm::log(from), libm::log(to)));
    let stack = if i.is_multiple_of(3) {
        let (share, scattering, loss) = (even(0.03, 1.0), even(0.5, 200.0), even(1e-4, 3.0));
        let [n, dispersion_deg, dive, azimuth] =
            [draw(1.0, 1.55), draw(3.0, 14.0), draw(0.0, 90.0), draw(-180.0, 180.0)];
        wood(share * scattering, (1.0 - share) * scattering, loss * scattering, n, [azimuth, dive, dispersion_deg])
    } else {
        let (sigma, mu_a, thickness, gap) = (even(0.01, 200.0), even(0.0005, 10.0), even(0.05, 1.0), even(0.1, 8.0));
        let (tablet_sigma, tablet_mu_a) = (even(1.0, 300.0), even(0.0001, 20.0));
        let roughness = [even(0.03, 1.0), even(0.03, 1.0)];
        let (n, tablet_n, coat) = (draw(1.4, 1.55), draw(1.3, 1.55), draw(0.05, 1.0));
        let (reflectance, touching) = (draw(0.51, 0.99), draw(0.0, 1.0) < 0.2);
        let scatters = |sigma: f64, g: f64| Scattering::Isotropic { mu_s: sigma / (1.0 - g), g };
        let film = Layer::new(thickness, n, mu_a, scatters(sigma, PIGMENT_G));
        let tablet = Layer { coat, ..Layer::new(f64::INFINITY, tablet_n, tablet_mu_a, scatters(tablet_sigma, 0.0)) };
        let foil = Substrate::Foil(Foil { reflectance, roughness });
        let (layers, below) = match i % 6 {
            1 => (vec![film, Layer::air(if touching { 0.0 } else { gap }), tablet], Substrate::Index(1.0)),
            4 => (vec![film, Layer::air(gap)], foil),
            _ => (vec![film], foil),
        };
        Stack { above: 1.0, layers, below }
    };
    (stack, question(draw(5.0, 75.0)))
}

fn wood(sigma_i: f64, sigma_c: f64, mu_a: f64, n: f64, [azimuth, dive, dispersion_deg]: [f64; 3]) -> Stack {
    let (axis, dispersion) = (reference::medium::axis(azimuth, dive), dispersion_deg.to_radians());
    Stack::half_space(
        n,
        mu_a,
        Scattering::Fibres { sigma_i, sigma_c, turn: CylinderPhase::Cauchy(0.0), axis, dispersion },
    )
}

fn question(tilt_deg: f64) -> Question {
    let (sin, cos) = libm::sincos(tilt_deg.to_radians());
    Question { view: DVec3::new(0.0, -sin, cos), cells: 0, angles: 0, ..Question::default() }
}

/// [`figures`], then the centre of gravity of the middle rows towards the lens and its error [rows].
fn all_figures(answer: &Answer) -> Vec<f64> {
    let middle = answer.seen.len() as i64 / 2;
    let inside = || (-HALF_WINDOW..=HALF_WINDOW).map(|k| (k as f64, answer.seen[(middle + k) as usize]));
    let light: f64 = inside().map(|(_, row)| row.value).sum();
    if light <= 0.0 {
        return figures(answer).into_iter().chain([0.0, UNKNOWN]).collect();
    }
    let at = inside().map(|(k, row)| k * row.value).sum::<f64>() / light;
    let error = inside().map(|(k, row)| ((k - at) * row.error).powi(2)).sum::<f64>().sqrt() / light;
    figures(answer).into_iter().chain([at, error]).collect()
}

fn by_kernel((stack, question): &Drawn) -> Vec<f64> {
    if stack.layers.len() == 1 && matches!(stack.below, Substrate::Index(_)) {
        all_figures(&kernel::solve(stack, question).expect("such media are answered"))
    } else {
        all_figures(&kernel_within_the_references_angles(stack, question))
    }
}

/// What is compared, with its place in [`all_figures`] and whether it is relative: S(a, n) is the light of rows a to
/// a + n - 1 on both sides, to all sides or to the lens.
const FIGURES: [(&str, usize, bool); 6] = [
    ("R", 0, false),
    ("S(1,8)", 4, true),
    ("S(7,5)", 6, true),
    ("lens S(1,8)", 10, true),
    ("lens S(7,5)", 12, true),
    ("centre [rows]", 14, false),
];

/// Deviation of each figure beside two standard errors of the reference; none where the window is [`FAINT`] or the
/// error [`VAGUE`].
fn deviations(truth: &[f64], kernel: &[f64]) -> [Option<f64>; FIGURES.len()] {
    FIGURES.map(|(_, at, is_relative)| {
        let scale = if is_relative { truth[at] } else { 1.0 };
        let is_told = match is_relative {
            true => truth[at] > FAINT && truth[at + 1] < VAGUE * truth[at],
            false => truth[at + 1] < VAGUE,
        };
        is_told.then(|| (((kernel[at] - truth[at]).abs() - 2.0 * truth[at + 1]) / scale).max(0.0))
    })
}

/// Deviations that 95 % of a group keep.
type Bars = [[f64; FIGURES.len()]; GROUPS.len()];

/// What is kept by [`SEED`]. The aim is 0.02 of R, a tenth of windows and 0.1 rows. It is not met where a number here
/// is greater: centres of half spaces whose free paths are long, and rows 7 to 11 of clear film on foil. Of the sealed
/// ones 21 draws show these to all sides and 14 to the lens.
const BARS: Bars =
    [[0.02, 0.1, 0.1, 0.1, 0.11, 0.15], [0.02, 0.1, 0.17, 0.1, 0.1, 0.1], [0.02, 0.1, 0.19, 0.1, 0.72, 0.14]];
/// Draws of each group without a [`Doubt`] that are off by more than a fifth in some window.
const FAR_OFF: [usize; GROUPS.len()] = [0, 0, 3];
/// Most draws of a group that are in doubt [1].
const MOST_IN_DOUBT: f64 = 0.08;
/// Draws of each group by which that is told.
const DRAWS_IN_DOUBT: u64 = 3000;

/// Compares and tells all draws of a seed: what is not within `bars`.
fn compare(
    seed: u64,
    bars: Bars,
    far_off: [usize; GROUPS.len()],
    truth: &mut dyn FnMut(&str, &Drawn, u64) -> Vec<f64>,
) -> Vec<String> {
    let mut faults = Vec::new();
    // Each deviation, and whether the answer was in doubt.
    let mut off: [[Vec<(f64, bool)>; FIGURES.len()]; GROUPS.len()] = Default::default();
    let (mut in_doubt, mut unmarked) = ([0usize; GROUPS.len()], [0usize; GROUPS.len()]);
    for i in 0..DRAWS * GROUPS.len() as u64 {
        let (group, drawn) = ((i % 3) as usize, drawn(seed, i));
        let name = format!("seed {seed}, draw {i:03}, {}", GROUPS[group]);
        let (truth, kernel) = (truth(&name, &drawn, i), by_kernel(&drawn));
        let found = deviations(&truth, &kernel);
        let doubt = Doubt::of(&drawn.0, &drawn.1).expect("such media are answered");
        let is_far_off = (1..5).any(|figure| found[figure].is_some_and(|off| off > 0.2));
        println!("{name}: {found:.3?}, {doubt:?}; {drawn:?}, reference {truth:.5?}, kernel {kernel:.5?}");
        in_doubt[group] += usize::from(doubt.is_some());
        unmarked[group] += usize::from(doubt.is_none() && is_far_off);
        off[group].iter_mut().zip(found).for_each(|(all, found)| all.extend(found.map(|off| (off, doubt.is_some()))));
    }
    for (group, name) in GROUPS.into_iter().enumerate() {
        for ((all, bar), (figure, ..)) in off[group].iter_mut().zip(bars[group]).zip(FIGURES) {
            all.sort_by(|a, b| b.0.total_cmp(&a.0));
            let sure: Vec<f64> = all.iter().filter(|(_, in_doubt)| !in_doubt).map(|(off, _)| *off).collect();
            let (at95, of_sure) = (all[all.len() / 20].0, sure[sure.len() / 20]);
            println!(
                "{name}, {figure}: {} draws, 95 % within {at95:.3}, not in doubt {of_sure:.3}, all within {:.3}",
                all.len(),
                all[0].0
            );
            if at95 > bar {
                faults.push(format!("{name}, {figure}: {at95:.3}"));
            }
        }
        println!("{name}: {} in doubt, {} others off by more than a fifth", in_doubt[group], unmarked[group]);
        if unmarked[group] > far_off[group] {
            faults.push(format!("{name}: {} in doubt, {} more far off", in_doubt[group], unmarked[group]));
        }
    }
    faults
}

fn photons((stack, _): &Drawn) -> u64 {
    let is_clear = match stack.layers[0].scattering {
        Scattering::Isotropic { mu_s, g } => mu_s * (1.0 - g) * stack.layers[0].thickness < CLEAR,
        _ => false,
    };
    if is_clear && matches!(stack.below, Substrate::Foil(_)) { PHOTONS_CLEAR } else { PHOTONS }
}

fn reference(drawn: &Drawn, seed: u64) -> Vec<f64> {
    all_figures(&solve(&drawn.0, &drawn.1, Effort { photons: photons(drawn), seed }))
}

/// Every figure within [`BARS`].
#[test]
fn what_recipes_accept_is_answered_as_by_the_reference() {
    let mut kept = Kept::of("accepted");
    let mut truth =
        |name: &str, drawn: &Drawn, i: u64| kept.says(name, &(drawn, photons(drawn)), || reference(drawn, i));
    let faults = compare(SEED, BARS, FAR_OFF, &mut truth);
    kept.finish();
    assert!(faults.is_empty(), "{faults:?}");
}

/// The same of a seed that nobody has seen, within the aim; it may fail, and tells what is to be mended.
#[test]
#[ignore = "ten minutes, and another answer each time: make fresh-draws"]
fn fresh_draws_are_answered_as_by_the_reference() {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).expect("a clock");
    let seed = std::env::var("SEED").map_or(now.as_secs(), |seed| seed.parse().expect("a whole number"));
    let faults = compare(seed, [[0.02, 0.1, 0.1, 0.1, 0.1, 0.1]; 3], [0; 3], &mut |_, drawn, i| reference(drawn, i));
    assert!(faults.is_empty(), "{faults:?}");
}

/// Hardly any of what recipes accept is in doubt, and something of each group is.
#[test]
fn little_is_in_doubt() {
    for group in 0..GROUPS.len() as u64 {
        let is_in_doubt = |i: &u64| {
            let (stack, question) = drawn(SEED, 3 * i + group);
            Doubt::of(&stack, &question).expect("such media are answered").is_some()
        };
        let share = (0..DRAWS_IN_DOUBT).filter(is_in_doubt).count() as f64 / DRAWS_IN_DOUBT as f64;
        println!("{}: {:.2} % in doubt", GROUPS[group as usize], 100.0 * share);
        assert!(share > 0.0 && share < MOST_IN_DOUBT, "{}: {share}", GROUPS[group as usize]);
    }
}

/// What is in doubt is off: of draws within the bounds of each [`Doubt`], the worst window is off by a tenth or more in
/// the median; where free paths are long, the centre [rows].
#[test]
fn doubts_are_deserved() {
    let mut kept = Kept::of("doubts");
    let mut faults = Vec::new();
    for (kind, least) in
        [(Doubt::StraightFibres, 0.1), (Doubt::LongPaths, 0.1), (Doubt::RoughFoil, 0.08), (Doubt::RolledFoil, 0.15)]
    {
        let mut worst: Vec<f64> = (0..12)
            .map(|i| {
                let drawn = doubtful(kind, i);
                assert_eq!(Doubt::of(&drawn.0, &drawn.1), Ok(Some(kind)), "{kind:?}, draw {i}");
                let name = format!("{kind:?}, draw {i:02}");
                let truth = kept.says(&name, &(&drawn, photons(&drawn)), || reference(&drawn, i));
                let found = deviations(&truth, &by_kernel(&drawn));
                println!("{name}: {found:.3?}");
                let telling = if kind == Doubt::LongPaths { 5..6 } else { 1..5 };
                found[telling].iter().flatten().copied().fold(0.0, f64::max)
            })
            .collect();
        worst.sort_by(f64::total_cmp);
        println!("{kind:?}: median {:.3}", worst[6]);
        if worst[6] < least {
            faults.push((kind, worst[6]));
        }
    }
    kept.finish();
    assert!(faults.is_empty(), "{faults:?}");
}

/// Draw number `i` within the bounds of `kind`.
fn doubtful(kind: Doubt, i: u64) -> Drawn {
    let mut rng = Stream::root(SEED).child(&format!("{kind:?}")).index(i).rng();
    let mut draw = |from: f64, to: f64| from + (to - from) * rng.random::<f64>();
    match kind {
        Doubt::StraightFibres => {
            let (scattering, share, loss) = (draw(1.2, 2.2), draw(0.05, 0.25), draw(0.2, 0.6));
            let direction = [draw(-20.0, 20.0), draw(5.0, 17.0), draw(3.0, 4.5)];
            let stack =
                wood(share * scattering, (1.0 - share) * scattering, loss * scattering, draw(1.0, 1.18), direction);
            (stack, question(draw(20.0, 40.0)))
        }
        Doubt::LongPaths => {
            let (scattering, share, loss) = (draw(0.5, 0.74), draw(0.1, 1.0), draw(0.01, 0.3));
            let direction = [draw(-180.0, 180.0), draw(0.0, 80.0), draw(3.0, 14.0)];
            let stack =
                wood(share * scattering, (1.0 - share) * scattering, loss * scattering, draw(1.1, 1.5), direction);
            (stack, question(draw(15.0, 50.0)))
        }
        Doubt::RoughFoil | Doubt::RolledFoil => {
            let is_rolled = kind == Doubt::RolledFoil;
            let (thickness, turns) = (draw(0.1, 0.8), if is_rolled { draw(0.02, 0.18) } else { draw(0.002, 0.04) });
            let scattering = Scattering::Isotropic { mu_s: turns / thickness / (1.0 - PIGMENT_G), g: PIGMENT_G };
            let film = Layer::new(thickness, draw(1.4, 1.55), draw(0.001, 0.1), scattering);
            let reflectance = draw(0.6, 0.95);
            let roughness =
                if is_rolled { [draw(0.03, 0.09), draw(0.35, 0.9)] } else { [draw(0.03, 0.9), draw(0.62, 0.95)] };
            let layers = if is_rolled { vec![film] } else { vec![film, Layer::air(draw(0.2, 3.0))] };
            let below = Substrate::Foil(Foil { reflectance, roughness });
            (Stack { above: 1.0, layers, below }, question(draw(15.0, 50.0)))
        }
    }
}
