//! What is known of the plans on board beyond their states: the doubt, its record, uploads of others, automatic
//! readings.

use vencejo_flight::plan::PlanKind;
use vencejo_proto::{Address, MissionItemInt, MonoTime};

use super::identity::state::{Doubted, Identity, Whose};
use crate::plan_record::{Doubt, PlanRecord, StoredRecord};
use crate::plan_state::PlanState;
use crate::request::RequestId;

/// Another station's upload of a mission.
#[derive(Debug)]
pub(super) struct Incoming {
    pub(super) from: Address,
    pub(super) items: Vec<Option<MissionItemInt>>,
    /// Whether items were asked for or sent.
    pub(super) has_begun: bool,
    pub(super) heard_at: MonoTime,
    /// State and doubt of the mission before; `None` if an upload of ours has begun since.
    pub(super) before: Option<(PlanState, Option<Doubted>)>,
}

/// What is read automatically.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    Plan(PlanKind),
    /// A parameter of an ArduPlane, by its name.
    Parameter(&'static str),
}

/// An automatic reading under way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Own {
    pub(super) id: RequestId,
    pub(super) what: Reading,
    pub(super) began: MonoTime,
}

/// State of the plans on board; `onboard`, `identity` and `others` act on it.
#[derive(Debug)]
pub(super) struct OnBoard {
    pub(super) doubt: Option<Doubted>,
    /// Items and fingerprint of the mission that was verified last, in this run or an earlier one.
    pub(super) verified: Option<(u16, u64)>,
    pub(super) identity: Identity,
    /// Records from earlier runs, newest first.
    pub(super) stored: Vec<StoredRecord>,
    /// The record of `identity.key` as it is on the disk.
    pub(super) kept: PlanRecord,
    pub(super) ticket: u64,
    /// Whether a record has been written in this run.
    pub(super) has_put: bool,
    pub(super) incoming: Option<Incoming>,
    /// Another station's plan file that is being written by MAVFTP.
    pub(super) incoming_file: Option<(Address, PlanKind)>,
    /// Items in the mission by MISSION_CURRENT.
    pub(super) total: Option<u16>,
    /// Until when that number counts as moving.
    pub(super) moving_until: Option<MonoTime>,
    pub(super) own: Option<Own>,
    /// When an automatic reading of the mission succeeded last.
    pub(super) own_verified_at: Option<MonoTime>,
    /// Whether a plan is to be read again although it is known, by kind.
    pub(super) is_copy_doubted: [bool; 3],
    pub(super) attempts: [usize; 3],
    /// How many of the flight parameters have been requested.
    pub(super) parameters_asked: usize,
    pub(super) not_before: [MonoTime; 3],
    pub(super) quiet_since: MonoTime,
    pub(super) is_stirred: bool,
}

impl OnBoard {
    pub(super) fn new(now: MonoTime) -> Self {
        Self {
            doubt: None,
            verified: None,
            identity: Identity::new(now),
            stored: Vec::new(),
            kept: PlanRecord::default(),
            ticket: 0,
            has_put: false,
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

    /// A plan's state has changed: reading it may succeed now.
    pub(super) fn on_state(&mut self, kind: PlanKind, state: PlanState) {
        self.attempts[kind as usize] = 0;
        if let (PlanKind::Mission, PlanState::Verified { .. } | PlanState::Empty) = (kind, state) {
            self.verified = state.count().zip(state.hash());
        }
    }

    /// What is to be recorded. While it is not known which aircraft is there, the doubt about the one before is kept.
    pub(super) fn record(&self) -> PlanRecord {
        let own = self.doubt.as_ref().filter(|doubted| !matches!(doubted.whose, Whose::Stored(_)));
        let doubt = own.map(|doubted| &doubted.doubt).or(self.identity.aside()).cloned();
        PlanRecord { verified: self.verified, doubt }
    }

    pub(super) fn doubt(&self) -> Option<&Doubt> {
        self.doubt.as_ref().map(|doubted| &doubted.doubt)
    }

    /// An upload begins: the mission is doubted until its end is verified.
    pub(super) fn begin_doubt(&mut self, doubt: Doubt) {
        self.doubt = Some(Doubted { doubt, whose: self.identity.present() });
    }

    /// The mission on board is whole.
    pub(super) fn end_doubt(&mut self) {
        if self.doubt.take().is_some() {
            self.identity.on_doubt_ended();
        }
    }

    pub(super) fn is_own(&self, id: RequestId) -> bool {
        self.own.is_some_and(|own| own.id == id)
    }
}
