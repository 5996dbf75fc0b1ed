//! Words of data sheets that are no keys: where one stands in a recipe, the fault names the keys that say the same.

/// Words, in small letters, and what says the same in a recipe. A part in backquotes is the path of a key.
const WORDS: [(&[&str], &str); 22] = [
    (&["qe", "eta", "quantum_yield"], "`exposure.quantum_efficiency`"),
    (&["aperture", "f_stop", "fstop", "f_no", "iris", "stop"], "`camera.f_number`"),
    (&["bit_depth", "bitdepth", "adc_bits", "bits_per_pixel", "bpp", "adc"], "`exposure.bits`"),
    (
        &["resolution", "image_size", "sensor_size", "roi", "window"],
        "`scan.columns` (along the line), `camera.rows` (across it) and `scan.profiles`",
    ),
    (
        &["gain", "conversion_gain", "system_gain", "sensitivity", "iso", "responsivity"],
        "`exposure.full_well_e`, the electrons that read as the greatest number: a gain of K DN per electron on 8 \
            bits is 255 / K",
    ),
    (
        &["species", "wood_species", "wood", "timber", "tree"],
        "no key, but a recipe of its own: `gen recipe list` has species/pine, species/oak and more; or change \
            `media.earlywood_mu_a_per_mm` and its neighbours",
    ),
    (&["frame_rate", "framerate", "fps", "profile_rate", "scan_rate", "sampling_rate"], "`motion.line_rate_hz`"),
    (&["shutter", "integration_time", "exposure_time", "shutter_time"], "`exposure.time_us`"),
    (&["pixel_size", "pixel_pitch", "pitch", "cell_size"], "`camera.pixel_um`"),
    (&["power", "laser_power", "output_power"], "`laser.power_mw`"),
    (&["triangulation_angle", "camera_angle", "view_angle", "angle", "tilt"], "`camera.tilt_deg`"),
    (&["standoff", "stand_off", "clearance", "clearance_distance"], "`camera.working_distance_mm`"),
    (
        &["fov", "field_of_view", "field", "measuring_range", "scan_width"],
        "no key: it follows from `camera.distance_mm`, `camera.focal_length_mm`, `camera.pixel_um` and `scan.columns` \
            (`gen rig` prints it)",
    ),
    (&["speed", "belt_speed", "conveyor_speed", "velocity", "feed"], "`motion.speed_mm_per_s`"),
    (&["full_well_capacity", "saturation_capacity", "fwc", "well_depth"], "`exposure.full_well_e`"),
    (&["read_noise", "readout_noise", "temporal_dark_noise", "noise"], "`exposure.dark_noise_dn`"),
    (&["offset", "black_level", "dark_offset", "pedestal"], "`exposure.dark_level_dn`"),
    (&["fwhm", "beam_diameter", "spot_size", "line_thickness", "laser_width"], "`laser.waist_fwhm_mm`"),
    (&["divergence", "opening_angle", "spread_angle"], "`laser.fan_angle_deg`"),
    (&["magnification"], "no key: it follows from `camera.focal_length_mm` and `camera.distance_mm`"),
    (&["colour", "color"], "`laser.wavelength_nm`"),
    (&["samples", "seed"], "no key: give it on the command line, `gen --recipe FILE -n N --seed S`"),
];

/// What says the same as the word `name`, where it is one of data sheets.
pub(super) fn keys_for(name: &str) -> Option<String> {
    let name = name.to_lowercase().replace(['-', ' '], "_");
    let (_, says) = WORDS.iter().find(|(words, _)| words.contains(&name.as_str()))?;
    Some(match says.strip_prefix("no key") {
        Some(rest) => format!("`{name}` is no key{rest}"),
        None => format!("what data sheets call `{name}` is {says}"),
    })
}

#[cfg(test)]
mod tests {
    use super::super::alternatives::ALTERNATIVES;
    use super::super::{SECTIONS, home};
    use super::*;
    use crate::Recipe;

    fn paths() -> Vec<String> {
        let settings = SECTIONS.iter().flat_map(|section| section.settings).map(|setting| setting.path.to_owned());
        let parameters = SECTIONS.iter().flat_map(|section| section.parameters).map(|parameter| parameter.path());
        let others = ALTERNATIVES.iter().map(|other| format!("{}.{}", other.section, other.name));
        settings.chain(parameters).chain(others).collect()
    }

    /// Guards words that lead nowhere: each key that is named exists, no word stands twice, and none is a key itself.
    #[test]
    fn words_lead_to_keys() {
        let paths = paths();
        let mut seen = Vec::new();
        for (words, says) in WORDS {
            for path in says.split('`').skip(1).step_by(2).filter(|path| !path.starts_with("gen ")) {
                assert!(paths.iter().any(|known| known == path), "{path} is no key");
            }
            for word in words {
                assert!(!seen.contains(word), "{word} stands twice");
                seen.push(word);
                let is_key = |path: &String| path.rsplit('.').next() == Some(word);
                assert!(!paths.iter().any(is_key), "{word} is a key");
                assert!(!SECTIONS.iter().any(|section| section.path == *word), "{word} is a section");
            }
        }
    }

    /// Guards answers by spelling alone: each word gets its keys named at the top of a recipe and in every section,
    /// however it is spelt.
    #[test]
    fn each_word_is_answered_wherever_it_stands() {
        for (words, says) in WORDS {
            for word in words {
                let named = says.split('`').nth(1).expect(says);
                let spelt = [word.to_uppercase(), word.replace('_', "-")];
                assert!(
                    spelt.iter().all(|word| home(None, word, &[]).is_some_and(|text| text.contains(named))),
                    "{word}"
                );
            }
        }
        for section in ["", "scan", "motion", "laser", "camera", "exposure", "board", "output"] {
            let keys = if section.is_empty() { "QE: 0.6".into() } else { format!("{section}: {{QE: 0.6}}") };
            let text = format!("name: x\nsubject: wood\nunstated: fixed\nclasses: {{a: {{share: 1}}}}\n{keys}\n");
            let faults = Recipe::parse("x.yaml", &text).expect_err("it has no such key").to_string();
            assert!(faults.contains("what data sheets call `qe` is `exposure.quantum_efficiency`"), "{faults}");
        }
    }
}
