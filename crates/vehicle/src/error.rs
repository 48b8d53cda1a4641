//! Errors of requests to a vehicle, named after the protocol's outcomes.

use std::fmt;
use std::time::Duration;

use thiserror::Error;
use vencejo_flight::plan::{Command, PlanKind};
use vencejo_proto::{Address, Counted, Seconds};

use crate::command::{CommandResult, numbered};
use crate::modes::{FlightMode, ModeFamily, UnknownMode};
use crate::plan_state::{PlanState, Unknown};
use crate::refusal::{remedies, remedy_of_silence};
use crate::transfer::TransferError;

/// The addressee of a command, as error messages name it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Recipient {
    /// A component at a link.
    Component(Address),
    /// A remote vehicle. Its MAVLink address on board is that of most others.
    Remote(String),
}

impl fmt::Display for Recipient {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Component(address) => write!(f, "vehicle {address}"),
            Self::Remote(name) => f.write_str(name),
        }
    }
}

impl From<Address> for Recipient {
    fn from(address: Address) -> Self {
        Self::Component(address)
    }
}

/// Why a request failed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum VehicleError {
    /// The vehicle refused a command.
    #[error("{target} refused {}: {result}{}{}", numbered(*command), join_reasons(reasons), name_cure(*cure))]
    CommandRefused {
        /// The addressed component, or the vehicle.
        target: Recipient,
        /// What.
        command: Command,
        /// Its `MAV_RESULT`.
        result: CommandResult,
        /// The vehicle's texts about it (pre-arm checks and the like), oldest first.
        reasons: Vec<String>,
        /// The mode that resolves it, if there is one: on the ground, [`crate::Request::PrepareFlight`] changes to it.
        cure: Option<FlightMode>,
    },
    /// The vehicle did not answer a command. It may have executed it.
    #[error(
        "{target} did not answer {}, sent {}{}: it may or may not have executed it; \
         check the link, read the vehicle's state, then decide",
        numbered(*command),
        Counted(*attempts, "time"),
        reasons.iter().map(|reason| format!("; {reason}")).collect::<String>()
    )]
    CommandTimeout {
        /// The addressed component, or the vehicle.
        target: Recipient,
        /// What.
        command: Command,
        /// Number of transmissions.
        attempts: u32,
        /// What is known of its silence: for a remote vehicle, what its station on board reports.
        reasons: Vec<String>,
    },
    /// The vehicle accepted, but its reports do not show the effect.
    #[error("vehicle accepted {} but within {} does not show {wanted}; it shows {observed}{}", numbered(*command), Seconds(*within), join_reasons(reasons))]
    NotConfirmed {
        /// What was sent.
        command: Command,
        /// The expected state.
        wanted: String,
        /// The reported state.
        observed: String,
        /// Time waited.
        within: Duration,
        /// The vehicle's texts since, oldest first.
        reasons: Vec<String>,
    },
    /// The same command is on its way already.
    #[error("{} is on its way already; wait for its result or cancel it", numbered(*command))]
    CommandBusy {
        /// Which.
        command: Command,
    },
    /// Another transfer runs; two never mix.
    #[error("another transfer ({running}) runs with this vehicle; wait for its result or cancel it")]
    TransferBusy {
        /// Which one runs.
        running: &'static str,
    },
    /// A plan or parameter transfer failed.
    #[error(transparent)]
    Transfer(#[from] TransferError),
    /// No such mode.
    #[error(transparent)]
    UnknownMode(#[from] UnknownMode),
    /// The mode exists, but the vehicle cannot be asked for it by this request.
    #[error("this vehicle has no mode for {action}; set a mode by its name instead")]
    NoModeFor {
        /// What was wanted.
        action: &'static str,
    },
    /// An invalid value.
    #[error("{field} is {value}, should be {expected}")]
    InvalidValue {
        /// Which value.
        field: &'static str,
        /// What it was.
        value: String,
        /// What it must be.
        expected: &'static str,
    },
    /// An invalid plan item.
    #[error(transparent)]
    Plan(#[from] vencejo_flight::FlightError),
    /// The mission on board may be a mixture of two: arming, starting it and jumping in it are refused.
    #[error(
        "the {kind} on board is {state}; upload it again or clear it before arming, starting it or jumping in it, or ask for \
         that despite a mixed plan (despite_mixed_plan)"
    )]
    PlanUnknown {
        /// Which plan.
        kind: PlanKind,
        /// What is known of it.
        state: PlanState,
    },
    /// The mission on board leads farther than any flight is meant to
    /// ([`REACH_M`](vencejo_flight::checks::REACH_M)): following it is refused.
    #[error(
        "item {item} of the mission on board lies {:.0} km from home and the vehicle, of at most 200 km: {}; upload a corrected \
         mission, or ask for that despite the plan (despite_mixed_plan)",
        distance_m / 1e3,
        if *is_swapped { "are latitude and longitude swapped?" } else { "check latitude and longitude" }
    )]
    OutOfReach {
        /// The first such item, counted from 1.
        item: usize,
        /// To home or the vehicle, whichever is nearer, metres.
        distance_m: f64,
        /// Whether it is in reach with latitude and longitude swapped.
        is_swapped: bool,
    },
    /// Only possible when disarmed.
    #[error("the vehicle is armed; disarm it before {action}")]
    Armed {
        /// What was wanted.
        action: &'static str,
    },
    /// Only possible on the ground.
    #[error("the vehicle is in the air; land it before {action}")]
    InTheAir {
        /// What was wanted.
        action: &'static str,
    },
    /// Only possible in flight.
    #[error("the vehicle is not flying: {consequence}; take off before {action}")]
    NotFlying {
        /// What was wanted.
        action: &'static str,
        /// What the vehicle would do.
        consequence: &'static str,
    },
    /// An ArduPlane that lands, or may land, is not sent what would make it flare in the air or turn away near the
    /// ground. [`crate::Request::AbortLanding`], which climbs first, and a change of mode are possible all the same.
    #[error(
        "the vehicle {}: {consequence}; {} before {action}",
        if *is_known { "is landing" } else { "flies a mission that was not read, and may be landing" },
        if *is_known { "abort the landing" } else { "read the mission or change the mode" }
    )]
    Landing {
        /// What was wanted.
        action: &'static str,
        /// What the vehicle would do.
        consequence: &'static str,
        /// Whether it is known to land; else it flies a mission that was not read.
        is_known: bool,
    },
    /// Home is needed and unknown.
    #[error("the vehicle has not said where home is; wait until it has a position")]
    HomeUnknown,
    /// The vehicle's state is too old to act on.
    #[error("the vehicle's state is not known (nothing heard for {}); wait for its heartbeat", Seconds(*age))]
    NotHeard {
        /// Age of its last heartbeat; without one, the time since it was first heard.
        age: Duration,
    },
    /// The firmware is too old (ArduPilot from before COMMAND_INT).
    #[error("this vehicle's firmware is too old for {what}; {instead}")]
    TooOld {
        /// What was wanted.
        what: &'static str,
        /// What to do.
        instead: &'static str,
    },
    /// Too many requests are waiting.
    #[error("{limit} requests are waiting for this vehicle already; wait for some of them")]
    TooManyRequests {
        /// The limit.
        limit: usize,
    },
    /// A requested message did not come, although the vehicle agreed to send it.
    #[error("vehicle agreed to send message {message_id} but it did not arrive; try again")]
    MessageNotReceived {
        /// Which.
        message_id: u32,
    },
    /// The vehicle restarted while the request was running.
    #[error("the vehicle restarted meanwhile; read its state, then decide")]
    Rebooted,
    /// The request was cancelled.
    #[error("cancelled")]
    Cancelled,
}

