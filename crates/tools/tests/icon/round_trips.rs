//! Files of the real camera: elements as the camera writes them, and exact round trips.

use std::fs;
use std::path::Path;

use crate::scans::{calibrated, folder, noise, plane, reader, uncalibrated, world, write, write_between, write_files};
use tools::icon::{
    Content, IconScan, PlaneContent, PlaneNumbers, ProfileMark, SensorImage, SensorTraits, Traits, open,
};

/// What a real calibrated scan of 2560 columns with FLOAT Range and Reflectance says, element by element: depth, name,
/// attributes in order of their names, text.
const REAL: &str = "0 icon_data_format name= valuetype= |
1 parameter name=size |12800
1 parameter name=version |1
1 parameter name=layout |SUBCOMPONENT
1 component name=Ranger3Range valuetype=Hi3D |
2 parameter name=size |12800
2 parameter name=height |1
2 worldrangetraits |
3 parameter name=lower bound x |130.306992
3 parameter name=lower bound R |62.224915
3 parameter name=upper bound x |370.141571
3 parameter name=upper bound R |117.414742
3 parameter name=coordinate unit |
2 subcomponent name=Range valuetype=FLOAT |
3 parameter name=size |10240
3 parameter name=width |2560
2 subcomponent name=Reflectance valuetype=BYTE |
3 parameter name=size |2560
3 parameter name=width |2560
";

/// An outline of XML in the words of [`REAL`], by another reader than ours.
fn outline(text: &str) -> String {
    use quick_xml::events::Event;
    let mut reader = quick_xml::Reader::from_str(text);
    let (mut lines, mut depth) = (Vec::<String>::new(), 0_usize);
    loop {
        match reader.read_event().expect("it is XML") {
            Event::Start(start) => {
                let mut attributes: Vec<String> = start
                    .attributes()
                    .map(|attribute| attribute.expect("it is an attribute"))
                    .map(|attribute| format!("{}={}", attribute.key.as_ref(), attribute.value))
                    .collect();
                attributes.sort();
                let name = start.name().as_ref().to_string();
                lines.push(format!("{depth} {} |", [vec![name], attributes].concat().join(" ")));
                depth += 1;
            }
            Event::Text(text) => {
                if let Some(line) = lines.last_mut() {
                    line.push_str(text.trim());
                }
            }
            Event::End(_) => depth -= 1,
            Event::Eof => return lines.join("\n") + "\n",
            _ => {}
        }
    }
}

/// Some rows of a scan.
fn part(scan: &IconScan, from: usize, to: usize) -> IconScan {
    let rows = |numbers: &PlaneNumbers| {
        let cut = |count: usize| from * count / scan.rows..to * count / scan.rows;
        match numbers {
            PlaneNumbers::Byte(all) => PlaneNumbers::Byte(all[cut(all.len())].to_vec()),
            PlaneNumbers::Word(all) => PlaneNumbers::Word(all[cut(all.len())].to_vec()),
            PlaneNumbers::Int(all) => PlaneNumbers::Int(all[cut(all.len())].to_vec()),
            PlaneNumbers::Float(all) => PlaneNumbers::Float(all[cut(all.len())].to_vec()),
        }
    };
    let planes = scan.planes.iter().map(|(part, numbers)| (*part, rows(numbers))).collect();
    IconScan { rows: to - from, planes, ..*scan }
}

/// A calibrated scan has the camera's elements, attributes and numbers, to the letter and in the camera's order.
#[test]
fn calibrated_scans_say_what_the_camera_says() {
    let (_folder, name) = folder();
    write(&name, &calibrated(2560, 2));
    let text = |name: &Path| fs::read_to_string(format!("{}.xml", name.display())).expect("it was just written");
    assert_eq!(outline(&text(&name)), REAL);
    assert_eq!(fs::metadata(format!("{}.dat", name.display())).expect("it was written").len(), 2 * 12800);
    // With the distance of profiles one element more, and nothing less.
    write(&name, &IconScan { traits: world(Some(0.1)), ..calibrated(2560, 2) });
    let more = outline(&text(&name));
    assert!(more.contains("3 parameter name=b axis range scale |0.1\n"), "{more}");
    let (before, after) = more.split_once("2 genistreamtraits |\n").expect("the element is there");
    let after = &after[after.find("2 subcomponent").expect("planes follow")..];
    assert_eq!(format!("{before}{after}"), REAL);
}

