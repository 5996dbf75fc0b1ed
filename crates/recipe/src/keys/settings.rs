//! Settings: every key that is the same for all samples, each declared once, and the structs that the bench takes.
//!
//! A row says key, type, default, meaning, source and what the setting needs to have an effect. Reading, JSON Schema,
//! reference and canonical form follow from it, and so does the struct of its section.

use serde_json::Value as Json;

use super::idle::{Idle, Wording};
use super::setting_type::{
    Absence, Auto, Channels, Count, File, Flag, FolderOrFile, GroupSize, NamedFile, Number, OneOf, SettingType,
    StackChoice, Word,
};
use super::texture;
use crate::asset::Asset;
use crate::asset_source::AssetSource;
use crate::built_in::{GRAN_1, MESHES, PICTURES, STACKS};
use optical_bench::settings::{
    Channel, Extraction, Fan, FibreAxis, Filter, FirstRow, Hdr, LaserLine, LensModel, LineShape, LogSource, Movement,
    Optics, Order, Output, PeakChoice, PeakMethod, PeakMethodName, PictureDepth, PictureEncoding, PictureFace,
    Postprocess, RangeForm, RangeFormName, Readout, ScatterDark, ScatterMode, Scheimpflug, Script, SearchDirection,
    SensorStack, Size, SpeckleLaw, SpecklePattern, Splits, ThesisMethod, Transport, TransportName, Words,
};
use yaml::{YamlNode, YamlReader};

/// Least sensor columns, which leave something to bin [px].
const MIN_COLUMNS: usize = 8;
/// Most sensor columns [px].
const MAX_COLUMNS: usize = 16384;
/// Most profiles: what the buffers of the real camera hold.
const MAX_PROFILES: usize = 16383;
/// Most boards of one log.
const MAX_BOARDS_PER_LOG: usize = 1000;
/// Farthest from the optical axis that the middle of the sensor's region stands [px].
const MAX_OFFSET_PX: f64 = 8192.0;

/// The declaration of one setting.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setting {
    /// Key in its section.
    pub name: &'static str,
    /// Path from the top of the recipe.
    pub path: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// Where the default and the range come from.
    pub source: &'static str,
    /// What it may be and what it is where the recipe says nothing.
    pub describe: fn() -> Description,
    /// What it needs to have an effect.
    pub needs: &'static [Needs],
    /// Reads a value at a path into the settings; `None` where it is at fault.
    pub read: fn(&mut Settings, &mut YamlReader, &YamlNode, &str) -> Option<()>,
    /// Reads what of its value lies in another file.
    pub load: fn(&mut Settings, &mut YamlReader, &AssetSource),
    /// The value in the canonical form; `None` where it is left out.
    pub canonical: fn(&Settings) -> Option<Json>,
    /// The file that it names.
    pub asset: fn(&Settings) -> Option<&Asset>,
}

/// What a setting may be, and its default.
pub(crate) struct Description {
    /// What is allowed, in words.
    pub allowed: String,
    /// Unit and range, where the reference has columns of their own for them.
    pub unit_and_range: Option<(&'static str, String)>,
    /// What is allowed, as JSON Schema.
    pub schema: Json,
    /// The default.
    pub default: Json,
}

/// Another setting of the section, and the words of it beside which a setting has an effect.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Needs {
    /// Path of the other setting, which stands before the one that needs it.
    pub path: &'static str,
    /// How a fault says it.
    wording: Wording,
    /// Its words.
    words: fn() -> Vec<&'static str>,
    /// The word that is chosen.
    chosen: fn(&Settings) -> &'static str,
}

impl Setting {
    /// Why the setting has no effect; `None` where it has one.
    pub fn idle(&self, settings: &Settings) -> Option<Idle> {
        self.needs.iter().find_map(|needs| {
            let Needs { path, wording, .. } = *needs;
            let (chosen, words) = ((needs.chosen)(settings), (needs.words)());
            (!words.contains(&chosen)).then(|| Idle { path, chosen: chosen.to_owned(), words, wording })
        })
    }
}

