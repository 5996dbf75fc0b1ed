//! Recipes by name: a file that exists wins, then those that are built in.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::fault::{Faults, RecipeError, nearest};
use super::node::{LONGEST, Place};
use super::walk::Walk;

/// The recipes that are built in, by name.
pub(super) const EMBEDDED: [(&str, &str); 2] =
    [("wood", include_str!("../../recipes/wood.yaml")), ("wood-small", include_str!("../../recipes/wood-small.yaml"))];

/// The text of the recipe `name`: of the file, or else of the embedded recipe `name`, also as `recipes/{name}.yaml`.
pub(super) fn text(name: &str) -> Result<String, RecipeError> {
    let path = Path::new(name);
    if path.exists() && !path.is_dir() {
        return match read(path) {
            Ok(bytes) => Ok(utf8(name, bytes)?),
            Err(source) => Err(RecipeError::Unreadable { path: path.to_owned(), source }),
        };
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

/// The bytes of a file or pipe, as far as it takes to see that they are too many.
fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(LONGEST as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The bytes as text; the first byte that is none is a fault at its place.
fn utf8(origin: &str, bytes: Vec<u8>) -> Result<String, Faults> {
    if bytes.len() > LONGEST {
        // Cut off in the middle of a letter, perhaps; the parser refuses the length.
        return Ok(String::from_utf8_lossy(&bytes).into_owned());
    }
    String::from_utf8(bytes).or_else(|error| {
        let good = String::from_utf8_lossy(&error.as_bytes()[..error.utf8_error().valid_up_to()]).into_owned();
        let column = good.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        let place = Place { line: good.matches('\n').count() + 1, column };
        let mut walk = Walk::new(&good);
        walk.fault(place, "", "is no UTF-8", "save the recipe as UTF-8 text");
        walk.finish(origin).map(|()| good)
    })
}
