//! Errors of transfers.

use std::fmt;
use std::time::Duration;

use thiserror::Error;
use vencejo_flight::FlightError;
use vencejo_flight::plan::{Difference, Field, PlanKind};
use vencejo_proto::ftp::FtpError;
use vencejo_proto::param::{ParamError, ParamName, ParamValue};
use vencejo_proto::{Counted, Seconds};

/// Most differences listed in a message.
const DIFFERENCES_SHOWN: usize = 3;

/// The step of a request that is not answered by MAVFTP.
pub const FTP_OPEN: &str = "opening a file by MAVFTP";

/// Why the item protocol can carry the mission only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NoPlanKinds {
    /// The firmware is from before fences and rally points went by it (ArduPilot before 4.0 had messages of their own).
    OldFirmware,
    /// The vehicle speaks MAVLink 1, whose messages do not say which plan they are about: it would take them for the
    /// mission.
    Mavlink1,
}

/// Why a transfer failed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TransferError {
    /// The vehicle fell silent.
    #[error("{step}: no answer from the vehicle for {}; check the link and try again", Seconds(*waited))]
    Timeout {
        /// The step that was not answered.
        step: &'static str,
        /// For how long.
        waited: Duration,
    },
    /// The vehicle did not answer by MAVFTP: it does not have it, or its messages are lost.
    #[error("{FTP_OPEN}: no answer from the vehicle for {}; check the link and try again", Seconds(*waited))]
    FtpAbsent {
        /// For how long.
        waited: Duration,
    },
    /// The vehicle is heard, but does not hear us: it answered neither this nor anything else.
    #[error(
        "nothing that was sent was answered for {}, though the vehicle is heard: it does not hear us; check transmitter, \
         antenna and cable of this side and the signing key, then try again",
        Seconds(*waited)
    )]
    Unreached {
        /// For how long.
        waited: Duration,
    },
    /// The vehicle answers, but the transfer makes no progress.
    #[error("{step}: given up after {}; try again, or look for another station that transfers too", Counted(*attempts, "attempt"))]
    NoProgress {
        /// The present step.
        step: &'static str,
        /// Number of attempts.
        attempts: u32,
    },
    /// The vehicle refused a plan.
    #[error("the vehicle refused the {kind}{}: {result}", at_item(*item))]
    Refused {
        /// Which plan.
        kind: PlanKind,
        /// Its `MAV_MISSION_RESULT`.
        result: MissionResult,
        /// The item sent last, counted from 1, when items were sent: most likely the one it refused. 0 is the home of an
        /// ArduPilot's mission.
        item: Option<u16>,
    },
    /// The vehicle's plan is not the one that was sent.
    #[error("the {kind} on board is not what was sent: {}; it was accepted, but do not fly it", list(differences))]
    NotAsSent {
        /// Which plan.
        kind: PlanKind,
        /// The differences, in order of item.
        differences: Vec<Difference>,
    },
    /// The mission is on board as it was sent, but the vehicle's own checks reject it: it does not fly it (PX4).
    #[error(
        "the mission is on board as it was sent, but the vehicle's own checks reject it, and it does not fly it: {}",
        why_rejected(reasons)
    )]
    Rejected {
        /// What its checks say; empty where they did not tell.
        reasons: Vec<String>,
    },
    /// The plan was sent, but could not be read back: the plan on board is unknown.
    #[error("the {kind} was sent but could not be read back, so what the vehicle holds is unknown: {reason}")]
    Unverified {
        /// Which plan.
        kind: PlanKind,
        /// Why.
        reason: Box<TransferError>,
    },
    /// The plan was to be removed, but items are left.
    #[error("the {kind} was cleared, but the vehicle still says that it has {}; try again", Counted(*count, "item"))]
    NotCleared {
        /// Which plan.
        kind: PlanKind,
        /// Items left, home not counted.
        count: u16,
    },
    /// The vehicle takes only its mission by the item protocol. Nothing was sent.
    #[error("{}", only_mission(*kind, *reason))]
    OnlyMission {
        /// Which plan was wanted.
        kind: PlanKind,
        /// Why not.
        reason: NoPlanKinds,
    },
    /// The vehicle answers, but not to MISSION_ITEM_INT and what belongs to it. The transfer then goes on with
    /// MISSION_ITEM; this is seen only when that is not allowed.
    #[error("the vehicle does not understand MISSION_ITEM_INT; it needs an older message for the items of a plan")]
    IntegerItemsIgnored,
    /// Too many.
    #[error("{what}: {count}, but at most {limit} are taken; the vehicle or the link is not sane")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many.
        count: u64,
        /// The limit.
        limit: u64,
    },
    /// The list to send is not numbered 0, 1, 2… or of another kind.
    #[error("item {index} of the list to send has seq {seq} and plan kind {mission_type}; number the items from 0")]
    BadList {
        /// Place in the list.
        index: usize,
        /// Its seq.
        seq: u16,
        /// Its `MAV_MISSION_TYPE`.
        mission_type: u8,
    },
    /// A plan item that may not be sent, or an impossible one from the vehicle.
    #[error(transparent)]
    Item(#[from] FlightError),
    /// The vehicle refused a MAVFTP request.
    #[error("{step} of {path}: the vehicle answers {error}")]
    Ftp {
        /// What was asked.
        step: &'static str,
        /// Which file.
        path: String,
        /// What it answered.
        error: FtpError,
    },
    /// Another station has a file open on the vehicle.
    #[error("{path}: another station is using MAVFTP with this vehicle; try again when it is done")]
    FtpBusy {
        /// Which file we wanted.
        path: String,
    },
    /// A file from the vehicle has unexpected content.
    #[error("{path}: {problem}")]
    BadFile {
        /// Which file.
        path: String,
        /// What is wrong.
        problem: String,
    },
    /// A parameter's name or value that may not be sent, or a file of them that cannot be read.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The vehicle does not know a parameter, or did not answer for it.
    #[error("parameter {name}: {}", if *told { "the vehicle has no such parameter; check its name" } else { "no answer; the vehicle may not have it, or the link is bad" })]
    UnknownParam {
        /// Its name.
        name: ParamName,
        /// Whether the vehicle reported so; otherwise it was silent.
        told: bool,
    },
    /// The vehicle refused a parameter.
    #[error("parameter {name}: the vehicle refused it: {reason}")]
    ParamRefused {
        /// Its name.
        name: ParamName,
        /// `MAV_PARAM_ERROR` in words.
        reason: &'static str,
    },
    /// The vehicle kept a value other than the one sent.
    #[error(
        "parameter {name}: the vehicle keeps {kept} instead of {asked}; it may be read-only, limited, or set by another station"
    )]
    ParamNotKept {
        /// Its name.
        name: ParamName,
        /// What was sent.
        asked: ParamValue,
        /// What it has.
        kept: ParamValue,
    },
    /// The transfer was cancelled.
    #[error("cancelled; what the vehicle holds is unknown until it is read")]
    Cancelled,
}

