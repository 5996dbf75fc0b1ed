//! Production's film, air and tablet, or foil, against the judge in the true shape of a pocket: filled, empty, touching and
//! tilted. Rows of 0.101 mm, as the reference camera sees them.

use glam::Vec3;
use procedural::blister::{Blister, Pack};
use procedural::{Body, Stream};
use sheetlight::transport::answer::{Estimate, Question};
use sheetlight::transport::kernel::layers::{Cover, Covers};
use sheetlight::transport::kernel::{BASIS, SPREAD_MM};
use sheetlight::transport::line::LineOfLight;
use sheetlight::transport::path::Effort;
use sheetlight::transport::path::body::judge;

const ROW_MM: f64 = 0.101;
const ROWS: usize = 20;
const LINE_MM: f64 = 0.05;

/// A level pack with smooth pockets.
fn pack(change: impl Fn(&mut Blister)) -> Pack {
    let mut blister = Blister::from_values(&mut |p| p.default);
    (blister.card.bow_mm, blister.card.curl_mm, blister.card.knurl_um, blister.card.code_mm) = (0.0, 0.0, 0.0, 0.0);
    (blister.pocket.bumps_um, blister.web.thinning_spread) = (0.0, 0.0);
    (blister.tablet.deboss_mm, blister.tablet.tilt_deg, blister.tablet.rattle, blister.tablet.on_edge) =
        (0.0, 0.0, 0.0, 0.0);
    change(&mut blister);
    Pack::form(Stream::root(7), &blister)
}

/// Central row, rows 1 to 8 and rows 7 to 11, each with both sides, and all light; of what entered.
fn sums(rows: &[Estimate]) -> [Estimate; 4] {
    let of = |from: usize, to: usize| {
        let mut sum = Estimate::default();
        for (i, row) in rows.iter().enumerate() {
            if (from..=to).contains(&i.abs_diff(ROWS)) {
                sum = Estimate { value: sum.value + row.value, error: sum.error.hypot(row.error) };
            }
        }
        sum
    };
    [of(0, 0), of(1, 8), of(7, 11), of(0, ROWS)]
}

/// The judge in the middle 3 mm of the fifth pocket, `off` mm beside its middle along the scan.
fn judged(pack: &Pack, photons: u64) -> [Estimate; 4] {
    let at = &pack.instances()[4];
    let middle = at.x_mm;
    let body = Body::Pack(Box::new(pack.clone()));
    let x: Vec<f32> = [-8.0, -4.0, 0.0, 4.0, 8.0].map(|d| (middle + 0.375 * d) as f32).to_vec();
    // Columns of 1.5 mm; three inner ones are read, all are lit with the rest of the pocket.
    let x: Vec<f32> = (0..7)
        .map(|i| (middle - 4.5 + 1.5 * f64::from(i)) as f32)
        .collect::<Vec<_>>()
        .into_iter()
        .chain(x.into_iter().take(0))
        .collect();
    let view = Question::default().view;
    let line = LineOfLight {
        body: &body,
        y: at.y_mm,
        line_mm: LINE_MM,
        x: &x,
        power: &[1.0; 7],
        view,
        row_mm: ROW_MM,
        rows: ROWS,
    };
    let (glow, books) = judge(&line, Effort { photons, seed: 1 });
    println!("{books:?}");
    let rows: Vec<Estimate> = (0..=2 * ROWS)
        .map(|row| {
            let cells = 7 * row + 2..7 * row + 5;
            let value = glow.light[cells.clone()].iter().map(|&v| f64::from(v)).sum::<f64>() / 3.0;
            let error = glow.error[cells].iter().map(|&v| f64::from(v).powi(2)).sum::<f64>().sqrt() / 3.0;
            Estimate { value, error }
        })
        .collect();
    sums(&rows)
}

