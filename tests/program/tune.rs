//! `gen tune` as a stranger meets it: who is answered, and what is never done.

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpStream};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use test_support::program::{Place, recipe};

/// A server, which ends with this value.
struct Served {
    child: Child,
    port: u16,
    /// Path of the page: the token between two strokes.
    path: String,
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Served {
    fn of(place: &Place, arguments: &str) -> Self {
        let mut child = place.command(&format!("tune {arguments}")).stderr(Stdio::null()).spawn().expect("it starts");
        let mut address = String::new();
        BufReader::new(child.stdout.take().expect("it is piped")).read_line(&mut address).expect("it says its address");
        let rest = address.trim().strip_prefix("http://127.0.0.1:").unwrap_or_else(|| panic!("no address: {address}"));
        let (port, path) = rest.split_once('/').expect("a path stands behind the port");
        Self { child, port: port.parse().expect("it is a port"), path: format!("/{path}") }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port)).expect("it listens");
        stream.set_read_timeout(Some(Duration::from_secs(60))).expect("a time can be set");
        stream
    }

    /// The answer to these bytes: its status, head and body; status 0 where it closes without one.
    fn raw(&self, request: &[u8]) -> (u16, String, Vec<u8>) {
        let mut stream = self.connect();
        // It may answer and close before it has all.
        let _ = stream.write_all(request);
        answer(stream)
    }

    fn host(&self) -> String {
        format!("Host: 127.0.0.1:{}\r\n", self.port)
    }

    fn get(&self, path: &str, headers: &str) -> u16 {
        self.raw(format!("GET {path} HTTP/1.1\r\n{headers}\r\n").as_bytes()).0
    }

    /// The answer to a question as the page asks it.
    fn ask(&self, name: &str, question: &Value) -> (u16, Vec<u8>) {
        let (body, port) = (question.to_string(), self.port);
        let head = format!(
            "POST {}api/{name} HTTP/1.1\r\n{}Origin: http://127.0.0.1:{port}\r\nSec-Fetch-Site: same-origin\r\n\
             Content-Type: application/json\r\nContent-Length: {}\r\n\r\n",
            self.path,
            self.host(),
            body.len()
        );
        let (status, _, body) = self.raw(&[head.as_bytes(), body.as_bytes()].concat());
        (status, body)
    }

    fn json(&self, name: &str, question: &Value) -> Value {
        let (status, body) = self.ask(name, question);
        assert_eq!(status, 200, "{name}: {}", String::from_utf8_lossy(&body));
        serde_json::from_slice(&body).unwrap_or_else(|_| panic!("{name} is no JSON"))
    }
}

fn answer(mut stream: TcpStream) -> (u16, String, Vec<u8>) {
    let mut bytes = Vec::new();
    match stream.read_to_end(&mut bytes) {
        Err(error) if error.kind() == ErrorKind::WouldBlock => panic!("no end of the answer"),
        _ => {}
    }
    let Some(end) = bytes.windows(4).position(|four| four == b"\r\n\r\n") else { return (0, String::new(), bytes) };
    let head = String::from_utf8_lossy(&bytes[..end]).into_owned();
    let status = head.split(' ').nth(1).and_then(|word| word.parse().ok()).unwrap_or(0);
    (status, head, bytes.split_off(end + 4))
}

/// The page itself has what a browser needs to know of it, and loads its parts alone.
#[test]
fn the_page_is_served_to_who_has_its_address() {
    let place = Place::with(&[]);
    let served = Served::of(&place, "tiny.yaml");
    let request = |path: &str| format!("GET {path} HTTP/1.1\r\n{}\r\n", served.host());
    let (status, head, body) = served.raw(request(&served.path).as_bytes());
    let page = String::from_utf8(body).expect("it is text");
    assert_eq!(status, 200, "{head}");
    for header in [
        "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'",
        "frame-ancestors 'none'",
        "Cache-Control: no-store",
        "X-Content-Type-Options: nosniff",
        "Referrer-Policy: no-referrer",
        "Cross-Origin-Resource-Policy: same-origin",
    ] {
        assert!(head.contains(header), "no {header}:\n{head}");
    }
    assert!(!head.to_lowercase().contains("access-control"), "no other origin may read answers:\n{head}");
    assert!(page.contains("</html>") && !page.contains("://"), "the page loads nothing from elsewhere");
    for part in ["tune.css", "tune.js"] {
        assert_eq!(served.get(&format!("{}{part}", served.path), &served.host()), 200, "{part}");
    }
}

