//! iCon file layout: the planes of a file in order, read from XML and written to XML.

use super::traits::Traits;
use super::xml::{XmlFault, XmlNode};
use super::{IconScan, SensorImage};

/// Most subcomponents of a component: cameras write seven at most, and each is asked for with every part of a scan.
const MAX_PLANES: usize = 64;

/// Type of a plane's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NumberType {
    /// 8 bits.
    Byte,
    /// 16 bits.
    Word,
    /// 32 bits.
    Int,
    /// Single precision.
    Float,
}

impl NumberType {
    const ALL: [Self; 4] = [Self::Byte, Self::Word, Self::Int, Self::Float];

    /// Value type in XML.
    pub fn name(self) -> &'static str {
        match self {
            Self::Byte => "BYTE",
            Self::Word => "WORD",
            Self::Int => "INT",
            Self::Float => "FLOAT",
        }
    }

    /// Bytes of one number.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Byte => 1,
            Self::Word => 2,
            Self::Int | Self::Float => 4,
        }
    }
}

/// What a plane holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaneContent {
    /// Place along the line of each height of a calibrated scan [mm].
    RangeX,
    /// Heights.
    Range,
    /// Light at the peak, as the camera names it in uncalibrated scans [DN].
    Intensity,
    /// Light at the peak, as it names it beside laser scatter [DN].
    Reflectance,
    /// Light beside the peak: BYTE where the camera scaled it down, else WORD, sums as they are [DN].
    Scatter,
    /// Notes of each profile.
    Mark,
    /// An exposure [DN].
    Image,
    /// Something that is stepped over.
    Other,
}

impl PlaneContent {
    /// What is known, its name in XML, and the types that it may have.
    const KNOWN: [(Self, &'static str, &'static [NumberType]); 8] = [
        // Of other types nothing says what they mean: these are stepped over.
        (Self::RangeX, "Range X", &[NumberType::Float]),
        (Self::Range, "Range", &[NumberType::Word, NumberType::Float]),
        (Self::Range, "Range R", &[NumberType::Word, NumberType::Float]),
        (Self::Intensity, "Intensity", &[NumberType::Byte]),
        (Self::Reflectance, "Reflectance", &[NumberType::Byte]),
        (Self::Scatter, "Scatter", &[NumberType::Byte, NumberType::Word]),
        (Self::Mark, "Mark", &[NumberType::Int]),
        (Self::Image, "Image", &[NumberType::Byte]),
    ];

    fn named(name: &str) -> Self {
        let known = Self::KNOWN.iter().find(|(_, known, _)| known.eq_ignore_ascii_case(name));
        known.map_or(Self::Other, |(part, ..)| *part)
    }

    /// Name in XML.
    pub fn name(self) -> &'static str {
        Self::KNOWN.iter().find(|(part, ..)| *part == self).map_or("", |(_, name, _)| name)
    }

    /// The types that it may have.
    fn kinds(self) -> &'static [NumberType] {
        Self::KNOWN.iter().find(|(part, ..)| *part == self).map_or(&NumberType::ALL, |(.., kinds)| kinds)
    }
}

/// One subcomponent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Plane {
    pub part: PlaneContent,
    pub kind: NumberType,
    /// Numbers in a row.
    pub width: usize,
    /// Bytes of one row of all planes before it.
    pub before: usize,
}

impl Plane {
    /// Bytes of one of its rows.
    pub fn line(&self) -> usize {
        self.width * self.kind.bytes()
    }
}

/// A component that can be read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Component {
    Scan(Traits),
    SensorImage {
        rows: usize,
        /// Where the region begins on the sensor: column, row [px].
        offset: [u32; 2],
        plane: Plane,
    },
}

/// Everything that the XML says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FileLayout {
    pub subject: Component,
    /// Planes of the component that is read, in order.
    pub planes: Vec<Plane>,
    /// Names and types of planes that are stepped over.
    pub unused: Vec<String>,
    /// Bytes of one row of all planes of all components.
    pub line: usize,
    /// Whether all rows of a plane lie together (layout SUBCOMPONENT), not all planes of a row (SCAN).
    pub planar: bool,
}

