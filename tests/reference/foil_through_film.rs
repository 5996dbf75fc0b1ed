//! The line on foil, as bent film of empty pockets shows it, against the reference: where it stands and how bright it
//! is.
//!
//! Both follow Snell's law through both sides of the film, the reference photon by photon through facets of 0.1 mm,
//! production by slopes and their changes. Film is up to four times thinner on shoulders than on flanges, and a prism
//! there. The reference's light is kept ([`Kept`]); the first profile of each test is asked again in each run.

use super::borders::bench_of;
use super::kept::Kept;
use crate::expose;
use base::{Body, Matter, Surface};
use optical_bench::settings::Transport;
use recipe::{Recipe, Scene};
use scanner::optics::ScanLine;
use scanner::optics::{Band, Scratch, Sensor, TILE};
use transport::kernel::BASIS;

/// Packs, profiles of each, and photons for each of those.
const PACKS: usize = 6;
const PROFILES: [usize; 3] = [12, 18, 24];
/// Profiles of pockets' far sides, which the lens does not see.
const FAR_PROFILES: [usize; 4] = [36, 38, 39, 40];
const PHOTONS: u64 = 60_000;
/// Profiles of pockets' shoulders and walls behind, which foil shows before them.
const LEANING_PROFILES: [usize; 4] = [33, 35, 36, 37];
/// Least slope away from the lens of film that counts as leaning [1].
const LEANING: f32 = 0.3;
/// Profiles all over a pocket, and packs of which all of them are compared.
const POCKET_PROFILES: [usize; 6] = [8, 11, 16, 22, 28, 33];
const FEW_PACKS: usize = 4;
/// Columns that are compared together.
const TOGETHER: usize = 8;
/// Profiles that cross embossed codes on the card.
const CODE_PROFILES: [usize; 6] = [40, 41, 42, 43, 44, 45];
/// Height below which the card's film lies, codes and all [mm].
const MOST_OF_CODES_MM: f32 = 0.6;
/// Middle of the rows beside a line from which on wide light alone is left.
const BESIDE_ROWS: f32 = 9.0;
/// Rows on either side of production's line that count.
const REACH: i32 = 6;
/// Rows beside the film's line about which light counts that has been far.
const ASIDE_ROWS: f32 = 14.0;
/// Columns from a pocket within which the card is at its foot [px].
const NEAR_FOOT: usize = 16;
/// Least room below film whose line on foil stands clear of its own [mm].
const LEAST_GAP_MM: f32 = 1.5;

/// Light and centre of gravity about the line on foil, by groups of columns; of `places` [e-, px].
fn lines(sensor: &Sensor, band: &Band, profile: usize, places: &[Option<f32>]) -> Vec<[f64; 2]> {
    let mut sums = vec![[0.0; 2]; places.len().div_ceil(TOGETHER)];
    let mut scratch = Scratch::default();
    for tile in 0..places.len().div_ceil(TILE) {
        sensor.window(band, profile, tile, &mut scratch);
        for (column, place) in places.iter().enumerate().skip(tile * TILE).take(TILE) {
            let Some(place) = place else { continue };
            for window in &scratch.windows[..scratch.used] {
                for (k, (volume, surface)) in window.volume.iter().zip(window.surface.iter()).enumerate() {
                    let away = window.first_row[column % TILE] + k as i32 - place.round() as i32;
                    if away.abs() <= REACH {
                        let light = f64::from(volume[column % TILE] + surface[column % TILE]);
                        let sum = &mut sums[column / TOGETHER];
                        *sum = [sum[0] + light, sum[1] + light * f64::from(away)];
                    }
                }
            }
        }
    }
    sums.into_iter().map(|[light, moment]| [light, moment / light.max(1e-9)]).collect()
}

/// Empty packs whose film has these pigments, with their bodies.
fn empty_packs(seed: u64, sigma_per_mm: &str) -> impl Iterator<Item = (Scene, Body)> {
    changed_packs(seed, &[&format!("film.sigma_per_mm={sigma_per_mm}"), "foil.rolled_along_line=1"])
}

/// Empty packs with these changes, with their bodies.
fn changed_packs(seed: u64, changes: &[&str]) -> impl Iterator<Item = (Scene, Body)> + use<> {
    packs_of("missing", seed, changes)
}