/// Other names, other origins, no token, other methods, names of files: each is refused, and the page still answers.
#[test]
fn strangers_are_refused() {
    let place = Place::with(&[]);
    place.write("secret.txt", "secret");
    let served = Served::of(&place, "tiny.yaml");
    let (own, host, port) = (served.path.clone(), served.host(), served.port);
    let other = format!("{}0/", &own[..own.len() - 2]);
    let other = if other == own { format!("{}1/", &own[..own.len() - 2]) } else { other };
    for (path, headers, wanted) in [
        (own.clone(), String::new(), 403),
        (own.clone(), format!("Host: localhost:{port}\r\n"), 403),
        (own.clone(), format!("Host: evil.example:{port}\r\n"), 403),
        (own.clone(), format!("{host}{host}"), 400),
        (own.clone(), format!("{host}Origin: https://evil.example\r\n"), 403),
        (own.clone(), format!("{host}Origin: null\r\n"), 403),
        (own.clone(), format!("{host}Sec-Fetch-Site: cross-site\r\n"), 403),
        ("/".into(), host.clone(), 403),
        ("/tune.js".into(), host.clone(), 403),
        (other, host.clone(), 403),
        (own[..own.len() - 1].into(), host.clone(), 403),
        (format!("{own}secret.txt"), host.clone(), 404),
        (format!("{own}../secret.txt"), host.clone(), 404),
        (format!("{own}%2e%2e/secret.txt"), host.clone(), 404),
        (format!("{own}/etc/passwd"), host.clone(), 404),
        (format!("{own}api/state"), host.clone(), 404),
        (format!("{own}?x"), host.clone(), 404),
    ] {
        assert_eq!(served.get(&path, &headers), wanted, "{path} {headers}");
    }
    let post = |headers: &str| {
        let request = format!("POST {own}api/start HTTP/1.1\r\n{host}{headers}Content-Length: 2\r\n\r\n{{}}");
        served.raw(request.as_bytes()).0
    };
    let json = "Content-Type: application/json\r\n";
    assert_eq!(post(json), 200);
    assert_eq!(post(""), 415);
    assert_eq!(post("Content-Type: text/plain\r\n"), 415);
    assert_eq!(post(&format!("{json}Origin: http://127.0.0.1:{}\r\n", port ^ 1)), 403);
    assert_eq!(post(&format!("{json}Sec-Fetch-Site: none\r\n")), 403);
    for method in ["PUT", "DELETE", "OPTIONS", "HEAD"] {
        assert_eq!(served.raw(format!("{method} {own} HTTP/1.1\r\n{host}\r\n").as_bytes()).0, 405, "{method}");
    }
    assert_eq!(served.raw(b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\r\n\r\n").0, 400, "no HTTP");
    assert_eq!(served.ask("nothing", &json!({})).0, 404);
    assert_eq!(served.ask("state", &json!({ "text": 3 })).0, 400);
    assert_eq!(served.get(&own, &host), 200, "it still answers");
}

/// What is larger or slower than any question of the page is given up, and keeps nobody else waiting.
#[test]
#[ignore = "long"]
fn huge_and_slow_requests_are_given_up() {
    let place = Place::with(&[]);
    let served = Served::of(&place, "tiny.yaml");
    let (own, host) = (served.path.clone(), served.host());
    let head =
        |length: &str| format!("POST {own}api/start HTTP/1.1\r\n{host}Content-Type: application/json\r\n{length}\r\n");
    assert_eq!(served.raw(head("Content-Length: 99999999999999999999999\r\n").as_bytes()).0, 413);
    assert_eq!(served.raw(head("Content-Length: 5000000\r\n").as_bytes()).0, 413);
    assert_eq!(served.raw(head("Content-Length: -1\r\n").as_bytes()).0, 400);
    assert_eq!(served.raw(head("Content-Length: 2\r\nContent-Length: 2\r\n").as_bytes()).0, 400);
    assert_eq!(served.raw(head("").as_bytes()).0, 411);
    assert_eq!(served.raw(head("Transfer-Encoding: chunked\r\n").as_bytes()).0, 501);
    let long = format!("GET {own} HTTP/1.1\r\n{host}X: {}\r\n\r\n", "x".repeat(64 << 10));
    assert_eq!(served.raw(long.as_bytes()).0, 431);
    let many = format!("GET {own} HTTP/1.1\r\n{host}{}\r\n", "X: 1\r\n".repeat(100));
    assert_eq!(served.raw(many.as_bytes()).0, 431);

    // Requests that never end are given up by their time, also where a byte comes now and then.
    let mut slow: Vec<TcpStream> = (0..8).map(|_| served.connect()).collect();
    slow.iter_mut().for_each(|stream| stream.write_all(b"GET ").expect("it takes the beginning"));
    let mut body = served.connect();
    body.write_all(head("Content-Length: 100\r\n").as_bytes()).expect("it takes the head");
    assert_eq!(served.get(&own, &host), 200, "others are answered meanwhile");
    let begun = Instant::now();
    while body.write_all(b" ").is_ok() && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(500));
        body.set_nonblocking(true).expect("it can be asked");
        let is_answered = !matches!(body.peek(&mut [0]), Err(error) if error.kind() == ErrorKind::WouldBlock);
        body.set_nonblocking(false).expect("it can be asked");
        if is_answered {
            break;
        }
    }
    assert_eq!(answer(body).0, 408);
    for stream in slow {
        assert_eq!(answer(stream).0, 408);
    }
}

