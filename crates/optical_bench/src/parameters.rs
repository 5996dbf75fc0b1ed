//! The numbers of the bench: scan, laser, camera, exposure, noise and speckle.
//!
//! Sources: [T] Kihl and Källberg 2021; [V] vendors' data; [M] engineering estimate; [C] computed in
//! docs/theory/instrument.md.

use base::Need::{self, Amount, Any, Facets, Fibres, On, While};
use base::{Parameter, parameters};

use crate::settings::Optics;

const BEAM: Need = On("laser.profile", &["gaussian", "point"]);
const BEAM_OR_SLIT: Need = On("laser.profile", &["gaussian", "slit"]);
const LINE: Need = On("laser.profile", &["gaussian", "slit", "texture"]);
const GAUSSIAN: Need = On("laser.profile", &["gaussian"]);
const SLIT: Need = On("laser.profile", &["slit"]);
const TEXTURE: Need = On("laser.profile", &["texture"]);
const POINT: Need = On("laser.profile", &["point"]);
const POWELL: Need = On("laser.fan", &["powell"]);
const TURNTABLE: Need = On("motion.kind", &["turntable"]);
const GIVEN: Need = While("camera.scheimpflug", &["given"]);
const BAND_PASS: Need = While("camera.filter", &["band_pass"]);
const HOPS: Need = Any(&["laser.mode_hop_um", "laser.mode_hop_power"]);
const SPECKLE: Need = Amount("speckle.strength");
/// The other models of light know one Gaussian line alone.
const KERNEL: Need = While("transport.model", &["kernel"]);
/// The thesis' scripts know nothing of the sensor.
const PHYSICAL: Need = While("postprocess.order", &["physical"]);

parameters! {
    /// Movement of the object under the laser.
    motion: MotionParameters {
        /// Distance between two profiles.
        step_mm: 0.001, 5.0, 0.068, "[T]", fixed;
        /// Profiles a second while the object moves on; 0: it stands still while it is exposed.
        line_rate_hz: 0.0, 100000.0, 0.0, "free; 0 leaves motion blur out", fixed;
        /// Diffuse reflectance of the conveyor.
        conveyor_reflectance: 0.0, 1.0, 0.04, "[M] black rubber", log_uniform(0.025, 0.08);
        /// Standard deviation of a profile's place, each on its own; cut at 0.45 of the smallest step, so that profiles
        /// stay in order.
        encoder_jitter_um: 0.0, 1000.0, 0.0, "[M] off; 0.5 to 5 with an encoder", fixed;
        /// Amplitude of an error of the place that comes again and again: an eccentric wheel.
        wow_um: 0.0, 5000.0, 0.0, "[M] off; 10 to 100 with a wheel", fixed;
        /// Way after which it comes again: the wheel's circumference. Needs `wow_um`.
        wow_period_mm: 0.1, 10000.0, 200.0, "[M]", fixed, needs [Amount("motion.wow_um")];
        /// Amplitude of a vibration in height of all that stands under the instrument. Needs `line_rate_hz`.
        vibration_um: 0.0, 500.0, 0.0, "[M] off; 1 to 50", fixed, needs [Amount("motion.line_rate_hz")];
        /// Its frequency.
        vibration_hz: 0.1, 10000.0, 60.0, "[M] 20 to 200", log_uniform(20.0, 200.0),
            needs [Amount("motion.vibration_um")];
        /// For `kind: turntable`: distance from the axis at which profiles are `step_mm` apart.
        turn_radius_mm: 0.1, 5000.0, 50.0, "free", fixed, needs [TURNTABLE];
        /// For `kind: turntable`: where along the line the axis stands.
        turn_axis_x_mm: -500.0, 500.0, 0.0, "free", fixed, needs [TURNTABLE];
        /// For `kind: turntable`: the part of the object that stands on the axis, along the scan.
        turn_axis_y_mm: -5000.0, 5000.0, 0.0, "free", fixed, needs [TURNTABLE];
    }
}

