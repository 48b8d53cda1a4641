//! Uploads of plans, and their verification.
//!
//! An upload succeeds only when the list read back is the list that was sent, as the vehicle stores it; until then the
//! plan is unknown.

use vencejo_flight::plan::{Keeping, MissionItem, PlanKind, plans_equal_as_stored};
use vencejo_proto::dialect::{MISSION_CLEAR_ALL_DATA, MavMessage};
use vencejo_proto::plan_file::{PLAN_FILE_ITEM_LEN, encode_plan_file};
use vencejo_proto::{Address, Message, MissionItemInt, MonoTime};

use super::download::{DownloadedPlan, path};
use super::float::largest_error_m;
use super::ftp::{FileWrite, abandon};
use super::items::{ItemUpload, ItemsSent, Outbox, mav_mission_type};
use super::read_back::{Others, OthersUntil, ReadBack};
use super::route::PlanRoute;
use super::timing::{DENIED_WAIT, MESSAGE_TIMEOUT, RESTARTS, RoundTrip, SILENCE_LIMIT};
use super::{MissionResult, Transfer, TransferConfig, TransferError, TransferOutput};

/// A plan that the vehicle has, read back from it.
#[derive(Debug, Clone, PartialEq)]
pub struct VerifiedPlan {
    /// Which.
    pub kind: PlanKind,
    /// The list as the vehicle holds it, seq 0 upwards, home included where it is item 0.
    pub items: Vec<MissionItemInt>,
    /// How it was sent.
    pub route: PlanRoute,
    /// How far the farthest position is from where it was sent to be, metres, home of an ArduPilot aside; `None` when
    /// all are exact. Only [`PlanRoute::FloatItems`] moves positions, by what 32-bit floats cannot hold: up to 0.8 m at
    /// latitude 40°, 3.6 m at longitude 180°.
    pub position_error_m: Option<f64>,
}

/// Replaces a plan by the best route, reads it back and compares. See [`PlanRoute`].
#[derive(Debug)]
pub struct PlanUpload {
    config: TransferConfig,
    kind: PlanKind,
    items: Vec<MissionItemInt>,
    route: PlanRoute,
    /// The MAVFTP session that carried the file.
    session: Option<u8>,
    /// How often the list was sent again because the vehicle did not confirm it.
    resent: u32,
    /// The vehicle's id of the list since it has it.
    plan_id: Option<u32>,
    others: OthersUntil,
    step: Step,
    result: Option<Result<VerifiedPlan, TransferError>>,
    out: Outbox,
}

#[derive(Debug)]
enum Step {
    SendFile(Box<FileWrite>),
    SendItems(ItemUpload),
    /// The upload is kept when its final MISSION_ACK did not come: the vehicle may still ask for an item.
    ReadBack(Box<ReadBack>, Option<ItemUpload>),
    Over,
}

impl PlanUpload {
    /// Begins to send `items`: the list as on the wire, seq 0 upwards, home included where the vehicle has it as item 0
    /// (`Mission::to_wire`). Whom the items are addressed to is set here.
    pub fn new(config: &TransferConfig, kind: PlanKind, mut items: Vec<MissionItemInt>, now: MonoTime) -> Self {
        for item in &mut items {
            item.target = config.vehicle;
        }
        let route = if items.is_empty() { PlanRoute::items(config) } else { PlanRoute::first(config) };
        let mut upload = Self {
            config: config.clone(),
            kind,
            items,
            route,
            session: None,
            resent: 0,
            plan_id: None,
            others: OthersUntil::default(),
            step: Step::Over,
            result: None,
            out: Outbox::new(),
        };
        match upload.check() {
            Ok(()) => upload.send(route, now),
            Err(error) => upload.result = Some(Err(error)),
        }
        upload
    }

    /// Whether the list may be sent: numbered, of one kind, and every number in it finite and in range.
    fn check(&self) -> Result<(), TransferError> {
        let limit = u64::from(u16::MAX);
        if self.items.len() as u64 > limit {
            return Err(TransferError::TooMany { what: "items of a plan", count: self.items.len() as u64, limit });
        }
        for (index, item) in self.items.iter().enumerate() {
            if usize::from(item.seq) != index || item.mission_type != self.kind.mission_type() {
                return Err(TransferError::BadList { index, seq: item.seq, mission_type: item.mission_type });
            }
            MissionItem::from_wire(item)?.check_sendable(vencejo_proto::MissionSeq(item.seq))?;
        }
        Ok(())
    }

