//! Each wrong picture by a recipe that names it, and each map that serves by what it does.

use std::io::Cursor;
use std::path::Path;

use glam::Vec2;
use image::{DynamicImage, ImageFormat, RgbImage, RgbaImage};
use procedural::wood::GivenWood;

use crate::Recipe;
use crate::asset_source::AssetSource;
use crate::built_in::PICTURES;

fn png(picture: &DynamicImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).expect("encoded");
    bytes.into_inner()
}

fn board() -> RgbImage {
    image::load_from_memory(PICTURES[0].1).expect("a picture").into_rgb8()
}

fn parsed(folder: &Path, keys: &str) -> Result<Recipe, String> {
    let text = format!(
        "name: p\nsubject: wood\nunstated: fixed\nlog: {{source: picture}}\nboard: {{width_mm: 20, length_mm: 30}}\n\
         picture: {{{keys}}}\nclasses: {{all: {{share: 1}}}}\n"
    );
    Recipe::parse_with("p.yaml", &text, &AssetSource::Beside(folder.to_owned())).map_err(|fault| fault.to_string())
}

#[test]
fn wrong_pictures_are_told_with_key_and_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let save = |name: &str, bytes: &[u8]| std::fs::write(path.join(name), bytes).expect("written");
    let colours = board();
    let (cols, rows) = colours.dimensions();
    // A part of it is enough wood, and quicker.
    let part = image::imageops::crop_imm(&colours, 0, 0, cols, 220).to_image();
    save("part.png", &png(&part.clone().into()));
    save("text.png", b"no picture");
    save("cut.png", &png(&part.clone().into())[..900]);
    save("even.png", &png(&RgbImage::from_pixel(cols, rows, image::Rgb([90; 3])).into()));
    let noise = RgbImage::from_fn(cols, 220, |x, y| {
        let mixed = (u64::from(x) * 7919 + u64::from(y) * 104_729 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        image::Rgb([100 + (mixed >> 59) as u8; 3])
    });
    save("noise.png", &png(&noise.into()));
    save("small.png", &png(&image::imageops::crop_imm(&colours, 0, 0, 40, 40).to_image().into()));
    save("grey.png", &png(&image::GrayImage::from_pixel(cols, 220, image::Luma([9])).into()));
    save("black.png", &png(&RgbImage::new(cols, 220).into()));
    save("map.exr", b"no map");
    for (keys, key, problem) in [
        ("pixel_mm: 0.1", "log.source", "no picture is named"),
        ("file: none", "log.source", "no picture is named"),
        ("file: none.png", "picture.file", "there is no file"),
        ("file: text.png", "picture.file", "is no picture that can be read"),
        ("file: cut.png", "picture.file", "is no picture that can be read"),
        ("file: even.png, pixel_mm: 0.15", "picture.file", "the same all over"),
        ("file: noise.png, pixel_mm: 0.15", "picture.file", "noise.png"),
        ("file: small.png, pixel_mm: 0.15", "picture.file", "shows"),
        ("file: part.png, pixel_mm: 0.08", "board.length_mm", "its picture shows"),
        ("file: part.png, pixel_mm: 0.15, pixel_across_mm: 0.04", "board.width_mm", "its picture shows"),
        ("file: part.png, pixel_mm: 0.15, labels: part.png", "picture.labels", "classes are grey of 8 bits"),
        ("file: part.png, pixel_mm: 0.15, labels: grey.png", "picture.labels", "no class of wood"),
        ("file: part.png, pixel_mm: 0.15, fibres: small.png", "picture.fibres", "and the picture has"),
        ("fibres: grey.png, pixel_mm: 0.15", "picture.fibres", "is grey"),
        ("fibres: black.png, pixel_mm: 0.15", "picture.fibres", "no colour with a direction"),
        ("fibres: map.exr, pixel_mm: 0.15", "picture.fibres", "map.exr"),
        ("file: part.png, pixel_mm: 0.15, gamma: 2", "picture.gamma", "has no effect beside"),
        ("file: part.png, pixel_mm: 0.15, depth_mm: 2", "picture.depth_mm", "has no effect beside"),
    ] {
        let told = parsed(path, keys).expect_err(keys);
        println!("{told}");
        assert!(told.contains(key) && told.contains(problem), "{keys}: {told}");
    }
    assert!(parsed(path, "file: part.png, pixel_mm: 0.15").is_ok());
    // What is for other boards alone, and what is for boards from pictures alone.
    let text =
        |more: &str| format!("name: p\nsubject: wood\nunstated: fixed\n{more}\nclasses: {{all: {{share: 1}}}}\n");
    for (more, key) in [
        ("picture: {pixel_mm: 0.2}", "picture.pixel_mm"),
        ("picture: {along: 0.2}", "picture.along"),
        ("picture: {file: pictures/board.png}", "picture.file"),
        (
            "log: {source: picture, ring_width_mm: 3}\npicture: {file: pictures/board.png, pixel_mm: 0.15}\nboard: \
                {width_mm: 20, length_mm: 30}",
            "log.ring_width_mm",
        ),
        (
            "log: {source: picture}\nrot: {reach_mm: 3}\npicture: {file: pictures/board.png, pixel_mm: 0.15}\nboard: \
                {width_mm: 20, length_mm: 30}",
            "rot.reach_mm",
        ),
    ] {
        let told = Recipe::parse("p.yaml", &text(more)).expect_err(more).to_string();
        assert!(told.contains(key) && told.contains("has no effect while `log.source` is"), "{told}");
    }
}