impl VehicleError {
    /// Known remedies for a refusal, each once: by the vehicle's texts, or without any by the command.
    pub fn remedies(&self) -> Vec<&'static str> {
        match self {
            Self::CommandRefused { command, result, reasons, .. } if reasons.is_empty() => {
                remedy_of_silence(*command, *result).into_iter().collect()
            }
            Self::CommandRefused { reasons, .. } | Self::NotConfirmed { reasons, .. } => remedies(reasons),
            _ => Vec::new(),
        }
    }
}

/// `": first; second"`, or nothing.
fn join_reasons(reasons: &[String]) -> String {
    if reasons.is_empty() { String::new() } else { format!(": {}", reasons.join("; ")) }
}

/// `"; prepare the flight, or change to mode MANUAL, then arm"`, or nothing.
fn name_cure(cure: Option<FlightMode>) -> String {
    cure.map_or_else(String::new, |mode| format!("; prepare the flight, or change to mode {mode}, then arm"))
}

impl VehicleError {
    /// One of each kind, for tests of error mappings.
    #[doc(hidden)]
    pub fn examples() -> Vec<Self> {
        let target = Recipient::Component(Address::new(1, 1));
        let command = Command::COMPONENT_ARM_DISARM;
        vec![
            Self::CommandRefused {
                target: target.clone(),
                command,
                result: CommandResult::FAILED,
                reasons: vec!["PreArm: GPS 1: not healthy".into()],
                cure: None,
            },
            Self::CommandTimeout { target, command, attempts: 4, reasons: Vec::new() },
            Self::NotConfirmed {
                command,
                wanted: "armed".into(),
                observed: "disarmed".into(),
                within: Duration::from_secs(3),
                reasons: vec!["Throttle not zero".into()],
            },
            Self::CommandBusy { command },
            Self::TransferBusy { running: "upload" },
            Self::Transfer(TransferError::Cancelled),
            Self::UnknownMode(UnknownMode {
                family: ModeFamily::ArduPlane,
                name: "AUTOO".into(),
                suggestions: vec!["AUTO"],
            }),
            Self::NoModeFor { action: "landing" },
            Self::InvalidValue { field: "lat_deg", value: "NaN".into(), expected: "-90 to 90" },
            Self::Plan(vencejo_flight::FlightError::NotOnEarth { lat_deg: 91.0, lon_deg: 0.0 }),
            Self::PlanUnknown { kind: PlanKind::Mission, state: PlanState::Unknown(Unknown::TransferFailed) },
            Self::OutOfReach { item: 2, distance_m: 6_638_600.0, is_swapped: true },
            Self::Armed { action: "restarting" },
            Self::InTheAir { action: "preparing a flight" },
            Self::NotFlying { action: "landing", consequence: "it would arm and take off" },
            Self::Landing { action: "jumping in the mission", consequence: "it would turn away", is_known: true },
            Self::HomeUnknown,
            Self::NotHeard { age: Duration::from_secs(6) },
            Self::TooManyRequests { limit: 64 },
            Self::MessageNotReceived { message_id: 148 },
            Self::Rebooted,
            Self::Cancelled,
            Self::TooOld { what: "a radius", instead: "leave it out" },
        ]
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Without a wildcard, so that a new kind does not compile until it has an example.
    fn place(error: &VehicleError) -> usize {
        match error {
            VehicleError::CommandRefused { .. } => 0,
            VehicleError::CommandTimeout { .. } => 1,
            VehicleError::NotConfirmed { .. } => 2,
            VehicleError::CommandBusy { .. } => 3,
            VehicleError::TransferBusy { .. } => 4,
            VehicleError::Transfer(_) => 5,
            VehicleError::UnknownMode(_) => 6,
            VehicleError::NoModeFor { .. } => 7,
            VehicleError::InvalidValue { .. } => 8,
            VehicleError::Plan(_) => 9,
            VehicleError::PlanUnknown { .. } => 10,
            VehicleError::Armed { .. } => 11,
            VehicleError::HomeUnknown => 12,
            VehicleError::NotHeard { .. } => 13,
            VehicleError::TooManyRequests { .. } => 14,
            VehicleError::MessageNotReceived { .. } => 15,
            VehicleError::Rebooted => 16,
            VehicleError::Cancelled => 17,
            VehicleError::TooOld { .. } => 18,
            VehicleError::InTheAir { .. } => 19,
            VehicleError::Landing { .. } => 20,
            VehicleError::NotFlying { .. } => 21,
            VehicleError::OutOfReach { .. } => 22,
        }
    }

    #[test]
    fn each_kind_has_an_example_and_says_something() {
        let examples = VehicleError::examples();
        assert_eq!(examples.iter().map(place).collect::<BTreeSet<_>>(), (0..=22).collect());
        assert!(examples.iter().all(|error| !error.to_string().is_empty()));
    }
}
