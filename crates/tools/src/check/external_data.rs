//! ONNX external data: the files of weights that a model keeps beside itself, and the checksum over model and weights.
//!
//! A model of more than 2 GB, or one exported so, holds only its graph and names the files with its weights. Two such
//! models may differ in these files alone, so the checksum of a model covers them.
//!
//! Of onnx.proto3 only the fields that lead to tensors are followed. A protobuf message is a sequence of fields: a tag
//! (`field number * 8 + wire type`), then a varint, eight bytes, four bytes, or a length and as many bytes. Everything
//! that leads to no tensor is skipped. Depth and lengths are bounded, so a hostile file is refused.

use std::collections::BTreeSet;
use std::io::{ErrorKind, Read};
use std::path::Path;

use sha2::{Digest, Sha256};

use super::CheckError;
use dataset::hex;

/// Bytes that are read and hashed at once.
const CHUNK_BYTES: usize = 1 << 20;
/// Most bytes of a model: no message of protobuf has more.
const MAX_MODEL_BYTES: u64 = 1 << 31;
/// Most bytes of a file of weights.
const MAX_WEIGHTS_BYTES: u64 = 1 << 34;
/// What to do about weights that cannot be read.
const ONE_FILE: &str = "export it again, with all its weights in one file";
/// Most messages within messages: far more than anybody exports, and far less than a stack holds.
const MAX_NESTING: usize = 256;
/// Identifier of onnxruntime's own format, behind the first four bytes; such a file names no others.
const ORT_FORMAT: &[u8] = b"ORTM";

/// Messages of onnx.proto3 on the way to a tensor's files.
#[derive(Clone, Copy)]
enum OnnxMessage {
    Model,
    Training,
    Function,
    Graph,
    Node,
    Attribute,
    Sparse,
    Tensor,
    Entry,
}

impl OnnxMessage {
    /// The message in field `number`, where it leads on.
    fn within(self, number: u64) -> Option<Self> {
        match (self, number) {
            (Self::Model, 7) | (Self::Attribute, 6 | 11) | (Self::Training, 1 | 2) => Some(Self::Graph),
            (Self::Model, 20) => Some(Self::Training),
            (Self::Model, 25) => Some(Self::Function),
            (Self::Function, 7) | (Self::Graph, 1) => Some(Self::Node),
            (Self::Function, 11) | (Self::Node, 5) => Some(Self::Attribute),
            (Self::Graph, 5) | (Self::Attribute, 5 | 10) | (Self::Sparse, 1 | 2) => Some(Self::Tensor),
            (Self::Graph, 15) | (Self::Attribute, 22 | 23) => Some(Self::Sparse),
            (Self::Tensor, 13) => Some(Self::Entry),
            _ => None,
        }
    }
}

/// SHA-256 of the model and of the files of weights that it names, one behind the other in the order of their names:
/// what `cat model.onnx weights.data | sha256sum` prints. `None` where the files that it names cannot be told.
///
/// # Errors
/// Where one of them cannot be read.
pub(crate) fn sha256_with_weights(model: &Path) -> Result<Option<String>, CheckError> {
    let name_one = "name an ONNX file with --model";
    let bytes = files::read(model, MAX_MODEL_BYTES).map_err(|e| match e.kind() {
        ErrorKind::NotFound => CheckError::at(model, "there is no such model".into(), name_one),
        _ => CheckError::at(model, format!("it cannot be read: {e}"), name_one),
    })?;
    let Some(names) = weight_files(&bytes) else { return Ok(None) };
    let mut hash = Sha256::new_with_prefix(&bytes);
    let folder = model.parent().unwrap_or(Path::new(""));
    let mut piece = vec![0; if names.is_empty() { 0 } else { CHUNK_BYTES }];
    for name in names {
        let path = folder.join(&name);
        let unreadable = |e: std::io::Error| {
            CheckError::at(&path, format!("weights of {} are not read: {e}", model.display()), ONE_FILE)
        };
        let (mut file, _) = files::open_within(&path, MAX_WEIGHTS_BYTES).map_err(unreadable)?;
        loop {
            match file.read(&mut piece).map_err(unreadable)? {
                0 => break,
                n => hash.update(&piece[..n]),
            }
        }
    }
    Ok(Some(hex(&hash.finalize())))
}

/// The fault of a model whose files of weights cannot be told.
pub(crate) fn no_onnx(model: &Path) -> CheckError {
    CheckError::at(model, "the files of weights that it names cannot be told".into(), ONE_FILE)
}

/// Names of the files of weights, from the model's folder; `None` where the bytes are no ONNX.
fn weight_files(model: &[u8]) -> Option<BTreeSet<String>> {
    let mut found = BTreeSet::new();
    if model.get(4..8) != Some(ORT_FORMAT) {
        follow(model, OnnxMessage::Model, MAX_NESTING, &mut found)?;
    }
    Some(found)
}

