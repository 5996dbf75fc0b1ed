//! Embedded recipes, and recipes by name: a file that exists wins, then those that are built in.

use std::path::{Path, PathBuf};

use crate::Recipe;
use crate::asset_source::AssetSource;
use crate::subject::Subject;
use yaml::{YamlFaults, nearest_spelling, read_bytes, utf8_text};

/// A recipe that is built in.
#[derive(Debug, Clone, Copy)]
pub struct BuiltInRecipe {
    /// Its name, also as `recipes/{name}.yaml`.
    pub name: &'static str,
    /// What it is, in a few words.
    pub summary: &'static str,
    /// Its text.
    pub text: &'static str,
}

/// A built-in recipe, whose text is the file of its name below `recipes`.
macro_rules! built_in {
    ($name:literal, $summary:literal) => {
        BuiltInRecipe {
            name: $name,
            summary: $summary,
            text: include_str!(concat!("../../../recipes/", $name, ".yaml")),
        }
    };
}

/// The recipes that are built in.
pub(super) const EMBEDDED: [BuiltInRecipe; 27] = [
    built_in!("wood", "the thesis' scan of boards at full size"),
    built_in!("wood-small", "a small one to try things with"),
    built_in!("blister", "the thesis' scan of packs at full size: white tablets under coloured, half clear film"),
    built_in!("blister-small", "a small one to try things with"),
    built_in!("blister-clear", "transparent film, so that pockets show what lies in them"),
    built_in!("blister-opaque", "white film over oblong tablets, so that little light comes back from below"),
    built_in!("wood-train", "many small samples, to train and to test classifiers with: docs/theory/baselines.md"),
    built_in!("wood-grading", "boards for grading, with every defect of wood: docs/theory/wood.md"),
    built_in!(
        "wood-grading-train",
        "pieces of boards with every defect of wood, to train graders with: docs/theory/baselines.md"
    ),
    built_in!(
        "wood-sawmill",
        "windows of sawn boards as photographs of a production line have them: docs/theory/wood.md"
    ),
    built_in!("wood-stem", "boards sawn out of whole stems with whorls: docs/theory/wood.md"),
    built_in!("wood-log", "all boards of a log, sawn through and through, with wane: docs/theory/wood.md"),
    built_in!("wood-measured", "boards sawn out of a scanned log: docs/theory/wood.md"),
    built_in!("wood-picture", "boards cut out of a photograph: docs/guide/pictures.md"),
    built_in!("wood-slices", "boards cut out of a stack of slices: docs/guide/pictures.md"),
    built_in!("blister-train", "many small samples, to train and to test classifiers with: docs/theory/baselines.md"),
    built_in!("sawtooth", "the calibration piece RCAL-300 at full size, of blasted metal"),
    built_in!("sawtooth-small", "a small one to try things with, of metal and of plastic"),
    built_in!("mesh-small", "a plate with a hole, an arch and a ball, from a file of triangles"),
    built_in!("species/pine", "small pieces of pine, with resin canals; guesses: docs/theory/wood.md"),
    built_in!(
        "species/larch",
        "small pieces of larch, with dark heartwood and much latewood; guesses: docs/theory/wood.md"
    ),
    built_in!("species/beech", "small pieces of beech, with fine vessels and rays; guesses: docs/theory/wood.md"),
    built_in!("species/birch", "small pieces of birch, with vessels all over its rings; guesses: docs/theory/wood.md"),
    built_in!("species/oak", "small pieces of oak, with rings of vessels and broad rays; guesses: docs/theory/wood.md"),
    built_in!("thesis/sawtooth", "the thesis' simulation by its tables and scripts, slow"),
    built_in!("thesis/wood", "the thesis' simulation by its tables and scripts, slow"),
    built_in!("thesis/blister", "the thesis' simulation by its tables and scripts, slow"),
];

