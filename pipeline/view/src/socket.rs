//! A WebSocket on which every question is answered before the next is read.

use crate::http::Head;
use serde_json::Value;
use std::io::Write;
use std::net::TcpStream;
use tungstenite::handshake::derive_accept_key;
use tungstenite::protocol::{Role, WebSocket, WebSocketConfig};
use tungstenite::{Bytes, Message};

/// Longest question in bytes.
const LONGEST: usize = 64 * 1024;

/// One viewer's socket.
pub struct Socket(WebSocket<TcpStream>);

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
        Ok(Socket(socket))
    }

    /// The next question.
    pub fn ask(&mut self) -> Result<String, Ended> {
        loop {
            match self.0.read() {
                Ok(Message::Text(text)) => return Ok(text.to_string()),
                Ok(Message::Close(_)) | Err(_) => {
                    // the reply to a close, if it can still be sent
                    let _ = self.0.flush();
                    return Err(Ended);
                }
                Ok(_) => {}
            }
        }
    }

    /// Sends facts.
    pub fn tell(&mut self, facts: &Value) -> Result<(), Ended> {
        let text = Message::Text(facts.to_string().into());
        self.0.send(text).map_err(|_| Ended)
    }

    /// Sends bytes.
    pub fn send(&mut self, bytes: Vec<u8>) -> Result<(), Ended> {
        let bytes = Message::Binary(Bytes::from(bytes));
        self.0.send(bytes).map_err(|_| Ended)
    }
}
