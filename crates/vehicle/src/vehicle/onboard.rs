//! The plans on board between transfers: the doubt whether the mission is a mixture, and automatic reading of plans
//! that are not known. Which aircraft a doubt belongs to is in `identity`; what other stations do to the plans is in
//! `others`.
//!
//! ```text
//!                 upload begins (ours, another's)          ended, verified
//!   verified ───────────────────────────────────▶ doubt ───────────────────▶ verified
//!      ▲                                            │ cut off, lost, restarted
//!      │ read: what was sent, or what was before    ▼
//!      └──────────────────────────────────── unknown, perhaps mixed ──▶ differs (read: neither)
//! ```
//!
//! A doubt is recorded before the first message of an upload goes out, and outlives restarts of the vehicle and of this
//! program. Only a verified transfer, or reading a mission that is known to be whole, ends it.

use std::sync::Arc;
use std::time::Duration;

use vencejo_flight::plan::PlanKind;
use vencejo_proto::param::ParamName;
use vencejo_proto::{MissionItemInt, MonoTime};

use super::Vehicle;
use super::board::{Own, Reading};
use super::operation::{Op, State};
use super::steps::Step;
use crate::plan_record::{Doubt, Writer};
use crate::plan_state::{PlanState, Unknown};
use crate::request::{Reply, RequestId};
use crate::telemetry::{Severity, SystemStatus};
use crate::transfer::{TransferError, UPLOAD_REST, is_as_sent};

/// Time without requests before a plan is read automatically.
const QUIET: Duration = Duration::from_millis(1_500);
/// An automatic reading that takes longer than this has a slow link, and is cancelled by any request.
const HURRY: Duration = Duration::from_secs(2);
/// Waits before a failed automatic reading is retried; after the last it is given up.
const RETRIES: [Duration; 2] = [Duration::from_secs(10), Duration::from_secs(60)];
/// Parameters of an ArduPlane that are read after its plans: how it circles, how fast it flies, how it turns, whether a
/// return looks for the mission's landing. Each is requested once, even when it does not answer.
const FLIGHT_PARAMETERS: [&str; 4] = ["WP_LOITER_RAD", "AIRSPEED_CRUISE", "ROLL_LIMIT_DEG", "RTL_AUTOLAND"];
/// Parameters that a computer on board reads before those: whose heartbeats the autopilot counts. The second name is
/// from before ArduPilot 4.7.
pub(super) const STATION_PARAMETERS: [&str; 2] = ["MAV_GCS_SYSID", "SYSID_MYGCS"];
/// A mission that was read automatically is returned to requests for it up to this age.
const FRESH_COPY: Duration = Duration::from_secs(3);
/// How long an upload waits for its doubt to be recorded. A failing disk must not prevent a flight.
const RECORDED_WITHIN: Duration = Duration::from_secs(2);

// ── The doubt ────────────────────────────────────────────────────────────────────────────────────────────────────────

impl Vehicle {
    /// The record with this ticket, or a later one, has been written, or could not be: uploads that waited for it
    /// begin.
    pub fn on_kept(&mut self, ticket: u64, now: MonoTime) {
        let is_recorded = |op: &Op| matches!(op.state, State::Recording { ticket: wanted, .. } if wanted <= ticket);
        while let Some(index) = self.ops.iter().position(is_recorded) {
            self.go_on_recorded(index, now);
        }
        self.pump(now);
    }

    fn go_on_recorded(&mut self, index: usize, now: MonoTime) {
        if let State::Recording { step, before, .. } = std::mem::replace(&mut self.ops[index].state, State::Ready) {
            self.run_transfer(index, step, Some(before), now);
        }
    }

    /// Begins to doubt the mission, before `sent` goes out. Returns the ticket of the record that the upload waits for,
    /// and until when.
    pub(super) fn doubt_before_sending(&mut self, sent: Vec<MissionItemInt>, now: MonoTime) -> Option<(u64, MonoTime)> {
        let before = self.before();
        self.on_board.begin_doubt(Doubt { writer: Writer::Us, sent: Some(Arc::new(sent)), before });
        Some((self.remember()?, now + RECORDED_WITHIN))
    }

