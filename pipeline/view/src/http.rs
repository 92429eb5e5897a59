//! The little of HTTP that the page needs: a request's head, read within bounds, and whether it
//! may come in.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Longest head of a request in bytes.
const LONGEST: usize = 16 * 1024;
/// Most header lines.
const MOST_HEADERS: usize = 64;
/// Time that a request's head may take.
pub const PATIENCE: Duration = Duration::from_secs(5);

/// A request's head.
#[derive(Debug, Default, PartialEq)]
pub struct Head {
    method: String,
    path: String,
    token: Option<String>,
    host: Option<String>,
    origin: Option<String>,
    upgrade: bool,
    /// `Sec-WebSocket-Key`.
    pub key: Option<String>,
    /// Bytes that were read beyond the head.
    pub rest: Vec<u8>,
}

/// Purpose of a request that is let in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The page itself.
    Page,
    /// The WebSocket of frames.
    Frames,
    /// The WebSocket of path tracing.
    Trace,
}

/// Answer to a request that is not let in: status line and body.
pub type Refusal = (&'static str, &'static str);

const BAD: Refusal = (
    "400 Bad Request",
    "not a request that this server understands\n",
);
const METHOD: Refusal = ("405 Method Not Allowed", "only GET\n");
const FOREIGN: Refusal = ("403 Forbidden", "not asked from this server's own page\n");
const TOKEN: Refusal = (
    "403 Forbidden",
    "the URL that rrf view printed has a token; this one has another or none\n",
);
const NOTHING: Refusal = ("404 Not Found", "nothing here\n");
/// Too many connections.
pub const FULL: Refusal = ("503 Service Unavailable", "too many viewers\n");

/// Reads a request's head.
pub fn read_head(stream: &mut TcpStream) -> Result<Head, Refusal> {
    let end = Instant::now() + PATIENCE;
    let mut bytes = Vec::new();
    let mut buffer = [0; 2048];
    loop {
        if let Some(head) = parse(&bytes)? {
            return Ok(head);
        }
        let left = end.saturating_duration_since(Instant::now());
        if bytes.len() >= LONGEST || left.is_zero() {
            return Err(BAD);
        }
        stream.set_read_timeout(Some(left)).map_err(|_| BAD)?;
        match stream.read(&mut buffer) {
            Ok(count) if count > 0 => bytes.extend_from_slice(&buffer[..count]),
            _ => return Err(BAD),
        }
    }
}

/// The head at the start of `bytes`, once all of it is there.
fn parse(bytes: &[u8]) -> Result<Option<Head>, Refusal> {
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut request = httparse::Request::new(&mut headers);
    let httparse::Status::Complete(length) = request.parse(bytes).map_err(|_| BAD)? else {
        return Ok(None);
    };
    let target = request.path.unwrap_or_default();
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    let token = query
        .split('&')
        .find_map(|pair| pair.strip_prefix("token="));
    let mut head = Head {
        method: request.method.unwrap_or_default().into(),
        path: path.into(),
        token: token.map(Into::into),
        rest: bytes[length..].to_vec(),
        ..Head::default()
    };
    for header in request.headers.iter() {
        let value = std::str::from_utf8(header.value).map_err(|_| BAD)?.trim();
        let slot = match header.name.to_ascii_lowercase().as_str() {
            "host" => &mut head.host,
            "origin" => &mut head.origin,
            "sec-websocket-key" => &mut head.key,
            "upgrade" => {
                head.upgrade = value.eq_ignore_ascii_case("websocket");
                continue;
            }
            // a body would have to be read, or be taken for the next request
            "content-length" | "transfer-encoding" if value != "0" => return Err(BAD),
            _ => continue,
        };
        if slot.replace(value.into()).is_some() {
            return Err(BAD);
        }
    }
    Ok(Some(head))
}

