//! Sending a plan item by item.

use vencejo_flight::plan::PlanKind;
use vencejo_proto::dialect::{MISSION_COUNT_DATA, MavMessage};
use vencejo_proto::{Address, Message, MissionItemInt, MonoTime};

use super::{LateErrors, Outbox, ack, mav_mission_type};
use crate::transfer::float::to_float;
use crate::transfer::timing::{
    BUSY_WAIT, DENIED_WAIT, DUPLICATE_WINDOW, INTEGERS_IGNORED, ITEM_TIMEOUT, MESSAGE_TIMEOUT, PROGRESS_LIMIT,
    REQUEST_REPEAT, RESTARTS, RoundTrip, SILENCE_LIMIT, STALL_LIMIT,
};
use crate::transfer::{ItemForm, MissionResult, Transfer, TransferConfig, TransferError, TransferOutput};

/// Number of returns to an earlier item above which an upload makes no progress.
const INSISTENCE: u32 = 20;

/// How an item upload ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ItemsSent {
    /// Whether the vehicle's final MISSION_ACK came. Without it, every item was sent and the vehicle asks for none
    /// again.
    pub acknowledged: bool,
    /// The vehicle's id of the list since then, where it gives one (MISSION_ACK.opaque_id).
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
    /// When a message of this transfer last came, or when it began.
    heard: MonoTime,
    /// When the present attempt began to ask by MISSION_COUNT.
    counting_since: MonoTime,
    /// When it last progressed, and the furthest item.
    progressed: MonoTime,
    furthest: u16,
    /// Number of returns of the vehicle to an earlier item.
    insisted: u32,
    /// How often it requested the first item by MISSION_REQUEST, which may mean that it does not support the answer.
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
        /// The item it last requested.
        asked: u16,
        /// When we answered that request.
        answered: MonoTime,
        /// Items before this one were sent.
        sent: u16,
        /// Items sent ahead of its requests, plus the one it asks for.
        window: u16,
        /// Whether it reported an item out of order: items are missing, and it will request them again.
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
            counting_since: now,
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

    /// An item's number among those of the plan: an ArduPilot's mission begins with home.
    fn number_of(&self, seq: u16) -> u16 {
        let begins_with_home = self.config.is_ardupilot && self.kind == PlanKind::Mission;
        seq.saturating_add(u16::from(!begins_with_home))
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
        (self.furthest, self.counting_since) = (0, now);
        if self.restarts > RESTARTS {
            self.give_up(self.restarts);
        } else {
            self.send_count(1, now);
        }
    }

    /// Ends an upload in which the vehicle may still wait for an item; a PX4 would refuse the next one meanwhile.
    fn give_up(&mut self, attempts: u32) {
        self.out.push_back(TransferOutput::Send(ack(&self.config, self.kind, MissionResult::OPERATION_CANCELLED)));
        self.end(Err(TransferError::NoProgress { step: "sending a plan item by item", attempts }));
    }

    /// The vehicle is in another transfer: the count is repeated when that may have ended.
    fn on_busy(&mut self, result: MissionResult, now: MonoTime) {
        if now.since(self.counting_since) >= SILENCE_LIMIT {
            self.end(Err(TransferError::Refused { kind: self.kind, result, item: None }));
        } else if let Upload::Counting { retry_at, .. } = &mut self.state {
            *retry_at = now + if result == MissionResult::ERROR { BUSY_WAIT } else { DENIED_WAIT };
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
                // A vehicle that goes on to the next item has understood this one.
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

    /// Resumes an upload that ended without the final MISSION_ACK: the vehicle requests an item after all.
    pub(crate) fn resume(&mut self, now: MonoTime) {
        let count = self.count();
        // The request that follows is to be answered at once.
        let answered = MonoTime::ZERO;
        self.state =
            Upload::Sending { asked: count.saturating_sub(1), answered, sent: count, window: 1, complained: false };
        self.heard = now;
        self.progressed = now;
    }

    /// Whether a message requests an item of this list.
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

    /// Whether such an answer to the count says that the vehicle is in another transfer.
    fn may_be_busy(&self, result: MissionResult) -> bool {
        result == MissionResult::DENIED || !self.config.is_ardupilot
    }

    fn on_ack(&mut self, result: MissionResult, plan_id: Option<u32>, now: MonoTime) {
        let (counting, all_sent, last) = match self.state {
            Upload::Counting { .. } => (true, self.items.is_empty(), None),
            Upload::Sending { asked, sent, .. } => (false, sent == self.count(), Some(self.number_of(asked))),
            Upload::Over(_) => return,
        };
        self.heard = now;
        match result {
            MissionResult::ACCEPTED if all_sent => self.end(Ok(ItemsSent { acknowledged: true, plan_id })),
            // Accepted before all was sent: of a previous upload, or wrong. The read-back would find out.
            MissionResult::ACCEPTED => {}
            MissionResult::INVALID_SEQUENCE => match &mut self.state {
                Upload::Sending { window, complained, .. } if self.config.is_ardupilot => {
                    *window = 1;
                    *complained = true;
                }
                Upload::Sending { .. } => self.restart(now),
                _ => {}
            },
            // A PX4 answers so to the count while it is in another transfer, and to each copy of an item that comes when
            // it has given up waiting for that.
            MissionResult::DENIED | MissionResult::ERROR if counting && self.may_be_busy(result) => {
                self.on_busy(result, now);
            }
            MissionResult::DENIED => self.restart(now),
            MissionResult::ERROR if !self.config.is_ardupilot && self.restarts < RESTARTS => self.restart(now),
            // It has all items, and received the last one again.
            MissionResult::ERROR if self.config.is_ardupilot && all_sent => {
                self.end(Ok(ItemsSent { acknowledged: false, plan_id: None }));
            }
            MissionResult::ERROR if self.config.is_ardupilot && counting && self.errors.may_be_late() => {}
            // The vehicle gave up waiting; while counting, this ends the previous upload.
            MissionResult::OPERATION_CANCELLED => {
                if !counting {
                    self.restart(now);
                }
            }
            result => self.end(Err(TransferError::Refused { kind: self.kind, result, item: last })),
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
            return self.give_up(self.restarts + 1);
        }
        match self.state {
            Upload::Counting { tries, .. } => {
                let waited = now.since(self.heard);
                if waited >= self.round_trip.limit(SILENCE_LIMIT) {
                    self.end(Err(TransferError::Timeout { step: "MISSION_COUNT", waited }));
                } else {
                    self.round_trip.timed_out();
                    self.send_count(tries + 1, now);
                }
            }
            // The last item was sent and is not requested again: most likely the final MISSION_ACK was lost.
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