/// The same of packs of a class.
fn packs_of(class: &'static str, seed: u64, changes: &[&str]) -> impl Iterator<Item = (Scene, Body)> + use<> {
    let changes: Vec<_> = changes.iter().chain(&["speckle.strength=0"]).map(|text| text.parse().unwrap()).collect();
    let recipe = Recipe::load_changed(concat!(env!("CARGO_MANIFEST_DIR"), "/recipes/gap/blister.yaml"), &changes)
        .expect("it is a recipe");
    let packs = (0..).map(move |index| recipe.draw(seed, index)).filter(move |scene| scene.class == class);
    packs.take(PACKS).map(|scene| (pipeline::body(&scene), scene)).map(|(body, scene)| (scene, body))
}

/// What a pack is made of about a profile: another pack has another answer.
fn matter_about(scene: &Scene, body: &Body, profile: usize) -> Vec<Option<(Surface, Matter)>> {
    let middle = profile as f64 * scene.bench.motion.step_mm;
    let of_line = |away: f64| {
        let slice = body.slice((middle + away) as f32);
        (-12..=12).map(move |i| 2.0 * i as f32).map(move |x| {
            let surface = slice.surface(x)?;
            Some((surface, slice.matter(x, surface.z)))
        })
    };
    [-6.0, -2.0, 0.0, 2.0, 6.0].into_iter().flat_map(|away| of_line(away).collect::<Vec<_>>()).collect()
}

/// Light and centre of gravity by groups of columns, ours and the reference's.
type Groups = Vec<[[f64; 2]; 2]>;
/// Chooses a column's place by production's row.
type Places<'a> = &'a dyn Fn(&ScanLine, usize) -> Option<f32>;

/// One test's comparisons, and what the reference said of its packs.
struct Comparison(Kept);

impl Comparison {
    fn of(test: &str) -> Self {
        Self(Kept::of(&format!("foil_{test}")))
    }

    /// Light and centre of gravity about lines at `places`, by profile.
    fn of_profiles(
        &mut self,
        profiles: &[usize],
        pack: &(Scene, Body),
        places: impl Fn(&ScanLine, usize) -> Option<f32>,
    ) -> Vec<(usize, Groups)> {
        self.of_places(profiles, pack, [&places]).into_iter().map(|(profile, [groups])| (profile, groups)).collect()
    }

