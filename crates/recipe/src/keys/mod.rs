//! Keys of a recipe by section: reading, canonical form, schema and reference all walk over this table.
//!
//! Parameters are drawn for each sample and declared beside the physics that uses them; settings are the same for all
//! samples and declared in [`settings`].

pub(super) mod alternatives;
mod datasheet_words;
pub(super) mod idle;
pub(crate) mod setting_type;
pub(super) mod settings;

use std::collections::BTreeMap;
use std::sync::LazyLock;

use base::{Parameter, ParameterGroup};
use procedural::blister::Blister;
use procedural::solid::{Material, Piece, Placing};
use procedural::wood::Wood;

use self::settings::{
    BinSettings, CameraSettings, ExposureSettings, ExtractionSettings, LampSettings, LaserSettings, LogSettings,
    MeshSettings, MotionSettings, OutputSettings, PictureSettings, PostprocessSettings, ScanSettings, Setting,
    SlicesSettings, SpeckleSettings, SplitSettings, TransportSettings,
};
use super::subject::Subject;
use optical_bench::parameters::{
    CameraParameters, ExposureParameters, LampParameters, LaserParameters, MotionParameters, SpeckleParameters,
};

/// A group of keys.
#[derive(Debug, Clone, Copy)]
pub(super) struct RecipeSection {
    /// Key path, for instance `camera` or `output.bin`.
    pub path: &'static str,
    /// What the group is about.
    pub doc: &'static str,
    /// What the objects are in recipes that have it; empty for all recipes.
    pub subjects: &'static [Subject],
    /// Keys that are the same for all samples.
    pub settings: &'static [Setting],
    /// Keys that are drawn for each sample.
    pub parameters: &'static [Parameter],
}

/// A section of parameters: of some subjects, or of all, with settings beside them.
macro_rules! drawn {
    ($Group:ty, $subjects:expr, $settings:expr) => {
        RecipeSection {
            path: <$Group>::GROUP,
            doc: <$Group>::DOC,
            subjects: $subjects,
            settings: $settings,
            parameters: <$Group>::PARAMETERS,
        }
    };
}

/// The sections of the groups that make a subject's objects.
fn of_subject(groups: &[ParameterGroup], subjects: &'static [Subject]) -> impl Iterator<Item = RecipeSection> {
    groups.iter().map(move |&ParameterGroup { path, doc, parameters }| {
        let settings = match path {
            "log" => LogSettings::SETTINGS,
            "picture" => PictureSettings::SETTINGS,
            "slices" => SlicesSettings::SETTINGS,
            _ => &[],
        };
        RecipeSection { path, doc, subjects, settings, parameters }
    })
}

/// A section of settings alone.
const fn fixed(path: &'static str, doc: &'static str, settings: &'static [Setting]) -> RecipeSection {
    RecipeSection { path, doc, subjects: &[], settings, parameters: &[] }
}

/// Path of the section whose first setting can stand for all: `transport: path`.
pub(super) const TRANSPORT: &str = "transport";

/// What the section [`TRANSPORT`] is about.
pub(super) const TRANSPORT_DOC: &str = "\
How light spreads below the surface: the name of a model (`transport: path`), or a map of a model and its keys
(`transport: {model: path, photons_per_profile: 100000}`). Each key has an effect on one model and is a fault beside
another. Datasets are made with `kernel`; the others are slow, for single profiles and comparisons.";

/// What the section `postprocess` is about.
const POSTPROCESS_DOC: &str = "\
What is done to the light of whole frames before they are read. `physical` leaves it to laser, lens, speckle and sensor;
the others are the orders of the thesis' scripts, each on noise-free frames without speckle. A key beside an order \
that it
has no effect on is a fault.";

/// Every section, in the order of the light: scan, bench, object, transport, reading, writing.
pub(super) static SECTIONS: LazyLock<Vec<RecipeSection>> = LazyLock::new(|| {
    let bench = [
        fixed("scan", "Sizes of the scan.", ScanSettings::SETTINGS),
        drawn!(MotionParameters, &[], MotionSettings::SETTINGS),
        drawn!(LaserParameters, &[], LaserSettings::SETTINGS),
        drawn!(CameraParameters, &[], CameraSettings::SETTINGS),
        drawn!(ExposureParameters, &[], ExposureSettings::SETTINGS),
        drawn!(SpeckleParameters, &[], SpeckleSettings::SETTINGS),
        drawn!(LampParameters, &[], LampSettings::SETTINGS),
    ];
    let objects = of_subject(Wood::GROUPS, &[Subject::Wood]).chain(of_subject(Blister::GROUPS, &[Subject::Blister]));
    let others = [
        drawn!(Piece, &[Subject::Sawtooth], &[]),
        drawn!(Placing, &[Subject::Mesh], MeshSettings::SETTINGS),
        drawn!(Material, &[Subject::Sawtooth, Subject::Mesh], &[]),
        fixed(TRANSPORT, TRANSPORT_DOC, TransportSettings::SETTINGS),
        fixed("postprocess", POSTPROCESS_DOC, PostprocessSettings::SETTINGS),
        fixed("extraction", "How a profile is read from a frame.", ExtractionSettings::SETTINGS),
        fixed("splits", "Shares of the parts of the dataset; they sum to 1.", SplitSettings::SETTINGS),
        fixed("output", "What is written.", OutputSettings::SETTINGS),
        fixed("output.bin", "How many pixels are averaged into one of the written images.", BinSettings::SETTINGS),
    ];
    bench.into_iter().chain(objects).chain(others).collect()
});

