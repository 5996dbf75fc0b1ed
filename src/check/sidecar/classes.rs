//! The classes of a model, and which classes of the dataset each of them is.

use output_schema::DatasetHead;

use super::{Task, required};
use crate::yaml::fault::nearest;
use crate::yaml::node::{Node, Value};
use crate::yaml::walk::{Walk, clipped};

/// Most classes of a model: 255 stands for none.
const MOST: usize = 254;

/// Names of the model's classes, and the model's class of each class of the dataset.
pub(super) type Classes = (Vec<String>, Vec<Option<usize>>);

/// Reads `classes`.
pub(super) fn read(walk: &mut Walk, node: &Node, task: Task, head: &DatasetHead) -> Option<Classes> {
    let entries = match &node.value {
        Value::List(entries) if (2..=MOST).contains(&entries.len()) => entries,
        Value::List(entries) => {
            let problem = format!("has {} entries", entries.len());
            walk.fault(node.place, "classes", problem, format!("list 2 to {MOST} classes"));
            return None;
        }
        other => {
            walk.fault(node.place, "classes", format!("is {}", other.kind()), "list the model's classes in order");
            return None;
        }
    };
    let known: Vec<(usize, &str)> = match task {
        Task::Samples => head.classes.iter().map(String::as_str).enumerate().collect(),
        _ => head.shown_classes().collect(),
    };
    let last = known.iter().map(|(value, _)| *value).max().unwrap_or(0);
    let (mut names, mut truth) = (Vec::new(), vec![None; last + 1]);
    let mut whole = true;
    for (class, entry) in entries.iter().enumerate() {
        let path = format!("classes[{class}]");
        let Some((name, of)) = entry_of(walk, entry, &path) else {
            whole = false;
            continue;
        };
        if names.contains(&name) {
            walk.fault(
                entry.place,
                &path,
                format!("`{}` stands here twice", clipped(&name)),
                "give each class its own name",
            );
        }
        names.push(name);
        for node in of {
            let Some(text) = walk.text(node, &path, "the name of a class of the dataset") else { continue };
            let Some((value, _)) = known.iter().find(|(_, known)| *known == text) else {
                let all: Vec<&str> = known.iter().map(|(_, name)| *name).collect();
                let kind = if task == Task::Samples { "samples" } else { "pixels" };
                let hint =
                    nearest(text, all.iter().copied()).map_or(String::new(), |m| format!("did you mean `{m}`? "));
                let remedy = format!("{hint}its classes of {kind} are {}; `of: []` for none", all.join(", "));
                walk.fault(node.place, &path, format!("the dataset has no class `{}`", clipped(text)), remedy);
                continue;
            };
            if let Some(other) = truth[*value].replace(class).filter(|&other| other != class) {
                let problem = format!("`{text}` belongs to classes[{other}] already");
                walk.fault(node.place, &path, problem, "name it under one class");
            }
        }
    }
    whole.then_some((names, truth))
}

/// Name of a class and the nodes that name classes of the dataset; a plain text is both.
fn entry_of<'n>(walk: &mut Walk, entry: &'n Node, path: &str) -> Option<(String, Vec<&'n Node>)> {
    if let Value::Text(name) = &entry.value {
        return Some((name.clone(), vec![entry]));
    }
    let mut map = walk.section(entry, path);
    let name = required(walk, &mut map, "name", "the name of the class");
    let name = name.and_then(|node| walk.text(node, &map.path_of("name"), "the name of the class"));
    let of = map.take(walk, "of").map(|node| match &node.value {
        Value::List(entries) => Some(entries.iter().collect()),
        Value::Text(_) => Some(vec![node]),
        other => {
            let remedy = "list the classes of the dataset that it is, `of: [sound_knot, dead_knot]`";
            walk.fault(node.place, &map.path_of("of"), format!("is {}", other.kind()), remedy);
            None
        }
    });
    if of.is_none() {
        let remedy = "list the classes of the dataset that it is, `of: [sound_knot, dead_knot]`";
        walk.fault(map.place(), &map.path_of("of"), "is missing", remedy);
    }
    map.close(walk, &["name", "of"], &|_| None);
    Some((name?.to_owned(), of??))
}
