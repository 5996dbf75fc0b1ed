//! Grown stems against the scanned log: the mean of many lies where the log's own spread allows it.

use crate::gran_1::*;

/// Grown stems.
const STEMS: u64 = 500;
/// Share of the bootstrap within the interval: with 17 statistics, one in six logs of the model itself would leave one
/// of them.
const SHARE: f64 = 0.99;

/// A statistic of one stem with the interval of the scanned log; units are resampled as they may depend on each other:
/// clusters, whorls, branches or stretches of sections.
struct Row {
    name: &'static str,
    of: Box<dyn Fn(&procedural::wood::Stem) -> f64>,
    interval: [f64; 2],
}

fn per_mm(units: &[(f64, f64)]) -> f64 {
    units.iter().map(|u| u.0).sum::<f64>() / units.iter().map(|u| u.1).sum::<f64>()
}

fn mean_of(values: &[f64]) -> f64 {
    mean(values.iter().copied())
}

fn rows() -> Vec<Row> {
    let log = gran_1();
    let mut rows = Vec::new();
    macro_rules! row {
        ($name:literal, $units:expr, $statistic:expr) => {{
            let units = $units;
            let interval = bootstrap(&units(&log), SHARE, $name, $statistic);
            rows.push(Row { name: $name, of: Box::new(move |stem| $statistic(&units(stem))), interval });
        }};
    }
    fn whorls<T>(f: fn(&Cluster) -> T) -> impl Fn(&procedural::wood::Stem) -> Vec<T> {
        move |stem| clusters(stem).iter().filter(|c| c.is_whorl()).map(f).collect()
    }
    row!(
        "knots per metre",
        |stem: &procedural::wood::Stem| {
            let pitched = |c: Cluster| c.pitch.map(|pitch| (1000.0 * c.branches.len() as f64, pitch));
            clusters(stem).into_iter().filter_map(pitched).collect::<Vec<_>>()
        },
        |units: &[(f64, f64)]| per_mm(units)
    );
    row!("whorl spacing [mm]", |stem: &procedural::wood::Stem| spacings(&clusters(stem)), |v: &[f64]| mean_of(v));
    row!("its deviation [mm]", |stem: &procedural::wood::Stem| spacings(&clusters(stem)), |v: &[f64]| deviation(v));
    row!("knots per whorl", whorls(|c| c.branches.len() as f64), |v: &[f64]| mean_of(v));
    row!("height of a whorl [mm]", whorls(Cluster::height), |v: &[f64]| mean_of(v));
    row!(
        "share of clusters that are no whorl",
        |stem: &procedural::wood::Stem| {
            clusters(stem).iter().map(|c| f64::from(u8::from(!c.is_whorl()))).collect::<Vec<_>>()
        },
        |v: &[f64]| mean_of(v)
    );
    row!("mean resultant of a whorl", whorls(Cluster::resultant), |v: &[f64]| mean_of(v));
    row!("deviation of its gaps", whorls(Cluster::gaps), |v: &[Vec<f64>]| deviation(&v.concat()));
    let branch_logs = |stem: &procedural::wood::Stem| stem.branches().iter().map(log_width).collect::<Vec<_>>();
    row!("mean ln width", branch_logs, |v: &[f64]| mean_of(v));
    row!("deviation of ln width", branch_logs, |v: &[f64]| deviation(v));
    row!(
        "share that ends inside",
        |stem: &procedural::wood::Stem| {
            stem.branches().iter().map(|b| f64::from(u8::from(b.end_mm.is_finite()))).collect::<Vec<_>>()
        },
        |v: &[f64]| mean_of(v)
    );
    row!(
        "share dead at the surface",
        |stem: &procedural::wood::Stem| {
            let out = stem.branches().iter().filter(|b| b.end_mm.is_infinite());
            out.map(|b| f64::from(u8::from(b.death_mm < surface(stem, b)))).collect::<Vec<_>>()
        },
        |v: &[f64]| mean_of(v)
    );
    row!(
        "share of knots' volume [1e-4]",
        |stem: &procedural::wood::Stem| {
            let sections = sections(stem);
            let area = std::f64::consts::PI * mean(sections.iter().map(|s| s.square));
            let volumes = |c: Cluster| {
                let knots: f64 = c.branches.iter().map(|b| volume(stem, b)).sum();
                c.pitch.map(|pitch| (1.0e4 * knots, area * pitch))
            };
            clusters(stem).into_iter().filter_map(volumes).collect::<Vec<_>>()
        },
        |units: &[(f64, f64)]| per_mm(units)
    );
    // Neighbouring sections are alike over 400 mm: stretches of six are resampled, not single ones.
    let stretches = |stem: &procedural::wood::Stem| sections(stem).chunks(6).map(<[_]>::to_vec).collect::<Vec<_>>();
    row!("taper [mm/m]", stretches, |v: &[Vec<Section>]| taper(&v.concat()));
    row!("largest over smallest radius", stretches, |v: &[Vec<Section>]| mean(v.concat().iter().map(|s| s.ratio)));
    row!("wander of the pith, rms [mm]", pith_stretches, |v: &[Vec<[f64; 2]>]| {
        mean(v.concat().iter().map(|p| p[0])).sqrt()
    });
    row!("tilt over 100 mm, rms [deg]", pith_stretches, |v: &[Vec<[f64; 2]>]| {
        mean(v.concat().iter().map(|p| p[1])).sqrt().to_degrees()
    });
    rows
}

#[test]
fn grown_stems_are_like_the_scanned_log() {
    let log = gran_1();
    let stems: Vec<_> = (0..STEMS).map(grown).collect();
    let mut outside = Vec::new();
    for row in rows() {
        let values: Vec<f64> = stems.iter().map(|stem| (row.of)(stem)).filter(|v| v.is_finite()).collect();
        let (measured, grown) = ((row.of)(&log), mean(values.iter().copied()));
        let [low, high] = row.interval;
        println!(
            "{:36} measured {measured:8.3} ({low:.3} to {high:.3}), grown {grown:8.3}, from stem to stem {:.3}",
            row.name,
            deviation(&values)
        );
        if !(low..=high).contains(&grown) {
            outside.push(format!("{}: {grown} outside {low} to {high}", row.name));
        }
    }
    assert!(outside.is_empty(), "{outside:?}");
}
