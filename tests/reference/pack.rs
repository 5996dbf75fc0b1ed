//! Production's film over tablet or foil against the reference in the true shape of a pocket: filled, empty, touching,
//! tilted. Rows are 0.101 mm, as the reference camera sees them, and both sides of the line count together.

use super::kept::Kept;
use base::{Body, BodyKind, Instance, Stream};
use glam::Vec3;
use procedural::blister::{Blister, Pack};
use reference::path::Effort;
use reference::path::line_response::line_response_with_balance;
use transport::answer::{Estimate, Question};
use transport::kernel::film_stack::{FilmStack, FilmStackKernel};
use transport::kernel::{BASIS, PACK_SPREAD_MM};
use transport::line::LineSource;

const ROW_MM: f64 = 0.101;
const ROWS: usize = 20;
const LINE_MM: f64 = 0.05;
/// Photons for each column.
const PHOTONS: u64 = 6_000;
/// What is compared: the scatter, its far rows, and all light; the first row and the last.
const WINDOWS: [(&str, usize, usize); 3] = [("rows 1 to 8", 1, 8), ("rows 7 to 11", 7, 11), ("all", 0, ROWS)];

type Change = fn(&mut Blister);

/// A level pack with smooth pockets.
fn pack(change: Change) -> Pack {
    Pack::form(Stream::root(7), &numbers(change))
}

/// What it is made from.
fn numbers(change: Change) -> Blister {
    let mut blister = Blister::from_values(&mut |p| p.default);
    (blister.card.bow_mm, blister.card.curl_mm, blister.card.knurl_um, blister.card.code_mm) = (0.0, 0.0, 0.0, 0.0);
    (blister.pocket.bumps_um, blister.web.thinning_spread) = (0.0, 0.0);
    let tablet = &mut blister.tablet;
    (tablet.deboss_mm, tablet.tilt_deg, tablet.rattle, tablet.on_edge) = (0.0, 0.0, 0.0, 0.0);
    change(&mut blister);
    blister
}

/// The pocket in the middle.
fn middle(pack: &Pack) -> &Instance {
    let pockets: Vec<_> = pack.instances().iter().filter(|i| i.within == 0).collect();
    pockets[pockets.len() / 2]
}

/// Light in rows `from..=to`, of what entered.
fn window(rows: &[Estimate], from: usize, to: usize) -> Estimate {
    let inside = rows.iter().enumerate().filter(|(i, _)| (from..=to).contains(&i.abs_diff(ROWS)));
    inside.fold(Estimate::default(), |sum, (_, row)| Estimate {
        value: sum.value + row.value,
        error: sum.error.hypot(row.error),
    })
}

/// The reference in the middle 4.5 mm of the middle pocket, which is lit across `columns` of 1.5 mm, an odd number.
fn by_reference(pack: &Pack, columns: usize) -> Vec<Estimate> {
    let at = middle(pack);
    let (body, half) = (Body::new(pack.clone()), columns / 2);
    let x: Vec<f32> = (0..columns).map(|i| (at.x_mm + 1.5 * (i as f64 - half as f64)) as f32).collect();
    let line = LineSource {
        body: &body,
        y: at.y_mm,
        line_mm: LINE_MM,
        x: &x,
        power: &vec![1.0; columns],
        view: Question::default().view,
        row_mm: ROW_MM,
        rows: ROWS,
    };
    let (response, balance) = line_response_with_balance(&line, Effort { photons: PHOTONS * columns as u64, seed: 1 });
    let sum = balance.absorbed.value + balance.left.value + balance.dropped.value + balance.lost.value;
    assert!((sum - 1.0).abs() < 1e-6, "energy {sum}");
    let row = |of: &[f32], row: usize| {
        of[columns * row + half - 1..columns * row + half + 2].iter().map(|&v| f64::from(v)).collect::<Vec<_>>()
    };
    (0..=2 * ROWS)
        .map(|r| Estimate {
            value: row(&response.light, r).iter().sum::<f64>() / 3.0,
            error: row(&response.error, r).iter().map(|e| e * e).sum::<f64>().sqrt() / 3.0,
        })
        .collect()
}

