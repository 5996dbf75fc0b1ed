//! Fibres of a picture, found once: they take seconds of work, follow from its numbers and the settings alone, and are
//! kept in the user's cache under the hash of both.
//!
//! A file is: [`MAGIC`], its own name, rows, columns and knots as 64 bits, azimuths, dives and confidences, ten numbers
//! of each knot, and SHA-256 of all that; numbers are little-endian, of 32 bits. What is not so to the bit is as if it
//! were not there.

use crate::asset::hex;
use files::Cache;
use glam::{Vec2, Vec3};
use sha2::{Digest, Sha256};
use wood_picture::{FibreMap, PictureAnalysis, PictureFault, PictureKnot, fibre_map};

/// What a file begins with.
const MAGIC: &[u8] = b"sheetlight fibres\n";
/// First digits of SHA-256 of the fibres of the built-in picture. Whatever changes the analysis changes them, so they
/// stand in every name: no run takes fibres that another analysis has found. A test holds them to the analysis.
const ANALYSIS: &str = "8744edb33f59bc3f";
/// Numbers of a knot.
const KNOT_NUMBERS: usize = 10;

/// As [`fibre_map`], taken from the cache where they are there.
///
/// # Errors
/// Those of [`fibre_map`].
pub(super) fn fibres_of(
    cache: Option<&Cache>,
    grey: &[f32],
    size: [usize; 2],
    pixel_mm: [f32; 2],
    settings: &PictureAnalysis,
) -> Result<FibreMap, PictureFault> {
    let Some(cache) = cache else { return fibre_map(grey, size, pixel_mm, settings) };
    let name = name(grey, size, pixel_mm, settings);
    if let Some(map) = cache.read(&name).and_then(|bytes| read(&bytes, &name, size, pixel_mm)) {
        return Ok(map);
    }
    let map = fibre_map(grey, size, pixel_mm, settings)?;
    cache.keep(&name, &written(&map, &name));
    Ok(map)
}

/// The name of what follows from these numbers and settings.
fn name(grey: &[f32], size: [usize; 2], pixel_mm: [f32; 2], settings: &PictureAnalysis) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let mut hash = Sha256::new_with_prefix(format!("{version} {ANALYSIS} {size:?} {pixel_mm:?} {settings:?}"));
    for row in grey.chunks(size[1].max(1)) {
        hash.update(row.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>());
    }
    format!("{}.fibres", hex(&hash.finalize()))
}

fn written(map: &FibreMap, name: &str) -> Vec<u8> {
    let mut bytes = [MAGIC, name.as_bytes()].concat();
    for count in [map.size[0], map.size[1], map.knots.len()] {
        bytes.extend((count as u64).to_le_bytes());
    }
    for plane in [&map.azimuth_rad, &map.dive_rad, &map.confidence] {
        plane.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    }
    for knot in &map.knots {
        let PictureKnot { centre_mm, half_axes_mm: [a, b], azimuth_rad, axis, end_confidence, brightness, dead } =
            *knot;
        let [x, y] = centre_mm.to_array();
        let [u, v, w] = axis.to_array();
        let numbers = [x, y, a, b, azimuth_rad, u, v, w, end_confidence, if dead { -brightness } else { brightness }];
        numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    }
    let sum = Sha256::digest(&bytes);
    bytes.extend(sum);
    bytes
}

