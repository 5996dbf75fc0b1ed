//! Recipes with one fault, and what is said about it.

use recipe::{Recipe, RecipeError, YamlFaults};

/// A recipe that is right, one key a line, so that the cases below can append to it.
pub const GOOD: &str = "name: good\nsubject: wood\nclasses: {clear: {share: 1}}\n";

pub fn faults(text: &str) -> YamlFaults {
    match Recipe::parse("bad.yaml", text) {
        Err(RecipeError::Faulty(faults)) => faults,
        Err(other) => panic!("{other}\n{text}"),
        Ok(_) => panic!("accepted:\n{text}"),
    }
}

/// The only fault of [`GOOD`] with `line` appended is at `place` and `key` and says all of `words`.
pub fn only(line: &str, place: (usize, usize), key: &str, words: &[&str]) {
    whole(&format!("{GOOD}{line}\n"), (place.0 + 3, place.1), key, words);
}

/// The only fault of `text`.
pub fn whole(text: &str, place: (usize, usize), key: &str, words: &[&str]) {
    let faults = faults(text);
    assert_eq!(faults.list.len(), 1, "{faults}\n{text}");
    let fault = &faults.list[0];
    assert_eq!((fault.place.line, fault.place.column), place, "{faults}");
    assert_eq!(fault.key, key, "{faults}");
    for word in words {
        assert!(fault.to_string().contains(word), "{faults} lacks {word}");
    }
    assert!(!fault.remedy.is_empty(), "{faults}");
}
