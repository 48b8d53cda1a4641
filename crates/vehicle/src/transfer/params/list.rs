//! Reading all parameters.

use std::collections::BTreeMap;

use vencejo_proto::dialect::{MavMessage, PARAM_REQUEST_LIST_DATA, PARAM_VALUE_DATA};
use vencejo_proto::param::{Param, ParamName, ParamValue, ShownEncodings, decode_packed_params};
use vencejo_proto::{Address, Message, MonoTime};

use super::{Heard, NO_INDEX, read, request_read};
use crate::transfer::ftp::{FileEnd, FileRead};
use crate::transfer::items::Outbox;
use crate::transfer::timing::{ITEM_TIMEOUT, MESSAGE_TIMEOUT, RESTARTS, RoundTrip, SILENCE_LIMIT};
use crate::transfer::{Transfer, TransferConfig, TransferError, TransferOutput};

/// The packed parameter file with default values; ArduPilots before 4.2 ignore the query.
const PACKED_WITH_DEFAULTS: &str = "@PARAM/param.pck?withdefaults=1";
/// The same without, for one that refuses the query.
const PACKED: &str = "@PARAM/param.pck";
/// Most bytes of a packed parameter file: 28 for each of the most parameters.
const PACKED_MAX: usize = 28 * MAX_PARAMS;
/// Most parameters taken; the largest autopilots have about 2,000.
const MAX_PARAMS: usize = 10_000;
/// Parameters asked for at once when gaps are filled: ArduPilot queues 20 requests.
const MAX_REQUESTS: usize = 10;

/// Reads all parameters: over MAVFTP as one packed file where the vehicle is an ArduPilot that has it, with their
/// default values where it knows them; else as a stream of PARAM_VALUE whose gaps are asked for again. Its value is in
/// the vehicle's order.
#[derive(Debug)]
pub struct ParamList {
    config: TransferConfig,
    by: ListBy,
    /// Values told while the file is read, which may hold earlier ones.
    told: BTreeMap<ParamName, ParamValue>,
    result: Option<Result<Vec<Param>, TransferError>>,
    is_over: bool,
    out: Outbox,
}

#[derive(Debug)]
enum ListBy {
    File(Box<FileRead>, Attempt),
    Messages(Messages),
}

/// Attempts to read the file, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Attempt {
    First,
    /// A parameter was added while the file was read, or the file is invalid.
    Second,
    /// The vehicle refused the query for default values.
    WithoutDefaults,
}

/// The stream of PARAM_VALUE.
#[derive(Debug)]
struct Messages {
    /// By index. A map, because their number comes from the vehicle.
    params: BTreeMap<u16, Option<Heard>>,
    /// The encodings that they show.
    shown: ShownEncodings,
    count: Option<u16>,
    count_changes: u32,
    /// How often the whole list was requested, and when.
    asked: u32,
    asked_at: MonoTime,
    /// When a new value last came.
    progressed: MonoTime,
    /// Indexes requested singly.
    reads: BTreeMap<u16, Asked>,
    /// Where to look for the next gap.
    cursor: u16,
    is_filling: bool,
    round_trip: RoundTrip,
}

#[derive(Debug, Clone, Copy)]
struct Asked {
    at: MonoTime,
    /// Asked for twice: the answer may be to either request, and tells no round trip (Karn's algorithm).
    again: bool,
}

impl ParamList {
    /// Begins to read.
    pub fn new(config: &TransferConfig, now: MonoTime) -> Self {
        let by = ListBy::Messages(Messages::new(config, now));
        let (told, out) = (BTreeMap::new(), Outbox::new());
        let mut list = Self { config: config.clone(), by, told, result: None, is_over: false, out };
        if config.is_ardupilot && config.has_ftp {
            list.by_file(Attempt::First, now);
        } else {
            list.by_messages(now);
        }
        list
    }

    fn by_file(&mut self, attempt: Attempt, now: MonoTime) {
        let end_of = Box::new(|_: &[u8]| Ok(FileEnd::WhenShort));
        let path = if attempt == Attempt::WithoutDefaults { PACKED } else { PACKED_WITH_DEFAULTS };
        let file = FileRead::new(&self.config, path, PACKED_MAX, end_of, None, now);
        self.by = ListBy::File(Box::new(file), attempt);
        self.advance(now);
    }

