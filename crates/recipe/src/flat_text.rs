//! A tree as text again: values in a line each, sections in blocks.

use yaml::{YamlNode, YamlValue};

use super::merge::Level;

/// The tree `root` as a text that means the same, a key a line.
pub(super) fn block(root: &YamlNode) -> String {
    let mut text = String::new();
    lines(root, Level::Root, 0, &mut text);
    text
}

/// The entries of a map in lines of their own.
fn lines(node: &YamlNode, level: Level, indent: usize, text: &mut String) {
    let YamlValue::Map(entries) = &node.value else { return };
    for (key, node) in entries {
        let inner = level.inner(&key.name);
        let start = format!("{}{}:", " ".repeat(indent), quoted(&key.name));
        match &node.value {
            YamlValue::Map(map) if inner != Level::Value && !map.is_empty() => {
                let blank = if indent == 0 { "\n" } else { "" };
                *text += &format!("{blank}{start}\n");
                lines(node, inner, indent + 2, text);
            }
            _ => *text += &format!("{start} {}\n", flow(node)),
        }
    }
}

/// A value as YAML in one line.
pub(super) fn flow(node: &YamlNode) -> String {
    match &node.value {
        YamlValue::Nothing => "null".to_owned(),
        YamlValue::Flag(flag) => flag.to_string(),
        YamlValue::Number(number) if number.is_nan() => ".nan".to_owned(),
        YamlValue::Number(number) if number.is_infinite() => if *number > 0.0 { ".inf" } else { "-.inf" }.to_owned(),
        YamlValue::Number(number) => serde_json::json!(number).to_string().trim_end_matches(".0").to_owned(),
        YamlValue::Text(text) => quoted(text),
        YamlValue::List(list) => format!("[{}]", list.iter().map(flow).collect::<Vec<_>>().join(", ")),
        YamlValue::Map(map) => {
            let entries: Vec<_> =
                map.iter().map(|(key, node)| format!("{}: {}", quoted(&key.name), flow(node))).collect();
            format!("{{{}}}", entries.join(", "))
        }
    }
}

/// A text, in quotes where it could be read as something else.
pub(super) fn quoted(text: &str) -> String {
    let word = text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text.bytes().all(|c| c.is_ascii_alphanumeric() || b"_-/.".contains(&c));
    let reserved = ["true", "false", "null", "yes", "no", "on", "off", "y", "n"];
    if word && !reserved.contains(&text.to_ascii_lowercase().as_str()) {
        text.to_owned()
    } else {
        serde_json::json!(text).to_string()
    }
}

#[cfg(test)]
mod tests {
    use yaml::parse_yaml;

    use super::*;

    /// A line of YAML means what the value meant.
    #[test]
    fn values_keep_their_meaning_in_one_line() {
        for value in
            ["30", "1.5e-7", "[1, 2]", "{uniform: [20, 30]}", "'30'", "wood", "\"a: b\"", "true", "'no'", ".inf"]
        {
            let once = flow(&parse_yaml(value, "value").unwrap_or_else(|_| panic!("{value}")));
            let again = flow(&parse_yaml(&once, "value").unwrap_or_else(|_| panic!("{once}")));
            assert_eq!(once, again, "{value}");
        }
        let flow_of = |text: &str| flow(&parse_yaml(text, "value").unwrap_or_else(|_| panic!("{text}")));
        assert_eq!(flow_of("{uniform: [20, 30.50]}"), "{uniform: [20, 30.5]}");
        assert_eq!((flow_of("'30'"), flow_of("30"), flow_of("{}")), ("\"30\"".into(), "30".into(), "{}".into()));
    }
}
