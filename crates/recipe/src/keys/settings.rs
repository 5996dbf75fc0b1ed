//! Settings: every key that is the same for all samples, each declared once, and the structs that the bench takes.
//!
//! A row says meaning, key, type, default, source and what the setting needs to mean something. Reading, refusal, JSON
//! Schema, reference and canonical form follow from it, and so does the struct of its section.

use base::Words;
use serde_json::Value as Json;

use super::idle::{Idle, Wording};
use super::setting_type::{
    Auto, Count, File, FileForm, Flag, GroupSize, ImageChoice, ImageList, NamedFile, Number, OneOf, SettingType,
    StackChoice, Word, WordList,
};
use crate::asset::{Asset, BuiltIn};
use crate::asset_source::AssetSource;
use crate::built_in::{GRAN_1, MESHES, PICTURES, STACKS};
use optical_bench::settings::{
    Channel, Extraction, Fan, Filter, FirstRow, Hdr, Lamps, LaserLine, LensModel, LineShape, LogSource, Movement,
    Optics, Order, Output, PeakChoice, PeakMethod, PeakMethodName, PictureDepth, PictureEncoding, Postprocess,
    RangeForm, RangeFormName, Readout, ScatterDark, ScatterMode, Scheimpflug, Script, SearchDirection, SensorStack,
    Size, SpeckleLaw, SpecklePattern, SplitBy, Splits, TextureImage, ThesisMethod, Transport, TransportName,
};
use wood_picture::{Face, FibreAxis};
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
/// What splits do not part unless a recipe says otherwise.
const UNPARTED: [SplitBy; 2] = [SplitBy::Log, SplitBy::Batch];

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
    /// What it needs to mean something, and what its whole section does.
    needs: [&'static [SettingNeed]; 2],
    /// Reads a value at a path into the settings; `None` where it is at fault.
    pub read: fn(&mut Settings, &mut YamlReader, &YamlNode, &str) -> Option<()>,
    /// Reads what of its value lies in another file.
    pub load: fn(&mut Settings, &mut YamlReader, &AssetSource),
    /// The value in the canonical form; `None` where it is left out.
    pub canonical: fn(&Settings) -> Option<Json>,
    /// The file that it names.
    pub asset: fn(&Settings) -> Option<&Asset>,
    /// Files of the program that it may name; `None` where it names none.
    pub built_in: fn() -> Option<&'static [BuiltIn]>,
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

/// Another setting, and the words of it beside which a setting means something.
#[derive(Debug, Clone, Copy)]
struct SettingNeed {
    /// Path of the other setting.
    path: &'static str,
    /// What becomes of a setting that does not have it.
    unmet: UnmetSetting,
    /// How a fault says it.
    wording: Wording,
    /// Why a value, which the fault names then, has no effect.
    because: Option<&'static str>,
    /// What to do instead of what follows from the words.
    remedy: Option<&'static str>,
    /// Its words.
    words: fn() -> Vec<&'static str>,
    /// The word that is chosen.
    chosen: fn(&Settings) -> &'static str,
}

/// What becomes of a setting whose need is not met.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum UnmetSetting {
    /// It does not exist: written at all it is a fault, and the canonical form has none (`only`). The other setting
    /// stands before it in its section.
    Absent,
    /// Any other value than its default is a fault (`needs`).
    Refused,
    /// Written at all it is a fault, and the canonical form has its default (`unwritten_without`).
    Unwritten,
}

impl Setting {
    /// Why the setting does not exist; `None` where it does.
    pub fn idle(&self, settings: &Settings) -> Option<Idle> {
        self.unmet(settings).find(|(need, _)| need.unmet == UnmetSetting::Absent).map(|(_, idle)| idle)
    }

    /// Why the setting has no effect, whatever its value; `None` where it has one.
    pub fn without_effect(&self, settings: &Settings) -> Option<String> {
        self.unmet(settings).next().map(|(_, idle)| idle.refusal().0)
    }

