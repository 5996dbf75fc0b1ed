//! Purpose: making a dataset and validating it take as much memory for many samples, and for many in one shard, as for
//! a few, and making it no more than is said before; and so do the fibres of a picture.

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::Command;

use dataset::Dataset;
use dataset::validate::{ValidationOptions, validate};
use optical_bench::settings::{Output, SensorStack, Size};
use recipe::Recipe;
use sheetlight::generate::{DatasetRequest, MemoryEstimate, generate};
use test_support::records::{self, claimed, head, output};

/// Names the folder that [`validates`] is to read in a process of its own, and [`generates`] to fill.
const FOLDER: &str = "SHEETLIGHT_TEST_FOLDER";
/// Says how many samples [`generates`] is to make, in shards of how many, at what smallest f-number.
const SAMPLES: &str = "SHEETLIGHT_TEST_SAMPLES";
/// Makes the allocator give back what is freed, so that the peak tells what is held and not how it was cut up: without,
/// it varies by 25 MB between runs.
const TIGHT: [(&str, &str); 3] =
    [("MALLOC_ARENA_MAX", "1"), ("MALLOC_MMAP_THRESHOLD_", "65536"), ("MALLOC_TRIM_THRESHOLD_", "65536")];
/// Large enough that a sample weighs more than what else varies: about 15 MB of decoded maps.
const LARGE: Size = Size { columns: 640, rows: 20, profiles: 512 };

/// Samples of one kind in one shard.
fn write(path: &Path, samples: u64) {
    let output = Output { sensor_stack: SensorStack::None, samples_per_shard: Some(samples as usize), ..output() };
    let folder = Dataset::open_or_create(path, head(&output, &LARGE, samples), false, &|| ()).expect("it opens");
    let mut writer = claimed(&folder, 0);
    for index in 0..samples {
        let record = records::record(index, &LARGE, &output);
        writer.push(dataset::encode(record, &output)).expect("it is written");
    }
    writer.finish().expect("it is finished");
    folder.complete(&|| ()).expect("the card is written");
}

/// Largest memory of a process of its own that does what the test `name` does there, told by `variables` [MB].
fn peak(name: &str, variables: &[(&str, &OsStr)]) -> f64 {
    let mut own = Command::new(std::env::current_exe().expect("this test"));
    own.args(["--exact", name, "--nocapture"]).envs(variables.iter().copied()).envs(TIGHT);
    let output = own.output().expect("it runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().find_map(|line| line.split("VmHWM:").nth(1)).unwrap_or_else(|| panic!("no peak in {text}"));
    line.trim().trim_end_matches("kB").trim().parse::<f64>().expect("a number") / 1000.0
}

/// Does it on two threads and says what it took.
fn tell_peak(work: impl FnOnce() + Send) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    pool.install(work);
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    println!("{}", status.lines().find(|line| line.starts_with("VmHWM:")).expect("a peak"));
}

/// What the process of its own does.
fn validates(folder: &Path) {
    tell_peak(|| {
        let report = validate(folder, &ValidationOptions::default());
        // Synthetic records look more alike than scans do; what counts is that all of them were decoded.
        assert!(report.samples >= 6 && report.images == 14 * report.samples, "{report}");
    });
}

#[test]
fn memory_of_validation_is_flat() {
    if let Some(folder) = std::env::var_os(FOLDER) {
        return validates(Path::new(&folder));
    }
    let peaks = [6, 36].map(|samples| {
        let place = tempfile::tempdir().expect("a folder");
        write(place.path(), samples);
        peak("memory_of_validation_is_flat", &[(FOLDER, place.path().as_os_str())])
    });
    // 30 samples more would be 450 MB decoded and 60 MB as files. What may grow is what the allocator leaves unused.
    println!("peak of 6 and of 36 samples: {peaks:?} MB");
    assert!(peaks[1] < peaks[0] + 30.0, "{peaks:?} MB");
}

