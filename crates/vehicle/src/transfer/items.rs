//! The item protocol: a plan to or from the vehicle, one message for each item
//! (<https://mavlink.io/en/services/mission.html>).
//!
//! What the vehicle holds after an upload is not checked here; [`super::plan`] reads it back.

use std::collections::VecDeque;

use vencejo_flight::plan::{MAX_ITEMS, PlanKind};
use vencejo_proto::dialect::{
    MISSION_COUNT_DATA, MISSION_REQUEST_DATA, MISSION_REQUEST_INT_DATA, MISSION_REQUEST_LIST_DATA, MavMessage,
    MavMissionType,
};
use vencejo_proto::{Address, Message, MissionAck, MissionItemInt, MissionSeq, MonoTime};

use super::float::{from_float, to_float};
use super::timing::{
    DENIED_WAIT, DUPLICATE_WINDOW, INTEGERS_IGNORED, INTEGERS_IGNORED_AFTER, ITEM_TIMEOUT, MESSAGE_TIMEOUT,
    PROGRESS_LIMIT, REQUEST_REPEAT, RESTARTS, RoundTrip, SILENCE_LIMIT, STALL_LIMIT,
};
use super::{ItemForm, MissionResult, Transfer, TransferConfig, TransferError, TransferOutput};

/// Most items asked for at once from an ArduPilot.
const MAX_REQUESTS: usize = 32;
/// Items asked for at once to begin with.
const FIRST_REQUESTS: usize = 4;
/// An item counts as lost when this many asked for after it have come.
const OVERTAKEN: u32 = 3;

/// A vehicle that goes back to an earlier item more often gets nowhere.
const INSISTENCE: u32 = 20;

/// ArduPilot answers an item that comes when it expects none with [`MissionResult::ERROR`]
/// (`GCS_MAVLINK::handle_mission_item`), so late copies of the last item bring some of them after an upload. This many
/// of our questions may be answered so.
const LATE_ERRORS: u32 = 3;

/// [`MissionResult::ERROR`]s that may be about an upload before. Late copies come in any number, but together: of those
/// between two questions of ours one counts. A vehicle that means it says it to each.
#[derive(Debug, Default)]
struct LateErrors {
    questions: u32,
    is_counted: bool,
}

impl LateErrors {
    /// A question goes out.
    fn on_question(&mut self) {
        self.is_counted = false;
    }

    /// Whether the error that came may be late.
    fn may_be_late(&mut self) -> bool {
        self.questions += u32::from(!std::mem::replace(&mut self.is_counted, true));
        self.questions <= LATE_ERRORS
    }
}

/// What a machine puts out. Bounded by its owner, who drains it after every call: a call adds at most a window of
/// items.
pub(crate) type Outbox = VecDeque<TransferOutput>;

pub(crate) fn mav_mission_type(kind: PlanKind) -> MavMissionType {
    match kind {
        PlanKind::Mission => MavMissionType::MAV_MISSION_TYPE_MISSION,
        PlanKind::Fence => MavMissionType::MAV_MISSION_TYPE_FENCE,
        PlanKind::Rally => MavMissionType::MAV_MISSION_TYPE_RALLY,
    }
}

/// Our MISSION_ACK to the vehicle.
pub(crate) fn ack(config: &TransferConfig, kind: PlanKind, result: MissionResult) -> Message {
    Message::MissionAck(MissionAck {
        target: config.vehicle,
        result: result.0,
        mission_type: kind.mission_type(),
        opaque_id: 0,
    })
}

/// How an item upload ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ItemsSent {
    /// Whether the vehicle's final MISSION_ACK came. Without it, every item was sent and the vehicle asks for none
    /// again.
    pub acknowledged: bool,
    /// What the vehicle calls the list since then, where it says so (MISSION_ACK.opaque_id).
    pub plan_id: Option<u32>,
}

/// Sends a list, item by item.
#[derive(Debug)]
pub(crate) struct ItemUpload {
    config: TransferConfig,
    kind: PlanKind,
    items: Vec<MissionItemInt>,
    form: ItemForm,
    state: Upload,
    /// When something about this transfer came last, or when it began.
    heard: MonoTime,
    began: MonoTime,
    /// When it last got further, and the item it got to.
    progressed: MonoTime,
    furthest: u16,
    /// How often the vehicle went back to an earlier item.
    insisted: u32,
    /// How often it asked for the first item by MISSION_REQUEST, which may mean that it did not understand the answer.
    asked_first: u32,
    /// [`MissionResult::ERROR`]s that may have been about items before.
    errors: LateErrors,
    restarts: u32,
    round_trip: RoundTrip,
    out: Outbox,
}

