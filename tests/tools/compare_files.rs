//! `gen compare` with files of bare numbers: PNG, TIFF, CSV and PLY that the tests write from a sample, read back with
//! the statistics of the dataset; what has to be stated, and files that are damaged.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;

use dataset::{Grey, read_png, write_png};
use serde_json::Value;
use test_support::program::{Place, SPECKLE};
use tools::compare::{CountScale, CsvForm, MissingNumber, ScanSource, StatedScale, StatisticsBuilder};

/// A sample in counts, beside the dataset `planks` that holds it as images.
struct Sample {
    place: Place,
    cols: usize,
    range: Vec<u16>,
    reflectance: Vec<u16>,
    scatter: Vec<u16>,
    offset: f64,
    scale: f64,
    pitch: [f64; 2],
}

impl Sample {
    fn new() -> Self {
        let place = Place::with(&[
            SPECKLE,
            ["exr: [range, reflectance, scatter, label, instance]", "exr: []"],
            ["truth_maps: true", "truth_maps: false"],
        ]);
        place.make("planks", "--n 1");
        place.done("export png planks --out pngs");
        let split = ["train", "test", "validation"].into_iter().find(|split| place.path("pngs").join(split).exists());
        let split = split.expect("the sample has a split");
        let row: Value = place.json(&format!("pngs/{split}.jsonl"));
        let map = |name: &str| {
            let path = place.path(&format!("pngs/{split}/{name}/00000000.png"));
            let (cols, _, grey) = read_png(&fs::read(path).expect("it was exported")).expect("it is whole");
            (cols as usize, grey.numbers())
        };
        let number = |key: &str| row[key].as_f64().expect("the row has it");
        let (cols, range) = map("range");
        let (reflectance, scatter) = (map("reflectance").1, map("scatter").1);
        let [offset, scale] = ["range_offset_mm", "range_scale_mm"].map(number);
        let pitch = ["col_mm", "row_mm"].map(number);
        fs::rename(place.path("pngs").join(split), place.path("maps")).expect("the folder is ours");
        Self { cols, range, reflectance, scatter, offset, scale, pitch, place }
    }

    /// What is stated where Range holds counts.
    fn counts(&self) -> String {
        let [col, row] = self.pitch;
        format!("--mm-per-count {} --offset {} --col-mm {col} --row-mm {row}", self.scale, self.offset)
    }

    fn height(&self, i: usize) -> f64 {
        if self.range[i] == 0 { f64::NAN } else { self.offset + f64::from(self.range[i]) * self.scale }
    }

    /// Points with places in mm, profile by profile.
    fn points(&self) -> Vec<[f64; 3]> {
        let place = |i: usize| [(i % self.cols) as f64 * self.pitch[0], (i / self.cols) as f64 * self.pitch[1]];
        (0..self.range.len()).map(|i| [place(i)[0], place(i)[1], self.height(i)]).collect()
    }

    /// Both sides of a comparison of the dataset with files.
    fn compare(&self, arguments: &str) -> [Value; 2] {
        // Files don't tell the object.
        let run = self.place.run(&format!("compare planks {arguments} --json --whole"));
        assert_eq!((run.code, run.err.as_str()), (0, ""), "gen compare planks {arguments}");
        let both: Value = serde_json::from_str(&run.out).expect("it prints JSON");
        ["sim", "real"].map(|side| both[side].clone())
    }

    /// The files have every statistic of the dataset, pitches to rounding.
    fn is_alike(&self, arguments: &str, has_light: bool) {
        let [mut sim, mut real] = self.compare(arguments);
        for way in ["along", "across"] {
            let [a, b] = [&sim, &real].map(|side| side["pitch_mm"][way].as_f64().expect("it is known"));
            assert!((a - b).abs() < 1e-9, "{arguments}: {a} and {b} mm");
        }
        for side in [&mut sim, &mut real] {
            let side = side.as_object_mut().expect("it is a map");
            side.retain(|key, _| !matches!(key.as_str(), "name" | "pitch_mm"));
            let of_light =
                ["least_reflectance_dn", "saturated_share", "scatter_dn", "speckle_contrast", "speckle_correlation"];
            side.retain(|key, _| has_light || !of_light.contains(&key.as_str()));
        }
        assert_eq!(sim, real, "gen compare planks {arguments}");
    }

