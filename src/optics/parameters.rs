//! The numbers of the bench: scan, laser, camera, exposure, noise and speckle.
//!
//! Sources: [T] Kihl and Källberg 2021; [V] vendors' data; [M] engineering estimate; [C] computed in docs/instrument.md.

use procedural::parameters;

parameters! {
    /// Movement of the object under the laser.
    motion: Motion {
        /// Distance between two profiles.
        step_mm: 0.001, 5.0, 0.068, "[T]";
        /// Diffuse reflectance of the conveyor.
        conveyor_reflectance: 0.0, 1.0, 0.04, "[M] black rubber";
    }
}

parameters! {
    /// The laser line, straight down along the plane y = 0.
    laser: Laser {
        /// Wavelength in vacuum.
        wavelength_nm: 400.0, 1100.0, 660.0, "[T]";
        /// Optical power of the whole line.
        power_mw: 0.01, 5000.0, 50.0, "[M] 5 to 150";
        /// Half width at 1/e^2 in the waist, across the line.
        waist_mm: 0.005, 2.0, 0.1, "[V]";
        /// Height of the waist over the conveyor.
        waist_height_mm: -500.0, 500.0, 20.0, "[M]";
        /// Beam quality M^2.
        m_squared: 1.0, 50.0, 1.3, "[V] from 200 um over 70 mm";
        /// Height of the point that the fan comes from over the conveyor.
        fan_height_mm: 20.0, 5000.0, 400.0, "[M] 200 to 600";
        /// Full angle of the fan (Powell lens: even line on a plane).
        fan_angle_deg: 1.0, 120.0, 45.0, "[M] 20 to 75";
        /// Spectral width at half maximum.
        linewidth_nm: 0.001, 20.0, 0.8, "[M] 0.3 to 1.0";
    }
}

parameters! {
    /// The camera, tilted against the laser plane, sensor tilted to focus it (Scheimpflug).
    camera: Camera {
        /// From the lens to the origin.
        distance_mm: 50.0, 5000.0, 410.0, "[T]";
        /// Between the optical axis and the laser plane.
        tilt_deg: 5.0, 75.0, 25.0, "[T]";
        /// Focal length.
        focal_length_mm: 4.0, 200.0, 25.0, "[T]";
        /// f-number.
        f_number: 1.0, 32.0, 2.8, "[T]";
        /// Pitch of the pixels.
        pixel_um: 1.0, 30.0, 6.0, "[T]";
        /// Standard deviation of the lens's point spread on the sensor (aberration and diffraction).
        blur_um: 0.0, 30.0, 2.5, "[M] 1.5 to 6";
        /// Transmission of lens and band-pass filter.
        transmission: 0.01, 1.0, 0.75, "[M]";
    }
}

parameters! {
    /// From light to digital numbers (EMVA 1288). DN count on the scale of 8 bits (0 to 255) whatever `bits` is.
    exposure: Exposure {
        /// Exposure time.
        time_us: 0.1, 100000.0, 40.0, "[C] 10 to 400";
        /// Electrons per photon.
        quantum_efficiency: 0.01, 1.0, 0.55, "[M] 0.45 to 0.65";
        /// Electrons at which a pixel is full; it reads the greatest number then.
        full_well_e: 500.0, 1000000.0, 25000.0, "[M] 10000 to 40000";
        /// Mean digital number without light.
        dark_level_dn: 0.0, 128.0, 11.6, "[T]";
        /// Standard deviation of a dark pixel, everything included but for dark current.
        dark_noise_dn: 0.3, 30.0, 1.09, "[T]";
        /// Part of that which is common to a row and changes with each exposure.
        row_noise_dn: 0.0, 10.0, 0.3, "[M]";
        /// Part of that which is common to a row and stays.
        row_pattern_dn: 0.0, 10.0, 0.2, "[M]";
        /// Part of that which is common to a column and stays.
        column_pattern_dn: 0.0, 10.0, 0.0, "[M] 0.1; off";
        /// Part of that by which pixels differ without light (DSNU).
        dsnu_dn: 0.0, 10.0, 0.0, "[M] 0.25; off";
        /// Standard deviation of the pixels' response to light (PRNU).
        prnu: 0.0, 0.2, 0.0, "[M] 0.005 to 0.02; off";
        /// Electrons that gather in a pixel without light.
        dark_current_e_per_s: 0.0, 1e6, 50.0, "[M]";
        /// Share of the charge above the full well that flows to the neighbours along the column.
        blooming: 0.0, 1.0, 0.0, "[M] none, as in a global shutter with a drain";
        /// Share of the pixels that are dead or always full, one half each.
        defect_share: 0.0, 0.01, 0.0, "[M] 1e-5; off";
        /// Scale of the photon noise: 1 as nature has it, 0 to switch it off.
        shot_noise: 0.0, 1.0, 1.0, "Poisson";
    }
}

parameters! {
    /// Speckle, anchored to the object.
    speckle: Speckle {
        /// Scale of the contrast: 1 as physics has it, 0 to switch it off.
        strength: 0.0, 1.0, 1.0, "Goodman";
        /// Independent patterns in light reflected by the surface: 1 polarised, 2 depolarised.
        surface_patterns: 1.0, 64.0, 1.0, "[C]", count;
        /// Extra independent patterns in light from below the surface, on top of path spread and depolarisation.
        volume_patterns: 1.0, 64.0, 2.0, "[C]", count;
    }
}

/// The whole bench of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bench {
    /// Movement.
    pub motion: Motion,
    /// Laser.
    pub laser: Laser,
    /// Camera.
    pub camera: Camera,
    /// Exposure.
    pub exposure: Exposure,
    /// Speckle.
    pub speckle: Speckle,
}
