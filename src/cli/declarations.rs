//! `gen schema commands`: every command with its arguments, from which the functions of the Python package are made.

use std::any::TypeId;
use std::path::PathBuf;

use clap::{Arg, ArgAction, Command};
use serde_json::{Value, json};

/// Commands that are for a terminal or a browser alone.
const FOR_PEOPLE: [&str; 4] = ["completions", "help", "man", "tune"];

/// Every command of the program, those with commands below them by these alone.
pub(super) fn commands(mut program: Command) -> Value {
    program.build();
    let mut found = vec![declaration(&program, &["generate"])];
    below(&program, &[], &mut found);
    Value::Array(found)
}

fn below<'a>(command: &'a Command, path: &[&'a str], found: &mut Vec<Value>) {
    for command in command.get_subcommands().filter(|command| !FOR_PEOPLE.contains(&command.get_name())) {
        let path: Vec<&str> = path.iter().copied().chain([command.get_name()]).collect();
        if command.has_subcommands() {
            below(command, &path, found);
        } else {
            found.push(declaration(command, &path));
        }
    }
}

fn declaration(command: &Command, path: &[&str]) -> Value {
    let about = command.get_about().map(ToString::to_string);
    // What is said on the terminal is no matter of what a command does.
    let own = |argument: &&Arg| !argument.is_hide_set() && !argument.is_global_set();
    let arguments: Vec<Value> = command.get_arguments().filter(own).filter_map(argument).collect();
    json!({ "command": path, "about": about, "arguments": arguments })
}

/// An argument; `None` for those that print help or the version.
fn argument(argument: &Arg) -> Option<Value> {
    let many = match argument.get_action() {
        ArgAction::Help | ArgAction::HelpShort | ArgAction::HelpLong | ArgAction::Version => return None,
        ArgAction::Append => true,
        _ => argument.get_num_args().is_some_and(|count| count.max_values() > 1),
    };
    let is_flag = matches!(argument.get_action(), ArgAction::SetTrue);
    let values = argument.get_possible_values();
    let words: Vec<&str> = values.iter().map(clap::builder::PossibleValue::get_name).collect();
    let defaults: Vec<_> = argument.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    Some(json!({
        "name": argument.get_id().as_str(),
        "option": argument.get_long().map(|long| format!("--{long}")),
        "doc": argument.get_help().map(ToString::to_string),
        "type": if is_flag { "flag" } else { type_name(argument) },
        "many": many && !is_flag,
        "required": argument.is_required_set(),
        "words": if is_flag { Vec::new() } else { words },
        "default": if is_flag { Vec::new() } else { defaults },
    }))
}

fn type_name(argument: &Arg) -> &'static str {
    let found = argument.get_value_parser().type_id();
    let is = |types: &[TypeId]| types.iter().any(|known| found == *known);
    if is(&[TypeId::of::<u64>(), TypeId::of::<usize>(), TypeId::of::<u32>(), TypeId::of::<u16>()]) {
        "whole"
    } else if is(&[TypeId::of::<f64>(), TypeId::of::<f32>()]) {
        "number"
    } else if is(&[TypeId::of::<PathBuf>()]) {
        "path"
    } else {
        "text"
    }
}
