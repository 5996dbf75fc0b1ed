//! What of the laser has no effect is refused; pictures come from files.

use std::io::Cursor;

use base::{Gloss, Medium};
use recipe::{Recipe, Scene};
use scanner::optics::{Band, ROWS, Scratch, Sensor, TILE};
use test_support::target::{expose, plate, scene};

const RECIPE: &str = "name: a\nsubject: wood\nunstated: fixed\nclasses: {one: {share: 1}}\n";

/// A surface that throws all light back evenly.
fn white() -> Medium {
    Medium::opaque(Gloss { matte: 1.0, ..Gloss::NONE })
}

/// What the laser would pass over in silence is a fault with a remedy; the same with its default is none.
#[test]
fn numbers_without_effect_are_refused() {
    let faults = [
        ("laser: {line_width_mm: 0.5}", "laser.line_width_mm", "profile: slit"),
        ("laser: {profile: slit, waist_mm: 0.2}", "laser.waist_mm", "profile: gaussian"),
        ("laser: {fan: cylindrical, fan_soft_ends: 0.1}", "laser.fan_soft_ends", "fan: powell"),
        ("laser: {power_noise_profiles: 3}", "laser.power_noise_profiles", "power_noise"),
        ("laser: {mode_profiles: 50}", "laser.mode_profiles", "mode_hop_um"),
        ("laser: {dust_mm: 3}", "laser.dust_mm", "dust_count"),
        ("laser: {profile: point, dust_count: 3}", "laser.dust_count", "profile"),
        ("camera: {glare_um: 100}", "camera.glare_um", "glare_share"),
        ("laser: {second_line_share: 0.3}", "laser.second_line_share", "second_line_mm"),
        ("laser: {skirt_width: 20}", "laser.skirt_width", "skirt_share"),
        ("laser: {streak_share: 0.1}", "laser.streak_share", "streaks_per_mm"),
        ("laser: {glints_per_mm: 1}", "laser.glints_per_mm", "no metal"),
        ("laser: {profile: point, second_line_mm: 3}", "laser.second_line_mm", "profile: point"),
        ("laser: {profile: texture, fan: cylindrical}", "laser.fan", "remove"),
        ("laser: {lobe_share: 0.5, skirt_share: 0.45}", "laser.lobe_share", "0.1"),
        ("laser: {second_line_mm: 20}\nmotion: {step_mm: 0.005}", "laser.second_line_mm", "closer"),
        ("laser: {profile: slit}\ntransport: diffusion", "laser.profile", "gaussian"),
        ("laser: {skirt_share: 0.02}\ntransport: path", "laser.skirt_share", "kernel"),
        ("laser: {texture: none.png}", "laser.texture", "none.png"),
    ];
    for (text, key, remedy) in faults {
        let error = Recipe::parse("a.yaml", &format!("{RECIPE}{text}\n")).expect_err(text).to_string();
        assert!(error.contains(key) && error.contains(remedy), "{text}: {error}");
    }
    // Streaks and glints need fibres and metal.
    let piece = "name: a\nsubject: sawtooth\nunstated: fixed\nclasses: {one: {share: 1}}\n";
    for (text, key, fine) in [
        ("laser: {streaks_per_mm: 1}", "laser.streaks_per_mm", "material: {k_per_mm: 5}"),
        ("laser: {glints_per_mm: 1}\nmaterial: {reflectance: 0.04}", "laser.glints_per_mm", ""),
        ("laser: {glints_per_mm: 1}\nmaterial: {gloss: 0}", "laser.glints_per_mm", ""),
    ] {
        let error = Recipe::parse("a.yaml", &format!("{piece}{text}\n")).expect_err(text).to_string();
        assert!(error.contains(key) && error.contains("no effect"), "{text}: {error}");
        if !fine.is_empty() {
            Recipe::parse("a.yaml", &format!("{piece}{text}\n{fine}\n")).unwrap_or_else(|error| panic!("{error}"));
        }
    }
    let of_class = RECIPE.replace("share: 1}", "share: 1, laser: {lobe_distance: 3}}");
    let error = Recipe::parse("a.yaml", &of_class).expect_err("a class").to_string();
    assert!(error.contains("classes.one.laser.lobe_distance"), "{error}");
    let fine = [
        "laser: {line_width_mm: 0.3}",
        "laser: {profile: slit, line_width_mm: 0.5, second_line_mm: 3, second_line_share: 0.2}",
        "laser: {profile: texture}",
        "laser: {profile: point, point_step_mm: 0.2, m_squared: 1.1}",
        "laser: {fan: cylindrical, skirt_share: {uniform: [0, 0.02]}, skirt_width: 15, streaks_per_mm: 1}",
    ];
    for text in fine {
        let recipe = Recipe::parse("a.yaml", &format!("{RECIPE}{text}\n")).unwrap_or_else(|error| panic!("{error}"));
        // What a recipe means is a recipe itself.
        let again = Recipe::parse("a.yaml", &recipe.canonical_json()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(recipe.hash(), again.hash(), "{text}");
    }
}

/// On pieces and parts it is the material that decides: glints need facets of metal, streaks and the fibres' angles
/// need fibres.
#[test]
fn the_material_decides_what_shines() {
    const DULL: &str = "material: {reflectance: 0.04, gloss: 0.05}\n";
    const FIBROUS: &str = "material: {k_per_mm: 5, fibre_azimuth_deg: 20, fibre_dive_deg: 3}\n";
    let faults = |text: &str| {
        let text = format!("name: a\nsubject: sawtooth\nunstated: fixed\nclasses: {{one: {{share: 1}}}}\n{text}");
        Recipe::parse("a.yaml", &text).map(|_| String::new()).unwrap_or_else(|error| error.to_string())
    };
    for (text, key, remedy) in [
        (format!("{DULL}laser: {{glints_per_mm: 1}}"), "laser.glints_per_mm", "material.reflectance"),
        ("material: {gloss: 0}\nlaser: {glints_per_mm: 1}".to_owned(), "laser.glints_per_mm", "material.gloss"),
        ("laser: {streaks_per_mm: 1}".to_owned(), "laser.streaks_per_mm", "material.k_per_mm"),
        ("material: {fibre_azimuth_deg: 20}".to_owned(), "material.fibre_azimuth_deg", "k_per_mm"),
        ("material: {fibre_dive_deg: 20}".to_owned(), "material.fibre_dive_deg", "k_per_mm"),
        ("material: {fibre_dispersion_deg: 9}".to_owned(), "material.fibre_dispersion_deg", "k_per_mm"),
    ] {
        let found = faults(&text);
        assert!(found.contains(key) && found.contains(remedy), "{text}: {found}");
    }
    for fine in
        ["laser: {glints_per_mm: 1}".to_owned(), FIBROUS.to_owned(), format!("{FIBROUS}laser: {{streaks_per_mm: 1}}")]
    {
        assert_eq!(faults(&fine), "", "{fine}");
    }
}

/// Light of one profile by column, and its mean row.
fn columns(sensor: &Sensor, band: &Band, profile: usize, count: usize) -> Vec<[f64; 2]> {
    let mut scratch = Scratch::default();
    let mut columns = Vec::new();
    for tile in 0..count / TILE {
        sensor.window(band, profile, tile, &mut scratch);
        columns.extend((0..TILE).map(|c| {
            let light = |k: usize| f64::from(scratch.electrons(k, c));
            let sum: f64 = (0..ROWS).map(light).sum();
            let first = f64::from(scratch.windows[0].first_row[c]);
            [sum, (0..ROWS).map(|k| (first + k as f64) * light(k)).sum::<f64>() / sum]
        }));
    }
    columns
}

/// A picture in a file is thrown as it is: its first column at the smallest x, its first row at the largest y, its grey
/// as light.
#[test]
fn pictures_come_from_files() {
    let folder = tempfile::tempdir().expect("a folder");
    // 16 bits: two columns of light 1 and 3; the left one in the upper half, the right one in the lower.
    let grey = [20_000u16, 0, 0, 60_000];
    let picture = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(2, 2, grey.to_vec()).expect("four pixels");
    let mut png = Cursor::new(Vec::new());
    picture.write_to(&mut png, image::ImageFormat::Png).expect("in memory");
    std::fs::write(folder.path().join("a.png"), png.into_inner()).expect("written");
    let text = "laser: {profile: texture, texture: a.png, texture_length_mm: 40, texture_width_mm: 0.8}\n";
    let path = folder.path().join("a.yaml");
    std::fs::write(&path, format!("{RECIPE}{text}")).expect("written");
    let recipe = Recipe::load(path.to_str().expect("a plain name")).unwrap_or_else(|error| panic!("{error}"));
    let mut own = recipe.draw(0, 0);
    own.bench = Scene { bench: scene(1).bench, ..own.clone() }.bench;
    (own.bench.laser.texture_length_mm, own.bench.laser.texture_width_mm) = (40.0, 0.8);
    (own.size.columns, own.size.profiles) = (640, 1);
    let (sensor, band) = expose(&own, plate(white(), 0.0, 0.0, 0.0), 0..1);
    let light = columns(&sensor, &band, 0, 640);
    let rig = sensor.camera().rig;
    let at = |x: f64| light[(rig.project(x, 0.0, 0.0).0).round() as usize];
    let ([left, up], [right, down]) = (at(-14.0), at(14.0));
    assert!((right / left - 3.0).abs() < 0.02, "{left} and {right} electrons");
    // A quarter of the picture on either side of the plane, rows fall with y.
    for (row, y) in [(up, 0.2), (down, -0.2)] {
        let expected = rig.project(14.0, y, 0.0).1;
        assert!((row - expected).abs() < 0.02, "row {row}, {expected}");
    }
    for (name, bytes) in [("b.png", b"no picture".to_vec()), ("a.png", Vec::new())] {
        std::fs::write(folder.path().join(name), bytes).expect("written");
        std::fs::write(&path, format!("{RECIPE}{}", text.replace("a.png", name))).expect("written");
        let error = Recipe::load(path.to_str().expect("a plain name")).expect_err("no picture").to_string();
        assert!(error.contains("laser.texture") && error.contains("grey PNG"), "{error}");
    }
}

/// What a profile shows does not depend on the band that it is in, whatever stands beside the line.
#[test]
fn bands_make_no_difference() {
    let mut scene = scene(64);
    let laser = &mut scene.bench.laser;
    (laser.second_line_mm, laser.streaks_per_mm, laser.width_jitter) = (2.7, 1.0, 0.1);
    (laser.skirt_share, laser.lobe_share, laser.fan_ripple) = (0.02, 0.02, 0.1);
    let look = |band: std::ops::Range<usize>| {
        let (sensor, band) = expose(&scene, pipeline::body(&scene), band);
        let bits = |[light, row]: [f64; 2]| [light.to_bits(), row.to_bits()];
        columns(&sensor, &band, 31, 256).into_iter().map(bits).collect::<Vec<_>>()
    };
    assert!(look(0..64) == look(31..32));
}