    /// What is wrong with the value of a setting that exists and has no effect, and what to do.
    pub fn refusal(&self, settings: &Settings, yaml: &YamlReader) -> Option<(String, String)> {
        let value = (self.canonical)(settings);
        let (need, idle) = self.unmet(settings).find(|(need, _)| match need.unmet {
            UnmetSetting::Absent => false,
            UnmetSetting::Refused => value != (self.canonical)(&Settings::default()),
            UnmetSetting::Unwritten => yaml.has(self.path),
        })?;
        let (problem, remedy) = idle.refusal();
        let named = need.because.zip(value.as_ref().and_then(Json::as_str));
        Some((named.map_or(problem.clone(), |(reason, value)| format!("`{value}` {problem}: {reason}")), remedy))
    }

    /// Whether it needs the setting at `path` to exist.
    pub fn exists_by(&self, path: &str) -> bool {
        self.needs().any(|need| need.unmet == UnmetSetting::Absent && need.path == path)
    }

    fn needs(&self) -> impl Iterator<Item = &'static SettingNeed> {
        self.needs.into_iter().flatten()
    }

    /// Needs that are not met, and what is said of them.
    fn unmet(&self, settings: &Settings) -> impl Iterator<Item = (&'static SettingNeed, Idle)> {
        self.needs().filter_map(move |need| {
            let SettingNeed { path, wording, remedy, .. } = *need;
            let (chosen, words) = ((need.chosen)(settings), (need.words)());
            let idle = |words| Idle { path, chosen: chosen.to_owned(), words, wording, remedy };
            (!words.contains(&chosen)).then(|| (need, idle(words)))
        })
    }
}