    /// Fingerprint of the mission on board, or of the one before the doubt began.
    pub(super) fn before(&self) -> Option<u64> {
        match self.on_board.doubt() {
            Some(doubt) => doubt.before,
            None => self.plans.get(PlanKind::Mission).hash(),
        }
    }

    /// Judges a mission that was read: it is whole if there is no doubt, or if it equals the list that was being sent
    /// or one that is known to have been whole.
    pub(super) fn judge(&mut self, wire: &[MissionItemInt], state: PlanState) -> PlanState {
        let PlanState::Verified { count, hash } = state else {
            self.on_board.end_doubt();
            return state;
        };
        let config = self.transfer_config();
        let before = self.on_board.verified.map(|(_, hash)| hash);
        let is_whole = self.on_board.doubt().is_none_or(|doubt| {
            [doubt.before, before].contains(&Some(hash))
                || doubt.sent.as_ref().is_some_and(|sent| is_as_sent(&config, sent, wire))
        });
        if !is_whole {
            return PlanState::Differs { count, hash };
        }
        self.on_board.end_doubt();
        let was_known = self.plans.get(PlanKind::Mission).hash().is_some();
        if !was_known && before.is_some_and(|before| before != hash) {
            tracing::info!(vehicle = %self.address, "the mission on board is not the one that was read back last");
        }
        state
    }
}

// ── A restart ────────────────────────────────────────────────────────────────────────────────────────────────────────

impl Vehicle {
    /// The vehicle restarted: uploads have ended.
    pub(super) fn on_board_restarted(&mut self, since: MonoTime, now: MonoTime) {
        let board = &mut self.on_board;
        (board.incoming_file, board.total, board.moving_until) = (None, None, None);
        (board.quiet_since, board.parameters_asked) = (now, 0);
        if let Some(incoming) = board.incoming.take() {
            self.keep_heard(incoming);
        }
        self.doubt_identity(since, true, now);
        for kind in PlanKind::ALL {
            self.set_plan(kind, self.state_after_restart(kind));
        }
    }

    /// Its heartbeat shows another autopilot than before: another aircraft, or other firmware. What was numbered for
    /// the former one is wrong for it.
    pub(super) fn on_other_autopilot(&mut self, now: MonoTime) {
        let written = self.written[PlanKind::Mission as usize];
        let is_misnumbered = written.is_some_and(|written| written.at >= self.heartbeat_at);
        self.restarted_at = None;
        self.on_restart(now, now);
        if is_misnumbered && self.on_board.doubt.is_none() {
            self.on_board.begin_doubt(Doubt { writer: Writer::Us, sent: None, before: None });
            self.set_plan(PlanKind::Mission, PlanState::Unknown(Unknown::TransferFailed));
        }
        if let Some(doubted) = &mut self.on_board.doubt {
            doubted.doubt.sent = None;
        }
        self.remember();
    }
}

// ── Automatic reading ────────────────────────────────────────────────────────────────────────────────────────────────

impl Vehicle {
    /// Whether it is not up yet. Until its main loop runs, an ArduPlane answers requests for its fence as if it had
    /// none (`AC_PolyFence_loader::num_stored_items`), and says that it is calibrating.
    pub(super) fn is_starting(&self) -> bool {
        let status = self.telemetry.heartbeat.map(|heartbeat| heartbeat.value.system_status);
        matches!(status, Some(SystemStatus::Boot | SystemStatus::Calibrating))
    }

