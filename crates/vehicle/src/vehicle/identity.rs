//! Which aircraft the vehicle is. Several may use one system id, one after the other on the same radio, so what is
//! known of the mission on board belongs to the hardware that AUTOPILOT_VERSION names, and is recorded under its id.
//!
//! ```text
//!                    it tells the id of its hardware
//!   first heard ──▶ unsure ─────────────────────────▶ known
//!                   ▲    ▲                              │
//!                   └────┴── restarted, or heard again ─┘
//!                            after a silence
//! ```
//!
//! While it is unsure, AUTOPILOT_VERSION is requested until it comes (`streams`), and for `IDENTIFIED_WITHIN` a
//! mission that is read is not judged by a doubt that may be about another aircraft. Then one that has not told counts
//! as the one before, whose record keeps its doubt all the same. The id decides about the doubt by [`Whose`] it is:
//!
//! | doubt | the same id | another id |
//! |---|---|---|
//! | `Known`: began while the aircraft was known | stays | stays with the aircraft before |
//! | `Present`: began since it is unsure | stays | goes to this aircraft |
//! | `Either`: began when it was unsure before | stays | goes to both |
//! | `Stored`: read from the disk | becomes its own | is dropped; one under a system id goes to this aircraft |

pub(super) mod state;

use std::sync::Arc;

use vencejo_flight::checks::CheckContext;
use vencejo_flight::plan::PlanKind;
use vencejo_flight::rehearsal::Learner;
use vencejo_proto::MonoTime;

use self::state::{Doubted, Unsure, Whose};
use super::board::OnBoard;
use super::{FlightParameters, Vehicle};
use crate::plan_record::{Doubt, HardwareIds, PlanRecord, StoredRecord, VehicleKey, Writer};
use crate::plan_state::{PlanState, Unknown};
use crate::request::Output;
use crate::streams::AUTOPILOT_VERSION;
use crate::transfer::UPLOAD_REST;

/// The reason that goes with a doubt.
fn unknown_of(doubt: &Doubt) -> Unknown {
    match doubt.writer {
        Writer::Us => Unknown::TransferFailed,
        Writer::Another => Unknown::SentElsewhere,
        Writer::NotKnown => Unknown::RecordDamaged,
    }
}

// ── Identification ───────────────────────────────────────────────────────────────────────────────────────────────────

impl Vehicle {
    /// From `since` on it may be another aircraft, until it tells who it is.
    pub(super) fn doubt_identity(&mut self, since: MonoTime, has_restarted: bool, now: MonoTime) {
        let is_ours_written = self.writes(PlanKind::Mission);
        let board = &mut self.on_board;
        let is_theirs_written = board.incoming.as_ref().is_some_and(|incoming| now < incoming.heard_at + UPLOAD_REST);
        let record = board.record();
        let is_by_hardware = board.identity.key.as_ref().is_some_and(VehicleKey::is_hardware);
        let aside = is_by_hardware.then(|| record.clone());
        board.identity.unsure = Some(Unsure::new(since, has_restarted, aside, now));
        match &mut board.doubt {
            Some(Doubted { whose, .. })
                if *whose == Whose::Present || *whose == Whose::Known && (is_ours_written || is_theirs_written) =>
            {
                *whose = Whose::Either;
            }
            Some(_) => {}
            // The one that was there since has none, the one before may be back.
            None => {
                if let Some(doubt) = record.doubt {
                    self.take_over(doubt, Whose::Known);
                }
            }
        }
    }

    /// AUTOPILOT_VERSION has come.
    pub(super) fn on_version(&mut self, now: MonoTime) {
        let Some(version) = self.telemetry.version.map(|version| version.value) else { return };
        let told = HardwareIds::of_version(&version);
        if told.is_another(self.on_board.identity.hardware) {
            self.on_exchange(now);
        }
        self.streams.on_received(AUTOPILOT_VERSION);
        let hardware = told.or(self.on_board.identity.hardware);
        self.on_board.identity.hardware = hardware;
        match hardware.key().filter(|_| told.key().is_some()) {
            Some(key) => self.identify(key, now),
            None => self.stop_waiting(now),
        }
    }

