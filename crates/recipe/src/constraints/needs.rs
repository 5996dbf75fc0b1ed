//! What parameters need to mean something, as their declarations say it ([`base::Condition`]), asked of a recipe.
//!
//! A number that has no effect under the other keys of a recipe is a fault where a recipe gives it another value than
//! its default: nothing that is written is passed over in silence. A number of an object that no sample may have is
//! noted instead: a recipe may keep it for classes to come.

use super::RecipeObject;
use super::bounds::DrawBounds;
use crate::distribution::Distribution;
use crate::keys;
use crate::keys::idle::{Idle, Wording};
use crate::keys::settings::Settings;
use crate::subject::Subject;
use base::{Need, Parameter, Unmet};
use optical_bench::settings::LogSource;
use procedural::wood::widest_tube_um;
use yaml::YamlReader;

/// The key of a recipe that says where the log comes from.
const LOG_SOURCE: &str = "log.source";
/// Reflectance above which facets are taken for metal ([`base::Gloss::is_metal`]) [1].
const MIN_METAL_REFLECTANCE: f64 = 0.5;

/// Notes settings that have no effect.
pub(super) fn refuse_settings(yaml: &mut YamlReader, subject: Option<Subject>, settings: &Settings) {
    // What an object needs is open while the subject is a fault itself.
    let known = keys::sections(subject).filter(|section| subject.is_some() || section.subjects.is_empty());
    for setting in known.flat_map(|section| section.settings) {
        if let Some((problem, remedy)) = setting.refusal(settings, yaml) {
            yaml.joint_fault(&[setting.path], problem, remedy);
        }
    }
}

/// Notes parameters that have no effect, at the top level and in each class, whose bounds are `scenes`.
pub(super) fn refuse(yaml: &mut YamlReader, object: RecipeObject, scenes: &[DrawBounds]) {
    idle(Unmet::Refused, object, scenes, &mut |key, problem, remedy| yaml.joint_fault(&[key], problem, remedy));
}

/// What parameters have no effect although a recipe may have them, each with what to do.
pub(super) fn notes(object: RecipeObject, scenes: &[DrawBounds]) -> Vec<String> {
    let mut notes = Vec::new();
    idle(Unmet::Noted, object, scenes, &mut |key, problem, remedy| {
        notes.push(format!("{key} {problem}; {remedy}"));
    });
    if object.subject == Some(Subject::Wood) {
        narrowed(scenes, &mut notes);
    }
    notes
}

/// Paths of the parameters that must be 0 while the setting at `path` is what it is, and can be another number.
pub(super) fn not_zero(settings: &Settings, scene: &DrawBounds, path: &str) -> Vec<String> {
    let unmet = |need| matches!(need, Need::While(of, words) if of == path && !words.contains(&&*word(settings, of)));
    let of_bench = keys::parameters(None).filter(|parameter| needs(parameter, Unmet::Zero).any(unmet));
    of_bench.map(Parameter::path).filter(|path| !is_zero(scene, path)).collect()
}

/// Notes tubes of wood that can be drawn wider than so many have room for.
fn narrowed(scenes: &[DrawBounds], notes: &mut Vec<String>) {
    for (count, width, tubes) in [
        ("anatomy.canals_per_mm2", "anatomy.canal_um", "canals"),
        ("anatomy.pores_per_mm2", "anatomy.pore_um", "vessels"),
    ] {
        for scene in &scenes[1..] {
            let own = [count, width].iter().any(|path| scene.overrides.contains_key(*path));
            let prefix = if own { scene.prefix.as_str() } else { "" };
            let (most, widest) = (scene.most(count), scene.most(width));
            let room = widest_tube_um(most);
            if most > 0.0 && widest > room {
                let note = format!(
                    "{prefix}{width} can be {widest:.0}, and where {most} {tubes} stand on a mm2 they are at most \
                        {room:.0} um \
                     wide: wider ones are narrowed; give less, or fewer {tubes}"
                );
                if !notes.contains(&note) {
                    notes.push(note);
                }
            }
        }
    }
}

