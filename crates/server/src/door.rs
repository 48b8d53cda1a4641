//! Connection limits: the number of connections, in total and per address, and which of them is closed for a new one.
//!
//! A connection is counted before it is accepted. While all slots are taken by clients that are being served, further
//! connections stay in the listen backlog, where they use no file descriptors of this process. A connection without a
//! session is only tolerated: when its address or the whole server is full, the oldest of those is closed, and after
//! them the one with a session that has been idle for longest: its last request is answered, and it is not a WebSocket.
//! So a client that opens connections without using them cannot lock out others.

mod answering;
mod descriptors;
mod limits;
mod stream;

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use axum::extract::connect_info::Connected;
use axum_server::{AddrListener, Address};
use tokio::net::{TcpListener, TcpStream};

pub use descriptors::Descriptors;
pub use limits::{Connection, DoorLimits};
use limits::{NoSlot, Slot, Slots};
pub use stream::Guarded;

/// A listener with connection limits.
#[derive(Debug)]
pub struct Door {
    listener: TcpListener,
    slots: Arc<Slots>,
    limits: DoorLimits,
    turned_away: AtomicU64,
}

impl Door {
    /// Wraps a listening socket.
    ///
    /// # Errors
    /// When the runtime cannot register the socket.
    pub fn new(listener: std::net::TcpListener, limits: DoorLimits) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener: TcpListener::from_std(listener)?,
            slots: Arc::default(),
            limits,
            turned_away: AtomicU64::new(0),
        })
    }
}

/// Identity of a connection, available to its requests.
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
            self.slots.wait_for_room(&self.limits).await;
            let (stream, address) = self.listener.accept().await?;
            let entered = loop {
                match self.slots.enter(address.ip(), &self.limits) {
                    Ok(connection) => break Some(connection),
                    Err(NoSlot::TooMany) => break None,
                    // The connection that was to be closed has received a request since.
                    Err(NoSlot::Full) => self.slots.wait_for_room(&self.limits).await,
                }
            };
            let Some(connection) = entered else {
                let count = self.turned_away.fetch_add(1, Ordering::Relaxed) + 1;
                // The 1st, 2nd, 4th, 8th…, so that a flood does not fill the log.
                if count.is_power_of_two() {
                    tracing::warn!(%address, count, "connection refused: too many from this address");
                }
                continue;
            };
            let slot = Slot { slots: self.slots.clone(), connection: connection.clone() };
            return Ok((Guarded::new(stream, slot, &self.limits), Caller { connection }));
        }
    }

    fn get_local_addr(&self) -> io::Result<Caller> {
        // A listener has no peer.
        Err(io::ErrorKind::Unsupported.into())
    }
}

#[cfg(test)]
mod tests;
