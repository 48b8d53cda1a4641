//! Parameters of a vehicle (<https://mavlink.io/en/services/parameter.html>): what reading all of them (`list`), and
//! reading or setting one (`one`), have in common.

mod list;
mod one;

use vencejo_proto::Message;
use vencejo_proto::dialect::{MavMessage, MavParamError, PARAM_REQUEST_READ_DATA, PARAM_VALUE_DATA};
use vencejo_proto::param::{Param, ParamEncoding, ParamName, ParamType, ParamValue, ShownEncodings};

pub use self::list::ParamList;
pub use self::one::{ParamRead, ParamSet};
use super::{TransferConfig, TransferError, TransferOutput};

/// The index of a PARAM_VALUE that answers a request by name, or none.
pub(crate) const NO_INDEX: u16 = u16::MAX;

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
        Some(Param::new(self.name, value))
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