/// The keys that have no effect, at the top level and in each class, with the reason and the remedy.
fn idle(
    unmet: Unmet,
    RecipeObject { subject, settings, parameters: base, .. }: RecipeObject,
    scenes: &[DrawBounds],
    tell: &mut dyn FnMut(String, String, String),
) {
    let (top, of_classes) = (&scenes[0], &scenes[1..]);
    for parameter in keys::parameters(subject) {
        let path = parameter.path();
        let usual = Distribution::Fixed(parameter.default);
        let lack =
            |scene: &DrawBounds| needs(parameter, unmet).find_map(|need| refusal(need, subject, settings, scene));
        if base.get(&path) != Some(&usual)
            && of_classes.iter().all(|scene| lack(scene).is_some())
            && let Some((problem, remedy)) = lack(top).or_else(|| of_classes.iter().find_map(lack))
        {
            tell(path.clone(), problem, remedy);
        }
        for scene in of_classes {
            let is_own = scene.overrides.get(&path).is_some_and(|own| *own != usual);
            if is_own && let Some((problem, remedy)) = lack(scene) {
                tell(format!("{}{path}", scene.prefix), problem, remedy);
            }
        }
    }
}

/// Paths of the parameters of which every class lacks something.
pub(super) fn without_effect(object: RecipeObject, scenes: &[DrawBounds]) -> Vec<String> {
    let RecipeObject { subject, settings, .. } = object;
    let lacks = |parameter: &Parameter, scene: &DrawBounds| {
        parameter.conditions.iter().any(|condition| refusal(condition.need, subject, settings, scene).is_some())
    };
    let of_classes = if scenes.len() > 1 { &scenes[1..] } else { scenes };
    let idle = |parameter: &&Parameter| of_classes.iter().all(|scene| lacks(parameter, scene));
    keys::parameters(subject).filter(idle).map(Parameter::path).collect()
}

/// Parameters that have no effect in any of `scenes`, each with the reason.
pub(super) fn reasons(object: RecipeObject, scenes: &[DrawBounds]) -> Vec<(String, String)> {
    let RecipeObject { subject, settings, .. } = object;
    let lack = |parameter: &Parameter, scene: &DrawBounds| {
        parameter.conditions.iter().find_map(|condition| refusal(condition.need, subject, settings, scene))
    };
    let reason = |parameter: &Parameter| {
        let lacks: Option<Vec<_>> = scenes.iter().map(|scene| lack(parameter, scene)).collect();
        Some((parameter.path(), lacks?.swap_remove(0).0))
    };
    keys::parameters(subject).filter_map(reason).collect()
}

/// What a parameter needs so as not to be `unmet`, in the order of its declaration.
fn needs(parameter: &Parameter, unmet: Unmet) -> impl Iterator<Item = Need> {
    parameter.conditions.iter().filter(move |condition| condition.unmet == unmet).map(|condition| condition.need)
}

/// Why a parameter with this need has no effect, and what to do; `None` where the need is met.
fn refusal(need: Need, subject: Option<Subject>, settings: &Settings, scene: &DrawBounds) -> Option<(String, String)> {
    let source = settings.log.source;
    match need {
        Need::On(path, words) => not_chosen(settings, path, words, Wording::OnPair),
        Need::While(path, words) => not_chosen(settings, path, words, Wording::While),
        Need::Facets => no_facets(subject?, scene).map(no_matter),
        Need::Fibres => no_fibres(subject?, scene).map(no_matter),
        Need::RoomToStand => no_room_to_stand(scene),
        _ if !is_unmet(need, subject, source, scene) => None,
        Need::Amount(path) => {
            Some((format!("has no effect while `{path}` is 0"), format!("give `{path}` too, or remove it")))
        }
        Need::Factor(path) => {
            Some((format!("has no effect while `{path}` is 1"), format!("give `{path}` too, or remove it")))
        }
        Need::Any(paths) | Need::AnyOrLog(paths, _) => {
            // What boards from elsewhere alone can have is no remedy.
            let open = paths.iter().copied().filter(|path| has_room_in(path, source));
            let open: Vec<_> = if subject == Some(Subject::Wood) { open.collect() } else { paths.to_vec() };
            let Some(first) = open.first() else {
                let problem = format!("has no effect while `{LOG_SOURCE}` is `{}`", source.name());
                return Some((problem, "remove it".to_owned()));
            };
            let named = if open.len() > 3 { &open[..1] } else { &open };
            let (zero, other) = match open.len() {
                1 => (" is 0", ""),
                count if named.len() < count => (" and all others of their kind are 0", ", or another of them"),
                _ => (" are 0", ", or another of them"),
            };
            let problem = format!("has no effect while `{}`{zero}", named.join("` and `"));
            Some((problem, format!("give `{first}` too{other}, or remove it")))
        }
        Need::Outline => {
            let what = "has no effect: an ellipse and a stadium that are as long as wide are the same circle";
            Some((what.to_owned(), "give another `tablet.width_mm`, or remove it".to_owned()))
        }
    }
}

