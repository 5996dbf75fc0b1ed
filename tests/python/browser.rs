//! Chromium, and what it makes of a page.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longest that Chromium may take for a page.
const LIMIT: Duration = Duration::from_secs(120);

/// What Chromium makes of a file after its scripts ran, in a window of so many pixels. Where it hangs or crashes, the
/// test says how it ended and what it wrote.
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
