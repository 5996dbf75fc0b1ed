//! Whatever the bytes, reading a recipe gives a recipe or a list of faults, and what is accepted can be drawn.
//!
//! ```text
//! mkdir -p fuzz/corpus/recipe
//! cargo fuzz run recipe fuzz/corpus/recipe fuzz/seeds/recipe recipes -- -dict=fuzz/recipe.dict -max_len=8192
//! ```

#![no_main]

use libfuzzer_sys::fuzz_target;
use recipe::Recipe;

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match Recipe::parse("fuzz.yaml", text) {
        Ok(recipe) => {
            let scene = recipe.draw(0, 0);
            assert!(scene.draws().iter().all(|(_, value)| value.is_finite()));
            // The canonical form is a recipe of the same meaning.
            let again = Recipe::parse("canonical.json", &recipe.canonical_json()).expect("a recipe");
            assert_eq!(again.hash(), recipe.hash());
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