    /// A refusal, with its exit status.
    fn refuses(&self, arguments: &str, code: i32, words: &str) {
        let run = self.place.run(&format!("compare planks {arguments}"));
        assert!(run.err.contains(words), "gen compare planks {arguments}: '{words}' is not in: {}", run.err);
        assert_eq!((run.code, run.out.as_str()), (code, ""), "gen compare planks {arguments}: {}", run.err);
    }
}

/// A grey TIFF without compression: byte order, bits, sample format (1 whole, 3 float), meaning of 0 (1 black).
fn tiff(cols: usize, pixels: &[u8], little: bool, [bits, format, meaning]: [u32; 3]) -> Vec<u8> {
    let rows = pixels.len() / cols / (bits as usize / 8);
    let short = |n: u32| if little { (n as u16).to_le_bytes() } else { (n as u16).to_be_bytes() };
    let long = |n: u32| if little { n.to_le_bytes() } else { n.to_be_bytes() };
    let entries = [
        (256, cols as u32),
        (257, rows as u32),
        (258, bits),
        (259, 1),
        (262, meaning),
        (273, 8),
        (277, 1),
        (278, rows as u32),
        (279, pixels.len() as u32),
        (339, format),
    ];
    let mut file = if little { b"II*\0".to_vec() } else { b"MM\0*".to_vec() };
    file.extend(long(8 + pixels.len() as u32));
    file.extend(pixels);
    file.extend(short(entries.len() as u32));
    for (tag, value) in entries {
        file.extend([short(tag), short(4)].concat());
        file.extend([long(1), long(value)].concat());
    }
    file.extend(long(0));
    file
}

