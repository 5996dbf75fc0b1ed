//! Constraints between lamps, the objects under them and the images that are written.

use crate::keys::settings::Settings;
use crate::subject::Subject;
use optical_bench::settings::{Channel, Lamps};
use yaml::YamlReader;

/// The map `grey` is written where there are lamps and only there, and shows objects whose light the model knows.
pub(super) fn settings(yaml: &mut YamlReader, subject: Option<Subject>, settings: &Settings) {
    let output = settings.output();
    let lists = [("output.png", &output.png), ("output.exr", &output.exr)];
    let listed = |list: &[Channel]| list.contains(&Channel::Grey);
    if settings.lamps.number == Lamps::None {
        for (path, _) in lists.into_iter().filter(|(_, list)| listed(list)) {
            let remedy = "give `lamps: {number: one}` or `two`, or remove it";
            yaml.joint_fault(&[path, "lamps.number"], "lists `grey`, and there are no lamps", remedy);
        }
        return;
    }
    if !lists.iter().any(|(_, list)| listed(list)) {
        let problem = "there are lamps, and no list of images has `grey`";
        yaml.joint_fault(&["lamps.number", "output.png", "output.exr"], problem, "add it, or remove the lamps");
    }
    if subject == Some(Subject::Blister) {
        let problem = "film mirrors and bends the light of lamps, which the map `grey` does not know";
        yaml.joint_fault(&["lamps.number"], problem, "remove the lamps from recipes about packs");
    }
}
