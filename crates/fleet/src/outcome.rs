//! What an order yields beyond "done", and what went wrong with a transfer: as answers carry it. No I/O.

use std::time::Duration;

use vencejo_flight::plan::{Difference, Field};
use vencejo_proto::param::ParamName;
use vencejo_proto::plain;
use vencejo_station::StationError;
use vencejo_vehicle::transfer::{MissionResult, TransferError};
use vencejo_vehicle::{Reply, VehicleError};

use crate::content::{Content, MAX_WITH_ANSWER, OneParam, pack_items, pack_params, value_of};
use crate::plans::{PlanTold, kind_of};
use crate::wire::{BadPayload, MAX_MESSAGES, MAX_TEXT, Said};

/// Differences that are told; of more, the first.
const MAX_DIFFERENCES: usize = 64;
/// What the station on board waited for, where the step itself is only in its log.
pub(crate) const STEP: &str = "the transfer on board";

/// What came of an order.
#[derive(Clone, PartialEq, prost::Oneof)]
pub enum Outcome {
    /// The acknowledgement's `result_param2`.
    #[prost(sint32, tag = "11")]
    Acknowledged(i32),
    /// One parameter as the vehicle has it.
    #[prost(message, tag = "12")]
    Param(OneParam),
    /// All parameters.
    #[prost(message, tag = "13")]
    Params(Content),
    /// The message that was asked for.
    #[prost(message, tag = "14")]
    Message(Said),
    /// A plan as the vehicle has it.
    #[prost(message, tag = "15")]
    Plan(PlanOutcome),
    /// A transfer that failed.
    #[prost(message, tag = "16")]
    Fault(Fault),
}

/// A plan as the vehicle has it.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PlanOutcome {
    /// What is known of it now.
    #[prost(message, optional, tag = "1")]
    pub told: Option<PlanTold>,
    /// Its items.
    #[prost(message, optional, tag = "2")]
    pub list: Option<Content>,
    /// How far the farthest position is from where it was sent to be, m.
    #[prost(double, optional, tag = "3")]
    pub position_error_m: Option<f64>,
}

/// How a transfer failed.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Fault {
    /// Which way.
    #[prost(enumeration = "FaultKind", tag = "1")]
    pub kind: i32,
    /// Which plan (`MAV_MISSION_TYPE`).
    #[prost(uint32, tag = "2")]
    pub plan: u32,
    /// For how long was waited, ms.
    #[prost(uint64, tag = "3")]
    pub waited_ms: u64,
    /// `MAV_MISSION_RESULT`, items left, attempts, or a message's id.
    #[prost(uint32, tag = "4")]
    pub number: u32,
    /// The item that was refused, counted from 1.
    #[prost(uint32, optional, tag = "5")]
    pub item: Option<u32>,
    /// In what the plan differs.
    #[prost(message, repeated, tag = "6")]
    pub differences: Vec<DifferenceTold>,
    /// What the parameter was to be.
    #[prost(message, optional, tag = "7")]
    pub asked: Option<OneParam>,
    /// What it is.
    #[prost(message, optional, tag = "8")]
    pub kept: Option<OneParam>,
    /// Name of a parameter that nobody knows.
    #[prost(string, tag = "9")]
    pub name: String,
    /// Whether the vehicle said so.
    #[prost(bool, tag = "10")]
    pub is_told: bool,
    /// What the vehicle's own checks say of a mission that they reject.
    #[prost(string, repeated, tag = "11")]
    pub reasons: Vec<String>,
}

/// The ways.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, prost::Enumeration)]
#[repr(i32)]
pub enum FaultKind {
    /// Never sent.
    Unspecified = 0,
    /// The vehicle's plan is not the one that was sent.
    NotAsSent = 1,
    /// It could not be read back.
    Unverified = 2,
    /// The vehicle refused the plan.
    Refused = 3,
    /// Items are left.
    NotCleared = 4,
    /// The vehicle fell silent.
    Timeout = 5,
    /// The vehicle does not hear the station on board.
    Unreached = 6,
    /// It gets nowhere.
    NoProgress = 7,
    /// No such parameter.
    UnknownParam = 8,
    /// The vehicle kept another value.
    ParamNotKept = 9,
    /// The message did not come.
    NoMessage = 10,
    /// The mission is on board as it was sent, and the vehicle's own checks reject it.
    Rejected = 11,
}

/// One difference.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct DifferenceTold {
    /// Place in the list.
    #[prost(uint32, tag = "1")]
    pub seq: u32,
    /// 0 the item, 1 its command, 2 its frame, 3 to 9 its parameters.
    #[prost(uint32, tag = "2")]
    pub field: u32,
    /// What should be there.
    #[prost(double, optional, tag = "3")]
    pub sent: Option<f64>,
    /// What is there.
    #[prost(double, optional, tag = "4")]
    pub kept: Option<f64>,
}

