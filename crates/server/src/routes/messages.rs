//! Raw commands and messages, for everything without a path of its own.

use axum::Json;
use axum::extract::State;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_flight::plan::Command;
use vencejo_proto::{Address, CommandInt, CommandLong, FieldError, FieldValue, Header, MavVersion, Message, SystemId};
use vencejo_station::VehicleHandle;
use vencejo_vehicle::signing::SETUP_SIGNING_ID;
use vencejo_vehicle::{MessageId, Reply, Request};

use crate::convert;
use crate::dto::Done;
use crate::dto::cause::{Cause, ResourceKind};
use crate::dto::message::{
    Acknowledged, CommandChoice, MessageRate, NewMessage, RawCommandInt, RawCommandLong, RawMessage,
};
use crate::extract::{DespiteMixedPlan, Json as Body, Name, Operator, Pilot, Vehicle};
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(command_long))
        .routes(routes!(command_int))
        .routes(routes!(send_message))
        .routes(routes!(request_message))
        .routes(routes!(set_message_rate))
}

/// Placeholder, replaced by the vehicle's address.
const THE_VEHICLE: Address = Address::new(0, 0);

fn number_of(command: &CommandChoice) -> Result<u16, Problem> {
    match command {
        CommandChoice::Number(number) => Ok(*number),
        CommandChoice::Name(name) => Command::from_name(name).map(|command| command.0).ok_or_else(|| {
            let detail = format!("'{name}' is not a command; give its name, such as 'DO_CHANGE_SPEED', or its number");
            Problem::not_found(ResourceKind::Command, name, detail)
        }),
    }
}

/// Parameters as sent over MAVLink: 32-bit floats, NaN for null, 0 for missing ones.
fn params_of<const N: usize>(given: &[Option<f64>]) -> Result<[f32; N], Problem> {
    if given.len() > N {
        return Err(Problem::invalid_value(
            "params",
            format!("a list of {}", given.len()),
            &format!("a list of at most {N}"),
        ));
    }
    let mut params = [0.0; N];
    for (param, value) in params.iter_mut().zip(given) {
        *param = value.map_or(f32::NAN, |value| value as f32);
        if param.is_infinite() {
            return Err(Problem::invalid_value("params", value.unwrap_or_default(), "numbers that fit 32 bits"));
        }
    }
    Ok(params)
}

async fn acknowledged(
    pilot: &Pilot,
    vehicle: &VehicleHandle,
    despite: DespiteMixedPlan,
    request: Request,
) -> Result<Json<Acknowledged>, Problem> {
    match pilot.ask(vehicle, despite, request).await? {
        Reply::Acknowledged { result_param2 } => Ok(Json(Acknowledged { result_param2 })),
        _ => Ok(Json(Acknowledged { result_param2: 0 })),
    }
}

/// Id of a message given by name or number.
///
/// # Errors
/// [`Cause::NotFound`] for an unknown name.
pub fn message_id(name: &str) -> Result<MessageId, Problem> {
    name.parse().map_err(|error: FieldError| Problem::not_found(ResourceKind::Message, name, error.to_string()))
}

/// Address from which the vehicle sends.
fn address_of(vehicle: &VehicleHandle) -> Address {
    let system = vehicle.system().unwrap_or(SystemId::BROADCAST);
    vehicle.address().unwrap_or(Address { system, ..Address::new(0, 1) })
}

/// Converts a received message for the answer.
pub(super) fn raw_message(app: &App, vehicle: &VehicleHandle, message: &Message) -> RawMessage {
    let frame = message.encode(Header { sequence: 0, source: address_of(vehicle), version: MavVersion::V2 });
    convert::raw_message(&frame, app.now())
}

/// Sends any command as COMMAND_LONG. It is retransmitted only if repeating it is known to be safe.
#[utoipa::path(post, path = "/vehicles/{id}/command/long", tag = "raw", request_body = RawCommandLong,
    params(("id" = u16, Path, description = "The vehicle's id"),
        ("despite_mixed_plan" = Option<bool>, Query, description = "Carry it out although the mission on board may be mixed or lead out of reach")),
    responses((status = 200, body = Acknowledged), Problem))]
async fn command_long(
    pilot: Pilot,
    Vehicle(vehicle): Vehicle,
    despite: DespiteMixedPlan,
    Body(raw): Body<RawCommandLong>,
) -> Result<Json<Acknowledged>, Problem> {
    let command = number_of(&raw.command)?;
    let params = params_of(&raw.params)?;
    let command = CommandLong { target: THE_VEHICLE, command, confirmation: 0, params };
    acknowledged(&pilot, &vehicle, despite, Request::RawCommandLong(command)).await
}

