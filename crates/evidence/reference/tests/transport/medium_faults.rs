//! Purpose: whatever stands in a medium file, reading it gives a medium in range or faults with a place, and never
//! panics.

use std::fs;
use std::path::Path;

use reference::medium::LayeredMedium;
use reference::model::Model;
use reference::path::Effort;
use transport::answer::Question;
use transport::stack::Scattering;

/// What a value is replaced by.
const WEIRD: [&str; 16] = [
    "",
    "~",
    ".nan",
    ".inf",
    "-.inf",
    "-1",
    "0",
    "1e999",
    "1e-320",
    "99999999999999999999",
    "true",
    "x",
    "[]",
    "{}",
    "[1, [2]]",
    "&a [*a]",
];

fn examples() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../recipes/media");
    let files = fs::read_dir(folder).expect("recipes/media").map(|entry| entry.expect("an entry").path());
    let yaml = files.filter(|path| path.extension().is_some_and(|end| end == "yaml"));
    yaml.map(|path| fs::read_to_string(path).expect("a text")).collect()
}

/// Everything that a reader promises about what it accepts.
fn in_range(medium: &LayeredMedium) -> bool {
    let last = medium.stack.layers.len() - 1;
    let fine = medium.stack.layers.iter().enumerate().all(|(i, layer)| {
        let scattering = match layer.scattering {
            Scattering::Isotropic { mu_s, g } => mu_s >= 0.0 && g.abs() < 1.0,
            Scattering::Tensor { mu_s, g } => mu_s.min_element() >= 0.0 && mu_s.is_finite() && g.abs() < 1.0,
            Scattering::Fibres { sigma_i, sigma_c, turn, axis, dispersion } => {
                sigma_i.min(sigma_c) >= 0.0
                    && turn.mean_cosine().abs() < 1.0
                    && (axis.length() - 1.0).abs() < 1e-9
                    && (0.0..1.0).contains(&dispersion)
            }
        };
        let thick = layer.thickness > 0.0 && (layer.thickness.is_finite() || i == last);
        scattering && thick && layer.mu_a >= 0.0 && layer.mu_a.is_finite() && (1.0..=4.0).contains(&layer.n)
    });
    let question = &medium.question;
    let view = (question.view.length() - 1.0).abs() < 1e-9 && question.view.z > 0.0;
    fine && view && question.row_mm > 0.0 && question.cell_mm > 0.0 && question.line_mm >= 0.0
}

#[test]
fn damaged_media_are_read_or_refused() {
    let (mut read, mut refused) = (0, 0);
    for text in examples() {
        let values = text.match_indices(": ").map(|(at, _)| at + 2).filter(|at| {
            let line = text[..*at].rsplit('\n').next().unwrap_or_default();
            !line.contains('#')
        });
        for from in values {
            let rest = &text[from..];
            let to = from + rest.find([',', '}', ']', '\n']).unwrap_or(rest.len());
            for weird in WEIRD {
                let damaged = format!("{}{weird}{}", &text[..from], &text[to..]);
                match LayeredMedium::parse("m.yaml", &damaged) {
                    Ok(medium) => {
                        assert!(in_range(&medium), "{damaged}");
                        // Refusing is well, panicking is not.
                        let question = Question { cells: medium.question.cells.min(2), ..medium.question };
                        let _ = Model::Kernel.ask(&medium.stack, &question, Effort::default(), &|_| ());
                        read += 1;
                    }
                    Err(faults) => {
                        assert!(
                            !faults.list.is_empty() && faults.list.iter().all(|fault| fault.place.line > 0),
                            "{damaged}"
                        );
                        refused += 1;
                    }
                }
            }
        }
        // A file that stops anywhere, on any letter.
        for (end, _) in text.char_indices().step_by(3) {
            if let Ok(medium) = LayeredMedium::parse("m.yaml", &text[..end]) {
                assert!(in_range(&medium), "{}", &text[..end]);
            }
        }
    }
    println!("{read} read, {refused} refused");
    assert!(read > 50 && refused > 500, "{read} read, {refused} refused");
}