parameters! {
    /// The laser line, straight down along the plane y = 0.
    laser: LaserParameters {
        /// Wavelength in vacuum.
        wavelength_nm: 400.0, 1100.0, 660.0, "[T]; spread [M]", normal(660.0, 3.0);
        /// Optical power of the whole line.
        power_mw: 0.01, 5000.0, 50.0, "[M] 5 to 150", uniform(44.0, 56.0);
        /// Half width at 1/e^2 in the waist, across the line.
        waist_mm: 0.005, 2.0, 0.1, "[V]; spread [M]", log_uniform(0.08, 0.13), needs [BEAM];
        /// Height of the waist over the conveyor.
        waist_height_mm: -500.0, 500.0, 20.0, "[M]", uniform(10.0, 30.0), needs [BEAM];
        /// Beam quality M^2.
        m_squared: 1.0, 50.0, 1.3, "[V] from 200 um over 70 mm; spread [M]", uniform(1.1, 1.6), needs [BEAM];
        /// Height of the point that the fan comes from over the conveyor.
        fan_height_mm: 20.0, 5000.0, 400.0, "[M] 200 to 600", fixed;
        /// Full angle of the fan: its ends behind a Powell lens, 1/e^2 behind a cylindrical one.
        fan_angle_deg: 1.0, 120.0, 45.0, "[M] 20 to 75", fixed, needs [BEAM_OR_SLIT];
        /// Half width of the ramps at the ends of a Powell lens's fan, over half the fan.
        fan_soft_ends: 0.001, 0.5, 0.02, "[M] 0.02 to 0.05", uniform(0.02, 0.05), needs [BEAM_OR_SLIT, POWELL];
        /// Greatest departure from an even line: 3 to 5 sinusoids along the fan.
        fan_ripple: 0.0, 0.5, 0.0, "[V] 0.05 to 0.2", fixed, needs [BEAM_OR_SLIT];
        /// Spectral width at half maximum.
        linewidth_nm: 0.001, 20.0, 0.8, "[M] 0.3 to 1.0", log_uniform(0.3, 1.0);
        /// Width of a slit's line at the conveyor.
        line_width_mm: 0.02, 3.0, 0.3, "[T] a slit; width free", fixed, needs [SLIT];
        /// Extent of a texture along the line, at the conveyor.
        texture_length_mm: 1.0, 5000.0, 300.0, "free", fixed, needs [TEXTURE];
        /// Extent of a texture across the line, at the conveyor.
        texture_width_mm: 0.05, 4.0, 0.61, "0.01 a pixel of the thesis' line, as wide as the default waist then", fixed,
            needs [TEXTURE];
        /// Where a point laser stands along the line in the first profile, at the conveyor.
        point_x_mm: -2000.0, 2000.0, 0.0, "free", fixed, needs [POINT];
        /// How far a point laser goes on from profile to profile.
        point_step_mm: -100.0, 100.0, 0.0924, "[C] a column", fixed, needs [POINT];
        /// Length of line about its first place that a point laser goes round in.
        point_span_mm: 0.01, 4000.0, 100.0, "free", fixed, needs [POINT];
        /// Distance along the motion of a second line, parallel to the first; 0 for none.
        second_line_mm: -20.0, 20.0, 0.0, "off", fixed, needs [LINE], zero_without [KERNEL];
        /// Share of the power in the second line.
        second_line_share: 0.0, 0.9, 0.5, "[M]", fixed, needs [LINE, Amount("laser.second_line_mm")];
        /// Bow of the line at both ends of the fan, at the conveyor (smile, quadratic); unknown to the calibration.
        smile_um: -1000.0, 1000.0, 0.0, "[M] 0 to 50", fixed, needs [LINE], zero_without [KERNEL];
        /// The same with unlike signs at the two ends (cubic).
        smile_cubic_um: -1000.0, 1000.0, 0.0, "[M] 0 to 50", fixed, needs [LINE], zero_without [KERNEL];
        /// Share of the power in lines beside the line.
        lobe_share: 0.0, 0.5, 0.0, "[M] 0.001 to 0.02", fixed, needs [GAUSSIAN], zero_without [KERNEL];
        /// Pairs of them, each further pair with 1, 1/4, 1/9 of the first one's light.
        lobe_pairs: 1.0, 3.0, 1.0, "[M]", fixed, count, needs [GAUSSIAN, Amount("laser.lobe_share")];
        /// Distance of the first pair from the line, in half widths w of the line.
        lobe_distance: 1.0, 8.0, 2.5, "[M] 1.5 to 4", uniform(1.5, 4.0), needs [GAUSSIAN, Amount("laser.lobe_share")];
        /// Share of the power in a wide halo around the line.
        skirt_share: 0.0, 0.5, 0.0, "[M] 0.005 to 0.03", fixed, needs [GAUSSIAN], zero_without [KERNEL];
        /// Full width of the halo at half its height, in half widths w of the line.
        skirt_width: 1.0, 40.0, 10.0, "[M] 5 to 20", log_uniform(5.0, 20.0),
            needs [GAUSSIAN, Amount("laser.skirt_share")];
        /// Standard deviation of the line's width along itself, over its width.
        width_jitter: 0.0, 0.3, 0.0, "[M] 0.05", fixed, needs [BEAM_OR_SLIT], zero_without [KERNEL];
        /// Correlation length of that, at the conveyor.
        width_jitter_mm: 0.1, 500.0, 4.0, "[M] 1 to 10", log_uniform(1.0, 10.0),
            needs [BEAM_OR_SLIT, Amount("laser.width_jitter")];
        /// Grains of dust on the window that the fan leaves by; they are the instrument's.
        dust_count: 0.0, 500.0, 0.0, "[M] off; 1 to 10", fixed, count, needs [LINE];
        /// Largest share of the light that a grain takes in the middle of its shadow; shares are even below that.
        dust_shade: 0.01, 1.0, 0.3, "[M] 0.05 to 0.6", uniform(0.05, 0.6), needs [LINE, Amount("laser.dust_count")];
        /// Median width of a grain's shadow at half its depth, at the conveyor.
        dust_mm: 0.2, 50.0, 4.0, "[C] 0.3 mm at 30 of 400 mm of the fan's way", log_uniform(1.0, 10.0),
            needs [LINE, Amount("laser.dust_count")];
        /// Standard deviation of the power over the profiles of a scan, over its mean.
        power_noise: 0.0, 0.3, 0.0, "[M] off; 0.005 to 0.03", fixed;
        /// Profiles over which it is alike (correlation length); below 0.3 each is on its own.
        power_noise_profiles: 0.1, 10000.0, 20.0, "[M]", log_uniform(0.3, 300.0), needs [Amount("laser.power_noise")];
        /// How far along the motion the line jumps when the diode changes between two modes.
        mode_hop_um: 0.0, 200.0, 0.0, "[M] off; 5 to 20", fixed;
        /// Difference of its powers in the two modes, over their mean.
        mode_hop_power: 0.0, 0.5, 0.0, "[M] off; up to 0.01", fixed;
        /// Mean number of profiles that it stays in a mode.
        mode_profiles: 2.0, 100000.0, 300.0, "[M]", log_uniform(100.0, 1000.0), needs [HOPS];
        /// Single fibres that guide light out of the line, on wood, at any moment.
        streaks_per_mm: 0.0, 50.0, 0.0, "[M] 0.5 to 2", fixed, needs [Fibres], zero_without [KERNEL];
        /// Their width.
        streak_width_um: 5.0, 200.0, 40.0, "[M] 30 to 50, a tracheid", uniform(30.0, 50.0),
            needs [Amount("laser.streaks_per_mm")];
        /// Mean length on either side of the line, an exponential law.
        streak_length_mm: 0.02, 5.0, 0.4, "[M]", log_uniform(0.25, 0.6), needs [Amount("laser.streaks_per_mm")];
        /// Their mean irradiance over the peak of the line.
        streak_share: 0.0, 0.5, 0.03, "[M] 0.01 to 0.05", log_uniform(0.01, 0.05),
            needs [Amount("laser.streaks_per_mm")];
        /// Facets of metal that mirror light into the lens, at any moment.
        glints_per_mm: 0.0, 50.0, 0.0, "[M]", fixed, needs [Facets];
        /// Mean light of such a facet over that of the metal around it in a column, an exponential law.
        glint_gain: 0.0, 1000.0, 4.0, "[M]", log_uniform(2.5, 6.0), needs [Amount("laser.glints_per_mm")];
        /// Mean length of a facet along the motion, an exponential law.
        glint_length_mm: 0.01, 5.0, 0.15, "[M] two passes of a cutter", log_uniform(0.1, 0.22),
            needs [Amount("laser.glints_per_mm")];
    }
}

