//! Checks of the numbers in raw commands and raw messages.
//!
//! ArduPilot converts many of them to 32-bit integers unchecked (`convert_COMMAND_LONG_loc_param`,
//! `handle_set_position_target_global_int` and the handlers behind them), which is undefined behaviour in C++ for
//! values out of range: in its simulator, where such faults are trapped, it ends the autopilot.

use std::ops::RangeInclusive;

use vencejo_flight::plan::Command;
use vencejo_proto::dialect::{MavMessage, PositionTargetTypemask};
use vencejo_proto::{FieldValue, Message};

use crate::command::CommandMessage;
use crate::error::VehicleError;

pub(super) fn height(field: &'static str, alt_m: f64) -> Result<f32, VehicleError> {
    in_range(field, alt_m, -1_000.0..=100_000.0, "a height, -1,000 to 100,000 m")
}

pub(super) fn in_range(
    field: &'static str,
    value: f64,
    range: RangeInclusive<f64>,
    expected: &'static str,
) -> Result<f32, VehicleError> {
    if range.contains(&value) { Ok(value as f32) } else { Err(invalid(field, value, expected)) }
}

pub(super) fn invalid(field: &'static str, value: impl ToString, expected: &'static str) -> VehicleError {
    VehicleError::InvalidValue { field, value: value.to_string(), expected }
}

/// Checks the numbers of a message. Parameters and debug values are excepted: any number is valid there, and some hold
/// the bytes of an integer.
pub(super) fn check_message(message: &Message, is_ardupilot: bool) -> Result<(), VehicleError> {
    let alt_m = match message {
        Message::CommandLong(long) => return check_command(&CommandMessage::Long(*long), is_ardupilot),
        Message::CommandInt(int) => return check_command(&CommandMessage::Int(*int), is_ardupilot),
        Message::Dialect(
            MavMessage::PARAM_SET(_)
            | MavMessage::NAMED_VALUE_FLOAT(_)
            | MavMessage::DEBUG(_)
            | MavMessage::DEBUG_VECT(_)
            | MavMessage::DEBUG_FLOAT_ARRAY(_),
        ) => return Ok(()),
        Message::MissionItemFloat(item) if takes_position(Command(item.command)) && is_global(item.frame) => {
            place(item.x.into(), item.y.into())?;
            item.z
        }
        Message::MissionItemInt(item) if takes_position(Command(item.command)) && is_global(item.frame) => {
            place(degrees(item.x.into()), degrees(item.y.into()))?;
            item.z
        }
        Message::Dialect(MavMessage::SET_POSITION_TARGET_GLOBAL_INT(target)) => {
            let has_height = !target.type_mask.contains(PositionTargetTypemask::POSITION_TARGET_TYPEMASK_Z_IGNORE);
            if has_height { new_height(target.alt.into())? } else { f32::NAN }
        }
        Message::Dialect(MavMessage::SET_POSITION_TARGET_LOCAL_NED(target)) => target.z,
        _ => f32::NAN,
    };
    height_or_none(alt_m)?;
    message.fields().iter().try_for_each(|(name, value)| match (*name, value) {
        ("lat" | "lat_int" | "latitude", FieldValue::Signed(value)) => place(degrees(*value), f64::NAN),
        ("lon" | "lng" | "lon_int" | "longitude", FieldValue::Signed(value)) => place(f64::NAN, degrees(*value)),
        (name, FieldValue::List(values)) => values.iter().try_for_each(|value| float(name, value)),
        (name, value) => float(name, value),
    })
}

fn float(field: &'static str, value: &FieldValue) -> Result<(), VehicleError> {
    if let FieldValue::Float(value) = value { number(field, *value) } else { Ok(()) }
}

/// The command, if its numbers are valid.
pub(super) fn checked(command: CommandMessage, is_ardupilot: bool) -> Result<CommandMessage, VehicleError> {
    check_command(&command, is_ardupilot).map(|()| command)
}

