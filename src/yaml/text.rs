//! From bytes to text.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::fault::Faults;
use super::node::{LONGEST, Place};
use super::walk::Walk;

/// The bytes of a file or pipe, as far as it takes to see that they are too many.
pub(crate) fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(LONGEST as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The bytes as text of what is to be a `noun`; the first byte that is none is a fault at its place.
pub(crate) fn utf8(origin: &str, bytes: Vec<u8>, noun: &'static str) -> Result<String, Faults> {
    if bytes.len() > LONGEST {
        // Cut off in the middle of a letter, perhaps; the parser refuses the length.
        return Ok(String::from_utf8_lossy(&bytes).into_owned());
    }
    String::from_utf8(bytes).or_else(|error| {
        let good = String::from_utf8_lossy(&error.as_bytes()[..error.utf8_error().valid_up_to()]).into_owned();
        let column = good.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        let place = Place { line: good.matches('\n').count() + 1, column };
        let mut walk = Walk::new(&good, noun);
        walk.fault(place, "", "is no UTF-8", format!("save the {noun} as UTF-8 text"));
        walk.finish(origin).map(|()| good)
    })
}