/// A rising line of the thesis' colours (slope 1, yellow) is 45 degrees from the scan towards the laser line, and alpha
/// is light.
#[test]
fn drawn_maps_are_fibres() {
    let folder = tempfile::tempdir().expect("a folder");
    let map =
        RgbaImage::from_fn(150, 220, |x, _| image::Rgba(if x < 75 { [255, 255, 0, 255] } else { [0, 255, 255, 128] }));
    std::fs::write(folder.path().join("map.png"), png(&map.into())).expect("written");
    for (first_row, sign) in [("far", 1.0), ("near", -1.0)] {
        let keys = format!("fibres: map.png, pixel_mm: 0.15, first_row: {first_row}");
        let recipe = parsed(folder.path(), &keys).expect("a map");
        let scene = recipe.draw(1, 0);
        let wood = scene.picture.as_ref().expect("read").cut(scene.plan.wood().expect("a board"));
        let [left, right] = [4.0, 17.0].map(|x| wood.at(Vec2::new(x, 15.0), 0.0));
        let half = 0.5_f32.sqrt();
        assert!((left.fibre.dot(glam::Vec3::new(half, sign * half, 0.0)).abs() - 1.0).abs() < 1e-4, "{}", left.fibre);
        assert!(
            (right.fibre.dot(glam::Vec3::new(half, -sign * half, 0.0)).abs() - 1.0).abs() < 1e-4,
            "{}",
            right.fibre
        );
        assert!(right.mu_a > 2.0 * left.mu_a, "half of the light: {} and {}", right.mu_a, left.mu_a);
    }
}

/// What is small in a file and large in memory is told by its headers, and patches are no more than instances can be.
#[test]
fn maps_that_are_too_much_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let map = RgbaImage::from_pixel(320, 220, image::Rgba([255, 255, 0, 255]));
    std::fs::write(path.join("map.png"), png(&map.into())).expect("written");
    let spots = image::GrayImage::from_fn(320, 220, |x, y| image::Luma([1 + ((x + y) % 2) as u8]));
    std::fs::write(path.join("spots.png"), png(&spots.into())).expect("written");
    let told = parsed(path, "fibres: map.png, pixel_mm: 0.15, labels: spots.png").expect_err("too many patches");
    assert!(told.contains("picture.labels") && told.contains("35200 patches, more than 30000"), "{told}");
    let write = |name: &str, names: &[String], size: i32| {
        let channel =
            |name: &String| exr::prelude::AnyChannel::new(name.as_str(), exr::prelude::FlatSamples::F32(vec![1.0; 4]));
        let channels = exr::prelude::AnyChannels::sort(names.iter().map(channel).collect());
        let mut bytes = Cursor::new(Vec::new());
        use exr::prelude::WritableImage;
        exr::prelude::Image::from_channels((2, 2), channels)
            .write()
            .non_parallel()
            .to_buffered(&mut bytes)
            .expect("written");
        let mut bytes = bytes.into_inner();
        let mark = b"dataWindow\0box2i\0";
        let at = bytes.windows(mark.len()).position(|part| part == mark).expect("a window") + mark.len() + 4 + 8;
        for side in 0..2 {
            bytes[at + 4 * side..at + 4 * side + 4].copy_from_slice(&(size - 1).to_le_bytes());
        }
        std::fs::write(path.join(name), bytes).expect("written");
    };
    let own = ["FibreCos2", "FibreSin2", "FibreDive"].map(str::to_owned);
    write("own.exr", &own, 2);
    write("large.exr", &own, 16_000);
    write("many.exr", &(0..40).map(|i| format!("c{i}")).collect::<Vec<_>>(), 2);
    for (file, problem) in [
        ("own", "board.length_mm"),
        ("large", "16000 x 16000 pixels, more than"),
        ("many", "40 channels, more than 16"),
    ] {
        let told = parsed(path, &format!("fibres: {file}.exr, pixel_mm: 0.15")).expect_err(file);
        assert!(told.contains(problem), "{file}: {told}");
    }
}
