//! The reference of every key, from the same tables; `recipes/README.md` is its committed copy.

use std::fmt::Write;

use serde_json::Value;

use super::distribution::{FORMS, range};
use super::embedded::EMBEDDED;
use super::keys::alternatives::alternatives;
use super::keys::{RecipeSection, SECTIONS, tidy, unit};
use yaml::number_text;

/// What a recipe is.
const OPENING: &str = "\
# Recipes

A recipe is a YAML file that says what a dataset is made of: the bench, the objects, the kinds of samples and what is
written. These are built into the program, so `wood` names the first wherever no file of that name exists; `gen recipe list`
lists them, and `gen recipe show wood > mine.yaml` copies one:

";

/// How one is written.
const WRITING: &str = "
This page is generated from the tables that the program reads recipes with (`BLESS=1 cargo test --test recipe_schema`
writes it again), and so is `recipe.schema.json`, by which editors complete and check a recipe that begins with

    # yaml-language-server: $schema=recipe.schema.json

## How a recipe reads

- `name`, `subject` (`wood`, `blister`, `sawtooth` or `mesh`) and `classes` are required; every other key has a default.
- `family` names the recipes that draw the same random numbers for the same seed; without it, `name` is a family of its own.
- `sampling` and `correlations` say how draws of samples and of keys hang together; without them they don't.
- `set` holds what `--set KEY=VALUE` changed on the command line: key paths with the values that replace those above.
- A section of one subject is a fault in a recipe about another.
- A *setting* is the same for all samples. A *parameter* is drawn for each sample: give a number or a distribution.
- A file is named relative to the recipe's own file, or is one that is built in. Its content is part of what the recipe
  means, and the dataset keeps a copy: give the folder of a dataset in place of a recipe to continue it. The long form
  `{name: part.stl, sha256: ...}` takes the file with that content alone.
- Keys in the words of data sheets (`speed_mm_per_s`, `waist_fwhm_mm`, `working_distance_mm` with `baseline_mm`) stand in place of
  others; of a key and what stands for it, one is given. `gen rig` tells all of them of any recipe.
- A key ends in its unit: mm, um, nm, deg, us, mW, DN (digital numbers), e (electrons). Keys without a unit are counts or
  shares.
- All faults of a recipe are reported at once, each with its line, its key, what is allowed and the nearest right spelling.

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

const BOUNDS: &str = "
Every draw is made again until it lies in the parameter's own range; a distribution with less than 1 % chance of that is a
fault, and so is an end or a value out of range. Counts are rounded to the nearest whole number.

## Correlations

Keys are drawn independently of each other, but for pairs that the recipe names:

```yaml
correlations:
  - {keys: [log.ring_width_mm, log.latewood_share], spearman: -0.6}      # wider rings have less latewood
  - {keys: [laser.waist_mm, laser.m_squared], spearman: 0.4}
```

- `spearman` is the rank correlation of the draws, between -1 and 1. Each key keeps its own distribution and its bounds, exactly;
  keys in no pair keep every draw.
- Keys are named with their section. Both must have a distribution on a scale (no number, choice or count) in at least one class; in
  classes in which one of them has none the pair has no effect.
- Several pairs must be possible together: what is much like a second key, and that much like a third, makes the first like the
  third. Pairs that are not named count as 0. A fault says which pair may be what.

By a Gaussian copula: x_i = F_i^-1(Phi(y_i)) with F_i the distribution function of key i and y normal with the correlations
2 sin(pi spearman / 6) (Pearson 1907; Nelsen 2006). Dependence is monotone; extremes of two keys meet no more often than these make
likely. There are no distributions that depend on another key: such a key would have no range and no law of its own to check, to
report or to validate. Kinds of samples (decayed, then dark) are what classes are for.

## Sampling

| `sampling` | how the samples of a class are drawn |
|---|---|
| `independent` | each by itself; the default |
| `low_discrepancy` | so that they cover the range of each key evenly: of the first n samples of a class, those below any place in the range of a key are their share within log2(n) + 1 samples |

Low discrepancy is for few samples: independent draws miss a share by some sqrt(n) / 2 samples. Points of two keys fill their plane
evenly too, with a tenth of the squared discrepancy of independent draws at n = 64 and 256. All distributions, counts and choices
too, and correlations stay as declared, and any sample can be made alone. Each sample follows from seed, family, class, its rank
within the class and the key paths: editing one key leaves every other draw as it was. A split is even by no more than chance, and
of keys that are correlated only the first by its path is as even as said. The sequences: van der Corput's, scrambled and put in another order for each key (Owen 1995, Burley 2020).

";

const CLASSES: &str = "\
## Classes

`classes` maps names (a-z, 0-9, _) to kinds of samples. Each has a `share`, relative to the other shares (at least a
millionth of their sum), and may repeat any group of parameters with the keys that it changes; settings stay the same for
all classes. Sample i belongs to the class at the point (offset + i / golden ratio) mod 1 of the shares, classes in the
order of their names, so every prefix of a dataset holds each class within a few samples of its share, and the first
hundred samples of a large dataset are the dataset of a hundred. Splits go by the order of the samples of each class: in every
prefix each split holds each class within two samples of its share.

## What stays when a recipe is edited