impl Recipe {
    /// The recipes that are built in.
    pub fn embedded() -> impl Iterator<Item = &'static BuiltInRecipe> {
        EMBEDDED.iter()
    }

    /// The text of a first recipe about `subject`, to be changed.
    pub fn first(subject: Subject) -> &'static str {
        match subject {
            Subject::Wood => include_str!("../../../recipes/new/wood.yaml"),
            Subject::Blister => include_str!("../../../recipes/new/blister.yaml"),
            Subject::Sawtooth => include_str!("../../../recipes/new/sawtooth.yaml"),
            Subject::Mesh => include_str!("../../../recipes/new/mesh.yaml"),
        }
    }

    /// The built-in recipe that [`Self::load`] takes for `name`, also as `recipes/{name}.yaml`; `None` where it takes a
    /// file, or finds nothing.
    pub fn built_in(name: &str) -> Option<&'static BuiltInRecipe> {
        let path = Path::new(name);
        if path.exists() && !path.is_dir() {
            return None;
        }
        EMBEDDED.iter().find(|known| known.name == stem(name))
    }
}

/// A name without the folder and the ending that those of built-in recipes may have.
fn stem(name: &str) -> &str {
    let stem = name.strip_prefix("./").unwrap_or(name);
    let stem = stem.strip_prefix("recipes/").unwrap_or(stem);
    stem.strip_suffix(".yaml").unwrap_or(stem)
}

/// The text of a recipe.
pub(super) struct FoundText {
    pub text: String,
    /// Where the files are that it names.
    pub files: AssetSource,
    /// The same for each name of the recipe.
    pub identity: PathBuf,
}

/// The recipe `name` for one whose files are in `files`: the file, or else the embedded recipe `name`, also as
/// `recipes/{name}.yaml`.
pub(super) fn find(name: &str, files: &AssetSource) -> Result<FoundText, RecipeError> {
    let path = match files {
        AssetSource::Beside(folder) => Some(folder.join(name)).filter(|path| path.exists() && !path.is_dir()),
        AssetSource::BuiltIn | AssetSource::Kept(_) => None,
    };
    if let Some(path) = path {
        let bytes = read_bytes(&path).map_err(|source| RecipeError::Unreadable { path: path.clone(), source })?;
        let files = AssetSource::Beside(path.parent().unwrap_or(Path::new("")).to_owned());
        let identity = identity(&path.to_string_lossy(), &files);
        return Ok(FoundText { text: utf8_text(name, bytes, "recipe")?, files, identity });
    }
    if let Some(known) = EMBEDDED.iter().find(|known| known.name == stem(name)) {
        let (text, files) = (known.text.to_owned(), AssetSource::BuiltIn);
        return Ok(FoundText { text, identity: identity(name, &files), files });
    }
    let known: Vec<_> = EMBEDDED.iter().map(|known| known.name).collect();
    let last = |known: &&str| known.rsplit('/').next() == Some(stem(name));
    let in_folder = known.iter().copied().find(last);
    let nearest = in_folder.or_else(|| nearest_spelling(stem(name), known.iter().copied())).map(str::to_owned);
    Err(RecipeError::NotFound { name: name.to_owned(), known, nearest })
}

/// What is the same for each name of the recipe `origin`, whose files are in `files`.
pub(super) fn identity(origin: &str, files: &AssetSource) -> PathBuf {
    match files {
        AssetSource::Beside(_) => Path::new(origin).canonicalize().unwrap_or_else(|_| origin.into()),
        AssetSource::BuiltIn | AssetSource::Kept(_) => Path::new("/built in").join(stem(origin)),
    }
}

/// Why there is no recipe.
#[derive(Debug, thiserror::Error)]
pub enum RecipeError {
    /// Neither a file nor an embedded recipe has this name.
    #[error("there is no file `{name}` and no embedded recipe of that name{}; embedded are \
        {}", did_you_mean(nearest.as_deref()), known.join(", "))]
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
