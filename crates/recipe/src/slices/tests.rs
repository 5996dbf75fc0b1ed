//! Each wrong stack by a recipe that names it, each key by what it changes, and where boards lie.

use std::collections::BTreeSet;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use base::{BodyKind, Stream};
use glam::Vec2;
use image::{DynamicImage, GrayImage, ImageFormat, Luma};
use procedural::wood;
use procedural::wood::{GivenWood, Plank, SlicesParameters, Wood};

use crate::Recipe;
use crate::asset_source::AssetSource;
use crate::built_in::STACKS;
use crate::keys::settings::SlicesSettings;

const SIZE: [u32; 2] = [60, 40];

fn png(picture: &DynamicImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).expect("encoded");
    bytes.into_inner()
}

/// Grey of a pixel of a slice, like rings that lean.
fn grey(slice: u32, x: u32, y: u32) -> u8 {
    (60 + (3 * x + 5 * y + 2 * slice) % 70 + (7 * x * y + 11 * slice) % 5) as u8
}

fn slice(number: u32) -> GrayImage {
    GrayImage::from_fn(SIZE[0], SIZE[1], |x, y| Luma([grey(number, x, y)]))
}

/// A folder of good slices below `path`, with some files in the place of its own or beside them.
fn stack(path: &Path, name: &str, others: &[(&str, Vec<u8>)]) {
    let folder = path.join(name);
    std::fs::create_dir(&folder).expect("made");
    for number in 0..50 {
        std::fs::write(folder.join(format!("s{number}.png")), png(&slice(number).into())).expect("written");
    }
    for (name, bytes) in others {
        std::fs::write(folder.join(name), bytes).expect("written");
    }
}

fn parsed(folder: &Path, keys: &str, more: &str) -> Result<Recipe, String> {
    let text = format!(
        "name: p\nsubject: wood\nunstated: fixed\n\
         log: {{source: slices}}\nboard: {{width_mm: 5, length_mm: 8, thickness_mm: 3}}\n\
         slices: {{{keys}}}\nclasses: {{all: {{share: 1}}}}\n{more}"
    );
    Recipe::parse_with("p.yaml", &text, &AssetSource::Beside(folder.to_owned())).map_err(|fault| fault.to_string())
}

fn cut(recipe: &Recipe, index: u64) -> Vec<[f32; 3]> {
    let scene = recipe.draw(1, index);
    let board = scene.slices.as_ref().expect("read").cut(scene.plan.wood().expect("a board"));
    let place = |i: u32| Vec2::new(0.3 + 0.41 * (i % 11) as f32, 0.2 + 0.37 * (i % 20) as f32);
    let at = |i: u32| board.at(place(i), 0.13 * (i % 7) as f32);
    (0..400).map(at).map(|matter| [matter.mu_a, matter.sigma_i, matter.k]).collect()
}

