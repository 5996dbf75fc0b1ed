//! Memory that a run takes, and what the machine has.
//!
//! A sample holds its maps while it is rendered, and every channel once more while it is encoded; sizes of both follow
//! from the recipe. What is available is asked of Linux: of the machine, and of the group of processes that a container
//! is. Where the system does not say, nothing is refused.

use std::fs;
use std::path::Path;

use dataset::Fault;
use recipe::Recipe;

use super::{FRAME_BYTES, TRIANGLE_BYTES, in_flight_of};
use optical_bench::settings::{Channel, Output};
use scanner::optics::speckle::{MAX_CACHED_BYTES, bytes_of_stack};

/// Bytes of a pixel while it is rendered: three measured maps, class and instance.
const RENDERED_BYTES: u64 = 3 * 4 + 1 + 2;
/// Bytes of a pixel in its truth maps, three at most.
const TRUTH_BYTES: u64 = 3 * 4;
/// Bytes of a pixel of the channel of the EXR file that is being made: maps go as channels come.
const CONVERTED_BYTES: u64 = 2 * 4;
/// Bytes of a pixel of a channel of the EXR file: of what is compressed beyond its map, and of the file.
const CHANNEL_BYTES: u64 = 1 + 1;
/// Bytes of a pixel of a PNG while it is encoded, and of the file.
const PNG_BYTES: u64 = 2;
/// Bytes of a pixel of a sample that waits to be written: its files.
const WRITTEN_BYTES: u64 = 10;
/// Bytes of a column of the rows that a thread holds about its band: 98 of 284 bytes on `wood.yaml`; other recipes'
/// peaks were measured as a whole.
const BAND_BYTES: u64 = 28_000;
/// What lamps add to both.
const GREY_BYTES: u64 = 4;
const GREY_BAND_BYTES: u64 = 5_000;
/// What a run takes whatever its recipe and threads: the program, tables of light, and what the allocator keeps.
/// Measured where samples are so many that all of it was touched: thousands [bytes].
const BASE_BYTES: u64 = 80 << 20;
/// Bytes of a pixel of a picture whose fibres are looked for, measured where no pixels are put together: 33.
const PICTURE_BYTES: u64 = 36;
/// Share of draws of a key that may lie beyond what is counted, at either end [1].
const RARE_DRAW: f64 = 1e-4;

/// Memory that a run takes at most, and what the machine has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryEstimate {
    /// What it takes [bytes].
    pub needed: u64,
    /// What is there for it; `None` where the system does not say [bytes].
    pub available: Option<u64>,
    /// What takes less.
    remedy: &'static str,
}

/// What takes less memory where samples are rendered.
const FEWER_PIXELS: &str = "take fewer scan.profiles or scan.columns, fewer channels (output.truth_maps: false), fewer \
    --threads, or a machine with more memory";

impl MemoryEstimate {
    /// For a dataset that `threads` threads make.
    pub fn of_dataset(recipe: &Recipe, threads: usize) -> Self {
        let (size, output) = (recipe.size(), recipe.output());
        let pixels = (size.columns * size.profiles) as u64;
        let written = pixels / (output.bin_columns * output.bin_profiles).max(1) as u64;
        let frames = (FRAME_BYTES * output.frames(&size) * size.columns * size.rows) as u64;
        let each = pixels * rendered(&output) + written * encoded(&output) + frames + triangles(recipe);
        let together = in_flight_of(recipe, threads);
        let rendering = together.min(threads as u64);
        let waiting = (together - rendering) * (written * WRITTEN_BYTES + frames);
        let per_shard = dataset::samples_per_shard(&output, &size, recipe.sample_seconds()) as u64;
        let tables = dataset::open_tables_bytes(&output, &size, &recipe.splits(), per_shard);
        let patterns = MAX_CACHED_BYTES as u64 + together.min(threads as u64) * patterns(recipe);
        let needed = BASE_BYTES + tables + patterns + rendering * each + waiting + bands(recipe, threads);
        Self { needed, available: available(), remedy: FEWER_PIXELS }
    }

