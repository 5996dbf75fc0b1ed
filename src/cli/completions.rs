//! `gen completions`: what makes a shell complete commands, options and their values.

use std::process::ExitCode;

use clap::{Args, Command};
use clap_complete::{Shell, generate};

use super::{CommandResult, print};

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
    print(&String::from_utf8(script)?);
    Ok(ExitCode::SUCCESS)
}
