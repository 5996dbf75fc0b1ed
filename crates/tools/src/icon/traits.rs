//! Range traits of iCon files: what columns and numbers of a scan mean, and the XML elements that say so.

use super::xml::{XmlFault, XmlNode};

/// Steps of Range in a sensor row.
const STEPS_PER_ROW: f64 = 16.0;
/// Steps between the lower and the upper bound of a calibrated WORD.
const WORD_STEPS: f64 = 65534.0;

/// The element beside Range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Traits {
    /// Uncalibrated: places on the sensor.
    Sensor(SensorTraits),
    /// Calibrated: places in the world.
    World(WorldTraits),
}

/// Place on the sensor = value * scale + origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorTraits {
    /// Rows of the region that was searched for the peak [px].
    pub region_rows: u32,
    /// Where the region begins on the sensor: column, row [px].
    pub origin: [f64; 2],
    /// Columns in a pixel of the scan, and rows in a step of Range: 1 and 1/16, or -1/16 where rows count upwards [px].
    pub scale: [f64; 2],
}

/// A box around everything that was measured, on an even grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldTraits {
    /// Least place along the line, least height [mm].
    pub lower: [f64; 2],
    /// Largest place along the line, largest height [mm].
    pub upper: [f64; 2],
    /// Distance between two profiles, where the file says it [mm].
    pub row_mm: Option<f64>,
}

impl SensorTraits {
    /// A region of the sensor with rows that count downwards.
    pub fn new(region_rows: u32, origin: [f64; 2]) -> Self {
        Self { region_rows, origin, scale: [1.0, 1.0 / STEPS_PER_ROW] }
    }
}

impl WorldTraits {
    /// Distance between two columns [mm].
    pub fn col_mm(&self, width: usize) -> f64 {
        (self.upper[0] - self.lower[0]) / width as f64
    }

    /// Height of one step of a WORD Range [mm].
    pub fn step_mm(&self) -> f64 {
        (self.upper[1] - self.lower[1]) / WORD_STEPS
    }
}

impl Traits {
    /// Height of a WORD of Range [mm], or its sensor row [px] where uncalibrated; NaN for 0, which is missing.
    pub fn height(&self, steps: u16) -> f64 {
        let n = f64::from(steps);
        match self {
            _ if steps == 0 => f64::NAN,
            Self::Sensor(sensor) => n * sensor.scale[1] + sensor.origin[1],
            Self::World(world) => world.lower[1] + (n - 1.0) * world.step_mm(),
        }
    }

    /// The step of [`Traits::height`] nearest to a height; 0 for NaN.
    pub fn steps(&self, height: f64) -> u16 {
        let n = match self {
            Self::Sensor(sensor) => (height - sensor.origin[1]) / sensor.scale[1],
            Self::World(world) if world.step_mm() > 0.0 => 1.0 + (height - world.lower[1]) / world.step_mm(),
            Self::World(_) => 1.0,
        };
        if n.is_nan() { 0 } else { n.round().clamp(1.0, f64::from(u16::MAX)) as u16 }
    }

    /// The XML elements of a scan of `width` columns; `words` tells whether Range is WORD.
    pub(super) fn nodes(&self, width: usize, words: bool) -> Vec<XmlNode> {
        let number = |(name, value): (&str, f64)| XmlNode::parameter(name, &value.to_string());
        match self {
            Self::Sensor(sensor) => {
                let right = width.saturating_sub(1) as f64;
                let last = (f64::from(sensor.region_rows) / sensor.scale[1].abs() - 1.0).round();
                let numbers = [
                    ("fov x0", 0.0),
                    ("fov x1", right),
                    ("fov x2", 0.0),
                    ("fov x3", right),
                    ("fov z0", 1.0),
                    ("fov z1", 1.0),
                    ("fov z2", last),
                    ("fov z3", last),
                    ("origin x", sensor.origin[0]),
                    ("scale x", sensor.scale[0]),
                    ("origin z", sensor.origin[1]),
                    ("scale z", sensor.scale[1]),
                ];
                let children = numbers.map(number).to_vec();
                vec![XmlNode::new("sensorrangetraits", &[], children)]
            }
            Self::World(world) => {
                let numbers = [
                    ("lower bound x", world.lower[0]),
                    ("lower bound R", world.lower[1]),
                    ("upper bound x", world.upper[0]),
                    ("upper bound R", world.upper[1]),
                ];
                let mut children = numbers.map(number).to_vec();
                children.push(XmlNode::parameter("coordinate unit", ""));
                let mut nodes = vec![XmlNode::new("worldrangetraits", &[], children)];
                nodes.extend(world.row_mm.map(|row_mm| stream_traits(world, row_mm, width, words)));
                nodes
            }
        }
    }

