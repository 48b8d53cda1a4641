//! Parameters of a vehicle: all of them, one of them, and setting one
//! (<https://mavlink.io/en/services/parameter.html>).

use std::collections::BTreeMap;

use vencejo_proto::dialect::{
    MavMessage, MavParamError, MavParamType, PARAM_REQUEST_LIST_DATA, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA,
    PARAM_VALUE_DATA,
};
use vencejo_proto::param::{
    Param, ParamEncoding, ParamError, ParamName, ParamType, ParamValue, ShownEncodings, decode_packed_params,
};
use vencejo_proto::{Address, Message, MonoTime};

use super::ftp::{FileEnd, FileRead};
use super::items::Outbox;
use super::timing::{
    ITEM_TIMEOUT, MESSAGE_TIMEOUT, PARAM_ANSWER_LIMIT, PARAM_TIMEOUT, RESTARTS, RoundTrip, SILENCE_LIMIT,
};
use super::{Transfer, TransferConfig, TransferError, TransferOutput};

const PACKED_PATH: &str = "@PARAM/param.pck";
/// Most bytes of a packed parameter file: 24 for each of the most parameters.
const PACKED_MAX: usize = 24 * MAX_PARAMS;
/// Most parameters taken; the largest autopilots have about 2,000.
const MAX_PARAMS: usize = 10_000;
/// Parameters asked for at once when gaps are filled: ArduPilot queues 20 requests.
const MAX_REQUESTS: usize = 10;
/// Contradicting reports, each after a transmission of the value, after which the vehicle's own value counts as final.
const CONTRADICTIONS: u32 = 4;
/// The index of a PARAM_VALUE that answers a request by name, or none.
const NO_INDEX: u16 = u16::MAX;

/// The contents of a PARAM_VALUE, undecoded.
#[derive(Debug, Clone, Copy)]
struct Heard {
    name: ParamName,
    raw: f32,
    param_type: ParamType,
}

impl Heard {
    /// `None` without a valid name, or for a type that PARAM_VALUE cannot hold.
    fn of(message: &PARAM_VALUE_DATA) -> Option<Self> {
        let name = ParamName::from_field(&message.param_id)?;
        Some(Self { name, raw: message.param_value, param_type: ParamType::from_mav(message.param_type)? })
    }

    /// The encoding that the value shows by itself.
    fn shown(self) -> Option<ParamEncoding> {
        let mut shown = ShownEncodings::default();
        shown.note(self.raw, self.param_type);
        shown.only()
    }

    /// Its value, in the encoding that is known or else in the one that it shows; one that shows none is taken for a
    /// number. `None` when the value cannot be.
    fn read(self, known: Option<ParamEncoding>) -> Option<Param> {
        let encoding = known.or_else(|| self.shown()).unwrap_or(ParamEncoding::CCast);
        let value = ParamValue::from_wire(self.raw, self.param_type, encoding)?;
        Some(Param { name: self.name, value })
    }
}

/// The name and value of a PARAM_VALUE; `None` when either is invalid.
fn read(config: &TransferConfig, message: &PARAM_VALUE_DATA) -> Option<Param> {
    Heard::of(message)?.read(config.param_encoding)
}

fn request_read(config: &TransferConfig, name: Option<ParamName>, index: i16) -> TransferOutput {
    TransferOutput::Send(Message::Dialect(MavMessage::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
        param_index: index,
        target_system: config.vehicle.system.0,
        target_component: config.vehicle.component.0,
        param_id: name.map_or([0; 16], ParamName::to_field).into(),
    })))
}

/// Reads all parameters: over MAVFTP as one packed file where the vehicle is an ArduPilot that has it, else as a stream
/// of PARAM_VALUE whose gaps are asked for again. Its value is in the vehicle's order.
#[derive(Debug)]
pub struct ParamList {
    config: TransferConfig,
    by: ListBy,
    result: Option<Result<Vec<Param>, TransferError>>,
    is_over: bool,
    out: Outbox,
}

#[derive(Debug)]
enum ListBy {
    File(Box<FileRead>, u32),
    Messages(Messages),
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
    /// Indexes requested singly, and when.
    reads: BTreeMap<u16, MonoTime>,
    /// Where to look for the next gap.
    cursor: u16,
    is_filling: bool,
    round_trip: RoundTrip,
}

