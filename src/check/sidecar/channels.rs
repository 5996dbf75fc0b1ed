//! The input channels of a model: which maps, in which unit, and how they are normalised.

use output_schema::DatasetHead;

use super::{Channel, has, number, required};
use crate::yaml::node::{Node, Value};
use crate::yaml::walk::{Range, Walk};

/// Keys of a channel.
pub(super) const KEYS: [&str; 6] = ["name", "unit", "mean", "sd", "missing", "relative"];
const CHANNELS: [&str; 3] = ["range", "reflectance", "scatter"];
const UNITS: [&str; 3] = ["mm", "px", "DN"];

/// Reads `channels`.
pub(super) fn read(walk: &mut Walk, node: &Node, head: &DatasetHead) -> Option<Vec<Channel>> {
    let entries = match &node.value {
        Value::List(entries) if !entries.is_empty() => entries,
        other => {
            let problem = if let Value::List(_) = other { "is empty" } else { "is no list" };
            walk.fault(node.place, "channels", problem, "list the model's input maps in order");
            return None;
        }
    };
    let read: Vec<_> = entries.iter().enumerate().map(|(i, entry)| channel(walk, entry, i, head)).collect();
    read.into_iter().collect()
}

fn channel(walk: &mut Walk, node: &Node, i: usize, head: &DatasetHead) -> Option<Channel> {
    let path = format!("channels[{i}]");
    let short = matches!(node.value, Value::Text(_));
    let mut map = if short { None } else { Some(walk.section(node, &path)) };
    let name = match &mut map {
        None => Some(node),
        Some(map) => required(walk, map, "name", &format!("one of {}", CHANNELS.join(", "))),
    };
    let found = name.and_then(|node| walk.word(node, &path, &CHANNELS));
    if let Some((node, name)) = name.zip(found).filter(|(_, name)| !has(head, name)) {
        let remedy = format!("write `output: {{png: [..., {name}]}}` in the recipe and make the dataset anew");
        walk.fault(node.place, &path, format!("the dataset has no images of `{name}`"), remedy);
    }
    let Some(mut map) = map else {
        unit_of(walk, node, (found?, None), &path, head);
        return Some(Channel { name: found?.into(), mean: 0.0, sd: 1.0, missing: 0.0, relative: false });
    };
    let any = Range { min: -1e9, max: 1e9, whole: false, unit: "" };
    let unit =
        map.take(walk, "unit").map_or(Some(None), |node| walk.word(node, &map.path_of("unit"), &UNITS).map(Some));
    if let Some((name, unit)) = found.zip(unit) {
        unit_of(walk, node, (name, unit), &path, head);
    }
    let mean = number(walk, &mut map, "mean", any, 0.0);
    let sd = number(walk, &mut map, "sd", Range { min: 1e-9, ..any }, 1.0);
    let missing = number(walk, &mut map, "missing", any, 0.0);
    let relative = map.take(walk, "relative").map_or(Some(false), |node| match node.value {
        Value::Flag(flag) => Some(flag),
        _ => {
            walk.fault(node.place, &map.path_of("relative"), format!("is {}", node.value.kind()), "give true or false");
            None
        }
    });
    map.close(walk, &KEYS, &|_| None);
    Some(Channel { name: found?.into(), mean: mean?, sd: sd?, missing: missing?, relative: relative? })
}

/// Faults a channel whose numbers the dataset has in another unit than the model takes.
fn unit_of(walk: &mut Walk, node: &Node, (name, told): (&str, Option<&str>), path: &str, head: &DatasetHead) {
    let (usual, found) = if name == "range" { ("mm", head.range_unit()) } else { ("DN", "DN") };
    let wanted = told.unwrap_or(usual);
    if wanted != found {
        let problem = format!("the model takes `{name}` in {wanted}, the dataset has it in {found}");
        let remedy = match found {
            "px" => "make a dataset whose recipe says `extraction: {range: calibrated}`, or write `unit: px` here where the model was trained on sensor rows".into(),
            _ => format!("write `unit: {found}` here where the model was trained on that, or name another dataset"),
        };
        walk.fault(node.place, path, problem, remedy);
    }
}
