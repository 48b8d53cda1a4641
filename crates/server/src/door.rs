//! The server's door: how many connections there are at once, from whom, and which of them makes room for another.
//!
//! A connection is counted before it is accepted; while all places are taken by people who are being served, further ones wait
//! outside, where they cost no descriptor of ours. One that has not shown a session yet is only tolerated: when its address or
//! the whole server is full, the oldest of those makes room, and after them the one with a session that has rested for longest:
//! its last request is answered, and it is no WebSocket. So whoever opens connections and asks for nothing shuts nobody out.

mod answering;
mod descriptors;
mod stream;

use std::io;
use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::extract::connect_info::Connected;
use axum_server::{AddrListener, Address};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Notify;

pub use answering::Answering;
pub use descriptors::Descriptors;
pub use stream::Guarded;

/// Connections at once at most, when there are descriptors for them.
const MOST_CONNECTIONS: usize = 512;
/// Connections at once that there is always room for.
const LEAST_CONNECTIONS: usize = 16;
/// Share of all places that one other machine may take.
const ADDRESS_SHARE: f64 = 0.25;
/// The same for this machine: a proxy here stands for many people.
const LOOPBACK_SHARE: f64 = 0.75;
/// How long a connection may take from its beginning to its first whole request, the TLS handshake included.
const ASK_WITHIN: Duration = Duration::from_secs(10);
/// How long a client may take nothing of what is sent to it. What the system holds back for it comes on top.
const STALL: Duration = Duration::from_secs(20);

/// In place of a number of requests: none is begun any more.
const ENDED: usize = usize::MAX;

/// How many connections, and how patient we are with each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoorLimits {
    /// Connections at once.
    pub places: usize,
    /// Connections at once of one other address (of IPv6 the network, /64).
    pub per_address: usize,
    /// Connections at once of this machine.
    pub of_loopback: usize,
    /// Until the first whole request.
    pub ask_within: Duration,
    /// While nothing is taken.
    pub stall: Duration,
}

impl DoorLimits {
    /// Limits for so many connections.
    pub fn of(places: usize) -> Self {
        let places = places.clamp(LEAST_CONNECTIONS, MOST_CONNECTIONS);
        let share = |share: f64| ((places as f64 * share) as usize).max(LEAST_CONNECTIONS / 2);
        Self {
            places,
            per_address: share(ADDRESS_SHARE),
            of_loopback: share(LOOPBACK_SHARE),
            ask_within: ASK_WITHIN,
            stall: STALL,
        }
    }
}

/// One connection, as its stream, its requests and the door see it.
#[derive(Debug)]
pub struct Connection {
    /// Where it comes from: of IPv6 the network.
    from: IpAddr,
    has_asked: AtomicBool,
    has_session: AtomicBool,
    /// Requests that are being answered, of which a WebSocket is one without an end; or [`ENDED`].
    under_way: AtomicUsize,
    /// When the last of them was over: of two connections the one with the smaller number has rested for longer.
    rests_since: AtomicU64,
    /// Told when it could make room.
    freed: Arc<Notify>,
    /// It is to end: told once, to its stream.
    end: Notify,
    is_ending: AtomicBool,
}

impl Connection {
    /// Where it comes from: of IPv6 the network.
    pub fn from(&self) -> IpAddr {
        self.from
    }

    /// A whole request has come. `None`: too late, the connection has made room for another, and nothing is to be done for it.
    pub fn asked(self: &Arc<Self>) -> Option<Answering> {
        self.has_asked.store(true, Ordering::Relaxed);
        // ENDED is the number after which there is none.
        let begun =
            self.under_way.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |count: usize| count.checked_add(1));
        begun.is_ok().then(|| Answering::new(self.clone()))
    }

    /// A request has shown a session: this connection makes room for nobody while it is served.
    pub fn showed_session(&self) {
        self.has_session.store(true, Ordering::Relaxed);
    }

    /// Whether a session was shown.
    pub fn has_session(&self) -> bool {
        self.has_session.load(Ordering::Relaxed)
    }

    fn may_make_room(&self) -> bool {
        !self.has_session() && !self.is_ending.load(Ordering::Relaxed)
    }

    fn rests(&self) -> bool {
        self.under_way.load(Ordering::SeqCst) == 0 && !self.is_ending.load(Ordering::Relaxed)
    }

    /// Ends it if it rests; whether it did. A request that comes at the same moment is either answered or not begun.
    fn make_room_at_rest(&self) -> bool {
        let is_ended = self.under_way.compare_exchange(0, ENDED, Ordering::SeqCst, Ordering::SeqCst).is_ok();
        if is_ended {
            self.make_room();
        }
        is_ended
    }

    fn make_room(&self) {
        self.is_ending.store(true, Ordering::Relaxed);
        self.end.notify_one();
    }
}

