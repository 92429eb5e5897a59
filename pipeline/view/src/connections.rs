//! Open connections: those that wait for their request, and viewers.

use std::collections::BTreeMap;
use std::net::{Shutdown, TcpStream};
use std::sync::{Mutex, MutexGuard};

/// A connection that is open.
struct Connection {
    stream: TcpStream,
    /// Whether its request came with the token.
    admitted: bool,
}

/// Open connections by number, oldest first, so that some or all can be closed from outside their
/// threads.
#[derive(Default)]
pub struct Connections(Mutex<BTreeMap<u64, Connection>>);

impl Connections {
    /// No thread panics while it holds the list.
    fn list(&self) -> MutexGuard<'_, BTreeMap<u64, Connection>> {
        self.0.lock().unwrap_or_else(|poison| poison.into_inner())
    }

    /// Adds a connection, which waits for its request.
    pub fn add(&self, number: u64, stream: TcpStream) {
        let admitted = false;
        self.list().insert(number, Connection { stream, admitted });
    }

    /// Makes a connection a viewer, if there are less than `most`.
    pub fn admit(&self, number: u64, most: usize) -> bool {
        let mut list = self.list();
        let viewers = list.values().filter(|c| c.admitted).count();
        match list.get_mut(&number) {
            Some(connection) if viewers < most => connection.admitted = true,
            _ => return false,
        }
        true
    }

    /// Forgets a connection.
    pub fn remove(&self, number: u64) {
        self.list().remove(&number);
    }

    /// How many wait for their request.
    pub fn waiting(&self) -> usize {
        self.list().values().filter(|c| !c.admitted).count()
    }

    /// Ends the connection that has waited longest for its request.
    pub fn close_oldest_waiting(&self) {
        let mut list = self.list();
        let oldest = list.iter().find(|(_, c)| !c.admitted);
        if let Some(number) = oldest.map(|(&number, _)| number)
            && let Some(connection) = list.remove(&number)
        {
            let _ = connection.stream.shutdown(Shutdown::Both);
        }
    }

    /// Ends all connections.
    pub fn close_all(&self) {
        for connection in self.list().values() {
            let _ = connection.stream.shutdown(Shutdown::Both);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;
    use std::net::TcpListener;

    #[test]
    fn the_oldest_that_waits_makes_room_and_viewers_stay() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let open = Connections::default();
        let mut theirs = Vec::new();
        for number in 0..3 {
            theirs.push(TcpStream::connect(address).unwrap());
            open.add(number, listener.accept().unwrap().0);
        }
        assert!(open.admit(0, 1));
        assert!(!open.admit(1, 1), "one viewer is all that is allowed");
        assert_eq!(open.waiting(), 2);
        open.close_oldest_waiting();
        assert_eq!(open.waiting(), 1);
        assert_eq!(theirs[1].read(&mut [0]).unwrap(), 0, "closed");
        assert!(!open.admit(1, 9), "it is gone");
        open.close_all();
        for stream in &mut theirs {
            assert_eq!(stream.read(&mut [0]).unwrap(), 0);
        }
    }
}
