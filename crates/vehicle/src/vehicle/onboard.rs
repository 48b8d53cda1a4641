//! The plans on board beyond the transfers of this moment: the doubt whether the mission is a mixture, what of it outlives the program, and the
//! reading back of what is not known, by itself. What other stations do to them is in `others`.
//!
//! ```text
//!                 upload begins (ours, another's)          ended, verified
//!   verified ───────────────────────────────────▶ doubt ───────────────────▶ verified
//!      ▲                                            │ cut off, lost, restarted
//!      │ read: what was sent, or what was before    ▼
//!      └──────────────────────────────────── unknown, perhaps mixed ──▶ differs (read: neither)
//! ```
//!
//! A doubt is written down before the first message of an upload goes out, and goes with the vehicle (its hardware's id) through
//! restarts of the vehicle and of this program. It ends with a transfer that is verified, not by being forgotten.

use std::sync::Arc;
use std::time::Duration;

use vencejo_flight::checks::CheckContext;
use vencejo_flight::plan::PlanKind;
use vencejo_flight::rehearsal::Learner;
use vencejo_proto::param::ParamName;
use vencejo_proto::{MissionItemInt, MonoTime};

use super::board::{IDENTIFIED_WITHIN, OnBoard, Own, Reading};
use super::operation::{Op, State};
use super::steps::Step;
use super::{FlightParameters, Vehicle};
use crate::plan_record::{Doubt, HardwareIds, PlanRecord, StoredRecord, VehicleKey, Writer};
use crate::plan_state::{PlanState, Unknown};
use crate::request::{Output, Reply, RequestId};
use crate::streams::AUTOPILOT_VERSION;
use crate::telemetry::Severity;
use crate::transfer::{TransferError, UPLOAD_REST, is_as_sent};

/// Nobody has asked for anything for this long before a plan is read without being asked for.
const QUIET: Duration = Duration::from_millis(1_500);
/// A reading that nobody asked for and that takes longer than this has a slow link, and makes room for any request.
const HURRY: Duration = Duration::from_secs(2);
/// Waits before a plan that could not be read is tried again; after them it is left alone.
const RETRIES: [Duration; 2] = [Duration::from_secs(10), Duration::from_secs(60)];
/// What an ArduPlane is asked for after its plans: how it circles, how fast it flies, how it turns, whether a return looks for the
/// mission's landing. Each once, also when it does not answer.
const FLIGHT_PARAMETERS: [&str; 4] = ["WP_LOITER_RAD", "AIRSPEED_CRUISE", "ROLL_LIMIT_DEG", "RTL_AUTOLAND"];
/// What a computer on board asks for before those: whose heartbeats the autopilot counts. The second name is that before ArduPilot 4.7.
pub(super) const STATION_PARAMETERS: [&str; 2] = ["MAV_GCS_SYSID", "SYSID_MYGCS"];
/// A plan that was read by itself this long ago is given to who asks for it.
const FRESH_COPY: Duration = Duration::from_secs(3);
/// How long an upload waits until it is written down that it begins. A disk that fails does not keep anybody from flying.
const RECORDED_WITHIN: Duration = Duration::from_secs(2);

/// The reason that goes with a doubt.
fn unknown_of(doubt: &Doubt) -> Unknown {
    match doubt.writer {
        Writer::Us => Unknown::TransferFailed,
        Writer::Another => Unknown::SentElsewhere,
        Writer::NotKnown => Unknown::RecordDamaged,
    }
}

// ── What outlives the program ────────────────────────────────────────────────────────────────────────────────────────

impl Vehicle {
    /// Records from runs before, of all vehicles. Which is this one's shows when it tells the id of its hardware; until then a
    /// doubt about one of its system id, or of none that is known, counts for it.
    pub fn on_records(&mut self, stored: Vec<StoredRecord>, now: MonoTime) {
        let board = &mut self.on_board;
        board.stored = stored;
        match board.key.take() {
            // What happened meanwhile is newer than what was written before it.
            Some(key) if board.has_put => board.key = Some(key),
            Some(key) => self.identify(key, now),
            None if board.doubt.is_none() => {
                let is_ours = |stored: &&StoredRecord| stored.system.is_none_or(|system| system == self.address.system);
                let found = board.stored.iter().filter(is_ours).find(|stored| stored.record.doubt.is_some());
                let Some(found) = found else { return };
                board.stand_in = Some(found.key.clone());
                let doubt = found.record.doubt.clone();
                self.take_over(doubt);
            }
            None => {}
        }
    }

