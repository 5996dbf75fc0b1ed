//! The onnxruntime library: found and loaded when `gen` runs, never when it is built.
//!
//! 1. the file that `ORT_DYLIB_PATH` names, and then nothing else;
//! 2. the package `onnxruntime` of a Python environment: the active one, then `.venv` in this folder or above it, then
//!    `.venv` above the program;
//! 3. the system's libraries.

use std::env::consts::{DLL_EXTENSION, DLL_PREFIX};
use std::env::{current_dir, current_exe, var_os};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use ort::environment::Environment;

/// The environment variable.
pub(crate) const LIBRARY_VARIABLE: &str = "ORT_DYLIB_PATH";
/// What to do without the library.
const INSTALL_REMEDY: &str = "install it with `make venv` or `pip install onnxruntime`, or set ORT_DYLIB_PATH to its \
    library (libonnxruntime.so, \
     libonnxruntime.dylib, onnxruntime.dll)";

/// onnxruntime allows one environment in a process and ort keeps the library for as long: so do we.
static LOADED: Mutex<Option<Environment>> = Mutex::new(None);

/// The library, loaded now or before.
///
/// # Errors
/// What was tried and why it failed; what to do.
pub fn load() -> Result<Environment, String> {
    let mut loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(environment) = loaded.as_ref() {
        return Ok(environment.clone());
    }
    let asked = var_os(LIBRARY_VARIABLE).filter(|path| !path.is_empty()).map(PathBuf::from);
    let places = environments(var_os("VIRTUAL_ENV").map(PathBuf::from), current_dir().ok(), current_exe().ok());
    let tried = match &asked {
        Some(path) => vec![std::path::absolute(path).ok().filter(|path| path.exists()).unwrap_or(path.clone())],
        None => {
            let mut found: Vec<PathBuf> = places.iter().flat_map(|place| in_environment(place)).collect();
            found.extend(["", ".1"].map(|end| PathBuf::from(format!("{DLL_PREFIX}onnxruntime.{DLL_EXTENSION}{end}"))));
            found
        }
    };
    let mut reasons = Vec::new();
    for path in &tried {
        match ort::init_from(path) {
            Ok(builder) => {
                // Errors come back from calls; its log would only say them again. Nothing is sent anywhere.
                let builder = builder.with_name("gen").with_telemetry(false).with_logger(Arc::new(|_, _, _, _, _| ()));
                let environment =
                    builder.build().map_err(|e| format!("onnxruntime does not start: {}", e.message()))?;
                *loaded = Some(environment.clone());
                return Ok(environment);
            }
            Err(error) => reasons.push(error.to_string()),
        }
    }
    let reasons = reasons.join("; ");
    Err(match asked {
        Some(_) => format!(
            "{LIBRARY_VARIABLE} names no onnxruntime library ({reasons}); correct or unset it, or {INSTALL_REMEDY}"
        ),
        None => format!(
            "onnxruntime is not found; {} ({reasons}); if it is installed in another Python environment, activate \
                that one; \
             else {INSTALL_REMEDY}",
            searched(&places, var_os("VIRTUAL_ENV").is_some())
        ),
    })
}

/// Python environments to look in.
fn environments(active: Option<PathBuf>, folder: Option<PathBuf>, program: Option<PathBuf>) -> Vec<PathBuf> {
    let above = |path: Option<PathBuf>| -> Vec<PathBuf> {
        path.iter().flat_map(|path| path.ancestors()).map(|folder| folder.join(".venv")).collect()
    };
    let mut places: Vec<PathBuf> = active.into_iter().collect();
    places.extend(above(folder).into_iter().chain(above(program)));
    places
}

