//! Samples of little use, which are what their recipe makes: each shortfall is a warning and no fault.

use dataset::validate::Code::{self, *};

use super::place::{inspect_rows, of_recipe, write_as};
use test_support::program::recipe;

#[test]
fn samples_of_little_use_are_warned_of() {
    let cases: [(&[[&str; 2]], Code); 4] = [
        (&[["\n  lead_in_mm: 1.5", "\n  lead_in_mm: 100"]], ObjectOutOfView),
        (&[["power_mw: 50", "power_mw: 0.1"]], HardlyMeasured),
        // A fan that ends on the object, in the field of the whole recipe.
        (
            &[
                ["step_mm: 0.068", "step_mm: 0.36"],
                ["pixel_um: 6", "pixel_um: 24"],
                ["power_mw: 50", "power_mw: 1\n  fan_angle_deg: 1"],
            ],
            PartlyMeasured,
        ),
        (&[["power_mw: 50", "power_mw: 3000"]], Saturated),
    ];
    for (changes, code) in cases {
        let (head, samples) = of_recipe(&recipe(changes), 2);
        for report in inspect_rows(write_as(head, samples).path(), 0..1) {
            let told = report.warnings.iter().filter(|found| found.code == code).count();
            assert!(report.is_clean() && told > 0, "{}:\n{report}", code.name());
        }
    }
}
