//! The server's door: how many connections there are at once, from whom, and which of them makes room for another.
//!
//! A connection is counted before it is accepted; while all places are taken by people who are being served, further ones wait
//! outside, where they cost no descriptor of ours. One that has not shown a session yet is only tolerated: when its address or
//! the whole server is full, the oldest of those makes room, and after them the one with a session that has rested for longest:
//! its last request is answered, and it is no WebSocket. So whoever opens connections and asks for nothing shuts nobody out.

mod answering;
mod descriptors;
mod places;
mod stream;

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use axum::extract::connect_info::Connected;
use axum_server::{AddrListener, Address};
use tokio::net::{TcpListener, TcpStream};

pub use descriptors::Descriptors;
pub use places::{Connection, DoorLimits};
use places::{NoPlace, Place, Places};
pub use stream::Guarded;

/// A listener that lets only so many in.
#[derive(Debug)]
pub struct Door {
    listener: TcpListener,
    places: Arc<Places>,
    limits: DoorLimits,
    turned_away: AtomicU64,
}

impl Door {
    /// A door before a socket that listens.
    ///
    /// # Errors
    /// When the runtime cannot take the socket.
    pub fn new(listener: std::net::TcpListener, limits: DoorLimits) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener: TcpListener::from_std(listener)?,
            places: Arc::default(),
            limits,
            turned_away: AtomicU64::new(0),
        })
    }
}

/// Who came in by the door: what the requests of a connection know about it.
#[derive(Debug, Clone)]
pub struct Caller {
    /// Its connection.
    pub connection: Arc<Connection>,
}

impl Connected<Self> for Caller {
    fn connect_info(caller: Self) -> Self {
        caller
    }
}

impl Address for Caller {
    type Stream = Guarded<TcpStream>;
    type Listener = Door;
}

impl AddrListener<Guarded<TcpStream>, Caller> for Door {
    async fn bind_to(_: Caller) -> io::Result<Self> {
        Err(io::ErrorKind::Unsupported.into())
    }

    async fn accept_stream(&self) -> io::Result<(Guarded<TcpStream>, Caller)> {
        loop {
            self.places.wait_for_room(&self.limits).await;
            let (stream, address) = self.listener.accept().await?;
            let entered = loop {
                match self.places.enter(address.ip(), &self.limits) {
                    Ok(connection) => break Some(connection),
                    Err(NoPlace::TooMany) => break None,
                    // Who was to make room is being served since.
                    Err(NoPlace::Full) => self.places.wait_for_room(&self.limits).await,
                }
            };
            let Some(connection) = entered else {
                let count = self.turned_away.fetch_add(1, Ordering::Relaxed) + 1;
                // The 1st, 2nd, 4th, 8th…: a flood must not fill the log.
                if count.is_power_of_two() {
                    tracing::warn!(%address, count, "turned away: too many connections from there");
                }
                continue;
            };
            let place = Place { places: self.places.clone(), connection: connection.clone() };
            return Ok((Guarded::new(stream, place, &self.limits), Caller { connection }));
        }
    }

    fn get_local_addr(&self) -> io::Result<Caller> {
        // Nobody is at the other end of a listener.
        Err(io::ErrorKind::Unsupported.into())
    }
}

#[cfg(test)]
mod tests;