/// Declares sections of settings: for each a struct with a field for each key, filled with the defaults, and the table
/// `SETTINGS` of its declarations; and [`Settings`], which has them all.
macro_rules! settings {
    ($($section:ident: $Section:ident at $path:literal {
        $($name:ident: $Type:ident $(<$Of:ident>)? ($($argument:expr),*) = $default:expr, $doc:literal, $source:literal
            $(, $wording:ident $key:ident in $words:expr)*;)+
    })+) => {
        /// Every setting, as a recipe says it or by default.
        #[derive(Debug, Clone, PartialEq, Default)]
        pub(in crate) struct Settings {
            $(#[doc = concat!("Section `", $path, "`.")] pub $section: $Section,)+
        }

        $(
            #[doc = concat!("Settings of the section `", $path, "`.")]
            #[derive(Debug, Clone, PartialEq)]
            pub(in crate) struct $Section {
                $(#[doc = $doc] pub $name: <$Type $(<$Of>)? as SettingType>::Value,)+
            }

            impl Default for $Section {
                fn default() -> Self {
                    Self { $($name: $default,)+ }
                }
            }

            impl $Section {
                /// The declarations, in the order of the fields.
                pub const SETTINGS: &[Setting] = &[$(Setting {
                    name: stringify!($name),
                    path: concat!($path, ".", stringify!($name)),
                    doc: $doc,
                    source: $source,
                    describe: || {
                        let kind = $Type $(::<$Of>)? ($($argument),*);
                        Description {
                            allowed: kind.allowed(),
                            unit_and_range: kind.unit_and_range(),
                            schema: kind.schema(),
                            default: kind.json(&Self::default().$name),
                        }
                    },
                    needs: &[$(Needs {
                        path: concat!($path, ".", stringify!($key)),
                        wording: Wording::$wording,
                        words: || ($words).into_iter().map(Words::name).collect(),
                        chosen: |settings| settings.$section.$key.name(),
                    },)*],
                    read: |settings, yaml, node, path| {
                        settings.$section.$name = ($Type $(::<$Of>)? ($($argument),*)).read(yaml, node, path)?;
                        Some(())
                    },
                    load: |settings, yaml, files| {
                        let path = concat!($path, ".", stringify!($name));
                        ($Type $(::<$Of>)? ($($argument),*)).load(&mut settings.$section.$name, yaml, path, files);
                    },
                    canonical: |settings| ($Type $(::<$Of>)? ($($argument),*)).canonical(&settings.$section.$name),
                    asset: |settings| ($Type $(::<$Of>)? ($($argument),*)).asset(&settings.$section.$name),
                },)+];
            }
        )+
    };
}

settings! {
    scan: ScanSettings at "scan" {
        columns: Count(MIN_COLUMNS, MAX_COLUMNS, "px") = 2560,
            "Sensor columns, and columns of the unbinned images.",
            "[T]";
        profiles: Count(1, MAX_PROFILES, "") = 4000,
            "Profiles in a scan, and rows of the unbinned images.",
            "[T]; the buffers of the real camera hold 16383";
    }

    motion: MotionSettings at "motion" {
        kind: Word<Movement>(&Movement::ALL) = Movement::Linear,
            "How the object moves: `linear`, straight on; or `turntable`, about an upright axis in the laser \
             plane. Profiles are then `step_mm` apart at `turn_radius_mm` from it.",
            "[T]";
    }

    laser: LaserSettings at "laser" {
        fan: Word<Fan>(&Fan::ALL) = Fan::Powell,
            "Lens that makes the line: `powell` lights a plane evenly, `cylindrical` leaves a hot spot in the \
             middle.",
            "[V]";
        profile: Word<LineShape>(&LineShape::ALL) = LineShape::Gaussian,
            "Light across the line: a `gaussian` beam; a `slit`, even with hard edges, as wide as its shadow is; \
             a `texture` thrown by a projector; or a `point`, a round spot stepped along the line.",
            "[T] slit and texture; [V]";
        texture: File(64, &[], Absence::Allowed) = NamedFile::NONE,
            "Grey PNG that a projector throws, 8 or 16 bits, proportional to light; rows across the line, columns \
             along it. `none` is the line of the thesis: three pixels wide of 61, blurred by a Gaussian of five.",
            "[T] 3.2.1";
    }

    camera: CameraSettings at "camera" {
        rows: Count(64, 4096, "px") = 832,
            "Sensor rows; the same for all samples, so a class cannot change it.",
            "[T]";
        scheimpflug: Word<Scheimpflug>(&Scheimpflug::ALL) = Scheimpflug::Solved,
            "Who tilts and focuses the sensor: the geometry, which puts the laser plane in focus, or \
             `sensor_tilt_deg` and `focus_distance_mm`.",
            "the real bench; [T] had none in the simulation";
        lens: Word<LensModel>(&LensModel::ALL) = LensModel::ThinLens,
            "A thin lens, which blurs what is out of focus, or a pinhole, which is sharp everywhere.",
            "free";
        diffraction: Flag() = true,
            "Whether the opening of the lens bends light: the core of Airy's disc beside `blur_um`.",
            "nature";
        filter: Word<Filter>(&Filter::ALL) = Filter::None,
            "Filter before the lens: none, or a band about `filter_centre_nm`.",
            "free; [T] band_pass";
        offset_columns: Number(-MAX_OFFSET_PX, MAX_OFFSET_PX, "px") = 0.0,
            "From the optical axis to the middle of the sensor's region, along the columns.",
            "region of interest";
        offset_rows: Number(-MAX_OFFSET_PX, MAX_OFFSET_PX, "px") = 0.0,
            "From the optical axis to the middle of the sensor's region, along the rows.",
            "region of interest";
    }

    exposure: ExposureSettings at "exposure" {
        bits: OneOf(&[8, 10, 12]) = 8,
            "Bits of a digital number. Keys in DN stay on the scale of 8 bits; images, frames and Scatter get \
             finer steps.",
            "[T] 8";
        hdr: Word<Hdr>(&Hdr::ALL) = Hdr::None,
            "A second, flatter slope for bright light: 2, 6 or 15 times the dynamic range.",
            "modes of the real camera";
    }

    speckle: SpeckleSettings at "speckle" {
        law: Word<SpeckleLaw>(&SpeckleLaw::ALL) = SpeckleLaw::Exponential,
            "Law of the light in a point: `exponential` as physics has it, `rayleigh` the square root of that, \
             whose contrast is 0.523.",
            "Goodman; [T] for `rayleigh`";
    }

    log: LogSettings at "log" {
        source: Word<LogSource>(&LogSource::ALL) = LogSource::Placed,
            "Where the log and its knots come from: `placed`, with as many knots on the face as `knots` says; `stem`, \
                a whole \
             stem with whorls, out of which the board is sawn where `stem` says; `measured`, a log from files, sawn \
             likewise; `picture`, a picture of a board's face; or `slices`, a stack of slices of a microscope or a \
             tomograph.",
            "docs/theory/wood.md";
        boards_per_log: GroupSize(MAX_BOARDS_PER_LOG) = 1,
            "Samples in a row that are boards of one log, which lie in it by a sawing pattern from where `stem` says, \
                and \
             have class, split, size and all that belongs to the log in common.",
            "docs/theory/wood.md",
            On source in [LogSource::Stem, LogSource::Measured];
        pith_file: File(16, &GRAN_1[0], Absence::Refused) = NamedFile::new(GRAN_1[0][0].0),
            "For `measured`: pith, rows of x, y and height [mm], heights rising; CSV or JSON (an array of rows).",
            "Larsson et al. 2022, MIT",
            On source in [LogSource::Measured];
        radii_file: File(16, &GRAN_1[1], Absence::Refused) = NamedFile::new(GRAN_1[1][0].0),
            "For `measured`: outline, a row of distances from the pith [mm] for each section, in equal steps along \
                it, at \
             azimuths that fall from 0 in equal steps of a turn.",
            "Larsson et al. 2022, MIT",
            On source in [LogSource::Measured];
        knots_file: File(16, &GRAN_1[2], Absence::Refused) = NamedFile::new(GRAN_1[2][0].0),
            "For `measured`: branches, rows of A to I [mm, rad], see docs/theory/wood.md.",
            "Larsson et al. 2022, MIT",
            On source in [LogSource::Measured];
    }

    picture: PictureSettings at "picture" {
        file: File(256, &PICTURES, Absence::Allowed) = NamedFile::NONE,
            "PNG, JPEG, TIFF or BMP of a board's face, the board's length down the rows; of a colour picture the red \
             channel counts, which is nearest to the laser. A dark belt around the board is cut \
             off. `none` beside `fibres`: every pixel has the light of clear wood, or in the thesis' colours what \
             alpha leaves of it.",
            "docs/guide/pictures.md";
        pixel_mm: Number(0.01, 0.4, "mm") = 0.1,
            "Size of a pixel down the rows.",
            "free; 0.1 to 0.2 is best";
        pixel_across_mm: Auto<Number>(Number(0.01, 0.4, "mm")) = None,
            "Size of a pixel along the rows; `auto` is the same as down them.",
            "free";
        encoding: Word<PictureEncoding>(&PictureEncoding::ALL) = PictureEncoding::Srgb,
            "How numbers go with light: `srgb` for ordinary files, `linear` for raw files and maps of scans, \
             `gamma` for another power.",
            "IEC 61966-2-1";
        gamma: Number(0.3, 4.0, "") = 2.2,
            "For `gamma`: light is the number to this power.",
            "free",
            Beside encoding in [PictureEncoding::Gamma];
        dark: Number(0.0, 0.9, "") = 0.0,
            "Number at no light, as a share of the end of the scale: the dark level of a scan.",
            "free";
        first_row: Word<FirstRow>(&FirstRow::ALL) = FirstRow::Far,
            "Which end of the board the first row shows: `far` on a photograph from above, `near` on maps that this \
             program writes.",
            "free";
        face: Word<PictureFace>(&PictureFace::ALL) = PictureFace::Bark,
            "Which side it shows: the pith lies below the `bark` side, 70 mm deep, and as far above the `pith` side. \
             Says whether fibres rise or sink towards knots.",
            "docs/guide/pictures.md";
        least_knot_mm: Number(1.0, 80.0, "mm") = 4.0,
            "Least width of a knot that is looked for.",
            "docs/guide/pictures.md";
        depth: Word<PictureDepth>(&PictureDepth::ALL) = PictureDepth::Feature,
            "How far below the face its colour goes: a `feature` as deep as it is wide, or all `even` to one depth \
             and clear wood's mean below it. In knots colour follows the branch.",
            "free: a picture does not say it";
        depth_mm: Number(0.05, 200.0, "mm") = 3.0,
            "For `even`: that depth.",
            "free",
            Beside depth in [PictureDepth::Even];
        fibres: File(256, &[], Absence::Allowed) = NamedFile::NONE,
            "Directions of the fibres, as large as the picture, in the place of those that are found in it: a PNG in \
             the thesis' colours, red over green the slope of rising lines, blue over green that of falling ones, or \
             an EXR with FibreCos2, FibreSin2 and FibreDive as `gen fibres` writes it.",
            "[T] 3.2.3";
        labels: File(64, &[], Absence::Allowed) = NamedFile::NONE,
            "Grey PNG of 8 bits, as large as the picture, of the numbers of pixel classes, in the place of knots that \
             are found as labels; 0 counts as clear wood.",
            "free";
    }

    slices: SlicesSettings at "slices" {
        stack: FolderOrFile(File(256, &STACKS, Absence::Allowed)) = NamedFile::NONE,
            "Folder of grey PNGs with 8 or 16 bits, one for each slice, in the order of their names (numbers in them \
                by \
             value); or a tar of them, which is what datasets keep.",
            "docs/guide/pictures.md";
        pixel_mm: Number(0.0001, 2.0, "mm") = 0.1,
            "Size of a pixel down the rows of a slice. Voxels below 0.05 mm are put together.",
            "free";
        pixel_across_mm: Auto<Number>(Number(0.0001, 2.0, "mm")) = None,
            "Size of a pixel along the rows; `auto` is the same as down them.",
            "free";
        slice_mm: Auto<Number>(Number(0.0001, 20.0, "mm")) = None,
            "Distance from slice to slice; `auto` is the size of a pixel down the rows.",
            "free";
        fibres: Word<FibreAxis>(&FibreAxis::ALL) = FibreAxis::Through,
            "Which way the fibres run in the stack: `through`, from slice to slice, so that slices are cross-sections; \
             `down` the rows of each slice, the last row at the near end; or `across`, along the rows. The first row \
             lies up, or the first slice where fibres run in the slices.",
            "free";
        black_kg_per_m3: Number(-20_000.0, 20_000.0, "kg/m^3") = 0.0,
            "Density at grey 0, by the calibration of the tomograph.",
            "free";
        white_kg_per_m3: Number(-100_000.0, 100_000.0, "kg/m^3") = 1500.0,
            "Density at the end of the scale of 8 or 16 bits; below that of black where dense wood is dark.",
            "free; 1500 is the cell wall";
        earlywood_kg_per_m3: Number(60.0, 1500.0, "kg/m^3") = 320.0,
            "Density of the earlywood whose coefficients `media` gives.",
            "docs/theory/wood.md";
        latewood_kg_per_m3: Number(60.0, 1500.0, "kg/m^3") = 800.0,
            "Density of the latewood whose coefficients `media` gives.",
            "docs/theory/wood.md";
    }

    mesh: MeshSettings at "mesh" {
        file: File(64, &MESHES, Absence::Refused) = NamedFile::new(MESHES[0].0),
            "Triangles of the part: OBJ, STL or PLY, by the name's ending.",
            "free";
    }

    transport: TransportSettings at "transport" {
        model: Word<TransportName>(&TransportName::ALL) = TransportName::Kernel,
            "Who says where light leaves: a table of Gaussians, Monte Carlo (the reference), diffusion on voxels or \
             the thesis' picture.",
            "docs/theory/physics.md";
        photons_per_profile: Count(1000, 10_000_000_000, "") = 1_000_000,
            "For `path`: photons that are walked in each profile.",
            "free; noise falls with their square root",
            On model in [TransportName::Path];
        voxel_mm: Number(0.05, 0.5, "mm") = 0.1,
            "For `diffusion`: edge of a voxel; memory grows with its inverse cube.",
            "free; 0.1 is a row of the default camera",
            On model in [TransportName::Diffusion];
        method: Word<ThesisMethod>(&ThesisMethod::ALL) = ThesisMethod::Diffusion,
            "For `thesis`: how light is spread over pixels; `conservative` is what its diffusion should be.",
            "[T]; `conservative` is ours",
            On model in [TransportName::Thesis];
        iterations: Count(1, 1000, "") = 20,
            "For `thesis` by `diffusion`: iterations; by `conservative`: steps from each path length to the next.",
            "[T] 20 on clear wood, 10 on a knot",
            On model in [TransportName::Thesis],
            On method in ThesisMethod::ALL.into_iter().filter(|method| method.iterates());
        pixel_mm: Number(0.02, 0.5, "mm") = 0.1,
            "For `thesis`: side of a pixel.",
            "free; 0.1 is a row of the default camera",
            On model in [TransportName::Thesis];
    }

    postprocess: PostprocessSettings at "postprocess" {
        order: Word<Order>(&Order::ALL) = Order::Physical,
            "The scripts, first one first.",
            "[T] section 3.3; `physical` is ours";
        blur_radius_px: Number(0.05, 20.0, "px") = 0.5,
            "Standard deviation of the Gaussian blur.",
            "[T] 0.5, wood 1; the thesis says radius",
            On order in Order::with(Script::Blur);
        intensity_scale: Number(0.01, 100.0, "") = 3.5,
            "Mean of the pattern of speckle that light is multiplied by.",
            "[T] saw-tooth 3.5, wood 6, pack 7",
            On order in Order::with(Script::Speckle);
        pattern_px: Count(64, 4096, "px") = 1000,
            "Side of the pattern.",
            "[T]",
            On order in Order::with(Script::Speckle);
        mask_px: Count(8, 2048, "px") = 500,
            "Diameter of the disc of random phases, at most half of the side: a speckle is side / diameter wide.",
            "[T]",
            On order in Order::with(Script::Speckle);
        sampling_factor: Count(1, 32, "") = 5,
            "Pattern pixels along a sensor pixel; 6 makes the speckles of the default bench as large as they are.",
            "[T] 5",
            On order in Order::with(Script::Speckle);
    }

    extraction: ExtractionSettings at "extraction" {
        method: Word<PeakMethodName>(&PeakMethodName::ALL) = PeakMethodName::CentreOfGravity,
            "How the peak is placed between the rows.",
            "[T] centre of gravity";
        blais_rioux_order: OneOf(&[2, 4, 8]) = 4,
            "For `blais_rioux`: rows of the derivative, half of them on each side.",
            "Blais and Rioux 1986",
            Beside method in [PeakMethodName::BlaisRioux];
        fir_length: OneOf(&[3, 5, 7, 9]) = 5,
            "For `fir`: taps of the binomial smoothing before the derivative.",
            "free",
            Beside method in [PeakMethodName::Fir];
        window_rows: OneOf(&[3, 7, 15]) = 7,
            "Rows on each side of the peak that the position is made from; `parabola` and `gaussian` have one.",
            "window around the maximum of the real camera",
            Beside method in [PeakMethodName::CentreOfGravity, PeakMethodName::BlaisRioux, PeakMethodName::Fir];
        peak: Word<PeakChoice>(&PeakChoice::ALL) = PeakChoice::Strongest,
            "Which peak of a column counts: the `strongest`, or the `first` that reaches the threshold.",
            "GlobalMax and FirstLocalMax of the real camera";
        direction: Word<SearchDirection>(&SearchDirection::ALL) = SearchDirection::Standard,
            "From where peaks are searched: `standard` from row 0, `reverse` from the last; a plateau counts from \
             its first row.",
            "search direction of the real camera";
        threshold_dn: Number(0.0, 255.0, "DN") = 17.0,
            "Smallest digital number of a peak, on the scale of 8 bits.",
            "dark level plus five standard deviations";
        subpixel_steps: Count(0, 256, "") = 16,
            "Steps per row in which the peak position is given; 0 leaves it unrounded.",
            "1/16 px of the real camera";
        scatter_mode: Word<ScatterMode>(&ScatterMode::ALL) = ScatterMode::Symmetric,
            "Which side windows Scatter sums: both, `front` (smaller row numbers) or `back`.",
            "modes of the real camera";
        scatter_offset_rows: Count(0, 15, "px") = 1,
            "Distance from the peak to the first summed row; 0 includes the peak.",
            "[T] wood";
        scatter_width_rows: Count(1, 16, "px") = 8,
            "Rows that are summed on each side; offset and width together at most 16, at most 29 rows in all.",
            "[T] wood";
        scatter_dark: Word<ScatterDark>(&ScatterDark::ALL) = ScatterDark::Kept,
            "Whether the dark level stays in Scatter or is taken out, ending at 0.",
            "the real camera sums plain numbers";
        range: Word<RangeFormName>(&RangeFormName::ALL) = RangeFormName::Calibrated,
            "What Range is: height at each sensor column [mm], sensor row [px], or height on an even grid of x \
             [mm].",
            "CalibratedAC, UncalibratedC and RectifiedC of the real camera";
        rectified_pitch_mm: Auto<Number>(Number(0.001, 10.0, "mm")) = None,
            "For `range: rectified`: distance of the grid's columns; `auto` is that of the sensor's columns at z \
             = 0.",
            "free",
            Beside range in [RangeFormName::Rectified];
    }

    splits: SplitSettings at "splits" {
        train: Number(0.0, 1.0, "") = 0.8,
            "Share for training.",
            "usual";
        validation: Number(0.0, 1.0, "") = 0.1,
            "Share for choosing.",
            "usual";
        test: Number(0.0, 1.0, "") = 0.1,
            "Share for the last word.",
            "usual";
    }

    output: OutputSettings at "output" {
        png: Channels() = [Channel::Range, Channel::Reflectance, Channel::Scatter, Channel::Label].to_vec(),
            "Images in the Parquet rows, as PNG.",
            "free";
        exr: Channels() = Channel::ALL.to_vec(),
            "Images in the EXR files; `[]` for no EXR files.",
            "free";
        truth_maps: Flag() = true,
            "Whether the EXR files hold noise-free maps too: height, and fibre azimuth and dive, or film \
             thickness and gap.",
            "free";
        sensor_stack: StackChoice(MAX_PROFILES) = SensorStack::None,
            "Which sensor frames are kept: none, all, or every k-th from the first.",
            "free";
        samples_per_shard: Auto<Count>(Count(1, 100_000, "")) = None,
            "Samples in a shard; `auto` keeps a shard under about 500 MB, and about a minute's work of two cores.",
            "free";
    }

    bin: BinSettings at "output.bin" {
        columns: Count(1, MAX_COLUMNS, "px") = 1,
            "Columns averaged into one, of measured pixels on one surface; divides `scan.columns`.",
            "free";
        profiles: Count(1, MAX_PROFILES, "") = 1,
            "Profiles averaged into one, of measured pixels on one surface; divides `scan.profiles`.",
            "free";
    }
}

impl Settings {
    /// Sizes of the scan.
    pub fn size(&self) -> Size {
        Size { columns: self.scan.columns, rows: self.camera.rows, profiles: self.scan.profiles }
    }

    /// How the sensor is read out.
    pub fn readout(&self) -> Readout {
        // The table ends bits at 12.
        Readout { bits: self.exposure.bits as u32, hdr: self.exposure.hdr }
    }

    /// What is done to frames before they are read; numbers that have no effect are 0.
    pub fn postprocess(&self) -> Postprocess {
        let PostprocessSettings { order, blur_radius_px, intensity_scale, pattern_px, mask_px, sampling_factor } =
            self.postprocess;
        let has = |step| order.steps().contains(&step);
        let number = |step, number| if has(step) { number } else { 0.0 };
        let count = |count| if has(Script::Speckle) { count } else { 0 };
        Postprocess {
            order,
            blur_radius_px: number(Script::Blur, blur_radius_px),
            intensity_scale: number(Script::Speckle, intensity_scale),
            pattern: SpecklePattern {
                size_px: count(pattern_px),
                mask_px: count(mask_px),
                factor: count(sampling_factor),
                law: self.speckle.law,
            },
        }
    }

    /// What of the laser is not drawn.
    pub fn line(&self) -> LaserLine {
        let LaserSettings { fan, profile, texture } = &self.laser;
        // A file that is no picture is a fault of the recipe.
        let picture = texture.asset().and_then(|file| texture::read(file.bytes()).ok());
        LaserLine { fan: *fan, shape: *profile, picture }
    }

    /// What of the camera is the same for all samples.
    pub fn optics(&self) -> Optics {
        let CameraSettings { rows: _, scheimpflug, lens, diffraction, filter, offset_columns, offset_rows } =
            self.camera;
        Optics { scheimpflug, lens, filter, diffraction, offset_columns, offset_rows }
    }

    /// How a profile is read.
    pub fn extraction(&self) -> Extraction {
        let own = &self.extraction;
        let method = match own.method {
            PeakMethodName::CentreOfGravity => PeakMethod::CentreOfGravity,
            PeakMethodName::Parabola => PeakMethod::Parabola,
            PeakMethodName::Gaussian => PeakMethod::Gaussian,
            PeakMethodName::BlaisRioux => PeakMethod::BlaisRioux { order: own.blais_rioux_order },
            PeakMethodName::Fir => PeakMethod::Fir { length: own.fir_length },
        };
        Extraction {
            method,
            peak: own.peak,
            direction: own.direction,
            window_rows: match own.method {
                PeakMethodName::Parabola | PeakMethodName::Gaussian => 1,
                PeakMethodName::CentreOfGravity | PeakMethodName::BlaisRioux | PeakMethodName::Fir => own.window_rows,
            },
            threshold_dn: own.threshold_dn * self.readout().scale(),
            // The table ends it at 256.
            subpixel_steps: own.subpixel_steps as u32,
            scatter_mode: own.scatter_mode,
            scatter_offset_rows: own.scatter_offset_rows,
            scatter_width_rows: own.scatter_width_rows,
            scatter_dark: own.scatter_dark,
            range: match own.range {
                RangeFormName::Calibrated => RangeForm::Calibrated,
                RangeFormName::Uncalibrated => RangeForm::Uncalibrated,
                RangeFormName::Rectified => RangeForm::Rectified { pitch_mm: own.rectified_pitch_mm },
            },
        }
    }

    /// How light spreads below the surface.
    pub fn transport(&self) -> Transport {
        let TransportSettings { model, photons_per_profile, voxel_mm, method, iterations, pixel_mm } = self.transport;
        match model {
            TransportName::Kernel => Transport::Kernel,
            TransportName::Path => Transport::Path { photons: photons_per_profile as u64 },
            TransportName::Diffusion => Transport::Diffusion { voxel_mm },
            TransportName::Thesis => {
                let iterations = if method.iterates() { iterations } else { 0 };
                Transport::Thesis { method, iterations, pixel_mm }
            }
        }
    }

    /// What is written.
    pub fn output(&self) -> Output {
        let OutputSettings { png, exr, truth_maps, sensor_stack, samples_per_shard } = self.output.clone();
        Output {
            bin_columns: self.bin.columns,
            bin_profiles: self.bin.profiles,
            png,
            exr,
            truth_maps,
            sensor_stack,
            samples_per_shard,
            bits: self.readout().bits,
        }
    }

    /// Shares of the splits.
    pub fn splits(&self) -> Splits {
        let SplitSettings { train, validation, test } = self.splits;
        Splits { train, validation, test }
    }
}