    /// The same of several places; profiles by rising number.
    fn of_places<const N: usize>(
        &mut self,
        profiles: &[usize],
        (scene, body): &(Scene, Body),
        places: [Places<'_>; N],
    ) -> Vec<(usize, [Groups; N])> {
        let mut by_reference = scene.clone();
        by_reference.transport = Transport::Path { photons: PHOTONS };
        let (sensor, band) = expose(scene, body.clone(), profiles[0]..profiles[profiles.len() - 1] + 1);
        let mut groups_of = |profile: usize| {
            let line = band.line(profile);
            let places =
                places.map(|places| (0..line.hits.len()).map(|column| places(line, column)).collect::<Vec<_>>());
            let ask = || {
                let (reference, truth) = expose(&by_reference, body.clone(), profile..profile + 1);
                let light = places.iter().flat_map(|places| lines(&reference, &truth, profile, places));
                // Thousandths of an electron and of a row.
                light.flatten().map(|figure| (1e3 * figure).round() / 1e3).collect()
            };
            // Light is counted about whole rows.
            let rows: Vec<Option<f32>> = places.iter().flatten().map(|place| place.map(f32::round)).collect();
            let counted = (PHOTONS, TOGETHER, REACH, rows);
            let question = (bench_of(scene), matter_about(scene, body, profile), profile, counted);
            let (case, is_first) = (format!("{}, profile {profile}", scene.class), self.0.is_new());
            let truth =
                if is_first { self.0.still_says(&case, &question, ask) } else { self.0.says(&case, &question, ask) };
            let truth: Vec<[f64; 2]> = truth.chunks(2).map(|group| [group[0], group[1]]).collect();
            let mut truth = truth.chunks(line.hits.len().div_ceil(TOGETHER));
            let groups = places.map(|places| {
                let ours = lines(&sensor, &band, profile, &places);
                let truth = truth.next().expect("as many places");
                ours.into_iter().zip(truth.iter().copied()).map(<[_; 2]>::from).collect()
            });
            (profile, groups)
        };
        profiles.iter().map(|&profile| groups_of(profile)).collect()
    }

    /// Nothing is kept that was not compared.
    fn finish(self) {
        self.0.finish();
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// Of groups of columns with a twentieth of the brightest's light: light within 18 % rms and 12 % in the mean, places
/// within 0.4 rows rms (seen: 16 %, -8 %, 0.25 rows). As if film were even, light would be 68 % off, 43 % in the mean,
/// and places 0.55 rows.
///
/// Foil is rolled along the line: what foil rolled across it throws to the lens is mostly light that pigment has turned
/// a little on its way down, which the kernel's film has not: light is 16 to 40 % too faint there, by packs.
#[test]
fn foil_is_seen_as_the_reference_sees_it() {
    let mut compared = Comparison::of("foil_is_seen");
    let on_foil = |row: &ScanLine, column: usize| {
        let seen = &row.secondary.as_ref().expect("a pack has it").transmitted;
        let film = row.hits[column].matter.film?;
        let deep = film.gap_mm.is_some_and(|gap| gap > LEAST_GAP_MM) && film.under.gloss.is_metal();
        let shows = seen.columns.contains(&column) && seen.exit[BASIS - 1][column] > 0.0;
        (deep && shows).then(|| seen.centre[column])
    };
    let (mut ratios, mut shifts) = (Vec::new(), Vec::new());
    for pack in empty_packs(5, "{log_uniform: [4, 6]}") {
        for (profile, groups) in compared.of_profiles(&PROFILES, &pack, on_foil) {
            let most = groups.iter().map(|[_, truth]| truth[0]).fold(0.0, f64::max);
            for [ours, truth] in groups.iter().filter(|[_, truth]| truth[0] > 0.05 * most) {
                println!("profile {profile}: {:8.0} of {:8.0} e-, {:+.2} rows", ours[0], truth[0], ours[1] - truth[1]);
                ratios.push(libm::log(ours[0].max(1.0) / truth[0]));
                shifts.push(ours[1] - truth[1]);
            }
        }
    }
    compared.finish();
    let [light, all, place] = [rms(&ratios), mean(&ratios), rms(&shifts)];
    println!(
        "{} groups: light within {light:.3} rms, {all:+.3} in the mean; places within {place:.2} rows",
        ratios.len()
    );
    assert!(ratios.len() > 60, "{}", ratios.len());
    assert!(light < 0.18 && all.abs() < 0.12, "light {light:.3} rms, {all:+.3} in the mean");
    assert!(place < 0.4, "places {place:.2} rows");
}

/// The film's own line where film rises along the line, on walls and edges of pockets: light within 13 % rms and 7 % in
/// the mean (seen: 9 %, +3 %; 17 and 5 % before light that meets film aslant was followed).
#[test]
fn walls_are_as_bright_as_the_reference_sees_them() {
    let mut compared = Comparison::of("walls_are_as_bright");
    let on_wall = |row: &ScanLine, column: usize| {
        let hit = &row.hits[column];
        let steep = hit.surface.slope_x.abs() > 0.3 && hit.matter.film.is_some() && hit.lit && hit.seen;
        steep.then(|| row.centre[column])
    };
    let mut ratios = Vec::new();
    for pack in empty_packs(6, "{log_uniform: [4, 40]}") {
        for (profile, groups) in compared.of_profiles(&PROFILES, &pack, on_wall) {
            for [ours, truth] in groups.iter().filter(|[_, truth]| truth[0] > 0.0) {
                println!("profile {profile}: {:8.0} of {:8.0} e-", ours[0], truth[0]);
                ratios.push(libm::log(ours[0].max(1.0) / truth[0]));
            }
        }
    }
    compared.finish();
    let [light, all] = [rms(&ratios), mean(&ratios)];
    println!("{} groups: light within {light:.3} rms, {all:+.3} in the mean", ratios.len());
    assert!(ratios.len() > 100, "{}", ratios.len());
    assert!(light < 0.13 && all.abs() < 0.07, "light {light:.3} rms, {all:+.3} in the mean");
}

/// Light far beside the film's line in the middle of empty pockets, which has been to and fro between film and foil:
/// within 12 % of the reference's in the mean of six packs (seen: +8 %). Light that ended 2 mm from where it landed, as
/// in wood, would be half of it.
#[test]
fn pockets_are_filled_with_light_as_the_reference_says() {
    let mut compared = Comparison::of("pockets_are_filled_with_light");
    let aside = |row: &ScanLine, column: usize| {
        let film = row.hits[column].matter.film?;
        let deep = film.gap_mm.is_some_and(|gap| gap > LEAST_GAP_MM) && row.hits[column].surface.slope_x.abs() < 0.3;
        deep.then(|| row.centre[column] - ASIDE_ROWS)
    };
    let mut ratios = Vec::new();
    for pack in empty_packs(7, "{log_uniform: [12, 40]}") {
        let mut sums = [0.0; 2];
        for [ours, truth] in compared.of_profiles(&PROFILES, &pack, aside).into_iter().flat_map(|(_, groups)| groups) {
            sums = [sums[0] + ours[0], sums[1] + truth[0]];
        }
        println!("{:8.0} of {:8.0} e-", sums[0], sums[1]);
        ratios.push(libm::log(sums[0] / sums[1]));
    }
    compared.finish();
    println!("{:+.3} in the mean, {:.3} rms", mean(&ratios), rms(&ratios));
    assert!(mean(&ratios).abs() < 0.12, "{ratios:?}");
}

/// Light 0.3 to 1.5 mm beside the film's line, on either side, all over empty pockets and pockets with a tablet and
/// under film of any pigment that the recipe has, which is what Scatter sums. It is of each pack within 8 % of the
/// reference's, by groups of columns within 17 % rms in empty pockets and 22 % in filled ones, 6 % in the mean (seen:
/// 4, 14, 18 and 1 %).
#[test]
fn pockets_scatter_as_the_reference_says() {
    let mut compared = Comparison::of("pockets_scatter");
    for (class, bar) in [("missing", 0.17), ("sound", 0.22)] {
        let mut ratios = Vec::new();
        for pack in packs_of(class, 12, &[]).take(FEW_PACKS) {
            let beside = |row: &ScanLine, column: usize, side: f32| {
                let hit = &row.hits[column];
                let over_room = hit.matter.film.is_some_and(|film| film.is_over_room());
                (over_room && hit.lit && hit.seen).then(|| row.centre[column] + side)
            };
            let sides: [Places<'_>; 2] =
                [&|row, column| beside(row, column, -BESIDE_ROWS), &|row, column| beside(row, column, BESIDE_ROWS)];
            let groups = compared.of_places(&POCKET_PROFILES, &pack, sides).into_iter().flat_map(|(_, groups)| groups);
            let lit: Vec<_> = groups.flatten().filter(|[_, truth]| truth[0] > 0.0).collect();
            let mean = lit.iter().map(|[_, truth]| truth[0]).sum::<f64>() / lit.len() as f64;
            let mut sums = [0.0; 2];
            for [ours, truth] in lit.iter().filter(|[_, truth]| truth[0] > 0.3 * mean) {
                sums = [sums[0] + ours[0], sums[1] + truth[0]];
                ratios.push(libm::log(ours[0].max(1.0) / truth[0]));
            }
            let share = sums[0] / sums[1];
            println!("{class}: {share:.3} of all light");
            assert!((share - 1.0).abs() < 0.08, "{class}: {share:.3} of all light");
        }
        let [light, all] = [rms(&ratios), mean(&ratios)];
        println!("{class}: {} groups: light within {light:.3} rms, {all:+.3} in the mean", ratios.len());
        assert!(ratios.len() > 200, "{class}: {}", ratios.len());
        assert!(light < bar && all.abs() < 0.06, "{class}: light {light:.3} rms, {all:+.3} in the mean");
    }
    compared.finish();
}

/// Light 0.3 to 1.5 mm beside lines on flanks of embossed codes that lean away from the lens, which leaves through the
/// card around: within 25 % rms and 10 % in the mean by groups of columns (seen: 20 %, +2 %). As if it left through the
/// flank, 38 % and -30 %: dark dashes in Scatter.
#[test]
fn embossed_codes_scatter_as_the_reference_says() {
    let mut compared = Comparison::of("embossed_codes_scatter");
    let beside = |row: &ScanLine, column: usize| {
        let hit = &row.hits[column];
        let sealed = hit.matter.film.is_some_and(|film| film.gap_mm.is_none());
        let code = sealed && hit.surface.z < MOST_OF_CODES_MM && hit.surface.slope_y < -LEANING;
        (code && hit.lit && hit.seen).then(|| row.centre[column] - BESIDE_ROWS)
    };
    let mut ratios = Vec::new();
    for pack in changed_packs(5, &[]) {
        for (profile, groups) in compared.of_profiles(&CODE_PROFILES, &pack, beside) {
            for [ours, truth] in groups.iter().filter(|[_, truth]| truth[0] > 0.0) {
                println!("profile {profile}: {:8.0} of {:8.0} e-", ours[0], truth[0]);
                ratios.push(libm::log(ours[0].max(1.0) / truth[0]));
            }
        }
    }
    compared.finish();
    let [light, all] = [rms(&ratios), mean(&ratios)];
    println!("{} groups: light within {light:.3} rms, {all:+.3} in the mean", ratios.len());
    assert!(ratios.len() > 20, "{}", ratios.len());
    assert!(light < 0.25 && all.abs() < 0.1, "light {light:.3} rms, {all:+.3} in the mean");
}

/// Light of lines on walls that look away from the lens, which has crept through film to where it is seen, by groups of
/// columns with a tenth of the brightest's. All of it is within 12 % of the reference's, 15 % in the mean and 30 % rms
/// (seen: 4, 8 and 20 %; 59, 70 and 170 % before it was followed). Profiles lie 0.26 mm apart here, and where an edge
/// is seen is known to half of that.
#[test]
fn light_creeps_into_sight_as_the_reference_says() {
    let mut compared = Comparison::of("light_creeps_into_sight");
    let behind = |row: &ScanLine, column: usize| {
        let hit = &row.hits[column];
        (hit.lit && !hit.seen && hit.matter.film.is_some()).then(|| row.centre[column])
    };
    let (mut sums, mut ratios) = ([0.0; 2], Vec::new());
    for pack in empty_packs(10, "{log_uniform: [10, 40]}") {
        for (profile, groups) in compared.of_profiles(&FAR_PROFILES, &pack, behind) {
            let most = groups.iter().map(|[_, truth]| truth[0]).fold(0.0, f64::max);
            for [ours, truth] in groups.iter().filter(|[_, truth]| truth[0] > 0.1 * most) {
                println!("profile {profile}: {:8.0} of {:8.0} e-", ours[0], truth[0]);
                sums = [sums[0] + ours[0], sums[1] + truth[0]];
                ratios.push(libm::log(ours[0].max(1.0) / truth[0]));
            }
        }
    }
    compared.finish();
    let [all, average, apart] = [sums[0] / sums[1], mean(&ratios), rms(&ratios)];
    println!("{} groups: {all:.3} of all light, {average:+.3} in the mean, {apart:.3} rms", ratios.len());
    assert!(ratios.len() > 100, "{}", ratios.len());
    assert!((all - 1.0).abs() < 0.12 && average.abs() < 0.15 && apart < 0.3, "{all:.3}, {average:+.3}, {apart:.3} rms");
}

/// Light beside the line on the card, at the feet of pockets, two thirds of which walls and card have thrown at each
/// other: within 15 % of the reference's in the mean of six packs (seen: +8 %; -64 % without).
#[test]
fn cards_are_lit_by_walls_as_the_reference_says() {
    let mut compared = Comparison::of("cards_are_lit_by_walls");
    let at_foot = |row: &ScanLine, column: usize| {
        let open = |column: usize| row.hits[column].matter.film.is_some_and(|film| film.gap_mm.is_some());
        let near = column.saturating_sub(NEAR_FOOT)..(column + NEAR_FOOT).min(row.hits.len());
        let card = row.hits[column].matter.film.is_some() && !open(column);
        (card && near.into_iter().any(open)).then(|| row.centre[column] - ASIDE_ROWS)
    };
    let mut ratios = Vec::new();
    for pack in empty_packs(8, "{log_uniform: [12, 40]}") {
        let mut sums = [0.0; 2];
        for [ours, truth] in compared.of_profiles(&PROFILES, &pack, at_foot).into_iter().flat_map(|(_, groups)| groups)
        {
            sums = [sums[0] + ours[0], sums[1] + truth[0]];
        }
        println!("{:8.0} of {:8.0} e- at feet", sums[0], sums[1]);
        ratios.push(libm::log(sums[0] / sums[1]));
    }
    compared.finish();
    println!("{:+.3} in the mean, {:.3} rms at feet", mean(&ratios), rms(&ratios));
    assert!(mean(&ratios).abs() < 0.15, "{ratios:?}");
}

/// What smooth foil shows of the lower side of weak film, as far beyond the line on foil as that lies beyond film's:
/// within 35 % of the reference's light in rows about it, in the mean of six packs (seen: +19 %). Up to 0.2 the
/// reference's frames showed the kernel's image on top of their own.
#[test]
fn smooth_foil_shows_the_lower_side_of_film() {
    let mut compared = Comparison::of("smooth_foil_shows_the_lower_side_of_film");
    let image = |row: &ScanLine, column: usize| {
        let film = row.hits[column].matter.film?;
        let deep = film.gap_mm.is_some_and(|gap| gap > LEAST_GAP_MM) && row.hits[column].surface.slope_x.abs() < 0.3;
        let through = row.secondary.as_ref().expect("a pack has it").transmitted.centre[column];
        let away = through - row.centre[column];
        (deep && away.abs() > ASIDE_ROWS).then_some(through + away)
    };
    let smooth =
        ["film.sigma_per_mm={log_uniform: [0.3, 3]}", "foil.roughness_along=0.04", "foil.roughness_across=0.04"];
    let mut ratios = Vec::new();
    for pack in changed_packs(9, &smooth) {
        let mut sums = [0.0; 2];
        for [ours, truth] in compared.of_profiles(&PROFILES, &pack, image).into_iter().flat_map(|(_, groups)| groups) {
            sums = [sums[0] + ours[0], sums[1] + truth[0]];
        }
        println!("{:8.0} of {:8.0} e- in the image", sums[0], sums[1]);
        ratios.push(libm::log(sums[0] / sums[1]));
    }
    compared.finish();
    println!("{:+.3} in the mean, {:.3} rms of images", mean(&ratios), rms(&ratios));
    assert!(mean(&ratios).abs() < 0.3, "{ratios:?}");
}

/// What foil shows of film that leans away from the lens, in rows about its image, by groups of columns with a fifth of
/// the brightest's: all of it within 12 % of the reference's and 25 % rms (seen: 0.97 of it and 15 %).
#[test]
fn foil_shows_film_that_leans() {
    let mut compared = Comparison::of("foil_shows_film_that_leans");
    let image = |row: &ScanLine, column: usize| {
        let hit = &row.hits[column];
        let film = hit.matter.film?;
        let leans = hit.surface.slope_y < -LEANING && film.gap_mm.is_some_and(|gap| gap > LEAST_GAP_MM);
        let reflections = &row.secondary.as_ref().expect("a pack has it").reflections;
        let images = reflections.iter().filter(|image| image.in_foil && image.column == column);
        let brightest = images.max_by(|a, b| a.electrons.total_cmp(&b.electrons))?;
        leans.then_some(brightest.row)
    };
    let (mut sums, mut ratios) = ([0.0; 2], Vec::new());
    for pack in empty_packs(11, "{log_uniform: [4, 12]}") {
        for (profile, groups) in compared.of_profiles(&LEANING_PROFILES, &pack, image) {
            let most = groups.iter().map(|[_, truth]| truth[0]).fold(0.0, f64::max);
            for [ours, truth] in groups.iter().filter(|[_, truth]| truth[0] > 0.2 * most) {
                println!("profile {profile}: {:8.0} of {:8.0} e-", ours[0], truth[0]);
                sums = [sums[0] + ours[0], sums[1] + truth[0]];
                ratios.push(libm::log(ours[0].max(1.0) / truth[0]));
            }
        }
    }
    compared.finish();
    let [all, apart] = [sums[0] / sums[1], rms(&ratios)];
    println!("{} groups: {all:.3} of all light, {apart:.3} rms of images", ratios.len());
    assert!(ratios.len() > 60, "{}", ratios.len());
    assert!((all - 1.0).abs() < 0.12 && apart < 0.25, "{all:.3}, {apart:.3} rms");
}