    /// Another station does something to the same plan.
    pub(crate) fn on_others(&mut self, others: Others, now: MonoTime) {
        self.others.note(others, now);
        if let Step::ReadBack(read, _) = &mut self.step {
            read.on_others(others, now);
            self.advance(now);
        }
    }

    /// Whether the vehicle has all of it, and it is being read back.
    pub(crate) fn is_sent(&self) -> bool {
        matches!(&self.step, Step::ReadBack(read, None) if read.is_closed())
    }

    /// Number of its items.
    pub(crate) fn count(&self) -> usize {
        self.items.len()
    }

    /// The vehicle's id of the list since it has it, where it gives one.
    pub(crate) fn plan_id(&self) -> Option<u32> {
        self.plan_id
    }

    fn send(&mut self, route: PlanRoute, now: MonoTime) {
        self.route = route;
        self.step = match route {
            PlanRoute::Items | PlanRoute::FloatItems => {
                let form = route.form(&self.config);
                Step::SendItems(ItemUpload::new(&self.config, self.kind, self.items.clone(), form, now))
            }
            PlanRoute::Ftp => {
                // Whole items in each write: a lost one leaves an item of zeros, and ArduPilot refuses the file.
                let file = encode_plan_file(self.kind.mission_type(), &self.items);
                let write = FileWrite::new(&self.config, path(self.kind), file, PLAN_FILE_ITEM_LEN, 10, now);
                Step::SendFile(Box::new(write))
            }
        };
        self.advance(now);
    }

    fn end(&mut self, result: Result<VerifiedPlan, TransferError>) {
        self.step = Step::Over;
        self.result = Some(result);
    }

    fn advance(&mut self, now: MonoTime) {
        let total = 2 * self.items.len() as u32;
        let mut put = |output, before: u32, per_item: u32| {
            self.out.push_back(match output {
                TransferOutput::Progress { done, .. } => {
                    TransferOutput::Progress { done: (before + done / per_item).min(total), total }
                }
                send => send,
            });
        };
        match &mut self.step {
            Step::SendItems(send) => {
                while let Some(output) = send.poll_output() {
                    put(output, 0, 1);
                }
                match send.result() {
                    None => {}
                    Some(Ok(ItemsSent { acknowledged: true, plan_id })) => {
                        self.plan_id = plan_id;
                        self.read_back(None, now);
                    }
                    Some(Ok(ItemsSent { acknowledged: false, .. })) => {
                        tracing::debug!(kind = %self.kind, "no final MISSION_ACK; the read-back decides");
                        let Step::SendItems(send) = std::mem::replace(&mut self.step, Step::Over) else { return };
                        self.read_back(None, now);
                        if let Step::ReadBack(_, unfinished) = &mut self.step {
                            *unfinished = Some(send);
                        }
                    }
                    Some(Err(error)) => self.fail_or_reroute(error, now),
                }
            }
            Step::SendFile(send) => {
                while let Some(output) = send.poll_output() {
                    put(output, 0, PLAN_FILE_ITEM_LEN as u32);
                }
                match send.result() {
                    None => {}
                    Some(Ok(session)) => self.read_back(Some(session), now),
                    Some(Err(error)) => self.fail_or_reroute(error, now),
                }
            }
            Step::ReadBack(read, unfinished) => {
                let (was_acknowledged, is_beside_others) = (unfinished.is_none(), read.is_beside_others());
                while let Some(output) = read.poll_output() {
                    put(output, total / 2, 1);
                }
                match read.result() {
                    None => {}
                    Some(Ok(plan)) => match compare(&self.config, self.kind, &self.items, &plan) {
                        Ok(position_error_m) => {
                            let (kind, route) = (self.kind, self.route);
                            self.end(Ok(VerifiedPlan { kind, items: plan.items, route, position_error_m }));
                        }
                        // Another station wrote it after us: sending it again would start a contest.
                        Err(error) if is_beside_others => self.end(Err(error)),
                        // It never acknowledged the whole list: once more.
                        Err(TransferError::NotAsSent { .. }) if !was_acknowledged && self.resent < RESTARTS => {
                            self.resent += 1;
                            self.send(self.route, now);
                        }
                        Err(error) => self.fail_or_reroute(error, now),
                    },
                    Some(Err(TransferError::Cancelled)) => self.end(Err(TransferError::Cancelled)),
                    Some(Err(reason)) => {
                        let kind = self.kind;
                        self.end(Err(TransferError::Unverified { kind, reason: Box::new(reason) }));
                    }
                }
            }
            Step::Over => {}
        }
    }

    fn read_back(&mut self, closing: Option<u8>, now: MonoTime) {
        self.session = closing;
        let read = ReadBack::new(self.route, &self.config, self.kind, closing, self.others, now);
        self.step = Step::ReadBack(Box::new(read), None);
        self.advance(now);
    }