#[test]
fn wrong_stacks_are_told_with_key_and_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let good = slice(9);
    stack(path, "good", &[]);
    stack(path, "text", &[("s9.png", b"no picture".to_vec())]);
    stack(path, "empty", &[("s9.png", Vec::new())]);
    stack(
        path,
        "cut",
        &[("s9.png", {
            let whole = png(&good.clone().into());
            whole[..whole.len() / 2].to_vec()
        })],
    );
    stack(path, "colour", &[("s9.png", png(&DynamicImage::from(good.clone()).into_rgb8().into()))]);
    stack(path, "alpha", &[("s9.png", png(&DynamicImage::from(good.clone()).into_luma_alpha8().into()))]);
    stack(path, "bits", &[("s9.png", png(&DynamicImage::from(good.clone()).into_luma16().into()))]);
    stack(path, "sizes", &[("s9.png", png(&GrayImage::new(60, 41).into()))]);
    std::fs::create_dir(path.join("none")).expect("made");
    std::fs::create_dir(path.join("one")).expect("made");
    std::fs::write(path.join("one/a.png"), png(&good.into())).expect("written");
    std::fs::write(path.join("a.png"), png(&slice(1).into())).expect("written");
    stack(path, "onebit", &[("s9.png", with_head(60, 40, 1))]);
    // What is small in a file and large in memory is told by its header.
    for (name, count, size) in [("large", 3, 2_000_000_000), ("many", 60, 5000)] {
        std::fs::create_dir(path.join(name)).expect("made");
        for number in 0..count {
            std::fs::write(path.join(format!("{name}/{number}.png")), with_head(size, size, 8)).expect("written");
        }
    }
    for (keys, key, problem, remedy) in [
        ("pixel_mm: 0.2", "log.source", "no stack of slices is named", "give `slices"),
        ("stack: nowhere", "slices.stack", "there is no file `nowhere`", "relative to the recipe's own file"),
        ("stack: a.png", "slices.stack", "`a.png` is no tar", "name a folder of PNG files"),
        ("stack: none", "log.source", "no stack of slices is named", "give `slices"),
        ("stack: ./none", "slices.stack", "`./none` has 0 PNG files", "at least 2 slices"),
        ("stack: one", "slices.stack", "`one` has 1 PNG files", "at least 2 slices"),
        ("stack: text", "slices.stack", "`text`: the slice `s9.png` is no PNG", "save it as PNG"),
        ("stack: empty", "slices.stack", "the slice `s9.png` is empty", "or remove it"),
        ("stack: cut", "slices.stack", "the slice `s9.png` is a PNG that is damaged", "bring the file back"),
        ("stack: colour", "slices.stack", "the slice `s9.png` has colours", "one grey channel"),
        ("stack: alpha", "slices.stack", "the slice `s9.png` has an alpha channel", "without a palette"),
        ("stack: bits", "slices.stack", "`s9.png` has 60 x 40 pixels of 16 bits, and `s0.png`", "one number of bits"),
        ("stack: sizes", "slices.stack", "`s9.png` has 60 x 41 pixels", "slices of one size"),
        ("stack: onebit", "slices.stack", "the slice `s9.png` has fewer than 8 bits a pixel", "8 or 16 bits"),
        ("stack: large", "slices.stack", "has 2000000000 x 2000000000 pixels", "crop the slices"),
        ("stack: many", "slices.stack", "has 60 slices of 5000 x 5000 pixels", "leave some out"),
        ("stack: good, pixel_mm: 0.005", "slices.stack", "the stack shows 0.25 by 0.20 by 0.30 mm", "size of a voxel"),
        (
            "stack: good, pixel_mm: 0.2, white_kg_per_m3: 200",
            "slices.stack",
            "the mean density is",
            "correct the densities",
        ),
        (
            "stack: good, pixel_mm: 0.2, white_kg_per_m3: 4000",
            "slices.stack",
            "the mean density is",
            "correct the densities",
        ),
        (
            "stack: good, pixel_mm: 0.2, black_kg_per_m3: 500, white_kg_per_m3: 505",
            "slices.stack",
            "the same all over",
            "further apart",
        ),
        (
            "stack: good, pixel_mm: 0.2, black_kg_per_m3: -600, white_kg_per_m3: 1300",
            "slices.stack",
            "which is air",
            "crop the slices",
        ),
        (
            "stack: good, pixel_mm: 0.2, black_kg_per_m3: 500, white_kg_per_m3: 500",
            "slices.white_kg_per_m3",
            "black and white are both 500",
            "give the densities",
        ),
        (
            "stack: good, pixel_mm: 0.2, earlywood_kg_per_m3: 800",
            "slices.earlywood_kg_per_m3",
            "latewood has 800 kg/m3, and earlywood 800",
            "the denser",
        ),
        ("stack: good, pixel_mm: 0.15", "board.length_mm", "8 mm long, and its slices cover 7.5 mm", "at most 7.5 mm"),
        (
            "stack: good, pixel_mm: 0.2, pixel_across_mm: 0.06",
            "board.width_mm",
            "5 mm wide, and its slices cover 3.6 mm",
            "at most 3.6 mm",
        ),
        (
            "stack: good, pixel_mm: 0.06, pixel_across_mm: 0.2, slice_mm: 0.2",
            "board.thickness_mm",
            "3 mm thick, and its slices cover 2.4 mm",
            "at most 2.4 mm",
        ),
        (
            "stack: good, pixel_mm: 0.1, pixel_across_mm: 0.2, slice_mm: 0.2, quarter_turns: {uniform: [0, 3]}",
            "board.width_mm",
            "5 mm wide, and its slices cover 4 mm",
            "at most 4 mm",
        ),
    ] {
        let told = parsed(path, keys, "").expect_err(keys);
        println!("{told}");
        for part in [key, problem, remedy] {
            assert!(told.contains(part), "{keys}: {told} has no `{part}`");
        }
    }
    // 12 x 8 mm are wide enough on either side, 12 x 4 mm on one.
    assert!(parsed(path, "stack: good, pixel_mm: 0.2, quarter_turns: {uniform: [0, 3]}", "").is_ok());
    let flat = "stack: good, pixel_mm: 0.1, pixel_across_mm: 0.2, slice_mm: 0.2";
    assert!(parsed(path, &format!("{flat}, quarter_turns: {{choice: {{values: [0, 2]}}}}"), "").is_ok());
    assert!(parsed(path, &format!("{flat}, quarter_turns: {{choice: {{values: [0, 3]}}}}"), "").is_err());
}

