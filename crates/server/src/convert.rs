//! Conversion between the core's values and those of the API. Makes no decisions except those that the core's types
//! require.

use vencejo_flight::FlightError;
use vencejo_flight::formats::ParamEntry;
use vencejo_flight::plan as core;
use vencejo_proto::{Frame, MonoTime, decode_fields, message_name};
use vencejo_vehicle::{self as vehicle, Reply};

use crate::dto;
use crate::dto::message::MessageField;
use crate::dto::recording::FileParam;
use crate::operations::Outcome;

mod facts;
mod landing;
mod link;
mod plan;
mod replay;
mod units;
mod vehicle_state;

pub(crate) use facts::{ages, attention, commands, gps_fixes, usual_plane, vehicle_kinds};
pub(crate) use landing::{finding_fix, landing, landing_alternative, landing_options};
pub(crate) use link::{links, networks, serial_ports, signing};
pub(crate) use plan::{
    core_item, core_plan, core_plan_kind, item, plan, plan_comparison, plan_format, plan_kind, plan_on_board,
    plan_state, uncertainty,
};
pub(crate) use replay::replay;
pub(crate) use units::{point, seconds};
pub(crate) use vehicle_state::{
    progress, text, texts, vehicle_control, vehicle_state, vehicle_summaries, vehicle_summary,
};

/// Result of a transfer; `None` for a reply without a result.
///
/// # Errors
/// For an invalid fence or rally list from the vehicle.
pub(crate) fn outcome(reply: Reply) -> Result<Outcome, FlightError> {
    Ok(match reply {
        Reply::Plan { kind, items, home, position_error_m, .. } => {
            let read = core::Plan::from_list(kind, core::Mission { home, items })?;
            Outcome { result: Some(dto::OperationResult::Plan(plan(&read))), position_error_m }
        }
        Reply::Parameters(params) => {
            let result = Some(dto::OperationResult::Params(params.iter().map(param).collect()));
            Outcome { result, position_error_m: None }
        }
        _ => Outcome::default(),
    })
}

/// A message with its fields by name.
pub(crate) fn raw_message(frame: &Frame, at: MonoTime) -> dto::RawMessage {
    let (id, source) = (frame.message_id(), frame.source());
    let fields = decode_fields(id, frame.payload()).unwrap_or_default();
    dto::RawMessage {
        name: message_name(id).map_or_else(|| format!("UNKNOWN_{id}"), str::to_owned),
        id,
        system_id: source.system.0,
        component_id: source.component.0,
        time_s: seconds(at),
        fields: fields.iter().map(|(name, value)| ((*name).to_owned(), MessageField::new(value))).collect(),
    }
}

/// A parameter of a file.
pub(crate) fn file_param(entry: &ParamEntry) -> FileParam {
    FileParam { name: entry.name.clone(), value: entry.value }
}

pub(crate) fn param(param: &vehicle::Param) -> dto::Param {
    let kind = match param.value {
        vehicle::ParamValue::U8(_) => "uint8",
        vehicle::ParamValue::I8(_) => "int8",
        vehicle::ParamValue::U16(_) => "uint16",
        vehicle::ParamValue::I16(_) => "int16",
        vehicle::ParamValue::U32(_) => "uint32",
        vehicle::ParamValue::I32(_) => "int32",
        vehicle::ParamValue::F32(_) => "real32",
    };
    let name = param.name.as_str().to_owned();
    let default = param.default.map(vehicle::ParamValue::as_f64);
    dto::Param { name, value: param.value.as_f64(), kind: kind.to_owned(), default }
}
