//! What can go wrong at the station, the vehicle's own answers included.

use std::time::Duration;

use thiserror::Error;
use vencejo_link::{AddressError, LinkError};
use vencejo_proto::SystemId;
use vencejo_vehicle::VehicleError;

/// Why the station could not do what it was asked for.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StationError {
    /// A link string that cannot be read.
    #[error(transparent)]
    Address(#[from] AddressError),
    /// A link that cannot be opened or does not exist.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The recorder could not even be started.
    #[error("the recorder cannot be started: {reason}; record elsewhere or not at all")]
    CannotRecord {
        /// What the system said.
        reason: String,
    },
    /// No autopilot was heard.
    #[error("no vehicle{} was heard within {} s on {links}; check the cable or address, the baud rate, and that the autopilot is on", wanted.map_or_else(String::new, |id| format!(" with system id {id}")), waited.as_secs())]
    NoVehicle {
        /// The one that was wanted.
        wanted: Option<SystemId>,
        /// For how long.
        waited: Duration,
        /// The links and their states.
        links: String,
    },
    /// The vehicle could not, or did not want to.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// The station has been closed.
    #[error("the station is closed; connect again")]
    Closed,
}
