//! Media: plane layers and a question about them, as a YAML file says them for `gen transport`.
//!
//! `text -> tree -> yaml -> LayeredMedium`. Every fault of a text is found at once and names its line, its key and its
//! remedy; what is left after that is in range, so no model checks it again. All azimuths in files are measured from
//! the motion (+y) towards the laser line (+x). recipes/media/README.md explains every key.

mod json;
mod reader;

use std::path::{Path, PathBuf};

use transport::answer::Question;
use transport::stack::Stack;
use yaml::{YamlFaults, read_bytes_or_standard_input, utf8_text};

pub use self::reader::axis;

/// Layers and what is asked about them; every number in it is in range.
#[derive(Debug, Clone, PartialEq)]
pub struct LayeredMedium {
    /// The layers.
    pub stack: Stack,
    /// What is asked.
    pub question: Question,
}

/// A medium that is built in, whose text is the file of its name below `recipes/media`.
macro_rules! built_in {
    ($($name:literal),+ $(,)?) => {
        [$(($name, include_str!(concat!("../../../../../recipes/media/", $name, ".yaml"))),)+]
    };
}

/// The media that are built in, by name.
const EMBEDDED: [(&str, &str); 9] = built_in!(
    "clear-wood",
    "giovanelli",
    "mcml-three-layers",
    "sealed-flange",
    "sound-knot",
    "tilted-light-on-a-tensor",
    "van-de-hulst",
    "white-pvc-over-air-over-foil",
    "white-pvc-over-air-over-tablet",
);

/// Why there is no medium.
#[derive(Debug, thiserror::Error)]
pub enum MediumError {
    /// The file cannot be read, and no built-in medium has its name.
    #[error(
        "cannot read the medium `{}`: {source}; give a file as those in recipes/media, or one that is built in: {}",
        path.display(),
        EMBEDDED.map(|(name, _)| name).join(", ")
    )]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The text is not a medium.
    #[error(transparent)]
    Faulty(#[from] YamlFaults),
}

impl LayeredMedium {
    /// The name of the built-in medium that [`Self::load`] takes for `path`: its name, also as
    /// `recipes/media/{name}.yaml`, where no such file is.
    pub fn built_in(path: &Path) -> Option<&'static str> {
        embedded(path).map(|(name, _)| name)
    }

    /// The medium in the file `path`, on standard input where that is `-`, or else the built-in one of that name.
    pub fn load(path: &Path) -> Result<Self, MediumError> {
        if let Some((name, text)) = embedded(path) {
            return Ok(Self::parse(name, text)?);
        }
        let bytes = read_bytes_or_standard_input(path)
            .map_err(|source| MediumError::Unreadable { path: path.to_owned(), source })?;
        let origin = files::shown(path);
        Ok(Self::parse(&origin, &utf8_text(&origin, bytes, reader::NOUN)?)?)
    }

    /// The medium that `text` writes; `origin` is where faults say that it comes from.
    pub fn parse(origin: &str, text: &str) -> Result<Self, YamlFaults> {
        reader::read(origin, text)
    }
}

/// Name and text of the built-in medium that `path` stands for.
fn embedded(path: &Path) -> Option<(&'static str, &'static str)> {
    let name = path.to_str().filter(|_| !path.exists())?;
    let name = name.strip_prefix("./").unwrap_or(name);
    let name = name.strip_prefix("recipes/media/").unwrap_or(name);
    let name = name.strip_suffix(".yaml").unwrap_or(name);
    EMBEDDED.into_iter().find(|(known, _)| *known == name)
}