    /// What to read automatically next, and when; `None` while something else is going on.
    fn reading_due(&self) -> Option<(Reading, MonoTime)> {
        let board = &self.on_board;
        let is_busy = !self.ops.is_empty() || self.transfer.is_some() || self.param.is_some();
        let is_identified = board.identity.key.is_some() && board.identity.waits_until().is_none();
        let is_ready = self.telemetry.heartbeat.is_some() && is_identified && self.streams.is_settled();
        let is_held = self.is_lost || is_busy || self.is_starting() || board.incoming.is_some();
        if !self.config.reads_back || !is_ready || is_held {
            return None;
        }
        let is_wanted = |kind: &PlanKind| {
            let is_open = matches!(self.plans.get(*kind), PlanState::Unknown(why) if why != Unknown::Transferring);
            let is_open = is_open || board.is_copy_doubted[*kind as usize];
            // A vehicle whose mission cannot be read is not asked for the other plans.
            let is_mission_known = !matches!(self.plans.get(PlanKind::Mission), PlanState::Unknown(_));
            let may_ask = *kind == PlanKind::Mission || is_mission_known && self.no_plan_kinds().is_none();
            is_open && may_ask && board.attempts[*kind as usize] <= RETRIES.len()
        };
        let due = |kind: PlanKind| {
            let moving = board.moving_until.unwrap_or(board.quiet_since);
            (Reading::Plan(kind), (board.quiet_since + QUIET).max(moving).max(board.not_before[kind as usize]))
        };
        let of_station = if self.our.component.is_onboard_computer() { &STATION_PARAMETERS[..] } else { &[] };
        let mut parameters = of_station.iter().chain(&FLIGHT_PARAMETERS);
        let parameter = parameters.nth(board.parameters_asked).filter(|_| self.is_arduplane());
        let parameter = parameter.map(|name| (Reading::Parameter(name), board.quiet_since + QUIET));
        // At equal times plans come before parameters.
        PlanKind::ALL.into_iter().filter(is_wanted).map(due).chain(parameter).min_by_key(|(_, at)| *at)
    }

    /// When [`Self::on_board_time`] is wanted.
    pub(super) fn on_board_deadline(&self) -> Option<MonoTime> {
        let board = &self.on_board;
        let identified = board.identity.waits_until();
        let left = board.incoming.as_ref().map(|incoming| incoming.heard_at + UPLOAD_REST);
        let recorded = self.ops.iter().filter_map(|op| match &op.state {
            State::Recording { until, .. } => Some(*until),
            _ => None,
        });
        let reading = self.reading_due().map(|(_, at)| at);
        [identified, left, board.moving_until, reading].into_iter().flatten().chain(recorded).min()
    }

    pub(super) fn on_board_time(&mut self, now: MonoTime) {
        if self.on_board.identity.waits_until().is_some_and(|until| now >= until) {
            self.stop_waiting(now);
        }
        let board = &mut self.on_board;
        if let Some(incoming) = board.incoming.take_if(|incoming| now >= incoming.heard_at + UPLOAD_REST)
            // Our own upload is judged by its read-back.
            && !self.writes(PlanKind::Mission)
        {
            self.keep_heard(incoming);
            self.remember();
        }
        if self.on_board.moving_until.take_if(|until| now >= *until).is_some()
            && self.on_board.doubt.is_none()
            && self.plans.get(PlanKind::Mission) == PlanState::Unknown(Unknown::SentElsewhere)
        {
            self.set_plan(PlanKind::Mission, PlanState::Unknown(Unknown::ChangedElsewhere));
        }
        let is_late = |op: &Op| matches!(op.state, State::Recording { until, .. } if now >= until);
        while let Some(index) = self.ops.iter().position(is_late) {
            tracing::warn!(vehicle = %self.address, "an upload begins although its doubt could not be recorded");
            self.note(Severity::WARNING, "the mission's state cannot be written to the disk".to_owned(), now);
            self.go_on_recorded(index, now);
        }
        if let Some((what, at)) = self.reading_due()
            && now >= at
        {
            self.read_by_itself(what, now);
        }
    }