parameters! {
    /// The camera, tilted against the laser plane, and its lens.
    camera: CameraParameters {
        /// From the lens to the origin.
        distance_mm: 50.0, 5000.0, 410.0, "[T]", fixed;
        /// Between the optical axis and the laser plane.
        tilt_deg: 5.0, 75.0, 25.0, "[T]", fixed;
        /// Focal length.
        focal_length_mm: 4.0, 200.0, 25.0, "[T]", fixed;
        /// f-number.
        f_number: 1.0, 32.0, 2.8, "[T]", fixed;
        /// Tilt of the sensor about the line's direction, where `scheimpflug` is `given`.
        sensor_tilt_deg: -30.0, 30.0, 0.0, "[T] no adapter in the simulation", fixed, needs [GIVEN];
        /// Distance along the axis at which the lens is sharp, where `scheimpflug` is `given`; 1e9 is infinity.
        focus_distance_mm: 20.0, 1e9, 410.0, "the bench; [T] infinity in the simulation", fixed, needs [GIVEN];
        /// Radial distortion of second order (Brown and Conrady) of normalised directions.
        distortion_k1: -0.5, 0.5, 0.0, "[M] -0.1 to 0 for 25 mm lenses", fixed;
        /// Radial distortion of fourth order.
        distortion_k2: -1.0, 1.0, 0.0, "[M] 0 to 0.1", fixed;
        /// Radial distortion of sixth order.
        distortion_k3: -2.0, 2.0, 0.0, "[M]", fixed;
        /// Tangential distortion, most of it along the rows' order.
        distortion_p1: -0.02, 0.02, 0.0, "[M] 0.0005", fixed;
        /// Tangential distortion, most of it along the line.
        distortion_p2: -0.02, 0.02, 0.0, "[M] 0.0005", fixed;
        /// Rows that the image has moved since the calibration when a scan begins: of an instrument that has warmed up.
        drift_rows: -50.0, 50.0, 0.0, "[C] off; 0.4 for 10 K at 410 mm of aluminium", fixed;
        /// Rows that it moves on until the scan ends.
        drift_scan_rows: -50.0, 50.0, 0.0, "[M] off; 0 to 0.2", fixed;
        /// Growth of the image along the rows since the calibration, about the axis, over its size.
        drift_scale: -0.05, 0.05, 0.0, "[C] off; 2e-4 for 10 K of aluminium", fixed;
        /// Pitch of the pixels.
        pixel_um: 1.0, 30.0, 6.0, "[T]", fixed;
        /// Standard deviation of the lens's point spread on the sensor by aberrations.
        blur_um: 0.0, 30.0, 2.5, "[M] 1.5 to 6", uniform(1.5, 6.0);
        /// Share of a pixel's charge that each of its four neighbours collects.
        crosstalk: 0.0, 0.1, 0.0, "[M] 0.01 to 0.02", fixed;
        /// Share of the laser's light that lens, window and the dust on them spread far about its image: veiling glare.
        glare_share: 0.0, 0.5, 0.0, "[M] off; 0.005 to 0.03 of C-mount lenses", fixed, zero_without [PHYSICAL];
        /// Radius on the sensor within which half of that falls.
        glare_um: 20.0, 5000.0, 250.0, "[M] 20 to 100 pixels", log_uniform(120.0, 600.0),
            needs [Amount("camera.glare_share")];
        /// Transmission of lens and band-pass filter, in the filter's middle.
        transmission: 0.01, 1.0, 0.75, "[M]", uniform(0.7, 0.8);
        /// Share of light that the lens's mounts take half a sensor's width away from the axis, rising with the square.
        vignetting: 0.0, 0.95, 0.0, "[M] 0 to 0.3, beyond the cosines of geometry", fixed;
        /// Middle of the band that the filter passes at right angles, where `filter` is `band_pass`.
        filter_centre_nm: 350.0, 1200.0, 660.0, "[T]", fixed, needs [BAND_PASS];
        /// Full width of that band at half of its height.
        filter_width_nm: 2.0, 300.0, 30.0, "[T] 660 +- 15", fixed, needs [BAND_PASS];
        /// Spectral irradiance of the object by lamps and windows, the same from all sides.
        ambient_w_per_m2_nm: 0.0, 3.0, 0.0, "[M] 0.005 in a lit hall, 1.3 in sunlight; 0 under a hood", fixed,
            zero_without [PHYSICAL];
    }
}