Each parameter of each sample has a random stream of its own, keyed by the seed, the family, the sample and the key path.
Editing one key leaves every other draw as it was, but of keys that are correlated with it. With `sampling: low_discrepancy` the class
and the rank in it take the place of the sample's number, so that editing classes moves more draws. Recipes of other names draw other numbers, so that no board of one is a board
of another: who trains on one and tests on the other sees nothing twice. To compare two recipes sample by sample, give both one
`family`; then choose another seed for the data that a network is tested on. Class and split of a sample follow from the seed, the
family, its number, the classes with their shares, and `splits`. The identity of a sample (a UUID) follows from the meaning of the
whole recipe, the seed and its number: comments, the order of keys and the way a number is written do not matter, everything else
does.

## What must fit together

- `camera.focal_length_mm` stays below half of `camera.distance_mm`; laser and camera stand above the object.
- `exposure.dark_noise_dn` covers its parts: row noise^2 + row pattern^2 + column pattern^2 + DSNU^2 + 1/12 (rounding) is
  at most its square.
- DN in keys count on the scale of 8 bits (0 to 255) whatever `exposure.bits` is, so that a recipe is one sensor; images,
  frames and Scatter hold the converter's own numbers.
- Under an order of `postprocess` other than `physical` noise is `dark_level_dn` and `dark_noise_dn` alone: the other
  sources of noise and of structure are 0 there, `exposure.hdr` is none and `speckle` has its law alone.
- `scan.columns` times `scan.profiles` is at most 2^27; the bins divide them.
- `extraction.scatter_offset_rows` + `scatter_width_rows` is at most 16, and at most 29 rows are summed, 16 of
  12 bits.
- A key of `extraction` stands only beside the `method` or the `range` that it has an effect on.
- `splits` sum to 1; `rot.edge` is -1 or 1.
- All pockets have room on the card, with their walls, at the distances asked for; `tablet.band_mm` is at most
  `tablet.thickness_mm`.
- `transport` is `kernel` or `path` for blister packs: the other models know no film over air. It is `kernel` for meshes,
  which can overhang.
- `material.gloss` times `reflectance` plus `matte` is at most 1: no surface throws back more light than it gets.
- A key of `transport` stands only beside the model, and `iterations` beside a method, that it has an effect on.

These hold for every draw: a distribution is checked at its ends.
";

const SOURCES: &str = "\
## Sources

[T] Kihl and Källberg 2021, the thesis whose bench this is; [V] vendors' published figures; [M] engineering estimate;
[C] computed or chosen so that the observables come out; [G] statistics of a scanned spruce log (Larsson et al. 2022);
[L] literature named in the project's documentation.
";

/// Every key of a recipe: meaning, unit, default, range and source, in Markdown.
pub fn reference_markdown() -> String {
    let mut page = OPENING.to_owned();
    page.push_str("| recipe | what |\n|---|---|\n");
    for recipe in &EMBEDDED {
        row(&mut page, &[&format!("`{}.yaml`", recipe.name), recipe.summary]);
    }
    page.push_str(WRITING);
    page.push_str("\n## Distributions\n\n");
    page.push_str("| form | draws | source |\n|---|---|---|\n| `v` | always v | |\n");
    for form in FORMS {
        row(&mut page, &[&format!("`{}`", form.example), form.law, form.source]);
    }
    page.push_str(BOUNDS);
    page.push_str("## Keys\n");
    for section in &SECTIONS {
        keys(&mut page, section);
    }
    page.push('\n');
    for part in [CLASSES, SOURCES] {
        page.push_str(part);
        page.push('\n');
    }
    page.truncate(page.trim_end().len());
    page.push('\n');
    page
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
    let _ = write!(page, "\n### `{}`{kind}\n\n{subject}{}\n\n", section.path, tidy(section.doc));
    page.push_str("| key | meaning | unit | default | range | source |\n|---|---|---|---|---|---|\n");
    for setting in section.settings {
        let description = (setting.describe)();
        let (unit, range) = description.unit_and_range.unwrap_or_else(|| (unit(setting.name), description.allowed));
        let default = match description.default {
            Value::Number(number) if number.is_f64() => number_text(number.as_f64().unwrap_or(f64::NAN)),
            other => other.to_string().replace('"', "").replace(',', ", "),
        };
        row(page, &[&format!("`{}`", setting.name), setting.doc, unit, &default, &range, setting.source]);
    }
    for parameter in section.parameters {
        let allowed = range(parameter);
        let whole = if parameter.integer { ", whole" } else { "" };
        row(
            page,
            &[
                &format!("`{}`", parameter.name),
                &tidy(parameter.doc),
                allowed.unit,
                &number_text(parameter.default),
                &format!("{} to {}{whole}", number_text(parameter.min), number_text(parameter.max)),
                parameter.source,
            ],
        );
    }
    rows_of_alternatives(page, section);
}

fn rows_of_alternatives(page: &mut String, section: &RecipeSection) {
    for alternative in alternatives(section.path) {
        let of: Vec<_> = alternative.of.iter().map(|key| format!("`{key}`")).collect();
        let (doc, default) = (alternative.doc, format!("in place of {}", of.join(" and ")));
        let range = if alternative.is_drawn { "as that of what it stands for" } else { "1 to 5000, a number" };
        row(page, &[&format!("`{}`", alternative.name), doc, unit(alternative.name), &default, range, "data sheets"]);
    }
}

fn row(page: &mut String, cells: &[&str]) {
    let cells: Vec<_> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    let _ = writeln!(page, "| {} |", cells.join(" | "));
}