    fn read_by_itself(&mut self, what: Reading, now: MonoTime) {
        let step = match what {
            Reading::Plan(kind) => Step::Download(kind),
            Reading::Parameter(name) => {
                self.on_board.parameters_asked += 1;
                let Ok(name) = ParamName::new(name) else { return };
                Step::ParamRead(name)
            }
        };
        let id = RequestId(self.next_request);
        self.next_request += 1;
        self.ops.push(Op::new(id, [].into()));
        self.on_board.own = Some(Own { id, what, began: now });
        self.run_transfer(self.ops.len() - 1, step, None, now);
    }

    /// A request comes during an automatic reading: it joins if it wants the same plan, else it may cancel the reading.
    /// Returns whether it joined.
    pub(super) fn make_room(&mut self, id: RequestId, steps: &[Step], needs_lane: bool, now: MonoTime) -> bool {
        let Some(own) = self.on_board.own else { return false };
        if let Reading::Plan(kind) = own.what
            && *steps == [Step::Download(kind)]
            && let Some(lane) = &mut self.transfer
        {
            lane.id = id;
            for op in &mut self.ops {
                if op.id == own.id {
                    op.id = id;
                }
            }
            self.on_board.own = None;
            return true;
        }
        if needs_lane || now.since(own.began) > HURRY {
            for lane in [&mut self.transfer, &mut self.param].into_iter().flatten().filter(|lane| lane.id == own.id) {
                lane.cancel(now);
            }
            self.drain_lanes(now);
        }
        false
    }

    /// The reply to a download of the mission that was read automatically just now.
    pub(super) fn fresh_copy(&self, steps: &[Step], now: MonoTime) -> Option<Reply> {
        let is_fresh = self.on_board.own_verified_at.is_some_and(|at| now.since(at) < FRESH_COPY);
        if !is_fresh || *steps != [Step::Download(PlanKind::Mission)] {
            return None;
        }
        let state = self.plans.get(PlanKind::Mission);
        let mission = self.mission()?;
        let (items, home) = (mission.items.clone(), mission.home);
        Some(Reply::Plan { kind: PlanKind::Mission, items, home, state, position_error_m: None })
    }

    /// What an automatic reading is about; `None` for requests.
    pub(super) fn on_board_own(&self, id: RequestId) -> Option<Reading> {
        self.on_board.own.filter(|own| own.id == id).map(|own| own.what)
    }

    /// Has a plan read once more although it is known, at `from` or later.
    pub(super) fn doubt_copy(&mut self, kind: PlanKind, from: MonoTime) {
        self.on_board.is_copy_doubted[kind as usize] = true;
        let not_before = &mut self.on_board.not_before[kind as usize];
        *not_before = from.max(*not_before);
    }

    /// An automatic reading has ended.
    pub(super) fn on_own_read(&mut self, what: Reading, error: Option<&TransferError>, now: MonoTime) {
        self.on_board.own = None;
        let Reading::Plan(kind) = what else { return };
        let (attempts, not_before) =
            (&mut self.on_board.attempts[kind as usize], &mut self.on_board.not_before[kind as usize]);
        match error {
            None => {
                self.on_board.is_copy_doubted[kind as usize] = false;
                self.on_board.own_verified_at =
                    (kind == PlanKind::Mission).then_some(now).or(self.on_board.own_verified_at);
            }
            // It made room for a request.
            Some(TransferError::Cancelled) => {}
            Some(TransferError::Refused { .. } | TransferError::OnlyMission { .. }) if kind != PlanKind::Mission => {
                *attempts = RETRIES.len() + 1;
            }
            Some(error) => {
                tracing::debug!(vehicle = %self.address, %kind, %error, "the plan on board could not be read");
                if let Some(wait) = RETRIES.get(*attempts) {
                    *not_before = now + *wait;
                }
                *attempts += 1;
            }
        }
    }

    /// Restarts the quiet time before automatic readings while requests are pending or have just ended, and while the
    /// vehicle starts.
    pub(super) fn stay_quiet(&mut self, now: MonoTime) {
        let is_stirred = std::mem::take(&mut self.on_board.is_stirred);
        if is_stirred || self.pending() > 0 || self.is_starting() {
            self.on_board.quiet_since = now;
        }
    }
}