impl From<&Difference> for DifferenceTold {
    fn from(difference: &Difference) -> Self {
        let field = match difference.field {
            Field::Item => 0,
            Field::Command => 1,
            Field::Frame => 2,
            Field::Param(index) => 3 + u32::from(index),
        };
        let seq = u32::try_from(difference.seq).unwrap_or(u32::MAX);
        Self { seq, field, sent: difference.sent, kept: difference.kept }
    }
}

impl DifferenceTold {
    fn read(&self) -> Result<Difference, BadPayload> {
        let field = match self.field {
            0 => Field::Item,
            1 => Field::Command,
            2 => Field::Frame,
            3..=9 => Field::Param((self.field - 3) as u8),
            _ => return Err(BadPayload::Field("field")),
        };
        Ok(Difference { seq: self.seq as usize, field, sent: self.sent, kept: self.kept })
    }
}

/// What came of an order that succeeded; `None`: no more than that. Lists go with it where they are short enough, else
/// by their name: put them on the shelf.
pub fn outcome_of(reply: &Reply) -> Option<Outcome> {
    Some(match reply {
        Reply::Acknowledged { result_param2 } => Outcome::Acknowledged(*result_param2),
        Reply::Parameter(param) => Outcome::Param(param.into()),
        Reply::Parameters(params) => Outcome::Params(Content::of(pack_params(params))),
        Reply::Message(message) => Outcome::Message(Said::of_message(message)),
        Reply::Plan { items, home, position_error_m, .. } => {
            let list = vencejo_flight::plan::Mission { home: *home, items: items.clone() };
            let list = (!list.items.is_empty()).then(|| Content::of(pack_items(&list)));
            Outcome::Plan(PlanOutcome { told: None, list, position_error_m: *position_error_m })
        }
        _ => return None,
    })
}

impl Outcome {
    /// The list that belongs to it.
    pub fn content(&mut self) -> Option<&mut Content> {
        match self {
            Self::Params(content) => Some(content),
            Self::Plan(plan) => plan.list.as_mut(),
            _ => None,
        }
    }

    /// The same with a list that is too long for an answer by its name alone.
    #[must_use]
    pub fn short(mut self) -> Self {
        if let Some(content) = self.content() {
            *content = std::mem::take(content).at_most(MAX_WITH_ANSWER);
        }
        self
    }
}

/// How a transfer failed; `None` where it was refused and nothing was changed, in words.
pub fn fault_of(error: &VehicleError) -> Option<Fault> {
    let fault = |kind: FaultKind| Fault { kind: kind.into(), ..Fault::default() };
    let ms = |waited: &Duration| u64::try_from(waited.as_millis()).unwrap_or(u64::MAX);
    let error = match error {
        VehicleError::Transfer(error) => error,
        VehicleError::MessageNotReceived { message_id } => {
            return Some(Fault { number: *message_id, ..fault(FaultKind::NoMessage) });
        }
        _ => return None,
    };
    Some(match error {
        TransferError::NotAsSent { kind, differences } => Fault {
            plan: kind.mission_type().into(),
            differences: differences.iter().take(MAX_DIFFERENCES).map(DifferenceTold::from).collect(),
            ..fault(FaultKind::NotAsSent)
        },
        TransferError::Rejected { reasons } => {
            Fault { reasons: reasons.iter().take(MAX_MESSAGES).cloned().collect(), ..fault(FaultKind::Rejected) }
        }
        TransferError::Unverified { kind, .. } => {
            Fault { plan: kind.mission_type().into(), ..fault(FaultKind::Unverified) }
        }
        TransferError::Refused { kind, result, item } => Fault {
            plan: kind.mission_type().into(),
            number: result.0.into(),
            item: item.map(u32::from),
            ..fault(FaultKind::Refused)
        },
        TransferError::NotCleared { kind, count } => {
            Fault { plan: kind.mission_type().into(), number: (*count).into(), ..fault(FaultKind::NotCleared) }
        }
        TransferError::Timeout { waited, .. } | TransferError::FtpAbsent { waited } => {
            Fault { waited_ms: ms(waited), ..fault(FaultKind::Timeout) }
        }
        TransferError::Unreached { waited } => Fault { waited_ms: ms(waited), ..fault(FaultKind::Unreached) },
        TransferError::NoProgress { attempts, .. } => Fault { number: *attempts, ..fault(FaultKind::NoProgress) },
        TransferError::UnknownParam { name, told } => {
            Fault { name: name.as_str().to_owned(), is_told: *told, ..fault(FaultKind::UnknownParam) }
        }
        TransferError::ParamNotKept { name, asked, kept } => {
            let of = |value: &vencejo_proto::param::ParamValue| {
                Some(OneParam {
                    name: name.as_str().to_owned(),
                    kind: value.param_type().to_mav() as u32,
                    value: value.as_f64(),
                })
            };
            Fault { asked: of(asked), kept: of(kept), ..fault(FaultKind::ParamNotKept) }
        }
        _ => return None,
    })
}