/// Faults of a recipe are told with line, key and remedy; edits keep comments; a region comes as its numbers.
#[test]
fn the_page_is_told_what_a_recipe_is() {
    let place = Place::with(&[]);
    let served = Served::of(&place, "tiny.yaml --set camera.tilt_deg=31");
    let start = served.json("start", &json!({}));
    let text = start["text"].as_str().expect("it has a text").to_owned();
    assert!(text.contains("  tilt_deg: 31\n"), "the change stands in its place:\n{text}");
    let question = |text: &str, more: Value| {
        let mut question = json!({ "text": text, "seed": 0, "index": 1, "page": "a", "turn": 1 });
        question.as_object_mut().expect("a map").extend(more.as_object().expect("a map").clone());
        question
    };
    let edit = json!({ "edit": { "key": "laser.power_mw", "value": "44" } });
    let state = served.json("state", &question(&text, edit));
    assert_eq!(state["states"]["laser.power_mw"]["value"], 44.0);
    assert_eq!(state["text"].as_str().expect("a text"), text.replace("  power_mw: 50\n", "  power_mw: 44\n"));
    let edit = json!({ "edit": { "key": "laser.power_mw", "value": "44000" } });
    let state = served.json("state", &question(&text, edit));
    assert_eq!(state["faults"][0]["key"], "laser.power_mw");
    assert!(state["faults"][0]["line"].as_u64() > Some(1) && state["faults"][0]["remedy"].is_string(), "{state}");
    for (key, value) in [("laser power", "1"), ("laser.power_mw", "{"), ("laser.power_mw", "[1")] {
        let state = served.json("state", &question(&text, json!({ "edit": { "key": key, "value": value } })));
        assert_eq!(state["status"], 422, "{key}={value}: {state}");
    }
    let asked = json!({ "look": 1, "profile": 20, "column": 30, "profiles": 16, "columns": 20 });
    let (status, bytes) = served.ask("region", &question(&text, asked));
    let length = u32::from_le_bytes(bytes[..4].try_into().expect("four bytes")) as usize;
    let head: Value = serde_json::from_slice(&bytes[4..4 + length]).expect("a head of JSON");
    assert_eq!((status, &head["profiles"], &head["columns"]), (200, &json!(16), &json!(20)));
    assert_eq!(bytes.len(), 4 + length + 16 * 20 * (3 * 4 + 2 + 1));
    let huge = json!({ "profile": 0, "column": 0, "profiles": 100_000_000_000_u64, "columns": 100_000_000_000_u64 });
    assert_eq!(served.json("region", &question(&text, huge))["status"], 422);
    // What a newer turn of the page has taken the place of is dropped.
    served.json("rig", &question(&text, json!({ "turn": 7 })));
    assert_eq!(served.json("rig", &question(&text, json!({ "turn": 6 })))["status"], 409);
}