#[derive(Debug)]
enum Upload {
    /// MISSION_COUNT was sent.
    Counting {
        sent: MonoTime,
        tries: u32,
        retry_at: MonoTime,
    },
    /// The vehicle asks for items.
    Sending {
        /// The item it asked for last.
        asked: u16,
        /// When we answered that request.
        answered: MonoTime,
        /// Items before this one were sent.
        sent: u16,
        /// Items sent ahead of its requests, plus the one it asks for.
        window: u16,
        /// It complained about an item out of order: it has not got all, and asks again.
        complained: bool,
    },
    Over(Option<Result<ItemsSent, TransferError>>),
}

impl ItemUpload {
    /// `items` are numbered from 0, of one kind, at most 65,535.
    pub(crate) fn new(
        config: &TransferConfig,
        kind: PlanKind,
        items: Vec<MissionItemInt>,
        form: ItemForm,
        now: MonoTime,
    ) -> Self {
        let mut upload = Self {
            config: config.clone(),
            kind,
            items,
            form,
            state: Upload::Over(None),
            heard: now,
            began: now,
            progressed: now,
            furthest: 0,
            insisted: 0,
            asked_first: 0,
            errors: LateErrors::default(),
            restarts: 0,
            round_trip: RoundTrip::new(config.round_trip, MESSAGE_TIMEOUT),
            out: Outbox::new(),
        };
        match config.refuses_items(kind) {
            Some(error) => upload.end(Err(error)),
            None => upload.send_count(1, now),
        }
        upload
    }

    fn count(&self) -> u16 {
        self.items.len() as u16
    }

    fn asked(&self) -> u16 {
        if let Upload::Sending { asked, .. } = self.state { asked } else { 0 }
    }

    fn send_count(&mut self, tries: u32, now: MonoTime) {
        self.errors.on_question();
        self.out.push_back(TransferOutput::Send(Message::Dialect(MavMessage::MISSION_COUNT(MISSION_COUNT_DATA {
            count: self.count(),
            target_system: self.config.vehicle.system.0,
            target_component: self.config.vehicle.component.0,
            mission_type: mav_mission_type(self.kind),
            ..Default::default()
        }))));
        self.state = Upload::Counting { sent: now, tries, retry_at: now + self.round_trip.timeout() };
    }

    fn end(&mut self, result: Result<ItemsSent, TransferError>) {
        self.state = Upload::Over(Some(result));
    }

    fn restart(&mut self, now: MonoTime) {
        self.restarts += 1;
        self.furthest = 0;
        if self.restarts > RESTARTS {
            self.end(Err(TransferError::NoProgress { step: "sending a plan item by item", attempts: self.restarts }));
        } else {
            self.send_count(1, now);
        }
    }

    fn send_items(&mut self, from: u16, to: u16) {
        for item in &self.items[usize::from(from)..usize::from(to)] {
            self.out.push_back(TransferOutput::Send(match self.form {
                ItemForm::Integer | ItemForm::Unknown => Message::MissionItemInt(*item),
                ItemForm::Float => Message::MissionItemFloat(to_float(item)),
            }));
        }
        self.out.push_back(TransferOutput::Progress { done: u32::from(from), total: u32::from(self.count()) });
    }

    /// The vehicle asks for an item; `by_int` when by MISSION_REQUEST_INT, which is a promise to understand the answer.
    fn on_request(&mut self, seq: u16, by_int: bool, now: MonoTime) {
        let count = self.count();
        if seq >= count {
            return;
        }
        if by_int && self.form == ItemForm::Unknown {
            self.form = ItemForm::Integer;
        }
        let step = match self.state {
            // Any other number is a request of an upload before this one.
            Upload::Counting { sent, tries, .. } if seq == 0 => {
                if tries == 1 {
                    self.round_trip.sample(now.since(sent));
                }
                let may_run_ahead = self.config.is_ardupilot && self.form == ItemForm::Integer;
                Some((0, if may_run_ahead { self.config.item_window.clamp(1, 64) } else { 1 }))
            }
            // It asks for the next item only when it has the one before.
            Upload::Sending { asked, answered, sent, window, .. } => {
                if seq == asked {
                    // Asked again: the item was lost. Go back to it, and no longer send ahead.
                    (now.since(answered) >= DUPLICATE_WINDOW).then_some((seq, 1))
                } else if seq > asked && seq <= sent {
                    Some((sent, window))
                } else {
                    // A lower number is late, unless the vehicle insists.
                    (seq < asked && now.since(answered) >= REQUEST_REPEAT / 2).then_some((seq, 1))
                }
            }
            _ => None,
        };
        self.heard = now;
        if let Some((from, window)) = step {
            if self.form == ItemForm::Unknown {
                // Whoever goes on to the next item has understood this one.
                self.form = if seq > 0 { ItemForm::Integer } else { self.form };
                self.asked_first += 1;
                if self.form == ItemForm::Unknown && self.asked_first >= INTEGERS_IGNORED {
                    return self.end(Err(TransferError::IntegerItemsIgnored));
                }
            }
            if seq < self.asked() {
                self.insisted += 1;
                self.furthest = seq;
            }
            if seq > self.furthest && self.insisted <= INSISTENCE {
                (self.furthest, self.progressed) = (seq, now);
            }
            let to = count.min(seq.saturating_add(window)).max(from);
            self.send_items(from, to);
            self.state = Upload::Sending { asked: seq, answered: now, sent: to, window, complained: false };
        }
    }

