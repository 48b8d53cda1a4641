//! What is known of the plans on board beyond their states: the doubt, its record, uploads of others, readings of our own.

use std::time::Duration;

use vencejo_flight::plan::PlanKind;
use vencejo_proto::{Address, MissionItemInt, MonoTime};

use crate::plan_record::{Doubt, HardwareIds, PlanRecord, StoredRecord, VehicleKey};
use crate::plan_state::PlanState;
use crate::request::RequestId;

/// A vehicle that has not told the id of its hardware for this long after it was heard is known by its system id.
pub(super) const IDENTIFIED_WITHIN: Duration = Duration::from_secs(5);

/// Another station's upload of a mission.
#[derive(Debug)]
pub(super) struct Incoming {
    pub(super) from: Address,
    pub(super) items: Vec<Option<MissionItemInt>>,
    /// Whether the vehicle took it up.
    pub(super) has_begun: bool,
    pub(super) heard_at: MonoTime,
    /// What was known before; `None` where an upload of ours has begun since.
    pub(super) before: Option<(PlanState, Option<Doubt>)>,
}

/// What is read by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    Plan(PlanKind),
    /// Of how an ArduPlane flies, by its name.
    Parameter(&'static str),
}

/// A reading that nobody asked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Own {
    pub(super) id: RequestId,
    pub(super) what: Reading,
    pub(super) began: MonoTime,
}

/// What is known and doubted of the plans on board; `onboard` acts on it.
#[derive(Debug)]
pub(super) struct OnBoard {
    pub(super) doubt: Option<Doubt>,
    /// Whether the doubt began since the vehicle started, or came back after a silence: it is about the one that is there, whoever
    /// that will tell to be.
    pub(super) is_doubt_new: bool,
    /// The mission that was read back last, in this run or one before.
    pub(super) verified: Option<(u16, u64)>,
    /// Whose record this is; `None` until the vehicle is identified.
    pub(super) key: Option<VehicleKey>,
    /// What it has told of its hardware, in all its messages.
    pub(super) hardware: HardwareIds,
    /// The record of that one as it was when the vehicle restarted, until it tells again who it is: another may have come back on its link.
    pub(super) aside: Option<PlanRecord>,
    /// Whether that is awaited, until `identified_by`.
    pub(super) awaits_identity: bool,
    /// The record whose doubt stands in until the vehicle is identified.
    pub(super) stand_in: Option<VehicleKey>,
    /// Records from runs before.
    pub(super) stored: Vec<StoredRecord>,
    /// What is written down.
    pub(super) kept: PlanRecord,
    pub(super) ticket: u64,
    /// Whether anything was written down of it in this run.
    pub(super) has_put: bool,
    /// When the wait for the hardware's id ends.
    pub(super) identified_by: MonoTime,
    pub(super) incoming: Option<Incoming>,
    /// Another station's plan file that is being written.
    pub(super) incoming_file: Option<(Address, PlanKind)>,
    /// Items in the mission by MISSION_CURRENT.
    pub(super) total: Option<u16>,
    /// Until when that number counts as moving.
    pub(super) moving_until: Option<MonoTime>,
    pub(super) own: Option<Own>,
    /// When a reading that nobody asked for was verified.
    pub(super) own_verified_at: Option<MonoTime>,
    /// Whether a plan is to be read once more although it is known, by kind.
    pub(super) is_copy_doubted: [bool; 3],
    pub(super) attempts: [usize; 3],
    /// How many of the flight parameters were asked for.
    pub(super) parameters_asked: usize,
    pub(super) not_before: [MonoTime; 3],
    pub(super) quiet_since: MonoTime,
    pub(super) is_stirred: bool,
}

impl OnBoard {
    pub(super) fn new(now: MonoTime) -> Self {
        Self {
            doubt: None,
            is_doubt_new: false,
            verified: None,
            key: None,
            hardware: HardwareIds::default(),
            aside: None,
            awaits_identity: false,
            stand_in: None,
            stored: Vec::new(),
            kept: PlanRecord::default(),
            ticket: 0,
            has_put: false,
            identified_by: now + IDENTIFIED_WITHIN,
            incoming: None,
            incoming_file: None,
            total: None,
            moving_until: None,
            own: None,
            own_verified_at: None,
            is_copy_doubted: [false; 3],
            attempts: [0; 3],
            parameters_asked: 0,
            not_before: [now; 3],
            quiet_since: now,
            is_stirred: false,
        }
    }

    /// A plan's state is another one: what failed before may go now.
    pub(super) fn on_state(&mut self, kind: PlanKind, state: PlanState) {
        self.attempts[kind as usize] = 0;
        if let (PlanKind::Mission, PlanState::Verified { .. } | PlanState::Empty) = (kind, state) {
            self.verified = state.count().zip(state.hash());
        }
    }

    /// What is to be remembered.
    pub(super) fn record(&self) -> PlanRecord {
        PlanRecord { verified: self.verified, doubt: self.doubt.clone() }
    }

    /// Whether the doubt may be about another vehicle than the one that is there, which will soon tell who it is.
    pub(super) fn may_doubt_another(&self) -> bool {
        self.stand_in.is_some() || self.awaits_identity && self.doubt.is_some() && !self.is_doubt_new
    }

    pub(super) fn doubt(&self) -> Option<&Doubt> {
        self.doubt.as_ref()
    }

    /// What this run has seen of the mission: from now on it is this vehicle's own, whoever it will tell to be.
    pub(super) fn set_doubt(&mut self, doubt: Option<Doubt>) {
        self.is_doubt_new = doubt.is_some();
        self.doubt = doubt;
        self.stand_in = None;
    }

    pub(super) fn is_own(&self, id: RequestId) -> bool {
        self.own.is_some_and(|own| own.id == id)
    }
}
