//! `gen tune`: a page on one's own machine, on which the keys of a recipe are turned and its samples seen at once.
//!
//! A server answers one address of this machine alone, and there the page that it made itself (`door`). A request is
//! read with bounds on its bytes and its time (`connection`). It carries the whole text of the recipe: the server keeps
//! nothing of a page but which of its requests is the newest (`turns`), and what is dear to make again (`samples`).
//! `answers` has what can be asked.

mod answers;
mod connection;
mod door;
mod samples;
mod turns;

use std::io;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use recipe::asset_source::AssetSource;

use self::answers::Answers;
use self::connection::{HttpRefusal, HttpReply, REQUEST_TIME, drain, read_body, read_head, write_reply};
use self::door::Door;

/// Most connections at a time; a browser opens six.
const MAX_CONNECTIONS: usize = 48;

/// Writes a file as a whole or not at all; says why it cannot.
pub type SaveFile = fn(&std::path::Path, &[u8]) -> Result<(), String>;

/// What the page begins with.
#[derive(Debug)]
pub struct TuneStart {
    /// Text of the recipe.
    pub text: String,
    /// Where faults say that it comes from.
    pub origin: String,
    /// The recipe's file, which the page may save to; `None` where it came from elsewhere.
    pub file: Option<PathBuf>,
    /// Folder in which other names are saved.
    pub folder: PathBuf,
    /// Where the files are that it names.
    pub files: AssetSource,
    /// Seed of the draws.
    pub seed: u64,
    /// Sample that is shown first.
    pub index: u64,
    /// Threads that render.
    pub threads: usize,
    /// How files are written.
    pub save: SaveFile,
}

/// A server that has its port and answers nobody yet.
#[derive(Debug)]
pub struct TuneServer {
    listener: TcpListener,
    door: Arc<Door>,
    answers: Arc<Answers>,
}

impl TuneServer {
    /// Takes `port` of this machine, or any free one for 0.
    ///
    /// # Errors
    /// The system's, where the port is not free or gives no random numbers.
    pub fn open(start: TuneStart, port: u16) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let door = Arc::new(Door::new(listener.local_addr()?.port())?);
        let answers = Arc::new(Answers::new(start).map_err(io::Error::other)?);
        Ok(Self { listener, door, answers })
    }

    /// The address of the page. Whoever knows it is let in.
    pub fn address(&self) -> String {
        self.door.address()
    }

    /// Answers until the process ends.
    pub fn serve(&self) {
        let open = Arc::new(AtomicUsize::new(0));
        for stream in self.listener.incoming() {
            // A connection that failed before it was taken is its other end's trouble.
            let Ok(stream) = stream else { continue };
            if open.fetch_add(1, Ordering::Relaxed) >= MAX_CONNECTIONS {
                open.fetch_sub(1, Ordering::Relaxed);
                continue;
            }
            let (door, answers, counted) = (Arc::clone(&self.door), Arc::clone(&self.answers), Arc::clone(&open));
            let started = std::thread::Builder::new().name("tune".into()).spawn(move || {
                converse(stream, &door, &answers);
                counted.fetch_sub(1, Ordering::Relaxed);
            });
            if started.is_err() {
                open.fetch_sub(1, Ordering::Relaxed);
            }
        }
    }
}

/// One request and its answer.
fn converse(mut stream: TcpStream, door: &Door, answers: &Answers) {
    let asked = catch_unwind(AssertUnwindSafe(|| ask(&mut stream, door, answers)));
    let fault = "a fault of gen itself: please report it with the recipe";
    let reply = asked.unwrap_or_else(|_| Err(HttpRefusal { status: 500, why: fault.into() }));
    let refused = reply.is_err();
    // Whoever has gone away needs no answer.
    if write_reply(&mut stream, &reply.unwrap_or_else(HttpReply::from)).is_ok() && refused {
        drain(&mut stream);
    }
}

fn ask(stream: &mut TcpStream, door: &Door, answers: &Answers) -> Result<HttpReply, HttpRefusal> {
    let deadline = Instant::now() + REQUEST_TIME;
    let (head, begun) = read_head(stream, deadline)?;
    // Nothing more is read of strangers.
    let path = door.admit(&head)?;
    match path {
        "" | "tune.css" | "tune.js" if !head.is_post => Ok(answers.page(path)),
        _ if head.is_post => {
            let name = path.strip_prefix("api/").ok_or_else(HttpRefusal::unknown)?;
            let body = read_body(stream, &head, begun, deadline)?;
            answers.answer(name, &body)
        }
        _ => Err(HttpRefusal::unknown()),
    }
}