fn little(numbers: &[u16]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// A cloud of points in binary PLY of doubles, with reflectance and scatter.
fn ply(sample: &Sample, organised: bool, keep: impl Fn(usize) -> bool) -> Vec<u8> {
    let points = sample.points();
    let kept: Vec<usize> = (0..points.len()).filter(|i| keep(*i)).collect();
    let mut file = "ply\nformat binary_little_endian 1.0\ncomment a scan\n".to_owned();
    if organised {
        let rows = points.len() / sample.cols;
        let _ = write!(file, "obj_info num_cols {}\nobj_info num_rows {rows}\n", sample.cols);
    }
    let _ = writeln!(file, "element vertex {}", kept.len());
    file += "property double x\nproperty double y\nproperty double z\nproperty uchar intensity\nproperty ushort \
        scatter\nend_header\n";
    let mut file = file.into_bytes();
    for i in kept {
        file.extend(points[i].iter().flat_map(|mm| mm.to_le_bytes()));
        file.push(sample.reflectance[i] as u8);
        file.extend(sample.scatter[i].to_le_bytes());
    }
    file
}

/// Numbers as lines of text.
fn grid(cols: usize, numbers: impl Iterator<Item = f64>, separator: &str) -> String {
    let numbers: Vec<String> = numbers.map(|n| if n.is_nan() { String::new() } else { n.to_string() }).collect();
    numbers.chunks(cols).map(|line| line.join(separator) + "\n").collect()
}

/// PNG as they are exported: by options, by names beside Range, and by folders.
#[test]
fn png_is_the_dataset() {
    let sample = Sample::new();
    let stated = format!("{} --missing 0", sample.counts());
    let maps = "--reflectance maps/reflectance/00000000.png --scatter maps/scatter/00000000.png";
    sample.is_alike(&format!("maps/range/00000000.png {stated} {maps}"), true);
    sample.is_alike(&format!("maps/range/00000000.png {stated}"), false);
    sample.is_alike(&format!("maps/range {stated}"), false);
    sample.is_alike(&format!("maps {stated}"), true);
    for map in ["range", "reflectance", "scatter"] {
        let from = sample.place.path(&format!("maps/{map}/00000000.png"));
        fs::copy(from, sample.place.path(&format!("board.{map}.PNG"))).expect("the folder is ours");
    }
    sample.is_alike(&format!("board.range.PNG {stated}"), true);
    // The maps that belong to it by name are not given twice.
    sample.refuses(&format!("board.range.PNG {stated} --scatter maps/scatter/00000000.png"), 1, "leave --scatter away");
}

/// TIFF of both byte orders, whole numbers and floats.
#[test]
fn tiff_is_the_dataset() {
    let sample = Sample::new();
    let (cols, range) = (sample.cols, &sample.range);
    let big: Vec<u8> = range.iter().flat_map(|n| n.to_be_bytes()).collect();
    let narrow: Vec<u8> = sample.reflectance.iter().map(|dn| *dn as u8).collect();
    let light = sample.scatter.iter().flat_map(|dn| f32::from(*dn).to_le_bytes()).collect::<Vec<u8>>();
    // Counts in floats, so that nothing is rounded.
    let float = range.iter().flat_map(|&n| if n == 0 { f32::NAN } else { f32::from(n) }.to_le_bytes());
    sample.place.write("a.range.tif", tiff(cols, &little(range), true, [16, 1, 1]));
    sample.place.write("a.reflectance.tiff", tiff(cols, &narrow, true, [8, 1, 1]));
    sample.place.write("a.scatter.tif", tiff(cols, &light, true, [32, 3, 1]));
    sample.place.write("big.tif", tiff(cols, &big, false, [16, 1, 1]));
    sample.place.write("float.tif", tiff(cols, &float.collect::<Vec<u8>>(), true, [32, 3, 1]));
    let stated = sample.counts();
    sample.is_alike(&format!("a.range.tif {stated} --missing 0"), true);
    sample.is_alike(&format!("big.tif {stated} --missing 0"), false);
    sample.is_alike(&format!("float.tif {stated}"), false);
    sample.place.write("white.tif", tiff(cols, &little(range), true, [16, 1, 0]));
    sample.refuses(&format!("white.tif {stated} --missing 0"), 1, "save it with 0 as black");
}

/// CSV: a grid of heights with empty fields, and points with a header or by order.
#[test]
fn csv_is_the_dataset() {
    let sample = Sample::new();
    let cols = sample.cols;
    let heights = || (0..sample.range.len()).map(|i| sample.height(i));
    sample.place.write("grid.csv", grid(cols, heights(), ","));
    sample.place.write("light.csv", grid(cols, sample.reflectance.iter().map(|dn| f64::from(*dn)), ";"));
    let [col, row] = sample.pitch;
    let pitches = format!("--col-mm {col} --row-mm {row}");
    sample.is_alike(&format!("grid.csv --mm-per-count 1 {pitches}"), false);
    let [sim, real] = sample.compare(&format!("grid.csv --mm-per-count 1 {pitches} --reflectance light.csv --bits 8"));
    assert_eq!(sim["speckle_contrast"], real["speckle_contrast"]);
    let mut named = "x_mm,y_mm,z_mm,intensity,scatter\n".to_owned();
    let mut bare = String::new();
    for (i, [x, y, z]) in sample.points().into_iter().enumerate() {
        let z = if z.is_nan() { "nan".into() } else { z.to_string() };
        let (dn, sum) = (sample.reflectance[i], sample.scatter[i]);
        let _ = writeln!(named, "{x},{y},{z},{dn},{sum}");
        let _ = writeln!(bare, "{x} {y} {z} {dn} {sum}");
    }
    sample.place.write("named.csv", named);
    sample.place.write("bare.txt", bare);
    sample.is_alike(&format!("named.csv --bits 8 --cols {cols}"), true);
    sample.is_alike(&format!("bare.txt --csv points --mm-per-count 1 --bits 8 --cols {cols}"), true);
}

/// PLY: stored profile by profile by its header, or in any order on an even grid, without the points that are missing.
#[test]
fn ply_is_the_dataset() {
    let sample = Sample::new();
    let cols = sample.cols;
    sample.place.write("organised.ply", ply(&sample, true, |_| true));
    sample.is_alike("organised.ply --mm-per-count 1", true);
    sample.place.write("plain.ply", ply(&sample, false, |_| true));
    sample.is_alike(&format!("plain.ply --mm-per-count 1 --cols {cols}"), true);
    // On a grid, which ends with the last points that have heights.
    sample.place.write("cloud.ply", ply(&sample, false, |i| sample.range[i] > 0));
    let measured: Vec<usize> = (0..sample.range.len()).filter(|i| sample.range[*i] > 0).collect();
    let span = |at: fn(usize, usize) -> usize| {
        let (low, high) = measured.iter().map(|i| at(*i, cols)).fold((usize::MAX, 0), |(l, h), x| (l.min(x), h.max(x)));
        (high - low + 1) as u64
    };
    let spans = (Some(span(|i, cols| i % cols)), Some(span(|i, cols| i / cols)));
    let [sim, real] = sample.compare("cloud.ply --mm-per-count 1");
    assert_eq!((real["columns"].as_u64(), real["profiles"].as_u64()), spans);
    for key in ["range_noise_um", "edge_share", "saturated_share", "least_reflectance_dn", "heights_mm"] {
        assert_eq!(sim[key], real[key], "{key}");
    }
    let [_, um] = sample.compare("cloud.ply --um-per-count 1000");
    assert_eq!(um["range_noise_um"], real["range_noise_um"]);
}

/// A surface as a Gocator exports it has the statistics of the dataset, with nothing stated; `.xyz` are points without
/// being told.
#[test]
fn exports_say_what_they_are() {
    let sample = Sample::new();
    let [col, row] = sample.pitch;
    let rows = sample.range.len() / sample.cols;
    let number = |z: f64| if z.is_nan() { String::new() } else { z.to_string() };
    let grid = |at: &dyn Fn(usize) -> String| {
        let mut text = "Y\\X".to_owned();
        (0..sample.cols).for_each(|i| text += &format!(",{}", (i as f64 - 7.0) * col));
        for j in 0..rows {
            text += &format!("\r\n{}", j as f64 * row);
            (0..sample.cols).for_each(|i| text += &format!(",{}", at(j * sample.cols + i)));
        }
        text + "\r\nEnd\r\n"
    };
    let head = format!(
        "Info\r\nCSV Version,XResolution,YResolution\r\n2,{col:.3},{row:.3}\r\nEnd\r\nFrame\r\n0\r\nEnd\r\nPart\r\n"
    );
    let range = head + "Frame,Source,Row Count,X Offset\r\n0,0,48,-0.5\r\n" + &grid(&|i| number(sample.height(i)));
    let dn = |i: usize| if sample.range[i] > 0 { sample.reflectance[i].to_string() } else { String::new() };
    sample.place.write("gocator.csv", &range);
    sample.is_alike("gocator.csv", false);
    sample.place.write("lit.csv", range.clone() + "PartIntensity\r\n" + &grid(&dn));
    let [sim, real] = sample.compare("lit.csv");
    for key in ["least_reflectance_dn", "saturated_share", "speckle_contrast"] {
        assert_eq!(sim[key], real[key], "{key}");
    }
    let points: String = sample.points().iter().map(|[x, y, z]| format!("{x} {y} {z} 0 0 1\n")).collect();
    sample.place.write("cloud.xyz", points);
    sample.is_alike(&format!("cloud.xyz --mm-per-count 1 --cols {}", sample.cols), false);
    for (arguments, words) in [
        ("gocator.csv --mm-per-count 1", "names the unit of heights itself"),
        ("gocator.csv --col-mm 0.1", "leave --col-mm away"),
        ("gocator.csv --csv grid", "leave --csv away"),
        ("gocator.csv --cols 64", "leave --cols away"),
        ("lit.csv --reflectance maps/reflectance/00000000.png", "holds its own intensity"),
        ("cloud.xyz", "--mm-per-count (1 where they are mm)"),
    ] {
        sample.refuses(arguments, 1, words);
    }
}

/// Every option changes what it is about.
#[test]
fn every_option_has_an_effect() {
    let sample = Sample::new();
    let rest = "--reflectance maps/reflectance/00000000.png --scatter maps/scatter/00000000.png";
    let of = |scale: &str| sample.compare(&format!("maps/range/00000000.png {scale}"))[1].clone();
    let plain = of("--um-per-count 2 --missing 0");
    for (scale, key) in [
        ("--um-per-count 4 --missing 0", "range_noise_um"),
        ("--mm-per-count 0.003 --missing 0", "heights_mm"),
        ("--um-per-count 2 --missing none", "missing_share"),
        ("--um-per-count 2 --missing 0 --offset -3.5", "heights_mm"),
        ("--um-per-count 2 --missing 0 --col-mm 0.2", "pitch_mm"),
        ("--um-per-count 2 --missing 0 --row-mm 0.2", "pitch_mm"),
        (&format!("--um-per-count 2 --missing 0 {rest}"), "scatter_dn"),
        (&format!("--um-per-count 2 --missing 0 {rest}"), "least_reflectance_dn"),
    ] {
        assert_ne!(of(scale)[key], plain[key], "{scale}");
    }
    assert_eq!(of("--mm-per-count 0.002 --missing 0"), plain);
    // Sensor rows are compared with sensor rows.
    sample.refuses("maps/range/00000000.png --px-per-count 0.01 --missing 0", 1, "the other sensor rows");
    let wide: Vec<u16> = sample.reflectance.iter().map(|dn| dn * 4).collect();
    sample.place.write("wide.png", write_png(&Grey::Sixteen(wide), sample.cols));
    let counts = format!("maps/range/00000000.png {} --missing 0", sample.counts());
    let bits = |bits: u64| sample.compare(&format!("{counts} --reflectance wide.png --bits {bits}"))[1].clone();
    assert_ne!(bits(10)["least_reflectance_dn"], bits(12)["least_reflectance_dn"]);
    // --csv and --cols decide what the same lines are.
    let lines: String = (0..400).map(|i| format!("{} {} {}\n", i % 20, i / 20, (i * 7919) % 101)).collect();
    sample.place.write("lines.txt", lines);
    let of = |options: &str| sample.compare(&format!("lines.txt --um-per-count 1 {options}"))[1].clone();
    let sizes = ["--csv grid", "--csv points", "--csv points --cols 10"].map(of);
    let sizes = sizes.map(|side| (side["columns"].as_u64(), side["profiles"].as_u64()));
    assert_eq!(sizes, [(Some(3), Some(400)), (Some(20), Some(20)), (Some(10), Some(40))]);
}

/// What is needed and not stated, or stated and not needed, is told with its option; so is what is ambiguous.
#[test]
fn nothing_is_guessed() {
    let sample = Sample::new();
    let png = "maps/range/00000000.png";
    let counts = format!("{} --missing 0", sample.counts());
    sample.place.write("wide.png", write_png(&Grey::Sixteen(vec![900; sample.range.len()]), sample.cols));
    sample.place.write("other.png", write_png(&Grey::Eight(vec![9; 12]), 4));
    sample.place.write("three.csv", "1,2,3\n4,5,6\n");
    sample.place.write("named.csv", "x_mm,y_mm,z_mm\n0,0,1\n1,0,2\n0,1,3\n1,1,4\n");
    sample.place.write("uneven.csv", "x,y,z\n0,0,1\n1,0,2\n1.4,0,2\n0,1,3\n");
    sample.place.write("far.csv", "1,2,3,4,5,1e300\n");
    sample.place.write("organised.ply", ply(&sample, true, |_| true));
    fs::create_dir(sample.place.path("mixed")).expect("the folder is ours");
    sample.place.write("mixed/a.png", write_png(&Grey::Eight(vec![9; 12]), 4));
    sample.place.write("mixed/a.csv", "1,2,3,4,5,6\n");
    for (arguments, code, words) in [
        (png.to_owned(), 1, "--mm-per-count (1 where they are mm)"),
        (format!("{png} --um-per-count 2"), 1, "give --missing 0"),
        (format!("{png} --um-per-count 2 --mm-per-count 2"), 2, "cannot be used with"),
        (format!("{png} --um-per-count 0"), 2, "above 0"),
        (format!("{png} {counts} --reflectance wide.png"), 1, "give --bits, 8 to 16"),
        (format!("{png} {counts} --reflectance wide.png --bits 9"), 1, "no digital number of 9 bits"),
        (format!("{png} {counts} --reflectance other.png"), 1, "give maps on one grid"),
        (format!("{png} {counts} --reflectance organised.ply"), 1, "no map alone"),
        (format!("{png} {counts} --reflectance maps/reflectance/00000000.png --bits 12"), 1, "has 8 bits, not 12"),
        (format!("{png} {counts} --bits 8"), 2, "--bits: no effect"),
        (format!("{png} {counts} --csv grid"), 2, "--csv: no effect"),
        (format!("{png} {counts} --cols 4"), 2, "--cols: no effect"),
        ("planks --um-per-count 2".into(), 2, "no effect, for both sides say their scale themselves"),
        ("planks --scatter maps/scatter/00000000.png".into(), 2, "--scatter: no effect"),
        ("three.csv --mm-per-count 1".into(), 1, "--csv points or --csv grid"),
        ("three.csv --mm-per-count 1 --csv grid --cols 3".into(), 1, "leave --cols away"),
        ("named.csv --mm-per-count 1".into(), 1, "names the unit of heights itself"),
        ("named.csv --csv grid".into(), 1, "leave --csv away"),
        ("uneven.csv --mm-per-count 1".into(), 1, "give --cols where points are stored profile by profile"),
        ("far.csv --mm-per-count 1".into(), 1, "--missing"),
        ("organised.ply --mm-per-count 1 --cols 7".into(), 1, "leave --cols away"),
        ("organised.ply --px-per-count 1".into(), 1, "one unit for x, y and z"),
        ("mixed --mm-per-count 1".into(), 1, "NAME.range.png"),
    ] {
        sample.refuses(&arguments, code, words);
    }
    // One scale for two sides is said.
    let run = sample.place.done(&format!("compare {png} {png} {counts}"));
    assert!(run.err.contains("holds for each"), "{}", run.err);
    let run = sample.place.run(&format!("compare {png} {png} {counts} --scatter maps/scatter/00000000.png"));
    assert!(run.code == 2 && run.err.contains("several sides are one file of Range"), "{}", run.err);
}

/// Files that claim more than can be compared, that never end or are no files, are refused before they take memory.
#[test]
fn hostile_files_are_refused() {
    let place = Place::new();
    let claim = |name: &str, bytes: Vec<u8>| place.write(name, bytes);
    claim("huge.ply", b"ply\nformat ascii 1.0\nelement vertex 60000000\nproperty float x\nend_header\n".to_vec());
    let mut wide = tiff(2, &[0; 8], true, [16, 1, 1]);
    let sizes = wide.len() - 10 * 12 - 4;
    for entry in [0, 1] {
        wide[sizes + entry * 12 + 8..][..4].copy_from_slice(&0x7fff_ffff_u32.to_le_bytes());
    }
    claim("huge.tif", wide);
    claim("empty.png", Vec::new());
    claim("empty.csv", Vec::new());
    claim("binary.csv", vec![0xff; 64]);
    for name in ["sparse.png", "sparse.tif", "sparse.csv", "sparse.ply"] {
        let file = fs::File::create(place.path(name)).expect("the folder is ours");
        file.set_len(1 << 40).expect("it takes no room");
    }
    for name in ["pipe.png", "pipe.csv", "pipe.ply"] {
        let made = Command::new("mkfifo").arg(place.path(name)).status().expect("mkfifo is there");
        assert!(made.success());
    }
    for name in ["huge.ply", "huge.tif", "empty.png", "empty.csv", "binary.csv"].into_iter().chain([
        "sparse.png",
        "sparse.tif",
        "sparse.csv",
        "sparse.ply",
        "pipe.png",
        "pipe.csv",
        "pipe.ply",
    ]) {
        let run = place.run(&format!("compare {name} {name} --mm-per-count 1 --missing 0 -q"));
        assert!(run.code == 1 && run.err.contains(name) && run.err.contains("; "), "{name}: {}", run.err);
    }
}

/// Bytes of files, flipped, cut and doubled at random: a fault or numbers, and never a panic.
#[test]
fn damaged_files_never_panic() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let counts: Vec<u16> = (0..24 * 20).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 20) as u16).collect();
    let number = |i: usize| f64::from(counts[i]) / 7.0;
    let text = |i: usize| format!("{},{},{},{}\n", i % 24, i / 24, number(i), i % 251);
    let cloud: String = (0..480).map(|i| text(i).replace(',', " ")).collect();
    let head = "ply\nformat ascii 1.0\nobj_info num_cols 24\nobj_info num_rows 20\nelement vertex 480\nproperty float \
        x\n\
                property float y\nproperty float z\nproperty uchar intensity\nend_header\n";
    let binary = head.replace("ascii", "binary_big_endian");
    let places = (0..480).flat_map(|i| [(i % 24) as f32, (i / 24) as f32, number(i) as f32].map(f32::to_be_bytes));
    let places: Vec<[u8; 4]> = places.collect();
    let points = places.chunks(3).flat_map(|place| [place.concat(), vec![77]].concat()).collect::<Vec<u8>>();
    let files: [(&str, Vec<u8>); 8] = [
        ("a.png", write_png(&Grey::Sixteen(counts.clone()), 24)),
        ("a.tif", tiff(24, &little(&counts), true, [16, 1, 1])),
        ("b.tif", tiff(24, &[1; 24 * 20 * 4], false, [32, 3, 1])),
        (
            "a.csv",
            (0..480)
                .map(|i| format!("{}{}", number(i), if i % 24 == 23 { '\n' } else { ';' }))
                .collect::<String>()
                .into(),
        ),
        ("b.csv", ("x,y,z,reflectance\n".to_owned() + &(0..480).map(text).collect::<String>()).into()),
        ("c.csv", (0..480).map(text).collect::<String>().into()),
        ("a.ply", (head.to_owned() + &cloud).into()),
        ("b.ply", [binary.as_bytes(), &points].concat()),
    ];
    let stated = StatedScale {
        count: Some(CountScale::Mm(0.001)),
        missing: Some(MissingNumber::Number(0.0)),
        bits: Some(8),
        ..StatedScale::default()
    };
    let read = |path: &Path, csv: Option<CsvForm>| {
        let source = ScanSource::open(path, 1, &StatedScale { csv, ..stated.clone() })?;
        let mut builder = StatisticsBuilder::new("damaged");
        builder.add(&source.frame(0)?);
        Ok::<_, dataset::Fault>(builder.statistics())
    };
    let mut state = 1_u64;
    let mut draw = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as usize) % below.max(1)
    };
    for (name, whole) in files {
        let path = folder.path().join(name);
        let csv = (name == "c.csv").then_some(CsvForm::Points);
        fs::write(&path, &whole).expect("the folder is ours");
        let found = read(&path, csv).unwrap_or_else(|fault| panic!("{name} is whole: {fault}"));
        assert_eq!(found.size, (24, 20), "{name}");
        let mut refused = 0;
        for _ in 0..300 {
            let mut bytes = whole.clone();
            for _ in 0..=draw(3) {
                // Half of it near the head, where sizes are.
                let reach = if draw(2) == 0 { bytes.len().min(200) } else { bytes.len() };
                let at = draw(reach);
                match draw(5) {
                    0 => bytes.truncate(at.max(1)),
                    1 => bytes[at] ^= 1 << draw(8),
                    2 => bytes[at] = [0, 0xff, b'9', b'-', b'e', b'\n'][draw(6)],
                    3 => drop(bytes.splice(at..at, *b"999999999")),
                    _ => {
                        let copied = bytes[at..].to_vec();
                        bytes.extend(copied);
                    }
                }
            }
            fs::write(&path, bytes).expect("the folder is ours");
            refused += usize::from(read(&path, csv).is_err());
        }
        println!("{name}: {refused} of 300 damaged files are refused");
        assert!(refused > 30, "{name}: {refused} of 300 are refused");
    }
}
