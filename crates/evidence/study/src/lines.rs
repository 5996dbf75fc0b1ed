//! Line spread of fifteen media: reflectance, radiance factor towards the lens, shares of rows and asymmetry by every
//! model of transport, on the media of docs/theory/physics.md.
//!
//! Rows are 0.101 mm wide and the line has a standard deviation of 0.05 mm, as in that table. Errors of sums over rows
//! take rows as independent; the correlation of a multinomial count is neglected.

use image::RgbImage;
use serde_json::{Value, json};

use super::compared_model::ComparedModel;
use super::{StudyProgress, StudyReport, ask, describe, photon_document, total_photons};
use drawing::chart::{Axis, Chart, Series};
use drawing::{Area, MARGIN, Page};
use reference::media::{WOODS, WoodMedium};
use reference::model::Model;
use reference::path::Effort;
use transport::answer::{Answer, Estimate, LineSide, Question};

/// Default number of photons for each medium.
pub const PHOTONS: u64 = 300_000;
/// Rows on either side of the central one.
const ROWS_ASIDE: usize = 20;

/// A medium and the answers of the models, in the order of [`Model::ALL`].
struct MediumCase {
    wood: WoodMedium,
    answers: [Result<Answer, String>; Model::ALL.len()],
}

/// How far the kernel may be off the reference Monte Carlo.
#[derive(Debug, Clone, Copy)]
pub enum Tolerance {
    /// Difference from the reference.
    Absolute(f64),
    /// Difference over the reference [1].
    Relative(f64),
}

/// Where a number of the kernel stands against its tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Within it, two standard errors too.
    Within,
    /// Beyond it, less two standard errors.
    Beyond,
    /// Two standard errors reach over the tolerance.
    Open,
}

/// A number that is measured on a line spread.
#[derive(Debug, Clone, Copy)]
pub struct SpreadFigure {
    key: &'static str,
    /// Name in tables.
    pub name: &'static str,
    /// How far the kernel may be off.
    pub tolerance: Tolerance,
}

const fn figure(key: &'static str, name: &'static str, tolerance: Tolerance) -> SpreadFigure {
    SpreadFigure { key, name, tolerance }
}

/// What the kernel is held to on each medium.
pub const FIGURES: [SpreadFigure; 5] = [
    figure("reflectance", "R", Tolerance::Absolute(0.01)),
    figure("towards_lens_over_reflectance", "lens / R", Tolerance::Relative(0.05)),
    figure("rows_1_to_8", "S(1,8)", Tolerance::Relative(0.05)),
    figure("rows_7_to_11", "S(7,5)", Tolerance::Relative(0.05)),
    figure("asymmetry_rows_1_to_8", "asymmetry", Tolerance::Absolute(0.03)),
];

impl Tolerance {
    /// Difference of `figure` from the reference, absolute or relative.
    fn off(self, figure: Estimate, reference: Estimate) -> Estimate {
        let (f, j) = (figure.value, reference.value);
        match self {
            Self::Absolute(_) => Estimate { value: f - j, error: libm::hypot(figure.error, reference.error) },
            Self::Relative(_) => {
                Estimate { value: f / j - 1.0, error: libm::hypot(figure.error, reference.error * f / j) / j.abs() }
            }
        }
    }

    /// Where `figure` of the kernel stands against that of the reference.
    pub fn verdict(self, figure: Estimate, reference: Estimate) -> Verdict {
        let (Self::Absolute(most) | Self::Relative(most)) = self;
        let Estimate { value, error } = self.off(figure, reference);
        if value.abs() + 2.0 * error <= most {
            Verdict::Within
        } else if value.abs() - 2.0 * error > most {
            Verdict::Beyond
        } else {
            Verdict::Open
        }
    }

    fn words(self) -> String {
        match self {
            Self::Absolute(most) => format!("{most}"),
            Self::Relative(most) => format!("{} %", 100.0 * most),
        }
    }
}

impl Verdict {
    /// Name in tables and documents.
    pub fn name(self) -> &'static str {
        match self {
            Self::Within => "ok",
            Self::Beyond => "off",
            Self::Open => "?",
        }
    }
}

impl MediumCase {
    fn answer(&self, model: Model) -> Option<&Answer> {
        Model::ALL.into_iter().zip(&self.answers).find(|(known, _)| *known == model)?.1.as_ref().ok()
    }

    /// The kernel's verdicts in the order of [`FIGURES`]; `None` where it or the reference refuses.
    pub(crate) fn verdicts(&self) -> Option<[Verdict; FIGURES.len()]> {
        let (reference, kernel) = (figures(self.answer(Model::Path)?), figures(self.answer(Model::Kernel)?));
        Some(std::array::from_fn(|i| FIGURES[i].tolerance.verdict(kernel[i], reference[i])))
    }
}

