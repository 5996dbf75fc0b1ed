//! Scatter along one profile of a recipe's sample, by every model of light below the surface: what the kernel makes of
//! knots and borders, against the reference Monte Carlo with its standard errors.
//!
//! All models look through the same bench, free of sensor noise and speckle. The reference is walked eight independent
//! times; mean and standard error of a bin of columns are taken from these walks.

use serde_json::{Value, json};

use super::compared_model::ComparedModel;
use super::instrument::targets::TargetView;
use super::{StudyEvent, StudyProgress, StudyReport, announce, photon_document};
use drawing::chart::{Axis, Chart, Series};
use drawing::{Area, MARGIN, Page};
use optical_bench::settings::{ThesisMethod, Transport};
use pipeline::Equipment;
use recipe::{Scene, Subject};
use reference::model::Model;
use reference::path::Effort;
use scanner::optics::speckle::PatternCache;
use transport::answer::Estimate;

/// Photons of the reference Monte Carlo in all.
pub const PHOTONS: u64 = 2_000_000;
/// Independent walks of the reference Monte Carlo.
const WALKS: u64 = 8;
/// Columns averaged into one.
const BIN_COLUMNS: usize = 8;
/// Rows beside the peak that Scatter sums on each side.
const SCATTER_ROWS: usize = 8;
const CHART_PX: (u32, u32) = (1100, 420);

/// Scatter and all light of the bins along the line by one model [e-].
struct ProfileLine {
    model: ComparedModel,
    scatter: Vec<Estimate>,
    light: Vec<Estimate>,
}

/// Photons of the whole study.
pub fn workload(effort: Effort) -> u64 {
    effort.photons.div_ceil(WALKS) * WALKS
}

/// Runs the study on `profile` of `scene`.
pub fn study(scene: &Scene, profile: usize, effort: Effort, progress: StudyProgress) -> StudyReport {
    let patterns = PatternCache::new(0);
    let equipment = Equipment { patterns: &patterns, line_solvers: reference::line_solver };
    let body = pipeline::body(scene);
    let mut x = Vec::new();
    let mut expose_bins = |transport: Transport, repeat: u64| {
        let mut own = scene.clone();
        (own.transport, own.stream) = (transport, scene.stream.child("study").index(effort.seed).index(repeat));
        let view = TargetView::new(&own, body.clone(), equipment, profile..profile + 1);
        x = bin_means(view.band.line(profile).hits.iter().map(|hit| f64::from(hit.x)));
        let (light, columns) = (view.light(profile), own.size.columns);
        let column = |column: usize| light.iter().skip(column).step_by(columns).copied();
        ColumnLight {
            scatter: bin_means((0..columns).map(|c| scatter(&column(c).collect::<Vec<_>>()))),
            total: bin_means((0..columns).map(|c| column(c).sum())),
        }
    };
    let what = format!("profile {profile} of sample {}", scene.index);
    let (method, pixel_mm) = (ThesisMethod::Diffusion, 0.05);
    let models = [
        (ComparedModel::Model(Model::Path), Transport::Path { photons: effort.photons.div_ceil(WALKS) }),
        (ComparedModel::Model(Model::Diffusion), Transport::Diffusion { voxel_mm: 0.1 }),
        (ComparedModel::Model(Model::Kernel), Transport::Kernel),
        (ComparedModel::Thesis, Transport::Thesis { method, iterations: 20, pixel_mm }),
    ];
    // Diffusion and the thesis' picture know no film over air.
    let knows = |transport: &Transport| {
        scene.plan.subject() == Subject::Wood || matches!(transport, Transport::Path { .. } | Transport::Kernel)
    };
    let lines: Vec<ProfileLine> = models
        .into_iter()
        .filter(|(_, transport)| knows(transport))
        .map(|(model, transport)| {
            announce(model.name(), &what, progress);
            let repeats = if matches!(transport, Transport::Path { .. }) { WALKS } else { 1 };
            let walks: Vec<_> = (0..repeats)
                .map(|repeat| {
                    let bins = expose_bins(transport, repeat);
                    if repeats > 1 {
                        progress(StudyEvent::Done(effort.photons.div_ceil(WALKS)));
                    }
                    bins
                })
                .collect();
            let estimates = |of: fn(&ColumnLight) -> &Vec<f64>| {
                (0..walks[0].total.len()).map(|bin| Estimate::of(walks.iter().map(|walk| of(walk)[bin]))).collect()
            };
            ProfileLine { model, scatter: estimates(|walk| &walk.scatter), light: estimates(|walk| &walk.total) }
        })
        .collect();
    report(scene, profile, &x, &lines, effort)
}