    /// Goes on with an upload that ended without the final MISSION_ACK: the vehicle asks for an item after all.
    pub(crate) fn resume(&mut self, now: MonoTime) {
        let count = self.count();
        // The request that follows is to be answered at once.
        let answered = MonoTime::ZERO;
        self.state =
            Upload::Sending { asked: count.saturating_sub(1), answered, sent: count, window: 1, complained: false };
        self.heard = now;
        self.progressed = now;
    }

    /// Whether a message asks for an item of this list.
    #[allow(deprecated, reason = "ArduPilot asks with MISSION_REQUEST, also for MISSION_ITEM_INT")]
    pub(crate) fn is_asked_by(&self, from: Address, message: &Message) -> bool {
        let kind = mav_mission_type(self.kind);
        self.config.concerns_us(from, message)
            && match message {
                Message::Dialect(MavMessage::MISSION_REQUEST_INT(request)) => request.mission_type == kind,
                Message::Dialect(MavMessage::MISSION_REQUEST(request)) => request.mission_type == kind,
                _ => false,
            }
    }

    fn on_ack(&mut self, result: MissionResult, plan_id: Option<u32>, now: MonoTime) {
        let (counting, all_sent, last) = match self.state {
            Upload::Counting { .. } => (true, self.items.is_empty(), None),
            Upload::Sending { asked, sent, .. } => (false, sent == self.count(), Some(MissionSeq(asked))),
            Upload::Over(_) => return,
        };
        self.heard = now;
        match result {
            MissionResult::ACCEPTED if all_sent => self.end(Ok(ItemsSent { acknowledged: true, plan_id })),
            // Accepted before all was sent: of an upload before this one, or a lie. The read-back would find out.
            MissionResult::ACCEPTED => {}
            MissionResult::INVALID_SEQUENCE => match &mut self.state {
                Upload::Sending { window, complained, .. } if self.config.is_ardupilot => {
                    *window = 1;
                    *complained = true;
                }
                Upload::Sending { .. } => self.restart(now),
                _ => {}
            },
            MissionResult::DENIED if counting => {
                if now.since(self.began) >= SILENCE_LIMIT {
                    self.end(Err(TransferError::Refused { kind: self.kind, result, seq: None }));
                } else if let Upload::Counting { retry_at, .. } = &mut self.state {
                    *retry_at = now + DENIED_WAIT;
                }
            }
            MissionResult::DENIED => self.restart(now),
            // It has all it wants, and got the last item once more.
            MissionResult::ERROR if self.config.is_ardupilot && all_sent => {
                self.end(Ok(ItemsSent { acknowledged: false, plan_id: None }));
            }
            MissionResult::ERROR if self.config.is_ardupilot && counting && self.errors.may_be_late() => {}
            // The vehicle gave up waiting; while counting, it is the end of the upload before.
            MissionResult::OPERATION_CANCELLED => {
                if !counting {
                    self.restart(now);
                }
            }
            result => self.end(Err(TransferError::Refused { kind: self.kind, result, seq: last })),
        }
    }

    /// When the state ends by itself, and whether that begins the upload anew.
    fn patience(&self) -> Option<MonoTime> {
        let limit = self.progressed + PROGRESS_LIMIT;
        match self.state {
            Upload::Counting { retry_at, .. } => Some(retry_at.min(limit)),
            Upload::Sending { asked, complained, .. } => {
                let stalled = (self.heard + STALL_LIMIT).min(limit);
                let is_last = asked + 1 == self.count() && !complained;
                let finished = self.heard + REQUEST_REPEAT + ITEM_TIMEOUT + self.round_trip.timeout();
                Some(if is_last { finished.min(stalled) } else { stalled })
            }
            Upload::Over(_) => None,
        }
    }
}

impl Transfer for ItemUpload {
    type Value = ItemsSent;