/// The numbers of [`FIGURES`].
pub fn figures(answer: &Answer) -> [Estimate; FIGURES.len()] {
    let r = answer.reflectance;
    let lens = answer.towards_lens.map_or(Estimate::exact(f64::NAN), |towards| {
        let value = towards.value / r.value;
        let relative = libm::hypot(towards.error / towards.value, r.error / r.value);
        Estimate { value, error: value * relative }
    });
    let sum = |from: usize, to: usize| {
        let centre = answer.line.len() / 2;
        let rows = (from..=to.min(centre)).flat_map(|k| [answer.line[centre - k], answer.line[centre + k]]);
        let error = rows.map(|row| row.error * row.error).sum::<f64>().sqrt();
        Estimate { value: answer.rows(from, to, LineSide::Both), error }
    };
    let near = sum(1, 8);
    let (ahead, behind) = (answer.rows(1, 8, LineSide::Ahead), answer.rows(1, 8, LineSide::Behind));
    let asymmetry = Estimate { value: (ahead - behind) / near.value, error: near.error / near.value };
    [r, lens, near, sum(7, 11), asymmetry]
}

/// Photons of the whole study.
pub fn workload(effort: Effort) -> u64 {
    total_photons(effort, WOODS.len() as u64)
}

/// Runs the study.
pub fn study(effort: Effort, progress: StudyProgress) -> StudyReport {
    let question = Question { rows: ROWS_ASIDE, cells: 0, angles: 0, ..Question::default() };
    let cases = WOODS.map(|wood| {
        let of = (&wood.stack(), &question);
        MediumCase { wood, answers: Model::ALL.map(|model| ask(model, wood.name, of, effort, progress)) }
    });
    StudyReport { table: table(&cases), json: json(&cases, effort), picture: draw(&cases), figures: Vec::new() }
}

fn table(cases: &[MediumCase]) -> String {
    let mut text =
        String::from("Shares of a line's energy; asymmetry: rows 1 to 8 ahead less behind, over their sum.\n");
    text += "In brackets what a model has over the reference, `path`. Published Monte Carlo figures\n";
    text += "(docs/theory/physics.md) are those of an earlier walk: R agrees, S(1,8) of clear wood was 0.420.\n";
    text += "ok, off: the kernel against its bar; ?: two standard errors of the reference reach over it.\n";
    text += &format!("  {:20}{:10}", "medium", "model");
    for SpreadFigure { name, .. } in FIGURES {
        text += &format!("{name:>22}");
    }
    text += "\n";
    for case in cases {
        let reference = case.answer(Model::Path).map(figures);
        for (model, answer) in Model::ALL.into_iter().zip(&case.answers) {
            let verdicts = case.verdicts().filter(|_| model == Model::Kernel);
            text += &format!("  {:20}{:10}", case.wood.name, model.name());
            match answer {
                Ok(answer) => {
                    for (i, figure) in figures(answer).into_iter().enumerate() {
                        let reference = reference.filter(|_| model != Model::Path).map(|reference| reference[i]);
                        let verdict = verdicts.map_or("", |verdicts| verdicts[i].name());
                        text += &format!("{:>18} {verdict:3}", words(FIGURES[i].tolerance, figure, reference));
                    }
                }
                Err(reason) => text += &format!("  refuses: {reason}"),
            }
            text = text.trim_end().to_owned() + "\n";
        }
    }
    text + &kernel_summary(cases)
}

/// For how many media the kernel is within each tolerance.
fn kernel_summary(cases: &[MediumCase]) -> String {
    let verdicts: Vec<_> = cases.iter().filter_map(MediumCase::verdicts).collect();
    let each = FIGURES.iter().enumerate().map(|(i, SpreadFigure { name, tolerance, .. })| {
        let count = |verdict: Verdict| verdicts.iter().filter(|verdicts| verdicts[i] == verdict).count();
        let open = if count(Verdict::Open) > 0 { format!(", {} open", count(Verdict::Open)) } else { String::new() };
        format!("{name} to {}: {} of {}{open}", tolerance.words(), count(Verdict::Within), cases.len())
    });
    let each: Vec<_> = each.collect();
    format!("kernel within its bars: {}\n", each.join("; "))
}

/// A number, and its difference from the reference in brackets.
fn words(tolerance: Tolerance, figure: Estimate, reference: Option<Estimate>) -> String {
    let own = describe(figure, 4);
    match reference.map(|reference| (tolerance, tolerance.off(figure, reference).value)) {
        Some((Tolerance::Absolute(_), off)) => format!("{own} ({off:+.4})"),
        Some((Tolerance::Relative(_), off)) => format!("{own} ({:+.1}%)", 100.0 * off),
        None => own,
    }
}