    /// For one sample that `threads` threads draw.
    pub fn of_preview(recipe: &Recipe, threads: usize) -> Self {
        let size = recipe.size();
        let each = (size.columns * size.profiles) as u64 * rendered(&recipe.output());
        // Programs draw one sample after the other, and keep patterns.
        let patterns = MAX_CACHED_BYTES as u64 + patterns(recipe);
        let needed = BASE_BYTES + patterns + each + bands(recipe, threads) + triangles(recipe);
        Self { needed, available: available(), remedy: FEWER_PIXELS }
    }

    /// For the fibres of a picture of so many pixels.
    pub fn of_picture(pixels: u64) -> Self {
        let remedy = "crop the picture, average pixels to 0.15 mm, or take a machine with more memory";
        Self { needed: BASE_BYTES + pixels * PICTURE_BYTES, available: available(), remedy }
    }

    /// Whether the machine has it; true where the system does not say.
    pub fn fits(&self) -> bool {
        self.available.is_none_or(|available| self.needed <= available)
    }

    /// Refuses what the machine does not have.
    ///
    /// # Errors
    /// How much is missing, and what to do.
    pub fn check(&self) -> Result<(), Fault> {
        if self.fits() {
            return Ok(());
        }
        let gb = |bytes: u64| format!("{:.1} GB", bytes as f64 / 1e9);
        let what = format!("it takes up to {}, {} are available", gb(self.needed), gb(self.available.unwrap_or(0)));
        Err(Fault::new("memory", what, self.remedy))
    }
}

fn bands(recipe: &Recipe, threads: usize) -> u64 {
    let lamps = if recipe.output().has(Channel::Grey) { GREY_BAND_BYTES } else { 0 };
    threads as u64 * recipe.size().columns as u64 * (BAND_BYTES + lamps)
}

/// Patterns of speckle of a sample, of the finest grain and the most looks that draws have, but for one in 10^4 of a
/// key.
fn patterns(recipe: &Recipe) -> u64 {
    let (low, high) = (RARE_DRAW, 1.0 - RARE_DRAW);
    let drawn = |path: &str, share: f64| {
        let declared = recipe.parameters().find(|(parameter, _)| parameter.path() == path);
        let (parameter, _) = declared.unwrap_or_else(|| panic!("no table declares {path}"));
        let of_class = recipe.classes().iter().filter_map(|class| recipe.distribution(&class.name, path));
        let ends = of_class.map(|distribution| distribution.quantile(parameter, share));
        ends.reduce(if share < 0.5 { f64::min } else { f64::max }).expect("every recipe has a class")
    };
    // The working f-number is larger than the lens' own, which makes the grain coarser.
    let finest =
        drawn("laser.wavelength_nm", low) * 1e-3 * drawn("camera.f_number", low) / drawn("camera.pixel_um", high);
    bytes_of_stack(finest, ["speckle.surface_patterns", "speckle.volume_patterns"].map(|path| drawn(path, high))) as u64
}

fn rendered(output: &Output) -> u64 {
    let lamps = if output.has(Channel::Grey) { GREY_BYTES } else { 0 };
    RENDERED_BYTES + lamps + if output.truth_maps { TRUTH_BYTES } else { 0 }
}

fn encoded(output: &Output) -> u64 {
    let truth = if output.truth_maps { 3 } else { 0 };
    // Reflectance is there twice.
    let channels = output.exr_names().len() as u64 + u64::from(output.exr.contains(&Channel::Reflectance)) + truth;
    CONVERTED_BYTES + channels * CHANNEL_BYTES + output.png.len() as u64 * PNG_BYTES
}

fn triangles(recipe: &Recipe) -> u64 {
    recipe.mesh().map_or(0, |mesh| TRIANGLE_BYTES * mesh.triangles.len()) as u64
}