    fn by_messages(&mut self, now: MonoTime) {
        self.by = ListBy::Messages(Messages::new(&self.config, now));
        self.out.push_back(self.request_list());
    }

    fn request_list(&self) -> TransferOutput {
        TransferOutput::Send(Message::Dialect(MavMessage::PARAM_REQUEST_LIST(PARAM_REQUEST_LIST_DATA {
            target_system: self.config.vehicle.system.0,
            target_component: self.config.vehicle.component.0,
        })))
    }

    fn end(&mut self, result: Result<Vec<Param>, TransferError>) {
        self.is_over = true;
        self.result = Some(result);
    }

    /// Passes on the outputs and the result of the file's reader.
    fn advance(&mut self, now: MonoTime) {
        let ListBy::File(file, attempt) = &mut self.by else { return };
        while let Some(output) = file.poll_output() {
            self.out.push_back(output);
        }
        let attempt = *attempt;
        match file.result() {
            None => {}
            Some(Ok(bytes)) => match decode_packed_params(&bytes) {
                Ok(mut params) if params.len() <= MAX_PARAMS => {
                    for param in &mut params {
                        param.value = self.told.get(&param.name).copied().unwrap_or(param.value);
                    }
                    self.end(Ok(params));
                }
                _ if attempt == Attempt::First => self.by_file(Attempt::Second, now),
                _ => self.by_messages(now),
            },
            Some(Err(TransferError::Cancelled)) => self.end(Err(TransferError::Cancelled)),
            Some(Err(error @ TransferError::Timeout { .. })) => self.end(Err(error)),
            Some(Err(TransferError::Ftp { .. })) if attempt != Attempt::WithoutDefaults => {
                self.by_file(Attempt::WithoutDefaults, now);
            }
            Some(Err(error)) => {
                tracing::debug!(%error, "reading parameters message by message instead");
                self.by_messages(now);
            }
        }
    }

    fn on_value(&mut self, value: &PARAM_VALUE_DATA, now: MonoTime) {
        let ListBy::Messages(messages) = &mut self.by else { return };
        let (index, count) = (value.param_index, value.param_count);
        // A parameter that changed meanwhile: it was not requested by index.
        if index == NO_INDEX {
            if let Some(changed) = Heard::of(value) {
                let same_name = |param: &&mut Option<Heard>| param.is_some_and(|param| param.name == changed.name);
                if let Some(kept) = messages.params.values_mut().find(same_name) {
                    *kept = Some(changed);
                }
            }
            return;
        }
        if usize::from(count) > MAX_PARAMS {
            let (count, limit) = (u64::from(count), MAX_PARAMS as u64);
            return self.end(Err(TransferError::TooMany { what: "parameters", count, limit }));
        }
        if index >= count {
            return;
        }
        if messages.count != Some(count) {
            if messages.count.is_some() {
                messages.count_changes += 1;
                // A changed number of parameters shifts all indexes.
                messages.params.clear();
                messages.reads.clear();
                messages.cursor = 0;
                if messages.count_changes > RESTARTS {
                    let attempts = messages.count_changes;
                    let step = "reading parameters while their number keeps changing";
                    return self.end(Err(TransferError::NoProgress { step, attempts }));
                }
            }
            messages.count = Some(count);
        }
        if let Some(asked) = messages.reads.remove(&index).filter(|asked| !asked.again) {
            messages.round_trip.sample(now.since(asked.at));
        }
        let heard = Heard::of(value);
        if let Some(Heard { raw, param_type, .. }) = heard {
            messages.shown.note(raw, param_type);
        }
        if messages.params.insert(index, heard).is_none() {
            messages.progressed = now;
        }
        let (done, total) = (messages.params.len() as u32, u32::from(count));
        self.out.push_back(TransferOutput::Progress { done, total });
        if done == total {
            // An impossible value (NaN, a number that its type cannot hold) is left out, not a failure.
            let encoding = self.config.param_encoding.or_else(|| messages.shown.only());
            let heard = std::mem::take(&mut messages.params).into_values().flatten();
            let params = heard.filter_map(|heard| heard.read(encoding)).collect();
            return self.end(Ok(params));
        }
        if messages.is_filling {
            self.fill(now);
        }
    }