/// Whether one sample may meet it and another not; else all samples of a dataset do, or none does.
pub(super) fn is_of_samples(need: Need, subject: Subject, source: LogSource) -> bool {
    match need {
        Need::Facets | Need::Fibres => matches!(subject, Subject::Sawtooth | Subject::Mesh),
        Need::AnyOrLog(_, sources) => !sources.contains(&source.name()),
        _ => !deciders(need).is_empty(),
    }
}

/// Paths of the parameters whose draws say whether it is met; none where settings do.
pub(crate) fn deciders(need: Need) -> Vec<&'static str> {
    match need {
        Need::On(..) | Need::While(..) => Vec::new(),
        Need::Facets => vec!["material.gloss", "material.reflectance"],
        Need::Fibres => vec!["material.k_per_mm"],
        Need::Amount(path) | Need::Factor(path) => vec![path],
        Need::Any(paths) | Need::AnyOrLog(paths, _) => paths.to_vec(),
        Need::RoomToStand => [&ROOM[..], &STANDING[..]].concat(),
        Need::Outline => vec!["tablet.length_mm", "tablet.width_mm", "tablet.shape"],
    }
}

/// Whether draws within `scene` never meet it; what settings decide counts as met.
pub(super) fn is_unmet(need: Need, subject: Option<Subject>, source: LogSource, scene: &DrawBounds) -> bool {
    match need {
        Need::On(..) | Need::While(..) => false,
        Need::Facets => subject.is_some_and(|subject| no_facets(subject, scene).is_some()),
        Need::Fibres => subject.is_some_and(|subject| no_fibres(subject, scene).is_some()),
        Need::Amount(path) => is_zero(scene, path),
        Need::Factor(path) => scene.ends(path) == [1.0, 1.0],
        Need::AnyOrLog(_, sources) if sources.contains(&source.name()) => false,
        Need::Any(paths) | Need::AnyOrLog(paths, _) => paths.iter().all(|path| is_zero(scene, path)),
        Need::RoomToStand => no_room_to_stand(scene).is_some(),
        Need::Outline => {
            let [length, width] = ["tablet.length_mm", "tablet.width_mm"].map(|path| scene.ends(path));
            length == width && length[0] == length[1] && scene.most("tablet.shape") < 2.0
        }
    }
}

/// Whether boards of a source can have the parameter `path`.
pub(crate) fn has_room_in(path: &str, source: LogSource) -> bool {
    let elsewhere = |need| matches!(need, Need::While(LOG_SOURCE, words) if !words.contains(&source.name()));
    keys::parameter(None, path).is_none_or(|parameter| !needs(parameter, Unmet::Refused).any(elsewhere))
}