/// Groups of processes of either version: what stands before their name, their folder, and the names of the files that
/// say what they may take and take, and of the line that says how much of that are files.
const GROUPS: [(&str, &str, [&str; 3]); 2] = [
    ("0::/", "/sys/fs/cgroup", ["memory.max", "memory.current", "inactive_file"]),
    (":memory:/", "/sys/fs/cgroup/memory", ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"]),
];

/// Memory that this process may still take [bytes]; `None` where the system does not say.
fn available() -> Option<u64> {
    let read = |path: &Path| fs::read_to_string(path).ok();
    let machine = read(Path::new("/proc/meminfo")).and_then(|text| of_machine(&text));
    let groups = read(Path::new("/proc/self/cgroup")).unwrap_or_default();
    let group = |(start, root, names): (&str, &str, [&str; 3])| {
        let own = groups.lines().find_map(|line| line.split_once(start)).map(|(_, own)| own)?;
        // A container may see its own group as the root.
        [Path::new(root).join(own), root.into()].into_iter().find_map(|folder| {
            let [most, current, files] = names;
            let file = |name: &str| read(&folder.join(name));
            of_group(&file(most)?, &file(current)?, (&file("memory.stat").unwrap_or_default(), files))
        })
    };
    machine.into_iter().chain(GROUPS.into_iter().filter_map(group)).min()
}

/// What `/proc/meminfo` says is available [bytes].
fn of_machine(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// What a group of processes may still take; of what it holds, files that were read can go [bytes].
fn of_group(most: &str, current: &str, (stat, files): (&str, &str)) -> Option<u64> {
    let [most, current] = [most, current].map(|text| text.trim().parse::<u64>().ok());
    let files =
        stat.lines().find_map(|line| line.strip_prefix(files)?.strip_prefix(' ')?.trim().parse().ok()).unwrap_or(0);
    Some(most?.saturating_sub(current?.saturating_sub(files)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the system writes is understood, and what it does not write refuses nothing.
    #[test]
    fn what_is_available_is_read() {
        let text = "MemTotal:       16303428 kB\nMemFree:          812344 kB\nMemAvailable:    2097152 kB\n";
        assert_eq!((of_machine(text), of_machine("MemTotal: 1 kB\n")), (Some(2 << 30), None));
        let stat = "anon 5\ninactive_file 1000\n";
        assert_eq!(of_group("5000\n", "3000\n", (stat, "inactive_file")), Some(3000));
        assert_eq!(of_group("max\n", "3000\n", (stat, "inactive_file")), None);
        assert!(MemoryEstimate { needed: u64::MAX, available: None, remedy: FEWER_PIXELS }.check().is_ok());
        let refused = MemoryEstimate { needed: 9_300_000_000, available: Some(2 << 30), remedy: FEWER_PIXELS }
            .check()
            .expect_err("too much");
        assert!(refused.to_string().contains("up to 9.3 GB, 2.1 GB are available; take fewer"), "{refused}");
    }

    /// The largest recipe took 6.0 GB when it was measured (three samples, two threads), and is told up to a half more;
    /// a small one, which took 0.29 for 7000 samples, up to 0.45.
    #[test]
    fn the_largest_recipe_is_told() {
        let text = |columns: usize, profiles: usize| {
            let small = include_str!("../../recipes/wood-small.yaml");
            let text = small.replacen("columns: 256 ", &format!("columns: {columns} "), 1);
            text.replacen("profiles: 256 ", &format!("profiles: {profiles} "), 1)
        };
        let needed = |columns, profiles| {
            let recipe = Recipe::parse("a.yaml", &text(columns, profiles)).unwrap_or_else(|error| panic!("{error}"));
            MemoryEstimate::of_dataset(&recipe, 2).needed as f64 / 1e9
        };
        let (largest, small) = (needed(8192, 16383), needed(256, 256));
        assert!((6.0..1.5 * 6.0).contains(&largest) && (0.29..0.45).contains(&small), "{largest} and {small} GB");
        // Each thread holds rows of its own, also where there are more threads than samples in work.
        let recipe = Recipe::parse("a.yaml", &text(2560, 256)).unwrap_or_else(|error| panic!("{error}"));
        let [few, many] = [2, 64].map(|threads| MemoryEstimate::of_dataset(&recipe, threads).needed);
        assert!(many - few >= 62 * 70_000_000, "{few} and {many} bytes");
    }
}
