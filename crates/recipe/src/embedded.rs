//! Embedded recipes, and recipes by name: a file that exists wins, then those that are built in.

use std::path::{Path, PathBuf};

use crate::asset::AssetSource;
use yaml::{YamlFaults, nearest_spelling, read_bytes, utf8_text};

/// The recipes that are built in, by name.
pub(super) const EMBEDDED: [(&str, &str); 14] = [
    ("wood", include_str!("../../../recipes/wood.yaml")),
    ("wood-small", include_str!("../../../recipes/wood-small.yaml")),
    ("blister", include_str!("../../../recipes/blister.yaml")),
    ("blister-small", include_str!("../../../recipes/blister-small.yaml")),
    ("blister-clear", include_str!("../../../recipes/blister-clear.yaml")),
    ("blister-opaque", include_str!("../../../recipes/blister-opaque.yaml")),
    ("wood-train", include_str!("../../../recipes/wood-train.yaml")),
    ("blister-train", include_str!("../../../recipes/blister-train.yaml")),
    ("sawtooth", include_str!("../../../recipes/sawtooth.yaml")),
    ("sawtooth-small", include_str!("../../../recipes/sawtooth-small.yaml")),
    ("mesh-small", include_str!("../../../recipes/mesh-small.yaml")),
    ("thesis/sawtooth", include_str!("../../../recipes/thesis/sawtooth.yaml")),
    ("thesis/wood", include_str!("../../../recipes/thesis/wood.yaml")),
    ("thesis/blister", include_str!("../../../recipes/thesis/blister.yaml")),
];

/// The text of the recipe `name`: of the file, or else of the embedded recipe `name`, also as `recipes/{name}.yaml`; and
/// where the files are that it names.
pub(super) fn text(name: &str) -> Result<(String, AssetSource), RecipeError> {
    let path = Path::new(name);
    if path.exists() && !path.is_dir() {
        return match read_bytes(path) {
            Ok(bytes) => {
                let folder = path.parent().unwrap_or(Path::new("")).to_owned();
                Ok((utf8_text(name, bytes, "recipe")?, AssetSource::Beside(folder)))
            }
            Err(source) => Err(RecipeError::Unreadable { path: path.to_owned(), source }),
        };
    }
    let stem = name.strip_prefix("./").unwrap_or(name);
    let stem = stem.strip_prefix("recipes/").unwrap_or(stem);
    let stem = stem.strip_suffix(".yaml").unwrap_or(stem);
    match EMBEDDED.iter().find(|(known, _)| *known == stem) {
        Some((_, text)) => Ok(((*text).to_owned(), AssetSource::BuiltIn)),
        None => {
            let known: Vec<_> = EMBEDDED.iter().map(|(known, _)| *known).collect();
            let nearest = nearest_spelling(stem, known.iter().copied()).map(str::to_owned);
            Err(RecipeError::NotFound { name: name.to_owned(), known, nearest })
        }
    }
}

/// Why there is no recipe.
#[derive(Debug, thiserror::Error)]
pub enum RecipeError {
    /// Neither a file nor an embedded recipe has this name.
    #[error("there is no file `{name}` and no embedded recipe of that name{}; embedded are {}", did_you_mean(nearest.as_deref()), known.join(", "))]
    NotFound {
        /// What was asked for.
        name: String,
        /// Names of the embedded recipes.
        known: Vec<&'static str>,
        /// The embedded name that is spelt most like it.
        nearest: Option<String>,
    },
    /// The file exists and cannot be read.
    #[error("cannot read the recipe `{}`: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The text is not a recipe.
    #[error(transparent)]
    Faulty(#[from] YamlFaults),
}

/// `; did you mean ...?` where there is something to mean.
fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}
