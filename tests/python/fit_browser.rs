//! The pages of `gen fit` and `gen cover` in Chromium: every section, pictures, the filter of statistics, no request,
//! and no scrolling sideways on a phone.

use serde_json::Value;
use test_support::pages::between;
use test_support::program::{Place, sawtooth_recipe};

use crate::browser::browse;

/// What a copy of the page tells of itself: faults and requests from its first line on, and what is seen once it is
/// there, before and after a click on the filter.
const PROBE: [&str; 2] = [
    "<script>
    const faults = [];
    addEventListener('error', (event) => faults.push('error: ' + (event.message || event.target.outerHTML)), true);
    addEventListener('securitypolicyviolation', (event) => faults.push('refused: ' + event.blockedURI));
    console.error = console.warn = (...words) => faults.push('console: ' + words.join(' '));
    </script>",
    "<script>addEventListener('load', () => {
    const is_seen = (element) => element.getBoundingClientRect().height > 0;
    const rows = () => [...document.querySelectorAll('table.statistics tbody tr')].filter(is_seen);
    const names = (rows) => rows.map((row) => row.querySelector('th').textContent);
    const images = [...document.images];
    const sections = [...document.querySelectorAll('main > section')].filter((part) => \
    part.getBoundingClientRect().height > 60);
    const all = rows();
    document.getElementById('only-out').click();
    const out = rows();
    document.getElementById('only-out').click();
    const told = {
        sections: sections.map((part) => part.id),
        images: images.length,
        decoded: images.filter((image) => image.complete && image.naturalWidth > 0).length,
        sizes: [...new Set(images.map((image) => image.naturalWidth + ' ' + image.naturalHeight))],
        drawings: [...document.querySelectorAll('svg.strip')].filter(is_seen).length,
        rows: all.length,
        marked: names(all.filter((row) => /out of reach|outside/.test(row.textContent))),
        out: names(out),
        again: rows().length,
        requests: performance.getEntriesByType('resource').map((entry) => entry.name).filter((name) => \
        !name.startsWith('data:')),
        faults,
    };
    document.body.appendChild(document.createElement('output')).id = 'told';
    document.getElementById('told').textContent = JSON.stringify(told);
    });</script>",
];