    /// Another vehicle is in its place: what is remembered of that one counts, and of the one before it is remembered what is known.
    pub(super) fn on_board_replaced(&mut self, now: MonoTime) {
        let board = &mut self.on_board;
        if let Some(key) = board.key.clone() {
            // What has come since the restart is of the one that is there now.
            let record = board.aside.take().unwrap_or_else(|| board.record());
            let is_other = record != board.kept;
            board.stored.retain(|stored| stored.key != key);
            board.stored.push(StoredRecord {
                key: key.clone(),
                system: Some(self.address.system),
                record: record.clone(),
            });
            if is_other && self.config.keeps_records {
                self.put(key, record);
            }
        }
        let before = std::mem::replace(&mut self.on_board, OnBoard::new(now));
        (self.on_board.ticket, self.on_board.incoming, self.on_board.own) =
            (before.ticket, before.incoming, before.own);
        for kind in PlanKind::ALL {
            // What is being written is written to this one.
            if self.plans.get(kind) != PlanState::Unknown(Unknown::Transferring) {
                self.set_plan(kind, PlanState::Unknown(Unknown::NeverRead));
            }
        }
        if self.telemetry.heartbeat.is_none() {
            // What the one before was, this one may not be.
            (self.told.mode, self.telemetry.last_type) = (None, None);
        }
        self.flight_parameters = FlightParameters::default();
        self.parameters = Arc::default();
        self.limits = CheckContext::default();
        self.learner = Learner::default();
        self.on_records(before.stored, now);
        if before.is_doubt_new {
            self.on_board.set_doubt(None);
            self.take_over(before.doubt);
        }
    }

    /// It may be another vehicle from now on: what was written before is about the one before, unless it is still being written.
    pub(super) fn on_board_may_be_anothers(&mut self) {
        let is_writing = self.transfer.as_ref().is_some_and(|lane| lane.machine.writes_plan());
        self.on_board.is_doubt_new &= is_writing || self.on_board.incoming.is_some();
    }

    /// Doubts a mission as it was doubted in a run before.
    fn take_over(&mut self, doubt: Option<Doubt>) {
        let Some(doubt) = doubt else { return };
        let unknown = unknown_of(&doubt);
        self.on_board.doubt = Some(doubt);
        let is_moving = self.transfer.as_ref().is_some_and(|lane| lane.machine.writes_plan());
        if !is_moving {
            self.set_plan(PlanKind::Mission, PlanState::Unknown(unknown));
        }
    }

    pub(super) fn on_version(&mut self, now: MonoTime) {
        let Some(version) = self.telemetry.version.map(|version| version.value) else { return };
        self.streams.on_received(AUTOPILOT_VERSION);
        let hardware = HardwareIds::of_version(&version);
        let is_another = hardware.is_another(self.on_board.hardware);
        if is_another {
            // What began since it started is about this one, and what was asked of it is asked of this one, however late it tells who it is.
            if self.on_board.aside.is_none() {
                let is_doubt_new = self.on_board.is_doubt_new;
                self.on_restart(now, now);
                self.on_board.is_doubt_new = is_doubt_new;
            }
            self.on_board_replaced(now);
        }
        self.on_board.hardware = hardware.or(self.on_board.hardware);
        let by_system = VehicleKey::of_system(self.address.system);
        self.identify(self.on_board.hardware.key().unwrap_or(by_system), now);
        if is_another {
            self.pump(now);
        }
    }

    /// It is known who it is, or known better.
    fn identify(&mut self, key: VehicleKey, now: MonoTime) {
        self.on_board.awaits_identity = false;
        if self.on_board.key.as_ref() == Some(&key) {
            self.on_board.aside = None;
            return;
        }
        if self.on_board.key.as_ref().is_some_and(|before| before.system().is_none()) && key.system().is_some() {
            // One that has told its hardware's id keeps it.
            return;
        }
        self.on_board.aside = None;
        let board = &mut self.on_board;
        let before = board.key.replace(key.clone());
        let is_another = board.stand_in.take().is_some_and(|stand_in| stand_in != key);
        if is_another {
            // The doubt was about another vehicle of this system id.
            board.doubt = None;
            if matches!(
                self.plans.get(PlanKind::Mission),
                PlanState::Unknown(Unknown::TransferFailed | Unknown::SentElsewhere | Unknown::RecordDamaged)
            ) {
                self.set_plan(PlanKind::Mission, PlanState::Unknown(Unknown::NeverRead));
            }
        }
        let board = &mut self.on_board;
        let found = board.stored.iter().find(|stored| stored.key == key).map(|stored| stored.record.clone());
        let kept = found.unwrap_or_default();
        let wrote = board.has_put;
        board.kept = kept.clone();
        board.verified = board.verified.or(kept.verified);
        if board.doubt.is_none() && !wrote {
            self.take_over(kept.doubt);
        }
        if let Some(before) = before.filter(|_| wrote) {
            // What was written under the name before goes under this one.
            self.put(before, PlanRecord::default());
        }
        self.remember();
        self.pump(now);
    }

