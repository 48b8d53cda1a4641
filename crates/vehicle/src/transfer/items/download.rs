//! Reading a plan item by item.

use std::collections::VecDeque;
use std::time::Duration;

use vencejo_flight::plan::{MAX_ITEMS, PlanKind};
use vencejo_proto::dialect::{MISSION_REQUEST_DATA, MISSION_REQUEST_INT_DATA, MISSION_REQUEST_LIST_DATA, MavMessage};
use vencejo_proto::{Address, Message, MissionItemInt, MonoTime};

use super::{LateErrors, Outbox, ack, mav_mission_type};
use crate::transfer::float::from_float;
use crate::transfer::timing::{
    DENIED_WAIT, FORGOTTEN_AFTER, INTEGERS_IGNORED_AFTER, MESSAGE_TIMEOUT, PROGRESS_LIMIT, RESTARTS, RoundTrip,
    SILENCE_LIMIT,
};
use crate::transfer::{ItemForm, MissionResult, Transfer, TransferConfig, TransferError, TransferOutput};

/// Most items requested at once from an ArduPilot.
const MAX_REQUESTS: usize = 32;
/// Items requested at once at first.
const FIRST_REQUESTS: usize = 4;
/// An item counts as lost when this many requested after it have come.
const OVERTAKEN: u32 = 3;

/// Reads a list, item by item.
#[derive(Debug)]
pub(crate) struct ItemDownload {
    config: TransferConfig,
    kind: PlanKind,
    form: ItemForm,
    state: Download,
    heard: MonoTime,
    /// When the present attempt began.
    began: MonoTime,
    /// When it last progressed.
    progressed: MonoTime,
    /// [`MissionResult::ERROR`]s that may have been about an upload before.
    errors: LateErrors,
    restarts: u32,
    round_trip: RoundTrip,
    out: Outbox,
}

#[derive(Debug)]
enum Download {
    Listing { sent: MonoTime, tries: u32, retry_at: MonoTime },
    Reading(Reading),
    Over(Option<Result<Vec<MissionItemInt>, TransferError>>),
}

#[derive(Debug)]
struct Reading {
    items: Vec<Option<MissionItemInt>>,
    have: usize,
    /// Items before this one were requested.
    next: usize,
    /// Requested and not received yet, in the order of the requests.
    asked: VecDeque<Asked>,
    /// Most items requested at once.
    window: usize,
    /// When the first was requested, and how often items were late since.
    began: MonoTime,
    late: u32,
}

#[derive(Debug, Clone, Copy)]
struct Asked {
    seq: u16,
    at: MonoTime,
    again: bool,
    overtaken: u32,
}

impl ItemDownload {
    pub(crate) fn new(config: &TransferConfig, kind: PlanKind, form: ItemForm, now: MonoTime) -> Self {
        let mut download = Self {
            config: config.clone(),
            kind,
            form,
            state: Download::Over(None),
            heard: now,
            began: now,
            progressed: now,
            errors: LateErrors::default(),
            restarts: 0,
            round_trip: RoundTrip::new(config.round_trip, MESSAGE_TIMEOUT),
            out: Outbox::new(),
        };
        match config.refuses_items(kind) {
            Some(error) => download.end(Err(error)),
            None => download.send_list(1, now),
        }
        download
    }

    fn send_list(&mut self, tries: u32, now: MonoTime) {
        self.errors.on_question();
        self.out.push_back(TransferOutput::Send(Message::Dialect(MavMessage::MISSION_REQUEST_LIST(
            MISSION_REQUEST_LIST_DATA {
                target_system: self.config.vehicle.system.0,
                target_component: self.config.vehicle.component.0,
                mission_type: mav_mission_type(self.kind),
            },
        ))));
        self.state = Download::Listing { sent: now, tries, retry_at: now + self.round_trip.timeout() };
    }

    fn end(&mut self, result: Result<Vec<MissionItemInt>, TransferError>) {
        self.state = Download::Over(Some(result));
    }

    fn restart(&mut self, error: TransferError, now: MonoTime) {
        self.restarts += 1;
        self.began = now;
        if self.restarts > RESTARTS {
            self.end(Err(error));
        } else {
            self.send_list(1, now);
        }
    }

    fn on_count(&mut self, count: u16, now: MonoTime) {
        self.heard = now;
        match &self.state {
            Download::Listing { sent, tries, .. } => {
                if *tries == 1 {
                    self.round_trip.sample(now.since(*sent));
                }
            }
            // The plan changed while it was read.
            Download::Reading(reading) if reading.items.len() != usize::from(count) => {
                self.restarts += 1;
                if self.restarts > RESTARTS {
                    let attempts = self.restarts;
                    return self
                        .end(Err(TransferError::NoProgress { step: "reading a plan that keeps changing", attempts }));
                }
            }
            _ => return,
        }
        if usize::from(count) > MAX_ITEMS {
            return self.end(Err(TransferError::TooMany {
                what: "items of a plan",
                count: u64::from(count),
                limit: MAX_ITEMS as u64,
            }));
        }
        let window = if self.may_ask_ahead() { FIRST_REQUESTS } else { 1 };
        let items = vec![None; usize::from(count)];
        let asked = VecDeque::new();
        self.state = Download::Reading(Reading { items, have: 0, next: 0, asked, window, began: now, late: 0 });
        self.ask(now);
    }