impl FileLayout {
    /// The layout of a scan.
    pub fn of(scan: &IconScan) -> Self {
        let mut line = 0;
        let mut planes = Vec::new();
        for (part, numbers) in &scan.planes {
            let width = if *part == PlaneContent::Mark { 5 } else { scan.width };
            let plane = Plane { part: *part, kind: numbers.kind(), width, before: line };
            line += plane.line();
            planes.push(plane);
        }
        Self { subject: Component::Scan(scan.traits), planes, unused: Vec::new(), line, planar: true }
    }

    /// The layout of a sensor image.
    pub fn of_image(image: &SensorImage) -> Self {
        let &SensorImage { cols, rows, offset, .. } = image;
        let plane = Plane { part: PlaneContent::Image, kind: NumberType::Byte, width: cols, before: 0 };
        let subject = Component::SensorImage { rows, offset, plane };
        Self { subject, planes: vec![plane], unused: Vec::new(), line: cols, planar: false }
    }

    /// Columns: planes of pixels all have as many.
    pub fn width(&self) -> usize {
        let wide = |plane: &&Plane| matches!(plane.part, PlaneContent::Range | PlaneContent::Image);
        self.planes.iter().find(wide).map_or(0, |plane| plane.width)
    }

    /// As XML.
    pub fn write(&self) -> String {
        let parameter = |name: &str, count: usize| XmlNode::parameter(name, &count.to_string());
        let layout = XmlNode::parameter("layout", if self.planar { "SUBCOMPONENT" } else { "SCAN" });
        let words = self.planes.iter().any(|plane| plane.part == PlaneContent::Range && plane.kind == NumberType::Word);
        let (root, size, height, mut inner, component) = match &self.subject {
            Component::Scan(traits) => {
                let component = [("valuetype", "Hi3D"), ("name", "Ranger3Range")];
                ([("valuetype", ""), ("name", "")], self.line, 1, traits.nodes(self.width(), words), component)
            }
            Component::SensorImage { rows, offset, .. } => {
                let traits = vec![
                    parameter("size x", self.width()),
                    parameter("size y", *rows),
                    parameter("offset x", offset[0] as usize),
                    parameter("offset y", offset[1] as usize),
                ];
                let component = [("valuetype", "image"), ("name", "Ranger3Image")];
                let root = [("valuetype", "IMAGE"), ("name", "IMAGE")];
                (root, self.line * rows, *rows, vec![XmlNode::new("imagetraits", &[], traits)], component)
            }
        };
        inner.extend(self.planes.iter().map(|plane| {
            let attributes = [("valuetype", plane.kind.name()), ("name", plane.part.name())];
            let children = vec![parameter("size", plane.line()), parameter("width", plane.width)];
            XmlNode::new("subcomponent", &attributes, children)
        }));
        let mut children = vec![parameter("size", self.line), parameter("height", height)];
        children.append(&mut inner);
        let component = XmlNode::new("component", &component, children);
        let children = vec![parameter("size", size), XmlNode::parameter("version", "1"), layout, component];
        XmlNode::new("icon_data_format", &root, children).write()
    }

    /// From the root element.
    pub fn read(root: &XmlNode) -> Result<Self, XmlFault> {
        if root.name != "icon_data_format" {
            return Err(root.fault(format!("its root is <{}>, not <icon_data_format>", root.name)));
        }
        let version = root.get("version")?;
        if version.text != "1" {
            return Err(version.fault(format!("its version is '{}', and only 1 is known", version.text)));
        }
        let layout = root.get("layout")?;
        let planar = match layout.text.as_str() {
            "SUBCOMPONENT" => true,
            "SCAN" => false,
            other => return Err(layout.fault(format!("its layout is '{other}', neither SUBCOMPONENT nor SCAN"))),
        };
        let mut line = 0;
        let mut found: Option<(&XmlNode, Vec<Plane>)> = None;
        let mut unused = Vec::new();
        for component in root.children.iter().filter(|child| child.name == "component") {
            let (planes, names) = planes(component, &mut line)?;
            let holds = planes.iter().any(|plane| matches!(plane.part, PlaneContent::Range | PlaneContent::Image));
            let is_read = holds && found.is_none();
            let is_calibrated = component.child("worldrangetraits").is_some();
            for (plane, name) in planes.iter().zip(names) {
                let is_used = match plane.part {
                    PlaneContent::Other => false,
                    PlaneContent::RangeX => is_read && is_calibrated,
                    _ => is_read,
                };
                if !is_used {
                    unused.push(format!("{name} {}", plane.kind.name()));
                }
            }
            if is_read {
                found = Some((component, planes));
            }
        }
        let none = || root.fault("no component has a subcomponent 'Range' or 'Image'".into());
        let (component, planes) = found.ok_or_else(none)?;
        let image = planes.iter().find(|plane| plane.part == PlaneContent::Image);
        let subject = match image {
            Some(plane) => image_subject(component, *plane)?,
            None => {
                let size = root.get("size")?;
                if size.count()? != line {
                    let what = format!("it says {} bytes a row, but its subcomponents take {line}", size.text);
                    return Err(size.fault(what));
                }
                let width =
                    planes.iter().find(|plane| plane.part == PlaneContent::Range).map_or(0, |plane| plane.width);
                Component::Scan(Traits::read(component, width)?)
            }
        };
        Ok(Self { subject, planes, unused, line, planar })
    }
}