parameters! {
    /// From light to digital numbers (EMVA 1288). DN count on the scale of 8 bits (0 to 255) whatever `bits` is.
    exposure: ExposureParameters {
        /// Exposure time.
        time_us: 0.1, 100000.0, 40.0, "[C] 10 to 400", fixed;
        /// Electrons per photon.
        quantum_efficiency: 0.01, 1.0, 0.55, "[M] 0.45 to 0.65", uniform(0.5, 0.6);
        /// Electrons at which a pixel is full; it reads the greatest number then.
        full_well_e: 500.0, 1000000.0, 25000.0, "[M] 10000 to 40000", uniform(23000.0, 27000.0);
        /// Mean digital number without light.
        dark_level_dn: 0.0, 128.0, 11.6, "[T]; spread [M]", normal(11.6, 0.6);
        /// Standard deviation of a dark pixel, everything included but for dark current.
        dark_noise_dn: 0.3, 30.0, 1.09, "[T]; spread [M]", uniform(1.0, 1.2);
        /// Part of that which is common to a row and changes with each exposure.
        row_noise_dn: 0.0, 10.0, 0.3, "[M]", uniform(0.15, 0.45), zero_without [PHYSICAL];
        /// Part of that which is common to a row and stays.
        row_pattern_dn: 0.0, 10.0, 0.2, "[M]", uniform(0.1, 0.3), zero_without [PHYSICAL];
        /// Part of that which is common to a column and stays.
        column_pattern_dn: 0.0, 10.0, 0.0, "[M] 0.1; off", fixed, zero_without [PHYSICAL];
        /// Part of that by which pixels differ without light (DSNU).
        dsnu_dn: 0.0, 10.0, 0.0, "[M] 0.25; off", fixed, zero_without [PHYSICAL];
        /// Standard deviation of the pixels' response to light (PRNU).
        prnu: 0.0, 0.2, 0.0, "[M] 0.005 to 0.02; off", fixed, zero_without [PHYSICAL];
        /// Electrons that gather in a pixel without light.
        dark_current_e_per_s: 0.0, 1e6, 50.0, "[M]", log_uniform(20.0, 125.0), zero_without [PHYSICAL];
        /// Share of the charge above the full well that flows to the neighbours along the column.
        blooming: 0.0, 1.0, 0.0, "[M] none, as in a global shutter with a drain", fixed, zero_without [PHYSICAL];
        /// Share of the pixels that are dead or always full, one half each.
        defect_share: 0.0, 0.01, 0.0, "[M] 1e-5; off", fixed, zero_without [PHYSICAL];
        /// Scale of the photon noise: 1 as nature has it, 0 to switch it off.
        shot_noise: 0.0, 1.0, 1.0, "Poisson", fixed, zero_without [PHYSICAL];
    }
}

