//! How a profile is read from a frame, by the names that the real camera has for it.

/// How the peak is placed between the rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
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

impl Method {
    /// Names in recipes and files, in the order of the variants.
    pub const NAMES: [&str; 5] = ["centre_of_gravity", "parabola", "gaussian", "blais_rioux", "fir"];

    /// Name in recipes and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::CentreOfGravity => Self::NAMES[0],
            Self::Parabola => Self::NAMES[1],
            Self::Gaussian => Self::NAMES[2],
            Self::BlaisRioux { .. } => Self::NAMES[3],
            Self::Fir { .. } => Self::NAMES[4],
        }
    }
}

/// Which peak of a column counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Peak {
    /// The greatest number; of several alike the first. GlobalMax of the camera.
    Strongest,
    /// The first number at or above the threshold after which numbers do not rise. FirstLocalMax of the camera.
    First,
}

impl Peak {
    /// Names in recipes and files, in the order of the variants.
    pub const NAMES: [&str; 2] = ["strongest", "first"];
}

/// In which direction rows are searched: it decides what "first" means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// From row 0 on.
    Standard,
    /// From the last row on.
    Reverse,
}

impl Direction {
    /// Names in recipes and files, in the order of the variants.
    pub const NAMES: [&str; 2] = ["standard", "reverse"];
}

/// Which side windows Scatter sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScatterMode {
    /// Both sides of the peak.
    Symmetric,
    /// Rows before the peak (smaller row numbers).
    Front,
    /// Rows after the peak.
    Back,
}

impl ScatterMode {
    /// Every mode in the order of [`Self::NAMES`].
    pub const ALL: [Self; 3] = [Self::Symmetric, Self::Front, Self::Back];
    /// Names in recipes and files.
    pub const NAMES: [&str; 3] = ["symmetric", "front", "back"];

    /// Name in recipes and files.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

/// What becomes of the dark level in Scatter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScatterDark {
    /// It stays in the sum, as the camera has it.
    Kept,
    /// It is taken out; what is left ends at 0.
    Subtracted,
}

impl ScatterDark {
    /// Names in recipes and files, in the order of the variants.
    pub const NAMES: [&str; 2] = ["kept", "subtracted"];
}

/// What Range is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RangeForm {
    /// Height at each sensor column [mm]. CalibratedAC of the camera.
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
    /// Names in recipes and files, in the order of the variants.
    pub const NAMES: [&str; 3] = ["calibrated", "uncalibrated", "rectified"];

    /// Name in recipes and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Calibrated => Self::NAMES[0],
            Self::Uncalibrated => Self::NAMES[1],
            Self::Rectified { .. } => Self::NAMES[2],
        }
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
    pub method: Method,
    /// Which peak of a column counts.
    pub peak: Peak,
    /// From where peaks are searched.
    pub direction: Direction,
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