    /// An APM 2 has room for a few requests (128 bytes) and answers no faster for more of them.
    fn may_ask_ahead(&self) -> bool {
        self.config.is_ardupilot && self.form != ItemForm::Float
    }

    /// Requests as many items as the window allows, or ends when all are there.
    fn ask(&mut self, now: MonoTime) {
        let Download::Reading(reading) = &mut self.state else { return };
        let (have, total) = (reading.have, reading.items.len());
        if have == total {
            let items = std::mem::take(&mut reading.items).into_iter().flatten().collect();
            self.out.push_back(TransferOutput::Send(ack(&self.config, self.kind, MissionResult::ACCEPTED)));
            return self.end(Ok(items));
        }
        while reading.asked.len() < reading.window && reading.next < total {
            let asked = Asked { seq: reading.next as u16, at: now, again: false, overtaken: 0 };
            reading.next += 1;
            if reading.items[usize::from(asked.seq)].is_none() {
                self.errors.on_question();
                reading.asked.push_back(asked);
                self.out.push_back(TransferOutput::Send(request(&self.config, self.kind, self.form, asked.seq)));
            }
        }
    }

    /// How long to wait for an item. A PX4 ends a transfer in which nothing was asked for 5 s: three requests are to
    /// come in that time, so that two may be lost.
    fn item_timeout(&self) -> Duration {
        let timeout = self.round_trip.timeout();
        if self.config.is_ardupilot {
            timeout
        } else {
            timeout.min(self.round_trip.first_timeout().max(MESSAGE_TIMEOUT))
        }
    }

    /// Requests late and overtaken items again.
    fn ask_again(&mut self, now: MonoTime) {
        let timeout = self.item_timeout();
        let Download::Reading(reading) = &mut self.state else { return };
        let mut late = false;
        let mut again = Vec::new();
        reading.asked.retain(|asked| {
            let is_late = now >= asked.at + timeout;
            let is_lost = is_late || asked.overtaken >= OVERTAKEN;
            late |= is_late;
            if is_lost {
                again.push(asked.seq);
            }
            !is_lost
        });
        for seq in again {
            self.errors.on_question();
            reading.asked.push_back(Asked { seq, at: now, again: true, overtaken: 0 });
            self.out.push_back(TransferOutput::Send(request(&self.config, self.kind, self.form, seq)));
        }
        if late {
            reading.window = (reading.window / 2).max(1);
            reading.late += 1;
            self.round_trip.timed_out();
        }
    }

    fn on_item(&mut self, item: &MissionItemInt, now: MonoTime) {
        let Download::Reading(reading) = &mut self.state else { return };
        let Some(slot) = reading.items.get_mut(usize::from(item.seq)) else { return };
        self.heard = now;
        if slot.is_some() {
            return;
        }
        *slot = Some(*item);
        self.progressed = now;
        reading.have += 1;
        if let Some(place) = reading.asked.iter().position(|asked| asked.seq == item.seq) {
            let answered = reading.asked.remove(place).expect("invariant: the place was just found");
            // What was asked for twice may answer either question: it tells neither a round trip nor that others were
            // overtaken.
            if !answered.again {
                self.round_trip.sample(now.since(answered.at));
                for earlier in reading.asked.iter_mut().take(place) {
                    earlier.overtaken += 1;
                }
            }
        }
        if self.config.is_ardupilot && self.form != ItemForm::Float {
            reading.window = (reading.window + 1).min(MAX_REQUESTS);
        }
        let (done, total) = (reading.have as u32, reading.items.len() as u32);
        self.out.push_back(TransferOutput::Progress { done, total });
        self.ask_again(now);
        self.ask(now);
    }

