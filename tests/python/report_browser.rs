//! The page of `gen report` in Chromium: filters by class and split, and no scrolling sideways on a phone or a laptop.

use crate::browser::browse;
use serde_json::json;
use test_support::pages::{between, page, planks_page, values};
use test_support::program::Place;

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
    assert!(!of("data-split", split).is_empty() && of("data-split", split).len() < 6, "the boards have two splits");
    assert_eq!(shown(&format!("#split={split}")), of("data-split", split));
    assert_eq!(shown("#class=%3Cscript%3E").len(), 6, "an unknown class filters nothing");
}

/// What a page tells after a script of the test's own used it in a window of so many pixels.
fn used(place: &Place, html: &str, window: [u32; 2], script: &str) -> String {
    let tell = "const tell = (words) => { document.body.appendChild(document.createElement('output')).id = 'told'; \
        document.getElementById('told').textContent = words; };";
    place.write("used.html", html.replace("</body>", &format!("<script>{tell}{script}</script></body>")));
    let dom = browse(&place.path("used.html"), "", window);
    between(&dom, "<output id=\"told\">", "</output>")[0].to_owned()
}

/// In the large view the arrow keys go on from sample to sample, from wherever the focus is, and `l` goes on too.
#[test]
fn keys_work_more_than_once() {
    let (place, html) = planks_page("--frames 0");
    let script = "
        const press = (key) => document.activeElement.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true \
        }));
        const large = () => document.querySelector('dialog h3').firstChild.textContent.trim();
        document.querySelectorAll('a.maps')[0].click();
        document.querySelectorAll('dialog button')[1].focus();
        const seen = [large()];
        for (const key of ['ArrowRight', 'ArrowRight', 'ArrowRight', 'ArrowLeft']) { press(key); seen.push(large()); }
        const labels = [0, 1, 2].map(() => { press('l'); return document.getElementById('labels').checked; });
        tell([...seen, ...labels, document.querySelectorAll('dialog .card').length].join(';'));";
    let cards = between(&html, "<article class=\"card\"", "</article>");
    let title = |card: usize| between(cards[card], "<h3>", "<span")[0].trim().to_owned();
    let wanted = [title(0), title(1), title(2), title(3), title(2), "false;true;false;1".into()];
    assert_eq!(used(&place, &html, [1366, 768], script), wanted.join(";"));
}

/// The address keeps filter, labels and search, and a link to a section takes none of them away.
#[test]
fn the_address_keeps_everything() {
    let (place, html) = planks_page("--frames 0");
    let script = "
        const set = (input, event, change) => { change(input); input.dispatchEvent(new Event(event, { bubbles: true \
        })); };
        document.getElementById('labels').click();
        set(document.getElementById('find'), 'input', (input) => { input.value = 'knots width'; });
        document.querySelector('input[name=\"split\"][value=\"test\"]').click();
        const full = location.hash;
        document.documentElement.style.scrollBehavior = 'auto';
        document.querySelector('nav a[href=\"#numbers\"]').click();
        const there = Math.abs(document.getElementById('numbers').getBoundingClientRect().top) < innerHeight;
        tell([full, location.hash, document.activeElement.id, scrollY > 0 && there].join(' '));";
    let hash = "#split=test&amp;labels=off&amp;find=knots+width";
    assert_eq!(used(&place, &html, [1366, 768], script), format!("{hash} {hash} numbers true"));
    let dom = browse(&place.path("planks/reports/report.html"), "#labels=off&find=knots+width", [1366, 768]);
    let numbers = between(&dom, "class=\"multiple\"", ">");
    let open = numbers.iter().filter(|number| !number.contains("hidden")).count();
    assert!(open > 0 && open < numbers.len(), "{open} of {} numbers", numbers.len());
}

