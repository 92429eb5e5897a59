//! The listening socket, and a thread for each connection.

use crate::error::ViewError;
use crate::http::{self, Head, PATIENCE, Way};
use crate::show::Show;
use crate::socket::Socket;
use crate::{frames, page, traced};
use rayon::ThreadPool;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

/// Most connections at once.
const MOST_CONNECTIONS: usize = 64;

/// A server on the loopback address, not yet answering.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    token: String,
    stopped: Arc<AtomicBool>,
}

/// Ends a server from another thread.
#[derive(Clone)]
pub struct Stopper {
    address: SocketAddr,
    stopped: Arc<AtomicBool>,
}

impl Stopper {
    /// Ends the server: open connections are closed, [`Server::run`] returns.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::SeqCst);
        // wakes the listener, which then sees the flag
        let _ = TcpStream::connect(self.address);
    }
}

/// Open connections by number, so that an ending server can close them.
#[derive(Default)]
struct Open(Mutex<BTreeMap<u64, TcpStream>>);

impl Open {
    /// No thread panics while it holds the list.
    fn list(&self) -> MutexGuard<'_, BTreeMap<u64, TcpStream>> {
        self.0.lock().unwrap_or_else(|poison| poison.into_inner())
    }

    fn close_all(&self) {
        for stream in self.list().values() {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }
}

impl Server {
    /// Listens on `port` of 127.0.0.1; 0 for a free one.
    pub fn bind(port: u16) -> Result<Server, ViewError> {
        let bind = |source| ViewError::Bind { port, source };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(bind)?;
        let address = listener.local_addr().map_err(bind)?;
        Ok(Server {
            listener,
            address,
            token: random_hex()?,
            stopped: Arc::default(),
        })
    }

    /// URL of the page, token included.
    pub fn url(&self) -> String {
        format!("http://{}/?token={}", self.address, self.token)
    }

    /// A handle that ends it.
    pub fn stopper(&self) -> Stopper {
        Stopper {
            address: self.address,
            stopped: Arc::clone(&self.stopped),
        }
    }

    /// Answers until it is stopped.
    pub fn run(&self, show: &Show) -> Result<(), ViewError> {
        let threads = rayon::current_num_threads();
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        let (open, pool) = (&Open::default(), &pool);
        std::thread::scope(|scope| {
            for number in 0.. {
                let accepted = self.listener.accept();
                if self.stopped.load(Ordering::SeqCst) {
                    break;
                }
                let (mut stream, _) = match accepted {
                    Ok(accepted) => accepted,
                    // a connection that ended before it was accepted
                    Err(e) if e.kind() == std::io::ErrorKind::ConnectionAborted => continue,
                    Err(error) => {
                        open.close_all();
                        return Err(ViewError::Accept(error));
                    }
                };
                let Ok(copy) = stream.try_clone() else {
                    continue;
                };
                if open.list().len() >= MOST_CONNECTIONS {
                    let (status, body) = http::FULL;
                    let _ = stream.set_write_timeout(Some(PATIENCE));
                    let _ = http::answer(&mut stream, status, "text/plain", "", body);
                    continue;
                }
                open.list().insert(number, copy);
                scope.spawn(move || {
                    self.connection(show, pool, stream);
                    open.list().remove(&number);
                });
            }
            open.close_all();
            Ok(())
        })
    }

    /// One connection from its first byte to its last. Errors end it: there is nobody to tell.
    fn connection(&self, show: &Show, pool: &ThreadPool, mut stream: TcpStream) {
        let _ = stream.set_nodelay(true);
        let admitted = http::read_head(&mut stream).and_then(|head| {
            let way = head.admit(self.address.port(), &self.token)?;
            Ok((head, way))
        });
        let ended = match admitted {
            Ok((head, Way::Page)) => self.page(&mut stream, &head),
            Ok((head, way)) => {
                if let Ok(mut socket) = Socket::open(stream, head) {
                    let _ended = match way {
                        Way::Trace => traced::serve(show, pool, &mut socket),
                        _ => frames::serve(show, &mut socket),
                    };
                }
                return;
            }
            Err((status, body)) => http::answer(&mut stream, status, "text/plain", "", body),
        };
        if ended.is_ok() {
            let _ = stream.shutdown(Shutdown::Write);
        }
    }

    fn page(&self, stream: &mut TcpStream, head: &Head) -> std::io::Result<()> {
        let nonce = random_hex().map_err(std::io::Error::other)?;
        let policy = page::policy(&nonce, head.host());
        let more = format!("Content-Security-Policy: {policy}\r\n");
        http::answer(
            stream,
            "200 OK",
            "text/html",
            &more,
            &page::document(&nonce),
        )
    }
}

/// 128 random bits as hexadecimal digits.
fn random_hex() -> Result<String, ViewError> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(ViewError::Random)?;
    Ok(bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    }))
}