/// Why a newcomer has no place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NoPlace {
    /// All places are taken by people who are being served: it waits.
    Full,
    /// Its address has too many that are all being served.
    TooMany,
}

/// The connections there are, oldest first.
#[derive(Debug, Default)]
struct Places {
    taken: Mutex<Vec<Arc<Connection>>>,
    freed: Arc<Notify>,
}

impl Places {
    fn taken(&self) -> MutexGuard<'_, Vec<Arc<Connection>>> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until one more may be accepted: because there is room, or because somebody makes room.
    async fn wait_for_room(&self, limits: &DoorLimits) {
        loop {
            let freed = self.freed.notified();
            {
                let taken = self.taken();
                // One over the limit is on its way out already while its successor comes in.
                if taken.len() < limits.places
                    || (taken.len() == limits.places
                        && taken.iter().any(|taken| taken.may_make_room() || taken.rests()))
                {
                    return;
                }
            }
            freed.await;
        }
    }

    /// Gives a newcomer its place, if need be that of the oldest that has shown no session, or has rested for longest.
    fn enter(&self, address: IpAddr, limits: &DoorLimits) -> Result<Arc<Connection>, NoPlace> {
        let from = network_of(address);
        let most = if address.to_canonical().is_loopback() { limits.of_loopback } else { limits.per_address };
        let mut taken = self.taken();
        let staying = |connection: &&Arc<Connection>| !connection.is_ending.load(Ordering::Relaxed);
        let all = taken.iter().filter(staying).count();
        let own = taken.iter().filter(staying).filter(|connection| connection.from == from).count();
        if own >= most || all >= limits.places {
            let may = |connection: &&Arc<Connection>| own < most || connection.from == from;
            let made_room = match taken.iter().filter(may).find(|connection| connection.may_make_room()) {
                Some(oldest) => {
                    oldest.make_room();
                    true
                }
                None => {
                    let mut resting: Vec<_> =
                        taken.iter().filter(may).filter(|connection| connection.rests()).collect();
                    resting.sort_by_key(|connection| connection.rests_since.load(Ordering::Relaxed));
                    resting.into_iter().any(|connection| connection.make_room_at_rest())
                }
            };
            if !made_room {
                // With others here it has its share; alone, it waits for a place like anybody.
                let has_its_share = own >= most && (own < all || all < limits.places);
                return Err(if has_its_share { NoPlace::TooMany } else { NoPlace::Full });
            }
        }
        let connection = Arc::new(Connection {
            from,
            has_asked: AtomicBool::new(false),
            has_session: AtomicBool::new(false),
            under_way: AtomicUsize::new(0),
            rests_since: AtomicU64::new(0),
            freed: self.freed.clone(),
            end: Notify::new(),
            is_ending: AtomicBool::new(false),
        });
        taken.push(connection.clone());
        Ok(connection)
    }

    fn leave(&self, connection: &Arc<Connection>) {
        self.taken().retain(|taken| !Arc::ptr_eq(taken, connection));
        self.freed.notify_one();
    }
}

/// Whoever has one IPv6 address has its whole network.
fn network_of(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => {
            let [a, b, c, d, ..] = address.segments();
            if address.is_loopback() { IpAddr::V6(address) } else { IpAddr::from([a, b, c, d, 0, 0, 0, 0]) }
        }
        address => address,
    }
}

/// A place that is taken until this is dropped.
#[derive(Debug)]
pub struct Place {
    places: Arc<Places>,
    connection: Arc<Connection>,
}

impl Drop for Place {
    fn drop(&mut self) {
        self.places.leave(&self.connection);
    }
}

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
