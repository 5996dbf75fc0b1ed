//! YAML files, read strictly: a tree in which every value knows its place, a reader that takes keys and values from it,
//! and faults, each with line, key and remedy. Nothing here knows what a file means.

mod fault;
mod node;
mod reader;

pub use fault::{YamlFault, YamlFaults};

pub use fault::nearest_spelling;
pub use node::{MAX_FILE_BYTES, TextPosition, YamlError, YamlKey, YamlNode, YamlValue, parse_yaml};
pub use reader::{
    Mapping, NumberRange, YamlReader, clipped_text, number_text, read_bytes, read_bytes_or_standard_input, utf8_text,
};