    #[allow(deprecated, reason = "ArduPilot asks with MISSION_REQUEST, also for MISSION_ITEM_INT")]
    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        if !self.config.concerns_us(from, message) {
            return;
        }
        let kind = mav_mission_type(self.kind);
        match message {
            Message::Dialect(MavMessage::MISSION_REQUEST_INT(request)) if request.mission_type == kind => {
                self.on_request(request.seq, true, now);
            }
            Message::Dialect(MavMessage::MISSION_REQUEST(request)) if request.mission_type == kind => {
                self.on_request(request.seq, false, now);
            }
            Message::MissionAck(ack) if ack.mission_type == self.kind.mission_type() => {
                self.on_ack(MissionResult(ack.result), Some(ack.opaque_id).filter(|id| *id != 0), now);
            }
            _ => {}
        }
    }

    fn on_time(&mut self, now: MonoTime) {
        let Some(at) = self.patience() else { return };
        if now < at {
            return;
        }
        if now >= self.progressed + PROGRESS_LIMIT {
            let attempts = self.restarts + 1;
            return self.end(Err(TransferError::NoProgress { step: "sending a plan item by item", attempts }));
        }
        match self.state {
            Upload::Counting { tries, .. } => {
                let waited = now.since(self.heard);
                if waited >= SILENCE_LIMIT {
                    self.end(Err(TransferError::Timeout { step: "MISSION_COUNT", waited }));
                } else {
                    self.round_trip.timed_out();
                    self.send_count(tries + 1, now);
                }
            }
            // The last item was sent and is not asked for again: most likely the final MISSION_ACK was lost.
            Upload::Sending { asked, complained: false, .. } if asked + 1 == self.count() => {
                self.end(Ok(ItemsSent { acknowledged: false, plan_id: None }));
            }
            Upload::Sending { .. } => self.restart(now),
            Upload::Over(_) => {}
        }
    }

    fn deadline(&self) -> Option<MonoTime> {
        self.patience()
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<ItemsSent, TransferError>> {
        if let Upload::Over(result) = &mut self.state { result.take() } else { None }
    }

    fn cancel(&mut self, _now: MonoTime) {
        if !matches!(self.state, Upload::Over(_)) {
            self.out.clear();
            self.out.push_back(TransferOutput::Send(ack(&self.config, self.kind, MissionResult::OPERATION_CANCELLED)));
            self.end(Err(TransferError::Cancelled));
        }
    }
}

/// Reads a list, item by item.
#[derive(Debug)]
pub(crate) struct ItemDownload {
    config: TransferConfig,
    kind: PlanKind,
    form: ItemForm,
    state: Download,
    heard: MonoTime,
    began: MonoTime,
    /// When it last got further.
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
    /// Items before this one were asked for.
    next: usize,
    /// Asked for and not there yet, in the order of asking.
    asked: VecDeque<Asked>,
    /// How many may be asked for at once.
    window: usize,
    /// When the first was asked for, and how often some were late since.
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

    /// Asks for as many items as the window lets, or ends when all are there.
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

    /// Asks again for items that are late or were overtaken.
    fn ask_again(&mut self, now: MonoTime) {
        let timeout = self.round_trip.timeout();
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
        let refused = TransferError::Refused { kind, result, seq: None };
        match (&mut self.state, result) {
            (Download::Over(_), _) | (_, MissionResult::ACCEPTED) => {}
            (_, MissionResult::ERROR) if self.config.is_ardupilot && self.errors.may_be_late() => {}
            // Another station is uploading.
            (Download::Listing { retry_at, .. }, MissionResult::DENIED | MissionResult::OPERATION_CANCELLED) => {
                self.heard = now;
                if now.since(self.began) >= SILENCE_LIMIT {
                    self.end(Err(refused));
                } else {
                    *retry_at = now + DENIED_WAIT;
                }
            }
            // Left over from an upload before this.
            (Download::Listing { .. }, MissionResult::INVALID_SEQUENCE) => {}
            (Download::Listing { .. }, _) => self.end(Err(refused)),
            // The plan got shorter, or another station began to upload: from the beginning.
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
        let waited = now.since(self.heard);
        if now >= self.progressed + PROGRESS_LIMIT {
            let attempts = self.restarts + 1;
            return self.end(Err(TransferError::NoProgress { step: "reading a plan item by item", attempts }));
        }
        match self.state {
            Download::Listing { .. } if waited >= SILENCE_LIMIT => {
                self.end(Err(TransferError::Timeout { step: "MISSION_REQUEST_LIST", waited }));
            }
            Download::Reading(_) if waited >= SILENCE_LIMIT => {
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
            Download::Reading(_) => self.ask_again(now),
            Download::Over(_) => {}
        }
    }

    fn deadline(&self) -> Option<MonoTime> {
        let limit = self.progressed + PROGRESS_LIMIT;
        match &self.state {
            Download::Listing { retry_at, .. } => Some((*retry_at).min(limit)),
            Download::Reading(reading) => {
                let timeout = self.round_trip.timeout();
                let late = reading.asked.iter().map(|asked| asked.at + timeout).min();
                let gone = (self.heard + SILENCE_LIMIT).min(limit);
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
