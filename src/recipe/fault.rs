//! Why there is no recipe: where, what, and what to do.

use std::path::PathBuf;

use crate::yaml::fault::Faults;

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
    Faulty(#[from] Faults),
}

/// `; did you mean ...?` where there is something to mean.
fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}
