//! Requests and answers of HTTP/1.1 over a connection that serves one of each, bounded in bytes and in time.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

use serde_json::json;

/// Longest that a whole request may take to come.
pub(super) const REQUEST_TIME: Duration = Duration::from_secs(10);
/// Longest that an answer may take to be taken.
const REPLY_TIME: Duration = Duration::from_secs(60);
/// Longest head of a request [bytes].
const MAX_HEAD_BYTES: usize = 16 << 10;
/// Most headers of a request; browsers send twenty.
const MAX_HEADERS: usize = 64;
/// Longest body: a recipe of the greatest length, each of whose characters JSON may write as two [bytes].
const MAX_BODY_BYTES: usize = (2 * yaml::MAX_FILE_BYTES) + (64 << 10);
/// Longest that what comes of a request that was refused is still read, so that the answer arrives.
const DRAIN_TIME: Duration = Duration::from_secs(2);

/// Bytes that are read at a time.
const READ_BYTES: usize = 16 << 10;

/// What a browser may do with an answer: nothing from elsewhere, in no frame, kept by nobody.
const HEADERS: &str = "Connection: close\r\n\
    Cache-Control: no-store\r\n\
    Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
    connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\
    Cross-Origin-Opener-Policy: same-origin\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\n\
    Referrer-Policy: no-referrer\r\n\
    X-Content-Type-Options: nosniff\r\n\
    X-Frame-Options: DENY\r\n";

/// What a request says before its body.
#[derive(Debug)]
pub(super) struct RequestHead {
    /// POST; GET otherwise.
    pub is_post: bool,
    /// What is asked for, as it was sent: nothing in it is decoded.
    pub path: String,
    /// Names in small letters, and values.
    pub headers: Vec<(String, String)>,
}

impl RequestHead {
    /// The value of a header.
    ///
    /// # Errors
    /// Where it is there twice, which two readers could understand in two ways.
    pub fn header(&self, name: &str) -> Result<Option<&str>, HttpRefusal> {
        let mut found = self.headers.iter().filter(|(own, _)| own == name).map(|(_, value)| value.as_str());
        let first = found.next();
        if found.next().is_some() { Err(HttpRefusal::malformed()) } else { Ok(first) }
    }
}

/// An answer.
#[derive(Debug)]
pub(super) struct HttpReply {
    /// Status.
    pub status: u16,
    /// What the body is.
    pub kind: &'static str,
    /// The body.
    pub body: Vec<u8>,
}

impl HttpReply {
    /// A document.
    pub fn json(document: &serde_json::Value) -> Self {
        Self { status: 200, kind: "application/json", body: document.to_string().into_bytes() }
    }
}

/// Why a request has no answer.
#[derive(Debug)]
pub(super) struct HttpRefusal {
    /// Status.
    pub status: u16,
    /// In words.
    pub why: String,
}

impl HttpRefusal {
    /// Nothing is called so.
    pub fn unknown() -> Self {
        Self { status: 404, why: "nothing is called so".into() }
    }

    /// It is no request that is understood.
    pub fn malformed() -> Self {
        Self { status: 400, why: "this is no request that is understood".into() }
    }

    /// It is larger than anything that the page asks.
    fn too_large(status: u16) -> Self {
        Self { status, why: "the request is larger than any that is answered".into() }
    }
}

impl From<HttpRefusal> for HttpReply {
    fn from(HttpRefusal { status, why }: HttpRefusal) -> Self {
        Self { status, ..Self::json(&json!({ "fault": why })) }
    }
}

impl From<io::Error> for HttpRefusal {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                Self { status: 408, why: "the request came too slowly".into() }
            }
            _ => Self::malformed(),
        }
    }
}