    /// Reads the element of a component.
    pub(super) fn read(component: &XmlNode, width: usize) -> Result<Self, XmlFault> {
        if let Some(node) = component.child("worldrangetraits") {
            let stream = component.child("genistreamtraits");
            let row_mm =
                stream.and_then(|stream| stream.find("b axis range scale")).map(XmlNode::number).transpose()?;
            let lower = [node.get("lower bound x")?.number()?, node.get("lower bound R")?.number()?];
            let upper = [node.get("upper bound x")?.number()?, node.get("upper bound R")?.number()?];
            if lower[0] > upper[0] || lower[1] > upper[1] {
                return Err(node.fault(format!("lower bounds {lower:?} lie above upper bounds {upper:?}")));
            }
            return Ok(Self::World(WorldTraits { lower, upper, row_mm }));
        }
        let missing = || component.fault("neither worldrangetraits nor sensorrangetraits say what Range means".into());
        let node = component.child("sensorrangetraits").ok_or_else(missing)?;
        let scale = [node.get("scale x")?.number()?, node.get("scale z")?.number()?];
        let rows = ((node.get("fov z2")?.number()? + 1.0) * scale[1].abs()).round();
        if scale[1] == 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&rows) {
            return Err(node.fault(format!("its scale z {} and fov z2 make {rows} sensor rows", scale[1])));
        }
        let right = node.get("fov x1")?.number()?;
        if right + 1.0 != width as f64 {
            return Err(node.fault(format!("its fov x1 is {right}, but Range is {width} wide")));
        }
        let origin = [node.get("origin x")?.number()?, node.get("origin z")?.number()?];
        Ok(Self::Sensor(SensorTraits { region_rows: rows as u32, origin, scale }))
    }
}

/// What newer cameras add: scale and offset of each axis, among them the distance between profiles.
fn stream_traits(world: &WorldTraits, row_mm: f64, width: usize, words: bool) -> XmlNode {
    let (c_scale, c_offset) = if words {
        // The first step is 1, which means the lower bound.
        (world.step_mm(), world.lower[1] - world.step_mm())
    } else {
        (1.0, 0.0)
    };
    let axis = |name: &str, what: &str, value: f64| {
        XmlNode::parameter(&format!("{name} axis range {what}"), &value.to_string())
    };
    let children = vec![
        XmlNode::parameter("region id", "scan 3d extraction 1"),
        XmlNode::parameter("extraction method", "hi 3d"),
        XmlNode::parameter("output mode", "rectified c"),
        axis("a", "scale", world.col_mm(width)),
        axis("a", "offset", world.lower[0]),
        axis("b", "scale", row_mm),
        axis("b", "offset", 0.0),
        axis("c", "scale", c_scale),
        axis("c", "offset", c_offset),
        XmlNode::parameter("c axis range missing", "true"),
        axis("c", "missing value", 0.0),
        XmlNode::parameter("unit", "millimeter"),
    ];
    XmlNode::new("genistreamtraits", &[], children)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A peak in sensor row r of a region that begins at row o is step 16 (r - o), and 0 is missing.
    #[test]
    fn steps_are_sixteenths_of_a_row() {
        let traits = Traits::Sensor(SensorTraits::new(100, [0.0, 292.0]));
        assert_eq!(traits.height(16), 293.0);
        assert_eq!(traits.height(1599), 292.0 + 1599.0 / 16.0);
        assert!(traits.height(0).is_nan());
        let upwards = Traits::Sensor(SensorTraits { region_rows: 100, origin: [0.0, 391.0], scale: [1.0, -0.0625] });
        assert_eq!(upwards.height(16), 390.0);
        for n in [1_u16, 7, 1599] {
            assert_eq!((traits.steps(traits.height(n)), upwards.steps(upwards.height(n))), (n, n));
        }
    }

    /// WORDs of a calibrated scan run from 1 at the lower bound to 65535 at the upper one.
    #[test]
    fn words_span_the_bounds() {
        let world = WorldTraits { lower: [0.0, -5.0], upper: [64.0, 60.534], row_mm: None };
        let traits = Traits::World(world);
        for (step, height) in [(1, -5.0), (5001, 0.0), (65535, 60.534)] {
            assert!((traits.height(step) - height).abs() < 1e-9, "a micrometre a step");
        }
        assert_eq!((traits.steps(-9.0), traits.steps(99.0), traits.steps(f64::NAN)), (1, 65535, 0));
        assert_eq!(world.col_mm(640), 0.1);
    }
}