impl Fault {
    /// The error that it tells of.
    ///
    /// # Errors
    /// [`BadPayload::Field`] for what cannot be.
    pub fn read(&self) -> Result<StationError, BadPayload> {
        let waited = Duration::from_millis(self.waited_ms);
        let kind = || kind_of(self.plan);
        let error = match FaultKind::try_from(self.kind).unwrap_or(FaultKind::Unspecified) {
            FaultKind::Unspecified => return Err(BadPayload::Field("fault")),
            FaultKind::NotAsSent => {
                let told = self.differences.iter().take(MAX_DIFFERENCES).map(DifferenceTold::read);
                TransferError::NotAsSent { kind: kind()?, differences: told.collect::<Result<_, _>>()? }
            }
            FaultKind::Unverified => unverified(kind()?, waited),
            FaultKind::Rejected => {
                let reasons = self.reasons.iter().take(MAX_MESSAGES);
                TransferError::Rejected { reasons: reasons.map(|reason| plain(reason, MAX_TEXT)).collect() }
            }
            FaultKind::Refused => {
                let item = self.item.map(u16::try_from).transpose().map_err(|_| BadPayload::Field("item"))?;
                let result = u8::try_from(self.number).map_err(|_| BadPayload::Field("result"))?;
                TransferError::Refused { kind: kind()?, result: MissionResult(result), item }
            }
            FaultKind::NotCleared => {
                let count = u16::try_from(self.number).map_err(|_| BadPayload::Field("count"))?;
                TransferError::NotCleared { kind: kind()?, count }
            }
            FaultKind::Timeout => TransferError::Timeout { step: STEP, waited },
            FaultKind::Unreached => TransferError::Unreached { waited },
            FaultKind::NoProgress => TransferError::NoProgress { step: STEP, attempts: self.number },
            FaultKind::UnknownParam => {
                let name = ParamName::new(&self.name).map_err(|_| BadPayload::Field("parameter name"))?;
                TransferError::UnknownParam { name, told: self.is_told }
            }
            FaultKind::ParamNotKept => {
                let (Some(asked), Some(kept)) = (&self.asked, &self.kept) else {
                    return Err(BadPayload::Field("parameter"));
                };
                let name = ParamName::new(&asked.name).map_err(|_| BadPayload::Field("parameter name"))?;
                let (asked, kept) = (value_of(asked.kind, asked.value)?, value_of(kept.kind, kept.value)?);
                TransferError::ParamNotKept { name, asked, kept }
            }
            FaultKind::NoMessage => {
                return Ok(VehicleError::MessageNotReceived { message_id: self.number }.into());
            }
        };
        Ok(VehicleError::Transfer(error).into())
    }
}

/// A plan was sent, and nobody knows what the vehicle holds.
pub fn unverified(kind: vencejo_flight::plan::PlanKind, waited: Duration) -> TransferError {
    TransferError::Unverified { kind, reason: Box::new(TransferError::Timeout { step: STEP, waited }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_went_wrong_on_board_is_what_is_told_far_away() {
        let mut same = 0;
        for error in TransferError::examples() {
            // These change nothing on board. A request that was cancelled ends with [`VehicleError::Cancelled`].
            let is_refusal = matches!(
                error,
                TransferError::TooMany { .. }
                    | TransferError::BadList { .. }
                    | TransferError::Item(_)
                    | TransferError::Ftp { .. }
                    | TransferError::FtpBusy { .. }
                    | TransferError::BadFile { .. }
                    | TransferError::Param(_)
                    | TransferError::ParamRefused { .. }
                    | TransferError::OnlyMission { .. }
                    | TransferError::IntegerItemsIgnored
                    | TransferError::Cancelled
            );
            let error = VehicleError::Transfer(error);
            let Some(fault) = fault_of(&error) else {
                assert!(is_refusal, "{error:?} is told as a refusal");
                continue;
            };
            assert!(!is_refusal, "{error:?}");
            let told = fault.read().expect("it was made here");
            let is_kin = |one: &StationError, other: &VehicleError| match (one, other) {
                (StationError::Vehicle(VehicleError::Transfer(one)), VehicleError::Transfer(other)) => {
                    std::mem::discriminant(one) == std::mem::discriminant(other)
                        || matches!(other, TransferError::FtpAbsent { .. })
                }
                _ => false,
            };
            assert!(is_kin(&told, &error), "{error:?} became {told:?}");
            same += usize::from(told == error.into());
        }
        assert!(same >= 7, "{same}");
        let no_message = VehicleError::MessageNotReceived { message_id: 148 };
        assert_eq!(fault_of(&no_message).map(|fault| fault.read()), Some(Ok(no_message.into())));
        assert_eq!(fault_of(&VehicleError::HomeUnknown), None);
        assert!(Fault::default().read().is_err());
        assert!(Fault { kind: 1, plan: 9, ..Fault::default() }.read().is_err());
        assert!(Fault { kind: 9, ..Fault::default() }.read().is_err());
    }
}
