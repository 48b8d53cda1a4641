//! Errors of the station, including the vehicle's own answers.

use std::fmt;
use std::time::Duration;

use thiserror::Error;
use vencejo_link::{AddressError, LinkError};
use vencejo_proto::Seconds;
use vencejo_vehicle::transfer::TransferError;
use vencejo_vehicle::{Danger, VehicleError, VehicleId};

use crate::confirm::{Challenge, VALID_FOR};
use crate::control::NotTaken;
use crate::replay::MAX_REPLAYS;
use crate::signing::SigningError;

/// Most vehicles that an error lists.
const MAX_LISTED: usize = 20;

/// The vehicle that a caller waits for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Wanted {
    /// The first that is heard.
    First,
    /// The one with this id.
    Id(VehicleId),
    /// The one far away with this name.
    Named(String),
}

impl Wanted {
    /// Whether a vehicle is it, which may be one of a recording that is only looked at.
    pub(crate) fn is(&self, id: VehicleId, is_aside: bool, name: Option<&str>) -> bool {
        match self {
            Self::First => !is_aside,
            Self::Id(wanted) => *wanted == id,
            Self::Named(wanted) => name == Some(wanted),
        }
    }
}

impl fmt::Display for Wanted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::First => Ok(()),
            Self::Id(id) => write!(f, " with id {id}"),
            Self::Named(name) => write!(f, " called {name}"),
        }
    }
}

/// What was heard instead of a vehicle, or else where to look.
fn heard_instead(wanted: &Wanted, links: &str, heard: &[String]) -> String {
    match (heard, wanted) {
        ([], Wanted::Named(_)) => "; is its station on board in the fleet, and this station too?".into(),
        ([], _) => {
            let advice = if links.contains("serial:") {
                "check the cable or address, the baud rate, and that the autopilot is on"
            } else {
                "check the kind of link (udpin listens, tcp dials a server) and the address, and that the autopilot, or \
                 its simulator, runs"
            };
            format!(" on {links}; {advice}")
        }
        (heard, _) => {
            let more = if heard.len() > MAX_LISTED { " …" } else { "" };
            let listed: Vec<_> = heard.iter().take(MAX_LISTED).map(String::as_str).collect();
            format!("; heard: {}{more}", listed.join(", "))
        }
    }
}

/// Why a request to the station failed.
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
        /// The operating system's error.
        reason: String,
    },
    /// No autopilot was heard.
    #[error("no vehicle{wanted} was heard within {}{}", Seconds(*waited), heard_instead(wanted, links, heard))]
    NoVehicle {
        /// The one that was wanted.
        wanted: Wanted,
        /// For how long.
        waited: Duration,
        /// The links and their states.
        links: String,
        /// The vehicles that were heard, by name or id.
        heard: Vec<String>,
    },
    /// The vehicle's request failed.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// Signing keys.
    #[error(transparent)]
    Signing(#[from] SigningError),
    /// Another operator holds control.
    #[error("{holder} holds control{}: ask for it, or wait until it is given up", vehicle.as_ref().map_or_else(String::new, |name| format!(" of {name}")))]
    Control {
        /// Its name.
        holder: String,
        /// The remote vehicle whose control it is; `None`: that of the station.
        vehicle: Option<String>,
    },
    /// The caller is no longer an operator of this station.
    #[error("this operator is no longer one of the station's, and nothing was sent; connect again")]
    Dismissed,
    /// A dangerous act: it has to be requested again with a confirmation.
    #[error("{} of {} {}; nothing was sent: confirm it", challenge.danger, challenge.vehicle_name(), challenge.danger.words())]
    NeedsConfirmation {
        /// What is to be confirmed.
        challenge: Box<Challenge>,
    },
    /// A confirmation that is not valid for the act.
    #[error(
        "this confirmation was given out for another act, was used, or ran out; nothing was sent: ask again without one"
    )]
    BadConfirmation,
    /// The station on board of a vehicle far away did not do it; nothing was sent to the autopilot.
    #[error("the station on board of {name} did not do it: {why}")]
    RemoteRefused {
        /// Name of the vehicle.
        name: String,
        /// Why.
        why: String,
    },
    /// A vehicle that is played from a recording was asked for something. Nothing was sent.
    #[error("vehicle {vehicle} is a recording that is replayed: it takes no orders")]
    Replayed {
        /// Its id or name.
        vehicle: String,
    },
    /// A recording that cannot be replayed.
    #[error("{file} cannot be replayed: {reason}")]
    BadRecording {
        /// Name of the file.
        file: String,
        /// Why.
        reason: String,
    },
    /// [`MAX_REPLAYS`] are open.
    #[error("{MAX_REPLAYS} recordings are being replayed; close one first")]
    TooManyReplays,
    /// There is no room for another vehicle that is not at a link.
    #[error("no more vehicles can be followed; close a replay, or wait until some are lost")]
    TooManyVehicles,
    /// The station has been closed.
    #[error("the station is closed; connect again")]
    Closed,
}

