//! `gen completions`: what makes a shell complete commands, options and their values; `gen man`: the manual's pages.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::{Shell, generate};
use clap_mangen::Man;

use super::{CommandResult, DONE, UsageError, output, print};

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen completions bash > ~/.local/share/bash-completion/completions/gen
  gen completions zsh > ~/.zfunc/_gen              with fpath+=~/.zfunc before compinit
  gen completions fish > ~/.config/fish/completions/gen.fish")]
pub(super) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

pub(super) fn run(arguments: &CompletionsArgs, command: &mut Command) -> CommandResult {
    let mut script = Vec::new();
    generate(arguments.shell, command, "gen", &mut script);
    print(&String::from_utf8(script)?)?;
    Ok(DONE)
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen man | man -l -                               the page of gen itself
  gen man export coco > gen-export-coco.1          that of a command
  gen man --all ~/.local/share/man/man1            those of all commands, for `man gen-export-coco`")]
pub(super) struct ManArgs {
    /// The command [default: gen itself]
    #[arg(conflicts_with = "out")]
    command: Vec<String>,
    /// Write the pages of all commands into this folder
    #[arg(id = "out", long = "all", value_name = "DIR", value_parser = output::folder())]
    all: Option<PathBuf>,
}

/// Prints the page of a command, or writes all.
pub(super) fn manual(arguments: &ManArgs, mut command: Command) -> CommandResult {
    command.build();
    if let Some(folder) = &arguments.all {
        let remedy = "name a folder that is there and can be written with --all";
        for command in with_commands_below(&command) {
            output::write_or(&folder.join(format!("{}.1", title(command))), &page(command)?, remedy)?;
        }
        return Ok(DONE);
    }
    let mut found = &command;
    for name in &arguments.command {
        found = found.find_subcommand(name).ok_or_else(|| {
            let names: Vec<&str> = found.get_subcommands().map(Command::get_name).collect();
            let remedy = if names.is_empty() { "it has none".into() } else { format!("it has {}", names.join(", ")) };
            UsageError(format!("`{}` has no command `{name}`: {remedy}", found.get_name()))
        })?;
    }
    print(&String::from_utf8(page(found)?)?)?;
    Ok(DONE)
}

/// A command and all below it, but for those that only print help.
fn with_commands_below(command: &Command) -> Vec<&Command> {
    let below = command.get_subcommands().filter(|below| below.get_name() != "help");
    std::iter::once(command).chain(below.flat_map(with_commands_below)).collect()
}

fn title(command: &Command) -> String {
    command.get_bin_name().unwrap_or("gen").replace(' ', "-")
}

/// The page of a command [bytes of roff].
fn page(command: &Command) -> std::io::Result<Vec<u8>> {
    let mut page = Vec::new();
    Man::new(command.clone()).title(title(command)).render(&mut page)?;
    Ok(page)
}