    fn on_ack(&mut self, result: MissionResult, now: MonoTime) {
        let kind = self.kind;
        let refused = TransferError::Refused { kind, result, item: None };
        match (&mut self.state, result) {
            (Download::Over(_), _) | (_, MissionResult::ACCEPTED) => {}
            (_, MissionResult::ERROR) if self.config.is_ardupilot && self.errors.may_be_late() => {}
            // Another station is uploading, or a PX4 waits for the end of another transfer, for 5 s at most.
            (Download::Listing { retry_at, .. }, MissionResult::DENIED | MissionResult::OPERATION_CANCELLED)
            | (Download::Listing { retry_at, .. }, MissionResult::ERROR)
                if result != MissionResult::ERROR || !self.config.is_ardupilot =>
            {
                self.heard = now;
                if now.since(self.began) >= SILENCE_LIMIT {
                    self.end(Err(refused));
                } else {
                    *retry_at = now + DENIED_WAIT;
                }
            }
            // Left over from a previous upload.
            (Download::Listing { .. }, MissionResult::INVALID_SEQUENCE) => {}
            (Download::Listing { .. }, _) => self.end(Err(refused)),
            // The plan became shorter, or another station began an upload: from the beginning.
            (Download::Reading(_), _) => {
                self.heard = now;
                self.restart(refused, now);
            }
        }
    }
}

#[allow(deprecated, reason = "vehicles from before MISSION_REQUEST_INT know only MISSION_REQUEST")]
fn request(config: &TransferConfig, kind: PlanKind, form: ItemForm, seq: u16) -> Message {
    let (target_system, target_component) = (config.vehicle.system.0, config.vehicle.component.0);
    let mission_type = mav_mission_type(kind);
    Message::Dialect(match form {
        ItemForm::Integer | ItemForm::Unknown => MavMessage::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
            seq,
            target_system,
            target_component,
            mission_type,
        }),
        ItemForm::Float => {
            MavMessage::MISSION_REQUEST(MISSION_REQUEST_DATA { seq, target_system, target_component, mission_type })
        }
    })
}

impl Transfer for ItemDownload {
    type Value = Vec<MissionItemInt>;

    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        if !self.config.concerns_us(from, message) {
            return;
        }
        let kind = self.kind.mission_type();
        match message {
            Message::Dialect(MavMessage::MISSION_COUNT(count)) if count.mission_type as u8 == kind => {
                self.on_count(count.count, now);
            }
            Message::MissionItemInt(item) if item.mission_type == kind => self.on_item(item, now),
            Message::MissionItemFloat(item) if item.mission_type == kind && self.form == ItemForm::Float => {
                self.on_item(&from_float(item), now);
            }
            Message::MissionAck(ack) if ack.mission_type == kind => self.on_ack(MissionResult(ack.result), now),
            _ => {}
        }
    }

    fn on_time(&mut self, now: MonoTime) {
        if self.deadline().is_none_or(|at| now < at) {
            return;
        }
        let (waited, silence) = (now.since(self.heard), self.round_trip.limit(SILENCE_LIMIT));
        if now >= self.progressed + PROGRESS_LIMIT {
            let attempts = self.restarts + 1;
            return self.end(Err(TransferError::NoProgress { step: "reading a plan item by item", attempts }));
        }
        match self.state {
            Download::Listing { .. } if waited >= silence => {
                self.end(Err(TransferError::Timeout { step: "MISSION_REQUEST_LIST", waited }));
            }
            Download::Reading(_) if waited >= silence => {
                self.end(Err(TransferError::Timeout { step: "MISSION_REQUEST_INT", waited }));
            }
            Download::Listing { tries, .. } => {
                self.round_trip.timed_out();
                self.send_list(tries + 1, now);
            }
            Download::Reading(ref reading)
                if self.form == ItemForm::Unknown
                    && reading.have == 0
                    // They are late for the second time.
                    && reading.late >= 1
                    && now >= reading.began + INTEGERS_IGNORED_AFTER =>
            {
                self.end(Err(TransferError::IntegerItemsIgnored));
            }
            // It answers nothing more: from the beginning.
            Download::Reading(_) if !self.config.is_ardupilot && waited >= FORGOTTEN_AFTER => {
                self.restart(TransferError::Timeout { step: "MISSION_REQUEST_INT", waited }, now);
            }
            Download::Reading(_) => self.ask_again(now),
            Download::Over(_) => {}
        }
    }

    fn deadline(&self) -> Option<MonoTime> {
        let limit = self.progressed + PROGRESS_LIMIT;
        match &self.state {
            Download::Listing { retry_at, .. } => Some((*retry_at).min(limit)),
            Download::Reading(reading) => {
                let timeout = self.item_timeout();
                let late = reading.asked.iter().map(|asked| asked.at + timeout).min();
                let gone = (self.heard + self.round_trip.limit(SILENCE_LIMIT)).min(limit);
                Some(late.map_or(gone, |late| late.min(gone)))
            }
            Download::Over(_) => None,
        }
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<Vec<MissionItemInt>, TransferError>> {
        if let Download::Over(result) = &mut self.state { result.take() } else { None }
    }

    fn cancel(&mut self, _now: MonoTime) {
        if !matches!(self.state, Download::Over(_)) {
            self.out.clear();
            self.out.push_back(TransferOutput::Send(ack(&self.config, self.kind, MissionResult::OPERATION_CANCELLED)));
            self.end(Err(TransferError::Cancelled));
        }
    }
}
