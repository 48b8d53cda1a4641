//! States of the plans on board.

use std::fmt;

use vencejo_flight::FlightError;
use vencejo_flight::plan::{Mission, PlanKind, items_from_wire};
use vencejo_proto::{Counted, MissionItemInt};

/// Why a plan on board is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Unknown {
    /// It was never read.
    NeverRead,
    /// A transfer runs.
    Transferring,
    /// A transfer of ours failed or was cancelled; the vehicle may hold a mixture.
    TransferFailed,
    /// Another station is uploading one, or was not seen to finish; the vehicle may hold a mixture.
    SentElsewhere,
    /// Its stored record is unreadable, and may have said that it is a mixture.
    RecordDamaged,
    /// The vehicle restarted.
    Rebooted,
    /// Another station changed it.
    ChangedElsewhere,
}

/// The state of a plan on board. Only a read-back makes it known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PlanState {
    /// Unknown, and why.
    Unknown(Unknown),
    /// There is no plan.
    Empty,
    /// Read from the vehicle, item by item.
    Verified {
        /// Items without home.
        count: u16,
        /// Fingerprint of the items as the vehicle holds them, home left out: equal plans have equal ones.
        hash: u64,
    },
    /// Read from the vehicle, item by item, after an unfinished upload: it equals neither the plan that was being sent
    /// nor the one before, as far as these are known, and may be a mixture.
    Differs {
        /// Items without home.
        count: u16,
        /// Fingerprint, as above.
        hash: u64,
    },
}

impl PlanState {
    /// Whether the plan on board may be a mixture of two that an upload left behind.
    pub fn may_be_mixed(self) -> bool {
        matches!(
            self,
            Self::Unknown(
                Unknown::Transferring | Unknown::TransferFailed | Unknown::SentElsewhere | Unknown::RecordDamaged
            ) | Self::Differs { .. }
        )
    }

    /// Items on board without home, where they were read.
    pub fn count(self) -> Option<u16> {
        match self {
            Self::Unknown(_) => None,
            Self::Empty => Some(0),
            Self::Verified { count, .. } | Self::Differs { count, .. } => Some(count),
        }
    }

    /// Fingerprint of the items on board, where they were read; that of an empty list when there are none.
    pub(crate) fn hash(self) -> Option<u64> {
        match self {
            Self::Unknown(_) => None,
            Self::Empty => Some(hash_items([])),
            Self::Verified { hash, .. } | Self::Differs { hash, .. } => Some(hash),
        }
    }
}

impl fmt::Display for PlanState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(why) => f.write_str(match why {
                Unknown::NeverRead => "unknown: never read",
                Unknown::Transferring => "unknown: a transfer runs",
                Unknown::TransferFailed => "unknown: a transfer failed half-way, it may be a mixture",
                Unknown::SentElsewhere => "unknown: another station's upload has not ended, it may be a mixture",
                Unknown::RecordDamaged => "unknown: what was written down of it is damaged, it may be a mixture",
                Unknown::Rebooted => "unknown: the vehicle restarted",
                Unknown::ChangedElsewhere => "unknown: another station changed it",
            }),
            Self::Empty => f.write_str("empty"),
            Self::Verified { count, hash } => write!(f, "verified: {}, {hash:016x}", Counted(*count, "item")),
            Self::Differs { count, hash } => {
                write!(
                    f,
                    "perhaps mixed: {}, {hash:016x}, no mission that is known to be whole",
                    Counted(*count, "item")
                )
            }
        }
    }
}

/// The plan states of one vehicle, one for each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PlanStates([PlanState; 3]);

impl PlanStates {
    pub(crate) fn new() -> Self {
        Self([PlanState::Unknown(Unknown::NeverRead); 3])
    }

    pub(crate) fn get(&self, kind: PlanKind) -> PlanState {
        self.0[kind as usize]
    }

