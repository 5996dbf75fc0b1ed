//! Truth maps that were changed in all samples alike, objects that the image's border cuts, and headers of other
//! programs.

use base::Class;
use dataset::validate::Code::*;
use dataset::{Encoded, ExrChannel};
use optical_bench::settings::Channel;

use super::place::{boards, codes_of, exr, labels, of_recipe, relabel, with};
use test_support::program::{mesh_recipe, pack_recipe, recipe, sawtooth_recipe};

/// The recipes of all subjects, as small as they go with something of every kind in view.
fn recipes() -> [(&'static str, String); 4] {
    let wide =
        |text: String, size: [[&str; 2]; 2]| size.iter().fold(text, |text, [old, new]| text.replacen(old, new, 1));
    [
        ("wood", recipe(&[])),
        (
            "blister",
            wide(
                pack_recipe(&[]),
                [["\n  columns: 128 ", "\n  columns: 256 "], ["\n  profiles: 96 ", "\n  profiles: 200 "]],
            ),
        ),
        ("sawtooth", sawtooth_recipe(&[])),
        ("mesh", mesh_recipe(&[])),
    ]
}

const MAPS: [&str; 5] = ["FibreAzimuth", "FibreDive", "FilmGap", "FilmThickness", "Height"];

/// A change of the numbers of a map of so many columns.
type Change = fn(&[f32], usize) -> Vec<f32>;

/// The changes, by name.
const CHANGES: [(&str, Change); 5] = [
    ("zeroed", |map, _| vec![0.0; map.len()]),
    ("mirrored", |map, cols| map.chunks(cols).flat_map(|line| line.iter().rev().copied()).collect()),
    ("shifted by a column", |map, cols| {
        map.chunks(cols).flat_map(|line| [&line[cols - 1..], &line[..cols - 1]].concat()).collect()
    }),
    ("shifted by three rows", |map, cols| [&map[3 * cols..], &map[..3 * cols]].concat()),
    ("scaled", |map, _| map.iter().map(|number| number * 0.9).collect()),
];

fn changed(samples: &mut [Encoded], name: &str, change: Change) {
    for sample in samples {
        let cols = sample.cols;
        exr(sample, |channels: &mut Vec<ExrChannel>, _| {
            for channel in channels.iter_mut().filter(|channel| channel.name == name) {
                channel.numbers = change(&channel.numbers, cols);
            }
        });
    }
}

#[test]
#[ignore = "long"]
fn truth_maps_of_all_samples() {
    let (mut tried, mut missed) = (0, Vec::new());
    for (subject, text) in recipes() {
        let (head, samples) = of_recipe(&text, 4);
        assert_eq!(codes_of(&head, samples.clone(), subject), [], "{subject}");
        let declared: Vec<&str> = head.channels().iter().map(|channel| channel.name).collect();
        for name in MAPS.iter().filter(|name| declared.contains(name)) {
            for (what, change) in CHANGES {
                let mut other = samples.clone();
                changed(&mut other, name, change);
                if other.iter().zip(&samples).all(|(other, own)| other.exr == own.exr) {
                    continue;
                }
                tried += 1;
                let what = format!("{name} {what} of {subject}");
                if !codes_of(&head, other, &what).contains(&TruthDiffers) {
                    missed.push(what);
                }
            }
        }
    }
    println!("{tried} changes of truth maps, {} missed", missed.len());
    assert!(tried > 25 && missed.is_empty(), "missed: {missed:?}");
}

#[test]
#[ignore = "long"]
fn objects_at_the_border() {
    let (mut tried, mut missed) = (0, Vec::new());
    for (subject, text) in recipes().into_iter().take(2) {
        let (head, samples) = of_recipe(&text, 6);
        for (i, sample) in samples.iter().enumerate() {
            for object in &sample.objects {
                let [x, y, width, height] = object.bbox.map(|side| side as usize);
                let at_border = x == 0 || y == 0 || x + width == sample.cols || y + height == sample.rows;
                if !at_border || object.instance.within > 0 {
                    continue;
                }
                let mut other = samples.clone();
                let [mut label, mut instance] = labels(sample);
                let own: Vec<u16> = std::iter::once(object.instance.id)
                    .chain(
                        sample
                            .objects
                            .iter()
                            .filter(|o| o.instance.within == object.instance.id)
                            .map(|o| o.instance.id),
                    )
                    .collect();
                let ground = if subject == "wood" { Class::Clear } else { Class::Flange };
                for (label, instance) in label.iter_mut().zip(&mut instance).filter(|(_, i)| own.contains(i)) {
                    (*label, *instance) = (ground as u16, 0);
                }
                relabel(&mut other[i], &label, &instance);
                tried += 1;
                if !codes_of(&head, other, "an object at the border erased").contains(&LabelDiffers) {
                    missed.push(format!(
                        "{subject} {i}: {:?} {:?} of {} x {} at ({:.1}, {:.1}) mm, diameter {:.1} mm",
                        object.instance.class,
                        object.bbox,
                        sample.cols,
                        sample.rows,
                        object.instance.x_mm,
                        object.instance.y_mm,
                        object.instance.diameter_mm
                    ));
                }
            }
        }
    }
    println!("{tried} objects at the border erased, missed: {missed:#?}");
    assert!(tried > 10 && missed.is_empty(), "missed: {missed:#?}");
}

/// The place of the value of an attribute in a header, past its name, its type and its length.
fn attribute(file: &[u8], name: &str, kind: &str) -> usize {
    let start = [name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat();
    let at = file.windows(start.len()).position(|window| window == start).expect("the attribute");
    at + start.len() + 4
}

#[test]
#[ignore = "long"]
fn headers() {
    let place = format!("{}.exr", boards().samples[1].id);
    let patch = |name: &'static str, kind: &'static str, skip: usize, change: fn(&mut [u8])| {
        move |samples: &mut Vec<Encoded>| {
            let file = samples[1].exr.as_mut().expect("there");
            let at = attribute(file, name, kind) + skip;
            change(&mut file[at..]);
        }
    };
    let more = |bytes: &mut [u8]| {
        let number = i32::from_le_bytes(bytes[..4].try_into().expect("four")) + 16;
        bytes[..4].copy_from_slice(&number.to_le_bytes());
    };
    let float = |bytes: &mut [u8]| bytes[..4].copy_from_slice(&3.5_f32.to_le_bytes());
    let shift = |samples: &mut Vec<Encoded>| {
        patch("dataWindow", "box2i", 0, more)(samples);
        patch("dataWindow", "box2i", 8, more)(samples);
    };
    with(shift, &[HeaderDiffers], &place, "a data window that is shifted by 16 columns");
    with(patch("displayWindow", "box2i", 8, more), &[HeaderDiffers], &place, "a wider display window");
    with(patch("pixelAspectRatio", "float", 0, float), &[HeaderDiffers], &place, "pixels of another aspect");
    with(patch("screenWindowWidth", "float", 0, float), &[HeaderDiffers], &place, "another window of the screen");
    with(patch("xDensity", "float", 0, float), &[HeaderDiffers], &place, "other pixels in an inch");
    let said = |samples: &mut Vec<Encoded>| exr(&mut samples[1], |_, text| text["author"] = "nobody".into());
    with(said, &[HeaderDiffers], &place, "another key in the text attribute");

    let chunk = |samples: &mut Vec<Encoded>| {
        let png =
            &mut samples[1].png.iter_mut().find(|(channel, _)| *channel == Channel::Reflectance).expect("there").1;
        // A gamma of 1/1, with its sum.
        let gamma = [b"\0\0\0\x04gAMA".as_slice(), &100_000_u32.to_be_bytes(), &[0x31, 0xe8, 0x96, 0x5f]].concat();
        png.splice(33..33, gamma);
    };
    with(chunk, &[HeaderDiffers], "sample 1", "a chunk gAMA");
    let behind = |samples: &mut Vec<Encoded>| samples[1].png[0].1.extend(*b"more");
    with(behind, &[HeaderDiffers], "sample 1", "bytes beyond the end of a PNG");
}
