//! `gen completions`: what makes a shell complete commands, options and their values; `gen man`: the manual's pages.

use clap::{Args, Command};
use clap_complete::{Shell, generate};
use clap_mangen::Man;

use super::{CommandResult, DONE, UsageError, print};

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
  gen man export coco > gen-export-coco.1          that of a command")]
pub(super) struct ManArgs {
    /// The command [default: gen itself]
    command: Vec<String>,
}

/// Prints the page of a command.
pub(super) fn manual(arguments: &ManArgs, mut command: Command) -> CommandResult {
    command.build();
    let mut found = &command;
    for name in &arguments.command {
        found = found.find_subcommand(name).ok_or_else(|| {
            let names: Vec<&str> = found.get_subcommands().map(Command::get_name).collect();
            let remedy = if names.is_empty() { "it has none".into() } else { format!("it has {}", names.join(", ")) };
            UsageError(format!("`{}` has no command `{name}`: {remedy}", found.get_name()))
        })?;
    }
    let title = found.get_bin_name().unwrap_or("gen").replace(' ', "-");
    let mut page = Vec::new();
    Man::new(found.clone()).title(title).render(&mut page)?;
    print(&String::from_utf8(page)?)?;
    Ok(DONE)
}