/// Declares sections of settings: for each a struct with a field for each key, filled with the defaults, and the table
/// `SETTINGS` of its declarations; and [`Settings`], which has them all.
///
/// Marks follow the source, or stand behind `all` for the settings of a section: what they need to mean something,
/// `only`, `needs` and `unwritten_without`, of which [`UnmetSetting`] says the difference. In their brackets are how a
/// fault says it ([`Wording`]), another setting and its words, and what else is said.
macro_rules! settings {
    ($($section:ident: $Section:ident at $path:literal {
        $(all $of_all:ident($saying:ident $other:ident.$its:ident in $some:expr);)?
        $($(#[doc = $doc:literal])+ $name:ident: $Type:ident $(<$Of:ident>)? ($($argument:expr),*) = $default:expr,
            $source:literal
            $(, $mark:ident($wording:ident $of:ident.$key:ident in $words:expr $(, $more:ident $text:literal)*))*;)+
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
                $($(#[doc = $doc])+ pub $name: <$Type $(<$Of>)? as SettingType>::Value,)+
            }

            impl Default for $Section {
                fn default() -> Self {
                    Self { $($name: $default,)+ }
                }
            }

            impl $Section {
                const NEEDS: &[SettingNeed] = &[$(settings!(@need $of_all $saying $other.$its in $some))?];

                /// The declarations, in the order of the fields.
                pub const SETTINGS: &[Setting] = &[$(Setting {
                    name: stringify!($name),
                    path: concat!($path, ".", stringify!($name)),
                    doc: concat!($($doc,)+),
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
                    needs: [
                        &[$(settings!(@need $mark $wording $of.$key in $words $(, $more $text)*),)*],
                        Self::NEEDS,
                    ],
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
                    built_in: || ($Type $(::<$Of>)? ($($argument),*)).built_in(),
                },)+];
            }
        )+
    };
    (@need $mark:ident $wording:ident $of:ident.$key:ident in $words:expr
        $(, because $reason:literal)? $(, remedy $remedy:literal)?) => {
        SettingNeed {
            path: concat!(stringify!($of), ".", stringify!($key)),
            unmet: settings!(@$mark),
            wording: Wording::$wording,
            because: settings!(@text $($reason)?),
            remedy: settings!(@text $($remedy)?),
            words: || ($words).into_iter().map(Words::name).collect(),
            chosen: |settings| settings.$of.$key.name(),
        }
    };
    (@only) => { UnmetSetting::Absent };
    (@needs) => { UnmetSetting::Refused };
    (@unwritten_without) => { UnmetSetting::Unwritten };
    (@text) => { None };
    (@text $text:literal) => { Some($text) };
}

settings! {
    lamps: LampSettings at "lamps" {
        /// Lamps of diffuse light beside the laser; with one or two there is a map `grey`.
        number: Word<Lamps>(&Lamps::ALL) = Lamps::None, "off; scanners of boards have one or two",
            needs(While transport.model in [TransportName::Kernel], because "other models know the laser alone"),
            needs(While motion.kind in [Movement::Linear], because "shadows fall along a straight way");
    }

    scan: ScanSettings at "scan" {
        /// Sensor columns, and columns of the unbinned images.
        columns: Count(MIN_COLUMNS, MAX_COLUMNS, "px") = 2560, "[T]";
        /// Profiles in a scan, and rows of the unbinned images.
        profiles: Count(1, MAX_PROFILES, "") = 4000, "[T]; the buffers of the real camera hold 16383";
    }

    motion: MotionSettings at "motion" {
        /// How the object moves: `linear`, straight on; or `turntable`, about an upright axis in the laser plane.
        /// Profiles are then `step_mm` apart at `turn_radius_mm` from it.
        kind: Word<Movement>(&Movement::ALL) = Movement::Linear, "[T]";
    }

    laser: LaserSettings at "laser" {
        /// Lens that makes the line: `powell` lights a plane evenly, `cylindrical` leaves a hot spot in the middle.
        fan: Word<Fan>(&Fan::ALL) = Fan::Powell, "[V]",
            needs(OnPair laser.profile in [LineShape::Gaussian, LineShape::Slit],
                remedy "it is for lines with a lens: remove it");
        /// Light across the line: a `gaussian` beam; a `slit`, even with hard edges, as wide as its shadow is; a
        /// `texture` thrown by a projector; or a `point`, a round spot stepped along the line.
        profile: Word<LineShape>(&LineShape::ALL) = LineShape::Gaussian, "[T] slit and texture; [V]";
        /// Grey PNG that a projector throws, 8 or 16 bits, proportional to light; rows across the line, columns along
        /// it. `none` is the line of the thesis: three pixels wide of 61, blurred by a Gaussian of five.
        texture: File(64, &[], FileForm::Optional) = NamedFile::NONE, "[T] 3.2.1",
            needs(OnPair laser.profile in [LineShape::Texture], remedy "give `profile: texture`, or remove it");
    }

    camera: CameraSettings at "camera" {
        /// Sensor rows; the same for all samples, so a class cannot change it.
        rows: Count(64, 4096, "px") = 832, "[T]";
        /// Who tilts and focuses the sensor: the geometry, which puts the laser plane in focus, or `sensor_tilt_deg`
        /// and `focus_distance_mm`.
        scheimpflug: Word<Scheimpflug>(&Scheimpflug::ALL) = Scheimpflug::Solved,
            "the real bench; [T] had none in the simulation";
        /// A thin lens, which blurs what is out of focus, or a pinhole, which is sharp everywhere.
        lens: Word<LensModel>(&LensModel::ALL) = LensModel::ThinLens, "free",
            needs(While camera.scheimpflug in [Scheimpflug::Given], because "the laser plane is sharp anyway");
        /// Whether the opening of the lens bends light: the core of Airy's disc beside `blur_um`.
        diffraction: Flag() = true, "nature";
        /// Filter before the lens: none, or a band about `filter_centre_nm`.
        filter: Word<Filter>(&Filter::ALL) = Filter::None, "free; [T] band_pass";
        /// From the optical axis to the middle of the sensor's region, along the columns.
        offset_columns: Number(-MAX_OFFSET_PX, MAX_OFFSET_PX, "px") = 0.0, "region of interest";
        /// From the optical axis to the middle of the sensor's region, along the rows.
        offset_rows: Number(-MAX_OFFSET_PX, MAX_OFFSET_PX, "px") = 0.0, "region of interest";
    }

    exposure: ExposureSettings at "exposure" {
        /// Bits of a digital number. Keys in DN stay on the scale of 8 bits; images, frames and Scatter get finer
        /// steps.
        bits: OneOf(&[8, 10, 12]) = 8, "[T] 8";
        /// A second, flatter slope for bright light: 2, 6 or 15 times the dynamic range.
        hdr: Word<Hdr>(&Hdr::ALL) = Hdr::None, "modes of the real camera",
            needs(On postprocess.order in [Order::Physical], remedy "remove it, or give `order: physical`");
    }

    speckle: SpeckleSettings at "speckle" {
        /// Law of the light in a point: `exponential` as physics has it, `rayleigh` the square root of that, whose
        /// contrast is 0.523.
        law: Word<SpeckleLaw>(&SpeckleLaw::ALL) = SpeckleLaw::Exponential, "Goodman; [T] for `rayleigh`",
            unwritten_without(On postprocess.order in Order::with(Script::Speckle).chain([Order::Physical]),
                remedy "remove it");
    }

    log: LogSettings at "log" {
        #[doc = " Where the log and its knots come from: `placed`, with as many knots on the face as `knots` says; \
            `stem`, a whole stem with whorls, out of which the board is sawn where `stem` says; `measured`, a log from \
            files, sawn likewise; `picture`, a picture of a board's face; or `slices`, a stack of slices of a \
            microscope or a tomograph."]
        source: Word<LogSource>(&LogSource::ALL) = LogSource::Placed, "docs/theory/wood.md";
        /// Samples in a row that are boards of one log, which lie in it by a sawing pattern from where `stem` says, and
        /// have class, split, size and all that belongs to the log in common.
        boards_per_log: GroupSize(MAX_BOARDS_PER_LOG) = 1, "docs/theory/wood.md",
            only(On log.source in [LogSource::Stem, LogSource::Measured]);
        /// For `measured`: pith, rows of x, y and height [mm], heights rising; CSV or JSON (an array of rows).
        pith_file: File(16, &GRAN_1[0], FileForm::Needed) = NamedFile::new(GRAN_1[0][0].0), "Larsson et al. 2022, MIT",
            only(On log.source in [LogSource::Measured]);
        /// For `measured`: outline, a row of distances from the pith [mm] for each section, in equal steps along it, at
        /// azimuths that fall from 0 in equal steps of a turn.
        radii_file: File(16, &GRAN_1[1], FileForm::Needed) = NamedFile::new(GRAN_1[1][0].0),
            "Larsson et al. 2022, MIT",
            only(On log.source in [LogSource::Measured]);
        /// For `measured`: branches, rows of A to I [mm, rad], see docs/theory/wood.md.
        knots_file: File(16, &GRAN_1[2], FileForm::Needed) = NamedFile::new(GRAN_1[2][0].0),
            "Larsson et al. 2022, MIT",
            only(On log.source in [LogSource::Measured]);
    }

    picture: PictureSettings at "picture" {
        all needs(While log.source in [LogSource::Picture]);
        /// PNG, JPEG, TIFF or BMP of a board's face, the board's length down the rows; of a colour picture the red
        /// channel counts, which is nearest to the laser. A dark belt around the board is cut off. `none` beside
        /// `fibres`: every pixel has the light of clear wood, or in the thesis' colours what alpha leaves of it.
        file: File(256, &PICTURES, FileForm::Optional) = NamedFile::NONE, "docs/guide/pictures.md";
        /// Size of a pixel down the rows.
        pixel_mm: Number(0.01, 0.4, "mm") = 0.1, "free; 0.1 to 0.2 is best";
        /// Size of a pixel along the rows; `auto` is the same as down them.
        pixel_across_mm: Auto<Number>(Number(0.01, 0.4, "mm")) = None, "free";
        /// How numbers go with light: `srgb` for ordinary files, `linear` for raw files and maps of scans, `gamma` for
        /// another power.
        encoding: Word<PictureEncoding>(&PictureEncoding::ALL) = PictureEncoding::Srgb, "IEC 61966-2-1";
        /// For `gamma`: light is the number to this power.
        gamma: Number(0.3, 4.0, "") = 2.2, "free",
            only(Beside picture.encoding in [PictureEncoding::Gamma]);
        /// Number at no light, as a share of the end of the scale: the dark level of a scan.
        dark: Number(0.0, 0.9, "") = 0.0, "free";
        /// Which end of the board the first row shows: `far` on a photograph from above, `near` on maps that this
        /// program writes.
        first_row: Word<FirstRow>(&FirstRow::ALL) = FirstRow::Far, "free";
        /// Which side it shows: the pith lies below the `bark` side, 70 mm deep, and as far above the `pith` side. Says
        /// whether fibres rise or sink towards knots.
        face: Word<Face>(&Face::ALL) = Face::Bark, "docs/guide/pictures.md";
        /// Least width of a knot that is looked for.
        least_knot_mm: Number(1.0, 80.0, "mm") = 4.0, "docs/guide/pictures.md";
        /// How far below the face its colour goes: a `feature` as deep as it is wide, or all `even` to one depth and
        /// clear wood's mean below it. In knots colour follows the branch.
        depth: Word<PictureDepth>(&PictureDepth::ALL) = PictureDepth::Feature, "free: a picture does not say it";
        /// For `even`: that depth.
        depth_mm: Number(0.05, 200.0, "mm") = 3.0, "free",
            only(Beside picture.depth in [PictureDepth::Even]);
        #[doc = " Directions of the fibres, as large as the picture, in the place of those that are found in it: a PNG \
            in the thesis' colours, red over green the slope of rising lines, blue over green that of falling ones, or \
            an EXR with FibreCos2, FibreSin2 and FibreDive as `gen fibres` writes it."]
        fibres: File(256, &[], FileForm::Optional) = NamedFile::NONE, "[T] 3.2.3";
        /// Grey PNG of 8 bits, as large as the picture, of the numbers of pixel classes, in the place of knots that are
        /// found as labels; 0 counts as clear wood.
        labels: File(64, &[], FileForm::Optional) = NamedFile::NONE, "free";
    }

    slices: SlicesSettings at "slices" {
        all needs(While log.source in [LogSource::Slices]);
        /// Folder of grey PNGs with 8 or 16 bits, one for each slice, in the order of their names (numbers in them by
        /// value); or a tar of them, which is what datasets keep.
        stack: File(256, &STACKS, FileForm::OptionalStack) = NamedFile::NONE, "docs/guide/pictures.md";
        /// Size of a pixel down the rows of a slice. Voxels below 0.05 mm are put together.
        pixel_mm: Number(0.0001, 2.0, "mm") = 0.1, "free";
        /// Size of a pixel along the rows; `auto` is the same as down them.
        pixel_across_mm: Auto<Number>(Number(0.0001, 2.0, "mm")) = None, "free";
        /// Distance from slice to slice; `auto` is the size of a pixel down the rows.
        slice_mm: Auto<Number>(Number(0.0001, 20.0, "mm")) = None, "free";
        /// Which way the fibres run in the stack: `through`, from slice to slice, so that slices are cross-sections;
        /// `down` the rows of each slice, the last row at the near end; or `across`, along the rows. The first row lies
        /// up, or the first slice where fibres run in the slices.
        fibres: Word<FibreAxis>(&FibreAxis::ALL) = FibreAxis::Through, "free";
        /// Density at grey 0, by the calibration of the tomograph.
        black_kg_per_m3: Number(-20_000.0, 20_000.0, "kg/m^3") = 0.0, "free";
        /// Density at the end of the scale of 8 or 16 bits; below that of black where dense wood is dark.
        white_kg_per_m3: Number(-100_000.0, 100_000.0, "kg/m^3") = 1500.0, "free; 1500 is the cell wall";
        /// Density of the earlywood whose coefficients `media` gives.
        earlywood_kg_per_m3: Number(60.0, 1500.0, "kg/m^3") = 320.0, "docs/theory/wood.md";
        /// Density of the latewood whose coefficients `media` gives.
        latewood_kg_per_m3: Number(60.0, 1500.0, "kg/m^3") = 800.0, "docs/theory/wood.md";
    }

    mesh: MeshSettings at "mesh" {
        /// Triangles of the part: OBJ, STL or PLY, by the name's ending.
        file: File(64, &MESHES, FileForm::Needed) = NamedFile::new(MESHES[0].0), "free";
    }

    transport: TransportSettings at "transport" {
        /// Who says where light leaves: a table of Gaussians, Monte Carlo (the reference), diffusion on voxels or the
        /// thesis' picture.
        model: Word<TransportName>(&TransportName::ALL) = TransportName::Kernel, "docs/theory/physics.md";
        /// For `path`: photons that are walked in each profile.
        photons_per_profile: Count(1000, 10_000_000_000, "") = 1_000_000, "free; noise falls with their square root",
            only(On transport.model in [TransportName::Path]);
        /// For `diffusion`: edge of a voxel; memory grows with its inverse cube.
        voxel_mm: Number(0.05, 0.5, "mm") = 0.1, "free; 0.1 is a row of the default camera",
            only(On transport.model in [TransportName::Diffusion]);
        /// For `thesis`: how light is spread over pixels; `conservative` is what its diffusion should be.
        method: Word<ThesisMethod>(&ThesisMethod::ALL) = ThesisMethod::Diffusion, "[T]; `conservative` is ours",
            only(On transport.model in [TransportName::Thesis]);
        /// For `thesis` by `diffusion`: iterations; by `conservative`: steps from each path length to the next.
        iterations: Count(1, 1000, "") = 20, "[T] 20 on clear wood, 10 on a knot",
            only(On transport.model in [TransportName::Thesis]),
            only(On transport.method in ThesisMethod::ALL.into_iter().filter(|method| method.iterates()));
        /// For `thesis`: side of a pixel.
        pixel_mm: Number(0.02, 0.5, "mm") = 0.1, "free; 0.1 is a row of the default camera",
            only(On transport.model in [TransportName::Thesis]);
    }

    postprocess: PostprocessSettings at "postprocess" {
        /// The scripts, first one first.
        order: Word<Order>(&Order::ALL) = Order::Physical, "[T] section 3.3; `physical` is ours";
        /// Standard deviation of the Gaussian blur.
        blur_radius_px: Number(0.05, 20.0, "px") = 0.5, "[T] 0.5, wood 1; the thesis says radius",
            only(On postprocess.order in Order::with(Script::Blur));
        /// Mean of the pattern of speckle that light is multiplied by.
        intensity_scale: Number(0.01, 100.0, "") = 3.5, "[T] saw-tooth 3.5, wood 6, pack 7",
            only(On postprocess.order in Order::with(Script::Speckle));
        /// Side of the pattern.
        pattern_px: Count(64, 4096, "px") = 1000, "[T]",
            only(On postprocess.order in Order::with(Script::Speckle));
        /// Diameter of the disc of random phases, at most half of the side: a speckle is side / diameter wide.
        mask_px: Count(8, 2048, "px") = 500, "[T]",
            only(On postprocess.order in Order::with(Script::Speckle));
        /// Pattern pixels along a sensor pixel; 6 makes the speckles of the default bench as large as they are.
        sampling_factor: Count(1, 32, "") = 5, "[T] 5",
            only(On postprocess.order in Order::with(Script::Speckle));
    }

    extraction: ExtractionSettings at "extraction" {
        /// How the peak is placed between the rows.
        method: Word<PeakMethodName>(&PeakMethodName::ALL) = PeakMethodName::CentreOfGravity, "[T] centre of gravity";
        /// For `blais_rioux`: rows of the derivative, half of them on each side.
        blais_rioux_order: OneOf(&[2, 4, 8]) = 4, "Blais and Rioux 1986",
            only(Beside extraction.method in [PeakMethodName::BlaisRioux]);
        /// For `fir`: taps of the binomial smoothing before the derivative.
        fir_length: OneOf(&[3, 5, 7, 9]) = 5, "free",
            only(Beside extraction.method in [PeakMethodName::Fir]);
        /// Rows on each side of the peak that the position is made from; `parabola` and `gaussian` have one.
        window_rows: OneOf(&[3, 7, 15]) = 7, "window around the maximum of the real camera",
            only(Beside extraction.method in [
                PeakMethodName::CentreOfGravity, PeakMethodName::BlaisRioux, PeakMethodName::Fir,
            ]);
        /// Which peak of a column counts: the `strongest`, or the `first` that reaches the threshold.
        peak: Word<PeakChoice>(&PeakChoice::ALL) = PeakChoice::Strongest,
            "GlobalMax and FirstLocalMax of the real camera";
        /// From where peaks are searched: `standard` from row 0, `reverse` from the last; a plateau counts from its
        /// first row.
        direction: Word<SearchDirection>(&SearchDirection::ALL) = SearchDirection::Standard,
            "search direction of the real camera";
        /// Smallest digital number of a peak, on the scale of 8 bits.
        threshold_dn: Number(0.0, 255.0, "DN") = 17.0, "dark level plus five standard deviations";
        /// Steps per row in which the peak position is given; 0 leaves it unrounded.
        subpixel_steps: Count(0, 256, "") = 16, "1/16 px of the real camera";
        /// Which side windows Scatter sums: both, `front` (smaller row numbers) or `back`.
        scatter_mode: Word<ScatterMode>(&ScatterMode::ALL) = ScatterMode::Symmetric, "modes of the real camera";
        /// Distance from the peak to the first summed row; 0 includes the peak.
        scatter_offset_rows: Count(0, 15, "px") = 1, "[T] wood";
        /// Rows that are summed on each side; offset and width together at most 16, at most 29 rows in all.
        scatter_width_rows: Count(1, 16, "px") = 8, "[T] wood";
        /// Whether the dark level stays in Scatter or is taken out, ending at 0.
        scatter_dark: Word<ScatterDark>(&ScatterDark::ALL) = ScatterDark::Kept, "the real camera sums plain numbers";
        /// What Range is: height at each sensor column [mm], sensor row [px], or height on an even grid of x [mm].
        range: Word<RangeFormName>(&RangeFormName::ALL) = RangeFormName::Calibrated,
            "CalibratedAC, UncalibratedC and RectifiedC of the real camera";
        /// For `range: rectified`: distance of the grid's columns; `auto` is that of the sensor's columns at z = 0.
        rectified_pitch_mm: Auto<Number>(Number(0.001, 10.0, "mm")) = None, "free",
            only(Beside extraction.range in [RangeFormName::Rectified]);
    }

    splits: SplitSettings at "splits" {
        /// Share for training.
        train: Number(0.0, 1.0, "") = 0.8, "usual";
        /// Share for choosing.
        validation: Number(0.0, 1.0, "") = 0.1, "usual";
        /// Share for the last word.
        test: Number(0.0, 1.0, "") = 0.1, "usual";
        /// What they do not part: all that a `rig` has scanned, the boards of a `log`, the objects of a `batch`; `[]`
        /// for nothing. Shares are then met as well as these groups allow.
        by: WordList<SplitBy>(Some(&UNPARTED)) = UNPARTED.to_vec(), "what a test split is for: matter not seen before";
    }

    output: OutputSettings at "output" {
        /// Images in the Parquet rows, as PNG; where `lamps` are, `grey` too.
        png: WordList<Channel>(None) =
            [Channel::Range, Channel::Reflectance, Channel::Scatter, Channel::Label].to_vec(), "free";
        /// Images in the EXR files: `auto` for what `png` lacks to the last bit, such as fractions of heights and means
        /// of binned pixels; `all`; or a list. Without any, and without `truth_maps`, there are no EXR files.
        exr: ImageList() = ImageChoice::Auto, "free";
        /// Whether the EXR files hold noise-free maps: height, and fibre azimuth and dive, or film thickness and gap.
        truth_maps: Flag() = true, "free";
        /// Which sensor frames are kept: none, all, or every k-th from the first.
        sensor_stack: StackChoice(MAX_PROFILES) = SensorStack::None, "free";
        /// Samples in a shard; `auto` keeps a shard under about 500 MB, and about a minute's work of two cores.
        samples_per_shard: Auto<Count>(Count(1, 100_000, "")) = None, "free";
    }

    bin: BinSettings at "output.bin" {
        /// Columns averaged into one, of measured pixels on one surface; divides `scan.columns`.
        columns: Count(1, MAX_COLUMNS, "px") = 1, "free";
        /// Profiles averaged into one, of measured pixels on one surface; divides `scan.profiles`.
        profiles: Count(1, MAX_PROFILES, "") = 1, "free";
    }
}

impl Settings {
    /// Adds the map `grey` to the images in tables where there are lamps and the recipe lists none itself.
    pub fn list_grey(&mut self, is_written: impl Fn(&str) -> bool) {
        let png = &mut self.output.png;
        if self.lamps.number != Lamps::None && !is_written("output.png") {
            png.push(Channel::Grey);
            png.sort_unstable();
        }
    }

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

    /// What of the laser is not drawn; `picture` is what its texture shows.
    pub fn line(&self, picture: Option<TextureImage>) -> LaserLine {
        LaserLine { fan: self.laser.fan, shape: self.laser.profile, picture }
    }

    /// What of the camera is the same for all samples.
    pub fn optics(&self) -> Optics {
        let CameraSettings { rows: _, scheimpflug, lens, diffraction, filter, offset_columns, offset_rows } =
            self.camera;
        Optics { scheimpflug, lens, filter, diffraction, offset_columns, offset_rows, lamps: self.lamps.number }
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
        let mut output = Output {
            bin_columns: self.bin.columns,
            bin_profiles: self.bin.profiles,
            png,
            exr: Vec::new(),
            range_rest: false,
            truth_maps,
            sensor_stack,
            samples_per_shard,
            bits: self.readout().bits,
        };
        let known = Channel::ALL.into_iter().filter(|c| *c != Channel::Grey || self.lamps.number != Lamps::None);
        match exr {
            ImageChoice::These(list) => output.exr = list,
            ImageChoice::All => output.exr = known.collect(),
            ImageChoice::Auto => {
                let extraction = self.extraction();
                let lacking = known.filter(|&channel| !output.png_is_exact(channel, &extraction, self.camera.rows));
                let has_numbers = output.png.contains(&Channel::Range);
                let (range, others) = lacking.partition(|&channel| channel == Channel::Range && has_numbers);
                let range: Vec<Channel> = range;
                (output.range_rest, output.exr) = (!range.is_empty(), others);
            }
        }
        output
    }

    /// Shares of the splits.
    pub fn splits(&self) -> Splits {
        let SplitSettings { train, validation, test, by: _ } = self.splits;
        Splits { train, validation, test }
    }
}
