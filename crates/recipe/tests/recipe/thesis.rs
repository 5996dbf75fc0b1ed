//! The recipes of the thesis have its tables' numbers; keys that its scripts know nothing of are refused, not passed
//! over.

use optical_bench::settings::{Order, SpeckleLaw};
use recipe::Recipe;

/// Tables 3.1 to 3.3.
#[test]
fn recipes_have_the_numbers_of_the_tables() {
    for (name, profiles, blur, scale, scatter) in [
        ("thesis/sawtooth", None, 0.5, 3.5, None),
        ("thesis/wood", Some(4000), 1.0, 6.0, Some((1, 8))),
        ("thesis/blister", Some(1000), 0.5, 7.0, Some((7, 5))),
    ] {
        let recipe = Recipe::load(name).unwrap_or_else(|error| panic!("{error}"));
        for spelling in [format!("recipes/{name}.yaml"), format!("./recipes/{name}.yaml")] {
            assert_eq!(Recipe::load(&spelling).expect("embedded").hash(), recipe.hash(), "{spelling}");
        }
        let scene = recipe.draw(0, 0);
        let camera = scene.bench.camera;
        assert_eq!(
            [camera.distance_mm, camera.focal_length_mm, camera.f_number, camera.pixel_um],
            [410.0, 25.0, 2.8, 6.0]
        );
        assert_eq!((scene.size.columns, scene.size.rows), (2560, 832));
        assert_eq!(camera.sensor_tilt_deg, 0.0);
        assert!(profiles.is_none_or(|n| n == scene.size.profiles) && scene.bench.motion.step_mm == 0.068);
        let scripts = scene.postprocess;
        assert_eq!(scripts.order, Order::BlurSpeckleNoise);
        assert_eq!((scripts.blur_radius_px, scripts.intensity_scale), (blur, scale), "{name}");
        let pattern = scripts.pattern;
        assert_eq!((pattern.size_px, pattern.mask_px, pattern.factor), (1000, 500, 5));
        assert_eq!(pattern.law, SpeckleLaw::Rayleigh);
        let exposure = scene.bench.exposure;
        assert_eq!((exposure.dark_level_dn, exposure.dark_noise_dn), (11.6, 1.09));
        let extraction = scene.extraction;
        let own = (extraction.scatter_offset_rows, extraction.scatter_width_rows);
        assert!(scatter.is_none_or(|scatter| scatter == own), "{name}: {own:?}");
    }
}

const QUIET: &str = "exposure: {row_noise_dn: 0, row_pattern_dn: 0, dark_current_e_per_s: 0, shot_noise: 0}";

fn faults(text: &str) -> String {
    let text = format!("name: a\nsubject: wood\nunstated: fixed\nclasses: {{one: {{share: 1}}}}\n{text}\n");
    Recipe::parse("a.yaml", &text).map(|_| String::new()).unwrap_or_else(|error| error.to_string())
}

/// Each key that has no effect is a fault that names it; what is left is none.
#[test]
fn idle_keys_are_refused() {
    for order in &Order::NAMES[1..] {
        assert_eq!(faults(&format!("{QUIET}\npostprocess: {{order: {order}}}")), "", "{order}");
    }
    for (text, key) in [
        ("postprocess: {blur_radius_px: 1}".to_owned(), "postprocess.blur_radius_px"),
        ("postprocess: {order: physical, intensity_scale: 2}".to_owned(), "postprocess.intensity_scale"),
        (format!("{QUIET}\npostprocess: {{order: noise_speckle, blur_radius_px: 1}}"), "postprocess.blur_radius_px"),
        (format!("{QUIET}\npostprocess: {{order: blur_noise, sampling_factor: 6}}"), "postprocess.sampling_factor"),
        (format!("{QUIET}\ncamera: {{glare_share: 0.02}}\npostprocess: {{order: blur_noise}}"), "camera.glare_share"),
        (format!("{QUIET}\nspeckle: {{law: rayleigh}}\npostprocess: {{order: blur_noise}}"), "speckle.law"),
        (format!("{QUIET}\nspeckle: {{strength: 0.5}}\npostprocess: {{order: noise_speckle}}"), "speckle.strength"),
        ("postprocess: {order: blur_noise}".to_owned(), "exposure.shot_noise"),
        ("postprocess: {order: blur_noise}".to_owned(), "exposure.row_noise_dn"),
        (format!("{QUIET}\npostprocess: {{order: noise_speckle, mask_px: 501}}"), "postprocess.mask_px"),
    ] {
        let found = faults(&text);
        assert!(found.contains(key), "{text}: {found}");
    }
    let hdr = QUIET.replace("{row", "{hdr: soft, row");
    assert!(faults(&format!("{hdr}\npostprocess: {{order: blur_noise}}")).contains("exposure.hdr"));
    assert_eq!(faults("exposure: {hdr: soft, bits: 12}"), "");
    let twelve = "exposure: {bits: 12}\nextraction: {scatter_offset_rows: 0, scatter_width_rows: 9}";
    assert!(faults(twelve).contains("at most 16"), "{}", faults(twelve));
}