/// Checks the numbers of a command.
pub(super) fn check_command(command: &CommandMessage, is_ardupilot: bool) -> Result<(), VehicleError> {
    let (code, params, place_deg, alt_m) = match command {
        CommandMessage::Long(long) => {
            let [.., lat, lon, alt] = long.params;
            (Command(long.command), &long.params[..], Some((lat.into(), lon.into())), alt)
        }
        CommandMessage::Int(int) => {
            let place_deg = is_global(int.frame).then(|| (degrees(int.x.into()), degrees(int.y.into())));
            (Command(int.command), &int.params[..], place_deg, int.z)
        }
    };
    let infos = code.info().map(|info| &info.params);
    let numbers = params.iter().enumerate().chain(matches!(command, CommandMessage::Int(_)).then_some((6, &alt_m)));
    for (index, param) in numbers {
        let field = if params.len() == 4 && index == 6 { "z" } else { PARAMS[index] };
        if param.is_nan() && is_ardupilot && !may_be_none(code, index) {
            return Err(invalid(field, param, "a number: ArduPilot converts it to an integer"));
        }
        number(field, (*param).into())?;
        if infos.is_some_and(|infos| !infos[index].takes((*param).into())) {
            return Err(invalid(field, param, "one that fits 32 bits, in thousandths where it is a measure"));
        }
    }
    match code {
        Command::DO_CHANGE_ALTITUDE => new_height(params[0].into()).map(drop),
        Command::GUIDED_CHANGE_ALTITUDE => new_height(alt_m.into()).map(drop),
        code if takes_position(code) => {
            if let Some((lat_deg, lon_deg)) = place_deg {
                place(lat_deg, lon_deg)?;
            }
            height_or_none(alt_m)
        }
        _ => Ok(()),
    }
}

/// Whether ArduPilot accepts NaN for a parameter (`handle_command_int_do_reposition`,
/// `handle_command_do_gimbal_manager_pitchyaw`).
fn may_be_none(code: Command, index: usize) -> bool {
    matches!((code, index), (Command::DO_REPOSITION, 3) | (Command::DO_GIMBAL_MANAGER_PITCHYAW, 0..4))
        || code.param_may_be_unset(index)
}

/// Names of a command's parameters.
const PARAMS: [&str; 7] = ["param1", "param2", "param3", "param4", "param5", "param6", "param7"];

/// Checks that a number fits a 32-bit integer. The minimum is exact as a 32-bit float, the maximum is not.
fn number(field: &'static str, value: f64) -> Result<(), VehicleError> {
    if value.is_nan() || (f64::from(i32::MIN)..-f64::from(i32::MIN)).contains(&value) {
        return Ok(());
    }
    Err(invalid(field, value, "-2147483648 to below 2147483648, or NaN where MAVLink allows it"))
}

/// A position, degrees; NaN where there is none.
fn place(lat_deg: f64, lon_deg: f64) -> Result<(), VehicleError> {
    for (field, value, limit, expected) in [
        ("lat_deg", lat_deg, 90.0, "a latitude, -90 to 90 degrees, or NaN"),
        ("lon_deg", lon_deg, 180.0, "a longitude, -180 to 180 degrees, or NaN"),
    ] {
        if value.abs() > limit {
            return Err(invalid(field, value, expected));
        }
    }
    Ok(())
}

/// Degrees of an integer of 1e-7 degrees, whose maximum means "none".
fn degrees(scaled: i64) -> f64 {
    if scaled == i64::from(i32::MAX) { f64::NAN } else { scaled as f64 / 1e7 }
}

fn height_or_none(alt_m: f32) -> Result<(), VehicleError> {
    if alt_m.is_nan() { Ok(()) } else { height("alt_m", alt_m.into()).map(drop) }
}

/// A new altitude for an ArduPlane in flight: it reads 0 cm without a position as an unset location, which ends its
/// simulator (`Location::get_alt_cm`; ArduPlane 4.6.3), and GUIDED_CHANGE_ALTITUDE refuses it as dangerous. A position
/// 0 cm above home has no altitude either (`Location::sanitize`).
pub(super) fn new_height(alt_m: f64) -> Result<f32, VehicleError> {
    if alt_m.abs() < 0.01 {
        return Err(invalid("alt_m", alt_m, "a height that ArduPlane takes; it takes 0 for none"));
    }
    height("alt_m", alt_m)
}

/// Whether parameters 5 to 7 of a command are latitude, longitude and height.
fn takes_position(command: Command) -> bool {
    // Commands that are not mission items.
    const DO_SET_GLOBAL_ORIGIN: Command = Command(611);
    matches!(command, Command::DO_REPOSITION | DO_SET_GLOBAL_ORIGIN | Command::EXTERNAL_POSITION_ESTIMATE)
        || command.info().is_some_and(|info| info.has_position)
}

/// Whether x and y of a frame are degrees (MAV_FRAME).
fn is_global(frame: u8) -> bool {
    matches!(frame, 0 | 3 | 5 | 6 | 10 | 11)
}
