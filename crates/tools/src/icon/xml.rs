//! XML of iCon files: a tree of elements with attributes and text, written with an indent of two spaces.

use std::fmt::Write;

use quick_xml::escape::{escape, resolve_predefined_entity};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

/// Deepest nesting that is read: cameras nest four deep, and a tree is let go of recursively.
const MAX_DEPTH: usize = 32;
/// Most elements that are read, of which each takes some hundred bytes: cameras write some thousand.
const MAX_ELEMENTS: usize = 500_000;
/// Most attributes of an element that are read, each of which is compared with those before it: cameras write two.
const MAX_ATTRIBUTES: usize = 64;

/// What is wrong, and in which line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct XmlFault {
    /// Line, from 1.
    pub line: usize,
    /// What is wrong.
    pub what: String,
}

/// One element.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct XmlNode {
    /// Its name.
    pub name: String,
    /// Its attributes in order.
    pub attributes: Vec<(String, String)>,
    /// Its own text without surrounding space.
    pub text: String,
    /// Elements within.
    pub children: Vec<XmlNode>,
    /// Line where it begins; 0 where it was not read.
    pub line: usize,
}

impl XmlNode {
    /// An element with elements.
    pub fn new(name: &str, attributes: &[(&str, &str)], children: Vec<Self>) -> Self {
        let attributes = attributes.iter().map(|(name, value)| ((*name).into(), (*value).into())).collect();
        Self { name: name.into(), attributes, children, ..Self::default() }
    }

    /// `<parameter name="...">text</parameter>`.
    pub fn parameter(name: &str, text: &str) -> Self {
        Self { text: text.into(), ..Self::new("parameter", &[("name", name)], Vec::new()) }
    }

    /// An attribute; empty where there is none.
    pub fn attribute(&self, name: &str) -> &str {
        self.attributes.iter().find(|(known, _)| known == name).map_or("", |(_, value)| value)
    }

    /// The first element of a name.
    pub fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }

    /// The parameter of a name; upper and lower case are one, as cameras differ in them.
    pub fn find(&self, name: &str) -> Option<&Self> {
        let named = |child: &&Self| child.name == "parameter" && child.attribute("name").eq_ignore_ascii_case(name);
        self.children.iter().find(named)
    }

    /// As [`XmlNode::find`], or that it is missing.
    pub fn get(&self, name: &str) -> Result<&Self, XmlFault> {
        self.find(name).ok_or_else(|| self.fault(format!("<{}> has no parameter '{name}'", self.name)))
    }

    /// The text as a finite number.
    pub fn number(&self) -> Result<f64, XmlFault> {
        let number = self.text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.fault(format!("'{}' is '{}', which is no number", self.attribute("name"), self.text)))
    }

    /// The text as a count.
    pub fn count(&self) -> Result<usize, XmlFault> {
        let count = self.text.parse().ok();
        count.ok_or_else(|| self.fault(format!("'{}' is '{}', which is no count", self.attribute("name"), self.text)))
    }

    /// Something wrong with this element.
    pub fn fault(&self, what: String) -> XmlFault {
        XmlFault { line: self.line, what }
    }

    /// As text.
    pub fn write(&self) -> String {
        let mut text = String::new();
        self.write_at(0, &mut text);
        text
    }

    fn write_at(&self, depth: usize, text: &mut String) {
        let indent = depth * 2;
        // Writing to a string cannot fail.
        let _ = write!(text, "{:indent$}<{}", "", self.name);
        for (name, value) in &self.attributes {
            let _ = write!(text, " {name}=\"{}\"", escape(value.as_str()));
        }
        let _ = write!(text, ">{}", escape(self.text.as_str()));
        for child in &self.children {
            text.push('\n');
            child.write_at(depth + 1, text);
        }
        if !self.children.is_empty() {
            let _ = write!(text, "\n{:indent$}", "");
        }
        let _ = write!(text, "</{}>", self.name);
    }
}

/// The root element of a document.
pub(super) fn read(text: &str) -> Result<XmlNode, XmlFault> {
    let mut reader = Reader::from_str(text);
    // Elements that are open, from the outermost.
    let mut open: Vec<XmlNode> = Vec::new();
    let (mut lines, mut elements) = (XmlLines { rest: text.as_bytes(), line: 1 }, 0);
    loop {
        let ahead = text.len() - reader.buffer_position() as usize;
        let line = lines.until(ahead);
        let event = reader.read_event().map_err(|error| XmlFault { line, what: error.to_string() })?;
        if matches!(event, Event::Start(_) | Event::Empty(_)) {
            elements += 1;
            if elements > MAX_ELEMENTS {
                return Err(XmlFault { line, what: format!("more than {MAX_ELEMENTS} elements") });
            }
        }
        let done = match event {
            Event::Start(start) => {
                if open.len() >= MAX_DEPTH {
                    return Err(XmlFault { line, what: format!("more than {MAX_DEPTH} elements within each other") });
                }
                open.push(begun(&start, line)?);
                None
            }
            Event::Empty(start) => Some(begun(&start, line)?),
            Event::End(_) => open.pop(),
            Event::Text(part) => {
                add(&mut open, &part);
                None
            }
            Event::CData(part) => {
                add(&mut open, &part);
                None
            }
            Event::GeneralRef(reference) => {
                let name: &str = &reference;
                let known = match reference.resolve_char_ref() {
                    Ok(Some(letter)) => Some(letter.to_string()),
                    _ => resolve_predefined_entity(name).map(String::from),
                };
                let unknown = || XmlFault { line, what: format!("&{name}; is no character that XML knows") };
                add(&mut open, &known.ok_or_else(unknown)?);
                None
            }
            Event::Eof => {
                let what = match open.last() {
                    Some(node) => format!("the file ends within <{}>", node.name),
                    None => "there is no XML element".into(),
                };
                return Err(XmlFault { line, what });
            }
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) => None,
        };
        if let Some(mut node) = done {
            node.text = node.text.trim().into();
            match open.last_mut() {
                Some(parent) => parent.children.push(node),
                None => return Ok(node),
            }
        }
    }
}