/// Production's answer for the plane layers in the middle of that pocket.
fn produced(pack: &Pack) -> Vec<Estimate> {
    let at = middle(pack);
    let slice = pack.slice(at.y_mm as f32);
    let (matter, surface) = (slice.matter(at.x_mm as f32, 0.0), slice.surface(at.x_mm as f32).expect("film"));
    let film = matter.film.expect("film");
    let view = Question::default().view.as_vec3();
    let normal = Vec3::new(-surface.slope_x, -surface.slope_y, 1.0).normalize();
    let cover = FilmStack {
        medium: matter.medium,
        film,
        enter: 1.0,
        view_up: normal.dot(view),
        light_up: normal.z,
        view,
        light: Vec3::Z,
        normal,
    };
    let answer = FilmStackKernel::new().spread(&cover);
    // What comes from below is seen through the film nearer to the lens.
    let shift = f64::from(cover.seen_beside());
    let row = |row: usize| {
        let place = (row as f64 - ROWS as f64) * ROW_MM;
        let of = |j: usize| {
            let sigma = f64::from(PACK_SPREAD_MM[j]).hypot(LINE_MM) * 2f64.sqrt();
            let share = |y: f64| 0.5 * (libm::erf((y + 0.5 * ROW_MM) / sigma) - libm::erf((y - 0.5 * ROW_MM) / sigma));
            f64::from(answer.enter[j] * answer.exit[j]) * share(place)
                + f64::from(answer.passes * answer.below[j]) * share(place - shift)
        };
        Estimate::exact((0..BASIS).map(of).sum())
    };
    (0..=2 * ROWS).map(row).collect()
}

/// Within 12 % and three standard errors of the reference in every window, walls and all; but for the far rows of a
/// tilted tablet deep below its film, 35 %: the kernel has film and tablet parallel.
#[test]
fn scatter_of_pockets_is_that_of_the_reference() {
    let wide: Change = |b| {
        (b.card.columns, b.card.rows, b.pocket.dome_mm) = (1.0, 1.0, 0.0);
        (b.tablet.length_mm, b.tablet.width_mm, b.tablet.shape, b.defects.missing) = (30.0, 20.0, 1.0, 1.0);
    };
    let cases: [(&str, f64, usize, Change); 5] = [
        ("filled", 0.12, 7, |_| ()),
        ("empty", 0.12, 7, |b| b.defects.missing = 9.0),
        ("touching", 0.12, 7, |b| (b.pocket.headroom_mm, b.pocket.dome_mm, b.tablet.band_mm) = (0.1, 0.0, 4.6)),
        ("tilted", 0.35, 7, |b| (b.tablet.tilt_deg, b.pocket.headroom_mm, b.pocket.dome_mm) = (15.0, 2.5, 0.0)),
        ("wide and empty", 0.12, 19, wide),
    ];
    let (mut faults, mut kept) = (Vec::new(), Kept::of("pockets"));
    for (number, (name, far, columns, change)) in cases.into_iter().enumerate() {
        let (kernel, pack) = (produced(&pack(change)), pack(change));
        let question = (middle(&pack), columns, PHOTONS, numbers(change));
        let reference = || by_reference(&pack, columns).iter().flat_map(|row| [row.value, row.error]).collect();
        let reference = match number {
            0 => kept.still_says(name, &question, reference),
            _ => kept.says(name, &question, reference),
        };
        let reference: Vec<Estimate> =
            reference.chunks(2).map(|row| Estimate { value: row[0], error: row[1] }).collect();
        for (what, from, to) in WINDOWS {
            let (k, j) = (window(&kernel, from, to).value, window(&reference, from, to));
            println!("{name}, {what}: {k:.4} against {:.4} +- {:.4}, {:.3}", j.value, j.error, k / j.value);
            let bar = if from == 7 { far } else { 0.12 };
            if (k - j.value).abs() > bar * j.value + 3.0 * j.error {
                faults.push(format!("{name}, {what}: {k} against {j:?}"));
            }
        }
    }
    kept.finish();
    assert!(faults.is_empty(), "{faults:#?}");
}