/// Notes the files that a message names; `None` where it is broken.
fn follow(mut bytes: &[u8], message: OnnxMessage, left: usize, found: &mut BTreeSet<String>) -> Option<()> {
    let (mut key, mut value) = (&[][..], &[][..]);
    while !bytes.is_empty() {
        let field = varint(&mut bytes)?;
        let content = match field % 8 {
            0 => varint(&mut bytes).map(|_| &[][..])?,
            1 => take(&mut bytes, 8)?,
            2 => {
                let length = varint(&mut bytes)?;
                take(&mut bytes, length)?
            }
            5 => take(&mut bytes, 4)?,
            _ => return None,
        };
        match (message, field / 8, field % 8) {
            (OnnxMessage::Entry, 1, 2) => key = content,
            (OnnxMessage::Entry, 2, 2) => value = content,
            (_, number, 2) => {
                if let Some(inner) = message.within(number) {
                    follow(content, inner, left.checked_sub(1)?, found)?;
                }
            }
            _ => {}
        }
    }
    if matches!(message, OnnxMessage::Entry) && key == b"location" {
        found.insert(std::str::from_utf8(value).ok()?.to_owned());
    }
    Some(())
}

/// A varint: seven bits a byte, the lowest first.
fn varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut found = 0;
    for place in 0..10 {
        let (&byte, rest) = bytes.split_first()?;
        *bytes = rest;
        found |= u64::from(byte & 0x7f) << (7 * place);
        if byte < 0x80 {
            return Some(found);
        }
    }
    None
}

/// The next `count` bytes.
fn take<'b>(bytes: &mut &'b [u8], count: u64) -> Option<&'b [u8]> {
    let (content, rest) = bytes.split_at_checked(usize::try_from(count).ok()?)?;
    *bytes = rest;
    Some(content)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number as the format writes it.
    fn digits(mut number: usize) -> Vec<u8> {
        let mut bytes = Vec::new();
        while number > 127 {
            bytes.push((number % 128) as u8 | 0x80);
            number /= 128;
        }
        bytes.push(number as u8);
        bytes
    }

    /// A field of bytes.
    fn field(number: usize, content: &[u8]) -> Vec<u8> {
        [&digits(8 * number + 2), &digits(content.len()), content].concat()
    }

    /// A tensor that lies in the file `name`, with dimensions, an offset, and numbers of every kind about it.
    fn tensor(name: &str) -> Vec<u8> {
        let entry =
            |key: &str, value: &str| field(13, &[field(1, key.as_bytes()), field(2, value.as_bytes())].concat());
        let plain = [vec![0x08, 0xac, 0x02, 0x45, 1, 2, 3, 4, 0x49, 1, 2, 3, 4, 5, 6, 7, 8], field(8, b"location")];
        [plain.concat(), entry("offset", "16"), entry("location", name), vec![0x70, 1]].concat()
    }

    fn names(model: &[u8]) -> Vec<String> {
        weight_files(model).expect("it is whole").into_iter().collect()
    }

    /// Weights of the graph, of graphs within nodes, of constants, of sparse tensors and of functions are all found,
    /// each file once.
    #[test]
    fn files_are_found_wherever_tensors_are() {
        let constant = field(1, &field(5, &field(5, &tensor("constant"))));
        let branch = field(1, &field(5, &field(6, &field(5, &tensor("branch")))));
        let sparse = field(15, &[field(1, &tensor("a/values")), field(2, &tensor("indices"))].concat());
        let graph = [field(5, &tensor("plain")), field(5, &tensor("plain")), constant, branch, sparse].concat();
        let function = field(25, &field(7, &field(5, &field(10, &tensor("function")))));
        let model = [vec![0x08, 8], field(7, &graph), function].concat();
        assert_eq!(names(&model), ["a/values", "branch", "constant", "function", "indices", "plain"]);
        // What broke off anywhere is no model, or names fewer files; nothing panics.
        for end in 0..model.len() {
            assert!(weight_files(&model[..end]).is_none_or(|names| names.len() < 6), "{end}");
        }
    }

    #[test]
    fn models_in_one_file_name_no_other() {
        for name in ["mean_sign.onnx", "wood_patches.onnx"] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/models").join(name);
            let bytes = std::fs::read(&path).expect("it is there");
            assert!(names(&bytes).is_empty());
            assert_eq!(sha256_with_weights(&path).expect("it is read"), Some(hex(&Sha256::digest(&bytes))));
        }
        assert!(names(b"....ORTM and so on").is_empty());
        for wrong in [&b"\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff"[..], b"\x0a\xff\x01", b"\x0b", b"\x0d12"] {
            assert!(weight_files(wrong).is_none(), "{wrong:?}");
        }
    }

    /// Graphs within graphs without end are refused, not followed down the stack.
    #[test]
    fn depth_ends() {
        let nested = |depth: usize| {
            let graph = (0..depth).fold(field(5, &tensor("deep")), |graph, _| field(1, &field(5, &field(6, &graph))));
            weight_files(&field(7, &graph))
        };
        assert_eq!(nested(80).map(|names| names.len()), Some(1));
        assert!(nested(90).is_none() && nested(2000).is_none());
    }
}