impl ParamList {
    /// Begins to read.
    pub fn new(config: &TransferConfig, now: MonoTime) -> Self {
        let by = ListBy::Messages(Messages::new(config, now));
        let mut list = Self { config: config.clone(), by, result: None, is_over: false, out: Outbox::new() };
        if config.is_ardupilot && config.has_ftp {
            list.by = ListBy::File(Box::new(Self::file(config, now)), 0);
            list.advance(now);
        } else {
            list.by_messages(now);
        }
        list
    }

    fn file(config: &TransferConfig, now: MonoTime) -> FileRead {
        let end_of = Box::new(|_: &[u8]| Ok(FileEnd::WhenShort));
        FileRead::new(config, PACKED_PATH, PACKED_MAX, end_of, None, now)
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
        let ListBy::File(file, attempts) = &mut self.by else { return };
        while let Some(output) = file.poll_output() {
            self.out.push_back(output);
        }
        let attempts = *attempts;
        match file.result() {
            None => {}
            Some(Ok(bytes)) => match decode_packed_params(&bytes) {
                Ok(params) if params.len() <= MAX_PARAMS => self.end(Ok(params)),
                // A parameter was added while it was read, or the file is invalid.
                _ if attempts == 0 => {
                    self.by = ListBy::File(Box::new(Self::file(&self.config, now)), attempts + 1);
                    self.advance(now);
                }
                _ => self.by_messages(now),
            },
            Some(Err(TransferError::Cancelled)) => self.end(Err(TransferError::Cancelled)),
            Some(Err(error @ TransferError::Timeout { .. })) => self.end(Err(error)),
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
        if let Some(asked) = messages.reads.remove(&index) {
            messages.round_trip.sample(now.since(asked));
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
                messages.reads.insert(index, now);
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
        match self.reads.values().min() {
            Some(oldest) => *oldest + timeout,
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
        if waited >= SILENCE_LIMIT {
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
        let before = messages.reads.len();
        messages.reads.retain(|_, at| now < *at + timeout);
        if messages.reads.len() < before {
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
            ListBy::Messages(messages) => Some(messages.retry_at().min(messages.progressed + SILENCE_LIMIT)),
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

/// The error of a PARAM_ERROR about a parameter; `None` for other messages.
fn refusal(message: &Message, name: ParamName) -> Option<TransferError> {
    let Message::Dialect(MavMessage::PARAM_ERROR(error)) = message else { return None };
    if ParamName::from_field(&error.param_id) != Some(name) {
        return None;
    }
    let reason = match error.error {
        MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST => return Some(TransferError::UnknownParam { name, told: true }),
        MavParamError::MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE => "the value is out of range",
        MavParamError::MAV_PARAM_ERROR_PERMISSION_DENIED => "this station may not set it",
        MavParamError::MAV_PARAM_ERROR_READ_ONLY => "it is read-only",
        MavParamError::MAV_PARAM_ERROR_TYPE_UNSUPPORTED => "its type is not supported",
        MavParamError::MAV_PARAM_ERROR_TYPE_MISMATCH => "its type is different",
        MavParamError::MAV_PARAM_ERROR_READ_FAIL => "it could not be read",
        MavParamError::MAV_PARAM_ERROR_COMPONENT_NOT_FOUND => "the component does not exist",
        MavParamError::MAV_PARAM_ERROR_NO_ERROR => return None,
    };
    Some(TransferError::ParamRefused { name, reason })
}

/// Reads one parameter by its name.
#[derive(Debug)]
pub struct ParamRead {
    config: TransferConfig,
    name: ParamName,
    began: MonoTime,
    retry_at: Option<MonoTime>,
    round_trip: RoundTrip,
    /// The encoding that the value showed.
    shown: Option<ParamEncoding>,
    result: Option<Result<Param, TransferError>>,
    out: Outbox,
}

impl ParamRead {
    /// Begins to read.
    pub fn new(config: &TransferConfig, name: ParamName, now: MonoTime) -> Self {
        let mut read = Self {
            config: config.clone(),
            name,
            began: now,
            retry_at: None,
            round_trip: RoundTrip::new(config.round_trip, PARAM_TIMEOUT),
            shown: None,
            result: None,
            out: Outbox::new(),
        };
        read.ask(now);
        read
    }

    fn ask(&mut self, now: MonoTime) {
        self.out.push_back(request_read(&self.config, Some(self.name), -1));
        self.retry_at = Some(now + self.round_trip.timeout());
    }

    fn end(&mut self, result: Result<Param, TransferError>) {
        self.retry_at = None;
        self.result = Some(result);
    }
}

impl Transfer for ParamRead {
    type Value = Param;

    fn on_message(&mut self, from: Address, message: &Message, _now: MonoTime) {
        if self.retry_at.is_none() || !self.config.concerns_us(from, message) {
            return;
        }
        if let Some(error) = refusal(message, self.name) {
            return self.end(Err(error));
        }
        if let Message::Dialect(MavMessage::PARAM_VALUE(value)) = message
            && let Some(heard) = Heard::of(value).filter(|heard| heard.name == self.name)
            && let Some(param) = heard.read(self.config.param_encoding)
        {
            self.shown = heard.shown();
            self.end(Ok(param));
        }
    }

    fn on_time(&mut self, now: MonoTime) {
        if self.deadline().is_none_or(|at| now < at) {
            return;
        }
        if now.since(self.began) >= PARAM_ANSWER_LIMIT {
            self.end(Err(TransferError::UnknownParam { name: self.name, told: false }));
        } else {
            self.round_trip.timed_out();
            self.ask(now);
        }
    }

    fn deadline(&self) -> Option<MonoTime> {
        self.retry_at.map(|at| at.min(self.began + PARAM_ANSWER_LIMIT))
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<Param, TransferError>> {
        self.result.take()
    }

    fn cancel(&mut self, _now: MonoTime) {
        if self.retry_at.is_some() {
            self.end(Err(TransferError::Cancelled));
        }
    }
}

/// Sets one parameter: reads it, so that its type is known and the value can be checked; sends the value; and is done
/// when the vehicle then says that it has it.
#[derive(Debug)]
pub struct ParamSet {
    config: TransferConfig,
    name: ParamName,
    wanted: f64,
    step: Set,
    round_trip: RoundTrip,
    out: Outbox,
}

#[derive(Debug)]
enum Set {
    Reading(ParamRead),
    Setting {
        value: ParamValue,
        began: MonoTime,
        retry_at: MonoTime,
        /// A different value that the vehicle has reported since the last transmission.
        other: Option<ParamValue>,
        /// How often it was sent and a different value came back.
        contradicted: u32,
    },
    Over(Option<Result<Param, TransferError>>),
}

impl ParamSet {
    /// Begins to set. A value that is not finite ends at once.
    pub fn new(config: &TransferConfig, name: ParamName, value: f64, now: MonoTime) -> Self {
        let step = match ParamValue::new(ParamType::F32, value) {
            Ok(_) => Set::Reading(ParamRead::new(config, name, now)),
            Err(error) => Set::Over(Some(Err(error.into()))),
        };
        let round_trip = RoundTrip::new(config.round_trip, PARAM_TIMEOUT);
        let mut set = Self { config: config.clone(), name, wanted: value, step, round_trip, out: Outbox::new() };
        set.advance(now);
        set
    }

    fn advance(&mut self, now: MonoTime) {
        let Set::Reading(reading) = &mut self.step else { return };
        while let Some(output) = reading.poll_output() {
            self.out.push_back(output);
        }
        let shown = reading.shown;
        match reading.result() {
            None => {}
            Some(Err(error)) => self.step = Set::Over(Some(Err(error))),
            Some(Ok(param)) => match self.checked(param, shown) {
                Err(error) => self.step = Set::Over(Some(Err(error.into()))),
                Ok(value) => {
                    let retry_at = now + self.round_trip.timeout();
                    self.step = Set::Setting { value, began: now, retry_at, other: None, contradicted: 0 };
                    self.send(value);
                }
            },
        }
    }

    /// The value to send, of the type that the vehicle has, whose value was read and `shown` its encoding.
    fn checked(&mut self, read: Param, shown: Option<ParamEncoding>) -> Result<ParamValue, ParamError> {
        let value = ParamValue::new(read.value.param_type(), self.wanted)?;
        self.config.param_encoding = self.config.param_encoding.or(shown);
        let is_known = self.config.param_encoding.is_some() || value.param_type() == ParamType::F32;
        is_known.then_some(value).ok_or(ParamError::UnknownEncoding { name: self.name })
    }

    /// As it goes over the wire.
    fn wire(&self, value: ParamValue) -> f32 {
        // An unknown encoding is possible only for floats, which are the same in both.
        value.to_wire(self.config.param_encoding.unwrap_or(ParamEncoding::CCast))
    }

    fn send(&mut self, value: ParamValue) {
        let param_type: MavParamType = value.param_type().to_mav();
        self.out.push_back(TransferOutput::Send(Message::Dialect(MavMessage::PARAM_SET(PARAM_SET_DATA {
            param_value: self.wire(value),
            target_system: self.config.vehicle.system.0,
            target_component: self.config.vehicle.component.0,
            param_id: self.name.to_field().into(),
            param_type,
        }))));
    }

    fn on_value(&mut self, param: Param, now: MonoTime) {
        let Set::Setting { value, .. } = self.step else { return };
        // As it came over the wire: a C-cast integer above 2^24 has lost its last bits both ways.
        if self.wire(param.value).to_bits() == self.wire(value).to_bits() {
            self.step = Set::Over(Some(Ok(param)));
            return;
        }
        let Set::Setting { retry_at, other, .. } = &mut self.step else { return };
        // The old value may be a late answer to an earlier read: send again, and then believe the vehicle.
        *other = Some(param.value);
        *retry_at = (*retry_at).min(now + ITEM_TIMEOUT);
    }
}

impl Transfer for ParamSet {
    type Value = Param;

    fn on_message(&mut self, from: Address, message: &Message, now: MonoTime) {
        match &mut self.step {
            Set::Reading(reading) => {
                reading.on_message(from, message, now);
                self.advance(now);
            }
            Set::Setting { .. } => {
                if !self.config.concerns_us(from, message) {
                    return;
                }
                if let Some(error) = refusal(message, self.name) {
                    self.step = Set::Over(Some(Err(error)));
                } else if let Message::Dialect(MavMessage::PARAM_VALUE(value)) = message
                    && let Some(param) = read(&self.config, value)
                    && param.name == self.name
                {
                    self.on_value(param, now);
                }
            }
            Set::Over(_) => {}
        }
    }

    fn on_time(&mut self, now: MonoTime) {
        match &mut self.step {
            Set::Reading(reading) => {
                reading.on_time(now);
                self.advance(now);
            }
            Set::Setting { value, began, retry_at, other, contradicted } if now >= *retry_at => {
                let (name, asked) = (self.name, *value);
                let waited = now.since(*began);
                match other.take() {
                    Some(kept) => {
                        *contradicted += 1;
                        if *contradicted >= CONTRADICTIONS {
                            let error = TransferError::ParamNotKept { name, asked, kept };
                            self.step = Set::Over(Some(Err(error)));
                            return;
                        }
                    }
                    None => self.round_trip.timed_out(),
                }
                if waited >= SILENCE_LIMIT {
                    self.step = Set::Over(Some(Err(TransferError::Timeout { step: "PARAM_SET", waited })));
                    return;
                }
                *retry_at = now + self.round_trip.timeout();
                // ArduPilot may keep silent when nothing changes: set and read in one go.
                self.send(asked);
                self.out.push_back(request_read(&self.config, Some(name), -1));
            }
            _ => {}
        }
    }

    fn deadline(&self) -> Option<MonoTime> {
        match &self.step {
            Set::Reading(reading) => reading.deadline(),
            Set::Setting { retry_at, .. } => Some(*retry_at),
            Set::Over(_) => None,
        }
    }

    fn poll_output(&mut self) -> Option<TransferOutput> {
        self.out.pop_front()
    }

    fn result(&mut self) -> Option<Result<Param, TransferError>> {
        if let Set::Over(result) = &mut self.step { result.take() } else { None }
    }

    fn cancel(&mut self, _now: MonoTime) {
        if !matches!(self.step, Set::Over(_)) {
            self.step = Set::Over(Some(Err(TransferError::Cancelled)));
        }
    }
}