impl Head {
    /// The request's purpose, if it may come in. `Host` has to be this machine's loopback name and
    /// `Origin`, which a WebSocket must have, this server: a name that someone else's page
    /// made to resolve here (DNS rebinding) is neither.
    pub fn admit(&self, port: u16, token: &str) -> Result<Way, Refusal> {
        let host = self.host.as_deref().ok_or(BAD)?;
        let names = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{port}"));
        if !names.iter().any(|name| name == host) {
            return Err(FOREIGN);
        }
        let own = format!("http://{host}");
        if self.origin.as_ref().is_some_and(|origin| *origin != own) {
            return Err(FOREIGN);
        }
        if !self
            .token
            .as_deref()
            .is_some_and(|given| same(given, token))
        {
            return Err(TOKEN);
        }
        if self.method != "GET" {
            return Err(METHOD);
        }
        let way = match self.path.as_str() {
            "/" => return Ok(Way::Page),
            "/frames" => Way::Frames,
            "/trace" => Way::Trace,
            _ => return Err(NOTHING),
        };
        if !self.upgrade || self.key.is_none() {
            return Err(BAD);
        }
        if self.origin.is_none() {
            return Err(FOREIGN);
        }
        Ok(way)
    }

    /// The name by which this server was asked.
    pub fn host(&self) -> &str {
        self.host.as_deref().unwrap_or_default()
    }
}

/// Equality in a time that does not tell where two texts differ.
fn same(a: &str, b: &str) -> bool {
    let differing = a.bytes().zip(b.bytes()).fold(0, |d, (a, b)| d | (a ^ b));
    a.len() == b.len() && differing == 0
}

/// Sends an answer and its body; the connection ends with it.
pub fn answer(
    stream: &mut TcpStream,
    status: &str,
    kind: &str,
    more: &str,
    body: &str,
) -> std::io::Result<()> {
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {}\r\n\
         Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
         Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
         Cross-Origin-Opener-Policy: same-origin\r\nConnection: close\r\n{more}\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(body.as_bytes())?;
    stream.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOCKET: &str = "GET /frames?token=abc HTTP/1.1\r\nHost: 127.0.0.1:8000\r\n\
        Origin: http://127.0.0.1:8000\r\nUpgrade: websocket\r\nSec-WebSocket-Key: k\r\n\r\n";

    fn admitted(request: &str) -> Result<Way, &'static str> {
        let head = parse(request.as_bytes()).map_err(|(status, _)| status)?;
        let way = head.unwrap().admit(8000, "abc");
        way.map_err(|(status, _)| status)
    }

    #[test]
    fn the_page_and_its_sockets_come_in() {
        let page = "GET /?token=abc HTTP/1.1\r\nHost: localhost:8000\r\n\r\n";
        assert_eq!(admitted(page), Ok(Way::Page));
        assert_eq!(admitted(SOCKET), Ok(Way::Frames));
        assert_eq!(admitted(&SOCKET.replace("frames", "trace")), Ok(Way::Trace));
    }

    #[test]
    fn everyone_else_stays_out() {
        let changes = [
            ("token=abc", "token=abd", "403"),
            ("token=abc", "token=ab", "403"),
            ("?token=abc", "", "403"),
            ("Host: 127.0.0.1:8000", "Host: evil.example:8000", "403"),
            ("Host: 127.0.0.1:8000", "Host: 127.0.0.1:8001", "403"),
            ("Host: 127.0.0.1:8000\r\n", "", "400"),
            (
                "Host: 127.0.0.1:8000",
                "Host: a\r\nHost: 127.0.0.1:8000",
                "400",
            ),
            ("http://127.0.0.1:8000", "http://evil.example", "403"),
            ("Origin: http://127.0.0.1:8000\r\n", "", "403"),
            ("Upgrade: websocket", "Upgrade: h2c", "400"),
            ("GET", "POST", "405"),
            ("/frames", "/etc/passwd", "404"),
            ("Upgrade", "Content-Length: 5\r\nUpgrade", "400"),
            ("HTTP/1.1", "HTTP/3.7", "400"),
        ];
        for (from, to, status) in changes {
            let request = SOCKET.replacen(from, to, 1);
            let refused = admitted(&request).unwrap_err();
            assert!(
                request != SOCKET && refused.starts_with(status),
                "{to}: {refused}"
            );
        }
    }

    #[test]
    fn a_head_in_pieces_is_waited_for() {
        for cut in 0..SOCKET.len() {
            assert_eq!(parse(&SOCKET.as_bytes()[..cut]), Ok(None), "{cut}");
        }
    }
}
