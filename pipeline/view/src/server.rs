//! The listening socket, and a thread for each connection.

use crate::connections::Connections;
use crate::error::ViewError;
use crate::http::{self, Head, PATIENCE, Way};
use crate::show::Show;
use crate::socket::Socket;
use crate::{frames, page, traced};
use rayon::ThreadPool;
use std::fmt::Write;
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Most viewers at once: connections that came with the token.
const MOST_VIEWERS: usize = 64;
/// Most connections whose request is not there yet; a further one takes the place of the oldest, so
/// that slow ones keep nobody out.
const MOST_WAITING: usize = 16;
/// Pause before another try where the system gives no connection, for want of files or memory.
const PAUSE: Duration = Duration::from_millis(20);

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

    /// Whether the server has been ended.
    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::SeqCst)
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
        let (open, pool) = (&Connections::default(), &pool);
        std::thread::scope(|scope| {
            for number in 0.. {
                let accepted = self.listener.accept();
                if self.stopped.load(Ordering::SeqCst) {
                    break;
                }
                // out of files or memory, or a connection that ended before it was accepted
                let copied = accepted.and_then(|(stream, _)| Ok((stream.try_clone()?, stream)));
                let Ok((copy, stream)) = copied else {
                    open.close_oldest_waiting();
                    std::thread::sleep(PAUSE);
                    continue;
                };
                if open.waiting() >= MOST_WAITING {
                    open.close_oldest_waiting();
                }
                open.add(number, copy);
                let started = std::thread::Builder::new().spawn_scoped(scope, move || {
                    self.connection(show, pool, stream, || open.admit(number, MOST_VIEWERS));
                    open.remove(number);
                });
                if started.is_err() {
                    open.remove(number);
                }
            }
            open.close_all();
            Ok(())
        })
    }

    /// One connection from its first byte to its last; `has_room` says whether there may be one more
    /// viewer. Errors end it: there is nobody to tell.
    fn connection(
        &self,
        show: &Show,
        pool: &ThreadPool,
        mut stream: TcpStream,
        has_room: impl Fn() -> bool,
    ) {
        let _ = stream.set_nodelay(true);
        let _ = stream.set_write_timeout(Some(PATIENCE));
        let admitted = http::read_head(&mut stream).and_then(|head| {
            let way = head.admit(self.address.port(), &self.token)?;
            match has_room() {
                true => Ok((head, way)),
                false => Err(http::FULL),
            }
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