parameters! {
    /// Speckle, anchored to the object.
    speckle: SpeckleParameters {
        /// Scale of the contrast: 1 as physics has it, 0 to switch it off.
        strength: 0.0, 1.0, 1.0, "Goodman", fixed;
        /// Independent patterns in light reflected by the surface: 1 polarised, 2 depolarised. The law is that of the
        /// largest of 1, 2 and 4 patterns below it.
        surface_patterns: 1.0, 64.0, 1.0, "[C]", fixed, count, of [SPECKLE];
        /// Extra independent patterns in light from below the surface, on top of path spread and depolarisation.
        volume_patterns: 1.0, 64.0, 2.0, "[C]", fixed, count, of [SPECKLE];
    }
}

const LAMPS: Need = On("lamps.number", &["one", "two"]);
const TWO_LAMPS: Need = On("lamps.number", &["two"]);
const SHEEN: Need = Amount("lamps.sheen");

parameters! {
    /// Lamps of diffuse light beside the laser, and how the sensor takes their light: the map `grey`. DN count on the
    /// scale of 8 bits.
    lamps: LampParameters {
        /// Wavelength of the light that is measured.
        wavelength_nm: 400.0, 1100.0, 660.0, "[M] red; the laser's, which media are given at", fixed, needs [LAMPS];
        /// Difference of wavelengths over which absorption falls by a factor e: that of wood's brown dyes. Needs a
        /// wavelength that is not the laser's.
        absorption_decay_nm: 20.0, 2000.0, 110.0, "[M] spruce, 450 to 650 nm", log_uniform(90.0, 130.0), needs [LAMPS];
        /// Angle of the lamp from upright, in the plane across the line; above 0 on the side that profiles to come lie
        /// on.
        tilt_deg: -60.0, 60.0, 45.0, "[M] 30 to 60", fixed, needs [LAMPS];
        /// The same of the second lamp.
        second_tilt_deg: -60.0, 60.0, -45.0, "[M]", fixed, needs [TWO_LAMPS];
        /// Share of the lamps' light that the second one gives.
        second_share: 0.0, 1.0, 0.5, "[M]", fixed, needs [TWO_LAMPS];
        /// Angle under which a lamp is seen from the object, across the line.
        width_deg: 1.0, 20.0, 8.0, "[M] a bar of 40 mm at 300 mm", fixed, needs [LAMPS];
        /// Share of the light that comes from all sides: housing, conveyor, second reflections.
        fill: 0.0, 1.0, 0.1, "[M] 0.05 to 0.3", uniform(0.05, 0.3), needs [LAMPS];
        /// Highlight of fibres that mirror a lamp into the lens, over the light of a white surface so lit.
        sheen: 0.0, 2.0, 0.0, "[M] 0.3 to 1 on sawn spruce, by photographs", fixed, needs [LAMPS];
        /// Standard deviation of the fibres' lean about their direction, which makes the highlight wide.
        sheen_spread_deg: 2.0, 40.0, 10.0, "[M] 6 to 15", uniform(6.0, 15.0), needs [LAMPS, SHEEN];
        /// Standard deviation on the object of what lens, pixel and movement blur.
        blur_mm: 0.0, 0.2, 0.04, "[M] half a pixel", uniform(0.03, 0.06), needs [LAMPS];
        /// Mean digital number of a level white surface less the dark level; clear wood has 0.7 of it.
        white_dn: 1.0, 5000.0, 230.0, "[M] clear wood at 160", uniform(210.0, 250.0), needs [LAMPS];
        /// Electrons at the end of the scale.
        full_well_e: 500.0, 1000000.0, 15000.0, "[M] 10000 to 40000", log_uniform(10000.0, 40000.0), needs [LAMPS];
        /// Mean digital number without light.
        dark_level_dn: 0.0, 128.0, 5.0, "[M]", uniform(4.0, 6.0), needs [LAMPS];
        /// Standard deviation of a dark pixel.
        dark_noise_dn: 0.0, 30.0, 0.6, "[M]", uniform(0.5, 0.8), needs [LAMPS];
    }
}