/// A slice whose header says another size and another number of bits.
fn with_head(cols: u32, rows: u32, bits: u8) -> Vec<u8> {
    let mut bytes = png(&slice(1).into());
    bytes[16..20].copy_from_slice(&cols.to_be_bytes());
    bytes[20..24].copy_from_slice(&rows.to_be_bytes());
    bytes[24] = bits;
    let sum = crc(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&sum.to_be_bytes());
    bytes
}

/// The sum of a chunk of a PNG (ISO 3309).
fn crc(bytes: &[u8]) -> u32 {
    let step = |sum: u32| if sum & 1 == 1 { 0xedb8_8320 ^ (sum >> 1) } else { sum >> 1 };
    !bytes.iter().fold(!0, |sum, byte| (0..8).fold(sum ^ u32::from(*byte), |sum, _| step(sum)))
}

/// Any part of a slice and any byte of it spoilt: wood or a fault, and no panic.
#[test]
fn damaged_slices_never_panic() {
    let whole = png(&slice(3).into());
    let own = |bytes: &[u8]| {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, bytes) in [("a.png", whole.as_slice()), ("b.png", bytes), ("c.png", whole.as_slice())] {
            std::fs::write(folder.path().join(name), bytes).expect("written");
        }
        parsed(folder.path(), "stack: ., pixel_mm: 0.2, slice_mm: 3", "").err()
    };
    for length in (0..whole.len()).step_by(29) {
        let told = own(&whole[..length]).expect("too short");
        assert!(told.contains("slices.stack") && told.contains("`b.png`"), "{told}");
    }
    for at in (0..whole.len()).step_by(17) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x5a;
        if let Some(told) = own(&bytes) {
            assert!(told.contains("slices.stack") && told.contains("`b.png`"), "{told}");
        }
    }
}

/// What is for other boards alone, and what is for boards from slices alone.
#[test]
fn keys_without_an_effect_are_refused() {
    let stack = "slices: {stack: slices/spruce.tar, pixel_mm: 0.15, slice_mm: 0.75}\n\
                 board: {width_mm: 20, length_mm: 30, thickness_mm: 4}\n";
    for (source, more, key) in [
        ("placed", "slices: {pixel_mm: 0.2}", "slices.pixel_mm"),
        ("placed", "slices: {along: 0.2}", "slices.along"),
        ("picture", "picture: {file: pictures/board.png}\nslices: {stack: slices/spruce.tar}", "slices.stack"),
        ("slices", "picture: {along: 0.2}", "picture.along"),
        ("slices", "picture: {pixel_mm: 0.2}", "picture.pixel_mm"),
        ("slices", "media: {knot_k_ratio: 1.2}", "media.knot_k_ratio"),
        ("slices", "media: {knot_fibre_dispersion_deg: 9}", "media.knot_fibre_dispersion_deg"),
        ("slices", "rot: {reach_mm: 3}", "rot.reach_mm"),
        ("slices", "grain: {torn_um: 20}", "grain.torn_um"),
    ] {
        let log = if source == "slices" { stack } else { "" };
        let text = format!(
            "name: p\nsubject: wood\nunstated: fixed\n\
             log: {{source: {source}}}\n{log}{more}\nclasses: {{all: {{share: 1}}}}\n"
        );
        let told = Recipe::parse("p.yaml", &text).expect_err(more).to_string();
        assert!(told.contains(key) && told.contains("has no effect while `log.source` is"), "{told}");
    }
    let share = "name: p\nsubject: wood\nunstated: fixed\n\
        log: {source: slices, latewood_share: 0.3}\nclasses: {all: {share: 1}}\n";
    let told = Recipe::parse("p.yaml", &format!("{share}{stack}")).expect_err("a share").to_string();
    assert!(told.contains("log.latewood_share"), "{told}");
}

