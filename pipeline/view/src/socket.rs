//! A WebSocket on which every question is answered before the next is read.

use crate::http::Head;
use serde_json::Value;
use std::io::{ErrorKind, Write};
use std::net::TcpStream;
use std::sync::Mutex;
use tungstenite::handshake::derive_accept_key;
use tungstenite::protocol::{Role, WebSocket, WebSocketConfig};
use tungstenite::{Bytes, Message};

/// Longest question in bytes.
const LONGEST: usize = 64 * 1024;

/// One viewer's socket.
pub struct Socket {
    socket: WebSocket<TcpStream>,
    /// Held by the thread that looks for a question.
    looks: Mutex<()>,
}

/// The socket has ended: closed by the page, or broken.
#[derive(Debug)]
pub struct Ended;

impl Socket {
    /// Answers the request to upgrade.
    pub fn open(mut stream: TcpStream, head: Head) -> Result<Socket, Ended> {
        let key = derive_accept_key(head.key.unwrap_or_default().as_bytes());
        let answer = format!(
            "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Accept: {key}\r\n\r\n"
        );
        stream.write_all(answer.as_bytes()).map_err(|_| Ended)?;
        stream.set_read_timeout(None).map_err(|_| Ended)?;
        stream.set_write_timeout(None).map_err(|_| Ended)?;
        let config = WebSocketConfig::default()
            .max_message_size(Some(LONGEST))
            .max_frame_size(Some(LONGEST));
        let socket = WebSocket::from_partially_read(stream, head.rest, Role::Server, Some(config));
        let looks = Mutex::default();
        Ok(Socket { socket, looks })
    }

    /// Whether another question has come, or the page has gone; `false` where another thread is looking.
    pub fn has_question(&self) -> bool {
        let Ok(_alone) = self.looks.try_lock() else {
            return false;
        };
        let stream = self.socket.get_ref();
        let peeked = stream
            .set_nonblocking(true)
            .and_then(|()| stream.peek(&mut [0]));
        // where the stream cannot be made to wait again, the next read says so
        let waits = stream.set_nonblocking(false).is_ok();
        !waits || !matches!(&peeked, Err(error) if error.kind() == ErrorKind::WouldBlock)
    }

    /// The next question.
    pub fn ask(&mut self) -> Result<String, Ended> {
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => return Ok(text.to_string()),
                Ok(Message::Close(_)) | Err(_) => {
                    // the reply to a close, if it can still be sent
                    let _ = self.socket.flush();
                    return Err(Ended);
                }
                Ok(_) => {}
            }
        }
    }

    /// Sends facts.
    pub fn tell(&mut self, facts: &Value) -> Result<(), Ended> {
        let text = Message::Text(facts.to_string().into());
        self.socket.send(text).map_err(|_| Ended)
    }

    /// Sends bytes.
    pub fn send(&mut self, bytes: Vec<u8>) -> Result<(), Ended> {
        let bytes = Message::Binary(Bytes::from(bytes));
        self.socket.send(bytes).map_err(|_| Ended)
    }
}