/// Sends any command as COMMAND_INT. It is retransmitted only if repeating it is known to be safe.
#[utoipa::path(post, path = "/vehicles/{id}/command/int", tag = "raw", request_body = RawCommandInt,
    params(("id" = u16, Path, description = "The vehicle's id"),
        ("despite_mixed_plan" = Option<bool>, Query, description = "Carry it out although the mission on board may be mixed or lead out of reach")),
    responses((status = 200, body = Acknowledged), Problem))]
async fn command_int(
    pilot: Pilot,
    Vehicle(vehicle): Vehicle,
    despite: DespiteMixedPlan,
    Body(raw): Body<RawCommandInt>,
) -> Result<Json<Acknowledged>, Problem> {
    let command = number_of(&raw.command)?;
    let params = params_of(&raw.params)?;
    let [z] = params_of(&[Some(raw.z)])?;
    let (x, y) = (raw.x, raw.y);
    let command =
        CommandInt { target: THE_VEHICLE, frame: raw.frame, command, current: 0, autocontinue: 0, params, x, y, z };
    acknowledged(&pilot, &vehicle, despite, Request::RawCommandInt(command)).await
}

fn not_a_message(error: &FieldError) -> Problem {
    match error {
        FieldError::UnknownMessage { name } => Problem::not_found(ResourceKind::Message, name, error.to_string()),
        _ => Problem::invalid(error.to_string()),
    }
}

/// Sends any message as given, without waiting for an answer. Refused are numbers that no autopilot can interpret; while
/// the mission may be mixed, messages that arm, start the mission or set its current item; and while it leads out of reach,
/// or home and position are not known, those that have the vehicle follow it. A new altitude is refused while an ArduPlane
/// lands, or may be landing in a mission that was not read.
#[utoipa::path(post, path = "/vehicles/{id}/messages", tag = "raw", request_body = NewMessage,
    params(("id" = u16, Path, description = "The vehicle's id"),
        ("despite_mixed_plan" = Option<bool>, Query, description = "Carry it out although the mission on board may be mixed or lead out of reach")),
    responses((status = 200, body = Done), Problem))]
async fn send_message(
    pilot: Pilot,
    Vehicle(vehicle): Vehicle,
    DespiteMixedPlan(despite): DespiteMixedPlan,
    Body(new): Body<NewMessage>,
) -> Result<Json<Done>, Problem> {
    let fields = new.fields.into_iter();
    let fields = fields.map(|(name, value)| (name, value.map_or(FieldValue::Float(f64::NAN), |value| value.to_wire())));
    let message = Message::from_fields(&new.name, fields.collect(), address_of(&vehicle))
        .map_err(|error| not_a_message(&error))?;
    if message.id() == SETUP_SIGNING_ID {
        return Err(Problem::invalid("SETUP_SIGNING contains a key: use POST /api/v1/vehicles/{id}/signing"));
    }
    if pilot.vehicle(&vehicle).send(&message, despite, pilot.confirmation())?.is_sent() {
        return Ok(Json(Done {}));
    }
    let detail = format!("{} was not sent: no link to the vehicle is open", new.name);
    Err(Problem::new(Cause::NotSent { message: new.name }, detail))
}

/// Requests one message from the vehicle and returns it. Needs no control, unlike `POST
/// /vehicles/{id}/request-message`.
#[utoipa::path(post, path = "/vehicles/{id}/messages/{name}/request", operation_id = "request_named_message", tag = "raw",
    params(("id" = u16, Path, description = "The vehicle's id"), ("name" = String, Path, description = "Such as HOME_POSITION, or its number")),
    responses((status = 200, body = RawMessage), Problem))]
async fn request_message(
    State(app): State<App>,
    _: Operator,
    Vehicle(vehicle): Vehicle,
    Name(name): Name,
) -> Result<Json<RawMessage>, Problem> {
    let request = Request::RequestMessage { message: message_id(&name)? };
    let Reply::Message(message) = vehicle.request(request).wait().await.ok_or_else(Problem::closed)?? else {
        return Err(Problem::closed());
    };
    Ok(Json(raw_message(&app, &vehicle, &message)))
}

/// Sets the rate of a message, as `POST /vehicles/{id}/set-message-rate` does.
#[utoipa::path(put, path = "/vehicles/{id}/messages/{name}/rate", operation_id = "set_rate_of_named_message", tag = "raw",
    request_body = MessageRate,
    params(("id" = u16, Path, description = "The vehicle's id"), ("name" = String, Path, description = "Such as RAW_IMU, or its number")),
    responses((status = 200, body = Done), Problem))]
async fn set_message_rate(
    pilot: Pilot,
    Vehicle(vehicle): Vehicle,
    Name(name): Name,
    Body(MessageRate { rate_hz }): Body<MessageRate>,
) -> Result<Json<Done>, Problem> {
    let request = Request::SetMessageRate {
        message: message_id(&name)?,
        rate_hz: rate_hz.unwrap_or(vencejo_vehicle::MessageRate::Stop),
    };
    pilot.ask(&vehicle, DespiteMixedPlan(false), request).await?;
    Ok(Json(Done {}))
}