/// Wood from slices has no bark but that of wane, and a remedy is one that such boards can take.
#[test]
fn keys_for_what_slices_do_not_have_are_noted() {
    let recipe = |source: &str, more: &str| {
        let text = format!(
            "name: p\nsubject: wood\nunstated: fixed\n\
             log: {{source: {source}}}\nboard: {{width_mm: 20, length_mm: 30, thickness_mm: \
                4}}\n\
             {more}\nclasses: {{all: {{share: 1}}}}\n"
        );
        Recipe::parse("p.yaml", &text).unwrap_or_else(|fault| panic!("{fault}")).notes().join("; ")
    };
    for (source, from) in [
        ("slices", "slices: {stack: slices/spruce.tar, pixel_mm: 0.15, slice_mm: 0.75}"),
        ("picture", "picture: {file: pictures/board.png}"),
    ] {
        let bark = recipe(source, &format!("{from}\nmedia: {{bark_mu_a_per_mm: 2.2}}"));
        assert!(
            bark.contains(
                "media.bark_mu_a_per_mm has no effect while `wane.width_mm` is 0; give `wane.width_mm` \
            too, or remove it"
            ),
            "{bark}"
        );
        let wane = recipe(source, &format!("{from}\nmedia: {{bark_mu_a_per_mm: 2.2}}\nwane: {{width_mm: 2}}"));
        assert!(!wane.contains("bark_mu_a"), "{wane}");
        let resin = recipe(source, &format!("{from}\nmedia: {{resin_k_per_mm: 0.7}}"));
        assert!(resin.contains(&format!("has no effect while `log.source` is `{source}`; remove it")), "{resin}");
    }
    let stem = recipe("stem", "media: {bark_mu_a_per_mm: 2.2}");
    assert!(!stem.contains("bark_mu_a"), "{stem}");
}

/// A margin of air is told with where the wood begins and what to set, and what is told to set serves.
#[test]
fn air_around_the_wood_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("airy")).expect("made");
    // 1.2 of 8 mm above the wood, 1 of 10 mm before its near end.
    for number in 0..50 {
        let airy = GrayImage::from_fn(SIZE[0], SIZE[1], |x, y| {
            Luma([if y < 6 || number < 5 { 2 } else { grey(number, x, y) }])
        });
        std::fs::write(folder.path().join(format!("airy/s{number}.png")), png(&airy.into())).expect("written");
    }
    let airy = "stack: airy, pixel_mm: 0.2";
    let told = parsed(folder.path(), &format!("{airy}, depth: 0"), "").expect_err("air");
    println!("{told}");
    for part in ["slices.depth: 100 %", "wood lies 1.2 to 8 mm below", "give `slices.depth` from 0.24 to 1, or crop"] {
        assert!(told.contains(part), "{told} has no `{part}`");
    }
    assert!(parsed(folder.path(), &format!("{airy}, depth: {{uniform: [0, 1]}}"), "").is_err());
    let deep = parsed(folder.path(), &format!("{airy}, depth: {{uniform: [0.24, 1]}}"), "").expect("wood");
    assert_eq!(deep.notes(), &[] as &[String]);
    let near =
        parsed(folder.path(), &format!("{airy}, depth: 0.5, along: 0"), "").expect("mostly wood").notes().join("; ");
    for part in ["slices.along: 12 % of a board's face can be air", "1 to 10 mm from its near end", "from 0.5 to 1"] {
        assert!(near.contains(part), "{near} has no `{part}`");
    }
    // Turned by one quarter, what lay above lies on the right.
    let turned = parsed(folder.path(), &format!("{airy}, quarter_turns: 1, across: 1"), "")
        .expect("mostly wood")
        .notes()
        .join("; ");
    for part in ["slices.across: 20 % of", "0 to 6.8 mm from its left", "`slices.across` from 0 to 0.6"] {
        assert!(turned.contains(part), "{turned} has no `{part}`");
    }
    // A class has its own place.
    let text = format!(
        "name: p\nsubject: wood\nunstated: fixed\n\
         log: {{source: slices}}\nboard: {{width_mm: 5, length_mm: 8, thickness_mm: 3}}\n\
         slices: {{{airy}, depth: 0.5}}\nclasses: {{deep: {{share: 1}}, high: {{share: 1, slices: {{depth: 0.1}}}}}}\n"
    );
    let files = AssetSource::Beside(folder.path().to_owned());
    let told = Recipe::parse_with("p.yaml", &text, &files).expect_err("air").to_string();
    assert!(told.contains("classes.high.slices.depth"), "{told}");
}