    fn fail_or_reroute(&mut self, error: TransferError, now: MonoTime) {
        match self.route.after(&error, &self.config, self.kind) {
            Some(next) => {
                tracing::debug!(kind = %self.kind, %error, ?next, "sending by another route");
                // If the upload's session were still open, the next user of MAVFTP would make its file the plan.
                if let Some(session) = self.session.take() {
                    self.out.extend(abandon(&self.config, session).map(TransferOutput::Send));
                }
                self.send(next, now);
            }
            None => self.end(Err(error)),
        }
    }
}

impl Transfer for PlanUpload {
    type Value = VerifiedPlan;

    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        match &mut self.step {
            Step::SendFile(step) => step.on_message(from, message, now),
            Step::SendItems(step) => step.on_message(from, message, now),
            Step::ReadBack(_, unfinished)
                if unfinished.as_ref().is_some_and(|send| send.is_asked_by(from, message)) =>
            {
                if let Some(mut send) = unfinished.take() {
                    send.resume(now);
                    send.on_message(from, message, now);
                    self.step = Step::SendItems(send);
                }
            }
            Step::ReadBack(step, _) => step.on_message(from, message, now),
            Step::Over => {}
        }
        self.advance(now);
    }

    fn on_time(&mut self, now: MonoTime) {
        match &mut self.step {
            Step::SendFile(step) => step.on_time(now),
            Step::SendItems(step) => step.on_time(now),
            Step::ReadBack(step, _) => step.on_time(now),
            Step::Over => {}
        }
        self.advance(now);
    }

    fn deadline(&self) -> Option<MonoTime> {
        match &self.step {
            Step::SendFile(step) => step.deadline(),
            Step::SendItems(step) => step.deadline(),
            Step::ReadBack(step, _) => step.deadline(),
            Step::Over => None,
        }
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<VerifiedPlan, TransferError>> {
        self.result.take()
    }

    fn cancel(&mut self, now: MonoTime) {
        match &mut self.step {
            Step::SendFile(step) => step.cancel(now),
            Step::SendItems(step) => step.cancel(now),
            Step::ReadBack(step, _) => step.cancel(now),
            Step::Over => {}
        }
        self.advance(now);
    }
}

/// Whether the list read back is the list sent, as the vehicle stores it; how far positions are off where they were
/// rounded.
fn compare(
    config: &TransferConfig,
    kind: PlanKind,
    sent: &[MissionItemInt],
    read_back: &DownloadedPlan,
) -> Result<Option<f64>, TransferError> {
    let parse = |items: &[MissionItemInt]| items.iter().map(MissionItem::from_wire).collect::<Result<Vec<_>, _>>();
    let unreadable = |error| TransferError::Unverified { kind, reason: Box::new(TransferError::Item(error)) };
    let (sent, kept) = (parse(sent)?, parse(&read_back.items).map_err(unreadable)?);
    let is_rounded = read_back.route == PlanRoute::FloatItems;
    let keeping = Keeping { is_ardupilot: config.is_ardupilot, in_floats: is_rounded };
    plans_equal_as_stored(&sent, &kept, kind, keeping)
        .map_err(|differences| TransferError::NotAsSent { kind, differences })?;
    let first = usize::from(config.is_ardupilot && kind == PlanKind::Mission);
    Ok(is_rounded.then(|| largest_error_m(&sent, &kept, first)))
}

/// Whether the mission that was read is the list that was sent, as the vehicle stores it.
pub(crate) fn is_as_sent(config: &TransferConfig, sent: &[MissionItemInt], read: &[MissionItemInt]) -> bool {
    let (kind, items) = (PlanKind::Mission, read.to_vec());
    compare(config, kind, sent, &DownloadedPlan { kind, items, route: PlanRoute::items(config) }).is_ok()
}

/// Removes a plan and checks that it is gone. See [`PlanRoute`].
#[derive(Debug)]
pub struct PlanClear {
    config: TransferConfig,
    kind: PlanKind,
    step: Clear,
    began: MonoTime,
    round_trip: RoundTrip,
    others: OthersUntil,
    out: Outbox,
}

#[derive(Debug)]
enum Clear {
    Asking { retry_at: MonoTime },
    Checking(Box<ReadBack>),
    Over(Option<Result<(), TransferError>>),
}