/// Reads the head of a request; what came of its body already comes back beside it.
pub(super) fn read_head(stream: &mut TcpStream, deadline: Instant) -> Result<(RequestHead, Vec<u8>), HttpRefusal> {
    let mut bytes = Vec::new();
    loop {
        let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        match request.parse(&bytes) {
            Ok(httparse::Status::Complete(length)) => {
                let head = head_of(&request)?;
                return Ok((head, bytes.split_off(length)));
            }
            Ok(httparse::Status::Partial) if bytes.len() >= MAX_HEAD_BYTES => return Err(HttpRefusal::too_large(431)),
            Ok(httparse::Status::Partial) => {}
            Err(httparse::Error::TooManyHeaders) => return Err(HttpRefusal::too_large(431)),
            Err(_) => return Err(HttpRefusal::malformed()),
        }
        read_more(stream, &mut bytes, MAX_HEAD_BYTES, deadline)?;
    }
}

fn head_of(request: &httparse::Request<'_, '_>) -> Result<RequestHead, HttpRefusal> {
    let is_post = match request.method {
        Some("GET") => false,
        Some("POST") => true,
        _ => return Err(HttpRefusal { status: 405, why: "GET and POST are answered".into() }),
    };
    let header = |header: &httparse::Header<'_>| {
        let value = std::str::from_utf8(header.value).map_err(|_| HttpRefusal::malformed())?;
        Ok((header.name.to_ascii_lowercase(), value.trim().to_owned()))
    };
    let headers: Result<Vec<_>, HttpRefusal> = request.headers.iter().map(header).collect();
    Ok(RequestHead { is_post, path: request.path.unwrap_or_default().to_owned(), headers: headers? })
}

/// Reads the body of a request, of which `begun` came with its head.
pub(super) fn read_body(
    stream: &mut TcpStream,
    head: &RequestHead,
    mut begun: Vec<u8>,
    deadline: Instant,
) -> Result<Vec<u8>, HttpRefusal> {
    if head.header("transfer-encoding")?.is_some() {
        return Err(HttpRefusal { status: 501, why: "a body comes with its length".into() });
    }
    let length =
        head.header("content-length")?.ok_or(HttpRefusal { status: 411, why: "a body has a length".into() })?;
    if length.is_empty() || !length.bytes().all(|digit| digit.is_ascii_digit()) {
        return Err(HttpRefusal::malformed());
    }
    let length = length.parse().unwrap_or(usize::MAX);
    if length > MAX_BODY_BYTES {
        return Err(HttpRefusal::too_large(413));
    }
    while begun.len() < length {
        read_more(stream, &mut begun, length, deadline)?;
    }
    begun.truncate(length);
    Ok(begun)
}

/// Reads what is there, up to `most` bytes in all, before the deadline.
fn read_more(stream: &mut TcpStream, bytes: &mut Vec<u8>, most: usize, deadline: Instant) -> io::Result<()> {
    let left = deadline.saturating_duration_since(Instant::now());
    if left.is_zero() {
        return Err(ErrorKind::TimedOut.into());
    }
    stream.set_read_timeout(Some(left))?;
    let mut part = [0; READ_BYTES];
    let room = (most - bytes.len()).min(READ_BYTES);
    match stream.read(&mut part[..room])? {
        0 => Err(ErrorKind::UnexpectedEof.into()),
        count => {
            bytes.extend_from_slice(&part[..count]);
            Ok(())
        }
    }
}

/// Writes an answer.
pub(super) fn write_reply(stream: &mut TcpStream, reply: &HttpReply) -> io::Result<()> {
    let HttpReply { status, kind, body } = reply;
    let reason = if *status == 200 { "OK" } else { "Refused" };
    let length = body.len();
    let head =
        format!("HTTP/1.1 {status} {reason}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{HEADERS}\r\n");
    stream.set_write_timeout(Some(REPLY_TIME))?;
    stream.write_all(head.as_bytes())?;
    stream.write_all(body)?;
    stream.flush()
}

/// Ends a connection whose request was not read to its end: closed at once, the system would take the answer back.
pub(super) fn drain(stream: &mut TcpStream) {
    let _ = stream.shutdown(Shutdown::Write);
    let (mut part, deadline) = (Vec::new(), Instant::now() + DRAIN_TIME);
    while read_more(stream, &mut part, READ_BYTES, deadline).is_ok() {
        part.clear();
    }
}
