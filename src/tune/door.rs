//! Who is answered: the page that this program made, in a browser of this machine.
//!
//! Other users and programs of the machine don't know the token in the address. Pages of other origins don't either,
//! and a browser says for them where they come from (`Origin`, `Sec-Fetch-Site`). A name that somebody makes lead to
//! 127.0.0.1 stands in `Host`. What is asked by POST is JSON, which no form of another page can send.

use std::io;

use super::connection::{HttpRefusal, RequestHead};

/// Bytes of the token: more than anybody tries.
const TOKEN_BYTES: usize = 24;

/// The one address that is answered.
#[derive(Debug)]
pub(super) struct Door {
    host: String,
    origin: String,
    token: String,
}

impl Door {
    /// With a new token, for a port of this machine.
    pub fn new(port: u16) -> io::Result<Self> {
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes).map_err(io::Error::other)?;
        let host = format!("127.0.0.1:{port}");
        let token = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { origin: format!("http://{host}"), host, token })
    }

    /// The address of the page.
    pub fn address(&self) -> String {
        format!("{}/{}/", self.origin, self.token)
    }

    /// What is asked for, behind the token.
    ///
    /// # Errors
    /// Whoever does not come from the page itself, or has not its address.
    pub fn admit<'h>(&self, head: &'h RequestHead) -> Result<&'h str, HttpRefusal> {
        let refused = |why: &str| Err(HttpRefusal { status: 403, why: why.into() });
        if head.header("host")? != Some(self.host.as_str()) {
            return refused("this is no name of this server");
        }
        if head.header("origin")?.is_some_and(|origin| origin != self.origin) {
            return refused("pages of other origins are not answered");
        }
        let site = head.header("sec-fetch-site")?;
        if !matches!(site, None | Some("same-origin")) && (head.is_post || site != Some("none")) {
            return refused("pages of other origins are not answered");
        }
        let given = head.path.strip_prefix('/').and_then(|path| path.split_once('/'));
        let Some((_, rest)) = given.filter(|(token, _)| are_same(token.as_bytes(), self.token.as_bytes())) else {
            return refused("the address lacks its token: take it as gen tune printed it");
        };
        if head.is_post && head.header("content-type")? != Some("application/json") {
            return Err(HttpRefusal { status: 415, why: "questions are JSON".into() });
        }
        Ok(rest)
    }
}

/// Whether two texts are the same, in a time that does not tell where they differ.
fn are_same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |unlike, (a, b)| std::hint::black_box(unlike | (a ^ b))) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(method: &str, path: &str, headers: &[(&str, &str)]) -> RequestHead {
        let headers = headers.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect();
        RequestHead { is_post: method == "POST", path: path.to_owned(), headers }
    }

    #[test]
    fn the_page_alone_is_let_in() {
        let door = Door::new(4000).expect("there are random numbers");
        let path = door.address().strip_prefix("http://127.0.0.1:4000").expect("it is on this machine").to_owned();
        let host = ("host", "127.0.0.1:4000");
        let json = ("content-type", "application/json");
        let api = format!("{path}api/state");
        assert!(matches!(door.admit(&head("GET", &path, &[host, ("sec-fetch-site", "none")])), Ok("")));
        let own = [host, json, ("origin", "http://127.0.0.1:4000"), ("sec-fetch-site", "same-origin")];
        assert!(matches!(door.admit(&head("POST", &api, &own)), Ok("api/state")));
        let nearly = format!("{}0/", &path[..path.len() - 2]);
        for (method, path, headers) in [
            ("GET", path.as_str(), &[][..]),
            ("GET", &path, &[("host", "localhost:4000")]),
            ("GET", &path, &[("host", "evil.example:4000")]),
            ("GET", &path, &[host, host]),
            ("GET", &path, &[host, ("sec-fetch-site", "cross-site")]),
            ("GET", &path, &[host, ("sec-fetch-site", "same-site")]),
            ("GET", &path, &[host, ("origin", "null")]),
            ("POST", &api, &[host, json, ("origin", "http://127.0.0.1:4001")]),
            ("POST", &api, &[host, json, ("sec-fetch-site", "none")]),
            ("POST", &api, &[host]),
            ("POST", &api, &[host, ("content-type", "text/plain")]),
            ("GET", "/", &[host]),
            ("GET", "//", &[host]),
            ("GET", if nearly == path { "/x/" } else { &nearly }, &[host]),
        ] {
            assert!(door.admit(&head(method, path, headers)).is_err(), "{method} {path} {headers:?}");
        }
        assert_ne!(door.token, Door::new(4000).expect("there are random numbers").token);
    }
}