/// Beside a setting out of its range nothing is told that follows from its default.
#[test]
fn a_setting_at_fault_has_one_fault() {
    let folder = tempfile::tempdir().expect("a folder");
    stack(folder.path(), "good", &[]);
    for keys in [
        "stack: good, pixel_mm: 0",
        "stack: good, pixl_mm: 0.2",
        "stack: good, pixel_mm: 0.2, white_kg_per_m3: 1e9, black_kg_per_m3: 1500",
        "stack: good, pixel_mm: 0.2, latewood_kg_per_m3: 0, earlywood_kg_per_m3: 900",
    ] {
        let told = parsed(folder.path(), keys, "").expect_err(keys);
        assert_eq!(told.matches("slices.").count(), 1, "{told}");
        assert!(!told.contains("board."), "{told}");
    }
}

#[test]
fn every_key_has_an_effect() {
    let folder = tempfile::tempdir().expect("a folder");
    stack(folder.path(), "good", &[]);
    stack(folder.path(), "other", &[("s20.png", png(&slice(0).into()))]);
    let base = [("stack", "good"), ("pixel_mm", "0.2"), ("along", "0.5"), ("across", "0.5"), ("depth", "0.5")];
    let keys = |changed: Option<(&str, &str)>| {
        let own = base.into_iter().filter(|(key, _)| changed.is_none_or(|(name, _)| name != *key));
        own.chain(changed).map(|(key, value)| format!("{key}: {value}")).collect::<Vec<_>>().join(", ")
    };
    let before = cut(&parsed(folder.path(), &keys(None), "").expect("good"), 0);
    let changes = [
        ("stack", "other"),
        ("pixel_mm", "0.21"),
        ("pixel_across_mm", "0.19"),
        ("slice_mm", "0.19"),
        ("fibres", "across"),
        ("fibres", "down"),
        ("black_kg_per_m3", "30"),
        ("white_kg_per_m3", "1480"),
        ("earlywood_kg_per_m3", "330"),
        ("latewood_kg_per_m3", "790"),
        ("along", "0.6"),
        ("across", "0.4"),
        ("depth", "0.7"),
        ("quarter_turns", "1"),
        ("quarter_turns", "2"),
        ("mirrored", "1"),
        ("turned", "1"),
    ];
    let mut seen = vec![before];
    for change in changes {
        // Down the rows there are 8 mm of wood.
        let recipe = parsed(folder.path(), &keys(Some(change)), "").unwrap_or_else(|told| panic!("{told}"));
        let after = cut(&recipe, 0);
        assert!(!seen.contains(&after), "{change:?} does nothing");
        seen.push(after);
    }
    let changed: BTreeSet<&str> = changes.into_iter().map(|(key, _)| key).collect();
    let settings = SlicesSettings::SETTINGS.iter().map(|setting| setting.name);
    let declared: BTreeSet<&str> =
        settings.chain(SlicesParameters::PARAMETERS.iter().map(|parameter| parameter.name)).collect();
    assert_eq!(changed, declared);
    // Of the media, those of clear wood.
    let plain = parsed(folder.path(), &keys(None), "").expect("good");
    for key in [
        "earlywood_mu_a_per_mm: 0.1",
        "earlywood_sigma_i_per_mm: 2.5",
        "earlywood_k_per_mm: 9",
        "latewood_mu_a_ratio: 2",
        "latewood_sigma_i_ratio: 1.3",
        "latewood_k_ratio: 0.9",
    ] {
        let other = parsed(folder.path(), &keys(None), &format!("media: {{{key}}}")).expect(key);
        assert_ne!(cut(&plain, 0), cut(&other, 0), "{key}");
    }
}

