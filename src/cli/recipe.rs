//! `gen recipe`: the recipes that are built in, and the text of any.

use clap::{Args, Subcommand};
use serde_json::{Value, json};

use super::console::Console;
use super::{CommandResult, DONE, RecipeArgs, print};
use recipe::Recipe;

#[derive(Debug, Subcommand)]
#[command(after_help = "Examples:
  gen recipe list                                  the recipes that are built in
  gen recipe show wood > mine.yaml                 a copy to change
  gen recipe show wood --set name=steep --set camera.tilt_deg=35 > steep.yaml
  gen recipe show planks --json | jq .camera       everything that the recipe of a dataset means, defaults included")]
pub(super) enum RecipeCommand {
    /// List the recipes that are built in
    List(RecipeListArgs),
    /// Print the text of a recipe
    Show(ShowArgs),
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
}

pub(super) fn run(command: &RecipeCommand, console: &Console) -> CommandResult {
    match command {
        RecipeCommand::List(arguments) => list(arguments),
        RecipeCommand::Show(arguments) => {
            let recipe = arguments.recipe.load(console)?.recipe;
            print(&if arguments.json { recipe.canonical_json() } else { recipe.text().to_owned() })?;
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