fn only_mission(kind: PlanKind, reason: NoPlanKinds) -> String {
    match reason {
        NoPlanKinds::OldFirmware => {
            let (message, parameter) = match kind {
                PlanKind::Rally => ("RALLY_POINT", "RALLY_TOTAL"),
                PlanKind::Mission | PlanKind::Fence => ("FENCE_POINT", "FENCE_TOTAL"),
            };
            format!(
                "the vehicle's firmware is too old to take a {kind} plan by the mission protocol: it has parameters \
                 ({parameter}) and {message} messages for it; set it with a ground station of its time, or update it"
            )
        }
        NoPlanKinds::Mavlink1 => format!(
            "the vehicle speaks MAVLink 1, in which a {kind} plan cannot be told from the mission and would replace it; \
             let its port speak MAVLink 2 (SERIALn_PROTOCOL = 2)"
        ),
    }
}

fn at_item(item: Option<u16>) -> String {
    item.map_or_else(String::new, |item| format!(" at item {item}"))
}

fn why_rejected(reasons: &[String]) -> String {
    const USUAL: &str = "it does not tell why (a take-off has to come first, a landing be no steeper than FW_LND_ANG, and all \
                         of it lie inside the fence)";
    if reasons.is_empty() { USUAL.to_owned() } else { reasons.join("; ") }
}

fn list(differences: &[Difference]) -> String {
    let shown: Vec<_> = differences.iter().take(DIFFERENCES_SHOWN).map(ToString::to_string).collect();
    let more = differences.len().saturating_sub(DIFFERENCES_SHOWN);
    if more == 0 { shown.join("; ") } else { format!("{}; and {more} more", shown.join("; ")) }
}

/// A vehicle's result of a plan transfer (`MAV_MISSION_RESULT`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MissionResult(pub u8);

impl MissionResult {
    /// Taken.
    pub const ACCEPTED: Self = Self(0);
    /// Not accepted, for an unlisted reason. ArduPilot: for an item when it expects none.
    pub const ERROR: Self = Self(1);
    /// An item out of order. ArduPilot goes on waiting for the right one.
    pub const INVALID_SEQUENCE: Self = Self(13);
    /// Not from this station; with ArduPilot: another one is uploading.
    pub const DENIED: Self = Self(14);
    /// The transfer was cancelled, or timed out on the vehicle.
    pub const OPERATION_CANCELLED: Self = Self(15);

