//! Where the sidecar of a model lies when nobody says it.

use std::path::{Path, PathBuf};

use crate::check::CheckError;

/// Endings of a sidecar beside its model.
pub const ENDINGS: [&str; 3] = ["yaml", "yml", "json"];

/// The sidecar beside a model.
///
/// # Errors
/// Where there is none, or more than one.
pub fn beside(model: &Path) -> Result<PathBuf, CheckError> {
    let all = ENDINGS.map(|ending| model.with_extension(ending));
    let shown = |paths: &[PathBuf], and: &str| {
        paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(and)
    };
    let mut found = all.clone().to_vec();
    found.retain(|path| path.exists());
    match found.as_slice() {
        [one] => Ok(one.clone()),
        [] => {
            let remedy = "write one as docs/check.md says, or name it with --sidecar";
            Err(CheckError::at(model, format!("there is no sidecar beside it ({})", shown(&all, ", ")), remedy))
        }
        several => {
            let what = format!("{} lie beside it", shown(several, " and "));
            Err(CheckError::at(model, what, "name the one that is its sidecar with --sidecar"))
        }
    }
}