/// Production's answer for the plane layers in the middle of that pocket.
fn produced(pack: &Pack) -> [f64; 4] {
    let at = &pack.instances()[4];
    let matter = pack.slice(at.y_mm as f32).matter(at.x_mm as f32);
    let surface = pack.slice(at.y_mm as f32).surface(at.x_mm as f32).expect("film");
    let film = matter.film.expect("film");
    println!(
        "{:?} gap {:?} thickness {:.4} slope {:.3?} metal {}",
        matter.class,
        film.gap_mm,
        film.thickness_mm,
        film.under_slope,
        film.under.gloss.is_metal()
    );
    let view = Question::default().view.as_vec3();
    let normal = Vec3::new(-surface.slope_x, -surface.slope_y, 1.0).normalize();
    let cover = Cover { medium: matter.medium, film, enter: 1.0, view_up: normal.dot(view), view };
    let answer = Covers::new().spread(&cover);
    // Light from below the film comes through nearer to the lens.
    let shift = f64::from(film.gap_mm.unwrap_or(0.0) * view.y / view.z);
    let rows: Vec<Estimate> = (0..=2 * ROWS)
        .map(|row| {
            let y = (row as f64 - ROWS as f64) * ROW_MM;
            let value = (0..BASIS)
                .map(|j| {
                    let sigma = f64::from(SPREAD_MM[j]).hypot(LINE_MM);
                    let share = |y: f64| {
                        0.5 * (libm::erf((y + 0.5 * ROW_MM) / sigma / 2f64.sqrt())
                            - libm::erf((y - 0.5 * ROW_MM) / sigma / 2f64.sqrt()))
                    };
                    f64::from(answer.enter[j] * answer.exit[j]) * share(y)
                        + f64::from(answer.through[j]) * share(y - shift)
                })
                .sum();
            Estimate::exact(value)
        })
        .collect();
    sums(&rows).map(|e| e.value)
}

#[test]
fn report() {
    let tilted = |b: &mut Blister| {
        (b.tablet.tilt_deg, b.pocket.headroom_mm, b.pocket.dome_mm) = (15.0, 2.5, 0.0);
    };
    let wide = |b: &mut Blister| {
        (b.card.width_mm, b.card.length_mm, b.card.pitch_x_mm, b.card.pitch_y_mm) = (160.0, 140.0, 50.0, 45.0);
        (b.tablet.length_mm, b.tablet.width_mm, b.pocket.clearance_mm, b.tablet.band_mm) = (20.0, 20.0, 5.0, 4.6);
        b.pocket.dome_mm = 0.0;
        b.web.thinning = 0.0;
        b.web.thickness_mm = 0.13;
    };
    let missing = |b: &mut Blister| b.defects.missing = 9.0;
    let cases: [(&str, Box<dyn Fn(&mut Blister)>); 7] = [
        ("filled", Box::new(|_: &mut Blister| ())),
        ("empty", Box::new(missing)),
        (
            "touching",
            Box::new(|b: &mut Blister| (b.pocket.headroom_mm, b.pocket.dome_mm, b.tablet.band_mm) = (0.1, 0.0, 4.6)),
        ),
        ("tilted", Box::new(tilted)),
        ("plane filled", Box::new(wide)),
        (
            "plane empty",
            Box::new(move |b: &mut Blister| {
                wide(b);
                missing(b)
            }),
        ),
        (
            "empty clear",
            Box::new(move |b: &mut Blister| {
                b.web.sigma_per_mm = 2.0;
                missing(b)
            }),
        ),
    ];
    for (name, change) in cases {
        let pack = pack(change);
        let kernel = produced(&pack);
        let start = std::time::Instant::now();
        let judge = judged(&pack, 100_000);
        println!("{name}: {:?}", start.elapsed());
        for (what, (k, j)) in ["row 0", "rows 1-8", "rows 7-11", "all"].iter().zip(kernel.into_iter().zip(judge)) {
            println!("   {what:10} kernel {k:.4}, judge {:.4} +- {:.4}, ratio {:.3}", j.value, j.error, k / j.value);
        }
    }
}
