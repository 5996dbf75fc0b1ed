//! A line of light on the fifteen media of docs/physics.md: where it comes out again, by every model.
//!
//! Rows and line are the table's: 0.101 mm, standard deviation 0.05 mm. Errors of sums over rows take rows as
//! independent, which photons that leave in one row or another are but for a share of their number.

use serde_json::{Value, json};

use super::media::{WOODS, Wood};
use super::{Report, Watch, ask, head, lines_page, photons, told};
use crate::transport::answer::{Answer, Estimate, Question, Side};
use crate::transport::model::Model;
use crate::transport::path::Effort;

/// Photons for each medium unless told otherwise.
pub const PHOTONS: u64 = 300_000;
/// Rows on either side of the central one.
pub(super) const ROWS: usize = 20;

/// A medium and what the models say of it, in the order of [`Model::ALL`].
pub(super) struct Case {
    pub wood: Wood,
    pub answers: Vec<Result<Answer, String>>,
}

/// What is read off a line spread.
const FIGURES: [(&str, &str); 5] = [
    ("reflectance", "R"),
    ("towards_lens_over_reflectance", "lens / R"),
    ("rows_1_to_8", "S(1,8)"),
    ("rows_7_to_11", "S7(7,5)"),
    ("asymmetry_rows_1_to_8", "asymmetry"),
];

/// The numbers of [`FIGURES`].
fn figures(answer: &Answer) -> [Estimate; FIGURES.len()] {
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
        Estimate { value: answer.rows(from, to, Side::Both), error }
    };
    let near = sum(1, 8);
    let (ahead, behind) = (answer.rows(1, 8, Side::Ahead), answer.rows(1, 8, Side::Behind));
    let asymmetry = Estimate { value: (ahead - behind) / near.value, error: near.error / near.value };
    [r, lens, near, sum(7, 11), asymmetry]
}

/// Photons that [`study`] walks.
pub fn work(effort: Effort) -> u64 {
    photons(effort, WOODS.len() as u64)
}

/// Makes the study.
pub fn study(effort: Effort, watch: Watch) -> Report {
    let question = Question { rows: ROWS, cells: 0, angles: 0, ..Question::default() };
    let answers = |wood: &Wood, model: Model| {
        ask(model, wood.name, (&wood.stack(), &question), effort, watch).map_err(|refusal| refusal.to_string())
    };
    let case =
        |wood: &Wood| Case { wood: *wood, answers: Model::ALL.map(|model| answers(wood, model)).into_iter().collect() };
    let cases: Vec<Case> = WOODS.iter().map(case).collect();
    Report { table: table(&cases), json: json(&cases, effort), picture: lines_page::draw(&cases) }
}

fn table(cases: &[Case]) -> String {
    let mut text =
        String::from("Shares of a line's energy; asymmetry: rows 1 to 8 ahead less behind, over their sum.\n");
    text += "In brackets what a model has over the judge (asymmetry: less the judge's).\n";
    text += &format!("  {:20}{:10}", "medium", "model");
    for (_, name) in FIGURES {
        text += &format!("{name:>19}");
    }
    text += "\n";
    for case in cases {
        let judge = case.answers.first().and_then(|answer| answer.as_ref().ok()).map(figures);
        for (model, answer) in Model::ALL.into_iter().zip(&case.answers) {
            text += &format!("  {:20}{:10}", case.wood.name, model.name());
            match answer {
                Ok(answer) => {
                    for (i, figure) in figures(answer).into_iter().enumerate() {
                        let judge = judge.filter(|_| model != Model::Path).map(|judge| judge[i].value);
                        text += &format!("{:>19}", words(i, figure, judge));
                    }
                }
                Err(reason) => text += &format!("  refuses: {reason}"),
            }
            text += "\n";
        }
    }
    text
}

/// A number beside what the judge has.
fn words(i: usize, figure: Estimate, judge: Option<f64>) -> String {
    let own = told(figure, 4);
    match judge {
        Some(judge) if FIGURES[i].1 == "asymmetry" => format!("{own} ({:+.3})", figure.value - judge),
        Some(judge) => format!("{own} ({:+.1}%)", 100.0 * (figure.value / judge - 1.0)),
        None => own,
    }
}

fn json(cases: &[Case], effort: Effort) -> Value {
    let mut document = head("transport", effort);
    let question = Question::default();
    document["row_mm"] = json!(question.row_mm);
    document["line_sd_mm"] = json!(question.line_mm);
    let answer = |(model, answer): (Model, &Result<Answer, String>)| match answer {
        Ok(answer) => {
            let mut shown = json!({ "model": model.name() });
            for ((key, _), figure) in FIGURES.into_iter().zip(figures(answer)) {
                shown[key] = json!(figure);
            }
            shown["line"] = json!(answer.line);
            shown
        }
        Err(reason) => json!({ "model": model.name(), "refuses": reason }),
    };
    let case = |case: &Case| {
        let [mu_a, sigma_i, sigma_c, n] = case.wood.coefficients;
        json!({
            "medium": case.wood.name,
            "mu_a_per_mm": mu_a, "sigma_i_per_mm": sigma_i, "sigma_c_per_mm": sigma_c, "n": n,
            "dive_deg": case.wood.dive, "azimuth_deg": case.wood.azimuth,
            "models": Model::ALL.into_iter().zip(&case.answers).map(answer).collect::<Vec<_>>(),
        })
    };
    document["media"] = cases.iter().map(case).collect();
    document
}
