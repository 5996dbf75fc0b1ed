//! The reference of every key, from the same tables; the pages of `recipes/` are its committed copy.

use std::fmt::Write;

use base::{Natural, Parameter};
use serde_json::Value;

use super::distribution::{FORMS, range};
use super::embedded::EMBEDDED;
use super::keys::alternatives::alternatives;
use super::keys::{RecipeSection, SECTIONS, tidy, unit};
use super::presets::{PRESET, PRESET_DOC, PresetSource, names, presets};
use super::subject::Subject;
use yaml::number_text;

/// What a recipe is.
const OPENING: &str = "\
# Recipes

A recipe is a YAML file that says what a dataset is made of: the bench, the objects, the kinds of samples and what is
written. Copy one that is built in and change it:

    gen recipe list
    gen recipe new --subject wood > mine.yaml      # a first one of 20 lines; or all of one: gen recipe show wood-small
    gen preview --recipe mine.yaml --out board.png

A whole recipe:

```yaml
# yaml-language-server: $schema=recipe.schema.json
name: two-kinds
subject: wood
scan: {columns: 512, profiles: 256}                   # a field of 23.6 x 17.4 mm
board: {width_mm: 20, length_mm: 15, lead_in_mm: 1}  # that holds the board
camera:
  tilt_deg: 30                                       # a number
  blur_um: {uniform: [1.5, 4]}                       # a distribution
classes:
  clear: {share: 2}                                  # two of three samples
  knotty:
    share: 1                                         # one of three
    knots: {sound_count: {uniform: [1, 4]}}          # only here; everything else as at the top level
output: {bin: {columns: 2, profiles: 2}}
```

";

/// How one takes values from another.
const INHERITANCE: &str = "\
## A recipe that extends another

```yaml
# yaml-language-server: $schema=recipe.schema.json
extends: wood-small                                  # a built-in recipe, or a file beside this one
name: steep
camera: {tilt_deg: 35, blur_um: null}                # one number is another, one key goes back to its default
classes:
  rot: null                                          # one class less
  sound_knot: {share: 0.4}                           # what it changes of the bench and the board stays
  broad_knot: {share: 0.1, knots: {sound_count: 1, width_mm: 7}}
```

- Sections, classes and their sections are merged key by key: what stands in this recipe wins, and `null` removes a key
  of the parent. `camera:` with nothing behind it is `null` too.
- Every other value replaces the parent's whole: a number, a distribution, a list, `transport` with its keys.
- A key in the words of data sheets removes the keys that it stands for, and these remove it.
- Of a list of parents, `extends: [wood, my-media.yaml]`, the last one counts most. One of them may have a few sections
  alone, such as the matter that `gen fit --matter` writes.
- A parent may extend others; at most eight are above a recipe. Files that it names stay its own.
- Where something is wrong with an inherited value, the fault names the parent's file and line.
- `gen recipe show --flat` prints all of it as one text. A dataset keeps that text, with the SHA-256 of each recipe that
  it was made from, and needs none of their files any more. Ids follow from what it means, not from how it is split.

";

/// How one is written.
const READING: &str = "\
## How a recipe reads

- `name` and `subject` (`wood`, `blister`, `sawtooth` or `mesh`) are required. A recipe that extends another has them
  from there.