/// An uncalibrated scan says where on the sensor it was measured: columns, sixteenths of rows, origin, scale.
#[test]
fn uncalibrated_scans_say_where_on_the_sensor() {
    let (_folder, name) = folder();
    write(&name, &uncalibrated(64, 3));
    let text = outline(&fs::read_to_string(format!("{}.xml", name.display())).expect("it was just written"));
    for line in [
        "1 parameter name=size |340",
        "2 sensorrangetraits |",
        "3 parameter name=fov x1 |63",
        "3 parameter name=fov z0 |1",
        "3 parameter name=fov z2 |13311",
        "3 parameter name=fov z3 |13311",
        "3 parameter name=origin z |12",
        "3 parameter name=scale z |0.0625",
        "2 subcomponent name=Range valuetype=WORD |",
        "2 subcomponent name=Intensity valuetype=BYTE |",
        "2 subcomponent name=Scatter valuetype=WORD |",
        "2 subcomponent name=Mark valuetype=INT |\n3 parameter name=size |20\n3 parameter name=width |5",
    ] {
        assert!(text.contains(&format!("{line}\n")), "'{line}' is not in\n{text}");
    }
}

/// Every kind of scan comes back number by number, in whatever pieces it is read.
#[test]
fn scans_come_back() {
    let (_folder, name) = folder();
    let words = IconScan {
        traits: world(Some(0.068)),
        planes: vec![
            (PlaneContent::Range, PlaneNumbers::Word(noise(88).map(|n| n as u16).collect())),
            (PlaneContent::Scatter, PlaneNumbers::Byte(noise(88).map(|n| (n >> 9) as u8).collect())),
        ],
        ..calibrated(8, 11)
    };
    let mut placed = calibrated(6, 11);
    placed.planes.insert(0, (PlaneContent::RangeX, PlaneNumbers::Float(noise(66).map(|n| n as f32).collect())));
    let reversed = SensorTraits { scale: [1.0, -0.0625], ..SensorTraits::new(832, [8.0, 700.5]) };
    for scan in [
        calibrated(37, 11),
        uncalibrated(5, 11),
        words,
        placed,
        IconScan {
            traits: Traits::Sensor(reversed),
            planes: vec![uncalibrated(7, 11).planes.swap_remove(0)],
            ..uncalibrated(7, 11)
        },
    ] {
        write(&name, &scan);
        let mut reader = reader(&name);
        assert_eq!((reader.width(), reader.rows(), reader.traits()), (scan.width, 11, scan.traits));
        assert_eq!(reader.read(0, 99).expect("it is whole"), scan);
        assert_eq!(reader.read(3, 2).expect("it is whole"), part(&scan, 3, 5));
        assert_eq!(reader.read(11, 1).expect("there is nothing").rows, 0);
    }
}

