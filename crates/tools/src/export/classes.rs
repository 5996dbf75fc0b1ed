//! Categories of pixel classes in other layouts: which have objects, of what kind, and which count as good.

use base::{Class, ClassKind};
use dataset::Fault;
use output_schema::{DatasetHead, SCHEMA_VERSION};

/// A pixel class that has objects: a category of COCO.
pub(super) struct Category<'a> {
    /// Value in label images.
    pub value: usize,
    /// Name.
    pub name: &'a str,
    /// What it is a kind of.
    pub supercategory: &'static str,
}

/// The categories of the dataset's subject, in order of their values.
pub(super) fn categories(head: &DatasetHead) -> Vec<Category<'_>> {
    let kind = |name: &str| match Class::named(name)?.kind() {
        ClassKind::Ground => None,
        ClassKind::Sound(kind) => kind,
        ClassKind::Defect(kind) => Some(kind),
    };
    let category = |(value, name)| Some(Category { value, name, supercategory: kind(name)? });
    head.shown_classes().filter_map(category).collect()
}

/// For each label value whether it is good, by the names that the user gave; `background` always is, and
/// without names all but the defects are.
pub(super) fn good(head: &DatasetHead, given: &[String]) -> Result<[bool; 256], Fault> {
    if given.is_empty() && !Class::of_subject(&head.subject, SCHEMA_VERSION[1]).any(Class::is_defect) {
        let what = format!("its subject `{}` has no defects", head.subject);
        let remedy = "export it as png or webdataset, or say with --good which classes are good";
        return Err(Fault::new(&head.recipe.name, what, remedy));
    }
    let shown: Vec<&str> = head.shown_classes().map(|(_, name)| name).collect();
    if let Some(unknown) = given.iter().find(|name| !shown.contains(&name.as_str())) {
        let remedy = format!("give some of {}", shown.join(", "));
        return Err(Fault::new("--good", format!("there is no class `{unknown}`"), remedy));
    }
    let is_good = |name: &str| match given {
        [] => Class::named(name).is_some_and(Class::is_sound),
        given => given.iter().any(|good| good == name),
    };
    let mut good = [false; 256];
    good[0] = true;
    for (value, name) in head.shown_classes() {
        good[value & 255] |= is_good(name);
    }
    Ok(good)
}

/// Refuses a name of a damaged `dataset.json` that would lead out of a folder.
pub(super) fn folder_name(name: &str) -> Result<&str, Fault> {
    let known = |c: u8| c.is_ascii_alphanumeric() || c == b'_' || c == b'-';
    match !name.is_empty() && name.len() <= 64 && name.bytes().all(known) {
        true => Ok(name),
        false => {
            let what = format!("the pixel class {name:?} is no name for a folder");
            Err(Fault::damaged("dataset.json".as_ref(), what))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_their_folder() {
        assert!(folder_name("dead_knot").is_ok());
        for name in ["", "..", "a/b", "/etc", "a\\b", "a\0", &"a".repeat(65)] {
            assert!(folder_name(name).is_err(), "{name:?}");
        }
    }
}