/// Counts lines once from the beginning to the end, however often it is asked.
struct XmlLines<'a> {
    /// What was not looked at yet.
    rest: &'a [u8],
    /// Line where that begins, from 1.
    line: usize,
}

impl XmlLines<'_> {
    /// The line at which so many bytes lie ahead; those before are done with.
    fn until(&mut self, ahead: usize) -> usize {
        let (passed, rest) = self.rest.split_at(self.rest.len() - ahead);
        self.line += passed.iter().filter(|byte| **byte == b'\n').count();
        self.rest = rest;
        self.line
    }
}

fn add(open: &mut [XmlNode], text: &str) {
    if let Some(node) = open.last_mut() {
        node.text.push_str(text);
    }
}

fn begun(start: &BytesStart, line: usize) -> Result<XmlNode, XmlFault> {
    let mut node = XmlNode { name: start.name().as_ref().to_string(), line, ..XmlNode::default() };
    for attribute in start.attributes() {
        if node.attributes.len() >= MAX_ATTRIBUTES {
            return Err(XmlFault { line, what: format!("more than {MAX_ATTRIBUTES} attributes of an element") });
        }
        let attribute = attribute.map_err(|error| XmlFault { line, what: error.to_string() })?;
        let value = attribute.normalized_value(XmlVersion::Implicit1_0);
        let value = value.map_err(|error| XmlFault { line, what: error.to_string() })?;
        node.attributes.push((attribute.key.as_ref().to_string(), value.into_owned()));
    }
    Ok(node)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is written is read again, with letters that XML keeps for itself.
    #[test]
    fn trees_come_back() {
        let inner = XmlNode::parameter("a <b> \"c\" & d", "1 < 2 & 'x' > \"y\"");
        let tree =
            XmlNode::new("root", &[("valuetype", ""), ("name", "")], vec![inner, XmlNode::parameter("empty", "")]);
        let mut back = read(&tree.write()).expect("it was just written");
        assert_eq!((back.line, back.children[0].line, back.children[1].line), (1, 2, 3));
        back.line = 0;
        back.children.iter_mut().for_each(|child| child.line = 0);
        assert_eq!(back, tree);
    }

    /// Declarations, comments, CDATA, numbered letters and empty elements are understood.
    #[test]
    fn other_writers_are_understood() {
        let text = "<?xml version='1.0'?>\n<!-- by hand -->\n<r><p name = 'n' > &#49;<![CDATA[2]]>&amp;3 </p><e/></r>";
        let tree = read(text).expect("it is XML");
        assert_eq!((tree.children[0].text.as_str(), tree.children[0].attribute("name")), ("12&3", "n"));
        assert_eq!((tree.line, tree.children[1].name.as_str()), (3, "e"));
    }

    /// Work and memory grow with the length of the text: lines are counted once, and much of anything is refused.
    #[test]
    fn long_texts_take_no_more_work_than_they_are_long() {
        let text = b"\n\none\n";
        let mut lines = XmlLines { rest: text, line: 1 };
        let told: Vec<(usize, usize)> = [6, 5, 5, 1, 0].map(|ahead| (lines.until(ahead), lines.rest.len())).to_vec();
        // Each byte is passed once: what is left is as long as what lies ahead.
        assert_eq!(told, [(1, 6), (2, 5), (2, 5), (3, 1), (4, 0)]);
        let many = format!("<r>{}</r>", "\n<e/>".repeat(200_000));
        let tree = read(&many).expect("it is XML");
        assert_eq!((tree.children.len(), tree.children[199_999].line), (200_000, 200_001));
        let told = |text: &str, what: &str| {
            let fault = read(text).expect_err(what);
            assert!(fault.what.contains(what), "{}", fault.what);
        };
        told(&format!("<r>{}</r>", "<e/>".repeat(MAX_ELEMENTS)), "elements");
        let attributes: String = (0..100_000).map(|n| format!(" a{n}=''")).collect();
        told(&format!("<r{attributes}/>"), "attributes");
    }

    /// Every way of being no XML names its line, and none is a panic.
    #[test]
    fn faults_name_their_line() {
        for (text, line) in
            [("", 1), ("<a>\n<b>\n</a>", 3), ("<a>\n&nothing;</a>", 2), ("<a>\n<b x=1/></a>", 2), ("<a>\n", 2)]
        {
            assert_eq!(read(text).expect_err(text).line, line, "{text:?}");
        }
        let deep = "<a>".repeat(100_000);
        assert!(read(&deep).expect_err("too deep").what.contains("within each other"));
        let whole = XmlNode::parameter("name", "text").write();
        for end in 0..whole.len() {
            assert!(read(&whole[..end]).is_err(), "{end} bytes are no whole element");
        }
    }
}