/// The picture that the page offers is that of `gen preview`, byte for byte.
#[test]
fn the_picture_is_that_of_preview() {
    let place = Place::with(&[]);
    place.done("preview tiny.yaml --index 2 --seed 4 --out of-preview.png");
    let served = Served::of(&place, "tiny.yaml");
    let question = json!({ "text": recipe(&[]), "seed": 4, "index": 2, "page": "a", "turn": 1 });
    let (_, picture) = served.ask("picture", &question);
    assert!(picture == std::fs::read(place.path("of-preview.png")).expect("it is there"), "another picture");
}

/// Only a recipe beside the recipe is written, never over what is there unless one says so.
#[test]
fn saving_stays_in_its_folder() {
    let place = Place::with(&[]);
    place.write("there.yaml", "mine");
    std::fs::create_dir(place.path("inner")).expect("a folder");
    let served = Served::of(&place, "tiny.yaml");
    let text = format!("# new\n{}", recipe(&[]));
    let save = |more: Value| {
        let mut question = json!({ "text": text });
        question.as_object_mut().expect("a map").extend(more.as_object().expect("a map").clone());
        served.json("save", &question)
    };
    let before = place.tree("");
    for name in [
        "../out.yaml",
        "/tmp/out.yaml",
        "inner/out.yaml",
        "inner\\out.yaml",
        "C:out.yaml",
        ".hidden.yaml",
        "out.txt",
        "out",
        ".yaml",
        "",
        "..",
        "a\u{0}.yaml",
        "-n.yaml",
        "nul.yaml",
        "com1.yaml",
        &format!("{}.yaml", "x".repeat(80)),
    ] {
        assert_eq!(save(json!({ "name": name, "replace": true }))["status"], 422, "{name}");
    }
    assert_eq!(save(json!({ "name": "there.yaml" }))["status"], 409);
    assert_eq!(place.tree(""), before, "nothing was written");
    assert_eq!(save(json!({ "name": "there.yaml", "replace": true }))["saved"], "there.yaml");
    assert_eq!(save(json!({ "name": "new.yaml" }))["saved"], "new.yaml");
    assert_eq!(save(json!({}))["saved"], "tiny.yaml");
    for name in ["there.yaml", "new.yaml", "tiny.yaml"] {
        assert_eq!(std::fs::read_to_string(place.path(name)).expect("it is there"), text, "{name}");
    }
    // What somebody else has changed meanwhile is not lost.
    place.write("tiny.yaml", "theirs");
    assert_eq!(save(json!({}))["status"], 409);
    assert_eq!(std::fs::read_to_string(place.path("tiny.yaml")).expect("it is there"), "theirs");
    let built_in = Served::of(&place, "wood-small");
    assert_eq!(built_in.json("save", &json!({ "text": text }))["status"], 422, "a built-in recipe has no file");
}

/// A file with faults is opened all the same; what is no recipe is refused, and so is a port that is taken.
#[test]
fn what_is_opened_and_what_is_not() {
    let place = Place::with(&[]);
    place.write("faulty.yaml", recipe(&[["\n  power_mw: 50", "\n  power_mw: -1"]]));
    let served = Served::of(&place, "faulty.yaml");
    let text = served.json("start", &json!({}))["text"].clone();
    let state = served.json("state", &json!({ "text": text, "seed": 0, "index": 0 }));
    assert_eq!(state["faults"][0]["key"], "laser.power_mw");
    place.run("tune nothing.yaml").refused(&["nothing.yaml"]);
    place.run(&format!("tune tiny.yaml --port {}", served.port)).refused(&["cannot listen", "--port"]);
    assert_eq!(place.run("tune tiny.yaml --port 0").code, 2);
    // A script would show another sample than the one of that number.
    assert_eq!(place.run("tune tiny.yaml --seed 9007199254740992").code, 2);
    assert_eq!(place.run("tune tiny.yaml --index 9007199254740992").code, 2);
}

/// Ctrl-C ends it with the status of shells for that.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_it() {
    let place = Place::with(&[]);
    let mut served = Served::of(&place, "tiny.yaml");
    let _open = served.connect();
    let kill = std::process::Command::new("kill").args(["-INT", &served.child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
    assert_eq!(served.child.wait().expect("it ends").code(), Some(130));
}