/// The refusal of a parameter that needs one of some words of the setting at `path`, where another is chosen.
fn not_chosen(
    settings: &Settings,
    path: &'static str,
    words: &[&'static str],
    wording: Wording,
) -> Option<(String, String)> {
    let chosen = word(settings, path);
    (!words.contains(&&*chosen)).then(|| Idle { path, chosen, words: words.to_vec(), wording, remedy: None }.refusal())
}

/// The word of the setting at `path`.
fn word(settings: &Settings, path: &str) -> String {
    let setting = keys::settings(None).find(|setting| setting.path == path);
    let word = setting.and_then(|setting| (setting.canonical)(settings)?.as_str().map(str::to_owned));
    word.unwrap_or_else(|| panic!("no setting of words is {path}"))
}

/// What matter lacks, and what to do, as a refusal.
fn no_matter((lack, remedy): (&str, &str)) -> (String, String) {
    (format!("has no effect: {lack}"), remedy.to_owned())
}

fn is_zero(scene: &DrawBounds, path: &str) -> bool {
    scene.least(path) == 0.0 && scene.most(path) == 0.0
}

/// What a tablet that stands has room in, and what stands.
const ROOM: [&str; 3] = ["tablet.thickness_mm", "pocket.headroom_mm", "pocket.dome_mm"];
const STANDING: [&str; 2] = ["tablet.length_mm", "tablet.width_mm"];

/// Why no tablet has room to stand on its edge, and what to do: at its highest the film leaves the tablet's thickness,
/// the room above it and the roof's dome, and a tablet that stands is as high as it is wide.
fn no_room_to_stand(scene: &DrawBounds) -> Option<(String, String)> {
    let room: f64 = ROOM.map(|path| scene.most(path)).iter().sum();
    let [length, width] = STANDING.map(|path| scene.least(path));
    let stands = length.min(width);
    (stands > room).then(|| {
        let what =
            format!("has no effect: a tablet that stands is {stands} mm high, and a pocket has room for {room:.1} mm");
        (what, "give more `pocket.headroom_mm`, or remove it".to_owned())
    })
}

/// Why matter has no facets of metal, and what to do.
fn no_facets(subject: Subject, scene: &DrawBounds) -> Option<(&'static str, &'static str)> {
    match subject {
        Subject::Wood => Some(("boards have no metal", "remove it")),
        Subject::Blister => Some(("the foil of a pack lies below its film", "remove it")),
        Subject::Sawtooth | Subject::Mesh => {
            let dull =
                scene.most("material.gloss") == 0.0 || scene.most("material.reflectance") <= MIN_METAL_REFLECTANCE;
            dull.then_some((
                "the material has no facets of metal",
                "give `material.gloss` above 0 and `material.reflectance` above 0.5, or remove it",
            ))
        }
    }
}

/// Why matter has no fibres, and what to do.
fn no_fibres(subject: Subject, scene: &DrawBounds) -> Option<(&'static str, &'static str)> {
    match subject {
        Subject::Wood => None,
        Subject::Blister => Some(("packs have no fibres", "remove it")),
        Subject::Sawtooth | Subject::Mesh => (scene.most("material.k_per_mm") == 0.0)
            .then_some(("the material has no fibres", "give `material.k_per_mm` above 0, or remove it")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn needs_are_of_keys_that_are_declared() {
        for parameter in keys::parameters(None) {
            let path = parameter.path();
            for condition in parameter.conditions {
                let known = |path: &str| keys::parameter(None, path).is_some();
                assert!(deciders(condition.need).into_iter().all(known), "{path} needs {:?}", condition.need);
                let (Need::On(of, words) | Need::While(of, words)) = condition.need else { continue };
                let setting = keys::settings(None).find(|setting| setting.path == of);
                let allowed = setting.map(|setting| (setting.describe)().schema["enum"].clone()).unwrap_or_default();
                let allowed: Vec<&str> = allowed.as_array().into_iter().flatten().filter_map(|w| w.as_str()).collect();
                assert!(words.iter().all(|word| allowed.contains(word)), "{path} needs {of}: {words:?}");
                let section = of.split_once('.').map(|(section, _)| section);
                assert!(!matches!(condition.need, Need::On(..)) || section == Some(parameter.group), "{path}: {of}");
            }
        }
        // Every count of defects is asked for.
        let defects = || keys::parameters(Some(Subject::Blister)).filter(|parameter| parameter.group == "defects");
        let severity = defects().find(|parameter| !parameter.integer).expect("one is no count");
        let asked: Vec<_> = severity.conditions.iter().flat_map(|condition| deciders(condition.need)).collect();
        assert!(defects().filter(|parameter| parameter.integer).all(|count| asked.contains(&&*count.path())));
    }
}