fn read(bytes: &[u8], name: &str, size: [usize; 2], pixel_mm: [f32; 2]) -> Option<FibreMap> {
    let (content, sum) = bytes.split_last_chunk::<32>()?;
    if *sum != Sha256::digest(content)[..] {
        return None;
    }
    let mut rest = content.strip_prefix(MAGIC)?.strip_prefix(name.as_bytes())?;
    let mut count = || {
        let (count, behind) = rest.split_first_chunk::<8>()?;
        rest = behind;
        usize::try_from(u64::from_le_bytes(*count)).ok()
    };
    let (found, knots) = ([count()?, count()?], count()?);
    let pixels = size[0] * size[1];
    let (numbers, []) = rest.as_chunks::<4>() else { return None };
    if found != size || numbers.len() != (3 * pixels).checked_add(knots.checked_mul(KNOT_NUMBERS)?)? {
        return None;
    }
    let numbers: Vec<f32> = numbers.iter().map(|four| f32::from_le_bytes(*four)).collect();
    let plane = |i: usize| numbers[i * pixels..][..pixels].to_vec();
    let knot = |[x, y, a, b, azimuth_rad, u, v, w, end_confidence, brightness]: &[f32; KNOT_NUMBERS]| PictureKnot {
        centre_mm: Vec2::new(*x, *y),
        half_axes_mm: [*a, *b],
        azimuth_rad: *azimuth_rad,
        axis: Vec3::new(*u, *v, *w),
        end_confidence: *end_confidence,
        brightness: brightness.abs(),
        dead: brightness.is_sign_negative(),
    };
    Some(FibreMap {
        size,
        pixel_mm,
        azimuth_rad: plane(0),
        dive_rad: plane(1),
        confidence: plane(2),
        knots: numbers[3 * pixels..].as_chunks().0.iter().map(knot).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::{RowOrder, grey};
    use super::*;
    use crate::asset::Asset;
    use crate::built_in::PICTURES;
    use wood_picture::Encoding;

    fn built_in() -> (Vec<f32>, [usize; 2], PictureAnalysis) {
        let file = Asset::new(PICTURES[0].0, PICTURES[0].1.to_vec());
        let (grey, size, _) = grey(&file, 0.0, Encoding::Srgb, &RowOrder { is_far: true }).expect("a picture");
        (grey, size, PictureAnalysis { encoding: Encoding::Srgb, ..PictureAnalysis::default() })
    }

    /// What is kept is what is found, to the bit; it is taken where it is whole, of this name and of this analysis, and
    /// made anew otherwise.
    #[test]
    fn what_is_kept_is_what_is_found() {
        let (grey, size, settings) = built_in();
        let place = tempfile::tempdir().expect("a folder");
        let cache = Cache::at(place.path(), 1 << 30);
        let pixel_mm = [0.15; 2];
        let asked =
            |cache: Option<&Cache>, settings: &PictureAnalysis| fibres_of(cache, &grey, size, pixel_mm, settings);
        let found = asked(None, &settings).expect("it is wood");
        assert!(!found.knots.is_empty());
        let sum = hex(&Sha256::digest(written(&found, "")));
        assert_eq!(&sum[..16], ANALYSIS, "the analysis has changed: so must the names of what it found");
        let mut dead = found.clone();
        dead.knots[0].dead = !dead.knots[0].dead;
        for map in [&found, &dead] {
            assert_eq!(read(&written(map, "a"), "a", size, pixel_mm).as_ref(), Some(map));
        }

        let name = name(&grey, size, pixel_mm, &settings);
        let kept = written(&found, &name);
        assert_eq!(asked(Some(&cache), &settings).as_ref(), Ok(&found));
        assert!(cache.read(&name).is_some_and(|bytes| bytes == kept), "it is kept");
        // It is really read: what lies there is told, whatever it is.
        cache.keep(&name, &written(&dead, &name));
        assert_eq!(asked(Some(&cache), &settings).as_ref(), Ok(&dead));
        // Anything else is none.
        let mut turned = kept.clone();
        turned[MAGIC.len() + 90 + 4000] ^= 1;
        let other = written(&dead, "another");
        for (wrong, what) in
            [(&kept[..kept.len() - 1], "cut"), (&turned, "turned"), (&other, "another"), (&[], "empty")]
        {
            assert_eq!(read(wrong, &name, size, pixel_mm), None, "{what}");
        }
        assert_eq!(read(&kept, &name, [size[1], size[0]], pixel_mm), None);
        cache.keep(&name, &turned);
        assert_eq!(asked(Some(&cache), &settings).as_ref(), Ok(&found));
        assert!(cache.read(&name).is_some_and(|bytes| bytes == kept), "it is replaced");
        // Other settings and other numbers have other names.
        let mut others =
            vec![super::name(&grey, size, [0.15, 0.16], &settings), super::name(&grey[1..], size, pixel_mm, &settings)];
        others.push(super::name(&grey, size, pixel_mm, &PictureAnalysis { least_knot_mm: 4.5, ..settings }));
        assert!(!others.contains(&name));
        assert_eq!(
            asked(Some(&cache), &PictureAnalysis { encoding: Encoding::Unknown, ..settings }),
            Err(PictureFault::NotLinear)
        );
    }
}