/// The whole bench of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bench {
    /// Movement.
    pub motion: MotionParameters,
    /// Laser.
    pub laser: LaserParameters,
    /// Camera.
    pub camera: CameraParameters,
    /// Exposure.
    pub exposure: ExposureParameters,
    /// Speckle.
    pub speckle: SpeckleParameters,
    /// Lamps beside the laser.
    pub lamps: LampParameters,
    /// What of the camera is the same for all samples.
    pub optics: Optics,
}

impl Bench {
    /// Sections of a recipe that describe it.
    pub const SECTIONS: [&'static str; 6] = [
        MotionParameters::GROUP,
        LaserParameters::GROUP,
        CameraParameters::GROUP,
        ExposureParameters::GROUP,
        SpeckleParameters::GROUP,
        LampParameters::GROUP,
    ];

    /// Fills every group from `value`, asked once for each declaration in the order of the groups.
    pub fn from_values(value: &mut dyn FnMut(&'static Parameter) -> f64, optics: Optics) -> Self {
        Self {
            motion: MotionParameters::from_values(value),
            laser: LaserParameters::from_values(value),
            camera: CameraParameters::from_values(value),
            exposure: ExposureParameters::from_values(value),
            speckle: SpeckleParameters::from_values(value),
            lamps: LampParameters::from_values(value),
            optics,
        }
    }
}

impl Default for Bench {
    /// Every number at its declared default.
    fn default() -> Self {
        Self::from_values(&mut |parameter| parameter.default, Optics::default())
    }
}
