//! Constraints between the model of light and the objects and media that it knows.

use super::bounds::DrawBounds;
use crate::keys::settings::Settings;
use crate::subject::Subject;
use base::{KERNEL_INDICES, KERNEL_LEAST_SHARE};
use optical_bench::settings::TransportName;
use procedural::wood::LEAST_SIGMA_I;
use yaml::{YamlReader, number_text};

/// Whether a model can spread light in such objects: those that need one medium without air know no pack, and all but
/// the kernel ask for a height field, which a mesh need not be.
fn knows(model: TransportName, subject: Subject) -> bool {
    match subject {
        Subject::Wood | Subject::Sawtooth => true,
        Subject::Blister => matches!(model, TransportName::Kernel | TransportName::Path),
        Subject::Mesh => model == TransportName::Kernel,
    }
}

/// The model that is chosen can spread light in the recipe's objects.
pub(super) fn check(yaml: &mut YamlReader, subject: Option<Subject>, settings: &Settings) {
    let model = settings.transport.model;
    if let Some(subject) = subject.filter(|subject| !knows(model, *subject)) {
        let (lack, remedy) = match subject {
            Subject::Mesh => ("no part that overhangs", "give `kernel`"),
            Subject::Wood | Subject::Blister | Subject::Sawtooth => {
                ("no film over air", "give `kernel`, or `path` for single profiles")
            }
        };
        let problem = format!("`{}` knows {lack}, and the subject is `{}`", model.name(), subject.name());
        yaml.joint_fault(&["transport.model", "transport"], problem, remedy);
    }
}

/// Media that the kernel's tables span: what lies beyond them would be clamped.
pub(super) fn media(yaml: &mut YamlReader, subject: Option<Subject>, settings: &Settings, scene: &DrawBounds) {
    if settings.transport.model != TransportName::Kernel {
        return;
    }
    // Parts from files have no other model.
    let otherwise =
        if subject == Some(Subject::Mesh) { "" } else { ", or give `transport: path`, which has no such limit" };
    match subject {
        Some(Subject::Wood) => {
            let clear = ["media.earlywood_sigma_i_per_mm", "media.earlywood_k_per_mm"];
            let (sigma, k) = (scene.least(clear[0]), scene.most(clear[1]));
            let kind = |(what, [sigma_ratio, k_ratio]): (&'static str, [&'static str; 2])| {
                let keys = vec![sigma_ratio, k_ratio];
                let (sigma_ratio, k_ratio) = (scene.least(sigma_ratio), scene.most(k_ratio));
                // Rot is most severe as far beyond the class table as clear wood is before it.
                let severe = |ratio: f64| if what == "rot" { 2.0 * ratio - 1.0 } else { ratio };
                let sigma = (sigma * sigma_ratio.min(severe(sigma_ratio))).max(LEAST_SIGMA_I.into());
                (what, keys, sigma / (sigma + k * k_ratio.max(severe(k_ratio))))
            };
            let kinds = [
                ("latewood", ["media.latewood_sigma_i_ratio", "media.latewood_k_ratio"]),
                ("knots", ["media.knot_sigma_i_ratio", "media.knot_k_ratio"]),
                ("rot", ["media.rot_sigma_i_ratio", "media.rot_k_ratio"]),
            ];
            let all = [("earlywood", Vec::new(), sigma / (sigma + k))].into_iter().chain(kinds.map(kind));
            let least = all.min_by(|a, b| a.2.total_cmp(&b.2));
            if let Some((what, ratios, least)) = least {
                let keys: Vec<&str> = clear.into_iter().chain(ratios).collect();
                share(yaml, scene, &keys, least, what, otherwise);
            }
        }
        Some(Subject::Sawtooth | Subject::Mesh) => {
            let keys = ["material.sigma_i_per_mm", "material.k_per_mm"];
            let (sigma, k) = (scene.least(keys[0]), scene.most(keys[1]));
            share(yaml, scene, &keys, sigma / (sigma + k), "the material", otherwise);
            let most = scene.most("material.n_eff");
            if most > f64::from(KERNEL_INDICES[1]) {
                let (most, limit) =
                    (number_text(most), number_text(f64::from(KERNEL_INDICES[1] * 1000.0).round() / 1e3));
                let problem = format!("can be {most}, and the tables of `transport: kernel` end at {limit}");
                scene.fault(yaml, &["material.n_eff"], problem, &format!("give at most {limit}{otherwise}"));
            }
        }
        Some(Subject::Blister) | None => {}
    }
}

/// The isotropic part of scattering is no less than the kernel's table has.
fn share(yaml: &mut YamlReader, scene: &DrawBounds, keys: &[&str], share: f64, what: &str, otherwise: &str) {
    let least = f64::from(KERNEL_LEAST_SHARE);
    if share < least - 1e-6 {
        let problem = format!(
            "the isotropic part of the scattering of {what} can be {:.1} %, and the tables of `transport: kernel` \
                begin at {:.0} %",
            100.0 * share,
            100.0 * least
        );
        scene.fault(yaml, keys, problem, &format!("raise sigma_i or lower k{otherwise}"));
    }
}

/// The names of the models that can spread light in objects of `subject`.
pub(crate) fn models(subject: Subject) -> Vec<&'static str> {
    TransportName::ALL.into_iter().filter(|model| knows(*model, subject)).map(TransportName::name).collect()
}
