//! The page of `gen report` in Chromium: filters by class and split, and no scrolling sideways on a phone or a laptop.

mod gen_support;
mod report_support;

use report_support::{between, browse, planks_page, values};

/// What the test's own copy of a page tells about its width: of the document and of the window [px].
const PROBE: &str = "<script>addEventListener('load', () => \
    parent.postMessage(document.documentElement.scrollWidth + ' ' + innerWidth, '*'));</script>";

/// A filter in the address hides what it should and nothing else, in the sheet and among the frames.
#[test]
fn filters_work_by_the_address() {
    let (place, html) = planks_page("");
    let path = place.path("planks/reports/report.html");
    let shown = |fragment: &str| {
        let dom = browse(&path, fragment, [1366, 768]);
        let cards = between(&dom, "<article class=\"card\"", "</article>");
        assert_eq!(cards.len(), 6, "every card is in the page");
        let told = between(&dom, "<output id=\"shown\"", "</output>")[0].to_owned();
        let open = cards.iter().filter(|card| !card.split('>').next().unwrap_or("").contains("hidden"));
        let mut ids: Vec<String> = open.map(|card| values(card, "id")[0].to_owned()).collect();
        ids.sort();
        assert!(told.contains(&format!(">{} sample", ids.len())), "{told}");
        ids
    };
    let cards = between(&html, "<article class=\"card\"", "</article>");
    let of = |attribute: &str, value: &str| {
        let mut ids: Vec<String> = cards
            .iter()
            .filter(|card| values(card, attribute)[0] == value)
            .map(|card| values(card, "id")[0].to_owned())
            .collect();
        ids.sort();
        ids
    };
    let class = values(cards[0], "data-class")[0];
    let split = values(cards[5], "data-split")[0];
    assert_eq!(shown("").len(), 6);
    assert!(!of("data-class", class).is_empty() && of("data-class", class).len() < 6);
    assert_eq!(shown(&format!("#class={class}")), of("data-class", class));
    assert_eq!(shown(&format!("#split={split}")), of("data-split", split));
    assert_eq!(shown("#class=%3Cscript%3E").len(), 6, "an unknown class filters nothing");
}

/// Nothing scrolls sideways, however narrow the window is.
#[test]
fn pages_fit_their_window() {
    let (place, html) = planks_page("");
    place.write("probe.html", html.replace("</body>", &format!("{PROBE}</body>")));
    for width in [390, 1366] {
        // Windows of Chromium are 500 px wide at least; a frame in a page is as wide as it is told to be.
        let frame = format!(
            "<!doctype html><p id=probe></p><script>onmessage = (e) => {{ probe.textContent = e.data; }}</script>\
             <iframe src=probe.html style='width:{width}px;height:844px;border:0'></iframe>"
        );
        place.write("frame.html", frame);
        let dom = browse(&place.path("frame.html"), "", [1500, 900]);
        let told = between(&dom, "<p id=\"probe\">", "</p>")[0];
        let numbers: Vec<u32> = told.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let [document, window] = numbers[..] else { panic!("{width}: the page tells `{told}`") };
        assert!(window == width && document <= window, "{width}: the document is {document} px wide in {window} px");
    }
}