    fn put(&mut self, key: VehicleKey, record: PlanRecord) -> u64 {
        self.on_board.ticket += 1;
        self.on_board.has_put = true;
        let (ticket, system) = (self.on_board.ticket, Some(self.address.system));
        self.outputs.push_back(Output::Keep { ticket, stored: StoredRecord { key, system, record } });
        ticket
    }

    /// Has what is known of the mission written down, when that is another thing than before.
    pub(super) fn remember(&mut self) -> Option<u64> {
        if !self.config.keeps_records {
            return None;
        }
        let board = &mut self.on_board;
        let record = board.record();
        if record == board.kept || board.stand_in.is_some() {
            return None;
        }
        let system = self.address.system;
        let key = board.key.get_or_insert_with(|| VehicleKey::of_system(system)).clone();
        board.kept = record.clone();
        Some(self.put(key, record))
    }

    /// A record has been written down, or could not be: what waited for it goes on.
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

    /// Begins to doubt the mission, before `sent` goes out. Returns what it must wait for, if for anything.
    pub(super) fn doubt_before_sending(&mut self, sent: Vec<MissionItemInt>, now: MonoTime) -> Option<(u64, MonoTime)> {
        let before = self.before();
        self.on_board.set_doubt(Some(Doubt { writer: Writer::Us, sent: Some(Arc::new(sent)), before }));
        Some((self.remember()?, now + RECORDED_WITHIN))
    }

    /// Fingerprint of the mission on board, or of that before a doubt began.
    pub(super) fn before(&self) -> Option<u64> {
        match &self.on_board.doubt {
            Some(doubt) => doubt.before,
            None => self.plans.get(PlanKind::Mission).hash(),
        }
    }

    /// What a mission is that was read: verified, or one that is neither what was sent nor what was before.
    pub(super) fn judge(&mut self, wire: &[MissionItemInt], state: PlanState) -> PlanState {
        let PlanState::Verified { count, hash } = state else {
            self.on_board.set_doubt(None);
            return state;
        };
        let config = self.transfer_config();
        let is_whole = self.on_board.doubt.as_ref().is_none_or(|doubt| {
            doubt.before == Some(hash) || doubt.sent.as_ref().is_some_and(|sent| is_as_sent(&config, sent, wire))
        });
        if !is_whole {
            return PlanState::Differs { count, hash };
        }
        self.on_board.set_doubt(None);
        let before = self.on_board.verified.filter(|_| self.plans.get(PlanKind::Mission).hash().is_none());
        if before.is_some_and(|(_, before)| before != hash) {
            tracing::info!(vehicle = %self.address, "the mission on board is not the one that was read back last");
        }
        state
    }
}

// ── A restart ────────────────────────────────────────────────────────────────────────────────────────────────────────

impl Vehicle {
    /// The vehicle restarted: what was being written is over.
    pub(super) fn on_board_restarted(&mut self, now: MonoTime) {
        let board = &mut self.on_board;
        (board.incoming_file, board.total, board.moving_until, board.own) = (None, None, None, None);
        (board.quiet_since, board.parameters_asked, board.is_doubt_new) = (now, 0, false);
        if let Some(incoming) = board.incoming.take() {
            self.keep_heard(incoming);
        }
        for kind in PlanKind::ALL {
            let doubt = self.on_board.doubt.as_ref().filter(|_| kind == PlanKind::Mission);
            self.set_plan(kind, PlanState::Unknown(doubt.map_or(Unknown::Rebooted, unknown_of)));
        }
        let board = &mut self.on_board;
        if board.key.as_ref().is_some_and(|key| key.system().is_none()) {
            let record = board.record();
            board.aside.get_or_insert(record);
            (board.awaits_identity, board.identified_by) = (true, now + IDENTIFIED_WITHIN);
        }
    }
}