/// A page tells what a browser makes of it.
fn told(place: &Place, page: &str) -> Value {
    let strict = "style-src 'unsafe-inline'";
    assert_eq!(page.matches(strict).count(), 1, "the page says what a browser may load");
    let page = page
        .replace(strict, &format!("{strict}; script-src 'unsafe-inline'"))
        .replace("<title>", &format!("{}<title>", PROBE[0]))
        .replace("</body>", &format!("{}</body>", PROBE[1]));
    place.write("probe.html", page);
    let dom = browse(&place.path("probe.html"), "", [1366, 768]);
    let told = between(&dom, "<output id=\"told\">", "</output>");
    assert_eq!(told.len(), 1, "the page tells nothing of itself:\n{dom}");
    serde_json::from_str(&told[0].replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")).expect("it is JSON")
}

/// A fit of a small saw-tooth, of which one scan has more noise than any recipe of the prior makes.
#[test]
fn the_page_of_a_fit_works() {
    let text = sawtooth_recipe(&[["\n  profiles: 48 ", "\n  profiles: 64 "]]);
    let (head, rest) = text.split_once("\nclasses:").expect("the recipe has classes");
    let (_, tail) = rest.split_once("\nextraction:").expect("settings of extraction stand behind them");
    let place = Place::new();
    place.write("tiny.yaml", format!("{head}\nclasses: {{even: {{share: 1}}}}\n\nextraction:{tail}"));
    place.make(
        "real",
        "--n 1 --seed 5 --set laser.waist_mm=0.12 --set exposure.time_us=40 --set exposure.dark_noise_dn=6",
    );
    place.done("fit --recipe tiny.yaml --real real --simulations 400 --rounds 2 --out fitted.yaml");
    let page = std::fs::read_to_string(place.path("fitted.html")).expect("the page is beside the recipe");
    assert!(!page.contains("://") && !page.contains("<script"), "the page is one file without scripts");

    let seen = told(&place, &page);
    let count = |key: &str| seen[key].as_u64().unwrap_or_else(|| panic!("no number `{key}` in {seen:#}"));
    let list = |key: &str| list_of(&seen, key);
    assert_eq!(list("sections"), ["maps", "keys", "statistics", "reach", "recipe"]);
    assert_eq!((count("images"), count("decoded")), (9, 9), "three kinds of maps on three sides");
    assert_eq!(list("sizes"), ["64 64"], "pixels are those of the maps");
    assert_eq!((count("drawings"), count("again")), (count("rows"), count("rows")));
    let out = list("out");
    assert!(!out.is_empty() && out.len() < count("rows") as usize, "{seen:#}");
    assert_eq!(out, list("marked"), "the filter leaves what is marked");
    assert!(list("requests").is_empty() && list("faults").is_empty(), "{seen:#}");

    // The probe itself sees what it should.
    let broken = page.replace("<nav", "<img src=\"http://127.0.0.1:9/x.png\"><nav");
    assert!(!list_of(&told(&place, &broken), "faults").is_empty(), "a request is seen");

    fits_a_phone(&place, &page);
}

/// What `gen cover` says of a scan with more noise than the recipe draws.
#[test]
fn the_page_of_a_cover_works() {
    let place = Place::new();
    place.write("tiny.yaml", sawtooth_recipe(&[["\n  profiles: 48 ", "\n  profiles: 64 "]]));
    place.make("real", "--n 1 --seed 5 --set exposure.dark_noise_dn=12");
    place.done("cover tiny.yaml --real real --simulations 200 --out cover.html");
    let page = std::fs::read_to_string(place.path("cover.html")).expect("the page is written");
    assert!(!page.contains("://") && !page.contains("<script"), "the page is one file without scripts");
    let seen = told(&place, &page);
    let (rows, out) = (seen["rows"].as_u64().expect("a number"), list_of(&seen, "out"));
    assert_eq!(list_of(&seen, "sections"), ["widen", "scans"]);
    assert_eq!((seen["drawings"].as_u64(), seen["again"].as_u64()), (Some(rows), Some(rows)));
    assert!(!out.is_empty() && out.len() < rows as usize, "{seen:#}");
    assert_eq!(out, list_of(&seen, "marked"), "the filter leaves what is marked");
    assert!(list_of(&seen, "requests").is_empty() && list_of(&seen, "faults").is_empty(), "{seen:#}");
    fits_a_phone(&place, &page);
}

/// Faults a page that scrolls sideways on a phone.
fn fits_a_phone(place: &Place, page: &str) {
    let wide = "<script>addEventListener('load', () => \
        parent.postMessage(document.documentElement.scrollWidth + ' ' + innerWidth, '*'));</script>";
    place.write(
        "narrow.html",
        page.replace("style-src", "script-src 'unsafe-inline'; style-src")
            .replace("</body>", &format!("{wide}</body>")),
    );
    let frame = "<!doctype html><p id=probe></p><script>onmessage = (e) => { probe.textContent = e.data; }</script>\
        <iframe src=narrow.html style='width:390px;height:844px;border:0'></iframe>";
    place.write("frame.html", frame);
    let dom = browse(&place.path("frame.html"), "", [1500, 900]);
    let numbers: Vec<u32> =
        between(&dom, "<p id=\"probe\">", "</p>")[0].split_whitespace().filter_map(|word| word.parse().ok()).collect();
    assert!(matches!(numbers[..], [document, 390] if document <= 390), "the page is wider than a phone: {numbers:?}");
}

fn list_of(told: &Value, key: &str) -> Vec<Value> {
    told[key].as_array().unwrap_or_else(|| panic!("no list `{key}` in {told:#}")).clone()
}