/// The bytes lie plane after plane, little-endian: all of Range, then Intensity, then Scatter, then Mark.
#[test]
fn planes_follow_each_other() {
    let (_folder, name) = folder();
    let numbers = [u32::MAX, 0x0003_0000, 2, 0, 0];
    let planes = vec![
        (PlaneContent::Range, PlaneNumbers::Word(vec![0x0102, 3, 4, 5])),
        (PlaneContent::Intensity, PlaneNumbers::Byte(vec![6, 7, 8, 9])),
        (PlaneContent::Scatter, PlaneNumbers::Byte(vec![10, 11, 12, 13])),
        (PlaneContent::Mark, PlaneNumbers::Int([numbers; 2].concat())),
    ];
    let scan = IconScan { planes, ..uncalibrated(2, 2) };
    write(&name, &scan);
    let bytes = fs::read(format!("{}.dat", name.display())).expect("it was just written");
    assert_eq!(bytes[..16], [2, 1, 3, 0, 4, 0, 5, 0, 6, 7, 8, 9, 10, 11, 12, 13]);
    assert_eq!(bytes[16..36], [255, 255, 255, 255, 0, 0, 3, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!(bytes.len(), 56);
    let mark = ProfileMark { encoder: -1, status: 0x0003_0000, timestamp: 2, ..ProfileMark::default() };
    assert_eq!(reader(&name).read(1, 1).expect("it is whole").marks(), Some(vec![mark]));
}

/// Missing is NaN for whoever asks for heights, however it was written.
#[test]
fn missing_heights_are_nan() {
    let planes = vec![(PlaneContent::Range, PlaneNumbers::Float(vec![0.0, f32::NAN, 70.5, -0.0]))];
    let heights = IconScan { planes, ..calibrated(4, 1) }.heights();
    assert!(heights[0].is_nan() && heights[1].is_nan() && heights[3].is_nan() && heights[2] == 70.5, "{heights:?}");
    let planes = vec![(PlaneContent::Range, PlaneNumbers::Word(vec![0, 16]))];
    let heights = IconScan { planes, ..uncalibrated(2, 1) }.heights();
    assert!(heights[0].is_nan() && heights[1] == 13.0, "{heights:?}");
}

/// A sensor image comes back and has the camera's names.
#[test]
fn sensor_images_come_back() {
    let (_folder, name) = folder();
    let image = SensorImage { cols: 9, rows: 4, offset: [3, 128], dn: noise(36).map(|n| n as u8).collect() };
    write_files(&name, image.files());
    let Ok(Content::Image(back)) = open(&name) else { panic!("it is no image") };
    assert_eq!(back, image);
    let text = outline(&fs::read_to_string(format!("{}.xml", name.display())).expect("it was just written"));
    for line in [
        "0 icon_data_format name=IMAGE valuetype=IMAGE |",
        "1 parameter name=size |36",
        "1 parameter name=layout |SCAN",
        "1 component name=Ranger3Image valuetype=image |",
        "2 parameter name=height |4",
        "3 parameter name=offset y |128",
        "2 subcomponent name=Image valuetype=BYTE |",
    ] {
        assert!(text.contains(&format!("{line}\n")), "'{line}' is not in\n{text}");
    }
}

/// An image between planes that we do not know is read in either layout, each plane with its own width.
#[test]
fn images_are_found_between_planes() {
    let (_folder, name) = folder();
    let image = SensorImage { cols: 9, rows: 4, offset: [3, 128], dn: noise(36).map(|n| n as u8).collect() };
    for layout in ["SCAN", "SUBCOMPONENT"] {
        write_between(&name, &image, layout, [("Before", "WORD", 10, 5), ("After", "INT", 12, 3)]);
        let Ok(Content::Image(back)) = open(&name) else { panic!("{layout} is no image") };
        assert_eq!(back, image, "{layout}");
    }
}

/// Planes, components and settings that we do not know are stepped over; line-by-line layout and short marks are read.
#[test]
fn other_cameras_are_read() {
    let (_folder, name) = folder();
    let scan = uncalibrated(2, 3);
    write(&name, &scan);
    let text = fs::read_to_string(format!("{}.xml", name.display())).expect("it was just written");
    let from = text.find("<sensorrangetraits>").expect("it is there");
    let traits = &text[from..text.find("<subcomponent").expect("it is there")];
    let description = format!(
        "\u{feff}<?xml version=\"1.0\"?><icon_data_format><parameter name=\"size\">23</parameter><parameter \
         name=\"version\">1</parameter><parameter name=\"layout\">SCAN</parameter><component name=\"Other\">{}\
         </component><component name=\"Ranger3Range\">{traits}{}{}{}</component><genistream>x &lt; y</genistream>\
         </icon_data_format>",
        plane("BYTE", "Colour", 3, 3),
        plane("FLOAT", "Range X", 8, 2),
        plane("WORD", "Range R", 4, 2),
        plane("INT", "Mark", 8, 2),
    );
    fs::write(format!("{}.xml", name.display()), description).expect("the folder is ours");
    let row = |n: u8| {
        let mut bytes = vec![0xAA; 11];
        bytes.extend([n, 0, n, 1, n, 0, 0, 0, 7, 0, 0, 0]);
        bytes
    };
    fs::write(format!("{}.dat", name.display()), [row(1), row(2), row(3)].concat()).expect("the folder is ours");
    let mut reader = reader(&name);
    let back = reader.read(1, 2).expect("it is whole");
    let steps = PlaneNumbers::Word(vec![2, 258, 3, 259]);
    assert_eq!((reader.rows(), back.plane(PlaneContent::Range)), (3, Some(&steps)));
    let marks = back.marks().expect("they are there");
    assert_eq!(marks[1], ProfileMark { encoder: 3, status: 7, ..ProfileMark::default() });
}
