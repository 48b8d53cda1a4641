//! Limits of a server's connections, and the slots in use: who holds them, and who makes room for a new connection.

use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;

/// Largest number of connections, if there are enough file descriptors.
const MOST_CONNECTIONS: usize = 512;
/// Number of connections that is always permitted.
const LEAST_CONNECTIONS: usize = 16;
/// Share of all slots that one remote address may use.
const ADDRESS_SHARE: f64 = 0.25;
/// Share of all slots that this machine may use: a proxy here stands for many clients.
const LOOPBACK_SHARE: f64 = 0.75;
/// Time from the start of a connection, TLS handshake included, to its first complete request.
const ASK_WITHIN: Duration = Duration::from_secs(10);
/// Time for which a client may read nothing of what is sent to it, in addition to what the system buffers for it.
const STALL: Duration = Duration::from_secs(20);

/// In place of the number of requests: no more are accepted.
const ENDED: usize = usize::MAX;

/// Limits of connections and time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoorLimits {
    /// Largest number of connections.
    pub connections: usize,
    /// Largest number of connections of one remote address (for IPv6, of its /64 network).
    pub per_address: usize,
    /// Largest number of connections of this machine.
    pub of_loopback: usize,
    /// Time to the first complete request.
    pub ask_within: Duration,
    /// Time for which a client may read nothing.
    pub stall: Duration,
}

impl DoorLimits {
    /// Limits for a number of connections.
    pub fn of(connections: usize) -> Self {
        let connections = connections.clamp(LEAST_CONNECTIONS, MOST_CONNECTIONS);
        let share = |share: f64| ((connections as f64 * share) as usize).max(LEAST_CONNECTIONS / 2);
        Self {
            connections,
            per_address: share(ADDRESS_SHARE),
            of_loopback: share(LOOPBACK_SHARE),
            ask_within: ASK_WITHIN,
            stall: STALL,
        }
    }
}

/// A connection, shared by its stream, its requests and the listener.
#[derive(Debug)]
pub struct Connection {
    /// Remote address; for IPv6, its network.
    from: IpAddr,
    pub(super) has_asked: AtomicBool,
    has_session: AtomicBool,
    /// Requests in progress, of which a WebSocket is one without an end; or [`ENDED`].
    pub(super) under_way: AtomicUsize,
    /// Sequence number of the end of its last request: of two connections, the one with the smaller number has been
    /// idle for longer.
    pub(super) rests_since: AtomicU64,
    /// Notified when it could make room.
    pub(super) freed: Arc<Notify>,
    /// Notifies its stream, once, that it is to end.
    pub(super) end: Notify,
    is_ending: AtomicBool,
}

impl Connection {
    /// Remote address; for IPv6, its network.
    pub fn from(&self) -> IpAddr {
        self.from
    }

    /// Records that a request had a session: the connection is not closed while its requests are in progress.
    pub fn showed_session(&self) {
        self.has_session.store(true, Ordering::Relaxed);
    }

    /// Whether a request had a session.
    pub fn has_session(&self) -> bool {
        self.has_session.load(Ordering::Relaxed)
    }

    fn may_make_room(&self) -> bool {
        !self.has_session() && !self.is_ending.load(Ordering::Relaxed)
    }

    fn rests(&self) -> bool {
        self.under_way.load(Ordering::SeqCst) == 0 && !self.is_ending.load(Ordering::Relaxed)
    }

    /// Ends the connection if it is idle; returns whether it did. A request that arrives at the same moment is either
    /// answered or not started.
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

/// Why a new connection gets no slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NoSlot {
    /// All slots are used by connections with requests in progress: it waits.
    Full,
    /// Its address has too many, all with requests in progress.
    TooMany,
}

/// The open connections, oldest first.
#[derive(Debug, Default)]
pub(super) struct Slots {
    taken: Mutex<Vec<Arc<Connection>>>,
    freed: Arc<Notify>,
}

impl Slots {
    fn taken(&self) -> MutexGuard<'_, Vec<Arc<Connection>>> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until another connection may be accepted: because there is a free slot, or because one can be closed.
    pub(super) async fn wait_for_room(&self, limits: &DoorLimits) {
        loop {
            let freed = self.freed.notified();
            {
                let taken = self.taken();
                // One over the limit is already being closed while its successor is accepted.
                if taken.len() < limits.connections
                    || (taken.len() == limits.connections
                        && taken.iter().any(|taken| taken.may_make_room() || taken.rests()))
                {
                    return;
                }
            }
            freed.await;
        }
    }

    /// Gives a new connection a slot, if necessary that of the oldest one without a session, or of the one idle for
    /// longest.
    pub(super) fn enter(&self, address: IpAddr, limits: &DoorLimits) -> Result<Arc<Connection>, NoSlot> {
        let from = network_of(address);
        let most = if address.to_canonical().is_loopback() { limits.of_loopback } else { limits.per_address };
        let mut taken = self.taken();
        let staying = |connection: &&Arc<Connection>| !connection.is_ending.load(Ordering::Relaxed);
        let all = taken.iter().filter(staying).count();
        let own = taken.iter().filter(staying).filter(|connection| connection.from == from).count();
        if own >= most || all >= limits.connections {
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
                // An address that competes with others has used up its share; a single one waits for a slot.
                let has_its_share = own >= most && (own < all || all < limits.connections);
                return Err(if has_its_share { NoSlot::TooMany } else { NoSlot::Full });
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

    pub(super) fn leave(&self, connection: &Arc<Connection>) {
        self.taken().retain(|taken| !Arc::ptr_eq(taken, connection));
        self.freed.notify_one();
    }
}

/// A client with one IPv6 address can use the whole network.
pub(super) fn network_of(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => {
            let [a, b, c, d, ..] = address.segments();
            if address.is_loopback() { IpAddr::V6(address) } else { IpAddr::from([a, b, c, d, 0, 0, 0, 0]) }
        }
        address => address,
    }
}

/// A slot that is in use until this is dropped.
#[derive(Debug)]
pub struct Slot {
    pub(super) slots: Arc<Slots>,
    pub(super) connection: Arc<Connection>,
}

impl Drop for Slot {
    fn drop(&mut self) {
        self.slots.leave(&self.connection);
    }
}
