//! Reading and setting one parameter.

use vencejo_proto::dialect::{MavMessage, MavParamType, PARAM_SET_DATA};
use vencejo_proto::param::{Param, ParamEncoding, ParamError, ParamName, ParamType, ParamValue};
use vencejo_proto::{Address, Message, MonoTime};

use super::{Heard, read, refusal, request_read};
use crate::transfer::items::Outbox;
use crate::transfer::timing::{ITEM_TIMEOUT, PARAM_ANSWER_LIMIT, PARAM_TIMEOUT, RoundTrip, SILENCE_LIMIT};
use crate::transfer::{Transfer, TransferConfig, TransferError, TransferOutput};

/// Contradicting reports, each after a transmission of the value, after which the vehicle's own value counts as final.
const CONTRADICTIONS: u32 = 4;

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
        if now.since(self.began) >= self.round_trip.limit(PARAM_ANSWER_LIMIT) {
            self.end(Err(TransferError::UnknownParam { name: self.name, told: false }));
        } else {
            self.round_trip.timed_out();
            self.ask(now);
        }
    }

    fn deadline(&self) -> Option<MonoTime> {
        self.retry_at.map(|at| at.min(self.began + self.round_trip.limit(PARAM_ANSWER_LIMIT)))
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
                if waited >= self.round_trip.limit(SILENCE_LIMIT) {
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