/// A tap makes every map of a sample larger, on a laptop and on a phone, upright or lying, with labels or without. The
/// place of a map that is not kept is as large as its neighbours, and none in the large view.
#[test]
fn the_large_view_is_large() {
    let upright = ["\n  profiles: 48 ", "\n  profiles: 120 "];
    let bare = [
        ["png: [range, reflectance, scatter, label]", "png: [range, reflectance]"],
        ["exr: [range, reflectance, scatter, label, instance]", "exr: []"],
    ];
    let script = "
        const sizes = (selector) => [...document.querySelectorAll(selector)].map((map) => map.getBoundingClientRect())
            .filter((box) => box.width > 0).map((box) => [box.width, box.height, box.top].map(Math.round).join(' \
            ')).join(';');
        const small = sizes('#s0 .map');
        document.querySelector('#s0 a.maps').click();
        tell(small + '/' + sizes('dialog .map') + '/' + document.querySelector('dialog').clientWidth + ' 0 0');";
    for changes in [vec![], vec![upright], bare.to_vec(), [bare.as_slice(), &[upright]].concat()] {
        let place = Place::with(&changes);
        place.make("planks", "--n 1");
        let html = page(&place, "planks", "--frames 0");
        for (window, share) in [([1366, 768], 0.3), ([500, 900], 0.85)] {
            let told = used(&place, &html, window, script);
            let row = |text: &str| -> Vec<f64> { text.split(' ').map(|n| n.parse().expect("a number")).collect() };
            let parts: Vec<Vec<Vec<f64>>> = told.split('/').map(|part| part.split(';').map(row).collect()).collect();
            let [small, large, dialog] = &parts[..] else { panic!("{told}") };
            let kept = html.matches("<img").count();
            assert!(small.len() == 3 && large.len() == kept && kept == if changes.len() > 1 { 2 } else { 3 }, "{told}");
            for (before, after) in small.iter().zip(large) {
                assert!(
                    after[0] > 1.5 * before[0] && after[0] > share * dialog[0][0],
                    "{changes:?}: {window:?}: {told}"
                );
                let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1.0);
                assert!(same(before, &small[0]), "maps in a row are alike: {changes:?}: {told}");
                assert!(same(&after[..2], &large[0][..2]), "maps in the large view are alike: {changes:?}: {told}");
            }
        }
    }
}

/// Nothing that a drawing says or marks lies outside of it.
#[test]
fn drawings_are_whole() {
    let (place, _) = planks_page("--frames 0");
    let bin = |place: f64| json!({"confidence": place, "accuracy": place, "count": 5});
    let check = json!({
        "format": "sheetlight-check", "model": {}, "task": "segment", "split": "all", "accuracy": {}, "classes": [],
            "confusion": [],
        "calibration": {"error": 0.0, "bins": [bin(0.0), bin(0.5), bin(1.0)]},
    });
    place.write("planks/reports/check-x-all.json", check.to_string());
    let html = page(&place, "planks", "--frames 2");
    assert!(html.contains(">logarithmic</text>") && html.matches("class=\"point\"").count() == 3);
    let script = "
        const cut = [...document.querySelectorAll('svg text, svg circle')].filter((mark) => {
            const [inner, outer] = [mark, mark.ownerSVGElement].map((one) => one.getBoundingClientRect());
            return inner.left < outer.left - .5 || inner.right > outer.right + .5 || inner.top < outer.top - .5
                || inner.bottom > outer.bottom + .5;
        });
        tell(cut.map((mark) => mark.ownerSVGElement.getAttribute('class') + ':' + (mark.textContent || \
        mark.tagName)).join(';'));";
    assert_eq!(used(&place, &html, [1366, 768], script), "");
}

/// Nothing scrolls sideways, however narrow the window is and however long the words of kept results are.
#[test]
fn pages_fit_their_window() {
    let (place, _) = planks_page("--frames 0");
    let long = "aNameWithoutAnyBlank".repeat(8);
    let fault = json!({"code": "file-checksum", "place": long, "what": long, "remedy": long});
    let validation = json!({
        "format": "sheetlight-validation", "clean": false, "faults": [fault], "samples": 6,
            "paths": [{long.as_str(): long}],
    });
    let shares =
        json!({"accuracy": 0.5, "low": 0.25, "high": 0.75, "samples": 6, "of": 6, "from": 1.5, "to": 123_456.5});
    let class =
        json!({"name": long, "support": 6, "guessed": 6, "precision": 0.5, "recall": 0.5, "f1": 0.5, "iou": 0.5});
    let wrong = json!({"index": 1, "first": [1, 2], "truth": long, "guess": long, "confidence": 0.75});
    let check = json!({
        "format": "sheetlight-check", "model": {"sha256": "0"}, "task": "segment", "split": "all", "samples": 6,
        "accuracy": shares, "classes": [class, class], "confusion": [[123_456, 1], [1, 123_456]],
        "calibration": {"error": 0.5, "bins": []}, "slices": [{"column": long, "groups": [shares]}], "worst": [wrong],
    });
    place.write("planks/reports/validation.json", validation.to_string());
    place.write(&format!("planks/reports/check-{}-all.json", &long[..100]), check.to_string());
    let html = page(&place, "planks", "");
    assert!(html.matches(&long).count() > 10, "the results are on the page");
    fits(&place, &html);
    place.write("planks/dataset.json", "{\"format\": 1");
    assert_eq!(place.run("report planks --out none.html").code, 1);
    let html = std::fs::read_to_string(place.path("none.html")).expect("a page");
    assert!(html.contains("No dataset can be read here"));
    fits(&place, &html);
}

/// Faults a page that is wider than its window.
fn fits(place: &Place, html: &str) {
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
