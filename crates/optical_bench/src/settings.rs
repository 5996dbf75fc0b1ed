//! What a recipe fixes for all samples: sizes, how lines are read, what is written. Nothing here is drawn.

mod extraction;
mod laser;
mod motion;
mod postprocess;
mod readout;

use base::words;

pub use extraction::{
    Extraction, PeakChoice, PeakMethod, PeakMethodName, RangeForm, RangeFormName, ScatterDark, ScatterMode,
    SearchDirection,
};
pub use laser::{Fan, LaserLine, LineShape, TextureImage};
pub use motion::{Movement, SpeckleLaw};
pub use postprocess::{Order, Postprocess, Script, SpecklePattern};
pub use readout::{Hdr, Readout};

/// Sizes of the scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Sensor columns, and columns of the unbinned images [px].
    pub columns: usize,
    /// Sensor rows [px].
    pub rows: usize,
    /// Profiles in a scan, and rows of the unbinned images.
    pub profiles: usize,
}

/// Which sensor frames are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorStack {
    /// None.
    None,
    /// Every k-th profile, from profile 0.
    Every(usize),
    /// All of them (`every: 1`).
    All,
}

words! {
    /// An image that can be written.
    #[derive(PartialOrd, Ord)]
    Channel {
        /// Height.
        Range = "range",
        /// Digital number at the peak.
        Reflectance = "reflectance",
        /// Light beside the peak.
        Scatter = "scatter",
        /// Light of lamps.
        Grey = "grey",
        /// Class of each pixel.
        Label = "label",
        /// Instance of each pixel.
        Instance = "instance",
    }
}

/// Name in `dataset.json` of what the whole numbers of Range leave of it.
const RANGE_REST: &str = "range_rest";

/// What is written.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Columns averaged into one.
    pub bin_columns: usize,
    /// Profiles averaged into one.
    pub bin_profiles: usize,
    /// Images in the Parquet rows, as PNG.
    pub png: Vec<Channel>,
    /// Images in the EXR files.
    pub exr: Vec<Channel>,
    /// Whether the EXR files hold what the whole numbers of Range in the tables leave of it.
    pub range_rest: bool,
    /// Whether the EXR files hold height, and what lies below the surface.
    pub truth_maps: bool,
    /// Sensor frames kept.
    pub sensor_stack: SensorStack,
    /// Samples in a shard; `None` keeps a shard under about 500 MB, and about a minute's work of two cores.
    pub samples_per_shard: Option<usize>,
    /// Bits of a digital number: 8, 10 or 12.
    pub bits: u32,
}

impl Output {
    /// Whether there are EXR files.
    pub fn has_exr(&self) -> bool {
        self.truth_maps || self.range_rest || !self.exr.is_empty()
    }

    /// What the EXR files hold beside truth, by the names of `dataset.json`.
    pub fn exr_names(&self) -> Vec<String> {
        let images = Channel::ALL.into_iter().filter(|image| self.exr.contains(image));
        images.map(Channel::name).chain(self.range_rest.then_some(RANGE_REST)).map(Into::into).collect()
    }

    /// Whether an image is written.
    pub fn has(&self, channel: Channel) -> bool {
        self.png.contains(&channel) || self.exr.contains(&channel)
    }

    /// Whether a pixel of the images is one that the extraction gave: neither a mean nor interpolated.
    fn has_pixels_of(&self, extraction: &Extraction) -> bool {
        self.bin_columns * self.bin_profiles == 1 && !matches!(extraction.range, RangeForm::Rectified { .. })
    }

    /// Whether Range is whole numbers: steps of rows, of a sensor of so many; heights are none.
    fn range_is_whole(&self, extraction: &Extraction, rows: usize) -> bool {
        let steps = extraction.subpixel_steps as usize * rows;
        extraction.range == RangeForm::Uncalibrated
            && self.has_pixels_of(extraction)
            && (1..=usize::from(u16::MAX)).contains(&steps)
    }

    /// Whether the tables hold an image to the last bit, and which of its pixels are measured.
    pub fn png_is_exact(&self, channel: Channel, extraction: &Extraction, rows: usize) -> bool {
        let has = |channel: Channel| self.png.contains(&channel);
        has(channel)
            && match channel {
                Channel::Range => self.range_is_whole(extraction, rows),
                Channel::Reflectance | Channel::Grey => self.has_pixels_of(extraction),
                // What is not measured is 0 in it, and so is what is dark.
                Channel::Scatter => {
                    self.has_pixels_of(extraction)
                        && extraction.scatter_dark == ScatterDark::Kept
                        && (has(Channel::Range) || has(Channel::Reflectance))
                }
                Channel::Label | Channel::Instance => true,
            }
    }

    /// Sensor frames kept of a scan.
    pub fn frames(&self, size: &Size) -> usize {
        match self.sensor_stack {
            SensorStack::None => 0,
            SensorStack::Every(step) => size.profiles.div_ceil(step.max(1)),
            SensorStack::All => size.profiles,
        }
    }
}

/// Shares of the splits [1]; they sum to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Splits {
    /// For training.
    pub train: f64,
    /// For choosing.
    pub validation: f64,
    /// For the last word.
    pub test: f64,
}

words! {
    /// What splits do not part.
    SplitBy {
        /// All that an instrument has scanned.
        Rig = "rig",
        /// The boards of a log.
        Log = "log",
        /// The objects of a batch.
        Batch = "batch",
    }
}