    /// Requests missing parameters singly, a few at a time.
    fn fill(&mut self, now: MonoTime) {
        let ListBy::Messages(messages) = &mut self.by else { return };
        let Some(count) = messages.count else { return };
        for _ in 0..count {
            if messages.reads.len() >= MAX_REQUESTS {
                break;
            }
            let index = messages.cursor % count;
            messages.cursor = (index + 1) % count;
            if !messages.params.contains_key(&index) && !messages.reads.contains_key(&index) {
                messages.reads.insert(index, Asked { at: now, again: false });
                self.out.push_back(request_read(&self.config, None, index as i16));
            }
        }
    }
}

impl Messages {
    fn new(config: &TransferConfig, now: MonoTime) -> Self {
        Self {
            params: BTreeMap::new(),
            shown: ShownEncodings::default(),
            count: None,
            count_changes: 0,
            asked: 1,
            asked_at: now,
            progressed: now,
            reads: BTreeMap::new(),
            cursor: 0,
            is_filling: false,
            round_trip: RoundTrip::new(config.round_trip, MESSAGE_TIMEOUT),
        }
    }

    /// When to ask again: for the whole list while nothing has come, else for what is missing.
    fn retry_at(&self) -> MonoTime {
        let timeout = self.round_trip.timeout();
        match self.reads.values().map(|asked| asked.at).min() {
            Some(oldest) => oldest + timeout,
            None if self.params.is_empty() => self.asked_at + timeout.max(MESSAGE_TIMEOUT),
            // The stream has stopped. ArduPilot sends it with a third of the line, so parts may be far apart.
            None => self.progressed + (2 * ITEM_TIMEOUT).max(timeout),
        }
    }
}

impl Transfer for ParamList {
    type Value = Vec<Param>;

    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        if self.is_over {
            return;
        }
        match &mut self.by {
            ListBy::File(file, _) => {
                if let Message::Dialect(MavMessage::PARAM_VALUE(value)) = message
                    && value.param_index == NO_INDEX
                    && self.config.concerns_us(from, message)
                    && let Some(param) = read(&self.config, value)
                    && self.told.len() < MAX_PARAMS
                {
                    self.told.insert(param.name, param.value);
                }
                file.on_message(from, message, now);
                self.advance(now);
            }
            ListBy::Messages(_) => {
                if let Message::Dialect(MavMessage::PARAM_VALUE(value)) = message
                    && self.config.concerns_us(from, message)
                {
                    self.on_value(value, now);
                }
            }
        }
    }

    fn on_time(&mut self, now: MonoTime) {
        if self.is_over {
            return;
        }
        let messages = match &mut self.by {
            ListBy::File(file, _) => {
                file.on_time(now);
                return self.advance(now);
            }
            ListBy::Messages(messages) => messages,
        };
        let waited = now.since(messages.progressed);
        if waited >= messages.round_trip.limit(SILENCE_LIMIT) {
            return self.end(Err(TransferError::Timeout { step: "PARAM_REQUEST_LIST", waited }));
        }
        if now < messages.retry_at() {
            return;
        }
        if messages.params.is_empty() {
            messages.asked += 1;
            messages.asked_at = now;
            messages.reads.clear();
            let request = self.request_list();
            self.out.push_back(request);
            return;
        }
        let timeout = messages.round_trip.timeout();
        let mut late = false;
        for (index, asked) in messages.reads.iter_mut().filter(|(_, asked)| now >= asked.at + timeout) {
            *asked = Asked { at: now, again: true };
            self.out.push_back(request_read(&self.config, None, *index as i16));
            late = true;
        }
        if late {
            messages.round_trip.timed_out();
        }
        messages.is_filling = true;
        self.fill(now);
    }

    fn deadline(&self) -> Option<MonoTime> {
        if self.is_over {
            return None;
        }
        match &self.by {
            ListBy::File(file, _) => file.deadline(),
            ListBy::Messages(messages) => {
                Some(messages.retry_at().min(messages.progressed + messages.round_trip.limit(SILENCE_LIMIT)))
            }
        }
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<Vec<Param>, TransferError>> {
        self.result.take()
    }

    fn cancel(&mut self, now: MonoTime) {
        if self.is_over {
            return;
        }
        if let ListBy::File(file, _) = &mut self.by {
            file.cancel(now);
            return self.advance(now);
        }
        self.end(Err(TransferError::Cancelled));
    }
}