impl PlanClear {
    /// Begins to clear.
    pub fn new(config: &TransferConfig, kind: PlanKind, now: MonoTime) -> Self {
        let mut clear = Self {
            config: config.clone(),
            kind,
            step: Clear::Over(None),
            began: now,
            round_trip: RoundTrip::new(config.round_trip, MESSAGE_TIMEOUT),
            others: OthersUntil::default(),
            out: Outbox::new(),
        };
        match config.refuses_items(kind) {
            Some(error) => clear.step = Clear::Over(Some(Err(error))),
            None => clear.ask(now),
        }
        clear
    }

    /// Another station does something to the same plan.
    pub(crate) fn on_others(&mut self, others: Others, now: MonoTime) {
        self.others.note(others, now);
        if let Clear::Checking(check) = &mut self.step {
            check.on_others(others, now);
            self.advance();
        }
    }

    /// Whether the vehicle has acknowledged the removal, and it is being checked.
    pub(crate) fn is_cleared(&self) -> bool {
        matches!(self.step, Clear::Checking(_))
    }

    fn ask(&mut self, now: MonoTime) {
        self.out.push_back(TransferOutput::Send(Message::Dialect(MavMessage::MISSION_CLEAR_ALL(
            MISSION_CLEAR_ALL_DATA {
                target_system: self.config.vehicle.system.0,
                target_component: self.config.vehicle.component.0,
                mission_type: mav_mission_type(self.kind),
            },
        ))));
        self.step = Clear::Asking { retry_at: now + self.round_trip.timeout() };
    }

    fn advance(&mut self) {
        let Clear::Checking(check) = &mut self.step else { return };
        while let Some(output) = check.poll_output() {
            if matches!(output, TransferOutput::Send(_)) {
                self.out.push_back(output);
            }
        }
        let Some(result) = check.result() else { return };
        let kind = self.kind;
        // ArduPilot keeps home as item 0 of a mission.
        let home = u16::from(self.config.is_ardupilot && kind == PlanKind::Mission);
        self.step = Clear::Over(Some(match result {
            Ok(plan) => match (plan.items.len() as u16).saturating_sub(home) {
                0 => Ok(()),
                count => Err(TransferError::NotCleared { kind, count }),
            },
            Err(TransferError::Cancelled) => Err(TransferError::Cancelled),
            Err(reason) => Err(TransferError::Unverified { kind, reason: Box::new(reason) }),
        }));
    }
}

impl Transfer for PlanClear {
    type Value = ();

    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        match (&mut self.step, message) {
            (Clear::Asking { retry_at }, Message::MissionAck(ack))
                if self.config.concerns_us(from, message) && ack.mission_type == self.kind.mission_type() =>
            {
                match MissionResult(ack.result) {
                    MissionResult::ACCEPTED => {
                        let route = PlanRoute::items(&self.config);
                        let check = ReadBack::new(route, &self.config, self.kind, None, self.others, now);
                        self.step = Clear::Checking(Box::new(check));
                    }
                    // Left over from a previous upload.
                    MissionResult::INVALID_SEQUENCE | MissionResult::OPERATION_CANCELLED => {}
                    MissionResult::DENIED if now.since(self.began) < SILENCE_LIMIT => *retry_at = now + DENIED_WAIT,
                    result => {
                        self.step =
                            Clear::Over(Some(Err(TransferError::Refused { kind: self.kind, result, item: None })));
                    }
                }
            }
            (Clear::Checking(check), _) => check.on_message(from, message, now),
            _ => {}
        }
        self.advance();
    }

    fn on_time(&mut self, now: MonoTime) {
        match &mut self.step {
            Clear::Asking { retry_at } if now >= *retry_at => {
                let waited = now.since(self.began);
                if waited >= self.round_trip.limit(SILENCE_LIMIT) {
                    self.step = Clear::Over(Some(Err(TransferError::Timeout { step: "MISSION_CLEAR_ALL", waited })));
                } else {
                    self.round_trip.timed_out();
                    self.ask(now);
                }
            }
            Clear::Checking(check) => check.on_time(now),
            _ => {}
        }
        self.advance();
    }

    fn deadline(&self) -> Option<MonoTime> {
        match &self.step {
            Clear::Asking { retry_at } => Some(*retry_at),
            Clear::Checking(check) => check.deadline(),
            Clear::Over(_) => None,
        }
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<(), TransferError>> {
        if let Clear::Over(result) = &mut self.step { result.take() } else { None }
    }

    fn cancel(&mut self, now: MonoTime) {
        match &mut self.step {
            Clear::Asking { .. } => self.step = Clear::Over(Some(Err(TransferError::Cancelled))),
            Clear::Checking(check) => check.cancel(now),
            Clear::Over(_) => {}
        }
        self.advance();
    }
}