words! {
    /// Where the log of a board and its knots come from.
    LogSource {
        /// A pith line of the board's own, and knots that are placed on its face one by one.
        Placed = "placed",
        /// A whole stem with its whorls, out of which the board is sawn.
        Stem = "stem",
        /// A log that a scanner measured, out of which the board is sawn.
        Measured = "measured",
        /// No log: a picture of a board's face.
        Picture = "picture",
        /// No log: a stack of slices of a microscope or a tomograph.
        Slices = "slices",
    }
}

words! {
    /// How the numbers of a picture go with light.
    PictureEncoding {
        /// The curve of ordinary files.
        Srgb = "srgb",
        /// In proportion to light.
        Linear = "linear",
        /// A power of light.
        Gamma = "gamma",
    }
}

words! {
    /// Which end of the board the first row of a picture shows.
    FirstRow {
        /// The end that is scanned last: a photograph from above.
        Far = "far",
        /// The end that is scanned first: maps that this program writes.
        Near = "near",
    }
}

words! {
    /// How far below the face its colour goes.
    PictureDepth {
        /// Each feature as deep as it is wide.
        Feature = "feature",
        /// Everything to one depth.
        Even = "even",
    }
}

words! {
    /// Who says how the sensor is tilted and where the lens is sharp.
    Scheimpflug {
        /// The geometry: the laser plane is in focus.
        Solved = "solved",
        /// The recipe.
        Given = "given",
    }
}

words! {
    /// What the lens is taken for.
    LensModel {
        /// A thin lens, which blurs what is out of focus.
        ThinLens = "thin_lens",
        /// A hole: sharp everywhere.
        Pinhole = "pinhole",
    }
}

words! {
    /// What lies before the lens.
    Filter {
        /// Nothing that depends on colour.
        None = "none",
        /// A band-pass filter.
        BandPass = "band_pass",
    }
}

words! {
    /// Lamps of diffuse light beside the laser, which the map `grey` is taken under.
    Lamps {
        /// None: no map.
        None = "none",
        /// One.
        One = "one",
        /// Two.
        Two = "two",
    }
}

/// What of the camera is the same for all samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optics {
    /// Who says how the sensor stands.
    pub scheimpflug: Scheimpflug,
    /// What the lens is taken for.
    pub lens: LensModel,
    /// What lies before the lens.
    pub filter: Filter,
    /// Whether the lens's opening bends light.
    pub diffraction: bool,
    /// From the optical axis to the middle of the sensor's region along the columns [px].
    pub offset_columns: f64,
    /// From the optical axis to the middle of the sensor's region along the rows [px].
    pub offset_rows: f64,
    /// Lamps beside the laser.
    pub lamps: Lamps,
}

impl Default for Optics {
    /// As recipes have it that say nothing.
    fn default() -> Self {
        Self {
            scheimpflug: Scheimpflug::Solved,
            lens: LensModel::ThinLens,
            filter: Filter::None,
            diffraction: true,
            offset_columns: 0.0,
            offset_rows: 0.0,
            lamps: Lamps::None,
        }
    }
}

words! {
    /// How light spreads below the surface, by name; what datasets are made with first.
    TransportName {
        /// [`Transport::Kernel`].
        Kernel = "kernel",
        /// [`Transport::Path`].
        Path = "path",
        /// [`Transport::Diffusion`].
        Diffusion = "diffusion",
        /// [`Transport::Thesis`].
        Thesis = "thesis",
    }
}

/// How light spreads below the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transport {
    /// Gaussians over path length from a table: what datasets are made with.
    Kernel,
    /// Monte Carlo of the transport equation, the reference.
    Path {
        /// Photons of each profile.
        photons: u64,
    },
    /// Steady anisotropic diffusion on voxels around each line.
    Diffusion {
        /// Side of a voxel [mm].
        voxel_mm: f64,
    },
    /// The 2-D method of the thesis.
    Thesis {
        /// How light is spread over pixels.
        method: ThesisMethod,
        /// Iterations of `diffusion`, steps from path to path of `conservative`; 0 for methods that have none.
        iterations: usize,
        /// Side of its pixels [mm].
        pixel_mm: f64,
    },
}

impl Transport {
    /// Name in recipes and files.
    pub fn name(self) -> &'static str {
        let name = match self {
            Self::Kernel => TransportName::Kernel,
            Self::Path { .. } => TransportName::Path,
            Self::Diffusion { .. } => TransportName::Diffusion,
            Self::Thesis { .. } => TransportName::Thesis,
        };
        name.name()
    }
}

words! {
    /// How the thesis' method spreads light over pixels.
    ThesisMethod {
        /// Eight neighbours, iterated.
        Diffusion = "diffusion",
        /// The same with a stencil that keeps energy.
        Conservative = "conservative",
        /// Along lines by their equation.
        LinearEquation = "linear_equation",
        /// Along anti-aliased lines.
        AntiAliased = "anti_aliased",
        /// Along Bresenham's lines.
        Bresenham = "bresenham",
    }
}

impl ThesisMethod {
    /// Whether it goes on step by step, so that a number of iterations means something.
    pub fn iterates(self) -> bool {
        matches!(self, Self::Diffusion | Self::Conservative)
    }
}
