//! Recipe words: what the recipe of a dataset says of its objects, for the card, Croissant metadata and the page of
//! `gen report`. What the recipe leaves open is left open here too.

use output_schema::DatasetHead;
use serde_json::Value;

/// Absorption from which on nothing comes back from below the surface: that of metal [1/mm].
const OPAQUE_PER_MM: f64 = 1000.0;

/// What the scans are of: "scans of ...".
pub fn objects_in_words(head: &DatasetHead) -> String {
    match head.subject.as_str() {
        "wood" => format!("boards of {}{}", kind_of_wood(head), origin_of_boards(head)),
        "blister" => "blister packs".into(),
        "sawtooth" => "a saw-tooth for calibration".into(),
        "mesh" => "a part from a file of triangles".into(),
        other => other.into(),
    }
}

/// Hardwoods are those with vessels; of woods without them, those with resin canals are softwoods. Wood with neither
/// may be any whose cells are not drawn.
fn kind_of_wood(head: &DatasetHead) -> &'static str {
    let (vessels, canals) = (bounds(head, "anatomy", "pores_per_mm2"), bounds(head, "anatomy", "canals_per_mm2"));
    let all_have = |bounds: &[[f64; 2]]| !bounds.is_empty() && bounds.iter().all(|[least, _]| *least > 0.0);
    let none_has = |bounds: &[[f64; 2]]| !bounds.is_empty() && bounds.iter().all(|[_, most]| *most <= 0.0);
    match () {
        () if all_have(&vessels) => "hardwood",
        () if none_has(&vessels) && all_have(&canals) => "softwood",
        () => "wood",
    }
}

/// Where the recipe has its boards from.
fn origin_of_boards(head: &DatasetHead) -> &'static str {
    match head.recipe.canonical["log"]["source"].as_str() {
        Some("stem") => " sawn out of simulated stems",
        Some("measured") => " sawn out of a measured log",
        Some("picture") => " cut out of a picture",
        Some("slices") => " cut out of a stack of slices",
        _ => "",
    }
}

/// Whether light enters the object in any class: all but pieces of metal.
pub(crate) fn is_entered_by_light(head: &DatasetHead) -> bool {
    let absorption = bounds(head, "material", "mu_a_per_mm");
    absorption.is_empty() || absorption.iter().any(|[least, _]| *least < OPAQUE_PER_MM)
}

/// Whether light leaves speckle in any class.
pub(crate) fn has_speckle(head: &DatasetHead) -> bool {
    let strength = bounds(head, "speckle", "strength");
    strength.is_empty() || strength.iter().any(|[_, most]| *most > 0.0)
}

/// The least and the greatest that a number of the recipe can be, of each class; none where the recipe does not have
/// it.
fn bounds(head: &DatasetHead, group: &str, key: &str) -> Vec<[f64; 2]> {
    let recipe = &head.recipe.canonical;
    let law = |class: &String| {
        let own = &recipe["classes"][class.as_str()][group][key];
        if own.is_null() { &recipe[group][key] } else { own }
    };
    head.classes.iter().filter_map(|class| extremes(law(class))).collect()
}

/// The least and the greatest of a distribution as the canonical form writes it.
fn extremes(law: &Value) -> Option<[f64; 2]> {
    let pair = |low: &Value, high: &Value| Some([low.as_f64()?, high.as_f64()?]);
    if law.is_number() {
        return pair(law, law);
    }
    let (form, arguments) = law.as_object()?.iter().next()?;
    match form.as_str() {
        "uniform" | "log_uniform" => pair(&arguments[0], &arguments[1]),
        "truncated" => pair(&arguments["min"], &arguments["max"]),
        "choice" => {
            let values = || arguments["values"].as_array().into_iter().flatten().filter_map(Value::as_f64);
            Some([values().reduce(f64::min)?, values().reduce(f64::max)?])
        }
        "lognormal" => Some([f64::MIN_POSITIVE, f64::INFINITY]),
        "normal" => Some([f64::NEG_INFINITY, f64::INFINITY]),
        _ => None,
    }
}