/// Where boards lie is drawn for each sample, the same each time; a folder, its tar and what a dataset keeps are one
/// stack, whose content is known by the recipe's hash.
#[test]
fn samples_lie_elsewhere_in_one_stack_known_by_its_content() {
    let folder = tempfile::tempdir().expect("a folder");
    stack(folder.path(), "good", &[]);
    let keys = |name: &str| {
        format!(
            "stack: {name}, pixel_mm: 0.2, along: {{uniform: [0, 1]}}, across: {{uniform: [0, 1]}}, depth: {{uniform: \
                [0, 1]}}"
        )
    };
    let recipe = parsed(folder.path(), &keys("good"), "").expect("good");
    let boards: Vec<_> = (0..6).map(|index| cut(&recipe, index)).collect();
    for (i, board) in boards.iter().enumerate() {
        assert_eq!(*board, cut(&recipe, i as u64));
        assert!(!boards[..i].contains(board), "sample {i} lies where another does");
    }
    let [a, b] = [0, 1].map(|index| recipe.draw(1, index).slices.expect("read"));
    assert!(Arc::ptr_eq(&a, &b), "samples share the volume");
    let (key, file) = recipe.files().next().expect("one file");
    assert_eq!((key, file.name()), ("slices.stack", "good.tar"));
    std::fs::write(folder.path().join("good.tar"), file.bytes()).expect("written");
    assert_eq!(parsed(folder.path(), &keys("good.tar"), "").expect("a tar").hash(), recipe.hash());
    let sum = format!("{{name: good, sha256: {}}}", file.sha256());
    assert_eq!(parsed(folder.path(), &keys(&sum), "").expect("the same").hash(), recipe.hash());
    std::fs::write(folder.path().join("good/s7.png"), png(&slice(8).into())).expect("written");
    assert_ne!(parsed(folder.path(), &keys("good"), "").expect("another").hash(), recipe.hash());
    let told = parsed(folder.path(), &keys(&sum), "").expect_err("another content");
    assert!(told.contains("slices.stack") && told.contains(file.sha256()), "{told}");
}

/// How recipes/slices/spruce.tar was made: cross-sections of wood that `procedural` grew, whose absorption is in
/// proportion to density.
#[test]
#[ignore = "writes the slices of the recipe wood-slices"]
fn write_the_slices_of_the_recipe() {
    const PIXEL_MM: f32 = 0.15;
    const SLICE_MM: f32 = 0.75;
    let mut grown = Wood::from_values(&mut |parameter| parameter.default);
    let wood::Board { width_mm, length_mm, thickness_mm, lead_in_mm, cup_mm, twist_deg, .. } = &mut grown.board;
    (*width_mm, *length_mm, *thickness_mm, *lead_in_mm) = (30.0, 50.0, 10.0, 0.0);
    (*cup_mm, *twist_deg) = (0.0, 0.0);
    (grown.log.pith_depth_mm, grown.log.pith_offset_mm) = (45.0, 12.0);
    let plank = Plank::grow(Stream::root(7).child("slices of the recipe"), &grown);
    let folder = tempfile::tempdir().expect("a folder");
    for number in 0..60_u32 {
        let cut = plank.slice(2.0 + SLICE_MM * (number as f32 + 0.5));
        let picture = GrayImage::from_fn(160, 40, |x, y| {
            let [across, depth] = [x, y].map(|pixel| PIXEL_MM * (pixel as f32 + 0.5));
            let absorption = cut.matter(across - 12.0, 9.0 - depth).medium.mu_a;
            let density = 320.0 * absorption / grown.media.earlywood_mu_a_per_mm as f32;
            Luma([(255.0 * density / 1500.0).round().clamp(0.0, 255.0) as u8])
        });
        std::fs::write(folder.path().join(format!("slice_{number:02}.png")), png(&picture.into())).expect("written");
    }
    let tar = crate::slice_tar::of_folder(folder.path(), "spruce", 1 << 20).expect("a tar");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../recipes").join(STACKS[0].0);
    std::fs::write(path, tar.bytes()).expect("written");
}