- Numbers that are not stated [vary by nature](keys/draws.md#what-is-not-stated), or keep their defaults where it says
  `unstated: fixed`. Settings that are not stated have their defaults.
- A *setting* is the same for all samples. A *parameter* is drawn for each sample, or for each of its
  [groups](keys/draws.md#rigs-logs-and-batches): give a number or a
  [distribution](keys/draws.md#distributions).
- [`classes`](keys/draws.md#classes) names kinds of samples, with their shares and the keys that they change; without
  it there is one of each kind.
- `family` names the recipes that draw the same random numbers for the same seed; without it, `name` is a family of its
  own.
- [`sampling` and `correlations`](keys/draws.md#correlations) say how draws of samples and of keys hang together;
  without them they don't.
- `set` holds what `--set KEY=VALUE` changed on the command line: key paths with the values that replace those above.
- A section of one subject is a fault in a recipe about another.
- A file is named relative to the recipe's own file, or is one that is built in. Its content is part of what the recipe
  means, and the dataset keeps a copy: give the folder of a dataset in place of a recipe to continue it. The long form
  `{name: part.stl, sha256: ...}` takes the file with that content alone.
- Keys in the words of data sheets (`speed_mm_per_s`, `waist_fwhm_mm`, `working_distance_mm` with `baseline_mm`) stand
  in place of others; give one of both. `gen rig` prints all of them for any recipe.
- A key ends in its unit: mm, um, nm, deg, us, mW, DN (digital numbers), e (electrons). Keys without a unit are counts
  or shares.
- All faults of a recipe are reported at once, each with its line, its key, what is allowed and the nearest right
  spelling.
- `recipe.schema.json` lets editors complete and check a recipe that begins with
  `# yaml-language-server: $schema=recipe.schema.json`.

These pages and the schema are generated from the tables that the program reads recipes with
(`BLESS=1 cargo test -p recipe --test recipe_schema` writes them again).
";

/// Keys that one changes first: group and name.
const FIRST: [(&str, &str); 15] = [
    ("scan", "columns"),
    ("scan", "profiles"),
    ("motion", "step_mm"),
    ("laser", "power_mw"),
    ("laser", "waist_mm"),
    ("camera", "distance_mm"),
    ("camera", "tilt_deg"),
    ("camera", "focal_length_mm"),
    ("exposure", "time_us"),
    ("speckle", "strength"),
    ("extraction", "threshold_dn"),
    ("output", "exr"),
    ("knots", "sound_count"),
    ("film", "sigma_per_mm"),
    ("mesh", "file"),
];

/// Pages of keys: file, title, and what they are about.
const KEY_PAGES: [(&str, &str, &str); 5] = [
    ("keys/bench.md", "The bench", "Scan, motion, laser, camera, sensor, extraction and the model of light."),
    ("keys/wood.md", "Boards", "The board, its log, defects, optical media and surface."),
    ("keys/blister.md", "Blister packs", "The pack, its pockets and tablets, film, foil and defects."),
    ("keys/parts.md", "Saw-teeth and parts", "Calibration pieces, parts from files, and what they are made of."),
    ("keys/output.md", "What is written", "Splits, images, truth maps, sensor frames, and binning."),
];

/// The page of draws.
const DRAWS: (&str, &str) = ("keys/draws.md", "Distributions, classes and sampling");

/// The page of presets.
const PRESETS: (&str, &str) = ("keys/presets.md", "Presets");

/// What a preset is.
const PRESETS_INTRODUCTION: &str = "\
What data sheets say, as values of a [recipe](../README.md). `gen recipe presets` lists the same, `--json` for programs.

```yaml
extends: wood-small
name: my-line
camera: {preset: alvium-c-508, f_number: 4}      # numbers of the sheet; what stands beside them wins
laser: {preset: s-laser-660-fine, power_mw: 60}
classes:
  larch: {share: 1, log: {preset: european-larch}}
```

- What a recipe states wins over its presets, and these win over what it extends. Of a list of names (`preset: [a, b]`)
  the last one wins.
- A preset may have keys of other sections: a camera has the keys of `exposure` that its sheet tells.
- What a sheet lacks stays as it is: as inherited, or the default.
- The values become part of the recipe: a dataset keeps them, with the SHA-256 of the file that they are from.
";

/// What the letters of the column *source* mean.
const SOURCES: &str = "\
Sources: [T] Kihl and Källberg 2021, the thesis whose bench this is; [V] vendors' published figures; [M] and [E]
engineering estimates; [C] computed or chosen so that the observables come out; [G] statistics of a scanned spruce log
(Larsson et al. 2022); [P] photographs of sawn boards; [L] literature named in the project's documentation. The column
*natural* says how a number differs between rigs, logs, batches or samples of good installations; empty where it does
not, is chosen, or is off. Where the source tells no such spread, *spread [M]* marks an estimate.
";

const BOUNDS: &str = "
Every draw is made again until it lies in the parameter's own range. A distribution with less than 1 % chance of that is
a fault, and so is an end or a value out of range. Counts are rounded to the nearest whole number.

";

const CLASSES: &str = "\
## Classes

`classes` maps names (a-z, 0-9, _) to kinds of samples. Each has a `share`, relative to the other shares (at least a
millionth of their sum). It may repeat any group of parameters with the keys that it changes; settings stay the same for
all classes.

Sample i belongs to the class at the point (offset + i / golden ratio) mod 1 of the shares, classes in the order of
their names. So every prefix of a dataset holds each class within a few samples of its share, and the first hundred
samples of a large dataset are the dataset of a hundred. Splits go by the order of the samples of each class: in every
prefix each split holds each class within two samples of its share.

Without `classes` a recipe has one class for each kind of object that its subject knows, with shares as a line sees them
that looks for defects (estimates): `--estimate` lists them, and `gen recipe show --json` prints what they change.

";

const UNSTATED: &str = "\
## What is not stated

With `unstated: drawn`, the default, a number that a recipe does not state varies as it does between good installations:
the column *natural* of the tables of keys. With `unstated: fixed` all of them are at their defaults. Recipes that are
built in say so, and hand it on to those that extend them.

- What is off by default stays off: an effect that one must ask for, counts of defects, what one builds or chooses.
- A number is drawn only where it has an effect: how rot looks, where a class has rot.
- What is stated comes first. Natural numbers that have no room beside it go back to their defaults.
- Some go together by nature, and a recipe's own pairs come first: wide rings have less latewood.
- `gen rig`, `gen preview`, `--estimate` and `gen report` say how many vary. They name numbers of matter that are fixed
  although classes are told by what moves with them.
- `gen fit` looks for what is stated; natural numbers are drawn for each scan.
- A dataset that an earlier version began counts as `unstated: fixed`.

";

const GROUPS: &str = "\
## Rigs, logs and batches

| numbers | are the same in |
|---|---|
| of the bench: `motion`, `laser`, `camera`, `exposure`, `speckle`, `lamps` | all that one of `rigs` has scanned |
| of boards: `log`, `stem`, `knots`, `anatomy`, `media` but `gloss`, size of `board` | boards of one log \
(`log.boards_per_log`) |
| of others: `tablet`, `pocket`, `film`, `foil`, `material`, sizes of `pack` and `sawtooth` | objects of one batch \
(`samples_per_batch`) |
| all others: how the object lies, its face, its defects | one sample |

- `rigs: 8` makes eight instruments, each drawn once. Each scans as many samples of each class as another. A log or a
  batch is scanned by one of them. Without it each sample has its own.
- `samples_per_batch: 10` makes ten samples in a row one batch. Without it each sample has its own, and each board its
  own log without `log.boards_per_log`.
- The columns `rig`, `log_number` and `batch` of the table of samples say which.
- `splits.by` names what splits do not part: `[log, batch]` unless it says otherwise, `[rig]` to test on instruments
  never seen, `[]` for nothing. Shares are met as well as whole groups allow; `--estimate` and a run tell how well.

";

const CORRELATIONS: &str = "\
## Correlations

Keys are drawn independently of each other, but for pairs that the recipe names:

```yaml
correlations:
  - {keys: [log.ring_width_mm, log.latewood_share], spearman: -0.6}      # wider rings have less latewood
  - {keys: [laser.waist_mm, laser.m_squared], spearman: 0.4}
```

- `spearman` is the rank correlation of the draws, between -1 and 1. Each key keeps its own distribution and its bounds,
  exactly; keys in no pair keep every draw.
- Keys are named with their section. Both must have a distribution on a scale (no number, choice or count) in at least
  one class; in classes in which one of them has none the pair has no effect.
- Several pairs must be possible together. Pairs that are not named count as 0. A fault says which pair may be what.

By a Gaussian copula: x_i = F_i^-1(Phi(y_i)) with F_i the distribution function of key i and y normal with the
correlations 2 sin(pi spearman / 6) (Pearson 1907; Nelsen 2006). Dependence is monotone; extremes of two keys meet no
more often than these make likely. No distribution depends on another key. Kinds of samples (decayed, then dark) are
what classes are for.

";

const SAMPLING: &str = "\
## Sampling

| `sampling` | how the samples of a class are drawn |
|---|---|
| `independent` | each by itself; the default |
| `low_discrepancy` | so that they cover the range of each key evenly: of the first n samples of a class, those below \
any place in the range of a key are their share within log2(n) + 1 samples |

Low discrepancy is for few samples: independent draws miss a share by some sqrt(n) / 2 samples. Points of two keys fill
their plane evenly too. Distributions and correlations stay as declared, and any sample can be made alone. A split is
even by no more than chance, and of keys that are correlated only the first by its path is as even as stated. The
sequences are van der Corput's, scrambled and put in another order for each key (Owen 1995, Burley 2020).

";

const EDITING: &str = "\
## What stays when a recipe is edited

Each parameter of each sample has a random stream of its own, keyed by the seed, the family, the sample and the key
path. Editing one key leaves every other draw as it was, but of keys that are correlated with it. With
`sampling: low_discrepancy` editing classes moves more draws, since the rank in the class counts.

- **Other names draw other numbers**: who trains on one recipe and tests on another sees nothing twice.
- **To compare two recipes sample by sample**, give both one `family`. Then choose another seed for the data that a
  network is tested on.
- **The identity** of a sample (a UUID) follows from the meaning of the whole recipe, the seed and its number. Comments,
  the order of keys and the way a number is written do not matter.

";

const FITTING: &str = "\
## What must fit together

These hold for every draw: a distribution is checked at its ends, and a recipe that breaks one is refused with a remedy.

- `camera.focal_length_mm` stays below half of `camera.distance_mm`; laser and camera stand above the object.
- `exposure.dark_noise_dn` covers its parts: row noise^2 + row pattern^2 + column pattern^2 + DSNU^2 + 1/12 (rounding)
  is at most its square.
- `scan.columns` times `scan.profiles` is at most 2^27; the bins divide them. `splits` sum to 1.
- `extraction.scatter_offset_rows` + `scatter_width_rows` is at most 16, and at most 29 rows are summed, 16 of 12 bits.
- All pockets have room on the card, with their walls; `tablet.band_mm` is at most `tablet.thickness_mm`.
- `material.gloss` times `reflectance` plus `matte` is at most 1: no surface throws back more light than it gets.
- `transport` is `kernel` or `path` for blister packs, and `kernel` for meshes, which can overhang.
- A key of `extraction` or `transport` stands only beside the method, range or model that it has an effect on.
- Under an order of `postprocess` other than `physical` noise is `dark_level_dn` and `dark_noise_dn` alone,
  `exposure.hdr` is none and `speckle` has its law alone.

DN in keys count on the scale of 8 bits (0 to 255) whatever `exposure.bits` is, so that a recipe is one sensor; images,
frames and Scatter hold the converter's own numbers.
";

/// A page of the reference.
pub struct ReferencePage {
    /// Its file below `recipes`, with slashes.
    pub file: &'static str,
    /// Its text, in Markdown.
    pub text: String,
}

/// Every key of a recipe: meaning, unit, default, range and source; the overview first.
pub fn reference_pages() -> Vec<ReferencePage> {
    let mut pages = vec![ReferencePage { file: "README.md", text: overview() }];
    for (file, title, about) in KEY_PAGES {
        let mut text = format!("# {title}\n\n{about} [Recipes](../README.md) says how to write keys.\n\n{SOURCES}");
        for section in SECTIONS.iter().filter(|section| page_of(section) == file) {
            keys(&mut text, section);
        }
        pages.push(ReferencePage { file, text });
    }
    pages.push(ReferencePage { file: PRESETS.0, text: preset_page() });
    pages.push(ReferencePage { file: DRAWS.0, text: draws() });
    pages
}

/// The pages of [`reference_pages`] as one text.
pub fn reference_markdown() -> String {
    reference_pages().into_iter().map(|page| page.text).collect::<Vec<_>>().join("\n")
}

fn overview() -> String {
    let mut page = OPENING.to_owned();
    page.push_str("## Where keys are explained\n\n| page | keys |\n|---|---|\n");
    for (file, title, _) in KEY_PAGES {
        let sections = SECTIONS.iter().filter(|section| page_of(section) == file);
        let paths: Vec<_> = sections.map(|section| format!("`{}`", section.path)).collect();
        row(&mut page, &[&format!("[{title}]({file})"), &paths.join(", ")]);
    }
    row(&mut page, &[&format!("[{}]({})", PRESETS.1, PRESETS.0), "`preset` of `camera`, `laser` and more"]);
    row(
        &mut page,
        &[
            &format!("[{}]({})", DRAWS.1, DRAWS.0),
            "distributions, `unstated`, `rigs`, `classes`, `correlations`, `sampling`",
        ],
    );
    page.push_str("\n## Fifteen keys that matter first\n\n| key | default | meaning |\n|---|---|---|\n");
    for (path, name) in FIRST {
        let section = SECTIONS.iter().find(|section| section.path == path);
        let cells = section.into_iter().flat_map(rows).find(|cells| cells[0] == name);
        // A test asks for each of them.
        let Some([_, meaning, unit, default, ..]) = cells else { continue };
        let default = format!("{default} {unit}");
        row(&mut page, &[&format!("`{path}.{name}`"), default.trim_end(), &meaning]);
    }
    page.push('\n');
    page.push_str(INHERITANCE);
    page.push_str(READING);
    page.push_str("\n## Recipes that are built in\n\n");
    page.push_str("`wood` names the first wherever no file of that name exists.\n\n| recipe | what |\n|---|---|\n");
    for recipe in &EMBEDDED {
        row(&mut page, &[&format!("`{}.yaml`", recipe.name), recipe.summary]);
    }
    page
}

fn draws() -> String {
    let mut page = format!("# {}\n\nHow a sample's numbers are drawn from a [recipe](../README.md).\n\n", DRAWS.1);
    page.push_str("## Distributions\n\n| form | draws | source |\n|---|---|---|\n| `v` | always v | |\n");
    for form in FORMS {
        row(&mut page, &[&format!("`{}`", form.example), form.law, form.source]);
    }
    for part in [BOUNDS, UNSTATED, GROUPS, CLASSES, CORRELATIONS, SAMPLING, EDITING, FITTING] {
        page.push_str(part);
    }
    page
}

/// Every preset with its sources.
fn preset_page() -> String {
    let mut page = format!("# {}\n\n{PRESETS_INTRODUCTION}", PRESETS.1);
    let all = presets();
    let mut sources: Vec<&PresetSource> = Vec::new();
    let mut section = "";
    for preset in &all {
        if preset.section != section {
            section = preset.section;
            let _ = write!(
                page,
                "\n## `{section}`\n\n| preset | what | numbers | says too | lacks |\n|---|---|---|---|---|\n"
            );
        }
        let numbers = preset.numbers.iter().map(|number| {
            let at = sources.iter().position(|known| **known == number.source).unwrap_or_else(|| {
                sources.push(&number.source);
                sources.len() - 1
            });
            let remark = if number.remark.is_empty() { String::new() } else { format!(": {}", number.remark) };
            format!("`{}` {} ({}{remark})", number.key, number.value, at + 1)
        });
        let numbers = numbers.collect::<Vec<_>>().join("; ");
        let name = format!("`{}`", preset.name);
        row(&mut page, &[&name, &preset.what, &numbers, &preset.says.join("; "), &preset.lacks.join("; ")]);
    }
    page.push_str("\n## Sources\n\n| number | source | where | taken over |\n|---|---|---|---|\n");
    for (at, source) in sources.iter().enumerate() {
        row(&mut page, &[&(at + 1).to_string(), &source.what, &source.address, &source.seen]);
    }
    page
}

/// The file of [`KEY_PAGES`] that a section stands in.
fn page_of(section: &RecipeSection) -> &'static str {
    match section.subjects.first() {
        Some(Subject::Wood) => "keys/wood.md",
        Some(Subject::Blister) => "keys/blister.md",
        Some(Subject::Sawtooth | Subject::Mesh) => "keys/parts.md",
        None if ["splits", "output", "output.bin"].contains(&section.path) => "keys/output.md",
        None => "keys/bench.md",
    }
}

fn keys(page: &mut String, section: &RecipeSection) {
    let kind = match (section.settings.is_empty(), section.parameters.is_empty()) {
        (false, true) => " (settings)",
        (true, false) => " (parameters)",
        _ => " (parameters, and a setting)",
    };
    let subjects: Vec<_> = section.subjects.iter().map(|subject| format!("`{}`", subject.name())).collect();
    let subject = if subjects.is_empty() { String::new() } else { format!("Subject {}. ", subjects.join(" or ")) };
    // Writing to a string cannot fail.
    let _ = write!(page, "\n### `{}`{kind}\n\n", section.path);
    wrapped(page, &format!("{subject}{}", tidy(section.doc)));
    page.push('\n');
    page.push_str("| key | meaning | unit | default | range | natural | source |\n|---|---|---|---|---|---|---|\n");
    for [name, cells @ ..] in rows(section) {
        let name = format!("`{name}`");
        row(page, &[&name, &cells[0], &cells[1], &cells[2], &cells[3], &cells[4], &cells[5]]);
    }
}

/// How a number varies by nature, in a few words; nothing where it does not.
pub(super) fn natural(parameter: &Parameter) -> String {
    let text = number_text;
    match parameter.natural {
        Natural::Fixed => String::new(),
        Natural::Uniform { min, max } => format!("{} to {}", text(min), text(max)),
        Natural::LogUniform { min, max } => format!("{} to {}, even in the logarithm", text(min), text(max)),
        Natural::Normal { mean, sd } => format!("normal, {} with sd {}", text(mean), text(sd)),
        Natural::OneOf(values) => values.iter().map(|value| text(*value)).collect::<Vec<_>>().join(" or "),
    }
}

/// What the table of a section says of its keys: name, meaning, unit, default, range, natural variation and source.
fn rows(section: &RecipeSection) -> Vec<[String; 7]> {
    let settings = section.settings.iter().map(|setting| {
        let description = (setting.describe)();
        let (unit, range) = description.unit_and_range.unwrap_or_else(|| (unit(setting.name), description.allowed));
        let default = match description.default {
            Value::Number(number) if number.is_f64() => number_text(number.as_f64().unwrap_or(f64::NAN)),
            other => other.to_string().replace('"', "").replace(',', ", "),
        };
        [setting.name.into(), tidy(setting.doc), unit.into(), default, range, String::new(), setting.source.into()]
    });
    let parameters = section.parameters.iter().map(|parameter| {
        let allowed = range(parameter);
        let whole = if parameter.integer { ", whole" } else { "" };
        [
            parameter.name.into(),
            tidy(parameter.doc),
            allowed.unit.into(),
            number_text(parameter.default),
            format!("{} to {}{whole}", number_text(parameter.min), number_text(parameter.max)),
            natural(parameter),
            parameter.source.into(),
        ]
    });
    let words = alternatives(section.path).map(|alternative| {
        let of: Vec<_> = alternative.of.iter().map(|key| format!("`{key}`")).collect();
        let range = if alternative.is_drawn { "as that of what it stands for" } else { "1 to 5000, a number" };
        [
            alternative.name.into(),
            alternative.doc.into(),
            unit(alternative.name).into(),
            format!("in place of {}", of.join(" and ")),
            range.into(),
            String::new(),
            "data sheets".into(),
        ]
    });
    let cells =
        || [PRESET, PRESET_DOC, "", "none", "names of [presets](presets.md)", "", "data sheets"].map(str::to_owned);
    let preset = (!names(section.path).is_empty()).then(cells);
    settings.chain(parameters).chain(words).chain(preset).collect()
}

/// Adds a paragraph in lines of at most 120 characters.
fn wrapped(page: &mut String, text: &str) {
    let mut length = 0;
    for word in text.split_whitespace() {
        let letters = word.chars().count();
        if length > 0 {
            let fits = length + 1 + letters <= 120;
            page.push(if fits { ' ' } else { '\n' });
            length = if fits { length + 1 } else { 0 };
        }
        page.push_str(word);
        length += letters;
    }
    page.push('\n');
}

fn row(page: &mut String, cells: &[&str]) {
    let cells: Vec<_> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    let _ = writeln!(page, "| {} |", cells.join(" | "));
}
