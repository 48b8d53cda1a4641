//! Aircraft and ground stations on Eclipse Zenoh.

mod aircraft;
mod checked;
mod door;
mod endpoint;
mod ground;
mod handshake;
mod history;
mod membership;
mod network;
mod organisation;
mod ros2;
#[cfg(test)]
mod tests;
mod tls;

pub use aircraft::{Aircraft, AircraftConfig, AircraftStatus};
pub use endpoint::{Endpoint, Transport};
pub use ground::{Far, Ground, GroundConfig, GroundStatus, Standing};
pub use history::{Contents, HistoryConfig, open_film};
pub use membership::{Membership, join, renew, standing, try_address};
pub use network::{is_router_of, session_of_an_aircraft};
pub use organisation::{DOOR_PORT, Made, Organisation};
pub use ros2::{Examined, Gateway, GatewayConfig, GatewayStatus, RosPapers, RosRouter, examine};

/// Batches of 64 KB of what keeps the network together (declarations, a liveliness token of each aircraft) that may
/// wait to be sent. All that one who joins is told comes at once, from the thread that would send it: it has to fit, or
/// the sessions end. 1 MB is 10,000 aircraft with the longest names.
const CONTROL_QUEUE: usize = 16;

/// Seconds since 1970, as the clock of this machine has it.
pub fn unix_now() -> u64 {
    let now = std::time::SystemTime::now();
    now.duration_since(std::time::UNIX_EPOCH).map_or(0, |since| since.as_secs())
}

/// UTC since 1970 by this machine's clock, ns.
pub(crate) fn utc_ns() -> i64 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    i64::try_from(now.as_nanos()).unwrap_or(i64::MAX)
}