/// What was looked through, in words.
fn searched(places: &[PathBuf], active: bool) -> String {
    let mut words = vec![format!("{LIBRARY_VARIABLE} is not set")];
    if !active {
        words.push("no Python environment is active (VIRTUAL_ENV is not set)".into());
    }
    let mut named: Vec<&PathBuf> = Vec::new();
    for place in places.iter().filter(|place| place.is_dir()) {
        if !named.contains(&place) {
            named.push(place);
        }
    }
    words.extend(named.iter().map(|place| format!("{} has no package onnxruntime", place.display())));
    if named.is_empty() {
        words.push("there is no .venv in this folder, beside the program, or above either".into());
    }
    format!("searched: {}, and the system's libraries", words.join(", "))
}

/// Libraries of the package `onnxruntime` in a Python environment, the newest Python first.
fn in_environment(place: &Path) -> Vec<PathBuf> {
    let list = |path: PathBuf| -> Vec<PathBuf> {
        let mut found: Vec<_> = fs::read_dir(path).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
        found.sort();
        found.into_iter().rev().collect()
    };
    let start = format!("{DLL_PREFIX}onnxruntime.");
    let is_library = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(&start) && name.contains(&format!(".{DLL_EXTENSION}"))
    };
    // `lib/python3.11/site-packages`; on Windows `Lib/site-packages`.
    let pythons = list(place.join("lib")).into_iter().chain([place.join("Lib")]);
    let packages = pythons.map(|python| python.join("site-packages").join("onnxruntime").join("capi"));
    packages.flat_map(list).filter(is_library).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The package's own library is found, its helpers are not taken for it, and an environment without it gives none.
    #[test]
    fn libraries_of_environments_are_found() {
        let place = tempfile::tempdir().expect("a folder");
        let capi = place.path().join("lib/python3.11/site-packages/onnxruntime/capi");
        fs::create_dir_all(&capi).expect("a folder");
        assert!(in_environment(place.path()).is_empty() && in_environment(Path::new("/nowhere")).is_empty());
        for name in ["libonnxruntime_providers_shared.so", "libonnxruntime.so.1.31.1", "onnxruntime_pybind11_state.so"]
        {
            fs::write(capi.join(name), "").expect("a file");
        }
        let found = in_environment(place.path());
        if cfg!(target_os = "linux") {
            assert_eq!(found, [capi.join("libonnxruntime.so.1.31.1")]);
        }
        // As on Windows, with the name that it has on this system.
        let place = tempfile::tempdir().expect("a folder");
        let library = place.path().join("Lib/site-packages/onnxruntime/capi");
        fs::create_dir_all(&library).expect("a folder");
        let library = library.join(format!("{DLL_PREFIX}onnxruntime.{DLL_EXTENSION}"));
        fs::write(&library, "").expect("a file");
        assert_eq!(in_environment(place.path()), [library]);
    }

    /// Who has installed the package elsewhere reads where it was looked for, and that no environment is active.
    #[test]
    fn what_was_searched_is_named() {
        let place = tempfile::tempdir().expect("a folder");
        let [there, gone] = [place.path().join(".venv"), place.path().join("above/.venv")];
        fs::create_dir(&there).expect("a folder");
        let told = searched(&[there.clone(), gone.clone(), there.clone()], false);
        let named = format!("{} has no package onnxruntime", there.display());
        assert_eq!(told.matches(&named).count(), 1, "{told}");
        assert!(!told.contains(&gone.display().to_string()) && told.contains("VIRTUAL_ENV is not set"), "{told}");
        assert!(told.contains("ORT_DYLIB_PATH is not set") && told.contains("the system's libraries"), "{told}");
        let told = searched(&[gone], true);
        assert!(told.contains("there is no .venv") && !told.contains("VIRTUAL_ENV"), "{told}");
    }

    #[test]
    fn environments_are_the_active_one_then_those_above() {
        let found = environments(Some("/active".into()), Some("/a/b".into()), Some("/c/gen".into()));
        let wanted = ["/active", "/a/b/.venv", "/a/.venv", "/.venv", "/c/gen/.venv", "/c/.venv", "/.venv"];
        assert_eq!(found, wanted.map(PathBuf::from));
    }
}