impl Vehicle {
    /// Its heartbeat shows another autopilot than before: another aircraft, or other firmware. What was numbered for the
    /// former one is wrong for it.
    pub(super) fn on_other_autopilot(&mut self, now: MonoTime) {
        let written = self.written[PlanKind::Mission as usize];
        let is_misnumbered = written.is_some_and(|written| written.at >= self.heartbeat_at);
        self.restarted_at = None;
        self.on_restart(now, now);
        if is_misnumbered && self.on_board.doubt.is_none() {
            self.on_board.set_doubt(Some(Doubt { writer: Writer::Us, sent: None, before: None }));
            self.set_plan(PlanKind::Mission, PlanState::Unknown(Unknown::TransferFailed));
        }
        if let Some(doubt) = &mut self.on_board.doubt {
            doubt.sent = None;
        }
        self.remember();
    }
}

// ── What is read by itself ───────────────────────────────────────────────────────────────────────────────────────────

impl Vehicle {
    /// What is to be read by itself, and when; `None` while something else goes on.
    fn reading_due(&self) -> Option<(Reading, MonoTime)> {
        let board = &self.on_board;
        let is_busy = !self.ops.is_empty() || self.transfer.is_some() || self.param.is_some();
        let is_identified = board.key.is_some() && !board.awaits_identity;
        let is_ready = self.telemetry.heartbeat.is_some() && is_identified && self.streams.is_settled();
        if !self.config.reads_back || self.is_lost || is_busy || !is_ready || board.incoming.is_some() {
            return None;
        }
        let is_wanted = |kind: &PlanKind| {
            let is_open = matches!(self.plans.get(*kind), PlanState::Unknown(why) if why != Unknown::Transferring);
            let is_open = is_open || board.is_copy_doubted[*kind as usize];
            // A vehicle that does not tell its mission is not asked for the others.
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
        // Of two at the same time the first.
        PlanKind::ALL.into_iter().filter(is_wanted).map(due).chain(parameter).min_by_key(|(_, at)| *at)
    }

    /// Whether it is to tell soon who it is.
    fn awaits_identity(&self) -> bool {
        let board = &self.on_board;
        (board.key.is_none() || board.awaits_identity) && self.telemetry.heartbeat.is_some()
    }

    /// Whether what a mission is that was read waits until it is known whose it is.
    pub(super) fn holds_verdict(&self) -> bool {
        self.awaits_identity() && self.on_board.may_doubt_another()
    }

    /// When [`Self::on_board_time`] is wanted.
    pub(super) fn on_board_deadline(&self) -> Option<MonoTime> {
        let board = &self.on_board;
        let identified = self.awaits_identity().then_some(board.identified_by);
        let left = board.incoming.as_ref().map(|incoming| incoming.heard_at + UPLOAD_REST);
        let recorded = self.ops.iter().filter_map(|op| match &op.state {
            State::Recording { until, .. } => Some(*until),
            _ => None,
        });
        let reading = self.reading_due().map(|(_, at)| at);
        [identified, left, board.moving_until, reading].into_iter().flatten().chain(recorded).min()
    }

    pub(super) fn on_board_time(&mut self, now: MonoTime) {
        if self.awaits_identity() && now >= self.on_board.identified_by {
            self.identify(VehicleKey::of_system(self.address.system), now);
        }
        let board = &mut self.on_board;
        if let Some(incoming) = board.incoming.take_if(|incoming| now >= incoming.heard_at + UPLOAD_REST)
            // What we write ourselves is found out by reading it back.
            && !self.transfer.as_ref().is_some_and(|lane| lane.is_about(PlanKind::Mission) && lane.machine.writes_plan())
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
            tracing::warn!(vehicle = %self.address, "an upload begins although it could not be written down that it does");
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

    /// A request comes while a plan is read that nobody asked for: it joins, or goes before. Whether it joined.
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

    /// The plan as it was read by itself just now, for who asks for it.
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

    /// What a reading that nobody asked for is about, if it is one.
    pub(super) fn on_board_own(&self, id: RequestId) -> Option<Reading> {
        self.on_board.own.filter(|own| own.id == id).map(|own| own.what)
    }

    /// The copy of a plan is to be compared with the vehicle's once more, at `from` or later.
    pub(super) fn doubt_copy(&mut self, kind: PlanKind, from: MonoTime) {
        self.on_board.is_copy_doubted[kind as usize] = true;
        let not_before = &mut self.on_board.not_before[kind as usize];
        *not_before = from.max(*not_before);
    }

    /// A reading that nobody asked for has ended.
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
            // It made room for somebody.
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

    /// Somebody asks, or something goes on: a reading that nobody asked for waits.
    pub(super) fn stay_quiet(&mut self, now: MonoTime) {
        let is_stirred = std::mem::take(&mut self.on_board.is_stirred);
        if is_stirred || self.pending() > 0 {
            self.on_board.quiet_since = now;
        }
    }
}
