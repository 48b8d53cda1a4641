//! The places of a server's connections: how many there are, whose they are, and who makes room for a newcomer.

use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;

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
    pub(super) has_asked: AtomicBool,
    has_session: AtomicBool,
    /// Requests that are being answered, of which a WebSocket is one without an end; or [`ENDED`].
    pub(super) under_way: AtomicUsize,
    /// When the last of them was over: of two connections the one with the smaller number has rested for longer.
    pub(super) rests_since: AtomicU64,
    /// Told when it could make room.
    pub(super) freed: Arc<Notify>,
    /// It is to end: told once, to its stream.
    pub(super) end: Notify,
    is_ending: AtomicBool,
}

impl Connection {
    /// Where it comes from: of IPv6 the network.
    pub fn from(&self) -> IpAddr {
        self.from
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
pub(super) enum NoPlace {
    /// All places are taken by people who are being served: it waits.
    Full,
    /// Its address has too many that are all being served.
    TooMany,
}

/// The connections there are, oldest first.
#[derive(Debug, Default)]
pub(super) struct Places {
    taken: Mutex<Vec<Arc<Connection>>>,
    freed: Arc<Notify>,
}

impl Places {
    fn taken(&self) -> MutexGuard<'_, Vec<Arc<Connection>>> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until one more may be accepted: because there is room, or because somebody makes room.
    pub(super) async fn wait_for_room(&self, limits: &DoorLimits) {
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
    pub(super) fn enter(&self, address: IpAddr, limits: &DoorLimits) -> Result<Arc<Connection>, NoPlace> {
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

    pub(super) fn leave(&self, connection: &Arc<Connection>) {
        self.taken().retain(|taken| !Arc::ptr_eq(taken, connection));
        self.freed.notify_one();
    }
}

/// Whoever has one IPv6 address has its whole network.
pub(super) fn network_of(address: IpAddr) -> IpAddr {
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
    pub(super) places: Arc<Places>,
    pub(super) connection: Arc<Connection>,
}

impl Drop for Place {
    fn drop(&mut self) {
        self.places.leave(&self.connection);
    }
}