/// Light of the columns, means over bins [e-].
struct ColumnLight {
    /// In the rows beside the peak that Scatter sums.
    scatter: Vec<f64>,
    /// In all rows.
    total: Vec<f64>,
}

/// Means over bins of columns.
fn bin_means(columns: impl Iterator<Item = f64>) -> Vec<f64> {
    let columns: Vec<f64> = columns.collect();
    columns.chunks(BIN_COLUMNS).map(|bin| bin.iter().sum::<f64>() / bin.len() as f64).collect()
}

/// Light of the rows of a column beside its peak that Scatter sums.
fn scatter(rows: &[f64]) -> f64 {
    let at = |k: usize| rows.get(k).copied().unwrap_or(0.0);
    let peak = (0..rows.len()).max_by(|&a, &b| at(a).total_cmp(&at(b))).unwrap_or(0);
    (1..=SCATTER_ROWS).map(|d| at(peak + d) + peak.checked_sub(d).map_or(0.0, at)).sum()
}

/// Root mean square of a model's relative difference in Scatter from the reference, over bins that the reference knows
/// to 10 % [1].
fn scatter_rms(model: &ProfileLine, reference: &ProfileLine) -> f64 {
    let pairs = model.scatter.iter().zip(&reference.scatter);
    let known = pairs.filter(|(_, reference)| reference.error > 0.0 && reference.error < 0.1 * reference.value);
    let squares: Vec<f64> = known.map(|(model, reference)| (model.value / reference.value - 1.0).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

fn report(scene: &Scene, profile: usize, x: &[f64], lines: &[ProfileLine], effort: Effort) -> StudyReport {
    let reference = &lines[0];
    let total = |line: &ProfileLine| line.light.iter().map(|e| e.value).sum::<f64>();
    let mut table = format!(
        "Profile {profile} of sample {} ({}): scatter is rows 1 to {SCATTER_ROWS} on both sides of the peak, bins of \
            {BIN_COLUMNS} columns\n\
         {:14} {:>14} {:>26}\n",
        scene.index, scene.class, "model", "light/reference", "rms of scatter to reference"
    );
    for line in lines {
        table += &format!(
            "{:14} {:14.3} {:26.3}\n",
            line.model.name(),
            total(line) / total(reference),
            scatter_rms(line, reference)
        );
    }
    let model = |line: &ProfileLine| -> Value {
        json!({
            "model": line.model.name(),
            "rms_of_scatter_to_reference": scatter_rms(line, reference),
            "scatter_e": line.scatter,
            "light_e": line.light,
        })
    };
    let mut json = photon_document("profile", effort);
    json["sample"] = json!({ "index": scene.index, "id": scene.id, "class": scene.class, "profile": profile });
    json["x_mm"] = json!(x);
    json["models"] = lines.iter().map(model).collect();
    let most = lines.iter().flat_map(|line| &line.scatter).map(|e| e.value).fold(1.0, f64::max);
    let series = lines.iter().map(|line| {
        let marks = x.iter().zip(&line.scatter).map(|(&x, e)| (x, e.value, e.error));
        let joined = line.model != ComparedModel::Model(Model::Path);
        Series { joined, ..Series::marks(line.model.colour(), marks).named(line.model.name()) }
    });
    let ends = (x.first().copied().unwrap_or(0.0), x.last().copied().unwrap_or(1.0));
    let chart = Chart::new(
        &format!("Sample {} ({}), profile {profile}: scatter along the line", scene.index, scene.class),
        Axis::even("x [mm]", ends.0, ends.1),
        Axis::even("rows 1 to 8 on both sides of the peak [e-]", 0.0, 1.05 * most),
        series.collect(),
    );
    let mut page = Page::new(CHART_PX.0 + 2 * MARGIN, CHART_PX.1 + 2 * MARGIN);
    chart.draw(&mut page, Area { left: MARGIN, top: MARGIN, width: CHART_PX.0, height: CHART_PX.1 });
    StudyReport { table, json, picture: page.0, figures: Vec::new() }
}