fn image_subject(component: &XmlNode, plane: Plane) -> Result<Component, XmlFault> {
    let rows = component.get("height")?.count()?;
    let traits = component.child("imagetraits");
    let offset = |name| {
        let Some(node) = traits.and_then(|traits| traits.find(name)) else { return Ok(0) };
        u32::try_from(node.count()?).map_err(|_| node.fault(format!("'{name}' is beyond any sensor")))
    };
    Ok(Component::SensorImage { rows, offset: [offset("offset x")?, offset("offset y")?], plane })
}

/// The subcomponents of a component with their names; `line` grows by their bytes.
fn planes<'a>(component: &'a XmlNode, line: &mut usize) -> Result<(Vec<Plane>, Vec<&'a str>), XmlFault> {
    let (mut planes, mut names): (Vec<Plane>, Vec<&str>) = (Vec::new(), Vec::new());
    for node in component.children.iter().filter(|child| child.name == "subcomponent") {
        if planes.len() >= MAX_PLANES {
            return Err(node.fault(format!("the component has more than {MAX_PLANES} subcomponents")));
        }
        let (name, kind) = (node.attribute("name"), node.attribute("valuetype"));
        let part = PlaneContent::named(name);
        let known = NumberType::ALL.into_iter().find(|known| known.name() == kind);
        let kind = known.ok_or_else(|| node.fault(format!("'{name}' is {kind}, not BYTE, WORD, INT or FLOAT")))?;
        let part = if part == PlaneContent::RangeX && kind != NumberType::Float { PlaneContent::Other } else { part };
        if !part.kinds().contains(&kind) {
            return Err(node.fault(format!("'{name}' is {}, which it never is", kind.name())));
        }
        let (size, width) = (node.get("size")?.count()?, node.get("width")?.count()?);
        if width == 0 || width.checked_mul(kind.bytes()) != Some(size) {
            return Err(node.fault(format!("'{name}' has {width} numbers of {} bytes in {size} bytes", kind.bytes())));
        }
        if part == PlaneContent::Mark && !matches!(width, 2 | 5) {
            return Err(node.fault(format!("'{name}' has {width} numbers, neither 2 nor 5")));
        }
        if part != PlaneContent::Other && planes.iter().any(|plane| plane.part == part) {
            return Err(node.fault(format!("'{name}' is there twice")));
        }
        planes.push(Plane { part, kind, width, before: *line });
        names.push(name);
        *line = line.checked_add(size).ok_or_else(|| node.fault("its rows are beyond any memory".into()))?;
    }
    let wide = planes.iter().find(|plane| matches!(plane.part, PlaneContent::Range | PlaneContent::Image));
    let mut pixels = planes.iter().filter(|plane| !matches!(plane.part, PlaneContent::Mark | PlaneContent::Other));
    if let Some(wide) = wide
        && let Some(other) = pixels.find(|other| other.width != wide.width)
    {
        let (name, second) = (wide.part.name(), other.part.name());
        return Err(component.fault(format!("{name} is {} wide, {second} is {}", wide.width, other.width)));
    }
    Ok((planes, names))
}