    /// Sets one; returns whether it changed.
    pub(crate) fn set(&mut self, kind: PlanKind, state: PlanState) -> bool {
        std::mem::replace(&mut self.0[kind as usize], state) != state
    }
}

/// A list as a vehicle holds it: the plan, and its state if nothing speaks against it. `has_home`: a mission begins with
/// home as item 0.
pub(crate) fn read_plan(
    kind: PlanKind,
    wire: &[MissionItemInt],
    has_home: bool,
) -> Result<(Mission, PlanState), FlightError> {
    let has_home = has_home && kind == PlanKind::Mission;
    let list = match kind {
        PlanKind::Mission => Mission::from_wire(wire, has_home)?,
        PlanKind::Fence | PlanKind::Rally => Mission { home: None, items: items_from_wire(wire, kind)? },
    };
    let count = u16::try_from(list.items.len()).unwrap_or(u16::MAX);
    let state = match &list.items[..] {
        [] => PlanState::Empty,
        _ => PlanState::Verified { count, hash: hash_items(&wire[usize::from(has_home)..]) },
    };
    Ok((list, state))
}

/// 64-bit FNV-1a over what an item means: frame, command, parameters and position; not its number, target or flags
/// of the moment. (Fowler, Noll, Vo; IETF draft-eastlake-fnv.)
pub(crate) fn hash_items<'a>(items: impl IntoIterator<Item = &'a MissionItemInt>) -> u64 {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0100_0000_01b3;
    let mut hash = OFFSET;
    let mut eat = |bytes: &[u8]| {
        for byte in bytes {
            hash = (hash ^ u64::from(*byte)).wrapping_mul(PRIME);
        }
    };
    for item in items {
        eat(&[item.frame]);
        eat(&item.command.to_le_bytes());
        for param in item.params.iter().chain([&item.z]) {
            // −0 and 0 are one value, and so are all NaN.
            let bits = if param.is_nan() { f32::NAN.to_bits() } else { (param + 0.0).to_bits() };
            eat(&bits.to_le_bytes());
        }
        eat(&item.x.to_le_bytes());
        eat(&item.y.to_le_bytes());
    }
    hash
}

#[cfg(test)]
mod tests {
    use super::*;
    use vencejo_proto::Address;

    fn item(seq: u16, z: f32) -> MissionItemInt {
        MissionItemInt {
            target: Address::new(1, 1),
            seq,
            frame: 3,
            command: 16,
            current: 0,
            autocontinue: 1,
            params: [0.0; 4],
            x: 403_332_000,
            y: -37_978_000,
            z,
            mission_type: 0,
        }
    }

    #[test]
    fn hash_tells_plans_apart_by_what_they_mean() {
        let plan = [item(1, 50.0), item(2, 60.0)];
        let renumbered = [item(0, 50.0), item(1, 60.0)];
        assert_eq!(hash_items(&plan), hash_items(&renumbered));
        assert_ne!(hash_items(&plan), hash_items(&[item(1, 60.0), item(2, 50.0)]), "order matters");
        assert_ne!(hash_items(&plan), hash_items(&plan[..1]));
        let mut negative_zero = plan;
        negative_zero[0].params[0] = -0.0;
        assert_eq!(hash_items(&plan), hash_items(&negative_zero));
    }

    #[test]
    fn states_start_unknown_and_report_changes() {
        let mut states = PlanStates::new();
        assert_eq!(states.get(PlanKind::Rally), PlanState::Unknown(Unknown::NeverRead));
        assert!(states.set(PlanKind::Rally, PlanState::Empty));
        assert!(!states.set(PlanKind::Rally, PlanState::Empty));
        assert!(!states.get(PlanKind::Mission).may_be_mixed());
        assert!(PlanState::Unknown(Unknown::TransferFailed).may_be_mixed());
        assert!(PlanState::Differs { count: 3, hash: 1 }.may_be_mixed());
        assert!(!PlanState::Verified { count: 3, hash: 1 }.may_be_mixed());
    }
}
