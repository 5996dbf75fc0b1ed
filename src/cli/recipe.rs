//! `gen recipe`: the recipes that are built in, the text of any, a first one, and presets.

use base::Words;
use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand};
use serde_json::{Value, json};

use super::console::Console;
use super::{CommandResult, DONE, RecipeArgs, print};
use recipe::{Preset, PresetSource, Recipe, Subject, presets};

#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:
  gen recipe list                                  the recipes that are built in
  gen recipe new --subject blister > mine.yaml     a first recipe of 20 lines, to change
  gen recipe presets                               data sheets of cameras, lasers, films, ...
  gen recipe show wood > mine.yaml                 a copy to change
  gen recipe show wood --set name=steep --set camera.tilt_deg=35 > steep.yaml
  gen recipe show pine.yaml --flat                 the same text with what it inherits from others
  gen recipe show planks --json | jq .camera       everything that the recipe of a dataset means, defaults included")]
pub(super) enum RecipeCommand {
    /// List the recipes that are built in
    List(RecipeListArgs),
    /// Print the text of a recipe
    Show(ShowArgs),
    /// Print a first recipe, to be changed: at most 20 lines with comments
    New(NewArgs),
    /// List the presets: what data sheets say of cameras, lasers and materials, with sources
    Presets(RecipeListArgs),
}

#[derive(Debug, Args)]
pub(super) struct RecipeListArgs {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
pub(super) struct ShowArgs {
    #[command(flatten)]
    recipe: RecipeArgs,
    /// Print everything that it means, defaults included, as JSON, which is a recipe too
    #[arg(long)]
    json: bool,
    /// Print one text of what it states and what it inherits
    #[arg(long, conflicts_with = "json")]
    flat: bool,
}

#[derive(Debug, Args)]
pub(super) struct NewArgs {
    /// What the objects are
    #[arg(long, value_parser = PossibleValuesParser::new(Subject::NAMES))]
    subject: String,
}

pub(super) fn run(command: &RecipeCommand, console: &Console) -> CommandResult {
    match command {
        RecipeCommand::List(arguments) => list(arguments),
        RecipeCommand::New(arguments) => {
            let subject = Subject::named(&arguments.subject).ok_or("the subject is none of those that are known")?;
            print(Recipe::first(subject))?;
            Ok(DONE)
        }
        RecipeCommand::Presets(arguments) => list_presets(arguments),
        RecipeCommand::Show(arguments) => {
            let recipe = arguments.recipe.load(console)?.recipe;
            let text = if arguments.flat { recipe.text() } else { recipe.written() };
            print(&if arguments.json { recipe.canonical_json() } else { text.to_owned() })?;
            Ok(DONE)
        }
    }
}

fn list(arguments: &RecipeListArgs) -> CommandResult {
    let mut documents = Vec::new();
    for known in Recipe::embedded() {
        let recipe = Recipe::load(known.name)?;
        let size = recipe.size();
        if arguments.json {
            documents.push(json!({
                "name": known.name,
                "summary": known.summary,
                "subject": recipe.subject().name(),
                "columns": size.columns,
                "profiles": size.profiles,
                "classes": recipe.classes().iter().map(|class| class.name.as_str()).collect::<Vec<_>>(),
            }));
        } else {
            let size = format!("{} x {}", size.columns, size.profiles);
            print(&format!("{:16} {:9} {size:>11}  {}\n", known.name, recipe.subject().name(), known.summary))?;
        }
    }
    if arguments.json {
        print(&format!("{:#}\n", Value::Array(documents)))?;
    }
    Ok(DONE)
}

fn list_presets(arguments: &RecipeListArgs) -> CommandResult {
    if arguments.json {
        let documents: Vec<Value> = presets().iter().map(preset_json).collect();
        print(&format!("{:#}\n", Value::Array(documents)))?;
        return Ok(DONE);
    }
    for preset in presets() {
        print(&preset_lines(&preset))?;
    }
    Ok(DONE)
}

/// What a preset says, in lines: its numbers, then their sources.
fn preset_lines(preset: &Preset) -> String {
    let mut text = format!("{}: {{preset: {}}}  {}\n", preset.section, preset.name, preset.what);
    let mut sources: Vec<&PresetSource> = Vec::new();
    for number in &preset.numbers {
        let at = sources.iter().position(|known| **known == number.source).unwrap_or_else(|| {
            sources.push(&number.source);
            sources.len() - 1
        });
        let remark = if number.remark.is_empty() { String::new() } else { format!(" {}", number.remark) };
        text += &format!("  {}: {}  # [{}]{remark}\n", number.key, number.value, at + 1);
    }
    for (word, list) in [("says", &preset.says), ("lacks", &preset.lacks)] {
        if !list.is_empty() {
            text += &format!("  {word}: {}\n", list.join("; "));
        }
    }
    for (at, PresetSource { what, address, seen }) in sources.iter().enumerate() {
        let address = if address.is_empty() { String::new() } else { format!(", {address}") };
        text += &format!("  [{}] {what}{address}, taken over {seen}\n", at + 1);
    }
    text
}

fn preset_json(preset: &Preset) -> Value {
    let numbers = preset.numbers.iter().map(|number| {
        json!({
            "key": number.key,
            "value": number.value,
            "remark": number.remark,
            "source": number.source.what,
            "address": number.source.address,
            "seen": number.source.seen,
        })
    });
    json!({
        "section": preset.section,
        "name": preset.name,
        "what": preset.what,
        "numbers": numbers.collect::<Vec<_>>(),
        "says": preset.says,
        "lacks": preset.lacks,
    })
}
