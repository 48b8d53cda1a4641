//! Parameters of a vehicle.

use axum::Json;
use axum::body::Bytes;
use axum::extract::rejection::BytesRejection;
use axum::extract::{DefaultBodyLimit, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_flight::formats::{MAX_FILE_BYTES, ParamDialect, ParamEntry, read_params as read_file, write_params};
use vencejo_station::{Pending, RequestResult};
use vencejo_vehicle::{Reply, Request};

use crate::convert;
use crate::dto::recording::FileParam;
use crate::dto::{NewParam, Operation, OperationKind, Param};
use crate::extract::{Json as Body, Name, Operator, Pilot, Vehicle, Viewer};
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(read_params))
        .routes(routes!(get_param, set_param))
        .routes(routes!(format_params))
        .merge(OpenApiRouter::new().routes(routes!(parse_params)).layer(DefaultBodyLimit::max(MAX_FILE_BYTES)))
}

/// Reads all parameters; they are the result of the operation.
#[utoipa::path(get, path = "/vehicles/{id}/params", tag = "params", params(("id" = u16, Path, description = "The vehicle's id")),
    responses((status = 202, body = Operation), Problem))]
async fn read_params(
    State(app): State<App>,
    Operator(session): Operator,
    Vehicle(vehicle): Vehicle,
) -> Result<(StatusCode, Json<Operation>), Problem> {
    let pending = vehicle.request(Request::ParamList);
    let operation = app.follow(session, vehicle.id().number(), OperationKind::ReadParams, pending)?;
    Ok((StatusCode::ACCEPTED, Json(operation)))
}

async fn ask(pending: Pending<RequestResult>) -> Result<Json<Param>, Problem> {
    match pending.wait().await.ok_or_else(Problem::closed)?? {
        Reply::Parameter(param) => Ok(Json(convert::param(&param))),
        _ => Err(Problem::closed()),
    }
}

/// Reads one parameter from the vehicle.
#[utoipa::path(get, path = "/vehicles/{id}/params/{name}", tag = "params",
    params(("id" = u16, Path, description = "The vehicle's id"), ("name" = String, Path, description = "Up to 16 characters")),
    responses((status = 200, body = Param), Problem))]
async fn get_param(_: Operator, Vehicle(vehicle): Vehicle, Name(name): Name) -> Result<Json<Param>, Problem> {
    ask(vehicle.request(Request::ParamRead { name })).await
}

/// Writes one parameter; returns the value that the vehicle stored.
#[utoipa::path(put, path = "/vehicles/{id}/params/{name}", tag = "params", request_body = NewParam,
    params(("id" = u16, Path, description = "The vehicle's id"), ("name" = String, Path, description = "Up to 16 characters")),
    responses((status = 200, body = Param), Problem))]
async fn set_param(
    pilot: Pilot,
    Vehicle(vehicle): Vehicle,
    Name(name): Name,
    Body(new): Body<NewParam>,
) -> Result<Json<Param>, Problem> {
    ask(pilot.request(&vehicle, Request::ParamSet { name, value: new.value })).await
}

/// Parses a parameter file of any supported format (`.param`, `.parm`, `.params`); the body is the file.
#[utoipa::path(post, path = "/params/parse", tag = "params",
    request_body(content = Vec<u8>, content_type = "application/octet-stream"),
    responses((status = 200, body = Vec<FileParam>), Problem))]
async fn parse_params(_: Viewer, body: Result<Bytes, BytesRejection>) -> Result<Json<Vec<FileParam>>, Problem> {
    let params = super::parsed(body?, |bytes| Ok(read_file(bytes)?.iter().map(convert::file_param).collect()));
    Ok(Json(params.await?))
}

/// Formats a `.param` file: one `NAME,value` per line, in the given order.
#[utoipa::path(post, path = "/params/format", tag = "params", request_body = Vec<FileParam>,
    responses((status = 200, content_type = "text/plain", body = String), Problem))]
async fn format_params(_: Viewer, Body(params): Body<Vec<FileParam>>) -> Response {
    let entries: Vec<_> =
        params.into_iter().map(|FileParam { name, value }| ParamEntry { name, value, mav_param_type: None }).collect();
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("text/plain; charset=utf-8")),
        (header::CONTENT_DISPOSITION, HeaderValue::from_static("attachment; filename=\"vehicle.param\"")),
    ];
    (headers, write_params(&entries, ParamDialect::MissionPlanner)).into_response()
}
