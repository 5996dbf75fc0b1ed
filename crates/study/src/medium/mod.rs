//! Media: plane layers and a question about them, as a YAML file says them for `gen transport`.
//!
//! `text -> tree -> yaml -> LayeredMedium`. Every fault of a text is found at once and names its line, its key and its
//! remedy; what is left after that is in range, so no model checks it again. All azimuths in files are measured from the motion
//! (+y) towards the laser line (+x). recipes/media/README.md explains every key.

mod json;
mod reader;

use std::path::{Path, PathBuf};

use transport::answer::Question;
use transport::stack::Stack;
use yaml::{YamlFaults, read_bytes, utf8_text};

pub use self::reader::axis;

/// Layers and what is asked about them; every number in it is in range.
#[derive(Debug, Clone, PartialEq)]
pub struct LayeredMedium {
    /// The layers.
    pub stack: Stack,
    /// What is asked.
    pub question: Question,
}

/// Why there is no medium.
#[derive(Debug, thiserror::Error)]
pub enum MediumError {
    /// The file cannot be read.
    #[error("cannot read the medium `{}`: {source}; examples are in recipes/media", path.display())]
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
    /// The medium in the file `path`.
    pub fn load(path: &Path) -> Result<Self, MediumError> {
        let bytes = read_bytes(path).map_err(|source| MediumError::Unreadable { path: path.to_owned(), source })?;
        let origin = path.display().to_string();
        Ok(Self::parse(&origin, &utf8_text(&origin, bytes, reader::NOUN)?)?)
    }

    /// The medium that `text` writes; `origin` is where faults say that it comes from.
    pub fn parse(origin: &str, text: &str) -> Result<Self, YamlFaults> {
        reader::read(origin, text)
    }
}