    /// It is another aircraft than the one before. What has come since it may be is of this one.
    fn on_exchange(&mut self, now: MonoTime) {
        if self.on_board.identity.unsure.is_none() {
            self.doubt_identity(now, false, now);
        }
        let Some(unsure) = &self.on_board.identity.unsure else { return };
        let (since, has_restarted, has_ended_doubt) = (unsure.since, unsure.has_restarted, unsure.has_ended_doubt);
        if !has_restarted {
            // What was under way may have begun with the one before.
            self.end_life(since, now);
        }
        let doubted = self.on_board.doubt.clone();
        let carried = doubted.filter(|doubted| matches!(doubted.whose, Whose::Present | Whose::Either));
        self.on_board_replaced(carried.map(|doubted| doubted.doubt), has_ended_doubt, now);
    }

    /// Another aircraft is in its place: of the one before is recorded what is known, and of this one what was recorded
    /// counts, or the doubt that is `carried` over to it; neither where one `has_ended_doubt` since it may be there.
    pub(super) fn on_board_replaced(&mut self, carried: Option<Doubt>, has_ended_doubt: bool, now: MonoTime) {
        let board = &mut self.on_board;
        if let Some(key) = board.identity.key.take() {
            let aside = board.identity.unsure.as_mut().and_then(|unsure| unsure.aside.take());
            let record = aside.unwrap_or_else(|| board.record());
            let is_changed = record != board.kept;
            let system = Some(self.address.system);
            board.stored.retain(|stored| stored.key != key);
            board.stored.push(StoredRecord { key: key.clone(), system, record: record.clone() });
            if is_changed && self.config.keeps_records {
                self.put(key, record);
            }
        }
        let before = std::mem::replace(&mut self.on_board, OnBoard::new(now));
        (self.on_board.ticket, self.on_board.incoming, self.on_board.own) =
            (before.ticket, before.incoming, before.own);
        for kind in PlanKind::ALL {
            // What is being written is written to this one.
            if !self.writes(kind) {
                self.set_plan(kind, PlanState::Unknown(Unknown::NeverRead));
            }
        }
        let is_type_known = self.telemetry.heartbeat.is_some();
        if !is_type_known {
            (self.told.mode, self.telemetry.last_type) = (None, None);
        }
        self.flight_parameters = FlightParameters::default();
        self.parameters = Arc::default();
        self.limits = CheckContext::default();
        self.learner = Learner::default();
        if has_ended_doubt {
            self.on_board.identity.on_doubt_ended();
        }
        if let Some(mut doubt) = carried {
            // A list that was numbered for another autopilot is not to be compared with this one's.
            doubt.sent.take_if(|_| !is_type_known);
            self.take_over(doubt, Whose::Present);
        }
        self.on_records(before.stored, now);
    }

    /// The vehicle has told the id of its hardware.
    fn identify(&mut self, key: VehicleKey, now: MonoTime) {
        if self.on_board.identity.key.as_ref() != Some(&key) {
            self.take_record(key);
        }
        let board = &mut self.on_board;
        board.identity.unsure = None;
        if let Some(doubted) = &mut board.doubt {
            doubted.whose = Whose::Known;
        }
        self.remember();
        self.pump(now);
    }

    /// The vehicle has not told the id of its hardware within `IDENTIFIED_WITHIN`, or has none: it stays unsure.
    pub(super) fn stop_waiting(&mut self, now: MonoTime) {
        if let Some(unsure) = &mut self.on_board.identity.unsure {
            unsure.waits_until = None;
        }
        if self.on_board.identity.key.is_none() {
            self.take_record(VehicleKey::of_system(self.address.system));
            self.remember();
        }
        self.pump(now);
    }