    /// Its name in the dialect, and what it means.
    const fn text(self) -> (&'static str, &'static str) {
        match self.0 {
            0 => ("MAV_MISSION_ACCEPTED", "accepted"),
            1 => ("MAV_MISSION_ERROR", "not accepting plans now"),
            2 => ("MAV_MISSION_UNSUPPORTED_FRAME", "an item's frame is not supported"),
            3 => ("MAV_MISSION_UNSUPPORTED", "an item's command is not supported"),
            4 => (
                "MAV_MISSION_NO_SPACE",
                "more items than it can store; in the first seconds after its start it cannot store any",
            ),
            5 => ("MAV_MISSION_INVALID", "an item has an invalid value"),
            6 => ("MAV_MISSION_INVALID_PARAM1", "param1 is invalid"),
            7 => ("MAV_MISSION_INVALID_PARAM2", "param2 is invalid"),
            8 => ("MAV_MISSION_INVALID_PARAM3", "param3 is invalid"),
            9 => ("MAV_MISSION_INVALID_PARAM4", "param4 is invalid"),
            10 => ("MAV_MISSION_INVALID_PARAM5_X", "x (latitude) is invalid"),
            11 => ("MAV_MISSION_INVALID_PARAM6_Y", "y (longitude) is invalid"),
            12 => ("MAV_MISSION_INVALID_PARAM7", "z (altitude) is invalid"),
            13 => ("MAV_MISSION_INVALID_SEQUENCE", "an item came out of order"),
            14 => ("MAV_MISSION_DENIED", "another station is uploading, or it takes no plan from this one"),
            15 => ("MAV_MISSION_OPERATION_CANCELLED", "cancelled or timed out"),
            _ => ("unknown MAV_MISSION_RESULT", "a result that is not listed"),
        }
    }

    /// Its name in the dialect.
    pub const fn name(self) -> &'static str {
        self.text().0
    }
}

impl fmt::Display for MissionResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, meaning) = self.text();
        write!(f, "{meaning} ({name}, {})", self.0)
    }
}

impl TransferError {
    /// One of each kind, for tests of error mappings.
    #[doc(hidden)]
    pub fn examples() -> Vec<Self> {
        let kind = PlanKind::Mission;
        let path = || "@PARAM/param.pck".to_owned();
        let name = ParamName::new("WP_RADIUS").expect("invariant: a good name");
        let difference = Difference { seq: 3, field: Field::Param(6), sent: Some(80.0), kept: Some(70.0) };
        vec![
            Self::Timeout { step: "sending the mission", waited: Duration::from_secs(15) },
            Self::NoProgress { step: "sending the mission", attempts: 3 },
            Self::Refused { kind, result: MissionResult::DENIED, item: Some(3) },
            Self::NotAsSent { kind, differences: vec![difference] },
            Self::Unverified { kind, reason: Box::new(Self::Cancelled) },
            Self::NotCleared { kind, count: 3 },
            Self::TooMany { what: "items", count: 65_535, limit: 724 },
            Self::BadList { index: 1, seq: 7, mission_type: 0 },
            Self::Item(FlightError::NotOnEarth { lat_deg: 91.0, lon_deg: 0.0 }),
            Self::Ftp { step: "opening", path: path(), error: FtpError::new(FtpError::FILE_NOT_FOUND) },
            Self::FtpBusy { path: path() },
            Self::BadFile { path: path(), problem: "it ends in the middle".into() },
            Self::Param(ParamError::NotFinite { value: f64::NAN }),
            Self::UnknownParam { name, told: true },
            Self::ParamRefused { name, reason: "it is read-only" },
            Self::ParamNotKept { name, asked: ParamValue::F32(50.0), kept: ParamValue::F32(60.0) },
            Self::Cancelled,
            Self::OnlyMission { kind: PlanKind::Fence, reason: NoPlanKinds::OldFirmware },
            Self::IntegerItemsIgnored,
            Self::Unreached { waited: Duration::from_millis(4_500) },
            Self::FtpAbsent { waited: Duration::from_secs(3) },
            Self::Rejected { reasons: vec!["it has no landing (MIS_TKO_LAND_REQ)".into()] },
        ]
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Without a wildcard, so that a new kind does not compile until it has an example.
    fn place(error: &TransferError) -> usize {
        match error {
            TransferError::Timeout { .. } => 0,
            TransferError::NoProgress { .. } => 1,
            TransferError::Refused { .. } => 2,
            TransferError::NotAsSent { .. } => 3,
            TransferError::Unverified { .. } => 4,
            TransferError::NotCleared { .. } => 5,
            TransferError::TooMany { .. } => 6,
            TransferError::BadList { .. } => 7,
            TransferError::Item(_) => 8,
            TransferError::Ftp { .. } => 9,
            TransferError::FtpBusy { .. } => 10,
            TransferError::BadFile { .. } => 11,
            TransferError::Param(_) => 12,
            TransferError::UnknownParam { .. } => 13,
            TransferError::ParamRefused { .. } => 14,
            TransferError::ParamNotKept { .. } => 15,
            TransferError::Cancelled => 16,
            TransferError::OnlyMission { .. } => 17,
            TransferError::IntegerItemsIgnored => 18,
            TransferError::Unreached { .. } => 19,
            TransferError::FtpAbsent { .. } => 20,
            TransferError::Rejected { .. } => 21,
        }
    }

    #[test]
    fn each_kind_has_an_example_and_says_something() {
        let examples = TransferError::examples();
        assert_eq!(examples.iter().map(place).collect::<BTreeSet<_>>(), (0..=21).collect());
        assert!(examples.iter().all(|error| !error.to_string().is_empty()));
    }
}
