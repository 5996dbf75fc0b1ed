//! Constraints between a board and the picture that it is cut from.

use super::bounds::DrawBounds;
use crate::keys::settings::Settings;
use crate::subject::Subject;
use optical_bench::settings::LogSource;
use wood_picture::BoardPicture;
use yaml::{YamlReader, number_text};

/// A board from a picture has one.
pub(super) fn settings(yaml: &mut YamlReader, subject: Option<Subject>, settings: &Settings) {
    if subject == Some(Subject::Wood) && settings.log.source == LogSource::Picture {
        // A file that is named and cannot be read is a fault of its own.
        let told = ["picture.file", "picture.fibres"].iter().any(|key| yaml.has_fault_of(key));
        if settings.picture.file.asset().is_none() && settings.picture.fibres.asset().is_none() && !told {
            let remedy = "give `picture: {file: ..., pixel_mm: ...}`, or `fibres` there";
            yaml.joint_fault(&["log.source"], "is `picture`, and no picture is named", remedy);
        }
    }
}

/// Boards are no larger than the picture.
pub(super) fn scene(yaml: &mut YamlReader, picture: Option<&BoardPicture>, scene: &DrawBounds) {
    let Some(picture) = picture else { return };
    let sides =
        [("board.length_mm", "picture.pixel_mm", "long"), ("board.width_mm", "picture.pixel_across_mm", "wide")];
    for ((key, pixel, way), shown) in sides.into_iter().zip(picture.extent_mm().map(f64::from)) {
        if scene.most(key) > shown + 1.0e-3 {
            let [most, shown] = [scene.most(key), shown].map(|mm| number_text((mm * 100.0).round() / 100.0));
            let problem = format!("the board can be {most} mm {way}, and its picture shows {shown} mm");
            scene.fault(yaml, &[key], problem, &format!("make the board smaller, or correct `{pixel}`"));
        }
    }
}
