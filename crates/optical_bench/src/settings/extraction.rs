//! How a profile is read from a frame, by the names that the real camera has for it.

use base::words;

words! {
    /// How the peak is placed between the rows, by name.
    PeakMethodName {
        /// [`PeakMethod::CentreOfGravity`].
        CentreOfGravity = "centre_of_gravity",
        /// [`PeakMethod::Parabola`].
        Parabola = "parabola",
        /// [`PeakMethod::Gaussian`].
        Gaussian = "gaussian",
        /// [`PeakMethod::BlaisRioux`].
        BlaisRioux = "blais_rioux",
        /// [`PeakMethod::Fir`].
        Fir = "fir",
    }
}

/// How the peak is placed between the rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PeakMethod {
    /// Centre of gravity of the light about the peak.
    CentreOfGravity,
    /// Vertex of the parabola through the peak and its two neighbours.
    Parabola,
    /// The same through their logarithms.
    Gaussian,
    /// Zero of the difference of the `order / 2` rows behind and before.
    BlaisRioux {
        /// 2, 4 or 8 [px].
        order: usize,
    },
    /// Zero of the derivative after binomial smoothing.
    Fir {
        /// Taps of the smoothing, odd [px].
        length: usize,
    },
}

words! {
    /// Which peak of a column counts.
    PeakChoice {
        /// The greatest number; of several alike the first. GlobalMax of the camera.
        Strongest = "strongest",
        /// The first number at or above the threshold after which numbers do not rise. FirstLocalMax of the camera.
        First = "first",
    }
}

words! {
    /// In which direction rows are searched: it decides what "first" means.
    SearchDirection {
        /// From row 0 on.
        Standard = "standard",
        /// From the last row on.
        Reverse = "reverse",
    }
}

words! {
    /// Which side windows Scatter sums.
    ScatterMode {
        /// Both sides of the peak.
        Symmetric = "symmetric",
        /// Rows before the peak (smaller row numbers).
        Front = "front",
        /// Rows after the peak.
        Back = "back",
    }
}

words! {
    /// What becomes of the dark level in Scatter.
    ScatterDark {
        /// It stays in the sum, as the camera has it.
        Kept = "kept",
        /// It is taken out; what is left ends at 0.
        Subtracted = "subtracted",
    }
}

words! {
    /// What Range is, by name.
    RangeFormName {
        /// [`RangeForm::Calibrated`].
        Calibrated = "calibrated",
        /// [`RangeForm::Uncalibrated`].
        Uncalibrated = "uncalibrated",
        /// [`RangeForm::Rectified`].
        Rectified = "rectified",
    }
}

/// What Range is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum RangeForm {
    /// Height at each sensor column [mm]. CalibratedAC of the camera.
    #[default]
    Calibrated,
    /// Sensor row at each sensor column [px]. UncalibratedC of the camera.
    Uncalibrated,
    /// Height on an even grid of x [mm]. RectifiedC of the camera.
    Rectified {
        /// Distance of the grid's columns [mm]; `None` for that of the sensor's columns at z = 0.
        pitch_mm: Option<f64>,
    },
}

impl RangeForm {
    /// Name in recipes and files.
    pub fn name(self) -> &'static str {
        let name = match self {
            Self::Calibrated => RangeFormName::Calibrated,
            Self::Uncalibrated => RangeFormName::Uncalibrated,
            Self::Rectified { .. } => RangeFormName::Rectified,
        };
        name.name()
    }

    /// Unit of the numbers.
    pub fn unit(self) -> &'static str {
        if self == Self::Uncalibrated { "px" } else { "mm" }
    }
}

/// How a profile is read from a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extraction {
    /// How the peak is placed between the rows.
    pub method: PeakMethod,
    /// Which peak of a column counts.
    pub peak: PeakChoice,
    /// From where peaks are searched.
    pub direction: SearchDirection,
    /// Rows on each side of the peak that the position is made from: 3, 7 or 15 [px]. Parabola and Gaussian use one.
    pub window_rows: usize,
    /// Smallest digital number of a peak [DN].
    pub threshold_dn: f64,
    /// Steps per row in which the peak position is given; 0 leaves it unrounded.
    pub subpixel_steps: u32,
    /// Which side windows Scatter sums.
    pub scatter_mode: ScatterMode,
    /// Distance from the peak to the first summed row; 0 includes the peak [px].
    pub scatter_offset_rows: usize,
    /// Rows that are summed on each side [px].
    pub scatter_width_rows: usize,
    /// What becomes of the dark level in Scatter.
    pub scatter_dark: ScatterDark,
    /// What Range is.
    pub range: RangeForm,
}
