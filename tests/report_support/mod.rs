//! A page of `gen report` as text, and a browser that opens it.

#![allow(dead_code)]

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::gen_support::Place;

/// Longest that Chromium may take for a page.
const LIMIT: Duration = Duration::from_secs(120);

/// Six boards in `planks`, in two splits, and their page.
pub fn planks_page(arguments: &str) -> (Place, String) {
    let place = Place::with(&[[
        "splits: {train: 0.8, validation: 0.1, test: 0.1}",
        "splits: {train: 0.5, validation: 0, test: 0.5}",
    ]]);
    place.make("planks", "--n 6 --samples-per-shard 4");
    let page = page(&place, "planks", arguments);
    (place, page)
}

/// The page of a dataset, in its usual place.
pub fn page(place: &Place, folder: &str, arguments: &str) -> String {
    place.done(&format!("report {folder} --no-timing {arguments}"));
    std::fs::read_to_string(place.path(&format!("{folder}/reports/report.html"))).expect("the page is there")
}

/// Values of an attribute in the order of the page.
pub fn values<'a>(page: &'a str, attribute: &str) -> Vec<&'a str> {
    let start = format!(" {attribute}=\"");
    page.split(&start).skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

/// The elements of a kind: what lies between `<article class="card"` and its end, for instance.
pub fn between<'a>(page: &'a str, start: &str, end: &str) -> Vec<&'a str> {
    page.split(start).skip(1).filter_map(|rest| rest.split(end).next()).collect()
}

/// What Chromium makes of a file after its scripts ran, in a window of so many pixels. Where it hangs or crashes, the test
/// says how it ended and what it wrote.
pub fn browse(path: &Path, fragment: &str, [width, height]: [u32; 2]) -> String {
    let profile = tempfile::tempdir().expect("a temporary folder");
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let browser = names.into_iter().find(|name| {
        let probe = Command::new(name).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        probe.is_ok_and(|status| status.success())
    });
    let browser = browser.expect("Chromium is missing, in which pages are tested: apt-get install chromium");
    // Files, for a full pipe would stop it.
    let [out, err] = ["out", "err"].map(|name| profile.path().join(name));
    let file = |path: &Path| File::create(path).expect("a file can be written");
    let mut child = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"])
        .args(["--disable-background-networking", "--disable-component-update", "--hide-scrollbars"])
        .args(["--virtual-time-budget=3000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("--window-size={width},{height}"))
        .arg(format!("file://{}{fragment}", path.display()))
        .stdin(Stdio::null())
        .stdout(file(&out))
        .stderr(file(&err))
        .spawn()
        .expect("Chromium starts");
    let start = Instant::now();
    let mut status = child.try_wait().expect("Chromium can be waited for");
    while status.is_none() && start.elapsed() < LIMIT {
        std::thread::sleep(Duration::from_millis(20));
        status = child.try_wait().expect("Chromium can be waited for");
    }
    let told = || String::from_utf8_lossy(&std::fs::read(&err).unwrap_or_default()).into_owned();
    let Some(status) = status else {
        child.kill().and_then(|()| child.wait()).expect("Chromium can be ended");
        panic!("{browser} took more than {LIMIT:?} for {}{fragment}:\n{}", path.display(), told());
    };
    let dom = std::fs::read_to_string(&out).expect("pages are UTF-8");
    assert!(status.success() && dom.contains("</html>"), "{browser} ended with {status}:\n{}\n{dom}", told());
    dom
}