/// Small scans of a small board, whose f-number may be drawn.
fn small_recipe(f_number: f64) -> Recipe {
    let mut text = include_str!("../recipes/wood-small.yaml").to_string();
    let drawn = format!("f_number: {{uniform: [{f_number}, 2.8]}}");
    let changes = [("columns: 256 ", "columns: 64 "), ("profiles: 256 ", "profiles: 16 "), ("f_number: 2.8", &drawn)];
    for (from, to) in changes {
        assert!(text.contains(from), "no {from}");
        text = text.replacen(from, to, 1);
    }
    Recipe::parse("small.yaml", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// What the process of its own does.
fn generates(folder: &Path, asked: &str) {
    let asked: Vec<f64> = asked.split(' ').map(|number| number.parse().expect("a number")).collect();
    let [samples, per_shard, f_number] = asked[..] else { panic!("{asked:?}") };
    let recipe = small_recipe(f_number);
    let request = DatasetRequest {
        samples: samples as u64,
        seed: 5,
        out: folder.into(),
        part: (0, 1),
        samples_per_shard: Some(per_shard as u64),
    };
    tell_peak(|| {
        let made = generate(&recipe, &request, Vec::new(), &|_| ()).expect("it is made");
        assert_eq!(made.samples, request.samples);
    });
}

/// In many shards and in one; with patterns of speckle that hardly two samples share, and of all finenesses.
#[test]
fn memory_of_generation_is_flat_and_said_before() {
    const NAME: &str = "memory_of_generation_is_flat_and_said_before";
    if let (Some(folder), Ok(asked)) = (std::env::var_os(FOLDER), std::env::var(SAMPLES)) {
        return generates(Path::new(&folder), &asked);
    }
    for (numbers, per_shard, f_number, more) in [([900, 2400], 10, 2.5, 25.0), ([40, 120], 120, 1.0, 80.0)] {
        let ask = |samples: u64| {
            let place = tempfile::tempdir().expect("a folder");
            let asked = format!("{samples} {per_shard} {f_number}");
            peak(NAME, &[(FOLDER, place.path().as_os_str()), (SAMPLES, asked.as_ref())])
        };
        let mut peaks = numbers.map(ask);
        if peaks[1] >= peaks[0] + more {
            // How many shards are open at once depends on what else the machine does: what grows does so twice.
            peaks[1] = peaks[1].min(ask(numbers[1]));
        }
        let said = MemoryEstimate::of_dataset(&small_recipe(f_number), 2).needed as f64 / 1e6;
        println!("{per_shard} samples a shard: peak of {numbers:?} samples {peaks:?} MB, said {said} MB");
        // Groups of rows and open tables fill in the first hundreds of samples. 1500 samples more weigh 40 MB as files,
        // and 80 stacks of patterns 3 GB. What may grow is what of allocated memory has not been used before.
        assert!(peaks[1] < peaks[0] + more && peaks[1] < said && said < 2.5 * peaks[1], "{peaks:?} MB, said {said}");
    }
}

/// Fibres of a picture take no more for each pixel than is said before, and hardly less: of colours of 16 bits, where
/// no pixels are put together.
#[test]
fn memory_of_fibres_is_said_before() {
    if let Some(folder) = std::env::var_os(FOLDER) {
        let picture = Path::new(&folder).join("board.png");
        return tell_peak(|| {
            let order = ["gen", "fibres", "--pixel-mm", "0.15", "--encoding", "srgb"].map(OsString::from);
            assert_eq!(sheetlight::cli::run_from(order.into_iter().chain([picture.into()])), 0);
        });
    }
    let board =
        image::load_from_memory(include_bytes!("../recipes/pictures/board.png")).expect("a picture").into_rgb16();
    let sides = [700, 1500];
    let peaks = sides.map(|side| {
        let place = tempfile::tempdir().expect("a folder");
        // Beside its mirror image, again and again: nothing jumps.
        let at = |i: u32, count: u32| if (i / count).is_multiple_of(2) { i % count } else { count - 1 - i % count };
        let pixel = |x, y| *board.get_pixel(at(x, board.width()), at(y, board.height()));
        let picture = image::ImageBuffer::from_fn(side, side, pixel);
        picture.save(place.path().join("board.png")).expect("written");
        // Every plane by itself, as those of large pictures are: what is freed goes back at once.
        let variables = [(FOLDER, place.path().as_os_str()), ("MALLOC_MMAP_THRESHOLD_", "65536".as_ref())];
        peak("memory_of_fibres_is_said_before", &variables)
    });
    let pixels = sides.map(|side| u64::from(side).pow(2));
    let each = 1.024e6 * (peaks[1] - peaks[0]) / (pixels[1] - pixels[0]) as f64;
    let said = pixels.map(|pixels| MemoryEstimate::of_picture(pixels).needed);
    let said_each = (said[1] - said[0]) as f64 / (pixels[1] - pixels[0]) as f64;
    println!("pictures of {pixels:?} pixels: peaks {peaks:?} MB, {each:.1} bytes a pixel, said {said_each}");
    assert!(each < said_each && said_each < 1.3 * each, "{each:.1} bytes a pixel, said {said_each}");
    assert!(peaks[1] < said[1] as f64 / 1e6, "{peaks:?} MB");
}