impl RecipeSection {
    /// Whether recipes about `subject` have it; all have what is asked about while the subject is a fault itself.
    pub(crate) fn is_of(&self, subject: Option<Subject>) -> bool {
        self.subjects.is_empty() || subject.is_none_or(|subject| self.subjects.contains(&subject))
    }
}

/// The sections of recipes about `subject`, in the order of [`SECTIONS`].
pub(super) fn sections(subject: Option<Subject>) -> impl Iterator<Item = &'static RecipeSection> {
    SECTIONS.iter().filter(move |section| section.is_of(subject))
}

/// The parameters of recipes about `subject`, in the order of [`SECTIONS`].
pub(super) fn parameters(subject: Option<Subject>) -> impl Iterator<Item = &'static Parameter> {
    sections(subject).flat_map(|section| section.parameters)
}

/// The parameter at `path` of recipes about `subject`.
pub(super) fn parameter(subject: Option<Subject>, path: &str) -> Option<&'static Parameter> {
    static BY_PATH: LazyLock<BTreeMap<String, Vec<(&RecipeSection, &Parameter)>>> = LazyLock::new(|| {
        let mut known: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for (section, parameter) in
            SECTIONS.iter().flat_map(|section| section.parameters.iter().map(move |p| (section, p)))
        {
            known.entry(parameter.path()).or_default().push((section, parameter));
        }
        known
    });
    let found = BY_PATH.get(path)?.iter().find(|(section, _)| section.is_of(subject));
    found.map(|(_, parameter)| *parameter)
}

/// The settings of recipes about `subject`, in the order of [`SECTIONS`].
pub(super) fn settings(subject: Option<Subject>) -> impl Iterator<Item = &'static Setting> {
    sections(subject).flat_map(|section| section.settings)
}

/// The unit that a key ends in, empty for none.
pub(super) fn unit(name: &str) -> &'static str {
    match output_schema::unit_of(name) {
        "1" => "",
        unit => unit,
    }
}

/// Where a key that stands in the wrong section, or in a recipe about another subject, belongs, and what says the same
/// as a word of data sheets, unless it is one of the `known` keys there without its unit.
pub(super) fn home(subject: Option<Subject>, name: &str, known: &[&str]) -> Option<String> {
    let lacks_end = |key: &&str| key.strip_prefix(name).is_some_and(|end| end.starts_with('_'));
    let said = || if known.iter().any(lacks_end) { None } else { datasheet_words::keys_for(name) };
    let has = |section: &&RecipeSection| {
        section.parameters.iter().any(|p| p.name == name) || section.settings.iter().any(|s| s.name == name)
    };
    let listed = |sections: Vec<&RecipeSection>| -> Option<String> {
        let paths: Vec<_> = sections.iter().map(|section| format!("`{}`", section.path)).collect();
        (!paths.is_empty()).then(|| format!("`{name}` belongs in {}", paths.join(" or ")))
    };
    let foreign = |section: &&RecipeSection| !section.is_of(subject);
    // Each section that is not of this subject is of others.
    let remedy = |section: &RecipeSection| {
        let names = |quote: &str| -> Vec<_> {
            section.subjects.iter().map(|subject| format!("{quote}{}`", subject.name())).collect()
        };
        format!("is for subject {}: remove it, or give {}", names("`").join(" or "), names("`subject: ").join(" or "))
    };
    if let Some(other) = SECTIONS.iter().filter(foreign).find(|s| s.path == name) {
        return Some(format!("`{name}` {}", remedy(other)));
    }
    let of_others = || {
        let section = SECTIONS.iter().filter(foreign).find(has)?;
        Some(format!("`{name}` of `{}` {}", section.path, remedy(section)))
    };
    listed(sections(subject).filter(has).collect()).or_else(of_others).or_else(said)
}

/// Documentation without the blanks that `///` leaves in front of its lines.
pub(super) fn tidy(doc: &str) -> String {
    doc.trim().replace("  ", " ")
}