fn json(cases: &[MediumCase], effort: Effort) -> Value {
    let mut document = photon_document("transport", effort);
    let question = Question::default();
    document["row_mm"] = json!(question.row_mm);
    document["line_sd_mm"] = json!(question.line_mm);
    let answer = |(model, answer): (Model, &Result<Answer, String>)| match answer {
        Ok(answer) => {
            let mut shown = json!({ "model": model.name() });
            for (SpreadFigure { key, .. }, figure) in FIGURES.into_iter().zip(figures(answer)) {
                shown[key] = json!(figure);
            }
            shown["line"] = json!(answer.line);
            shown
        }
        Err(reason) => json!({ "model": model.name(), "refuses": reason }),
    };
    let case = |case: &MediumCase| {
        let [mu_a, sigma_i, sigma_c, n] = case.wood.coefficients;
        json!({
            "medium": case.wood.name,
            "mu_a_per_mm": mu_a, "sigma_i_per_mm": sigma_i, "sigma_c_per_mm": sigma_c, "n": n,
            "dive_deg": case.wood.dive, "azimuth_deg": case.wood.azimuth,
            "models": Model::ALL.into_iter().zip(&case.answers).map(answer).collect::<Vec<_>>(),
            "kernel_marks": case.verdicts().map(|verdicts| {
                let each = FIGURES.iter().zip(verdicts).map(|(figure, verdict)| (figure.key.to_owned(),
                    json!(verdict.name())));
                Value::Object(each.collect())
            }),
        })
    };
    document["media"] = cases.iter().map(case).collect();
    document
}

const CHART_COLUMNS: u32 = 3;
/// Width and height of a chart [px].
const CHART_PX: (u32, u32) = (430, 270);
const HEADING_PX: u32 = 46;

fn draw(cases: &[MediumCase]) -> RgbImage {
    let rows = (cases.len() as u32).div_ceil(CHART_COLUMNS);
    let mut page =
        Page::new(MARGIN + CHART_COLUMNS * (CHART_PX.0 + MARGIN), HEADING_PX + rows * (CHART_PX.1 + MARGIN) + MARGIN);
    let words = "A line of light: share of its energy that leaves in each row along the motion. Below each chart the \
        kernel \
                 against its bars: ok, off, or ? where the reference's error hides it";
    page.words(MARGIN, 20, words);
    page.words_in(MARGIN, 36, kernel_summary(cases).trim_end(), ComparedModel::Model(Model::Kernel).colour());
    for (i, case) in cases.iter().enumerate() {
        let (row, column) = (i as u32 / CHART_COLUMNS, i as u32 % CHART_COLUMNS);
        let (left, top) = (MARGIN + column * (CHART_PX.0 + MARGIN), HEADING_PX + row * (CHART_PX.1 + MARGIN));
        let area = Area { left, top, width: CHART_PX.0, height: CHART_PX.1 };
        chart(case).draw(&mut page, area);
    }
    page.0
}

fn chart(case: &MediumCase) -> Chart {
    let series = Model::ALL.into_iter().zip(&case.answers).filter_map(|(model, answer)| {
        let answer = answer.as_ref().ok()?;
        let at = |(row, share): (usize, &Estimate)| {
            ((row as f64 - ROWS_ASIDE as f64) * answer.row_mm, share.value, share.error)
        };
        let marks = Series::marks(ComparedModel::Model(model).colour(), answer.line.iter().enumerate().map(at));
        Some(Series { joined: !model.walks(), ..marks.named(model.name()) })
    });
    let [mu_a, s, k, n] = case.wood.coefficients;
    Chart {
        title: format!("{}: mu_a {mu_a}, sigma_i {s}, sigma_c {k}, n {n}", case.wood.name),
        x: Axis::even("y [mm]", -2.1, 2.1),
        y: Axis::log("share of the energy in a row", 1e-4, 0.5),
        series: series.collect(),
        foot: (verdicts(case), ComparedModel::Model(Model::Kernel).colour()),
    }
}

/// Verdict of each figure of the kernel.
fn verdicts(case: &MediumCase) -> String {
    let each = |verdicts| {
        FIGURES.iter().zip(verdicts).map(|(figure, verdict): (_, Verdict)| [figure.name, verdict.name()].join(" "))
    };
    case.verdicts().map_or_else(String::new, |verdicts| each(verdicts).collect::<Vec<_>>().join("  "))
}