    /// Keeps the record of `key` from now on, and takes over what is stored there.
    fn take_record(&mut self, key: VehicleKey) {
        let board = &mut self.on_board;
        let before = board.identity.key.replace(key.clone()).filter(|before| *before != key);
        let found = board.stored.iter().find(|stored| stored.key == key).map(|stored| stored.record.clone());
        let found = found.unwrap_or_default();
        board.kept = found.clone();
        let mut moved = before.filter(|_| board.has_put);
        if let Some(Doubted { whose, .. }) = &mut board.doubt
            && let Whose::Stored(stored) = whose
            && (*stored == key || key.is_hardware())
        {
            if *stored != key && stored.is_hardware() {
                board.doubt = None;
            } else {
                moved = moved.or(Some(stored.clone()).filter(|stored| *stored != key));
                *whose = Whose::Present;
            }
        }
        match found.doubt {
            Some(doubt) if board.doubt.is_none() && !board.identity.has_ended_doubt() => {
                // What was read meanwhile was not judged by this doubt.
                board.verified = found.verified;
                self.take_over(doubt, Whose::Present);
            }
            _ => {
                board.verified = board.verified.or(found.verified);
                let may_be_mixed = self.plans.get(PlanKind::Mission).may_be_mixed();
                if self.on_board.doubt.is_none() && may_be_mixed && !self.writes(PlanKind::Mission) {
                    self.set_plan(PlanKind::Mission, PlanState::Unknown(Unknown::NeverRead));
                }
            }
        }
        if let Some(moved) = moved.filter(|_| self.config.keeps_records) {
            // What was recorded under the name before goes under this one; a doubt that may be of either, under both.
            let doubted = self.on_board.doubt.as_ref().filter(|doubted| doubted.whose == Whose::Either);
            let doubt = doubted.filter(|_| !moved.is_hardware()).map(|doubted| doubted.doubt.clone());
            self.put(moved, PlanRecord { verified: None, doubt });
        }
    }

    /// Doubts the mission as it was doubted before.
    fn take_over(&mut self, doubt: Doubt, whose: Whose) {
        let unknown = unknown_of(&doubt);
        self.on_board.doubt = Some(Doubted { doubt, whose });
        if !self.writes(PlanKind::Mission) {
            self.set_plan(PlanKind::Mission, PlanState::Unknown(unknown));
        }
    }

    /// The state of a plan after a restart.
    pub(super) fn state_after_restart(&self, kind: PlanKind) -> PlanState {
        let doubt = self.on_board.doubt().filter(|_| kind == PlanKind::Mission);
        PlanState::Unknown(doubt.map_or(Unknown::Rebooted, unknown_of))
    }

    /// Whether what a mission is that was read waits until it is known whose it is.
    pub(super) fn holds_verdict(&self) -> bool {
        let board = &self.on_board;
        let may_be_anothers = board.doubt.as_ref().is_some_and(|doubted| doubted.whose != Whose::Present);
        may_be_anothers && board.identity.waits_until().is_some()
    }
}

// ── Records ──────────────────────────────────────────────────────────────────────────────────────────────────────────

impl Vehicle {
    /// Records from runs before, of all vehicles, newest first. Which is this one's shows when it tells the id of its
    /// hardware; until then a doubt about one of its system id, or of an unknown one, counts for it.
    pub fn on_records(&mut self, stored: Vec<StoredRecord>, now: MonoTime) {
        let board = &mut self.on_board;
        board.stored = stored;
        match board.identity.key.clone() {
            // What happened meanwhile is newer than what was written before it.
            Some(_) if board.has_put => {}
            Some(key) => {
                self.take_record(key);
                if self.on_board.identity.unsure.is_none()
                    && let Some(doubted) = &mut self.on_board.doubt
                {
                    doubted.whose = Whose::Known;
                }
                self.remember();
                self.pump(now);
            }
            None if board.doubt.is_none() && !board.identity.has_ended_doubt() => {
                let is_ours = |stored: &&StoredRecord| stored.system.is_none_or(|system| system == self.address.system);
                let mut found = board.stored.iter().filter(is_ours);
                let found = found.find_map(|stored| Some((stored.key.clone(), stored.record.doubt.clone()?)));
                if let Some((key, doubt)) = found {
                    self.take_over(doubt, Whose::Stored(key));
                }
            }
            None => {}
        }
    }

    fn put(&mut self, key: VehicleKey, record: PlanRecord) -> u64 {
        self.on_board.ticket += 1;
        self.on_board.has_put = true;
        let (ticket, system) = (self.on_board.ticket, Some(self.address.system));
        self.outputs.push_back(Output::Keep { ticket, stored: StoredRecord { key, system, record } });
        ticket
    }

    /// Has what is known of the mission recorded where it has changed. Returns the ticket of the record.
    pub(super) fn remember(&mut self) -> Option<u64> {
        if !self.config.keeps_records {
            return None;
        }
        let board = &mut self.on_board;
        let record = board.record();
        let is_stored = board.doubt.as_ref().is_some_and(|doubted| matches!(doubted.whose, Whose::Stored(_)));
        if record == board.kept || is_stored {
            return None;
        }
        let system = self.address.system;
        let key = board.identity.key.get_or_insert_with(|| VehicleKey::of_system(system)).clone();
        board.kept = record.clone();
        Some(self.put(key, record))
    }
}