impl StationError {
    /// One of each kind, the vehicle's and the transfers' included, for tests of error mappings.
    #[doc(hidden)]
    pub fn examples() -> Vec<Self> {
        let mut examples = vec![
            Self::Address(AddressError::Empty),
            Self::Link(LinkError::TooManyLinks),
            Self::CannotRecord { reason: "no space left on device".into() },
            Self::NoVehicle {
                wanted: Wanted::Id(VehicleId::new(1)),
                waited: Duration::from_secs(30),
                links: "no link".into(),
                heard: Vec::new(),
            },
            Self::Control { holder: "Ana".into(), vehicle: Some("plane7".into()) },
            Self::Dismissed,
            Self::NeedsConfirmation {
                challenge: Box::new(Challenge {
                    id: "0123456789abcdef".into(),
                    danger: Danger::Reboot,
                    vehicle: VehicleId::new(1),
                    name: None,
                    valid_for: VALID_FOR,
                }),
            },
            Self::BadConfirmation,
            Self::RemoteRefused { name: "plane7".into(), why: "the picture is too old".into() },
            Self::Replayed { vehicle: "1".into() },
            Self::BadRecording { file: "flight.tlog".into(), reason: "there is no state of an aircraft in it".into() },
            Self::TooManyReplays,
            Self::TooManyVehicles,
            Self::Closed,
        ];
        examples.extend(SigningError::examples().into_iter().map(Self::Signing));
        examples.extend(VehicleError::examples().into_iter().map(Self::Vehicle));
        examples.extend(TransferError::examples().into_iter().map(|error| Self::Vehicle(error.into())));
        examples
    }
}

impl From<NotTaken> for StationError {
    fn from(reason: NotTaken) -> Self {
        match reason {
            NotTaken::Held(holder) => Self::Control { holder, vehicle: None },
            NotTaken::Dismissed => Self::Dismissed,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Without a wildcard, so that a new kind does not compile until it has an example.
    fn place(error: &StationError) -> usize {
        match error {
            StationError::Address(_) => 0,
            StationError::Link(_) => 1,
            StationError::CannotRecord { .. } => 2,
            StationError::NoVehicle { .. } => 3,
            StationError::Vehicle(_) => 4,
            StationError::Closed => 5,
            StationError::Signing(_) => 6,
            StationError::Control { .. } => 7,
            StationError::NeedsConfirmation { .. } => 8,
            StationError::BadConfirmation => 9,
            StationError::RemoteRefused { .. } => 10,
            StationError::Dismissed => 11,
            StationError::Replayed { .. } => 12,
            StationError::BadRecording { .. } => 13,
            StationError::TooManyReplays => 14,
            StationError::TooManyVehicles => 15,
        }
    }

    #[test]
    fn each_kind_has_an_example() {
        assert_eq!(StationError::examples().iter().map(place).collect::<BTreeSet<_>>(), (0..=15).collect());
    }
}
