//! Recipes by name: a file that exists wins, then those that are built in.

use std::path::Path;

use super::fault::{Faults, RecipeError, nearest};
use super::node::Place;
use super::walk::Walk;

/// The recipes that are built in, by name.
pub(super) const EMBEDDED: [(&str, &str); 2] =
    [("wood", include_str!("../../recipes/wood.yaml")), ("wood-small", include_str!("../../recipes/wood-small.yaml"))];

/// The text of the recipe `name`: of the file, or else of the embedded recipe `name`, also as `recipes/{name}.yaml`.
pub(super) fn text(name: &str) -> Result<String, RecipeError> {
    let path = Path::new(name);
    if path.is_file() {
        let unreadable = |source| RecipeError::Unreadable { path: path.to_owned(), source };
        return Ok(utf8(name, std::fs::read(path).map_err(unreadable)?)?);
    }
    let stem = name.strip_prefix("./").unwrap_or(name);
    let stem = stem.strip_prefix("recipes/").unwrap_or(stem);
    let stem = stem.strip_suffix(".yaml").unwrap_or(stem);
    match EMBEDDED.iter().find(|(known, _)| *known == stem) {
        Some((_, text)) => Ok((*text).to_owned()),
        None => {
            let known: Vec<_> = EMBEDDED.iter().map(|(known, _)| *known).collect();
            let nearest = nearest(stem, known.iter().copied()).map(str::to_owned);
            Err(RecipeError::NotFound { name: name.to_owned(), known, nearest })
        }
    }
}

/// The bytes as text; the first byte that is none is a fault at its place.
fn utf8(origin: &str, bytes: Vec<u8>) -> Result<String, Faults> {
    String::from_utf8(bytes).or_else(|error| {
        let good = String::from_utf8_lossy(&error.as_bytes()[..error.utf8_error().valid_up_to()]).into_owned();
        let column = good.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        let place = Place { line: good.matches('\n').count() + 1, column };
        let mut walk = Walk::new(&good);
        walk.fault(place, "", "is no UTF-8", "save the recipe as UTF-8 text");
        walk.finish(origin).map(|()| good)
    })
}
